// The mesh: globally shared vertices, polygons, normals.
#include "support/mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

votess::Options mesh_options(const std::optional<votess::Box>& box = std::nullopt) {
    votess::Options options = test::all_options(box);
    options.want.normals = options.want.surfaces = options.want.radii = options.want.faces = true;
    return options;
}

votess::Tessellation mesh_of(const test::PointSet& set) {
    return votess::tessellate(set.points, mesh_options(set.box));
}

// The seeds of each simplex, moved so that the lowest is at home; how often.
using Simplices = std::map<std::vector<std::array<int, 4>>, int>;
Simplices simplices_of(const votess::Delaunay& dual, std::span<const std::size_t> names = {}) {
    Simplices simplices;
    const auto add = [&](std::span<const std::int32_t> seeds, std::span<const std::int8_t> shifts) {
        std::vector<std::array<int, 4>> members;
        for (std::size_t k = 0; k < seeds.size(); ++k) {
            const auto seed = static_cast<std::size_t>(seeds[k]);
            members.push_back({static_cast<int>(names.empty() ? seed : names[seed]), 0, 0, 0});
            for (std::size_t axis = 0; axis < 3 && !shifts.empty(); ++axis)
                members.back()[axis + 1] = shifts[3 * k + axis];
        }
        std::ranges::sort(members);
        const auto home = members[0];
        for (auto& m : members)
            for (std::size_t axis = 1; axis < 4; ++axis) m[axis] -= home[axis];
        ++simplices[members];
    };
    const auto some = [](const auto& values, std::size_t begin, std::size_t count) {
        return std::span(values).subspan(values.empty() ? 0 : begin, values.empty() ? 0 : count);
    };
    for (std::size_t t = 0; 4 * t < dual.tetrahedra.size(); ++t)
        add(some(dual.tetrahedra, 4 * t, 4), some(dual.tetrahedra_shifts, 12 * t, 12));
    for (std::size_t p = 0; p < dual.polytope_centers.size(); ++p) {
        const auto begin = static_cast<std::size_t>(dual.polytope_indptr[p]),
                   count = static_cast<std::size_t>(dual.polytope_indptr[p + 1]) - begin;
        add(some(dual.polytope_indices, begin, count), some(dual.polytope_shifts, 3 * begin, 3 * count));
    }
    return simplices;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("mesh: uniform seeds, each interior vertex is shared by four cells") {
        const auto set = test::uniform(test::by_size(100000, 5000), 71);
        const auto t = mesh_of(set);
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

    TEST_CASE("mesh: every family") {
        for (const auto& set : test::families(test::by_size(600, 150), 5)) {
            INFO(set.name);
            const auto t = mesh_of(set);
            CHECK(test::check_mesh(t, set.points) == "");
            const auto report = votess::verify(t, set.points, {4, 1});
            CHECK(report.failure == "");
            CHECK(report.skipped.empty());
        }
    }

    TEST_CASE("mesh: lattices have one vertex where many cells meet") {
        const auto cubic = mesh_of(test::cubic(7));
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
        const auto bcc = votess::delaunay(mesh_of(test::bcc(5)));
        CHECK(bcc.polytope_centers.empty());
        CHECK(!bcc.tetrahedra_centers.empty());
        const auto fcc = votess::delaunay(mesh_of(test::fcc(6)));
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

    TEST_CASE("mesh: small sets full of ties") {
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
            const auto t = mesh_of(set);
            REQUIRE(test::check_mesh(t, set.points) == "");
            const auto dual = votess::delaunay(t);
            for (std::size_t p = 0; p < dual.polytope_centers.size(); ++p)
                REQUIRE(dual.polytope_indptr[p + 1] - dual.polytope_indptr[p] > 4);
        }
    }

    TEST_CASE("mesh: few seeds and duplicates") {
        const test::PointSet one{"one", {0.3, 0.4, 0.5}, test::unit_box()};
        const auto cube = mesh_of(one);
        CHECK(test::check_mesh(cube, one.points) == "");
        CHECK(cube.vertices().size() == 24);
        CHECK(cube.face_vertices().size() == 24);
        CHECK(cube.surface_areas()[0] == doctest::Approx(6));
        CHECK(cube.security_radii()[0] == doctest::Approx(2 * std::hypot(0.7, 0.6, 0.5)));
        CHECK(votess::delaunay(cube).tetrahedra.empty());
        const test::PointSet two{"two", {0.25, 0.5, 0.5, 0.75, 0.5, 0.5}, test::unit_box()};
        CHECK(test::check_mesh(mesh_of(two), two.points) == "");
        CHECK(mesh_of(two).vertices().size() == 36);
        const auto none = mesh_of({"none", {}, std::nullopt});
        CHECK(none.vertices().empty());
        CHECK(none.face_offsets().size() == 1);
        CHECK(none.cell_vertex_indptr().size() == 1);
        CHECK(votess::delaunay(none).polytope_indptr.size() == 1);
        const auto set = test::with_duplicates(100, 20, 9);
        const auto t = mesh_of(set);
        CHECK(test::check_mesh(t, set.points) == "");
        for (std::size_t i = 0; i < t.size(); ++i) {
            if (t.status()[i] != votess::CellStatus::duplicate) continue;
            REQUIRE(t.cell_vertex_indptr()[i] == t.cell_vertex_indptr()[i + 1]);
            REQUIRE(t.surface_areas()[i] == 0);
            REQUIRE(t.security_radii()[i] == 0);
        }
    }

    TEST_CASE("mesh: the same for any number of threads, any tuning and moved seeds") {
        for (const auto& set : {test::uniform(test::by_size(20000, 3000), 3), test::fcc(test::reduced() ? 8 : 16)}) {
            const auto t = mesh_of(set);
            votess::Options options = mesh_options(set.box);
            options.threads = 5;
            const auto threads = votess::tessellate(set.points, options);
            CHECK(test::check_identical(t, threads) == "");
            options.grid_resolution = 3;
            options.instructions = "baseline";
            CHECK(test::check_same_cells(t, votess::tessellate(set.points, options)) == "");
            votess::Tessellator tessellator;
            options = mesh_options(set.box);
            auto before = set.points;
            for (double& x : before) x += 1e-4 * std::sin(1e3 * x);
            if (set.box->upper[0] == 1)
                for (double& x : before) x = std::clamp(x, 0.0, 1.0);
            (void)tessellator.tessellate(before, options);
            CHECK(test::check_identical(t, tessellator.tessellate(set.points, options)) == "");
        }
    }

    TEST_CASE("mesh: vertices alone are those of the faces, whatever rows list") {
        const auto set = test::clustered(test::by_size(3000, 500), 8);
        const auto all = mesh_of(set);
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

    TEST_CASE("mesh: cells clipped by every seed give the same mesh") {
        for (const auto& set : {test::uniform(test::by_size(400, 100), 12), test::cubic(5), test::fcc(4),
                                test::cospherical_and_center(26), test::on_sphere_and_center(200, 3)}) {
            INFO(set.name);
            CHECK(test::check_same_mesh(test::mesh_of_clipped_cells(set), mesh_of(set)) == "");
        }
    }

    TEST_CASE("min_face: pairs go together, and nothing else changes") {
        const auto set = test::uniform(test::by_size(5000, 1000), 31);
        const auto all = mesh_of(set);
        votess::Options options = mesh_options(set.box);
        options.min_face = 0.2;
        const auto t = votess::tessellate(set.points, options);
        double sum = 0;
        std::size_t faces = 0;
        for (std::size_t e = 0; e < all.indices().size(); ++e)
            if (all.indices()[e] >= 0) sum += all.face_areas()[e], ++faces;
        CHECK(t.least_face() == doctest::Approx(0.2 * sum / static_cast<double>(faces)).epsilon(1e-12));
        std::size_t entry = 0, counted = 0;
        for (std::size_t i = 0; i < all.size(); ++i) {
            for (auto e = static_cast<std::size_t>(all.indptr()[i]); e < static_cast<std::size_t>(all.indptr()[i + 1]);
                 ++e) {
                const std::int32_t j = all.indices()[e];
                double area = all.face_areas()[e];
                if (j >= 0 && static_cast<std::size_t>(j) < i) {
                    const auto row = all.neighbors(static_cast<std::size_t>(j));
                    area = all.face_areas()[static_cast<std::size_t>(
                        all.indptr()[static_cast<std::size_t>(j)] +
                        (std::ranges::lower_bound(row, static_cast<std::int32_t>(i)) - row.begin()))];
                }
                if (j >= 0 && area < t.least_face()) continue;
                REQUIRE(t.indices()[entry] == j);
                REQUIRE(t.face_areas()[entry] == all.face_areas()[e]);
                REQUIRE(t.face_normals()[3 * entry + 2] == all.face_normals()[3 * e + 2]);
                const auto here = t.face_offsets()[entry], there = all.face_offsets()[e];
                REQUIRE(t.face_offsets()[entry + 1] - here == all.face_offsets()[e + 1] - there);
                REQUIRE(t.face_vertices()[static_cast<std::size_t>(here)] ==
                        all.face_vertices()[static_cast<std::size_t>(there)]);
                ++entry;
            }
            REQUIRE(static_cast<std::size_t>(t.indptr()[i + 1]) == entry);
            REQUIRE(t.face_counts()[i] == t.neighbors(i).size());
            counted += t.face_counts()[i];
        }
        CHECK(entry < all.indices().size() * 9 / 10);
        CHECK(t.stats().faces == counted);
        CHECK(std::ranges::equal(t.vertices(), all.vertices()));
        const auto report = votess::verify(t, set.points);
        CHECK(report.failure == "");
        CHECK(report.skipped == std::vector<std::string>{"euler"});
        CHECK(t.stats().tiny_faces == 0);
        for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
            options.min_face = bad;
            CHECK_THROWS_AS((void)votess::tessellate(set.points, options), votess::Error);
        }
    }

    TEST_CASE("min_face: a lattice written with decimals is a lattice again") {
        test::PointSet set = test::scaled(test::fcc(6), 0.1);
        for (double& x : set.points) x = 0.3 + x / 3;
        set.box = test::cube(0.3 - 0.05, 0.3 + 0.65 / 3 + 0.05);
        const auto raw = mesh_of(set);
        votess::Options options = mesh_options(set.box);
        options.min_face = 1e-6;
        const auto t = votess::tessellate(set.points, options);
        std::size_t raw_extra = 0, inner = 0;
        for (std::size_t i = 0; i < t.size(); ++i) {
            if (t.neighbors(i)[0] < 0) continue;
            ++inner;
            REQUIRE(t.neighbors(i).size() == 12);
            raw_extra += raw.neighbors(i).size() - 12;
        }
        CHECK(inner > 50);
        CHECK(raw_extra > 0);
    }

    TEST_CASE("tiny faces: as many as the areas say, whatever was wanted") {
        test::PointSet rounded = test::scaled(test::fcc(4), 0.1),
                       clustered = test::clustered(test::by_size(2000, 400), 6);
        for (double& x : rounded.points) x = 0.3 + x / 3;
        rounded.box = test::cube(0.3 - 0.05, 0.3 + 0.45 / 3 + 0.05);
        for (double& x : clustered.points) x *= 0x1p-300;
        clustered.box.reset();
        for (const auto& set : {rounded, clustered, test::uniform(500, 3), test::cubic(4)}) {
            CAPTURE(set.name);
            votess::Options options = mesh_options(set.box);
            const auto all = votess::tessellate(set.points, options);
            double sum = 0, faces = 0;
            for (std::size_t e = 0; e < all.indices().size(); ++e)
                if (all.indices()[e] >= 0) sum += all.face_areas()[e], ++faces;
            const double limit = std::ldexp(1.0, std::ilogb(1e-9 * sum / faces));
            std::uint64_t tiny = 0;
            for (std::size_t e = 0; e < all.indices().size(); ++e)
                tiny += all.indices()[e] >= 0 && all.face_areas()[e] < limit ? 1 : 0;
            CAPTURE(tiny);
            if (set.name == rounded.name) CHECK(tiny > 0);
            CHECK(all.stats().tiny_faces == tiny);
            options.want = {.neighbors = false};
            CHECK(votess::tessellate(set.points, options).stats().tiny_faces == tiny);
            options.want = {.volumes = false, .faces = true};
            CHECK(votess::tessellate(set.points, options).stats().tiny_faces == tiny);
            options.want = {.volumes = false};
            const auto lists = votess::tessellate(set.points, options);
            CHECK_FALSE(lists.stats().tiny_faces.has_value());
            CHECK(votess::count_tiny_faces(lists, set.points) == tiny);
            CHECK(votess::verify(lists, set.points, {1, 1}).tiny_faces == tiny);
            options.min_face = 1e-8;
            CHECK(votess::tessellate(set.points, options).stats().tiny_faces == 0);
        }
    }

    TEST_CASE("Delaunay after min_face: a lattice that was rounded and turned has its polytopes again") {
        // A rotation and a scale that no float64 holds exactly.
        const double turn[3][3] = {{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}};
        const auto turned = [&](const std::array<double, 3>& x) {
            std::array<double, 3> y{};
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t k = 0; k < 3; ++k) y[i] += turn[i][k] * x[k] / 3;
            return y;
        };
        for (const auto& set : {test::cubic(4), test::bcc(3), test::fcc(3), test::diamond(2)}) {
            CAPTURE(set.name);
            votess::Options exact = mesh_options(set.box);
            for (std::size_t k = 0; k < 3; ++k) exact.box->lower[k] -= 0.125, exact.box->upper[k] -= 0.125;
            exact.periodic = {true, true, true};
            const auto lattice = votess::tessellate(set.points, exact);
            const auto expected = simplices_of(votess::delaunay(lattice));
            const double side = exact.box->upper[0] - exact.box->lower[0];
            votess::Options options = mesh_options();
            options.cell = votess::TriclinicBox{
                turned(exact.box->lower), turned({side, 0, 0}), turned({0, side, 0}), turned({0, 0, side}), {}};
            options.cell->periodic = {true, true, true};
            test::Coordinates points;
            for (std::size_t i = 0; i < set.points.size(); i += 3)
                for (const double x : turned({set.points[i], set.points[i + 1], set.points[i + 2]}))
                    points.push_back(x);
            const auto raw = votess::tessellate(points, options);
            const bool has_ties = !votess::delaunay(lattice).polytope_centers.empty();
            CHECK((raw.stats().tiny_faces > 0) == has_ties);
            CHECK((simplices_of(votess::delaunay(raw)) != expected) == has_ties);
            options.min_face = 1e-6;
            const auto t = votess::tessellate(points, options);
            CHECK(t.stats().tiny_faces == 0);
            CHECK(simplices_of(votess::delaunay(t)) == expected);
        }
    }

    TEST_CASE("Delaunay after min_face: unions of tetrahedra, in any order of the seeds") {
        test::Random random(5);
        const auto set = test::uniform(test::by_size(600, 200), 17);
        const auto order = test::permutation(set.size(), random);
        test::Coordinates permuted;
        for (const std::size_t i : order) permuted.insert(permuted.end(), &set.points[3 * i], &set.points[3 * i] + 3);
        votess::Options options = mesh_options(set.box);
        options.periodic = {true, true, true};
        const auto whole = simplices_of(votess::delaunay(votess::tessellate(set.points, options)));
        options.min_face = 1e-4;
        const auto joined = simplices_of(votess::delaunay(votess::tessellate(set.points, options)));
        CHECK(joined == simplices_of(votess::delaunay(votess::tessellate(permuted, options)), order));
        CHECK(joined.size() < whole.size());
        std::size_t same = 0;
        for (const auto& [members, count] : whole) same += joined.contains(members) ? 1 : 0;
        CHECK(same > whole.size() / 2);
        // A face that is left would shrink to nothing.
        options.min_face = 1;
        try {
            (void)votess::delaunay(votess::tessellate(set.points, options));
            FAIL("no refusal");
        } catch (const votess::Error& error) {
            CHECK(error.code() == votess::ErrorCode::invalid_argument);
            CHECK(std::string(error.what()).find("delaunay: faces below an area of ") == 0);
        }
    }

    // Weights that leave each second cell of a lattice no more than its seed.
    TEST_CASE("mesh: power diagrams with cells that are points") {
        const auto set = test::cubic(6);
        std::vector<double> weights;
        for (std::size_t i = 0; i < set.size(); ++i)
            weights.push_back(std::fmod(set.points[3 * i] + set.points[3 * i + 1] + set.points[3 * i + 2], 2));
        for (const bool periodic : {false, true}) {
            votess::Options options = mesh_options(set.box);
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

    TEST_CASE("Delaunay: refused without faces") {
        const auto set = test::uniform(50, 2);
        CHECK_THROWS_AS((void)votess::delaunay(test::run(set)), votess::Error);
    }

    TEST_CASE("mesh: periodic domains, cells close up to a torus") {
        const auto set = test::uniform(test::by_size(2000, 400), 44);
        votess::Options box = mesh_options(test::unit_box()), slab = box, triclinic = mesh_options(), few = box;
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
}
