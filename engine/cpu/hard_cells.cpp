#include "cpu/hard_cells.hpp"

#include <algorithm>
#include <atomic>
#include <limits>

#include "core/arithmetic.hpp"
#include "cpu/cpu_clipper.hpp"
#include "index/seed_images.hpp"
#include "triangulate/power_sites.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t block_cells = 64;
constexpr std::size_t budget_growth = 8;  // from round to round of searches
constexpr std::size_t sampled_cells = 16;
constexpr std::size_t exact_tests = 4;  // so many tests take as long as one that may be exact
// Cost of a triangulation, in tests per seed: about 15 tests decided by exact arithmetic, 200 others.
constexpr std::size_t triangulation_tests = 60;
constexpr std::size_t max_triangulated = 20'000'000;  // seeds; 300 bytes each
constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

// Returns whether the coordinates alone make up the diagram: no weights, and no place that is rounded.
bool are_plain_points(const SortedSeeds& seeds) {
    if (!seeds.weights.empty()) return false;
    if (seeds.images == nullptr || !seeds.images->any_wrapped()) return true;
    for (std::size_t s = 0; s < seeds.size(); ++s)
        if (!seeds.images->is_exact(s)) return false;
    return true;
}

}  // namespace

std::vector<std::int32_t> CpuClipper::collect_hard() {
    std::vector<std::int32_t> hard;
    for (const auto& worker : workers_) {
        hard.insert(hard.end(), worker->hard.begin(), worker->hard.end());
        worker->hard.clear();
    }
    std::sort(hard.begin(), hard.end());
    return hard;
}

void CpuClipper::clip_hard(ResultBuilder& out) {
    const std::size_t count = seeds_.size();
    const Domain& domain = *job_.domain;
    const bool periodic = domain.is_periodic();
    // Walls only cut the cells, and so do images of seeds.
    const bool has_delaunay = count > 1 && count <= max_triangulated;
    std::vector<std::int32_t> hard = collect_hard();
    if (hard.empty()) return;
    const std::size_t cost = triangulation_tests * count;
    // Most of these cells have not been tried at all, so the first round allows as many tests as a block.
    std::size_t tests = SearchBudget::max_tests;
    for (; !hard.empty(); hard = collect_hard(), tests *= budget_growth) {
        if (tests >= 2 * count) tests = unlimited;
        const auto search = [tests](std::size_t seed, Worker& worker) { return worker.builder.build(seed, tests); };
        // One of the two is always completed. Together they cost a few times as much as the cheaper one.
        bool many = hard.size() > cost / std::min(tests, count);
        if (many && has_delaunay && domain.has_weights() && !delaunay_) {
            // Most searches may take far fewer tests, or exact ones.
            std::atomic<std::size_t> used = 0;
            std::vector<std::int32_t> sample, rest;
            const std::size_t step = ceil_div(hard.size(), sampled_cells);
            for (std::size_t k = 0; k < hard.size(); ++k) (k % step == 0 ? sample : rest).push_back(hard[k]);
            clip_each(sample, out, [&](std::size_t seed, Worker& worker) {
                Cell* const cell = search(seed, worker);
                used += worker.builder.tests() * (cell == nullptr || cell->used_exact() ? exact_tests : 1);
                return cell;
            });
            many = used / sample.size() > cost / hard.size();
            hard = collect_hard();
            hard.insert(hard.end(), rest.begin(), rest.end());
            std::sort(hard.begin(), hard.end());
        }
        if (has_delaunay && (delaunay_ || many) && triangulate()) {
            clip_each(hard, out, [this, periodic](std::size_t seed, Worker& worker) {
                if (!seeds_.weights.empty() && delaunay_->is_hidden(seed)) return &worker.builder.build_hidden(seed);
                delaunay_->neighbors(seed, worker.candidates, worker.marks);
                Cell& cell = !periodic    ? worker.builder.build_from(seed, worker.candidates)
                             : unwrapped_ ? worker.builder.build_among_images(seed, worker.candidates, *unwrapped_)
                                          : worker.builder.build_among_images(seed, worker.candidates);
                if (seeds_.is_beyond(seed) && !cell.empty()) cell.drop_if_flat();  // as a search does
                return &cell;
            });
        } else {
            clip_each(hard, out, search);
        }
    }
}

bool CpuClipper::widen_images() {
    std::size_t hard = 0;
    for (const auto& worker : workers_) hard += worker->hard.size();
    if (seeds_.images == nullptr || hard == 0) return false;
    const double tests = static_cast<double>(hard) * static_cast<double>(SearchBudget::max_tests);
    if (!images_.widen(tests, *pool_, seeds_)) return false;
    weigh_places();
    hierarchy_.build(seeds_, *pool_);
    return true;
}

void CpuClipper::clip_hard_again(ResultBuilder& out, const Share& share) {
    order_ = collect_hard();
    const std::span<std::int32_t> cells = out.allocate_cells(order_.size());
    std::ranges::transform(order_, cells.begin(), [&](std::int32_t s) { return row_of(static_cast<std::size_t>(s)); });
    cut_into_blocks(cells.size());
    clip_order(cells, false, out, share);
}

bool CpuClipper::triangulate() {
    if (!delaunay_ && seeds_.images != nullptr && seeds_.weights.empty()) unwrapped_ = unwrap(seeds_, *pool_);
    if (!delaunay_ && !unwrapped_ && are_plain_points(seeds_)) delaunay_.emplace(seeds_);
    if (!delaunay_) {
        std::vector<PowerSites::Site> sites;
        for (std::size_t s = 0; s < seeds_.size(); ++s) {
            auto at = seeds_.images == nullptr ? SeedImages::Base{{seeds_.x[s], seeds_.y[s], seeds_.z[s]}, {}}
                                               : images_.base(s);
            for (std::size_t j = 0; j < 3 && unwrapped_; ++j) at.shift[j] += unwrapped_->shifts[s][j];
            sites.push_back({at.point, at.shift, seeds_.weights.empty() ? 0 : seeds_.weights[s]});
        }
        delaunay_.emplace(seeds_.size(), PowerSites(std::move(sites), &job_.domain->lattice));
    }
    return delaunay_->valid();
}

template <class Build>
void CpuClipper::clip_each(const std::vector<std::int32_t>& seeds, ResultBuilder& out, const Build& build) {
    const std::span<std::int32_t> cells = out.allocate_cells(seeds.size());
    std::ranges::transform(seeds, cells.begin(), [&](std::int32_t s) { return row_of(static_cast<std::size_t>(s)); });
    pool_->run(ceil_div(cells.size(), block_cells), [&](std::size_t block, unsigned index) {
        Worker& worker = *workers_[index];
        const std::size_t begin = block * block_cells, end = std::min(cells.size(), begin + block_cells);
        for (std::size_t k = begin; k < end; ++k) {
            check_stop();
            const auto seed = static_cast<std::size_t>(seeds[k]);
            finish(build(seed, worker), seed, worker);
        }
        worker.writer.end_block(cells.subspan(begin, end - begin));
    });
}

}  // namespace votess::cpu
