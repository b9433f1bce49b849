// Domains without end: boxes with infinite bounds.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <votess/diagram.hpp>
#include <votess/stream.hpp>

#include "exact/insphere.hpp"
#include "input/settle.hpp"
#include "oracle/exact_polygons.hpp"
#include "oracle/half_spaces.hpp"
#include "support/arrays.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"
#include "unbounded/endless_box.hpp"

namespace {

using test::Coordinates;
using test::has;
using test::text;
using votess::Options;

constexpr double inf = std::numeric_limits<double>::infinity();
const votess::Box no_ends = test::cube(-inf, inf);
Options in_box(const votess::Box& box) {
    Options options;
    options.box = box;
    return options;
}
// Returns a box that ends far away, beyond all vertices of these tests.
votess::Box far_away(const Coordinates& points) {
    double largest = 1e-300;
    for (const double x : points) largest = std::max(largest, std::abs(x));
    const double end = std::ldexp(largest, 240);
    return test::cube(-end, end);
}

Options endless_options(const votess::Box& box = no_ends) {
    Options options = test::all_options(box);
    options.want.surfaces = options.want.radii = true;
    return options;
}

// Returns the ids with the walls of `box` that are without end as one.
std::vector<std::int32_t> with_one_infinity(std::span<const std::int32_t> row, const votess::Box& box) {
    const votess::EndlessSides sides(votess::region_of(in_box(box)));
    std::vector<std::int32_t> out;
    for (const std::int32_t id : row) {
        out.push_back(sides.has(id) ? sides.id() : id);
        std::ranges::sort(out);
        out.erase(std::ranges::unique(out).begin(), out.end());
    }
    return out;
}

// Compares with rational arithmetic in a box that ends far away.
std::string check_cells(const votess::Tessellation& t, const Coordinates& points, Options options) {
    const votess::Box box = *options.box;
    const votess::EndlessSides sides(votess::region_of(in_box(box)));
    const votess::Box far = far_away(points);
    for (std::size_t k = 0; k < 3; ++k) {
        if (sides.has(-1 - 2 * static_cast<int>(k))) options.box->lower[k] = far.lower[k];
        if (sides.has(-2 - 2 * static_cast<int>(k))) options.box->upper[k] = far.upper[k];
    }
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (t.status()[i] == votess::CellStatus::duplicate) continue;
        const auto exact = test::exact_cell(points, options, i);
        std::vector<std::int32_t> row;
        bool open = false;
        for (const auto& face : exact.faces) {
            row.push_back(face.id);
            open = open || sides.has(face.id);
        }
        if (!std::ranges::equal(t.neighbors(i), with_one_infinity(row, box)))
            return text("cell ", i, " has other neighbors than by rational arithmetic");
        const double volume = t.volumes()[i], expected = open ? inf : exact.volume;
        if (volume != expected && !(std::abs(volume - expected) <= 1e-10 * expected))
            return text("cell ", i, " has volume ", volume, ", exact is ", expected);
        if (std::isnan(t.centroids()[3 * i]) != (open || row.empty())) return text("cell ", i, " has a wrong centroid");
        if (std::isinf(t.surface_areas()[i]) != open || std::isinf(t.security_radii()[i]) != open)
            return text("cell ", i, " has a wrong surface or radius");
    }
    return "";
}

// Areas of faces against rational arithmetic in a box that ends far away. near: cells that reach no farther may round
// areas as their surface; others do not.
std::string check_areas(const votess::Tessellation& t, const Coordinates& points, Options options, double near) {
    const votess::EndlessSides sides(votess::region_of(options));
    const votess::Box far = far_away(points);
    for (std::size_t k = 0; k < 3; ++k) {
        if (std::isinf(options.box->lower[k])) options.box->lower[k] = far.lower[k];
        if (std::isinf(options.box->upper[k])) options.box->upper[k] = far.upper[k];
    }
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto polygons = test::exact_polygons(points, options, i);
        const auto at_end = [&](const test::RationalVector& x) {
            return std::ranges::any_of(polygons, [&](const test::ExactPolygon& p) {
                return sides.has(p.face.id) && test::dot(p.n, x) == p.h;
            });
        };
        std::size_t entry = static_cast<std::size_t>(t.indptr()[i]);
        for (const test::ExactPolygon& p : polygons) {
            if (sides.has(p.face.id)) continue;
            while (sides.has(t.indices()[entry])) ++entry;
            REQUIRE(t.indices()[entry] == p.face.id);
            double square = 0;
            for (const mpq_class& x : test::doubled_area(p.corners)) square += x.get_d() * x.get_d();
            const double expected = std::ranges::any_of(p.corners, at_end) ? inf : std::sqrt(square) / 2;
            const double of_surface = t.security_radii()[i] <= 2 * near ? t.surface_areas()[i] : 0;
            const double area = t.face_areas()[entry++];
            if (area != expected && !(std::abs(area - expected) <= 1e-10 * (expected + of_surface)))
                return text("the face of cell ", i, " with ", p.face.id, " has area ", area, ", exact is ", expected);
        }
    }
    return "";
}

// Rows, counts and volumes of a run in one box or two against those in a box that ends far away.
std::string check_rows(const votess::Tessellation& t, const Coordinates& points, Options options) {
    options.box = far_away(points);
    const auto far = votess::tessellate(points, options);
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (!std::ranges::equal(t.neighbors(i), with_one_infinity(far.neighbors(i), no_ends)))
            return text("cell ", i, " has other neighbors than in a box that ends far away");
        const bool open = !t.neighbors(i).empty() && t.neighbors(i)[0] < 0;
        const double expected = open ? inf : far.volumes()[i];
        if (t.volumes()[i] != expected && !(std::abs(t.volumes()[i] - expected) <= 1e-10 * expected))
            return text("cell ", i, " has volume ", t.volumes()[i], ", expected is ", expected);
    }
    return "";
}

