#include "gpu/seed_store.hpp"

#include <algorithm>
#include <cstring>

#include "shared/bindings.h"

namespace votess::gpu {
namespace {

using vulkan::MemoryKind;
using vulkan::push_bytes;

constexpr VkDeviceSize staging_bytes = VkDeviceSize{8} << 20;
constexpr VkDeviceSize node_bytes = 48;  // struct Node of shaders/lib/node.glsl
constexpr VkDeviceSize coordinate_bytes = 8;

std::uint32_t blocks_of(std::uint32_t count, std::uint32_t block) {
    return count / block + (count % block != 0 ? 1 : 0);
}

// First node and number of nodes of each level of the hierarchy.
void plan_levels(std::uint32_t seeds, std::vector<std::uint32_t>& first, std::vector<std::uint32_t>& size) {
    first.assign(1, 0);
    size.assign(1, blocks_of(seeds, GROUP_SEEDS));
    while (size.back() > 1) {
        first.push_back(first.back() + size.back());
        size.push_back(blocks_of(size.back(), FAN));
    }
}

}  // namespace

void Bindings::set(std::uint32_t binding, const Buffer& buffer) {
    for (BufferBinding& b : list_)
        if (b.binding == binding) {
            b.buffer = &buffer;
            return;
        }
    list_.push_back({binding, &buffer});
}

void Scan::reserve(vulkan::Memory& memory, std::uint32_t count) {
    sums_.clear();
    do {
        count = blocks_of(count, TILE_ITEMS);
        sums_.push_back(memory.buffer(VkDeviceSize{count} * 4, MemoryKind::device, "scan sums"));
    } while (count > 1);
}

void Scan::record(Commands& commands, const Passes& passes, const Buffer& data, std::uint32_t count) const {
    std::vector<std::uint32_t> counts;  // of each level's array
    const Buffer* level_data = &data;
    Bindings bindings;
    for (const Buffer& sums : sums_) {
        counts.push_back(count);
        bindings.set(BINDING_SCAN_DATA, *level_data);
        bindings.set(BINDING_SCAN_SUMS, sums);
        const std::uint32_t blocks = blocks_of(count, TILE_ITEMS);
        commands.dispatch(passes.scan_blocks, bindings.list(), push_bytes(ScanPush{count}),
                          std::uint64_t{blocks} * TILE_GROUP);
        commands.barrier();
        if (blocks <= 1) break;
        level_data = &sums;
        count = blocks;
    }
    // From the level below the last one down.
    for (std::size_t level = counts.size() - 1; level-- > 0;) {
        bindings.set(BINDING_SCAN_DATA, level == 0 ? data : sums_[level - 1]);
        bindings.set(BINDING_SCAN_SUMS, sums_[level]);
        commands.dispatch(passes.scan_add, bindings.list(), push_bytes(ScanPush{counts[level]}), counts[level]);
        commands.barrier();
    }
}

SeedStore::SeedStore(vulkan::Device& device, vulkan::Memory& memory)
    : device_(device), memory_(memory), commands_(device, 4), uploads_{Commands(device, 2), Commands(device, 2)} {}

std::uint32_t SeedStore::most_seeds(const vulkan::Device& device, const vulkan::Memory& memory) {
    const auto range = std::min<VkDeviceSize>(device.adapter().limits.maxStorageBufferRange, memory.max_buffer_bytes());
    // Seven seeds have at most one node on level 0 and a seventh of that above.
    const VkDeviceSize by_nodes = range / node_bytes * 7 - 8 * MOST_LEVELS;
    // 24 + 24 bytes of coordinates, 24 of keys and indices, 4 of input indices, 7 of nodes, and as much again is free.
    const VkDeviceSize by_memory = device.adapter().device_memory / 2 / 84;
    return static_cast<std::uint32_t>(
        std::min({range / coordinate_bytes, by_nodes, by_memory, VkDeviceSize{INDEX_MASK}}));
}

void SeedStore::reserve(std::uint32_t count) {
    if (count <= capacity_) return;
    capacity_ = 0;
    const VkDeviceSize n = count;
    const auto device_buffer = [&](VkDeviceSize bytes, const char* name) {
        return memory_.buffer(bytes, MemoryKind::device, name);
    };
    for (int k = 0; k < 3; ++k) {
        points_[k] = {};
        seeds_[k] = {};
        points_[k] = device_buffer(n * coordinate_bytes, "points");
        seeds_[k] = device_buffer(n * coordinate_bytes, "seeds");
    }
    for (int k = 0; k < 2; ++k) {
        keys_[k] = {};
        index_[k] = {};
        keys_[k] = device_buffer(n * 8, "keys");
        index_[k] = device_buffer(n * 4, "index");
        staging_[k] = memory_.buffer(std::min(staging_bytes, n * 24), MemoryKind::upload, "staging");
    }
    const std::uint32_t counts = blocks_of(count, TILE_ITEMS) * DIGITS;
    counts_ = device_buffer(VkDeviceSize{counts} * 4, "digit counts");
    scan_.reserve(memory_, counts);
    seed_input_ = device_buffer(n * 4, "seed input");
    plan_levels(count, level_first_, level_size_);
    nodes_ = device_buffer((VkDeviceSize{level_first_.back()} + 1) * node_bytes, "nodes");
    run_state_ = device_buffer(sizeof(RunState), "run state");
    state_host_ = memory_.buffer(sizeof(RunState), MemoryKind::download, "run state, host");
    order_host_ = memory_.buffer(n * 4, MemoryKind::download, "seed input, host");
    capacity_ = count;

    bindings_.set(BINDING_RUN_STATE, run_state_);
    bindings_.set(BINDING_NODES, nodes_);
    bindings_.set(BINDING_SEED_INPUT, seed_input_);
    for (std::uint32_t k = 0; k < 3; ++k) {
        bindings_.set(BINDING_POINTS_X + k, points_[k]);
        bindings_.set(BINDING_SEEDS_X + k, seeds_[k]);
    }
}

void SeedStore::upload(const Job& job, std::span<const std::int32_t> members, const Passes& passes) {
    const auto& points = job.points;
    if (points.f32.empty())
        upload({std::as_bytes(points.f64), 24, POINTS_FLOAT64, false}, members, job.box, passes);
    else
        upload({std::as_bytes(points.f32), 12, POINTS_FLOAT32, false}, members, job.box, passes);
}

void SeedStore::upload(const PeriodicPart& periodic, const Passes& passes) {
    const auto bytes = std::as_bytes(std::span(periodic.coordinates));
    upload({bytes, 24, POINTS_UNITS, periodic.lossy}, {}, periodic.box, passes);
}

void SeedStore::upload(const RawPoints& points, std::span<const std::int32_t> members, const Box& box,
                       const Passes& passes) {
    count_ = static_cast<std::uint32_t>(members.empty() ? points.bytes.size() / points.bytes_each : members.size());
    reserve(count_);
    plan_levels(count_, level_first_, level_size_);
    units_ = Units::for_box(box);
    bool box_lossy = false;
    UploadPush push{};
    for (int k = 0; k < 3; ++k) {
        origin_[k] = units_.of(box.lower[k], box_lossy);
        extent_[k] = units_.of(box.upper[k], box_lossy) - origin_[k];
        push.origin[k] = words(origin_[k]);
    }
    push.shift = units_.shift;
    push.format = points.format;

    commands_.begin();
    commands_.fill(run_state_, 0, sizeof(RunState), 0);
    const std::uint32_t lossy = (box_lossy ? LOSSY_BOX : 0) | (points.lossy ? LOSSY_POINTS : 0);
    if (lossy != 0) commands_.fill(run_state_, offsetof(RunState, lossy), 4, lossy);
    commands_.barrier();
    commands_.end();
    commands_.submit();
    seconds_ = {};

    const std::size_t point_bytes = points.bytes_each;
    const std::byte* const bytes = points.bytes.data();
    const auto slice = static_cast<std::uint32_t>(staging_[0].size() / point_bytes);
    Bindings bindings = bindings_;
    struct Stamps {
        std::uint32_t begin = 0, end = 0;
        bool used = false;
    } stamps[2];
    const auto collect = [&](std::size_t slot) {
        uploads_[slot].wait();
        if (stamps[slot].used) seconds_.upload += uploads_[slot].seconds(stamps[slot].begin, stamps[slot].end);
        stamps[slot].used = false;
    };
    std::size_t slot = 0;
    for (std::uint32_t first = 0; first < count_; first += push.count, slot ^= 1) {
        push.first = first;
        push.count = std::min(slice, count_ - first);
        collect(slot);
        std::byte* to = staging_[slot].mapped().data();
        if (members.empty()) {
            std::memcpy(to, bytes + std::size_t{first} * point_bytes, std::size_t{push.count} * point_bytes);
        } else {
            for (std::uint32_t i = 0; i < push.count; ++i)
                std::memcpy(to + std::size_t{i} * point_bytes,
                            bytes + static_cast<std::size_t>(members[first + i]) * point_bytes, point_bytes);
        }
        staging_[slot].flush();
        bindings.set(BINDING_RAW, staging_[slot]);
        Commands& commands = uploads_[slot];
        commands.begin();
        {
            const auto label = commands.label("upload");
            stamps[slot].begin = commands.timestamp();
            commands.barrier();
            commands.dispatch(passes.upload, bindings.list(), push_bytes(push), push.count);
            stamps[slot].end = commands.timestamp();
            stamps[slot].used = true;
            commands.barrier();
        }
        commands.end();
        commands.submit();
    }
    collect(0);
    collect(1);
    commands_.wait();
}

void SeedStore::record_radix_pass(std::uint32_t pass, const Passes& passes) {
    constexpr std::uint32_t passes_per_word = (KEY_WORD_BITS + DIGIT_BITS - 1) / DIGIT_BITS;
    const SortPush push{count_, blocks_of(count_, TILE_ITEMS), pass % passes_per_word * DIGIT_BITS,
                        pass / passes_per_word};
    Bindings bindings;
    bindings.set(BINDING_KEYS_IN, keys_[pass % 2]);
    bindings.set(BINDING_INDEX_IN, index_[pass % 2]);
    bindings.set(BINDING_KEYS_OUT, keys_[1 - pass % 2]);
    bindings.set(BINDING_INDEX_OUT, index_[1 - pass % 2]);
    bindings.set(BINDING_SCAN_DATA, counts_);
    const std::uint64_t invocations = std::uint64_t{push.tiles} * TILE_GROUP;
    commands_.dispatch(passes.sort_count, bindings.list(), push_bytes(push), invocations);
    commands_.barrier();
    scan_.record(commands_, passes, counts_, push.tiles * DIGITS);
    commands_.dispatch(passes.sort_scatter, bindings.list(), push_bytes(push), invocations);
    commands_.barrier();
}

void SeedStore::sort(const Passes& passes, std::uint32_t key_bits) {
    constexpr std::uint32_t radix_passes = 2 * ((KEY_WORD_BITS + DIGIT_BITS - 1) / DIGIT_BITS);
    static_assert(radix_passes % 4 == 0);  // the result is where the keys were made, after half of them too
    const std::uint64_t longest = std::max({extent_[0], extent_[1], extent_[2]});
    const KeyPush push{
        count_, key_bits,
        static_cast<float>(std::ldexp(1.0, 32 + static_cast<int>(key_bits)) / static_cast<double>(longest))};
    Bindings bindings = bindings_;
    bindings.set(BINDING_KEYS_OUT, keys_[0]);
    bindings.set(BINDING_INDEX_OUT, index_[0]);
    bindings.set(BINDING_KEYS_IN, keys_[0]);
    bindings.set(BINDING_INDEX_IN, index_[0]);

    commands_.begin();
    std::optional<Commands::Label> label(std::in_place, commands_, "sort");
    const auto begin = commands_.timestamp();
    commands_.dispatch(passes.sort_key, bindings.list(), push_bytes(push), count_);
    commands_.barrier();
    // With up to ten bits per axis the high word is 0 in every key.
    const std::uint32_t needed = key_bits <= KEY_WORD_BITS / 3 ? radix_passes / 2 : radix_passes;
    for (std::uint32_t pass = 0; pass < needed; ++pass) record_radix_pass(pass, passes);
    commands_.dispatch(passes.sort_gather, bindings.list(), push_bytes(push), count_);
    const auto end = commands_.timestamp();
    commands_.barrier();
    commands_.copy(run_state_, 0, state_host_, 0, sizeof(RunState));
    commands_.copy(seed_input_, 0, order_host_, 0, VkDeviceSize{count_} * 4);
    commands_.barrier_to_host();
    label.reset();
    commands_.end();
    commands_.submit();
    commands_.wait();
    seconds_.sort = commands_.seconds(begin, end);
    state_host_.invalidate();
    order_host_.invalidate();
    state_ = state_host_.as<RunState>()[0];
}

void SeedStore::build_hierarchy(const Passes& passes) {
    commands_.begin();
    std::optional<Commands::Label> label(std::in_place, commands_, "knn");
    const auto begin = commands_.timestamp();
    for (std::uint32_t level = 0; level < level_count(); ++level) {
        const std::uint32_t below = level == 0 ? 0 : level - 1;
        const BoxesPush push{
            count_, level, level_first_[level], level_size_[level], level_first_[below], level_size_[below]};
        commands_.dispatch(passes.knn_boxes, bindings_.list(), push_bytes(push), push.count);
        commands_.barrier();
    }
    const auto end = commands_.timestamp();
    label.reset();
    commands_.end();
    commands_.submit();
    commands_.wait();
    seconds_.knn = commands_.seconds(begin, end);
}

}  // namespace votess::gpu
