#include "distributed/blocks/far_cells.hpp"

#include <algorithm>
#include <string>

#include "cpu/cpu_engine.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "result/arrays.hpp"
#include "unbounded/run_endless.hpp"

namespace votess::blocks {
namespace {

// rows: ascending.
void keep_rows(detail::Result& r, std::span<const std::size_t> rows) {
    std::vector<bool> stays(r.indices.size());
    for (const std::size_t row : rows)
        std::fill(stays.begin() + r.indptr[row], stays.begin() + r.indptr[row + 1], true);
    detail::keep_entries(r, stays);
    for (std::size_t k = 0; k < rows.size(); ++k) r.indptr[k + 1] = r.indptr[rows[k] + 1];
    r.indptr.resize_uninitialized(rows.size() + 1);
    detail::for_arrays([&](const auto& array) {
        auto& values = array.of(r);
        if (array.per != Per::cell || values.empty()) return;
        for (std::size_t k = 0; k < rows.size(); ++k)
            for (std::size_t c = 0; c < array.components; ++c)
                values[array.components * k + c] = values[array.components * rows[k] + c];
        values.resize_uninitialized(array.components * rows.size());
    });
}

}  // namespace

std::vector<std::uint32_t> FarCells::take(const BlockDomain& domain, const Run& run, std::size_t count,
                                          std::span<const std::uint32_t> skipped) {
    std::vector<std::uint32_t> rows;
    if (!domain.endless()) return rows;
    for (std::size_t i = 0; i < count; ++i) {
        const auto row = static_cast<std::uint32_t>(i);
        if (std::ranges::binary_search(skipped, row)) continue;
        if (run.result.status[i] == CellStatus::empty)
            throw Error(ErrorCode::unsupported,
                        "seed " + std::to_string(run.seeds.ids[i]) +
                            " has no cell near the others, for its weight is small: whether it has one far out is not "
                            "known across blocks, give " +
                            option("box") + ", or leave the seed out");
        const auto neighbors = std::span<const std::int32_t>(run.result.indices)
                                   .subspan(static_cast<std::size_t>(run.result.indptr[i]),
                                            static_cast<std::size_t>(run.result.indptr[i + 1] - run.result.indptr[i]));
        if (std::ranges::none_of(neighbors, [&](std::int32_t id) { return domain.is_end(id); })) continue;
        rows.push_back(row);
        ids.push_back(run.seeds.ids[i]);
        seeds.add(run.seeds, i);
        for (const std::int32_t id : neighbors)
            if (id >= 0) seeds.add(run.seeds, static_cast<std::size_t>(id));
    }
    return rows;
}

void find_far(const BlockDomain& domain, const FarCells& all, std::span<const std::int64_t> ids, Run& run) {
    if (ids.empty()) return;
    run.seeds = all.seeds.sorted();
    Settled whole = domain.in_space();
    whole.points = {run.seeds.points, {}};
    whole.weights = {run.seeds.weights};
    whole.list_walls = whole.want.neighbors = true;
    const auto on_cpu = [&](Settled in_box) {
        const Job job = make_job(std::move(in_box));
        StageClock clock;
        detail::Result result;
        cpu::CpuEngine(run.clipper).run(job, clock, result);
        return result;
    };
    run.result = run_endless(whole, on_cpu);
    std::vector<std::size_t> rows;
    for (const std::int64_t id : ids) rows.push_back(place_of(id, run.seeds.ids));
    keep_rows(run.result, rows);
}

}  // namespace votess::blocks
