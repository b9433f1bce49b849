#include "distributed/stream/assembler.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/arithmetic.hpp"

namespace votess::stream {
namespace {

constexpr std::size_t widened_at_once = 65536;

}  // namespace

Assembler::Assembler(const Layout& layout, const StreamHead& head, const std::vector<std::vector<RowStore*>>& groups,
                     ThreadPool& pool, std::span<const std::int64_t> only)
    : layout_(layout), head_(head), pool_(pool), only_(only) {
    for (const auto& stores : groups) {
        std::vector<Part>& parts = groups_.emplace_back();
        for (RowStore* store : stores) {
            store->rewind();
            parts.push_back(
                {store, Cursor<std::int64_t>(store->ids()), Cursor<RowStore::Duplicate>(store->duplicates()), {}, {}});
        }
    }
}

template <class Task>
void Assembler::for_parts(const Task& task) {
    for (std::vector<Part>& parts : groups_) pool_.run(parts.size(), [&](std::size_t p, unsigned) { task(parts[p]); });
}

void Assembler::find(Part& part, std::uint64_t end) {
    part.places.clear();
    for (const std::int64_t* id = part.ids.peek(); id != nullptr && place(*id) < end;
         part.ids.pop(), id = part.ids.peek())
        part.places.push_back(static_cast<std::uint32_t>(place(*id) - first_));
    part.lengths.resize(layout_.rows() ? part.places.size() : 0);
    part.store->lengths().read(std::span(part.lengths));
    for (std::size_t k = 0; k < part.lengths.size(); ++k) indptr_[part.places[k] + 1] = part.lengths[k];
    for (const auto* one = part.duplicates.peek(); one != nullptr && place(one->id) < end;
         part.duplicates.pop(), one = part.duplicates.peek())
        duplicate_of_[place(one->id) - first_] = one->of;
}

void Assembler::take_cells(Part& part, std::size_t array) {
    const std::size_t each = layout_.bytes(array);
    std::vector<std::byte> some(each * part.places.size());
    part.store->of(array).read(std::span(some));
    std::byte* const to = arrays_[array].data();
    for (std::size_t k = 0; k < part.places.size(); ++k)
        std::memcpy(to + each * part.places[k], some.data() + each * k, each);
}

void Assembler::take_entries(Part& part, std::size_t array) {
    const std::size_t each = layout_.bytes(array);
    std::size_t count = 0;
    for (const std::uint32_t length : part.lengths) count += length;
    std::vector<std::byte> some(each * count);
    part.store->of(array).read(std::span(some));
    std::byte* const to = arrays_[array].data();
    const std::byte* from = some.data();
    for (std::size_t k = 0; k < part.places.size(); ++k) {
        const std::size_t size = each * part.lengths[k];
        if (size > 0) std::memcpy(to + each * static_cast<std::size_t>(indptr_[part.places[k]] - entries_), from, size);
        from += size;
    }
}

template <class T>
std::span<const T> Assembler::as(std::size_t array) const {
    const auto& bytes = arrays_[array];
    return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

StreamRows Assembler::next(std::size_t max_cells) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(max_cells, head_.seeds - first_));
    indptr_.assign(count + 1, 0);
    duplicate_of_.assign(head_.duplicates ? count : 0, -1);
    for_parts([&](Part& part) { find(part, first_ + count); });
    indptr_[0] = entries_;
    for (std::size_t i = 0; i < count; ++i) indptr_[i + 1] += indptr_[i];
    const auto entries = static_cast<std::size_t>(indptr_[count] - entries_);

    StreamRows rows;
    rows.first = first_;
    for_row_arrays([&](const auto& array, std::size_t number) {
        const std::size_t each = layout_.bytes(number);
        if (each == 0) return;
        auto& bytes = arrays_[number];
        auto& out = array.of(rows);
        using Element = std::remove_cvref_t<decltype(out[0])>;
        if (array.per == Per::entry) {
            bytes.resize(each * entries);
            for_parts([&](Part& part) { take_entries(part, number); });
        } else {
            // Seeds in no block were dropped and have no cell.
            const bool is_status = number == Layout::status;
            bytes.assign(each * count, is_status ? static_cast<std::byte>(CellStatus::outside) : std::byte{0});
            if (array.name == "centroids")
                std::fill_n(reinterpret_cast<double*>(bytes.data()), bytes.size() / sizeof(double),
                            std::numeric_limits<double>::quiet_NaN());
            for_parts([&](Part& part) { take_cells(part, number); });
            if (const std::uint32_t of_faces = Layout::of_faces(number); of_faces > 0) {
                const auto faces = as<std::uint32_t>(detail::number_of("face_counts"));
                auto* const lacking = reinterpret_cast<std::uint32_t*>(bytes.data());
                for (std::size_t i = 0; i < count; ++i) lacking[i] = of_faces * faces[i] - lacking[i];
            }
        }
        out = as<Element>(number);
    });
    rows.duplicate_of = duplicate_of_;
    if (layout_.rows()) rows.indptr = indptr_;
    if (layout_.rows() && layout_.narrow()) {
        indices_.resize(entries);
        const auto narrow = as<std::int32_t>(Layout::indices);
        pool_.run(ceil_div(entries, widened_at_once), [&](std::size_t task, unsigned) {
            const std::size_t begin = task * widened_at_once, end = std::min(entries, begin + widened_at_once);
            std::copy(narrow.begin() + static_cast<std::ptrdiff_t>(begin),
                      narrow.begin() + static_cast<std::ptrdiff_t>(end),
                      indices_.begin() + static_cast<std::ptrdiff_t>(begin));
        });
        rows.indices = indices_;
    }
    entries_ += static_cast<std::int64_t>(entries);
    first_ += count;
    return rows;
}

}  // namespace votess::stream
