// surface_cells(): parts tile the surface, threads, ties, the dual, refusals, stops. Fractions: test_surface.py.
// lloyd_on_surface(), remesh() and sample_surface().
#include "votess/surface.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "polytope/cell_kernels.hpp"

namespace {

struct Given {
    std::vector<double> vertices;
    std::vector<std::int32_t> triangles;
    [[nodiscard]] votess::TriangleMesh view() const { return {vertices, triangles}; }
};

// The octahedron, its triangles cut into n^2 and put onto the unit sphere.
Given sphere(int n) {
    Given s;
    for (const int x : {1, -1})
        for (const int y : {1, -1})
            for (const int z : {1, -1}) {
                const auto first = static_cast<std::int32_t>(s.vertices.size() / 3);
                for (int i = 0; i <= n; ++i)
                    for (int j = 0; j <= n - i; ++j) {
                        const double a = i, b = j, c = n - i - j, length = std::sqrt(a * a + b * b + c * c);
                        for (const double coordinate : {x * a, y * b, z * c}) s.vertices.push_back(coordinate / length);
                    }
                const auto at = [&](int i, int j) { return first + i * (n + 1) - i * (i - 1) / 2 + j; };
                const auto add = [&](std::int32_t u, std::int32_t v, std::int32_t w) {
                    if (x * y * z > 0) std::swap(v, w);
                    s.triangles.insert(s.triangles.end(), {u, v, w});
                };
                for (int i = 0; i < n; ++i)
                    for (int j = 0; j < n - i; ++j) {
                        add(at(i, j), at(i, j + 1), at(i + 1, j));
                        if (j + 1 < n - i) add(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
                    }
            }
    return s;
}

std::vector<double> places_on_sphere(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<double> points;
    for (std::size_t i = 0; i < count; ++i) {
        double x[3], square = 0;
        for (double& coordinate : x) coordinate = normal(random), square += coordinate * coordinate;
        for (const double coordinate : x) points.push_back(coordinate / std::sqrt(square));
    }
    return points;
}

double sum(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

votess::SurfaceCells cells_of(const std::vector<double>& points, const Given& surface,
                              const votess::SurfaceOptions& options = {}) {
    votess::TriangleMesh mesh = surface.view();
    mesh.merge = true;
    return votess::surface_cells(points, mesh, options);
}

}  // namespace

TEST_CASE("surface: the dual of cells on a sphere is a closed mesh, on any number of threads") {
    const Given surface = sphere(24);
    const auto points = places_on_sphere(300, 1);
    votess::SurfaceOptions options;
    options.threads = 1;
    const votess::SurfaceCells one = cells_of(points, surface, options);
    options.threads = 3;
    const votess::SurfaceCells three = cells_of(points, surface, options);
    CHECK(one.areas == three.areas);
    CHECK(one.centroids == three.centroids);
    CHECK(one.lengths == three.lengths);
    CHECK(one.vertices == three.vertices);
    CHECK(one.dual == three.dual);
    CHECK(one.faults().empty());
    CHECK(one.dual.size() == 3 * (2 * 300 - 4));
    double area = 0;
    for (std::size_t t = 0; t < surface.triangles.size(); t += 3) {
        const auto x = [&](std::size_t i, std::size_t k) {
            return surface.vertices[3 * static_cast<std::size_t>(surface.triangles[t + i]) + k];
        };
        double square = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            const double c = (x(1, l) - x(0, l)) * (x(2, m) - x(0, m)) - (x(1, m) - x(0, m)) * (x(2, l) - x(0, l));
            square += c * c;
        }
        area += 0.5 * std::sqrt(square);
    }
    CHECK(std::abs(sum(one.areas) / area - 1) < 1e-13);
    // Each edge is run along once in each direction, and triangles are counterclockwise seen from outside.
    std::set<std::pair<std::int32_t, std::int32_t>> edges;
    for (std::size_t t = 0; t < one.dual.size(); t += 3) {
        for (std::size_t k = 0; k < 3; ++k) CHECK(edges.insert({one.dual[t + k], one.dual[t + (k + 1) % 3]}).second);
        const double* const a = &points[3 * static_cast<std::size_t>(one.dual[t])];
        const double* const b = &points[3 * static_cast<std::size_t>(one.dual[t + 1])];
        const double* const c = &points[3 * static_cast<std::size_t>(one.dual[t + 2])];
        CHECK(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                  a[2] * (b[0] * c[1] - b[1] * c[0]) >
              0);
    }
    for (const auto& [from, to] : edges) CHECK(edges.count({to, from}) == 1);
}

TEST_CASE("surface: all vector instructions give equal digits") {
    const Given surface = sphere(12);
    const auto points = places_on_sphere(3000, 2);
    const auto kernels = votess::cpu::supported_kernels();
    const votess::SurfaceCells best = cells_of(points, surface);
    for (const votess::cpu::Kernels* const other : kernels) {
        votess::cpu::set_best_kernels(*other);
        const votess::SurfaceCells cells = cells_of(points, surface);
        CHECK(cells.areas == best.areas);
        CHECK(cells.vertices == best.vertices);
        CHECK(cells.lengths == best.lengths);
    }
    votess::cpu::set_best_kernels(*kernels.front());
}

TEST_CASE("surface: ties go to the lowest seed, and polygons share corners") {
    const Given square{{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 3}};
    // Two layers of a lattice: pairs of seeds mirrored by the square.
    std::vector<double> points;
    for (const double x : {0.125, 0.375, 0.625, 0.875})
        for (const double y : {0.125, 0.375, 0.625, 0.875})
            for (const double z : {0.5, -0.5}) points.insert(points.end(), {x, y, z});
    const votess::SurfaceCells cells = votess::surface_cells(points, square.view());
    for (std::size_t i = 0; i < cells.size(); ++i) CHECK(cells.areas[i] == (i % 2 == 0 ? 0.0625 : 0));
    CHECK(cells.faults().empty());
    CHECK(cells.dual.size() == 3 * 18);
    for (const std::int32_t seed : cells.indices) CHECK(seed % 2 == 0);
    CHECK(cells.indices.size() == 2 * 24);
}

TEST_CASE("surface: all threads share a triangle of many cells") {
    const Given square{{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 3}};
    std::vector<double> points;
    for (std::uint32_t i = 0, state = 1; i < 30000; ++i) {
        state = state * 1664525 + 1013904223;
        points.push_back(i % 3 == 2 ? 0 : state * 0x1p-32);
    }
    const votess::SurfaceCells one = votess::surface_cells(points, square.view(), {.threads = 1});
    const votess::SurfaceCells three = votess::surface_cells(points, square.view(), {.threads = 3});
    CHECK(std::abs(sum(one.areas) - 1) < 1e-13);
    CHECK(one.areas == three.areas);
    CHECK(one.indices == three.indices);
    CHECK(one.corners == three.corners);
    CHECK(one.vertices == three.vertices);
    const votess::SurfaceCells areas =
        votess::surface_cells(points, square.view(), {.want = votess::SurfaceWant::areas, .threads = 3});
    CHECK(areas.areas == one.areas);
    CHECK(areas.borders == one.borders);
    CHECK(areas.indptr.empty());
    CHECK_THROWS_AS((void)areas.faults(), votess::Error);
}

TEST_CASE("surface: refuses what it cannot read, and stops") {
    const Given square{{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 3}};
    const std::vector<double> points{0.5, 0.5, 0};
    const auto message = [&](const std::vector<double>& seeds, const Given& surface,
                             const votess::SurfaceOptions& options = {}) -> std::string {
        try {
            (void)votess::surface_cells(seeds, surface.view(), options);
        } catch (const votess::Error& error) {
            CHECK(error.code() == votess::ErrorCode::invalid_argument);
            return error.what();
        }
        return "";
    };
    CHECK(message({}, square) == "there are no points: give at least one");
    CHECK(message({0, 0, NAN}, square) == "point 0: z = nan is not finite");
    CHECK(message(points, {square.vertices, {}}) == "surface: it has no triangles: give a surface");
    CHECK(message(points, {square.vertices, {0, 1, 4}}) ==
          "surface: triangle 0 names vertex 4, but there are 4: give indices from 0 on");
    CHECK(message(points, {square.vertices, {0, 0, 1}}) == "surface: its triangles have no area");
    const std::vector<double> weights{1, 2};
    CHECK(message(points, square, {.weights = weights}) ==
          "SurfaceOptions::weights hold 2 numbers for 1 points: give one for each");
    const Given ball = sphere(40);
    votess::SurfaceOptions options;
    options.progress = [](double) { return false; };
    CHECK_THROWS_AS((void)cells_of(places_on_sphere(2000, 2), ball, options), votess::Error);
}

TEST_CASE("surface: relaxation spreads seeds, and the fixed ones stay") {
    const Given ball = sphere(12);
    const std::vector<double> points = places_on_sphere(60, 3);
    std::vector<std::uint8_t> fixed(60);
    fixed[7] = 1;
    const auto relaxed = votess::lloyd_on_surface(points, ball.view(), {.steps = 12, .fixed = fixed, .threads = 2});
    REQUIRE(relaxed.energies.size() == 13);
    for (std::size_t k = 1; k < 13; ++k) CHECK(relaxed.energies[k] <= relaxed.energies[k - 1] * (1 + 1e-12));
    CHECK(relaxed.energies.back() < 0.8 * relaxed.energies.front());
    for (std::size_t k = 21; k < 24; ++k) CHECK(relaxed.points[k] == points[k]);
    const auto alone = votess::lloyd_on_surface(points, ball.view(), {.steps = 12, .fixed = fixed, .threads = 1});
    CHECK(alone.points == relaxed.points);
    const auto early = votess::lloyd_on_surface(points, ball.view(), {.tolerance = 0.1});
    CHECK(early.moved.size() < 100);
    CHECK(early.moved.back() <= 0.1);
}

TEST_CASE("surface: a new mesh is closed, as the surface is") {
    // Each edge joins two triangles that run along it in opposite directions.
    const auto is_closed = [](const votess::Remesh& mesh) {
        std::set<std::pair<std::int32_t, std::int32_t>> sides;
        for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
            if (!sides.insert({mesh.triangles[k], mesh.triangles[k % 3 == 2 ? k - 2 : k + 1]}).second) return false;
        return std::ranges::all_of(sides, [&](const auto& side) { return sides.contains({side.second, side.first}); });
    };
    Given ball = sphere(12);
    votess::TriangleMesh view = ball.view();
    view.merge = true;
    const votess::Remesh round = votess::remesh(view, 200, {.steps = 15});
    CHECK(round.vertices.size() == 600);
    CHECK(round.triangles.size() == 3 * 396);
    CHECK(is_closed(round));
    CHECK(round.faults.empty());
    CHECK(round.min_angle > 25);
    CHECK(round.mean_min_angle > 45);
    // A chord of the sphere with the length of its triangles' sides, about sqrt(4 pi / 200 * 1.15), is 0.01 deep.
    CHECK(round.distance > 0.005);
    CHECK(round.distance < 0.03);
    const votess::Remesh again = votess::remesh(view, 200, {.steps = 15, .threads = 1});
    CHECK(again.vertices == round.vertices);
    CHECK(again.triangles == round.triangles);
    // A plate thinner than its triangles has cells on both sides.
    for (std::size_t k = 2; k < ball.vertices.size(); k += 3) ball.vertices[k] *= 0.01;
    const votess::Remesh flat = votess::remesh(view, 200, {.steps = 15});
    CHECK(is_closed(flat));
    CHECK(flat.faults.empty());
    CHECK(flat.points.size() < 0.8 * static_cast<double>(flat.vertices.size()));
}

TEST_CASE("surface: places on it, and refusals of a mesh") {
    const Given square{{0, 0, 5, 1, 0, 5, 1, 1, 5, 0, 1, 5}, {0, 1, 2, 0, 2, 3}};
    const std::vector<double> places = votess::sample_surface(square.view(), 1000, 4);
    REQUIRE(places.size() == 3000);
    double below = 0;
    for (std::size_t i = 0; i < 1000; ++i) {
        CHECK(places[3 * i + 2] == 5);
        CHECK(std::min(places[3 * i], places[3 * i + 1]) >= 0);
        CHECK(std::max(places[3 * i], places[3 * i + 1]) <= 1);
        below += places[3 * i + 1] <= places[3 * i] ? 1 : 0;
    }
    CHECK(below == 500);  // one place in each stretch of equal area
    const auto message = [&](std::size_t count, const votess::RemeshOptions& options = {}) -> std::string {
        try {
            (void)votess::remesh(square.view(), count, options);
        } catch (const votess::Error& error) {
            return error.what();
        }
        return "";
    };
    CHECK(message(0) == "the number of vertices is 0: give at least 1");
    CHECK(message(2147483647) == "the number of vertices is 2147483647, which is too many: give at most 268435456");
    CHECK(message(5, {.sharp = 0}) == "RemeshOptions::sharp is 0: give an angle above 0, up to 180 degrees");
    CHECK_THROWS_AS((void)votess::remesh(square.view(), 500, {.progress = [](double) { return false; }}),
                    votess::Error);
    CHECK_THROWS_AS((void)votess::lloyd_on_surface(places, square.view(), {.tolerance = -1}), votess::Error);
    const std::vector<std::uint8_t> fixed(3);
    CHECK_THROWS_AS((void)votess::lloyd_on_surface(places, square.view(), {.fixed = fixed}), votess::Error);
    const votess::Remesh point = votess::remesh(square.view(), 1);
    CHECK(point.triangles.empty());
    CHECK(std::isinf(point.distance));
}
