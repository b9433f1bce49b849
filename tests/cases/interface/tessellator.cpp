// A Tessellator that is kept gives what a new one gives, whatever its earlier calls were. Results, stats and devices.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>
#include <votess/alpha.hpp>
#include <votess/network.hpp>
#include <votess/pieces.hpp>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

struct Case {
    std::string name;
    test::Coordinates points;
    votess::Options options;
    std::vector<double> weights;  // instead of the options'
    bool narrow = false;          // float32

    [[nodiscard]] votess::Tessellation on(votess::Tessellator& tessellator) const {
        votess::Options with_weights = options;
        with_weights.weights = weights;
        if (!narrow) return tessellator.tessellate(points, with_weights);
        const std::vector<float> floats(points.begin(), points.end());
        return tessellator.tessellate(floats, with_weights);
    }
};

Case call(const std::string& name, const test::Coordinates& points) {
    return {name, points, test::all_options(test::unit_box()), {}};
}

void copy_seed(test::Coordinates& points, std::size_t from, std::size_t to) {
    for (std::size_t k = 0; k < 3; ++k) points[3 * to + k] = points[3 * from + k];
}

// Mostly of the same seeds, so that what is left of another call would fit.
std::vector<Case> all_kinds(std::size_t n) {
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

}  // namespace