// An entry of a row, with all of infinity as one.
struct Entry {
    std::int32_t id = 0;
    std::array<int, 3> shift{};
    friend auto operator<=>(const Entry&, const Entry&) = default;
};

std::vector<Entry> entries_of(const votess::Tessellation& t, std::size_t row) {
    std::vector<Entry> out;
    for (auto e = static_cast<std::size_t>(t.indptr()[row]); e < static_cast<std::size_t>(t.indptr()[row + 1]); ++e) {
        out.push_back({t.indices()[e], {}});
        const std::size_t each = t.planar() ? 2 : 3;
        for (std::size_t k = 0; k < each && !t.shifts().empty(); ++k) out.back().shift[k] = t.shifts()[each * e + k];
    }
    return out;
}

// Rows, shifts and volumes of a periodic domain without end, with the options of far ends, by rational arithmetic.
std::string check_periodic(const votess::Tessellation& t, const Coordinates& points, const Options& options,
                           const Options& far) {
    const votess::EndlessSides sides(votess::region_of(options));
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto exact = test::exact_cell(points, far, i);
        std::vector<Entry> row;
        bool open = false;
        for (const auto& face : exact.faces) {
            const bool infinite = sides.has(face.id);
            if (!infinite || !open) row.push_back({infinite ? sides.id() : face.id, face.shift});
            open = open || infinite;
        }
        std::ranges::sort(row);
        if (entries_of(t, i) != row) return text("cell ", i, " has other neighbors than by rational arithmetic");
        const double expected = open ? inf : exact.volume;
        if (t.volumes()[i] != expected && !(std::abs(t.volumes()[i] - expected) <= 1e-10 * expected))
            return text("cell ", i, " has volume ", t.volumes()[i], ", exact is ", expected);
    }
    return "";
}

// Compares with the cells of the seeds among their images, in the same domain without periods.
std::string check_images(const votess::Tessellation& t, const Coordinates& points, Options options,
                         std::array<std::array<double, 3>, 2> periods) {
    constexpr int most = 2;
    const std::size_t dimensions = options.planar ? 2 : 3, n = t.size();
    const std::int32_t infinity = votess::EndlessSides(votess::region_of(options)).id();
    const auto places = votess::wrapped_points(t, points);
    std::vector<std::array<int, 2>> shifts{{0, 0}};
    for (int a = -most; a <= most; ++a)
        for (int b = -most; b <= most; ++b)
            if ((a != 0 || b != 0) && (b == 0 || periods[1] != std::array<double, 3>{})) shifts.push_back({a, b});
    Coordinates images;
    std::vector<double> weights;
    for (const auto& [a, b] : shifts) {
        for (std::size_t x = 0; x < places.size(); ++x)
            images.push_back(places[x] + a * periods[0][x % dimensions] + b * periods[1][x % dimensions]);
        weights.insert(weights.end(), options.weights.begin(), options.weights.end());
    }
    std::vector<std::int64_t> only(n);
    for (std::size_t i = 0; i < n; ++i) only[i] = static_cast<std::int64_t>(i);
    options.cell.reset();
    options.periodic = {};
    options.box = options.planar ? votess::Box{{-inf, -inf, 0}, {inf, inf, 0}} : no_ends;
    options.weights = weights;
    options.only = only;
    const auto all = votess::tessellate(images, options);
    for (std::size_t i = 0; i < n; ++i) {
        std::vector<Entry> row, expected;
        for (const Entry& e : entries_of(t, i)) row.push_back(e.id == infinity ? Entry{-1, {}} : e);
        for (const std::int32_t id : all.neighbors(i)) {
            const auto& [a, b] = shifts[id < 0 ? 0 : static_cast<std::size_t>(id) / n];
            expected.push_back({id < 0 ? -1 : id % static_cast<std::int32_t>(n), {a, b, 0}});
        }
        std::ranges::sort(row);
        std::ranges::sort(expected);
        if (row != expected) return text("cell ", i, " has other neighbors than among images");
        const double volume = all.volumes()[i];
        if (t.volumes()[i] != volume && !(std::abs(t.volumes()[i] - volume) <= 1e-10 * volume))
            return text("cell ", i, " has volume ", t.volumes()[i], ", among images ", volume);
        if (std::isinf(t.surface_areas()[i]) != std::isinf(all.surface_areas()[i]))
            return text("cell ", i, " has another surface than among images");
        if (t.vertex_counts()[i] != all.vertex_counts()[i] || t.edge_counts()[i] != all.edge_counts()[i])
            return text("cell ", i, " has other counts than among images");
    }
    return "";
}

