// Vulkan's headers and functions. The engine includes Vulkan's headers through this file only. It does not use volk's
// global function pointers, because a host program may have its own. Calls on a device go through its VolkDeviceTable,
// all others through the structs below.
#pragma once

#include <volk.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "votess/votess.hpp"

namespace votess::gpu::vulkan {

// Returns the name as in "VK_ERROR_DEVICE_LOST", or "VkResult -123" for one unknown here.
[[nodiscard]] std::string result_name(VkResult result);
// Throws for a negative result: device_lost, out_of_memory, else internal. `call` is the function's name.
void check(VkResult result, const char* call);
// Returns a size as in "128 MiB", for messages.
[[nodiscard]] std::string bytes_text(VkDeviceSize bytes);

// Returns a structure of that type.
template <class T>
[[nodiscard]] T structure(VkStructureType type) {
    T value{};
    value.sType = type;
    return value;
}

// Returns the list of a call that takes a count and an array. name: of the function.
template <class Value, class Call>
[[nodiscard]] std::vector<Value> list_of(const char* name, const Call& call) {
    std::vector<Value> list;
    for (VkResult result = VK_INCOMPLETE; result == VK_INCOMPLETE;) {
        std::uint32_t count = 0;
        check(call(&count, static_cast<Value*>(nullptr)), name);
        list.resize(count);
        result = call(&count, list.data());
        check(result, name);
        list.resize(count);
    }
    return list;
}

[[nodiscard]] inline bool has(const std::vector<VkExtensionProperties>& list, std::string_view name) {
    return std::ranges::any_of(list, [&](const auto& e) { return e.extensionName == name; });
}

// clang-format off
#define VOTESS_LOADER_CALLS(call)                                                 \
    call(vkEnumerateInstanceVersion) /* null: a loader for Vulkan 1.0 */          \
    call(vkEnumerateInstanceExtensionProperties) call(vkEnumerateInstanceLayerProperties) call(vkCreateInstance)
#define VOTESS_INSTANCE_CALLS(call)                                               \
    call(vkDestroyInstance) call(vkEnumeratePhysicalDevices)                      \
    call(vkGetPhysicalDeviceProperties) call(vkGetPhysicalDeviceProperties2)      \
    call(vkGetPhysicalDeviceFeatures2) call(vkGetPhysicalDeviceFormatProperties)  \
    call(vkGetPhysicalDeviceMemoryProperties) call(vkGetPhysicalDeviceQueueFamilyProperties) \
    call(vkEnumerateDeviceExtensionProperties) call(vkCreateDevice) call(vkGetDeviceProcAddr)
#define VOTESS_DEBUG_CALLS(call)                                                  \
    call(vkCreateDebugUtilsMessengerEXT) call(vkDestroyDebugUtilsMessengerEXT)    \
    call(vkSetDebugUtilsObjectNameEXT)                                            \
    call(vkCmdBeginDebugUtilsLabelEXT) call(vkCmdEndDebugUtilsLabelEXT)
#define VOTESS_DECLARE(name) PFN_##name name = nullptr;
// Functions of the loader that need no instance.
struct LoaderCalls {
    PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr = nullptr;
    VOTESS_LOADER_CALLS(VOTESS_DECLARE)
};
// Functions of an instance; those of VK_EXT_debug_utils are null unless that is enabled.
struct InstanceCalls {
    VOTESS_INSTANCE_CALLS(VOTESS_DECLARE)
    VOTESS_DEBUG_CALLS(VOTESS_DECLARE)
};
#undef VOTESS_DECLARE
// clang-format on

// Fills the table of a device. Thread-safe.
void load_device_table(VolkDeviceTable& table, VkDevice device, PFN_vkGetDeviceProcAddr get);

}  // namespace votess::gpu::vulkan
