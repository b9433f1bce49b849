// Which Vulkan device a name stands for.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gpu/vulkan/device.hpp"

namespace votess::gpu {

// All Vulkan devices by index; empty where there is no Vulkan.
std::vector<DeviceInfo> list_devices();

// device: "auto", "gpu", "lavapipe" or an index. Null for "auto" when there is no GPU that votess can use; throws
// `unsupported` with the reason for the others. Discrete GPUs come before integrated ones.
std::shared_ptr<vulkan::Device> choose_device(const std::string& device);

}  // namespace votess::gpu
