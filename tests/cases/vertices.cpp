// Wanted vertices and faces: shared vertices and polygons.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "support/check.hpp"
#include "support/mesh.hpp"
#include "support/random.hpp"

TEST_SUITE("cases") {
    TEST_CASE("vertices: uniform seeds, each interior vertex is shared by four cells") {
        const auto set = test::uniform(test::by_size(30000, 5000), 71);
        const auto t = test::mesh_of(set);
        CHECK(test::check_mesh(t, set.points) == "");
        const auto cells = test::cells_of_vertices(t);
        const auto interior = test::interior_vertices(t);
        std::size_t inside = 0;
        for (std::size_t v = 0; v < cells.size(); ++v) {
            if (!interior[v]) continue;
            ++inside;
            REQUIRE(cells[v] == 4);
        }
        CHECK(inside > 5 * set.size());
        double worst = 0;
        for (std::size_t i = 0; i < t.size(); ++i) {
            double sum[3]{};
            for (auto e = static_cast<std::size_t>(t.indptr()[i]); e < static_cast<std::size_t>(t.indptr()[i + 1]); ++e)
                for (std::size_t k = 0; k < 3; ++k) sum[k] += t.face_areas()[e] * t.face_normals()[3 * e + k];
            worst = std::max(worst, std::hypot(sum[0], sum[1], sum[2]) / t.surface_areas()[i]);
        }
        CHECK(worst <= 1e-12);
    }

    TEST_CASE("vertices: every family") {
        for (const auto& set : test::families(test::by_size(600, 150), 5)) {
            INFO(set.name);
            const auto t = test::mesh_of(set);
            CHECK(test::check_mesh(t, set.points) == "");
            const auto report = votess::verify(t, set.points, {4, 1});
            CHECK(report.failure == "");
            CHECK(report.skipped.empty());
        }
    }

    TEST_CASE("vertices: lattices have one vertex where many cells meet") {
        const auto cubic = test::mesh_of(test::cubic(7));
        CHECK(cubic.vertices().size() == 3 * 8 * 8 * 8);
        const auto cells = test::cells_of_vertices(cubic);
        const auto interior = test::interior_vertices(cubic);
        for (std::size_t v = 0; v < cells.size(); ++v)
            if (interior[v]) REQUIRE(cells[v] == 8);
        const auto boxes = votess::delaunay(cubic);
        CHECK(boxes.tetrahedra.empty());
        CHECK(boxes.polytope_centers.size() == 6 * 6 * 6);
        CHECK(boxes.polytope_indices.size() == 8 * 6 * 6 * 6);

        // Four cells at each vertex: no polytopes. Octahedra and tetrahedra fill space two to one.
        const auto bcc = votess::delaunay(test::mesh_of(test::bcc(5)));
        CHECK(bcc.polytope_centers.empty());
        CHECK(!bcc.tetrahedra_centers.empty());
        const auto fcc = votess::delaunay(test::mesh_of(test::fcc(6)));
        CHECK(!fcc.tetrahedra_centers.empty());
        std::size_t octahedra = 0;
        for (std::size_t p = 0; p < fcc.polytope_centers.size(); ++p) {
            const auto seeds = fcc.polytope_indptr[p + 1] - fcc.polytope_indptr[p];
            REQUIRE((seeds == 6 || seeds == 5));  // five where the box ends
            octahedra += seeds == 6 ? 1 : 0;
        }
        CHECK(3 * octahedra > fcc.polytope_centers.size());
        CHECK(fcc.tetrahedra_centers.size() > octahedra);
    }

    TEST_CASE("vertices: small sets full of ties") {
        test::Random random(77);
        for (std::size_t round = 0; round < test::by_size(400, 60); ++round) {
            test::PointSet set{"ties", {}, std::nullopt};
            const std::size_t n = 1 + random.below(40), range = 2 + random.below(4);
            for (std::size_t k = 0; k < 3 * n; ++k) set.points.push_back(static_cast<double>(random.below(range)));
            if (random.chance(0.5)) set.box = test::cube(0, static_cast<double>(range) - 0.5 * random.below(2));
            // Some ties nearly, so that tiny polygons lie beside exact ones.
            for (double& x : set.points)
                if (round % 3 == 0 && random.chance(0.1) && x > 0) x = std::nextafter(x, 0);
            if (round % 5 == 0) set = test::scaled(set, 1e-10);
            CAPTURE(round);
            const auto t = test::mesh_of(set);
            REQUIRE(test::check_mesh(t, set.points) == "");
            const auto dual = votess::delaunay(t);
            for (std::size_t p = 0; p < dual.polytope_centers.size(); ++p)
                REQUIRE(dual.polytope_indptr[p + 1] - dual.polytope_indptr[p] > 4);
        }
    }

    TEST_CASE("vertices: few seeds and duplicates") {
        const test::PointSet one{"one", {0.3, 0.4, 0.5}, test::unit_box()};
        const auto cube = test::mesh_of(one);
        CHECK(test::check_mesh(cube, one.points) == "");
        CHECK(cube.vertices().size() == 24);
        CHECK(cube.face_vertices().size() == 24);
        CHECK(cube.surface_areas()[0] == doctest::Approx(6));
        CHECK(cube.security_radii()[0] == doctest::Approx(2 * std::hypot(0.7, 0.6, 0.5)));
        CHECK(votess::delaunay(cube).tetrahedra.empty());
        const test::PointSet two{"two", {0.25, 0.5, 0.5, 0.75, 0.5, 0.5}, test::unit_box()};
        CHECK(test::check_mesh(test::mesh_of(two), two.points) == "");
        CHECK(test::mesh_of(two).vertices().size() == 36);
        const auto none = test::mesh_of({"none", {}, std::nullopt});
        CHECK(none.vertices().empty());
        CHECK(none.face_offsets().size() == 1);
        CHECK(none.cell_vertex_indptr().size() == 1);
        CHECK(votess::delaunay(none).polytope_indptr.size() == 1);
        const auto set = test::with_duplicates(100, 20, 9);
        const auto t = test::mesh_of(set);
        CHECK(test::check_mesh(t, set.points) == "");
        for (std::size_t i = 0; i < t.size(); ++i) {
            if (t.status()[i] != votess::CellStatus::duplicate) continue;
            REQUIRE(t.cell_vertex_indptr()[i] == t.cell_vertex_indptr()[i + 1]);
            REQUIRE(t.surface_areas()[i] == 0);
            REQUIRE(t.security_radii()[i] == 0);
        }
    }

    TEST_CASE("vertices: the same for any number of threads, any tuning and moved seeds") {
        for (const auto& set : {test::uniform(test::by_size(20000, 3000), 3), test::fcc(test::reduced() ? 8 : 16)}) {
            const auto t = test::mesh_of(set);
            votess::Options options = test::mesh_options(set.box);
            options.threads = 5;
            const auto threads = votess::tessellate(set.points, options);
            CHECK(test::check_identical(t, threads) == "");
            options.grid_resolution = 3;
            options.instructions = "baseline";
            CHECK(test::check_same_cells(t, votess::tessellate(set.points, options)) == "");
            votess::Tessellator tessellator;
            options = test::mesh_options(set.box);
            auto before = set.points;
            for (double& x : before) x += 1e-4 * std::sin(1e3 * x);
            if (set.box->upper[0] == 1)
                for (double& x : before) x = std::clamp(x, 0.0, 1.0);
            (void)tessellator.tessellate(before, options);
            CHECK(test::check_identical(t, tessellator.tessellate(set.points, options)) == "");
        }
    }

    TEST_CASE("vertices: vertices alone are those of the faces, whatever rows list") {
        const auto set = test::clustered(test::by_size(3000, 500), 8);
        const auto all = test::mesh_of(set);
        votess::Options options;
        options.box = set.box;
        options.device = "cpu";
        options.want = {};
        options.want.volumes = false;
        options.want.vertices = true;
        const auto t = votess::tessellate(set.points, options);
        CHECK(!t.lists_walls());
        CHECK(t.face_offsets().empty());
        // Cells whose volume would lose digits are found in another way, where that is wanted.
        const auto near = [](double a, double b) { return std::abs(a - b) < 1e-9; };
        CHECK(std::ranges::equal(t.vertices(), all.vertices(), near));
        CHECK(std::ranges::equal(t.cell_vertex_indptr(), all.cell_vertex_indptr()));
        CHECK(std::ranges::equal(t.cell_vertex_indices(), all.cell_vertex_indices()));
        for (std::size_t i = 0; i < t.size(); ++i) REQUIRE((t.neighbors(i).empty() || t.neighbors(i)[0] >= 0));
    }

    TEST_CASE("vertices: periodic domains, cells close up to a torus") {
        const auto set = test::uniform(test::by_size(2000, 400), 44);
        votess::Options box = test::mesh_options(test::unit_box()), slab = box, triclinic = test::mesh_options(),
                        few = box;
        box.periodic = few.periodic = {true, true, true};
        slab.periodic = {true, false, true};
        triclinic.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0.1, 0}, {0.4, 1.1, 0.2}, {-0.3, 0.2, 0.9}};
        for (const auto& options : {box, slab, triclinic}) {
            const auto t = votess::tessellate(set.points, options);
            CHECK(votess::verify(t, set.points, {6, 1}).failure == "");
            const auto dual = votess::delaunay(t);
            CHECK(dual.polytope_centers.empty());
            if (options.periodic[1] == options.periodic[0]) {
                // Simple cells: V - E + F - C = 0 with E = 2 V.
                CHECK(2 * dual.tetrahedra_centers.size() + 2 * t.size() == t.indices().size());
                CHECK(test::delaunay_volume(t, dual, set.points) ==
                      doctest::Approx(t.stats().box_volume).epsilon(1e-10));
            }
        }
        // Seeds that are their own neighbors.
        for (const std::size_t n : {1, 2, 3, 7}) {
            const test::Coordinates points(set.points.begin(), set.points.begin() + static_cast<std::ptrdiff_t>(3 * n));
            const auto t = votess::tessellate(points, few);
            CHECK(votess::verify(t, points).failure == "");
            if (n > 1) continue;
            CHECK(t.vertices().size() == 24);
            const auto dual = votess::delaunay(t);
            CHECK(dual.tetrahedra.empty());
            CHECK(dual.polytope_indices == std::vector<std::int32_t>(8, 0));
        }
    }

    // Weights that leave each second cell of a lattice no more than its seed.
    // Cells far from their seeds and from each other's size. Measures are exact to 1e-10 with vertices that are not.
    TEST_CASE("vertices: measures do not make them coarser") {
        for (std::uint64_t seed = 250; seed < 320; ++seed) {
            CAPTURE(seed);
            test::Random random(seed);
            const double size = std::pow(10, random.uniform(-3.3, -2.5));
            test::Coordinates points;
            std::vector<double> weights;
            for (int cluster = 0; cluster < 2; ++cluster) {
                std::array<double, 3> middle, move;
                for (double& x : middle) x = random.uniform(0.3, 0.7);
                for (double& x : move) x = random.uniform(-0.6, 0.6);
                for (int i = 0; i < 50; ++i) {
                    double weight = 0;
                    for (std::size_t k = 0; k < 3; ++k) {
                        const double x = size * (random.uniform(-2, 2) + random.uniform(-1, 1));
                        points.push_back(std::clamp(middle[k] + x, 0.0, 1.0));
                        weight += move[k] * points.back() + x * x * (1 - 0.2 / size);
                    }
                    weights.push_back(weight);
                }
            }
            votess::Options options;
            options.box = test::cube(0, 1);
            options.weights = weights;
            options.want.faces = true;
            const auto alone = votess::tessellate(points, options);
            options.want.volumes = options.want.areas = true;
            const auto measured = votess::tessellate(points, options);
            REQUIRE(alone.vertices().size() == measured.vertices().size());
            for (std::size_t k = 0; k < alone.vertices().size(); ++k)
                CHECK(std::abs(alone.vertices()[k] - measured.vertices()[k]) < 1e-11);
            CHECK(votess::verify(measured, points).failure == "");
        }
    }

    TEST_CASE("vertices: power diagrams with cells that are points") {
        const auto set = test::cubic(6);
        std::vector<double> weights;
        for (std::size_t i = 0; i < set.size(); ++i)
            weights.push_back(std::fmod(set.points[3 * i] + set.points[3 * i + 1] + set.points[3 * i + 2], 2));
        for (const bool periodic : {false, true}) {
            votess::Options options = test::mesh_options(set.box);
            options.weights = weights;
            options.periodic = {periodic, periodic, periodic};
            const auto t = votess::tessellate(set.points, options);
            CHECK(votess::verify(t, set.points, {20, 1}).failure == "");
            CHECK(t.stats().volume_sum == doctest::Approx(216).epsilon(1e-12));
            CHECK(t.stats().empty_cells == (periodic ? 108 : 104));  // corners of the box keep an eighth of a cube
            for (std::size_t i = 0; i < t.size(); ++i) {
                if (t.status()[i] != votess::CellStatus::empty) continue;
                REQUIRE(t.neighbors(i).empty());
                REQUIRE(t.security_radii()[i] == 0);
                REQUIRE(t.surface_areas()[i] == 0);
            }
        }
    }
}
