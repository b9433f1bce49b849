#include "move.hpp"

namespace {

__global__ void move(Rows rows, unsigned* pairs) {
    const unsigned i = blockIdx.x * blockDim.x + threadIdx.x;
    if (i >= rows.count) return;
    const uint4 cell = rows.cells[i];
    const int* const row = rows.indices + cell.y;
    unsigned found = 0;
    for (unsigned k = 0; k < cell.z; ++k) found += row[k] > static_cast<int>(i);
    atomicAdd(pairs, found);
    const float4 to = rows.geometry[i];  // 0 where the device left the cell unresolved
    float4& seed = rows.seeds[i];
    seed.x += to.x;
    seed.y += to.y;
    seed.z += to.z;
}

}  // namespace

cudaError_t move_to_centroids(const Rows& rows, unsigned* pairs, cudaStream_t stream) {
    constexpr unsigned block = 128;
    move<<<(rows.count + block - 1) / block, block, 0, stream>>>(rows, pairs);
    return cudaGetLastError();
}
