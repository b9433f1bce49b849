// Some sorted seeds whose candidates, cells and rows are in the device's memory at once. Arrays, and what is recorded
// for the second half of knn, for clip and for download.
#pragma once

#include <algorithm>
#include <cstdint>

#include "gpu/seeds/device_seeds.hpp"

namespace votess::gpu {

// What the cells may rely on, and what is wanted of them.
struct ChunkJob {
    bool neighbors = true, walls = false;
    double volume_tolerance = 1e-5;
    // Cells of the seeds with an index of at least this are beside the part and not made.
    std::uint32_t own_count = 0;
    // Bounds in units, from the box's lower corner, within which all seeds are known; see KnnPush.
    std::uint64_t lower[3]{}, upper[3]{};
    std::uint32_t bounded = 0;
    // Ids from here on are in rows by the name that the seeds have for them.
    std::uint32_t named_from = INDEX_MASK;
};

// Cells of a chunk: so many as are wanted, 0 = as suits the device, at most `seeds` and what its limits allow.
[[nodiscard]] std::uint32_t usual_chunk(const vulkan::Device& device, const PassSettings& settings,
                                        std::uint32_t wanted, std::uint32_t seeds);

class DeviceCells {
public:
    static constexpr std::uint32_t geometry_components = 4;  // volume and centroid
    static constexpr std::uint32_t number_bytes = 8;  // of each, and of an area: Number in shaders/numbers/number.glsl

    // Bytes per cell of a chunk on the device; the largest of its arrays.
    static VkDeviceSize bytes_per_cell(const PassSettings& settings);
    static VkDeviceSize largest_bytes_per_cell(const PassSettings& settings);

    // Arrays for up to `cells`.
    void reserve(Workspace& workspace, std::uint32_t cells, const PassSettings& settings);
    // Where the rows go, and the areas beside them; for that many entries. Windows of 2^window_bits of them are bound.
    void set_rows_out(const Slice& rows, const Slice& areas, std::uint32_t capacity,
                      std::uint32_t window_bits = max_window_bits);
    // Beside the rows, in as many windows; after set_rows_out(), without which none are wanted.
    void set_shifts_out(const Slice& shifts);
    static constexpr std::uint32_t max_window_bits = 31;
    // The largest that the device can bind.
    [[nodiscard]] static std::uint32_t window_bits(const vulkan::Device& device);

    // Sorted seeds first .. first + count - 1.
    void set_job(const DeviceSeeds& seeds, const PassSettings& settings, const ChunkJob& job, std::uint32_t first,
                 std::uint32_t count);
    // With a subgroup per cell search is part of clip.
    void record_knn(Recorder& recorder, const Passes& passes) const;
    void record_clip(Recorder& recorder, const Passes& passes, bool second_tier, bool ties = false) const;
    // The rows one after the other, from entry row_base of the chunk's state on.
    void record_rows(Recorder& recorder, const Passes& passes) const;

    [[nodiscard]] std::uint32_t capacity() const { return cells_; }
    // Entries that the rows of so many cells may have.
    [[nodiscard]] VkDeviceSize max_entries(std::uint32_t cells) const {
        return VkDeviceSize{cells} * planes_ + VkDeviceSize{std::min(cells, todo_capacity_)} * more_planes_;
    }
    [[nodiscard]] const Bindings& bindings() const { return bindings_; }
    [[nodiscard]] Slice slice(std::uint32_t binding) const { return bindings_.get(binding); }

private:
    void set_windows(const std::uint32_t (&bindings)[ROW_WINDOWS], const Slice& rows);

    std::uint32_t cells_ = 0, todo_capacity_ = 0, max_of_tile_ = 0;
    std::uint32_t planes_ = 0, more_planes_ = 0;  // of a cell, and of one of the second tier beyond
    Scan scan_, todo_scan_;
    Slice tiles_;  // of cells left to the second tier
    Bindings bindings_, second_bindings_;
    KnnPush knn_{};
    ClipPush clip_{};
    CellsPush both_{};
    RowsPush rows_{};
    TodoPush todo_{};
};

}  // namespace votess::gpu
