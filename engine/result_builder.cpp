#include "result_builder.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace votess {
namespace {

constexpr std::size_t copied_block = 4096;  // cells

std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
#if defined(__APPLE__)
    return static_cast<std::uint64_t>(usage.ru_maxrss);
#else
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
#endif
}

double accurate_sum(std::span<const double> values) {
    double sum = 0, lost = 0;  // Kahan: 1e9 volumes sum to the last digits
    for (const double v : values) {
        const double y = v - lost, t = sum + y;
        lost = (t - sum) - y;
        sum = t;
    }
    // Beyond the largest double the corrections are NaN.
    return std::isfinite(sum) ? sum : std::accumulate(values.begin(), values.end(), 0.0);
}

[[noreturn]] void bug(const std::string& what) {
    throw Error(ErrorCode::internal, "a bug in votess: " + what);
}

std::size_t sum_of(std::span<const std::uint32_t> lengths) {
    return std::accumulate(lengths.begin(), lengths.end(), std::size_t{0});
}

}  // namespace

void ResultBuilder::begin(const Job& job) {
    const std::size_t count = job.points.count();
    const Want& want = job.options.want;
    result_ = {};
    blocks_.clear();
    kept_.clear();
    counters_ = {};
    want_neighbors_ = want.neighbors;
    want_areas_ = want.areas;
    result_.box = job.box;
    result_.lists_walls = job.options.walls;
    result_.status.assign(count, CellStatus::certified);
    if (want.neighbors) result_.indptr.assign(count + 1, 0);
    if (want.volumes) result_.volumes.assign(count, 0.0);
    if (want.centroids) result_.centroids.assign(3 * count, std::numeric_limits<double>::quiet_NaN());
    if (want.counts)
        for (auto* v : {&result_.face_counts, &result_.edge_counts, &result_.vertex_counts}) v->assign(count, 0);
}

void ResultBuilder::add_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                             std::span<const std::int32_t> ids, std::span<const double> areas) {
    if (!want_neighbors_) return;
    Block block{cells, {}, {ids.begin(), ids.end()}, {areas.begin(), areas.end()}};
    set_lengths(cells, lengths, ids.size(), areas.size());
    // A row that comes by another call would be taken for one of this block.
    if (std::ranges::find(lengths, 0u) != lengths.end()) {
        for (std::size_t k = 0; k < cells.size(); ++k)
            if (lengths[k] > 0) block.own_cells.push_back(cells[k]);
        block.cells = block.own_cells;
    }
    push(std::move(block));
}

void ResultBuilder::copy_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                              std::span<const std::int32_t> ids, std::span<const double> areas) {
    if (!want_neighbors_) return;
    if (sum_of(lengths) != ids.size()) bug("rows and their lengths do not fit");
    for (std::size_t begin = 0; begin < cells.size(); begin += copied_block) {
        const auto part = cells.subspan(begin, std::min(copied_block, cells.size() - begin));
        const auto part_lengths = lengths.subspan(begin, part.size());
        Block block;
        const std::size_t size = sum_of(part_lengths);
        block.ids.assign(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(size));
        ids = ids.subspan(size);
        if (want_areas_ && areas.size() >= size) {
            block.areas.assign(areas.begin(), areas.begin() + static_cast<std::ptrdiff_t>(size));
            areas = areas.subspan(size);
        }
        set_lengths(part, part_lengths, size, block.areas.size());
        for (std::size_t k = 0; k < part.size(); ++k)
            if (part_lengths[k] > 0) block.own_cells.push_back(part[k]);
        block.cells = block.own_cells;
        push(std::move(block));
    }
}

std::span<const std::int32_t> ResultBuilder::keep(std::vector<std::int32_t> cells) {
    std::lock_guard lock(mutex_);
    return kept_.emplace_back(std::move(cells));
}

void ResultBuilder::count(const CellCounters& counters) {
    std::lock_guard lock(mutex_);
    counters_.faces += counters.faces;
    counters_.exact_cells += counters.exact_cells;
    counters_.fallback_cells += counters.fallback_cells;
}

// The checks keep an engine's bug from writing beyond the arrays in place_rows().
void ResultBuilder::set_lengths(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                                std::size_t ids, std::size_t areas) {
    if (want_areas_ && areas != ids) bug("rows and their areas do not fit");
    if (cells.size() != lengths.size()) bug("cells and row lengths do not fit");
    auto& indptr = result_.indptr;
    std::size_t sum = 0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
        if (lengths[k] == 0) continue;
        const std::size_t i = static_cast<std::uint32_t>(cells[k]) + std::size_t{1};
        if (i >= indptr.size() || indptr[i] != 0) bug("cell " + std::to_string(cells[k]) + " has no place for its row");
        indptr[i] = lengths[k];
        sum += lengths[k];
    }
    if (sum != ids) bug("rows and their lengths do not fit");
}

void ResultBuilder::push(Block block) {
    std::lock_guard lock(mutex_);
    blocks_.push_back(std::move(block));
}

void ResultBuilder::set_duplicates(std::vector<std::int32_t> duplicate_of) {
    result_.duplicate_of = std::move(duplicate_of);
    for (std::size_t i = 0; i < result_.duplicate_of.size(); ++i)
        if (result_.duplicate_of[i] >= 0) {
            result_.status[i] = CellStatus::duplicate;
            ++result_.stats.duplicates;
        }
}

void ResultBuilder::finish(detail::Result& result, ThreadPool& pool) {
    for (std::size_t i = 0; i < result_.status.size(); ++i)
        if (result_.status[i] != CellStatus::certified && result_.status[i] != CellStatus::duplicate)
            bug("cell " + std::to_string(i) + " was left over");
    if (want_neighbors_) place_rows(pool);
    finish_stats(result_.stats, pool);
    result_.stats.device = std::move(result.stats.device);
    result_.stats.seconds = result.stats.seconds;
    result = std::move(result_);
    result_ = {};
    blocks_ = {};
    kept_ = {};
}

void ResultBuilder::place_rows(ThreadPool& pool) {
    auto& indptr = result_.indptr;
    for (std::size_t i = 1; i < indptr.size(); ++i) indptr[i] += indptr[i - 1];
    result_.indices.resize(static_cast<std::size_t>(indptr.back()));
    if (want_areas_) result_.face_areas.resize(result_.indices.size());
    pool.run(blocks_.size(), [&](std::size_t index, unsigned) {
        Block& block = blocks_[index];
        const std::int32_t* from = block.ids.data();
        const double* areas = block.areas.data();
        for (const std::int32_t cell : block.cells) {
            const auto i = static_cast<std::size_t>(cell);
            const auto length = indptr[i + 1] - indptr[i];
            std::copy_n(from, length, result_.indices.data() + indptr[i]);
            from += length;
            if (!want_areas_) continue;
            std::copy_n(areas, length, result_.face_areas.data() + indptr[i]);
            areas += length;
        }
        block = {};  // the memory serves what comes next
    });
}

void ResultBuilder::finish_stats(Stats& stats, ThreadPool& pool) const {
    stats.points = result_.status.size();
    stats.empty_cells = stats.duplicates;
    stats.faces = counters_.faces;
    stats.exact_cells = counters_.exact_cells;
    stats.fallback_cells = counters_.fallback_cells;
    const auto cells = stats.points - stats.empty_cells;
    stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
    stats.volume_sum = accurate_sum(result_.volumes);
    stats.box_volume = 1;
    for (int k = 0; k < 3; ++k) stats.box_volume *= result_.box.upper[k] - result_.box.lower[k];
    stats.threads = pool.size();
    stats.peak_memory_bytes = peak_memory();
}

}  // namespace votess
