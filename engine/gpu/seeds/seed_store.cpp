#include "gpu/seeds/seed_store.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

namespace votess::gpu {
namespace {

using vulkan::MemoryKind;

constexpr VkDeviceSize staging_bytes = VkDeviceSize{8} << 20;
constexpr std::uint32_t task_items = 1u << 14;  // per task that fills staging memory

}  // namespace

SeedStore::SeedStore(vulkan::Device& device, vulkan::Memory& memory)
    : memory_(memory), commands_(device, 4), uploads_{Commands(device, 2), Commands(device, 2)} {}

void SeedStore::reserve(std::uint32_t count, bool weights) {
    if (count <= capacity_ && walls_.size() <= wall_capacity_ && weights <= has_weights_) return;
    has_weights_ = weights;
    count = std::max(count, capacity_);
    const auto walls = std::max(static_cast<std::uint32_t>(walls_.size()), wall_capacity_);
    capacity_ = wall_capacity_ = 0;
    const VkDeviceSize n = count;
    buffers_.clear();
    seeds_.reserve(buffers_, count, 0, walls, weights);
    for (Buffer& staging : staging_) {
        staging = {};
        staging = memory_.buffer(std::min(staging_bytes, n * 24), MemoryKind::upload, "staging");
    }
    state_host_ = memory_.buffer(sizeof(RunState), MemoryKind::download, "run state, host");
    order_host_ = memory_.buffer(n * 4, MemoryKind::download, "seed input, host");
    capacity_ = count;
    wall_capacity_ = walls;
}

void SeedStore::upload(const Job& job, std::span<const std::int32_t> members, const Box& box, const Passes& passes,
                       ThreadPool& pool) {
    const auto& points = job.points;
    if (points.f32.empty())
        upload({std::as_bytes(points.f64), 24, POINTS_FLOAT64, false}, members, box, passes, job, members, pool);
    else
        upload({std::as_bytes(points.f32), 12, POINTS_FLOAT32, false}, members, box, passes, job, members, pool);
}

void SeedStore::upload(const PeriodicPart& periodic, const Job& job, const Passes& passes, ThreadPool& pool) {
    const auto bytes = std::as_bytes(std::span(periodic.coordinates));
    upload({bytes, 24, POINTS_UNITS, periodic.lossy}, {}, periodic.box, passes, job, periodic.part.members, pool);
}

void SeedStore::upload(const RawPoints& points, std::span<const std::int32_t> members, const Box& box,
                       const Passes& passes, const Job& job, std::span<const std::int32_t> members_of_weights,
                       ThreadPool& pool) {
    const auto total =
        static_cast<std::uint32_t>(members.empty() ? points.bytes.size() / points.bytes_each : members.size());
    const Domain& domain = *job.domain;
    reserve(total, domain.has_weights());
    seeds_.set_count(total);
    seeds_.set_box(box);
    seeds_.set_walls(walls_);
    seeds_.set_weights(weight_units(domain, seeds_.units(), job.scale));
    seeds_.set_heaviest_unknown(true);
    seconds_ = {};

    commands_.submit([&] {
        seeds_.record_begin(commands_, points.lossy);
        commands_.barrier();
    });
    upload_pieces(points, members, total, false, passes, pool);
    if (domain.has_weights())
        upload_pieces({std::as_bytes(std::span(domain.weights)), 8, POINTS_FLOAT64, false}, members_of_weights, total,
                      true, passes, pool);
    commands_.wait();
}

void SeedStore::upload_pieces(const RawPoints& points, std::span<const std::int32_t> members, std::uint32_t total,
                              bool weights, const Passes& passes, ThreadPool& pool) {
    const std::size_t each = points.bytes_each;
    const std::byte* const bytes = points.bytes.data();
    stream(
        total, each, pool,
        [&](std::byte* to, std::uint32_t first, std::uint32_t count) {
            if (members.empty()) {
                std::memcpy(to, bytes + std::size_t{first} * each, std::size_t{count} * each);
                return;
            }
            for (std::uint32_t i = 0; i < count; ++i)
                std::memcpy(to + std::size_t{i} * each, bytes + static_cast<std::size_t>(members[first + i]) * each,
                            each);
        },
        [&](Commands& commands, const Slice& staging, std::uint32_t first, std::uint32_t count) {
            if (weights)
                seeds_.record_weights(commands, passes, {staging, points.format, 1}, first, count);
            else
                seeds_.record_upload(commands, passes, {staging, points.format}, first, count);
        });
}

void SeedStore::upload_names(std::uint32_t count, const std::function<uvec2(std::uint32_t)>& name, ThreadPool& pool) {
    if (count > name_capacity_ || name_capacity_ == 0) {
        name_capacity_ = 0;
        name_buffers_.clear();
        seeds_.reserve_names(name_buffers_, count);
        name_capacity_ = std::max(count, 1u);
    }
    stream(
        count, sizeof(uvec2), pool,
        [&](std::byte* to, std::uint32_t first, std::uint32_t of_slice) {
            for (std::uint32_t i = 0; i < of_slice; ++i) {
                const uvec2 value = name(first + i);
                std::memcpy(to + sizeof value * i, &value, sizeof value);
            }
        },
        [&](Commands& commands, const Slice& staging, std::uint32_t first, std::uint32_t of_slice) {
            commands.copy(staging, 0, seeds_.bindings().get(BINDING_NAMES), VkDeviceSize{first} * sizeof(uvec2),
                          VkDeviceSize{of_slice} * sizeof(uvec2));
        });
}

void SeedStore::stream(std::uint32_t total, std::size_t bytes_each, ThreadPool& pool, const auto& write,
                       const auto& record) {
    const auto slice = static_cast<std::uint32_t>(staging_[0].size() / bytes_each);
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
    for (std::uint32_t first = 0, count = 0; first < total; first += count, slot ^= 1) {
        count = std::min(slice, total - first);
        collect(slot);
        std::byte* const to = staging_[slot].mapped().data();
        pool.run(blocks_of(count, task_items), [&](std::size_t task, unsigned) {
            const auto begin = static_cast<std::uint32_t>(task) * task_items;
            write(to + begin * bytes_each, first + begin, std::min(task_items, count - begin));
        });
        staging_[slot].flush();
        Commands& commands = uploads_[slot];
        commands.submit([&] {
            const auto label = commands.label("upload");
            stamps[slot].begin = commands.timestamp();
            commands.barrier();
            record(commands, staging_[slot], first, count);
            stamps[slot].end = commands.timestamp();
            stamps[slot].used = true;
        });
    }
    collect(0);
    collect(1);
}

double SeedStore::run_labeled(const char* name, const auto& record) {
    std::uint32_t begin = 0, end = 0;
    commands_.submit([&] {
        const auto label = commands_.label(name);
        begin = commands_.timestamp();
        end = record();
    });
    commands_.wait();
    return commands_.seconds(begin, end);
}

void SeedStore::sort(const Passes& passes, std::uint32_t key_bits) {
    seconds_.sort = 0;
    const auto run = [&](const auto& record) {
        seconds_.sort += run_labeled("sort", [&] {
            const auto end = record();
            commands_.barrier_to_host();
            return end;
        });
        state_host_.invalidate();
    };
    const auto is_crowded = [&] {
        run([&] {
            seeds_.record_order(commands_, passes, DeviceSeeds::coarse_bits);
            seeds_.record_crowded(commands_, passes);
            commands_.copy(seeds_.crowded(), 0, state_host_, 0, 4);
            return commands_.timestamp();
        });
        return state_host_.as<std::uint32_t>()[0] != 0;
    };
    // Few inputs have seeds so close together that they need more bits.
    const bool ordered = key_bits > DeviceSeeds::coarse_bits && count() > 0 && !is_crowded();
    run([&] {
        if (!ordered) seeds_.record_order(commands_, passes, key_bits);
        seeds_.record_gather(commands_, passes);
        const auto end = commands_.timestamp();
        commands_.copy(seeds_.run_state(), 0, state_host_, 0, sizeof(RunState));
        commands_.copy(seeds_.seed_input(), 0, order_host_, 0, VkDeviceSize{count()} * 4);
        return end;
    });
    order_host_.invalidate();
    state_ = state_host_.as<RunState>()[0];
}

void SeedStore::build_hierarchy(const Passes& passes, const KnownSeeds& known) {
    seconds_.knn = run_labeled("knn", [&] {
        seeds_.record_hierarchy(commands_, passes, known);
        return commands_.timestamp();
    });
}

}  // namespace votess::gpu
