// Moving Voronoi cells in a program's own Vulkan: a compute shader moves the seeds, votess records its passes behind it
// into the same command buffer, and a fragment shader draws the slice z = 0.5 from what votess wrote. The seeds never
// leave the GPU. CMakeLists.txt says how it is built.
//
//     vulkan_window [--headless N]       (N frames without a window, the last one checked)
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "gpu.hpp"
#include "shaders.hpp"
#ifdef WITH_WINDOW
#include <GLFW/glfw3.h>
#endif

constexpr std::uint32_t side = 20, count = side * side * side;  // seeds
constexpr vk::Extent2D extent{600, 600};
constexpr vk::Format format = vk::Format::eR8G8B8A8Unorm;
using enum vk::PipelineStageFlagBits;
using enum vk::ImageLayout;
constexpr vk::ShaderStageFlags stages = vk::ShaderStageFlagBits::eCompute | vk::ShaderStageFlagBits::eFragment;

struct Push {  // as in shaders/common.glsl
    std::uint32_t seeds_along = side;
    float time = 0, width = extent.width;
};

struct Scene {
    explicit Scene(const Gpu& on) : gpu(on) {
        make_buffers();
        make_picture();
        const vk::PushConstantRange push{stages, 0, sizeof(Push)};
        layout = gpu.device->createPipelineLayoutUnique(
            vk::PipelineLayoutCreateInfo{}.setSetLayouts(*set_layout).setPushConstantRanges(push));
        const vk::UniqueShaderModule compute = make_shader(gpu, move_comp);
        vk::ComputePipelineCreateInfo moving{.layout = *layout};
        moving.stage.setStage(vk::ShaderStageFlagBits::eCompute).setModule(*compute).setPName("main");
        move = gpu.device->createComputePipelineUnique({}, moving).value;
        draw = make_drawing(gpu, *layout, format, extent, *make_shader(gpu, whole_vert), *make_shader(gpu, slice_frag));
    }

    // Moves the seeds, finds their cells, draws them; the picture is left as a source of copies.
    void record(vk::CommandBuffer commands, float time) const {
        const Push push{.time = time};
        commands.bindPipeline(vk::PipelineBindPoint::eCompute, *move);
        commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout, 0, set, {});
        commands.pushConstants<Push>(*layout, stages, 0, push);
        commands.dispatch((count + 63) / 64, 1, 1);
        barrier(commands, eComputeShader, eComputeShader | eFragmentShader);

        // All of votess. What it writes is visible to whatever follows: no barrier is needed behind it.
        frame.record(commands, {.count = count});

