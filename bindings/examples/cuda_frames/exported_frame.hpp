// A frame of votess in memory that another API may map: seeds and rows are one buffer, which a file descriptor names.
// A timeline semaphore orders the frames and the work of the other API. Nothing in this file depends on CUDA.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>
#include <vulkan/vulkan.hpp>
// Behind the headers of Vulkan.
#include <votess/vulkan.hpp>

using Uuid = std::array<std::uint8_t, VK_UUID_SIZE>;

class ExportedFrame {
public:
    // Bytes from the start of the exported buffer.
    struct Places {
        vk::DeviceSize seeds = 0, header = 0, cells = 0, indices = 0, geometry = 0, end = 0;
    };

    // Takes the device with this UUID, or else the first one that votess can use. Seeds are vec4.
    ExportedFrame(std::uint32_t seeds, const votess::Box& box, const std::optional<Uuid>& uuid) {
        make_device(uuid);
        // As in ../vulkan_frames: the plan, then its buffers.
        plan_.emplace(handles_, votess::vulkan::PlanOptions{.max_seeds = seeds, .box = box, .stride = 4});
        make_buffers();
        make_semaphore();
        record();
    }
    ~ExportedFrame() { device_->waitIdle(); }
    ExportedFrame(const ExportedFrame&) = delete;
    ExportedFrame& operator=(const ExportedFrame&) = delete;

    [[nodiscard]] const votess::vulkan::Plan& plan() const { return *plan_; }
    [[nodiscard]] const Places& places() const { return places_; }
    // Bytes of the allocation, which whoever imports it must name.
    [[nodiscard]] vk::DeviceSize memory_size() const { return memory_size_; }
    [[nodiscard]] std::uint32_t memory_type() const { return memory_type_; }
    [[nodiscard]] Uuid uuid() const { return uuid_of(physical_); }
    [[nodiscard]] vk::Device device() const { return *device_; }
    [[nodiscard]] vk::Semaphore semaphore() const { return *semaphore_; }

    // Return a new file descriptor. The API that imports it owns it then.
    [[nodiscard]] int memory_descriptor() const {
        const auto get = reinterpret_cast<PFN_vkGetMemoryFdKHR>(device_->getProcAddr("vkGetMemoryFdKHR"));
        const VkMemoryGetFdInfoKHR info = vk::MemoryGetFdInfoKHR{
            .memory = *shared_.memory, .handleType = vk::ExternalMemoryHandleTypeFlagBits::eOpaqueFd};
        int descriptor = -1;
        if (get(*device_, &info, &descriptor) != VK_SUCCESS) throw std::runtime_error("the memory cannot be exported");
        return descriptor;
    }
    // Throws where the device has no VK_KHR_external_semaphore_fd.
    [[nodiscard]] int semaphore_descriptor() const {
        if (!exports_semaphores_) throw std::runtime_error("the device cannot export semaphores");
        const auto get = reinterpret_cast<PFN_vkGetSemaphoreFdKHR>(device_->getProcAddr("vkGetSemaphoreFdKHR"));
        const VkSemaphoreGetFdInfoKHR info = vk::SemaphoreGetFdInfoKHR{
            .semaphore = *semaphore_, .handleType = vk::ExternalSemaphoreHandleTypeFlagBits::eOpaqueFd};
        int descriptor = -1;
        if (get(*device_, &info, &descriptor) != VK_SUCCESS)
            throw std::runtime_error("the semaphore cannot be exported");
        return descriptor;
    }

    // Submits a frame that begins when the semaphore has the value `after`, and sets it to `done` at its end. Waits for
    // nothing, so many frames may be pending.
    void submit(std::uint64_t after, std::uint64_t done) const {
        vk::TimelineSemaphoreSubmitInfo values;
        values.setWaitSemaphoreValues(after).setSignalSemaphoreValues(done);
        const vk::PipelineStageFlags all = vk::PipelineStageFlagBits::eAllCommands;
        vk::SubmitInfo info{.pNext = &values};
        info.setWaitSemaphores(*semaphore_).setWaitDstStageMask(all).setSignalSemaphores(*semaphore_);
        queue_.submit(info.setCommandBuffers(*commands_));
    }

private:
    struct Buffer {
        vk::UniqueDeviceMemory memory;
        vk::UniqueBuffer buffer;
    };

