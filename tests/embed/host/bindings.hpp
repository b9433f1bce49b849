// What shaders see: a descriptor set of storage buffers at bindings 0, 1, ..., and push constants.
#pragma once

#include <cstdint>
#include <span>

#include "host_device.hpp"

namespace host {

class Bindings {
public:
    Bindings(const HostDevice& device, VkShaderStageFlags stage, std::uint32_t buffers, std::uint32_t max_sets,
             std::uint32_t push_bytes);

    [[nodiscard]] VkPipelineLayout layout() const { return layout_.get(); }
    // A new set of these buffers; it lives as long as this object.
    [[nodiscard]] VkDescriptorSet set(std::span<const VkDescriptorBufferInfo> buffers) const;

private:
    VkDevice device_;
    Owned<VkDescriptorSetLayout> set_layout_;
    Owned<VkPipelineLayout> layout_;
    Owned<VkDescriptorPool> pool_;
};

[[nodiscard]] Owned<VkShaderModule> make_shader(const HostDevice& device, std::span<const std::uint32_t> words);
[[nodiscard]] VkPipelineShaderStageCreateInfo stage_info(VkShaderStageFlagBits stage, VkShaderModule module);

}  // namespace host
