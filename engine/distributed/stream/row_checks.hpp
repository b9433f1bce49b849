// What verify() checks, of rows that come once and are not kept.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "distributed/stream/row_store.hpp"
#include "verify/told_cell.hpp"

namespace votess::stream {

// How many cells are tried by brute force: as many as take about a second, at least 64, but no more than fit a tenth of
// the memory with what the blocks say of them.
[[nodiscard]] std::size_t sample_size(std::uint64_t seeds, std::size_t blocks, bool periodic, std::uint64_t memory);

class RowChecks {
public:
    // sample: so many cells are kept.
    RowChecks(const Layout& layout, std::size_t sample) : layout_(layout), sample_(sample) {}

    // The rows that are next.
    void take(const StreamRows& rows);

    struct BlockSeeds {
        blocks::Seeds seeds;
        std::vector<CellStatus> status;
    };
    // After the last row. stats: with the sum of volumes. block: reads a block, which is done twice.
    [[nodiscard]] VerifyReport report(const Stats& stats, const BlockDomain& domain, std::size_t blocks,
                                      const std::function<BlockSeeds(std::size_t)>& block);

private:
    struct Kept {  // a cell of the sample
        std::uint64_t key;
        std::int64_t id;
        CellStatus status;
        double volume;
        std::vector<ToldFace> row;
    };
    static bool before(const Kept& a, const Kept& b) { return a.key < b.key; }
    void take_row(const StreamRows& rows, std::size_t k);
    void keep(const StreamRows& rows, std::size_t k);
    [[nodiscard]] std::string check_symmetry() const;
    [[nodiscard]] BlockCells cells_of_sample() const;
    [[nodiscard]] std::string check_sample(const BlockDomain& domain, std::size_t blocks,
                                           const std::function<BlockSeeds(std::size_t)>& block);

    const Layout& layout_;
    std::size_t sample_;
    bool certified_ = false;
    std::string wrong_row_, wrong_count_;   // the first
    std::array<std::uint64_t, 2> pairs_{};  // sums over entries, see add_pair()
    std::vector<Kept> kept_;                // a heap
};

}  // namespace votess::stream
