#include "gpu/frames/exported_frames.hpp"

#include <algorithm>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "gpu/frames/frame.hpp"
#include "gpu/frames/gather_rows.hpp"
#include "shaders.hpp"
#include "shared/order.h"

namespace votess::gpu {
namespace {

using vulkan::check;

constexpr VkExternalMemoryHandleTypeFlagBits memory_type_of_handle = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
constexpr VkExternalSemaphoreHandleTypeFlagBits semaphore_type_of_handle =
    VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT;

[[noreturn]] void lacks(const std::string& device, const std::string& what) {
    throw Error(ErrorCode::unsupported, device + " cannot share memory with another API: it lacks " + what +
                                            ". Use frames of points in the host's memory");
}

std::string text_of(const Uuid& uuid) {
    constexpr char digits[] = "0123456789abcdef";
    std::string text;
    for (std::size_t i = 0; i < uuid.size(); ++i) {
        if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
        text += {digits[uuid[i] >> 4], digits[uuid[i] & 15]};
    }
    return text;
}

// Returns the device with this UUID, which exports memory, and semaphores where it can.
std::shared_ptr<vulkan::Device> exporting_device(const Uuid& uuid) {
    const auto instance = vulkan::Instance::create();
    const std::vector<vulkan::Adapter> adapters = instance->adapters();
    const auto found = std::ranges::find(adapters, uuid, &vulkan::Adapter::uuid);
    if (found == adapters.end()) {
        std::string others;
        for (const vulkan::Adapter& adapter : adapters)
            others += (others.empty() ? "there is " : ", ") + adapter.name + " " + text_of(adapter.uuid);
        throw Error(ErrorCode::unsupported, "no Vulkan device has the UUID " + text_of(uuid) + ": " +
                                                (others.empty() ? "there is none" : others) +
                                                "; install the Vulkan driver of the device");
    }
    if (!found->missing().empty()) lacks(found->name, "what votess requires: it " + found->missing());
    if (found->api_version < VK_API_VERSION_1_2) lacks(found->name, "Vulkan 1.2, use a newer driver");
    if (!found->exports_memory) lacks(found->name, VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME);
    return vulkan::Device::create(instance, *found, {.exports = true});
}

}  // namespace

ExportedFrames::Shared::~Shared() {
    const VolkDeviceTable& table = device.table();
    table.vkDestroySemaphore(device.handle(), semaphore, nullptr);
    table.vkDestroyBuffer(device.handle(), buffer, nullptr);
    table.vkFreeMemory(device.handle(), memory, nullptr);
}

ExportedFrames::ExportedFrames(const Uuid& uuid, const votess::vulkan::PlanOptions& options, const Want& want,
                               unsigned threads, bool gradients)
    : device_(exporting_device(uuid)),
      plan_(votess::vulkan::detail::PlanAccess::plan(device_, options)),
      want_(want),
      pool_(threads),
      shared_{*device_},
      memory_(*device_),
      scratch_(memory_) {
    if (gradients) gradients_.emplace(plan_);
    make_shared();
    const auto in = [this](std::uint64_t place) {
        return votess::vulkan::BufferRange{shared_.buffer, place == detail::ExportedArrays::none ? 0 : place};
    };
    buffers_.emplace(memory_, plan_, in(arrays_.points), in(arrays_.weights));
    make_passes();
    if (gradients) slopes_ = scratch_.take(options.max_seeds * Gradients::slope_bytes, "slopes");
    for (auto& flight : flights_) flight = std::make_unique<vulkan::Commands>(*device_);
}

ExportedFrames::~ExportedFrames() {
    device_->drain();
}

// Makes the exported buffer, in memory of its own, and the semaphore.
void ExportedFrames::make_shared() {
    vulkan::Device& device = *device_;
    const VolkDeviceTable& table = device.table();
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    const VkDeviceSize n = plan_.options().max_seeds;
    const VkDeviceSize alignment = std::max<VkDeviceSize>(device.adapter().limits.minStorageBufferOffsetAlignment, 256);
    VkDeviceSize end = 0;
    const auto place = [&](std::uint64_t& at, VkDeviceSize bytes) {
        if (bytes == 0) return;
        if (bytes > device.adapter().limits.maxStorageBufferRange)
            throw Error(ErrorCode::unsupported, "an array of " + vulkan::bytes_text(bytes) + " is more than the " +
                                                    vulkan::bytes_text(device.adapter().limits.maxStorageBufferRange) +
                                                    " that shaders of " + device.adapter().name +
                                                    " can bind at once: lower max_points or max_entries");
        at = end;
        end += round_up(bytes, alignment);
    };
    const VkDeviceSize number = plan_.options().format == votess::vulkan::SeedFormat::float32 ? 4 : 8;
    arrays_.max_entries = sizes.indices / 4;
    place(arrays_.points, sizes.seeds);
    place(arrays_.weights, sizes.weights);
    place(arrays_.status, 4 * n);
    place(arrays_.indptr, want_.neighbors ? 4 * (n + 1) : 0);
    place(arrays_.indices, sizes.indices);
    place(arrays_.shifts, sizes.shifts);
    place(arrays_.face_areas, sizes.areas);
    place(arrays_.volumes, want_.volumes ? 4 * n : 0);
    place(arrays_.centroids, want_.centroids ? 3 * number * n : 0);
    if (gradients_) {
        place(arrays_.given_volumes, want_.volumes ? 4 * n : 0);
        place(arrays_.given_centroids, want_.centroids ? 3 * number * n : 0);
        place(arrays_.given_face_areas, sizes.areas);
        place(arrays_.by_points, 4 * number * n);
        arrays_.by_weights = arrays_.by_points + 3 * number * n;
    }

    auto external =
        vulkan::structure<VkExternalMemoryBufferCreateInfo>(VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO);
    external.handleTypes = memory_type_of_handle;
    auto buffer = vulkan::structure<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
    buffer.pNext = &external;
    buffer.size = end;
    buffer.usage = votess::vulkan::buffer_usage;
    check(table.vkCreateBuffer(device.handle(), &buffer, nullptr, &shared_.buffer), "vkCreateBuffer");
    VkMemoryRequirements needs{};
    table.vkGetBufferMemoryRequirements(device.handle(), shared_.buffer, &needs);
    const VkPhysicalDeviceMemoryProperties& memory = device.adapter().memory;
    std::uint32_t type = 0;
    while (type < memory.memoryTypeCount &&
           ((needs.memoryTypeBits >> type & 1) == 0 ||
            (memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) == 0))
        ++type;
    if (type == memory.memoryTypeCount) lacks(device.adapter().name, "a type of memory for it");
    auto dedicated = vulkan::structure<VkMemoryDedicatedAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_DEDICATED_ALLOCATE_INFO);
    dedicated.buffer = shared_.buffer;
    auto exportable = vulkan::structure<VkExportMemoryAllocateInfo>(VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO);
    exportable.pNext = &dedicated;
    exportable.handleTypes = memory_type_of_handle;
    auto allocate = vulkan::structure<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
    allocate.pNext = &exportable;
    allocate.allocationSize = arrays_.memory_bytes = needs.size;
    allocate.memoryTypeIndex = type;
    check(table.vkAllocateMemory(device.handle(), &allocate, nullptr, &shared_.memory), "vkAllocateMemory");
    check(table.vkBindBufferMemory(device.handle(), shared_.buffer, shared_.memory, 0), "vkBindBufferMemory");

