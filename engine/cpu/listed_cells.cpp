// Cells whose neighbors another engine has found and certified: their polytopes, for what that engine does not measure.
#include <algorithm>
#include <functional>
#include <vector>

#include "core/arithmetic.hpp"
#include "cpu/cpu_clipper.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t block_cells = 512;

}  // namespace

void CpuClipper::clip_listed(const NeighborLists& lists, ResultBuilder& out, const Share& share) {
    if (lists.cells.empty()) return;
    sort();
    find_positions();
    begin_workers(out);
    const std::size_t count = lists.cells.size(), blocks = ceil_div(count, block_cells);
    const std::span<std::int32_t> cells = out.allocate_cells(count);
    std::ranges::copy(lists.cells, cells.begin());
    std::vector<std::size_t> first_entry(blocks + 1, 0);
    for (std::size_t k = 0; k < count; ++k) first_entry[k / block_cells + 1] += lists.lengths[k];
    for (std::size_t b = 0; b < blocks; ++b) first_entry[b + 1] += first_entry[b];
    const Stoppable stoppable(progress_);
    if (progress_) Stoppable::enter_stage(share);
    const auto task = [&](std::size_t block, unsigned index) {
        Worker& worker = workers_[index];
        const std::size_t begin = block * block_cells, end = std::min(count, begin + block_cells);
        std::size_t entry = first_entry[block];
        for (std::size_t k = begin; k < end; ++k) {
            worker.candidates.clear();
            worker.shifts.clear();
            const auto seed = static_cast<std::size_t>(position_[static_cast<std::size_t>(cells[k])]);
            for (const std::size_t row_end = entry + lists.lengths[k]; entry < row_end; ++entry) {
                if (lists.ids[entry] < 0) continue;
                const std::int32_t neighbor = position_[static_cast<std::size_t>(lists.ids[entry])];
                worker.candidates.push_back(neighbor);
                if (lists.shifts.empty()) continue;
                exact::Shift shift = images_.shift_in_domain(neighbor, seed);
                for (std::size_t j = 0; j < 3; ++j) shift[j] = lists.shifts[entry][j] - shift[j];
                worker.shifts.push_back(shift);
            }
            Cell& cell = lists.shifts.empty() ? worker.builder.build_from(seed, worker.candidates)
                                              : worker.builder.build_from(seed, worker.candidates, worker.shifts);
            worker.writer.write(seed, cell);
        }
        worker.writer.end_block(cells.subspan(begin, end - begin));
    };
    pool_->run_stage(blocks, std::cref(task));
    for (const Worker& worker : workers_) {
        out.count(worker.writer.counters());
        out.count(worker.writer.tally());
    }
}

}  // namespace votess::cpu
