#include "gpu/frames/host_frames.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "core/progress.hpp"
#include "gpu/frames/frame.hpp"
#include "gpu/frames/gather_rows.hpp"

namespace votess::gpu {
HostFrames::HostFrames(std::shared_ptr<vulkan::Device> device, const votess::vulkan::PlanOptions& options,
                       const Want& want, unsigned threads)
    : device_(std::move(device)),
      plan_(votess::vulkan::detail::PlanAccess::plan(device_, options)),
      want_(want),
      pool_(threads),
      memory_(*device_),
      commands_(*device_) {
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    // The device reads them once, and the host reads them again.
    seeds_ = memory_.buffer(sizes.seeds, vulkan::MemoryKind::download, "seeds");
    if (sizes.weights > 0) weights_ = memory_.buffer(sizes.weights, vulkan::MemoryKind::download, "weights");
    workspace_ = memory_.buffer(sizes.workspace, vulkan::MemoryKind::device, "workspace");
    header_ = output(sizes.header, "header");
    cells_ = output(sizes.cells, "cells");
    indices_ = output(sizes.indices, "indices");
    geometry_ = output(sizes.geometry, "geometry");
    areas_ = output(sizes.areas, "areas");
    shifts_ = output(sizes.shifts, "shifts");
    frame_ = plan_.frame({.seeds = {seeds_.handle()},
                          .workspace = {workspace_.handle()},
                          .header = {header_.written.handle()},
                          .cells = {cells_.written.handle()},
                          .indices = {indices_.written.handle()},
                          .geometry = {geometry_.written.handle()},
                          .areas = {areas_.written.handle()},
                          .shifts = {shifts_.written.handle()},
                          .weights = {weights_.handle()}});
}

HostFrames::Output HostFrames::output(VkDeviceSize bytes, const char* name) {
    Output made;
    if (bytes == 0) return made;
    made.written = memory_.buffer(bytes, vulkan::MemoryKind::device, name);
    if (made.written.mapped().empty()) made.copy = memory_.buffer(bytes, vulkan::MemoryKind::download, name);
    return made;
}

void HostFrames::begin(std::size_t count, bool narrow) {
    has_run_ = false;
    commands_.wait();  // for a run that was cancelled
    count_ = count;
    narrow_ = narrow;
}

void HostFrames::submit() {
    constexpr std::chrono::milliseconds interval{20};
    seeds_.flush();
    if (weights_) weights_.flush();
    const Output* const outputs[] = {&header_, &cells_, &indices_, &geometry_, &areas_, &shifts_};
    commands_.begin();
    frame_.record(commands_.handle(), {.count = static_cast<std::uint32_t>(count_)});
    for (const Output* out : outputs)
        if (out->copy) commands_.copy(out->written, 0, out->copy, 0, out->copy.size());
    commands_.barrier_to_host();
    commands_.end();
    commands_.submit();
    while (!commands_.wait_for(interval)) check_stop();
    for (const Output* out : outputs) (out->copy ? out->copy : out->written).invalidate();
    const auto messages = device_->instance().take_messages();
    if (!messages.empty())
        throw Error(ErrorCode::internal, "Vulkan validation found " + std::to_string(messages.size()) +
                                             " problems, the first: " + messages.front());
    has_run_ = true;
}

detail::FrameRows HostFrames::gather(const votess::vulkan::Resolved& more) {
    return gather_rows({.seeds = seeds_.as<double>(),
                        .cells = cells_.as<votess::vulkan::Cell>().first(count_),
                        .indices = indices_.as<std::int32_t>(),
                        .geometry = geometry_.as<float>(),
                        .areas = areas_.as<float>(),
                        .shifts = shifts_.as<std::int8_t>()},
                       more, want_, narrow_, pool_);
}

detail::FrameRows HostFrames::resolve() {
    const std::span<const double> weights = weights_.as<double>();
    return gather(plan_.resolve(seeds_.as<double>(), weights, cells_.as<votess::vulkan::Cell>().first(count_),
                                {.box = {}, .cell = {}, .threads = pool_.requested()}));
}

}  // namespace votess::gpu
