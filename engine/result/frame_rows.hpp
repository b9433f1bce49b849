// The cells of a frame in the host's memory, in the order of the points.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/buffer.hpp"

namespace votess::detail {

// Arrays that were not requested are empty.
struct FrameRows {
    Buffer<std::int32_t> status;           // N CellStatus
    Buffer<std::int32_t> indptr, indices;  // N + 1 offsets; ids ascend in a row, walls first
    Buffer<std::int8_t> shifts;            // 3 an entry of indices, in periodic domains
    Buffer<float> face_areas;              // an entry of indices
    Buffer<float> volumes;                 // N; 0 without a cell
    // 3N, of the cells around the points as given; NaN without a cell. In the numbers of the points.
    Buffer<float> centroids32;
    Buffer<double> centroids64;
    std::size_t unresolved = 0;  // cells that the device did not certify
    std::size_t kept = 0;        // cells of the last frame that still hold
};

// Derivatives of a number by the arrays of FrameRows, and as long; null: 0.
struct FrameVectors {
    const float* volumes = nullptr;
    const double* centroids = nullptr;
    const float* face_areas = nullptr;
};

// Arrays of frames in memory that another API maps, see votess_frames_export.
struct ExportedArrays {
    static constexpr std::uint64_t none = ~std::uint64_t{0};  // an array that was not requested
    int memory_descriptor = -1, semaphore_descriptor = -1;    // the semaphore's is -1 where the device exports none
    std::uint64_t memory_bytes = 0, max_entries = 0;
    // Bytes from the start of the memory.
    std::uint64_t points = none, weights = none, status = none, indptr = none, indices = none, shifts = none,
                  face_areas = none, volumes = none, centroids = none, given_volumes = none, given_centroids = none,
                  given_face_areas = none, by_points = none, by_weights = none;
};

}  // namespace votess::detail
