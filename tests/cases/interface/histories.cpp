// A Tessellator that is kept gives what a new one gives, whatever its earlier calls were: every domain, every group of
// arrays, on the CPU and on a GPU. VOTESS_TEST_STEPS sets the length of the random histories.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "support/check.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"

namespace {

using votess::Options;
using votess::Want;

struct Case {
    std::string name;
    test::Coordinates points;
    Options options;
    std::vector<double> weights, radii;  // instead of the options', as are the following
    std::vector<std::int64_t> only;
    test::Solid solid;
    bool narrow = false;  // float32

    [[nodiscard]] votess::Tessellation on(votess::Tessellator& tessellator) const {
        Options given = options;
        given.weights = weights;
        given.radii = radii;
        if (!only.empty()) given.only = only;
        if (!solid.triangles.empty()) given.mesh = solid.mesh();
        if (!narrow) return tessellator.tessellate(points, given);
        const std::vector<float> floats(points.begin(), points.end());
        return tessellator.tessellate(floats, given);
    }
    [[nodiscard]] votess::Tessellation alone() const {
        votess::Tessellator fresh;
        return on(fresh);
    }
};

Case call(const std::string& name, const test::Coordinates& points) {
    Case c;
    c.name = name;
    c.points = points;
    c.options = test::all_options(test::unit_box());
    return c;
}

void copy_seed(test::Coordinates& points, std::size_t from, std::size_t to) {
    for (std::size_t k = 0; k < 3; ++k) points[3 * to + k] = points[3 * from + k];
}

Want everything() {
    return {true, true, true, true, true, true, true, true, true, true};
}

// One box, mostly the same seeds, so that the rest of another call would fit.
std::vector<Case> kinds_of_seeds(std::size_t n) {
    const test::Coordinates seeds = test::uniform(n, 85).points;
    test::Random random(86);
    std::vector<Case> calls{call("uniform", seeds), call("clustered", test::clustered(n, 87).points),
                            call("fewer", test::uniform(n / 3, 88).points), call("none", {}),
                            call("one", {0.5, 0.25, 0.5})};
    auto add = [&](const std::string& name) -> Case& { return calls.emplace_back(call(name, seeds)); };
    for (double& x : add("moved").points) x = std::clamp(x + 1e-3 * random.uniform(-1, 1), 0.0, 1.0);
    Case& some_equal = add("some are equal");
    for (std::size_t i = 0; i + 20 < n; i += 20) copy_seed(some_equal.points, i, i + 1 + random.below(19));
    Case& equal = add("all are equal");
    for (std::size_t i = 1; i < n; ++i) copy_seed(equal.points, 0, i);
    Case& dropped = add("some are dropped");
    dropped.options.outside = votess::Outside::drop;
    for (std::size_t i = 0; i < n; i += 7) dropped.points[3 * i + i % 3] += i % 2 == 0 ? 1 : -1;
    Case& gone = add("all but one are dropped");
    gone.options.outside = votess::Outside::drop;
    for (std::size_t i = 1; i < n; ++i) gone.points[3 * i] += 2;
    Case& weighted = add("weights");
    for (std::size_t i = 0; i < n; ++i) weighted.weights.push_back(1e-5 * random.uniform());
    Case& buried = add("some are buried at their place or equal");
    for (std::size_t i = 0; i < n; ++i) buried.weights.push_back(1e-4 * static_cast<double>(i % 3));
    for (std::size_t i = 3; i < n; i += 5) copy_seed(buried.points, i - 1 - i % 3, i);
    Case& one_heavy = add("one buries all others");
    one_heavy.weights.assign(n, 0);
    one_heavy.weights[n / 2] = 10;
    add("periodic").options.periodic = {true, false, true};
    Case& wall = add("a wall, some are dropped");
    wall.options.walls.push_back({{1, 1, 1}, 2});
    wall.options.outside = votess::Outside::drop;
    add("larger box").options.box = test::cube(-3, 40);  // another scale
    add("no box").options.box.reset();
    add("float32").narrow = true;
    Case& baseline = add("other instructions and threads");
    baseline.options.instructions = "baseline";
    baseline.options.threads = 3;
    baseline.options.grid_resolution = 2;
    Case& rows = add("rows of seeds alone");
    rows.options.want = {.volumes = false};
    rows.options.list_walls = false;
    add("volumes alone").options.want = {.neighbors = false};
    return calls;
}

// Every kind of domain.
std::vector<Case> kinds_of_domains(std::size_t n) {
    constexpr double end = std::numeric_limits<double>::infinity();
    const test::Coordinates seeds = test::uniform(n, 91).points;
    std::vector<Case> calls;
    const auto add = [&](const std::string& name) -> Case& {
        Case& c = calls.emplace_back(call(name, seeds));
        c.options.want = everything();
        return c;
    };
    add("box");
    add("one axis repeats").options.periodic = {false, true, false};
    add("all axes repeat").options.periodic = {true, true, true};
    const auto cell = [&](const std::string& name) -> Case& {
        Case& c = add(name);
        c.options.box.reset();
        c.options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.3, 1, 0}, {0, -0.2, 1}};
        return c;
    };
    cell("triclinic");
    Case& slab = cell("triclinic slab");
    slab.options.cell->periodic = {true, true, false};
    slab.options.outside = votess::Outside::drop;
    add("walls").options.walls = test::octahedron(0.8);
    calls.back().options.outside = votess::Outside::keep;
    Case& kept = add("seeds outside");
    kept.options.outside = votess::Outside::keep;
    kept.options.box = test::cube(0.2, 0.7);
    const auto endless = [&](const std::string& name) -> Case& {
        Case& c = add(name);
        c.options.box = test::cube(-end, end);
        return c;
    };
    endless("all of space");
    endless("two seeds in all of space").points.resize(6);
    endless("a tetrahedron in all of space").points.resize(12);
    endless("half of space").options.box->upper[2] = 1;
    const auto plane = [&](const std::string& name) -> Case& {
        Case& c = add(name);
        c.points.resize(2 * n);
        c.options.planar = true;
        c.options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
        return c;
    };
    plane("plane");
    plane("periodic plane").options.periodic = {true, true, false};
    plane("plane without end").options.box = votess::Box{{-end, -end, 0}, {end, end, 0}};
    Case& oblique = plane("oblique plane");
    oblique.options.box.reset();
    oblique.options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {0, 0, 0}, {true, true, false}};
    const auto mesh = [&](const std::string& name) -> Case& {
        Case& c = add(name);
        c.solid = test::cuboid(0.3, 0.8);
        c.options.list_walls = false;
        c.options.want.counts = c.options.want.radii = c.options.want.vertices = c.options.want.faces = false;
        return c;
    };
    mesh("mesh");
    mesh("mesh, volumes alone").options.want = {.neighbors = false};
    mesh("periodic mesh").options.periodic = {true, true, true};
    Case& polygon = mesh("polygon");
    polygon.points.resize(2 * n);
    polygon.options.planar = true;
    polygon.options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
    polygon.solid = {{0.3, 0.3, 0.8, 0.3, 0.8, 0.8, 0.3, 0.8}, {0, 1, 1, 2, 2, 3, 3, 0}};
    const auto some = [&](Case& c) {
        for (std::size_t i = 0; i < n; i += 3) c.only.push_back(static_cast<std::int64_t>(n - 1 - i));
    };
    some(add("a subset"));
    some(endless("a subset in all of space"));
    some(mesh("a subset in a mesh"));
    add("radii").radii.assign(n, 0.01);
    calls.back().radii[n / 2] = 0.3;
    endless("weights in all of space").weights.assign(n, 0.5);
    add("small faces dropped").options.min_face = 0.2;
    plane("short edges dropped").options.min_face = 0.2;
    add("none").points.clear();
    plane("none in the plane").points.clear();
    return calls;
}

