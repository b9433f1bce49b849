// Cells in flight, with their results on the host. Two chunks take turns, so that the host works on one while the
// device works on the other.
#pragma once

#include <cstdint>
#include <span>

#include "gpu/device_cells.hpp"
#include "gpu/schedule.hpp"
#include "gpu/seeds/seed_store.hpp"

namespace votess::gpu {

class Chunk {
public:
    Chunk(vulkan::Device& device, vulkan::Memory& memory, std::uint32_t cells, const PassSettings& settings);

    [[nodiscard]] std::uint32_t capacity() const { return cells_.capacity(); }
    // Records and submits the stages.
    void start(const SeedStore& seeds, const Passes& passes, const ChunkJob& job, const Piece& piece);
    void wait();

    // These tell of the finished chunk, per cell in sorted order.
    [[nodiscard]] const Piece& piece() const { return piece_; }
    [[nodiscard]] std::uint32_t first() const { return piece_.first; }
    [[nodiscard]] std::uint32_t count() const { return piece_.count; }
    [[nodiscard]] std::span<const std::uint32_t> info() const { return info_host_.as<std::uint32_t>().first(count()); }
    [[nodiscard]] std::span<const std::uint32_t> row_lengths() const {
        return length_host_.as<std::uint32_t>().first(count());
    }
    [[nodiscard]] std::span<const std::int32_t> rows(std::size_t size) const {
        return rows_out_.as<std::int32_t>().first(size);
    }
    // Area `entry` of those beside the rows, in the square of its cell's own unit of length.
    [[nodiscard]] double area(std::size_t entry) const;
    // Volume and centroid of a cell in its own unit of length.
    [[nodiscard]] double geometry(std::uint32_t cell, std::uint32_t component) const;
    // Cells that the first tier left, when there was a second one.
    [[nodiscard]] std::uint32_t left_count() const { return state_host_.as<ChunkState>()[0].left_count; }

    struct Seconds {
        double knn = 0, clip = 0, download = 0;
    };
    [[nodiscard]] Seconds seconds() const;  // by the device's clock; 0 where it has none

    // For tests of single passes.
    [[nodiscard]] const DeviceCells& on_device() const { return cells_; }

private:
    // Element i of an array of Number, see shaders/numbers/number.glsl.
    [[nodiscard]] double number(const Buffer& buffer, std::size_t i) const;

    bool float64_;
    bool measure_;
    OwnBuffers buffers_;
    DeviceCells cells_;
    Buffer info_host_, length_host_, geometry_host_, state_host_, rows_out_, areas_out_;
    Commands commands_;
    std::uint32_t stamps_[4]{};
    Piece piece_;
};

}  // namespace votess::gpu
