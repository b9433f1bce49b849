// verify() of a whole result: its rows go through the RowChecker in pieces, and its polygons are compared.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "core/buffer.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/vector3.hpp"
#include "input/domain_of_result.hpp"
#include "input/settle.hpp"
#include "input/supports.hpp"
#include "plane/sheet.hpp"
#include "result/handle.hpp"
#include "result/rows.hpp"
#include "solid/mesh_cells.hpp"
#include "unbounded/endless_box.hpp"
#include "verify/certificate.hpp"
#include "verify/row_checker.hpp"
#include "verify/same_arrays.hpp"
#include "votess/pieces.hpp"

namespace votess {
namespace {

using detail::Result;

constexpr std::size_t rows_at_once = std::size_t{1} << 14;
constexpr std::size_t rows_per_stop = 1024;  // after which the user may stop

// Returns a second run for the same rows.
Settled second_run(const Tessellation& t, const Result& result, std::span<const double> points) {
    Settled run = run_of(t, points);
    if (!result.is_subset) return run;
    run.subset.emplace(result.ids.begin(), result.ids.end());
    const auto& all = *result.all_seeds;
    run.weights.given.assign(all.weights.begin(), all.weights.end());
    if (std::ranges::find(all.status, CellStatus::outside) != all.status.end()) run.region.outside = Outside::drop;
    return run;
}

// Throws invalid_argument unless there is a row of coordinates for each seed.
void require_points_of(const Tessellation& t, const Result& result, std::span<const double> points) {
    if (!result.is_subset) return require_points(t, points, "verify");
    const std::size_t dimensions = t.planar() ? 2 : 3, count = result.all_seeds->count;
    if (points.size() != dimensions * count)
        refuse("verify(): points hold " + std::to_string(points.size()) +
               " coordinates, the run of some of the cells had " + std::to_string(count) + " points");
}

class WholeResult : public RunBlocks {
public:
    WholeResult(const Result& result, std::span<const double> points)
        : r_(result), names_(result.ids.begin(), result.ids.end()) {
        points_.resize_uninitialized(points.size());
        std::ranges::copy(points, points_.begin());  // read once, see input/snapshot.hpp
    }

    [[nodiscard]] std::span<const double> points() const { return points_; }

    bool for_rows(const Visit& visit) override {
        std::vector<std::int64_t> ids;
        for (std::size_t begin = 0; begin < r_.status.size(); begin += rows_at_once) {
            check_stop();
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
            for_row_arrays([&](const auto& array, std::size_t) {
                const auto& all = array.of(r_);
                if constexpr (std::is_assignable_v<decltype(array.of(rows)), decltype(std::span(all.data(), 1))>) {
                    const bool of_cell = array.per == Per::cell;
                    if (!all.empty())
                        array.of(rows) = std::span(all.data(), all.size())
                                             .subspan(array.components * (of_cell ? begin : first),
                                                      array.components * (of_cell ? size : entries));
                }
            });
            RowNames names;
            if (r_.is_subset) names.ids = std::span<const std::int64_t>(names_).subspan(begin, size);
            visit(rows, names);
        }
        return true;
    }

