#include "gpu/frames/frame.hpp"

#include <algorithm>

namespace votess::vulkan {
namespace {

using gpu::FrameCell;
using gpu::FrameHeader;
using gpu::FramePush;

static_assert(sizeof(Header) == sizeof(FrameHeader) && offsetof(Header, kept) == offsetof(FrameHeader, kept));
static_assert(sizeof(Cell) == sizeof(FrameCell) && offsetof(Cell, faces) == offsetof(FrameCell, faces));

constexpr double volume_tolerance = 0.5e-5;

}  // namespace

bool detail::is_unresolved(std::uint32_t status) {
    switch (static_cast<CellStatus>(status)) {
        case CellStatus::certified:
        case CellStatus::duplicate:
        case CellStatus::empty:
        case CellStatus::outside:
            return false;
        default:
            return true;
    }
}

Frame::Frame() = default;

void Frame::record(VkCommandBuffer commands, const RecordOptions& options) const {
    if (!state_) refuse("the Frame is empty: Plan::frame() makes one");
    if (commands == VK_NULL_HANDLE) refuse("the command buffer is null");
    const std::uint32_t most = state_->plan->options.max_seeds;
    if (options.count > most)
        refuse("count = " + std::to_string(options.count) + " is more than max_seeds = " + std::to_string(most));
    if (options.count_buffer.offset % 4 != 0)
        refuse("count_buffer.offset = " + std::to_string(options.count_buffer.offset) + " must be a multiple of 4");
    detail::check_domain(state_->plan->options, options);
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
    weights_ = slice(buffers.weights, sizes.weights, "weights");
    header_ = slice(buffers.header, sizes.header, "header");
    gpu::PartOfBuffer workspace(*plan->device, scratch.handle, scratch.offset);
    seeds_.reserve(workspace, plan->options.max_seeds, plan->images, static_cast<std::uint32_t>(plan->walls.size()),
                   plan->passes->settings.weights);
    seeds_.set_walls(plan->walls);
    cells_.reserve(workspace, plan->chunk_cells, plan->passes->settings);
    if (plan->options.follow)
        kept_.reserve(workspace, plan->options.max_seeds + plan->images, plan->options.max_seeds,
                      slice(buffers.kept, sizes.kept, "kept"));
    cells_.set_rows_out({.rows = slice(buffers.indices, sizes.indices, "indices"),
                         .areas = slice(buffers.areas, sizes.areas, "areas"),
                         .shifts = slice(buffers.shifts, sizes.shifts, "shifts"),
                         .capacity = plan->entries,
                         .window_bits = gpu::DeviceCells::window_bits(*plan->device)});
    outputs_.set(BINDING_HEADER, header_);
    outputs_.set(BINDING_CELLS, slice(buffers.cells, sizes.cells, "cells"));
    // The pass binds the header in place of an array that is not requested.
    const gpu::Slice geometry = slice(buffers.geometry, sizes.geometry, "geometry");
    outputs_.set(BINDING_GEOMETRY_OUT, geometry ? geometry : header_);
    outputs_.set(BINDING_GEOMETRY, cells_.geometry());
    outputs_.set(BINDING_CHUNK, cells_.chunk());
    for (const std::uint32_t binding : {BINDING_SEED_INPUT, BINDING_SEEDS})
        outputs_.set(binding, seeds_.bindings().get(binding));
    // Makes all descriptor sets: a recording of fewer seeds needs no other.
    record(
        VK_NULL_HANDLE,
        {.count = plan->options.max_seeds, .count_buffer = {}, .box = {}, .cell = {}, .timestamps = {}, .fresh = true});
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
    set_domain(seeds_, *plan, options);
    seeds_.set_count(options.count == 0 ? 0 : options.count + plan->images);
    stamp(0);
    record_upload(options);
    stamp(1);
    {
        const auto label = recorder_.label("sort");
        seeds_.record_order(recorder_, passes, KEY_BITS_PER_AXIS);
        seeds_.record_gather(recorder_, passes);
    }
    stamp(2);
    {
        const auto label = recorder_.label("knn");
        seeds_.record_hierarchy(recorder_, passes, chunk_job(options.count));
    }
    stamp(3);
    if (plan->options.follow)
        record_kept_cells(options);
    else
        record_cells(options.count);
    recorder_.barrier_to_all();
    stamp(4);
}

void detail::FrameState::record_upload(const RecordOptions& of_frame) {
    const auto label = recorder_.label("upload");
    const gpu::Passes& passes = *plan->passes;
    const PlanOptions& options = plan->options;
    const std::uint32_t count = of_frame.count;
    seeds_.record_begin(recorder_, false);
    recorder_.fill(header_, offsetof(FrameHeader, seeds), 4, count);
    recorder_.fill(header_, offsetof(FrameHeader, certified), sizeof(FrameHeader) - 4, 0);
    recorder_.fill(cells_.state(), offsetof(gpu::ChunkState, row_base), 4, 0);
    recorder_.barrier();
    std::uint32_t check = CHECK_BOX;
    if (of_frame.count_buffer.buffer != VK_NULL_HANDLE) {
        const gpu::Slice number{of_frame.count_buffer.buffer, of_frame.count_buffer.offset, sizeof(std::uint32_t)};
        recorder_.copy(number, 0, header_, offsetof(FrameHeader, seeds), number.size);
        seeds_.record_present(recorder_, number);
        recorder_.barrier();
        check |= CHECK_COUNT;
    }
    const std::uint32_t format = options.format == SeedFormat::float32 ? POINTS_FLOAT32 : POINTS_FLOAT64;
    seeds_.record_upload(recorder_, passes, {raw_, format, options.stride, check}, 0, count);
    if (const auto& weights = options.weights)
        seeds_.record_weights(recorder_, passes, {weights_, format, weights->stride, check, weights->first}, 0, count);
    if (!plan->walls.empty()) seeds_.record_walls(recorder_, passes, count);
    if (is_periodic(options)) seeds_.record_images(recorder_, passes, header_, count);
}

gpu::ChunkJob detail::FrameState::chunk_job(std::uint32_t count) const {
    gpu::ChunkJob job;
    job.neighbors = plan->options.neighbors;
    job.walls = plan->options.list_walls;
    job.volume_tolerance = volume_tolerance;
    job.own_count = count;
    for (std::size_t k = 0; k < 3 && plan->options.cell; ++k) {
        constexpr std::uint64_t rounded = 2 * MAX_STEPS_APART;  // images may be off by less
        job.bounded |= 9u << k;
        job.lower[k] = rounded;
        job.upper[k] = seeds_.extent()[k] - rounded;
        job.named_from = count;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        if (!plan->options.periodic[k]) continue;
        job.bounded |= 9u << k;
        job.upper[k] = seeds_.extent()[k];
        job.period[k] = seeds_.period(k);
        job.named_from = count;
    }
    return job;
}

void detail::FrameState::record_cells(std::uint32_t count) {
    const gpu::Passes& passes = *plan->passes;
    const gpu::ChunkJob job = chunk_job(count);
    // Images are sorted among the seeds and get no cells.
    for (std::uint32_t first = 0; first < seeds_.count();) {
        const std::uint32_t cells = std::min(plan->chunk_cells, seeds_.count() - first);
        cells_.set_job(seeds_, passes.settings, job, first, cells);
        cells_.record_knn(recorder_, passes);
        cells_.record_clip(recorder_, passes, true);
        record_download(job, first, cells);
        first += cells;
    }
}

void detail::FrameState::record_download(const gpu::ChunkJob& job, std::uint32_t first, std::uint32_t cells) {
    const gpu::Passes& passes = *plan->passes;
    const auto label = recorder_.label("download");
    if (job.neighbors) cells_.record_rows(recorder_, passes);
    const FramePush push{first,
                         cells,
                         plan->entries,
                         job.neighbors ? 1u : 0u,
                         plan->options.geometry ? 1u : 0u,
                         seeds_.units().shift,
                         seeds_.count(),
                         job.own_count,
                         cells_.clip_push().keeps};
    recorder_.run(passes.download_cells, outputs_, push, cells);
    if (!job.neighbors) return;
    recorder_.run(passes.download_total, outputs_, push, 1);
}

void detail::FrameState::record_kept_cells(const RecordOptions& options) {
    const gpu::Passes& passes = *plan->passes;
    const gpu::ChunkJob job = chunk_job(options.count);
    if (seeds_.count() > 0) cells_.set_job(seeds_, passes.settings, job, 0, seeds_.count());
    kept_.set_job(seeds_, cells_, options.count);
    kept_.record_recall(recorder_, passes, options.fresh);
    for (std::uint32_t round = 0; seeds_.count() > 0; ++round) {
        cells_.record_knn(recorder_, passes);
        cells_.record_clip(recorder_, passes, true);
        if (round == KEPT_ROUNDS) break;
        const auto label = recorder_.label("kept");
        kept_.record_match(recorder_, passes);
        if (round + 1 == KEPT_ROUNDS) kept_.record_judgment(recorder_, passes);
    }
    if (seeds_.count() > 0) record_download(job, 0, seeds_.count());
    kept_.record_store(recorder_, passes);
}

}  // namespace votess::vulkan
