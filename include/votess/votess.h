// votess: exact 3D Voronoi tessellation. C interface of votess.hpp, which describes the method and the arrays.
//
// Rules:
//   - Handles are opaque; free each with its _free function (NULL is allowed).
//   - Functions that can fail return a votess_status. votess_last_error() then returns the reason, per thread. It names
//     fields of votess_options as options.min_face.
//   - Structs begin with their own size as the caller compiled it. Later versions only add fields at the end. Fields
//     that the caller lacks keep their defaults; fields that the library lacks are ignored. A size above
//     VOTESS_LARGEST_STRUCT is uninitialized memory and is refused.
//   - Arrays are read by their names into a votess_array; they belong to the handle and live as long as it.
//   - No exception leaves the library.
#ifndef VOTESS_H
#define VOTESS_H

#include <stddef.h>
#include <stdint.h>

#include <votess/export.hpp>
#include <votess/version.hpp>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum votess_status {
    VOTESS_OK = 0,
    VOTESS_ERROR_INVALID_ARGUMENT = 1,
    VOTESS_ERROR_OUT_OF_MEMORY = 2,
    VOTESS_ERROR_CANCELLED = 3,
    VOTESS_ERROR_UNSUPPORTED = 4,
    VOTESS_ERROR_INTERNAL = 5,
    VOTESS_ERROR_DEVICE_LOST = 6,
    VOTESS_ERROR_INVALID_USE = 7,    // the tessellator is busy in another call
    VOTESS_ERROR_STORAGE = 8,        // temporary files of votess_tessellate_stream()
    VOTESS_ERROR_NO_THREADS = 9,     // the system gives fewer threads than votess_options.threads
    VOTESS_ERROR_NOT_CONVERGED = 10  // votess_fit_volumes did not reach the tolerance
} votess_status;

// Values of the status bytes of cells; see CellStatus in votess.hpp.
typedef enum votess_cell_status {
    VOTESS_CELL_CERTIFIED = 0,
    VOTESS_CELL_NEEDS_EXACT = 1,
    VOTESS_CELL_PLANE_OVERFLOW = 2,
    VOTESS_CELL_VERTEX_OVERFLOW = 3,
    VOTESS_CELL_CANDIDATES_EXHAUSTED = 4,
    VOTESS_CELL_DUPLICATE = 5,
    VOTESS_CELL_EMPTY = 6,
    VOTESS_CELL_OUTSIDE = 7
} votess_cell_status;

// Bits of votess_options.want; see Want in votess.hpp.
enum {
#define VOTESS_GROUP(name, NAME, bit, value) VOTESS_WANT_##NAME = bit,
#include "votess/arrays.h"
};

// Checks that votess_verify can skip; see VerifyReport::skipped in votess.hpp.
#define VOTESS_CHECK_VOLUMES 1u
#define VOTESS_CHECK_SYMMETRY 2u
#define VOTESS_CHECK_EULER 4u
#define VOTESS_CHECK_SAMPLE 8u
#define VOTESS_SAMPLE_AUTOMATIC SIZE_MAX

#define VOTESS_LARGEST_STRUCT 4096u

#define VOTESS_DUPLICATES_MERGE 0
#define VOTESS_DUPLICATES_ERROR 1

#define VOTESS_OUTSIDE_ERROR 0
#define VOTESS_OUTSIDE_DROP 1
#define VOTESS_OUTSIDE_KEEP 2

// Relative error of volumes, centroids and areas; see Precision in votess.hpp.
typedef enum votess_precision {
    VOTESS_PRECISION_SINGLE = 0,  // 1e-5 on a GPU, 1e-10 on the CPU
    VOTESS_PRECISION_DOUBLE = 1   // 1e-10
} votess_precision;

// Called by the thread that runs votess_tessellate or a query, about ten times a second. Return 0 to cancel, else
// nonzero. A C++ exception of the callback ends the call with VOTESS_ERROR_CANCELLED; votess_last_error() names it.
typedef int (*votess_progress_callback)(double fraction, void* user);
// Sets the callback of this thread, which later calls use where they have none: votess_delaunay_new(),
// votess_network_new(), votess_alpha_new(), votess_verify() and all others. NULL removes it. user: passed to it.
VOTESS_API void votess_set_progress(votess_progress_callback progress, void* user);
// message: zero-terminated, valid during the call.
typedef void (*votess_log_callback)(const char* message, void* user);

