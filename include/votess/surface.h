// C interface of votess/surface.hpp, which describes the methods and the arrays. Rules and errors are those of
// votess/votess.h.
#ifndef VOTESS_SURFACE_H
#define VOTESS_SURFACE_H

#include <votess/votess.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct votess_surface votess_surface;

typedef struct votess_surface_options {
    uint32_t struct_size;               // set it to sizeof(votess_surface_options); all other members may be 0
    uint32_t threads;                   // 0: one for each processor
    const double* weights;              // count, length unit squared; NULL for none
    double tolerance;                   // as TriangleMesh::tolerance
    int32_t merge;                      // 1: vertices at equal places are one
    int32_t want;                       // SurfaceWant, 0: all arrays; the others are then empty
    votess_progress_callback progress;  // may be NULL
    void* user;
} votess_surface_options;

// Makes the parts of cells on a surface. points: 3 * count. vertices: 3 * vertex_count. triangles: 3 * triangle_count
// indices of vertices. options: NULL for the defaults. Free *out with votess_surface_free.
VOTESS_API votess_status votess_surface_new(const double* points, size_t count, const double* vertices,
                                            size_t vertex_count, const int32_t* triangles, size_t triangle_count,
                                            const votess_surface_options* options, votess_surface** out);

typedef struct votess_surface_lloyd_options {
    uint32_t struct_size;               // set it to sizeof(votess_surface_lloyd_options); all other members may be 0
    uint32_t threads;                   // 0: one for each processor
    const uint8_t* fixed;               // count, 1 for a point that does not move; NULL: all move
    double tolerance;                   // as SurfaceLloydOptions::tolerance
    double mesh_tolerance;              // as TriangleMesh::tolerance
    uint32_t steps;                     // the maximum
    int32_t merge;                      // 1: vertices at equal places are one
    votess_progress_callback progress;  // may be NULL
    void* user;
} votess_surface_lloyd_options;

// Makes the cells of lloyd_on_surface(). It has the arrays points, step_energies and moved too, the members of
// SurfaceRelaxation. Arguments as for votess_surface_new.
VOTESS_API votess_status votess_surface_lloyd(const double* points, size_t count, const double* vertices,
                                              size_t vertex_count, const int32_t* triangles, size_t triangle_count,
                                              const votess_surface_lloyd_options* options, votess_surface** out);

typedef struct votess_remesh_options {
    uint32_t struct_size;               // set it to sizeof(votess_remesh_options)
    uint32_t threads;                   // 0: one for each processor
    uint64_t rng_seed;                  // of the first places
    double sharp;                       // degrees, above 0 up to 180; 0 means 40
    double mesh_tolerance;              // as TriangleMesh::tolerance
    uint32_t steps;                     // of the relaxation
    int32_t merge;                      // 1: vertices at equal places are one
    votess_progress_callback progress;  // may be NULL
    void* user;
} votess_remesh_options;

// Makes a mesh as remesh() does, of about count vertices. options: NULL for the defaults of RemeshOptions. Further
// arrays are members of Remesh: mesh_vertices, mesh_triangles, points, step_energies and mesh_faults.
VOTESS_API votess_status votess_surface_remesh(size_t count, const double* vertices, size_t vertex_count,
                                               const int32_t* triangles, size_t triangle_count,
                                               const votess_remesh_options* options, votess_surface** out);

// The figures of Remesh.
typedef struct votess_remesh_figures {
    uint32_t struct_size;  // sizeof(votess_remesh_figures)
    uint32_t reserved;
    double min_angle;
    double mean_min_angle;
    double distance;
    uint64_t border_edges;
    uint64_t crowded_edges;
} votess_remesh_figures;

// Fills the figures of a mesh from votess_surface_remesh; for others an error.
VOTESS_API votess_status votess_surface_figures(const votess_surface* surface, votess_remesh_figures* figures);

VOTESS_API void votess_surface_free(votess_surface* surface);
// Its arrays have the names of the members of SurfaceCells, and faults (int32). Further ones are named above.
VOTESS_API votess_status votess_surface_array(const votess_surface* surface, const char* name, votess_array* array);

#ifdef __cplusplus
}
#endif

#endif
