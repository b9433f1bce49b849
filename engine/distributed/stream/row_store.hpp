// The cells of a block in temporary files, until those of all blocks are complete.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/thread_pool.hpp"
#include "distributed/blocks/local_block.hpp"
#include "distributed/stream/spool.hpp"
#include "result/arrays.hpp"
#include "votess/stream.hpp"

namespace votess::stream {

// The bytes that each of detail::row_arrays takes for one cell or entry; 0 when it is not wanted. duplicate_of has
// none: a store keeps pairs instead.
struct Layout {
    // whole: the run.
    Layout(const Settled& whole, std::uint64_t seeds);
    [[nodiscard]] std::size_t bytes(std::size_t array) const { return bytes_[array]; }
    [[nodiscard]] bool rows() const { return bytes(indices) > 0; }
    [[nodiscard]] bool narrow() const { return bytes(indices) == sizeof(std::int32_t); }
    [[nodiscard]] std::size_t bytes_of(Per per) const {
        std::size_t sum = per == Per::cell && rows() ? sizeof(std::uint32_t) : 0;  // the length of the row
        for_row_arrays([&](const auto& array, std::size_t number) {
            if (array.per == per) sum += bytes_[number];
        });
        return sum;
    }

    // Edges and vertices are stored as what they lack of 3 and 2 for each face, which is nearly always the same.
    // Returns 0 for other arrays.
    [[nodiscard]] static constexpr std::uint32_t of_faces(std::size_t array) {
        return array == detail::number_of("edge_counts") ? 3 : array == detail::number_of("vertex_counts") ? 2 : 0;
    }

    static constexpr std::size_t indices = detail::number_of("indices"), status = detail::number_of("status");

private:
    std::array<std::size_t, detail::row_array_count> bytes_{};
};

// Cells in ascending order of ids.
class RowStore {
public:
    struct Duplicate {
        std::int64_t id, of;
    };

    // ids: of the cells. They may be written later.
    RowStore(const Layout& layout, TemporaryFile& file, Spool ids);

    // Adds the first `count` cells of the run. skipped: ascending; these get no row here, a later store has them.
    void add(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped);

    // From now on, what has been read leaves the disk.
    void release_as_read();
    // All is read from the start again.
    void rewind();

    [[nodiscard]] std::uint64_t entries() const { return entries_; }
    [[nodiscard]] bool has_duplicates() const { return duplicates_.size() > 0; }
    [[nodiscard]] Spool& ids() { return ids_; }
    [[nodiscard]] Spool& lengths() { return lengths_; }  // of rows
    [[nodiscard]] Spool& of(std::size_t array) { return arrays_[array]; }
    [[nodiscard]] const Spool& duplicates() const { return duplicates_; }

private:
    struct Piece;
    void add_rows(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped);

    const Layout& layout_;
    Spool ids_, duplicates_, lengths_;
    std::vector<Spool> arrays_;
    std::uint64_t entries_ = 0;
};

}  // namespace votess::stream
