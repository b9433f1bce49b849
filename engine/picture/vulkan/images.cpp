#include "picture/vulkan/images.hpp"

#include <span>
#include <vector>

namespace votess::gpu {
namespace {

using vulkan::check;

bool is_depth(VkFormat format) {
    return format == VK_FORMAT_D32_SFLOAT || format == VK_FORMAT_X8_D24_UNORM_PACK32;
}

VkAttachmentDescription attachment(VkFormat format, VkSampleCountFlagBits samples, VkAttachmentLoadOp load, bool keep,
                                   VkImageLayout after) {
    VkAttachmentDescription info{};
    info.format = format;
    info.samples = samples;
    info.loadOp = load;
    info.storeOp = keep ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_DONT_CARE;
    info.stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    info.stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE;
    info.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    info.finalLayout = after;
    return info;
}

struct PassShape {
    std::vector<VkAttachmentDescription> attachments;  // color, then depth and resolved color where there are
    bool depth = false, resolve = false;
    VkPipelineStageFlags reader;  // of the color, afterwards
    VkAccessFlags access;
};

OwnedRenderPass render_pass(vulkan::Device& device, const PassShape& shape) {
    const VkAttachmentReference color{0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference depth{1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference resolve{2, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    VkSubpassDescription subpass{};
    subpass.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
    subpass.colorAttachmentCount = 1;
    subpass.pColorAttachments = &color;
    subpass.pDepthStencilAttachment = shape.depth ? &depth : nullptr;
    subpass.pResolveAttachments = shape.resolve ? &resolve : nullptr;

    constexpr VkPipelineStageFlags drawing = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                             VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                             VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    constexpr VkAccessFlags writes =
        VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    VkSubpassDependency dependencies[2]{};
    dependencies[0].srcSubpass = VK_SUBPASS_EXTERNAL;
    dependencies[0].dstSubpass = 0;
    dependencies[0].srcStageMask = drawing;
    dependencies[0].dstStageMask = drawing;
    dependencies[0].dstAccessMask =
        writes | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT;
    dependencies[1].srcSubpass = 0;
    dependencies[1].dstSubpass = VK_SUBPASS_EXTERNAL;
    dependencies[1].srcStageMask = drawing;
    dependencies[1].srcAccessMask = writes;
    dependencies[1].dstStageMask = shape.reader;
    dependencies[1].dstAccessMask = shape.access;

    VkRenderPassCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO;
    info.attachmentCount = static_cast<std::uint32_t>(shape.attachments.size());
    info.pAttachments = shape.attachments.data();
    info.subpassCount = 1;
    info.pSubpasses = &subpass;
    info.dependencyCount = 2;
    info.pDependencies = dependencies;
    OwnedRenderPass pass(device);
    check(device.table().vkCreateRenderPass(device.handle(), &info, nullptr, pass.out()), "vkCreateRenderPass");
    return pass;
}

OwnedFramebuffer framebuffer(vulkan::Device& device, const OwnedRenderPass& pass, std::span<const VkImageView> views,
                             VkExtent2D size) {
    VkFramebufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
    info.renderPass = pass.get();
    info.attachmentCount = static_cast<std::uint32_t>(views.size());
    info.pAttachments = views.data();
    info.width = size.width;
    info.height = size.height;
    info.layers = 1;
    OwnedFramebuffer frame(device);
    check(device.table().vkCreateFramebuffer(device.handle(), &info, nullptr, frame.out()), "vkCreateFramebuffer");
    return frame;
}

// Takes the first type of memory that is the device's own, else any.
OwnedMemory allocate(vulkan::Device& device, const VkMemoryRequirements& needs) {
    const VkPhysicalDeviceMemoryProperties& memory = device.adapter().memory;
    VkResult result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    for (const bool local : {true, false}) {
        for (std::uint32_t type = 0; type < memory.memoryTypeCount; ++type) {
            const VkMemoryPropertyFlags flags = memory.memoryTypes[type].propertyFlags;
            constexpr VkMemoryPropertyFlags special =
                VK_MEMORY_PROPERTY_PROTECTED_BIT | VK_MEMORY_PROPERTY_LAZILY_ALLOCATED_BIT;
            const bool is_local = flags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
            if (!(needs.memoryTypeBits >> type & 1) || is_local != local || (flags & special)) continue;
            VkMemoryAllocateInfo info{};
            info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
            info.allocationSize = needs.size;
            info.memoryTypeIndex = type;
            OwnedMemory block(device);
            result = device.table().vkAllocateMemory(device.handle(), &info, nullptr, block.out());
            if (result == VK_SUCCESS) return block;
        }
    }
    check(result, "vkAllocateMemory");
    return {};
}

}  // namespace

Formats::Formats(vulkan::Device& device) : depth(VK_FORMAT_D32_SFLOAT) {
    VkFormatProperties properties{};
    device.instance().calls().vkGetPhysicalDeviceFormatProperties(device.adapter().handle, depth, &properties);
    const bool usable = properties.optimalTilingFeatures & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT;
    if (!usable) depth = VK_FORMAT_X8_D24_UNORM_PACK32;  // every device has one of the two
}

RenderPasses::RenderPasses(vulkan::Device& device, const Formats& formats) {
    constexpr auto one = VK_SAMPLE_COUNT_1_BIT;
    constexpr auto clear = VK_ATTACHMENT_LOAD_OP_CLEAR, nothing = VK_ATTACHMENT_LOAD_OP_DONT_CARE;
    constexpr auto for_depth = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
    constexpr auto for_color = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    constexpr auto to_read = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    constexpr auto to_copy = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    surface = render_pass(device, {{attachment(Formats::surface, one, clear, true, to_read),
                                    attachment(formats.depth, one, clear, false, for_depth)},
                                   true,
                                   false,
                                   VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                                   VK_ACCESS_SHADER_READ_BIT});
    occlusion = render_pass(device, {{attachment(Formats::occlusion, one, nothing, true, to_read)},
                                     false,
                                     false,
                                     VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                                     VK_ACCESS_SHADER_READ_BIT});
    color = render_pass(device, {{attachment(Formats::color, Formats::samples, clear, false, for_color),
                                  attachment(formats.depth, Formats::samples, clear, false, for_depth),
                                  attachment(Formats::color, one, nothing, true, to_copy)},
                                 true,
                                 true,
                                 VK_PIPELINE_STAGE_TRANSFER_BIT,
                                 VK_ACCESS_TRANSFER_READ_BIT});
}

Image::Image(vulkan::Device& device, VkFormat format, VkExtent2D size, VkSampleCountFlagBits samples,
             VkImageUsageFlags usage)
    : memory(device), image(device), view(device) {
    const VolkDeviceTable& table = device.table();
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = format;
    info.extent = {size.width, size.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = 1;
    info.samples = samples;
    info.tiling = VK_IMAGE_TILING_OPTIMAL;
    info.usage = usage;
    info.sharingMode = VK_SHARING_MODE_EXCLUSIVE;
    info.initialLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    check(table.vkCreateImage(device.handle(), &info, nullptr, image.out()), "vkCreateImage");

    VkMemoryRequirements needs{};
    table.vkGetImageMemoryRequirements(device.handle(), image.get(), &needs);
    memory = allocate(device, needs);
    check(table.vkBindImageMemory(device.handle(), image.get(), memory.get(), 0), "vkBindImageMemory");

    VkImageViewCreateInfo look{};
    look.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    look.image = image.get();
    look.viewType = VK_IMAGE_VIEW_TYPE_2D;
    look.format = format;
    const VkImageAspectFlags aspect = is_depth(format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    look.subresourceRange = {aspect, 0, 1, 0, 1};
    check(table.vkCreateImageView(device.handle(), &look, nullptr, view.out()), "vkCreateImageView");
}

namespace {
constexpr VkImageUsageFlags drawn = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
constexpr VkImageUsageFlags drawn_and_read = drawn | VK_IMAGE_USAGE_SAMPLED_BIT;
constexpr VkImageUsageFlags depth_only = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
}  // namespace

Images::Images(vulkan::Device& device, const Formats& formats, const RenderPasses& passes, VkExtent2D extent)
    : size(extent),
      surface(device, Formats::surface, size, VK_SAMPLE_COUNT_1_BIT, drawn_and_read),
      surface_depth(device, formats.depth, size, VK_SAMPLE_COUNT_1_BIT, depth_only),
      occlusion(device, Formats::occlusion, size, VK_SAMPLE_COUNT_1_BIT, drawn_and_read),
      samples(device, Formats::color, size, Formats::samples, drawn),
      sample_depth(device, formats.depth, size, Formats::samples, depth_only),
      color(device, Formats::color, size, VK_SAMPLE_COUNT_1_BIT, drawn | VK_IMAGE_USAGE_TRANSFER_SRC_BIT) {
    const VkImageView of_surface[] = {surface.view.get(), surface_depth.view.get()};
    surface_frame = framebuffer(device, passes.surface, of_surface, size);
    const VkImageView of_occlusion[] = {occlusion.view.get()};
    occlusion_frame = framebuffer(device, passes.occlusion, of_occlusion, size);
    const VkImageView of_color[] = {samples.view.get(), sample_depth.view.get(), color.view.get()};
    color_frame = framebuffer(device, passes.color, of_color, size);
}

}  // namespace votess::gpu
