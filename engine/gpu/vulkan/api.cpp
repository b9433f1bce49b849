#include "gpu/vulkan/api.hpp"

#include <array>
#include <cstdio>
#include <utility>

#include "input/option_name.hpp"

namespace votess::gpu::vulkan {

std::string result_name(VkResult result) {
#define VOTESS_NAMED(name) \
    { name, #name }
    static constexpr std::pair<VkResult, const char*> names[] = {VOTESS_NAMED(VK_SUCCESS),
                                                                 VOTESS_NAMED(VK_NOT_READY),
                                                                 VOTESS_NAMED(VK_TIMEOUT),
                                                                 VOTESS_NAMED(VK_INCOMPLETE),
                                                                 VOTESS_NAMED(VK_ERROR_OUT_OF_HOST_MEMORY),
                                                                 VOTESS_NAMED(VK_ERROR_OUT_OF_DEVICE_MEMORY),
                                                                 VOTESS_NAMED(VK_ERROR_INITIALIZATION_FAILED),
                                                                 VOTESS_NAMED(VK_ERROR_DEVICE_LOST),
                                                                 VOTESS_NAMED(VK_ERROR_MEMORY_MAP_FAILED),
                                                                 VOTESS_NAMED(VK_ERROR_LAYER_NOT_PRESENT),
                                                                 VOTESS_NAMED(VK_ERROR_EXTENSION_NOT_PRESENT),
                                                                 VOTESS_NAMED(VK_ERROR_FEATURE_NOT_PRESENT),
                                                                 VOTESS_NAMED(VK_ERROR_INCOMPATIBLE_DRIVER),
                                                                 VOTESS_NAMED(VK_ERROR_TOO_MANY_OBJECTS),
                                                                 VOTESS_NAMED(VK_ERROR_FRAGMENTED_POOL),
                                                                 VOTESS_NAMED(VK_ERROR_OUT_OF_POOL_MEMORY),
                                                                 VOTESS_NAMED(VK_ERROR_INVALID_SHADER_NV),
                                                                 VOTESS_NAMED(VK_ERROR_UNKNOWN)};
#undef VOTESS_NAMED
    for (const auto& [known, name] : names)
        if (known == result) return name;
    return "VkResult " + std::to_string(static_cast<int>(result));
}

void check(VkResult result, const char* call) {
    if (result >= 0) return;
    const std::string where = std::string(" in ") + call;
    switch (result) {
        case VK_ERROR_DEVICE_LOST:
            throw Error(
                ErrorCode::device_lost,
                "the device was lost" + where +
                    ": it crashed, was reset or unplugged, or its driver stopped work that took too long; try a "
                    "smaller " +
                    option("chunk_size") + " or another device");
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            throw Error(ErrorCode::out_of_memory, "the driver is out of host memory" + where);
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        case VK_ERROR_OUT_OF_POOL_MEMORY:
            throw Error(ErrorCode::out_of_memory, "the device is out of memory" + where + "; try a smaller " +
                                                      option("chunk_size") + " or another device");
        case VK_ERROR_INITIALIZATION_FAILED:
        case VK_ERROR_INCOMPATIBLE_DRIVER:
        case VK_ERROR_LAYER_NOT_PRESENT:
        case VK_ERROR_EXTENSION_NOT_PRESENT:
        case VK_ERROR_FEATURE_NOT_PRESENT:
        case VK_ERROR_TOO_MANY_OBJECTS:
        case VK_ERROR_INVALID_SHADER_NV:
        case VK_ERROR_UNKNOWN:
            throw Error(ErrorCode::unsupported, "the driver refuses, " + result_name(result) + where +
                                                    "; try another device, or a newer driver");
        default:
            throw Error(ErrorCode::internal, result_name(result) + where);
    }
}

std::string bytes_text(VkDeviceSize bytes) {
    static constexpr std::array units{"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    double value = static_cast<double>(bytes);
    std::size_t unit = 0;
    while (value >= 1024 && unit + 1 < units.size()) {
        value /= 1024;
        ++unit;
    }
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.4g %s", value, units[unit]);
    return text.data();
}

}  // namespace votess::gpu::vulkan
