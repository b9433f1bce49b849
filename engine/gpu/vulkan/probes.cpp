// Vulkan does not say how a device rounds, nor the size of subgroups where it varies. These run shaders to find out.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <vector>

#include "gpu/vulkan/commands.hpp"
#include "shaders.hpp"
#include "shared/interface.h"
#include "shared/layout.h"

namespace votess::gpu::vulkan {
namespace {

// Returns pairs whose sums and products need rounding, in both directions and with both signs.
template <class Real>
std::vector<Real> operand_pairs(std::uint32_t count) {
    std::vector<Real> pairs;
    std::uint64_t state = 1;
    for (std::uint32_t i = 0; i < 2 * count; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;  // Knuth's MMIX
        const Real fraction = static_cast<Real>(state >> 11) * static_cast<Real>(0x1p-53);
        const Real value = std::ldexp(1 + fraction, static_cast<int>(state >> 9 & 7) - 4);
        pairs.push_back((state >> 10 & 1) != 0 ? -value : value);
    }
    return pairs;
}

// Runs a pass and waits until the host can read its results.
void run(Device& device, const Pass& pass, std::span<const BufferBinding> bindings, std::uint32_t count,
         const Buffer& results) {
    Commands commands(device);
    commands.submit([&] {
        commands.dispatch(pass, bindings, push_bytes(ScanPush{count}), count);
        commands.barrier_to_host();
    });
    commands.wait();
    results.invalidate();
}

template <class Real>
bool rounds_to_nearest(Device& device, std::span<const std::uint32_t> spirv) {
    constexpr std::uint32_t count = 256;
    Memory memory(device, 1 << 16);
    const Pass pass(device,
                    {.name = "probe_rounding", .spirv = spirv, .push_bytes = sizeof(ScanPush), .local_size = 32});
    const Buffer operands = memory.buffer(2 * count * sizeof(Real), MemoryKind::upload, "operands");
    const Buffer results = memory.buffer(6 * count * sizeof(Real), MemoryKind::download, "results");
    const auto pairs = operand_pairs<Real>(count);
    std::memcpy(operands.mapped().data(), pairs.data(), 2 * count * sizeof(Real));
    operands.flush();
    run(device, pass, std::array<BufferBinding, 2>{{{BINDING_RAW, &operands}, {BINDING_GEOMETRY, &results}}}, count,
        results);
    const auto found = results.as<Real>();
    for (std::uint32_t i = 0; i < count; ++i) {
        const Real a = pairs[2 * i], b = pairs[2 * i + 1];
        const auto* const result = &found[6 * i];
        if (result[0] != a + b || result[1] != a * b || result[2] != static_cast<Real>(0x01000001u + 2 * i))
            return false;
        // Fused or rounded twice: the bounds hold for both.
        const Real product = a * b;
        if (result[5] != std::fma(a, b, b) && result[5] != product + b) return false;
        // The filter's bounds allow these errors. Vulkan promises them for float32, and no smaller ones for float64.
        constexpr Real ulp = std::numeric_limits<Real>::epsilon();
        const Real quotient = a / b, root = std::sqrt(std::abs(a));
        if (!(std::abs(result[3] - quotient) <= 3 * ulp * std::abs(quotient) &&
              std::abs(result[4] - root) <= 8 * ulp * root))
            return false;
    }
    return true;
}

}  // namespace

std::uint32_t probe_subgroup_size(Device& device) {
    constexpr std::uint32_t count = 1024;
    Memory memory(device, 1 << 16);
    const Pass pass(device, {.name = "probe_lanes",
                             .spirv = shaders::probe_lanes,
                             .push_bytes = sizeof(ScanPush),
                             .local_size = TILE_GROUP});
    const Buffer sizes = memory.buffer(count * sizeof(std::uint32_t), MemoryKind::download, "sizes");
    run(device, pass, std::array{BufferBinding{BINDING_SCAN_DATA, &sizes}}, count, sizes);
    const auto found = sizes.as<std::uint32_t>();
    return std::ranges::count(found, found[0]) == count ? found[0] : 0;
}

Rounding probe_rounding(Device& device, bool float64) {
    return {rounds_to_nearest<float>(device, shaders::probe_rounding_f32),
            float64 && rounds_to_nearest<double>(device, shaders::probe_rounding_f64)};
}

}  // namespace votess::gpu::vulkan
