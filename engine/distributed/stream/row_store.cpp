#include "distributed/stream/row_store.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/arithmetic.hpp"

namespace votess::stream {
namespace {

constexpr std::size_t piece_cells = 16384;

std::byte* grow(std::vector<std::byte>& bytes, std::size_t by) {
    bytes.resize(bytes.size() + by);
    return bytes.data() + bytes.size() - by;
}

void put_ids(std::span<const std::int64_t> ids, bool narrow, std::vector<std::byte>& bytes) {
    if (!narrow) {
        std::memcpy(grow(bytes, ids.size_bytes()), ids.data(), ids.size_bytes());
        return;
    }
    std::byte* to = grow(bytes, ids.size() * sizeof(std::int32_t));
    for (const std::int64_t id : ids) {
        const auto value = static_cast<std::int32_t>(id);
        std::memcpy(to, &value, sizeof value);
        to += sizeof value;
    }
}

// Appends a row, which starts at entry `begin`. each: bytes of one entry.
void put_values(std::size_t begin, std::size_t size, const void* values, std::size_t each,
                std::vector<std::byte>& bytes) {
    if (each == 0 || size == 0) return;
    std::memcpy(grow(bytes, size * each), static_cast<const std::byte*>(values) + each * begin, each * size);
}

}  // namespace

Layout::Layout(const Want& want, bool periodic, std::uint64_t seeds) {
    const auto set = [this](Array array, bool wanted, std::size_t bytes) {
        bytes_[static_cast<std::size_t>(array)] = wanted ? bytes : 0;
    };
    const bool wide = seeds > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());
    set(Array::status, true, sizeof(CellStatus));
    set(Array::lengths, want.neighbors, sizeof(std::uint32_t));
    set(Array::volumes, want.volumes, sizeof(double));
    set(Array::centroids, want.centroids, 3 * sizeof(double));
    set(Array::surface_areas, want.surfaces, sizeof(double));
    set(Array::security_radii, want.radii, sizeof(double));
    for (const Array counts : {Array::face_counts, Array::edge_counts, Array::vertex_counts})
        set(counts, want.counts, sizeof(std::uint32_t));
    set(Array::neighbors, want.neighbors, wide ? sizeof(std::int64_t) : sizeof(std::int32_t));
    set(Array::shifts, want.neighbors && periodic, 3);
    set(Array::areas, want.areas, sizeof(double));
    set(Array::normals, want.normals, 3 * sizeof(double));
}

RowStore::RowStore(const Layout& layout, TemporaryFile& file, Spool ids)
    : layout_(layout), ids_(std::move(ids)), duplicates_(file), arrays_(array_count, Spool(file)) {}

void RowStore::add(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped) {
    const detail::Result& result = run.result;
    if (layout_.rows()) add_rows(run, count, skipped);
    const auto add = [&](Array array, const auto& values) {
        if (layout_.bytes(array) > 0) of(array).append(std::span(values.data(), values.size()));
    };
    add(Array::status, result.status);
    add(Array::volumes, result.volumes);
    add(Array::centroids, result.centroids);
    add(Array::surface_areas, result.surface_areas);
    add(Array::security_radii, result.security_radii);
    add(Array::face_counts, result.face_counts);
    add(Array::edge_counts, result.edge_counts);
    add(Array::vertex_counts, result.vertex_counts);
    std::vector<Duplicate> duplicates;
    for (std::size_t i = 0; i < result.duplicate_of.size(); ++i)
        if (const std::int32_t of = result.duplicate_of[i]; of >= 0)
            duplicates.push_back({run.seeds.ids[i], run.seeds.ids[static_cast<std::size_t>(of)]});
    duplicates_.append(std::span<const Duplicate>(duplicates));
}

struct RowStore::Piece {
    std::vector<std::int64_t> row;  // ids
    std::vector<std::uint32_t> lengths;
    std::array<std::vector<std::byte>, entry_arrays.size()> entries;
};

void RowStore::add_rows(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped) {
    const detail::Result& result = run.result;
    ThreadPool& pool = run.clipper.pool();
    std::vector<Piece> pieces(2 * std::size_t{pool.size()});
    const bool narrow = layout_.bytes(Array::neighbors) == sizeof(std::int32_t);
    const auto fill = [&](std::size_t begin, Piece& piece) {
        piece.lengths.clear();
        for (auto& bytes : piece.entries) bytes.clear();
        auto& [ids, shifts, areas, normals] = piece.entries;
        for (std::size_t i = begin; i < std::min(count, begin + piece_cells); ++i) {
            if (std::ranges::binary_search(skipped, static_cast<std::uint32_t>(i))) {
                piece.lengths.push_back(0);
                continue;
            }
            const auto at = static_cast<std::size_t>(result.indptr[i]),
                       size = static_cast<std::size_t>(result.indptr[i + 1]) - at;
            piece.row.clear();
            for (const std::int32_t index : std::span(result.indices).subspan(at, size))
                piece.row.push_back(index < 0 ? index : run.seeds.ids[static_cast<std::size_t>(index)]);
            piece.lengths.push_back(static_cast<std::uint32_t>(size));
            put_ids(piece.row, narrow, ids);
            put_values(at, size, result.shifts.data(), layout_.bytes(Array::shifts), shifts);
            put_values(at, size, result.face_areas.data(), layout_.bytes(Array::areas), areas);
            put_values(at, size, result.face_normals.data(), layout_.bytes(Array::normals), normals);
        }
    };
    for (std::size_t begin = 0; begin < count; begin += pieces.size() * piece_cells) {
        const std::size_t filled = std::min(pieces.size(), ceil_div(count - begin, piece_cells));
        pool.run(filled, [&](std::size_t k, unsigned) { fill(begin + k * piece_cells, pieces[k]); });
        for (std::size_t k = 0; k < filled; ++k) {
            of(Array::lengths).append(std::span<const std::uint32_t>(pieces[k].lengths));
            entries_ += pieces[k].entries[0].size() / layout_.bytes(Array::neighbors);
            for (std::size_t e = 0; e < entry_arrays.size(); ++e)
                of(entry_arrays[e]).append(std::span<const std::byte>(pieces[k].entries[e]));
        }
    }
}

}  // namespace votess::stream
