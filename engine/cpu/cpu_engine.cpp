#include "cpu/cpu_engine.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "options.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t block_seeds = 512;  // per task: neighbors in space, so the caches serve them
constexpr double progress_interval = 0.1;

std::size_t blocks_for(std::size_t count) {
    return (count + block_seeds - 1) / block_seeds;
}

// Calls the user's progress callback at most every progress_interval seconds.
ThreadPool::Watch watch(const ProgressCallback& progress, std::size_t total, double begin, double end) {
    if (!progress) return {};
    auto last = std::chrono::steady_clock::now();
    return [=, &progress](std::size_t done) mutable {
        const auto now = std::chrono::steady_clock::now();
        if (std::chrono::duration<double>(now - last).count() < progress_interval) return true;
        last = now;
        return progress(begin + (end - begin) * static_cast<double>(done) /
                                    static_cast<double>(std::max<std::size_t>(total, 1)));
    };
}

std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
#if defined(__APPLE__)
    return static_cast<std::uint64_t>(usage.ru_maxrss);
#else
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
#endif
}

void require(bool going_on) {
    if (!going_on) throw Error(ErrorCode::cancelled, "cancelled by the progress callback");
}

}  // namespace

void CpuEngine::upload(const Job& job) {
    job_ = job;
    result_ = {};
    rows_.clear();
    counters_.clear();
    const unsigned hardware = std::max(1u, std::thread::hardware_concurrency());
    const unsigned threads = job.options.threads == 0 ? hardware : job.options.threads;
    if (!pool_ || pool_->size() != threads) pool_.emplace(threads);
}

void CpuEngine::sort() {
    if (job_.options.progress) require(job_.options.progress(0.0));
    seeds_ = job_.points.f32.empty() ? sort_seeds(job_.points.f64, job_.scale, job_.options.grid_resolution, *pool_)
                                     : sort_seeds(job_.points.f32, job_.scale, job_.options.grid_resolution, *pool_);
    if (seeds_.duplicates > 0 && job_.options.duplicates == Duplicates::error) {
        const auto first = std::ranges::find_if(seeds_.duplicate_of, [](auto d) { return d >= 0; });
        const auto index = static_cast<std::size_t>(first - seeds_.duplicate_of.begin());
        throw Error(ErrorCode::invalid_argument,
                    "point " + std::to_string(index) + ": (" + number(job_.points[3 * index]) + ", " +
                        number(job_.points[3 * index + 1]) + ", " + number(job_.points[3 * index + 2]) +
                        ") is a duplicate of point " + std::to_string(*first));
    }
}

void CpuEngine::knn() {
    hierarchy_.build(seeds_, *pool_);
}

void CpuEngine::clip() {
    const std::size_t count = job_.points.count();
    const Want& want = job_.options.want;
    result_.status.assign(count, CellStatus::certified);
    if (want.neighbors) result_.indptr.assign(count + 1, 0);
    if (want.volumes) result_.volumes.assign(count, 0.0);
    if (want.centroids) result_.centroids.assign(3 * count, std::numeric_limits<double>::quiet_NaN());
    if (want.counts)
        for (auto* v : {&result_.face_counts, &result_.edge_counts, &result_.vertex_counts}) v->assign(count, 0);

    const std::size_t blocks = blocks_for(seeds_.size());
    rows_.resize(blocks);
    counters_.resize(blocks);
    std::vector<std::optional<CellBuilder>> builders(pool_->size());
    std::vector<Scratch> scratch(pool_->size());
    const bool finished = pool_->run(
        blocks,
        [&](std::size_t block, unsigned worker) {
            auto& builder = builders[worker];
            if (!builder) builder.emplace(seeds_, hierarchy_, job_.scaled_box);
            std::vector<std::int32_t> rows;
            rows.reserve(want.neighbors ? block_seeds * 17 : 0);
            Counters counters;
            const std::size_t end = std::min(seeds_.size(), (block + 1) * block_seeds);
            for (std::size_t seed = block * block_seeds; seed < end; ++seed)
                clip_seed(seed, *builder, scratch[worker], rows, counters);
            rows.shrink_to_fit();
            rows_[block] = std::move(rows);
            counters_[block] = counters;
        },
        watch(job_.options.progress, blocks, 0.05, 0.95));
    require(finished);
}

