#include "gpu/cells/part_download.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "core/arithmetic.hpp"

namespace votess::gpu {
namespace {

using vulkan::Buffer;
using vulkan::Commands;
using vulkan::MemoryKind;

constexpr VkDeviceSize slice_bytes = VkDeviceSize{16} << 20;
constexpr VkDeviceSize geometry_bytes = DeviceResults::geometry_bytes;
constexpr std::uint32_t usual_row = 20;  // entries per cell that the room for rows is made for
// The entries of a slice are a multiple of this. So each of its arrays starts at a multiple of 256 bytes, where any
// device can bind it.
constexpr std::uint32_t entry_block = 64;
constexpr std::size_t cell_group = 256;  // cells of a group; slices end between groups

}  // namespace

PartDownload::PartDownload(vulkan::Device& device, vulkan::Memory& memory)
    : device_(device),
      memory_(memory),
      results_(memory),
      commands_(device),
      slices_{Commands(device), Commands(device)} {}

void PartDownload::begin(const Wanted& wanted) {
    wanted_ = wanted;
    reserve();
    begin_batch();
}

void PartDownload::wait() {
    commands_.wait();
    for (Commands& slice : slices_) slice.wait();
}

void PartDownload::begin_batch() {
    entries_ = 0;
    commands_.submit([&] {
        commands_.barrier();
        results_.record_begin(commands_);
        commands_.barrier();
    });
}

ResultSizes PartDownload::best_sizes() const {
    ResultSizes sizes{.members = wanted_.members,
                      .entries = 0,
                      .measure = wanted_.measure,
                      .areas = wanted_.areas,
                      .shifts = wanted_.shifts};
    if (!wanted_.neighbors) return sizes;
    const auto& adapter = device_.adapter();
    const VkDeviceSize each = wanted_.areas ? DeviceCells::number_bytes : 4;
    VkDeviceSize most = std::min({adapter.limits.maxStorageBufferRange / each, memory_.max_buffer_bytes() / each,
                                  adapter.device_memory / 4 / DeviceResults::bytes_per_entry(sizes),
                                  VkDeviceSize{std::numeric_limits<std::uint32_t>::max()}});
    if (wanted_.max_entries != 0) most = std::min<VkDeviceSize>(most, wanted_.max_entries);
    const VkDeviceSize usual = VkDeviceSize{usual_row} * wanted_.members + wanted_.min_entries;
    sizes.entries = static_cast<std::uint32_t>(std::max(std::min(usual, most), wanted_.min_entries));
    return sizes;
}

void PartDownload::reserve() {
    const ResultSizes best = best_sizes(), &now = results_.sizes();
    const bool fits = now.members >= best.members && now.entries >= best.entries && now.measure == best.measure &&
                      now.areas == best.areas && now.shifts == best.shifts;
    if (!fits || wanted_.max_entries != 0) results_.reserve(best);
    const auto on_host = [&](Buffer& buffer, VkDeviceSize bytes, const char* name) {
        if (buffer && buffer.size() >= bytes) return;
        buffer = {};
        buffer = memory_.buffer(bytes, MemoryKind::download, name);
    };
    on_host(info_host_, VkDeviceSize{4} * wanted_.members, "part info, host");
    on_host(lengths_host_, VkDeviceSize{4} * wanted_.members, "part length, host");
    const VkDeviceSize rows = VkDeviceSize{best.entries + entry_block} * DeviceResults::bytes_per_entry(best);
    const VkDeviceSize geometry = wanted_.measure ? wanted_.members * geometry_bytes : 0;
    for (Buffer& staging : staging_) on_host(staging, std::min(slice_bytes, std::max(rows, geometry)), "slice");
}

void PartDownload::read_cells(const Passes& passes) {
    commands_.submit([&] {
        const auto label = commands_.label("download");
        if (wanted_.neighbors) results_.record_offsets(commands_, passes, wanted_.members);
        const VkDeviceSize bytes = VkDeviceSize{4} * wanted_.members;
        commands_.copy(results_.slice(BINDING_PART_INFO), 0, info_host_, 0, bytes);
        commands_.copy(results_.slice(BINDING_PART_LENGTH), 0, lengths_host_, 0, bytes);
        commands_.barrier_to_host();
    });
    commands_.wait();
    info_host_.invalidate(info().size_bytes());
    lengths_host_.invalidate(lengths().size_bytes());
}

void PartDownload::stream(std::size_t slices, const auto& record, const auto& take) {
    for (std::size_t i = 0; i <= slices; ++i) {
        if (i < slices) {
            Commands& commands = slices_[i % 2];
            commands.submit([&] {
                const auto label = commands.label("download");
                record(i, commands, staging_[i % 2]);
                commands.barrier_to_host();
            });
        }
        if (i == 0) continue;
        slices_[(i - 1) % 2].wait();
        take(i - 1, staging_[(i - 1) % 2]);
    }
}

void PartDownload::read_geometry(
    const std::function<void(std::size_t first, std::size_t count, const Numbers&)>& take) {
    const std::size_t most = staging_[0].size() / geometry_bytes, members = wanted_.members;
    const auto count = [&](std::size_t slice) { return std::min(most, members - slice * most); };
    stream(
        ceil_div(members, most),
        [&](std::size_t slice, Commands& commands, const Buffer& staging) {
            commands.copy(results_.slice(BINDING_PART_GEOMETRY), slice * most * geometry_bytes, staging, 0,
                          count(slice) * geometry_bytes);
        },
        [&](std::size_t slice, const Buffer& staging) {
            const std::size_t bytes = count(slice) * geometry_bytes;
            staging.invalidate(bytes);
            take(slice * most, count(slice), {staging.mapped().first(bytes), wanted_.float64});
        });
}

void PartDownload::read_rows(const Passes& passes, const std::function<void(const DeviceRows&)>& take) {
    const ResultSizes& sizes = results_.sizes();
    const VkDeviceSize each = 4 + (sizes.areas ? DeviceCells::number_bytes : 0) + (sizes.shifts ? 3 : 0);
    const auto most = static_cast<std::uint32_t>(staging_[0].size() / each / entry_block * entry_block);
    std::vector<DeviceResults::RowSlice> slices{{}};
    for (std::size_t first = 0; first < lengths().size(); first += cell_group) {
        const auto of_group = lengths().subspan(first, std::min(cell_group, lengths().size() - first));
        const std::uint32_t entries = std::accumulate(of_group.begin(), of_group.end(), 0u);
        const DeviceResults::RowSlice& last = slices.back();
        if (last.entries + entries > most) slices.push_back({last.first + last.count, 0, last.entry + last.entries, 0});
        slices.back().count += static_cast<std::uint32_t>(of_group.size());
        slices.back().entries += entries;
    }
    const VkDeviceSize areas = VkDeviceSize{4} * most, shifts = areas + (sizes.areas ? 8 : 0) * VkDeviceSize{most};
    stream(
        slices.size(),
        [&](std::size_t i, Commands& commands, const Buffer& staging) {
            const auto part = [&](bool wanted, VkDeviceSize offset, VkDeviceSize bytes) {
                return wanted ? Slice{staging.handle(), offset, bytes} : Slice{};
            };
            results_.record_rows(commands, passes, slices[i],
                                 {part(true, 0, areas), part(sizes.areas, areas, VkDeviceSize{8} * most),
                                  part(sizes.shifts, shifts, VkDeviceSize{3} * most)});
        },
        [&](std::size_t i, const Buffer& staging) {
            const auto& slice = slices[i];
            staging.invalidate(sizes.shifts  ? shifts + VkDeviceSize{3} * slice.entries
                               : sizes.areas ? areas + Numbers::each * slice.entries
                                             : VkDeviceSize{4} * slice.entries);
            const auto bytes = [&](VkDeviceSize offset, std::size_t count) {
                return std::span<const std::byte>(staging.mapped()).subspan(offset, count * slice.entries);
            };
            DeviceRows rows;
            rows.first = slice.first;
            rows.lengths = lengths().subspan(slice.first, slice.count);
            rows.ids = staging.as<std::int32_t>().first(slice.entries);
            if (sizes.areas) rows.areas = {bytes(areas, Numbers::each), wanted_.float64};
            if (sizes.shifts)
                rows.shifts = {reinterpret_cast<const std::int8_t*>(bytes(shifts, 3).data()), 3 * slice.entries};
            take(rows);
        });
}

}  // namespace votess::gpu
