// verify() of a whole result: its rows go through the RowChecker in pieces, and its polygons are compared.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/vector3.hpp"
#include "input/domain_of_result.hpp"
#include "plane/sheet.hpp"
#include "result/handle.hpp"
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
    if (t.size() == 0) return 0;
    Options options = domain_options(t);
    if (EndlessSides(options.box).any()) options.box = near_box({points, {}}, t.weights(), *options.box);
    options.weights = t.weights();
    options.device = "cpu";
    options.want = {};
    options.want.neighbors = false;
    return tessellate(points, options).stats().tiny_faces.value();
}

namespace {

// scale: of the tolerance. Infinite: the expected value itself is.
bool nearly_equal(double value, double expected, double tolerance, double scale) {
    return value == expected ||
           (std::isfinite(expected) &&
            std::abs(value - expected) <= tolerance * (std::isfinite(scale) ? scale : std::abs(expected)));
}

double tolerance_of(const Tessellation& t) {
    return t.stats().precision == Precision::single ? single_tolerance.sum : double_tolerance.sum;
}

// A row as a second run makes it. Arrays that it lacks are empty.
struct ExpectedRow {
    std::size_t components = 3;  // of shifts and normals
    std::vector<std::int32_t> ids;
    std::vector<std::int8_t> shifts;
    std::vector<double> areas, area_scales, normals;

    void clear() {
        for (auto* values : {&areas, &area_scales, &normals}) values->clear();
        ids.clear();
        shifts.clear();
    }
    // Adds an entry without its area.
    void add(const Tessellation& from, std::size_t entry) {
        ids.push_back(from.indices()[entry]);
        for (std::size_t k = 0; k < components; ++k) {
            if (!from.shifts().empty()) shifts.push_back(from.shifts()[3 * entry + k]);
            if (!from.face_normals().empty()) normals.push_back(from.face_normals()[3 * entry + k]);
        }
    }
    void add_area(double area, double scale) {
        areas.push_back(area);
        area_scales.push_back(scale);
    }
    // Returns which array of row i of a result differs, "" for none.
    [[nodiscard]] const char* difference(const Tessellation& t, std::size_t i) const {
        if (t.indptr().empty()) return "";
        const std::size_t begin = at(t.indptr()[i]), size = ids.size();
        if (!std::ranges::equal(t.neighbors(i), ids)) return "neighbors";
        if (!t.shifts().empty() &&
            !std::ranges::equal(t.shifts().subspan(components * begin, components * size), shifts))
            return "shifts";
        const double tolerance = tolerance_of(t);
        for (std::size_t k = 0; k < size && !t.face_areas().empty(); ++k)
            if (!nearly_equal(t.face_areas()[begin + k], areas[k], tolerance, area_scales[k])) return "areas of faces";
        for (std::size_t k = 0; k < components * size && !t.face_normals().empty(); ++k) {
            const double normal = t.face_normals()[components * begin + k];
            if (!nearly_equal(normal, normals[k], tolerance, 1) && !(std::isnan(normal) && std::isnan(normals[k])))
                return "normals of faces";
        }
        return "";
    }
};

// Checks the cells of the plane by the prisms of a sheet, which are verified.
VerifyReport verify_plane(const Tessellation& t, std::span<const double> points, const VerifyOptions& how) {
    require_points(t, points, "verify");
    Options options = domain_options(t);
    options.weights = t.weights();
    options.list_walls = t.lists_walls();
    options.min_area = t.least_face();
    options.device = "cpu";
    options.want = {.neighbors = true, .volumes = true, .counts = true, .areas = true, .normals = true};
    const std::vector<double> copy(points.begin(), points.end());  // read once, see input/snapshot.hpp
    const Sheet sheet({copy, {}}, options);
    const std::span<const double> places = sheet.points().f64;
    const Tessellation prisms = tessellate(places, sheet.options());
    VerifyReport report = verify(prisms, places, how);
    const auto fail = [&](std::size_t i, const char* what) {
        report.passed = false;
        report.failure = "cell " + std::to_string(i) + " has other " + what + " than in a second run";
    };
    const double tolerance = tolerance_of(t);
    const double mean = t.stats().box_volume / static_cast<double>(std::max<std::size_t>(t.size(), 1));
    ExpectedRow row;
    row.components = 2;
    for (std::size_t i = 0; i < t.size() && report.passed; ++i) {
        row.clear();
        double perimeter = 0;
        for (auto e = at(prisms.indptr()[i]); e < at(prisms.indptr()[i + 1]); ++e) {
            if (Sheet::bounds(prisms.indices()[e])) continue;
            row.add(prisms, e);
            perimeter += prisms.face_areas()[e] / sheet.thickness();
            row.add_area(prisms.face_areas()[e] / sheet.thickness(), 0);
        }
        std::ranges::fill(row.area_scales, perimeter);
        const std::uint32_t faces = prisms.face_counts()[i], edges = faces == 0 ? 0 : faces - 2;
        const double area = prisms.volumes()[i] / sheet.thickness();
        if (t.status()[i] != prisms.status()[i]) fail(i, "status");
        if (const char* what = row.difference(t, i); *what != 0) fail(i, what);
        if (!t.volumes().empty() && !nearly_equal(t.volumes()[i], area, tolerance, mean)) fail(i, "area");
        if (!t.face_counts().empty() &&
            std::array{t.face_counts()[i], t.edge_counts()[i], t.vertex_counts()[i]} != std::array{edges, edges, edges})
            fail(i, "numbers of edges");
    }
    return report;
}

// What a cell of a far box has on the walls at infinity.
class AtInfinity {
public:
    AtInfinity(const Tessellation& far, const EndlessSides& sides, std::size_t i) {
        for (auto e = at(far.indptr()[i]); e < at(far.indptr()[i + 1]); ++e) {
            if (!sides.has(far.indices()[e])) continue;
            any_ = true;
            if (far.face_offsets().empty()) continue;
            const std::span polygon = corners(far, e);
            for (std::size_t k = 0; k < polygon.size(); ++k) {
                const auto [a, b] = std::minmax(polygon[k], polygon[k + 1 == polygon.size() ? 0 : k + 1]);
                edges_.emplace_back(a, b);
                vertices_.push_back(polygon[k]);
            }
        }
        const auto sort = [](auto& values) {
            std::ranges::sort(values);
            values.erase(std::ranges::unique(values).begin(), values.end());
        };
        sort(edges_);
        sort(vertices_);
    }