    void for_blocks(const std::function<void(Seeds)>& task) override {
        Seeds seeds;
        std::span<const double> weights = r_.weights;
        std::span<const CellStatus> status = r_.status;
        if (r_.is_subset) weights = r_.all_seeds->weights, status = r_.all_seeds->status;
        for (std::size_t i = 0; i < points_.size() / 3; ++i)
            if (status.empty() || takes_part(status[i])) seeds.add(static_cast<std::int64_t>(i), points_, weights, i);
        task(std::move(seeds));
    }

private:
    const Result& r_;
    Buffer<double> points_{Buffer<double>::Pages::huge};  // accessed at random
    std::vector<std::int64_t> names_;                     // of the rows of a subset
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
    std::optional<Subset> subset;
    if (r.is_subset) subset.emplace(std::vector<std::int32_t>(r.ids.begin(), r.ids.end()));
    std::vector<std::uint64_t> edges;
    for (std::size_t row = 0; row < r.status.size(); ++row) {
        if (row % rows_per_stop == 0) check_stop();
        const std::int32_t i = subset ? subset->ids()[row] : static_cast<std::int32_t>(row);
        if (!is_watertight(r, rows, row, edges)) return "cell " + std::to_string(i) + " is not watertight";
        for (std::size_t entry = rows.begin(row); entry < rows.end(row); ++entry) {
            const FaceLabel label = rows.label(entry);
            if (label.id < i) continue;
            const std::int32_t other = subset ? subset->row_of(label.id) : label.id;
            if (other < 0) continue;
            if (!same_polygon(r, entry, rows.find(at(other), label.seen_from_behind(at(i)))))
                return "cells " + std::to_string(i) + " and " + std::to_string(label.id) +
                       " have different polygons between them";
        }
    }
    return {};
}

}  // namespace

std::uint64_t count_tiny_faces(const Tessellation& t, std::span<const double> points) {
    require(t, "count_tiny_faces");
    require_points(t, points, "count_tiny_faces");
    if (t.stats().tiny_faces) return *t.stats().tiny_faces;
    if (t.size() == 0) return 0;
    const std::vector<double> copy(points.begin(), points.end());  // read once, see input/snapshot.hpp
    Settled run = run_of(t, copy);
    if (EndlessSides(run.region).any()) end_near(run.region, run.points);
    run.want.neighbors = false;
    return tessellate(std::move(run)).stats().tiny_faces.value();
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

// Returns the seed of a row.
std::size_t seed_of(const Tessellation& t, std::size_t row) {
    return t.is_subset() ? at(t.ids()[row]) : row;
}

// Checks the cells of the plane by the prisms of a sheet, which are verified.
VerifyReport verify_plane(const Tessellation& t, Settled second, const VerifyOptions& how) {
    second.list_walls = t.lists_walls();
    second.want = {.neighbors = true, .volumes = true, .counts = true, .areas = true, .normals = true};
    const Sheet sheet(std::move(second));
    const Tessellation prisms = tessellate(sheet.in_space());
    VerifyReport report = verify(prisms, sheet.in_space().points.f64, how);
    const auto fail = [&](std::size_t i, const char* what) {
        report.passed = false;
        report.failure = "cell " + std::to_string(seed_of(t, i)) + " has other " + what + " than in a second run";
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
            perimeter += prisms.face_areas()[e];
            row.add_area(prisms.face_areas()[e], 0);
        }
        std::ranges::fill(row.area_scales, perimeter);
        const std::uint32_t faces = prisms.face_counts()[i], edges = faces == 0 ? 0 : faces - 2;
        if (t.status()[i] != prisms.status()[i]) fail(i, "status");
        if (const char* what = row.difference(t, i); *what != 0) fail(i, what);
        if (!t.volumes().empty() && !nearly_equal(t.volumes()[i], prisms.volumes()[i], tolerance, mean))
            fail(i, "area");
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

// Adds the area of a face of a far box, measured from its corners, in lengths of a power of two.
void add_area_of(const Tessellation& far, std::size_t entry, const AtInfinity& infinite, const double* seed,
                 ExpectedRow& row) {
    std::vector<std::array<double, 3>> places;
    double largest = 0, longest = 0;  // coordinate of a corner, with which it is rounded; of one from the seed
    for (const std::int32_t v : AtInfinity::corners(far, entry)) {
        if (infinite.has(v)) return row.add_area(infinity, 0);
        auto& place = places.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = far.vertices()[3 * at(v) + k];
            place[k] = x - seed[k];
            largest = std::max(largest, std::abs(x));
            longest = std::max(longest, std::abs(place[k]));
        }
    }
    constexpr int largest_exponent = 1020;  // its inverse is a number too
    const double unit = power_of_two(-std::clamp(exponent_above(longest), -largest_exponent, largest_exponent));
    std::array<double, 3> doubled{};
    double square = 0;  // of the largest distance from the seed, with which areas are rounded
    for (auto& place : places) {
        for (double& x : place) x *= unit;
        square = std::max(square, dot(place, place));
    }
    for (std::size_t k = 1; k + 1 < places.size(); ++k) {
        const auto part = cross(minus(places[k], places[0]), minus(places[k + 1], places[0]));
        for (std::size_t c = 0; c < 3; ++c) doubled[c] += part[c];
    }
    const MeasureUnit in_units(1 / unit, detail::result_of(far).thickness);
    const double scale = in_units.area(square + 0x1p-48 / double_tolerance.cell * largest * unit * std::sqrt(square));
    row.add_area(in_units.area(0.5 * length3(doubled[0], doubled[1], doubled[2])),
                 std::min(scale, std::numeric_limits<double>::max()));
}

VerifyReport verify_cells(const Tessellation& t, const Result& result, Settled second, const VerifyOptions& options,
                          const Certificate::Endless& endless = {});

// Whether rows of cells that have an end are as long as in the far box.
bool same_closed_rows(const Tessellation& t, const Tessellation& far, const EndlessSides& sides) {
    for (std::size_t i = 0; i < t.size() && !t.indptr().empty(); ++i) {
        std::size_t listed = 0;
        bool closed = true;
        for (const std::int32_t id : far.neighbors(i)) {
            closed = closed && !sides.has(id);
            listed += id >= 0 || t.lists_walls() ? 1 : 0;
        }
        if (closed && t.neighbors(i).size() != listed) return false;
    }
    return !t.indptr().empty();
}

// Whether the far box lists all neighbors of a nearer one, whose rows are proven: condition 3 of the certificate. There
// the polytopes of the far rows lie within proven cells, which overlap nowhere.
bool lists_those_near(const Tessellation& far, Settled near, const VerifyOptions& how) {
    const std::span<const double> points = near.points.f64;
    end_near(near.region, near.points, near.weights);
    near.list_walls = false;
    near.want = {.neighbors = true, .volumes = false};
    const Tessellation t = tessellate(std::move(near));
    if (!std::ranges::equal(t.status(), far.status()) || !verify(t, points, how).proven) return false;
    const Rows rows{t.indptr(), t.indices(), t.shifts()}, all{far.indptr(), far.indices(), far.shifts()};
    for (std::size_t i = 0; i < t.size(); ++i)
        for (std::size_t e = rows.begin(i); e < rows.end(i); ++e)
            if (all.find(i, rows.label(e)) == all.end(i)) return false;
    return true;
}

// Checks the cells of a domain without end by those of a box that holds all vertices, whose own cells are verified.
VerifyReport verify_endless(const Tessellation& t, Settled second, const VerifyOptions& how) {
    const std::span<const double> points = second.points.f64;
    const EndlessSides sides(second.region);
    const bool counts = !t.face_counts().empty(), areas = !t.face_areas().empty();
    const Settled given = second;
    end_far(second.region, second.points, second.weights);
    second.list_walls = true;
    second.want = {.neighbors = true,
                   .volumes = true,
                   .counts = true,
                   .normals = !t.face_normals().empty(),
                   .faces = counts || areas};
    const Tessellation far = tessellate(std::move(second));
    const std::vector<double> places = wrapped_points(far, points);
    const Result &result = detail::result_of(t), &of_far = detail::result_of(far);
    Certificate::Endless endless{t.is_subset() ? nullptr : &result, &sides};
    const auto check = [&] { return verify_cells(far, of_far, second_run(far, of_far, points), how, endless); };
    if (!same_closed_rows(t, far, sides)) endless.numbers = nullptr;
    VerifyReport report = check();
    if (report.passed && report.unproven == Certificate::no_volume && lists_those_near(far, given, how)) {
        endless.covered_once = true;
        report = check();
    }
    const bool compared = report.proven && endless.numbers != nullptr;
    if (!t.is_subset()) report.tiny_faces = count_tiny_faces(t, points);
    const double tolerance = tolerance_of(t);
    ExpectedRow row;
    for (std::size_t i = 0; i < t.size() && report.passed; ++i) {
        const auto fail = [&](const char* what) {
            report.passed = false;
            report.failure =
                "cell " + std::to_string(seed_of(t, i)) + " has other " + what + " than in a box that ends far away";
        };
        row.clear();
        const AtInfinity infinite(far, sides, i);
        bool listed = !infinite.any() || !t.lists_walls();
        const auto add_infinity = [&] {
            row.ids.push_back(sides.id());
            row.add_area(infinity, 0);
            if (!t.shifts().empty()) row.shifts.insert(row.shifts.end(), 3, 0);
            row.normals.insert(row.normals.end(), 3, std::numeric_limits<double>::quiet_NaN());
            listed = true;
        };
        for (auto e = at(far.indptr()[i]); e < at(far.indptr()[i + 1]); ++e) {
            const std::int32_t id = far.indices()[e];
            if (!listed && id >= sides.id()) add_infinity();
            if (sides.has(id) || (id < 0 && !t.lists_walls())) continue;
            row.add(far, e);
            if (areas) add_area_of(far, e, infinite, &places[3 * seed_of(t, i)], row);
        }
        if (!listed) add_infinity();
        if (t.status()[i] != far.status()[i]) fail("status");
        if (const char* what = row.difference(t, i); *what != 0) fail(what);
        // A volume of the far box may underflow.
        if (!t.volumes().empty() && (infinite.any() || !compared) &&
            !nearly_equal(t.volumes()[i], infinite.any() ? infinity : far.volumes()[i], tolerance, infinity) &&
            (infinite.any() || std::isnormal(far.volumes()[i])))
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

// Checks the parts of cells in a mesh. The whole cells are verified, and the pieces have the volumes. verify() compares
// the parts with those of a second run.
VerifyReport verify_in_mesh(const Tessellation& t, Settled second, const VerifyOptions& how) {
    second.want = {.neighbors = true, .volumes = true, .counts = true};
    VerifyReport report = verify(tessellate(second), second.points.f64, how);
    report.unproven = report.proven
                          ? "the whole cells are proven, and their parts in the mesh equal those of a second run"
                          : "a mesh cuts the cells, and " + report.unproven;
    report.proven = false;
    report.tiny_faces.reset();
    const Pieces parts = pieces(t);
    const double tolerance = tolerance_of(t);
    const double mean = t.stats().box_volume / static_cast<double>(std::max<std::size_t>(t.size(), 1));
    double sum = 0;
    for (std::size_t i = 0; i < t.size() && report.passed && !t.volumes().empty(); ++i) {
        double of_pieces = 0;
        for (auto p = at(parts.indptr[i]); p < at(parts.indptr[i + 1]); ++p) of_pieces += parts.volumes[p];
        sum += t.volumes()[i];
        if (nearly_equal(t.volumes()[i], of_pieces, tolerance, mean)) continue;
        report.passed = false;
        report.failure = "cell " + std::to_string(seed_of(t, i)) + " in the mesh has another volume than its pieces";
    }
    if (report.passed && !t.volumes().empty() && !t.is_subset() &&
        !nearly_equal(sum, t.stats().box_volume, tolerance, infinity)) {
        report.passed = false;
        report.failure = "volumes sum to " + number(sum) + ", the mesh has " + number(t.stats().box_volume);
    }
    return report;
}

// Tries to prove the cells from polygons. A refused input counts as not proven: other checks come first.
std::optional<Certificate::Verdict> prove_shared(const CheckedRun& run, const Settled& second, const Result& result,
                                                 const Certificate::Endless& endless) {
    if (result.face_offsets.empty()) return {};
    try {
        const Job job = make_job(second);
        return Certificate(run, job, result, endless).prove_shared();
    } catch (const Error& error) {
        if (error.code() != ErrorCode::invalid_argument) throw;
        return {};
    }
}

// Checks the cells of a box or a triclinic box.
VerifyReport verify_cells(const Tessellation& t, const Result& result, Settled second, const VerifyOptions& options,
                          const Certificate::Endless& endless) {
    const std::span<const double> points = second.points.f64;
    const bool single = t.stats().precision == Precision::single;
    second.list_walls = t.lists_walls();
    CheckedRun run{second, points.size() / 3, t.stats().box_volume, single ? single_tolerance : double_tolerance};
    if (second.subset) run.only = *second.subset;
    std::ranges::sort(run.only);
    run.settled.subset.reset();
    run.settled.weights = {};
    const bool periodic = t.periodic() != std::array<bool, 3>{};
    RowChecker::Sample sample{options.sample.value_or(sample_size(points.size() / 3, 1, periodic)), options.rng_seed};
    if (options.sample) sample.budget = infinity;
    WholeResult whole(result, points);
    const auto check = [&](const RowChecker::Sample& cells) {
        RowChecker checker(run, cells, whole);
        whole.for_rows([&](const StreamRows& rows, const RowNames& names) { checker.take(rows, names); });
        return checker.report();
    };
    const auto check_polygons_too = [&](VerifyReport& report) {
        if (!report.passed || result.face_offsets.empty()) return;
        report.failure = check_polygons(result);
        report.passed = report.failure.empty();
    };
    if (options.sample || t.is_subset()) {
        if (!options.sample) sample = {t.size(), options.rng_seed, infinity};
        VerifyReport report = check(sample);
        report.proven = !options.sample;
        if (options.sample) report.unproven = sample_was_given;
        check_polygons_too(report);
        return report;
    }
    RowChecker::Sample one{0, options.rng_seed, infinity};
    second.points = {whole.points(), {}};
    if (const auto verdict = prove_shared(run, second, result, endless)) {
        one.rows_are_proven = true;
        VerifyReport report = check(one);
        report.proven = report.passed;
        if (report.proven) report.tiny_faces = verdict->tiny_faces;
        return report;
    }
    VerifyReport report = check(one);
    if (!report.passed) return report;
    const Job job = make_job(std::move(second));
    const Certificate::Verdict verdict = Certificate(run, job, result, endless).prove();
    report.proven = verdict.proven;
    if (report.proven) {
        report.tiny_faces = verdict.tiny_faces;
        return report;
    }
    // All seeds clip the cell in question.
    one.max_cells = 1;
    one.cell = verdict.fault.text.empty() ? verdict.unsettled.id : verdict.fault.id;
    report = check(one);
    if (!report.passed) return report;
    if (verdict.fault.text.empty()) report = check(sample);
    report.unproven = verdict.unsettled.text;
    check_polygons_too(report);
    if (report.passed && !verdict.fault.text.empty()) {
        report.passed = false;
        report.failure = verdict.fault.text;
    }
    return report;
}

// Whether verify() compares a result with a run of all cells: one without small faces or rows, and one of more seeds
// than it takes the time of such a run to try.
bool needs_whole_run(const Tessellation& t, const VerifyOptions& options) {
    constexpr std::size_t tests = 3000;  // a seed: of the same time as a run of lists and its proof
    if (t.least_face() > 0) return true;
    if (options.sample) return false;
    const bool periodic = t.periodic() != std::array<bool, 3>{};
    return t.indptr().empty() || (t.is_subset() && t.size() * tests_of_seed(periodic) > tests);
}

// Verifies a run of all cells and faces, and compares.
VerifyReport verify_by_whole(const Tessellation& t, const Result& result, Settled second, const VerifyOptions& how) {
    const Points points = second.points;
    second.subset.reset();
    second.list_walls = t.lists_walls();
    second.want = {.neighbors = true, .volumes = false, .areas = t.least_face() > 0, .radii = true};
    detail::for_arrays([&](const auto& array) {
        if (array.word != nullptr && !array.of(result).empty()) second.want.*array.word = true;
    });
    const Tessellation whole = tessellate(std::move(second));
    VerifyReport report = verify(whole, points.f64, how);
    if (!report.passed) {
        report.failure = "in a run of all cells: " + report.failure;
        return report;
    }
    report.failure = difference_from_whole(result, detail::result_of(whole), tolerance_of(t));
    report.passed = report.failure.empty();
    if (t.is_subset() || t.stats().tiny_faces) report.tiny_faces = t.stats().tiny_faces;
    return report;
}

}  // namespace

VerifyReport verify(const Tessellation& t, std::span<const double> points, const VerifyOptions& options) {
    if (t.size() == 0 && points.empty() && !t.is_subset() && !t.probed()) {
        VerifyReport nothing;
        nothing.passed = nothing.proven = true;
        nothing.tiny_faces = 0;
        return nothing;
    }
    require(t, "verify");
    const Result& result = detail::result_of(t);
    require_points_of(t, result, points);
    VerifyReport report;
    report.failure = malformed(result);
    report.passed = report.failure.empty();
    if (!report.passed) return report;
    Settled second = second_run(t, result, points);
    std::vector<double> copy;  // read once, see input/snapshot.hpp; verify_cells() makes its own
    const bool by_whole = !t.in_mesh() && needs_whole_run(t, options);
    const bool in_box = !t.in_mesh() && !t.planar() && !EndlessSides(second.region).any() && !by_whole;
    if (!in_box) {
        copy.assign(points.begin(), points.end());
        second.points = {copy, {}};
    }
    Settled again = second;
    if (t.in_mesh())
        report = verify_in_mesh(t, std::move(second), options);
    else if (by_whole)
        report = verify_by_whole(t, result, std::move(second), options);
    else if (t.planar())
        report = verify_plane(t, std::move(second), options);
    else if (EndlessSides(second.region).any())
        report = verify_endless(t, std::move(second), options);
    else {
        report = verify_cells(t, result, std::move(second), options);
        if (t.stats().tiny_faces) report.tiny_faces = t.stats().tiny_faces;
        if (!t.is_subset() && !report.tiny_faces) report.tiny_faces = count_tiny_faces(t, points);
    }
    report.proven &= report.passed;
    // Certificates compare all numbers, vertices by polygons; other checks compare rows, volumes and areas.
    const bool compared = by_whole ? result.dropped_offsets.empty()
                                   : in_box && report.proven && !t.is_subset() &&
                                         (result.vertices.empty() || !result.face_offsets.empty());
    if (report.passed && (t.in_mesh() || (!compared && !options.sample))) {
        std::optional<solid::MeshArrays> mesh;
        std::optional<Rings> rings;
        if (t.in_mesh()) {
            again.region.mesh = mesh.emplace(result.mesh_cells->mesh, result.mesh_cells->scale).view();
            if (t.planar()) again.region.mesh = rings.emplace(*again.region.mesh).view();
            again.region.outside = Outside::error;
        }
        report.failure = difference_from_second_run(result, std::move(again), tolerance_of(t));
        report.passed = report.failure.empty();
        report.proven &= report.passed;
    }
    if (report.proven || !report.passed) report.unproven.clear();
    return report;
}

}  // namespace votess
