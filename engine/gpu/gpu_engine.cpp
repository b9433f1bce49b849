#include "gpu/gpu_engine.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>
#include <string>

#include "core/ceil.hpp"
#include "core/power_of_two.hpp"
#include "gpu/passes/kernel_choice.hpp"
#include "gpu/seeds/walls.hpp"
#include "input/implied_wants.hpp"

namespace votess::gpu {
namespace {

constexpr std::size_t block_cells = 4096;  // per task of the host

std::uint64_t& reason_of(FallbackReasons& reasons, std::uint32_t status) {
    switch (status) {
        case STATUS_NEEDS_EXACT:
            return reasons.uncertain;
        case STATUS_PLANE_OVERFLOW:
        case STATUS_VERTEX_OVERFLOW:
            return reasons.overflow;
        default:
            return reasons.exhausted;
    }
}

void add(FallbackReasons& sum, const FallbackReasons& some) {
    sum.uncertain += some.uncertain;
    sum.overflow += some.overflow;
    sum.exhausted += some.exhausted;
}

}  // namespace

GpuEngine::GpuEngine(std::shared_ptr<vulkan::Device> device, ExactClipper& clipper, const EngineLimits& limits)
    : device_(std::move(device)), memory_(*device_), clipper_(clipper), limits_(limits), seeds_(*device_, memory_) {}

PassSettings GpuEngine::pass_settings(const Options& options) const {
    const bool float64 = device_->has_float64();
    const bool measured_double = options.precision == Precision::double_ && !lists_only_;
    if (measured_double && !float64)
        throw Error(ErrorCode::unsupported, "device '" + device_->adapter().name +
                                                "' has no float64 arithmetic: use precision single, or the CPU");
    PassSettings s = usual_settings(*device_, options.k_init);
    if (limits_.most_walk_visits != 0) s.most_walk_visits = limits_.most_walk_visits;
    s.tiers[0].float64 = measured_double;
    s.measure = !lists_only_ && (options.want.volumes || options.want.centroids || options.want.areas);
    s.walls = has_device_walls(*job_.domain);
    s.areas = !lists_only_ && options.want.areas;
    if (const std::uint32_t size = limits_.local_size != 0 ? limits_.local_size : local_size_from_environment();
        size != 0) {
        s.local_size = size;
        if (s.subgroup_size != 0) s.subgroups = std::max(size / s.subgroup_size, 1u);
    }
    return s;
}

std::uint32_t GpuEngine::chunk_cells(const PassSettings& settings) const {
    const VkDeviceSize usual = usual_chunk(*device_, settings, job_.options.chunk_size, seeds_.count());
    const auto cells = static_cast<std::uint32_t>(
        std::clamp<VkDeviceSize>(memory_.max_buffer_bytes() / DeviceCells::largest_bytes_per_cell(settings), 1, usual));
    // Pieces of it begin with a tile of the second tier's list.
    return cells > TILE_ITEMS ? cells / TILE_ITEMS * TILE_ITEMS : cells;
}

void GpuEngine::run(const Job& job, StageClock& clock, detail::Result& result) {
    clock_ = &clock;
    begin(job);
    device_clips_ = job_.points.count() > 0 && find_domain();
    if (device_clips_) {
        find_parts();
        for (std::size_t index = 0; index < parts_->size(); ++index) {
            clock.enter(&StageSeconds::upload);
            upload_part(index);
            clock.enter(&StageSeconds::sort);
            sort_part();
            clock.enter(&StageSeconds::knn);
            seeds_.build_hierarchy(*passes_);
            device_seconds_.knn += seeds_.seconds().knn;
            clock.enter(&StageSeconds::clip);
            clip_part(index);
        }
        clock.share_clip(device_seconds_.knn, device_seconds_.clip, device_seconds_.download);
    } else {
        pending_.resize(job_.points.count());
        std::iota(pending_.begin(), pending_.end(), 0);
        reasons_.domain = pending_.size();
    }
    clock.enter(&StageSeconds::fallback);
    clip_pending(clipping.end);
    clock.enter(&StageSeconds::download);
    finish(result);
}

void GpuEngine::begin(const Job& job) {
    job_ = job;
    progress_ = Progress(job.options.progress);
    progress_.report(0);
    device_seconds_ = {};
    pending_.clear();
    reasons_ = {};
    duplicates_ = false;
    done_cells_ = 0;
    part_ = {};
    parts_.reset();
    // A run that was stopped may have left the device at work.
    for (auto& chunk : chunks_)
        if (chunk) chunk->wait();
    lists_only_ = needs_polytopes(job_.options.want);
    clipper_.begin(job_);
    result_.begin(job_, clipper_.pool());
}

void GpuEngine::find_parts() {
    const PassSettings settings = pass_settings(job_.options);
    if (!passes_ || passes_->settings != settings) {
        passes_.reset();
        for (auto& chunk : chunks_) chunk.reset();
        passes_.emplace(*device_, settings);
    }
    const std::uint32_t most = most_seeds();
    std::span<const std::int32_t> duplicate_of;
    if (job_.points.count() > most) {
        // Copies of a seed would otherwise lie in several parts.
        duplicate_of = clipper_.duplicate_of();
        duplicates_ = !duplicate_of.empty();
    }
    parts_.emplace(job_, duplicate_of, box_, periodic_ ? INDEX_MASK : most);
}

bool GpuEngine::find_domain() {
    periodic_.reset();
    if (!device_clips(job_)) return false;
    if (job_.domain->is_periodic()) {
        periodic_ = periodic_part(job_, most_seeds());
        if (!periodic_) return false;
    }
    box_ = periodic_ ? periodic_->box : device_box(job_);
    seeds_.set_walls(device_walls(job_, box_));
    return true;
}

std::uint32_t GpuEngine::most_seeds() const {
    return limits_.most_seeds != 0 ? limits_.most_seeds : SeedStore::most_seeds(*device_, memory_);
}

void GpuEngine::upload_part(std::size_t index) {
    if (periodic_) {
        part_ = periodic_->part;
        seeds_.upload(*periodic_, *passes_);
        return;
    }
    part_ = parts_->get(index);
    seeds_.upload(job_, part_.members, box_, *passes_);
}

void GpuEngine::sort_part() {
    const unsigned resolution = job_.options.grid_resolution;
    const auto bits = resolution == 0 ? KEY_BITS_PER_AXIS
                                      : std::clamp<std::uint32_t>(std::bit_width(resolution - 1), 1, KEY_BITS_PER_AXIS);
    seeds_.sort(*passes_, bits);
    if (seeds_.state().duplicates == 0 && seeds_.state().suspects == 0) return;
    duplicates_ = true;
    if (job_.options.duplicates == Duplicates::error) clipper_.prepare();  // throws, with the name of the first
}

void GpuEngine::clip_part(std::size_t index) {
    const std::uint32_t cells = chunk_cells(passes_->settings);
    for (auto& chunk : chunks_)
        if (!chunk || chunk->capacity() != cells) {
            chunk.reset();
            chunk.emplace(*device_, memory_, cells, passes_->settings);
        }
    ChunkJob job;
    const Options& options = job_.options;
    job.neighbors = options.want.neighbors || lists_only_;
    job.walls = options.list_walls;
    job.volume_tolerance = options.precision == Precision::double_ ? 0.5e-10 : 0.5e-5;
    job.own_count = part_.own_count;
    std::copy_n(part_.lower, 3, job.lower);
    std::copy_n(part_.upper, 3, job.upper);
    job.bounded = part_.bounded;

    Schedule schedule(seeds_.count(), cells);
    Chunk* running = nullptr;
    const bool last_part = index + 1 == parts_->size();
    std::size_t slot = 0;
    std::uint32_t most = cells;
    std::size_t done = 0;                           // seeds given to the device or left to the CPU
    auto begun = std::chrono::steady_clock::now();  // when the device began with the running chunk
    const auto take = [&](const Chunk& chunk, double progress) {
        const auto now = std::chrono::steady_clock::now();
        most = paced_cells(chunk, std::chrono::duration<double>(now - begun).count(), cells);
        begun = now;
        collect(chunk, schedule, progress);
    };
    for (;;) {
        const std::optional<Piece> piece = schedule.next(most);
        if (!piece && running == nullptr) break;
        Chunk* started = nullptr;
        if (piece) {
            done += piece->count;
            if (piece->on_device) {
                started = &*chunks_[slot];
                slot ^= 1;
                if (running == nullptr) begun = std::chrono::steady_clock::now();
                if (piece->ties) passes_->make_with_ties(*device_);
                started->start(seeds_, *passes_, job, *piece);
            } else {
                leave_to_cpu(piece->first, piece->count);
            }
        }
        // The CPU's share of the chunks before, beside the device's work on this one; the last share comes at the end.
        const double progress = clipping.at(done_cells_, job_.points.count());
        if (started != nullptr || done < seeds_.count() || !last_part) clip_pending(progress);
        Progress::require(progress_.going_on(progress));
        if (running != nullptr) {
            running->wait();
            take(*running, progress);
        }
        running = started;
        if (running != nullptr && piece->trial) {  // what it tells is worth the wait
            running->wait();
            if (schedule.repeat_with_ties(*piece, uncertain_cells(*running)))
                done -= piece->count;
            else
                take(*running, progress);
            running = nullptr;
        }
    }
}

std::size_t GpuEngine::uncertain_cells(const Chunk& chunk) const {
    if (chunk.piece().ties || seeds_.state().lossy != 0) return 0;
    return static_cast<std::size_t>(
        std::ranges::count(chunk.info(), STATUS_NEEDS_EXACT, [](std::uint32_t info) { return info & 0xff; }));
}

std::uint32_t GpuEngine::paced_cells(const Chunk& chunk, double host_seconds, std::uint32_t most) const {
    constexpr double usual_seconds = 0.25;  // drivers of displays stop work that takes some seconds
    constexpr double most_growth = 32;      // the next cells may be slower ones
    if (limits_.chunk_seconds == 0 && device_->adapter().software()) return most;
    const double allowed = limits_.chunk_seconds != 0 ? limits_.chunk_seconds : usual_seconds;
    const auto on_device = chunk.seconds();
    double spent = on_device.knn + on_device.clip + on_device.download;
    if (spent == 0) spent = host_seconds;  // a device without timestamps
    const double growth = std::min(allowed / std::max(spent, 1e-9), most_growth);
    return static_cast<std::uint32_t>(
        std::clamp<double>(chunk.count() * growth, std::min(most, Schedule::trial_cells), most));
}

void GpuEngine::collect(const Chunk& chunk, Schedule& schedule, double progress) {
    const auto order = seeds_.order().subspan(chunk.first(), chunk.count());
    const auto infos = chunk.info();
    const auto lengths = chunk.row_lengths();
    const std::size_t blocks = ceil_div(chunk.count(), block_cells);
    auto& cells = chunk_inputs_;
    auto& row_begin = row_begin_;
    cells.resize(chunk.count());
    row_begin.assign(blocks + 1, 0);
    for (std::uint32_t i = 0; i < chunk.count(); ++i) {
        cells[i] = input_of(order[i] & INDEX_MASK);
        row_begin[i / block_cells + 1] += lengths[i];
    }
    for (std::size_t b = 0; b < blocks; ++b) row_begin[b + 1] += row_begin[b];

    std::mutex mutex;
    std::size_t left = 0, beside = 0;
    clipper_.pool().run(blocks, [&](std::size_t block, unsigned) {
        const std::size_t begin = block * block_cells, end = std::min<std::size_t>(chunk.count(), begin + block_cells);
        CellCounters counters;
        std::vector<std::int32_t> pending;
        FallbackReasons reasons;
        std::size_t outside = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t info = infos[i], status = info & 0xff;
            if (status == STATUS_CERTIFIED) {
                if (lists_only_) continue;
                counters.faces += (info >> INFO_FACES_SHIFT) & 0xff;
                collect_cell(chunk, static_cast<std::uint32_t>(i), cells[i]);
            } else if (status == STATUS_OUTSIDE) {
                ++outside;
            } else if (status != STATUS_DUPLICATE) {
                pending.push_back(cells[i]);
                ++reason_of(reasons, status);
            }
        }
        result_.count(counters);
        if (job_.options.want.neighbors && !lists_only_) collect_rows(chunk, cells, begin, end, row_begin[block]);
        const std::lock_guard lock(mutex);
        left += pending.size();
        beside += outside;
        pending_.insert(pending_.end(), pending.begin(), pending.end());
        add(reasons_, reasons);
    });
    if (lists_only_) collect_lists(chunk, progress);
    done_cells_ += chunk.count() - beside;

