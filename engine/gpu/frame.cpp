#include "gpu/frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "input/options.hpp"

namespace votess::vulkan {
namespace {

using gpu::FrameCell;
using gpu::FrameHeader;
using gpu::FramePush;
using gpu::vulkan::push_bytes;

static_assert(sizeof(Header) == sizeof(FrameHeader) && offsetof(Header, faces) == offsetof(FrameHeader, faces));
static_assert(sizeof(Cell) == sizeof(FrameCell) && offsetof(Cell, faces) == offsetof(FrameCell, faces));

constexpr VkDeviceSize geometry_bytes = 16;  // of a cell: vec4
constexpr double volume_tolerance = 0.5e-5;
constexpr std::uint32_t most_walk_visits = 2000;  // a frame waits for its slowest cell; resolve() makes what is left
constexpr double margin_spacings = 3.4;           // of the mean distance between seeds: most uniform cells need less
constexpr std::uint32_t most_of_all = 1u << 27;   // seeds: rows have 32 bits for their entries

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::invalid_argument, what);
}

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

void check_cell(const TriclinicBox& cell) {
    if (cell.periodic != std::array{true, true, true})
        throw Error(ErrorCode::unsupported, "cell: in recorded frames a triclinic box must repeat along all its edges");
}

void check(const PlanOptions& options) {
    if (options.most_seeds == 0 || options.most_seeds > most_of_all)
        refuse("most_seeds = " + std::to_string(options.most_seeds) + " must be 1 to " + std::to_string(most_of_all));
    if (!(options.margin >= 0)) refuse("margin = " + number(options.margin) + " must be 0 or more");
    if (options.stride < 3) refuse("stride = " + std::to_string(options.stride) + " must be 3 or more numbers");
    if (options.format != SeedFormat::float32 && options.format != SeedFormat::float64)
        refuse("format = " + std::to_string(static_cast<std::uint32_t>(options.format)) +
               " is neither float32 nor float64");
    check_k_init(options.k_init);
    if (options.areas && !options.neighbors) refuse("areas lie beside the rows: neighbors must be wanted too");
    if (!options.cell) {
        check_box(options.box);
        return;
    }
    const Box none;
    if (options.box.lower != none.lower || options.box.upper != none.upper)
        refuse("box and cell are both given: the cell is a box by itself, give one of them");
    if (options.periodic != std::array<bool, 3>{})
        refuse("cell and periodic contradict each other: the cell says itself along which edges it repeats");
    check_cell(*options.cell);
}

// Returns how far around the box seeds get images.
double margin_of(const PlanOptions& options, const Box& box, std::uint32_t count) {
    if (options.margin > 0) return options.margin;
    double spacing = 1 / std::cbrt(static_cast<double>(std::max(count, 1u)));
    for (std::size_t k = 0; k < 3; ++k) spacing *= std::cbrt(box.upper[k] - box.lower[k]);
    return margin_spacings * spacing;
}

gpu::CellImages images_of(const PlanOptions& options, const TriclinicBox& cell, std::uint32_t count) {
    double volume = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
        volume += cell.a[k] * (cell.b[l] * cell.c[m] - cell.b[m] * cell.c[l]);
    }
    const double margin = margin_spacings * std::cbrt(std::abs(volume) / std::max(count, 1u));
    return gpu::cell_images(cell, options.margin > 0 ? options.margin : margin);
}

// Places for images: a quarter more than uniform seeds have.
std::uint32_t usual_images(const PlanOptions& options) {
    const double margin = margin_of(options, options.box, options.most_seeds);
    double larger = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        const double side = options.box.upper[k] - options.box.lower[k];
        if (options.periodic[k]) larger *= 1 + 2 * std::min(margin / side, 1.0);
    }
    if (options.cell) {
        const gpu::CellImages images = images_of(options, *options.cell, options.most_seeds);
        larger = 1 / images.volume;
        for (std::size_t k = 0; k < 3; ++k) larger *= images.box.upper[k] - images.box.lower[k];
    }
    return static_cast<std::uint32_t>(std::min(1.25 * (larger - 1) * options.most_seeds + 1000, 1.0 * most_of_all));
}

