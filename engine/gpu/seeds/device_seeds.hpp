// The seeds of a run on the device: coordinates in units, sorted along a Hilbert curve, with a hierarchy of boxes over
// them. Holds the arrays and records the stages upload, sort and the first half of knn.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gpu/domain/cell_images.hpp"
#include "gpu/domain/parts.hpp"
#include "gpu/domain/units.hpp"
#include "gpu/passes/passes.hpp"
#include "gpu/vulkan/recorder.hpp"
#include "gpu/vulkan/workspace.hpp"
#include "shared/interface.h"
#include "shared/layout.h"

namespace votess::gpu {

using vulkan::BufferBinding;
using vulkan::Recorder;

// Arrays by binding number. A pass uses some of them. Setting a number again replaces its array.
class Bindings {
public:
    void set(std::uint32_t binding, const Slice& slice);
    [[nodiscard]] Slice get(std::uint32_t binding) const;  // empty when it was never set
    [[nodiscard]] std::span<const BufferBinding> list() const { return std::span(list_).first(count_); }

private:
    std::array<BufferBinding, BINDING_COUNT> list_;
    std::size_t count_ = 0;
};

// Exclusive prefix sums of any number of words, in place.
class Scan {
public:
    // Reserves arrays for up to `count` words.
    void reserve(Workspace& workspace, std::uint32_t count);
    void record(Recorder& recorder, const Passes& passes, const Slice& data, std::uint32_t count) const;
    // Records sums inside blocks of TILE_ITEMS only. The first block's sum is 0, those of others are block_sums().
    void record_blocks(Recorder& recorder, const Passes& passes, const Slice& data, std::uint32_t count) const;
    [[nodiscard]] const Slice& block_sums() const { return sums_[0]; }

private:
    // Records that block b of the data gets sums[b] added.
    static void record_add(Recorder& recorder, const Passes& passes, const Slice& data, const Slice& sums,
                           std::uint32_t count);

    static constexpr std::size_t max_levels = 4;  // TILE_ITEMS^4 exceeds 32 bits
    std::array<Slice, max_levels> sums_;          // of each level: totals of the level before
};

class DeviceSeeds {
public:
    // Returns the bytes of a point or seed, and of a node of the hierarchy.
    static constexpr VkDeviceSize bytes_per_seed(bool weights) { return weights ? 32 : 24; }
    static_assert(sizeof(Node) == 48 && sizeof(NodeWeights) == 32);  // three and two words of search/nodes.glsl
    static constexpr VkDeviceSize bytes_per_node(bool weights) {
        return sizeof(Node) + (weights ? sizeof(NodeWeights) : 0);
    }

    // Reserves arrays for up to `capacity` seeds, `images` images of a periodic box and `walls` walls of any direction.
    // weights: reserves them for weights too.
    void reserve(Workspace& workspace, std::uint32_t capacity, std::uint32_t images = 0, std::uint32_t walls = 0,
                 bool weights = false);
    // Sets the walls of any direction. There must be room for them.
    void set_walls(std::vector<WallPlane> walls);
    // Reserves names for up to `count` seeds that have other names than their index.
    void reserve_names(Workspace& workspace, std::uint32_t count);
    // Sets the number of seeds for later recordings, all places of images included.
    void set_count(std::uint32_t count);
    void set_box(const Box& box);
    // The same. allowed: the box of points that are checked.
    void set_box(const Box& box, const Box& allowed);
    // Sets a box that repeats along these axes, with images up to `margin` outside of it. Throws `unsupported` when the
    // sides of the box are not whole numbers of units.
    void set_periodic_box(const Box& box, const std::array<bool, 3>& periodic, double margin);

    // Sets a triclinic box, with the box of its seeds and images.
    void set_cell(const CellImages& cell);
    // Sets the units of weights; none: the seeds have no weights.
    void set_weights(const std::optional<WeightUnits>& weights) { weights_ = weights; }
    // Sets that seeds with the largest weight may exist that are not uploaded.
    void set_heaviest_unknown(bool unknown) { heaviest_unknown_ = unknown; }

