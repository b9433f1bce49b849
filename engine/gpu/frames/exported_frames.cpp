#include "gpu/frames/exported_frames.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "gpu/frames/frame.hpp"
#include "gpu/frames/gather_rows.hpp"
#include "shaders.hpp"
#include "shared/order.h"

namespace votess::gpu {
namespace {

using votess::vulkan::Cell;
using vulkan::check;
using vulkan::push_bytes;

constexpr VkExternalMemoryHandleTypeFlagBits memory_type_of_handle = VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT;
constexpr VkExternalSemaphoreHandleTypeFlagBits semaphore_type_of_handle =
    VK_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD_BIT;

[[noreturn]] void lacks(const std::string& device, const std::string& what) {
    throw Error(ErrorCode::unsupported, device + " cannot share memory with another API: it lacks " + what +
                                            ". Use frames of points in the host's memory");
}

Uuid uuid_of(const vulkan::Instance& instance, VkPhysicalDevice device) {
    VkPhysicalDeviceIDProperties id{};
    id.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ID_PROPERTIES;
    VkPhysicalDeviceProperties2 properties{};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &id;
    instance.calls().vkGetPhysicalDeviceProperties2(device, &properties);
    Uuid uuid;
    std::copy_n(id.deviceUUID, uuid.size(), uuid.begin());
    return uuid;
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

bool has_extension(const std::vector<VkExtensionProperties>& known, const char* name) {
    return std::ranges::any_of(known, [name](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

}  // namespace

ExportingDevice::ExportingDevice(const Uuid& uuid) : instance_(vulkan::Instance::create()) {
    std::string others;
    for (const vulkan::Adapter& adapter : instance_->adapters()) {
        const Uuid found = adapter.api_version < VK_API_VERSION_1_1 ? Uuid{} : uuid_of(*instance_, adapter.handle);
        if (found == uuid) {
            create(adapter);
            return;
        }
        others += (others.empty() ? "" : ", ") + adapter.name + " " + text_of(found);
    }
    throw Error(ErrorCode::unsupported, "no Vulkan device has the UUID " + text_of(uuid) + ": " +
                                            (others.empty() ? "there is none" : "there is " + others) +
                                            "; install the Vulkan driver of the device");
}

void ExportingDevice::create(const vulkan::Adapter& adapter) {
    if (!adapter.missing().empty()) lacks(adapter.name, "what votess requires: it " + adapter.missing());
    if (adapter.api_version < VK_API_VERSION_1_2) lacks(adapter.name, "Vulkan 1.2, use a newer driver");
    const vulkan::InstanceCalls& calls = instance_->calls();
    std::uint32_t count = 0;
    check(calls.vkEnumerateDeviceExtensionProperties(adapter.handle, nullptr, &count, nullptr),
          "vkEnumerateDeviceExtensionProperties");
    std::vector<VkExtensionProperties> known(count);
    check(calls.vkEnumerateDeviceExtensionProperties(adapter.handle, nullptr, &count, known.data()),
          "vkEnumerateDeviceExtensionProperties");
    std::vector<const char*> extensions{VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME};
    if (!has_extension(known, extensions[0])) lacks(adapter.name, extensions[0]);
    exports_semaphores_ = has_extension(known, VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME);
    if (exports_semaphores_) extensions.push_back(VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME);
    if (adapter.portability_subset) extensions.push_back("VK_KHR_portability_subset");
    if (adapter.subgroup_size_control && adapter.subgroup_size_extension)
        extensions.push_back(VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME);

    VkPhysicalDeviceTimelineSemaphoreFeatures timeline{};
    timeline.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES;
    timeline.timelineSemaphore = VK_TRUE;
    VkPhysicalDeviceSubgroupSizeControlFeatures sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES;
    sizes.subgroupSizeControl = sizes.computeFullSubgroups = VK_TRUE;
    if (adapter.subgroup_size_control) timeline.pNext = &sizes;
    VkPhysicalDeviceFeatures features{};
    features.shaderFloat64 = adapter.float64;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueFamilyIndex = adapter.queue_family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.pNext = &timeline;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.pEnabledFeatures = &features;
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    check(calls.vkCreateDevice(adapter.handle, &info, nullptr, &handle_), "vkCreateDevice");
    const auto get = [&](const char* name) { return calls.vkGetDeviceProcAddr(handle_, name); };
    destroy_ = reinterpret_cast<PFN_vkDestroyDevice>(get("vkDestroyDevice"));
    reinterpret_cast<PFN_vkGetDeviceQueue>(get("vkGetDeviceQueue"))(handle_, adapter.queue_family, 0, &queue_);
    try {
        device_ = vulkan::Device::adopt(
            instance_, adapter,
            {handle_, adapter.queue_family, queue_, adapter.float64, adapter.subgroup_size_control, VK_NULL_HANDLE});
    } catch (...) {
        destroy_(handle_, nullptr);
        throw;
    }
}

ExportingDevice::~ExportingDevice() {
    device_.reset();
    destroy_(handle_, nullptr);
}

ExportedFrames::ExportedFrames(const Uuid& uuid, const votess::vulkan::PlanOptions& options, const Want& want,
                               unsigned threads)
    : exporting_(uuid),
      plan_(votess::vulkan::detail::PlanAccess::plan(exporting_.device(), options)),
      want_(want),
      pool_(threads),
      memory_(*exporting_.device()),
      scratch_(memory_) {
    try {
        make_shared();
        make_frame();
        make_passes();
        for (auto& flight : flights_) flight = std::make_unique<vulkan::Commands>(*exporting_.device());
    } catch (...) {
        const VolkDeviceTable& table = exporting_.device()->table();
        const VkDevice handle = exporting_.device()->handle();
        table.vkDestroySemaphore(handle, semaphore_, nullptr);
        table.vkDestroyBuffer(handle, shared_, nullptr);
        table.vkFreeMemory(handle, shared_memory_, nullptr);
        throw;
    }
}

ExportedFrames::~ExportedFrames() {
    vulkan::Device& device = *exporting_.device();
    device.drain();
    for (auto& flight : flights_) flight.reset();
    device.table().vkDestroySemaphore(device.handle(), semaphore_, nullptr);
    device.table().vkDestroyBuffer(device.handle(), shared_, nullptr);
    device.table().vkFreeMemory(device.handle(), shared_memory_, nullptr);
}

ExportedFrames::Output ExportedFrames::output(VkDeviceSize bytes, const char* name) {
    Output made;
    if (bytes == 0) return made;
    made.written = memory_.buffer(bytes, vulkan::MemoryKind::device, name);
    if (made.written.mapped().empty()) made.copy = memory_.buffer(bytes, vulkan::MemoryKind::download, name);
    return made;
}

// Makes the exported buffer, in memory of its own, and the semaphore.
void ExportedFrames::make_shared() {
    vulkan::Device& device = *exporting_.device();
    const VolkDeviceTable& table = device.table();
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    const VkDeviceSize n = plan_.options().most_seeds;
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
    place(places_.points, sizes.seeds);
    place(places_.weights, sizes.weights);
    place(places_.status, 4 * n);
    place(places_.indptr, want_.neighbors ? 4 * (n + 1) : 0);
    place(places_.indices, sizes.indices);
    place(places_.shifts, sizes.shifts);
    place(places_.face_areas, sizes.areas);
    place(places_.volumes, want_.volumes ? 4 * n : 0);
    place(places_.centroids, want_.centroids ? 3 * number * n : 0);

    VkExternalMemoryBufferCreateInfo external{};
    external.sType = VK_STRUCTURE_TYPE_EXTERNAL_MEMORY_BUFFER_CREATE_INFO;
    external.handleTypes = memory_type_of_handle;
    VkBufferCreateInfo buffer{};
    buffer.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    buffer.pNext = &external;
    buffer.size = end;
    buffer.usage = votess::vulkan::buffer_usage;
    check(table.vkCreateBuffer(device.handle(), &buffer, nullptr, &shared_), "vkCreateBuffer");
    VkMemoryRequirements needs{};
    table.vkGetBufferMemoryRequirements(device.handle(), shared_, &needs);
    const VkPhysicalDeviceMemoryProperties& memory = device.adapter().memory;
    std::uint32_t type = 0;
    while (type < memory.memoryTypeCount &&
           ((needs.memoryTypeBits >> type & 1) == 0 ||
            (memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) == 0))
        ++type;
    if (type == memory.memoryTypeCount) lacks(device.adapter().name, "a type of memory for it");
    VkMemoryDedicatedAllocateInfo dedicated{};
    dedicated.sType = VK_STRUCTURE_TYPE_MEMORY_DEDICATED_ALLOCATE_INFO;
    dedicated.buffer = shared_;
    VkExportMemoryAllocateInfo exportable{};
    exportable.sType = VK_STRUCTURE_TYPE_EXPORT_MEMORY_ALLOCATE_INFO;
    exportable.pNext = &dedicated;
    exportable.handleTypes = memory_type_of_handle;
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.pNext = &exportable;
    allocate.allocationSize = memory_bytes_ = needs.size;
    allocate.memoryTypeIndex = type;
    check(table.vkAllocateMemory(device.handle(), &allocate, nullptr, &shared_memory_), "vkAllocateMemory");
    check(table.vkBindBufferMemory(device.handle(), shared_, shared_memory_, 0), "vkBindBufferMemory");

    VkExportSemaphoreCreateInfo exported{};
    exported.sType = VK_STRUCTURE_TYPE_EXPORT_SEMAPHORE_CREATE_INFO;
    exported.handleTypes = semaphore_type_of_handle;
    VkSemaphoreTypeCreateInfo timeline{};
    timeline.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
    timeline.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    if (exporting_.exports_semaphores()) timeline.pNext = &exported;
    VkSemaphoreCreateInfo semaphore{};
    semaphore.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
    semaphore.pNext = &timeline;
    check(table.vkCreateSemaphore(device.handle(), &semaphore, nullptr, &semaphore_), "vkCreateSemaphore");
}

void ExportedFrames::make_frame() {
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    workspace_ = memory_.buffer(sizes.workspace, vulkan::MemoryKind::device, "workspace");
    header_ = output(sizes.header, "header");
    cells_ = output(sizes.cells, "cells");
    indices_ = output(sizes.indices, "indices");
    geometry_ = output(sizes.geometry, "geometry");
    areas_ = output(sizes.areas, "areas");
    shifts_ = output(sizes.shifts, "shifts");
    const auto in = [this](std::uint64_t place) {
        return votess::vulkan::BufferRange{shared_, place == none ? 0 : place};
    };
    frame_ = plan_.frame({.seeds = in(places_.points),
                          .workspace = {workspace_.handle()},
                          .header = {header_.written.handle()},
                          .cells = {cells_.written.handle()},
                          .indices = {indices_.written.handle()},
                          .geometry = {geometry_.written.handle()},
                          .areas = {areas_.written.handle()},
                          .shifts = {shifts_.written.handle()},
                          .weights = in(places_.weights)});
}

void ExportedFrames::make_passes() {
    vulkan::Device& device = *exporting_.device();
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
    if (want_.neighbors) scan_.reserve(scratch_, plan_.options().most_seeds + 1);
}

int ExportedFrames::memory_descriptor() {
    vulkan::Device& device = *exporting_.device();
    VkMemoryGetFdInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_MEMORY_GET_FD_INFO_KHR;
    info.memory = shared_memory_;
    info.handleType = memory_type_of_handle;
    int descriptor = -1;
    check(device.table().vkGetMemoryFdKHR(device.handle(), &info, &descriptor), "vkGetMemoryFdKHR");
    return descriptor;
}

int ExportedFrames::semaphore_descriptor() {
    if (!exporting_.exports_semaphores()) return -1;
    vulkan::Device& device = *exporting_.device();
    VkSemaphoreGetFdInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_GET_FD_INFO_KHR;
    info.semaphore = semaphore_;
    info.handleType = semaphore_type_of_handle;
    int descriptor = -1;
    check(device.table().vkGetSemaphoreFdKHR(device.handle(), &info, &descriptor), "vkGetSemaphoreFdKHR");
    return descriptor;
}

// Takes the exported buffer over from the other API, or gives it back.
void ExportedFrames::take(vulkan::Commands& commands, bool here) const {
    vulkan::Device& device = *exporting_.device();
    const std::uint32_t family = device.adapter().queue_family;
    VkBufferMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER;
    (here ? barrier.dstAccessMask : barrier.srcAccessMask) = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.srcQueueFamilyIndex = here ? VK_QUEUE_FAMILY_EXTERNAL : family;
    barrier.dstQueueFamilyIndex = here ? family : VK_QUEUE_FAMILY_EXTERNAL;
    barrier.buffer = shared_;
    barrier.size = VK_WHOLE_SIZE;
    constexpr VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    device.table().vkCmdPipelineBarrier(commands.handle(), all, all, 0, 0, nullptr, 1, &barrier, 0, nullptr);
}

void ExportedFrames::record_order(vulkan::Commands& commands, std::uint32_t count) const {
    const votess::vulkan::BufferSizes& sizes = plan_.sizes();
    const VkDeviceSize n = plan_.options().most_seeds;
    Bindings bindings;
    // Passes bind the cells in place of arrays that are not requested.
    const auto bind = [&](std::uint32_t binding, const Slice& array) {
        bindings.set(binding, array ? array : Slice(cells_.written));
    };
    const auto out = [&](std::uint32_t binding, std::uint64_t place, VkDeviceSize bytes) {
        bind(binding, place == none ? Slice{} : exported(place, bytes));
    };
    const VkDeviceSize number = plan_.options().format == votess::vulkan::SeedFormat::float32 ? 4 : 8;
    out(BINDING_RAW, places_.points, sizes.seeds);
    bind(BINDING_CELLS, cells_.written);
    bind(BINDING_GEOMETRY_OUT, geometry_.written);
    out(BINDING_PART_INFO, places_.status, 4 * n);
    out(BINDING_PART_OFFSETS, places_.indptr, 4 * (n + 1));
    out(BINDING_GEOMETRY, places_.volumes, 4 * n);
    out(BINDING_PART_GEOMETRY, places_.centroids, 3 * number * n);
    bind(BINDING_ROWS_OUT, indices_.written);
    bind(BINDING_AREAS_OUT, areas_.written);
    bind(BINDING_SHIFTS_OUT, shifts_.written);
    out(BINDING_SLICE_ROWS, places_.indices, sizes.indices);
    out(BINDING_SLICE_AREAS, places_.face_areas, sizes.areas);
    out(BINDING_SLICE_SHIFTS, places_.shifts, sizes.shifts);
    const OrderPush push{count,
                         want_.neighbors ? 1u : 0u,
                         want_.volumes ? 1u : 0u,
                         want_.centroids ? 1u : 0u,
                         sizes.areas > 0 ? 1u : 0u,
                         sizes.shifts > 0 ? 1u : 0u};
    commands.dispatch(passes_[0], bindings.list(), push_bytes(push), count + std::uint64_t{1});
    commands.barrier();
    if (!want_.neighbors) return;
    scan_.record(commands, votess::vulkan::detail::PlanAccess::passes(plan_), exported(places_.indptr, 4 * (n + 1)),
                 count + 1);
    commands.dispatch(passes_[1], bindings.list(), push_bytes(push), count);
    commands.barrier();
}

// Submits a batch without commands. Later submissions begin when the semaphore has the first value. It gets the second
// value after all earlier ones. 0: none.
void ExportedFrames::batch(std::uint64_t wait_value, std::uint64_t signal_value) {
    VkTimelineSemaphoreSubmitInfo values{};
    values.sType = VK_STRUCTURE_TYPE_TIMELINE_SEMAPHORE_SUBMIT_INFO;
    VkSubmitInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    info.pNext = &values;
    constexpr VkPipelineStageFlags all = VK_PIPELINE_STAGE_ALL_COMMANDS_BIT;
    if (wait_value != 0) {
        info.waitSemaphoreCount = values.waitSemaphoreValueCount = 1;
        values.pWaitSemaphoreValues = &wait_value;
        info.pWaitSemaphores = &semaphore_;
        info.pWaitDstStageMask = &all;
    }
    if (signal_value != 0) {
        info.signalSemaphoreCount = values.signalSemaphoreValueCount = 1;
        values.pSignalSemaphoreValues = &signal_value;
        info.pSignalSemaphores = &semaphore_;
    }
    check(exporting_.device()->table().vkQueueSubmit(exporting_.queue(), 1, &info, VK_NULL_HANDLE), "vkQueueSubmit");
}

void ExportedFrames::submit(std::uint32_t count, std::uint64_t after, std::uint64_t done) {
    has_run_ = false;
    vulkan::Commands& commands = *flights_[next_flight_];
    next_flight_ = 1 - next_flight_;
    commands.begin();
    take(commands, true);
    frame_.record(commands.handle(), {.count = count});
    record_order(commands, count);
    take(commands, false);
    commands.end();
    batch(after, 0);
    commands.submit();
    batch(0, done);
    check_messages();
    count_ = count;
    has_run_ = true;
}

void ExportedFrames::signal(std::uint64_t value) {
    VkSemaphoreSignalInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO;
    info.semaphore = semaphore_;
    info.value = value;
    vulkan::Device& device = *exporting_.device();
    check(device.table().vkSignalSemaphore(device.handle(), &info), "vkSignalSemaphore");
}

void ExportedFrames::wait(std::uint64_t value) {
    constexpr std::uint64_t interval = 20'000'000;  // nanoseconds
    VkSemaphoreWaitInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO;
    info.semaphoreCount = 1;
    info.pSemaphores = &semaphore_;
    info.pValues = &value;
    vulkan::Device& device = *exporting_.device();
    for (VkResult result = VK_TIMEOUT; result == VK_TIMEOUT;) {
        check_stop();
        result = device.table().vkWaitSemaphores(device.handle(), &info, interval);
        check(result, "vkWaitSemaphores");
    }
}

void ExportedFrames::check_messages() const {
    const auto messages = exporting_.device()->instance().take_messages();
    if (!messages.empty())
        throw Error(ErrorCode::internal, "Vulkan validation found " + std::to_string(messages.size()) +
                                             " problems, the first: " + messages.front());
}

void ExportedFrames::run_now(vulkan::Commands& commands) {
    commands.end();
    commands.submit();
    commands.wait();
    check_messages();
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
    const Output* const outputs[] = {&header_, &cells_, &indices_, &geometry_, &areas_, &shifts_};
    commands.begin();
    take(commands, true);
    commands.copy(exported(places_.points, sizes.seeds), 0, points, 0, sizes.seeds);
    if (weights) commands.copy(exported(places_.weights, sizes.weights), 0, weights, 0, sizes.weights);
    for (const Output* out : outputs)
        if (out->copy) commands.copy(out->written, 0, out->copy, 0, out->copy.size());
    take(commands, false);
    commands.barrier_to_host();
    run_now(commands);
    points.invalidate();
    if (weights) weights.invalidate();
    for (const Output* out : outputs) out->seen().invalidate();

    const auto cells = cells_.seen().as<Cell>().first(count_);
    const std::span<const Real> given = points.as<Real>(), masses = weights.as<Real>();
    const auto more = plan_.resolve(given, masses, std::span<const Cell>(cells),
                                    {.box = {}, .cell = {}, .threads = pool_.requested()});
    if (more.cells.empty()) return 0;
    const std::vector<double> seeds(given.begin(),
                                    given.begin() + static_cast<std::ptrdiff_t>(3 * std::size_t{count_}));
    constexpr bool narrow = sizeof(Real) == sizeof(float);
    const detail::FrameRows rows = gather_rows({.seeds = seeds,
                                                .cells = cells,
                                                .indices = indices_.seen().as<std::int32_t>(),
                                                .geometry = geometry_.seen().as<float>(),
                                                .areas = areas_.seen().as<float>(),
                                                .shifts = shifts_.seen().as<std::int8_t>()},
                                               more, want_, narrow, pool_);
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
        if (place == none || bytes.empty()) return;
        const vulkan::Buffer& stage =
            staged.emplace_back(memory_.buffer(bytes.size(), vulkan::MemoryKind::upload, "staging"));
        std::ranges::copy(bytes, stage.mapped().begin());
        stage.flush();
        commands.copy(stage, 0, exported(place, bytes.size()), 0, bytes.size());
    };
    std::vector<std::int8_t> padded(rows.shifts.empty() ? 0 : 4 * entries);
    for (std::size_t e = 0; e < padded.size() / 4; ++e) std::copy_n(&rows.shifts[3 * e], 3, &padded[4 * e]);
    upload(places_.status, rows.status);
    upload(places_.indptr, rows.indptr);
    upload(places_.indices, rows.indices);
    upload(places_.shifts, padded);
    upload(places_.face_areas, rows.face_areas);
    upload(places_.volumes, rows.volumes);
    upload(places_.centroids, rows.centroids32);
    upload(places_.centroids, rows.centroids64);
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
