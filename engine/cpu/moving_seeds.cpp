// Calls with moving seeds, see follow/kept_cells.hpp.
#include <algorithm>
#include <numeric>

#include "core/arithmetic.hpp"
#include "cpu/cpu_clipper.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t kept_block = 4096;  // cells in a task
constexpr std::size_t many_cells = 2048;  // for a thread

}  // namespace

bool CpuClipper::clip_kept(ResultBuilder& out, const Share& share, const std::function<void()>& ready) {
    KeptCells& kept = *kept_;
    kept.test(*pool_);
    std::size_t made = 0;
    for (kept.take_pending(order_); !order_.empty(); kept.take_pending(order_)) {
        if (made == 0) {
            if (!kept.pays(order_.size()) || kept.any_equal()) return false;
            build_search();
        }
        made += order_.size();
        const std::span<std::int32_t> cells = out.allocate_cells(order_.size());
        std::ranges::transform(order_, cells.begin(), [&](std::int32_t s) { return seeds_.input[s]; });
        if (cells.size() < many_cells * pool_->size())
            cut_into_small_blocks(cells.size());
        else
            cut_into_blocks(cells.size());
        clip_order(cells, false, out, share);
    }
    if (!kept.covers_once()) return false;
    ready();
    kept_ = nullptr;
    order_.clear();
    for (std::size_t s = 0; s < seeds_.size(); ++s)
        if (kept.is_kept(s)) order_.push_back(static_cast<std::int32_t>(s));
    const std::span<std::int32_t> cells = out.allocate_cells(order_.size());
    std::ranges::transform(order_, cells.begin(), [&](std::int32_t s) { return seeds_.input[s]; });
    begin_workers(out);
    const Stoppable stoppable(progress_, share);
    pool_->run_stage(ceil_div(cells.size(), kept_block), [&](std::size_t task, unsigned index) {
        Worker& worker = *workers_[index];
        const std::size_t begin = task * kept_block, end = std::min(cells.size(), begin + kept_block);
        for (std::size_t k = begin; k < end; ++k) {
            const auto seed = static_cast<std::size_t>(order_[k]);
            worker.writer.prefetch(seed);
            if (k + 8 < end) kept.prefetch(static_cast<std::size_t>(order_[k + 8]));
            if (worker.writer.write(seed, kept.cell(seed))) continue;
            finish(&clip_by_faces(seed, kept.cell(seed), worker), seed, worker);
        }
        worker.writer.end_block(cells.subspan(begin, end - begin));
    });
    end_workers(out);
    out.count({.kept_cells = cells.size()});
    return true;
}

Cell& CpuClipper::clip_by_faces(std::size_t seed, const KeptCell& cell, Worker& worker) const {
    worker.candidates.clear();
    worker.shifts.clear();
    for (std::size_t f = 0; f < cell.faces(); ++f) {
        const std::int32_t id = cell.ids()[f];
        if (id < 0) continue;
        worker.candidates.push_back(id);
        if (seeds_.images == nullptr) continue;
        const exact::Shift from_domain = images_.shift_in_domain(id, seed);
        exact::Shift& shift = worker.shifts.emplace_back(cell.shift(f));
        for (std::size_t j = 0; j < 3; ++j) shift[j] -= from_domain[j];
    }
    return build_from_candidates(seed, worker);
}

// Their rows are not written, so any order of their faces will do.
void CpuClipper::keep_sample(ResultBuilder& out) {
    KeptCells& kept = *kept_;
    begin_workers(out);
    const std::size_t count = seeds_.size();
    constexpr std::size_t block = KeptCells::sample_block;
    static_assert(block % Star::alignment == 0);
    std::vector<std::size_t> begins;
    for (std::size_t s = 0; s < count; s += block)
        if (kept.in_sample(s)) begins.push_back(s);
    pool_->run(begins.size(), [&](std::size_t task, unsigned index) {
        Worker& worker = *workers_[index];
        const std::size_t begin = begins[task], end = std::min(count, begin + block);
        worker.star->begin(begin, end, Star::Keep::corners);
        for (std::size_t s = begin; s < end; ++s)
            if (worker.star->build(s)) worker.writer.store(s, *worker.star);
    });
}

}  // namespace votess::cpu