// Arrays that shaders see as wholes.
void check_range(const gpu::vulkan::Device& device, VkDeviceSize bytes, const char* what, const char* option) {
    const VkDeviceSize most = device.adapter().limits.maxStorageBufferRange;
    if (bytes <= most) return;
    throw Error(ErrorCode::unsupported, std::string("the ") + what + " would take " + gpu::vulkan::bytes_text(bytes) +
                                            ", more than the " + gpu::vulkan::bytes_text(most) + " that shaders of " +
                                            device.adapter().name + " can see at once: lower " + option);
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
    auto state = std::make_shared<detail::PlanState>();
    state->device = gpu::vulkan::Device::adopt(
        instance, adapter,
        {host.device, host.queue_family, host.probe_queue, host.features.shaderFloat64 != VK_FALSE,
         host.subgroup_size_control, host.pipeline_cache});
    state->options = options;
    gpu::vulkan::Device& device = *state->device;
    gpu::PassSettings settings = gpu::usual_settings(device, options.k_init);
    settings.measure = options.geometry || options.areas;
    settings.areas = options.areas;
    settings.frames = true;
    settings.tiers[1].ties = true;
    settings.most_walk_visits = std::min(settings.most_walk_visits, most_walk_visits);
    settings.images = state->is_periodic();
    settings.triclinic = options.cell.has_value();
    state->passes.emplace(device, settings);
    if (state->is_periodic()) state->images = options.most_images != 0 ? options.most_images : usual_images(options);
    if (state->images > most_of_all)
        refuse("most_images = " + std::to_string(state->images) + " must be at most " + std::to_string(most_of_all));
    state->chunk_cells = gpu::usual_chunk(device, settings, options.chunk_size, options.most_seeds);

    const VkDeviceSize n = options.most_seeds;
    constexpr std::uint32_t usual_row = 20;
    // Rows are seen through windows, with areas through one.
    const std::uint64_t most_entries = std::uint64_t{options.areas ? 1u : ROW_WINDOWS}
                                       << gpu::DeviceCells::window_bits(device);
    if (options.most_entries > most_entries)
        throw Error(ErrorCode::unsupported, "most_entries = " + std::to_string(options.most_entries) +
                                                " is more than the " + std::to_string(most_entries) +
                                                " that shaders of " + adapter.name + " can reach");
    state->entries = options.most_entries != 0
                         ? options.most_entries
                         : static_cast<std::uint32_t>(std::min(usual_row * std::uint64_t{n}, most_entries));
    BufferSizes& sizes = state->sizes;
    const VkDeviceSize number_bytes = options.format == SeedFormat::float32 ? 4 : 8;
    sizes.seeds = ((n - 1) * options.stride + 3) * number_bytes;
    sizes.header = sizeof(Header);
    sizes.cells = n * sizeof(Cell);
    sizes.indices = options.neighbors ? VkDeviceSize{state->entries} * 4 : 0;
    sizes.geometry = options.geometry ? n * geometry_bytes : 0;
    sizes.areas = options.areas ? sizes.indices : 0;
    sizes.shifts = state->is_periodic() ? sizes.indices : 0;
    if (state->is_periodic() && !options.cell)  // refuses the box now
        gpu::DeviceSeeds().set_periodic_box(options.box, options.periodic,
                                            margin_of(options, options.box, options.most_seeds));
    gpu::PartOfBuffer workspace(device, VK_NULL_HANDLE, 0);
    gpu::DeviceSeeds().reserve(workspace, options.most_seeds, state->images);
    gpu::DeviceCells().reserve(workspace, state->chunk_cells, settings);
    sizes.workspace = workspace.bytes();
    check_range(device, sizes.seeds, "seeds", "most_seeds or stride");
    check_range(device, sizes.cells, "cells", "most_seeds");
    check_range(device, sizes.geometry, "geometry", "most_seeds");
    check_range(device, workspace.largest(), "largest part of the workspace", "most_seeds or chunk_size");
    state_ = std::move(state);
}

const BufferSizes& Plan::sizes() const noexcept {
    return state_->sizes;
}