    [[nodiscard]] bool any() const { return any_; }
    [[nodiscard]] std::size_t edges() const { return edges_.size(); }
    [[nodiscard]] std::size_t vertices() const { return vertices_.size(); }
    [[nodiscard]] bool has(std::int32_t vertex) const { return std::ranges::binary_search(vertices_, vertex); }
    [[nodiscard]] static std::span<const std::int32_t> corners(const Tessellation& t, std::size_t entry) {
        const std::size_t begin = at(t.face_offsets()[entry]), end = at(t.face_offsets()[entry + 1]);
        return t.face_vertices().subspan(begin, end - begin);
    }

private:
    bool any_ = false;
    std::vector<std::pair<std::int32_t, std::int32_t>> edges_;
    std::vector<std::int32_t> vertices_;
};

// Adds the area of a face of a far box, measured from its corners.
void add_area_of(const Tessellation& far, std::size_t entry, const AtInfinity& infinite, const double* seed,
                 ExpectedRow& row) {
    std::array<double, 3> doubled{};
    std::vector<std::array<double, 3>> places;
    double square = 0;  // of the largest distance from the seed, with which positions and areas are rounded
    for (const std::int32_t v : AtInfinity::corners(far, entry)) {
        if (infinite.has(v)) return row.add_area(infinity, 0);
        auto& place = places.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) place[k] = far.vertices()[3 * at(v) + k] - seed[k];
        square = std::max(square, dot(place, place));
    }
    for (std::size_t k = 1; k + 1 < places.size(); ++k) {
        const auto part = cross(minus(places[k], places[0]), minus(places[k + 1], places[0]));
        for (std::size_t c = 0; c < 3; ++c) doubled[c] += part[c];
    }
    row.add_area(0.5 * length3(doubled[0], doubled[1], doubled[2]), square);
}

