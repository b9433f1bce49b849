// The option `min_face`, and the count of tiny faces.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/check.hpp"
#include "support/mesh.hpp"

TEST_SUITE("cases") {
    TEST_CASE("min_face: in domains without end, faces that reach infinity stay") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        for (const bool periodic : {false, true}) {
            const auto set = test::uniform(300, 37);
            votess::Options options;
            options.box = votess::Box{{-inf, -inf, -inf}, {inf, inf, inf}};
            if (periodic) options.box = votess::Box{{0, 0, -inf}, {1, 1, inf}};
            options.periodic = {periodic, periodic, false};
            options.list_walls = options.want.faces = options.want.areas = options.want.counts = true;
            const auto all = votess::tessellate(set.points, options);
            options.min_face = 0.3;
            const auto t = votess::tessellate(set.points, options);
            double sum = 0;
            std::size_t faces = 0, entry = 0, infinite = 0;
            for (std::size_t e = 0; e < all.indices().size(); ++e)
                if (all.indices()[e] >= 0 && std::isfinite(all.face_areas()[e])) sum += all.face_areas()[e], ++faces;
            CHECK(t.least_face() == doctest::Approx(0.3 * sum / static_cast<double>(faces)).epsilon(1e-12));
            for (std::size_t e = 0; e < all.indices().size(); ++e) {
                const double area = all.face_areas()[e];
                if (all.indices()[e] >= 0 && area < t.least_face()) continue;
                REQUIRE(t.indices()[entry] == all.indices()[e]);
                REQUIRE(t.face_areas()[entry] == area);
                infinite += std::isinf(area) ? 1 : 0;
                ++entry;
            }
            CHECK(t.indices().size() == entry);
            CHECK(t.stats().faces == entry);
            CHECK(infinite > (periodic ? 5 : 100));
            CHECK(votess::verify(t, set.points).failure == "");
            options.min_face = 1e-9;
            CHECK(votess::delaunay(votess::tessellate(set.points, options)).tetrahedra ==
                  votess::delaunay(all).tetrahedra);
        }
    }

    TEST_CASE("min_face: pairs go together, and nothing else changes") {
        const auto set = test::uniform(test::by_size(5000, 1000), 31);
        const auto all = test::mesh_of(set);
        votess::Options options = test::mesh_options(set.box);
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
        CHECK(report.skipped.empty());
        CHECK(report.proven);
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
        const auto raw = test::mesh_of(set);
        votess::Options options = test::mesh_options(set.box);
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

    TEST_CASE("min_face: tiny faces are as many as the areas say, whatever was wanted") {
        test::PointSet rounded = test::scaled(test::fcc(4), 0.1),
                       clustered = test::clustered(test::by_size(2000, 400), 6);
        for (double& x : rounded.points) x = 0.3 + x / 3;
        rounded.box = test::cube(0.3 - 0.05, 0.3 + 0.45 / 3 + 0.05);
        for (double& x : clustered.points) x *= 0x1p-300;
        clustered.box.reset();
        for (const auto& set : {rounded, clustered, test::uniform(500, 3), test::cubic(4)}) {
            CAPTURE(set.name);
            votess::Options options = test::mesh_options(set.box);
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
}
