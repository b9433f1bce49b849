// Pieces of cells in a mesh.
#include "c/handles.hpp"

using namespace votess::c;

votess_status votess_pieces_new(const votess_result* result, double gap, uint32_t threads,
                                votess_progress_callback progress, void* user, votess_pieces** out) {
    return create(out, result, "result", [&](auto& of) {
        votess::PieceOptions options;
        options.gap = gap;
        options.threads = threads;
        if (progress != nullptr) options.progress = watching(progress, user);
        return votess_pieces{votess::pieces(of.tessellation, options), dimensions_of(of.tessellation)};
    });
}

votess_status votess_pieces_array(const votess_pieces* pieces, const char* name, votess_array* array) {
    return expose(pieces, "pieces", name, array, [](const votess_pieces& of) {
        const votess::Pieces& p = of.pieces;
        return std::array{named("indptr", p.indptr),
                          named("vertex_offsets", p.vertex_offsets),
                          named("vertices", p.vertices, of.dimensions),
                          named("triangle_offsets", p.triangle_offsets),
                          named("triangles", p.triangles, of.dimensions),
                          named("on_surface", p.on_surface),
                          named("sources", p.sources),
                          named("volumes", p.volumes),
                          named("centroids", p.centroids, of.dimensions)};
    });
}