    [[nodiscard]] static Uuid uuid_of(vk::PhysicalDevice device) {
        const auto chain = device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceIDProperties>();
        Uuid uuid;
        std::ranges::copy(chain.get<vk::PhysicalDeviceIDProperties>().deviceUUID, uuid.begin());
        return uuid;
    }

    [[nodiscard]] votess::vulkan::Requirements choose(const std::optional<Uuid>& uuid) {
        for (const vk::PhysicalDevice device : instance_->enumeratePhysicalDevices()) {
            votess::vulkan::Requirements needs = votess::vulkan::requirements(handles_.host, device);
            if (!needs.missing.empty() || device.getProperties().apiVersion < VK_API_VERSION_1_3) continue;
            if (uuid && uuid_of(device) != *uuid) continue;
            physical_ = device;
            return needs;
        }
        throw std::runtime_error("no Vulkan device of version 1.3 that votess can use");
    }

    void make_device(const std::optional<Uuid>& uuid) {
        const vk::ApplicationInfo application{.pApplicationName = "cuda_frames", .apiVersion = VK_API_VERSION_1_3};
        instance_ = vk::createInstanceUnique({.pApplicationInfo = &application});
        handles_.host = {*instance_, vkGetInstanceProcAddr, VK_API_VERSION_1_3};
        const votess::vulkan::Requirements needs = choose(uuid);
        std::vector<const char*> extensions{VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME};
        for (const std::string& extension : needs.extensions) extensions.push_back(extension.c_str());
        for (const vk::ExtensionProperties& known : physical_.enumerateDeviceExtensionProperties())
            if (std::strcmp(known.extensionName, VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME) == 0)
                exports_semaphores_ = true;
        if (exports_semaphores_) extensions.push_back(VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME);

        const auto features = std::bit_cast<vk::PhysicalDeviceFeatures>(handles_.features = needs.features);
        vk::PhysicalDeviceVulkan13Features newer;
        handles_.subgroup_size_control = needs.subgroup_size_control;
        newer.subgroupSizeControl = newer.computeFullSubgroups = needs.subgroup_size_control;
        vk::PhysicalDeviceVulkan12Features timeline{.pNext = &newer, .timelineSemaphore = true};
        const float priority = 1;
        vk::DeviceQueueCreateInfo queue{.queueFamilyIndex = needs.queue_family};
        queue.setQueuePriorities(priority);
        vk::DeviceCreateInfo info{.pNext = &timeline, .pEnabledFeatures = &features};
        device_ = physical_.createDeviceUnique(info.setQueueCreateInfos(queue).setPEnabledExtensionNames(extensions));
        queue_ = device_->getQueue(needs.queue_family, 0);
        handles_.physical_device = physical_;
        handles_.device = *device_;
        handles_.queue_family = needs.queue_family;
        handles_.probe_queue = queue_;
    }

    // Makes a buffer in memory of its own. `exported`: for other APIs.
    [[nodiscard]] Buffer make_buffer(vk::DeviceSize bytes, bool exported) {
        constexpr auto descriptor = vk::ExternalMemoryHandleTypeFlagBits::eOpaqueFd;
        const vk::ExternalMemoryBufferCreateInfo external{.handleTypes = descriptor};
        Buffer made;
        made.buffer = device_->createBufferUnique({.pNext = exported ? &external : nullptr,
                                                   .size = bytes,
                                                   .usage = vk::BufferUsageFlags(votess::vulkan::buffer_usage)});
        const vk::MemoryRequirements needs = device_->getBufferMemoryRequirements(*made.buffer);
        const vk::PhysicalDeviceMemoryProperties memory = physical_.getMemoryProperties();
        std::uint32_t type = 0;
        while (type < memory.memoryTypeCount &&
               ((needs.memoryTypeBits >> type & 1) == 0 ||
                !(memory.memoryTypes[type].propertyFlags & vk::MemoryPropertyFlagBits::eDeviceLocal)))
            ++type;
        if (type == memory.memoryTypeCount) throw std::runtime_error("no memory type that fits");
        const vk::MemoryDedicatedAllocateInfo dedicated{.buffer = *made.buffer};
        const vk::ExportMemoryAllocateInfo exportable{.pNext = &dedicated, .handleTypes = descriptor};
        made.memory = device_->allocateMemoryUnique(
            {.pNext = exported ? &exportable : nullptr, .allocationSize = needs.size, .memoryTypeIndex = type});
        device_->bindBufferMemory(*made.buffer, *made.memory, 0);
        if (exported) {
            memory_size_ = needs.size;
            memory_type_ = type;
        }
        return made;
    }

