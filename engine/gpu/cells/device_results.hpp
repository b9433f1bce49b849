// The cells of a part that stay on the device: status and geometry by member, and rows packed in the order of the
// chunks. Slices of rows are gathered from there in the order of the members.
#pragma once

#include <cstdint>

#include "gpu/cells/device_cells.hpp"
#include "gpu/vulkan/memory.hpp"

namespace votess::gpu {

// Which results stay, for how many members and entries of rows.
struct ResultSizes {
    std::uint32_t members = 0, entries = 0;
    bool measure = false, areas = false, shifts = false;
    bool operator==(const ResultSizes&) const = default;
};

class DeviceResults {
public:
    explicit DeviceResults(vulkan::Memory& memory) : buffers_(memory) {}

    static constexpr VkDeviceSize geometry_bytes =
        VkDeviceSize{DeviceCells::geometry_components} * DeviceCells::number_bytes;
    static VkDeviceSize bytes_per_member(bool measure);
    static VkDeviceSize bytes_per_entry(const ResultSizes& sizes);

    // Reserves arrays of these sizes. There are none after it throws.
    void reserve(const ResultSizes& sizes);
    [[nodiscard]] const ResultSizes& sizes() const { return sizes_; }

    // Records the reset: no cell is known, no row is stored.
    void record_begin(Recorder& recorder) const;
    // Makes `cells` write its rows here.
    void take_rows_of(DeviceCells& cells) const;
    // Records after the clip of sorted seeds from `first` on: stores their rows, for which there must be room, and
    // their status and geometry.
    void record_chunk(Recorder& recorder, const Passes& passes, const DeviceCells& cells, const ChunkJob& job,
                      std::uint32_t first, std::uint32_t count) const;
    // Records the sums of the lengths of the rows of members 0 .. count - 1, for record_rows().
    void record_offsets(Recorder& recorder, const Passes& passes, std::uint32_t count) const;

    // Rows of consecutive members.
    struct RowSlice {
        std::uint32_t first = 0, count = 0;    // members
        std::uint32_t entry = 0, entries = 0;  // entries before them, and their own
    };
    // Arrays for them, of `entries` rounded up to GATHER_ENTRIES; empty when not requested.
    struct SliceArrays {
        Slice rows, areas, shifts;
    };
    void record_rows(Recorder& recorder, const Passes& passes, const RowSlice& slice, const SliceArrays& to) const;

    [[nodiscard]] Slice slice(std::uint32_t binding) const { return bindings_.get(binding); }

private:
    OwnBuffers buffers_;
    ResultSizes sizes_;
    Scan scan_;
    Bindings bindings_;
    Slice rows_, areas_, shifts_;
};

}  // namespace votess::gpu
