#include "verify/reported_cell.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "input/settle.hpp"
#include "polytope/cell_shape.hpp"
#include "verify/brute_force.hpp"

namespace votess {
namespace {

// The job of some seeds, and cells that are clipped by them.
class Clipper {
public:
    Clipper(const Settled& run, const Seeds& seeds) : job_(make_job(with_seeds(run, seeds))), brute_force_(job_) {}

    // Returns whether the cell is empty. index: of its seed; or another seed, in the user's lengths.
    bool clip(std::size_t index) {
        brute_force_.clip(index, cell);
        return is_empty();
    }
    bool clip(const double* point, double weight) {
        brute_force_.clip({point[0] * scale(), point[1] * scale(), point[2] * scale()}, weight * scale() * scale(),
                          cell);
        return is_empty();
    }
    [[nodiscard]] const cpu::CellPlane& plane(std::size_t face) const {
        return cell.planes()[static_cast<std::size_t>(faces.planes[face])];
    }
    [[nodiscard]] double scale() const { return job_.scale; }
    [[nodiscard]] double work() const { return brute_force_.work(); }

    cpu::Cell cell;
    cpu::CellFaces faces;

private:
    static Settled with_seeds(Settled run, const Seeds& seeds) {
        run.points = {seeds.points, {}};
        run.weights = {seeds.weights};
        return run;
    }
    bool is_empty() {
        constexpr std::size_t min_faces = 4;  // with fewer a cell has no interior
        cell.canonical_faces(faces);
        return cell.empty() || faces.size() < min_faces;
    }

    Job job_;
    BruteForce brute_force_;
};

// By cell: whether the seeds of the block bury it, else how many have faces; then those seeds, cell after cell.
struct Reply {
    std::vector<std::uint8_t> empty;
    std::vector<std::uint64_t> counts;
    Seeds seeds;

