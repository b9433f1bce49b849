// votess::mpi::verify(): ranks ask each other by BlockVerifier.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <set>
#include <string>

#include "distributed/mpi/exchange.hpp"
#include "distributed/mpi/travel.hpp"
#include "verify/verify_sample.hpp"
#include "votess/mpi.hpp"

namespace votess::mpi {
namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

constexpr std::size_t rows_at_once = std::size_t{1} << 17;  // whose pairs travel

class Check {
public:
    Check(MPI_Comm comm, const Result& result, std::span<const double> points, const VerifyOptions& options)
        : ranks_(comm), result_(result), options_(options), made_(result.send_indptr.empty()) {
        ranks_.together([&] {
            if (made_ && !points.empty())
                throw Error(ErrorCode::invalid_argument,
                            "verify: Cells::made have their points in the result: give none");
            points_ = made_ ? std::span<const double>(result.points) : points;
            if (points_.size() != 3 * result.ids.size())
                throw Error(ErrorCode::invalid_argument, "verify: points hold " + std::to_string(points_.size()) +
                                                             " coordinates, the result has " +
                                                             std::to_string(result.ids.size()) + " cells");
        });
    }

    VerifyReport operator()() {
        const std::vector<std::int32_t> holders = made_ ? find_holders() : std::vector<std::int32_t>();
        const BlockCells& cells = result_.cells;
        ranks_.together([&] {
            const BlockDomain domain(result_.options, {}, result_.counts.seeds);
            verifier_.emplace(domain, result_.ids, points_, result_.weights, cells, made_ ? holders : cells.tags);
        });
        const bool volumes = ranks_.maximum(std::uint64_t{cells.volumes.size()}) > 0,
                   counts = ranks_.maximum(std::uint64_t{cells.face_counts.size()}) > 0;
        const bool any = ranks_.maximum(std::uint64_t{result_.ids.size()}) > 0;
        const auto check = [&](const char* name, bool possible, const auto& run) {
            if (any && !possible)
                report_.skipped.emplace_back(name);
            else if (report_.failure.empty())
                report_.failure = run();
        };
        check("volumes", volumes, [&] { return check_volumes(); });
        check("symmetry", true, [&] { return check_symmetry(); });
        check("euler", counts, [&] { return common([&] { return verifier_->check_euler(); }); });
        check("sample", true, [&] { return check_sample(); });
        report_.passed = report_.failure.empty();
        return report_;
    }

private:
    [[nodiscard]] std::size_t ranks() const { return static_cast<std::size_t>(ranks_.size()); }

    // What the lowest rank finds wrong, on all ranks.
    template <class Find>
    std::string common(const Find& find) {
        std::string text;
        ranks_.together([&] { text = find(); });
        return ranks_.first_of(text);
    }

    // Cells that stayed where they were made lie on ranks that rows do not tell. Ids are spread over the ranks, each
    // of which learns who has the cells of its ids, and then tells those who ask.
    std::vector<std::int32_t> find_holders() {
        const auto place = [&](std::int64_t id) { return static_cast<std::uint64_t>(id) % ranks(); };
        const auto send = [&](const std::vector<std::int64_t>& ids) {
            std::vector<std::vector<std::int64_t>> to(ranks());
            for (const std::int64_t id : ids) to[place(id)].push_back(id);
            std::vector<Message> messages;
            for (const auto& some : to) messages.push_back(to_bytes(some));
            return ranks_.exchange(messages);
        };
        std::vector<std::pair<std::int64_t, std::int32_t>> holder_of;
        std::vector<std::int64_t> asked;
        std::vector<Message> own, questions, answers;
        own = send(result_.ids);
        ranks_.together([&] {
            for (std::size_t r = 0; r < own.size(); ++r) {
                std::vector<std::int64_t> ids;
                append_bytes(own[r], ids);
                for (const std::int64_t id : ids) holder_of.emplace_back(id, static_cast<std::int32_t>(r));
            }
            std::ranges::sort(holder_of);
            for (const std::int64_t id : result_.cells.neighbors)
                if (id >= 0) asked.push_back(id);
            std::ranges::sort(asked);
            asked.erase(std::ranges::unique(asked).begin(), asked.end());
        });
        questions = send(asked);
        ranks_.together([&] {
            for (const Message& question : questions) {
                std::vector<std::int64_t> ids;
                append_bytes(question, ids);
                std::vector<std::int32_t> holders;
                for (const std::int64_t id : ids) {
                    const auto found = std::ranges::lower_bound(holder_of, std::pair{id, std::int32_t{0}});
                    if (found == holder_of.end() || found->first != id)
                        throw Error(ErrorCode::invalid_argument,
                                    "verify: no rank has the cell of the neighbor " + std::to_string(id));
                    holders.push_back(found->second);
                }
                answers.push_back(to_bytes(holders));
            }
        });
        answers = ranks_.exchange(answers);
        std::vector<std::int32_t> holders;
        ranks_.together([&] {
            // In the order in which they were asked.
            std::vector<std::vector<std::int32_t>> of_place(ranks());
            for (std::size_t r = 0; r < ranks(); ++r) append_bytes(answers[r], of_place[r]);
            std::vector<std::size_t> next(ranks());
            std::vector<std::int32_t> of_asked;
            for (const std::int64_t id : asked) of_asked.push_back(of_place[place(id)][next[place(id)]++]);
            for (const std::int64_t id : result_.cells.neighbors) {
                const auto at = std::ranges::lower_bound(asked, id) - asked.begin();
                holders.push_back(id < 0 ? -1 : of_asked[static_cast<std::size_t>(at)]);
            }
        });
        return holders;
    }

