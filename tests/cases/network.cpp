// The network: Euler's formula, sites of lattices, radii and largest spheres by definition.
#include "votess/network.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
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

// Small spheres and some large ones, by definition.
TEST_CASE("network: radii are distances to the nearest surface") {
    for (int trial = 0; trial < 16; ++trial) {
        CAPTURE(trial);
        test::Random random(40 + static_cast<std::uint64_t>(trial));
        const std::size_t count = 60;
        std::vector<double> radii(count);
        for (double& r : radii) r = random.uniform(0, 0.05);
        for (int k = 0; k < 1 + trial % 3; ++k) radii[static_cast<std::size_t>(7 * k)] = random.uniform(0.1, 0.4);
        const bool periodic = trial % 2 == 0;
        votess::Options options = periodic_cube(1);
        options.periodic = {periodic, periodic, periodic};
        options.radii = radii;
        const Case c(test::uniform(count, 50 + static_cast<std::uint64_t>(trial)).points, options);
        const auto nearest = [&](const std::array<double, 3>& x) {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < count; ++i) {
                double square = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double d = c.points[3 * i + k] - x[k], rest = periodic ? d - std::round(d) : d;
                    square += rest * rest;
                }
                least = std::min(least, std::sqrt(square) - radii[i]);
            }
            return least;
        };
        std::size_t outside = 0;
        for (std::size_t v = 0; v < c.n.vertices.size(); ++v) {
            const double expected = nearest({c.n.points[3 * v], c.n.points[3 * v + 1], c.n.points[3 * v + 2]});
            if (expected < 0) continue;  // within a sphere
            ++outside;
            REQUIRE(std::abs(c.n.vertex_radii[v] - expected) < 1e-12);
        }
        CHECK(outside > count);
        for (std::size_t e = 0; e < c.n.edge_radii.size(); ++e) {
            if (c.n.edge_radii[e] < 0) continue;
            double least = std::numeric_limits<double>::infinity();
            for (int step = 0; step <= 16; ++step) {
                std::array<double, 3> x{};
                for (std::size_t k = 0; k < 3; ++k) {
                    const double shift = periodic ? c.n.shifts[3 * e + k] : 0;
                    const auto from = static_cast<std::size_t>(c.n.edges[2 * e]),
                               to = static_cast<std::size_t>(c.n.edges[2 * e + 1]);
                    x[k] = std::lerp(c.n.points[3 * from + k], c.n.points[3 * to + k] + shift, step / 16.0);
                }
                least = std::min(least, nearest(x));
            }
            REQUIRE(c.n.edge_radii[e] <= least + 1e-12);
            REQUIRE(c.n.edge_radii[e] > least - 0.1);
        }
    }
}

TEST_CASE("network: radii in any unit") {
    const auto in_unit = [](int exponent, bool spheres) {
        test::Coordinates points = test::uniform(40, 3).points;
        std::vector<double> radii(spheres ? 40 : 0);
        for (std::size_t i = 0; i < radii.size(); ++i) radii[i] = std::ldexp(i % 9 == 0 ? 0.3 : 0.02, exponent);
        for (double& x : points) x = std::ldexp(x, exponent);
        votess::Options options = periodic_cube(std::ldexp(1.0, exponent));
        options.radii = radii;
        return Case(points, options).n;
    };
    for (const auto& [exponent, spheres] : {std::pair{500, true}, {-500, true}, {900, false}, {-900, false}}) {
        CAPTURE(exponent);
        const votess::Network one = in_unit(0, spheres), other = in_unit(exponent, spheres);
        CHECK(one.edges == other.edges);
        for (const auto radii : {&votess::Network::vertex_radii, &votess::Network::edge_radii}) {
            std::vector<double> expected = one.*radii;
            for (double& radius : expected) radius = std::ldexp(radius, exponent);
            CHECK(expected == other.*radii);
        }
    }
}

