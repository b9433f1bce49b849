// Cells in flight. Two chunks alternate: the host clips the cells that one left while the device works on the other.
// Certified cells stay on the device.
#pragma once

#include <cstdint>
#include <span>

#include "gpu/cells/device_results.hpp"
#include "gpu/schedule.hpp"
#include "gpu/seeds/seed_store.hpp"

namespace votess::gpu {

class Chunk {
public:
    Chunk(vulkan::Device& device, vulkan::Memory& memory, std::uint32_t cells, const PassSettings& settings);

    [[nodiscard]] std::uint32_t capacity() const { return cells_.capacity(); }
    // Records and submits the stages, which leave the cells in `results`.
    void start(const SeedStore& seeds, const Passes& passes, const ChunkJob& job, const Piece& piece,
               const DeviceResults& results);
    void wait();

    // Of the finished chunk. info: of each cell, in sorted order.
    [[nodiscard]] const Piece& piece() const { return piece_; }
    [[nodiscard]] std::uint32_t first() const { return piece_.first; }
    [[nodiscard]] std::uint32_t count() const { return piece_.count; }
    [[nodiscard]] std::span<const std::uint32_t> info() const { return info_host_.as<std::uint32_t>().first(count()); }
    // Returns the entries of all rows that the results hold.
    [[nodiscard]] std::uint32_t entries() const { return state_host_.as<ChunkState>()[0].row_base; }
    // Returns the number of cells that the first tier left, when there was a second one.
    [[nodiscard]] std::uint32_t left_count() const { return state_host_.as<ChunkState>()[0].left_count; }

    struct Seconds {
        double knn = 0, clip = 0, download = 0;
    };
    [[nodiscard]] Seconds seconds() const;  // by the device's clock; 0 where it has none

    // For tests of single passes.
    [[nodiscard]] const DeviceCells& on_device() const { return cells_; }

private:
    OwnBuffers buffers_;
    DeviceCells cells_;
    Buffer info_host_, state_host_;
    Commands commands_;
    std::uint32_t stamps_[4]{};
    Piece piece_;
};

}  // namespace votess::gpu
