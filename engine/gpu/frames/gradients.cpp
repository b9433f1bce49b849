#include "gpu/frames/gradients.hpp"

#include <algorithm>
#include <utility>

#include "gpu/frames/frame.hpp"
#include "shaders.hpp"
#include "shared/gradient.h"

namespace votess::gpu {

using votess::vulkan::detail::PlanAccess;

static_assert(sizeof(GradientPush) == 120);  // without padding, and less than the 128 bytes that any device has

GradientPasses::GradientPasses(vulkan::Device& device, bool wide) : GradientPasses(vulkan::PassBatch(device), wide) {}

GradientPasses::GradientPasses(vulkan::PassBatch&& batch, bool wide)
    : cells(batch.get({.name = "gradient_cells",
                       .spirv = wide ? shaders::gradient_cells_f64 : shaders::gradient_cells_f32,
                       .push_bytes = sizeof(GradientPush)})),
      faces(batch.get({.name = "gradient_faces",
                       .spirv = shaders::gradient_faces,
                       .push_bytes = sizeof(GradientPush),
                       .local_size = GRADIENT_LANES})) {
    batch.make();
}

namespace {

GradientPasses make_passes(const votess::vulkan::Plan& plan) {
    vulkan::Device& device = PlanAccess::device(plan);
    if (!plan.options().neighbors)
        throw Error(ErrorCode::invalid_argument, "gradients follow the rows: request neighbors too");
    if (!device.has_float64())
        throw Error(ErrorCode::unsupported, device.adapter().name +
                                                " has no float64, which gradients need: use tessellate() and its "
                                                "derivatives");
    return {device, plan.options().format == votess::vulkan::SeedFormat::float64};
}

}  // namespace

Gradients::Gradients(const votess::vulkan::Plan& plan) : plan_(plan), passes_(make_passes(plan)) {}

void Gradients::record(vulkan::Recorder& recorder, const votess::vulkan::Frame& frame, std::uint32_t count,
                       const GradientArrays& arrays) const {
    const DeviceSeeds& seeds = PlanAccess::seeds(frame);
    const votess::vulkan::PlanOptions& options = plan_.options();
    const bool wide = options.format == votess::vulkan::SeedFormat::float64;
    GradientPush push{};
    push.count = count;
    push.total = seeds.count();
    push.weights_at = 3 * options.max_seeds;
    push.shift = seeds.units().shift;
    push.bits = (arrays.shifts ? GRADIENT_SHIFTS : 0) | (options.weights ? GRADIENT_WEIGHTS : 0) |
                (arrays.given_volumes ? GRADIENT_OF_VOLUMES : 0) |
                (arrays.given_centroids ? GRADIENT_OF_CENTROIDS : 0) | (arrays.given_areas ? GRADIENT_OF_AREAS : 0) |
                (wide ? GRADIENT_FLOAT64 : 0);
    push.walls = static_cast<std::uint32_t>(seeds.walls());
    if (push.walls != 0) push.bits |= GRADIENT_OBLIQUE;
    for (std::uint32_t k = 0; k < 3; ++k) {
        push.extent[k] = words(seeds.extent()[k]);
        if (options.cell || options.periodic[k] || (push.bits & GRADIENT_OBLIQUE) != 0) continue;
        push.bits |= k << (GRADIENT_AXES_SHIFT + push.walls);
        push.walls += 2;
    }
    std::ranges::copy(seeds.vectors(), push.vector);

    Bindings bindings;
    const auto bind = [&](std::uint32_t binding, const Slice& array) {  // the gradient in place of those that are empty
        bindings.set(binding, array ? array : arrays.gradient);
    };
    bind(BINDING_RAW, arrays.points);
    bind(BINDING_PART_INFO, arrays.status);
    bind(BINDING_GEOMETRY, arrays.volumes);
    bind(BINDING_PART_GEOMETRY, arrays.centroids);
    bind(BINDING_GIVEN_VOLUMES, arrays.given_volumes);
    bind(BINDING_GIVEN_CENTROIDS, arrays.given_centroids);
    bind(BINDING_GIVEN_AREAS, arrays.given_areas);
    bind(BINDING_SLOPES, arrays.slopes);
    bind(BINDING_GRADIENT, arrays.gradient);
    bind(BINDING_PART_OFFSETS, arrays.indptr);
    bind(BINDING_SLICE_ROWS, arrays.indices);
    bind(BINDING_SLICE_SHIFTS, arrays.shifts);
    for (const std::uint32_t binding : {BINDING_POINTS, BINDING_RUN_STATE})
        bindings.set(binding, seeds.bindings().get(binding));
    recorder.run(passes_.cells, bindings, push, count);
    recorder.run(passes_.faces, bindings, push, std::uint64_t{count} * GRADIENT_LANES);
}

}  // namespace votess::gpu
