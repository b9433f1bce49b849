#include "gpu/vulkan/pass.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/thread_pool.hpp"
#include "gpu/vulkan/spirv.hpp"
#include "shared/interface.h"

namespace votess::gpu::vulkan {
namespace {

void require(bool good, const Device& device, const std::string& pass, const std::string& what) {
    if (good) return;
    throw Error(ErrorCode::unsupported,
                "the pass " + pass + " needs " + what + ", which is above the limits of " + device.adapter().name);
}

// Returns the constants of the info and the local size. Throws unless the shader declares exactly these.
std::vector<Constant> all_constants(const PassInfo& info) {
    std::vector<Constant> constants{{CONSTANT_LOCAL_SIZE, info.local_size}};
    constants.insert(constants.end(), info.constants.begin(), info.constants.end());
    std::ranges::sort(constants, {}, &Constant::id);
    if (!std::ranges::equal(constants, declared(info.spirv, Decoration::constant_id), {}, &Constant::id))
        throw Error(ErrorCode::internal, std::string("the pass ") + info.name +
                                             " does not set exactly the constants that its shader declares");
    return constants;
}

}  // namespace

Pass::Pass(Device& device, const PassInfo& info) : made_(std::make_shared<Made>(device, info)) {
    made_->make_pipeline(info);
}

PassBatch::PassBatch(Device& device) : device_(device), cache_(device.pass_cache()), lock_(cache_.mutex_) {}

PassBatch::~PassBatch() {
    std::erase_if(cache_.known_, [](const auto& known) { return known.pass.pipeline() == VK_NULL_HANDLE; });
}

Pass PassBatch::get(const PassInfo& info) {
    std::vector<PassCache::Known>& all = cache_.known_;
    const auto same = [&](const auto& known) {
        return known.info.spirv.data() == info.spirv.data() && known.info.push_bytes == info.push_bytes &&
               known.info.local_size == info.local_size && known.info.constants == info.constants &&
               known.info.subgroup_size == info.subgroup_size;
    };
    if (const auto found = std::ranges::find_if(all, same); found != all.end()) {
        std::rotate(found, found + 1, all.end());
        return all.back().pass;
    }
    all.push_back({info, Pass(std::make_shared<Pass::Made>(device_, info))});
    const auto unused = [](const auto& known) { return !known.pass.is_shared(); };
    if (std::ranges::count_if(all, unused) > std::ptrdiff_t{PassCache::max_unused})
        all.erase(std::ranges::find_if(all, unused));
    return all.back().pass;
}

void PassBatch::make() {
    std::vector<PassCache::Known*> missing;
    for (auto& known : cache_.known_)
        if (known.pass.pipeline() == VK_NULL_HANDLE) missing.push_back(&known);
    const auto make_one = [&](std::size_t i, unsigned) { missing[i]->pass.made_->make_pipeline(missing[i]->info); };
    if (missing.size() == 1)
        make_one(0, 0);
    else if (!missing.empty())
        ThreadPool(0).run(missing.size(), make_one);
}

Pass::Made::Made(Device& of, const PassInfo& info)
    : device(of),
      name(info.name),
      bindings(declared(info.spirv, Decoration::binding)),
      push_bytes(info.push_bytes),
      local_size(info.local_size) {
    const VkPhysicalDeviceLimits& limits = device.adapter().limits;
    require(local_size <= limits.maxComputeWorkGroupInvocations && local_size <= limits.maxComputeWorkGroupSize[0],
            device, name, "work-groups of " + std::to_string(local_size));
    require(push_bytes <= limits.maxPushConstantsSize, device, name,
            std::to_string(push_bytes) + " bytes of push constants");
    require(bindings.size() <= limits.maxPerStageDescriptorStorageBuffers, device, name,
            std::to_string(bindings.size()) + " storage buffers");
    try {
        make_layout();
    } catch (...) {
        destroy();
        throw;
    }
}

Pass::Made::~Made() {
    destroy();
}

void Pass::Made::destroy() const noexcept {
    const VolkDeviceTable& table = device.table();
    // Vulkan ignores null handles here.
    table.vkDestroyPipeline(device.handle(), pipeline, nullptr);
    table.vkDestroyPipelineLayout(device.handle(), layout, nullptr);
    table.vkDestroyDescriptorSetLayout(device.handle(), set_layout, nullptr);
}

void Pass::Made::make_layout() {
    std::vector<VkDescriptorSetLayoutBinding> slots;
    for (const std::uint32_t number : bindings) {
        slots.push_back({number, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    }
    const VolkDeviceTable& table = device.table();
    auto set = structure<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
    set.bindingCount = static_cast<std::uint32_t>(slots.size());
    set.pBindings = slots.data();
    check(table.vkCreateDescriptorSetLayout(device.handle(), &set, nullptr, &set_layout),
          "vkCreateDescriptorSetLayout");

    const VkPushConstantRange push{VK_SHADER_STAGE_COMPUTE_BIT, 0, push_bytes};
    auto create = structure<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
    create.setLayoutCount = 1;
    create.pSetLayouts = &set_layout;
    create.pushConstantRangeCount = push_bytes > 0 ? 1 : 0;
    create.pPushConstantRanges = &push;
    check(table.vkCreatePipelineLayout(device.handle(), &create, nullptr, &layout), "vkCreatePipelineLayout");
    device.name(layout, VK_OBJECT_TYPE_PIPELINE_LAYOUT, name.c_str());
}

void Pass::Made::make_pipeline(const PassInfo& info) {
    const VolkDeviceTable& table = device.table();
    const Adapter& adapter = device.adapter();
    const std::vector<std::uint32_t> spirv = with_demands(info.spirv, device.demands());
    auto code = structure<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
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

    auto create = structure<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
    create.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    create.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    create.stage.pName = "main";
    create.stage.pSpecializationInfo = &specialization;
    auto size = structure<VkPipelineShaderStageRequiredSubgroupSizeCreateInfo>(
        VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO);
    size.requiredSubgroupSize = info.subgroup_size;
    if (adapter.subgroup_size_control && info.subgroup_size >= adapter.min_subgroup_size &&
        info.subgroup_size <= adapter.max_subgroup_size) {
        create.stage.pNext = &size;
        create.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT;
    }
    create.layout = layout;
    check(table.vkCreateShaderModule(device.handle(), &code, nullptr, &create.stage.module), "vkCreateShaderModule");
    const VkResult result =
        table.vkCreateComputePipelines(device.handle(), device.cache_handle(), 1, &create, nullptr, &pipeline);
    // The module is not needed any more, with or without a pipeline.
    table.vkDestroyShaderModule(device.handle(), create.stage.module, nullptr);
    if (result < 0) pipeline = VK_NULL_HANDLE;
    check(result, ("vkCreateComputePipelines for " + name).c_str());
    device.name(pipeline, VK_OBJECT_TYPE_PIPELINE, name.c_str());
}

}  // namespace votess::gpu::vulkan
