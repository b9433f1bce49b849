// The cells of a frame in the host's memory, in the order of the points.
#pragma once

#include <votess/frames.h>

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

// Where the arrays of frames are in memory that another API maps.
struct ExportedArrays : votess_frames_export {
    static constexpr std::uint64_t none = ~std::uint64_t{0};  // an array that was not requested
    ExportedArrays() : votess_frames_export{} {
        memory_descriptor = semaphore_descriptor = -1;
        for (std::uint64_t* const array :
             {&points, &weights, &status, &indptr, &indices, &face_areas, &volumes, &shifts, &centroids, &given_volumes,
              &given_centroids, &given_face_areas, &by_points, &by_weights})
            *array = none;
    }
};

}  // namespace votess::detail
