#include "blocks/in_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "blocks/partition.hpp"
#include "cpu/query/locator.hpp"
#include "input/options.hpp"

namespace test {
namespace {

using namespace votess;
using blocks::Block;
using blocks::BlockCells;
using blocks::Seeds;

// The options of a run that knows its domain, and whose seeds have weights of their own.
Options with_domain(const Job& job) {
    Options options = job.options;
    if (!options.cell) options.box = job.box;
    options.outside = Outside::error;
    options.weights = options.radii = {};
    return options;
}

template <class T>
void put(std::vector<T>& to, const std::vector<T>& from, std::size_t place, std::size_t i, std::size_t each = 1) {
    for (std::size_t k = 0; k < each && !from.empty(); ++k) to[each * place + k] = from[each * i + k];
}

}  // namespace

InBlocks in_blocks(std::span<const double> points, const Options& options, std::size_t count) {
    const Job job = validate({points, {}}, options);
    const Options of_blocks = with_domain(job);
    const std::size_t size = points.size() / 3;
    std::vector<exact::Point> places;
    std::vector<std::int64_t> ids;
    for (std::size_t i = 0; i < size; ++i) {
        if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;
        exact::Point x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = points[3 * i + k] * job.scale;
        places.push_back(cpu::place_in(*job.domain, x)->at);
        ids.push_back(static_cast<std::int64_t>(i));
    }
    const blocks::Partition partition(places, count);
    std::vector<Seeds> own(count);
    for (std::size_t s = 0; s < ids.size(); ++s) {
        Seeds& to = own[partition.block_of(places[s])];
        const auto i = static_cast<std::size_t>(ids[s]);
        to.ids.push_back(ids[s]);
        to.points.insert(to.points.end(), &points[3 * i], &points[3 * i] + 3);
        if (!options.weights.empty()) to.weights.push_back(options.weights[i]);
        if (!options.radii.empty()) to.weights.push_back(options.radii[i] * options.radii[i]);
    }
    std::deque<Block> all;
    std::vector<blocks::Outline> outlines;
    for (const Seeds& seeds : own) outlines.push_back(all.emplace_back(of_blocks, seeds).outline());
    for (std::size_t b = 0; b < count; ++b) {
        Seeds given;
        for (std::size_t from = 0; from < count; ++from)
            if (from != b) given.add(all[from].layer_for(outlines[b]));
        all[b].clip(outlines, b, std::move(given));
    }
    InBlocks result;
    result.seeds = ids.size();
    std::vector<BlockCells> cells;
    for (std::size_t b = 0; b < count; ++b) {
        Seeds answers;
        for (std::size_t to = 0; to < count; ++to)
            if (to != b) answers.add(all[to].answer(all[b].questions()[to]));
        cells.push_back(all[b].finish(answers));
        const blocks::BlockCounts& counts = all[b].counts();
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
        if (!from.volumes.empty()) out.volumes.resize(size);
        if (!from.centroids.empty()) out.centroids.resize(3 * size, NAN);
        if (!from.face_counts.empty()) out.face_counts.resize(size), out.edge_counts.resize(size);
        for (std::size_t i = 0; i < own[b].size(); ++i) {
            const auto place = static_cast<std::size_t>(own[b].ids[i]);
            where[place] = {b, i};
            out.status[place] = from.status[i];
            if (!from.duplicate_of.empty()) out.duplicate_of[place] = from.duplicate_of[i];
            put(out.volumes, from.volumes, place, i);
            put(out.centroids, from.centroids, place, i, 3);
            put(out.face_counts, from.face_counts, place, i);
            put(out.edge_counts, from.edge_counts, place, i);
        }
    }
    out.indptr.assign(1, 0);
    for (const auto& [b, i] : where) {
        if (b < count) {
            const BlockCells& from = cells[b];
            for (auto e = static_cast<std::size_t>(from.indptr[i]); e < static_cast<std::size_t>(from.indptr[i + 1]);
                 ++e) {
                out.indices.push_back(from.indices[e]);
                for (std::size_t k = 0; k < 3 && !from.shifts.empty(); ++k)
                    out.shifts.push_back(from.shifts[3 * e + k]);
                if (!from.areas.empty()) out.areas.push_back(from.areas[e]);
            }
        }
        out.indptr.push_back(static_cast<std::int64_t>(out.indices.size()));
    }
    return result;
}

std::string difference(const InBlocks& found, const Tessellation& t) {
    const BlockCells& cells = found.cells;
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
    if (!std::ranges::equal(cells.shifts, t.shifts())) return "shifts differ";
    if (found.seeds == 0) return "";
    if (!std::ranges::equal(cells.face_counts, t.face_counts())) return "counts of faces differ";
    if (!std::ranges::equal(cells.edge_counts, t.edge_counts())) return "counts of edges differ";
    for (std::size_t i = 0; i < t.size(); ++i) {
        const std::int64_t of = t.duplicate_of().empty() ? -1 : t.duplicate_of()[i];
        if (cells.duplicate_of[i] != of) return "duplicates differ";
        if (!cells.volumes.empty() && std::abs(cells.volumes[i] - t.volumes()[i]) > 2e-10 * t.volumes()[i])
            return "cell " + std::to_string(i) + ": the volume differs";
    }
    return "";
}

}  // namespace test
