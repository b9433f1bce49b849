// Pieces of cells in a mesh.
#include "c/handles.hpp"

using namespace votess::c;

namespace {

template <typename Element>
const Element* expose(const votess_pieces* pieces, std::size_t* length,
                      std::vector<Element> votess::Pieces::*array) noexcept {
    return expose_array(pieces, &votess_pieces::pieces, array, "pieces is NULL", length);
}

}  // namespace

votess_status votess_pieces_new(const votess_result* result, double gap, uint32_t threads,
                                votess_progress_callback progress, void* user, votess_pieces** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(result, "result");
        votess::PieceOptions options;
        options.gap = gap;
        options.threads = threads;
        if (progress != nullptr)
            options.progress = [progress, user](double fraction) {
                return call_back("progress", [&] { return progress(fraction, user) != 0; });
            };
        *out = new votess_pieces{votess::pieces(result->tessellation, options)};
    });
}

void votess_pieces_free(votess_pieces* pieces) {
    delete pieces;
}

const int64_t* votess_pieces_indptr(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::indptr);
}

const int64_t* votess_pieces_vertex_offsets(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::vertex_offsets);
}

const double* votess_pieces_vertices(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::vertices);
}

const int64_t* votess_pieces_triangle_offsets(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::triangle_offsets);
}

const int32_t* votess_pieces_triangles(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::triangles);
}

const uint8_t* votess_pieces_on_surface(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::on_surface);
}

const int32_t* votess_pieces_sources(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::sources);
}

const double* votess_pieces_volumes(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::volumes);
}

const double* votess_pieces_centroids(const votess_pieces* pieces, size_t* length) {
    return expose(pieces, length, &votess::Pieces::centroids);
}
