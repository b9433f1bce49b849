// The Vulkan device that a name means.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gpu/vulkan/device.hpp"

namespace votess::gpu {

// Returns all Vulkan devices by index; empty where there is no Vulkan.
std::vector<DeviceInfo> list_devices();

// Opens the device of a name: "auto", "gpu", "lavapipe" or an index. Discrete GPUs come before integrated ones. Returns
// null for "auto" when there is no GPU that votess can use. Throws `unsupported` with the reason for other names.
std::shared_ptr<vulkan::Device> choose_device(const std::string& device);

}  // namespace votess::gpu
