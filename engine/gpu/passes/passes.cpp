#include "gpu/passes/passes.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "gpu/passes/kernel_choice.hpp"
#include "shaders.hpp"
#include "shared/interface.h"
#include "shared/layout.h"

namespace votess::gpu {
namespace {

using vulkan::Device;
using vulkan::Pass;
using vulkan::PassBatch;

template <class Push>
Pass make(PassBatch& batch, const char* name, std::span<const std::uint32_t> spirv, std::uint32_t local_size,
          std::vector<vulkan::Constant> constants = {}, std::uint32_t subgroup_size = 0) {
    return batch.get(
        {name, spirv, static_cast<std::uint32_t>(sizeof(Push)), local_size, std::move(constants), subgroup_size});
}

// The error of an operation is half a unit in the last place where the device rounds to nearest, else one unit.
vulkan::Constant unit_roundoff(const Device& device) {
    return {CONSTANT_UNIT_ROUNDOFF, std::bit_cast<std::uint32_t>(device.rounds_to_nearest() ? 0x1p-24f : 0x1p-23f)};
}

vulkan::Constant wanted_geometry(const PassSettings& settings) {
    return {CONSTANT_GEOMETRY, settings.measure ? (settings.areas ? 2u : 1u) : 0u};
}

struct Variants {
    std::span<const std::uint32_t> float32, measured_float64, float64;
};

std::span<const std::uint32_t> of_numbers(const PassSettings& settings, const TierLimits& limits,
                                          const Variants& variants) {
    if (limits.float64) return variants.float64;
    return settings.measure && settings.measure_float64 ? variants.measured_float64 : variants.float32;
}

vulkan::Constant has_weights(const PassSettings& settings) {
    return {CONSTANT_WEIGHTS, settings.weights ? 1u : 0u};
}

// Shaders that clip in float64 measure in it too. They write the numbers that the others write.
std::vector<vulkan::Constant> with_numbers(std::vector<vulkan::Constant> constants, const PassSettings& settings,
                                           const TierLimits& limits) {
    if (limits.float64) constants.push_back({CONSTANT_WRITES_SUMS, settings.measure_float64 ? 0u : 1u});
    return constants;
}

Pass clip_cells(PassBatch& batch, const PassSettings& settings, std::uint32_t tier) {
    const TierLimits& limits = settings.tiers[tier];
    using namespace shaders;
    const auto spirv = of_numbers(settings, limits,
                                  limits.ties ? Variants{clip_f32_ties, clip_f32_measure_f64_ties, clip_f64_ties}
                                              : Variants{clip_f32, clip_f32_measure_f64, clip_f64});
    return make<ClipPush>(batch, tier == 0 ? "clip_cells" : "clip_cells second tier", spirv, settings.local_size,
                          with_numbers({{CONSTANT_MAX_PLANES, limits.planes},
                                        {CONSTANT_MAX_VERTICES, limits.vertices},
                                        {CONSTANT_TIER, tier},
                                        wanted_geometry(settings),
                                        {CONSTANT_WALLS, settings.walls ? 1u : 0u},
                                        unit_roundoff(batch.device()),
                                        has_weights(settings)},
                                       settings, limits));
}

// clip_subgroup.comp and its includes rely on this: sets of planes are one or two words; 32 planes to test fit into the
// store.
static_assert(SUBGROUP_PLANES == 32 && GROUP_SEEDS == FAN && 4 * 32 <= 2 * SUBGROUP_STORE);

// Returns the subgroups of a work-group of the first tier.
std::uint32_t subgroups_of_group(const Device& device, const PassSettings& settings) {
    const vulkan::Adapter& adapter = device.adapter();
    const std::uint32_t number = settings.tiers[0].float64 ? 8 : 4, planes = settings.tiers[0].planes;
    const std::uint32_t bytes_of_subgroup =
        4 * (2 * SUBGROUP_STORE + MAX_LEVELS +
             std::max<std::uint32_t>(SUBGROUP_NODES + SUBGROUP_GROUPS, 2 * planes + SUBGROUP_STORE)) +
        planes * (4 * number + 4);
    std::uint32_t subgroups =
        std::min(settings.subgroups, adapter.limits.maxComputeSharedMemorySize / bytes_of_subgroup);
    if (adapter.subgroup_size_control) subgroups = std::min(subgroups, adapter.max_subgroups);
    return std::max(subgroups, 1u);
}

Pass clip_by_subgroup(PassBatch& batch, const PassSettings& settings, std::uint32_t tier) {
    const TierLimits& limits = settings.tiers[tier];
    using namespace shaders;
    const Variants with_ties =
        tier == 0 ? Variants{clip_subgroup_f32_ties, clip_subgroup_f32_measure_f64_ties, clip_subgroup_f64_ties}
                  : Variants{clip_subgroup_f32_second_ties, {}, clip_subgroup_f64_ties};
    const Variants without = tier == 0 ? Variants{clip_subgroup_f32, clip_subgroup_f32_measure_f64, clip_subgroup_f64}
                                       : Variants{clip_subgroup_f32_second, {}, clip_subgroup_f64};
    const auto spirv = of_numbers(settings, limits, limits.ties ? with_ties : without);
    const std::uint32_t subgroups = tier == 1 ? 1 : subgroups_of_group(batch.device(), settings);
    return make<CellsPush>(batch, tier == 0 ? "clip_subgroup" : "clip_subgroup second tier", spirv,
                           subgroups * settings.subgroup_size,
                           with_numbers({{CONSTANT_MAX_VERTICES, limits.vertices},
                                         {CONSTANT_TIER, tier},
                                         {CONSTANT_LANES, settings.subgroup_size},
                                         {CONSTANT_SUBGROUPS, subgroups},
                                         {CONSTANT_LOCKSTEP, batch.device().adapter().lockstep ? 1u : 0u},
                                         {CONSTANT_FIRST_COUNT, settings.first_count},
                                         wanted_geometry(settings),
                                         {CONSTANT_WALLS, settings.walls ? 1u : 0u},
                                         unit_roundoff(batch.device()),
                                         has_weights(settings)},
                                        settings, limits),
                           settings.subgroup_size);
}

Pass clip(PassBatch& batch, const PassSettings& settings, std::uint32_t tier) {
    return settings.subgroup_size != 0 ? clip_by_subgroup(batch, settings, tier) : clip_cells(batch, settings, tier);
}

Pass second_tier(PassBatch& batch, const PassSettings& settings) {
    return settings.has_second_tier() ? clip(batch, settings, 1) : Pass();
}

// rows, areas, float32, float64: the shaders of rows alone, with areas, and with areas in frames.
Pass rows_by(PassBatch& batch, const PassSettings& s, const char* name, std::span<const std::uint32_t> rows,
             std::span<const std::uint32_t> areas, std::span<const std::uint32_t> float32,
             std::span<const std::uint32_t> float64) {
    const auto of_frames = s.measure_float64 ? float64 : float32;
    return make<RowsPush>(batch, name, !s.areas ? rows : s.frames ? of_frames : areas, s.local_size);
}

Pass download_rows(PassBatch& batch, const PassSettings& settings) {
    using namespace shaders;
    return rows_by(batch, settings, "download_rows", shaders::download_rows, download_rows_areas,
                   download_frame_areas_f32, download_frame_areas_f64);
}

Pass download_named_rows(PassBatch& batch, const PassSettings& settings) {
    using namespace shaders;
    return rows_by(batch, settings, "download_rows names", download_rows_names, download_rows_names_areas,
                   download_frame_names_areas_f32, download_frame_names_areas_f64);
}

}  // namespace

PassSettings usual_settings(const Device& device, std::uint32_t k) {
    constexpr std::uint32_t usual_k = 112, max_first_count = 3 * SUBGROUP_STORE / 4;
    constexpr std::uint32_t software_walk = 512, usual_walk = 2000, usual_subgroup = 40000, usual_again = 400000;
    PassSettings s;
    s.k = k == 0 ? usual_k : k;
    const Kernel kernel = kernel_from_environment();
    s.subgroup_size = choose_subgroup_size(device.adapter(), kernel);
    s.on_cpu = device.adapter().software() && kernel == Kernel::automatic;
    s.measure_float64 = measures_in_float64(device.adapter(), device.has_float64(), measure_from_environment());
    if (k != 0) s.first_count = std::min(k, max_first_count);
    // A chunk waits for its slowest cell. Where the device is the CPU, its own clipper is faster at long walks.
    s.max_walk_visits = device.adapter().software() ? software_walk : usual_walk;
    if (!device.adapter().software()) {
        s.max_subgroup_visits[0] = usual_subgroup;
        s.max_subgroup_visits[1] = usual_again;
    }
    s.tiers[0] = {.planes = SUBGROUP_PLANES, .vertices = 64, .float64 = false};
    // Lanes of a software device have many vertices each, which take long to compile.
    const bool few = device.adapter().software() && s.subgroup_size != 0;
    s.tiers[1] = {.planes = 2 * SUBGROUP_PLANES, .vertices = few ? 64u : 128u, .float64 = device.has_float64()};
    return s;
}

Passes::Passes(Device& device, const PassSettings& s) : Passes(PassBatch(device), s) {}

Passes::Passes(PassBatch&& batch, const PassSettings& s)
    : settings(s),
      upload(make<UploadPush>(batch, "upload", shaders::upload, s.local_size)),
      sort_key(make<KeyPush>(batch, "sort_key", shaders::sort_key, s.local_size)),
      sort_count(make<SortPush>(batch, "sort_count", shaders::sort_count, TILE_GROUP)),
      sort_scatter(make<SortPush>(batch, "sort_scatter", shaders::sort_scatter, TILE_GROUP)),
      sort_crowded(make<KeyPush>(batch, "sort_crowded", shaders::sort_crowded, s.local_size)),
      sort_gather(make<KeyPush>(batch, "sort_gather", shaders::sort_gather, s.local_size, {has_weights(s)})),
      scan_blocks(make<ScanPush>(batch, "scan_blocks", shaders::scan_blocks, TILE_GROUP)),
      scan_add(make<ScanPush>(batch, "scan_add", shaders::scan_add, s.local_size)),
      knn_boxes(make<BoxesPush>(batch, "knn_boxes", shaders::knn_boxes, s.local_size, {has_weights(s)})),
      clip_first(clip(batch, s, 0)),
      clip_todo(make<TodoPush>(batch, "clip_todo", shaders::clip_todo, TILE_GROUP)),
      clip_second(second_tier(batch, s)),
      download_rows(gpu::download_rows(batch, s)),
      download_total(make<FramePush>(batch, "download_total", shaders::download_total, 1)) {
    make_optional(batch);
    batch.make();
}

void Passes::make_optional(PassBatch& batch) {
    const PassSettings& s = settings;
    const auto usual = [&]<class Push>(const char* name, std::span<const std::uint32_t> spirv, Push,
                                       std::vector<vulkan::Constant> constants = {}) {
        return make<Push>(batch, name, spirv, s.local_size, std::move(constants));
    };
    using namespace shaders;
    if (s.subgroup_size == 0)
        knn_search = usual("knn_search", shaders::knn_search, KnnPush{}, {{CONSTANT_K, s.k}, has_weights(s)});
    if (s.weights) {
        upload_weights = usual("upload_weights", shaders::upload_weights, UploadPush{});
        image_reach = usual("image_reach", shaders::image_reach, ReachPush{}, {has_weights(s)});
    }
    if (!s.frames || s.images) download_named_rows = gpu::download_named_rows(batch, s);
    if (!s.frames) {
        download_place = usual("download_place", shaders::download_place, FramePush{});
        download_gather = usual("download_gather", shaders::download_gather, GatherPush{});
        return;
    }
    download_cells = usual("download_cells", s.measure_float64 ? download_cells_f64 : download_cells_f32, FramePush{});
    if (s.walls) upload_walls = usual("upload_walls", shaders::upload_walls, UploadPush{});
    if (s.images) {
        upload_wrap = usual("upload_wrap", s.triclinic ? upload_wrap_triclinic : shaders::upload_wrap, ImagesPush{});
        upload_images = usual("upload_images", s.triclinic ? upload_images_triclinic : shaders::upload_images,
                              ImagesPush{}, {has_weights(s)});
    }
    if (!s.follow) return;
    const vulkan::Constant walls{CONSTANT_WALLS, s.walls ? 1u : 0u};
    kept_places = usual("kept_places", shaders::kept_places, KeptPush{});
    kept_recall = usual("kept_recall", s.images ? kept_recall_names : shaders::kept_recall, KeptPush{});
    clip_kept =
        usual("clip_kept", s.measure && s.measure_float64 ? clip_kept_f32_measure_f64 : clip_kept_f32, ClipPush{},
              {{CONSTANT_MAX_PLANES, KEPT_PLANES},
               {CONSTANT_MAX_VERTICES, KEPT_CORNERS},
               wanted_geometry(s),
               walls,
               unit_roundoff(batch.device()),
               has_weights(s)});
    kept_match = usual("kept_match", s.images ? kept_match_names : shaders::kept_match, KeptPush{});
    kept_cover = usual("kept_cover", shaders::kept_cover, CoverPush{},
                       {wanted_geometry(s), walls, unit_roundoff(batch.device()), has_weights(s)});
    kept_judge = usual("kept_judge", shaders::kept_judge, CoverPush{}, {has_weights(s)});
    kept_drop = usual("kept_drop", shaders::kept_drop, KeptPush{});
    kept_store = usual("kept_store", s.images ? kept_store_names : shaders::kept_store, KeptPush{});
}

void Passes::make_with_ties(Device& device) {
    if (with_ties.clip_first) return;
    PassBatch batch(device);
    PassSettings s = settings;
    s.tiers[0].ties = s.tiers[1].ties = true;
    const Pass first = clip(batch, s, 0), second = second_tier(batch, s);
    batch.make();
    with_ties = {first, second};
}

}  // namespace votess::gpu
