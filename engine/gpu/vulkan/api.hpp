// Vulkan's headers and functions. The engine includes Vulkan's headers through this file only. It does not use volk's
// global function pointers, because a host program may have its own. Calls on a device go through its VolkDeviceTable,
// all others through the structs below.
#pragma once

#include <volk.h>

#include "votess/votess.hpp"

namespace votess::gpu::vulkan {

// Returns the name as in "VK_ERROR_DEVICE_LOST", or "VkResult -123" for one unknown here.
[[nodiscard]] std::string result_name(VkResult result);
// Throws for a negative result: device_lost, out_of_memory, else internal. `call` is the function's name.
void check(VkResult result, const char* call);
// Returns a size as in "128 MiB", for messages.
[[nodiscard]] std::string bytes_text(VkDeviceSize bytes);

// Functions of the loader that need no instance.
struct LoaderCalls {
    PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr = nullptr;
    PFN_vkEnumerateInstanceVersion vkEnumerateInstanceVersion = nullptr;  // null: a loader for Vulkan 1.0
    PFN_vkEnumerateInstanceExtensionProperties vkEnumerateInstanceExtensionProperties = nullptr;
    PFN_vkEnumerateInstanceLayerProperties vkEnumerateInstanceLayerProperties = nullptr;
    PFN_vkCreateInstance vkCreateInstance = nullptr;
};

// Functions of an instance; those of VK_EXT_debug_utils are null unless that is enabled.
struct InstanceCalls {
    PFN_vkDestroyInstance vkDestroyInstance = nullptr;
    PFN_vkEnumeratePhysicalDevices vkEnumeratePhysicalDevices = nullptr;
    PFN_vkGetPhysicalDeviceProperties vkGetPhysicalDeviceProperties = nullptr;
    PFN_vkGetPhysicalDeviceProperties2 vkGetPhysicalDeviceProperties2 = nullptr;
    PFN_vkGetPhysicalDeviceFeatures2 vkGetPhysicalDeviceFeatures2 = nullptr;
    PFN_vkGetPhysicalDeviceFormatProperties vkGetPhysicalDeviceFormatProperties = nullptr;
    PFN_vkGetPhysicalDeviceMemoryProperties vkGetPhysicalDeviceMemoryProperties = nullptr;
    PFN_vkGetPhysicalDeviceQueueFamilyProperties vkGetPhysicalDeviceQueueFamilyProperties = nullptr;
    PFN_vkEnumerateDeviceExtensionProperties vkEnumerateDeviceExtensionProperties = nullptr;
    PFN_vkCreateDevice vkCreateDevice = nullptr;
    PFN_vkGetDeviceProcAddr vkGetDeviceProcAddr = nullptr;
    PFN_vkCreateDebugUtilsMessengerEXT vkCreateDebugUtilsMessengerEXT = nullptr;
    PFN_vkDestroyDebugUtilsMessengerEXT vkDestroyDebugUtilsMessengerEXT = nullptr;
    PFN_vkSetDebugUtilsObjectNameEXT vkSetDebugUtilsObjectNameEXT = nullptr;
    PFN_vkCmdBeginDebugUtilsLabelEXT vkCmdBeginDebugUtilsLabelEXT = nullptr;
    PFN_vkCmdEndDebugUtilsLabelEXT vkCmdEndDebugUtilsLabelEXT = nullptr;
};

// Fills the table of a device. Thread-safe.
void load_device_table(VolkDeviceTable& table, VkDevice device, PFN_vkGetDeviceProcAddr get);

}  // namespace votess::gpu::vulkan
