// The parts that every Vulkan program has: a device with one queue, buffers, a pipeline that draws.
#pragma once

#include <array>
#include <bit>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>
#include <vulkan/vulkan.hpp>
// Behind the headers of Vulkan.
#include <votess/vulkan.hpp>

struct Gpu {
    vk::UniqueInstance instance;
    vk::PhysicalDevice physical;
    vk::UniqueDevice device;
    vk::Queue queue;  // draws and computes
    vk::UniqueCommandPool pool;
    votess::vulkan::HostDevice handles;  // for votess
};

// Chooses the first device that this program and votess can use.
inline votess::vulkan::Requirements choose(Gpu& gpu) {
    constexpr vk::QueueFlags wanted = vk::QueueFlagBits::eGraphics | vk::QueueFlagBits::eCompute;
    for (const vk::PhysicalDevice device : gpu.instance->enumeratePhysicalDevices()) {
        votess::vulkan::Requirements needs = votess::vulkan::requirements(gpu.handles.host, device);
        if (!needs.missing.empty() || device.getProperties().apiVersion < VK_API_VERSION_1_3) continue;
        gpu.handles.physical_device = gpu.physical = device;
        gpu.handles.queue_family = 0;
        for (const vk::QueueFamilyProperties& family : device.getQueueFamilyProperties()) {
            if ((family.queueFlags & wanted) == wanted) return needs;
            ++gpu.handles.queue_family;
        }
    }
    throw std::runtime_error("no Vulkan device of version 1.3 that draws and computes");
}

inline Gpu make_gpu(const std::vector<const char*>& instance_extensions, std::vector<const char*> device_extensions) {
    Gpu gpu;
    const vk::ApplicationInfo application{.pApplicationName = "vulkan_frames", .apiVersion = VK_API_VERSION_1_3};
    gpu.instance = vk::createInstanceUnique(
        vk::InstanceCreateInfo{.pApplicationInfo = &application}.setPEnabledExtensionNames(instance_extensions));
    gpu.handles.host = {*gpu.instance, vkGetInstanceProcAddr, VK_API_VERSION_1_3};
    const votess::vulkan::Requirements needs = choose(gpu);

    // Step 1: enable the features that votess requires, beside the program's own.
    for (const std::string& extension : needs.extensions) device_extensions.push_back(extension.c_str());
    const auto features = std::bit_cast<vk::PhysicalDeviceFeatures>(gpu.handles.features = needs.features);
    vk::PhysicalDeviceVulkan13Features newer{.dynamicRendering = true};
    gpu.handles.subgroup_size_control = needs.subgroup_size_control;
    newer.subgroupSizeControl = newer.computeFullSubgroups = needs.subgroup_size_control;
    const float priority = 1;
    vk::DeviceQueueCreateInfo queue{.queueFamilyIndex = gpu.handles.queue_family};
    queue.setQueuePriorities(priority);
    vk::DeviceCreateInfo info{.pNext = &newer, .pEnabledFeatures = &features};
    info.setQueueCreateInfos(queue).setPEnabledExtensionNames(device_extensions);
    gpu.device = gpu.physical.createDeviceUnique(info);
    gpu.handles.device = *gpu.device;
    gpu.handles.probe_queue = gpu.queue = gpu.device->getQueue(gpu.handles.queue_family, 0);
    gpu.pool = gpu.device->createCommandPoolUnique({.queueFamilyIndex = gpu.handles.queue_family});
    return gpu;
}

// Records, submits and waits: one frame at a time is in flight. A program with more needs a Scene for each.
template <class Record>
void run(const Gpu& gpu, const Record& record) {
    const auto commands = gpu.device->allocateCommandBuffersUnique({.commandPool = *gpu.pool, .commandBufferCount = 1});
    commands[0]->begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    record(*commands[0]);
    commands[0]->end();
    gpu.queue.submit(vk::SubmitInfo{}.setCommandBuffers(*commands[0]));
    gpu.queue.waitIdle();
}

