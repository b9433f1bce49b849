// The cells of a block in temporary files, until those of all blocks are complete.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/thread_pool.hpp"
#include "distributed/blocks/local_block.hpp"
#include "distributed/stream/spool.hpp"
#include "votess/stream.hpp"

namespace votess::stream {

// The arrays of a result: first those of cells, then those of entries of rows.
enum class Array : std::uint8_t {
    status,
    lengths,
    volumes,
    centroids,
    surface_areas,
    security_radii,
    face_counts,
    edge_counts,
    vertex_counts,
    neighbors,
    shifts,
    areas,
    normals
};
inline constexpr std::size_t array_count = 13;
inline constexpr std::array cell_arrays{Array::status,      Array::lengths,       Array::volumes,
                                        Array::centroids,   Array::surface_areas, Array::security_radii,
                                        Array::face_counts, Array::edge_counts,   Array::vertex_counts};
inline constexpr std::array entry_arrays{Array::neighbors, Array::shifts, Array::areas, Array::normals};

// The bytes that each array takes for one cell or entry; 0 when it is not wanted.
struct Layout {
    Layout(const Want& want, bool periodic, std::uint64_t seeds);
    [[nodiscard]] std::size_t bytes(Array array) const { return bytes_[static_cast<std::size_t>(array)]; }
    [[nodiscard]] bool rows() const { return bytes(Array::lengths) > 0; }
    [[nodiscard]] std::size_t bytes_of_cell() const { return sum(cell_arrays); }
    [[nodiscard]] std::size_t bytes_of_entry() const { return sum(entry_arrays); }

private:
    [[nodiscard]] std::size_t sum(std::span<const Array> arrays) const {
        std::size_t sum = 0;
        for (const Array array : arrays) sum += bytes(array);
        return sum;
    }

    std::array<std::size_t, array_count> bytes_{};
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

    [[nodiscard]] std::uint64_t entries() const { return entries_; }
    [[nodiscard]] bool has_duplicates() const { return duplicates_.size() > 0; }
    [[nodiscard]] Spool& ids() { return ids_; }
    [[nodiscard]] Spool& of(Array array) { return arrays_[static_cast<std::size_t>(array)]; }
    [[nodiscard]] const Spool& duplicates() const { return duplicates_; }

private:
    struct Piece;
    void add_rows(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped);

    const Layout& layout_;
    Spool ids_, duplicates_;
    std::vector<Spool> arrays_;
    std::uint64_t entries_ = 0;
};

}  // namespace votess::stream