// The fields of Options in votess.hpp.
typedef struct votess_options {
    uint32_t struct_size;  // set by votess_options_init
    uint32_t want;         // VOTESS_WANT_* bits; default neighbors and volumes
    int32_t list_walls;    // nonzero: true
    int32_t has_box;       // nonzero: use box_lower and box_upper; 0: the default box; may be infinite: Options::box in
                           // votess.hpp
    double box_lower[3];
    double box_upper[3];
    int32_t periodic[3];  // nonzero: the box repeats along x, y, z
    int32_t has_cell;     // nonzero: a triclinic box instead of box, see TriclinicBox in votess.hpp
    double cell_origin[3];
    double cell_a[3];
    double cell_b[3];
    double cell_c[3];
    int32_t cell_periodic[3];  // nonzero: it repeats along a, b, c; default all. Leave periodic 0 or equal
    const double* walls;       // 4 * wall_count: nx, ny, nz, d of each wall n.x <= d; ids -7, -8, ...
    uint64_t wall_count;
    const double* weights;  // one for each point, or NULL: a power diagram; copied by the call
    const double* radii;    // the same as radii, whose squares are the weights; not both
    double min_face;
    double min_area;
    int32_t outside;     // VOTESS_OUTSIDE_*
    int32_t duplicates;  // VOTESS_DUPLICATES_*
    const char* device;  // NULL: default
    int32_t precision;   // VOTESS_PRECISION_*
    uint32_t threads;
    uint32_t grid_resolution;
    uint32_t k_init;
    uint32_t chunk_size;
    int32_t follow;                     // nonzero: true
    const char* instructions;           // NULL: default
    votess_progress_callback progress;  // may be NULL
    void* progress_user;
    votess_log_callback log;  // may be NULL
    void* log_user;
    int32_t planar;  // nonzero: two dimensions, see Options::planar in votess.hpp; the points are 2 * count coordinates
    // The seeds whose cells to make, see Options::only in votess.hpp. has_only 0: all cells.
    int32_t has_only;
    uint64_t only_count;
    const int64_t* only;  // only_count indices
    // A closed triangle mesh as the domain, see Options::mesh in votess.hpp. has_mesh 0: none.
    int32_t has_mesh;
    int32_t mesh_merge;  // nonzero: vertices at equal places are one
    uint64_t mesh_vertex_count;
    const double* mesh_vertices;  // 3 * mesh_vertex_count; 2 with planar
    uint64_t mesh_triangle_count;
    const int32_t* mesh_triangles;  // 3 * mesh_triangle_count; 2 with planar: edges, see TriangleMesh in votess.hpp
    double mesh_tolerance;          // with mesh_merge: see TriangleMesh::tolerance in votess.hpp
} votess_options;

// The fields of Stats in votess.hpp.
typedef struct votess_stats {
    uint32_t struct_size;  // set it to sizeof(votess_stats) before votess_result_stats
    uint32_t threads;
    uint64_t points, faces, duplicates, empty_cells, fallback_cells, exact_cells, peak_memory_bytes;
    double mean_faces, volume_sum, box_volume;
    double seconds_upload, seconds_sort, seconds_knn, seconds_clip, seconds_fallback, seconds_download, seconds_total;
    int32_t precision;  // VOTESS_PRECISION_* of volumes, centroids and areas; double after a run on the CPU
    char device[252];   // zero-terminated
    // Cells that the CPU made again, by reason; see FallbackReasons in votess.hpp. They add up to fallback_cells.
    uint64_t fallback_uncertain, fallback_overflow, fallback_exhausted, fallback_skipped, fallback_domain;
    int64_t tiny_faces;       // faces far smaller than the mean, see Stats::tiny_faces in votess.hpp; -1 when unknown
    double seconds_open;      // see StageSeconds::open in votess.hpp; part of seconds_total
    uint64_t moved_vertices;  // of a mesh, see TriangleMesh::tolerance in votess.hpp
    double moved_distance;    // the largest of these moves
    uint64_t kept_cells;      // cells of the last call that still hold, see Options::follow in votess.hpp
} votess_stats;

// An array of a handle. It lies in the library's memory, must not be written, and lives as long as the handle. Each
// type of handle with arrays has a function votess_<type>_array(), which sets *array to the one of this name. Names are
// those of the C++ struct. A NULL pointer and an unknown name give VOTESS_ERROR_INVALID_ARGUMENT and an empty *array;
// votess_last_error() then lists the names. An array that was not requested or does not apply is empty, without error.
typedef struct votess_array {
    const void* data;   // length * components elements, row by row; NULL when there are none
    size_t length;      // rows
    size_t components;  // elements in a row
    char kind;          // of an element: 'f' floating point, 'i' signed, 'u' unsigned
    uint8_t bytes;      // of an element: 1, 4 or 8
} votess_array;

typedef struct votess_tessellator votess_tessellator;
typedef struct votess_result votess_result;
typedef struct votess_delaunay votess_delaunay;
typedef struct votess_hull votess_hull;
typedef struct votess_diagram votess_diagram;
typedef struct votess_rays votess_rays;
typedef struct votess_natural votess_natural;
typedef struct votess_fit votess_fit;
typedef struct votess_zones votess_zones;
typedef struct votess_groups votess_groups;
typedef struct votess_masses votess_masses;
typedef struct votess_network votess_network;
typedef struct votess_pieces votess_pieces;
typedef struct votess_alpha votess_alpha;

