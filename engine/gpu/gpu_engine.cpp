#include "gpu/gpu_engine.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>

#include "gpu/domain/walls.hpp"
#include "gpu/passes/kernel_choice.hpp"
#include "input/option_name.hpp"

namespace votess::gpu {
namespace {

// Returns the shift as a word of a name, see SHIFT_NONE.
std::uint32_t shift_word(const std::array<std::int8_t, 3>& shift) {
    std::uint32_t word = 0;
    for (const std::int8_t k : shift) word = (word << 8) | static_cast<std::uint32_t>(k + 128);
    return word;
}

}  // namespace

GpuEngine::GpuEngine(std::shared_ptr<vulkan::Device> device, ExactClipper& clipper, const EngineLimits& limits)
    : device_(std::move(device)),
      memory_(*device_),
      clipper_(clipper),
      limits_(limits),
      seeds_(*device_, memory_),
      download_(*device_, memory_) {}

PassSettings GpuEngine::pass_settings() const {
    const bool float64 = device_->has_float64();
    const bool measured_double = job_.precision == Precision::double_ && !lists_only_;
    if (measured_double && !float64)
        throw Error(ErrorCode::unsupported, "device '" + device_->adapter().name + "' has no float64 arithmetic: use " +
                                                option("precision") + " = single, or the CPU");
    PassSettings s = usual_settings(*device_, job_.k_init);
    if (limits_.max_walk_visits != 0) s.max_walk_visits = limits_.max_walk_visits;
    if (measured_double) {
        s.tiers[0].float64 = true;
        if (s.subgroup_size != 0) s.tiers[0] = s.tiers[1];
    }
    s.measure_float64 = s.measure_float64 || measured_double;
    s.measure = !lists_only_ && (job_.want.volumes || job_.want.centroids || job_.want.areas);
    s.walls = has_device_walls(*job_.domain);
    s.areas = !lists_only_ && job_.want.areas;
    s.weights = job_.domain->has_weights();
    if (const std::uint32_t size = limits_.local_size != 0 ? limits_.local_size : local_size_from_environment();
        size != 0) {
        s.local_size = size;
        if (s.subgroup_size != 0) s.subgroups = std::max(size / s.subgroup_size, 1u);
    }
    return s;
}

std::uint32_t GpuEngine::chunk_cells(const PassSettings& settings) const {
    const VkDeviceSize usual = usual_chunk(*device_, settings, job_.chunk_size, seeds_.count());
    const auto cells = static_cast<std::uint32_t>(
        std::clamp<VkDeviceSize>(memory_.max_buffer_bytes() / DeviceCells::largest_bytes_per_cell(settings), 1, usual));
    // Pieces begin with a tile of the second tier's list.
    return cells > TILE_ITEMS ? cells / TILE_ITEMS * TILE_ITEMS : cells;
}

void GpuEngine::run(const Job& job, const DeviceDomain* domain, StageClock& clock, detail::Result& result) {
    clock_ = &clock;
    begin(job);
    device_clips_ = domain != nullptr && job_.points.count() > 0 && find_seeds(*domain);
    if (device_clips_) {
        find_parts();
        // A shader takes a seed beyond a wall for one on it.
        for (std::size_t i = 0; i < job_.beyond.size(); ++i)
            if (job_.beyond[i]) pending_.add(static_cast<std::int32_t>(i), &FallbackReasons::domain);
        for (std::size_t index = 0; index < parts_->size(); ++index) {
            clock.enter(&StageSeconds::upload);
            upload_part(index);
            clock.enter(&StageSeconds::sort);
            sort_part();
            clock.enter(&StageSeconds::knn);
            seeds_.build_hierarchy(*passes_, part_);
            device_seconds_.knn += seeds_.seconds().knn;
            clock.enter(&StageSeconds::clip);
            clip_part(index);
        }
        clock.share_clip(device_seconds_.knn, device_seconds_.clip, device_seconds_.download);
    } else {
        for (std::size_t i = 0; i < job_.points.count(); ++i)
            pending_.add(static_cast<std::int32_t>(i), &FallbackReasons::domain);
    }
    clock.enter(&StageSeconds::fallback);
    clip_pending(clipping.end);
    clock.enter(&StageSeconds::download);
    finish(result);
}

void GpuEngine::begin(const Job& job) {
    job_ = job;
    progress_ = Progress(job.progress);
    progress_.report(0);
    device_seconds_ = {};
    pending_.reset();
    duplicates_ = false;
    done_cells_ = 0;
    part_ = {};
    parts_.reset();
    // The device may still work on a run that was stopped.
    for (auto& chunk : chunks_)
        if (chunk) chunk->wait();
    download_.wait();
    // The CPU finds small faces, by areas of double precision: they do not depend on the device.
    lists_only_ = needs_polytopes(job_.want) || job_.min_face > 0 || job_.min_area > 0;
    clipper_.begin(job_);
    result_.begin(job_, clipper_.pool());
}

void GpuEngine::find_parts() {
    const PassSettings settings = pass_settings();
    if (!passes_ || passes_->settings != settings) {
        const StageClock::Within opening(*clock_, &StageSeconds::open);
        passes_.reset();
        for (auto& chunk : chunks_) chunk.reset();
        passes_.emplace(*device_, settings);
    }
    const std::uint32_t most = max_seeds();
    std::span<const std::int32_t> duplicate_of;
    if (job_.points.count() > most) {
        // Without this, equal seeds could lie in several parts.
        duplicate_of = clipper_.duplicate_of();
        duplicates_ = !duplicate_of.empty();
    }
    parts_.emplace(job_, duplicate_of, box_, periodic_ ? INDEX_MASK : most);
}

bool GpuEngine::find_seeds(const DeviceDomain& domain) {
    periodic_.reset();
    if (domain.images) {
        periodic_ = periodic_part(job_, *domain.images, max_seeds(), clipper_.pool());
        if (!periodic_) return false;
    }
    if (!job_.beyond.empty() && job_.points.count() > max_seeds()) return false;
    box_ = domain.box;
    seeds_.set_walls(device_walls(job_, box_));
    return true;
}

std::uint32_t GpuEngine::max_seeds() const {
    if (limits_.max_seeds != 0) return limits_.max_seeds;
    const vulkan::Adapter& adapter = device_->adapter();
    const bool measure = !lists_only_, weights = job_.domain->has_weights();
    const auto range = std::min<VkDeviceSize>(adapter.limits.maxStorageBufferRange, memory_.max_buffer_bytes());
    // Seven seeds have at most one node on level 0 and a seventh of that above.
    const VkDeviceSize by_nodes = range / DeviceSeeds::bytes_per_node(weights) * 7 - 8 * MAX_LEVELS;
    // 24 + 24 bytes of coordinates, 24 of keys and indices, 4 of input indices, 7 of nodes, 8 of names, and the results
    // of the cells. They take half of the memory; chunks and rows take a quarter each.
    const VkDeviceSize by_memory = adapter.device_memory / 2 / (92 + DeviceResults::bytes_per_member(measure));
    const VkDeviceSize by_geometry = range / (measure ? DeviceResults::geometry_bytes : 1);
    return static_cast<std::uint32_t>(std::min(
        {range / DeviceSeeds::bytes_per_seed(weights), by_geometry, by_nodes, by_memory, VkDeviceSize{INDEX_MASK}}));
}

void GpuEngine::upload_part(std::size_t index) {
    if (periodic_) {
        part_ = periodic_->part;
        seeds_.upload(*periodic_, job_, *passes_, clipper_.pool());
    } else {
        part_ = parts_->get(index);
        seeds_.upload(job_, part_.members, box_, *passes_, clipper_.pool());
    }
    if (part_.members.empty()) return;
    const std::uint32_t first = named_from();
    const auto name = [&](std::uint32_t i) {
        const std::size_t member = std::size_t{first} + i;
        return uvec2(static_cast<std::uint32_t>(part_.members[member]),
                     periodic_ ? shift_word(periodic_->shifts[member]) : SHIFT_NONE);
    };
    seeds_.upload_names(static_cast<std::uint32_t>(part_.members.size()) - first, name, clipper_.pool());
}

void GpuEngine::sort_part() {
    const unsigned resolution = job_.grid_resolution;
    const auto bits = resolution == 0 ? KEY_BITS_PER_AXIS
                                      : std::clamp<std::uint32_t>(std::bit_width(resolution - 1), 1, KEY_BITS_PER_AXIS);
    seeds_.sort(*passes_, bits);
    if (seeds_.state().duplicates == 0 && seeds_.state().suspects == 0) return;
    duplicates_ = true;
    if (job_.duplicates == Duplicates::error) clipper_.prepare();  // throws, and names the first
}

void GpuEngine::clip_part(std::size_t index) {
    const std::uint32_t cells = chunk_cells(passes_->settings);
    for (auto& chunk : chunks_)
        if (!chunk || chunk->capacity() != cells) {
            chunk.reset();
            chunk.emplace(*device_, memory_, cells, passes_->settings);
        }
    ChunkJob job;
    job.neighbors = job_.want.neighbors || lists_only_;
    job.walls = job_.list_walls;
    job.volume_tolerance = job_.precision == Precision::double_ ? 0.5e-10 : 0.5e-5;
    if (limits_.volume_tolerance != 0) job.volume_tolerance = limits_.volume_tolerance;
    static_cast<KnownSeeds&>(job) = part_;
    if (!part_.members.empty()) job.named_from = named_from();
    const auto max_entries = [&](std::uint32_t count) { return chunks_[0]->on_device().max_entries(count); };
    download_.begin(
        {.members = part_.own_count,
         .neighbors = job.neighbors,
         .measure = passes_->settings.measure,
         .areas = passes_->settings.areas,
         .shifts = periodic_.has_value(),
         .float64 = passes_->settings.measure_float64,
         .min_entries = std::max(max_entries(cells), 2 * max_entries(std::min(cells, Schedule::trial_cells))),
         .max_entries = limits_.max_entries});

    Schedule schedule(seeds_.count(), cells);
    bool first_batch = true;
    Chunk* running = nullptr;
    const bool last_part = index + 1 == parts_->size();
    std::size_t slot = 0;
    std::uint32_t most = cells;
    std::size_t done = 0;                           // seeds that the device took or left to the CPU
    auto begun = std::chrono::steady_clock::now();  // when the device started the running chunk
    const auto take = [&](Chunk& chunk) {
        chunk.wait();
        const auto now = std::chrono::steady_clock::now();
        most = paced_cells(chunk, std::chrono::duration<double>(now - begun).count(), cells);
        begun = now;
        collect(chunk, schedule);
    };
    for (;;) {
        const std::optional<Piece> piece = schedule.next(most);
        if (!piece && running == nullptr) break;
        Chunk* started = nullptr;
        if (piece) {
            done += piece->count;
            if (piece->on_device) {
                Chunk& next = *chunks_[slot];
                // A trial that is repeated with ties does not free its first rows.
                const VkDeviceSize needed = max_entries(piece->count) * (piece->trial && !piece->ties ? 2 : 1);
                if (running != nullptr && !download_.has_room(max_entries(running->count()) + needed)) {
                    take(*running);
                    running = nullptr;
                }
                if (!download_.has_room(needed)) {
                    take_batch(false);
                    download_.begin_batch();
                    first_batch = false;
                }
                started = &next;
                slot ^= 1;
                if (running == nullptr) begun = std::chrono::steady_clock::now();
                if (piece->ties) {
                    const StageClock::Within opening(*clock_, &StageSeconds::open);
                    passes_->make_with_ties(*device_);
                }
                started->start(seeds_, *passes_, job, *piece, download_.on_device());
            } else {
                leave_to_cpu(piece->first, piece->count);
            }
        }
        // The CPU clips the cells that earlier chunks left while the device works on this one. It clips the last ones
        // at the end.
        const double progress = progress_now();
        if (started != nullptr || done < seeds_.count() || !last_part) clip_pending(progress);
        Progress::require(progress_.going_on(progress));
        if (started != nullptr || running != nullptr) {
            const double share = static_cast<double>(done) / seeds_.count();
            touch_results((static_cast<double>(index) + share) / static_cast<double>(parts_->size()), first_batch);
        }
        if (running != nullptr) take(*running);
        running = started;
        if (running != nullptr && piece->trial) {  // its outcome is worth the wait
            running->wait();
            if (schedule.repeat_with_ties(*piece, uncertain_cells(*running))) {
                download_.set_entries(running->entries());
                done -= piece->count;
            } else {
                take(*running);
            }
            running = nullptr;
        }
    }
    take_batch(first_batch && is_in_input_order());
}

void GpuEngine::touch_results(double share, bool first_batch) {
    const bool placed = first_batch && is_in_input_order() && job_.want.neighbors && !lists_only_;
    const double row = placed && done_cells_ > 0 ? static_cast<double>(download_.entries()) / done_cells_ : 0;
    result_.touch(share, row, clipper_.pool());
}

std::size_t GpuEngine::uncertain_cells(const Chunk& chunk) const {
    if (chunk.piece().ties || seeds_.state().lossy != 0 || job_.domain->has_weights()) return 0;
    return static_cast<std::size_t>(
        std::ranges::count(chunk.info(), STATUS_NEEDS_EXACT, [](std::uint32_t info) { return info & 0xff; }));
}

std::uint32_t GpuEngine::paced_cells(const Chunk& chunk, double host_seconds, std::uint32_t most) const {
    constexpr double usual_seconds = 0.25;  // drivers of displays stop work that takes seconds
    constexpr double max_growth = 32;       // the next cells may be slower
    if (limits_.chunk_seconds == 0 && device_->adapter().software()) return most;
    const double allowed = limits_.chunk_seconds != 0 ? limits_.chunk_seconds : usual_seconds;
    const auto on_device = chunk.seconds();
    double spent = on_device.knn + on_device.clip + on_device.download;
    if (spent == 0) spent = host_seconds;  // a device without timestamps
    const double growth = std::min(allowed / std::max(spent, 1e-9), max_growth);
    return static_cast<std::uint32_t>(
        std::clamp<double>(chunk.count() * growth, std::min(most, Schedule::trial_cells), most));
}

void GpuEngine::collect(const Chunk& chunk, Schedule& schedule) {
    const auto order = seeds_.order().subspan(chunk.first(), chunk.count());
    const PendingCells::Left found = pending_.add_left(chunk.info(), order, part_, clipper_.pool());
    const std::size_t own = chunk.count() - found.beside;
    done_cells_ += own;
    download_.set_entries(chunk.entries());
    const auto seconds = chunk.seconds();
    device_seconds_.knn += seconds.knn;
    device_seconds_.clip += seconds.clip;
    device_seconds_.download += seconds.download;
    schedule.note(chunk.piece(), own, chunk.left_count(), found.to_cpu, uncertain_cells(chunk));
}

void GpuEngine::take_batch(bool all_cells) {
    const StageClock::Within stage(*clock_, &StageSeconds::download);
    const Want& want = job_.want;
    download_.read_cells(*passes_);
    const HostCells cells({.job = &job_,
                           .result = &result_,
                           .pool = &clipper_.pool(),
                           .members = is_in_input_order() ? std::span<std::int32_t>() : std::span(part_.members),
                           .wraps = periodic_ ? std::span(periodic_->wraps) : std::span<std::array<double, 3>>(),
                           .shift = seeds_.on_device().units().shift,
                           .info = download_.info()});
    if (job_.domain->has_weights()) cells.set_empty();
    if (lists_only_) {
        download_.read_rows(*passes_, [&](const DeviceRows& rows) {
            const StageClock::Within fallback(*clock_, &StageSeconds::fallback);
            cells.clip(rows, clipper_, {progress_now(), progress_now()});
        });
        return;
    }
    if (passes_->settings.measure)
        download_.read_geometry([&](std::size_t first, std::size_t count, const Numbers& geometry) {
            cells.finish(first, count, geometry);
        });
    else
        cells.finish(0, part_.own_count, {});
    if (!want.neighbors) return;
    if (all_cells) {
        clip_pending(clipping.end);
        result_.settle(download_.lengths(), clipper_.pool());
    }
    download_.read_rows(*passes_, [&](const DeviceRows& rows) { all_cells ? cells.place(rows) : cells.keep(rows); });
}

void GpuEngine::leave_to_cpu(std::uint32_t first, std::uint32_t count) {
    for (const std::uint32_t member : seeds_.order().subspan(first, count)) {
        if ((member & INDEX_MASK) >= part_.own_count) continue;
        ++done_cells_;
        if ((member & DUPLICATE_BIT) != 0) continue;
        pending_.add(input_of(member), &FallbackReasons::skipped);
    }
}

void GpuEngine::clip_pending(double progress) {
    if (pending_.empty()) return;
    const StageClock::Within fallback(*clock_, &StageSeconds::fallback);
    pending_.clip(clipper_, result_, {progress, progress});
}

void GpuEngine::finish(detail::Result& result) {
    std::optional<Stoppable> stoppable(std::in_place, progress_);
    // For a power diagram it sorts the seeds, to find those at one place.
    if (!job_.domain->has_weights() || !device_clips_ || duplicates_ || !job_.outside.empty())
        clipper_.set_empty(result_);
    if (duplicates_ || !device_clips_) result_.set_duplicates(clipper_.duplicate_of(), clipper_.pool());
    result_.finish(result, clipper_.pool());
    stoppable.reset();
    result.stats.device = device_->adapter().name;
    result.stats.fallback_reasons = pending_.reasons();
    result.stats.precision = device_clips_ && !lists_only_ ? job_.precision : Precision::double_;
    clipper_.end();
    device_->instance().check_messages();
    parts_.reset();
    periodic_.reset();
    part_ = {};
    job_ = {};
}

}  // namespace votess::gpu
