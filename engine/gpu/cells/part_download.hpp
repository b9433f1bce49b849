// Brings the cells of a part to the host. Chunks leave their cells on the device. A batch is as many cells as there is
// room for; it is read by member, in slices. The host works on one slice while the device writes the next.
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
        bool float64 = true;            // geometry is float64, else sums of two float32
        VkDeviceSize min_entries = 0;   // for the rows of a chunk
        std::uint32_t max_entries = 0;  // on the device; 0 = as it allows
    };
    // Begins a part, with a batch.
    void begin(const Wanted& wanted);
    void begin_batch();
    void wait();  // until the device is done
    // Returns whether the batch has room for this many more entries.
    [[nodiscard]] bool has_room(VkDeviceSize entries) const {
        return entries_ + entries <= results_.sizes().entries || !wanted_.neighbors;
    }
    void set_entries(std::uint32_t entries) { entries_ = entries; }
    [[nodiscard]] VkDeviceSize entries() const { return entries_; }
    [[nodiscard]] const DeviceResults& on_device() const { return results_; }

    // Reads info and row lengths by member, once all chunks of a batch are done.
    void read_cells(const Passes& passes);
    [[nodiscard]] std::span<const std::uint32_t> info() const {
        return info_host_.as<std::uint32_t>().first(wanted_.members);
    }
    [[nodiscard]] std::span<const std::uint32_t> lengths() const {
        return lengths_host_.as<std::uint32_t>().first(wanted_.members);
    }
    // Read slice by slice, after read_cells(). The arguments of `take` are valid until it returns.
    void read_geometry(const std::function<void(std::size_t first, std::size_t count, const Numbers&)>& take);
    void read_rows(const Passes& passes, const std::function<void(const DeviceRows&)>& take);

private:
    [[nodiscard]] ResultSizes best_sizes() const;
    void reserve();
    // Calls record(slice, commands, staging) and take(slice, staging) for each slice. Two are in flight.
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