// Version of the loaded library: major * 1000000 + minor * 1000 + patch, and as text "1.2.3".
VOTESS_API uint32_t votess_version(void);
VOTESS_API const char* votess_version_string(void);
// Sizes of the structs above in the loaded library, for callers that cannot include this header.
VOTESS_API size_t votess_sizeof_options(void);
VOTESS_API size_t votess_sizeof_stats(void);
// Returns the message of this thread's last failure, or "". UTF-8, valid until the thread's next failure.
VOTESS_API const char* votess_last_error(void);

// Writes the defaults, struct_size too. options: not NULL. size: sizeof(votess_options) as the caller compiled it; the
// library writes no byte beyond it.
VOTESS_API votess_status votess_options_init(votess_options* options, size_t size);
// Sets *want to the VOTESS_WANT_* bits of names with commas between them, see want_of() in votess.hpp. names: not NULL.
VOTESS_API votess_status votess_want_of(const char* names, uint32_t* want);
// Sets *want to the VOTESS_WANT_* bits of the arrays that a result holds: those of options->want, and those that it and
// min_face need. Fails for options that are wrong for any points. Ignores the lengths of weights and radii.
VOTESS_API votess_status votess_options_implied_want(const votess_options* options, uint32_t* want);

// A tessellator keeps device, threads and buffers between calls, and reuses the memory of freed results. Keep one for
// seeds that move from call to call. votess_tessellator_free frees all that it keeps; results stay valid. After fork()
// the child may use and free a tessellator of its parent, see Tessellator in votess.hpp.
VOTESS_API votess_status votess_tessellator_new(votess_tessellator** out);
VOTESS_API void votess_tessellator_free(votess_tessellator* tessellator);

// Tessellates. On success *out is a new result, which does not need the tessellator; else it is NULL.
// tessellator: NULL = one for this call. One call at a time: a second one, from another thread or a callback, fails
// with VOTESS_ERROR_INVALID_USE. No other thread may free it before the call returns.
// points: 3 * count coordinates, x y z per seed, or 2 * count if options->planar; NULL only when count is 0. The call
// copies them first: if another thread writes to them meanwhile, cells are wrong, but nothing else is. options: NULL =
// defaults.
VOTESS_API votess_status votess_tessellate(votess_tessellator* tessellator, const double* points, size_t count,
                                           const votess_options* options, votess_result** out);
VOTESS_API votess_status votess_tessellate_f32(votess_tessellator* tessellator, const float* points, size_t count,
                                               const votess_options* options, votess_result** out);
VOTESS_API void votess_result_free(votess_result* result);

VOTESS_API size_t votess_result_size(const votess_result* result);  // N
// Sets *array to an array of a result, by its name in votess/arrays.h, see votess_array. Orders and units as in
// Tessellation of votess.hpp. Vectors have two components in the plane. CellStatus is uint8_t, VOTESS_CELL_*. Also,
// with three components everywhere:
//   box (2, 3)     double, lower and upper corner; the bounds of a triclinic box
//   periodic (3)   uint8_t, 1 for each axis, or edge of a triclinic box, along which the domain repeats
//   cell (4, 3)    double, origin, a, b and c of a triclinic box; else it is empty
//   walls (M, 4)   double, as votess_options.walls
VOTESS_API votess_status votess_result_array(const votess_result* result, const char* name, votess_array* array);
VOTESS_API int votess_result_in_mesh(const votess_result* result);        // 1 with options.has_mesh, else 0
VOTESS_API int votess_result_planar(const votess_result* result);         // 1 for cells of the plane, else 0
VOTESS_API int votess_result_lists_walls(const votess_result* result);    // 1 when the rows hold wall ids, else 0
VOTESS_API double votess_result_least_face(const votess_result* result);  // area below which faces were dropped, or 0
VOTESS_API votess_status votess_result_stats(const votess_result* result, votess_stats* stats);

// The dual of the cells, see delaunay() in votess.hpp; result needs faces, and may be freed afterwards.
VOTESS_API votess_status votess_delaunay_new(const votess_result* result, votess_delaunay** out);
VOTESS_API void votess_delaunay_free(votess_delaunay* delaunay);
// The arrays of Delaunay in votess.hpp:
//   int32_t  tetrahedra (T, d + 1), tetrahedra_centers (T), polytope_indices (polytope_indptr[P]), polytope_centers (P)
//   int8_t   tetrahedra_shifts (T, (d + 1) * d), polytope_shifts (polytope_indptr[P], d), in a periodic domain
//   int64_t  polytope_indptr (P + 1)
VOTESS_API votess_status votess_delaunay_array(const votess_delaunay* delaunay, const char* name, votess_array* array);

