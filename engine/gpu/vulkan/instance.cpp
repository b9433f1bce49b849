#include "gpu/vulkan/instance.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>

namespace votess::gpu::vulkan {
namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";
// The newest version whose rules this code follows.
constexpr std::uint32_t newest_version = VK_API_VERSION_1_3;
// A program that repeats one mistake must not fill the memory.
constexpr std::size_t max_messages = 1000;

std::string_view validation_variable() {
    const char* value = std::getenv("VOTESS_VULKAN_VALIDATION");
    return value ? value : "";
}

// Fills the members that a list of calls declares.
#define VOTESS_LOAD(name) calls_.name = reinterpret_cast<PFN_##name>(get(instance, #name));

std::vector<VkExtensionProperties> extensions_of(const LoaderCalls& calls, const char* layer) {
    return list_of<VkExtensionProperties>("vkEnumerateInstanceExtensionProperties", [&](auto* count, auto* to) {
        return calls.vkEnumerateInstanceExtensionProperties(layer, count, to);
    });
}

bool has_layer(const LoaderCalls& calls, std::string_view name) {
    const auto list = list_of<VkLayerProperties>("vkEnumerateInstanceLayerProperties", [&](auto* count, auto* to) {
        return calls.vkEnumerateInstanceLayerProperties(count, to);
    });
    return std::any_of(list.begin(), list.end(), [&](const auto& l) { return l.layerName == name; });
}

}  // namespace

bool validation_wanted() {
    return validation_variable() == "1" || synchronization_validation_wanted();
}

bool synchronization_validation_wanted() {
    return validation_variable() == "2";
}

Loader::Loader() {
    const std::vector<std::string> names = system::vulkan_loaders();
    std::string failure;
    auto name = names.begin();
    while (name != names.end() && !(library_ = system::SharedLibrary::open(*name, failure)).is_open()) ++name;
    if (name == names.end())
        throw Error(ErrorCode::unsupported, "no Vulkan loader (" + names.front() + ") on this machine");
    const auto get = reinterpret_cast<PFN_vkGetInstanceProcAddr>(library_.symbol("vkGetInstanceProcAddr"));
    if (!get) throw Error(ErrorCode::unsupported, *name + " is not a Vulkan loader: it lacks vkGetInstanceProcAddr");
    calls_.vkGetInstanceProcAddr = get;
    constexpr VkInstance instance = VK_NULL_HANDLE;
    VOTESS_LOADER_CALLS(VOTESS_LOAD)
}

std::shared_ptr<Instance> Instance::create(const InstanceOptions& options) {
    return std::shared_ptr<Instance>(new Instance(options));
}

std::shared_ptr<Instance> Instance::adopt(const HostInstance& host) {
    return std::shared_ptr<Instance>(new Instance(host));
}

Instance::Instance(const HostInstance& host)
    : handle_(host.handle), version_(std::min(host.version, newest_version)), debug_utils_(host.debug_utils) {
    load_calls(host.get);
    // The host may have set the flag without having enabled the extension.
    debug_utils_ = debug_utils_ && calls_.vkCmdBeginDebugUtilsLabelEXT && calls_.vkCmdEndDebugUtilsLabelEXT &&
                   calls_.vkSetDebugUtilsObjectNameEXT;
}

Instance::Instance(const InstanceOptions& options) : validation_(options.validation) {
    loader_.emplace();
    if (!loader_->calls().vkEnumerateInstanceVersion) {
        throw Error(ErrorCode::unsupported, "votess needs Vulkan 1.1, the loader has 1.0");
    }
    check(loader_->calls().vkEnumerateInstanceVersion(&version_), "vkEnumerateInstanceVersion");
    version_ = std::min(version_, newest_version);
    create_handle(options);
    if (!handle_) return;
    load_calls(loader_->calls().vkGetInstanceProcAddr);
    try {
        if (validation_) create_messenger();
    } catch (...) {
        destroy();
        throw;
    }
}

Instance::~Instance() {
    destroy();
}

void Instance::destroy() noexcept {
    if (messenger_) calls_.vkDestroyDebugUtilsMessengerEXT(handle_, messenger_, nullptr);
    if (handle_ && loader_) calls_.vkDestroyInstance(handle_, nullptr);
}

