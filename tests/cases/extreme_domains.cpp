// Domains whose numbers are far from 1 or far from each other: exact, or refused with a reason, never rounded.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/certificate.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"

namespace {

using test::Coordinates;
using votess::Options;
using votess::TriclinicBox;

Options with_cell(const TriclinicBox& cell) {
    Options options = test::all_options();
    options.cell = cell;
    return options;
}

votess::Tessellation tessellate(const Coordinates& points, const Options& options) {
    return votess::tessellate(std::span<const double>(points), options);
}

// The message of the error, which must be the user's; "" when there was none.
std::string refusal(const Coordinates& points, const Options& options) {
    std::string message;
    try {
        (void)tessellate(points, options);
    } catch (const votess::Error& error) {
        CHECK(error.code() == votess::ErrorCode::invalid_argument);
        message = error.what();
    }
    return message;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TriclinicBox times(const TriclinicBox& cell, double factor) {
    TriclinicBox result = cell;
    for (auto* vector : {&result.origin, &result.a, &result.b, &result.c})
        for (double& x : *vector) x *= factor;
    return result;
}

Coordinates times(Coordinates points, double factor) {
    for (double& x : points) x *= factor;
    return points;
}

// A wedge of walls with its edge at x = -1, as thin as e: |z| <= e (1 + x), x <= 1, |y| <= 1.
std::vector<votess::Wall> wedge(double e) {
    return {{{-e, 0, 1}, e}, {{-e, 0, -1}, e}, {{1, 0, 0}, 1}, {{0, 1, 0}, 1}, {{0, -1, 0}, 1}};
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("extreme domains: a cell that scaling would round is refused") {
        const double huge = 0x1p100, tiny = 0x1p-1000;
        const TriclinicBox cube{{0, 0, 0}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}};
        CHECK(refusal({1, 1, 1}, with_cell(cube)) == "");
        const auto refused = [&](const TriclinicBox& cell, const std::string& what) {
            const std::string message = refusal({1, 1, 1}, with_cell(cell));
            CAPTURE(message);
            CHECK(has(message, what));
            CHECK(has(message, "9.33263618503"));
        };
        for (std::size_t k = 0; k < 3; ++k) {
            const std::string axis(1, "xyz"[k]);
            TriclinicBox cell = cube;
            cell.origin[k] = tiny;
            refused(cell, "cell: origin " + axis);
            cell = cube, cell.a[k] = tiny, cell.a[(k + 1) % 3] = huge, cell.b = {0, 0, 0}, cell.c = {0, 0, 0};
            cell.b[k] = cell.c[(k + 2) % 3] = huge;
            refused(cell, "cell: a " + axis);
            std::swap(cell.a, cell.b);
            refused(cell, "cell: b " + axis);
            std::swap(cell.b, cell.c);
            refused(cell, "cell: c " + axis);
        }
        // What the scale leaves as it is stays exact: eight faces, for the tilt parts ties.
        const TriclinicBox tilted{{0, 0, 0}, {huge, 0x1p-900, 0}, {0, huge, 0}, {0, 0, huge}};
        const auto t = tessellate({0, 0, 0}, with_cell(tilted));
        CHECK(t.neighbors(0).size() == 8);
    }

    TEST_CASE("extreme domains: bounds, walls, normals and weights that scaling would round are refused") {
        Options options = test::all_options(votess::Box{{0x1p-1000, 0, 0}, {0x1p100, 0x1p100, 0x1p100}});
        CHECK(has(refusal({1, 1, 1}, options), "box: lower x"));
        options.box = votess::Box{{0, 0, -0x1p100}, {0x1p100, 0x1p100, 0x1p-1000}};
        CHECK(has(refusal({1, 1, -1}, options), "box: upper z"));
        options.box = test::cube(0, 0x1p100);
        CHECK(has(refusal({1, 1, 0x1p-1000}, options), "point 0: z"));
        options.walls = {{{-1, 0, 0}, -0x1p-1000}};
        CHECK(has(refusal({1, 1, 1}, options), "wall 0"));
        options.walls = {{{0, 0, 1}, 0x1p99}, {{0x1p1000, 0x1p-1074, 0}, 0x1p1020}};
        CHECK(has(refusal({1, 1, 1}, options), "wall 1"));
        options.walls.clear();
        const std::vector<double> weights{0, 0x1p-1000};
        options.weights = weights;
        CHECK(has(refusal({1, 1, 1, 2, 2, 2}, options), "weight 1"));
        const std::vector<double> radii{0, 0x1p-450};
        options.weights = {};
        options.radii = radii;
        CHECK(has(refusal({1, 1, 1, 2, 2, 2}, options), "radius 1"));
    }

    TEST_CASE("extreme domains: a dropped seed may lie beyond what scaling leaves finite") {
        Options options = test::all_options();
        options.outside = votess::Outside::drop;
        for (std::size_t k = 0; k < 3; ++k)
            for (const double sign : {-1, 1}) {
                votess::Wall wall{{0, 0, 0}, 0x1p-300};
                wall.normal[k] = sign;
                options.walls.push_back(wall);
            }
        const auto t = tessellate({0, 0, 0, 0x1p900, 0, 0, 0, -0x1p1000, 0, 0x1p-301, 0, 0}, options);
        const std::vector<votess::CellStatus> status(t.status().begin(), t.status().end());
        using enum votess::CellStatus;
        CHECK(status == std::vector{certified, outside, outside, certified});
        CHECK(t.neighbors(0).size() == 6);
    }

    TEST_CASE("extreme domains: cells of any size give the same lists") {
        const TriclinicBox cell{{0.125, 0.25, 0}, {1, 0.25, 0}, {-0.25, 1.5, 0.125}, {0.5, 0, 1.25}};
        const Coordinates points{0.5, 0.5, 0.5, 0.25, 1, 0.75, 1, 0.75, 0.25, 0.75, 0.75, 1};
        const auto expected = tessellate(points, with_cell(cell));
        CHECK(test::check_against_half_spaces(expected, points, with_cell(cell), 3) == "");
        // 1e-110 and 1e103 are about 2^-365 and 2^342.
        for (const double factor :
             {0x1p-1000, 0x1p-400, 0x1p-365, 0x1p-110, 0x1p-64, 0x1p100, 0x1p342, 0x1p600, 0x1p1000}) {
            CAPTURE(factor);
            const Coordinates there = times(points, factor);
            const auto t = tessellate(there, with_cell(times(cell, factor)));
            CHECK(std::ranges::equal(t.indptr(), expected.indptr()));
            CHECK(std::ranges::equal(t.indices(), expected.indices()));
            CHECK(std::ranges::equal(t.shifts(), expected.shifts()));
            for (std::size_t k = 0; k < 3; ++k) CHECK(t.box().upper[k] == expected.box().upper[k] * factor);
            for (std::size_t i = 0; i < t.size(); ++i)
                CHECK(t.volumes()[i] == expected.volumes()[i] * factor * factor * factor);
            CHECK(votess::verify(t, there).failure == "");
        }
        for (const double factor : {1e-110, 1e103, 1e-300, 1e300}) {
            CAPTURE(factor);
            const Coordinates there = times(points, factor);
            const auto t = tessellate(there, with_cell(times(cell, factor)));
            CHECK(votess::verify(t, there).failure == "");
            CHECK(t.indices().size() == expected.indices().size());
        }
    }

    TEST_CASE("extreme domains: cells without a volume are refused, of any size") {
        for (const double factor : {0x1p-1060, 1e-110, 1.0, 1e103, 0x1p1000}) {
            CAPTURE(factor);
            for (const TriclinicBox& cell : {TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
                                             TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 1}},
                                             TriclinicBox{{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {0, 0, 1}}})
                CHECK(has(refusal({0, 0, 0}, with_cell(times(cell, factor))), "one plane"));
        }
        CHECK(has(refusal({}, with_cell({})), "one plane"));
        const double length = 1e-110;
        const TriclinicBox far{{1, 1, 1}, {length, 0, 0}, {0, length, 0}, {0, 0, length}};
        CHECK(has(refusal({1, 1, 1}, with_cell(far)), "too short"));
        const double huge = 1.5e308;
        const TriclinicBox beyond{{huge, 0, 0}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}};
        CHECK(has(refusal({huge, 0, 0}, with_cell(beyond)), "largest double"));
    }

    TEST_CASE("extreme domains: normals are unit vectors, of faces between the nearest of doubles too") {
        const double least = 0x1p-1074;
        const std::vector<Coordinates> sets{{0, 0, 0, least, least, 0},
                                            {0, 0, 0, least, least, least},
                                            {0, 0, 0, 3 * least, -2 * least, least},
                                            {0, 0, 0, 0x1p-600, 0x1p-601, 0},
                                            {0.25, 0.25, 0.25, 0.25, 0.25, 0.5}};
        for (const Coordinates& points : sets) {
            Options options = test::all_options(test::cube(-1, 1));
            options.want.normals = true;
            const auto t = tessellate(points, options);
            const auto normals = t.face_normals();
            REQUIRE(normals.size() == 3 * t.indices().size());
            for (std::size_t f = 0; f < t.indices().size(); ++f)
                CHECK(std::hypot(normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]) ==
                      doctest::Approx(1).epsilon(4e-16));
            const double length =
                std::hypot(points[3] * 0x1p500 - points[0] * 0x1p500, points[4] * 0x1p500 - points[1] * 0x1p500,
                           points[5] * 0x1p500 - points[2] * 0x1p500);
            const std::size_t last = t.neighbors(0).size() - 1;  // the other seed, behind the walls
            REQUIRE(t.neighbors(0)[last] == 1);
            for (std::size_t k = 0; k < 3; ++k)
                CHECK(normals[3 * last + k] ==
                      doctest::Approx((points[3 + k] * 0x1p500 - points[k] * 0x1p500) / length).epsilon(4e-16));
        }
    }

    TEST_CASE("extreme domains: without a box walls at any angle bound themselves") {
        for (const double e : {1e-3, 1e-8, 1e-9, 1e-10, 1e-15, 0x1p-70, 0x1p-105}) {
            CAPTURE(e);
            Options options = test::all_options();
            options.walls = wedge(e);
            const Coordinates points{0.5, 0, 0, 0.75, 0.25, 0};  // whose own bounds end far from the edge
            const auto t = tessellate(points, options);
            const double exact = 8 * e;  // 2 * integral of 2 e (1 + x)
            CHECK(t.stats().box_volume == doctest::Approx(exact).epsilon(1e-10));
            CHECK(t.volumes()[0] + t.volumes()[1] == doctest::Approx(exact).epsilon(1e-10));
            const double x[2] = {-1, 1}, z = 2 * e;
            CHECK(t.box().lower[0] <= x[0]);
            CHECK(t.box().lower[0] == doctest::Approx(x[0]).epsilon(0.01));
            CHECK(t.box().upper[0] >= x[1]);
            CHECK(t.box().upper[0] == doctest::Approx(x[1]).epsilon(0.01));
            CHECK(t.box().upper[2] >= z);
            CHECK(t.box().upper[2] == doctest::Approx(z).epsilon(0.01));
            CHECK(std::ranges::all_of(t.indices(), [](std::int32_t id) { return id >= 0 || id <= -7; }));
            CHECK(votess::verify(t, points).failure == "");
            // With a box around it the same cells.
            options.box = votess::Box{{-2, -2, -1}, {2, 2, 1}};
            CHECK(test::check_against_half_spaces(t, points, options, 0) == "");
        }
    }

    TEST_CASE("extreme domains: walls that leave room without bounds get those of the seeds") {
        const Coordinates points{0.5, 0, 0, -0.5, 0.25, 0};
        Options options = test::all_options();
        const auto otherwise = tessellate(points, options).box();
        options.walls = wedge(1e-10);
        options.walls.erase(options.walls.begin() + 2);  // x <= 1
        const auto t = tessellate(points, options);
        CHECK(t.box().lower[0] <= -1);
        CHECK(t.box().upper[0] == otherwise.upper[0]);
        CHECK(t.box().upper[1] == doctest::Approx(1).epsilon(0.01));
        // Two walls that are one plane but for the last bit: beyond their line there is room without end.
        options.walls = {{{std::nextafter(1.0, 2), 0, 1}, 1}, {{1, 0, 1}, 1}, {{0, 0, -1}, 1}};
        const auto open = tessellate(points, options);
        CHECK(open.box().lower[0] == otherwise.lower[0]);
        CHECK(open.box().upper[0] == doctest::Approx(2).epsilon(0.01));
        CHECK(open.box().lower[2] == doctest::Approx(-1).epsilon(0.01));
        CHECK(open.box().lower[2] < -1);
        CHECK(open.box().upper[2] == otherwise.upper[2]);
        // A plane between two walls leaves no room at all.
        options.walls = {{{0, 0, 1}, 0}, {{0, 0, -1}, 0}};
        const auto flat = tessellate(points, options);
        CHECK(flat.stats().box_volume == 0);
        CHECK(flat.stats().empty_cells == 2);
        for (std::size_t k = 0; k < 3; ++k) {
            CHECK(flat.box().lower[k] == otherwise.lower[k]);
            CHECK(flat.box().upper[k] == otherwise.upper[k]);
        }
    }

    TEST_CASE("extreme domains: the bounds of a small polyhedron far from 0 hold it") {
        Options options = test::all_options();
        const double ulp = 0x1p-52;
        for (std::size_t k = 0; k < 3; ++k) {
            votess::Wall below{{0, 0, 0}, -1}, above{{0, 0, 0}, 1 + 4 * ulp};
            below.normal[k] = -1, above.normal[k] = 1;
            options.walls.push_back(below);
            options.walls.push_back(above);
        }
        const Coordinates points{1 + ulp, 1 + ulp, 1 + ulp, 1 + 3 * ulp, 1 + 3 * ulp, 1 + 2 * ulp};
        const auto t = tessellate(points, options);
        CHECK(t.stats().box_volume == doctest::Approx(64 * ulp * ulp * ulp).epsilon(1e-10));
        CHECK(std::ranges::all_of(t.indices(), [](std::int32_t id) { return id >= 0 || id <= -7; }));
        CHECK(votess::verify(t, points).failure == "");
    }

    // The fuzz found it: the oracle's filter lost a vertex to underflow.
    TEST_CASE("extreme domains: a wall as near to the seed as numbers allow") {
        Options options = test::all_options(votess::Box{{0, 0, 0}, {403, 403, 403}});
        options.walls = {
            {{1, -1, 0}, std::numeric_limits<double>::denorm_min()}, {{1, 1, -1}, 403.25}, {{1, 1, 0}, 805.5}};
        const Coordinates points{402.75, 402.75, 402.25};
        const auto t = tessellate(points, options);
        CHECK(std::ranges::equal(t.neighbors(0), std::vector<std::int32_t>{-9, -8, -7, -6, -5, -4, -3, -1}));
        CHECK(test::check_certificate(t, points, options) == "");
    }
}
