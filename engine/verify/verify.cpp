// verify() of a whole result: its rows go through the RowChecker in pieces, and its polygons are compared.
#include <algorithm>
#include <cmath>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "input/domain_of_result.hpp"
#include "plane/sheet.hpp"
#include "result/rows.hpp"
#include "solid/mesh_cells.hpp"
#include "unbounded/endless_box.hpp"
#include "verify/row_checker.hpp"
#include "votess/pieces.hpp"

namespace votess {
namespace {

using detail::Result;

constexpr std::size_t rows_at_once = std::size_t{1} << 16;
constexpr std::size_t rows_per_stop = 1024;  // after which the user may stop

std::size_t at(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

class WholeResult : public RunBlocks {
public:
    WholeResult(const Result& result, std::span<const double> points)
        : r_(result), points_(points.begin(), points.end()) {}  // read once, see input/snapshot.hpp

    bool for_rows(const Visit& visit) override {
        std::vector<std::int64_t> ids;
        for (std::size_t begin = 0; begin < r_.status.size(); begin += rows_at_once) {
            const std::size_t size = std::min(rows_at_once, r_.status.size() - begin);
            StreamRows rows;
            rows.first = begin;
            std::size_t first = 0, entries = 0;
            if (!r_.indptr.empty()) {
                first = at(r_.indptr[begin]), entries = at(r_.indptr[begin + size]) - first;
                rows.indptr = std::span<const std::int64_t>(r_.indptr).subspan(begin, size + 1);
                ids.assign(r_.indices.data() + first, r_.indices.data() + first + entries);
                rows.indices = ids;
            }
            detail::for_row_arrays([&](const auto& array, std::size_t) {
                const auto& all = array.of(r_);
                if constexpr (std::is_assignable_v<decltype(array.of(rows)), decltype(std::span(all.data(), 1))>) {
                    const bool of_cell = array.per == detail::Per::cell;
                    if (!all.empty())
                        array.of(rows) = std::span(all.data(), all.size())
                                             .subspan(array.components * (of_cell ? begin : first),
                                                      array.components * (of_cell ? size : entries));
                }
            });
            visit(rows, {});
        }
        return true;
    }

    void for_blocks(const std::function<void(Seeds)>& task) override {
        Seeds seeds;
        for (std::size_t i = 0; i < r_.status.size(); ++i)
            if (takes_part(r_.status[i])) seeds.add(static_cast<std::int64_t>(i), points_, r_.weights, i);
        task(std::move(seeds));
    }

private:
    const Result& r_;
    std::vector<double> points_;
};

std::span<const std::int32_t> polygon(const Result& r, std::size_t entry) {
    const std::span<const std::int32_t> all = r.face_vertices;
    return all.subspan(at(r.face_offsets[entry]), at(r.face_offsets[entry + 1] - r.face_offsets[entry]));
}

// Whether each edge occurs twice, in opposite directions. edges: scratch.
bool is_watertight(const Result& r, const Rows& rows, std::size_t i, std::vector<std::uint64_t>& edges) {
    edges.clear();
    for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
        const auto corners = polygon(r, entry);
        if (corners.size() < 3) return false;
        for (std::size_t k = 0; k < corners.size(); ++k)
            edges.push_back(static_cast<std::uint64_t>(corners[k]) << 32 |
                            static_cast<std::uint32_t>(corners[k + 1 == corners.size() ? 0 : k + 1]));
    }
    std::ranges::sort(edges);
    return std::ranges::adjacent_find(edges) == edges.end() && std::ranges::all_of(edges, [&](std::uint64_t edge) {
               return std::ranges::binary_search(edges, edge << 32 | edge >> 32);
           });
}

// Whether both have the same vertices, or images of them, in opposite order.
bool same_polygon(const Result& r, std::size_t entry, std::size_t other) {
    const auto original = [&](std::int32_t v) { return r.vertex_image_of.empty() ? v : r.vertex_image_of[at(v)]; };
    const auto here = polygon(r, entry), there = polygon(r, other);
    if (here.size() != there.size()) return false;
    for (std::size_t turn = 0; turn < here.size(); ++turn) {
        std::size_t k = 0;
        while (k < here.size() && original(here[k]) == original(there[(turn + here.size() - k) % here.size()])) ++k;
        if (k == here.size()) return true;
    }
    return false;
}

// The rows are symmetric.
std::string check_polygons(const Result& r) {
    const Rows rows{r.indptr, r.indices, r.shifts};
    std::vector<std::uint64_t> edges;
    for (std::size_t i = 0; i < r.status.size(); ++i) {
        if (i % rows_per_stop == 0) check_stop();
        if (!is_watertight(r, rows, i, edges)) return "cell " + std::to_string(i) + " is not watertight";
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
            const FaceLabel label = rows.label(entry);
            if (label.id < static_cast<std::int32_t>(i)) continue;
            if (!same_polygon(r, entry, rows.find(at(label.id), label.seen_from_behind(i))))
                return "cells " + std::to_string(i) + " and " + std::to_string(label.id) +
                       " have different polygons between them";
        }
    }
    return {};
}

}  // namespace

