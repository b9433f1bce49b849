#include "gpu/cells/device_results.hpp"

#include <cstddef>

namespace votess::gpu {
namespace {

using vulkan::push_bytes;

}  // namespace

VkDeviceSize DeviceResults::bytes_per_member(bool measure) {
    return 4 * 4 + (measure ? geometry_bytes : 0);
}

VkDeviceSize DeviceResults::bytes_per_entry(const ResultSizes& sizes) {
    return 4 + (sizes.areas ? DeviceCells::number_bytes : 0) + (sizes.shifts ? 4 : 0);
}

void DeviceResults::reserve(const ResultSizes& sizes) {
    sizes_ = {};
    buffers_.clear();
    const VkDeviceSize n = sizes.members, entries = sizes.entries;
    const auto take = [&](std::uint32_t binding, VkDeviceSize bytes, const char* name) {
        bindings_.set(binding, buffers_.take(bytes, name));
    };
    take(BINDING_PART_INFO, 4 * n, "part info");
    take(BINDING_PART_LENGTH, 4 * n, "part length");
    take(BINDING_PART_BEGIN, 4 * n, "part begin");
    take(BINDING_PART_OFFSETS, 4 * n, "part offsets");
    take(BINDING_PART_GEOMETRY, sizes.measure ? geometry_bytes * n : 0, "part geometry");
    take(BINDING_HEADER, sizeof(FrameHeader), "part entries");
    scan_.reserve(buffers_, sizes.members);
    rows_ = buffers_.take(4 * entries, "rows out");
    areas_ = sizes.areas ? buffers_.take(DeviceCells::number_bytes * entries, "areas out") : Slice{};
    shifts_ = sizes.shifts ? buffers_.take(4 * entries, "shifts out") : Slice{};
    sizes_ = sizes;
}

void DeviceResults::record_begin(Recorder& recorder) const {
    recorder.fill(slice(BINDING_HEADER), 0, sizeof(FrameHeader), 0);
    recorder.fill(slice(BINDING_PART_INFO), 0, slice(BINDING_PART_INFO).size, STATUS_NEEDS_EXACT);
    recorder.fill(slice(BINDING_PART_LENGTH), 0, slice(BINDING_PART_LENGTH).size, 0);
}

void DeviceResults::take_rows_of(DeviceCells& cells) const {
    cells.set_rows_out({.rows = rows_, .areas = areas_, .shifts = shifts_, .capacity = sizes_.entries});
}

void DeviceResults::record_chunk(Recorder& recorder, const Passes& passes, const DeviceCells& cells,
                                 const ChunkJob& job, std::uint32_t first, std::uint32_t count) const {
    const FramePush push{.first_cell = first,
                         .cell_count = count,
                         .capacity = sizes_.entries,
                         .neighbors = job.neighbors ? 1u : 0u,
                         .geometry = sizes_.measure ? 1u : 0u,
                         .shift = 0,
                         .seed_count = 0,
                         .own_count = job.own_count,
                         .keeps = 0};
    Bindings bindings = bindings_;
    bindings.set(BINDING_SEED_INPUT, cells.seed_input());
    bindings.set(BINDING_CHUNK, cells.chunk());
    bindings.set(BINDING_GEOMETRY, cells.geometry());
    if (job.neighbors) {
        recorder.copy(slice(BINDING_HEADER), offsetof(FrameHeader, entries), cells.state(),
                      offsetof(ChunkState, row_base), 4);
        cells.record_rows(recorder, passes);
    }
    recorder.run(passes.download_place, bindings, push, count);
    if (!job.neighbors) return;
    recorder.run(passes.download_total, bindings, push, 1);
}

void DeviceResults::record_offsets(Recorder& recorder, const Passes& passes, std::uint32_t count) const {
    recorder.copy(slice(BINDING_PART_LENGTH), 0, slice(BINDING_PART_OFFSETS), 0, VkDeviceSize{count} * 4);
    recorder.barrier();
    scan_.record(recorder, passes, slice(BINDING_PART_OFFSETS), count);
}

void DeviceResults::record_rows(Recorder& recorder, const Passes& passes, const RowSlice& slice,
                                const SliceArrays& to) const {
    Bindings bindings = bindings_;
    // Passes bind the rows in place of arrays that are not requested.
    const auto set = [&](std::uint32_t binding, const Slice& array, const Slice& rows) {
        bindings.set(binding, array ? array : rows);
    };
    set(BINDING_ROWS_OUT, rows_, rows_);
    set(BINDING_AREAS_OUT, areas_, rows_);
    set(BINDING_SHIFTS_OUT, shifts_, rows_);
    set(BINDING_SLICE_ROWS, to.rows, to.rows);
    set(BINDING_SLICE_AREAS, to.areas, to.rows);
    set(BINDING_SLICE_SHIFTS, to.shifts, to.rows);
    const GatherPush push{slice.first,   slice.count,        slice.entry,
                          slice.entries, to.areas ? 1u : 0u, to.shifts ? 1u : 0u};
    recorder.dispatch(passes.download_gather, bindings.list(), push_bytes(push),
                      blocks_of(slice.entries, GATHER_ENTRIES));
}

}  // namespace votess::gpu
