#include "distributed/mpi/pack_cells.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <type_traits>
#include <utility>

#include "core/errors.hpp"
#include "result/arrays.hpp"

namespace votess::mpi {
namespace {

constexpr auto owners_of = [](auto& cells) -> auto& {
    return cells.owners;
};

// Calls visit(array) for all arrays of cells, or of entries of rows.
template <class Visit>
void for_arrays(Per per, const Visit& visit) {
    for_row_arrays([&](const auto& array, std::size_t) {
        if (array.per == per) visit(array);
    });
    if (per == Per::entry) visit(ArrayInfo{"owners", owners_of, per, 1, nullptr, ""});
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from, std::size_t begin, std::size_t end) {
    to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(begin),
              from.begin() + static_cast<std::ptrdiff_t>(end));
}

SomeCells read(const Message& message) {
    SomeCells arrived;
    Reader reader(message);
    reader.get(arrived.ids);
    reader.get(arrived.cells.indptr);
    for (const Per per : {Per::cell, Per::entry})
        for_arrays(per, [&](const auto& array) { reader.get(array.of(arrived.cells)); });
    reader.end();
    arrived.places.resize(arrived.ids.size());
    std::iota(arrived.places.begin(), arrived.places.end(), std::size_t{0});
    return arrived;
}

std::size_t begin_of(const BlockCells& cells, std::size_t i) {
    return static_cast<std::size_t>(cells.indptr[i]);
}

// Returns the value of a seed that was dropped.
template <class T>
T none() {
    if constexpr (std::is_same_v<T, CellStatus>)
        return CellStatus::outside;
    else
        return std::is_same_v<T, std::int64_t> ? T(-1) : T{};  // duplicate_of
}

}  // namespace

Message pack(const std::vector<std::int64_t>& ids, const BlockCells& cells, const std::vector<std::size_t>& places,
             bool planar) {
    if (places.empty()) return {};
    std::vector<std::int64_t> some_ids, indptr{0};
    for (const std::size_t i : places) {
        some_ids.push_back(ids[i]);
        indptr.push_back(indptr.back() + cells.indptr[i + 1] - cells.indptr[i]);
    }
    const auto entries = static_cast<std::size_t>(indptr.back());
    std::size_t bytes = 0;
    const auto size_of = [&](const auto& array) {
        return array.of(cells).empty()
                   ? 0
                   : components_of(array, planar) * (array.per == Per::cell ? places.size() : entries);
    };
    for (const Per per : {Per::cell, Per::entry})
        for_arrays(per, [&](const auto& array) {
            bytes += sizeof(std::uint64_t) + size_of(array) * sizeof(array.of(cells)[0]);
        });
    Writer writer;
    writer.reserve(bytes + sizeof(std::int64_t) * (some_ids.size() + indptr.size() + 2));
    writer.put(some_ids);
    writer.put(indptr);
    for (const Per per : {Per::cell, Per::entry})
        for_arrays(per, [&](const auto& array) {
            const std::span values(array.of(cells));
            writer.put(static_cast<std::uint64_t>(size_of(array)));
            if (values.empty()) return;
            for (const std::size_t i : places) {
                const std::size_t first = per == Per::cell ? i : begin_of(cells, i),
                                  end = per == Per::cell ? i + 1 : begin_of(cells, i + 1);
                const std::size_t each = components_of(array, planar);
                writer.append(values.subspan(each * first, each * (end - first)));
            }
        });
    return writer.take();
}

BlockCells unpack(const std::vector<Message>& from, const std::vector<std::int64_t>& ids,
                  const std::vector<CellStatus>& status, const Settled& whole, SomeCells own) {
    std::vector<std::pair<std::int64_t, std::size_t>> place_of;
    place_of.reserve(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) place_of.emplace_back(ids[i], i);
    if (!std::ranges::is_sorted(ids)) std::ranges::sort(place_of);
    std::vector<SomeCells> all;
    if (!own.places.empty()) all.push_back(std::move(own));
    for (const Message& message : from)
        if (!message.empty()) all.push_back(read(message));
    constexpr auto nobody = std::numeric_limits<std::size_t>::max();
    std::vector<std::pair<std::size_t, std::size_t>> where(ids.size(), {nobody, 0});
    for (std::size_t source = 0; source < all.size(); ++source)
        for (const std::size_t k : all[source].places) {
            const auto found = std::ranges::lower_bound(place_of, std::pair{all[source].ids[k], std::size_t{0}});
            where[found->second] = {source, k};
        }
    place_of = {};
    BlockCells out;
    out.indptr.reserve(ids.size() + 1);
    out.indptr.push_back(0);
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const auto& [source, k] = where[i];
        if (source == nobody && status[i] != CellStatus::outside)
            bug("the cell of id " + std::to_string(ids[i]) + " was lost");
        const std::size_t length =
            source == nobody ? 0 : begin_of(all[source].cells, k + 1) - begin_of(all[source].cells, k);
        out.indptr.push_back(out.indptr.back() + static_cast<std::int64_t>(length));
    }
    // Array by array; each is freed after the copy.
    const auto is_anywhere = [&](const auto& array) {
        return std::ranges::any_of(all, [&](const SomeCells& one) { return !array.of(one.cells).empty(); });
    };
    const auto drop = [&](const auto& array) {
        for (SomeCells& one : all) array.of(one.cells) = {};
    };
    for_arrays(Per::entry, [&](const auto& array) {
        if (!is_anywhere(array)) return;
        auto& to = array.of(out);
        const std::size_t each = components_of(array, whole.region.planar);
        to.reserve(each * static_cast<std::size_t>(out.indptr.back()));
        for (const auto& [source, k] : where) {
            if (source == nobody) continue;
            const BlockCells& cells = all[source].cells;
            append(to, array.of(cells), each * begin_of(cells, k), each * begin_of(cells, k + 1));
        }
        drop(array);
    });
    // A rank whose seeds were all dropped gets no cells, but all arrays.
    for_arrays(Per::cell, [&](const auto& array) {
        auto& to = array.of(out);
        const bool always = static_cast<const void*>(&to) == &out.status;
        if (!always && !is_anywhere(array) && (array.word == nullptr || !(whole.want.*array.word))) return;
        const std::size_t each = components_of(array, whole.region.planar);
        to.reserve(each * ids.size());
        for (const auto& [source, k] : where) {
            if (source == nobody || array.of(all[source].cells).empty())
                to.insert(to.end(), each, none<std::decay_t<decltype(to[0])>>());
            else
                append(to, array.of(all[source].cells), each * k, each * (k + 1));
        }
        drop(array);
    });
    const std::size_t dimensions = whole.region.planar ? 2 : 3;
    if (!out.centroids.empty())
        for (std::size_t i = 0; i < ids.size(); ++i)
            if (where[i].first == nobody)
                std::fill_n(out.centroids.begin() + static_cast<std::ptrdiff_t>(dimensions * i), dimensions,
                            std::numeric_limits<double>::quiet_NaN());
    return out;
}

}  // namespace votess::mpi