std::uint64_t count_tiny_faces(const Tessellation& t, std::span<const double> points) {
    require_whole_diagram(t, "count_tiny_faces");
    require_points(t, points, "count_tiny_faces");
    if (t.stats().tiny_faces) return *t.stats().tiny_faces;
    Options options = domain_options(t);
    if (EndlessSides(options.box).any()) options.box = near_box({points, {}}, *options.box);
    options.weights = t.weights();
    options.device = "cpu";
    options.want = {};
    options.want.neighbors = false;
    return tessellate(points, options).stats().tiny_faces.value();
}

namespace {

// mean: of all cells; the tolerance is relative to it, or to the cell where it is infinite.
bool nearly_equal(double volume, double expected, double tolerance, double mean) {
    return volume == expected ||
           std::abs(volume - expected) <= tolerance * (std::isfinite(mean) ? mean : std::abs(expected));
}

// Checks the cells of the plane by the prisms of a sheet, which are verified.
VerifyReport verify_plane(const Tessellation& t, std::span<const double> points, const VerifyOptions& how) {
    require_points(t, points, "verify");
    Options options = domain_options(t);
    options.weights = t.weights();
    options.list_walls = t.lists_walls();
    options.min_area = t.least_face();
    options.device = "cpu";
    options.want = {.neighbors = true, .volumes = true, .counts = true};
    const std::vector<double> copy(points.begin(), points.end());  // read once, see input/snapshot.hpp
    const Sheet sheet({copy, {}}, options);
    const std::span<const double> places = sheet.points().f64;
    const Tessellation prisms = tessellate(places, sheet.options());
    VerifyReport report = verify(prisms, places, how);
    const auto fail = [&](std::size_t i, const char* what) {
        report.passed = false;
        report.failure = "cell " + std::to_string(i) + " has other " + what + " than in a second run";
    };
    const double tolerance = t.stats().precision == Precision::single ? 1e-4 : 1e-9;
    const double mean = t.stats().box_volume / static_cast<double>(std::max<std::size_t>(t.size(), 1));
    std::vector<std::int32_t> row;
    for (std::size_t i = 0; i < t.size() && report.passed; ++i) {
        row.clear();
        for (const std::int32_t j : prisms.neighbors(i))
            if (!Sheet::bounds(j)) row.push_back(j);
        const std::uint32_t faces = prisms.face_counts()[i], edges = faces == 0 ? 0 : faces - 2;
        const double area = prisms.volumes()[i] / sheet.thickness();
        if (t.status()[i] != prisms.status()[i]) fail(i, "status");
        if (!t.indices().empty() && !std::ranges::equal(t.neighbors(i), row)) fail(i, "neighbors");
        if (!t.volumes().empty() && !nearly_equal(t.volumes()[i], area, tolerance, mean)) fail(i, "area");
        if (!t.face_counts().empty() && t.face_counts()[i] != edges) fail(i, "numbers of edges");
    }
    return report;
}

// Checks the cells of a domain without end by those of a box that holds all vertices, whose own cells are verified.
VerifyReport verify_endless(const Tessellation& t, std::span<const double> points, const VerifyOptions& how) {
    const std::vector<double> copy(points.begin(), points.end());  // read once, see input/snapshot.hpp
    const EndlessSides sides(t.box());
    Options options = domain_options(t);
    options.box = far_box({copy, {}}, t.weights(), t.box());
    options.weights = t.weights();
    options.list_walls = true;
    options.device = "cpu";
    options.want = {.neighbors = true, .volumes = true, .counts = true};
    const Tessellation far = tessellate(std::span<const double>(copy), options);
    VerifyReport report = verify(far, copy, how);
    report.tiny_faces = count_tiny_faces(t, copy);
    const double tolerance = t.stats().precision == Precision::single ? single_tolerance.sum : double_tolerance.sum;
    std::vector<std::int32_t> row;
    for (std::size_t i = 0; i < t.size() && report.passed; ++i) {
        const auto fail = [&](const char* what) {
            report.passed = false;
            report.failure = "cell " + std::to_string(i) + " has other " + what + " than in a box that ends far away";
        };
        row.clear();
        bool open = false;
        for (const std::int32_t id : far.neighbors(i)) {
            open = open || sides.has(id);
            if (!sides.has(id) && (id >= 0 || t.lists_walls())) row.push_back(id);
        }
        if (open && t.lists_walls()) row.insert(std::ranges::upper_bound(row, sides.id()), sides.id());
        if (t.status()[i] != far.status()[i]) fail("status");
        if (!t.indptr().empty() && !std::ranges::equal(t.neighbors(i), row)) fail("neighbors");
        if (t.volumes().empty()) continue;
        if (!nearly_equal(t.volumes()[i], open ? infinity : far.volumes()[i], tolerance, infinity)) fail("volume");
    }
    return report;
}

// Checks the parts of cells in a mesh. The whole cells are verified and cut again, and the pieces have the volumes.
VerifyReport verify_in_mesh(const Tessellation& t, std::span<const double> points, const VerifyOptions& how,
                            const solid::MeshCells& cells) {
    if (t.is_subset()) require_whole_diagram(t, "verify");
    require_points(t, points, "verify");
    const std::vector<double> copy(points.begin(), points.end());  // read once, see input/snapshot.hpp
    Options options = domain_options(t);
    options.weights = t.weights();
    options.device = "cpu";
    options.want = {.neighbors = true, .volumes = true, .counts = true};
    VerifyReport report = verify(tessellate(std::span<const double>(copy), options), copy, how);
    report.tiny_faces.reset();
    std::vector<double> vertices;
    std::vector<std::int32_t> triangles;
    for (std::size_t v = 0; v < cells.mesh.vertices(); ++v)
        for (const double x : cells.mesh.vertex(static_cast<std::int32_t>(v))) vertices.push_back(x / cells.scale);
    for (const auto& triangle : cells.mesh.given()) triangles.insert(triangles.end(), triangle.begin(), triangle.end());
    options.mesh = TriangleMesh{vertices, triangles};
    options.outside = Outside::error;
    options.want = {.neighbors = true, .volumes = true};
    const Tessellation again = tessellate(std::span<const double>(copy), options);
    const Pieces parts = pieces(t);
    const double tolerance = t.stats().precision == Precision::single ? single_tolerance.sum : double_tolerance.sum;
    const double mean = t.stats().box_volume / static_cast<double>(std::max<std::size_t>(t.size(), 1));
    double sum = 0;
    for (std::size_t i = 0; i < t.size() && report.passed; ++i) {
        const auto fail = [&](const std::string& what) {
            report.passed = false;
            report.failure = "cell " + std::to_string(i) + " in the mesh has " + what;
        };
        const auto entries = [&](const Tessellation& of) {
            const std::size_t first = at(of.indptr()[i]), count = at(of.indptr()[i + 1]) - first;
            return of.shifts().empty() ? of.shifts() : of.shifts().subspan(3 * first, 3 * count);
        };
        if (t.status()[i] != again.status()[i]) fail("another status than in a second run");
        if (!t.indptr().empty() && (!std::ranges::equal(t.neighbors(i), again.neighbors(i)) ||
                                    !std::ranges::equal(entries(t), entries(again))))
            fail("other neighbors than in a second run");
        if (t.volumes().empty()) continue;
        double of_pieces = 0;
        for (auto p = at(parts.indptr[i]); p < at(parts.indptr[i + 1]); ++p) of_pieces += parts.volumes[p];
        sum += t.volumes()[i];
        if (!nearly_equal(t.volumes()[i], again.volumes()[i], tolerance, mean))
            fail("another volume than in a second run");
        if (!nearly_equal(t.volumes()[i], of_pieces, tolerance, mean)) fail("another volume than its pieces");
    }
    if (report.passed && !t.volumes().empty() && !nearly_equal(sum, t.stats().box_volume, tolerance, infinity)) {
        report.passed = false;
        report.failure = "volumes sum to " + number(sum) + ", the mesh has " + number(t.stats().box_volume);
    }
    return report;
}

}  // namespace