    [[nodiscard]] Message message() const { return message_of(empty, counts, seeds); }
    static Reply of(const Message& message, std::size_t cells) {
        Reply reply;
        read_message(message, reply.empty, reply.counts, reply.seeds);
        if (reply.counts.size() != cells || reply.empty.size() != cells)
            bug("a reply is about other cells than the request");
        return reply;
    }
};

std::string row_difference(const ReportedCell& reported, std::vector<ReportedFace>& found, double allowed) {
    const std::vector<ReportedFace>& row = *reported.row;
    const std::string lists =
                          "seed " + std::to_string(reported.id) + " lists " + std::to_string(row.size()) + " neighbors",
                      by = std::to_string(found.size()) + " found by trying every seed";
    std::ranges::sort(found, std::less<>());
    std::size_t matched = 0;
    for (const ReportedFace& face : found) {
        const auto entry = std::ranges::lower_bound(row, face, std::less<>());
        if (entry == row.end() || face < *entry)
            return lists + ", without " + std::to_string(face.id) + ", which is one of the " + by;
        ++matched;
        if (reported.has_areas && entry->area != face.area &&
            !(std::abs(entry->area - face.area) <= allowed + smallest_double))
            return "the face of cell " + std::to_string(reported.id) + " with " + std::to_string(face.id) +
                   " has area " + number(entry->area) + ", trying every seed gives " + number(face.area);
    }
    return matched == row.size() ? std::string() : lists + " that differ from the " + by;
}

// ids: of the seeds that clipped the cell.
std::string difference(const CheckedRun& run, const ReportedCell& reported, bool empty,
                       std::span<const std::int64_t> ids, const Clipper& clipped) {
    if (empty != reported.empty)
        return "seed " + std::to_string(reported.id) + " is reported to have " +
               (reported.empty ? "no cell" : "a cell") + ", trying every seed leaves " +
               (reported.empty ? "one" : "none");
    if (empty) return {};
    for (std::size_t f = 0; f < clipped.faces.size(); ++f)
        if (run.ends.any() && run.ends.has(clipped.plane(f).id)) return {};
    constexpr double least_volume = 1e-250;  // smaller ones have digits in their own unit only
    double unscale = 1 / clipped.scale();
    std::vector<double> areas;
    cpu::CellGeometry geometry = clipped.cell.measure(clipped.faces, &areas);
    if (!(geometry.volume > least_volume)) {
        std::vector<std::uint32_t> ranks(clipped.faces.size());
        std::iota(ranks.begin(), ranks.end(), 0u);
        cpu::CellMeasures measures;
        cpu::measure_exactly(clipped.cell, clipped.faces, ranks, measures, areas);
        geometry.volume = measures.volume;
        unscale = std::ldexp(unscale, measures.exponent);
    }
    const MeasureUnit unit(unscale, run.settled.region.thickness);
    const double tolerance = run.tolerance.cell + double_tolerance.cell;  // both are rounded
    if (reported.row) {
        std::vector<ReportedFace> row;
        double surface = 0;
        for (std::size_t f = 0; f < clipped.faces.size(); ++f) {
            const cpu::CellPlane& plane = clipped.plane(f);
            const double area = unit.area(areas[f]);
            if (!run.planar || !Sheet::bounds(plane.id)) surface += area;
            if (!run.lists(plane.id)) continue;
            ReportedFace& face = row.emplace_back();
            face.id = plane.id < 0 ? plane.id : ids[static_cast<std::size_t>(plane.id)];
            face.area = area;
            for (std::size_t k = 0; k < 3; ++k) face.shift[k] = static_cast<std::int8_t>(plane.shift[k]);
        }
        if (auto text = row_difference(reported, row, tolerance * surface); !text.empty()) return text;
    }
    if (!reported.volume) return {};
    const double volume = unit.volume(geometry.volume);
    if (volume == *reported.volume ||  // both may be infinite
        std::abs(volume - *reported.volume) <= tolerance * volume + smallest_double)
        return {};
    return "cell " + std::to_string(reported.id) + " has volume " + number(*reported.volume) +
           ", trying every seed gives " + number(volume);
}

}  // namespace

std::vector<Message> clip_by_block(const CheckedRun& run, const Seeds& block, std::span<const Message> requests,
                                   double& work) {
    Clipper clipper(run.settled, block);
    std::vector<Message> replies;
    std::vector<std::size_t> own;
    for (const Message& request : requests) {
        Seeds cells;
        read_message(request, cells);
        Reply reply;
        for (std::size_t c = 0; c < cells.size(); ++c) {
            const std::size_t place = place_of(cells.ids[c], block.ids);
            const bool empty = place < block.size()
                                   ? clipper.clip(place)
                                   : clipper.clip(&cells.points[3 * c], cells.weights.empty() ? 0 : cells.weights[c]);
            own.clear();
            for (std::size_t f = 0; f < clipper.faces.size() && !empty; ++f)
                if (const std::int32_t id = clipper.plane(f).id; id >= 0 && static_cast<std::size_t>(id) < block.size())
                    own.push_back(static_cast<std::size_t>(id));
            std::ranges::sort(own);
            own.erase(std::ranges::unique(own).begin(), own.end());
            for (const std::size_t i : own) reply.seeds.add(block, i);
            reply.empty.push_back(empty ? 1 : 0);
            reply.counts.push_back(own.size());
        }
        replies.push_back(reply.message());
    }
    work += clipper.work();
    return replies;
}

Fault first_difference(const CheckedRun& run, std::span<const ReportedCell> cells, const Seeds& seeds,
                       std::span<const Message> replies) {
    std::vector<Seeds> around(cells.size());
    std::vector<bool> buried(cells.size());
    for (const Message& message : replies) {
        const Reply reply = Reply::of(message, cells.size());
        std::size_t at = 0;
        for (std::size_t c = 0; c < cells.size(); ++c) {
            if (reply.empty[c] != 0) buried[c] = true;
            for (std::uint64_t k = 0; k < reply.counts[c]; ++k) around[c].add(reply.seeds, at++);
        }
    }
    Fault first;
    for (std::size_t c = 0; c < cells.size(); ++c) {
        around[c].add(seeds, c);
        const Seeds all = around[c].sorted();
        Clipper clipper(run.settled, all);
        const bool empty = buried[c] || clipper.clip(place_of(cells[c].id, all.ids));
        auto text = difference(run, cells[c], empty, all.ids, clipper);
        if (!text.empty()) first.merge({cells[c].id, std::move(text)});
    }
    return first;
}

}  // namespace votess