const PlanOptions& Plan::options() const noexcept {
    return state_->options;
}

Frame Plan::frame(const Buffers& buffers) const {
    Frame frame;
    frame.state_ = std::make_shared<detail::FrameState>(state_, buffers);
    return frame;
}

Frame::Frame() = default;

void Frame::record(VkCommandBuffer commands, const RecordOptions& options) const {
    if (!state_) refuse("the Frame is empty: Plan::frame() makes one");
    if (commands == VK_NULL_HANDLE) refuse("the command buffer is null");
    const std::uint32_t most = state_->plan->options.most_seeds;
    if (options.count > most)
        refuse("count = " + std::to_string(options.count) + " is more than most_seeds = " + std::to_string(most));
    if (options.box) check_box(*options.box);
    const bool triclinic = state_->plan->options.cell.has_value();
    if (triclinic ? options.box.has_value() : options.cell.has_value())
        refuse(triclinic ? "a box is given, where the plan has a cell" : "a cell is given, where the plan has none");
    if (options.cell) check_cell(*options.cell);
    state_->record(commands, options);
}

detail::FrameState::FrameState(std::shared_ptr<const detail::PlanState> of, const Buffers& buffers)
    : plan(std::move(of)), recorder_(*plan->device) {
    const BufferSizes& sizes = plan->sizes;
    const VkDeviceSize alignment =
        std::max<VkDeviceSize>(plan->device->adapter().limits.minStorageBufferOffsetAlignment, 4);
    const auto slice = [&](const BufferRange& range, VkDeviceSize bytes, const char* name) {
        if (bytes == 0) return gpu::Slice{};
        if (range.buffer == VK_NULL_HANDLE) refuse(std::string("the buffer of ") + name + " is null");
        if (range.offset % alignment != 0)
            refuse(std::string("the offset of ") + name + ", " + std::to_string(range.offset) +
                   ", is not a multiple of " + std::to_string(alignment));
        return gpu::Slice{range.buffer, range.offset, bytes};
    };
    const gpu::Slice scratch = slice(buffers.workspace, sizes.workspace, "workspace");
    raw_ = slice(buffers.seeds, sizes.seeds, "seeds");
    header_ = slice(buffers.header, sizes.header, "header");
    gpu::PartOfBuffer workspace(*plan->device, scratch.handle, scratch.offset);
    seeds_.reserve(workspace, plan->options.most_seeds, plan->images);
    cells_.reserve(workspace, plan->chunk_cells, plan->passes->settings);
    // Passes bind something in place of arrays that are not wanted.
    const auto wanted = [&](const gpu::Slice& array) { return array ? array : header_; };
    cells_.set_rows_out(wanted(slice(buffers.indices, sizes.indices, "indices")),
                        wanted(slice(buffers.areas, sizes.areas, "areas")), plan->entries,
                        gpu::DeviceCells::window_bits(*plan->device));
    if (plan->is_periodic()) cells_.set_shifts_out(wanted(slice(buffers.shifts, sizes.shifts, "shifts")));
    outputs_.set(BINDING_HEADER, header_);
    outputs_.set(BINDING_CELLS, slice(buffers.cells, sizes.cells, "cells"));
    outputs_.set(BINDING_GEOMETRY_OUT, wanted(slice(buffers.geometry, sizes.geometry, "geometry")));
    for (const std::uint32_t binding :
         {BINDING_INFO, BINDING_ROW_LENGTH, BINDING_ROW_OFFSETS, BINDING_CHUNK_STATE, BINDING_GEOMETRY})
        outputs_.set(binding, cells_.slice(binding));
    outputs_.set(BINDING_SEED_INPUT, seeds_.seed_input());
    // All descriptor sets are made here: a recording of fewer seeds needs no other.
    record(VK_NULL_HANDLE, {.count = plan->options.most_seeds, .box = {}, .cell = {}, .timestamps = {}});
}

void detail::FrameState::record(VkCommandBuffer commands, const RecordOptions& options) {
    recorder_.open(commands);
    try {
        record_stages(options);
    } catch (...) {
        recorder_.close();
        throw;
    }
    recorder_.close();
}