    auto exported = vulkan::structure<VkExportSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_EXPORT_SEMAPHORE_CREATE_INFO);
    exported.handleTypes = semaphore_type_of_handle;
    auto timeline = vulkan::structure<VkSemaphoreTypeCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO);
    timeline.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    if (device_->adapter().exports_semaphores) timeline.pNext = &exported;
    auto semaphore = vulkan::structure<VkSemaphoreCreateInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO);
    semaphore.pNext = &timeline;
    check(table.vkCreateSemaphore(device.handle(), &semaphore, nullptr, &shared_.semaphore), "vkCreateSemaphore");
}

void ExportedFrames::make_passes() {
    vulkan::Device& device = *device_;
    const bool wide = plan_.options().format == votess::vulkan::SeedFormat::float64;
    if (wide && want_.centroids && !device.adapter().float64)
        throw Error(ErrorCode::unsupported, device.adapter().name +
                                                " has no float64, which centroids of float64 points need: give float32 "
                                                "points");
    const std::span<const std::uint32_t> cells = wide ? shaders::order_cells_f64 : shaders::order_cells_f32;
    vulkan::PassBatch batch(device);
    passes_.push_back(batch.get({.name = "order_cells", .spirv = cells, .push_bytes = sizeof(OrderPush)}));
    passes_.push_back(batch.get({.name = "order_rows", .spirv = shaders::order_rows, .push_bytes = sizeof(OrderPush)}));
    batch.make();
    if (want_.neighbors) scan_.reserve(scratch_, plan_.options().max_seeds + 1);
}