    const auto seconds = chunk.seconds();
    device_seconds_.knn += seconds.knn;
    device_seconds_.clip += seconds.clip;
    device_seconds_.download += seconds.download;
    schedule.note(chunk.piece(), chunk.count() - beside, chunk.left_count(), left, uncertain_cells(chunk));
}

void GpuEngine::collect_lists(const Chunk& chunk, double progress) {
    const auto infos = chunk.info();
    const auto lengths = chunk.row_lengths();
    const std::size_t size = std::accumulate(lengths.begin(), lengths.end(), std::size_t{0});
    const std::span<const std::int32_t> rows = chunk.rows(size);
    listed_cells_.clear();
    listed_lengths_.clear();
    listed_ids_.clear();
    listed_shifts_.clear();
    for (std::size_t i = 0, entry = 0; i < chunk.count(); entry += lengths[i++]) {
        if ((infos[i] & 0xff) != STATUS_CERTIFIED) continue;
        listed_cells_.push_back(chunk_inputs_[i]);
        listed_lengths_.push_back(lengths[i]);
        for (const std::int32_t id : rows.subspan(entry, lengths[i])) {
            listed_ids_.push_back(id < 0 || part_.members.empty() ? id : input_of(static_cast<std::uint32_t>(id)));
            if (!periodic_) continue;
            listed_shifts_.push_back({});
            if (id >= 0)
                listed_shifts_.back() = periodic_->shift_in_row(static_cast<std::uint32_t>(id), chunk_inputs_[i]);
        }
    }
    const StageClock::Within fallback(*clock_, &StageSeconds::fallback);
    clipper_.clip_listed({listed_cells_, listed_lengths_, listed_ids_, listed_shifts_}, result_, {progress, progress});
}