// Seeds for queries, see Diagram in diagram.hpp; many threads may query one. points: 3 * count coordinates, 2 * count
// if options->planar; copied. Each query and vector then has d = 2 components, else 3. Uses these options: the domain,
// planar, weights, radii, outside, duplicates, threads, grid_resolution, instructions and progress. progress is called
// during this call only.
VOTESS_API votess_status votess_diagram_new(const double* points, size_t count, const votess_options* options,
                                            votess_diagram** out);
// Sets *out to a second handle of the same seeds, or NULL after a failure. Its queries call options->progress and stop
// when that returns 0; other options are ignored. Nothing is copied. Free each handle.
VOTESS_API votess_status votess_diagram_view(const votess_diagram* diagram, const votess_options* options,
                                             votess_diagram** out);
VOTESS_API void votess_diagram_free(votess_diagram* diagram);
VOTESS_API size_t votess_diagram_size(const votess_diagram* diagram);  // N
VOTESS_API int votess_diagram_planar(const votess_diagram* diagram);   // 1 for seeds of the plane, else 0
// Writes count seeds: the one whose cell holds each query (d * count coordinates), or -1 outside the domain.
VOTESS_API votess_status votess_diagram_locate(const votess_diagram* diagram, const double* queries, size_t count,
                                               int32_t* seeds);
// Sets *out to a new result of count cells, or NULL after a failure: the cell that each query would have if it alone
// were added to the seeds, see Diagram::probe in diagram.hpp. want: VOTESS_WANT_* bits. list_walls: as in
// votess_options. weights: count, only in a power diagram; NULL = 0. votess_delaunay_new and votess_verify refuse the
// result with VOTESS_ERROR_INVALID_ARGUMENT; votess_wrapped_points takes the queries.
VOTESS_API votess_status votess_diagram_probe(const votess_diagram* diagram, const double* queries, size_t count,
                                              uint32_t want, int32_t list_walls, const double* weights,
                                              votess_result** out);

// The cells along rays, see Diagram::trace in diagram.hpp. origins, directions: d * count. lengths: count. middles:
// nonzero for true. On success *out is new, else NULL; the diagram may be freed afterwards.
VOTESS_API votess_status votess_rays_new(const votess_diagram* diagram, const double* origins, const double* directions,
                                         const double* lengths, size_t count, int32_t middles, votess_rays** out);
VOTESS_API void votess_rays_free(votess_rays* rays);
// The arrays of RayCells in diagram.hpp, for R rays:
//   int64_t  offsets (R + 1)
//   int32_t  seeds (offsets[R])
//   double   lengths (offsets[R]), middles (offsets[R], d)
VOTESS_API votess_status votess_rays_array(const votess_rays* rays, const char* name, votess_array* array);

// Natural-neighbor coordinates of queries, see Diagram::natural_neighbors in diagram.hpp. at_walls, gradients: nonzero
// for true. weights: count, only in a power diagram; NULL = 0. On success *out is new, else NULL; the diagram may be
// freed afterwards.
#define VOTESS_NATURAL_SIBSON 0
#define VOTESS_NATURAL_LAPLACE 1
VOTESS_API votess_status votess_natural_new(const votess_diagram* diagram, const double* queries, size_t count,
                                            int32_t method, int32_t at_walls, int32_t gradients, const double* weights,
                                            votess_natural** out);
VOTESS_API void votess_natural_free(votess_natural* natural);
// The arrays of NaturalCoordinates in diagram.hpp, for Q queries:
//   int64_t  indptr (Q + 1)
//   int32_t  indices (indptr[Q])
//   double   weights (indptr[Q]), gradients (indptr[Q], d)
VOTESS_API votess_status votess_natural_array(const votess_natural* natural, const char* name, votess_array* array);
// Writes the sums of values, weighted by these coordinates; NaN where there are none. values: N * components.
// interpolated: count * components. gradients: d times as many, or NULL.
VOTESS_API votess_status votess_diagram_interpolate(const votess_diagram* diagram, const double* values,
                                                    size_t components, const double* queries, size_t count,
                                                    int32_t method, int32_t at_walls, const double* weights,
                                                    double* interpolated, double* gradients);

// Fills a grid from the seeds' values, see Diagram::to_grid in diagram.hpp. values: N * columns. shape: nx, ny, nz,
// where nz is 1 in the plane. project: 0, 1 or 2 to sum along that axis, else -1. grid: nx * ny * nz * columns, without
// the projected axis. *without_place becomes the number of seeds whose mass has no place; may be NULL.
#define VOTESS_GRID_MEAN 0
#define VOTESS_GRID_DTFE 1
#define VOTESS_GRID_NEAREST 2
#define VOTESS_GRID_SIBSON 3
VOTESS_API votess_status votess_diagram_to_grid(const votess_diagram* diagram, const double* values, size_t columns,
                                                const size_t shape[3], int32_t method, int32_t project, double* grid,
                                                size_t* without_place);

