// A proof of cells that come in blocks, each of which has some of the seeds.
//
// Each block proves its cells by the conditions of certificate.hpp. From other blocks it gets the rows of its neighbors
// there, with all seeds that these rows name. So it can ask in exact signs whether the cell of such a neighbor has a
// corner. The neighbor's block asks the same from the other side. What is left belongs to all blocks together: rows are
// symmetric (RowChecker), and the volumes of all polytopes have one sum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "input/seeds.hpp"
#include "result/rows.hpp"
#include "verify/reported_cell.hpp"
#include "votess/row_arrays.hpp"
#include "votess/stream.hpp"

namespace votess {

// Rows of one block that another one needs: of cells that have neighbors there.
struct VOTESS_API BorderRows {
    Seeds seeds;                        // of the cells and all seeds that they list; some repeat
    std::vector<std::int64_t> cells;    // N ids
    std::vector<std::uint32_t> sizes;   // N, of the rows
    std::vector<std::int64_t> indices;  // ids, row after row, without walls
    std::vector<std::int8_t> shifts;    // three an entry; empty without periods

    [[nodiscard]] std::size_t size() const { return cells.size(); }
    void add(const BorderRows& others);
    void put_to(Writer& writer) const;
    void get_from(Reader& reader);
};
// Returns, by block, the rows that it needs of this one. seeds: of the block, with its neighbors, and tags that name
// their blocks. The first ones have these rows. skipped: ascending; rows that do not count.
[[nodiscard]] VOTESS_API std::vector<BorderRows> border_rows(const Seeds& seeds, const Rows& rows, std::size_t count,
                                                             std::span<const std::uint32_t> skipped,
                                                             std::size_t blocks);

// What the blocks found so far.
struct BlockProof {
    Fault fault, unsettled;        // as in Certificate::Verdict
    double volume = 0, doubt = 0;  // of all polytopes
    Seeds open;                    // reported to have no cell; no cells near them in their block exclude them
    bool certified = false;        // whether there is a cell
    static auto parts(auto& p) { return std::tie(p.fault, p.unsettled, p.volume, p.doubt, p.open, p.certified); }

    void merge(BlockProof other);
    // After the last block: notes what the sum of volumes says.
    void check_volume(double domain);
};

class BlockCertificate {
public:
    // own: the seeds of the block, also those without a cell. border: from all other blocks.
    BlockCertificate(const CheckedRun& run, Seeds own, const BorderRows& border);
    // Adds the next rows of the block, in the order of `own`.
    void add(const StreamRows& rows);
    // Call one of these once, after the last row. They throw `cancelled`.
    [[nodiscard]] BlockProof prove();
    // Returns the ids of the seeds, of any block, that cells of this block exclude.
    [[nodiscard]] std::vector<std::int64_t> find_excluded(const Seeds& hidden);

private:
    void add_entry(std::size_t cell, std::int64_t id, std::span<const std::int8_t> shift);
    void complete();
    template <class Task>
    auto with_certificate(const Task& task);
    void end_row() { rows_.indptr.push_back(static_cast<std::int64_t>(rows_.indices.size())); }

    const CheckedRun& run_;
    Seeds seeds_;        // the own ones, those of the border rows, and others
    std::size_t count_;  // own seeds
    SeedIndex index_;
    const BorderRows& border_;
    std::vector<std::uint32_t> border_cells_;  // numbers in border_, in the order of seeds_
    RowArrays<detail::Vector, std::int32_t> rows_;
    BlockProof proof_;
};

}  // namespace votess
