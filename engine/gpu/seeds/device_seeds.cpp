#include "gpu/seeds/device_seeds.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace votess::gpu {
namespace {

// Returns a whole number that orders doubles as their values do.
std::uint64_t ordered_bits(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x == 0 ? 0.0 : x);  // -0 equals 0
    const std::uint64_t sign = std::uint64_t{1} << 63;
    return (bits & sign) != 0 ? ~bits : bits | sign;
}

}  // namespace

void Bindings::set(std::uint32_t binding, const Slice& slice) {
    const auto end = list_.begin() + static_cast<std::ptrdiff_t>(count_);
    auto it = std::find_if(list_.begin(), end, [&](const BufferBinding& b) { return b.binding == binding; });
    if (it == end) ++count_;
    *it = {binding, slice};
}

Slice Bindings::get(std::uint32_t binding) const {
    for (const BufferBinding& b : list())
        if (b.binding == binding) return b.slice;
    return {};
}

void Scan::reserve(Workspace& workspace, std::uint32_t count) {
    for (Slice& sums : sums_) {
        count = blocks_of(count, TILE_ITEMS);
        sums = workspace.take_words(count, "scan sums");
        if (count <= 1) break;
    }
}

void Scan::record(Recorder& recorder, const Passes& passes, const Slice& data, std::uint32_t count) const {
    record_blocks(recorder, passes, data, count);
    if (count > TILE_ITEMS) record_add(recorder, passes, data, sums_[0], count);
}

void Scan::record_blocks(Recorder& recorder, const Passes& passes, const Slice& data, std::uint32_t count) const {
    std::array<std::uint32_t, max_levels> counts{};  // items of each level
    std::size_t levels = 0;
    Bindings bindings;
    for (;; count = blocks_of(count, TILE_ITEMS)) {
        counts[levels] = count;
        bindings.set(BINDING_SCAN_DATA, levels == 0 ? data : sums_[levels - 1]);
        bindings.set(BINDING_SCAN_SUMS, sums_[levels]);
        ++levels;
        recorder.run(passes.scan_blocks, bindings, ScanPush{count},
                     std::uint64_t{blocks_of(count, TILE_ITEMS)} * TILE_GROUP);
        if (count <= TILE_ITEMS) break;
    }
    // Adds the sums, from the level before the last one down to the sums of the first.
    for (std::size_t level = levels - 1; level-- > 1;)
        record_add(recorder, passes, sums_[level - 1], sums_[level], counts[level]);
}

void Scan::record_add(Recorder& recorder, const Passes& passes, const Slice& data, const Slice& sums,
                      std::uint32_t count) {
    Bindings bindings;
    bindings.set(BINDING_SCAN_DATA, data);
    bindings.set(BINDING_SCAN_SUMS, sums);
    recorder.run(passes.scan_add, bindings, ScanPush{count}, count);
}

void DeviceSeeds::reserve(Workspace& workspace, std::uint32_t seeds, std::uint32_t images, std::uint32_t walls,
                          bool weights) {
    const std::uint32_t capacity = seeds + images;
    set_count(capacity);
    has_images_ = images > 0;
    if (has_images_) {
        reserve_names(workspace, images);
        bindings_.set(BINDING_LATTICE, workspace.take(sizeof(LatticeData), "lattice"));
        image_counts_ = workspace.take_words(seeds, "image counts");
        image_scan_.reserve(workspace, seeds);
    }
    const VkDeviceSize n = capacity;
    const VkDeviceSize bytes = n * bytes_per_seed(weights);
    bindings_.set(BINDING_POINTS, workspace.take(bytes, "points"));
    bindings_.set(BINDING_SEEDS, workspace.take(bytes, "seeds"));
    for (int k = 0; k < 2; ++k) {
        keys_[k] = workspace.take_words(2 * n, "keys");
        index_[k] = workspace.take_words(n, "index");
    }
    const std::uint32_t counts = blocks_of(capacity, TILE_ITEMS) * DIGITS;
    counts_ = workspace.take_words(counts, "digit counts");
    scan_.reserve(workspace, counts);
    bindings_.set(BINDING_SEED_INPUT, workspace.take_words(n, "seed input"));
    const VkDeviceSize nodes = level_first_[level_count_ - 1] + VkDeviceSize{1};
    bindings_.set(BINDING_NODES, workspace.take(nodes * bytes_per_node(weights), "nodes"));
    state_and_walls_ = workspace.take(sizeof(RunState) + VkDeviceSize{walls} * sizeof(WallPlane), "run state");
    set_walls({});
}

