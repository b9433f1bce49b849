#include "gpu/cells/device_cells.hpp"

#include <algorithm>
#include <bit>

#include "core/arithmetic.hpp"

namespace votess::gpu {
namespace {

using vulkan::push_bytes;

constexpr VkDeviceSize bytes_per_entry = 4;  // of rows and shifts
constexpr VkDeviceSize any_alignment = 256;  // bytes; where any device can bind a part of a buffer

// Returns how many cells of a tile the second tier takes. Small lists leave nearly all cells to it, and so do lattices
// in frames, where the first tier decides no ties.
std::uint32_t max_of_tile(std::uint32_t cells, const PassSettings& settings) {
    constexpr std::uint32_t ordinary_k = 64;
    const bool all = settings.frames || settings.k < ordinary_k || cells <= TILE_ITEMS;
    return all ? TILE_ITEMS : TILE_ITEMS / 2;
}

std::uint32_t second_tier_cells(std::uint32_t cells, const PassSettings& settings) {
    return std::min(cells, blocks_of(cells, TILE_ITEMS) * max_of_tile(cells, settings));
}

// Returns the arrays of a chunk. Subgroups make no lists.
std::uint32_t words_per_cell(const PassSettings& settings) {
    return settings.subgroup_size != 0 ? WORDS_OF_CELLS : WORDS_LIST + settings.k;
}

}  // namespace

std::uint32_t usual_chunk(const vulkan::Device& device, const PassSettings& settings, std::uint32_t wanted,
                          std::uint32_t seeds) {
    // The second tier has few cells, which take long and leave most of a GPU idle, so chunks are large. Frames share
    // memory with the host's drawing, and nothing measures their time: small GPUs get chunks of about 50 ms.
    constexpr std::uint32_t for_software = 1u << 14;
    const auto& adapter = device.adapter();
    const std::uint32_t for_frames = adapter.unified() ? 1u << 17 : 1u << 20, for_parts = 1u << 22;
    VkDeviceSize cells = wanted;
    if (wanted == 0) cells = adapter.software() ? for_software : settings.frames ? for_frames : for_parts;
    // Less the state of a chunk, and a gap between the rows of the tiers.
    const VkDeviceSize range = adapter.limits.maxStorageBufferRange - 2 * any_alignment;
    cells = std::min(cells, range / DeviceCells::largest_bytes_per_cell(settings));
    // Two chunks take at most a quarter of the memory.
    cells = std::min(cells, adapter.device_memory / 8 / DeviceCells::bytes_per_cell(settings));
    return static_cast<std::uint32_t>(std::clamp<VkDeviceSize>(cells, 1, std::max(seeds, 1u)));
}

VkDeviceSize DeviceCells::bytes_per_cell(const PassSettings& s) {
    // The words of a chunk, rows of both tiers, geometry, and areas of the rows.
    const VkDeviceSize planes = s.tiers[0].planes + s.tiers[1].planes;
    return 4 * (words_per_cell(s) + planes + 2 * geometry_components + (s.areas ? 2 * planes : 0) +
                (s.follow ? KEPT_WORDS : 0));
}

VkDeviceSize DeviceCells::largest_bytes_per_cell(const PassSettings& s) {
    const VkDeviceSize planes = s.tiers[0].planes + s.tiers[1].planes;
    return 4 * std::max<VkDeviceSize>(
                   {words_per_cell(s), (s.areas ? 2 : 1) * planes, planes + (s.follow ? KEPT_WORDS : 0)});
}

void DeviceCells::reserve(Workspace& workspace, std::uint32_t cells, const PassSettings& settings) {
    cells_ = cells;
    todo_capacity_ = second_tier_cells(cells, settings);
    max_of_tile_ = max_of_tile(cells, settings);
    const VkDeviceSize n = cells, t = todo_capacity_;
    const auto take = [&](std::uint32_t binding, VkDeviceSize bytes, const char* name) {
        bindings_.set(binding, workspace.take(bytes, name));
    };
    // Rows of the second tier begin where they can be bound.
    second_first_ = round_up(n * settings.tiers[0].planes, any_alignment / bytes_per_entry);
    const VkDeviceSize entries = second_first_ + t * settings.tiers[1].planes;
    keeps_ = settings.follow ? entries : 0;
    take(BINDING_ROWS, (entries + (settings.follow ? n * KEPT_WORDS : 0)) * bytes_per_entry, "rows");
    take(BINDING_AREAS, settings.areas ? entries * number_bytes : 0, "areas");
    take(BINDING_CHUNK, sizeof(ChunkState) + 4 * n * words_per_cell(settings), "chunk");
    take(BINDING_GEOMETRY, settings.measure ? n * geometry_components * number_bytes : 0, "geometry");
    scan_.reserve(workspace, cells);
    tiles_ = workspace.take_words(blocks_of(cells, TILE_ITEMS), "todo of tiles");
    todo_scan_.reserve(workspace, blocks_of(cells, TILE_ITEMS));
    // A cell of the second tier has no row in the first.
    planes_ = settings.tiers[0].planes;
    more_planes_ = settings.tiers[1].planes - planes_;
}

std::uint32_t DeviceCells::window_bits(const vulkan::Device& device) {
    static_assert(area_bytes_of_frames == bytes_per_entry);
    const VkDeviceSize entries = device.adapter().limits.maxStorageBufferRange / bytes_per_entry;
    return std::min<std::uint32_t>(static_cast<std::uint32_t>(std::bit_width(entries)) - 1, max_window_bits);
}

void DeviceCells::set_rows_out(const RowsOut& rows) {
    rows_out_ = rows;
    rows_.capacity = rows.capacity;
    rows_.window_bits = rows.window_bits;
    rows_.shifts = rows.shifts ? 1 : 0;
}

Slice DeviceCells::state() const {
    const Slice all = chunk();
    return {all.handle, all.offset, sizeof(ChunkState)};
}

Slice DeviceCells::words_of(std::uint32_t array) const {
    const Slice all = chunk();
    const VkDeviceSize bytes = VkDeviceSize{4} * rows_.cell_count;
    return {all.handle, all.offset + sizeof(ChunkState) + array * bytes, bytes};
}

void DeviceCells::set_job(const DeviceSeeds& seeds, const PassSettings& settings, const ChunkJob& job,
                          std::uint32_t first, std::uint32_t count) {
    for (const BufferBinding& b : seeds.bindings().list()) bindings_.set(b.binding, b.slice);
    rows_.first_cell = first;
    rows_.cell_count = count;
    rows_.named_from = job.named_from;
    rows_.shift = seeds.units().shift;
    rows_.row_stride = cells_;
    rows_.second_row_stride = todo_capacity_;
    rows_.second_first = static_cast<std::uint32_t>(second_first_);
    const auto keeps = static_cast<std::uint32_t>(keeps_);
    todo_ = {count, max_of_tile_, settings.local_size, 0, keeps};
    // Passes have some of these.
    const auto set = [&](auto& push, std::uint32_t max_visits) {
        push.bounded = job.bounded;
        push.first_cell = first;
        push.cell_count = count;
        push.seed_count = seeds.count();
        push.own_count = job.own_count;
        push.level_count = static_cast<std::uint32_t>(seeds.level_first().size());
        push.max_visits = max_visits;
        push.keeps = keeps;
        if constexpr (requires { push.level_first; }) std::ranges::copy(seeds.level_first(), push.level_first);
        for (std::size_t k = 0; k < 3; ++k) {
            if constexpr (requires { push.extent; }) push.extent[k] = words(seeds.extent()[k]);
            if constexpr (requires { push.lower; })
                push.lower[k] = words(job.lower[k]), push.upper[k] = words(job.upper[k]);
        }
        if constexpr (requires { push.row_stride; }) {
            push.row_stride = cells_;
            push.walls = job.walls ? 1 : 0;
            push.neighbors = job.neighbors ? 1 : 0;
            push.volume_tolerance = static_cast<float>(job.volume_tolerance);
        }
    };
    set(knn_, settings.max_visits);
    set(clip_, settings.max_walk_visits);
    set(both_, settings.max_subgroup_visits[0]);
    set(both_again_, settings.max_subgroup_visits[1]);
    both_again_.row_stride = todo_capacity_;
    if (keeps != 0) both_again_.keeps -= rows_.second_first;
    second_bindings_ = bindings_;
    const auto set_second = [&](std::uint32_t binding, VkDeviceSize each) {
        const Slice all = bindings_.get(binding);
        const VkDeviceSize first = std::min(second_first_ * each, all.size);
        second_bindings_.set(binding, {all.handle, all.offset + first, all.size - first});
    };
    set_second(BINDING_ROWS, bytes_per_entry);
    set_second(BINDING_AREAS, number_bytes);
}

void DeviceCells::record_knn(Recorder& recorder, const Passes& passes) const {
    const auto label = recorder.label("knn");
    static_assert(offsetof(ChunkState, row_base) == offsetof(ChunkState, left_count) + 4);
    recorder.fill(state(), 0, offsetof(ChunkState, row_base), 0);
    recorder.barrier();
    if (!passes.knn_search) return;
    recorder.run(passes.knn_search, bindings_, knn_, knn_.cell_count);
}

void DeviceCells::record_clip(Recorder& recorder, const Passes& passes, bool second_tier, bool ties) const {
    const auto label = recorder.label("clip");
    const vulkan::Pass& clip_first = ties ? passes.with_ties.clip_first : passes.clip_first;
    const auto& clip_second = ties ? passes.with_ties.clip_second : passes.clip_second;
    const std::uint32_t lanes = passes.settings.subgroup_size;
    if (lanes == 0)
        recorder.run(clip_first, bindings_, clip_, clip_.cell_count);
    else
        recorder.run(clip_first, bindings_, both_, std::uint64_t{clip_.cell_count} * lanes);
    if (!second_tier || !clip_second) return;
    const std::uint32_t tiles = blocks_of(todo_.cell_count, TILE_ITEMS);
    Bindings bindings = bindings_;
    bindings.set(BINDING_SCAN_SUMS, tiles_);
    TodoPush todo = todo_;
    recorder.run(passes.clip_todo, bindings, todo, std::uint64_t{tiles} * TILE_GROUP);
    todo_scan_.record(recorder, passes, tiles_, tiles);
    todo.places = 1;
    recorder.run(passes.clip_todo, bindings, todo, std::uint64_t{tiles} * TILE_GROUP);
    if (lanes != 0) {
        recorder.dispatch_indirect(clip_second, second_bindings_.list(), push_bytes(both_again_), state(),
                                   offsetof(ChunkState, subgroups_x));
    } else {
        ClipPush second = clip_;
        second.row_stride = todo_capacity_;
        second.keeps = both_again_.keeps;
        recorder.dispatch_indirect(clip_second, second_bindings_.list(), push_bytes(second), state(),
                                   offsetof(ChunkState, groups_x));
    }
    recorder.barrier();
}

void DeviceCells::record_rows(Recorder& recorder, const Passes& passes) const {
    const std::uint32_t count = rows_.cell_count;
    const Slice offsets = words_of(WORDS_ROW_OFFSET);
    recorder.copy(words_of(WORDS_ROW_LENGTH), 0, offsets, 0, offsets.size);
    recorder.barrier();
    scan_.record(recorder, passes, offsets, count);
    const bool named = rows_.named_from < INDEX_MASK;
    const vulkan::Pass& pass = named ? passes.download_named_rows : passes.download_rows;
    const bool frames = passes.settings.frames;
    const VkDeviceSize window = VkDeviceSize{1} << rows_.window_bits;
    RowsPush push = rows_;
    Bindings bindings = bindings_;
    for (VkDeviceSize first = 0; first < rows_.capacity; first += window, ++push.window) {
        const VkDeviceSize entries = std::min(window, rows_.capacity - first);
        // Passes bind the rows in place of arrays that are not requested.
        const auto bind = [&](std::uint32_t binding, const Slice& array, VkDeviceSize each) {
            const Slice& bound = array ? array : rows_out_.rows;
            if (!array) each = bytes_per_entry;
            bindings.set(binding, {bound.handle, bound.offset + first * each, entries * each});
        };
        bind(BINDING_ROWS_OUT, rows_out_.rows, bytes_per_entry);
        bind(BINDING_AREAS_OUT, rows_out_.areas, frames ? area_bytes_of_frames : number_bytes);
        bind(BINDING_SHIFTS_OUT, rows_out_.shifts, bytes_per_entry);
        recorder.dispatch(pass, bindings.list(), push_bytes(push), count);
    }
}

}  // namespace votess::gpu