detail::ExportedArrays ExportedFrames::arrays() {
    const VolkDeviceTable& table = device_->table();
    detail::ExportedArrays found = arrays_;
    auto memory = vulkan::structure<VkMemoryGetFdInfoKHR>(VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR);
    memory.memory = shared_.memory;
    memory.handleType = memory_type_of_handle;
    check(table.vkGetMemoryFdKHR(device_->handle(), &memory, &found.memory_descriptor), "vkGetMemoryFdKHR");
    if (!device_->adapter().exports_semaphores) return found;
    auto semaphore = vulkan::structure<VkSemaphoreGetFdInfoKHR>(VK_STRUCTURE_TYPE_SEMAPHORE_GET_FD_INFO_KHR);
    semaphore.semaphore = shared_.semaphore;
    semaphore.handleType = semaphore_type_of_handle;
    check(table.vkGetSemaphoreFdKHR(device_->handle(), &semaphore, &found.semaphore_descriptor), "vkGetSemaphoreFdKHR");
    return found;
}

// Takes the exported buffer over from the other API, or gives it back.
void ExportedFrames::take(vulkan::Commands& commands, bool here) const {
    vulkan::Device& device = *device_;
    const std::uint32_t family = device.adapter().queue_family;
    auto barrier = vulkan::structure<VkBufferMemoryBarrier>(VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER);
    (here ? barrier.dstAccessMask : barrier.srcAccessMask) = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.srcQueueFamilyIndex = here ? VK_QUEUE_FAMILY_EXTERNAL : family;
    barrier.dstQueueFamilyIndex = here ? family : VK_QUEUE_FAMILY_EXTERNAL;
    barrier.buffer = shared_.buffer;
    barrier.size = VK_WHOLE_SIZE;
    constexpr VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    device.table().vkCmdPipelineBarrier(commands.handle(), all, all, 0, 0, nullptr, 1, &barrier, 0, nullptr);
}

void ExportedFrames::record_order(vulkan::Commands& commands, std::uint32_t count) const {
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    const VkDeviceSize n = plan_.options().max_seeds;
    Bindings bindings;
    // Passes bind the cells in place of arrays that are not requested.
    const auto bind = [&](std::uint32_t binding, const Slice& array) {
        bindings.set(binding, array ? array : Slice((*buffers_)[FrameBuffers::cells]));
    };
    const auto out = [&](std::uint32_t binding, std::uint64_t place, VkDeviceSize bytes) {
        bind(binding, place == detail::ExportedArrays::none ? Slice{} : exported(place, bytes));
    };
    const VkDeviceSize number = plan_.options().format == votess::vulkan::SeedFormat::float32 ? 4 : 8;
    out(BINDING_RAW, arrays_.points, sizes.seeds);
    bind(BINDING_CELLS, (*buffers_)[FrameBuffers::cells]);
    bind(BINDING_GEOMETRY_OUT, (*buffers_)[FrameBuffers::geometry]);
    out(BINDING_PART_INFO, arrays_.status, 4 * n);
    out(BINDING_PART_OFFSETS, arrays_.indptr, 4 * (n + 1));
    out(BINDING_GEOMETRY, arrays_.volumes, 4 * n);
    out(BINDING_PART_GEOMETRY, arrays_.centroids, 3 * number * n);
    bind(BINDING_ROWS_OUT, (*buffers_)[FrameBuffers::indices]);
    bind(BINDING_AREAS_OUT, (*buffers_)[FrameBuffers::areas]);
    bind(BINDING_SHIFTS_OUT, (*buffers_)[FrameBuffers::shifts]);
    out(BINDING_SLICE_ROWS, arrays_.indices, sizes.indices);
    out(BINDING_SLICE_AREAS, arrays_.face_areas, sizes.areas);
    out(BINDING_SLICE_SHIFTS, arrays_.shifts, sizes.shifts);
    const OrderPush push{count,
                         want_.neighbors ? 1u : 0u,
                         want_.volumes ? 1u : 0u,
                         want_.centroids ? 1u : 0u,
                         sizes.areas > 0 ? 1u : 0u,
                         sizes.shifts > 0 ? 1u : 0u};
    commands.run(passes_[0], bindings, push, count + std::uint64_t{1});
    if (!want_.neighbors) return;
    scan_.record(commands, votess::vulkan::detail::PlanAccess::passes(plan_), exported(arrays_.indptr, 4 * (n + 1)),
                 count + 1);
    commands.run(passes_[1], bindings, push, count);
}

