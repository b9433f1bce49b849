// delaunay(): the dual of the faces.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <limits>
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

    TEST_CASE("delaunay in the plane: whole numbers prove each triangle and polygon") {
        test::Random random(8);
        std::size_t polygons = 0;
        for (int trial = 0; trial < 40; ++trial) {
            CAPTURE(trial);
            constexpr std::int64_t side = 8;  // and the period
            const bool periodic = trial % 2 == 0;
            using Place = std::array<std::int64_t, 2>;
            std::vector<Place> seeds;
            for (std::uint64_t k = 3 + random.below(12); k > 0; --k)
                seeds.push_back({random.integer(0, side - 1), random.integer(0, side - 1)});
            std::ranges::sort(seeds);
            seeds.erase(std::unique(seeds.begin(), seeds.end()), seeds.end());
            test::Coordinates points;
            for (const Place& x : seeds) points.insert(points.end(), {double(x[0]), double(x[1])});
            votess::Options options;
            options.planar = options.want.faces = true;
            options.device = "cpu";
            options.box = votess::Box{{0, 0, 0}, {side, side, 0}};
            options.periodic = {periodic, periodic, false};
            if (!periodic) {
                constexpr double far = std::numeric_limits<double>::infinity();
                options.box = votess::Box{{-far, -far, 0}, {far, far, 0}};
            }
            const auto dual = votess::delaunay(votess::tessellate(points, options));
            const auto moved = [&](std::int32_t seed, const std::int8_t* shift) {
                Place x = seeds[static_cast<std::size_t>(seed)];
                for (std::size_t k = 0; k < 2 && shift != nullptr; ++k) x[k] += side * shift[k];
                return x;
            };
            const auto cross = [](const Place& a, const Place& b, const Place& c) {
                return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            };
            // Positive: d lies inside the circle of a counterclockwise triangle.
            const auto in_circle = [](const Place& a, const Place& b, const Place& c, const Place& d) {
                std::int64_t m[3][3];
                const Place* const rows[] = {&a, &b, &c};
                for (std::size_t r = 0; r < 3; ++r) {
                    m[r][0] = (*rows[r])[0] - d[0], m[r][1] = (*rows[r])[1] - d[1];
                    m[r][2] = m[r][0] * m[r][0] + m[r][1] * m[r][1];
                }
                return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                       m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                       m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
            };
            std::int64_t twice_area = 0;
            const auto check = [&](std::span<const std::int32_t> row, const std::int8_t* shifts) {
                std::vector<Place> x;
                for (std::size_t k = 0; k < row.size(); ++k)
                    x.push_back(moved(row[k], shifts == nullptr ? nullptr : shifts + 2 * k));
                for (std::size_t k = 1; k + 1 < x.size(); ++k) {
                    REQUIRE(cross(x[k - 1], x[k], x[k + 1]) > 0);
                    twice_area += cross(x[0], x[k], x[k + 1]);
                }
                const std::int64_t reach = periodic ? 3 : 0;
                for (const Place& seed : seeds)
                    for (std::int64_t i = -reach; i <= reach; ++i)
                        for (std::int64_t j = -reach; j <= reach; ++j) {
                            const Place y{seed[0] + side * i, seed[1] + side * j};
                            const auto inside = in_circle(x[0], x[1], x[2], y);
                            REQUIRE(inside <= 0);
                            REQUIRE((inside == 0) == (std::ranges::find(x, y) != x.end()));
                        }
            };
            const auto part = [](const auto& shifts, std::size_t at) { return shifts.empty() ? nullptr : &shifts[at]; };
            for (std::size_t t = 0; 3 * t < dual.tetrahedra.size(); ++t)
                check(std::span(dual.tetrahedra).subspan(3 * t, 3), part(dual.tetrahedra_shifts, 6 * t));
            polygons += dual.polytope_centers.size();
            for (std::size_t p = 0; p < dual.polytope_centers.size(); ++p) {
                const auto begin = static_cast<std::size_t>(dual.polytope_indptr[p]),
                           end = static_cast<std::size_t>(dual.polytope_indptr[p + 1]);
                check(std::span(dual.polytope_indices).subspan(begin, end - begin),
                      part(dual.polytope_shifts, 2 * begin));
            }
            if (periodic) CHECK(twice_area == 2 * side * side);
        }
        CHECK(polygons > 20);
    }

    TEST_CASE("delaunay: refused without faces") {
        const auto set = test::uniform(50, 2);
        CHECK_THROWS_AS((void)votess::delaunay(test::run(set)), votess::Error);
    }
}