// Takes the rows of the chunk's cells begin .. end - 1, which begin at entry `first_entry`.
void GpuEngine::collect_rows(const Chunk& chunk, std::span<const std::int32_t> cells, std::size_t begin,
                             std::size_t end, std::size_t first_entry) {
    const auto lengths = chunk.row_lengths().subspan(begin, end - begin);
    const std::size_t size = std::accumulate(lengths.begin(), lengths.end(), std::size_t{0});
    std::vector<std::int32_t> named;
    std::vector<double> areas;
    std::span<const std::int32_t> rows = chunk.rows(first_entry + size).subspan(first_entry);
    if (job_.options.want.areas) {
        areas.reserve(size);
        for (std::size_t i = begin; i < end; ++i) {
            const int exponent =
                static_cast<int>(chunk.info()[i] >> INFO_EXPONENT_SHIFT) - seeds_.on_device().units().shift;
            for (std::uint32_t k = 0; k < lengths[i - begin]; ++k)
                areas.push_back(times_power_of_two(chunk.area(first_entry + areas.size()), 2 * exponent));
        }
    }
    std::vector<std::int8_t> shifts;
    if (!part_.members.empty()) {  // the device knows them by other names, and another order
        struct Entry {
            std::int32_t id;
            std::array<std::int8_t, 3> shift;
            double area;
        };
        std::vector<Entry> row;
        named.assign(rows.begin(), rows.end());
        if (periodic_) shifts.resize(3 * size);
        for (std::size_t at = 0, i = 0; i < lengths.size(); at += lengths[i++]) {
            row.clear();
            for (std::size_t e = at; e < at + lengths[i]; ++e) {
                Entry entry{named[e], {}, areas.empty() ? 0 : areas[e]};
                if (named[e] >= 0) entry.id = input_of(static_cast<std::uint32_t>(named[e]));
                if (named[e] >= 0 && periodic_)
                    entry.shift = periodic_->shift_in_row(static_cast<std::uint32_t>(named[e]), cells[begin + i]);
                row.push_back(entry);
            }
            std::ranges::sort(row, {}, [](const Entry& entry) { return std::pair(entry.id, entry.shift); });
            for (std::size_t k = 0; k < row.size(); ++k) {
                named[at + k] = row[k].id;
                if (!areas.empty()) areas[at + k] = row[k].area;
                if (periodic_)
                    std::ranges::copy(row[k].shift, shifts.begin() + static_cast<std::ptrdiff_t>(3 * (at + k)));
            }
        }
        rows = named;
    }
    result_.copy_rows(cells.subspan(begin, end - begin), lengths, rows, {areas, {}, shifts});
}