// The fields of FitOptions in fit.hpp.
typedef struct votess_fit_options {
    uint32_t struct_size;  // set by votess_fit_options_init
    uint32_t max_steps;
    double tolerance;
    int32_t normalize;        // nonzero: true
    int32_t reserved;         // 0
    const double* density;    // the values of Density in density.hpp, in its order; NULL: none
    size_t density_shape[3];  // nx, ny, nz
} votess_fit_options;

// The fields of VolumeFit in fit.hpp that are numbers.
typedef struct votess_fit_stats {
    uint32_t struct_size;  // set it to sizeof(votess_fit_stats) before votess_fit_get_stats
    uint32_t steps;
    uint32_t tessellations;
    uint32_t reserved;
    double residual;
    double seconds_tessellate, seconds_assemble, seconds_solve, seconds_total;
} votess_fit_stats;

// Writes the defaults, struct_size too. options: not NULL. size: sizeof(votess_fit_options) as the caller compiled it.
VOTESS_API votess_status votess_fit_options_init(votess_fit_options* options, size_t size);
// Finds weights for given volumes, see fit_volumes() in fit.hpp. points: 3 * count coordinates, 2 * count if
// options->planar. targets: count volumes. options, fit_options: NULL = defaults; options->weights or radii are the
// start. On success *out is new, else NULL, except after VOTESS_ERROR_NOT_CONVERGED: it then has the best weights so
// far and no result.
VOTESS_API votess_status votess_fit_volumes(const double* points, size_t count, const double* targets,
                                            const votess_options* options, const votess_fit_options* fit_options,
                                            votess_fit** out);
VOTESS_API void votess_fit_free(votess_fit* fit);
// The array of VolumeFit in fit.hpp: weights (count), double.
VOTESS_API votess_status votess_fit_array(const votess_fit* fit, const char* name, votess_array* array);
VOTESS_API votess_status votess_fit_get_stats(const votess_fit* fit, votess_fit_stats* stats);
// Sets *out to a new handle of the tessellation, which does not need the fit, or to NULL after a failure.
VOTESS_API votess_status votess_fit_result(const votess_fit* fit, votess_result** out);

// Zones of a watershed, see watershed() in zones.hpp. values: count numbers, one for each cell of the result. maxima:
// nonzero for true. On success *out is new, else NULL; the result may be freed afterwards.
VOTESS_API votess_status votess_zones_new(const votess_result* result, const double* values, size_t count,
                                          int32_t maxima, votess_zones** out);
// Sets *out to the zones that remain when those of at most this persistence join their parents, or to NULL after a
// failure; see Zones::merge in zones.hpp.
VOTESS_API votess_status votess_zones_merge(const votess_zones* zones, double threshold, votess_zones** out);
VOTESS_API void votess_zones_free(votess_zones* zones);
// The arrays of Zones in zones.hpp, for Z zones that P passes join:
//   int32_t  labels (N), cores (Z), pairs (P, 2), passes (P, 2), parents (Z)
//   double   saddles (P), persistence (Z)
//   uint8_t  at_walls (Z), where the rows list walls
VOTESS_API votess_status votess_zones_array(const votess_zones* zones, const char* name, votess_array* array);

// Sums of the cells by group, see groups() in groups.hpp. labels: count numbers, one for each cell of the result. On
// success *out is new, else NULL; the result may be freed afterwards.
VOTESS_API votess_status votess_groups_new(const votess_result* result, const int64_t* labels, size_t count,
                                           votess_groups** out);
VOTESS_API void votess_groups_free(votess_groups* groups);
// The arrays of Groups in groups.hpp, for G groups of N seeds:
//   int64_t  labels (G), member_indptr (G + 1), indptr (G + 1), counts (indptr[G])
//   int32_t  members (N), indices (indptr[G])
//   double   volumes (G), surface_areas (G), mesh_areas (G), areas (indptr[G])
VOTESS_API votess_status votess_groups_array(const votess_groups* groups, const char* name, votess_array* array);

// Masses under a density that is constant in the boxes of a grid, see masses() in density.hpp. density: shape[0] *
// shape[1] * shape[2] values. threads: as in votess_options. On success *out is new, else NULL; the result may be freed
// afterwards.
VOTESS_API votess_status votess_masses_new(const votess_result* result, const double* density, const size_t shape[3],
                                           uint32_t threads, votess_masses** out);
VOTESS_API void votess_masses_free(votess_masses* masses);
// The arrays of Masses in density.hpp: masses (N), centroids (N, d), second_moments (N), face_masses (indptr[N]),
// double.
VOTESS_API votess_status votess_masses_array(const votess_masses* masses, const char* name, votess_array* array);

// The network of vertices and edges, see network() in network.hpp. points: 3 * count coordinates of the result's
// points, in the plane 2 * count. On success *out is new, else NULL.
VOTESS_API votess_status votess_network_new(const votess_result* result, const double* points, size_t count,
                                            votess_network** out);
