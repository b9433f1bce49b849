#include "blocks/in_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>

#include "distributed/blocks/messages.hpp"
#include "input/settle.hpp"
#include "support/arrays.hpp"
namespace test {
namespace {

using namespace votess;

// Copies the values of cell i to a place among `size` cells.
void put_cell(BlockCells& to, std::size_t place, std::size_t size, const BlockCells& from, std::size_t i, bool planar) {
    for_row_arrays([&](const auto& array, std::size_t) {
        const auto& values = array.of(from);
        if (array.per != Per::cell || values.empty()) return;
        const std::size_t each = components_of(array, planar);
        auto& copies = array.of(to);
        typename std::remove_cvref_t<decltype(copies)>::value_type none{};  // of seeds outside
        if constexpr (std::is_floating_point_v<decltype(none)>)
            if (array.name == "centroids") none = NAN;
        if (copies.empty()) copies.resize(each * size, none);
        for (std::size_t k = 0; k < each; ++k) copies[each * place + k] = values[each * i + k];
    });
}

}  // namespace

InBlocks in_blocks(std::span<const double> given, const Options& options, std::size_t count) {
    const std::size_t each = options.planar ? 2 : 3, size = given.size() / each;
    std::vector<double> points(3 * size);
    for (std::size_t i = 0; i < given.size(); ++i) points[i / each * 3 + i % each] = given[i];
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Box bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (std::size_t i = 0; i < points.size(); ++i) {
        bounds.lower[i % 3] = std::min(bounds.lower[i % 3], points[i]);
        bounds.upper[i % 3] = std::max(bounds.upper[i % 3], points[i]);
    }
    const Settled whole = settle(options);
    BlockDomain domain(whole, bounds, size);
    const std::vector<CellStatus> status = domain.check(points, whole.weights);
    std::vector<std::size_t> inside;
    std::vector<double> kept;
    for (std::size_t i = 0; i < size; ++i) {
        if (status[i] == CellStatus::outside) continue;
        inside.push_back(i);
        kept.insert(kept.end(), &points[3 * i], &points[3 * i] + 3);
    }
    const std::vector<double> places = domain.places(kept);
    domain.split(places, count);
    const std::vector<std::uint32_t> of_seed = domain.blocks_of(places);
    std::vector<Seeds> own(count);
    for (std::size_t s = 0; s < inside.size(); ++s) {
        Seeds& to = own[of_seed[s]];
        const std::size_t i = inside[s];
        to.add(static_cast<std::int64_t>(i), points, {}, i);
        to.tags.push_back(static_cast<std::int32_t>(i % 1000));
        if (!options.weights.empty()) to.weights.push_back(options.weights[i]);
        if (!options.radii.empty()) to.weights.push_back(options.radii[i] * options.radii[i]);
    }
    std::deque<blocks::LocalBlock> all;
    std::vector<Message> outlines;
    Settled run = domain.of_blocks();
    run.want.neighbors = true;  // cells of blocks have rows
    for (const Seeds& seeds : own) {
        all.emplace_back(run, seeds);
        outlines.push_back(to_message(summary_of(all.back().outline()).tiles));
    }
    for (std::size_t b = 0; b < count; ++b) {
        std::vector<blocks::Outline> others(count);
        Seeds halo;
        for (std::size_t from = 0; from < count; ++from) {
            if (from == b) continue;
            others[from] = blocks::read_outline(outlines[from]);
            Seeds some;
            read_halo(to_message(all[from].halo_for(blocks::read_outline(outlines[b])), all[from].outline()), some,
                      others[from]);
            halo.add(some);
        }
        all[b].clip(std::move(others), b, std::move(halo));
    }
    InBlocks result;
    result.seeds = inside.size();
    std::vector<BlockCells> cells;
    std::vector<Message> far;
    std::vector<std::vector<Message>> replies_to(count);
    for (std::size_t b = 0; b < count; ++b) {
        std::vector<blocks::Requests> requests(count);
        for (std::size_t from = 0; from < count; ++from)
            read_message(to_message(all[from].requests()[b]), requests[from]);
        const std::vector<Seeds> replies = all[b].reply(requests);
        for (std::size_t to = 0; to < count; ++to) replies_to[to].push_back(to_message(replies[to]));
    }
    for (std::size_t b = 0; b < count; ++b) {
        all[b].complete(blocks::joined<Seeds>(replies_to[b]), domain);
        if (domain.endless()) far.push_back(to_message(all[b].far()));
    }
    for (blocks::LocalBlock& block : all) {
        cells.push_back(block.finish(blocks::joined<blocks::FarCells>(far), domain));
        const BlockCounts& counts = block.counts();
        result.counts.given += counts.given;
        result.counts.needed += counts.needed;
        result.counts.tested += counts.tested;
        result.counts.questions += counts.questions;
    }
    BlockCells& out = result.cells;
    out.status.assign(size, CellStatus::outside);
    out.duplicate_of.assign(size, -1);
    std::vector<std::pair<std::size_t, std::size_t>> where(size, {count, 0});
    for (std::size_t b = 0; b < count; ++b) {
        const BlockCells& from = cells[b];
        for (std::size_t i = 0; i < own[b].ids.size(); ++i) {
            const auto place = static_cast<std::size_t>(own[b].ids[i]);
            where[place] = {b, i};
            put_cell(out, place, size, from, i, options.planar);
        }
    }
    out.indptr.assign(1, 0);
    for (const auto& [b, i] : where) {
        if (b < count) {
            const BlockCells& from = cells[b];
            for (auto e = static_cast<std::size_t>(from.indptr[i]); e < static_cast<std::size_t>(from.indptr[i + 1]);
                 ++e) {
                const std::int64_t id = from.indices[e];
                if (from.owners[e] != (id < 0 ? -1 : id % 1000)) out.owners.push_back(from.owners[e]);  // wrong ones
                for_row_arrays([&](const auto& array, std::size_t) {
                    const auto& values = array.of(from);
                    if (array.per != Per::entry || values.empty()) return;
                    const auto n = static_cast<std::ptrdiff_t>(components_of(array, options.planar));
                    const auto at = values.begin() + n * static_cast<std::ptrdiff_t>(e);
                    array.of(out).insert(array.of(out).end(), at, at + n);
                });
            }
        }
        out.indptr.push_back(static_cast<std::int64_t>(out.indices.size()));
    }
    return result;
}

std::string difference(const InBlocks& found, const Tessellation& t) {
    const BlockCells& cells = found.cells;
    if (!cells.owners.empty()) return "a tag is another seed's";
    if (!std::ranges::equal(cells.status, t.status())) return "statuses differ";
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto begin = static_cast<std::size_t>(cells.indptr[i]),
                   end = static_cast<std::size_t>(cells.indptr[i + 1]);
        const auto row = std::span(cells.indices).subspan(begin, end - begin);
        const std::string cell = "cell " + std::to_string(i) + ": ";
        if (!std::ranges::equal(row, t.neighbors(i))) {
            std::string text = cell + "neighbors";
            for (const auto id : row) text += " " + std::to_string(id);
            text += " instead of";
            for (const auto id : t.neighbors(i)) text += " " + std::to_string(id);
            return text;
        }
    }
    if (found.seeds == 0) return "";
    for (std::size_t i = 0; i < t.size(); ++i)
        if (const std::string array = different_cell(cells, i, t, i); !array.empty())
            return "cell " + std::to_string(i) + ": " + array + " differs";
    return "";
}

}  // namespace test
