#include "gpu/passes/pass.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "gpu/passes/spirv.hpp"
#include "shared/interface.h"

namespace votess::gpu::vulkan {
namespace {

void require(bool good, const Device& device, const std::string& pass, const std::string& what) {
    if (good) return;
    throw Error(ErrorCode::unsupported,
                "the pass " + pass + " needs " + what + ", which is above the limits of " + device.adapter().name);
}

// The constants of the info and the local size; throws unless the shader declares just these.
std::vector<Constant> all_constants(const PassInfo& info) {
    std::vector<Constant> constants{{CONSTANT_LOCAL_SIZE, info.local_size}};
    constants.insert(constants.end(), info.constants.begin(), info.constants.end());
    std::ranges::sort(constants, {}, &Constant::id);
    if (!std::ranges::equal(constants, declared(info.spirv, Decoration::constant_id), {}, &Constant::id))
        throw Error(ErrorCode::internal,
                    std::string("the pass ") + info.name + " sets other constants than its shader declares");
    return constants;
}

}  // namespace

Pass::Pass(Device& device, const PassInfo& info)
    : device_(&device),
      name_(info.name),
      bindings_(declared(info.spirv, Decoration::binding)),
      push_bytes_(info.push_bytes),
      local_size_(info.local_size) {
    const VkPhysicalDeviceLimits& limits = device.adapter().limits;
    require(local_size_ <= limits.maxComputeWorkGroupInvocations && local_size_ <= limits.maxComputeWorkGroupSize[0],
            device, name_, "work-groups of " + std::to_string(local_size_));
    require(push_bytes_ <= limits.maxPushConstantsSize, device, name_,
            std::to_string(push_bytes_) + " bytes of push constants");
    require(bindings_.size() <= limits.maxPerStageDescriptorStorageBuffers, device, name_,
            std::to_string(bindings_.size()) + " storage buffers");
    try {
        make_layout();
        make_pipeline(info);
    } catch (...) {
        destroy();
        throw;
    }
}

Pass::Pass(Pass&& other) noexcept
    : device_(other.device_),
      name_(std::move(other.name_)),
      bindings_(std::move(other.bindings_)),
      push_bytes_(other.push_bytes_),
      local_size_(other.local_size_),
      set_layout_(std::exchange(other.set_layout_, VK_NULL_HANDLE)),
      layout_(std::exchange(other.layout_, VK_NULL_HANDLE)),
      pipeline_(std::exchange(other.pipeline_, VK_NULL_HANDLE)) {}

Pass& Pass::operator=(Pass&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(name_, other.name_);
    std::swap(bindings_, other.bindings_);
    std::swap(push_bytes_, other.push_bytes_);
    std::swap(local_size_, other.local_size_);
    std::swap(set_layout_, other.set_layout_);
    std::swap(layout_, other.layout_);
    std::swap(pipeline_, other.pipeline_);
    return *this;
}

Pass::~Pass() {
    destroy();
}

void Pass::destroy() noexcept {
    const VolkDeviceTable& table = device_->table();
    // Vulkan ignores null handles here.
    table.vkDestroyPipeline(device_->handle(), pipeline_, nullptr);
    table.vkDestroyPipelineLayout(device_->handle(), layout_, nullptr);
    table.vkDestroyDescriptorSetLayout(device_->handle(), set_layout_, nullptr);
}

void Pass::make_layout() {
    std::vector<VkDescriptorSetLayoutBinding> slots;
    for (const std::uint32_t number : bindings_) {
        slots.push_back({number, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    }
    const VolkDeviceTable& table = device_->table();
    VkDescriptorSetLayoutCreateInfo set{};
    set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    set.bindingCount = static_cast<std::uint32_t>(slots.size());
    set.pBindings = slots.data();
    check(table.vkCreateDescriptorSetLayout(device_->handle(), &set, nullptr, &set_layout_),
          "vkCreateDescriptorSetLayout");

    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, push_bytes_};
    VkPipelineLayoutCreateInfo layout{};
    layout.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &set_layout_;
    layout.pushConstantRangeCount = push_bytes_ > 0 ? 1 : 0;
    layout.pPushConstantRanges = &push;
    check(table.vkCreatePipelineLayout(device_->handle(), &layout, nullptr, &layout_), "vkCreatePipelineLayout");
    device_->name(layout_, VK_OBJECT_TYPE_PIPELINE_LAYOUT, name_.c_str());
}

void Pass::make_pipeline(const PassInfo& info) {
    const VolkDeviceTable& table = device_->table();
    const Adapter& adapter = device_->adapter();
    const std::vector<std::uint32_t> spirv =
        rounding_to_nearest(info.spirv, adapter.can_ask_for_nearest32, adapter.can_ask_for_nearest64);
    VkShaderModuleCreateInfo code{};
    code.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    code.codeSize = std::span(spirv).size_bytes();
    code.pCode = spirv.data();

    const std::vector<Constant> constants = all_constants(info);
    std::vector<VkSpecializationMapEntry> entries;
    for (std::size_t i = 0; i < constants.size(); ++i) {
        const std::size_t offset = i * sizeof(Constant) + offsetof(Constant, value);
        entries.push_back({constants[i].id, static_cast<std::uint32_t>(offset), sizeof(Constant::value)});
    }
    VkSpecializationInfo specialization{};
    specialization.mapEntryCount = static_cast<std::uint32_t>(entries.size());
    specialization.pMapEntries = entries.data();
    specialization.dataSize = std::span(constants).size_bytes();
    specialization.pData = constants.data();

    VkComputePipelineCreateInfo pipeline{};
    pipeline.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    pipeline.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    pipeline.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    pipeline.stage.pName = "main";
    pipeline.stage.pSpecializationInfo = &specialization;
    VkPipelineShaderStageRequiredSubgroupSizeCreateInfo size{};
    size.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO;
    size.requiredSubgroupSize = info.subgroup_size;
    if (adapter.subgroup_size_control && info.subgroup_size >= adapter.min_subgroup_size &&
        info.subgroup_size <= adapter.max_subgroup_size) {
        pipeline.stage.pNext = &size;
        pipeline.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT;
    }
    pipeline.layout = layout_;
    check(table.vkCreateShaderModule(device_->handle(), &code, nullptr, &pipeline.stage.module),
          "vkCreateShaderModule");
    const VkResult result =
        table.vkCreateComputePipelines(device_->handle(), device_->cache_handle(), 1, &pipeline, nullptr, &pipeline_);
    // The module is not needed any more, whatever came out.
    table.vkDestroyShaderModule(device_->handle(), pipeline.stage.module, nullptr);
    if (result < 0) pipeline_ = VK_NULL_HANDLE;
    check(result, ("vkCreateComputePipelines for " + name_).c_str());
    device_->name(pipeline_, VK_OBJECT_TYPE_PIPELINE, name_.c_str());
}

}  // namespace votess::gpu::vulkan