void Instance::create_handle(const InstanceOptions& options) {
    const LoaderCalls& calls = loader_->calls();
    std::vector<VkExtensionProperties> available = extensions_of(calls, nullptr);
    std::vector<const char*> layers;
    std::vector<const char*> extensions;
    auto info = structure<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);

    const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    auto features = structure<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronization;
    if (validation_) {
        if (!has_layer(calls, validation_layer)) {
            throw Error(ErrorCode::unsupported, std::string("Vulkan validation is requested, but the layer ") +
                                                    validation_layer +
                                                    " is not installed (Debian, Ubuntu: vulkan-validationlayers)");
        }
        layers.push_back(validation_layer);
        const auto more = extensions_of(calls, validation_layer);
        available.insert(available.end(), more.begin(), more.end());
        if (options.synchronization && has(available, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME)) {
            extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
            info.pNext = &features;
        }
    }
    // Enabled only with validation: for names and labels the loader (1.3.239) walks the devices of all instances
    // without a lock, and crashes when another thread destroys one.
    debug_utils_ = validation_ && has(available, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (debug_utils_) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (has(available, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
        extensions.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
        info.flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
    }

    auto application = structure<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
    application.pEngineName = "votess";
    application.apiVersion = version_;
    info.pApplicationInfo = &application;
    info.enabledLayerCount = static_cast<std::uint32_t>(layers.size());
    info.ppEnabledLayerNames = layers.data();
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const VkResult result = calls.vkCreateInstance(&info, nullptr, &handle_);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) {  // the loader found no driver at all
        handle_ = VK_NULL_HANDLE;
        return;
    }
    check(result, "vkCreateInstance");
}

void Instance::load_calls(PFN_vkGetInstanceProcAddr get) {
    const VkInstance instance = handle_;
    VOTESS_INSTANCE_CALLS(VOTESS_LOAD)
    if (!debug_utils_) return;
    VOTESS_DEBUG_CALLS(VOTESS_LOAD)
}

void Instance::create_messenger() {
    if (!debug_utils_) {
        throw Error(ErrorCode::unsupported, "Vulkan validation is requested, but there is no VK_EXT_debug_utils");
    }
    auto info = structure<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
    info.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_GENERAL_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    info.pfnUserCallback = on_message;
    info.pUserData = this;
    check(calls_.vkCreateDebugUtilsMessengerEXT(handle_, &info, nullptr, &messenger_),
          "vkCreateDebugUtilsMessengerEXT");
}

std::vector<Adapter> Instance::adapters() const {
    std::vector<Adapter> adapters;
    if (!handle_) return adapters;
    const auto devices = list_of<VkPhysicalDevice>("vkEnumeratePhysicalDevices", [&](auto* count, auto* to) {
        const VkResult result = calls_.vkEnumeratePhysicalDevices(handle_, count, to);
        // Drivers return these when they find no device of theirs.
        if (result != VK_ERROR_INITIALIZATION_FAILED && result != VK_ERROR_INCOMPATIBLE_DRIVER) return result;
        *count = 0;
        return VK_SUCCESS;
    });
    for (const VkPhysicalDevice device : devices) adapters.push_back(query_adapter(calls_, device, version_));
    return adapters;
}

void Instance::add_message(std::string message) {
    std::lock_guard lock(mutex_);
    if (messages_.size() < max_messages) messages_.push_back(std::move(message));
}

std::vector<std::string> Instance::take_messages() {
    std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
}

void Instance::check_messages() {
    const auto messages = take_messages();
    if (!messages.empty())
        throw Error(ErrorCode::internal, "Vulkan validation found " + std::to_string(messages.size()) +
                                             " problems, the first: " + messages.front());
}

VkBool32 Instance::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT,
                              const VkDebugUtilsMessengerCallbackDataEXT* data, void* self) {
    try {
        const bool error = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
        const std::string_view text = data->pMessage ? data->pMessage : "";
        const std::string_view rule = data->pMessageIdName ? data->pMessageIdName : "";
        std::string message = error ? "error: " : "warning: ";
        // Older layers name the rule in the text.
        if (!rule.empty() && text.find(rule) == text.npos) message.append(rule).append(": ");
        static_cast<Instance*>(self)->add_message(message.append(text));
    } catch (...) {  // out of memory: the caller is C, and must not see an exception
    }
    return VK_FALSE;
}

}  // namespace votess::gpu::vulkan