TEST_SUITE("interface") {
    TEST_CASE("tessellator: any call after any other") {
        const std::vector<Case> calls = all_kinds(test::by_size(150, 60));
        std::vector<votess::Tessellation> expected;
        for (const Case& c : calls) {
            votess::Tessellator fresh;
            expected.push_back(c.on(fresh));
        }
        votess::Tessellator kept;
        for (std::size_t first = 0; first < calls.size(); ++first)
            for (std::size_t then = 0; then < calls.size(); ++then) {
                CAPTURE(calls[first].name);
                CAPTURE(calls[then].name);
                REQUIRE(test::check_identical(calls[first].on(kept), expected[first]) == "");
                REQUIRE(test::check_identical(calls[then].on(kept), expected[then]) == "");
            }
    }

    TEST_CASE("tessellator: the kinds of calls are what their names say") {
        const std::vector<Case> calls = all_kinds(60);
        for (const Case& c : calls) {
            CAPTURE(c.name);
            votess::Tessellator fresh;
            const auto t = c.on(fresh);
            const bool drops = c.options.outside == votess::Outside::drop;
            const auto has = [&](votess::CellStatus status) { return std::ranges::count(t.status(), status) > 0; };
            CHECK(has(votess::CellStatus::outside) == drops);
            CHECK(has(votess::CellStatus::duplicate) == c.name.ends_with("equal"));
            CHECK(has(votess::CellStatus::empty) == (c.name.find("bur") != std::string::npos));
        }
    }

    TEST_CASE("tessellator: seeds that move") {
        const std::size_t n = test::by_size(6000, 600);
        const double spacing = 1 / std::cbrt(static_cast<double>(n));
        for (const unsigned threads : {1u, 3u})
            for (const double distance : {0.0, 1e-12, 0.01, 1.0}) {
                CAPTURE(distance);
                test::Random random(71);
                Case c = call("moving", test::uniform(n, 72).points);
                c.options.threads = threads;
                votess::Tessellator kept;
                for (int step = 0; step < 3; ++step) {
                    votess::Tessellator fresh;
                    const auto t = c.on(kept);
                    CHECK(test::check_identical(t, c.on(fresh)) == "");
                    CHECK(test::check_invariants(t, c.points) == "");
                    for (double& x : c.points) x = std::clamp(x + distance * spacing * random.uniform(-1, 1), 0.0, 1.0);
                }
            }
    }

    TEST_CASE("tessellator: a Tessellator that was moved from refuses") {
        const test::PointSet set = test::uniform(100, 74);
        votess::Tessellator tessellator;
        const votess::Tessellator other = std::move(tessellator);
        CHECK(test::error_of([&] { (void)tessellator.tessellate(set.points); }) == votess::ErrorCode::invalid_use);
        tessellator = votess::Tessellator();
        CHECK(tessellator.tessellate(set.points).size() == 100);
    }

    TEST_CASE("tessellator: a result outlives its Tessellator and its copies") {
        const test::PointSet set = test::uniform(500, 84);
        const auto expected = test::run(set);
        votess::Tessellation kept;
        {
            votess::Tessellator tessellator;
            const auto t = tessellator.tessellate(set.points, test::all_options(set.box));
            kept = t;
            const auto other = tessellator.tessellate(test::uniform(700, 85).points);
            CHECK(other.size() == 700);
        }
        CHECK(test::check_identical(expected, kept) == "");
    }

    TEST_CASE("tessellator: a Tessellation that was moved from, or default-constructed, is empty") {
        votess::Tessellation t = votess::tessellate(test::uniform(20, 84).points, test::all_options());
        const votess::Tessellation taken = std::move(t);
        CHECK(taken.size() == 20);
        const votess::Tessellation none, null(nullptr);
        for (const votess::Tessellation* empty :
             {&std::as_const(t), &none, &null}) {  // NOLINT(bugprone-use-after-move)
            const votess::Tessellation& e = *empty;
            CHECK(e.size() == 0);
            CHECK(e.indptr().size() == 1);
            CHECK(e.indptr()[0] == 0);
            CHECK(e.neighbors(0).empty());
            for (const auto size : {e.indices().size(),
                                    e.face_areas().size(),
                                    e.face_normals().size(),
                                    e.shifts().size(),
                                    e.volumes().size(),
                                    e.centroids().size(),
                                    e.face_counts().size(),
                                    e.edge_counts().size(),
                                    e.vertex_counts().size(),
                                    e.surface_areas().size(),
                                    e.mesh_areas().size(),
                                    e.security_radii().size(),
                                    e.vertices().size(),
                                    e.face_offsets().size(),
                                    e.face_vertices().size(),
                                    e.cell_vertex_indptr().size(),
                                    e.cell_vertex_indices().size(),
                                    e.status().size(),
                                    e.duplicate_of().size(),
                                    e.walls().size(),
                                    e.weights().size(),
                                    e.ids().size()})
                CHECK(size == 0);
            CHECK(e.least_face() == 0);
            CHECK(e.box().upper == std::array<double, 3>{});
            CHECK(e.periodic() == std::array<bool, 3>{});
            CHECK(!e.cell());
            CHECK_FALSE((e.planar() || e.lists_walls() || e.probed() || e.in_mesh() || e.is_subset()));
            CHECK(e.stats().points == 0);
            CHECK(votess::verify(e, {}).passed);
            CHECK(votess::wrapped_points(e, {}).empty());
            CHECK(votess::delaunay(e).tetrahedra.empty());
            CHECK(votess::network(e, {}).points.empty());
            CHECK(votess::alpha_complex(e, {}).simplices[0].seeds.empty());
            CHECK_THROWS_AS((void)votess::pieces(e), votess::Error);
        }
        t = taken;
        CHECK(t.size() == 20);
    }

    TEST_CASE("tessellator: stats") {
        const test::PointSet set = test::cubic(8);
        const auto t = test::run(set);
        CHECK(t.stats().points == 512);
        CHECK(t.stats().faces == 512 * 6);
        CHECK(t.stats().mean_faces == 6);
        CHECK(t.stats().box_volume == 512);
        CHECK(t.stats().exact_cells > 0);  // a lattice is all ties
        CHECK(test::run(test::uniform(500, 87)).stats().fallback_cells == 0);
    }

    TEST_CASE("tessellator: devices") {
        const auto all = votess::devices();
        REQUIRE_FALSE(all.empty());
        CHECK(std::any_of(all.begin(), all.end(), [](const auto& device) { return device.id == "cpu"; }));
        for (const auto& device : all) {
            CHECK(device.name != "");
            votess::Options options;
            options.device = device.id;
            CHECK(votess::tessellate(test::uniform(50, 92).points, options).size() == 50);
        }
    }
}
