// Reads declarations of compiled shaders and adds demands to them. SPIR-V is words of 32 bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace votess::gpu::vulkan {

enum class Decoration : std::uint32_t { constant_id = 1, binding = 33 };

// Returns the values of a decoration in a shader's declarations, ascending.
[[nodiscard]] std::vector<std::uint32_t> declared(std::span<const std::uint32_t> spirv, Decoration decoration);

// What a shader can demand of float32 and of float64 (SPV_KHR_float_controls of Vulkan 1.2).
struct FloatDemands {
    // Sums, products and conversions round to nearest. Otherwise a device may round to either neighbor.
    bool nearest32 = false, nearest64 = false;
    // Infinities and NaN are kept. Otherwise a compiler may assume that there are none.
    bool infinities32 = false, infinities64 = false;
};

// Returns the shader with these demands, those of float64 only where it has any.
[[nodiscard]] std::vector<std::uint32_t> with_demands(std::span<const std::uint32_t> spirv, FloatDemands demands);

}  // namespace votess::gpu::vulkan
