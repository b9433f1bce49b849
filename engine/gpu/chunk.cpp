#include "gpu/chunk.hpp"

#include <algorithm>
#include <optional>

#include "shared/bindings.h"

namespace votess::gpu {
namespace {

using vulkan::MemoryKind;
using vulkan::push_bytes;

constexpr std::uint32_t geometry_components = 4;

// Small lists leave nearly all cells to the second tier.
std::uint32_t second_tier_cells(std::uint32_t cells, const PassSettings& settings) {
    constexpr std::uint32_t ordinary_k = 64, least = 1024;
    return settings.k < ordinary_k ? cells : std::max(cells / 2, std::min(cells, least));
}

// Where subgroups make the cells of the first tier, only those of the second need lists.
std::uint32_t listed_cells(std::uint32_t cells, const PassSettings& settings) {
    return settings.subgroup_size != 0 ? second_tier_cells(cells, settings) : cells;
}

// Words of the list for each cell of a large chunk.
VkDeviceSize list_words(const PassSettings& settings) {
    constexpr std::uint32_t large = 1u << 20;
    return (VkDeviceSize{settings.k} * listed_cells(large, settings) + large - 1) / large;
}

CellsPush cells_push(const KnnPush& knn, const ClipPush& clip) {
    CellsPush push{};
    std::ranges::copy(clip.extent, push.extent);
    std::ranges::copy(knn.lower, push.lower);
    std::ranges::copy(knn.upper, push.upper);
    push.bounded = knn.bounded;
    push.first_cell = clip.first_cell;
    push.cell_count = clip.cell_count;
    push.seed_count = clip.seed_count;
    push.own_count = clip.own_count;
    push.level_count = clip.level_count;
    push.most_visits = knn.most_visits;
    push.row_stride = clip.row_stride;
    push.todo_capacity = clip.todo_capacity;
    push.walls = clip.walls;
    push.neighbors = clip.neighbors;
    push.volume_tolerance = clip.volume_tolerance;
    return push;
}

}  // namespace

VkDeviceSize Chunk::bytes_per_cell(const PassSettings& s) {
    // List, rows and rows out, of both tiers; then the words of the constructor below, geometry as float64 twice, and
    // areas as float64 beside the rows.
    const VkDeviceSize planes = s.tiers[0].planes + s.tiers[1].planes;
    return 4 * (list_words(s) + 2 * planes + 10 + 2 * 2 * geometry_components + (s.areas ? 2 * 2 * planes : 0));
}

VkDeviceSize Chunk::largest_bytes_per_cell(const PassSettings& s) {
    const VkDeviceSize planes = s.tiers[0].planes + s.tiers[1].planes;
    return 4 * std::max<VkDeviceSize>(list_words(s), (s.areas ? 2 : 1) * planes);
}

Chunk::Chunk(vulkan::Device& device, vulkan::Memory& memory, std::uint32_t cells, const PassSettings& settings)
    : cells_(cells),
      todo_capacity_(second_tier_cells(cells, settings)),
      list_columns_(listed_cells(cells, settings)),
      float64_geometry_(device.has_float64()),
      measure_(settings.measure),
      areas_wanted_(settings.areas),
      commands_(device, 4) {
    const VkDeviceSize n = cells, t = todo_capacity_;
    const auto words_on = [&](VkDeviceSize count, MemoryKind kind, const char* name) {
        return memory.buffer(count * 4, kind, name);
    };
    const auto on_device = [&](VkDeviceSize count, const char* name) {
        return words_on(count, MemoryKind::device, name);
    };
    const auto on_host = [&](VkDeviceSize count, const char* name) {
        return words_on(count, MemoryKind::download, name);
    };
    list_ = on_device(VkDeviceSize{list_columns_} * settings.k, "list");
    list_info_ = memory.buffer(list_columns_ * sizeof(ListInfo), MemoryKind::device, "list info");
    rows_ = on_device(n * settings.tiers[0].planes, "rows");
    second_rows_ = on_device(t * settings.tiers[1].planes, "second rows");
    const VkDeviceSize area_words = settings.areas ? (float64_geometry_ ? 2 : 1) : 0;
    areas_ = on_device(n * settings.tiers[0].planes * area_words, "areas");
    second_areas_ = on_device(t * settings.tiers[1].planes * area_words, "second areas");
    info_ = on_device(n, "info");
    row_length_ = on_device(n, "row length");
    row_place_ = on_device(n, "row place");
    row_offsets_ = on_device(n, "row offsets");
    todo_ = on_device(t, "todo");
    state_ = memory.buffer(sizeof(ChunkState), MemoryKind::device, "chunk state");
    const VkDeviceSize geometry_words = measure_ ? n * geometry_components * (float64_geometry_ ? 2 : 1) : 0;
    geometry_ = on_device(geometry_words, "geometry");
    scan_.reserve(memory, cells);

    info_host_ = on_host(n, "info, host");
    length_host_ = on_host(n, "row length, host");
    geometry_host_ = on_host(geometry_words, "geometry, host");
    state_host_ = memory.buffer(sizeof(ChunkState), MemoryKind::download, "chunk state, host");
    // A cell of the second tier has no row in the first.
    const VkDeviceSize entries =
        n * settings.tiers[0].planes + t * (settings.tiers[1].planes - settings.tiers[0].planes);
    rows_out_ = on_host(entries, "rows out");
    areas_out_ = on_host(entries * area_words, "areas out");
}

void Chunk::start(const SeedStore& seeds, const Passes& passes, const ChunkJob& job, std::uint32_t first,
                  std::uint32_t count, bool second_tier) {
    first_ = first;
    count_ = count;
    KnnPush knn{};
    ClipPush clip{};
    for (int k = 0; k < 3; ++k) {
        knn.lower[k] = words(job.lower[k]);
        knn.upper[k] = words(job.upper[k]);
        clip.extent[k] = words(seeds.extent()[k]);
    }
    knn.bounded = job.bounded;
    knn.first_cell = clip.first_cell = first;
    knn.cell_count = clip.cell_count = count;
    knn.seed_count = clip.seed_count = seeds.count();
    knn.own_count = clip.own_count = job.own_count;
    knn.level_count = clip.level_count = seeds.level_count();
    std::ranges::copy(seeds.level_first(), knn.level_first);
    std::ranges::copy(seeds.level_first(), clip.level_first);
    knn.most_visits = passes.settings.most_visits;
    clip.most_visits = passes.settings.most_walk_visits;
    clip.todo_capacity = todo_capacity_;
    clip.walls = job.walls ? 1 : 0;
    clip.neighbors = job.neighbors ? 1 : 0;
    clip.volume_tolerance = static_cast<float>(job.volume_tolerance);

    Bindings bindings = seeds.bindings();
    bindings.set(BINDING_LIST, list_);
    bindings.set(BINDING_LIST_INFO, list_info_);
    bindings.set(BINDING_INFO, info_);
    bindings.set(BINDING_ROW_LENGTH, row_length_);
    bindings.set(BINDING_ROW_PLACE, row_place_);
    bindings.set(BINDING_ROWS, rows_);
    bindings.set(BINDING_GEOMETRY, geometry_);
    bindings.set(BINDING_TODO, todo_);
    bindings.set(BINDING_CHUNK_STATE, state_);
    bindings.set(BINDING_SECOND_ROWS, second_rows_);
    bindings.set(BINDING_ROW_OFFSETS, row_offsets_);
    bindings.set(BINDING_ROWS_OUT, rows_out_);
    bindings.set(BINDING_AREAS, areas_);
    bindings.set(BINDING_SECOND_AREAS, second_areas_);
    bindings.set(BINDING_AREAS_OUT, areas_out_);

    commands_.begin();
    std::optional<Commands::Label> label(std::in_place, commands_, "knn");
    commands_.fill(state_, 0, sizeof(ChunkState), 0);
    commands_.barrier();
    stamps_[0] = commands_.timestamp();
    knn.stride = clip.list_stride = list_columns_;
    clip.row_stride = cells_;
    const std::uint32_t lanes = passes.settings.subgroup_size;
    if (lanes == 0) {
        commands_.dispatch(passes.knn_search, bindings.list(), push_bytes(knn), count);
        commands_.barrier();
    }
    stamps_[1] = commands_.timestamp();
    label.emplace(commands_, "clip");
    if (lanes == 0)
        commands_.dispatch(passes.clip_cells[0], bindings.list(), push_bytes(clip), count);
    else
        commands_.dispatch(passes.clip_cells[0], bindings.list(), push_bytes(cells_push(knn, clip)),
                           std::uint64_t{count} * lanes);
    commands_.barrier();
    if (second_tier) {
        commands_.dispatch(passes.clip_todo, bindings.list(), push_bytes(clip), 1);
        commands_.barrier();
        if (lanes != 0) {
            knn.cell_count = todo_capacity_;
            commands_.dispatch_indirect(passes.knn_search, bindings.list(), push_bytes(knn), state_,
                                        offsetof(ChunkState, groups_x));
            commands_.barrier();
        }
        Bindings second = bindings;
        second.set(BINDING_ROWS, second_rows_);
        second.set(BINDING_AREAS, second_areas_);
        clip.row_stride = todo_capacity_;
        commands_.dispatch_indirect(passes.clip_cells[1], second.list(), push_bytes(clip), state_,
                                    offsetof(ChunkState, groups_x));
        commands_.barrier();
    }
    stamps_[2] = commands_.timestamp();

    label.emplace(commands_, "download");
    if (job.neighbors) {
        commands_.copy(row_length_, 0, row_offsets_, 0, VkDeviceSize{count} * 4);
        commands_.barrier();
        scan_.record(commands_, passes, row_offsets_, count);
        commands_.dispatch(passes.download_rows, bindings.list(), push_bytes(RowsPush{count, cells_, todo_capacity_}),
                           count);
    }
    commands_.copy(info_, 0, info_host_, 0, VkDeviceSize{count} * 4);
    commands_.copy(row_length_, 0, length_host_, 0, VkDeviceSize{count} * 4);
    if (measure_) commands_.copy(geometry_, 0, geometry_host_, 0, geometry_.size() / cells_ * count);
    commands_.copy(state_, 0, state_host_, 0, sizeof(ChunkState));
    stamps_[3] = commands_.timestamp();
    commands_.barrier_to_host();
    label.reset();
    commands_.end();
    commands_.submit();
}

void Chunk::wait() {
    commands_.wait();
    for (const Buffer* buffer : {&info_host_, &length_host_, &geometry_host_, &state_host_, &rows_out_, &areas_out_})
        buffer->invalidate();
}

double Chunk::area(std::size_t entry) const {
    return float64_geometry_ ? areas_out_.as<double>()[entry] : static_cast<double>(areas_out_.as<float>()[entry]);
}

double Chunk::geometry(std::uint32_t cell, std::uint32_t component) const {
    const std::size_t i = std::size_t{cell} * geometry_components + component;
    return float64_geometry_ ? geometry_host_.as<double>()[i] : static_cast<double>(geometry_host_.as<float>()[i]);
}

Chunk::Seconds Chunk::seconds() const {
    const auto between = [&](int from, int to) { return commands_.seconds(stamps_[from], stamps_[to]); };
    return {between(0, 1), between(1, 2), between(2, 3)};
}

}  // namespace votess::gpu
