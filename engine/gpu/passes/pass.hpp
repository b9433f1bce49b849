// A compute pipeline.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gpu/vulkan/device.hpp"

namespace votess::gpu::vulkan {

// A specialization constant, its value as raw bits.
struct Constant {
    std::uint32_t id, value;
};

struct PassInfo {
    const char* name = "";
    std::span<const std::uint32_t> spirv;  // declares storage buffers of set 0, which the pass binds
    std::uint32_t push_bytes = 0;          // size of the push constants, a multiple of 4
    std::uint32_t local_size = 64;         // invocations of a work-group, all along x: CONSTANT_LOCAL_SIZE
    std::vector<Constant> constants = {};  // all others that the shader declares
    std::uint32_t subgroup_size = 0;       // asked for where the device lets one ask; 0 = any
};

// Throws `unsupported` when the device's limits are too small for it, `internal` when the constants are not those of
// the shader.
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
    [[nodiscard]] std::span<const std::uint32_t> bindings() const { return bindings_; }  // ascending
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