        barrier(commands, eTransfer, eColorAttachmentOutput, *picture, eUndefined, eColorAttachmentOptimal);
        vk::RenderingAttachmentInfo color{.imageView = *view, .imageLayout = eColorAttachmentOptimal};
        color.setLoadOp(vk::AttachmentLoadOp::eDontCare).setStoreOp(vk::AttachmentStoreOp::eStore);
        commands.beginRendering(
            vk::RenderingInfo{.renderArea = {{0, 0}, extent}, .layerCount = 1}.setColorAttachments(color));
        commands.bindPipeline(vk::PipelineBindPoint::eGraphics, *draw);
        commands.bindDescriptorSets(vk::PipelineBindPoint::eGraphics, *layout, 0, set, {});
        commands.pushConstants<Push>(*layout, stages, 0, push);  // again: votess pushed its own
        commands.draw(3, 1, 0, 0);
        commands.endRendering();
        barrier(commands, eColorAttachmentOutput, eTransfer, *picture, eColorAttachmentOptimal, eTransferSrcOptimal);
    }

    void make_buffers() {
        const votess::vulkan::BufferSizes& sizes = plan.sizes();
        const auto make = [&](Buffer& buffer, vk::DeviceSize bytes) {
            buffer = make_buffer(gpu, bytes, vk::BufferUsageFlags(votess::vulkan::buffer_usage));
            return votess::vulkan::BufferRange{*buffer.buffer};
        };
        frame = plan.frame({.seeds = make(seeds, 16 * count),  // a vec4 each, in the shaders
                            .workspace = make(workspace, sizes.workspace),
                            .header = make(header, sizes.header),
                            .cells = make(cells, sizes.cells),
                            .indices = make(indices, sizes.indices),
                            .geometry = make(geometry, sizes.geometry)});

        // The program's own shaders see them too.
        constexpr auto storage = vk::DescriptorType::eStorageBuffer;
        std::vector<vk::DescriptorSetLayoutBinding> bindings;
        std::vector<vk::DescriptorBufferInfo> infos;
        for (const Buffer* buffer : {&seeds, &cells, &indices, &geometry}) {
            bindings.push_back({static_cast<std::uint32_t>(bindings.size()), storage, 1, stages, nullptr});
            infos.push_back({*buffer->buffer, 0, VK_WHOLE_SIZE});
        }
        set_layout =
            gpu.device->createDescriptorSetLayoutUnique(vk::DescriptorSetLayoutCreateInfo{}.setBindings(bindings));
        const vk::DescriptorPoolSize size{storage, 4};
        sets = gpu.device->createDescriptorPoolUnique(vk::DescriptorPoolCreateInfo{.maxSets = 1}.setPoolSizes(size));
        const auto one = vk::DescriptorSetAllocateInfo{.descriptorPool = *sets}.setSetLayouts(*set_layout);
        set = gpu.device->allocateDescriptorSets(one).front();
        vk::WriteDescriptorSet write{.dstSet = set, .descriptorType = storage};
        gpu.device->updateDescriptorSets(write.setBufferInfo(infos), {});
    }

    void make_picture() {
        vk::ImageCreateInfo info{.imageType = vk::ImageType::e2D, .format = format, .mipLevels = 1, .arrayLayers = 1};
        info.setExtent({extent.width, extent.height, 1});
        info.setUsage(vk::ImageUsageFlagBits::eColorAttachment | vk::ImageUsageFlagBits::eTransferSrc);
        picture = gpu.device->createImageUnique(info);
        memory = allocate(gpu, gpu.device->getImageMemoryRequirements(*picture));
        gpu.device->bindImageMemory(*picture, *memory, 0);
        vk::ImageViewCreateInfo whole{.image = *picture, .viewType = vk::ImageViewType::e2D, .format = format};
        view =
            gpu.device->createImageViewUnique(whole.setSubresourceRange({vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1}));
    }

    const Gpu& gpu;
    votess::vulkan::Plan plan{gpu.handles, {.most_seeds = count, .box = {{0, 0, 0}, {1, 1, 1}}, .stride = 4}};
    votess::vulkan::Frame frame;
    Buffer seeds, workspace, header, cells, indices, geometry;
    vk::UniqueDescriptorSetLayout set_layout;
    vk::UniqueDescriptorPool sets;
    vk::DescriptorSet set;
    vk::UniquePipelineLayout layout;
    vk::UniquePipeline move, draw;
    vk::UniqueDeviceMemory memory;
    vk::UniqueImage picture;
    vk::UniqueImageView view;
};

// Whether the last of the frames shows cells, nearly all of them proven exact.
bool draw_without_window(int frames) {
    const Gpu gpu = make_gpu({}, {});
    const Scene scene(gpu);
    for (int i = 0; i < frames; ++i) {
        run(gpu, [&](vk::CommandBuffer commands) { scene.record(commands, 0.05F * static_cast<float>(i)); });
    }
    struct Copy {
        votess::vulkan::Header header;
        std::array<std::uint32_t, std::size_t{extent.width} * extent.height> pixels;
    };
    using Memory = vk::MemoryPropertyFlagBits;
    const Buffer buffer = make_buffer(gpu, sizeof(Copy), vk::BufferUsageFlagBits::eTransferDst,
                                      Memory::eHostVisible | Memory::eHostCoherent);
    run(gpu, [&](vk::CommandBuffer commands) {
        vk::BufferImageCopy all{.bufferOffset = offsetof(Copy, pixels)};
        all.setImageExtent({extent.width, extent.height, 1})
            .setImageSubresource({vk::ImageAspectFlagBits::eColor, 0, 0, 1});
        commands.copyImageToBuffer(*scene.picture, eTransferSrcOptimal, *buffer.buffer, all);
        commands.copyBuffer(*scene.header.buffer, *buffer.buffer, vk::BufferCopy{.size = sizeof(Copy::header)});
        barrier(commands, eTransfer, eHost);
    });
    const auto& [header, pixels] = *static_cast<const Copy*>(gpu.device->mapMemory(*buffer.memory, 0, VK_WHOLE_SIZE));
    const std::set<std::uint32_t> colors(pixels.begin(), pixels.end());
    std::printf("%u of %u cells certified, %zu colors\n", header.certified, header.seeds, colors.size());
    const auto black = std::count(pixels.begin(), pixels.end(), 0xFF000000);
    return header.certified > 0.9 * count && colors.size() > 100 && black < std::ssize(pixels) / 2;
}