inline vk::UniqueDeviceMemory allocate(const Gpu& gpu, const vk::MemoryRequirements& needs,
                                       vk::MemoryPropertyFlags wanted = vk::MemoryPropertyFlagBits::eDeviceLocal) {
    const vk::PhysicalDeviceMemoryProperties memory = gpu.physical.getMemoryProperties();
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        if ((needs.memoryTypeBits >> i & 1) == 0 || (memory.memoryTypes[i].propertyFlags & wanted) != wanted) continue;
        return gpu.device->allocateMemoryUnique({.allocationSize = needs.size, .memoryTypeIndex = i});
    }
    throw std::runtime_error("no memory type that fits");
}

struct Buffer {
    vk::UniqueDeviceMemory memory;
    vk::UniqueBuffer buffer;
};

inline Buffer make_buffer(const Gpu& gpu, vk::DeviceSize bytes, vk::BufferUsageFlags usage,
                          vk::MemoryPropertyFlags wanted = vk::MemoryPropertyFlagBits::eDeviceLocal) {
    vk::UniqueBuffer buffer = gpu.device->createBufferUnique({.size = bytes, .usage = usage});
    vk::UniqueDeviceMemory memory = allocate(gpu, gpu.device->getBufferMemoryRequirements(*buffer), wanted);
    gpu.device->bindBufferMemory(*buffer, *memory, 0);
    return {std::move(memory), std::move(buffer)};
}

// Makes the writes of stages `from` visible to stages `to`. Changes the layout of an image if one is given.
inline void barrier(vk::CommandBuffer commands, vk::PipelineStageFlags from, vk::PipelineStageFlags to,
                    vk::Image image = {}, vk::ImageLayout before = {}, vk::ImageLayout after = {}) {
    constexpr vk::AccessFlags any = vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite;
    const vk::MemoryBarrier all{.srcAccessMask = any, .dstAccessMask = any};
    if (!image) return commands.pipelineBarrier(from, to, {}, all, {}, {});
    vk::ImageMemoryBarrier change{.srcAccessMask = any, .dstAccessMask = any, .oldLayout = before, .newLayout = after};
    change.setImage(image).setSubresourceRange({vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1});
    commands.pipelineBarrier(from, to, {}, {}, {}, change);
}

inline vk::UniqueShaderModule make_shader(const Gpu& gpu, std::span<const std::uint32_t> words) {
    return gpu.device->createShaderModuleUnique({.codeSize = words.size_bytes(), .pCode = words.data()});
}

// Makes a pipeline that draws over all of an image, without vertex buffers.
inline vk::UniquePipeline make_drawing(const Gpu& gpu, vk::PipelineLayout layout, vk::Format format,
                                       vk::Extent2D extent, vk::ShaderModule vertex, vk::ShaderModule fragment) {
    std::array<vk::PipelineShaderStageCreateInfo, 2> stages;
    stages[0].setStage(vk::ShaderStageFlagBits::eVertex).setModule(vertex).setPName("main");
    stages[1].setStage(vk::ShaderStageFlagBits::eFragment).setModule(fragment).setPName("main");
    const vk::PipelineVertexInputStateCreateInfo no_vertices;
    const vk::PipelineInputAssemblyStateCreateInfo triangles{.topology = vk::PrimitiveTopology::eTriangleList};
    const vk::Viewport whole{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
    const vk::Rect2D scissor{{0, 0}, extent};
    const auto viewport = vk::PipelineViewportStateCreateInfo{}.setViewports(whole).setScissors(scissor);
    const vk::PipelineRasterizationStateCreateInfo raster{.lineWidth = 1};
    const vk::PipelineMultisampleStateCreateInfo samples;
    const auto all = vk::PipelineColorBlendAttachmentState{}.setColorWriteMask(~vk::ColorComponentFlags{});
    const auto blend = vk::PipelineColorBlendStateCreateInfo{}.setAttachments(all);
    const auto rendering = vk::PipelineRenderingCreateInfo{}.setColorAttachmentFormats(format);
    vk::GraphicsPipelineCreateInfo info{.pNext = &rendering, .pColorBlendState = &blend, .layout = layout};
    info.setStages(stages).setPVertexInputState(&no_vertices).setPInputAssemblyState(&triangles);
    info.setPViewportState(&viewport).setPRasterizationState(&raster).setPMultisampleState(&samples);
    return gpu.device->createGraphicsPipelineUnique({}, info).value;
}
