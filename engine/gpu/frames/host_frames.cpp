#include "gpu/frames/host_frames.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <string>
#include <utility>

#include "core/progress.hpp"
#include "gpu/frames/frame.hpp"
#include "gpu/frames/gather_rows.hpp"
#include "shared/gradient.h"

namespace votess::gpu {

HostFrames::HostFrames(std::shared_ptr<vulkan::Device> device, const votess::vulkan::PlanOptions& options,
                       const Want& want, unsigned threads, bool gradients)
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
    if (gradients) gradients_.emplace(plan_);
}

void HostFrames::begin(std::size_t count, bool narrow) {
    fresh_ = !has_run_;
    has_run_ = false;
    commands_.wait();  // for a run that was cancelled
    count_ = count;
    more_ = {};
    narrow_ = narrow;
}

void HostFrames::submit() {
    constexpr std::chrono::milliseconds interval{20};
    seeds_.flush();
    weights_.flush();
    commands_.submit([&] {
        buffers_->frame().record(commands_.handle(), {.count = static_cast<std::uint32_t>(count_), .fresh = fresh_});
        buffers_->record_copies(commands_);
        commands_.barrier_to_host();
    });
    while (!commands_.wait_for(interval)) check_stop();
    buffers_->invalidate();
    device_->instance().check_messages();
    has_run_ = true;
}

detail::FrameRows HostFrames::gather() {
    return gather_rows(buffers_->seen(seeds_.as<double>(), count_), more_, want_, narrow_, pool_);
}

detail::FrameRows HostFrames::resolve() {
    const std::span<const double> seeds = seeds_.as<double>(), weights = weights_.as<double>();
    more_ = plan_.resolve(seeds, weights, buffers_->seen(seeds, count_).cells,
                          {.box = {}, .cell = {}, .threads = pool_.requested()});
    return gather();
}

void HostFrames::vjp(const detail::FrameVectors& given, double* by_points, double* by_weights) {
    const detail::FrameRows rows = gather();  // again: the caller may have changed its arrays
    if (rows.unresolved != 0)
        throw Error(ErrorCode::invalid_use, std::to_string(rows.unresolved) +
                                                " cells are unresolved, and gradients need all: resolve() them first");
    if (count_ == 0) return;
    std::vector<vulkan::Buffer> buffers;
    commands_.begin();
    const auto upload = [&](const auto& array, const char* name) -> Slice {
        const std::span<const std::byte> bytes = std::as_bytes(std::span(array.data(), array.size()));
        if (bytes.empty()) return {};
        const vulkan::Buffer& stage =
            buffers.emplace_back(memory_.buffer(bytes.size(), vulkan::MemoryKind::upload, "staging"));
        std::ranges::copy(bytes, stage.mapped().begin());
        stage.flush();
        const Slice from = stage;
        const Slice to = buffers.emplace_back(memory_.buffer(bytes.size(), vulkan::MemoryKind::device, name));
        commands_.copy(from, 0, to, 0, bytes.size());
        return to;
    };
    const auto vector = [&](const auto* numbers, std::size_t size) {
        return upload(std::span(numbers, numbers == nullptr ? 0 : size), "vectors");
    };
    const std::vector<double> widened(rows.centroids32.begin(), rows.centroids32.end());
    const vulkan::Buffer slopes = memory_.buffer(count_ * Gradients::slope_bytes, vulkan::MemoryKind::device, "slopes");
    const std::size_t capacity = plan_.options().max_seeds;
    const vulkan::Buffer gradient =
        memory_.buffer(4 * capacity * sizeof(double), vulkan::MemoryKind::download, "gradient");
    const GradientArrays arrays{
        .points = seeds_,
        .status = upload(rows.status, "status"),
        .indptr = upload(rows.indptr, "indptr"),
        .indices = upload(rows.indices, "indices"),
        .shifts = upload(padded_shifts(rows), "shifts"),
        .volumes = upload(rows.volumes, "volumes"),
        .centroids = narrow_ ? upload(widened, "centroids") : upload(rows.centroids64, "centroids"),
        .given_volumes = vector(given.volumes, count_),
        .given_centroids = vector(given.centroids, 3 * count_),
        .given_areas = vector(given.face_areas, rows.indices.size()),
        .slopes = slopes,
        .gradient = gradient};
    commands_.barrier();
    gradients_->record(commands_, buffers_->frame(), static_cast<std::uint32_t>(count_), arrays);
    commands_.barrier_to_host();
    commands_.end();
    commands_.submit();
    commands_.wait();  // the buffers last until then
    device_->instance().check_messages();
    gradient.invalidate();
    const std::span<const double> found = gradient.as<double>();
    const auto is_unknown = [](double number) {
        return std::bit_cast<std::uint64_t>(number) == std::uint64_t{GRADIENT_UNKNOWN} << 32;
    };
    const auto unknown = std::ranges::find_if(found.first(3 * count_), is_unknown) - found.begin();
    if (static_cast<std::size_t>(unknown) < 3 * count_) {
        const auto point = static_cast<std::size_t>(unknown) / 3;
        throw Error(ErrorCode::unsupported,
                    "the driver of " + device_->adapter().name + " ended the loops for point " + std::to_string(point) +
                        " early, whose cell has " + std::to_string(rows.indptr[point + 1] - rows.indptr[point]) +
                        " entries in its row: no gradient on this device, use tessellate() and its derivatives");
    }
    std::ranges::copy(found.first(3 * count_), by_points);
    std::ranges::copy(found.subspan(3 * capacity, count_), by_weights);
}

}  // namespace votess::gpu
