#include "moving.hpp"

#include <host_shaders.hpp>

namespace host {

Moving::Moving(const HostDevice& device, std::uint32_t max_sets)
    : bindings_(device, VK_SHADER_STAGE_COMPUTE_BIT, 2, max_sets, sizeof(MovePush)) {
    const Owned<VkShaderModule> module = make_shader(device, votess::gpu::shaders::move);
    VkComputePipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    info.stage = stage_info(VK_SHADER_STAGE_COMPUTE_BIT, module.get());
    info.layout = bindings_.layout();
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device.device(), device.pipeline_cache(), 1, &info, nullptr, &pipeline),
          "vkCreateComputePipelines");
    pipeline_ = {device.device(), pipeline, vkDestroyPipeline};
}

VkDescriptorSet Moving::set(VkBuffer source, VkBuffer target) const {
    const VkDescriptorBufferInfo buffers[] = {{source, 0, VK_WHOLE_SIZE}, {target, 0, VK_WHOLE_SIZE}};
    return bindings_.set(buffers);
}

void Moving::record(VkCommandBuffer commands, VkDescriptorSet set, const MovePush& push) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_.get());
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, bindings_.layout(), 0, 1, &set, 0, nullptr);
    vkCmdPushConstants(commands, bindings_.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof push, &push);
    vkCmdDispatch(commands, (push.count + 63) / 64, 1, 1);
}

}  // namespace host