void DeviceSeeds::set_walls(std::vector<WallPlane> walls) {
    walls_ = std::move(walls);
    Slice slice = state_and_walls_;
    slice.size = sizeof(RunState) + walls_.size() * sizeof(WallPlane);
    bindings_.set(BINDING_RUN_STATE, slice);
}

void DeviceSeeds::reserve_names(Workspace& workspace, std::uint32_t count) {
    bindings_.set(BINDING_NAMES, workspace.take(count * VkDeviceSize{sizeof(uvec2)}, "names"));
}

void DeviceSeeds::set_count(std::uint32_t count) {
    count_ = count;
    level_first_[0] = 0;
    level_size_[0] = blocks_of(count, GROUP_SEEDS);
    level_count_ = 1;
    for (; level_size_[level_count_ - 1] > 1; ++level_count_) {
        level_first_[level_count_] = level_first_[level_count_ - 1] + level_size_[level_count_ - 1];
        level_size_[level_count_] = blocks_of(level_size_[level_count_ - 1], FAN);
    }
}

void DeviceSeeds::set_box(const Box& box) {
    box_ = box;
    units_ = Units::for_box(box);
    box_lossy_ = false;
    for (int k = 0; k < 3; ++k) {
        origin_[k] = units_.of(box.lower[k], box_lossy_);
        extent_[k] = units_.of(box.upper[k], box_lossy_) - origin_[k];
    }
}

void DeviceSeeds::set_box(const Box& box, const Box& allowed) {
    set_box(box);
    box_ = allowed;
}

void DeviceSeeds::set_periodic_box(const Box& box, const std::array<bool, 3>& periodic, double margin) {
    Box larger = box, allowed = box;
    for (std::size_t k = 0; k < 3; ++k) {
        if (!periodic[k]) continue;
        const double side = box.upper[k] - box.lower[k];
        larger.lower[k] -= std::min(margin, 0.99 * side);  // images by one side suffice
        larger.upper[k] += std::min(margin, 0.99 * side);
        allowed.lower[k] -= side;
        allowed.upper[k] += side;
    }
    set_box(whole_box(larger, periodic), allowed);
    images_.periodic = 0;
    for (int k = 0; k < 3; ++k) {
        bool lossy = false;
        const std::uint64_t lower = units_.of(box.lower[k], lossy), upper = units_.of(box.upper[k], lossy);
        images_.lower[k] = words(lower - origin_[k]);
        images_.side[k] = words(upper - lower);
        images_.extent[k] = words(extent_[k]);
        if (!periodic[k]) continue;
        images_.periodic |= 1u << k;
        if (lossy)
            throw Error(ErrorCode::unsupported,
                        "the bounds of the periodic box differ too much in size for its sides to be whole numbers of "
                        "2^-62 of the longest one: choose bounds with fewer digits");
    }
}

void DeviceSeeds::set_cell(const CellImages& cell) {
    set_box(cell.box, cell.allowed);
    lattice_ = cell.data;
    for (int k = 0; k < 3; ++k) images_.extent[k] = words(extent_[k]);
}

std::array<uvec2, 9> DeviceSeeds::vectors() const {
    std::array<uvec2, 9> all{};
    std::ranges::copy(lattice_.vector, all.begin());
    for (std::size_t k = 0; k < 3; ++k)
        if ((images_.periodic >> k & 1) != 0) all[4 * k] = images_.side[k];
    return all;
}

