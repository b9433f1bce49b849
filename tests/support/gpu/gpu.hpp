// Compares the GPU engine with the CPU's.
#pragma once

#include <span>
#include <string>

#include "cpu/cpu_clipper.hpp"
#include "gpu/gpu_engine.hpp"
#include "gpu/passes/kernel_choice.hpp"
#include "support/check.hpp"
#include "support/gpu/vulkan.hpp"

namespace test {

// Promised relative errors of volumes, and of centroids over the size of the cell.
inline constexpr double single_tolerance = 1e-5, double_tolerance = 1e-10;

inline double tolerance(const votess::Options& options) {
    return options.precision == votess::Precision::double_ ? double_tolerance : single_tolerance;
}

// Compares results: lists, counts and statuses must be equal, volumes and centroids within the tolerance. Returns a
// line about the first difference.
std::string check_same(const votess::Tessellation& gpu, const votess::Tessellation& cpu, std::span<const double> points,
                       double tolerance);

// Returns the device name for tests of the whole library: lavapipe, or VOTESS_TEST_DEVICE.
std::string device_name();

// Return Kernel::subgroup and Precision::double_ where the tests' device supports them, else what every device
// supports.
votess::gpu::Kernel by_subgroup();
votess::Precision double_precision();

// During its life, new engines and plans use this kernel.
struct UseKernel : Environment {
    explicit UseKernel(votess::gpu::Kernel kernel);
};

// Returns the Tessellator that the tests of a process share, for the reason that SharedGpu gives.
votess::Tessellator& shared_tessellator();

// An engine on the tests' device.
struct GpuRunner {
    votess::cpu::CpuClipper clipper;
    votess::gpu::GpuEngine engine;

    explicit GpuRunner(Gpu& gpu, const votess::gpu::EngineLimits& limits = {}) : engine(gpu.device, clipper, limits) {}
    votess::Tessellation run(const PointSet& set, votess::Options options);
};

}  // namespace test