VOTESS_API void votess_network_free(votess_network* network);
// The arrays of Network in network.hpp, of V vertices and E edges:
//   double   points (V, d), vertex_radii (V), edge_radii (E)
//   int32_t  vertices (V), edges (E, 2)
//   uint8_t  at_walls (V)
//   int8_t   shifts (E, d), in a periodic domain
VOTESS_API votess_status votess_network_array(const votess_network* network, const char* name, votess_array* array);
// Writes the largest sphere at a vertex; see Network::largest_included.
VOTESS_API votess_status votess_network_largest_included(const votess_network* network, double* radius,
                                                         int32_t* vertex);
// Writes the largest sphere that can travel without end, see Network::largest_free. axis: 0, 1 or, in space, 2; -1 for
// any. *edge is -1 without such ways.
VOTESS_API votess_status votess_network_largest_free(const votess_network* network, int32_t axis, double* radius,
                                                     int32_t* edge, double* included_radius, int32_t* included_vertex);

// The pieces of cells in a mesh, see pieces() in pieces.hpp. gap: between pieces, 0 for none. threads: as in
// votess_options. progress: may be NULL; user: passed to it. On success *out is new, else NULL.
VOTESS_API votess_status votess_pieces_new(const votess_result* result, double gap, uint32_t threads,
                                           votess_progress_callback progress, void* user, votess_pieces** out);
VOTESS_API void votess_pieces_free(votess_pieces* pieces);
// The arrays of Pieces in pieces.hpp, of P pieces with V vertices and T triangles:
//   int64_t  indptr (N + 1), vertex_offsets (P + 1), triangle_offsets (P + 1)
//   double   vertices (V, 3), volumes (P), centroids (P, 3)
//   int32_t  triangles (T, 3), sources (T)
//   uint8_t  on_surface (T)
VOTESS_API votess_status votess_pieces_array(const votess_pieces* pieces, const char* name, votess_array* array);

// The alpha complex, see alpha_complex() in alpha.hpp. points: 3 * count coordinates of the result's points, in the
// plane 2 * count. replicate: 3 numbers of copies along the box vectors, or NULL for one each. On success *out is new,
// else NULL.
VOTESS_API votess_status votess_alpha_new(const votess_result* result, const double* points, size_t count,
                                          const int32_t* replicate, votess_alpha** out);
VOTESS_API void votess_alpha_free(votess_alpha* alpha);
// The arrays of AlphaSimplices in alpha.hpp, for the M simplices of dimension k, which is 0 to 3:
//   int32_t  seeds (M, k + 1)
//   int8_t   shifts (M, (k + 1) * d), in a periodic domain
//   double   values (M)
//   uint8_t  gabriel (M)
VOTESS_API votess_status votess_alpha_array(const votess_alpha* alpha, int32_t k, const char* name,
                                            votess_array* array);

// Checks a result against its points, see verify() in votess.hpp. A failed check is not a failed call.
// passed: 1 or 0. proven: 1 if all cells are proven, else 0; may be NULL. skipped: VOTESS_CHECK_* bits of the checks
// whose arrays the result lacks; may be NULL. sample: number of cells to clip again; VOTESS_SAMPLE_AUTOMATIC for a
// proof of all cells, or for about a second's work where float64 cannot settle it. sampled: number of cells clipped
// again, up to the one that failed; may be NULL. tiny_faces: as by votess_count_tiny_faces, or
// VOTESS_TINY_FACES_UNKNOWN for a subset, in a mesh and in the plane; may be NULL. failure: failure_size bytes for one
// line on the first failed check, else ""; zero-terminated, cut if too long; NULL with size 0. unproven: the same for
// one line on why not all cells are proven.
VOTESS_API votess_status votess_verify(const votess_result* result, const double* points, size_t count, size_t sample,
                                       uint64_t rng_seed, int* passed, int* proven, uint32_t* skipped, size_t* sampled,
                                       uint64_t* tiny_faces, char* failure, size_t failure_size, char* unproven,
                                       size_t unproven_size);
#define VOTESS_TINY_FACES_UNKNOWN UINT64_MAX

// Writes Stats::tiny_faces to *tiny_faces, see count_tiny_faces() in votess.hpp. points, count: as for votess_verify.
VOTESS_API votess_status votess_count_tiny_faces(const votess_result* result, const double* points, size_t count,
                                                 uint64_t* tiny_faces);
// Writes 3 * count coordinates, in the plane 2 * count, of the points inside a periodic domain, see wrapped_points() in
// votess.hpp.
VOTESS_API votess_status votess_wrapped_points(const votess_result* result, const double* points, size_t count,
                                               double* places);

// Writes 3 * count bytes: the colors of values in pictures, see value_colors() in picture.hpp. colormap: 0 tide, 1
// ember, 2 gray.
VOTESS_API votess_status votess_value_colors(const double* values, size_t count, int32_t colormap, uint8_t* rgb);

