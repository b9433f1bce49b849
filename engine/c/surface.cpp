// Cells on a surface.
#include <votess/surface.h>

#include <votess/surface.hpp>

#include "c/handles.hpp"

using namespace votess::c;

struct votess_surface {
    votess::SurfaceCells cells;
    std::vector<std::int32_t> faults;
    std::vector<double> points, energies, moved;  // of a relaxation or a remesh
    votess::Remesh mesh;                          // without its cells, points and energies
    bool is_mesh = false;

    explicit votess_surface(votess::SurfaceCells of) : cells(std::move(of)) {
        if (!cells.indptr.empty()) faults = cells.faults();
    }
};

namespace {

votess::TriangleMesh mesh_of(const double* vertices, size_t vertex_count, const int32_t* triangles,
                             size_t triangle_count, int32_t merge, double tolerance) {
    votess::TriangleMesh mesh;
    mesh.vertices = coordinates(vertices, vertex_count, "vertices", "vertex_count");
    mesh.triangles = coordinates(triangles, triangle_count, "triangles", "triangle_count");
    mesh.merge = merge != 0;
    mesh.tolerance = tolerance;
    return mesh;
}

}  // namespace

votess_status votess_surface_new(const double* points, size_t count, const double* vertices, size_t vertex_count,
                                 const int32_t* triangles, size_t triangle_count, const votess_surface_options* options,
                                 votess_surface** out) {
    return create(out, [&] {
        const votess_surface_options all = options == nullptr ? votess_surface_options{}
                                                              : read_struct(*options, "surface_options.struct_size",
                                                                            "set it to sizeof(votess_surface_options)");
        const votess::TriangleMesh mesh =
            mesh_of(vertices, vertex_count, triangles, triangle_count, all.merge, all.tolerance);
        votess::SurfaceOptions given;
        if (all.weights != nullptr) given.weights = {all.weights, count};
        if (all.want != 0) given.want = static_cast<votess::SurfaceWant>(all.want);
        given.threads = all.threads;
        if (all.progress != nullptr) given.progress = watching(all.progress, all.user);
        return votess_surface(votess::surface_cells(coordinates(points, count), mesh, given));
    });
}

votess_status votess_surface_lloyd(const double* points, size_t count, const double* vertices, size_t vertex_count,
                                   const int32_t* triangles, size_t triangle_count,
                                   const votess_surface_lloyd_options* options, votess_surface** out) {
    return create(out, [&] {
        const votess_surface_lloyd_options all = options == nullptr
                                                     ? votess_surface_lloyd_options{}
                                                     : read_struct(*options, "surface_lloyd_options.struct_size",
                                                                   "set it to sizeof(votess_surface_lloyd_options)");
        const votess::TriangleMesh mesh =
            mesh_of(vertices, vertex_count, triangles, triangle_count, all.merge, all.mesh_tolerance);
        votess::SurfaceLloydOptions given;
        if (options != nullptr) given.steps = all.steps;
        if (all.fixed != nullptr) given.fixed = {all.fixed, count};
        given.tolerance = all.tolerance;
        given.threads = all.threads;
        if (all.progress != nullptr) given.progress = watching(all.progress, all.user);
        votess::SurfaceRelaxation relaxed = votess::lloyd_on_surface(coordinates(points, count), mesh, given);
        votess_surface made(std::move(relaxed.cells));
        made.points = std::move(relaxed.points);
        made.energies = std::move(relaxed.energies);
        made.moved = std::move(relaxed.moved);
        return made;
    });
}

votess_status votess_surface_remesh(size_t count, const double* vertices, size_t vertex_count, const int32_t* triangles,
                                    size_t triangle_count, const votess_remesh_options* options, votess_surface** out) {
    return create(out, [&] {
        votess::RemeshOptions given;
        bool merge = false;
        double tolerance = 0;
        if (options != nullptr) {
            const votess_remesh_options all =
                read_struct(*options, "remesh_options.struct_size", "set it to sizeof(votess_remesh_options)");
            given.steps = all.steps;
            if (all.sharp != 0) given.sharp = all.sharp;
            given.rng_seed = all.rng_seed;
            given.threads = all.threads;
            if (all.progress != nullptr) given.progress = watching(all.progress, all.user);
            merge = all.merge != 0;
            tolerance = all.mesh_tolerance;
        }
        votess::Remesh mesh = votess::remesh(
            mesh_of(vertices, vertex_count, triangles, triangle_count, merge ? 1 : 0, tolerance), count, given);
        votess_surface made(std::move(mesh.cells));
        made.points = std::move(mesh.points);
        made.energies = std::move(mesh.energies);
        made.mesh = std::move(mesh);
        made.is_mesh = true;
        return made;
    });
}

votess_status votess_surface_figures(const votess_surface* surface, votess_remesh_figures* figures) {
    return guarded(surface, "surface", [&](auto& of) {
        require(figures, "figures");
        require_struct_size(figures->struct_size, sizeof(votess_remesh_figures), "remesh_figures.struct_size",
                            "set it to sizeof(votess_remesh_figures)");
        if (!of.is_mesh) refuse("surface is not a mesh: make it by votess_surface_remesh()");
        const votess::Remesh& mesh = of.mesh;
        write_struct({0, 0, mesh.min_angle, mesh.mean_min_angle, mesh.distance, mesh.border_edges, mesh.crowded_edges},
                     *figures);
    });
}

void votess_surface_free(votess_surface* surface) {
    delete surface;
}

votess_status votess_surface_array(const votess_surface* surface, const char* name, votess_array* array) {
    return expose(surface, "surface", name, array, [](const votess_surface& of) {
        std::vector arrays{named("faults", of.faults),
                           named("points", of.points, 3),
                           named("step_energies", of.energies),
                           named("moved", of.moved),
                           named("mesh_vertices", of.mesh.vertices, 3),
                           named("mesh_triangles", of.mesh.triangles, 3),
                           named("mesh_faults", of.mesh.faults)};
        votess::for_surface_arrays(of.cells, [&](const char* array, const auto& values, std::size_t components) {
            arrays.push_back(named(array, values, components));
        });
        return arrays;
    });
}
