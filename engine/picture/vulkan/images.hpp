// The images that a part of a picture is drawn into, and the passes that draw into them.
#pragma once

#include <array>

#include "picture/vulkan/owned.hpp"

namespace votess::gpu {

// The formats that the passes use. Colors are formats that every device has.
struct Formats {
    static constexpr VkFormat surface = VK_FORMAT_R32G32B32A32_SFLOAT;  // normal, distance
    static constexpr VkFormat occlusion = VK_FORMAT_R8_UNORM;
    static constexpr VkFormat color = VK_FORMAT_R8G8B8A8_UNORM;
    static constexpr VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_4_BIT;  // every device has it
    VkFormat depth;

    explicit Formats(vulkan::Device& device);
};

// The three passes: surfaces, occlusion, color.
struct RenderPasses {
    OwnedRenderPass surface, occlusion, color;

    RenderPasses(vulkan::Device& device, const Formats& formats);
};

struct Image {
    OwnedMemory memory;  // destroyed last
    OwnedImage image;
    OwnedImageView view;

    Image(vulkan::Device& device, VkFormat format, VkExtent2D size, VkSampleCountFlagBits samples,
          VkImageUsageFlags usage);
};

// All images of one size with their framebuffers.
struct Images {
    VkExtent2D size;
    Image surface, surface_depth, occlusion, samples, sample_depth, color;
    OwnedFramebuffer surface_frame, occlusion_frame, color_frame;

    Images(vulkan::Device& device, const Formats& formats, const RenderPasses& passes, VkExtent2D size);
};

}  // namespace votess::gpu
