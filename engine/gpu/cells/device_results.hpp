// What a device keeps of the cells of a part: by member what it knows about each, and their rows, packed in the order
// in which chunks made them. From there slices of rows are gathered in the order of the members.
#pragma once

#include <cstdint>

#include "gpu/cells/device_cells.hpp"
#include "gpu/vulkan/memory.hpp"

namespace votess::gpu {

// What is kept, for how many members and entries of rows.
struct ResultSizes {
    std::uint32_t members = 0, entries = 0;
    bool measure = false, areas = false, shifts = false;
    std::uint32_t window_bits = 0;  // of the rows, see DeviceCells::set_rows_out()
    bool operator==(const ResultSizes&) const = default;
};

class DeviceResults {
public:
    explicit DeviceResults(vulkan::Memory& memory) : buffers_(memory) {}

    static constexpr VkDeviceSize geometry_bytes =
        VkDeviceSize{DeviceCells::geometry_components} * DeviceCells::number_bytes;
    static VkDeviceSize bytes_per_member(bool measure);
    static VkDeviceSize bytes_per_entry(const ResultSizes& sizes);

    // Arrays of these sizes. When it throws there are none.
    void reserve(const ResultSizes& sizes);
    [[nodiscard]] const ResultSizes& sizes() const { return sizes_; }

    // No cell is known, no row taken.
    void record_begin(Recorder& recorder) const;
    // Has the rows of `cells` written here.
    void take_rows_of(DeviceCells& cells) const;
    // After the clip of sorted seeds from `first` on: their rows, for which there must be room, and what is known of
    // them.
    void record_chunk(Recorder& recorder, const Passes& passes, const DeviceCells& cells, const ChunkJob& job,
                      std::uint32_t first, std::uint32_t count) const;
    // For record_rows(): sums of the lengths of the rows of members 0 .. count - 1.
    void record_offsets(Recorder& recorder, const Passes& passes, std::uint32_t count) const;

    // Rows of consecutive members.
    struct RowSlice {
        std::uint32_t first = 0, count = 0;    // members
        std::uint32_t entry = 0, entries = 0;  // sum of the lengths before them, and of theirs
    };
    // Where they go: arrays of `entries`, rounded up to GATHER_ENTRIES; those not wanted are empty.
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
