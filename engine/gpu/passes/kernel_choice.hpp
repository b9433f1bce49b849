// The choice of a kernel for cells of the first tier, an invocation or a subgroup, and of the numbers that measure
// them.
#pragma once

#include <cstdint>
#include <string>

#include "gpu/vulkan/adapter.hpp"

namespace votess::gpu {

enum class Kernel {
    automatic,   // `subgroup` on GPUs that can, `invocation` on software devices
    invocation,  // an invocation makes a cell from a list of near seeds
    subgroup,    // a subgroup makes a cell and searches as it clips; needs subgroups of 8 to 64
};

// Returns an empty text when subgroups can make cells, else what the device lacks: "subgroups of 8 to 64 invocations,
// it has 4".
[[nodiscard]] std::string missing_for_subgroups(const vulkan::Adapter& adapter);

// Returns PassSettings::subgroup_size, 0 for the invocation kernel. Throws `unsupported` when the subgroup kernel is
// requested where it cannot run.
[[nodiscard]] std::uint32_t choose_subgroup_size(const vulkan::Adapter& adapter, Kernel kernel);

// Returns VOTESS_VULKAN_KERNEL of the environment, for measurements and tests: "automatic" (also when it is not set),
// "invocation" or "subgroup". Throws `invalid_argument`.
[[nodiscard]] Kernel kernel_from_environment();

enum class Measure {
    automatic,  // `float64` where it is known to be fast
    float64,
    float32,  // see shaders/measure/polyhedron.glsl
};

// Returns PassSettings::measure_float64. Throws `unsupported` when float64 is requested and the device has none.
[[nodiscard]] bool measures_in_float64(const vulkan::Adapter& adapter, bool has_float64, Measure measure);

// Returns VOTESS_VULKAN_MEASURE of the environment, for measurements and tests: "automatic" (also when it is not set),
// "float64" or "float32". Throws `invalid_argument`.
[[nodiscard]] Measure measure_from_environment();

// Returns the choice in words: "subgroups of 32 make cells, measured in float64".
[[nodiscard]] std::string kernel_text(const vulkan::Adapter& adapter, std::uint32_t subgroup_size,
                                      bool measure_float64);

// Returns VOTESS_VULKAN_LOCAL_SIZE of the environment, for measurements: invocations of a work-group, a power of two up
// to 1024. 0 when it is not set. Throws `invalid_argument`.
[[nodiscard]] std::uint32_t local_size_from_environment();

}  // namespace votess::gpu