// Submits a batch without commands. Later submissions begin when the semaphore has the first value. It gets the second
// value after all earlier ones. 0: none.
void ExportedFrames::batch(std::uint64_t wait_value, std::uint64_t signal_value) {
    auto values = vulkan::structure<VkTimelineSemaphoreSubmitInfo>(VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO);
    auto info = vulkan::structure<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
    info.pNext = &values;
    constexpr VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    if (wait_value != 0) {
        info.waitSemaphoreCount = values.waitSemaphoreValueCount = 1;
        values.pWaitSemaphoreValues = &wait_value;
        info.pWaitSemaphores = &shared_.semaphore;
        info.pWaitDstStageMask = &all;
    }
    if (signal_value != 0) {
        info.signalSemaphoreCount = values.signalSemaphoreValueCount = 1;
        values.pSignalSemaphoreValues = &signal_value;
        info.pSignalSemaphores = &shared_.semaphore;
    }
    device_->submit(info, VK_NULL_HANDLE);
}

void ExportedFrames::submit(std::uint32_t count, std::uint64_t after, std::uint64_t done) {
    const bool fresh = !std::exchange(has_run_, false);
    submit_recorded(after, done, [&](vulkan::Commands& commands) {
        buffers_->frame().record(commands.handle(), {.count = count, .fresh = fresh});
        record_order(commands, count);
    });
    count_ = count;
    has_run_ = true;
}

template <class Record>
void ExportedFrames::submit_recorded(std::uint64_t after, std::uint64_t done, const Record& record) {
    vulkan::Commands& commands = *flights_[next_flight_];
    next_flight_ = 1 - next_flight_;
    commands.begin();
    take(commands, true);
    record(commands);
    take(commands, false);
    commands.end();
    batch(after, 0);
    commands.submit();
    batch(0, done);
    device_->instance().check_messages();
}

void ExportedFrames::submit_vjp(const Want& given, std::uint64_t after, std::uint64_t done) {
    if (!has_run_)
        throw Error(ErrorCode::invalid_use, "gradients are those of the last frame, and there is none: run one first");
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    const VkDeviceSize n = plan_.options().max_seeds;
    const VkDeviceSize number = plan_.options().format == votess::vulkan::SeedFormat::float32 ? 4 : 8;
    const auto in = [&](std::uint64_t place, VkDeviceSize bytes) {
        return place == detail::ExportedArrays::none ? Slice{} : exported(place, bytes);
    };
    const auto vector = [&](bool is_given, std::uint64_t place, VkDeviceSize bytes, const char* name) {
        if (is_given && place == detail::ExportedArrays::none)
            throw Error(ErrorCode::invalid_argument, std::string("vectors for ") + name +
                                                         " are given, but these frames do not make them: put " + name +
                                                         " into want");
        return is_given ? exported(place, bytes) : Slice{};
    };
    const GradientArrays arrays{
        .points = in(arrays_.points, sizes.seeds),
        .status = in(arrays_.status, 4 * n),
        .indptr = in(arrays_.indptr, 4 * (n + 1)),
        .indices = in(arrays_.indices, sizes.indices),
        .shifts = in(arrays_.shifts, sizes.shifts),
        .volumes = in(arrays_.volumes, 4 * n),
        .centroids = in(arrays_.centroids, 3 * number * n),
        .given_volumes = vector(given.volumes, arrays_.given_volumes, 4 * n, "volumes"),
        .given_centroids = vector(given.centroids, arrays_.given_centroids, 3 * number * n, "centroids"),
        .given_areas = vector(given.areas, arrays_.given_face_areas, sizes.areas, "areas"),
        .slopes = slopes_,
        .gradient = exported(arrays_.by_points, 4 * number * n)};
    if (given.centroids && !want_.volumes)
        throw Error(ErrorCode::invalid_argument, "gradients by centroids need volumes too: put volumes into want");
    submit_recorded(after, done, [&](vulkan::Commands& commands) {
        gradients_->record(commands, buffers_->frame(), count_, arrays);
    });
}

void ExportedFrames::signal(std::uint64_t value) {
    auto info = vulkan::structure<VkSemaphoreSignalInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO);
    info.semaphore = shared_.semaphore;
    info.value = value;
    vulkan::Device& device = *device_;
    check(device.table().vkSignalSemaphore(device.handle(), &info), "vkSignalSemaphore");
}

