// Cells on a surface.
#include <votess/surface.h>

#include <votess/surface.hpp>

#include "c/handles.hpp"

using namespace votess::c;

struct votess_surface {
    votess::SurfaceCells cells;
    std::vector<std::int32_t> faults;
};

votess_status votess_surface_new(const double* points, size_t count, const double* vertices, size_t vertex_count,
                                 const int32_t* triangles, size_t triangle_count, const votess_surface_options* options,
                                 votess_surface** out) {
    return create(out, [&] {
        const votess_surface_options all = options == nullptr ? votess_surface_options{}
                                                              : read_struct(*options, "surface_options.struct_size",
                                                                            "set it to sizeof(votess_surface_options)");
        votess::TriangleMesh mesh;
        mesh.vertices = coordinates(vertices, vertex_count, "vertices", "vertex_count");
        mesh.triangles = coordinates(triangles, triangle_count, "triangles", "triangle_count");
        mesh.merge = all.merge != 0;
        mesh.tolerance = all.tolerance;
        votess::SurfaceOptions given;
        if (all.weights != nullptr) given.weights = {all.weights, count};
        given.threads = all.threads;
        if (all.progress != nullptr) given.progress = watching(all.progress, all.user);
        votess::SurfaceCells cells = votess::surface_cells(coordinates(points, count), mesh, given);
        std::vector<std::int32_t> faults = cells.faults();
        return votess_surface{std::move(cells), std::move(faults)};
    });
}

void votess_surface_free(votess_surface* surface) {
    delete surface;
}

votess_status votess_surface_array(const votess_surface* surface, const char* name, votess_array* array) {
    return expose(surface, "surface", name, array, [](const votess_surface& of) {
        const votess::SurfaceCells& c = of.cells;
        return std::array{named("areas", c.areas),
                          named("centroids", c.centroids, 3),
                          named("nearest", c.nearest, 3),
                          named("energies", c.energies),
                          named("borders", c.borders),
                          named("pieces", c.pieces),
                          named("euler", c.euler),
                          named("indptr", c.indptr),
                          named("indices", c.indices),
                          named("lengths", c.lengths),
                          named("curves", c.curves),
                          named("loops", c.loops),
                          named("polygon_triangles", c.polygon_triangles),
                          named("polygon_seeds", c.polygon_seeds),
                          named("polygon_areas", c.polygon_areas),
                          named("polygon_offsets", c.polygon_offsets),
                          named("corners", c.corners),
                          named("beyond", c.beyond),
                          named("vertices", c.vertices, 3),
                          named("dual", c.dual, 3),
                          named("dual_counts", c.dual_counts),
                          named("faults", of.faults)};
    });
}