void detail::FrameState::record_stages(const RecordOptions& options) {
    const gpu::Passes& passes = *plan->passes;
    const auto stamp = [&](std::uint32_t slot) {
        if (options.timestamps.pool != VK_NULL_HANDLE)
            recorder_.write_timestamp(options.timestamps.pool, options.timestamps.first + slot);
    };
    const Box box = options.box.value_or(plan->options.box);
    if (plan->options.cell)
        seeds_.set_cell(images_of(plan->options, options.cell.value_or(*plan->options.cell), options.count));
    else if (plan->is_periodic())
        seeds_.set_periodic_box(box, plan->options.periodic, margin_of(plan->options, box, options.count));
    else
        seeds_.set_box(box);
    seeds_.set_count(options.count == 0 ? 0 : options.count + plan->images);
    stamp(0);
    {
        const auto label = recorder_.label("upload");
        seeds_.record_begin(recorder_, false);
        recorder_.fill(header_, offsetof(FrameHeader, seeds), 4, options.count);
        recorder_.fill(header_, offsetof(FrameHeader, certified), sizeof(FrameHeader) - 4, 0);
        recorder_.fill(cells_.slice(BINDING_CHUNK_STATE), offsetof(gpu::ChunkState, row_base), 4, 0);
        recorder_.barrier();
        const std::uint32_t format = plan->options.format == SeedFormat::float32 ? POINTS_FLOAT32 : POINTS_FLOAT64;
        seeds_.record_upload(recorder_, passes, {raw_, format, plan->options.stride, true}, 0, options.count);
        if (plan->is_periodic()) seeds_.record_images(recorder_, passes, header_, options.count);
    }
    stamp(1);
    {
        const auto label = recorder_.label("sort");
        seeds_.record_order(recorder_, passes, KEY_BITS_PER_AXIS);
        seeds_.record_gather(recorder_, passes);
    }
    stamp(2);
    {
        const auto label = recorder_.label("knn");
        seeds_.record_hierarchy(recorder_, passes);
    }
    stamp(3);
    record_cells(options.count);
    recorder_.barrier_to_all();
    stamp(4);
}

void detail::FrameState::record_cells(std::uint32_t count) {
    const gpu::Passes& passes = *plan->passes;
    gpu::ChunkJob job;
    job.neighbors = plan->options.neighbors;
    job.walls = plan->options.list_walls;
    job.volume_tolerance = volume_tolerance;
    job.own_count = count;
    for (std::size_t k = 0; k < 3 && plan->options.cell; ++k) {
        constexpr std::uint64_t rounded = 2 * MOST_STEPS_APART;  // images may be beside their places by less
        job.bounded |= 9u << k;
        job.lower[k] = rounded;
        job.upper[k] = seeds_.extent()[k] - rounded;
        job.named_from = count;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        if (!plan->options.periodic[k]) continue;
        job.bounded |= 9u << k;
        job.upper[k] = seeds_.extent()[k];
        job.named_from = count;
    }
    // Images are sorted among the seeds, and make no cells.
    for (std::uint32_t first = 0; first < seeds_.count();) {
        const std::uint32_t cells = std::min(plan->chunk_cells, seeds_.count() - first);
        cells_.set_job(seeds_, passes.settings, job, first, cells);
        {
            const auto label = recorder_.label("knn");
            cells_.record_knn(recorder_, passes);
        }
        {
            const auto label = recorder_.label("clip");
            cells_.record_clip(recorder_, passes, true);
        }
        const auto label = recorder_.label("download");
        if (job.neighbors) cells_.record_rows(recorder_, passes);
        const FramePush push{first,
                             cells,
                             plan->entries,
                             job.neighbors ? 1u : 0u,
                             plan->options.geometry ? 1u : 0u,
                             seeds_.units().shift,
                             count};
        recorder_.dispatch(*passes.download_cells, outputs_.list(), push_bytes(push), cells);
        recorder_.barrier();
        if (job.neighbors) {
            recorder_.dispatch(passes.download_total, outputs_.list(), push_bytes(push), 1);
            recorder_.barrier();
        }
        first += cells;
    }
}

}  // namespace votess::vulkan
