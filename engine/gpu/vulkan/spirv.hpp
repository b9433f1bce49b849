// What is read from compiled shaders, and what is added to them: SPIR-V, words of 32 bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace votess::gpu::vulkan {

enum class Decoration : std::uint32_t { constant_id = 1, binding = 33 };

// The values that a shader's declarations have for a decoration, ascending.
[[nodiscard]] std::vector<std::uint32_t> declared(std::span<const std::uint32_t> spirv, Decoration decoration);

// The shader with the demand that its sums, products and conversions round to nearest, in float32 and, where it has
// such, in float64 (SPV_KHR_float_controls, which Vulkan 1.2 knows). Else a device may choose between the two
// neighbors.
[[nodiscard]] std::vector<std::uint32_t> rounding_to_nearest(std::span<const std::uint32_t> spirv, bool float32,
                                                             bool float64);

}  // namespace votess::gpu::vulkan
