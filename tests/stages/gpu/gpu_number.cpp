// The numbers that measure cells (shaders/numbers/number.glsl) against long double.
#include <doctest/doctest.h>

#include <bit>
#include <cmath>

#include "support/check.hpp"
#include "support/gpu/vulkan.hpp"
#include "support/random.hpp"

using namespace votess::gpu::vulkan;

namespace {

constexpr std::size_t operations = 6;  // of the shader
struct CountPush {
    std::uint32_t count;
};

// A number as it lies in memory.
std::uint64_t words_of(double a, bool float64) {
    if (float64) return std::bit_cast<std::uint64_t>(a);
    const auto high = static_cast<float>(a);
    const auto low = static_cast<float>(a - static_cast<double>(high));
    return std::bit_cast<std::uint32_t>(high) | std::uint64_t{std::bit_cast<std::uint32_t>(low)} << 32;
}
long double value_of(std::uint64_t words, bool float64) {
    if (float64) return std::bit_cast<double>(words);
    return static_cast<long double>(std::bit_cast<float>(static_cast<std::uint32_t>(words))) +
           static_cast<long double>(std::bit_cast<float>(static_cast<std::uint32_t>(words >> 32)));
}

std::vector<std::uint64_t> results_of(test::Gpu& gpu, const std::vector<std::uint64_t>& operands, bool float64) {
    const auto count = static_cast<std::uint32_t>(operands.size() / 2);
    Memory memory(*gpu.device, 1 << 20);
    PassInfo info;
    info.name = "test_number";
    info.spirv = float64 ? votess::gpu::shaders::test_number_f64 : votess::gpu::shaders::test_number_f32;
    info.push_bytes = sizeof(CountPush);
    info.local_size = 64;
    const Pass pass(*gpu.device, info);
    const Buffer in = memory.buffer(operands.size() * 8, MemoryKind::upload, "operands");
    const Buffer out = memory.buffer(count * operations * 8, MemoryKind::download, "results");
    std::ranges::copy(operands, in.as<std::uint64_t>().begin());
    in.flush();
    const BufferBinding bindings[] = {{2, &in}, {5, &out}};
    gpu.run(pass, bindings, push_bytes(CountPush{count}), count);
    out.invalidate();
    const auto found = out.as<std::uint64_t>();
    return {found.begin(), found.end()};
}

// Both signs, magnitudes around one, many or few digits, sums that nearly cancel.
std::vector<double> operands_of(std::size_t pairs) {
    test::Random random(17);
    std::vector<double> all;
    for (std::size_t i = 0; i < pairs; ++i) {
        double number[2];
        for (double& x : number) {
            x = std::ldexp(random.uniform(1, 2), static_cast<int>(random.integer(-12, 12)));
            if (random.chance(0.3)) x = static_cast<float>(x);
            if (random.chance(0.1)) x = std::ldexp(1.0, static_cast<int>(random.integer(-12, 12)));
            if (random.chance(0.5)) x = -x;
        }
        if (random.chance(0.3)) number[1] = -number[0] * (1 + std::ldexp(random.uniform(-1, 1), -20));
        if (random.chance(0.1)) number[1] = -number[0];
        all.insert(all.end(), {number[0], number[1]});
    }
    return all;
}

void check_numbers(test::Gpu& gpu, bool float64) {
    const std::size_t pairs = test::by_size(100000, 2000);
    const std::vector<double> given = operands_of(pairs);
    std::vector<std::uint64_t> operands;
    for (const double x : given) operands.push_back(words_of(x, float64));
    const auto found = results_of(gpu, operands, float64);
    // The shader's promised unit roundoffs, and that of long double.
    const long double unit = float64 ? 0x1.01p-53L : 0x1p-44L, unit_of_division = float64 ? 0x1.01p-53L : 0x1p-42L;
    for (std::size_t i = 0; i < pairs; ++i) {
        const long double a = value_of(operands[2 * i], float64), b = value_of(operands[2 * i + 1], float64);
        const long double sum = std::abs(a) + std::abs(b);
        CAPTURE(static_cast<double>(a));
        CAPTURE(static_cast<double>(b));
        const auto result = [&](std::size_t k) { return value_of(found[operations * i + k], float64); };
        REQUIRE(std::abs(result(0) - (a + b)) <= unit * sum);
        REQUIRE(std::abs(result(1) - (a - b)) <= unit * sum);
        REQUIRE(std::abs(result(2) - a * b) <= unit * std::abs(a * b));
        REQUIRE(std::abs(result(3) * b - 1) <= unit_of_division);
        REQUIRE(std::abs(result(4) - std::abs(a)) <= (unit + unit_of_division) * std::abs(a));
        const auto whole = static_cast<long double>(operands[2 * i]) / 4;
        REQUIRE(std::abs(result(5) - whole) <= unit * whole);
    }
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu numbers: sums of two float32 have 44 bits") {
        test::Gpu gpu;
        check_numbers(gpu, false);
    }
    TEST_CASE("gpu numbers: float64") {
        test::Gpu gpu;
        if (gpu.device->has_float64()) check_numbers(gpu, true);
    }
}
