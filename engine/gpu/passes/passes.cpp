#include "gpu/passes/passes.hpp"

#include <algorithm>
#include <bit>

#include "gpu/passes/kernel_choice.hpp"
#include "shaders.hpp"
#include "shared/bindings.h"
#include "shared/layout.h"

namespace votess::gpu {
namespace {

using vulkan::Device;
using vulkan::Pass;

template <class Push>
Pass make(Device& device, const char* name, std::span<const std::uint32_t> spirv, std::vector<std::uint32_t> bindings,
          std::uint32_t local_size, std::vector<std::uint32_t> constants = {}, std::uint32_t subgroup_size = 0) {
    return Pass(device, {name, spirv, std::move(bindings), static_cast<std::uint32_t>(sizeof(Push)), local_size,
                         std::move(constants), subgroup_size});
}

// An operation errs by half a unit in the last place where the device rounds to nearest, else by one.
float float_unit(const Device& device) {
    return device.rounds_to_nearest() ? 0x1p-24f : 0x1p-23f;
}

std::uint32_t wanted_geometry(const PassSettings& settings) {
    return settings.measure ? (settings.areas ? 2u : 1u) : 0u;
}

Pass clip_cells(Device& device, const PassSettings& settings, std::uint32_t tier) {
    const TierLimits& limits = settings.tiers[tier];
    const auto spirv =
        limits.float64 ? shaders::clip_f64
                       : (device.has_float64() && settings.measure ? shaders::clip_f32_measure_f64 : shaders::clip_f32);
    return make<ClipPush>(
        device, tier == 0 ? "clip_cells" : "clip_cells second tier", spirv,
        {BINDING_SEEDS_X, BINDING_SEEDS_Y, BINDING_SEEDS_Z, BINDING_SEED_INPUT, BINDING_RUN_STATE, BINDING_NODES,
         BINDING_LIST, BINDING_LIST_INFO, BINDING_INFO, BINDING_ROW_LENGTH, BINDING_ROW_PLACE, BINDING_ROWS,
         BINDING_GEOMETRY, BINDING_TODO, BINDING_CHUNK_STATE, BINDING_AREAS},
        settings.local_size,
        {limits.planes, limits.vertices, tier, wanted_geometry(settings),
         std::bit_cast<std::uint32_t>(float_unit(device)), settings.subgroup_size != 0 ? 1u : 0u});
}

// Of the shared arrays of clip_subgroup.comp and its includes.
std::uint32_t shared_bytes(const PassSettings& settings) {
    const std::uint32_t number = settings.tiers[0].float64 ? 8 : 4;
    return (2 * SUBGROUP_STORE + SUBGROUP_SCRATCH) * 4 + SUBGROUP_PLANES * (6 * number + 4) +
           settings.subgroup_size * 5 * number;
}

Pass clip_by_subgroup(Device& device, const PassSettings& settings) {
    const TierLimits& limits = settings.tiers[0];
    const auto spirv = limits.float64
                           ? shaders::clip_subgroup_f64
                           : (device.has_float64() && settings.measure ? shaders::clip_subgroup_f32_measure_f64
                                                                       : shaders::clip_subgroup_f32);
    const vulkan::Adapter& adapter = device.adapter();
    std::uint32_t subgroups =
        std::min(settings.subgroups, adapter.limits.maxComputeSharedMemorySize / shared_bytes(settings));
    if (adapter.subgroup_size_control) subgroups = std::min(subgroups, adapter.max_subgroups);
    subgroups = std::max(subgroups, 1u);
    return make<CellsPush>(
        device, "clip_subgroup", spirv,
        {BINDING_SEEDS_X, BINDING_SEEDS_Y, BINDING_SEEDS_Z, BINDING_SEED_INPUT, BINDING_RUN_STATE, BINDING_NODES,
         BINDING_INFO, BINDING_ROW_LENGTH, BINDING_ROW_PLACE, BINDING_ROWS, BINDING_GEOMETRY, BINDING_TODO,
         BINDING_CHUNK_STATE, BINDING_AREAS},
        subgroups * settings.subgroup_size,
        {limits.planes, limits.vertices, adapter.lockstep ? 1u : 0u, wanted_geometry(settings),
         std::bit_cast<std::uint32_t>(float_unit(device)), settings.subgroup_size, subgroups, settings.first_count},
        settings.subgroup_size);
}

Pass first_tier(Device& device, const PassSettings& settings) {
    return settings.subgroup_size != 0 ? clip_by_subgroup(device, settings) : clip_cells(device, settings, 0);
}

Pass download_rows(Device& device, const PassSettings& settings) {
    std::vector<std::uint32_t> bindings{BINDING_ROW_LENGTH,  BINDING_ROW_PLACE,   BINDING_ROWS,     BINDING_SECOND_ROWS,
                                        BINDING_ROW_OFFSETS, BINDING_CHUNK_STATE, BINDING_ROWS_OUT, BINDING_ROWS_OUT_1,
                                        BINDING_ROWS_OUT_2,  BINDING_ROWS_OUT_3};
    if (settings.images) {
        bindings.insert(bindings.end(), {BINDING_IMAGE_HOME, BINDING_SHIFTS_OUT, BINDING_SHIFTS_OUT_1,
                                         BINDING_SHIFTS_OUT_2, BINDING_SHIFTS_OUT_3});
        return make<RowsPush>(device, "download_rows shifts", shaders::download_rows_shifts, bindings,
                              settings.local_size);
    }
    if (!settings.areas)
        return make<RowsPush>(device, "download_rows", shaders::download_rows, bindings, settings.local_size);
    bindings.insert(bindings.end(), {BINDING_AREAS, BINDING_SECOND_AREAS, BINDING_AREAS_OUT});
    return make<RowsPush>(device, "download_rows areas", shaders::download_rows_areas, bindings, settings.local_size);
}

}  // namespace

PassSettings usual_settings(const Device& device, std::uint32_t k) {
    constexpr std::uint32_t usual_k = 112, most_first_count = 96;  // of SUBGROUP_STORE
    constexpr std::uint32_t software_walk = 512, usual_walk = 20000;
    PassSettings s;
    s.k = k == 0 ? usual_k : k;
    s.subgroup_size = choose_subgroup_size(device.adapter(), kernel_from_environment());
    if (k != 0) s.first_count = std::min(k, most_first_count);
    // Where the device is the CPU, long walks are quicker in the CPU's own clipper.
    s.most_walk_visits = device.adapter().software() ? software_walk : usual_walk;
    s.tiers[0] = {.planes = 32, .vertices = 64, .float64 = false};
    s.tiers[1] = {.planes = 64, .vertices = 128, .float64 = device.has_float64()};
    return s;
}

Passes::Passes(Device& device, const PassSettings& s)
    : settings(s),
      upload(make<UploadPush>(device, "upload", shaders::upload,
                              {BINDING_RAW, BINDING_POINTS_X, BINDING_POINTS_Y, BINDING_POINTS_Z, BINDING_RUN_STATE},
                              s.local_size)),
      sort_key(make<KeyPush>(
          device, "sort_key", shaders::sort_key,
          {BINDING_POINTS_X, BINDING_POINTS_Y, BINDING_POINTS_Z, BINDING_KEYS_OUT, BINDING_INDEX_OUT}, s.local_size)),
      sort_count(
          make<SortPush>(device, "sort_count", shaders::sort_count, {BINDING_KEYS_IN, BINDING_SCAN_DATA}, TILE_GROUP)),
      sort_scatter(make<SortPush>(
          device, "sort_scatter", shaders::sort_scatter,
          {BINDING_KEYS_IN, BINDING_INDEX_IN, BINDING_KEYS_OUT, BINDING_INDEX_OUT, BINDING_SCAN_DATA}, TILE_GROUP)),
      sort_gather(
          make<KeyPush>(device, "sort_gather", shaders::sort_gather,
                        {BINDING_POINTS_X, BINDING_POINTS_Y, BINDING_POINTS_Z, BINDING_KEYS_IN, BINDING_INDEX_IN,
                         BINDING_SEEDS_X, BINDING_SEEDS_Y, BINDING_SEEDS_Z, BINDING_SEED_INPUT, BINDING_RUN_STATE},
                        s.local_size)),
      scan_blocks(make<ScanPush>(device, "scan_blocks", shaders::scan_blocks, {BINDING_SCAN_DATA, BINDING_SCAN_SUMS},
                                 TILE_GROUP)),
      scan_add(
          make<ScanPush>(device, "scan_add", shaders::scan_add, {BINDING_SCAN_DATA, BINDING_SCAN_SUMS}, s.local_size)),
      knn_boxes(make<BoxesPush>(device, "knn_boxes", shaders::knn_boxes,
                                {BINDING_SEEDS_X, BINDING_SEEDS_Y, BINDING_SEEDS_Z, BINDING_NODES}, s.local_size)),
      knn_search(make<KnnPush>(device, "knn_search", shaders::knn_search,
                               {BINDING_SEEDS_X, BINDING_SEEDS_Y, BINDING_SEEDS_Z, BINDING_SEED_INPUT, BINDING_NODES,
                                BINDING_LIST, BINDING_LIST_INFO, BINDING_TODO, BINDING_CHUNK_STATE},
                               s.local_size, {s.k, s.subgroup_size != 0 ? 1u : 0u})),
      clip_cells{first_tier(device, s), gpu::clip_cells(device, s, 1)},
      clip_todo(make<ClipPush>(device, "clip_todo", shaders::clip_todo, {BINDING_CHUNK_STATE}, 1, {s.local_size})),
      download_rows(gpu::download_rows(device, s)) {
    if (!s.frames) return;
    download_cells = std::make_unique<Pass>(make<FramePush>(
        device, "download_cells", device.has_float64() ? shaders::download_cells_f64 : shaders::download_cells_f32,
        {BINDING_SEED_INPUT, BINDING_INFO, BINDING_ROW_LENGTH, BINDING_ROW_OFFSETS, BINDING_CHUNK_STATE,
         BINDING_GEOMETRY, BINDING_HEADER, BINDING_CELLS, BINDING_GEOMETRY_OUT},
        s.local_size));
    download_total = std::make_unique<Pass>(
        make<FramePush>(device, "download_total", shaders::download_total,
                        {BINDING_ROW_LENGTH, BINDING_ROW_OFFSETS, BINDING_CHUNK_STATE, BINDING_HEADER}, 1));
    if (!s.images) return;
    upload_wrap = std::make_unique<Pass>(
        make<ImagesPush>(device, "upload_wrap", shaders::upload_wrap,
                         {BINDING_POINTS_X, BINDING_POINTS_Y, BINDING_POINTS_Z, BINDING_SCAN_DATA}, s.local_size));
    upload_images = std::make_unique<Pass>(
        make<ImagesPush>(device, "upload_images", shaders::upload_images,
                         {BINDING_POINTS_X, BINDING_POINTS_Y, BINDING_POINTS_Z, BINDING_SCAN_DATA, BINDING_RUN_STATE,
                          BINDING_IMAGE_HOME, BINDING_HEADER},
                         s.local_size));
}

}  // namespace votess::gpu
