// The GPU engine beside the CPU's.
#pragma once

#include <span>
#include <string>

#include "cpu/cpu_clipper.hpp"
#include "gpu/gpu_engine.hpp"
#include "gpu/passes/kernel_choice.hpp"
#include "support/check.hpp"
#include "support/gpu/vulkan.hpp"

namespace test {

// Relative errors that are promised of volumes, and of centroids in sizes of the cell.
inline constexpr double single_tolerance = 1e-5, double_tolerance = 1e-10;

inline double tolerance(const votess::Options& options) {
    return options.precision == votess::Precision::double_ ? double_tolerance : single_tolerance;
}

// What the GPU must give given what the CPU gives: the same lists, counts, statuses; volumes and centroids within the
// tolerance. One line on the first difference.
std::string check_same(const votess::Tessellation& gpu, const votess::Tessellation& cpu, std::span<const double> points,
                       double tolerance);

// The device that tests of the whole library name: lavapipe, or VOTESS_TEST_DEVICE.
std::string device_name();

// Kernel::subgroup and Precision::double_ where the tests' device has what they need, else what every device can do.
votess::gpu::Kernel by_subgroup();
votess::Precision double_precision();

// During its life this kernel makes the cells of engines and plans that are made or set up anew.
struct UseKernel : Environment {
    explicit UseKernel(votess::gpu::Kernel kernel);
};

// An engine of its own on the tests' device, and the pipeline on it.
struct GpuRunner {
    votess::cpu::CpuClipper clipper;
    votess::gpu::GpuEngine engine;

    explicit GpuRunner(Gpu& gpu, const votess::gpu::EngineLimits& limits = {}) : engine(gpu.device, clipper, limits) {}
    votess::Tessellation run(const PointSet& set, votess::Options options);
};

}  // namespace test