// Values of the cells, a column of .vtu files.
typedef struct votess_column {
    const char* name;    // UTF-8, zero-terminated
    const void* values;  // cells * width numbers, a row for each cell
    uint64_t width;      // numbers in a row, 1 to 4096
    char kind;           // 'f' floating point, 'i' signed, 'u' unsigned
    uint8_t bytes;       // of a number: 4 or 8 for 'f', else 1, 2, 4 or 8
} votess_column;

// How well a mesh suits solvers, as OpenFOAM's checkMesh measures it.
typedef struct votess_mesh_quality {
    uint32_t struct_size;  // sizeof(votess_mesh_quality)
    uint32_t reserved;     // 0
    uint64_t cells, faces, internal_faces, vertices;
    double
        max_non_orthogonality;  // between a face's normal and the line through the centroids of its cells, in degrees
    double mean_non_orthogonality;  // of internal faces
    uint64_t severe_faces;          // above 70 degrees
    double
        max_skewness;  // distance of that line from the face's center, as a share of the face's size in its direction
    uint64_t skew_faces;                    // above 4
    double min_area, min_volume, min_edge;  // of faces, cells, edges
    uint64_t wrong_faces;                   // whose normal does not lead from owner to neighbor, or that have no area
    uint64_t wrong_cells;                   // without a positive volume
    uint64_t short_edges;                   // below votess_mesh.min_edge, which stay
} votess_mesh_quality;

// The mesh of N cells. Arrays are laid out as those of a result with VOTESS_WANT_FACES; the caller owns them.
typedef struct votess_mesh {
    uint32_t struct_size;                // sizeof(votess_mesh)
    uint32_t column_count;               // for .vtu
    uint64_t cells;                      // N
    uint64_t vertex_count;               // V
    const int64_t* indptr;               // N + 1
    const int32_t* indices;              // indptr[N]
    const int8_t* shifts;                // 3 * indptr[N]; NULL unless the domain is periodic
    const int64_t* face_offsets;         // indptr[N] + 1
    const int32_t* face_vertices;        // face_offsets[indptr[N]]
    const double* vertices;              // 3 * V
    const int64_t* cell_vertex_indptr;   // N + 1
    const int32_t* cell_vertex_indices;  // cell_vertex_indptr[N], ascending in each row
    const uint8_t* colors;               // 3 * N, red, green and blue of sRGB; .glb needs them; NULL for none in .ply
    const votess_column* columns;        // column_count
    double box_lower[3];                 // of the domain; the middle is the origin of positions in .glb
    double box_upper[3];
    int32_t planar;         // nonzero: cells of the plane, for .vtu alone; vertices and shifts have two components
    int32_t skip_open;      // nonzero: leave out cells that reach infinity, whose polygons hold -1; 0: refuse them
    uint64_t* left_out;     // receives their number; may be NULL
    double edges[9];        // a, b, c of a triclinic box; 0 for an axis-aligned one. For .foam, .tess, .cgns
    const double* seeds;    // 3 * N, for .tess
    const double* weights;  // N, of a power diagram, for .tess; NULL for none
    double min_edge;        // in .foam, .tess, .msh, .stl and .cgns collapse edges below this length; 0 for none
    uint64_t* short_edges;  // receives the number of these edges that stay; may be NULL
    // Receives the quality of what .foam, .tess, .msh, .stl and .cgns hold; struct_size must be set; may be NULL.
    votess_mesh_quality* quality;
} votess_mesh;

// A piece of a file.
typedef struct votess_bytes {
    const void* data;
    size_t count;    // bytes
    uint64_t total;  // bytes of the whole file; 0 when unknown before its end
    // The path of the file within its folder, for formats of several files; NULL for others. Pieces of one file follow
    // each other.
    const char* file;
} votess_bytes;

// Takes the next piece of a file, valid during the call. Return nonzero to continue, 0 to stop.
typedef int (*votess_write_callback)(const votess_bytes* bytes, void* user);

// Writes a mesh as a file, piece by piece. Fails with VOTESS_ERROR_INVALID_ARGUMENT for a NULL array, an index outside
// its array, and a .glb above 4 GiB; with VOTESS_ERROR_CANCELLED when write stops. format:
//   - ".vtu": polyhedra, in the plane polygons, with columns, without empty cells, ascending by their number of
//   vertices
//   - ".ply": faces, each once, with their two cells; triangles when there are colors
//   - ".obj": a group for each cell, named by its row, with its faces seen from outside
//   - ".glb": solids in colors
//   - ".foam": the files points, faces, owner, neighbour and boundary in constant/polyMesh, for OpenFOAM. Cells are the
//   rows with faces, in order. A patch for each wall, xmin to zmax for -1 to -6, wall7 and on for -7 and on; in a
//   periodic domain a pair of cyclic patches for each shift
//   - ".tess": the tessellation of Neper, with seeds and weights; its domain must not be periodic
//   - ".msh": surfaces in triangles, each once, for Gmsh. A physical volume for each cell, a physical surface for each
//   pair of cells and each wall
//   - ".stl": text, a solid for each cell, named by its row; two cells have the same triangles between them
//   - ".cgns": CGNS 3.4 in HDF5: one zone of NGON_n and NFACE_n, with the row of each cell. A boundary condition for
//   each patch of .foam, and in a periodic domain a pair of connections
// The last five need cells whose faces are all there, and fail where min_face or min_area dropped some. Their short
// edges may be collapsed by mesh.min_edge: the ends become one vertex, faces with two corners vanish, and cells stay
// closed. An edge stays if a cell would not remain a polyhedron of half its volume to 3/2, or a vertex leave its walls.
VOTESS_API votess_status votess_write_mesh(const votess_mesh* mesh, const char* format, votess_write_callback write,
                                           void* user);

