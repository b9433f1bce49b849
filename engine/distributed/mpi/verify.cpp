// votess::mpi::verify(): each rank feeds its rows to the checker, which combines the ranks.
#include <algorithm>
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
    void for_proofs(const Prove& prove) override {
        Seeds own;
        together([&] {
            for (std::size_t i = 0; i < result_.ids.size(); ++i) own.add(result_.ids[i], points_, result_.weights, i);
        });
        Seeds others = neighbors_of(own);
        const std::vector<Message> from = ranks_.exchange(border_for_others(own, others));
        together([&] {
            BorderRows border;
            others.tags = {};
            border.seeds = std::move(others);  // those of duplicates, too
            for (const Message& message : from) {
                BorderRows some;
                read_message(message, some);
                border.add(some);
            }
            if (own.size() > 0)
                prove(std::move(own), border, [&](const Visit& visit) { visit(rows_of(result_.cells), {}); });
        });
    }
    void together(const std::function<void()>& work) override { ranks_.together(work); }
    std::vector<Message> gather_all(const Message& own) override { return ranks_.gather_all(own); }
    std::vector<Message> exchange(const std::vector<Message>& to) override { return ranks_.exchange(to); }

private:
    // Returns the seeds of other ranks that rows name. Tags: the ranks that have their rows. The rank of an id modulo
    // their number knows where it is.
    Seeds neighbors_of(const Seeds& own) {
        const BlockCells& cells = result_.cells;
        const auto ranks = static_cast<std::size_t>(ranks_.size());
        const auto rank_of = [&](std::int64_t id) { return static_cast<std::uint64_t>(id) % ranks; };
        std::vector<Message> to(ranks);
        together([&] {
            std::vector<Seeds> known(ranks);
            std::vector<std::vector<std::int64_t>> wanted(ranks);
            for (std::size_t i = 0; i < own.size(); ++i)
                if (takes_part(cells.status[i])) known[rank_of(own.ids[i])].add(own, i);
            std::vector<std::int64_t> ids = cells.indices;
            ids.insert(ids.end(), cells.duplicate_of.begin(), cells.duplicate_of.end());
            std::ranges::sort(ids);
            ids.erase(std::ranges::unique(ids).begin(), ids.end());
            const SeedIndex index(own.ids);
            for (const std::int64_t id : ids)
                if (id >= 0 && index.find(id) < 0) wanted[rank_of(id)].push_back(id);
            for (std::size_t r = 0; r < ranks; ++r) to[r] = message_of(known[r], wanted[r]);
        });
        std::vector<Message> from = ranks_.exchange(to);
        together([&] {
            Seeds known;
            std::vector<std::vector<std::int64_t>> wanted(ranks);
            for (std::size_t r = 0; r < ranks; ++r) {
                Seeds some;
                read_message(from[r], some, wanted[r]);
                some.tags.assign(some.size(), static_cast<std::int32_t>(r));
                known.add(some);
            }
            const SeedIndex index(known.ids);
            for (std::size_t r = 0; r < ranks; ++r) {
                Seeds some;
                for (const std::int64_t id : wanted[r])
                    if (const std::int32_t k = index.find(id); k >= 0) some.add(known, static_cast<std::size_t>(k));
                to[r] = to_message(some);
            }
        });
        from = ranks_.exchange(to);
        Seeds others;
        together([&] {
            for (const Message& message : from) {
                Seeds some;
                read_message(message, some);
                others.add(some);
            }
        });
        return others;
    }

    // Returns, by rank, the rows that it needs.
    std::vector<Message> border_for_others(const Seeds& own, const Seeds& others) {
        std::vector<Message> to;
        together([&] {
            const BlockCells& cells = result_.cells;
            const std::size_t each = result_.options.planar ? 2 : 3;
            Seeds seeds = own;
            seeds.tags.assign(own.size(), ranks_.rank());
            seeds.add(others);
            const SeedIndex index(seeds.ids);
            std::vector<std::int32_t> indices;
            std::vector<std::int8_t> shifts(cells.shifts.size() / each * 3);
            for (const std::int64_t id : cells.indices) indices.push_back(id < 0 ? -1 : index.find(id));
            for (std::size_t e = 0; e < shifts.size() / 3; ++e)
                std::copy_n(&cells.shifts[each * e], each, &shifts[3 * e]);
            const Rows rows{cells.indptr, indices, shifts};
            for (const BorderRows& some :
                 border_rows(seeds, rows, own.size(), {}, static_cast<std::size_t>(ranks_.size())))
                to.push_back(to_message(some));
        });
        return to;
    }

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
        sample.unproven = options.sample ? sample_was_given : "";
        if (options.sample) sample.budget = std::numeric_limits<double>::infinity();
        const BlockDomain domain(std::move(whole), bounds, result.counts.seeds);
        checker.emplace(checked_run(domain, result.counts.seeds, result.counts.box_volume), sample, *block);
        block->for_rows([&](const StreamRows& rows, const RowNames& names) { checker->take(rows, names); });
    });
    return checker->report();
}

}  // namespace votess::mpi
