// Reads declarations of compiled shaders and adds demands to them. SPIR-V is words of 32 bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace votess::gpu::vulkan {

enum class Decoration : std::uint32_t { constant_id = 1, binding = 33 };

// Returns the values of a decoration in a shader's declarations, ascending.
[[nodiscard]] std::vector<std::uint32_t> declared(std::span<const std::uint32_t> spirv, Decoration decoration);

// Returns the shader with the demand that its sums, products and conversions round to nearest, in float32 and, where it
// has any, in float64 (SPV_KHR_float_controls of Vulkan 1.2). Without it a device may round to either neighbor.
[[nodiscard]] std::vector<std::uint32_t> rounding_to_nearest(std::span<const std::uint32_t> spirv, bool float32,
                                                             bool float64);

}  // namespace votess::gpu::vulkan
