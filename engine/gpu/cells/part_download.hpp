// Brings the cells of a part to the host. Chunks leave what they make on the device; a batch of them, as many as there
// is room for, is then read by member, in slices that the host works on while the device writes the next one.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "gpu/cells/device_results.hpp"
#include "gpu/cells/host_cells.hpp"
#include "gpu/vulkan/commands.hpp"

namespace votess::gpu {

class PartDownload {
public:
    PartDownload(vulkan::Device& device, vulkan::Memory& memory);

    struct Wanted {
        std::uint32_t members = 0;
        bool neighbors = true, measure = true, areas = false, shifts = false;
        bool float64 = true;            // what is measured, else sums of two float32
        VkDeviceSize min_entries = 0;   // of the rows of a chunk
        std::uint32_t max_entries = 0;  // on the device; 0 = as it allows
    };
    // Begins a part, with a batch.
    void begin(const Wanted& wanted);
    void begin_batch();
    void wait();  // until the device is done with all
    // Tells whether the batch has room for so many entries more.
    [[nodiscard]] bool has_room(VkDeviceSize entries) const {
        return entries_ + entries <= results_.sizes().entries || !wanted_.neighbors;
    }
    void set_entries(std::uint32_t entries) { entries_ = entries; }
    [[nodiscard]] const DeviceResults& on_device() const { return results_; }

    // Once all chunks of a batch are done: info and row lengths by member.
    void read_cells(const Passes& passes);
    [[nodiscard]] std::span<const std::uint32_t> info() const {
        return info_host_.as<std::uint32_t>().first(wanted_.members);
    }
    [[nodiscard]] std::span<const std::uint32_t> lengths() const {
        return lengths_host_.as<std::uint32_t>().first(wanted_.members);
    }
    // After read_cells(), slice by slice; what `take` gets is gone when it returns.
    void read_geometry(const std::function<void(std::size_t first, std::size_t count, const Numbers&)>& take);
    void read_rows(const Passes& passes, const std::function<void(const DeviceRows&)>& take);

private:
    [[nodiscard]] ResultSizes best_sizes() const;
    void reserve();
    // record(slice, commands, staging) and take(slice, staging) for each slice, two of which are in flight.
    void stream(std::size_t slices, const auto& record, const auto& take);

    vulkan::Device& device_;
    vulkan::Memory& memory_;
    DeviceResults results_;
    Wanted wanted_;
    VkDeviceSize entries_ = 0;
    vulkan::Buffer info_host_, lengths_host_, staging_[2];
    vulkan::Commands commands_, slices_[2];
};

}  // namespace votess::gpu
