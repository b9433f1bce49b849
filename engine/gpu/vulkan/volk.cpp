// volk's definitions, compiled once under names of our own. third_party/CMakeLists.txt makes volk_names.h from volk.h.
// A program that links votess statically may define volk's names itself, or use them for the loader's functions.
#include <volk_names.h>
// These follow the names.
#include <mutex>
#include <volk.c>

#include "gpu/vulkan/api.hpp"

namespace votess::gpu::vulkan {

void load_device_table(VolkDeviceTable& table, VkDevice device, PFN_vkGetDeviceProcAddr get) {
    // volk reads this one function from its global.
    static std::mutex mutex;
    std::lock_guard lock(mutex);
    vkGetDeviceProcAddr = get;
    volkLoadDeviceTable(&table, device);
}

}  // namespace votess::gpu::vulkan
