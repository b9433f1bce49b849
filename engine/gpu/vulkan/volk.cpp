// volk's definitions, compiled once, under names of our own: volk_names.h is made from volk.h by
// third_party/CMakeLists.txt. A program that links votess statically may define volk's names itself, or mean the
// loader's functions by them.
#include <volk_names.h>
// These come after the names.
#include <mutex>
#include <volk.c>

#include "gpu/vulkan/api.hpp"

namespace votess::gpu::vulkan {

void load_device_table(VolkDeviceTable& table, VkDevice device, PFN_vkGetDeviceProcAddr get) {
    // volk takes this one function from its global.
    static std::mutex mutex;
    std::lock_guard lock(mutex);
    vkGetDeviceProcAddr = get;
    volkLoadDeviceTable(&table, device);
}

}  // namespace votess::gpu::vulkan