void DeviceSeeds::record_images(Recorder& recorder, const Passes& passes, const Slice& header,
                                std::uint32_t count) const {
    ImagesPush push = images_;
    push.count = count;
    push.total = count_;
    Bindings bindings = bindings_;
    bindings.set(BINDING_SCAN_DATA, image_counts_);
    bindings.set(BINDING_HEADER, header);
    recorder.run(passes.upload_wrap, bindings, push, count);
    if (count == 0) return;
    image_scan_.record(recorder, passes, image_counts_, count);
    recorder.run(passes.upload_images, bindings, push, push.total - count);
}

void DeviceSeeds::record_walls(Recorder& recorder, const Passes& passes, std::uint32_t count) const {
    UploadPush push{};
    push.count = count;
    push.total = count_;
    recorder.run(passes.upload_walls, bindings_, push, count);
}

void DeviceSeeds::record_begin(Recorder& recorder, bool lossy) const {
    recorder.fill(run_state(), 0, sizeof(RunState), 0);
    if (weights_ && weights_->exponent != 0) {
        recorder.barrier();
        recorder.fill(run_state(), offsetof(RunState, weight_exponent), 4,
                      static_cast<std::uint32_t>(weights_->exponent));
    }
    if (weights_ && heaviest_unknown_) {
        bool rounded = false;
        const Units units{weights_->shift};
        const uvec2 heaviest = words(units.of(weights_->largest, rounded) - units.of(weights_->least, rounded) + 1);
        recorder.barrier();
        recorder.fill(run_state(), offsetof(RunState, heaviest), 4, heaviest.x);
        recorder.fill(run_state(), offsetof(RunState, heaviest) + 4, 4, heaviest.y);
    }
    recorder.write(run_state(), sizeof(RunState), std::as_bytes(std::span(walls_)));
    if (has_images_) recorder.write(bindings_.get(BINDING_LATTICE), 0, std::as_bytes(std::span(&lattice_, 1)));
    const std::uint32_t bits = (box_lossy_ ? LOSSY_BOX : 0) | (lossy ? LOSSY_POINTS : 0) |
                               (walls_.empty() ? 0 : LOSSY_WALLS) |
                               (lattice_.lossy != 0 ? LOSSY_POINTS | LOSSY_IMAGES : 0);
    if (bits == 0) return;
    recorder.barrier();
    recorder.fill(run_state(), offsetof(RunState, lossy), 4, bits);
}

void DeviceSeeds::record_present(Recorder& recorder, const Slice& count) const {
    recorder.copy(count, 0, run_state(), offsetof(RunState, present), sizeof(RunState::present));
}

void DeviceSeeds::record_raw(Recorder& recorder, const vulkan::Pass& pass, UploadPush push, const Raw& raw,
                             std::uint32_t first, std::uint32_t count) const {
    push.first = first;
    push.count = count;
    push.format = raw.format;
    push.stride = raw.stride;
    push.check = raw.check;
    push.begin = raw.begin;
    push.total = count_;
    Bindings bindings = bindings_;
    bindings.set(BINDING_RAW, raw.slice);
    recorder.run(pass, bindings, push, count);
}

void DeviceSeeds::record_weights(Recorder& recorder, const Passes& passes, const Raw& raw, std::uint32_t first,
                                 std::uint32_t count) const {
    UploadPush push{};
    bool lossy = false;
    push.origin[0] = words(Units{weights_->shift}.of(weights_->least, lossy));
    push.lower[0] = words(ordered_bits(weights_->least));
    push.upper[0] = words(ordered_bits(weights_->largest));
    push.shift = weights_->shift;
    record_raw(recorder, passes.upload_weights, push, raw, first, count);
}

void DeviceSeeds::record_upload(Recorder& recorder, const Passes& passes, const Raw& raw, std::uint32_t first,
                                std::uint32_t count) const {
    UploadPush push{};
    for (int k = 0; k < 3; ++k) {
        push.origin[k] = words(origin_[k]);
        push.lower[k] = words(ordered_bits(box_.lower[k]));
        push.upper[k] = words(ordered_bits(box_.upper[k]));
    }
    push.shift = units_.shift;
    record_raw(recorder, passes.upload, push, raw, first, count);
}

