// The host's picture: one pass over all pixels, whose shader follows rays through the cells.
#pragma once

#include <array>

#include "bindings.hpp"
#include "shaders/push.h"

namespace host {

// An image to draw to, left in the layout that copies read.
struct Target {
    Owned<VkDeviceMemory> memory;
    Owned<VkImage> image;
    Owned<VkImageView> view;
    Owned<VkFramebuffer> framebuffer;
};

class Drawing {
public:
    Drawing(const HostDevice& device, std::uint32_t width, std::uint32_t height, std::uint32_t max_sets);

    [[nodiscard]] Target make_target() const;
    // Seeds, cells, indices, geometry; those that votess reads and writes.
    [[nodiscard]] VkDescriptorSet set(const std::array<VkDescriptorBufferInfo, 4>& buffers) const;
    void record(VkCommandBuffer commands, VkDescriptorSet set, const Target& target, const DrawPush& push) const;
    // To a buffer of width * height * 4 bytes.
    void record_copy(VkCommandBuffer commands, const Target& target, VkBuffer buffer) const;
    // How the box is seen from around it; all but count and samples.
    [[nodiscard]] DrawPush view(float azimuth) const;

private:
    void make_render_pass();
    void make_pipeline();

    const HostDevice& device_;
    VkExtent2D extent_;
    Bindings bindings_;
    Owned<VkRenderPass> render_pass_;
    Owned<VkPipeline> pipeline_;
};

}  // namespace host
