// Uploads the seeds of a run, or of a part of it, and sorts them on the device.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "core/thread_pool.hpp"
#include "gpu/domain/periodic_part.hpp"
#include "gpu/seeds/device_seeds.hpp"
#include "gpu/vulkan/commands.hpp"
#include "input/job.hpp"

namespace votess::gpu {

using vulkan::Buffer;
using vulkan::Commands;

class SeedStore {
public:
    SeedStore(vulkan::Device& device, vulkan::Memory& memory);

    // Sets the walls of any direction for later uploads.
    void set_walls(std::vector<WallPlane> walls) { walls_ = std::move(walls); }
    // Uploads seeds in this box. members: their input indices; empty = all points.
    void upload(const Job& job, std::span<const std::int32_t> members, const Box& box, const Passes& passes,
                ThreadPool& pool);
    // Uploads seeds and images of a periodic domain.
    void upload(const PeriodicPart& periodic, const Job& job, const Passes& passes, ThreadPool& pool);
    // Uploads `count` names for ids in rows. Several threads call name(i).
    void upload_names(std::uint32_t count, const std::function<uvec2(std::uint32_t)>& name, ThreadPool& pool);
    // key_bits: the most per axis.
    void sort(const Passes& passes, std::uint32_t key_bits);
    void build_hierarchy(const Passes& passes, const KnownSeeds& known);

    [[nodiscard]] const DeviceSeeds& on_device() const { return seeds_; }
    [[nodiscard]] std::uint32_t count() const { return seeds_.count(); }
    [[nodiscard]] RunState state() const { return state_; }
    // After sort(): member of each sorted seed, with DUPLICATE_BIT.
    [[nodiscard]] std::span<const std::uint32_t> order() const {
        return order_host_.as<std::uint32_t>().first(count());
    }
    // Seconds that the device spent.
    struct Seconds {
        double upload = 0, sort = 0, knn = 0;
    };
    [[nodiscard]] const Seconds& seconds() const { return seconds_; }

private:
    struct RawPoints {
        std::span<const std::byte> bytes;
        std::size_t bytes_each;
        std::uint32_t format;  // POINTS_
        bool lossy;            // already rounded
    };

    void upload(const RawPoints& points, std::span<const std::int32_t> members, const Box& box, const Passes& passes,
                const Job& job, std::span<const std::int32_t> members_of_weights, ThreadPool& pool);
    // Copies points or weights of the members to the device, in pieces, and records the conversion of each piece.
    void upload_pieces(const RawPoints& points, std::span<const std::int32_t> members, std::uint32_t total,
                       bool weights, const Passes& passes, ThreadPool& pool);
    void reserve(std::uint32_t count, bool weights);
    // Copies items in slices, two of which are in flight. Threads write a slice with write(to, first, count);
    // record(commands, staging, first, count) records its use.
    void stream(std::uint32_t total, std::size_t bytes_each, ThreadPool& pool, const auto& write, const auto& record);
    // Runs what record() records. Returns the seconds until the timestamp that it returns.
    double run_labeled(const char* name, const auto& record);

    vulkan::Memory& memory_;
    OwnBuffers buffers_{memory_}, name_buffers_{memory_};
    Buffer staging_[2], state_host_, order_host_;
    std::uint32_t capacity_ = 0, name_capacity_ = 0, wall_capacity_ = 0;
    bool has_weights_ = false;
    std::vector<WallPlane> walls_;
    DeviceSeeds seeds_;
    RunState state_{};
    Seconds seconds_;
    // Destroyed first: their destructors wait for work on the buffers.
    Commands commands_;
    Commands uploads_[2];
};

}  // namespace votess::gpu
