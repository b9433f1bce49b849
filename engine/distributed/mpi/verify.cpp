// votess::mpi::verify(): each rank feeds its rows to the checker, which combines the ranks.
#include <array>
#include <limits>
#include <optional>
#include <string>

#include "distributed/blocks/blocks.hpp"
#include "distributed/mpi/exchange.hpp"
#include "input/settle.hpp"
#include "plane/sheet.hpp"
#include "verify/row_checker.hpp"
#include "votess/mpi.hpp"

namespace votess::mpi {
namespace {

constexpr std::size_t automatic = std::numeric_limits<std::size_t>::max();

class RankBlock : public RunBlocks {
public:
    RankBlock(const Ranks& ranks, const Result& result, std::span<const double> points)
        : ranks_(ranks), result_(result), made_(result.send_indptr.empty()) {
        const auto refuse = [](const std::string& text) {
            throw Error(ErrorCode::invalid_argument, "verify: " + text);
        };
        if (made_ && !points.empty()) refuse("Cells::made have their points in the result: give none");
        if (made_) points = result.points;
        const std::size_t count = result.ids.size();
        const bool planar = result.options.planar;
        if (points.size() != (planar ? 2 : 3) * count)
            refuse("points hold " + std::to_string(points.size()) + " coordinates, the result has " +
                   std::to_string(count) + " cells");
        const BlockCells& cells = result.cells;
        if (cells.status.size() != count || cells.indptr.size() != count + 1 ||
            cells.indices.size() != static_cast<std::size_t>(cells.indptr.back()) ||
            cells.owners.size() != cells.indices.size())
            refuse("the arrays of the result do not fit its " + std::to_string(count) +
                   " ids: give what tessellate() returned");
        if (planar)  // read once, see input/snapshot.hpp
            points_ = in_sheet({points, {}});
        else
            points_.assign(points.begin(), points.end());
    }

    [[nodiscard]] std::span<const double> points() const { return points_; }

    bool for_rows(const Visit& visit) override {
        const BlockCells& cells = result_.cells;
        const StreamRows rows = rows_of(cells);
        RowNames names{result_.ids, {}, ranks_.rank()};
        if (!made_) names.owners = cells.owners;
        visit(rows, names);
        return true;
    }
    void for_blocks(const std::function<void(Seeds)>& task) override {
        Seeds seeds;
        together([&] {
            for (std::size_t i = 0; i < result_.ids.size(); ++i)
                if (takes_part(result_.cells.status[i])) seeds.add(result_.ids[i], points_, result_.weights, i);
            seeds = seeds.sorted();
        });
        task(std::move(seeds));
    }
    void together(const std::function<void()>& work) override { ranks_.together(work); }
    std::vector<Message> gather_all(const Message& own) override { return ranks_.gather_all(own); }
    std::vector<Message> exchange(const std::vector<Message>& to) override { return ranks_.exchange(to); }

private:
    const Ranks& ranks_;
    const Result& result_;
    bool made_;
    std::vector<double> points_;
};

}  // namespace

VerifyReport verify(MPI_Comm comm, const Result& result, std::span<const double> points, const VerifyOptions& options) {
    const Ranks ranks(comm);
    Hash of_result;  // of the parts of a result that are equal on all ranks
    of_result.mix(result.send_indptr.empty(), result.counts.seeds, result.counts.box_volume, result.counts.volume_sum,
                  result.counts.exact_cells);
    ranks.agree("verify", std::array{CommonArgument{"the result", of_result.value()},
                                     CommonArgument{"sample", Hash().mix(options.sample.value_or(automatic)).value()},
                                     CommonArgument{"rng_seed", Hash().mix(options.rng_seed).value()}});
    std::optional<RankBlock> block;
    std::optional<RowChecker> checker;
    ranks.together([&] { block.emplace(ranks, result, points); });
    const Box bounds = ranks.bounds_of(block->points());
    ranks.together([&] {
        Settled whole = settle(result.options);
        const bool periodic = whole.region.is_periodic();
        RowChecker::Sample sample{0, options.rng_seed};
        sample.max_cells = options.sample.value_or(
            sample_size(result.counts.seeds / static_cast<std::uint64_t>(ranks.size()), 1, periodic));
        if (options.sample) sample.budget = std::numeric_limits<double>::infinity();
        const BlockDomain domain(std::move(whole), bounds, result.counts.seeds);
        checker.emplace(checked_run(domain, result.counts.seeds, result.counts.box_volume), sample, *block);
        block->for_rows([&](const StreamRows& rows, const RowNames& names) { checker->take(rows, names); });
    });
    return checker->report();
}

}  // namespace votess::mpi
