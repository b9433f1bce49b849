#include "distributed/mpi/pack_cells.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace votess::mpi {
namespace {

// Calls visit(member, numbers in each) for the arrays of cells, or of entries of rows.
template <class Visit>
void for_cell_arrays(const Visit& visit) {
    visit(&BlockCells::status, 1);
    visit(&BlockCells::duplicate_of, 1);
    visit(&BlockCells::volumes, 1);
    visit(&BlockCells::centroids, 3);
    visit(&BlockCells::surface_areas, 1);
    visit(&BlockCells::security_radii, 1);
    visit(&BlockCells::face_counts, 1);
    visit(&BlockCells::edge_counts, 1);
    visit(&BlockCells::vertex_counts, 1);
}
template <class Visit>
void for_entry_arrays(const Visit& visit) {
    visit(&BlockCells::neighbors, 1);
    visit(&BlockCells::tags, 1);
    visit(&BlockCells::shifts, 3);
    visit(&BlockCells::areas, 1);
    visit(&BlockCells::normals, 3);
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
    for_cell_arrays([&](auto member, std::size_t) { reader.get(arrived.cells.*member); });
    for_entry_arrays([&](auto member, std::size_t) { reader.get(arrived.cells.*member); });
    reader.end();
    arrived.places.resize(arrived.ids.size());
    std::iota(arrived.places.begin(), arrived.places.end(), std::size_t{0});
    return arrived;
}

std::size_t begin_of(const BlockCells& cells, std::size_t i) {
    return static_cast<std::size_t>(cells.indptr[i]);
}

// The value for a seed that was dropped.
template <class T>
T none(std::vector<T> BlockCells::*) {
    return {};
}
CellStatus none(std::vector<CellStatus> BlockCells::*) {
    return CellStatus::outside;
}
std::int64_t none(std::vector<std::int64_t> BlockCells::*) {
    return -1;
}

}  // namespace

Message pack(const std::vector<std::int64_t>& ids, const BlockCells& cells, const std::vector<std::size_t>& places) {
    if (places.empty()) return {};
    std::vector<std::int64_t> some_ids, indptr{0};
    for (const std::size_t i : places) {
        some_ids.push_back(ids[i]);
        indptr.push_back(indptr.back() + cells.indptr[i + 1] - cells.indptr[i]);
    }
    const auto entries = static_cast<std::size_t>(indptr.back());
    std::size_t bytes = 0;
    const auto count = [&](std::size_t rows) {
        return [&bytes, &cells, rows](auto member, std::size_t each) {
            using Number = std::decay_t<decltype((cells.*member)[0])>;
            bytes += sizeof(std::uint64_t) + ((cells.*member).empty() ? 0 : each * rows * sizeof(Number));
        };
    };
    for_cell_arrays(count(places.size()));
    for_entry_arrays(count(entries));
    Writer writer;
    writer.reserve(bytes + sizeof(std::int64_t) * (some_ids.size() + indptr.size() + 2));
    writer.put(some_ids);
    writer.put(indptr);
    for_cell_arrays([&](auto member, std::size_t each) {
        const std::span values(cells.*member);
        writer.put(static_cast<std::uint64_t>(values.empty() ? 0 : each * places.size()));
        if (values.empty()) return;
        for (const std::size_t i : places) writer.append(values.subspan(each * i, each));
    });
    for_entry_arrays([&](auto member, std::size_t each) {
        const std::span values(cells.*member);
        writer.put(static_cast<std::uint64_t>(values.empty() ? 0 : each * entries));
        if (values.empty()) return;
        for (const std::size_t i : places)
            writer.append(
                values.subspan(each * begin_of(cells, i), each * (begin_of(cells, i + 1) - begin_of(cells, i))));
    });
    return writer.take();
}

BlockCells unpack(const std::vector<Message>& from, const std::vector<std::int64_t>& ids,
                  const std::vector<CellStatus>& status, const Want& want, SomeCells own) {
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
            throw Error(ErrorCode::internal, "a bug in votess: the cell of id " + std::to_string(ids[i]) + " was lost");
        const std::size_t length =
            source == nobody ? 0 : begin_of(all[source].cells, k + 1) - begin_of(all[source].cells, k);
        out.indptr.push_back(out.indptr.back() + static_cast<std::int64_t>(length));
    }
    // Array by array; each is freed after the copy.
    const auto is_anywhere = [&](auto member) {
        return std::ranges::any_of(all, [&](const SomeCells& one) { return !(one.cells.*member).empty(); });
    };
    const auto drop = [&](auto member) {
        for (SomeCells& one : all) one.cells.*member = {};
    };
    for_entry_arrays([&](auto member, std::size_t each) {
        if (!is_anywhere(member)) return;
        auto& to = out.*member;
        to.reserve(each * static_cast<std::size_t>(out.indptr.back()));
        for (const auto& [source, k] : where) {
            if (source == nobody) continue;
            const BlockCells& cells = all[source].cells;
            append(to, cells.*member, each * begin_of(cells, k), each * begin_of(cells, k + 1));
        }
        drop(member);
    });
    // A rank whose seeds were all dropped gets no cells, but all arrays.
    const auto is_wanted = [&](const void* array) {
        return array == &out.status || (want.volumes && array == &out.volumes) ||
               (want.centroids && array == &out.centroids) || (want.surfaces && array == &out.surface_areas) ||
               (want.radii && array == &out.security_radii) ||
               (want.counts && (array == &out.face_counts || array == &out.edge_counts || array == &out.vertex_counts));
    };
    for_cell_arrays([&](auto member, std::size_t each) {
        if (!is_anywhere(member) && !is_wanted(&(out.*member))) return;
        auto& to = out.*member;
        to.reserve(each * ids.size());
        for (const auto& [source, k] : where) {
            if (source == nobody || (all[source].cells.*member).empty())
                to.insert(to.end(), each, none(member));
            else
                append(to, all[source].cells.*member, each * k, each * (k + 1));
        }
        drop(member);
    });
    if (!out.centroids.empty())
        for (std::size_t i = 0; i < ids.size(); ++i)
            if (where[i].first == nobody)
                std::fill_n(out.centroids.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                            std::numeric_limits<double>::quiet_NaN());
    return out;
}

}  // namespace votess::mpi