void DeviceSeeds::record_radix_pass(Recorder& recorder, const Passes& passes, std::uint32_t pass) const {
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
    recorder.run(passes.sort_count, bindings, push, invocations);
    scan_.record_blocks(recorder, passes, counts_, push.tiles * DIGITS);
    bindings.set(BINDING_SCAN_SUMS, scan_.block_sums());
    recorder.run(passes.sort_scatter, bindings, push, invocations);
}

void DeviceSeeds::record_order(Recorder& recorder, const Passes& passes, std::uint32_t key_bits) const {
    constexpr std::uint32_t radix_passes = 2 * ((KEY_WORD_BITS + DIGIT_BITS - 1) / DIGIT_BITS);
    static_assert(radix_passes % 4 == 0);  // an even number of passes, or half of them, ends where the keys were made
    const std::uint64_t longest = std::max({extent_[0], extent_[1], extent_[2]});
    const KeyPush push{
        count_, key_bits,
        static_cast<float>(std::ldexp(1.0, 32 + static_cast<int>(key_bits)) / static_cast<double>(longest))};
    Bindings bindings = bindings_;
    bindings.set(BINDING_KEYS_OUT, keys_[0]);
    bindings.set(BINDING_INDEX_OUT, index_[0]);
    recorder.run(passes.sort_key, bindings, push, count_);
    // With coarse keys the high word is 0 in all.
    const std::uint32_t needed = key_bits <= coarse_bits ? radix_passes / 2 : radix_passes;
    for (std::uint32_t pass = 0; pass < needed; ++pass) record_radix_pass(recorder, passes, pass);
}

void DeviceSeeds::record_crowded(Recorder& recorder, const Passes& passes) const {
    recorder.fill(crowded(), 0, 4, 0);
    recorder.barrier();
    Bindings bindings;
    bindings.set(BINDING_KEYS_IN, keys_[0]);
    bindings.set(BINDING_SCAN_DATA, crowded());
    recorder.run(passes.sort_crowded, bindings, KeyPush{count_, 0, 0}, count_);
}

void DeviceSeeds::record_gather(Recorder& recorder, const Passes& passes) const {
    Bindings bindings = bindings_;
    bindings.set(BINDING_KEYS_IN, keys_[0]);
    bindings.set(BINDING_INDEX_IN, index_[0]);
    recorder.run(passes.sort_gather, bindings, KeyPush{count_, 0, 0}, count_);
}

void DeviceSeeds::record_hierarchy(Recorder& recorder, const Passes& passes, const KnownSeeds& known) const {
    for (std::uint32_t level = 0; level < level_count_; ++level) {
        const std::uint32_t below = level == 0 ? 0 : level - 1;
        const BoxesPush push{
            count_, level, level_first_[level], level_size_[level], level_first_[below], level_size_[below]};
        recorder.run(passes.knn_boxes, bindings_, push, push.count);
    }
    const bool periodic = std::ranges::any_of(known.period, [](std::uint64_t period) { return period != 0; });
    if (weights_ && periodic && level_count_ > 1) record_image_reach(recorder, passes, known);
}

void DeviceSeeds::record_image_reach(Recorder& recorder, const Passes& passes, const KnownSeeds& known) const {
    ReachPush push{};
    for (int k = 0; k < 3; ++k) {
        push.lower[k] = words(known.lower[k]);
        push.upper[k] = words(known.upper[k]);
        push.side[k] = words(known.period[k]);
        push.periodic |= known.period[k] != 0 ? 1u << k : 0;
    }
    push.bounded = known.bounded;
    push.seed_count = count_;
    push.own_count = known.own_count;
    push.level_count = level_count_;
    push.node_count = level_size_[1];
    push.max_visits = 2 * passes.settings.max_visits;
    recorder.run(passes.image_reach, bindings_, push, push.node_count);
}

}  // namespace votess::gpu