// Each edge of a polygon is in two polygons of its cell, and both cells of a face have the same polygon.
std::string check_polygons(const votess::Tessellation& t) {
    const auto polygon = [&](std::size_t entry) {
        return t.face_vertices().subspan(
            static_cast<std::size_t>(t.face_offsets()[entry]),
            static_cast<std::size_t>(t.face_offsets()[entry + 1] - t.face_offsets()[entry]));
    };
    for (std::size_t i = 0; i < t.size(); ++i) {
        std::vector<std::pair<std::int32_t, std::int32_t>> edges, back;
        const auto begin = static_cast<std::size_t>(t.indptr()[i]), end = static_cast<std::size_t>(t.indptr()[i + 1]);
        bool open = false;
        for (std::size_t e = begin; e < end; ++e) {
            const auto corners = polygon(e);
            if (t.indices()[e] == -1) {
                open = true;
                if (!corners.empty()) return text("infinity has corners in cell ", i);
                continue;
            }
            if (std::ranges::count(corners, -1) > 1) return text("a polygon of cell ", i, " reaches infinity twice");
            for (std::size_t k = 0; k < corners.size(); ++k) {
                const auto from = corners[k], to = corners[(k + 1) % corners.size()];
                edges.emplace_back(from, to);
                back.emplace_back(to, from);
            }
            const auto j = static_cast<std::size_t>(t.indices()[e]);
            const auto theirs = t.neighbors(j);
            const auto place = std::ranges::lower_bound(theirs, static_cast<std::int32_t>(i)) - theirs.begin();
            const auto other = polygon(static_cast<std::size_t>(t.indptr()[j]) + static_cast<std::size_t>(place));
            std::vector<std::int32_t> a(corners.begin(), corners.end()), b(other.begin(), other.end());
            std::ranges::sort(a);
            std::ranges::sort(b);
            if (a != b) return text("cells ", i, " and ", j, " have different polygons");
        }
        std::ranges::sort(edges);
        std::ranges::sort(back);
        if (edges != back) return text("cell ", i, " is not closed");
        if (open != std::isinf(t.volumes()[i])) return text("cell ", i, " is open, or not, but has another volume");
        const auto V = t.vertex_counts()[i], E = t.edge_counts()[i], F = t.face_counts()[i];
        if (V > 0 && V + F != E + 2) return text("cell ", i, " has ", V, " vertices, ", E, " edges, ", F, " faces");
        if (V != t.cell_vertex_indptr()[i + 1] - t.cell_vertex_indptr()[i]) return text("cell ", i, " lacks vertices");
    }
    return "";
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("unbounded: cells of random and degenerate sets are exact") {
        test::Random random(5);
        std::size_t sets = 0, open = 0, number = 0;
        for (std::uint64_t seed = 1; seed <= 2; ++seed)
            for (const test::PointSet& set : test::families(seed % 2 == 0 ? 12 : 24, seed)) {
                CAPTURE(set.name);
                CAPTURE(seed);
                if ((seed == 1 || test::reduced()) && number++ % 3 != 0) continue;  // these take longer
                Options options = endless_options();
                std::vector<double> weights;
                if (seed == 2) {
                    const double size = set.box ? set.box->upper[0] - set.box->lower[0] : 1;
                    for (std::size_t i = 0; i < set.size(); ++i)
                        weights.push_back(0.05 * size * size * random.uniform(0, 1));
                    options.weights = weights;
                }
                if (set.name == "duplicates" || set.name == "near duplicates")
                    continue;  // the oracle takes distinct seeds
                const auto t = votess::tessellate(set.points, options);
                CHECK(check_cells(t, set.points, options) == "");
                open += static_cast<std::size_t>(std::ranges::count(t.volumes(), inf));
                ++sets;
            }
        MESSAGE(sets << " sets, " << open << " open cells");
        CHECK(open > 10 * sets / 2);
    }

    TEST_CASE("unbounded: some sides of a box may be without end") {
        for (const votess::Box& box : {votess::Box{{-inf, 0, -inf}, {inf, inf, 1}}, votess::Box{{0, 0, 0}, {1, 1, inf}},
                                       votess::Box{{-inf, -inf, 0}, {inf, inf, 1}}}) {
            const auto set = test::uniform(25, 3);
            const Options options = endless_options(box);
            const auto t = votess::tessellate(set.points, options);
            CHECK(check_cells(t, set.points, options) == "");
            CHECK(votess::verify(t, set.points).failure == "");
            CHECK(t.box().upper == box.upper);
        }
    }

    TEST_CASE("unbounded: faces have the same area from both cells, beside vertices at any distance") {
        test::Random random(11);
        std::size_t far = 0;
        for (std::size_t trial = 0; trial < test::by_size(60, 12); ++trial) {
            CAPTURE(trial);
            const std::size_t n = trial % 4 == 3 ? 34 : 6 + trial % 12;
            const double step = std::ldexp(1, -static_cast<int>(10 + 20 * (trial % 3)));
            Coordinates points;
            std::vector<double> weights;
            for (std::size_t i = 0; i < n; ++i) {
                for (std::size_t k = 0; k < 3; ++k)
                    points.push_back(0.5 + step * static_cast<double>(random.integer(-99, 99)));
                weights.push_back(step * (trial % 2 == 0 ? random.uniform(0, 1) : random.uniform(0, 99 * step)));
            }
            Options options = endless_options(trial % 5 == 4 ? votess::Box{{0, -inf, -inf}, {inf, inf, inf}} : no_ends);
            options.weights = weights;
            options.want.areas = true;
            const auto t = votess::tessellate(points, options);
            CHECK(check_areas(t, points, options, 99 * 16 * step) == "");
            CHECK(votess::verify(t, points).failure == "");
            far += static_cast<std::size_t>(
                std::ranges::count_if(t.volumes(), [&](double v) { return v > std::pow(1e6 * step, 3) && v < inf; }));
        }
        CHECK(far > 0);
    }

    TEST_CASE("unbounded: seeds apart by less than the rounding of their other coordinate") {
        const double x = 0.005, y = 5e-9, apart = 0x1p-70;
        for (const std::size_t n : {2, 40}) {
            CAPTURE(n);
            Coordinates points;
            for (std::size_t i = 0; i < n; ++i) points.insert(points.end(), {x, y + static_cast<double>(i) * apart});
            Options options = endless_options(votess::Box{{-inf, -inf, 0}, {inf, inf, 0}});
            options.planar = true;
            const auto t = votess::tessellate(points, options);
            REQUIRE(points[3] > points[1]);
            CHECK(votess::verify(t, points).failure == "");
            for (std::size_t i = 0; i < n; ++i) CHECK(t.neighbors(i).size() == (i == 0 || i + 1 == n ? 2 : 3));
        }
    }

    TEST_CASE("unbounded: a vertex on an end of the near box") {
        // A vertex lies six times the width of these seeds away from them.
        const std::vector<int> places{8, 3,  2,  -8, 5,  -1, 0,  -3, -1, 4, -2, 2,  4,  -4, -5, 7, -6, 1, -1, -5,
                                      0, -1, -4, 3,  -5, -4, 5,  -2, 0,  2, -7, -8, -3, -5, 8,  8, -5, 0, 2,  -5,
                                      1, 1,  3,  0,  2,  7,  -1, -2, -8, 8, 6,  0,  -1, 1,  6,  3, -1, 5, -3, -6};
        const Coordinates points(places.begin(), places.end());
        Options options;
        options.planar = true;
        options.box = votess::Box{{-inf, -inf, 0}, {inf, inf, 0}};
        options.want.neighbors = options.want.counts = options.want.faces = options.want.areas = true;
        const auto t = votess::tessellate(points, options);
        CHECK(votess::verify(t, points).failure == "");
        std::vector<std::array<double, 2>> vertices;
        for (std::size_t v = 0; v < t.vertices().size(); v += 2)
            vertices.push_back({t.vertices()[v], t.vertices()[v + 1]});
        CHECK(std::ranges::count(vertices, std::array{104.0, -56.5}) == 1);
        std::ranges::sort(vertices);
        CHECK(std::ranges::adjacent_find(vertices) == vertices.end());
    }

    TEST_CASE("unbounded: periodic along some axes, few seeds") {
        test::Random random(7);
        for (std::size_t trial = 0; trial < test::by_size(36, 12); ++trial) {
            CAPTURE(trial);
            const std::size_t n = random.below(trial % 4 == 0 ? 3 : 9);
            const double grid = trial % 3 == 0 ? 4 : 0x1p20;
            Coordinates points;
            std::vector<double> weights;
            for (std::size_t i = 0; i < n; ++i) {
                for (std::size_t k = 0; k < 3; ++k)
                    points.push_back(trial % 5 == 0 && k == 2
                                         ? 0.5
                                         : static_cast<double>(random.below(static_cast<std::size_t>(grid))) / grid +
                                               static_cast<double>(i) / 64);
                weights.push_back(random.uniform(0, 0.2));
            }
            Options options = endless_options(votess::Box{{0, 0, -inf}, {1, 1.5, inf}});
            if (trial % 2 == 0) options.weights = weights;
            options.periodic = {true, trial % 3 != 1, false};
            if (trial % 3 == 2) {  // one of the sides has an end
                (trial % 2 == 0 ? options.box->lower[2] : options.box->upper[2]) = trial % 2 == 0 ? -0.25 : 1.75;
                options.outside = votess::Outside::keep;
            }
            Options far = options;
            far.box->lower[2] = std::max(far.box->lower[2], -0x1p200);
            far.box->upper[2] = std::min(far.box->upper[2], 0x1p200);
            if (trial % 3 == 0) {
                options.periodic = {};
                options.box.reset();
                options.cell = votess::TriclinicBox{{0.125, 0, 0.5}, {1, 0, 0}, {0.5, 0.875, 0.25}, {}, {}};
                options.cell->periodic = {true, trial % 2 == 0, false};
                if (trial % 2 == 1) options.cell->b = {};
                far = options;
                far.cell->origin[2] = -0x1p150;
                far.cell->c = {0, 0, 0x1p151};
                if (trial % 2 == 1) far.cell->origin[1] = -0x1p150, far.cell->b = {0, 0x1p151, 0};
            }
            const auto t = votess::tessellate(points, options);
            CHECK(check_periodic(t, points, options, far) == "");
            CHECK(votess::verify(t, points).failure == "");
        }
    }

    TEST_CASE("unbounded: periodic along some axes, many seeds, among their images") {
        using Vector = std::array<double, 3>;
        for (std::size_t trial = 0; trial < test::by_size(6, 3); ++trial) {
            CAPTURE(trial);
            const bool planar = trial % 3 == 2, skewed = trial >= 3;
            const auto set = test::uniform(test::by_size(250, 90), static_cast<std::uint64_t>(trial));
            Coordinates points;
            std::vector<double> weights;
            for (std::size_t x = 0; x < set.points.size(); ++x)  // images of these are doubles
                if (!planar || x % 3 != 2) points.push_back(std::floor(set.points[x] * 0x1p30) * 0x1p-30);
            for (std::size_t i = 0; i < set.size(); ++i) weights.push_back(0.001 * static_cast<double>(i % 7));
            Options options = endless_options(votess::Box{{0, -inf, planar ? 0 : -inf}, {1, inf, planar ? 0 : inf}});
            options.planar = planar;
            options.want.faces = options.want.counts = true;
            std::array<Vector, 2> periods{{{1, 0, 0}, {}}};
            options.periodic[0] = true;
            if (trial % 3 == 0) options.box->lower[1] = 0, options.box->upper[1] = 1, periods[1] = {0, 1, 0};
            options.periodic[1] = trial % 3 == 0;
            if (skewed) {
                periods[0][1] = 0.25;
                if (trial == 3) periods[1] = {0.5, 1, 0.125};
                options.box.reset();
                options.periodic = {};
                options.cell = votess::TriclinicBox{{}, periods[0], periods[1], {}, {true, trial == 3, false}};
                options.weights = weights;
            }
            const auto t = votess::tessellate(points, options);
            CHECK(check_images(t, points, options, periods) == "");
            CHECK(votess::verify(t, points).failure == "");
            CHECK(t.periodic()[0]);
            CHECK(t.cell().has_value() == skewed);
            if (planar) continue;
            // All tetrahedra turn alike.
            const auto dual = votess::delaunay(t);
            const auto places = votess::wrapped_points(t, points);
            CHECK(dual.tetrahedra_centers.size() > set.size());
            for (std::size_t k = 0; k < dual.tetrahedra.size(); k += 4) {
                std::array<Vector, 4> x;
                for (std::size_t c = 0; c < 4; ++c)
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        x[c][axis] = places[3 * static_cast<std::size_t>(dual.tetrahedra[k + c]) + axis];
                        for (std::size_t j = 0; j < 2; ++j)
                            x[c][axis] += dual.tetrahedra_shifts[3 * (k + c) + j] * periods[j][axis];
                    }
                CHECK(votess::exact::orient(x[1], x[2], x[3], x[0]) > 0);
            }
        }
    }

    TEST_CASE("unbounded: many seeds, with all arrays") {
        const std::size_t n = test::by_size(1200, 500);
        for (test::PointSet set : {test::uniform(n, 1), test::with_duplicates(n, 40, 3), test::cubic(10),
                                   test::scaled(test::clustered(n, 4), 0x1p-100)}) {
            CAPTURE(set.name);
            Options options = endless_options();
            options.threads = 2;
            const auto rows = votess::tessellate(set.points, options);
            CHECK(check_rows(rows, set.points, options) == "");
            options.want.vertices = options.want.faces = options.want.normals = true;
            const auto t = votess::tessellate(set.points, options);
            CHECK(test::rows_of(t) == test::rows_of(rows));
            CHECK(std::ranges::equal(t.volumes(), rows.volumes()));
            CHECK(check_polygons(t) == "");
            CHECK(std::isinf(t.stats().volume_sum));
            CHECK(t.stats().faces == t.indices().size());
            if (set.name != "uniform") continue;
            CHECK(votess::verify(t, set.points).failure == "");
            // Euler's formula of the Delaunay tetrahedra of the convex hull.
            const auto dual = votess::delaunay(t);
            const auto hull = static_cast<std::size_t>(std::ranges::count(t.volumes(), inf));
            const std::size_t tetrahedra = dual.tetrahedra_centers.size(),
                              triangles = (4 * tetrahedra + 2 * hull - 4) / 2, edges = (t.indices().size() - hull) / 2;
            CHECK(set.size() + triangles == 1 + edges + tetrahedra);
        }
    }

    // Their vertices are 2^52 times as far as in a plane. Such seeds are run in the far box alone.
    TEST_CASE("unbounded: seeds in a plane or on a line up to rounding") {
        test::Random random(17);
        for (std::size_t trial = 0; trial < 12; ++trial) {
            const std::size_t count = trial < 6 ? 12 : 40;
            Coordinates points;
            for (std::size_t i = 0; i < count; ++i) {
                const double s = random.uniform(), t = trial % 2 == 0 ? random.uniform() : 0;
                points.insert(points.end(),
                              {0.1 + s / 3 - 0.3 * t, 0.2 + 0.7 * s + 0.13 * t, 0.3 + 0.11 * s + 0.77 * t});
            }
            CAPTURE(trial);
            Options options = endless_options();
            const auto t = votess::tessellate(points, options);
            CHECK(check_rows(t, points, options) == "");
            options.want.vertices = options.want.faces = true;
            const auto all = votess::tessellate(points, options);
            CHECK(test::rows_of(all) == test::rows_of(t));
            CHECK(std::ranges::equal(all.volumes(), t.volumes()));
            CHECK(check_polygons(all) == "");
            CHECK(votess::verify(all, points).failure == "");
        }
    }

    // Rows of compact cells do not depend on how far walls across the lattice are. Third edges that long came to NaN.
    TEST_CASE("unbounded: a periodic cell of any length across the lattice") {
        const Coordinates points{0.3333333333333325, 2.3052626492114048e-15, 0.6666666666666676,
                                 0.6666666666666667, 0.9999999999999981,     0.6666666666666662,
                                 0.3333333333333349, 0.3333333333333337,     0.6666666666666651};
        Options options = test::all_options();
        options.box.reset();
        options.cell =
            votess::TriclinicBox{{-0.1, -0.1, -0.1}, {1.2, 0, 0}, {0.3, 1.2, 0}, {0, 0, 0}, {true, true, false}};
        options.want.vertices = options.want.faces = true;
        const auto endless = votess::tessellate(points, options);
        CHECK(votess::verify(endless, points).failure == "");
        for (const bool both : {true, false}) {
            options.want = {.neighbors = true, .volumes = false};
            options.list_walls = false;
            std::vector<std::vector<std::int32_t>> rows;
            for (const int exponent : {100, 255, 256, 268, 269, 270, 340, 400}) {
                const double end = std::ldexp(1.0, exponent);
                options.cell->origin[2] = -end;
                options.cell->c = {0, 0, 2 * end};
                options.cell->periodic = {true, both, false};
                CAPTURE(exponent);
                CAPTURE(both);
                const auto t = votess::tessellate(points, options);
                if (rows.empty()) rows = test::rows_of(t);
                CHECK(test::rows_of(t) == rows);
            }
        }
    }

    TEST_CASE("unbounded: the far box lies beyond all vertices") {
        test::Random random(9);
        for (std::size_t trial = 0; trial < test::by_size(200, 40); ++trial) {
            // Four points near a plane, in few bits.
            const std::size_t grid = std::size_t{1} << (1 + random.below(20));
            Coordinates points;
            for (int i = 0; i < 12; ++i)
                points.push_back(i % 3 == 2 ? static_cast<double>(random.below(2))
                                            : static_cast<double>(random.below(grid)));
            Options options = endless_options();
            options.want.faces = true;
            const auto t = votess::tessellate(points, options);
            votess::Region far;
            far.box = no_ends;
            votess::end_far(far, {points, {}});
            const votess::Box box = *far.box;
            double farthest = 0;
            for (const double x : t.vertices()) farthest = std::max(farthest, std::abs(x));
            CHECK(farthest < box.upper[0]);
            if (t.vertices().empty()) continue;
            CHECK(votess::delaunay(t).tetrahedra_centers.size() == 1);
        }
    }

    TEST_CASE("unbounded: Delaunay tetrahedra of few points turn the right way") {
        test::Random random(21);
        for (std::size_t trial = 0; trial < test::by_size(150, 60); ++trial) {
            Coordinates points;
            const std::size_t n = 4 + random.below(4);
            for (std::size_t i = 0; i < 3 * n; ++i) points.push_back(random.uniform(-1, 1));
            Options options = endless_options(trial % 5 == 4 ? votess::Box{{-inf, -1, -inf}, {inf, 1, inf}} : no_ends);
            options.want.faces = true;
            const auto dual = votess::delaunay(votess::tessellate(points, options));
            for (std::size_t t = 0; t < dual.tetrahedra.size(); t += 4) {
                std::array<std::array<double, 3>, 3> d{};
                for (std::size_t k = 0; k < 3; ++k)
                    for (std::size_t c = 0; c < 3; ++c)
                        d[k][c] = points[3 * static_cast<std::size_t>(dual.tetrahedra[t + k + 1]) + c] -
                                  points[3 * static_cast<std::size_t>(dual.tetrahedra[t]) + c];
                const double six = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                                   d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                                   d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
                CHECK(six > 0);
                CHECK(dual.tetrahedra[t] == std::min({dual.tetrahedra[t], dual.tetrahedra[t + 1],
                                                      dual.tetrahedra[t + 2], dual.tetrahedra[t + 3]}));
            }
            if (trial % 5 != 4) CHECK(dual.tetrahedra.size() > 0);
        }
    }

    // By rows in a box that ends far away: seeds in one plane or on one line have prisms and slabs as cells.
    TEST_CASE("unbounded: periodic along some axes, seeds in a plane or nearly, and some beside it") {
        using Vector = std::array<double, 3>;
        for (int trial = 0; trial < 4; ++trial) {
            CAPTURE(trial);
            auto set = test::uniform(test::by_size(40, 20), static_cast<std::uint64_t>(trial));  // took 0.1 s each
            for (double& x : set.points) x = std::floor(x * 0x1p30) * 0x1p-30;  // images of these are doubles
            for (std::size_t i = static_cast<std::size_t>(trial) % 3; i < set.size(); ++i)
                set.points[3 * i + 2] = trial < 2 ? 0.5 : 0.5 + std::floor(16 * set.points[3 * i + 2]) * 0x1p-30;
            Options options = endless_options(votess::Box{{0, -inf, -inf}, {1, inf, inf}});
            options.want.faces = options.want.counts = true;
            std::array<Vector, 2> periods{{{1, 0, 0}, {}}};
            options.periodic[0] = true;
            if (trial % 2 == 0) options.box->lower[1] = 0, options.box->upper[1] = 1, periods[1] = {0, 1, 0};
            options.periodic[1] = trial % 2 == 0;
            const auto t = votess::tessellate(set.points, options);
            CHECK(check_images(t, set.points, options, periods) == "");
        }
    }

    TEST_CASE("unbounded: seeds in a plane or on a line") {
        test::Random random(14);
        for (std::size_t trial = 0; trial < 18; trial += test::by_size(1, 5)) {
            CAPTURE(trial);
            const std::size_t n = trial % 4 == 0 ? 2 + trial / 2 : 30;
            Coordinates points;
            for (std::size_t i = 0; i < n; ++i) {
                const double whole = std::ldexp(1.0, static_cast<int>(random.below(30)));
                const double u = std::floor(random.uniform(0, 1) * whole), v = std::floor(random.uniform(0, 1) * whole);
                const double w = random.uniform(0, 1);
                const std::array<std::array<double, 3>, 8> kinds{{{u, v, 0.25},
                                                                  {0.1, w, u},
                                                                  {u, w, u},
                                                                  {u, v, -u - v},
                                                                  {w, 0, 0},
                                                                  {u, u, u},
                                                                  {u, -2 * u, 3 * u},
                                                                  {w, w, 7}}};
                points.insert(points.end(), kinds[trial % 8].begin(), kinds[trial % 8].end());
            }
            Options options = endless_options();
            if (trial % 16 == 8) options.box = votess::Box{{-inf, -inf, -1}, {inf, inf, inf}};
            if (trial % 16 == 9) options.box = votess::Box{{-inf, -1, -inf}, {inf, 2, inf}};
            std::vector<double> weights;
            for (std::size_t i = 0; i < n; ++i) weights.push_back(random.uniform(0, 1) * (trial % 5 == 0 ? 1 : 1e-6));
            if (trial % 3 == 1) options.weights = weights;
            options.want.vertices = options.want.faces = true;
            const auto t = votess::tessellate(points, options);
            options.box = far_away(points);
            if (trial % 16 == 8) options.box->lower[2] = -1;
            if (trial % 16 == 9) options.box->lower[1] = -1, options.box->upper[1] = 2;
            const votess::Box& box = t.box();
            const auto far = votess::tessellate(points, options);
            for (std::size_t i = 0; i < n; ++i) {
                REQUIRE(t.status()[i] == far.status()[i]);
                REQUIRE(std::ranges::equal(t.neighbors(i), with_one_infinity(far.neighbors(i), box)));
                if (t.status()[i] == votess::CellStatus::certified) REQUIRE(std::isinf(t.volumes()[i]));
            }
            if (box.lower[2] == -inf)
                for (const double area : t.face_areas()) REQUIRE(std::isinf(area));
            if (box.lower[2] == -inf && box.lower[1] == -inf) {
                CHECK(t.vertices().empty());
                CHECK(check_polygons(t) == "");
            }
            CHECK(t.walls().empty());
        }
    }

    TEST_CASE("unbounded: many seeds in a plane or on a line take as long as in space") {
        const std::size_t n = test::by_size(20000, 3000);  // took a millisecond each
        test::Random random(15);
        for (const int kind : {0, 1, 2}) {
            Coordinates points;
            for (std::size_t i = 0; i < n; ++i) {
                const double u = random.uniform(0, 1), v = random.uniform(0, 1);
                const std::array<std::array<double, 3>, 3> kinds{{{u, v, 0}, {u, v, u}, {u, u, u}}};
                points.insert(points.end(), kinds[kind].begin(), kinds[kind].end());
            }
            Options options = endless_options();
            options.want = {};
            const auto t = votess::tessellate(points, options);
            CHECK(static_cast<std::size_t>(std::ranges::count(t.volumes(), inf)) == n);
            // Euler's formula of triangles in the plane, of edges on the line.
            const auto hull = kind == 2 ? std::size_t{2} : std::size_t{0};
            if (kind == 2) CHECK(t.indices().size() - n * (options.list_walls ? 1 : 0) == 2 * n - hull);
            CHECK(t.stats().exact_cells < n / 10);
        }
    }

    TEST_CASE("unbounded: a probe beside many seeds in a plane or on a line touches each of them") {
        const std::size_t n = test::by_size(4000, 1000);  // took a second for 1,000 seeds, 30 for 4,000
        test::Random random(16);
        for (const bool line : {true, false}) {
            Coordinates points;
            std::vector<std::int32_t> all;
            for (std::size_t i = 0; i < n; ++i) {
                points.insert(points.end(), {random.uniform(0, 1), line ? 0.0 : random.uniform(0, 1), 0});
                all.push_back(static_cast<std::int32_t>(i));
            }
            Options options = endless_options();
            const votess::Diagram diagram(points, options);
            const auto probed = diagram.probe(std::vector<double>{0.5, 0.3, 0.1});
            CHECK(std::ranges::equal(probed.neighbors(0), all));
        }
    }

    TEST_CASE("unbounded: the digits of some cells are those of the full run") {
        for (std::size_t trial = 0; trial < 12; trial += test::by_size(1, 5)) {
            CAPTURE(trial);
            const std::size_t n = trial % 3 == 0 ? 20 : 120;
            const auto set = test::uniform(n, 100 + trial);
            test::Random random(trial);
            std::vector<double> weights;
            for (std::size_t i = 0; i < n; ++i) weights.push_back(random.uniform(0, 1) * 0.1);
            Options options = endless_options();
            options.want.surfaces = options.want.radii = true;
            options.want.counts = options.want.areas = trial % 2 == 0;
            if (trial % 4 > 1) options.weights = weights;
            const auto all = votess::tessellate(set.points, options);
            for (std::size_t i = 0; i < n; i += 7) {
                const std::vector<std::int64_t> ids{static_cast<std::int64_t>(i),
                                                    static_cast<std::int64_t>((i + 11) % n)};
                options.only = ids;
                const auto some = votess::tessellate(set.points, options);
                for (std::size_t k = 0; k < 2; ++k)
                    REQUIRE(test::different_cell(some, k, all, static_cast<std::size_t>(ids[k])) == "");
            }
            options.only.reset();
        }
    }

    TEST_CASE("unbounded: weighted seeds at one place") {
        for (const Coordinates& place : {Coordinates{0.4, 0.2, 0.1}, Coordinates{0, 0, 0}, Coordinates{1e20, 0, 3}})
            for (const std::size_t n : {1, 2, 3, 40})
                for (const double size : {0.0, 0.1, 1e30, 1e-200}) {
                    Coordinates points;
                    std::vector<double> weights;
                    for (std::size_t i = 0; i < n; ++i) {
                        points.insert(points.end(), place.begin(), place.end());
                        weights.push_back(size * static_cast<double>(i));
                    }
                    Options options = endless_options();
                    options.weights = weights;
                    const auto t = votess::tessellate(points, options);
                    const std::size_t heaviest = size == 0 ? 0 : n - 1;
                    for (std::size_t i = 0; i < n; ++i) CHECK(t.volumes()[i] == (i == heaviest ? inf : 0));
                }
        const std::vector<double> weights{0, 1e300, 0};
        Options options = endless_options();
        options.weights = weights;
        CHECK(has(test::refusal({0, 0, 0, 1, 1, 1, 1, 0, 0}, options, votess::ErrorCode::unsupported), "weights"));
    }

    TEST_CASE("unbounded: in the plane") {
        for (const std::size_t n :
             {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{50}, test::by_size(4500, 500)}) {
            CAPTURE(n);
            test::Random random(n);
            Coordinates points;
            for (std::size_t i = 0; i < 2 * n; ++i) points.push_back(random.uniform(0, 1));
            Options options = endless_options(votess::Box{{-inf, -inf, 0}, {inf, inf, 0}});
            options.planar = options.want.vertices = options.want.faces = true;
            const auto t = votess::tessellate(points, options);
            if (n < 100) CHECK(votess::verify(t, points).failure == "");
            const auto hull = static_cast<std::size_t>(std::ranges::count(t.volumes(), inf));
            if (n >= 3) CHECK(t.vertices().size() / 2 == 2 * n - 2 - hull);  // triangles of the hull
            if (n > 100) continue;                                           // a high sheet takes long
            options.box = votess::Box{{-0x1p150, -0x1p150, 0}, {0x1p150, 0x1p150, 0}};
            const auto far = votess::tessellate(points, options);
            for (std::size_t i = 0; i < n; ++i)
                CHECK(test::row_of(t, i) == with_one_infinity(far.neighbors(i), no_ends));
        }
    }

    TEST_CASE("unbounded: natural neighbors reproduce linear fields in the convex hull, and end at it") {
        for (const bool weighted : {false, true}) {
            const auto set = test::uniform(test::by_size(2000, 500), 11);
            test::Random random(12);
            Options options;
            std::vector<double> values, weights;
            for (std::size_t i = 0; i < set.size(); ++i) {
                values.push_back(set.points[3 * i] + 2 * set.points[3 * i + 1] + 3 * set.points[3 * i + 2]);
                if (weighted) weights.push_back(1e-4 * random.uniform(0, 1));
            }
            options.weights = weights;
            const votess::Diagram d(set.points, options);
            Coordinates queries;
            for (std::size_t q = 0; q < test::by_size(3000, 600); ++q) queries.push_back(random.uniform(-0.1, 1.1));
            const auto field = d.interpolate(values, 1, queries).values;
            const auto rows = d.natural_neighbors(queries);
            votess::ProbeOptions probing;
            probing.list_walls = true;
            const auto cells = d.probe(queries, probing);
            std::size_t known = 0;
            for (std::size_t q = 0; q < field.size(); ++q) {
                const bool open = std::isinf(cells.volumes()[q]), empty = cells.neighbors(q).empty();
                CHECK(std::isnan(field[q]) == (open || empty));
                CHECK((rows.indptr[q] == rows.indptr[q + 1]) == (open || empty));
                if (!open && !empty) ++known;
                if (open || empty || weighted) continue;
                const double* x = &queries[3 * q];
                CHECK(std::abs(field[q] - (x[0] + 2 * x[1] + 3 * x[2])) <= 6e-12);
            }
            CHECK(known > field.size() / 3);
            CHECK(known < field.size());
            for (const std::int32_t seed : d.locate(Coordinates{1e9, 2e9, -3e9, 0.5, 0.5, 0.5})) CHECK(seed >= 0);
        }
    }

    TEST_CASE("unbounded: queries in a cell that lacks an edge are those of its box") {
        const test::Coordinates points = test::uniform(40, 91).points;
        test::Coordinates queries = test::uniform(60, 92).points;
        queries.insert(queries.end(), {0.3, 0.4, 100, -7.2, 8.1, -50});
        const std::size_t count = queries.size() / 3;
        const auto is_close = [](double x, double y, double error) {
            return x == y || std::abs(x - y) <= error * std::abs(x);
        };
        Options in_box, in_cell;
        in_box.box = votess::Box{{0, 0, -inf}, {1, 1, inf}};
        in_box.periodic = {true, true, false};
        in_cell.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}};
        in_cell.cell->periodic = {true, true, false};
        const votess::Diagram a(points, in_box), b(points, in_cell);
        CHECK(a.locate(queries) == b.locate(queries));
        const votess::Tessellation of_a = a.probe(queries), of_b = b.probe(queries);
        CHECK(std::ranges::equal(of_a.indices(), of_b.indices()));
        for (std::size_t q = 0; q < count; ++q) CHECK(is_close(of_a.volumes()[q], of_b.volumes()[q], 1e-10));
        const test::Coordinates ways = test::uniform(count, 93).points, lengths(count, 2.5);
        CHECK(a.trace(queries, ways, lengths).seeds == b.trace(queries, ways, lengths).seeds);
        test::Coordinates inner;  // farther up so few seeds know no coordinates
        for (std::size_t q = 0; q < count; ++q)
            if (std::abs(queries[3 * q + 2] - 0.5) < 0.2)
                inner.insert(inner.end(), &queries[3 * q], &queries[3 * q] + 3);
        CHECK(a.natural_neighbors(inner).indices == b.natural_neighbors(inner).indices);
        const votess::Box grid_a = a.grid_domain().box(), grid_b = b.grid_domain().box();
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(is_close(grid_a.lower[k], grid_b.lower[k], 1e-12));
            CHECK(is_close(grid_a.upper[k], grid_b.upper[k], 1e-12));
        }
    }

    TEST_CASE("unbounded: what needs an end is refused") {
        const auto set = test::uniform(10, 1);
        const auto refused = [&](auto change) {
            Options options = endless_options();
            change(options);
            return test::refusal(set.points, options);
        };
        CHECK(has(refused([](Options& o) { o.periodic = {true, false, false}; }), "no end along it"));
        CHECK(has(refused([](Options& o) {
                      o.box.reset();
                      o.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0, 1, 0}, {}, {true, true, true}};
                  }),
                  "Options::cell: c is 0"));
        CHECK(has(refused([](Options& o) { o.walls = {{{1, 0, 0}, 1}}; }), "without end"));
        CHECK(has(refused([](Options& o) { o.box->lower[0] = inf; }), "box"));
        CHECK(has(refused([](Options& o) { o.box->upper[1] = std::nan(""); }), "box"));
        CHECK(has(test::refusal({0, 0, 0, 1, 1, 1, 1e-300, 0, 0}, endless_options(), votess::ErrorCode::unsupported),
                  "too small"));
    }
}