#ifdef WITH_WINDOW
// The window keeps its size; one that changes it makes a new swapchain.
void draw_in_window() {
    if (glfwInit() == GLFW_FALSE || glfwVulkanSupported() == GLFW_FALSE) throw std::runtime_error("no window here");
    std::atexit(glfwTerminate);
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    GLFWwindow* const window = glfwCreateWindow(extent.width, extent.height, "votess", nullptr, nullptr);
    std::uint32_t names_given = 0;
    const char** const names = glfwGetRequiredInstanceExtensions(&names_given);
    const Gpu gpu = make_gpu({names, names + names_given}, {VK_KHR_SWAPCHAIN_EXTENSION_NAME});
    VkSurfaceKHR made = VK_NULL_HANDLE;
    glfwCreateWindowSurface(*gpu.instance, window, nullptr, &made);
    const vk::UniqueSurfaceKHR surface(made, *gpu.instance);
    if (!made || !gpu.physical.getSurfaceSupportKHR(gpu.handles.queue_family, *surface)) {
        throw std::runtime_error("no window that the GPU draws to");
    }
    const vk::SurfaceCapabilitiesKHR can = gpu.physical.getSurfaceCapabilitiesKHR(*surface);
    vk::SwapchainCreateInfoKHR info{.surface = *surface, .minImageCount = can.minImageCount, .imageArrayLayers = 1};
    info.setImageFormat(vk::Format::eB8G8R8A8Unorm).setImageUsage(vk::ImageUsageFlagBits::eTransferDst);
    info.setImageExtent(can.currentExtent.width == UINT32_MAX ? extent : can.currentExtent).setClipped(true);
    info.setPreTransform(can.currentTransform).setPresentMode(vk::PresentModeKHR::eFifo);
    const vk::UniqueSwapchainKHR swapchain = gpu.device->createSwapchainKHRUnique(info);
    const std::vector<vk::Image> images = gpu.device->getSwapchainImagesKHR(*swapchain);
    const vk::UniqueFence acquired = gpu.device->createFenceUnique({});
    const Scene scene(gpu);
    vk::ImageBlit all{};
    all.srcSubresource = all.dstSubresource = {vk::ImageAspectFlagBits::eColor, 0, 0, 1};
    all.srcOffsets[1] = vk::Offset3D{static_cast<int>(extent.width), static_cast<int>(extent.height), 1};
    all.dstOffsets[1] =
        vk::Offset3D{static_cast<int>(info.imageExtent.width), static_cast<int>(info.imageExtent.height), 1};
    while (glfwWindowShouldClose(window) == GLFW_FALSE) {
        glfwPollEvents();
        const std::uint32_t i = gpu.device->acquireNextImageKHR(*swapchain, UINT64_MAX, {}, *acquired).value;
        (void)gpu.device->waitForFences(*acquired, true, UINT64_MAX);
        gpu.device->resetFences(*acquired);
        run(gpu, [&](vk::CommandBuffer commands) {
            scene.record(commands, static_cast<float>(glfwGetTime()));
            barrier(commands, eTransfer, eTransfer, images[i], eUndefined, eTransferDstOptimal);
            commands.blitImage(*scene.picture, eTransferSrcOptimal, images[i], eTransferDstOptimal, all,
                               vk::Filter::eLinear);
            barrier(commands, eTransfer, eBottomOfPipe, images[i], eTransferDstOptimal, ePresentSrcKHR);
        });
        (void)gpu.queue.presentKHR(vk::PresentInfoKHR{}.setSwapchains(*swapchain).setImageIndices(i));
    }
    gpu.device->waitIdle();
}
#else
void draw_in_window() {
    throw std::runtime_error("built without GLFW: there is --headless N");
}
#endif

int main(int argc, char** argv) {
    try {
        if (argc == 3 && std::string(argv[1]) == "--headless") return draw_without_window(std::stoi(argv[2])) ? 0 : 1;
        draw_in_window();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "vulkan_window: %s\n", error.what());
        return 1;
    }
}
