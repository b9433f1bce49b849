#pragma once

#include <cuda_runtime_api.h>

// A frame's arrays as CUDA sees them. The order of all is that of the seeds.
struct Rows {
    float4* seeds;           // x y z, and a number that votess skips
    const uint4* cells;      // votess::vulkan::Cell: status, row_begin, row_length, faces
    const int* indices;      // the rows: ids of neighbors, negative for walls
    const float4* geometry;  // centroid relative to the seed, volume
    unsigned count;
};

// Enqueues a kernel that moves each seed to the centroid of its cell, and adds the number of pairs of neighbors to
// *pairs.
cudaError_t move_to_centroids(const Rows& rows, unsigned* pairs, cudaStream_t stream);
