// Calls with moving seeds, see follow/kept_cells.hpp.
#include <algorithm>
#include <atomic>
#include <numeric>

#include "core/arithmetic.hpp"
#include "cpu/cpu_clipper.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t kept_block = 4096, placed_block = 512;  // cells in a task
constexpr std::size_t many_cells = 2048;                      // for a thread

}  // namespace

bool CpuClipper::clip_kept(ResultBuilder& out, const Share& share, const std::function<void()>& ready) {
    KeptCells& kept = *kept_;
    kept.test(*pool_);
    std::size_t made = 0;
    for (kept.take_pending(order_); !order_.empty(); kept.take_pending(order_)) {
        if (made == 0) {
            if (!kept.pays(order_.size()) || kept.any_equal(KeptCells::Among::all_seeds)) return false;
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
    if (made == 0 && kept.any_equal(KeptCells::Among::hidden_seeds)) return false;
    if (!kept.covers_once()) return false;
    ready();
    kept_ = nullptr;
    write_kept(kept, out, share);
    return true;
}

// Rows of cells with the faces of the last call are copied, but not values of their faces.
void CpuClipper::write_kept(KeptCells& kept, ResultBuilder& out, const Share& share) {
    const std::size_t count = seeds_.size(), tasks = ceil_div(count, kept_block);
    const std::size_t points = job_.points.count(), row_tasks = ceil_div(points, kept_block);
    const Want& want = job_.want;
    const bool copies = want.neighbors && kept.rows().are_of(points, job_.list_walls);
    std::vector<std::uint32_t> lengths(want.neighbors ? points : 0);  // of kept rows, in input order
    std::vector<std::uint8_t> copied(copies ? points : 0);            // so, too
    const bool by_cell = needs_geometry(want) || want.counts || want.normals;
    const auto needs_row = [&](std::size_t s) { return want.neighbors && !(copies && kept.has_same_faces(s)); };
    std::atomic<std::size_t> all_faces = 0, all_kept = 0, all_hidden = 0, new_rows = 0;
    begin_workers(out);
    const Stoppable stoppable(progress_, share);
    pool_->run(copies ? row_tasks : 0, [&](std::size_t task, unsigned) {
        for (std::size_t i = task * kept_block; i < std::min(points, (task + 1) * kept_block); ++i) {
            lengths[i] = kept.rows().length(i);
            copied[i] = 1;
        }
    });
    pool_->run(tasks, [&](std::size_t task, unsigned) {
        std::size_t faces = 0, cells = 0, empty = 0, rows = 0;
        for (std::size_t s = task * kept_block; s < std::min(count, (task + 1) * kept_block); ++s) {
            if (kept.is_hidden(s)) {
                out.set_empty(static_cast<std::size_t>(seeds_.input[s]), CellStatus::empty);
                ++empty;
                continue;
            }
            const bool is_kept = kept.is_kept(s), has_row = is_kept && needs_row(s);
            cells += is_kept ? 1 : 0;
            if (is_kept && !by_cell && !has_row) faces += kept.faces(s);  // others are counted where they are written
            if (!want.neighbors || (is_kept && !has_row)) continue;
            const auto i = static_cast<std::size_t>(seeds_.input[s]);
            if (copies) copied[i] = 0;
            lengths[i] = 0;
            if (!has_row) continue;
            const auto ids = kept.cell(s).ids();
            std::size_t hidden = 0;  // walls come first
            while (!job_.list_walls && hidden < ids.size() && ids[hidden] < 0) ++hidden;
            lengths[i] = static_cast<std::uint32_t>(ids.size() - hidden);
            ++rows;
        }
        all_faces += faces;
        all_kept += cells;
        all_hidden += empty;
        new_rows += rows;
    });
    out.settle(lengths, *pool_);
    pool_->run(copies ? row_tasks : 0, [&](std::size_t task, unsigned) {
        const std::size_t last = std::min(points, (task + 1) * kept_block);
        for (std::size_t begin = task * kept_block, end = begin; begin < last; begin = end) {
            while (end < last && copied[end] == copied[begin]) ++end;
            if (copied[begin] == 0) continue;
            const auto [ids, shifts] = kept.rows().rows(begin, end);
            out.place_run(begin, end, ids, shifts);
        }
    });
    const std::size_t writes = by_cell || new_rows > 0 ? ceil_div(count, placed_block) : 0;
    pool_->run_stage(writes, [&](std::size_t task, unsigned index) {
        Worker& worker = *workers_[index];
        const std::size_t begin = task * placed_block, end = std::min(count, begin + placed_block);
        worker.writer.begin_placing(kept.places());
        for (std::size_t s = begin; s < end; ++s) {
            if (by_cell && s + 8 < end) {
                kept.prefetch(s + 8);
                worker.writer.prefetch(s + 8);
                kept.prefetch_places(s + 2, true);
            }
            if (!kept.is_kept(s) || kept.is_hidden(s) || !(by_cell || needs_row(s))) continue;
            if (!worker.writer.write(s, kept.cell(s), needs_row(s)))
                finish(&clip_by_faces(s, kept.cell(s), worker), s, worker);
        }
        worker.writer.end_placing();
    });
    end_workers(out);
    out.count({.faces = all_faces, .empty_cells = all_hidden, .kept_cells = all_kept});
    if (!copies || all_kept + all_hidden < count || new_rows > 0) kept.rows().clear();
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