void CpuEngine::clip_seed(std::size_t seed, CellBuilder& builder, Scratch& scratch, std::vector<std::int32_t>& rows,
                          Counters& counters) {
    const Want& want = job_.options.want;
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    Cell& cell = builder.build(seed);
    const bool need_polygons = want.volumes || want.centroids || want.counts || cell.met_tie();
    std::span<const std::int32_t> planes;
    if (need_polygons) {
        cell.canonical_faces(scratch.faces);
        planes = scratch.faces.planes;
    } else {
        cell.face_planes(scratch.planes);
        planes = scratch.planes;
    }
    counters.faces += planes.size();
    counters.exact_cells += cell.used_exact() ? 1 : 0;
    if (want.neighbors) {
        auto& row = scratch.row;
        row.clear();
        for (const std::int32_t p : planes) {
            const std::int32_t id = cell.planes()[p].id;
            if (id >= 0)
                row.push_back(seeds_.input[id]);
            else if (job_.options.walls)
                row.push_back(id);
        }
        std::sort(row.begin(), row.end());
        rows.insert(rows.end(), row.begin(), row.end());
        result_.indptr[input + 1] = static_cast<std::int64_t>(row.size());
    }
    if (want.volumes || want.centroids) {
        const CellGeometry geometry = cell.measure(scratch.faces);
        const double unscale = 1 / job_.scale;
        if (want.volumes) result_.volumes[input] = geometry.volume * unscale * unscale * unscale;
        if (want.centroids)
            for (int k = 0; k < 3; ++k)
                result_.centroids[3 * input + k] = (geometry.centroid[k] + cell.seed()[k]) * unscale;
    }
    if (want.counts) {
        result_.face_counts[input] = static_cast<std::uint32_t>(planes.size());
        result_.edge_counts[input] = scratch.faces.edge_count;
        result_.vertex_counts[input] = scratch.faces.vertex_count;
    }
}

// Exact arithmetic has decided every sign and every search has run to its proof: no cell is left over.
void CpuEngine::fallback() {}

void CpuEngine::download(detail::Result& result) {
    result_.box = job_.box;
    result_.lists_walls = job_.options.walls;
    result_.duplicate_of = std::move(seeds_.duplicate_of);
    for (std::size_t i = 0; i < result_.duplicate_of.size(); ++i)
        if (result_.duplicate_of[i] >= 0) result_.status[i] = CellStatus::duplicate;

    if (job_.options.want.neighbors) {
        auto& indptr = result_.indptr;
        for (std::size_t i = 1; i < indptr.size(); ++i) indptr[i] += indptr[i - 1];
        result_.indices.resize(static_cast<std::size_t>(indptr.back()));
        pool_->run(rows_.size(), [&](std::size_t block, unsigned) {
            const std::int32_t* from = rows_[block].data();
            const std::size_t end = std::min(seeds_.size(), (block + 1) * block_seeds);
            for (std::size_t seed = block * block_seeds; seed < end; ++seed) {
                const auto input = static_cast<std::size_t>(seeds_.input[seed]);
                const auto length = indptr[input + 1] - indptr[input];
                std::copy_n(from, length, result_.indices.data() + indptr[input]);
                from += length;
            }
            rows_[block] = {};
        });
    }
    finish_stats(result_);
    result_.stats.seconds = result.stats.seconds;
    result = std::move(result_);
    result_ = {};
    seeds_ = {};
    hierarchy_ = {};
    rows_ = {};
    if (job_.options.progress) require(job_.options.progress(1.0));
    job_ = {};
}

void CpuEngine::finish_stats(detail::Result& result) const {
    Stats& stats = result.stats;
    stats.device = "cpu";
    stats.points = job_.points.count();
    stats.duplicates = seeds_.duplicates;
    stats.empty_cells = seeds_.duplicates;
    for (const Counters& c : counters_) {
        stats.faces += c.faces;
        stats.exact_cells += c.exact_cells;
    }
    const auto cells = stats.points - stats.empty_cells;
    stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
    double sum = 0, lost = 0;  // Kahan: 1e9 volumes sum to the last digits
    for (const double v : result.volumes) {
        const double y = v - lost, t = sum + y;
        lost = (t - sum) - y;
        sum = t;
    }
    stats.volume_sum = sum;
    stats.box_volume = 1;
    for (int k = 0; k < 3; ++k) stats.box_volume *= job_.box.upper[k] - job_.box.lower[k];
    stats.threads = pool_->size();
    stats.peak_memory_bytes = peak_memory();
}

}  // namespace votess::cpu
