// Frames: cells of points that move, call after call, on any Vulkan device. Rows are int32 and sizes float32, as
// tensors have them. votess owns the device, the buffers and the commands; votess/vulkan.hpp is for programs with a
// device of their own. Rules, options and errors are those of votess/votess.h.
//
//     votess_frames_options frames = {sizeof frames, 100000};  // at most 100,000 points
//     votess_frames_new(&frames, &options, NULL, &f);          // options: box, periodic, cell, walls, want, device ...
//     votess_frames_run(f, points, NULL, count, &cells);       // every step
//     votess_frame_cells_array(cells, "indices", &array);
#ifndef VOTESS_FRAMES_H
#define VOTESS_FRAMES_H

#include <votess/votess.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct votess_frames votess_frames;            // a device, its buffers and commands; one call at a time
typedef struct votess_frame_cells votess_frame_cells;  // the cells of one run; independent of later runs

typedef struct votess_frames_options {
    uint32_t struct_size;  // set it to sizeof(votess_frames_options)
    uint32_t max_points;   // of a run, 1 to 2^27
    int32_t has_weights;   // 1: each run has weights from least_weight to largest_weight; or 0
    uint32_t max_entries;  // of all rows; 0: 20 a point. Cells whose rows do not fit stay unresolved
    double least_weight;   // length unit squared; points outside the range have no cell
    double largest_weight;
    double margin;        // width of the layer of images around a periodic box; 0: as suits uniform points
    uint32_t max_images;  // in that layer; 0: a quarter more than uniform points have
    // VOTESS_EXPORT_*: arrays are in device memory that another API maps, and points and weights have this type. See
    // votess_frames_get_export. The device is then the one with the UUID, not that of the options. 0: in host memory.
    int32_t exported;
    uint8_t device_uuid[16];
    int32_t gradients;  // 1: there is votess_frames_vjp, or votess_frames_submit_vjp; needs float64, and neighbors in
                        // `want`
} votess_frames_options;

#define VOTESS_EXPORT_FLOAT32 4
#define VOTESS_EXPORT_FLOAT64 8

// Opens the device and makes its pipelines, which may take seconds. The domain of the options is a finite box or a
// cell. `want` may have neighbors, volumes, centroids and areas. The device "auto" is a GPU, or without one a software
// device. `follow` keeps the cells for the next run: those that still hold are not made again. It pays where points
// move by at most a hundredth of their distance. Refused: planar, mesh, only, min_face, min_area, weights, radii,
// outside = keep, duplicates = error, precision = double. share: frames whose device and pipelines the new ones use
// too, in milliseconds; or NULL.
VOTESS_API votess_status votess_frames_new(const votess_frames_options* frames, const votess_options* options,
                                           const votess_frames* share, votess_frames** out);
VOTESS_API void votess_frames_free(votess_frames* frames);  // NULL does nothing
// Writes a line that names the device and its kernel.
VOTESS_API votess_status votess_frames_device(const votess_frames* frames, char* text, size_t size);

// Makes the cells of `count` points, 3 * count coordinates. weights: count, or NULL without has_weights. A point
// outside the domain or not finite has the status VOTESS_CELL_OUTSIDE and no cell. In a periodic domain points up to
// one side outside are wrapped into it, and farther ones count as outside. The device proves each cell that it returns;
// the others have no row and a status that says why.
VOTESS_API votess_status votess_frames_run(votess_frames* frames, const double* points, const double* weights,
                                           size_t count, votess_frame_cells** out);
VOTESS_API votess_status votess_frames_run_f32(votess_frames* frames, const float* points, const double* weights,
                                               size_t count, votess_frame_cells** out);
// Returns all cells of the last run: the CPU makes those that the device left.
VOTESS_API votess_status votess_frames_resolve(votess_frames* frames, votess_frame_cells** out);

VOTESS_API void votess_frame_cells_free(votess_frame_cells* cells);  // NULL does nothing
// Returns the number of cells that the device left.
VOTESS_API size_t votess_frame_cells_unresolved(const votess_frame_cells* cells);
// Returns the number of cells of the last run that still held, with `follow`.
VOTESS_API size_t votess_frame_cells_kept(const votess_frame_cells* cells);
// Sets an array, in the order of the points. Arrays that were not requested are empty.
//   status      int32 N
//   indptr      int32 N + 1: row i is indices[indptr[i]] to indices[indptr[i + 1] - 1]
//   indices     int32, ids ascend in a row, then shifts; walls first, with list_walls
//   shifts      int8 x 3, for each entry of indices, in periodic domains
//   face_areas  float32, for each entry of indices; within about 1e-5 of the cell's surface
//   volumes     float32 N, relative error at most 1e-5; 0 without a cell
//   centroids   N x 3 in the type of the points, of the cells around these as given; NaN without a cell
VOTESS_API votess_status votess_frame_cells_array(const votess_frame_cells* cells, const char* name,
                                                  votess_array* array);

