// Cells in flight, with their results on the host. Two chunks take turns, so that the host works on one while the
// device works on the other.
#pragma once

#include <cstdint>
#include <span>

#include "gpu/device_cells.hpp"
#include "gpu/seeds/seed_store.hpp"

namespace votess::gpu {

class Chunk {
public:
    Chunk(vulkan::Device& device, vulkan::Memory& memory, std::uint32_t cells, const PassSettings& settings);

    [[nodiscard]] std::uint32_t capacity() const { return cells_.capacity(); }
    // Records and submits the stages for sorted seeds first .. first + count - 1.
    void start(const SeedStore& seeds, const Passes& passes, const ChunkJob& job, std::uint32_t first,
               std::uint32_t count, bool second_tier);
    void wait();

    // These tell of the finished chunk, per cell in sorted order.
    [[nodiscard]] std::uint32_t first() const { return first_; }
    [[nodiscard]] std::uint32_t count() const { return count_; }
    [[nodiscard]] std::span<const std::uint32_t> info() const { return info_host_.as<std::uint32_t>().first(count_); }
    [[nodiscard]] std::span<const std::uint32_t> row_lengths() const {
        return length_host_.as<std::uint32_t>().first(count_);
    }
    [[nodiscard]] std::span<const std::int32_t> rows(std::size_t size) const {
        return rows_out_.as<std::int32_t>().first(size);
    }
    // Area `entry` of those beside the rows, in the square of its cell's own unit of length.
    [[nodiscard]] double area(std::size_t entry) const;
    // Volume and centroid of a cell in its own unit of length.
    [[nodiscard]] double geometry(std::uint32_t cell, std::uint32_t component) const;
    [[nodiscard]] std::uint32_t todo_count() const { return state_host_.as<ChunkState>()[0].todo_count; }

    struct Seconds {
        double knn = 0, clip = 0, download = 0;
    };
    [[nodiscard]] Seconds seconds() const;

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
    std::uint32_t first_ = 0, count_ = 0;
};

}  // namespace votess::gpu
