// The network: Euler's formula, sites of lattices, radii and largest spheres by definition.
#include "votess/network.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

struct Case {
    test::Coordinates points;
    votess::Options options;
    votess::Tessellation t;
    votess::Network n;

    Case(test::Coordinates p, votess::Options o) : points(std::move(p)), options(std::move(o)) {
        options.want.faces = true;
        t = votess::tessellate(points, options);
        n = votess::network(t, points);
    }
    // Vertices - edges + faces - cells.
    [[nodiscard]] long euler() const {
        const auto faces = std::ranges::count_if(t.indices(), [](std::int32_t id) { return id >= 0; }) / 2;
        const auto cells = std::ranges::count(t.status(), votess::CellStatus::certified);
        return static_cast<long>(n.vertices.size()) - static_cast<long>(n.edge_radii.size()) + faces - cells;
    }
    // How many vertices have each number of edges.
    [[nodiscard]] std::map<int, std::size_t> degrees() const {
        std::vector<int> edges(n.vertices.size());
        for (const std::int32_t v : n.edges) ++edges[static_cast<std::size_t>(v)];
        std::map<int, std::size_t> count;
        for (const int e : edges) ++count[e];
        return count;
    }
};

votess::Options periodic_cube(double side) {
    votess::Options options;
    options.box = test::cube(0, side);
    options.periodic = {true, true, true};
    return options;
}

// Copies of a basis in the unit cube.
test::Coordinates crystal(const test::Coordinates& basis, int cells) {
    test::Coordinates points;
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j)
            for (int k = 0; k < cells; ++k)
                for (std::size_t b = 0; b < basis.size(); b += 3)
                    points.insert(points.end(), {basis[b] + i, basis[b + 1] + j, basis[b + 2] + k});
    return points;
}

const test::Coordinates bcc_basis{0, 0, 0, 0.5, 0.5, 0.5};
const test::Coordinates fcc_basis{0, 0, 0, 0.5, 0.5, 0, 0.5, 0, 0.5, 0, 0.5, 0.5};

// Checks that edges are in order and once, and that none has more room than its ends.
void check_edges(const Case& c) {
    const votess::Network& n = c.n;
    std::set<std::tuple<std::int32_t, std::int32_t, int, int, int>> seen;
    auto last = *seen.insert({-1, 0, 0, 0, 0}).first;
    for (std::size_t e = 0; e < n.edge_radii.size(); ++e) {
        const std::int8_t none[3]{};
        const std::int8_t* s = n.shifts.empty() ? none : &n.shifts[3 * e];
        const std::tuple edge{n.edges[2 * e], n.edges[2 * e + 1], int{s[0]}, int{s[1]}, int{s[2]}};
        REQUIRE(last < edge);
        REQUIRE(n.edges[2 * e] <= n.edges[2 * e + 1]);
        last = edge;
        for (std::size_t end = 2 * e; end < 2 * e + 2; ++end)
            REQUIRE(n.edge_radii[e] <= n.vertex_radii[static_cast<std::size_t>(n.edges[end])]);
    }
}

}  // namespace

TEST_CASE("network: Euler's formula on the torus") {
    for (const std::size_t count : {1u, 2u, 5u, 60u}) {
        std::vector<double> radii(count);
        test::Random random(count);
        for (double& r : radii) r = random.uniform(0, 0.1);
        votess::Options cell;
        cell.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0.2, 0.4, 1}, {true, true, true}};
        votess::Options weighted = periodic_cube(1);
        weighted.radii = radii;
        for (const votess::Options& options : {periodic_cube(1), cell, weighted}) {
            const Case c(test::uniform(count, count).points, options);
            CHECK(c.euler() == 0);
            // Images of two seeds are tied; of more, four edges leave each vertex.
            if (count > 2) CHECK(c.degrees() == std::map<int, std::size_t>{{4, c.n.vertices.size()}});
            check_edges(c);
        }
    }
}

TEST_CASE("network: interstitial sites of BCC and FCC") {
    for (const int cells : {1, 2, 3}) {
        const auto cubes = static_cast<std::size_t>(cells * cells * cells);
        const Case fcc(crystal(fcc_basis, cells), periodic_cube(cells));
        CHECK(fcc.euler() == 0);
        // An atom has one octahedral site, where six cells meet, and two tetrahedral ones.
        CHECK(fcc.degrees() == std::map<int, std::size_t>{{4, 8 * cubes}, {8, 4 * cubes}});
        std::size_t octahedral = 0;
        for (const double radius : fcc.n.vertex_radii) {
            const bool wide = radius > 0.47;
            octahedral += wide;
            CHECK(std::abs(radius - (wide ? 0.5 : std::sqrt(3.0) / 4)) < 1e-14);
        }
        CHECK(octahedral == 4 * cubes);
        check_edges(fcc);

        const Case bcc(crystal(bcc_basis, cells), periodic_cube(cells));
        CHECK(bcc.euler() == 0);
        CHECK(bcc.n.vertices.size() == 12 * cubes);  // tetrahedral sites
        for (const double radius : bcc.n.vertex_radii) CHECK(std::abs(radius - std::sqrt(5.0) / 4) < 1e-14);
        std::size_t squares = 0;  // faces with an octahedral site in the middle, seen from both sides
        for (std::size_t f = 0; f + 1 < bcc.t.face_offsets().size(); ++f)
            squares += bcc.t.face_offsets()[f + 1] - bcc.t.face_offsets()[f] == 4;
        CHECK(squares == 2 * 6 * cubes);
        CHECK(std::abs(bcc.n.largest_included().radius - std::sqrt(5.0) / 4) < 1e-14);
        CHECK(std::abs(bcc.n.largest_free().value().radius - 3 * std::sqrt(2.0) / 8) < 1e-14);
        for (const int axis : {0, 1, 2})
            CHECK(std::abs(fcc.n.largest_free(axis).value().radius - 1 / std::sqrt(6.0)) < 1e-14);
    }
}

TEST_CASE("network: radii are distances to the nearest seed") {
    const Case c(test::uniform(60, 4).points, periodic_cube(1));
    for (std::size_t v = 0; v < c.n.vertices.size(); ++v) {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < c.points.size(); i += 3) {
            double square = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double d = c.n.points[3 * v + k] - c.points[i + k];
                square += (d - std::round(d)) * (d - std::round(d));
            }
            nearest = std::min(nearest, std::sqrt(square));
        }
        CHECK(std::abs(c.n.vertex_radii[v] - nearest) < 1e-13);
    }
}

TEST_CASE("network: walls and bad input") {
    votess::Options options;
    options.box = test::cube(-0.5, 2.5);
    const Case c(test::cubic(3).points, options);
    CHECK(c.n.vertices.size() == 64);
    CHECK(c.n.edge_radii.size() == 144);
    CHECK(std::ranges::count(c.n.at_walls, 1) == 56);
    CHECK(!c.n.largest_free());
    CHECK(c.n.shifts.empty());
    CHECK_THROWS_AS((void)c.n.largest_free(3), votess::Error);
    const auto t = votess::tessellate(c.points, votess::Options{});
    CHECK_THROWS_AS((void)votess::network(t, c.points), votess::Error);
    CHECK(votess::network(c.t, c.points).vertices == c.n.vertices);
    const std::vector<double> weights(c.points.size() / 3, -1.0);
    votess::Options negative = c.options;
    negative.weights = weights;
    CHECK_THROWS_AS((void)votess::network(votess::tessellate(c.points, negative), c.points), votess::Error);
}
