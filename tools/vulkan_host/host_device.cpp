#include "host_device.hpp"

#include <algorithm>
#include <cctype>

namespace host {
namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

// The first queue family that has these; VK_QUEUE_FAMILY_IGNORED where there is none.
std::uint32_t family_with(VkPhysicalDevice physical, VkQueueFlags flags, std::uint32_t& timestamp_bits) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    const auto it =
        std::find_if(families.begin(), families.end(), [&](const auto& f) { return (f.queueFlags & flags) == flags; });
    if (it == families.end()) return VK_QUEUE_FAMILY_IGNORED;
    timestamp_bits = it->timestampValidBits;
    return static_cast<std::uint32_t>(it - families.begin());
}

bool matches(const std::string& wanted, std::size_t index, const VkPhysicalDeviceProperties& properties) {
    if (wanted.empty() || wanted == std::to_string(index)) return true;
    if (wanted == "lavapipe" && properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU) return true;
    return lower(properties.deviceName).find(lower(wanted)) != std::string::npos;
}

votess::vulkan::HostInstance instance_for_votess(VkInstance instance) {
    return {.instance = instance, .get_instance_proc_addr = vkGetInstanceProcAddr, .api_version = VK_API_VERSION_1_1};
}

}  // namespace

void check(VkResult result, const char* call) {
    if (result < 0) throw std::runtime_error(std::string(call) + ": VkResult " + std::to_string(result));
}

void Messages::add(std::string line) {
    std::lock_guard lock(mutex_);
    lines_.push_back(std::move(line));
}

std::vector<std::string> Messages::lines() const {
    std::lock_guard lock(mutex_);
    return lines_;
}

HostDevice::HostDevice(const DeviceOptions& options, Messages& messages)
    : validate_(options.validate), messages_(messages) {
    if (volkInitialize() != VK_SUCCESS) throw NoDevice("no Vulkan loader on this machine");
    try {
        create_instance();
        choose(options.name, options.draws);
        create_device(options.float64);
    } catch (...) {
        destroy();
        throw;
    }
}

HostDevice::~HostDevice() {
    destroy();
}

void HostDevice::destroy() noexcept {
    cache_ = {};
    if (device_) vkDestroyDevice(device_, nullptr);
    if (messenger_) vkDestroyDebugUtilsMessengerEXT(instance_, messenger_, nullptr);
    if (instance_) vkDestroyInstance(instance_, nullptr);
}

void HostDevice::create_instance() {
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "votess_host";
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;

    VkDebugUtilsMessengerCreateInfoEXT messenger{};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = on_message;
    messenger.pUserData = &messages_;
    const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{};
    features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    features.pNext = &messenger;
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronization;
    const std::vector<const char*> extensions = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME,
                                                 VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    if (validate_ > 0) {
        info.enabledLayerCount = 1;
        info.ppEnabledLayerNames = &validation_layer;
        info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
        info.ppEnabledExtensionNames = extensions.data();
        info.pNext = validate_ > 1 ? static_cast<const void*>(&features) : &messenger;
    }
    const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) throw NoDevice("no Vulkan driver on this machine");
    check(result, "vkCreateInstance");
    volkLoadInstance(instance_);
    if (validate_ > 0) {
        check(vkCreateDebugUtilsMessengerEXT(instance_, &messenger, nullptr, &messenger_),
              "vkCreateDebugUtilsMessengerEXT");
    }
}

void HostDevice::choose(const std::string& name, bool draws) {
    std::uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance_, &count, nullptr), "vkEnumeratePhysicalDevices");
    std::vector<VkPhysicalDevice> all(count);
    check(vkEnumeratePhysicalDevices(instance_, &count, all.data()), "vkEnumeratePhysicalDevices");
    for (std::size_t i = 0; i < all.size(); ++i) {
        vkGetPhysicalDeviceProperties(all[i], &properties_);
        const VkQueueFlags flags = VK_QUEUE_COMPUTE_BIT | (draws ? VK_QUEUE_GRAPHICS_BIT : 0);
        queue_family_ = family_with(all[i], flags, timestamp_bits_);
        if (!matches(name, i, properties_) || queue_family_ == VK_QUEUE_FAMILY_IGNORED) continue;
        physical_ = all[i];
        return;
    }
    throw NoDevice("no Vulkan device that " + std::string(draws ? "draws" : "computes") +
                   (name.empty() ? name : ", named " + name));
}

void HostDevice::create_device(bool float64) {
    const votess::vulkan::Requirements needs = votess::vulkan::requirements(instance_for_votess(instance_), physical_);
    if (!needs.missing.empty()) throw std::runtime_error("votess: " + needs.missing);
    features_ = needs.features;
    if (!float64) features_.shaderFloat64 = VK_FALSE;
    std::vector<const char*> extensions;
    for (const std::string& extension : needs.extensions) extensions.push_back(extension.c_str());
    VkPhysicalDeviceSubgroupSizeControlFeatures sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_SIZE_CONTROL_FEATURES;
    sizes.subgroupSizeControl = sizes.computeFullSubgroups = VK_TRUE;
    subgroup_size_control_ = needs.subgroup_size_control;
    // The instance is of Vulkan 1.1, where this is an extension.
    if (subgroup_size_control_) extensions.push_back(VK_EXT_SUBGROUP_SIZE_CONTROL_EXTENSION_NAME);

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
    info.pNext = subgroup_size_control_ ? &sizes : nullptr;
    info.pEnabledFeatures = &features_;
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

votess::vulkan::HostDevice HostDevice::for_votess(bool probe) const {
    return {.host = instance_for_votess(instance_),
            .physical_device = physical_,
            .device = device_,
            .queue_family = queue_family_,
            .features = features_,
            .subgroup_size_control = subgroup_size_control_,
            .pipeline_cache = cache_.get(),
            .debug_utils = validate_ > 0,
            .probe_queue = probe ? queue_ : VK_NULL_HANDLE};
}

std::uint32_t HostDevice::memory_type(std::uint32_t allowed, VkMemoryPropertyFlags needed,
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

VkBool32 HostDevice::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                const VkDebugUtilsMessengerCallbackDataEXT* data, void* messages) {
    static_cast<Messages*>(messages)->add(data->pMessage);
    return VK_FALSE;
}

}  // namespace host