void GpuEngine::collect_cell(const Chunk& chunk, std::uint32_t cell, std::int32_t input) {
    const std::uint32_t info = chunk.info()[cell];
    const auto i = static_cast<std::size_t>(input);
    const Want& want = job_.options.want;
    const int exponent = static_cast<int>(info >> INFO_EXPONENT_SHIFT) - seeds_.on_device().units().shift;
    if (want.volumes) result_.volumes()[i] = times_power_of_two(chunk.geometry(cell, 0), 3 * exponent);
    if (want.centroids)
        for (std::uint32_t k = 0; k < 3; ++k)
            result_.centroids()[3 * i + k] = job_.points[3 * i + k] +
                                             (periodic_ && !periodic_->wraps.empty() ? periodic_->wraps[i][k] : 0) +
                                             times_power_of_two(chunk.geometry(cell, 1 + k), exponent);
    if (want.counts) {
        const std::uint32_t vertices = (info >> INFO_VERTICES_SHIFT) & 0xff, faces = (info >> INFO_FACES_SHIFT) & 0xff;
        result_.face_counts()[i] = faces;
        result_.edge_counts()[i] = vertices + faces - 2;  // Euler
        result_.vertex_counts()[i] = vertices;
    }
}

void GpuEngine::leave_to_cpu(std::uint32_t first, std::uint32_t count) {
    for (const std::uint32_t member : seeds_.order().subspan(first, count)) {
        if ((member & INDEX_MASK) >= part_.own_count) continue;
        ++done_cells_;
        if ((member & DUPLICATE_BIT) != 0) continue;
        pending_.push_back(input_of(member));
        ++reasons_.skipped;
    }
}

void GpuEngine::clip_pending(double progress) {
    if (pending_.empty()) return;
    const StageClock::Within fallback(*clock_, &StageSeconds::fallback);
    clipper_.clip(pending_, result_, {progress, progress});
    pending_.clear();
}

void GpuEngine::finish(detail::Result& result) {
    clipper_.set_empty(result_);
    if (duplicates_ || !device_clips_) result_.set_duplicates(clipper_.duplicate_of(), clipper_.pool());
    result_.finish(result, clipper_.pool());
    result.stats.device = device_->adapter().name;
    result.stats.fallback_reasons = reasons_;
    result.stats.precision = device_clips_ && !lists_only_ ? job_.options.precision : Precision::double_;
    clipper_.end();
    check_messages();
    progress_.report(1);
    parts_.reset();
    periodic_.reset();
    part_ = {};
    job_ = {};
}

// The validation layer's findings are bugs, whatever the result.
void GpuEngine::check_messages() {
    const auto messages = device_->instance().take_messages();
    if (!messages.empty())
        throw Error(ErrorCode::internal, "Vulkan validation found " + std::to_string(messages.size()) +
                                             " problems, the first: " + messages.front());
}

}  // namespace votess::gpu
