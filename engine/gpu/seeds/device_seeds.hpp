// The seeds of a run on the device: points as given become coordinates in units, sorted along a Hilbert curve, with a
// hierarchy of boxes over them. Arrays, and what is recorded for the stages upload, sort and the first half of knn.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gpu/domain/cell_images.hpp"
#include "gpu/domain/units.hpp"
#include "gpu/passes/passes.hpp"
#include "gpu/vulkan/recorder.hpp"
#include "gpu/vulkan/workspace.hpp"
#include "shared/interface.h"
#include "shared/layout.h"

namespace votess::gpu {

using vulkan::BufferBinding;
using vulkan::Recorder;

// Arrays by binding number; a pass picks those it uses. A number that is set again has a new array.
class Bindings {
public:
    void set(std::uint32_t binding, const Slice& slice);
    [[nodiscard]] Slice get(std::uint32_t binding) const;  // an empty one when it was never set
    [[nodiscard]] std::span<const BufferBinding> list() const { return std::span(list_).first(count_); }

private:
    std::array<BufferBinding, BINDING_COUNT> list_;
    std::size_t count_ = 0;
};

// Exclusive prefix sums of any number of words, in place.
class Scan {
public:
    // Arrays for up to `count` words.
    void reserve(Workspace& workspace, std::uint32_t count);
    void record(Recorder& recorder, const Passes& passes, const Slice& data, std::uint32_t count) const;

private:
    static constexpr std::size_t max_levels = 4;  // TILE_ITEMS to the fourth is more than 32 bits can count
    std::array<Slice, max_levels> sums_;          // per level: totals of the level below
};

class DeviceSeeds {
public:
    static constexpr VkDeviceSize coordinate_bytes = 8;

    // Arrays for up to `capacity` seeds, for the images of those of a periodic box, and for walls of any direction;
    // weights: for these too.
    void reserve(Workspace& workspace, std::uint32_t capacity, std::uint32_t images = 0, std::uint32_t walls = 0,
                 bool weights = false);
    // From now on there are these walls of any direction, for which there must be room.
    void set_walls(std::vector<WallPlane> walls);
    // For names of up to `count` seeds, where they have others than their index.
    void reserve_names(Workspace& workspace, std::uint32_t count);
    // Says how many seeds to record for from now on, with all places for images.
    void set_count(std::uint32_t count);
    void set_box(const Box& box);
    // The same; `allowed` is that of points that are checked.
    void set_box(const Box& box, const Box& allowed);
    // Along these axes the box repeats: images up to `margin` outside of it count. Throws `unsupported` when the sides
    // of the box are no whole numbers of units.
    void set_periodic_box(const Box& box, const std::array<bool, 3>& periodic, double margin);

    // The box of seeds and images around a triclinic one.
    void set_cell(const CellImages& cell);
    // From now on the seeds have such weights; none: they have no weights.
    void set_weights(const std::optional<WeightUnits>& weights) { weights_ = weights; }

    // Forgets what is known about points; to be followed by a barrier. lossy: points that are rounded already.
    void record_begin(Recorder& recorder, bool lossy) const;
    // Points of the raw array, from a number of it on, become those from `first` on. check: those outside of the box
    // get no cell.
    struct Raw {
        Slice slice;
        std::uint32_t format = POINTS_FLOAT64, stride = 3;
        bool check = false;
        std::uint32_t begin = 0;
    };
    void record_upload(Recorder& recorder, const Passes& passes, const Raw& raw, std::uint32_t first,
                       std::uint32_t count) const;
    // The same for weights, one number a seed, after its coordinates. check: seeds of others than those from the least
    // to the largest get no cell; else lighter ones, and those that are not finite, count as the least.
    void record_weights(Recorder& recorder, const Passes& passes, const Raw& raw, std::uint32_t first,
                        std::uint32_t count) const;
    // After the upload of `count` seeds: those beyond walls get no cell.
    void record_walls(Recorder& recorder, const Passes& passes, std::uint32_t count) const;
    // After that, too: brings them into the periodic box, and adds images at their places.
    void record_images(Recorder& recorder, const Passes& passes, const Slice& header, std::uint32_t count) const;
    // Finds the order of the points, by keys of so many bits per axis; with up to coarse_bits that takes half of the
    // time.
    static constexpr std::uint32_t coarse_bits = KEY_WORD_BITS / 3;
    void record_order(Recorder& recorder, const Passes& passes, std::uint32_t key_bits) const;
    // After record_order(): leaves a word at the begin of crowded() that is not 0 where the order is too coarse.
    void record_crowded(Recorder& recorder, const Passes& passes) const;
    // Brings the points into the order.
    void record_gather(Recorder& recorder, const Passes& passes) const;
    void record_hierarchy(Recorder& recorder, const Passes& passes) const;

    [[nodiscard]] std::uint32_t count() const { return count_; }
    [[nodiscard]] const Units& units() const { return units_; }
    [[nodiscard]] const std::uint64_t* extent() const { return extent_; }
    // The box's lower corner in units, modulo 2^64.
    [[nodiscard]] const std::uint64_t* origin() const { return origin_; }
    [[nodiscard]] std::span<const std::uint32_t> level_first() const {
        return std::span(level_first_).first(level_count_);
    }
    // The arrays that knn and clip read.
    [[nodiscard]] const Bindings& bindings() const { return bindings_; }
    [[nodiscard]] Slice run_state() const { return bindings_.get(BINDING_RUN_STATE); }
    [[nodiscard]] Slice seed_input() const { return bindings_.get(BINDING_SEED_INPUT); }
    [[nodiscard]] Slice sorted_keys() const { return keys_[0]; }
    [[nodiscard]] Slice sorted_index() const { return index_[0]; }
    [[nodiscard]] Slice crowded() const { return counts_; }

private:
    void record_radix_pass(Recorder& recorder, const Passes& passes, std::uint32_t pass) const;

    std::uint32_t count_ = 0;
    Units units_;
    std::optional<WeightUnits> weights_;
    Box box_;
    bool box_lossy_ = false;
    std::uint64_t extent_[3]{}, origin_[3]{};
    Slice keys_[2], index_[2], counts_, image_counts_, state_and_walls_;
    std::vector<WallPlane> walls_;
    Scan scan_, image_scan_;
    ImagesPush images_{};
    LatticeData lattice_{};
    std::array<std::uint32_t, MAX_LEVELS> level_first_{}, level_size_{};
    std::uint32_t level_count_ = 0;
    Bindings bindings_;
};

// How many blocks of `block` items there are.
[[nodiscard]] constexpr std::uint32_t blocks_of(std::uint32_t count, std::uint32_t block) {
    return count / block + (count % block != 0 ? 1 : 0);
}

}  // namespace votess::gpu