// Many of these have no cell in the domain, or reach places from outside of it.
TEST_CASE("network: spheres of seeds outside count") {
    for (int trial = 0; trial < 24; ++trial) {
        CAPTURE(trial);
        test::Random random(400 + static_cast<std::uint64_t>(trial));
        const bool periodic = trial % 3 == 1, slanted = trial % 3 == 2;
        votess::Options options;
        options.box = votess::Box{{periodic ? 0 : 0.3, 0.35, 0.3}, {periodic ? 1 : 0.7, 0.6, 0.65}};
        options.periodic = {periodic, false, false};
        if (slanted) options.walls = {{{1, 1, 0.5}, 1.1}}, options.box = votess::Box{{0.2, 0.2, 0.2}, {0.7, 0.7, 0.7}};
        options.outside = votess::Outside::keep;
        const std::size_t count = trial < 6 ? 2 : 25;
        std::vector<double> radii(count);
        for (double& r : radii) r = random.uniform(0, random.chance(0.2) ? 0.4 : 0.1);
        options.radii = radii;
        const Case c(test::uniform(count, 500 + static_cast<std::uint64_t>(trial)).points, options);
        for (std::size_t v = 0; v < c.n.vertices.size(); ++v) {
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t i = 0; i < count; ++i) {
                double square = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double d = c.points[3 * i + k] - c.n.points[3 * v + k];
                    const double rest = periodic && k == 0 ? d - std::round(d) : d;
                    square += rest * rest;
                }
                least = std::min(least, std::sqrt(square) - radii[i]);
            }
            if (least > 0) CHECK(std::abs(c.n.vertex_radii[v] - least) < 1e-12);
        }
    }
}

// Two channels of equal room, one of which leads to a wider pore.
TEST_CASE("network: the edge and the pore of a free sphere lie in one region") {
    for (const bool swapped : {false, true}) {
        votess::Network n;
        // Vertices 0 and 1 are one channel along x, 2 and 3 the other.
        n.vertex_radii = {2, 3, 2, 5};
        if (swapped) n.vertex_radii = {2, 5, 2, 3};
        n.points.assign(12, 0);
        n.edges = {0, 1, 0, 1, 2, 3, 2, 3};
        n.shifts = {0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0};
        n.edge_radii = {1.5, 1, 1.5, 1};
        for (const std::optional<int> axis : {std::optional<int>(), std::optional<int>(0)}) {
            const auto found = n.largest_free(axis).value();
            CHECK(found.radius == 1);
            CHECK(found.included.radius == 5);
            CHECK(found.included.vertex == (swapped ? 1 : 3));
            CHECK(found.edge == (swapped ? 1 : 3));
        }
        CHECK(!n.largest_free(1));
    }
    // Random graphs: the edge leads to the vertex by edges with as much room.
    test::Random random(5);
    for (int trial = 0; trial < 300; ++trial) {
        votess::Network n;
        const std::size_t vertices = 2 + random.below(8);
        for (std::size_t v = 0; v < vertices; ++v) n.vertex_radii.push_back(static_cast<double>(3 + random.below(5)));
        for (std::size_t e = 0; e < 12; ++e) {
            n.edges.push_back(static_cast<std::int32_t>(random.below(vertices)));
            n.edges.push_back(static_cast<std::int32_t>(random.below(vertices)));
            for (int k = 0; k < 3; ++k) n.shifts.push_back(static_cast<std::int8_t>(random.below(2)));
            n.edge_radii.push_back(static_cast<double>(random.below(4)));
        }
        const auto found = n.largest_free();
        if (!found) continue;
        std::set<std::int32_t> region{n.edges[2 * static_cast<std::size_t>(found->edge)]};
        for (std::size_t rounds = 0; rounds < vertices; ++rounds)
            for (std::size_t e = 0; e < 12; ++e)
                if (n.edge_radii[e] >= found->radius)
                    for (const std::size_t end : {2 * e, 2 * e + 1})
                        if (region.contains(n.edges[end])) region.insert(n.edges[end ^ 1]);
        CHECK(region.contains(found->included.vertex));
        CHECK(n.edge_radii[static_cast<std::size_t>(found->edge)] == found->radius);
        for (const std::int32_t v : region)
            CHECK(n.vertex_radii[static_cast<std::size_t>(v)] <= found->included.radius);
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
