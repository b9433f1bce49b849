#define VOLK_IMPLEMENTATION
#include "host.hpp"

#include <algorithm>
#include <cctype>

namespace host {
namespace {

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

bool matches(const std::string& wanted, std::size_t index, const VkPhysicalDeviceProperties& properties) {
    if (wanted == std::to_string(index)) return true;
    if (wanted == "lavapipe" && properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) return true;
    return lower(properties.deviceName).find(lower(wanted)) != std::string::npos;
}

votess::vulkan::HostInstance instance_for_votess(VkInstance instance) {
    return {.instance = instance, .get_instance_proc_addr = vkGetInstanceProcAddr, .api_version = VK_API_VERSION_1_1};
}

void barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
             VkAccessFlags read) {
    VkMemoryBarrier memory{};
    memory.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    memory.srcAccessMask = written;
    memory.dstAccessMask = read;
    vkCmdPipelineBarrier(commands, from, to, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

}  // namespace

void check(VkResult result, const char* call) {
    if (result < 0) throw std::runtime_error(std::string(call) + ": VkResult " + std::to_string(result));
}

Device::Device(const std::string& name, GetRequirements* get_requirements) {
    if (volkInitialize() != VK_SUCCESS) throw NoDevice("no Vulkan loader on this machine");
    try {
        create_instance();
        choose(name);
        create_device(get_requirements);
    } catch (...) {
        destroy();
        throw;
    }
}

Device::~Device() {
    destroy();
}

void Device::destroy() noexcept {
    cache_ = {};
    if (device_) vkDestroyDevice(device_, nullptr);
    if (instance_) vkDestroyInstance(instance_, nullptr);
}

void Device::create_instance() {
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "votess_host";
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;
    const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) throw NoDevice("no Vulkan driver on this machine");
    check(result, "vkCreateInstance");
    volkLoadInstance(instance_);
}

// Chooses the first device that matches, and its first queue family with compute.
void Device::choose(const std::string& name) {
    std::uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "vkEnumeratePhysicalDevices");
    std::vector<VkPhysicalDevice> all(count);
    check(vkEnumeratePhysicalDevices(instance_, &count, all.data()), "vkEnumeratePhysicalDevices");
    for (std::size_t i = 0; i < all.size(); ++i) {
        vkGetPhysicalDeviceProperties(all[i], &properties_);
        if (!matches(name, i, properties_)) continue;
        vkGetPhysicalDeviceQueueFamilyProperties(all[i], &count, nullptr);
        std::vector<VkQueueFamilyProperties> families(count);
        vkGetPhysicalDeviceQueueFamilyProperties(all[i], &count, families.data());
        for (queue_family_ = 0; queue_family_ < count; ++queue_family_) {
            if ((families[queue_family_].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0) continue;
            timestamp_bits_ = families[queue_family_].timestampValidBits;
            physical_ = all[i];
            return;
        }
    }
    throw NoDevice("no Vulkan device that computes is named " + name);
}

void Device::create_device(GetRequirements* get_requirements) {
    if (get_requirements) requirements_ = get_requirements(instance_for_votess(instance_), physical_);
    if (!requirements_.missing.empty()) throw std::runtime_error("votess: " + requirements_.missing);
    std::vector<const char*> extensions;
    for (const std::string& extension : requirements_.extensions) extensions.push_back(extension.c_str());
    VkPhysicalDeviceSubgroupSizeControlFeatures sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES;
    sizes.subgroupSizeControl = sizes.computeFullSubgroups = VK_TRUE;
    // An extension, because the instance is of Vulkan 1.1.
    if (requirements_.subgroup_size_control) extensions.push_back(VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME);

    const float priority = 1;
    VkDeviceQueueCreateInfo queue{};
    queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue.queueFamilyIndex = queue_family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.pNext = requirements_.subgroup_size_control ? &sizes : nullptr;
    info.pEnabledFeatures = &requirements_.features;
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    check(vkCreateDevice(physical_, &info, nullptr, &device_), "vkCreateDevice");
    volkLoadDevice(device_);
    vkGetDeviceQueue(device_, queue_family_, 0, &queue_);

    VkPipelineCacheCreateInfo cache{};
    cache.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
    VkPipelineCache handle = VK_NULL_HANDLE;
    check(vkCreatePipelineCache(device_, &cache, nullptr, &handle), "vkCreatePipelineCache");
    cache_ = {device_, handle, vkDestroyPipelineCache};
}

votess::vulkan::HostDevice Device::for_votess() const {
    return {.host = instance_for_votess(instance_),
            .physical_device = physical_,
            .device = device_,
            .queue_family = queue_family_,
            .features = requirements_.features,
            .subgroup_size_control = requirements_.subgroup_size_control,
            .pipeline_cache = cache_.get(),
            .probe_queue = queue_};
}

std::uint32_t Device::memory_type(std::uint32_t allowed, VkMemoryPropertyFlags needed,
                                  VkMemoryPropertyFlags preferred) const {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
    for (const VkMemoryPropertyFlags wanted : {needed | preferred, needed}) {
        for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
            if ((allowed >> i & 1) != 0 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
        }
    }
    throw std::runtime_error("no memory type that fits");
}

Buffer::Buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, Place place) : bytes_(bytes) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = bytes;
    info.usage = usage;
    VkBuffer buffer = VK_NULL_HANDLE;
    check(vkCreateBuffer(device.handle(), &info, nullptr, &buffer), "vkCreateBuffer");
    buffer_ = {device.handle(), buffer, vkDestroyBuffer};

    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device.handle(), buffer, &needs);
    VkMemoryAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocate.allocationSize = needs.size;
    constexpr VkMemoryPropertyFlags visible =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    allocate.memoryTypeIndex =
        place == Place::host ? device.memory_type(needs.memoryTypeBits, visible, VK_MEMORY_PROPERTY_HOST_CACHED_BIT)
                             : device.memory_type(needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
    VkDeviceMemory memory = VK_NULL_HANDLE;
    check(vkAllocateMemory(device.handle(), &allocate, nullptr, &memory), "vkAllocateMemory");
    memory_ = {device.handle(), memory, vkFreeMemory};
    check(vkBindBufferMemory(device.handle(), buffer, memory, 0), "vkBindBufferMemory");
    if (place == Place::device) return;
    void* mapped = nullptr;
    check(vkMapMemory(device.handle(), memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    mapped_ = static_cast<std::byte*>(mapped);
}

void run_once(const Device& device, const std::function<void(VkCommandBuffer)>& record) {
    VkCommandPoolCreateInfo pool_info{};
    pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool_info.queueFamilyIndex = device.queue_family();
    VkCommandPool pool_handle = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device.handle(), &pool_info, nullptr, &pool_handle), "vkCreateCommandPool");
    const Owned<VkCommandPool> pool{device.handle(), pool_handle, vkDestroyCommandPool};

    VkCommandBufferAllocateInfo commands_info{};
    commands_info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    commands_info.commandPool = pool_handle;
    commands_info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    commands_info.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    check(vkAllocateCommandBuffers(device.handle(), &commands_info, &commands), "vkAllocateCommandBuffers");

    VkFenceCreateInfo fence_info{};
    fence_info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
    VkFence fence_handle = VK_NULL_HANDLE;
    check(vkCreateFence(device.handle(), &fence_info, nullptr, &fence_handle), "vkCreateFence");
    const Owned<VkFence> fence{device.handle(), fence_handle, vkDestroyFence};

    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    record(commands);
    check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    check(vkQueueSubmit(device.queue(), 1, &submit, fence_handle), "vkQueueSubmit");
    constexpr std::uint64_t minutes = 60'000'000'000;
    const VkResult result = vkWaitForFences(device.handle(), 1, &fence_handle, VK_TRUE, 5 * minutes);
    check(result, "vkWaitForFences");
    if (result == VK_TIMEOUT) throw std::runtime_error("the device has not finished after five minutes");
}

