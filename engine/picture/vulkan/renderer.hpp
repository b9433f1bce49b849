// Draws a scene on a Vulkan device, without a window.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "gpu/vulkan/device.hpp"
#include "picture/scene.hpp"

namespace votess::gpu {

// What tests vary.
struct DrawLimits {
    std::uint32_t most_pixels = 2048;  // along a side of the parts that the picture is drawn in
};

[[nodiscard]] Picture draw(const picture::Scene& scene, const std::shared_ptr<vulkan::Device>& device,
                           const DrawLimits& limits = {});
// On the device that the name stands for, see choose_graphics_device.
[[nodiscard]] Picture draw(const picture::Scene& scene, const std::string& device);

}  // namespace votess::gpu
