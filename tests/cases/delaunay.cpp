// delaunay(): the dual of the faces.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "support/check.hpp"
#include "support/mesh.hpp"
#include "support/random.hpp"

namespace {

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
    TEST_CASE("delaunay after min_face: a lattice that was rounded and turned has its polytopes again") {
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
            votess::Options exact = test::mesh_options(set.box);
            for (std::size_t k = 0; k < 3; ++k) exact.box->lower[k] -= 0.125, exact.box->upper[k] -= 0.125;
            exact.periodic = {true, true, true};
            const auto lattice = votess::tessellate(set.points, exact);
            const auto expected = simplices_of(votess::delaunay(lattice));
            const double side = exact.box->upper[0] - exact.box->lower[0];
            votess::Options options = test::mesh_options();
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

    TEST_CASE("delaunay after min_face: unions of tetrahedra, in any order of the seeds") {
        test::Random random(5);
        const auto set = test::uniform(test::by_size(600, 200), 17);
        const auto order = test::permutation(set.size(), random);
        test::Coordinates permuted;
        for (const std::size_t i : order) permuted.insert(permuted.end(), &set.points[3 * i], &set.points[3 * i] + 3);
        votess::Options options = test::mesh_options(set.box);
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
            CHECK(std::string(error.what()).find("delaunay(): faces below an area of ") == 0);
        }
    }

    TEST_CASE("delaunay: refused without faces") {
        const auto set = test::uniform(50, 2);
        CHECK_THROWS_AS((void)votess::delaunay(test::run(set)), votess::Error);
    }
}