// Measures a mesh as .foam holds it. Fails as votess_write_mesh() does for that. quality: struct_size must be set.
VOTESS_API votess_status votess_measure_mesh(const votess_mesh* mesh, votess_mesh_quality* quality);

// P pieces of N cells in a mesh. Arrays are laid out as those of votess_pieces; the caller owns them.
typedef struct votess_piece_arrays {
    uint32_t struct_size;             // sizeof(votess_piece_arrays)
    uint32_t reserved;                // 0
    uint64_t rows;                    // N
    const int64_t* indptr;            // N + 1
    const int64_t* ids;               // N, to name cells by
    const int64_t* vertex_offsets;    // P + 1
    const double* vertices;           // 3 * vertex_offsets[P]
    const int64_t* triangle_offsets;  // P + 1
    const int32_t* triangles;         // 3 * triangle_offsets[P]
    const uint8_t* on_surface;        // triangle_offsets[P]
    const double* centroids;          // 3 * P
    const int32_t* sources;  // triangle_offsets[P], or NULL: for joined meshes, and lines of votess_render_pieces()
    double min_edge;         // in .foam, .msh and .cgns, as votess_mesh has it; 0 for none
    uint64_t* short_edges;   // receives the number of these edges that stay; may be NULL
    votess_mesh_quality* quality;  // as votess_mesh has it
} votess_piece_arrays;

// Writes pieces as a file, the same way. Each piece is an object, named by its cell: "17", or "17.0", "17.1" if the
// cell has several. format:
//   - ".glb": y is up. The origin of each object is at its centroid. Materials: surface, inside
//   - ".obj": the same materials, without a file of them
//   - ".3mf": the same materials, in millimeters
//   - ".stl": binary; all pieces in one
//   - ".foam", ".msh", ".cgns": one mesh of all pieces, as votess_write_mesh() writes it of whole cells. Corners at one
//   place become one, and pieces share the polygons between them. Needs the sources, and the pieces of all cells,
//   without a gap. Cell k of OpenFOAM is piece k. Physical volumes of Gmsh are the rows. A patch or physical surface
//   for each connected part of the surface: "surface", or "surface1" and on
//   - ".geojson": pieces of the plane, whose vertices and centroids have two components and whose triangles are edges
VOTESS_API votess_status votess_write_pieces(const votess_piece_arrays* pieces, const char* format,
                                             votess_write_callback write, void* user);
// Measures pieces as .foam holds them. Fails as votess_write_pieces() does for that. quality: struct_size must be set.
VOTESS_API votess_status votess_measure_pieces(const votess_piece_arrays* pieces, votess_mesh_quality* quality);

// Write walls around round bodies, see sphere_walls() in votess.hpp: 4 * faces numbers, as votess_options.walls.
VOTESS_API votess_status votess_sphere_walls(const double center[3], double radius, size_t faces, double* walls);
VOTESS_API votess_status votess_cylinder_walls(const double point[3], const double axis[3], double radius, size_t faces,
                                               double* walls);
VOTESS_API votess_status votess_cone_walls(const double apex[3], const double axis[3], double angle, size_t faces,
                                           double* walls);

// Walls around the convex hull of points, see hull_walls() in votess.hpp: 4 numbers each, for votess_options.walls.
// points: 3 * count coordinates, 2 * count if options->planar. The points and options may be freed afterwards.
VOTESS_API votess_status votess_hull_new(const double* points, size_t count, const votess_options* options,
                                         votess_hull** out);
VOTESS_API void votess_hull_free(votess_hull* hull);
// Its array: walls (M, 4), double.
VOTESS_API votess_status votess_hull_array(const votess_hull* hull, const char* name, votess_array* array);

// Devices: index from 0 to votess_device_count() - 1. The strings are copied, zero-terminated, cut if too long; each
// may be NULL with size 0. Pass id as votess_options.device.
VOTESS_API size_t votess_device_count(void);
VOTESS_API votess_status votess_device_info(size_t index, char* id, size_t id_size, char* name, size_t name_size,
                                            char* description, size_t description_size);

#ifdef __cplusplus
}
#endif

#endif
