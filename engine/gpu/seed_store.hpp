// The seeds of a run (or of a part of it) on the device: points as given become coordinates in units, sorted along a
// Hilbert curve, with a hierarchy of boxes over them. Stages upload, sort and the first half of knn.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine.hpp"
#include "gpu/passes.hpp"
#include "gpu/periodic_part.hpp"
#include "gpu/units.hpp"
#include "gpu/vulkan/commands.hpp"
#include "shared/layout.h"

namespace votess::gpu {

using vulkan::Buffer;
using vulkan::BufferBinding;
using vulkan::Commands;

// Buffers by binding number; a pass picks those it uses. A number that is set again has a new buffer.
class Bindings {
public:
    void set(std::uint32_t binding, const Buffer& buffer);
    [[nodiscard]] std::span<const BufferBinding> list() const { return list_; }

private:
    std::vector<BufferBinding> list_;
};

// Exclusive prefix sums of any number of words, in place.
class Scan {
public:
    // Buffers for arrays of up to `count` words.
    void reserve(vulkan::Memory& memory, std::uint32_t count);
    void record(Commands& commands, const Passes& passes, const Buffer& data, std::uint32_t count) const;

private:
    std::vector<Buffer> sums_;  // per level: totals of the level below
};

class SeedStore {
public:
    SeedStore(vulkan::Device& device, vulkan::Memory& memory);

    // Seeds for which all buffers stay within the device's limits.
    [[nodiscard]] static std::uint32_t most_seeds(const vulkan::Device& device, const vulkan::Memory& memory);

    // members: input indices of the seeds to take; empty = all points.
    void upload(const Job& job, std::span<const std::int32_t> members, const Passes& passes);
    // Seeds and images of a periodic domain.
    void upload(const PeriodicPart& periodic, const Passes& passes);
    // key_bits: per axis.
    void sort(const Passes& passes, std::uint32_t key_bits);
    void build_hierarchy(const Passes& passes);

    [[nodiscard]] std::uint32_t count() const { return count_; }
    [[nodiscard]] const Units& units() const { return units_; }
    [[nodiscard]] const std::uint64_t* extent() const { return extent_; }
    // The box's lower corner in units, modulo 2^64.
    [[nodiscard]] const std::uint64_t* origin() const { return origin_; }
    [[nodiscard]] RunState state() const { return state_; }
    // After sort(): index (of the members) of each sorted seed, with DUPLICATE_BIT.
    [[nodiscard]] std::span<const std::uint32_t> order() const { return order_host_.as<std::uint32_t>().first(count_); }
    [[nodiscard]] std::uint32_t level_count() const { return static_cast<std::uint32_t>(level_first_.size()); }
    [[nodiscard]] std::span<const std::uint32_t> level_first() const { return level_first_; }
    // What knn and clip read.
    [[nodiscard]] const Bindings& bindings() const { return bindings_; }
    // Seconds that the device spent.
    struct Seconds {
        double upload = 0, sort = 0, knn = 0;
    };
    [[nodiscard]] const Seconds& seconds() const { return seconds_; }

    // For tests: keys and input indices, sorted.
    [[nodiscard]] const Buffer& sorted_keys() const { return keys_[0]; }
    [[nodiscard]] const Buffer& sorted_index() const { return index_[0]; }

private:
    struct RawPoints {
        std::span<const std::byte> bytes;
        std::size_t bytes_each;
        std::uint32_t format;  // POINTS_
        bool lossy;            // already rounded
    };

    void upload(const RawPoints& points, std::span<const std::int32_t> members, const Box& box, const Passes& passes);
    void reserve(std::uint32_t count);
    void record_radix_pass(std::uint32_t pass, const Passes& passes);

    vulkan::Device& device_;
    vulkan::Memory& memory_;
    Buffer staging_[2];
    std::uint32_t count_ = 0, capacity_ = 0;
    Units units_;
    std::uint64_t extent_[3]{}, origin_[3]{};
    RunState state_{};
    Seconds seconds_;

    Buffer points_[3], keys_[2], index_[2], counts_;
    Buffer seeds_[3], seed_input_, nodes_, run_state_;
    Buffer state_host_, order_host_;
    Scan scan_;
    std::vector<std::uint32_t> level_first_, level_size_;
    Bindings bindings_;
    // Destroyed first, which waits for work on the buffers.
    Commands commands_;
    Commands uploads_[2];
};

}  // namespace votess::gpu