// Sets the derivatives of a number by the points and weights of the last run: by_points 3N, by_weights N. volumes,
// centroids, face_areas: its derivatives by these arrays of the cells, and as long; or NULL, 0. So it is a
// vector-Jacobian product. Those for centroids need volumes in `want` too; they are ignored where a point has no cell.
// The derivatives are in closed form, on the device, and usually right to 1e-5 of the largest one. Narrow cells of
// clusters lose digits, and cells far from their seeds in a power diagram. Where more than three cells meet at an edge,
// as in a lattice, areas have no derivative unless all are images of one point, and the result differs from one
// side to the other. Points without a cell have 0. Box, walls and the vectors of a periodic domain are fixed. Without
// weights, by_weights is the derivative at weights of 0. Refused while cells are unresolved.
VOTESS_API votess_status votess_frames_vjp(votess_frames* frames, const float* volumes, const double* centroids,
                                           const float* face_areas, double* by_points, double* by_weights);

// ---- Arrays on the device, for CUDA and other APIs ----
//
// The memory is exported (VK_KHR_external_memory_fd), and a timeline semaphore (VK_KHR_external_semaphore_fd), which
// begins at 0. A step: the other API writes the points, and sets the semaphore to the value `after` on its stream. It
// waits there for the value `done`, and then reads the arrays. No step waits on the host.

// Where the arrays are. UINT64_MAX: not requested.
typedef struct votess_frames_export {
    uint32_t struct_size;          // set it to sizeof(votess_frames_export)
    int32_t memory_descriptor;     // new ones with each call; the API that imports them owns them
    int32_t semaphore_descriptor;  // -1 where the device cannot export it
    int32_t reserved;
    uint64_t memory_bytes;                                  // of the allocation, which is a dedicated one
    uint64_t max_entries;                                   // room in indices
    uint64_t points, weights;                               // offsets in bytes: input, 3 numbers and 1 number a point
    uint64_t status, indptr, indices, face_areas, volumes;  // as those of votess_frame_cells_array()
    uint64_t shifts;                                        // int8 x 4 an entry, the fourth is 0
    uint64_t centroids;                                     // 3 numbers a point, as points
    // With gradients: derivatives by volumes, centroids and face_areas, which the other API writes, each in the type of
    // its array; and the gradient, 3 numbers and 1 number a point, as points.
    uint64_t given_volumes, given_centroids, given_face_areas, by_points, by_weights;
} votess_frames_export;
VOTESS_API votess_status votess_frames_get_export(votess_frames* frames, votess_frames_export* out);
// Submits the cells of `count` points. They begin when the semaphore has the value `after`, and set it to `done`, which
// is larger; values only grow from call to call. Waits on the host only while two submissions are pending.
VOTESS_API votess_status votess_frames_submit(votess_frames* frames, uint32_t count, uint64_t after, uint64_t done);
// Submits the gradient for the points of the last frame, as votess_frames_vjp() sets it. given: VOTESS_WANT_VOLUMES,
// VOTESS_WANT_CENTROIDS and VOTESS_WANT_AREAS, for the vectors that are written by the time of `after`. The gradient of
// points whose cells are unresolved is NaN, and that of their neighbors where vectors for their centroids are not 0.
// It is NaN too where votess_frames_vjp() refuses, and where a driver limits loops, as llvmpipe does, and a cell has
// some hundred neighbors.
VOTESS_API votess_status votess_frames_submit_vjp(votess_frames* frames, uint32_t given, uint64_t after, uint64_t done);
// Set the semaphore, or wait for it, on the host. Any thread may call them.
VOTESS_API votess_status votess_frames_signal(votess_frames* frames, uint64_t value);
VOTESS_API votess_status votess_frames_wait(votess_frames* frames, uint64_t value);
// Waits for the last submission, makes the cells that it left on the CPU, and writes all arrays again. Nothing else may
// use the memory meanwhile. resolved: gets the number of these cells, or NULL.
VOTESS_API votess_status votess_frames_resolve_exported(votess_frames* frames, uint64_t* resolved);

#ifdef __cplusplus
}
#endif

#endif