    void make_buffers() {
        const votess::vulkan::BufferSizes& sizes = plan_->sizes();
        const vk::DeviceSize step = physical_.getProperties().limits.minStorageBufferOffsetAlignment;
        const auto place = [&](vk::DeviceSize bytes) {
            const vk::DeviceSize begin = places_.end;
            places_.end += (bytes + step - 1) / step * step;
            return begin;
        };
        places_.seeds = place(vk::DeviceSize{16} * plan_->options().max_seeds);
        places_.header = place(sizes.header);
        places_.cells = place(sizes.cells);
        places_.indices = place(sizes.indices);
        places_.geometry = place(sizes.geometry);
        shared_ = make_buffer(places_.end, true);
        workspace_ = make_buffer(sizes.workspace, false);
        const vk::Buffer buffer = *shared_.buffer;
        frame_ = plan_->frame({.seeds = {buffer, places_.seeds},
                               .workspace = {*workspace_.buffer},
                               .header = {buffer, places_.header},
                               .cells = {buffer, places_.cells},
                               .indices = {buffer, places_.indices},
                               .geometry = {buffer, places_.geometry}});
    }

    void make_semaphore() {
        const vk::ExportSemaphoreCreateInfo exported{.handleTypes = vk::ExternalSemaphoreHandleTypeFlagBits::eOpaqueFd};
        const vk::SemaphoreTypeCreateInfo timeline{.pNext = exports_semaphores_ ? &exported : nullptr,
                                                   .semaphoreType = vk::SemaphoreType::eTimeline};
        semaphore_ = device_->createSemaphoreUnique({.pNext = &timeline});
    }

    // Records one frame, which may be submitted again and again. Its first barrier takes the buffer over from the other
    // API, and its last one gives it back.
    void record() {
        pool_ = device_->createCommandPoolUnique({.queueFamilyIndex = handles_.queue_family});
        commands_ =
            std::move(device_->allocateCommandBuffersUnique({.commandPool = *pool_, .commandBufferCount = 1}).front());
        commands_->begin({.flags = vk::CommandBufferUsageFlagBits::eSimultaneousUse});
        give(VK_QUEUE_FAMILY_EXTERNAL, handles_.queue_family);
        frame_.record(*commands_, {.count = plan_->options().max_seeds});
        give(handles_.queue_family, VK_QUEUE_FAMILY_EXTERNAL);
        commands_->end();
    }
    void give(std::uint32_t from, std::uint32_t to) const {
        constexpr vk::AccessFlags any = vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite;
        const bool here = to == handles_.queue_family;
        vk::BufferMemoryBarrier all{.srcQueueFamilyIndex = from, .dstQueueFamilyIndex = to};
        (here ? all.dstAccessMask : all.srcAccessMask) = any;
        all.setBuffer(*shared_.buffer).setSize(VK_WHOLE_SIZE);
        constexpr vk::PipelineStageFlags stages = vk::PipelineStageFlagBits::eAllCommands;
        commands_->pipelineBarrier(stages, stages, {}, {}, all, {});
    }

    vk::UniqueInstance instance_;
    vk::PhysicalDevice physical_;
    vk::UniqueDevice device_;
    vk::Queue queue_;
    votess::vulkan::HostDevice handles_;  // for votess
    bool exports_semaphores_ = false;
    std::optional<votess::vulkan::Plan> plan_;
    Places places_;
    vk::DeviceSize memory_size_ = 0;
    std::uint32_t memory_type_ = 0;
    Buffer shared_, workspace_;
    votess::vulkan::Frame frame_;
    vk::UniqueSemaphore semaphore_;
    vk::UniqueCommandPool pool_;
    vk::UniqueCommandBuffer commands_;
};