std::size_t random_steps() {
    const char* const steps = std::getenv("VOTESS_TEST_STEPS");
    return steps != nullptr ? static_cast<std::size_t>(std::atoll(steps)) : test::by_size(300, 100);
}

// Visits each ordered pair of numbers below `count` once, one after the other.
template <class Step>
void for_each_pair(std::size_t count, Step step) {
    for (std::size_t first = 0; first < count; ++first) {
        step(first), step(first);
        for (std::size_t then = first + 1; then < count; ++then) step(then), step(first);
    }
}

void check_pairs(const std::vector<Case>& calls) {
    std::vector<votess::Tessellation> expected;
    for (const Case& c : calls) expected.push_back(c.alone());
    votess::Tessellator kept;
    std::string last;
    for_each_pair(calls.size(), [&](std::size_t i) {
        CAPTURE(last);
        CAPTURE(calls[i].name);
        REQUIRE(test::check_same_result(calls[i].on(kept), expected[i]) == "");
        last = calls[i].name;
    });
}

}  // namespace

TEST_SUITE("interface") {
    TEST_CASE("histories: any call after any other, seeds") {
        check_pairs(kinds_of_seeds(test::by_size(80, 40)));
    }

    TEST_CASE("histories: any call after any other, domains") {
        check_pairs(kinds_of_domains(test::by_size(16, 12)));
    }

    TEST_CASE("histories: random calls, some results kept") {
        std::vector<Case> calls = kinds_of_domains(16);
        std::ranges::move(kinds_of_seeds(24), std::back_inserter(calls));
        test::Random random(92);
        const std::size_t plain = calls.size();
        for (std::size_t k = 0; k < plain; ++k) {  // again, with other groups of arrays
            Case c = calls[k];
            for (bool Want::*word : {&Want::neighbors, &Want::volumes, &Want::centroids, &Want::counts, &Want::areas,
                                     &Want::normals, &Want::surfaces, &Want::radii, &Want::vertices, &Want::faces})
                c.options.want.*word = c.options.want.*word && random.chance(0.5);
            c.options.list_walls = c.options.list_walls && random.chance(0.5);
            c.name += ", other arrays";
            calls.push_back(std::move(c));
        }
        std::vector<votess::Tessellation> expected;
        for (const Case& c : calls) expected.push_back(c.alone());
        votess::Tessellator kept;
        std::vector<votess::Tessellation> held(3);
        for (std::size_t step = 0; step < random_steps(); ++step) {
            const std::size_t i = random.below(calls.size());
            CAPTURE(step);
            CAPTURE(calls[i].name);
            const votess::Tessellation t = calls[i].on(kept);
            REQUIRE(test::check_same_result(t, expected[i]) == "");
            if (random.chance(0.3)) held[random.below(held.size())] = t;
            if (random.chance(0.3)) held[random.below(held.size())] = {};
        }
    }

    TEST_CASE("histories: the kinds of calls are what their names say") {
        for (const Case& c : kinds_of_seeds(60)) {
            CAPTURE(c.name);
            const auto t = c.alone();
            const bool drops = c.options.outside == votess::Outside::drop;
            const auto has = [&](votess::CellStatus status) { return std::ranges::count(t.status(), status) > 0; };
            CHECK(has(votess::CellStatus::outside) == drops);
            CHECK(has(votess::CellStatus::duplicate) == c.name.ends_with("equal"));
            CHECK(has(votess::CellStatus::empty) == (c.name.find("bur") != std::string::npos));
        }
    }
}
