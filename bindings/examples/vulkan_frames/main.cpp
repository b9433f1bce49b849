// Moving Voronoi cells in a program's own Vulkan. A frame is one command buffer: a compute shader moves the seeds,
// votess finds their cells, and a fragment shader draws them from votess's buffers. Nothing leaves the GPU.
//
//     vulkan_frames                                                draws in a window until it is closed
//     vulkan_frames --frames N [--samples N] [--output FILE.png]   draws N frames without a window, checks the last one
//
// The numbered steps are all that a program needs for votess; CMakeLists.txt says how to build this one.
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <set>

#include "gpu.hpp"
#include "shaders.hpp"
#ifdef WITH_WINDOW
#include <GLFW/glfw3.h>
#endif
#ifdef WITH_PNG
#include <png.h>
#endif

constexpr std::uint32_t count = 3000;  // seeds
constexpr vk::Extent2D extent{800, 600};
constexpr vk::Format format = vk::Format::eR8G8B8A8Unorm;
using Pixels = std::array<std::uint32_t, std::size_t{extent.width} * extent.height>;
using enum vk::PipelineStageFlagBits;
using enum vk::ImageLayout;
constexpr vk::ShaderStageFlags stages = vk::ShaderStageFlagBits::eCompute | vk::ShaderStageFlagBits::eFragment;

struct Push {  // as in shaders/push.glsl
    std::uint32_t seeds = count, samples = 1;
    float time = 0, step = 0, width = extent.width, height = extent.height;
};

// The buffers and pipelines of one frame in flight.
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
        draw = make_drawing(gpu, *layout, format, extent, *make_shader(gpu, whole_vert), *make_shader(gpu, cells_frag));
    }

    // Records one frame. The picture ends in the layout of a copy's source.
    void record(vk::CommandBuffer commands, const Push& push) const {
        commands.bindPipeline(vk::PipelineBindPoint::eCompute, *move);
        commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout, 0, set, {});
        commands.pushConstants<Push>(*layout, stages, 0, push);
        commands.dispatch((count + 63) / 64, 1, 1);
        barrier(commands, eComputeShader, eComputeShader | eFragmentShader);

        // Step 4, every frame: record votess behind a barrier from the writes to the seeds. It ends with a barrier of
        // its own: all later commands see the cells.
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
        // Step 3: make the buffers, as large as the plan says, and bind them to a frame.
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

        // The program's own shaders read them too.
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
    // Step 2, once: plan for the largest number of seeds and the box. Here the pipelines are made.
    votess::vulkan::Plan plan{gpu.handles, {.max_seeds = count, .box = {{0, 0, 0}, {1, 1, 1}}, .stride = 4}};
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

// A frame on the host.
struct ReadBack {
    votess::vulkan::Header header;
    std::array<float, std::size_t{4} * count> seeds, geometry;
    std::array<votess::vulkan::Cell, count> cells;
    Pixels pixels;
};

void read_back(const Scene& scene, const Buffer& target) {
    run(scene.gpu, [&](vk::CommandBuffer commands) {
        const auto copy = [&](const Buffer& source, std::size_t offset, std::size_t size) {
            commands.copyBuffer(*source.buffer, *target.buffer, vk::BufferCopy{.dstOffset = offset, .size = size});
        };
        copy(scene.header, offsetof(ReadBack, header), sizeof(ReadBack::header));
        copy(scene.seeds, offsetof(ReadBack, seeds), sizeof(ReadBack::seeds));
        copy(scene.cells, offsetof(ReadBack, cells), sizeof(ReadBack::cells));
        copy(scene.geometry, offsetof(ReadBack, geometry), sizeof(ReadBack::geometry));
        vk::BufferImageCopy all{.bufferOffset = offsetof(ReadBack, pixels)};
        all.setImageExtent({extent.width, extent.height, 1})
            .setImageSubresource({vk::ImageAspectFlagBits::eColor, 0, 0, 1});
        commands.copyImageToBuffer(*scene.picture, eTransferSrcOptimal, *target.buffer, all);
        barrier(commands, eTransfer, eHost);
    });
}

#ifdef WITH_PNG
void write_png(const std::string& file, const Pixels& pixels) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = extent.width;
    image.height = extent.height;
    image.format = PNG_FORMAT_RGBA;
    if (png_image_write_to_file(&image, file.c_str(), 0, pixels.data(), 0, nullptr) == 0)
        throw std::runtime_error(file + ": " + image.message);
}
#else
void write_png(const std::string&, const Pixels&) {
    throw std::runtime_error("--output: built without libpng");
}
#endif

struct Arguments {
    int frames = 0;             // without a window; 0: draw in a window
    std::uint32_t samples = 1;  // rays a pixel along each axis, in the last frame
    std::string output;         // PNG file of the last frame; empty: none
};

