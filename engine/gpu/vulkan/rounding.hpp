// Vulkan lets a device round sums and products to nearest or toward zero, and does not tell which. So this tries it
// out.
#pragma once

namespace votess::gpu::vulkan {

class Device;

struct Rounding {
    // float32 sums, products and conversions are rounded to nearest even, fma() once or twice, and quotients and roots
    // are right to a few units in the last place.
    bool nearest32 = false;
    bool nearest64 = false;  // the same in float64
};

// float64: whether the device has it, and it is enabled.
Rounding probe_rounding(Device& device, bool float64);

}  // namespace votess::gpu::vulkan