    std::string check_volumes() {
        double own = 0;
        std::uint64_t cells = 0;
        for (const double volume : result_.cells.volumes) own += volume;
        for (const CellStatus status : result_.cells.status) cells += status == CellStatus::certified ? 1 : 0;
        const double sum = ranks_.sum(own), domain = result_.counts.box_volume;
        // With no seed inside, no cell fills the domain. Subnormal volumes are rounded to a multiple of the least
        // double.
        const double expected = ranks_.sum(cells) == 0 ? 0 : domain;
        const double rounding =
            static_cast<double>(result_.counts.seeds + 1) * std::numeric_limits<double>::denorm_min();
        if (sum == expected || std::abs(sum - expected) <= double_tolerance.sum * domain + rounding) return {};
        return "volumes sum to " + number(sum) + ", the domain holds " + number(domain);
    }

    std::string check_symmetry() {
        std::string failure = common([&] { return verifier_->check_rows(); });
        const std::size_t rows = result_.ids.size();
        const auto most = static_cast<std::size_t>(ranks_.maximum(std::uint64_t{rows}));
        for (std::size_t first = 0; first < most && failure.empty(); first += rows_at_once) {
            std::vector<Message> pairs;
            ranks_.together([&] {
                pairs = verifier_->pairs(ranks(), std::min(first, rows), std::min(first + rows_at_once, rows));
            });
            pairs = ranks_.exchange(pairs);
            failure = common([&] {
                for (const Message& some : pairs)
                    if (auto wrong = verifier_->check_pairs(some); !wrong.empty()) return wrong;
                return std::string();
            });
        }
        return failure;
    }

    // Cells are drawn from those of all ranks, counted rank after rank.
    std::string check_sample() {
        const std::uint64_t own = verifier_->candidates(), before = ranks_.sum_before(own), all = ranks_.sum(own);
        SampleRandom random{options_.rng_seed};
        std::set<std::uint64_t> drawn;
        const std::uint64_t most = std::min(all, options_.sample ? std::uint64_t{*options_.sample} : all);
        while (report_.sampled < most) {
            if (!options_.sample && report_.sampled >= min_sample &&
                ranks_.maximum(std::uint64_t{verifier_->has_worked_enough() ? 1u : 0u}) > 0)
                break;
            std::vector<std::size_t> mine;
            const std::uint64_t batch = std::min<std::uint64_t>(min_sample, most - report_.sampled);
            for (std::uint64_t k = 0; k < batch;) {
                const std::uint64_t cell = random.next() % all;
                if (!drawn.insert(cell).second) continue;
                ++k;
                if (cell >= before && cell < before + own) mine.push_back(static_cast<std::size_t>(cell - before));
            }
            report_.sampled += batch;
            if (std::string failure = try_cells(mine); !failure.empty()) return failure;
        }
        return {};
    }

    std::string try_cells(const std::vector<std::size_t>& mine) {
        Message seeds;
        ranks_.together([&] { seeds = verifier_->seeds(mine); });
        const std::vector<Message> asked = ranks_.gather_all(seeds);
        std::vector<Message> faces(ranks());
        ranks_.together([&] {
            for (std::size_t r = 0; r < ranks(); ++r) faces[r] = verifier_->faces_of(asked[r]);
        });
        faces = ranks_.exchange(faces);
        return common([&] { return verifier_->check_cells(mine, faces); });
    }

    Ranks ranks_;
    const Result& result_;
    const VerifyOptions& options_;
    bool made_;
    std::span<const double> points_;
    std::optional<BlockVerifier> verifier_;
    VerifyReport report_;
};

}  // namespace

VerifyReport verify(MPI_Comm comm, const Result& result, std::span<const double> points, const VerifyOptions& options) {
    return Check(comm, result, points, options)();
}

}  // namespace votess::mpi