Arguments read(int argc, char** argv) {
    Arguments arguments;
    for (int i = 1; i < argc; i += 2) {
        const std::string option = argv[i], value = i + 1 < argc ? argv[i + 1] : "";
        const int number = std::atoi(value.c_str());
        if (option == "--frames" && number > 0) {
            arguments.frames = number;
        } else if (option == "--samples" && number > 0 && number <= 16) {
            arguments.samples = static_cast<std::uint32_t>(number);
        } else if (option == "--output" && !value.empty()) {
            arguments.output = value;
        } else {
            throw std::runtime_error("usage: vulkan_frames [--frames N [--samples 1..16] [--output FILE.png]]");
        }
    }
    return arguments;
}

// Draws the frames and checks the last one: its picture shows cells, and their volumes fill the box.
bool draw_without_window(const Arguments& arguments) {
    const Gpu gpu = make_gpu({}, {});
    const Scene scene(gpu);
    Push push;
    for (int i = 1; i <= arguments.frames; ++i) {
        if (i == arguments.frames) push.samples = arguments.samples;
        run(gpu, [&](vk::CommandBuffer commands) { scene.record(commands, push); });
        push.time += push.step = 0.1F;
    }
    using Memory = vk::MemoryPropertyFlagBits;
    const Buffer buffer = make_buffer(gpu, sizeof(ReadBack), vk::BufferUsageFlagBits::eTransferDst,
                                      Memory::eHostVisible | Memory::eHostCoherent);
    read_back(scene, buffer);
    const auto& got = *static_cast<const ReadBack*>(gpu.device->mapMemory(*buffer.memory, 0, VK_WHOLE_SIZE));
    if (!arguments.output.empty()) write_png(arguments.output, got.pixels);

    // Step 5, if wanted: the CPU finishes the cells that the GPU left pending. They have volume 0 in `geometry`.
    const votess::vulkan::Resolved resolved = scene.plan.resolve(got.seeds, got.cells);
    double volume = std::accumulate(resolved.volumes.begin(), resolved.volumes.end(), 0.0);
    for (std::size_t i = 3; i < got.geometry.size(); i += 4) volume += got.geometry[i];
    const std::set<std::uint32_t> colors(got.pixels.begin(), got.pixels.end());
    std::printf("%u of %u cells certified on the GPU, %zu on the CPU; volume %.5f of 1; %zu colors\n",
                got.header.certified, got.header.seeds, resolved.cells.size(), volume, colors.size());
    return got.header.certified > 0.9 * count && std::abs(volume - 1) < 1e-5 && colors.size() > 1000;
}

#ifdef WITH_WINDOW
// The window keeps its size; one that changes it makes a new swapchain.
void draw_in_window() {
    if (glfwInit() == GLFW_FALSE || glfwVulkanSupported() == GLFW_FALSE)
        throw std::runtime_error("GLFW finds no display or no Vulkan: give --frames N");
    std::atexit(glfwTerminate);
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
    GLFWwindow* const window = glfwCreateWindow(extent.width, extent.height, "votess", nullptr, nullptr);
    std::uint32_t name_count = 0;
    const char** const names = glfwGetRequiredInstanceExtensions(&name_count);
    const Gpu gpu = make_gpu({names, names + name_count}, {VK_KHR_SWAPCHAIN_EXTENSION_NAME});
    VkSurfaceKHR handle = VK_NULL_HANDLE;
    glfwCreateWindowSurface(*gpu.instance, window, nullptr, &handle);
    const vk::UniqueSurfaceKHR surface(handle, *gpu.instance);
    if (!handle || !gpu.physical.getSurfaceSupportKHR(gpu.handles.queue_family, *surface))
        throw std::runtime_error("the GPU cannot draw to the window: give --frames N");
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
    Push push{.samples = 2};
    while (glfwWindowShouldClose(window) == GLFW_FALSE) {
        glfwPollEvents();
        const std::uint32_t i = gpu.device->acquireNextImageKHR(*swapchain, UINT64_MAX, {}, *acquired).value;
        (void)gpu.device->waitForFences(*acquired, true, UINT64_MAX);
        gpu.device->resetFences(*acquired);
        run(gpu, [&](vk::CommandBuffer commands) {
            scene.record(commands, push);
            barrier(commands, eTransfer, eTransfer, images[i], eUndefined, eTransferDstOptimal);
            commands.blitImage(*scene.picture, eTransferSrcOptimal, images[i], eTransferDstOptimal, all,
                               vk::Filter::eLinear);
            barrier(commands, eTransfer, eBottomOfPipe, images[i], eTransferDstOptimal, ePresentSrcKHR);
        });
        push.time += push.step = 0.01F;
        (void)gpu.queue.presentKHR(vk::PresentInfoKHR{}.setSwapchains(*swapchain).setImageIndices(i));
    }
    gpu.device->waitIdle();
}
#else
void draw_in_window() {
    throw std::runtime_error("built without GLFW: give --frames N");
}
#endif

int main(int argc, char** argv) {
    try {
        const Arguments arguments = read(argc, argv);
        if (arguments.frames > 0) return draw_without_window(arguments) ? 0 : 1;
        draw_in_window();
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "vulkan_frames: %s\n", error.what());
        return 1;
    }
}
