// Cells in flight: some sorted seeds whose candidates, cells and rows are in the device's memory at once. Two chunks
// take turns, so that the host works on one while the device works on the other. Stages knn, clip and download.
#pragma once

#include <cstdint>
#include <span>

#include "gpu/seed_store.hpp"

namespace votess::gpu {

// What the cells of a part may rely on, and what is wanted of them.
struct ChunkJob {
    bool neighbors = true, walls = false;
    double volume_tolerance = 1e-5;
    // Cells of the seeds with an index of at least this are beside the part and not made.
    std::uint32_t own_count = 0;
    // Bounds in units, from the box's lower corner, within which all seeds are known; see KnnPush.
    std::uint64_t lower[3]{}, upper[3]{};
    std::uint32_t bounded = 0;
};

class Chunk {
public:
    Chunk(vulkan::Device& device, vulkan::Memory& memory, std::uint32_t cells, const PassSettings& settings);

    // Bytes per cell of a chunk on the device; the largest of its buffers.
    static VkDeviceSize bytes_per_cell(const PassSettings& settings);
    static VkDeviceSize largest_bytes_per_cell(const PassSettings& settings);

    [[nodiscard]] std::uint32_t capacity() const { return cells_; }
    // Records and submits the stages for sorted seeds first .. first + count - 1.
    void start(const SeedStore& seeds, const Passes& passes, const ChunkJob& job, std::uint32_t first,
               std::uint32_t count, bool second_tier);
    void wait();

    // Of the finished chunk; per cell in sorted order.
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
    [[nodiscard]] std::uint32_t list_columns() const { return list_columns_; }
    [[nodiscard]] const Buffer& list() const { return list_; }
    [[nodiscard]] const Buffer& list_info() const { return list_info_; }

private:
    std::uint32_t cells_;
    std::uint32_t todo_capacity_;
    std::uint32_t list_columns_;
    bool float64_geometry_;
    bool measure_, areas_wanted_;
    Buffer list_, list_info_, rows_, second_rows_, areas_, second_areas_;
    Buffer info_, row_length_, row_place_, row_offsets_, geometry_, todo_, state_;
    Buffer info_host_, length_host_, geometry_host_, state_host_, rows_out_, areas_out_;
    Scan scan_;
    Commands commands_;
    std::uint32_t stamps_[4]{};
    std::uint32_t first_ = 0, count_ = 0;
};

}  // namespace votess::gpu