// Checks the cells of a domain without end by those of a box that holds all vertices, whose own cells are verified.
VerifyReport verify_endless(const Tessellation& t, std::span<const double> points, const VerifyOptions& how) {
    const std::vector<double> copy(points.begin(), points.end());  // read once, see input/snapshot.hpp
    const EndlessSides sides(t.box());
    const bool counts = !t.face_counts().empty(), areas = !t.face_areas().empty();
    Options options = domain_options(t);
    options.box = far_box({copy, {}}, t.weights(), t.box());
    options.weights = t.weights();
    options.list_walls = true;
    options.device = "cpu";
    options.want = {.neighbors = true,
                    .volumes = true,
                    .counts = true,
                    .normals = !t.face_normals().empty(),
                    .faces = counts || areas};
    const Tessellation far = tessellate(std::span<const double>(copy), options);
    VerifyReport report = verify(far, copy, how);
    report.tiny_faces = count_tiny_faces(t, copy);
    const double tolerance = tolerance_of(t);
    ExpectedRow row;
    for (std::size_t i = 0; i < t.size() && report.passed; ++i) {
        const auto fail = [&](const char* what) {
            report.passed = false;
            report.failure = "cell " + std::to_string(i) + " has other " + what + " than in a box that ends far away";
        };
        row.clear();
        const AtInfinity infinite(far, sides, i);
        bool listed = !infinite.any() || !t.lists_walls();
        const auto add_infinity = [&] {
            row.ids.push_back(sides.id());
            row.add_area(infinity, 0);
            row.normals.insert(row.normals.end(), 3, std::numeric_limits<double>::quiet_NaN());
            listed = true;
        };
        for (auto e = at(far.indptr()[i]); e < at(far.indptr()[i + 1]); ++e) {
            const std::int32_t id = far.indices()[e];
            if (!listed && id >= sides.id()) add_infinity();
            if (sides.has(id) || (id < 0 && !t.lists_walls())) continue;
            row.add(far, e);
            if (areas) add_area_of(far, e, infinite, &copy[3 * i], row);
        }
        if (!listed) add_infinity();
        if (t.status()[i] != far.status()[i]) fail("status");
        if (const char* what = row.difference(t, i); *what != 0) fail(what);
        if (!t.volumes().empty() &&
            !nearly_equal(t.volumes()[i], infinite.any() ? infinity : far.volumes()[i], tolerance, infinity))
            fail("volume");
        if (!counts) continue;
        std::uint32_t faces = infinite.any() ? 1 : 0;
        for (const std::int32_t id : far.neighbors(i)) faces += sides.has(id) ? 0 : 1;
        if (t.face_counts()[i] != faces || t.edge_counts()[i] != far.edge_counts()[i] - infinite.edges() ||
            t.vertex_counts()[i] != far.vertex_counts()[i] - infinite.vertices())
            fail("numbers of faces, edges or vertices");
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
    const double tolerance = tolerance_of(t);
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
    if (t.size() == 0 && points.empty() && !t.is_subset() && !t.probed()) {
        VerifyReport nothing;
        nothing.passed = true;
        nothing.tiny_faces = 0;
        return nothing;
    }
    if (t.in_mesh()) return verify_in_mesh(t, points, options, *detail::result_of(t.result_).mesh_cells);
    if (t.planar() && !t.is_subset()) return verify_plane(t, points, options);
    require_whole_diagram(t, "verify");
    require_points(t, points, "verify");
    if (EndlessSides(t.box()).any()) return verify_endless(t, points, options);
    const Result& result = detail::result_of(t.result_);
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
