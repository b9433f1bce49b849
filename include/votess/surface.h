// C interface of votess/surface.hpp, which describes the method and the arrays. Rules and errors are those of
// votess/votess.h.
#ifndef VOTESS_SURFACE_H
#define VOTESS_SURFACE_H

#include <votess/votess.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct votess_surface votess_surface;

typedef struct votess_surface_options {
    uint32_t struct_size;   // set it to sizeof(votess_surface_options); all other members may be 0
    uint32_t threads;       // 0: one for each processor
    const double* weights;  // count, length unit squared; NULL for none
    double tolerance;       // as TriangleMesh::tolerance
    int32_t merge;          // 1: vertices at equal places are one
    int32_t reserved;
    votess_progress_callback progress;  // may be NULL
    void* user;
} votess_surface_options;

// Makes the parts of cells on a surface. points: 3 * count. vertices: 3 * vertex_count. triangles: 3 * triangle_count
// indices of vertices. options: NULL for the defaults. Free *out with votess_surface_free.
VOTESS_API votess_status votess_surface_new(const double* points, size_t count, const double* vertices,
                                            size_t vertex_count, const int32_t* triangles, size_t triangle_count,
                                            const votess_surface_options* options, votess_surface** out);
VOTESS_API void votess_surface_free(votess_surface* surface);
// Its arrays have the names of the members of SurfaceCells, and faults (int32).
VOTESS_API votess_status votess_surface_array(const votess_surface* surface, const char* name, votess_array* array);

#ifdef __cplusplus
}
#endif

#endif
