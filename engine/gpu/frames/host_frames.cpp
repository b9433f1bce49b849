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
    // The device reads them once, and the host reads them again.
    const auto input = [&](VkDeviceSize bytes, const char* name) {
        return bytes > 0 ? memory_.buffer(bytes, vulkan::MemoryKind::download, name) : vulkan::Buffer();
    };
    seeds_ = input(plan_.sizes().seeds, "seeds");
    weights_ = input(plan_.sizes().weights, "weights");
    buffers_.emplace(memory_, plan_, votess::vulkan::BufferRange{seeds_.handle()},
                     votess::vulkan::BufferRange{weights_.handle()});
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
    weights_.flush();
    commands_.begin();
    buffers_->frame().record(commands_.handle(), {.count = static_cast<std::uint32_t>(count_)});
    buffers_->record_copies(commands_);
    commands_.barrier_to_host();
    commands_.end();
    commands_.submit();
    while (!commands_.wait_for(interval)) check_stop();
    buffers_->invalidate();
    device_->instance().check_messages();
    has_run_ = true;
}

detail::FrameRows HostFrames::gather(const votess::vulkan::Resolved& more) {
    return gather_rows(buffers_->seen(seeds_.as<double>(), count_), more, want_, narrow_, pool_);
}

detail::FrameRows HostFrames::resolve() {
    const std::span<const double> seeds = seeds_.as<double>(), weights = weights_.as<double>();
    return gather(plan_.resolve(seeds, weights, buffers_->seen(seeds, count_).cells,
                                {.box = {}, .cell = {}, .threads = pool_.requested()}));
}

}  // namespace votess::gpu
