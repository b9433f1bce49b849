// A compute pipeline.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gpu/vulkan/device.hpp"

namespace votess::gpu::vulkan {

struct PassInfo {
    const char* name = "";
    std::span<const std::uint32_t> spirv;
    std::vector<std::uint32_t> bindings;   // numbers of the storage buffers in set 0; gaps are fine
    std::uint32_t push_bytes = 0;          // of push constants, a multiple of 4
    std::uint32_t local_size = 64;         // invocations of a work-group, all along x: specialization constant 0
    std::vector<std::uint32_t> constants;  // raw 32-bit values of specialization constants 1, 2, ...
    std::uint32_t subgroup_size = 0;       // asked for where the device lets one ask; 0 = any
};

// Throws `unsupported` when the device's limits are too small for it.
class Pass {
public:
    Pass(Device& device, const PassInfo& info);
    Pass(Pass&& other) noexcept;
    Pass& operator=(Pass&& other) noexcept;
    ~Pass();

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] VkPipeline pipeline() const { return pipeline_; }
    [[nodiscard]] VkPipelineLayout layout() const { return layout_; }
    [[nodiscard]] VkDescriptorSetLayout set_layout() const { return set_layout_; }
    [[nodiscard]] std::span<const std::uint32_t> bindings() const { return bindings_; }
    [[nodiscard]] std::uint32_t push_bytes() const { return push_bytes_; }
    [[nodiscard]] std::uint32_t local_size() const { return local_size_; }

private:
    void make_layout();
    void make_pipeline(const PassInfo& info);
    void destroy() noexcept;

    Device* device_;
    std::string name_;
    std::vector<std::uint32_t> bindings_;
    std::uint32_t push_bytes_;
    std::uint32_t local_size_;
    VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout layout_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
};

}  // namespace votess::gpu::vulkan
