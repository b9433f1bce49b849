// votess::vulkan::Plan: checks, pipelines and sizes.
#include <algorithm>
#include <limits>

#include "gpu/frames/frame.hpp"
#include "gpu/passes/kernel_choice.hpp"
#include "input/settle.hpp"

namespace votess::vulkan {
namespace {

using detail::max_of_all;

constexpr VkDeviceSize geometry_bytes = 16;  // of a cell: vec4

void check(const HostInstance& host) {
    if (host.instance == VK_NULL_HANDLE) refuse("the Vulkan instance is null");
    if (host.get_instance_proc_addr == nullptr) refuse("get_instance_proc_addr is null");
    if (host.api_version < VK_API_VERSION_1_1)
        throw Error(ErrorCode::unsupported, "votess needs an instance of Vulkan 1.1 (VkApplicationInfo::apiVersion)");
}

std::shared_ptr<gpu::vulkan::Instance> adopt(const HostInstance& host, bool debug_utils) {
    check(host);
    return gpu::vulkan::Instance::adopt({host.instance, host.get_instance_proc_addr, host.api_version, debug_utils});
}

void check(const PlanOptions& options) {
    if (options.max_seeds == 0 || options.max_seeds > max_of_all)
        refuse("max_seeds = " + std::to_string(options.max_seeds) + " must be 1 to " + std::to_string(max_of_all));
    if (options.stride < 3) refuse("stride = " + std::to_string(options.stride) + " must be 3 or more numbers");
    if (options.format != SeedFormat::float32 && options.format != SeedFormat::float64)
        refuse("format = " + std::to_string(static_cast<std::uint32_t>(options.format)) +
               " is neither float32 nor float64");
    check_member("PlanOptions::k_init", options.k_init);
    if (options.areas && !options.neighbors) refuse("areas follow the rows: request neighbors too");
    if (options.follow && options.chunk_size != 0)
        refuse("chunk_size = " + std::to_string(options.chunk_size) +
               ", but with follow all cells are in flight at once: leave it 0");
    detail::check_domain(options);
}

void check_family(const gpu::vulkan::Adapter& adapter, std::uint32_t family) {
    const std::string given = "queue_family = " + std::to_string(family);
    if (family >= adapter.families.size())
        refuse(given + ", but " + adapter.name + " has " + std::to_string(adapter.families.size()) +
               " queue families: give the family of the queue that runs the commands");
    if (!(adapter.families[family] & VK_QUEUE_COMPUTE_BIT))
        refuse(given + " has no compute on " + adapter.name + ": requirements() names a family that has one");
}

// Checks an array that shaders bind as a whole.
void check_range(const gpu::vulkan::Device& device, VkDeviceSize bytes, const char* what, const char* option) {
    const VkDeviceSize most = device.adapter().limits.maxStorageBufferRange;
    if (bytes <= most) return;
    throw Error(ErrorCode::unsupported, std::string("the ") + what + " would take " + gpu::vulkan::bytes_text(bytes) +
                                            ", more than the " + gpu::vulkan::bytes_text(most) + " that shaders of " +
                                            device.adapter().name + " can bind at once: lower " + option);
}

// Makes the pipelines of a plan and finds its sizes.
std::shared_ptr<const detail::PlanState> make_plan(std::shared_ptr<gpu::vulkan::Device> of,
                                                   const PlanOptions& options) {
    auto state = std::make_shared<detail::PlanState>();
    state->device = std::move(of);
    state->options = options;
    gpu::vulkan::Device& device = *state->device;
    gpu::PassSettings settings = gpu::usual_settings(device, options.k_init);
    settings.measure = options.geometry || options.areas;
    settings.areas = options.areas;
    settings.frames = true;
    settings.weights = options.weights.has_value();
    settings.walls = !options.walls.empty();
    settings.tiers[1].ties = !settings.weights && !settings.walls;  // with these no pass decides ties
    settings.images = detail::is_periodic(options);
    settings.triclinic = options.cell.has_value();
    settings.follow = options.follow;
    gpu::DeviceSeeds seeds;
    detail::make_walls(*state);
    detail::set_domain(seeds, *state, {.count = options.max_seeds});  // throws where no frame is possible
    state->passes.emplace(device, settings);
    if (settings.images) state->images = options.max_images != 0 ? options.max_images : detail::usual_images(options);
    if (state->images > max_of_all)
        refuse("max_images = " + std::to_string(state->images) + " must be at most " + std::to_string(max_of_all));
    state->chunk_cells = options.follow ? options.max_seeds + state->images
                                        : gpu::usual_chunk(device, settings, options.chunk_size, options.max_seeds);

    const VkDeviceSize n = options.max_seeds;
    constexpr std::uint32_t usual_row = 20;
    constexpr std::uint64_t max_entries = std::numeric_limits<std::uint32_t>::max();
    state->entries = options.max_entries != 0
                         ? options.max_entries
                         : static_cast<std::uint32_t>(std::min(usual_row * std::uint64_t{n}, max_entries));
    BufferSizes& sizes = state->sizes;
    const VkDeviceSize number_bytes = options.format == SeedFormat::float32 ? 4 : 8;
    sizes.seeds = ((n - 1) * options.stride + 3) * number_bytes;
    if (options.weights)
        sizes.weights = (options.weights->first + (n - 1) * options.weights->stride + 1) * number_bytes;
    sizes.header = sizeof(Header);
    sizes.cells = n * sizeof(Cell);
    sizes.indices = options.neighbors ? VkDeviceSize{state->entries} * 4 : 0;
    sizes.geometry = options.geometry ? n * geometry_bytes : 0;
    sizes.areas = options.areas ? sizes.indices : 0;
    sizes.shifts = settings.images ? sizes.indices : 0;
    gpu::PartOfBuffer workspace(device, VK_NULL_HANDLE, 0);
    seeds.reserve(workspace, options.max_seeds, state->images, static_cast<std::uint32_t>(state->walls.size()),
                  settings.weights);
    gpu::DeviceCells().reserve(workspace, state->chunk_cells, settings);
    if (options.follow) {
        gpu::KeptFrames().reserve(workspace, options.max_seeds + state->images, options.max_seeds, {});
        sizes.kept = gpu::KeptFrames::bytes(options.max_seeds, settings.images);
    }
    sizes.workspace = workspace.bytes();
    check_range(device, sizes.seeds, "seeds", "max_seeds or stride");
    check_range(device, sizes.weights, "weights", "max_seeds or stride");
    check_range(device, sizes.cells, "cells", "max_seeds");
    check_range(device, sizes.geometry, "geometry", "max_seeds");
    check_range(device, sizes.kept, "kept cells", "max_seeds, or leave out follow");
    check_range(device, workspace.largest(), "largest part of the workspace", "max_seeds or chunk_size");
    return state;
}

}  // namespace

Requirements requirements(const HostInstance& host, VkPhysicalDevice physical_device) {
    const auto instance = adopt(host, false);
    if (physical_device == VK_NULL_HANDLE) refuse("the physical device is null");
    const auto adapter = gpu::vulkan::query_adapter(instance->calls(), physical_device, instance->version());
    Requirements needs;
    needs.missing = adapter.missing();
    needs.queue_family = adapter.queue_family;
    needs.features.shaderFloat64 = adapter.float64;
    needs.subgroup_size_control = adapter.subgroup_size_control;
    if (adapter.portability_subset) needs.extensions.emplace_back("VK_KHR_portability_subset");
    return needs;
}

Plan::Plan(const HostDevice& host, const PlanOptions& options) {
    const auto instance = adopt(host.host, host.debug_utils);
    check(options);
    if (host.physical_device == VK_NULL_HANDLE) refuse("the physical device is null");
    if (host.device == VK_NULL_HANDLE) refuse("the device is null");
    const auto adapter = gpu::vulkan::query_adapter(instance->calls(), host.physical_device, instance->version());
    check_family(adapter, host.queue_family);
    state_ = make_plan(gpu::vulkan::Device::adopt(
                           instance, adapter,
                           {host.device, host.queue_family, host.probe_queue, host.features.shaderFloat64 != VK_FALSE,
                            host.subgroup_size_control, host.pipeline_cache}),
                       options);
}

Plan detail::PlanAccess::plan(std::shared_ptr<gpu::vulkan::Device> device, const PlanOptions& options) {
    check(options);
    return Plan(make_plan(std::move(device), options));
}

Plan Plan::with(const PlanOptions& options) const {
    return detail::PlanAccess::plan(state_->device, options);
}

const BufferSizes& Plan::sizes() const noexcept {
    return state_->sizes;
}

const PlanOptions& Plan::options() const noexcept {
    return state_->options;
}

std::string Plan::kernel() const {
    const gpu::PassSettings& settings = state_->passes->settings;
    return gpu::kernel_text(state_->device->adapter(), settings.subgroup_size, settings.measure_float64);
}

Frame Plan::frame(const Buffers& buffers) const {
    Frame frame;
    frame.state_ = std::make_shared<detail::FrameState>(state_, buffers);
    return frame;
}

}  // namespace votess::vulkan