void upload(const Device& device, std::span<const std::byte> bytes, VkBuffer target) {
    const Buffer staging(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Place::host);
    std::copy(bytes.begin(), bytes.end(), staging.mapped().begin());
    run_once(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy copy{0, 0, bytes.size()};
        vkCmdCopyBuffer(commands, staging.get(), target, 1, &copy);
        barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_ACCESS_MEMORY_READ_BIT);
    });
}

std::vector<std::byte> download(const Device& device, VkBuffer source, VkDeviceSize bytes) {
    const Buffer staging(device, bytes, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::host);
    run_once(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy copy{0, 0, bytes};
        vkCmdCopyBuffer(commands, source, staging.get(), 1, &copy);
        barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                VK_ACCESS_HOST_READ_BIT);
    });
    return {staging.mapped().begin(), staging.mapped().end()};
}

Owned<VkQueryPool> make_timestamps(const Device& device, std::uint32_t count) {
    if (device.timestamp_bits() == 0) return {};
    VkQueryPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = count;
    VkQueryPool pool = VK_NULL_HANDLE;
    check(vkCreateQueryPool(device.handle(), &info, nullptr, &pool), "vkCreateQueryPool");
    return {device.handle(), pool, vkDestroyQueryPool};
}

std::vector<double> seconds_of(const Device& device, VkQueryPool pool, std::uint32_t count) {
    if (pool == VK_NULL_HANDLE) return {};
    std::vector<std::uint64_t> ticks(count);
    check(vkGetQueryPoolResults(device.handle(), pool, 0, count, count * sizeof ticks[0], ticks.data(), sizeof ticks[0],
                                VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "vkGetQueryPoolResults");
    // The counter wraps around after so many bits.
    const std::uint32_t bits = device.timestamp_bits();
    const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    const double period = static_cast<double>(device.limits().timestampPeriod) * 1e-9;
    std::vector<double> seconds;
    for (const std::uint64_t tick : ticks) seconds.push_back(static_cast<double>((tick - ticks[0]) & mask) * period);
    return seconds;
}

}  // namespace host
