#include "gpu/vulkan/device.hpp"

#include <utility>
#include <vector>

#include "gpu/vulkan/pass.hpp"

namespace votess::gpu::vulkan {

template <class How>
std::shared_ptr<Device> Device::make(std::shared_ptr<Instance> instance, const Adapter& adapter, const How& how) {
    if (const std::string lack = adapter.missing(); !lack.empty())
        throw Error(ErrorCode::unsupported, "votess cannot use the device " + adapter.name + ": it " + lack);
    std::shared_ptr<Device> device(new Device(std::move(instance), adapter, how));
    device->find_rounding();
    device->find_subgroup_size();
    return device;
}

std::shared_ptr<Device> Device::create(std::shared_ptr<Instance> instance, const Adapter& adapter,
                                       const DeviceOptions& options) {
    return make(std::move(instance), adapter, options);
}

Device::Device(std::shared_ptr<Instance> instance, const Adapter& adapter, const DeviceOptions& options)
    : instance_(std::move(instance)),
      adapter_(adapter),
      float64_(options.float64 && adapter.float64),
      passes_(std::make_unique<PassCache>()) {
    const float priority = 1;
    auto queue = structure<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
    queue.queueFamilyIndex = adapter_.queue_family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;

    VkPhysicalDeviceFeatures features{};
    features.shaderFloat64 = float64_;
    std::vector<const char*> extensions;
    if (adapter_.portability_subset) extensions.push_back("VK_KHR_portability_subset");

    auto sizes = structure<VkPhysicalDeviceSubgroupSizeControlFeatures>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES);
    sizes.subgroupSizeControl = sizes.computeFullSubgroups = VK_TRUE;
    if (adapter_.subgroup_size_control && adapter_.subgroup_size_extension)
        extensions.push_back(VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME);
    auto timeline = structure<VkPhysicalDeviceTimelineSemaphoreFeatures>(
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_TIMELINE_SEMAPHORE_FEATURES);
    timeline.timelineSemaphore = VK_TRUE;
    if (options.exports) {
        extensions.push_back(VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME);
        if (adapter_.exports_semaphores) extensions.push_back(VK_KHR_EXTERNAL_SEMAPHORE_FD_EXTENSION_NAME);
    }
    auto info = structure<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
    if (adapter_.subgroup_size_control) info.pNext = &sizes;
    if (options.exports) timeline.pNext = const_cast<void*>(std::exchange(info.pNext, &timeline));
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.pEnabledFeatures = &features;
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const InstanceCalls& calls = instance_->calls();
    check(calls.vkCreateDevice(adapter_.handle, &info, nullptr, &handle_), "vkCreateDevice");
    load_device_table(table_, handle_, calls.vkGetDeviceProcAddr);
    try {
        table_.vkGetDeviceQueue(handle_, adapter_.queue_family, 0, &queue_);
        cache_.emplace(table_, handle_, adapter_);
    } catch (...) {
        table_.vkDestroyDevice(handle_, nullptr);
        throw;
    }
}

std::shared_ptr<Device> Device::adopt(std::shared_ptr<Instance> instance, const Adapter& adapter,
                                      const HostDevice& host) {
    return make(std::move(instance), adapter, host);
}

Device::Device(std::shared_ptr<Instance> instance, const Adapter& adapter, const HostDevice& host)
    : instance_(std::move(instance)),
      adapter_(adapter),
      handle_(host.handle),
      queue_(host.queue),
      float64_(host.float64),
      passes_(std::make_unique<PassCache>()),
      host_cache_(host.pipeline_cache),
      owned_(false) {
    adapter_.queue_family = host.queue_family;
    adapter_.subgroup_size_control = adapter_.subgroup_size_control && host.subgroup_size_control;
    load_device_table(table_, handle_, instance_->calls().vkGetDeviceProcAddr);
}

// Shaders demand that infinities and NaN are kept, except on NVIDIA's devices, which keep them anyway. They demand to
// round to nearest where a device rounds otherwise: NVIDIA's compiler makes slower code with that demand, by a tenth
// for a cell.
void Device::find_rounding() {
    constexpr std::uint32_t nvidia = 0x10de;
    const FloatDemands& offered = adapter_.offered;
    if (adapter_.vendor_id != nvidia) demands_ = {false, false, offered.infinities32, offered.infinities64};
    const bool can_probe = queue_ != VK_NULL_HANDLE;
    if (can_probe) rounding_ = probe_rounding(*this, float64_);
    if (rounding_.nearest32 && (rounding_.nearest64 || !float64_)) return;
    demands_.nearest32 = offered.nearest32;
    demands_.nearest64 = offered.nearest64;
    if (can_probe && (demands_.nearest32 || demands_.nearest64)) rounding_ = probe_rounding(*this, float64_);
}

// Drivers may report a nominal size that no shader has, as MoltenVK does. Kernels check the size again, and leave all
// cells if it is another one.
void Device::find_subgroup_size() {
    constexpr VkSubgroupFeatureFlags needed = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;
    Adapter& a = adapter_;
    if (a.subgroup_size_control || a.min_subgroup_size == a.max_subgroup_size || queue_ == VK_NULL_HANDLE ||
        !a.subgroup_in_compute || (a.subgroup_operations & needed) != needed)
        return;
    const std::uint32_t size = probe_subgroup_size(*this);
    if (size > 0) a.subgroup_size = a.min_subgroup_size = a.max_subgroup_size = size;
}

Device::~Device() {
    passes_.reset();
    cache_.reset();
    if (owned_) table_.vkDestroyDevice(handle_, nullptr);
}

void Device::submit(const VkSubmitInfo& info, VkFence fence) {
    std::lock_guard lock(queue_mutex_);
    check(table_.vkQueueSubmit(queue_, 1, &info, fence), "vkQueueSubmit");
}

void Device::drain() noexcept {
    std::lock_guard lock(queue_mutex_);
    table_.vkDeviceWaitIdle(handle_);
}

void Device::set_name(std::uint64_t object, VkObjectType type, const char* text) {
    if (!instance_->debug_utils() || !text) return;
    auto info = structure<VkDebugUtilsObjectNameInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
    info.objectType = type;
    info.objectHandle = object;
    info.pObjectName = text;
    // A failure does not matter: everything works without a name.
    instance_->calls().vkSetDebugUtilsObjectNameEXT(handle_, &info);
}

}  // namespace votess::gpu::vulkan
