// Cells of some sorted seeds on the device: candidates, cells and rows. Holds the arrays and records the second half of
// knn, clip and download.
#pragma once

#include <algorithm>
#include <cstdint>

#include "gpu/domain/parts.hpp"
#include "gpu/seeds/device_seeds.hpp"

namespace votess::gpu {

// The limits of the seeds that the cells may rely on, and the requested results.
struct ChunkJob : KnownSeeds {
    bool neighbors = true, walls = false;
    double volume_tolerance = 1e-5;
    // Rows have the names of ids from here on in place of the ids.
    std::uint32_t named_from = INDEX_MASK;
};

// Returns the cells of a chunk: `wanted`, 0 = as suits the device, at most `seeds` and the device's limits.
[[nodiscard]] std::uint32_t usual_chunk(const vulkan::Device& device, const PassSettings& settings,
                                        std::uint32_t wanted, std::uint32_t seeds);

class DeviceCells {
public:
    static constexpr std::uint32_t geometry_components = 4;  // volume and centroid
    // Bytes of a component or an area: Number in shaders/numbers/number.glsl. Areas of frames are float32.
    static constexpr VkDeviceSize number_bytes = 8, area_bytes_of_frames = 4;

    // Returns the bytes per cell of a chunk on the device, of all arrays and of the largest.
    static VkDeviceSize bytes_per_cell(const PassSettings& settings);
    static VkDeviceSize largest_bytes_per_cell(const PassSettings& settings);

    // Reserves arrays for up to `cells` cells.
    void reserve(Workspace& workspace, std::uint32_t cells, const PassSettings& settings);
    // Arrays for rows, each of `capacity` entries. An empty one is not requested.
    struct RowsOut {
        Slice rows, areas, shifts;
        std::uint32_t capacity = 0;
        // Passes see 2^window_bits entries at once.
        std::uint32_t window_bits = max_window_bits;
    };
    static constexpr std::uint32_t max_window_bits = 31;
    // Returns the largest that the device can bind, in frames.
    [[nodiscard]] static std::uint32_t window_bits(const vulkan::Device& device);
    void set_rows_out(const RowsOut& rows);

    // Sets the sorted seeds first .. first + count - 1. With PassSettings::follow these are all.
    void set_job(const DeviceSeeds& seeds, const PassSettings& settings, const ChunkJob& job, std::uint32_t first,
                 std::uint32_t count);
    // Records nothing but a reset where subgroups search as they clip.
    void record_knn(Recorder& recorder, const Passes& passes) const;
    void record_clip(Recorder& recorder, const Passes& passes, bool second_tier, bool ties = false) const;
    // Records the copy of rows one after the other, from entry row_base of the chunk's state on.
    void record_rows(Recorder& recorder, const Passes& passes) const;

    // What the passes for kept cells need of the job.
    [[nodiscard]] const ClipPush& clip_push() const { return clip_; }
    [[nodiscard]] const Bindings& bindings() const { return bindings_; }

    [[nodiscard]] std::uint32_t capacity() const { return cells_; }
    // Returns the most entries that the rows of `cells` cells have.
    [[nodiscard]] VkDeviceSize max_entries(std::uint32_t cells) const {
        return VkDeviceSize{cells} * planes_ + VkDeviceSize{std::min(cells, todo_capacity_)} * more_planes_;
    }
    [[nodiscard]] Slice seed_input() const { return bindings_.get(BINDING_SEED_INPUT); }
    [[nodiscard]] Slice geometry() const { return bindings_.get(BINDING_GEOMETRY); }
    [[nodiscard]] Slice chunk() const { return bindings_.get(BINDING_CHUNK); }
    // Returns the ChunkState.
    [[nodiscard]] Slice state() const;
    // Returns one of the arrays behind it, WORDS_, of the cells of the job.
    [[nodiscard]] Slice words_of(std::uint32_t array) const;

private:
    std::uint32_t cells_ = 0, todo_capacity_ = 0, max_of_tile_ = 0;
    VkDeviceSize second_first_ = 0;               // entry of the rows
    VkDeviceSize keeps_ = 0;                      // the same, of the columns of kept cells; 0: there are none
    std::uint32_t planes_ = 0, more_planes_ = 0;  // of a cell, and how many more in the second tier
    Scan scan_, todo_scan_;
    Slice tiles_;  // of cells left to the second tier
    Bindings bindings_, second_bindings_;
    KnnPush knn_{};
    ClipPush clip_{};
    CellsPush both_{}, both_again_{};
    RowsOut rows_out_;
    RowsPush rows_{};
    TodoPush todo_{};
};

}  // namespace votess::gpu
