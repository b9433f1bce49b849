// The checks of verify() on rows that come in pieces: from a whole result, from a stream or from the ranks of MPI.
//
// take() checks each row by itself, on the threads of the run: it ascends, Euler's formula holds, and the surface is
// closed. Over all rows it adds up volumes, and signed random numbers of pairs that cancel when each entry has its
// counterpart in the row of the neighbor. It keeps the cells of least random keys as a sample, which does not depend on
// how rows come. report() combines the ranks. Then it proves all cells, block by block, see block_certificate.hpp, or
// tries the sample by brute force.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "result/arrays.hpp"
#include "verify/block_certificate.hpp"
#include "verify/reported_cell.hpp"
#include "votess/block_cells.hpp"
#include "votess/stream.hpp"

namespace votess {

class ThreadPool;

// A sample costs about a second: this many distance tests. They are counted, so that every machine tries the same
// cells.
inline constexpr double sample_budget = 5e8;
inline constexpr std::size_t min_sample = 64;
// Returns how many distance tests a seed costs each cell of a sample.
[[nodiscard]] constexpr std::size_t tests_of_seed(bool periodic) {
    return periodic ? 62 : 2;
}
// Returns how many cells the budget pays for, at least 64. seeds: of all blocks.
[[nodiscard]] VOTESS_API std::size_t sample_size(std::uint64_t seeds, std::size_t blocks, bool periodic);

// The names of the seeds of some rows. By default these are StreamRows::first, first + 1, ...
struct RowNames {
    std::span<const std::int64_t> ids;  // n
    // The ranks that handed in the neighbors (entries), and these seeds. They are checked with the pairs, if given.
    std::span<const std::int32_t> owners;
    std::int32_t own_rank = 0;
};

// Gives access to the rows and seeds of a run. By default there is one rank; calls between ranks are collective.
class RunBlocks {
public:
    using Visit = std::function<void(const StreamRows&, const RowNames&)>;

    virtual ~RunBlocks() = default;
    // Visits all rows of this rank. Returns false where rows cannot be read again.
    virtual bool for_rows(const Visit&) { return false; }
    // Calls the task with the seeds of each block of this rank that have cells, ascending by id.
    virtual void for_blocks(const std::function<void(Seeds)>& task) = 0;
    // Calls prove(own, border, rows) for each block of this rank that has seeds: these, see BlockCertificate, and what
    // visits their rows. Only for a sample that says so.
    using RowsOf = std::function<void(const Visit&)>;
    using Prove = std::function<void(Seeds own, const BorderRows& border, const RowsOf& rows)>;
    virtual void for_proofs(const Prove&) {}

    // Does the work; when it throws on one rank, it throws on all.
    virtual void together(const std::function<void()>& work) { work(); }
    // Returns the messages of all ranks.
    [[nodiscard]] virtual std::vector<Message> gather_all(const Message& own) { return {own}; }
    // to: by rank. Returns what other ranks sent to this one, by rank.
    [[nodiscard]] virtual std::vector<Message> exchange(const std::vector<Message>& to) { return to; }
};

// Why nothing is proven where VerifyOptions has a sample.
inline constexpr const char* sample_was_given = "a number of cells was given, which are sampled";

class VOTESS_API RowChecker {
public:
    struct Sample {
        std::size_t max_cells = 0;
        std::uint64_t rng_seed = 1;
        double budget = sample_budget;            // no more cells once some rank has done this many distance tests
        std::size_t first_round = min_sample;     // cells in the first round
        std::optional<std::int64_t> cell{};       // no other one
        bool rows_are_proven = false;             // to ascend and to be symmetric
        std::string unproven = "rows come once";  // why for_proofs() is not asked; empty: it is
    };
    // blocks: must outlive this object.
    RowChecker(CheckedRun run, const Sample& sample, RunBlocks& blocks);
    ~RowChecker();

    // Takes each row once, in any order.
    void take(const StreamRows& rows, const RowNames& names = {});
    // Returns the verdict after the last row. Collective.
    [[nodiscard]] VerifyReport report();

private:
    // Sums over the rows of this rank, then of all.
    struct Sums {
        double volume = 0;
        std::uint64_t entries = 0;
        std::array<std::uint64_t, 2> pairs{};
        // Whether there is a certified cell, and whether there are these arrays.
        bool certified = false, rows = false, volumes = false, counts = false;
    };
    struct Kept {
        std::uint64_t key;
        ReportedCell cell;
    };
    static bool before(const Kept& a, const Kept& b) { return a.key < b.key; }

    // What one thread finds in rows by themselves.
    struct alignas(64) Checks {
        std::array<std::uint64_t, 2> pairs{};
        Fault order, euler, surface;
    };
    void take_row(Checks& checks, const StreamRows& rows, std::size_t k, std::int64_t id, const RowNames& names) const;
    void keep(const StreamRows& rows, std::size_t k, std::int64_t id);
    // Combines sums and faults of all ranks. Returns how many ranks there are.
    std::size_t combine();
    [[nodiscard]] std::string check_volumes() const;
    [[nodiscard]] std::string check_symmetry(std::size_t ranks);
    // Proves all cells, or says why not.
    void prove(VerifyReport& report);
    void exclude_open(const Seeds& own, BlockProof& proof);
    [[nodiscard]] Seeds seeds_of_sample();
    [[nodiscard]] std::string check_sample(std::size_t& sampled);
    [[nodiscard]] Fault try_cells(std::span<const ReportedCell> cells, const Seeds& named, double& work);
    [[nodiscard]] Fault first_of_ranks(const Fault& own);

    CheckedRun run_;
    Sample sample_;
    RunBlocks& blocks_;
    Sums sums_;
    std::unique_ptr<ThreadPool> pool_;  // once there are rows for several threads
    std::vector<Checks> checks_;        // of its threads
    Fault order_, euler_, surface_;
    std::vector<Kept> kept_;  // a heap; from check_sample() on, ascending
};

}  // namespace votess
