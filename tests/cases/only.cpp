// The option `only`: the cells of some seeds among all.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "support/arrays.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/scattered.hpp"
#include "support/solids.hpp"
#include "support/text.hpp"

namespace {

using votess::Options;

// Returns "" when the rows of a subset are those of the whole result, to the last digit.
std::string difference(const votess::Tessellation& some, const votess::Tessellation& all,
                       const std::vector<std::int64_t>& ids) {
    if (some.size() != ids.size() || some.ids().size() != ids.size()) return "the number of rows";
    for (std::size_t k = 0; k < ids.size(); ++k) {
        const auto i = static_cast<std::size_t>(ids[k]);
        if (some.ids()[k] != ids[k]) return test::text("the id of row ", k);
        if (const std::string array = test::different_cell(some, k, all, i); !array.empty())
            return test::text(array, " of ", i);
    }
    return "";
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("only: rows of some seeds are those of all, in every domain") {
        test::Random random(8);
        test::Scattered s;
        for (int kind = 0; kind < test::kinds_of_scattered; ++kind)
            for (const bool weighted : {false, true}) {
                CAPTURE(kind);
                CAPTURE(weighted);
                test::scatter(kind, 1000, 0.2, weighted, 5, s);
                for (std::size_t k = 0; k < 3 * 20; ++k) s.points[3000 - 60 + k] = s.points[k];  // duplicates
                const auto all = votess::tessellate(s.points, s.options);
                std::vector<std::int64_t> ids;
                for (const std::size_t i : test::permutation(1000, random))
                    if (random.chance(0.2) || i < 10 || i >= 990) ids.push_back(static_cast<std::int64_t>(i));
                s.options.only = ids;
                s.options.threads = 2;
                const auto some = votess::tessellate(s.points, s.options);
                CHECK(difference(some, all, ids) == "");
                s.options.want.vertices = s.options.want.faces = true;
                const auto with_polygons = votess::tessellate(s.points, s.options);
                CHECK(test::rows_of(with_polygons) == test::rows_of(some));
                CHECK(with_polygons.face_offsets().size() == with_polygons.indices().size() + 1);
                s.options.want.vertices = s.options.want.faces = false;
                s.options.only = std::span<const std::int64_t>();
                CHECK(votess::tessellate(s.points, s.options).size() == 0);
            }
    }

    // In a mesh a face has one area, that of one of its cells. Without end cells are made in two boxes.
    TEST_CASE("only: in meshes and without end, to the last digit") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        const test::Solid tetrahedron =
            test::tetrahedron({{{0, 0.1, 0.2}, {1, 0.2, 0}, {0.3, 1, 0.1}, {0.4, 0.3, 0.9}}});
        const test::Solid hollow = test::joined(test::cuboid(0.1, 0.9), test::cuboid(0.3, 0.6).reversed());
        Options options;
        options.want = {.centroids = true, .areas = true, .normals = true, .surfaces = true};
        std::vector<Options> domains(8, options);
        domains[0].mesh = tetrahedron.mesh();
        domains[1].mesh = domains[2].mesh = hollow.mesh();
        domains[2].box = test::cube(0, 1);
        domains[2].periodic = {true, true, false};
        domains[3].box = test::cube(-inf, inf);
        domains[4].box = votess::Box{{0, 0, -inf}, {1, 1, inf}};
        domains[4].periodic = {true, true, false};
        domains[5].box = votess::Box{{-1, -inf, -inf}, {inf, inf, inf}};
        domains[6].box = votess::Box{{-inf, -inf, 0}, {inf, inf, 0}};
        domains[6].planar = true;
        domains[7].box = test::cube(-0.5, 1.5);
        test::Random random(12);
        for (std::size_t domain = 0; domain < domains.size(); ++domain)
            for (std::size_t set = 0; set < test::by_size(12, 3); ++set) {
                CAPTURE(domain);
                CAPTURE(set);
                Options& of = domains[domain];
                const std::size_t count = 3 + random.below(60), each = of.planar ? 2 : 3;
                test::Coordinates points(each * count);
                for (double& x : points)
                    x = set % 2 == 0 ? random.uniform() : 0.1 * static_cast<double>(random.below(10));
                std::vector<std::int64_t> ids;
                for (const std::size_t i : test::permutation(count, random))
                    if (random.chance(0.3)) ids.push_back(static_cast<std::int64_t>(i));
                of.only.reset();
                const auto all = votess::tessellate(points, of);
                of.only = ids;
                CHECK(difference(votess::tessellate(points, of), all, ids) == "");
            }
    }

    // In so large a box cells do not find the vertices of their neighbors as they are made.
    TEST_CASE("only: cells share the vertices of the faces that they share") {
        const auto points = test::uniform(12, 1).points;
        Options options;
        options.box = test::cube(-1e10, 1e10);
        options.want = {.neighbors = true, .volumes = false, .faces = true};
        const auto all = votess::tessellate(points, options);
        std::vector<std::int64_t> ids{11, 3, 5, 0, 1, 2, 4, 6, 10, 9, 8, 7};
        options.only = ids;
        const auto same = votess::tessellate(points, options);
        CHECK(same.vertices().size() == all.vertices().size());
        CHECK(votess::verify(same, points).failure == "");
        ids.resize(5);
        options.only = ids;
        CHECK(votess::verify(votess::tessellate(points, options), points).failure == "");
    }

    // A vertex of many cells is where the first of them puts it, so blocks must not depend on threads.
    TEST_CASE("only: vertices do not depend on the number of threads") {
        test::Random random(3);
        for (int set = 0; set < 8; ++set) {  // lattices with three weights; places of their vertices are rounded
            std::vector<double> points, weights;
            std::vector<std::int64_t> ids;
            for (std::int64_t i = 0; i < 512; ++i) {
                for (const std::int64_t k : {i / 64, i / 8 % 8, i % 8})
                    points.push_back((static_cast<double>(k) + 0.5) / 8);
                weights.push_back(1e-3 * std::floor(random.uniform(0, 3)));
                if (i % 3 == 0) ids.push_back(i);
            }
            Options options;
            options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
            options.want = {.neighbors = true, .volumes = false, .faces = true};
            options.weights = weights;
            options.only = ids;
            options.threads = 1;
            const auto one = votess::tessellate(points, options);
            for (const unsigned threads : {2u, 3u}) {
                options.threads = threads;
                CHECK(std::ranges::equal(votess::tessellate(points, options).vertices(), one.vertices()));
            }
        }
    }

    TEST_CASE("only: refusals") {
        const auto set = test::uniform(50, 1);
        Options options = test::all_options(set.box);
        std::vector<std::int64_t> ids{3, 7, 50};
        options.only = ids;
        CHECK(test::refusal(set.points, options) ==
              "Options::only: seed 50 at place 2 is not among the 50 points: give indices from 0 on");
        ids[2] = 3;
        CHECK(test::refusal(set.points, options) ==
              "Options::only: seed 3 at place 2 was named before: give each seed once");
        ids[2] = 4;
        const auto t = votess::tessellate(set.points, options);
        CHECK(t.is_subset());
        CHECK(votess::verify(t, set.points).passed);
        CHECK_THROWS_AS((void)votess::verify(t, std::span<const double>(set.points).first(147)), votess::Error);
        options.min_face = 0.1;
        CHECK(test::has(test::refusal(set.points, options),
                        "Options::min_face and Options::min_area need the faces of all cells"));
        options.min_face = 0;
        options.device = "gpu";
        CHECK(test::has(test::refusal(set.points, options, votess::ErrorCode::unsupported), "cpu or auto"));
    }
}
