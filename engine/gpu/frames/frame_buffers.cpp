#include "gpu/frames/frame_buffers.hpp"

namespace votess::gpu {

FrameBuffers::FrameBuffers(vulkan::Memory& memory, const votess::vulkan::Plan& plan,
                           const votess::vulkan::BufferRange& seeds, const votess::vulkan::BufferRange& weights)
    : workspace_(memory.buffer(plan.sizes().workspace, vulkan::MemoryKind::device, "workspace")) {
    const votess::vulkan::BufferSizes& sizes = plan.sizes();
    const auto make = [&](Array array, VkDeviceSize bytes, const char* name) -> votess::vulkan::BufferRange {
        auto& [written, copy] = made_[array];
        if (bytes == 0) return {};
        written = memory.buffer(bytes, vulkan::MemoryKind::device, name);
        if (written.mapped().empty()) copy = memory.buffer(bytes, vulkan::MemoryKind::download, name);
        return {written.handle()};
    };
    if (sizes.kept > 0) kept_ = memory.buffer(sizes.kept, vulkan::MemoryKind::device, "kept");
    frame_ = plan.frame({.seeds = seeds,
                         .workspace = {workspace_.handle()},
                         .header = make(header, sizes.header, "header"),
                         .cells = make(cells, sizes.cells, "cells"),
                         .indices = make(indices, sizes.indices, "indices"),
                         .geometry = make(geometry, sizes.geometry, "geometry"),
                         .areas = make(areas, sizes.areas, "areas"),
                         .shifts = make(shifts, sizes.shifts, "shifts"),
                         .weights = weights,
                         .kept = {kept_.handle()}});
}

void FrameBuffers::record_copies(vulkan::Commands& commands) const {
    for (const Made& array : made_)
        if (array.copy) commands.copy(array.written, 0, array.copy, 0, array.copy.size());
}

void FrameBuffers::invalidate() const {
    for (const Made& array : made_) array.seen().invalidate();
}

FrameArrays FrameBuffers::seen(std::span<const double> seeds, std::size_t count) const {
    const auto array = [&](Array of) -> const vulkan::Buffer& { return made_[of].seen(); };
    return {.seeds = seeds,
            .cells = array(cells).as<votess::vulkan::Cell>().first(count),
            .indices = array(indices).as<std::int32_t>(),
            .geometry = array(geometry).as<float>(),
            .areas = array(areas).as<float>(),
            .shifts = array(shifts).as<std::int8_t>(),
            .kept = array(header).as<votess::vulkan::Header>().front().kept};
}

}  // namespace votess::gpu
