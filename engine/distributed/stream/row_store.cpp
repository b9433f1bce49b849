#include "distributed/stream/row_store.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

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

Layout::Layout(const Settled& whole, std::uint64_t seeds) {
    const bool narrow = seeds <= static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());
    for_row_arrays([&](const auto& array, std::size_t number) {
        using Rows = detail::Result;
        const bool wanted = array.word == nullptr || whole.want.*array.word;
        if (wanted)
            bytes_[number] = components_of(array, whole.region.planar) * sizeof(array.of(std::declval<Rows&>())[0]);
    });
    if (rows() && !narrow) bytes_[indices] = sizeof(std::int64_t);
    if (!whole.region.is_periodic()) bytes_[detail::number_of("shifts")] = 0;
    bytes_[detail::number_of("duplicate_of")] = 0;
}

RowStore::RowStore(const Layout& layout, TemporaryFile& file, Spool ids)
    : layout_(layout),
      ids_(std::move(ids)),
      duplicates_(file),
      lengths_(file),
      arrays_(detail::row_array_count, Spool(file)) {}

void RowStore::add(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped) {
    const detail::Result& result = run.result;
    if (layout_.rows()) add_rows(run, count, skipped);
    for_row_arrays([&](const auto& array, std::size_t number) {
        const auto& values = array.of(result);
        if (array.per != Per::cell || layout_.bytes(number) == 0) return;
        const std::uint32_t of_faces = Layout::of_faces(number);
        if (of_faces == 0) return of(number).append(std::span(values.data(), values.size()));
        std::vector<std::uint32_t> lacking(values.size());
        for (std::size_t i = 0; i < lacking.size(); ++i)
            lacking[i] = of_faces * result.face_counts[i] - static_cast<std::uint32_t>(values[i]);
        of(number).append(std::span<const std::uint32_t>(lacking));
    });
    std::vector<Duplicate> duplicates;
    for (std::size_t i = 0; i < result.duplicate_of.size(); ++i)
        if (const std::int32_t of = result.duplicate_of[i]; of >= 0)
            duplicates.push_back({run.seeds.ids[i], run.seeds.ids[static_cast<std::size_t>(of)]});
    duplicates_.append(std::span<const Duplicate>(duplicates));
}

void RowStore::release_as_read() {
    for (Spool* spool : {&ids_, &duplicates_, &lengths_}) spool->release_as_read();
    for (Spool& array : arrays_) array.release_as_read();
}

void RowStore::rewind() {
    for (Spool* spool : {&ids_, &duplicates_, &lengths_}) spool->rewind();
    for (Spool& array : arrays_) array.rewind();
}

struct RowStore::Piece {
    std::vector<std::int64_t> row;  // ids
    std::vector<std::uint32_t> lengths;
    std::array<std::vector<std::byte>, detail::row_array_count> entries;
};

void RowStore::add_rows(blocks::Run& run, std::size_t count, std::span<const std::uint32_t> skipped) {
    const detail::Result& result = run.result;
    ThreadPool& pool = run.clipper.pool();
    std::vector<Piece> pieces(2 * std::size_t{pool.size()});
    const auto fill = [&](std::size_t begin, Piece& piece) {
        piece.lengths.clear();
        for (auto& bytes : piece.entries) bytes.clear();
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
            for_row_arrays([&](const auto& array, std::size_t number) {
                auto& bytes = piece.entries[number];
                if (number == Layout::indices)
                    put_ids(piece.row, layout_.narrow(), bytes);
                else if (array.per == Per::entry)
                    put_values(at, size, array.of(result).data(), layout_.bytes(number), bytes);
            });
        }
    };
    for (std::size_t begin = 0; begin < count; begin += pieces.size() * piece_cells) {
        const std::size_t filled = std::min(pieces.size(), ceil_div(count - begin, piece_cells));
        pool.run(filled, [&](std::size_t k, unsigned) { fill(begin + k * piece_cells, pieces[k]); });
        for (std::size_t k = 0; k < filled; ++k) {
            lengths_.append(std::span<const std::uint32_t>(pieces[k].lengths));
            entries_ += pieces[k].entries[Layout::indices].size() / layout_.bytes(Layout::indices);
            for_row_arrays([&](const auto& array, std::size_t number) {
                using Element = std::remove_cvref_t<decltype(array.of(result)[0])>;
                const auto append = [&]<class T>(T) {
                    const auto& bytes = pieces[k].entries[number];
                    of(number).append(std::span(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)));
                };
                if (number == Layout::indices && !layout_.narrow())
                    append(std::int64_t{});
                else
                    append(Element{});
            });
        }
    }
}

}  // namespace votess::stream
