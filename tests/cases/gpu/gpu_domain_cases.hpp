// Domains on a Vulkan device against the CPU, with both kernels.
#pragma once

#include <algorithm>
#include <string>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/gpu/gpu.hpp"
#include "support/random.hpp"

namespace test {

inline votess::Options domain_options() {
    votess::Options options = all_options(unit_box());
    options.want.centroids = options.want.areas = true;
    return options;
}

inline Coordinates random_points(std::size_t n, std::uint64_t seed, double lower = 0, double upper = 1) {
    Random random(seed);
    Coordinates points(3 * n);
    for (double& x : points) x = random.uniform(lower, upper);
    return points;
}

struct Counts {
    std::uint64_t fallback = 0, empty = 0;  // cells left to the CPU; seeds without a cell
    std::string failure;
};

// on_device keeps its pipelines from one comparison to the next.
inline Counts compare_kernel(votess::Tessellator& on_device, const Coordinates& points, votess::Options options,
                             votess::gpu::Kernel kernel) {
    const auto cpu = votess::tessellate(std::span<const double>(points), options);
    options.device = device_name();
    const UseKernel chosen(kernel);
    const auto gpu = on_device.tessellate(std::span<const double>(points), options);
    Counts counts{gpu.stats().fallback_cells, gpu.stats().empty_cells, check_domain(gpu)};
    if (counts.failure.empty()) counts.failure = check_same(gpu, cpu, points, tolerance(options));
    if (counts.failure.empty() && !std::ranges::equal(cpu.shifts(), gpu.shifts())) counts.failure = "shifts differ";
    return counts;
}

// Compares both kernels where seeds are few. Counts the larger number of cells left to the CPU.
inline Counts compare_domain(votess::Tessellator& on_device, const Coordinates& points,
                             const votess::Options& options) {
    const Counts by_invocation = compare_kernel(on_device, points, options, votess::gpu::Kernel::invocation);
    const std::size_t most = by_size(600, 60);  // coordinates: the other kernel is slow on software devices
    if (!by_invocation.failure.empty() || points.size() > most) return by_invocation;
    Counts both = compare_kernel(on_device, points, options, by_subgroup());
    both.fallback = std::max(both.fallback, by_invocation.fallback);
    return both;
}

}  // namespace test