    // Records the reset of the run state; a barrier must follow. lossy: points are rounded already.
    void record_begin(Recorder& recorder, bool lossy) const;
    // Records that the number of points is in this buffer. Uploads check it with CHECK_COUNT.
    void record_present(Recorder& recorder, const Slice& count) const;
    // Records the conversion of raw points. `begin` is the first number of the raw array, `first` the first seed.
    // check: bits of CHECK_.
    struct Raw {
        Slice slice;
        std::uint32_t format = POINTS_FLOAT64, stride = 3;
        std::uint32_t check = 0;
        std::uint32_t begin = 0;
    };
    void record_upload(Recorder& recorder, const Passes& passes, const Raw& raw, std::uint32_t first,
                       std::uint32_t count) const;
    // The same for weights, one number a seed, after its coordinates. CHECK_BOX: a seed whose weight is not from the
    // least to the largest gets no cell. Otherwise lighter weights, and those that are not finite, count as the least.
    void record_weights(Recorder& recorder, const Passes& passes, const Raw& raw, std::uint32_t first,
                        std::uint32_t count) const;
    // Records after the upload of `count` seeds: seeds beyond walls get no cell.
    void record_walls(Recorder& recorder, const Passes& passes, std::uint32_t count) const;
    // Records after the upload: wraps the seeds into the periodic box and adds images.
    void record_images(Recorder& recorder, const Passes& passes, const Slice& header, std::uint32_t count) const;
    // Records the sort of the points, by keys of `key_bits` per axis. Up to coarse_bits it takes half of the time.
    static constexpr std::uint32_t coarse_bits = KEY_WORD_BITS / 3;
    void record_order(Recorder& recorder, const Passes& passes, std::uint32_t key_bits) const;
    // Records after record_order(): the first word of crowded() becomes nonzero where the order is too coarse.
    void record_crowded(Recorder& recorder, const Passes& passes) const;
    // Records the move of the points into that order.
    void record_gather(Recorder& recorder, const Passes& passes) const;
    // Records the hierarchy. In a power diagram `known` bounds the reach of images that are not among the seeds.
    void record_hierarchy(Recorder& recorder, const Passes& passes, const KnownSeeds& known) const;

    [[nodiscard]] std::uint32_t count() const { return count_; }
    [[nodiscard]] const Units& units() const { return units_; }
    [[nodiscard]] const std::uint64_t* extent() const { return extent_; }
    // Returns the side along which a periodic box repeats, in units.
    [[nodiscard]] std::uint64_t period(std::size_t axis) const {
        return images_.side[axis].x | std::uint64_t{images_.side[axis].y} << 32;
    }
    // Returns the vectors a, b and c along which the box repeats, in units; 0 where it does not.
    [[nodiscard]] std::array<uvec2, 9> vectors() const;
    // Returns the number of walls of any direction, with those of the box.
    [[nodiscard]] std::size_t walls() const { return walls_.size(); }
    // Returns the box's lower corner in units, modulo 2^64.
    [[nodiscard]] const std::uint64_t* origin() const { return origin_; }
    [[nodiscard]] std::span<const std::uint32_t> level_first() const {
        return std::span(level_first_).first(level_count_);
    }
    // Returns the arrays that knn and clip read.
    [[nodiscard]] const Bindings& bindings() const { return bindings_; }
    [[nodiscard]] Slice run_state() const { return bindings_.get(BINDING_RUN_STATE); }
    [[nodiscard]] Slice seed_input() const { return bindings_.get(BINDING_SEED_INPUT); }
    // Returns for each seed of a periodic box where its images begin among the names, after record_images().
    [[nodiscard]] Slice image_offsets() const { return image_counts_; }
    [[nodiscard]] Slice sorted_keys() const { return keys_[0]; }
    [[nodiscard]] Slice sorted_index() const { return index_[0]; }
    [[nodiscard]] Slice crowded() const { return counts_; }

private:
    void record_image_reach(Recorder& recorder, const Passes& passes, const KnownSeeds& known) const;
    void record_raw(Recorder& recorder, const vulkan::Pass& pass, UploadPush push, const Raw& raw, std::uint32_t first,
                    std::uint32_t count) const;
    void record_radix_pass(Recorder& recorder, const Passes& passes, std::uint32_t pass) const;

    std::uint32_t count_ = 0;
    Units units_;
    std::optional<WeightUnits> weights_;
    bool heaviest_unknown_ = false;
    Box box_;
    bool box_lossy_ = false;
    std::uint64_t extent_[3]{}, origin_[3]{};
    Slice keys_[2], index_[2], counts_, image_counts_, state_and_walls_;
    std::vector<WallPlane> walls_;
    Scan scan_, image_scan_;
    bool has_images_ = false;
    ImagesPush images_{};
    LatticeData lattice_{};
    std::array<std::uint32_t, MAX_LEVELS> level_first_{}, level_size_{};
    std::uint32_t level_count_ = 0;
    Bindings bindings_;
};

// Returns the number of blocks of `block` items.
[[nodiscard]] constexpr std::uint32_t blocks_of(std::uint32_t count, std::uint32_t block) {
    return count / block + (count % block != 0 ? 1 : 0);
}

}  // namespace votess::gpu
