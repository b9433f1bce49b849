#include "gpu/frames/kept_frames.hpp"

#include <algorithm>
#include <cmath>

namespace votess::gpu {
namespace {

// The share of pending cells from which on all are made. Invocations side by side wait for each other: on lavapipe with
// 8 lanes a frame with 8 % pending takes half the time of a whole one. Subgroups do not wait.
double max_pending_share(const PassSettings& settings) {
    return settings.subgroup_size != 0 ? 0.5 : 0.15;
}

// Returns the least width of the box along the vectors that repeat it, 3.0e38 if there are none.
double least_width(const std::array<double, 9>& vectors, std::uint32_t periodic) {
    double least = UNBOUNDED;
    for (std::size_t j = 0; j < 3; ++j) {
        if ((periodic >> j & 1) == 0) continue;
        const double* const own = &vectors[3 * j];
        const double* const next = &vectors[3 * ((j + 1) % 3)];
        const double* const other = &vectors[3 * ((j + 2) % 3)];
        double square = 0, volume = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            const double normal = next[l] * other[m] - next[m] * other[l];
            square += normal * normal;
            volume += own[k] * normal;
        }
        least = std::min(least, std::abs(volume) / std::sqrt(square));
    }
    return least;
}

}  // namespace

VkDeviceSize KeptFrames::bytes(std::uint32_t seeds, bool images) {
    return VkDeviceSize{4} * seeds * (KEPT_STORED_WORDS + (images ? KEPT_STORED_SHIFTS : 0));
}

void KeptFrames::reserve(Workspace& workspace, std::uint32_t points, std::uint32_t seeds, const Slice& store) {
    seeds_ = seeds;
    max_images_ = points - seeds;
    store_ = store;
    places_ = workspace.take_words(points, "places");
}

void KeptFrames::set_job(const DeviceSeeds& seeds, const DeviceCells& cells, std::uint32_t count) {
    bindings_ = cells.bindings();
    bindings_.set(BINDING_KEPT, store_);
    bindings_.set(BINDING_PLACES, places_);
    bindings_.set(BINDING_SCAN_DATA, seeds.image_offsets());
    state_ = cells.state();
    clip_ = cells.clip_push();
    push_ = {seeds.count(), count, count == 0 ? 0 : max_images_, clip_.keeps, seeds_, 0};
    std::array<double, 9> vectors{};
    std::uint32_t periodic = 0;
    for (std::size_t i = 0; const uvec2& words : seeds.vectors()) {
        vectors[i] = static_cast<double>(static_cast<std::int64_t>(words.x | std::uint64_t{words.y} << 32));
        if (vectors[i] != 0) periodic |= 1u << i / 3;
        ++i;
    }
    std::array<double, 9> edges = vectors;
    for (std::size_t j = 0; j < 3; ++j)
        if ((periodic >> j & 1) == 0) edges[4 * j] = 1;
    clip_.kept_reach = static_cast<float>(0.99 * least_width(edges, periodic));
    std::ranges::copy(clip_.extent, cover_.extent);
    std::ranges::transform(vectors, cover_.vectors, [](double x) { return static_cast<float>(x); });
    cover_.periodic = periodic;
    cover_.bounded = clip_.bounded;
    cover_.cell_count = cover_.seed_count = seeds.count();
    cover_.own_count = count;
    cover_.keeps = clip_.keeps;
    cover_.root = seeds.level_first().back();
}

void KeptFrames::record_recall(Recorder& recorder, const Passes& passes, bool fresh) const {
    record_reset(recorder);
    if (fresh) recorder.fill(store_, 0, VkDeviceSize{4} * seeds_, 0);  // no cell is stored
    recorder.barrier();
    recorder.run(passes.kept_places, bindings_, push_, push_.cell_count);
    recorder.run(passes.kept_recall, bindings_, push_, push_.cell_count);
    recorder.run(passes.clip_kept, bindings_, clip_, push_.cell_count);
    record_drop(recorder, passes, static_cast<std::uint32_t>(max_pending_share(passes.settings) * push_.own_count));
}

void KeptFrames::record_reset(Recorder& recorder) const {
    constexpr VkDeviceSize first = offsetof(ChunkState, kept_pending), point = offsetof(ChunkState, kept_point);
    recorder.fill(state_, first, point - first, 0);
    recorder.fill(state_, point, 4, ~std::uint32_t{0});
}

void KeptFrames::record_match(Recorder& recorder, const Passes& passes) const {
    record_reset(recorder);
    recorder.barrier();
    recorder.run(passes.kept_match, bindings_, push_, push_.cell_count);
}

void KeptFrames::record_judgment(Recorder& recorder, const Passes& passes) const {
    recorder.run(passes.kept_cover, bindings_, cover_, push_.cell_count);
    recorder.run(passes.kept_judge, bindings_, cover_, push_.cell_count);
    record_drop(recorder, passes, 0);
}

void KeptFrames::record_drop(Recorder& recorder, const Passes& passes, std::uint32_t max_pending) const {
    KeptPush push = push_;
    push.max_pending = max_pending;
    recorder.run(passes.kept_drop, bindings_, push, push.cell_count);
}

void KeptFrames::record_store(Recorder& recorder, const Passes& passes) const {
    recorder.run(passes.kept_store, bindings_, push_, seeds_);
}

}  // namespace votess::gpu
