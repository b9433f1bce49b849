#include "gpu/cells/device_cells.hpp"

#include <algorithm>
#include <bit>

#include "core/arithmetic.hpp"

namespace votess::gpu {
namespace {

using vulkan::push_bytes;

constexpr std::uint32_t row_windows[ROW_WINDOWS]{BINDING_ROWS_OUT, BINDING_ROWS_OUT_1, BINDING_ROWS_OUT_2,
                                                 BINDING_ROWS_OUT_3};
constexpr std::uint32_t shift_windows[ROW_WINDOWS]{BINDING_SHIFTS_OUT, BINDING_SHIFTS_OUT_1, BINDING_SHIFTS_OUT_2,
                                                   BINDING_SHIFTS_OUT_3};

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

// Subgroups make no lists.
std::uint32_t list_words(const PassSettings& settings) {
    return settings.subgroup_size != 0 ? 0 : settings.k;
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
    cells = std::min(cells, adapter.limits.maxStorageBufferRange / DeviceCells::largest_bytes_per_cell(settings));
    // Two chunks take at most a quarter of the memory.
    cells = std::min(cells, adapter.device_memory / 8 / DeviceCells::bytes_per_cell(settings));
    return static_cast<std::uint32_t>(std::clamp<VkDeviceSize>(cells, 1, std::max(seeds, 1u)));
}

VkDeviceSize DeviceCells::bytes_per_cell(const PassSettings& s) {
    // List, rows of both tiers, the words of reserve(), geometry, and areas of the rows.
    const VkDeviceSize planes = s.tiers[0].planes + s.tiers[1].planes;
    return 4 * (list_words(s) + planes + 10 + 2 * geometry_components + (s.areas ? 2 * planes : 0));
}

VkDeviceSize DeviceCells::largest_bytes_per_cell(const PassSettings& s) {
    const VkDeviceSize planes = s.tiers[0].planes + s.tiers[1].planes;
    return 4 * std::max<VkDeviceSize>(list_words(s), (s.areas ? 2 : 1) * planes);
}

void DeviceCells::reserve(Workspace& workspace, std::uint32_t cells, const PassSettings& settings) {
    cells_ = cells;
    todo_capacity_ = second_tier_cells(cells, settings);
    max_of_tile_ = max_of_tile(cells, settings);
    const VkDeviceSize n = cells, t = todo_capacity_;
    const VkDeviceSize words = number_bytes / 4, area_words = settings.areas ? words : 0;
    const VkDeviceSize first_rows = n * settings.tiers[0].planes, second_rows = t * settings.tiers[1].planes;
    const auto take = [&](std::uint32_t binding, VkDeviceSize count, const char* name) {
        bindings_.set(binding, workspace.take_words(count, name));
    };
    take(BINDING_LIST, n * list_words(settings), "list");
    take(BINDING_LIST_INFO, settings.subgroup_size != 0 ? 0 : n * (sizeof(ListInfo) / 4), "list info");
    take(BINDING_ROWS, first_rows, "rows");
    take(BINDING_SECOND_ROWS, second_rows, "second rows");
    take(BINDING_AREAS, first_rows * area_words, "areas");
    take(BINDING_SECOND_AREAS, second_rows * area_words, "second areas");
    take(BINDING_INFO, n, "info");
    take(BINDING_ROW_LENGTH, n, "row length");
    take(BINDING_ROW_PLACE, n, "row place");
    take(BINDING_ROW_OFFSETS, n, "row offsets");
    take(BINDING_TODO, t, "todo");
    take(BINDING_CHUNK_STATE, sizeof(ChunkState) / 4, "chunk state");
    take(BINDING_GEOMETRY, settings.measure ? n * geometry_components * words : 0, "geometry");
    scan_.reserve(workspace, cells);
    tiles_ = workspace.take_words(blocks_of(cells, TILE_ITEMS), "todo of tiles");
    todo_scan_.reserve(workspace, blocks_of(cells, TILE_ITEMS));
    // A cell of the second tier has no row in the first.
    planes_ = settings.tiers[0].planes;
    more_planes_ = settings.tiers[1].planes - planes_;
}

std::uint32_t DeviceCells::window_bits(const vulkan::Device& device) {
    const std::uint32_t words = device.adapter().limits.maxStorageBufferRange / 4;
    return std::min<std::uint32_t>(static_cast<std::uint32_t>(std::bit_width(words)) - 1, max_window_bits);
}

void DeviceCells::set_windows(const std::uint32_t (&bindings)[ROW_WINDOWS], const Slice& rows) {
    const VkDeviceSize window = VkDeviceSize{4} << rows_.window_bits;
    VkDeviceSize begin = 0;
    Slice slice = rows;
    for (const std::uint32_t binding : bindings) {
        // Nothing is written behind the last window, but Vulkan requires a binding.
        if (begin == 0 || begin < rows.size)
            slice = {rows.handle, rows.offset + begin, std::min(window, rows.size - begin)};
        bindings_.set(binding, slice);
        begin += window;
    }
}

void DeviceCells::set_rows_out(const Slice& rows, const Slice& areas, std::uint32_t capacity,
                               std::uint32_t window_bits) {
    rows_.window_bits = window_bits;
    rows_.capacity = capacity;
    set_windows(row_windows, rows);
    bindings_.set(BINDING_AREAS_OUT, areas);
    rows_.shifts = 0;
    set_windows(shift_windows, rows);  // unused, but Vulkan requires a binding
}

void DeviceCells::set_shifts_out(const Slice& shifts) {
    rows_.shifts = 1;
    set_windows(shift_windows, shifts);
}

void DeviceCells::set_job(const DeviceSeeds& seeds, const PassSettings& settings, const ChunkJob& job,
                          std::uint32_t first, std::uint32_t count) {
    for (int k = 0; k < 3; ++k) {
        knn_.lower[k] = words(job.lower[k]);
        knn_.upper[k] = words(job.upper[k]);
        clip_.extent[k] = words(seeds.extent()[k]);
    }
    knn_.bounded = clip_.bounded = job.bounded;
    knn_.first_cell = clip_.first_cell = first;
    knn_.cell_count = clip_.cell_count = rows_.cell_count = count;
    knn_.seed_count = clip_.seed_count = seeds.count();
    knn_.own_count = clip_.own_count = job.own_count;
    rows_.first_cell = first;
    rows_.named_from = job.named_from;
    rows_.shift = seeds.units().shift;
    knn_.level_count = clip_.level_count = static_cast<std::uint32_t>(seeds.level_first().size());
    std::ranges::copy(seeds.level_first(), knn_.level_first);
    std::ranges::copy(seeds.level_first(), clip_.level_first);
    knn_.max_visits = settings.max_visits;
    clip_.max_visits = settings.max_walk_visits;
    knn_.stride = clip_.list_stride = cells_;
    clip_.row_stride = rows_.row_stride = cells_;
    rows_.second_row_stride = todo_capacity_;
    todo_ = {count, max_of_tile_, settings.local_size, 0};
    clip_.walls = job.walls ? 1 : 0;
    clip_.neighbors = job.neighbors ? 1 : 0;
    clip_.volume_tolerance = static_cast<float>(job.volume_tolerance);
    for (const BufferBinding& b : seeds.bindings().list()) bindings_.set(b.binding, b.slice);
    std::ranges::copy(clip_.extent, both_.extent);
    std::ranges::copy(knn_.lower, both_.lower);
    std::ranges::copy(knn_.upper, both_.upper);
    both_.bounded = knn_.bounded;
    both_.first_cell = first;
    both_.cell_count = count;
    both_.seed_count = clip_.seed_count;
    both_.own_count = clip_.own_count;
    both_.level_count = clip_.level_count;
    both_.max_visits = settings.max_subgroup_visits[0];
    both_.row_stride = clip_.row_stride;
    both_.walls = clip_.walls;
    both_.neighbors = clip_.neighbors;
    both_.volume_tolerance = clip_.volume_tolerance;
    both_again_ = both_;
    both_again_.max_visits = settings.max_subgroup_visits[1];
    both_again_.row_stride = todo_capacity_;
    second_bindings_ = bindings_;
    second_bindings_.set(BINDING_ROWS, slice(BINDING_SECOND_ROWS));
    second_bindings_.set(BINDING_AREAS, slice(BINDING_SECOND_AREAS));
}

void DeviceCells::record_knn(Recorder& recorder, const Passes& passes) const {
    static_assert(offsetof(ChunkState, row_base) == offsetof(ChunkState, left_count) + 4);
    recorder.fill(slice(BINDING_CHUNK_STATE), 0, offsetof(ChunkState, row_base), 0);
    recorder.barrier();
    if (!passes.knn_search) return;
    recorder.dispatch(*passes.knn_search, bindings_.list(), push_bytes(knn_), knn_.cell_count);
    recorder.barrier();
}

void DeviceCells::record_clip(Recorder& recorder, const Passes& passes, bool second_tier, bool ties) const {
    const vulkan::Pass& clip_first = ties ? *passes.with_ties.clip_first : passes.clip_first;
    const auto& clip_second = ties ? passes.with_ties.clip_second : passes.clip_second;
    const std::uint32_t lanes = passes.settings.subgroup_size;
    if (lanes == 0)
        recorder.dispatch(clip_first, bindings_.list(), push_bytes(clip_), clip_.cell_count);
    else
        recorder.dispatch(clip_first, bindings_.list(), push_bytes(both_), std::uint64_t{clip_.cell_count} * lanes);
    recorder.barrier();
    if (!second_tier || !clip_second) return;
    const std::uint32_t tiles = blocks_of(todo_.cell_count, TILE_ITEMS);
    Bindings bindings = bindings_;
    bindings.set(BINDING_SCAN_SUMS, tiles_);
    TodoPush todo = todo_;
    recorder.dispatch(passes.clip_todo, bindings.list(), push_bytes(todo), std::uint64_t{tiles} * TILE_GROUP);
    recorder.barrier();
    todo_scan_.record(recorder, passes, tiles_, tiles);
    todo.places = 1;
    recorder.dispatch(passes.clip_todo, bindings.list(), push_bytes(todo), std::uint64_t{tiles} * TILE_GROUP);
    recorder.barrier();
    if (lanes != 0) {
        recorder.dispatch_indirect(*clip_second, second_bindings_.list(), push_bytes(both_again_),
                                   slice(BINDING_CHUNK_STATE), offsetof(ChunkState, subgroups_x));
    } else {
        ClipPush second = clip_;
        second.row_stride = todo_capacity_;
        recorder.dispatch_indirect(*clip_second, second_bindings_.list(), push_bytes(second),
                                   slice(BINDING_CHUNK_STATE), offsetof(ChunkState, groups_x));
    }
    recorder.barrier();
}

void DeviceCells::record_rows(Recorder& recorder, const Passes& passes) const {
    const std::uint32_t count = rows_.cell_count;
    recorder.copy(slice(BINDING_ROW_LENGTH), 0, slice(BINDING_ROW_OFFSETS), 0, VkDeviceSize{count} * 4);
    recorder.barrier();
    scan_.record(recorder, passes, slice(BINDING_ROW_OFFSETS), count);
    const bool named = rows_.named_from < INDEX_MASK;
    recorder.dispatch(named ? *passes.download_named_rows : passes.download_rows, bindings_.list(), push_bytes(rows_),
                      count);
}

}  // namespace votess::gpu
