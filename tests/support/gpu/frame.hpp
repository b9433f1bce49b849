// Frames recorded into a command buffer of a host, and the CPU's answer for the same seeds.
#pragma once

#include <doctest/doctest.h>

#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/vulkan.hpp>

#include "support/gpu/gpu.hpp"

namespace test::frame {

using namespace votess::vulkan;
using votess::CellStatus;
namespace vk = test::vk;

// A host with a device of its own, lent to plans.
struct Host {
    bool float64, probe = true, subgroup_size_control = false;
    test::Gpu gpu;
    vk::Memory memory{*gpu.device};
    vk::Commands commands{*gpu.device};

    // The device has float64 enabled only if it is wanted.
    explicit Host(bool want_float64 = true) : float64(want_float64), gpu({.float64 = want_float64}) {}

    [[nodiscard]] votess::vulkan::HostInstance instance() const {
        return {gpu.instance->handle(), loader.calls().vkGetInstanceProcAddr, gpu.instance->version()};
    }
    [[nodiscard]] votess::vulkan::HostDevice device() {
        votess::vulkan::HostDevice host;
        host.host = instance();
        host.physical_device = gpu.adapter.handle;
        host.device = gpu.device->handle();
        host.queue_family = gpu.adapter.queue_family;
        host.features.shaderFloat64 = float64 && gpu.adapter.float64;
        host.subgroup_size_control = subgroup_size_control;  // enabled where the adapter has it
        host.debug_utils = gpu.instance->debug_utils();
        if (probe) gpu.device->table().vkGetDeviceQueue(host.device, host.queue_family, 0, &host.probe_queue);
        return host;
    }
    // Returns a plan. It shares pipelines with the first one, as long as the members above stay as they are.
    [[nodiscard]] Plan plan(const PlanOptions& options) {
        if (first) return first->with(options);
        return first.emplace(device(), options);
    }

    vk::Loader loader;
    std::optional<Plan> first;
};

// Buffers of a frame, visible to the host.
struct Target {
    vk::Buffer seeds, weights, workspace, header, cells, indices, geometry, areas, shifts, kept;
    Frame frame;

    Target(Host& host, const Plan& plan) {
        const BufferSizes& sizes = plan.sizes();
        const auto visible = [&](VkDeviceSize bytes) { return host.memory.buffer(bytes, vk::MemoryKind::download); };
        seeds = host.memory.buffer(sizes.seeds, vk::MemoryKind::upload);
        weights = host.memory.buffer(sizes.weights, vk::MemoryKind::upload);
        workspace = host.memory.buffer(sizes.workspace, vk::MemoryKind::device);
        header = visible(sizes.header);
        cells = visible(sizes.cells);
        indices = visible(sizes.indices);
        geometry = visible(sizes.geometry);
        areas = visible(sizes.areas);
        shifts = visible(sizes.shifts);
        kept = host.memory.buffer(sizes.kept, vk::MemoryKind::device);
        frame = plan.frame({.seeds = {seeds.handle()},
                            .workspace = {workspace.handle()},
                            .header = {header.handle()},
                            .cells = {cells.handle()},
                            .indices = {indices.handle()},
                            .geometry = {geometry.handle()},
                            .areas = {areas.handle()},
                            .shifts = {shifts.handle()},
                            .weights = {weights.handle()},
                            .kept = {kept.handle()}});
    }

    template <class Real>
    void write(const Coordinates& points, std::uint32_t stride) const {
        const auto to = seeds.as<Real>();
        for (std::size_t i = 0; i < points.size(); ++i) to[i / 3 * stride + i % 3] = static_cast<Real>(points[i]);
        seeds.flush();
    }
    void write_weights(std::span<const double> values) {
        std::ranges::copy(values, weights.as<double>().begin());
        weights.flush();
    }
    [[nodiscard]] Header head() const {
        Header h;
        std::memcpy(&h, header.mapped().data(), sizeof h);
        return h;
    }
    [[nodiscard]] std::span<const Cell> cell(std::size_t count) const { return cells.as<Cell>().first(count); }
};

void run(Host& host, std::span<const Target* const> targets, const RecordOptions& options);
void run(Host& host, const Target& target, std::uint32_t count);

struct Rows {
    std::vector<std::vector<std::int32_t>> rows;
    std::vector<std::vector<std::int8_t>> shifts;  // three an entry, of periodic plans
    std::vector<std::vector<double>> areas;        // of plans with areas
    std::vector<double> volumes, centroids;        // of plans with geometry
    std::vector<CellStatus> status;
};

// Returns the rows of the frame and of resolve(). Real: the type of its seeds.
template <class Real>
Rows collect(const Plan& plan, const Target& target, std::size_t count, const std::optional<votess::Box>& box = {},
             const std::optional<votess::TriclinicBox>& cell = {});

// Replaces centroids of certified cells: the library's lie in the periodic domain, those of a frame near their seed.
void take_centroids(Rows& rows, const Target& target, const votess::Tessellation& t);

// A frame of a plan of its own, recorded and done.
struct OneFrame {
    Plan plan;
    Target target;
    std::size_t count;

    OneFrame(Host& host, const PlanOptions& options, const Coordinates& points)
        : plan(host.plan(options)), target(host, plan), count(points.size() / 3) {
        target.write<double>(points, options.stride);
        run(host, target, static_cast<std::uint32_t>(count));
    }
    [[nodiscard]] Header head() const { return target.head(); }
    [[nodiscard]] std::span<const Cell> cells() const { return target.cell(count); }
    [[nodiscard]] Rows rows() const { return collect<double>(plan, target, count); }
};

// Returns a line about the first difference; empty when equal.
std::string compare(const Rows& rows, const votess::Tessellation& t);
void check_header(const Header& h, std::span<const Cell> cells);
PlanOptions options_for(const PointSet& set);
votess::Tessellation on_cpu(const PointSet& set, const PlanOptions& plan, std::span<const double> weights = {});
// Compares a frame of the set with the CPU.
std::string check(Host& host, const PointSet& set, PlanOptions options);
// Compares frames of several sets, each in its own box, with one plan, whose pipelines take long to make.
std::string check(Host& host, std::span<const PointSet> sets, PlanOptions options);

}  // namespace test::frame