VerifyReport verify(const Tessellation& t, std::span<const double> points, const VerifyOptions& options) {
    if (t.in_mesh()) return verify_in_mesh(t, points, options, *t.result_->mesh_cells);
    if (t.planar() && !t.is_subset()) return verify_plane(t, points, options);
    require_whole_diagram(t, "verify");
    require_points(t, points, "verify");
    if (EndlessSides(t.box()).any()) return verify_endless(t, points, options);
    const Result& result = *t.result_;
    const bool single = t.stats().precision == Precision::single;
    CheckedRun run{domain_options(t), t.size(), t.stats().box_volume, t.least_face(),
                   single ? single_tolerance : double_tolerance};
    run.options.list_walls = t.lists_walls();
    const bool periodic = t.periodic() != std::array<bool, 3>{};
    RowChecker::Sample sample{options.sample.value_or(sample_size(t.size(), 1, periodic)), options.rng_seed};
    if (options.sample) sample.budget = std::numeric_limits<double>::infinity();
    WholeResult whole(result, points);
    RowChecker checker(std::move(run), sample, whole);
    whole.for_rows([&](const StreamRows& rows, const RowNames& names) { checker.take(rows, names); });
    VerifyReport report = checker.report();
    if (report.passed && !result.face_offsets.empty() && result.least_face == 0) {
        report.failure = check_polygons(result);
        report.passed = report.failure.empty();
    }
    report.tiny_faces = count_tiny_faces(t, points);
    return report;
}

}  // namespace votess