void ExportedFrames::wait(std::uint64_t value) {
    constexpr std::uint64_t interval = 20'000'000;  // nanoseconds
    auto info = vulkan::structure<VkSemaphoreWaitInfo>(VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO);
    info.semaphoreCount = 1;
    info.pSemaphores = &shared_.semaphore;
    info.pValues = &value;
    vulkan::Device& device = *device_;
    for (VkResult result = VK_TIMEOUT; result == VK_TIMEOUT;) {
        check_stop();
        result = device.table().vkWaitSemaphores(device.handle(), &info, interval);
        check(result, "vkWaitSemaphores");
    }
}

void ExportedFrames::run_now(vulkan::Commands& commands) {
    commands.end();
    commands.submit();
    commands.wait();
    device_->instance().check_messages();
}

template <class Real>
std::size_t ExportedFrames::resolve_as() {
    vulkan::Commands& commands = *flights_[next_flight_];
    for (auto& flight : flights_) flight->wait();
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    // Down: the points, and outputs that the host does not see.
    const vulkan::Buffer points = memory_.buffer(sizes.seeds, vulkan::MemoryKind::download, "points");
    vulkan::Buffer weights;
    if (sizes.weights > 0) weights = memory_.buffer(sizes.weights, vulkan::MemoryKind::download, "weights");
    commands.begin();
    take(commands, true);
    commands.copy(exported(arrays_.points, sizes.seeds), 0, points, 0, sizes.seeds);
    if (weights) commands.copy(exported(arrays_.weights, sizes.weights), 0, weights, 0, sizes.weights);
    buffers_->record_copies(commands);
    take(commands, false);
    commands.barrier_to_host();
    run_now(commands);
    points.invalidate();
    weights.invalidate();
    buffers_->invalidate();

    const std::span<const Real> given = points.as<Real>(), masses = weights.as<Real>();
    const auto more = plan_.resolve(given, masses, buffers_->seen({}, count_).cells,
                                    {.box = {}, .cell = {}, .threads = pool_.requested()});
    if (more.cells.empty()) return 0;
    const std::vector<double> seeds(given.begin(),
                                    given.begin() + static_cast<std::ptrdiff_t>(3 * std::size_t{count_}));
    constexpr bool narrow = sizeof(Real) == sizeof(float);
    const detail::FrameRows rows = gather_rows(buffers_->seen(seeds, count_), more, want_, narrow, pool_);
    const std::size_t entries = rows.indices.size();
    if (want_.neighbors && entries > sizes.indices / 4)
        throw Error(ErrorCode::unsupported, "the rows of all cells have " + std::to_string(entries) +
                                                " entries, more than max_entries = " +
                                                std::to_string(sizes.indices / 4) + ": make frames with more");
    // Up again.
    std::vector<vulkan::Buffer> staged;
    commands.begin();
    take(commands, true);
    const auto upload = [&](std::uint64_t place, const auto& array) {
        const std::span<const std::byte> bytes = std::as_bytes(std::span(array.data(), array.size()));
        if (place == detail::ExportedArrays::none || bytes.empty()) return;
        const vulkan::Buffer& stage =
            staged.emplace_back(memory_.buffer(bytes.size(), vulkan::MemoryKind::upload, "staging"));
        std::ranges::copy(bytes, stage.mapped().begin());
        stage.flush();
        commands.copy(stage, 0, exported(place, bytes.size()), 0, bytes.size());
    };
    upload(arrays_.status, rows.status);
    upload(arrays_.indptr, rows.indptr);
    upload(arrays_.indices, rows.indices);
    upload(arrays_.shifts, padded_shifts(rows));
    upload(arrays_.face_areas, rows.face_areas);
    upload(arrays_.volumes, rows.volumes);
    upload(arrays_.centroids, rows.centroids32);
    upload(arrays_.centroids, rows.centroids64);
    take(commands, false);
    run_now(commands);
    return more.cells.size();
}

std::size_t ExportedFrames::resolve() {
    if (!has_run_)
        throw Error(ErrorCode::invalid_use, "resolve() completes the last frame, and there is none: run one first");
    if (count_ == 0) return 0;
    return plan_.options().format == votess::vulkan::SeedFormat::float32 ? resolve_as<float>() : resolve_as<double>();
}

}  // namespace votess::gpu
