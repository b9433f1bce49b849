// to_grid(), dtfe: simplices that fit together, mass that is kept, fields that are linear.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "cases/fields/field_cases.hpp"
#include "input/settle.hpp"
#include "mesh/dual.hpp"
#include "support/check.hpp"

namespace {

using test::FieldCase;
using votess::Member;

using Vec = std::array<double, 3>;

// A tessellation with what is dual to it.
struct Dual {
    votess::Tessellation t;
    votess::Delaunay simplices;
    votess::PolytopeFacets facets;
    std::vector<double> places;

    Dual(const test::Coordinates& points, const votess::Options& options) {
        const auto result =
            std::make_shared<votess::detail::Result>(votess::arrays_of(votess::settle({points, {}}, options)));
        t = votess::Tessellation(result);
        simplices = votess::delaunay(t);
        facets = votess::polytope_facets(*result, simplices);
        places = votess::wrapped_points(t, points);
    }

    [[nodiscard]] Member corner(std::size_t tetrahedron, std::size_t k) const {
        Member m{simplices.tetrahedra[4 * tetrahedron + k], {}};
        if (!simplices.tetrahedra_shifts.empty())
            std::copy_n(&simplices.tetrahedra_shifts[3 * (4 * tetrahedron + k)], 3, m.shift.begin());
        return m;
    }
    [[nodiscard]] std::span<const Member> facet(std::size_t f) const {
        return std::span(facets.corners)
            .subspan(facets.corner_begin[f], facets.corner_begin[f + 1] - facets.corner_begin[f]);
    }
    [[nodiscard]] std::set<Member> members(std::size_t polytope) const {
        std::set<Member> all;
        for (auto f = facets.facet_begin[polytope]; f < facets.facet_begin[polytope + 1]; ++f)
            all.insert(facet(f).begin(), facet(f).end());
        return all;
    }

    [[nodiscard]] Vec place(const Member& m) const {
        Vec x{};
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] = places[3 * static_cast<std::size_t>(m.seed) + k];
            if (t.cell())
                x[k] += m.shift[0] * t.cell()->a[k] + m.shift[1] * t.cell()->b[k] + m.shift[2] * t.cell()->c[k];
            else
                x[k] += m.shift[k] * (t.box().upper[k] - t.box().lower[k]);
        }
        return x;
    }
};

template <class Members>
Vec mean(const Dual& d, const Members& members) {
    Vec mean{};
    for (const Member& m : members)
        for (std::size_t k = 0; k < 3; ++k) mean[k] += d.place(m)[k] / static_cast<double>(std::size(members));
    return mean;
}

double volume(const Vec& o, Vec a, Vec b, Vec c) {
    for (Vec* p : {&a, &b, &c})
        for (std::size_t k = 0; k < 3; ++k) (*p)[k] -= o[k];
    return (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
            a[2] * (b[0] * c[1] - b[1] * c[0])) /
           6;
}

// The corners of a triangle or a facet, moved so that the lowest is at home.
std::vector<Member> at_home(std::vector<Member> face) {
    std::ranges::sort(face);
    const votess::ByteShift home = face[0].shift;
    for (Member& m : face)
        for (std::size_t k = 0; k < 3; ++k) m.shift[k] = static_cast<std::int8_t>(m.shift[k] - home[k]);
    return face;
}

// How often each of them bounds a simplex.
std::map<std::vector<Member>, int> faces(const Dual& d) {
    std::map<std::vector<Member>, int> count;
    for (std::size_t t = 0; 4 * t < d.simplices.tetrahedra.size(); ++t)
        for (std::size_t left_out = 0; left_out < 4; ++left_out) {
            std::vector<Member> face;
            for (std::size_t k = 0; k < 4; ++k)
                if (k != left_out) face.push_back(d.corner(t, k));
            ++count[at_home(face)];
        }
    for (std::size_t f = 0; f + 1 < d.facets.corner_begin.size(); ++f)
        ++count[at_home({d.facet(f).begin(), d.facet(f).end()})];
    return count;
}

// For each seed the integral of what is 1 there, 0 at the others and linear between.
std::vector<double> integrals(const Dual& d) {
    std::vector<double> sum(d.t.size(), 0);
    const auto add = [&](const auto& members, double part) {
        for (const Member& m : members)
            sum[static_cast<std::size_t>(m.seed)] += part / static_cast<double>(std::size(members));
    };
    for (std::size_t t = 0; 4 * t < d.simplices.tetrahedra.size(); ++t) {
        const std::array<Member, 4> c{d.corner(t, 0), d.corner(t, 1), d.corner(t, 2), d.corner(t, 3)};
        add(c, volume(d.place(c[0]), d.place(c[1]), d.place(c[2]), d.place(c[3])));
    }
    for (std::size_t p = 0; p + 1 < d.facets.facet_begin.size(); ++p) {
        const auto all = d.members(p);
        const Vec center = mean(d, all);
        for (auto f = d.facets.facet_begin[p]; f < d.facets.facet_begin[p + 1]; ++f) {
            const auto facet = d.facet(f);
            const Vec middle = mean(d, facet);
            for (std::size_t k = 0; k < facet.size(); ++k) {
                const std::array<Member, 2> edge{facet[k], facet[(k + 1) % facet.size()]};
                const double v = volume(center, middle, d.place(edge[0]), d.place(edge[1]));
                add(all, v / 4);
                add(facet, v / 4);
                add(edge, v / 2);
            }
        }
    }
    return sum;
}

votess::Options with_faces(const std::optional<votess::Box>& box, bool periodic) {
    votess::Options options;
    options.box = box;
    options.periodic = {periodic, periodic, periodic};
    options.want.faces = true;
    options.threads = 1;
    options.device = "cpu";
    return options;
}

// Sets whose tetrahedra are flat, long or far below the digits of their places. Most are inside the unit box.
std::vector<FieldCase> hard_cases() {
    test::Random random(12);
    std::vector<FieldCase> cases;
    const auto number = [&] { return random.uniform(); };
    const auto add = [&](const char* name, std::size_t n, const auto& place) -> FieldCase& {
        cases.push_back({name, {}, with_faces(test::unit_box(), false)});
        std::set<Vec> places;
        while (places.size() < n) places.insert(place());
        for (const Vec& place : places)
            cases.back().points.insert(cases.back().points.end(), place.begin(), place.end());
        return cases.back();
    };
    const std::array<std::array<bool, 3>, 4> axes{
        {{false, false, false}, {true, false, false}, {false, true, true}, {true, true, true}}};
    for (const double size : {1e-6, 1e-14, 1e-40, 1e-322})
        for (const auto& periodic : axes) {
            add("sheet", 12, [&] { return Vec{number(), number(), size * number()}; }).options.periodic = periodic;
            add("column", 12, [&] {
                return Vec{number(), size * number(), size * number()};
            }).options.periodic = periodic;
            // Around a corner of the box, so that near seeds have homes a period away.
            add("cluster", 12, [&] {
                Vec x{};
                for (double& c : x) c = random.uniform() < 0.5 ? size * number() : 1 - std::max(size, 1e-15) * number();
                for (double& c : x) c = c < 1 ? c : 0;
                return x;
            }).options.periodic = periodic;
        }
    for (const auto& periodic : axes) {
        FieldCase& c = add("one ulp apart", 10, [&] { return Vec{number(), number(), number()}; });
        for (std::size_t k = 0; k < 30; ++k) c.points.push_back(std::nextafter(c.points[k], random.below(3) - 1.0));
        c.options.periodic = periodic;
        add("oblique sheet", 12, [&] {
            const double x = number(), y = number();
            return Vec{x, y, 0.25 + 0.3 * x + 0.2 * y};
        }).options.periodic = periodic;
    }
    return cases;
}

using Rational = std::array<mpq_class, 3>;

// A tetrahedron whose corners carry barycentric coordinates.
struct Part {
    std::array<Rational, 4> place;
    std::array<std::array<mpq_class, 4>, 4> coordinates;
    mpq_class volume;
};

// Visits parts that fill the place below h along an axis, by halving along edges that cross the plane.
template <class Visit>
void for_below(const Part& part, std::size_t axis, const mpq_class& h, const Visit& visit) {
    std::size_t below = 4, beyond = 4;
    for (std::size_t k = 0; k < 4; ++k) {
        if (part.place[k][axis] < h) below = k;
        if (part.place[k][axis] > h) beyond = k;
    }
    if (below == 4) return;
    if (beyond == 4) return visit(part);
    const Rational &from = part.place[below], &to = part.place[beyond];
    const mpq_class share = (h - from[axis]) / (to[axis] - from[axis]);
    for (const std::size_t moved : {below, beyond}) {
        Part half = part;
        for (std::size_t k = 0; k < 3; ++k) half.place[moved][k] = from[k] + share * (to[k] - from[k]);
        for (std::size_t k = 0; k < 4; ++k)
            half.coordinates[moved][k] =
                part.coordinates[below][k] + share * (part.coordinates[beyond][k] - part.coordinates[below][k]);
        half.volume *= moved == beyond ? share : 1 - share;
        for_below(half, axis, h, visit);
    }
}

// Adds the integrals of the coordinates, times `sign`.
void add_whole(const Part& part, int sign, std::array<mpq_class, 4>& sums) {
    for (const auto& corner : part.coordinates)
        for (std::size_t k = 0; k < 4; ++k) sums[k] += sign * part.volume * corner[k] / 4;
}

// Does so where x < h.
void add_below(const Part& part, const mpq_class& h, int sign, std::array<mpq_class, 4>& sums) {
    for_below(part, 0, h, [&](const Part& below) { add_whole(below, sign, sums); });
}

Part part_of(const Dual& d, std::size_t tetrahedron, const test::Coordinates& points) {
    Part part;
    for (std::size_t k = 0; k < 4; ++k) {
        const Member m = d.corner(tetrahedron, k);
        part.coordinates[k][k] = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            part.place[k][axis] = mpq_class(points[3 * static_cast<std::size_t>(m.seed) + axis]) + m.shift[axis];
    }
    const auto edge = [&](std::size_t k, std::size_t axis) -> mpq_class {
        return part.place[k][axis] - part.place[0][axis];
    };
    for (std::size_t k = 0; k < 3; ++k)
        part.volume +=
            edge(1, k) * (edge(2, (k + 1) % 3) * edge(3, (k + 2) % 3) - edge(2, (k + 2) % 3) * edge(3, (k + 1) % 3));
    REQUIRE(part.volume > 0);
    return part;
}

// By seed and octant of the unit box, for unit masses: the mass there. -1 for seeds without a tetrahedron.
std::vector<std::array<double, 8>> masses_in_octants(const Dual& d, const test::Coordinates& points) {
    const std::size_t n = points.size() / 3;
    std::vector<mpq_class> around(n);
    std::vector<std::array<mpq_class, 8>> inside(n);
    const auto visit_octants = [&](const Part& part, const std::array<int, 3>& image, const auto& visit) {
        // Each octant is a sum of corners, of everything below 0, 1/2 or 1 along the axes.
        for (int corner = 0; corner < 27; ++corner) {
            const std::array<int, 3> at{corner % 3, corner / 3 % 3, corner / 9};
            const auto height = [&](std::size_t axis) -> mpq_class { return mpq_class(at[axis], 2) + image[axis]; };
            std::array<mpq_class, 4> sums;
            for_below(part, 0, height(0), [&](const Part& x) {
                for_below(x, 1, height(1), [&](const Part& y) {
                    for_below(y, 2, height(2), [&](const Part& z) { add_whole(z, 1, sums); });
                });
            });
            for (int octant = 0; octant < 8; ++octant) {
                int sign = 1;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const int lower = octant >> (2 - axis) & 1;
                    if (at[axis] != lower && at[axis] != lower + 1) sign = 0;
                    if (at[axis] == lower) sign = -sign;
                }
                if (sign != 0) visit(octant, sign, sums);
            }
        }
    };
    for (std::size_t t = 0; 4 * t < d.simplices.tetrahedra.size(); ++t) {
        const Part part = part_of(d, t, points);
        for (std::size_t k = 0; k < 4; ++k) around[static_cast<std::size_t>(d.corner(t, k).seed)] += part.volume / 4;
        const int images = d.t.periodic()[2] ? 2 : 0;
        for (int image = -images; image <= images; ++image)
            visit_octants(part, {0, 0, image}, [&](int octant, int sign, const std::array<mpq_class, 4>& sums) {
                for (std::size_t k = 0; k < 4; ++k)
                    inside[static_cast<std::size_t>(d.corner(t, k).seed)][static_cast<std::size_t>(octant)] +=
                        sign * sums[k];
            });
    }
    std::vector<std::array<double, 8>> masses(n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t o = 0; o < 8; ++o)
            masses[i][o] = around[i] > 0 ? mpq_class(inside[i][o] / around[i]).get_d() : -1;
    return masses;
}

// By seed, for unit masses in the unit box: the mass where x < 1/2. -1 for seeds without a tetrahedron.
std::vector<double> masses_below(const Dual& d, const test::Coordinates& points) {
    const std::size_t n = points.size() / 3;
    std::vector<mpq_class> around(n), below(n);
    for (std::size_t t = 0; 4 * t < d.simplices.tetrahedra.size(); ++t) {
        const Part part = part_of(d, t, points);
        std::array<mpq_class, 4> sums;
        for (int image = -2; image <= 2; ++image) {
            add_below(part, mpq_class(2 * image + 1, 2), 1, sums);
            add_below(part, image, -1, sums);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            const auto seed = static_cast<std::size_t>(d.corner(t, k).seed);
            around[seed] += part.volume / 4;
            below[seed] += sums[k];
        }
    }
    std::vector<double> masses(n, -1);
    for (std::size_t i = 0; i < n; ++i)
        if (around[i] > 0) masses[i] = mpq_class(below[i] / around[i]).get_d();
    return masses;
}

}  // namespace

TEST_SUITE("dtfe") {
    TEST_CASE("dtfe: facets close polytopes, and simplices fit together") {
        std::vector<FieldCase> cases;
        for (const bool periodic : {false, true})
            for (const auto& set : {test::cubic(4), test::bcc(3), test::fcc(3), test::hexagonal(3), test::diamond(2),
                                    test::cospherical(26), test::cocircular(25, 3)})
                cases.push_back({set.name, set.points, with_faces(set.box, periodic)});
        // Few seeds of a grid, full of ties, which meet images of themselves.
        test::Random random(3);
        for (std::size_t set = 0; set < test::by_size(120, 30); ++set) {
            FieldCase c{"grid", {}, with_faces(test::unit_box(), true)};
            for (std::uint64_t i = 3 * (1 + random.below(12)); i-- > 0;)
                c.points.push_back(static_cast<double>(random.below(4)) / 4);
            if (set % 2 == 1) {
                c.points =
                    test::inside(votess::TriclinicBox{{}, {1, 0, 0}, {0.5, 1, 0}, {-0.25, 0.25, 1}, {}}, c.points);
                c.options.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0.5, 1, 0}, {-0.25, 0.25, 1}};
                c.options.box.reset();
                c.options.periodic = {};
            }
            cases.push_back(c);
        }
        std::size_t with_polytopes = 0;
        for (const FieldCase& c : cases) {
            CAPTURE(c.name);
            const Dual d(c.points, c.options);
            const auto& [facet_begin, corner_begin, corners] = d.facets;
            REQUIRE(facet_begin.size() == d.simplices.polytope_indptr.size());
            with_polytopes += facet_begin.size() > 1;
            for (std::size_t p = 0; p + 1 < facet_begin.size(); ++p) {
                const auto all = d.members(p);
                const auto begin = d.simplices.polytope_indptr[p], end = d.simplices.polytope_indptr[p + 1];
                REQUIRE(static_cast<std::int64_t>(all.size()) == end - begin);
                std::set<std::pair<Member, Member>> edges;
                for (auto f = facet_begin[p]; f < facet_begin[p + 1]; ++f) {
                    const auto facet = d.facet(f);
                    REQUIRE(facet.size() >= 3);
                    for (std::size_t k = 0; k < facet.size(); ++k) {
                        const Member& next = facet[(k + 1) % facet.size()];
                        REQUIRE(edges.insert({facet[k], next}).second);
                        REQUIRE(volume(mean(d, all), mean(d, facet), d.place(facet[k]), d.place(next)) > 0);
                    }
                }
                for (const auto& [from, to] : edges) REQUIRE(edges.contains({to, from}));
                REQUIRE(all.size() + facet_begin[p + 1] - facet_begin[p] == edges.size() / 2 + 2);
            }
            const auto parts = integrals(d);
            const double sum = std::accumulate(parts.begin(), parts.end(), 0.0);
            const bool periodic = d.t.periodic()[0];
            if (periodic) CHECK(std::abs(sum - d.t.stats().box_volume) <= 1e-12 * d.t.stats().box_volume);
            // The cubes of a lattice fill its hull.
            if (c.name == "cubic" && !periodic) CHECK(sum == doctest::Approx(27).epsilon(1e-12));
            for (const auto& [face, count] : faces(d)) {
                if (periodic)
                    REQUIRE(count == 2);
                else
                    REQUIRE(count <= 2);
            }
        }
        CHECK(with_polytopes > cases.size() / 2);
    }

    TEST_CASE("dtfe: mass is kept in every domain, and seeds without a tetrahedron are counted") {
        for (FieldCase& c : test::field_cases(test::by_size(300, 60)))
            for (const double weight : {0.0, 0.02}) {
                CAPTURE(c.name);
                CAPTURE(weight);
                const std::size_t n = c.points.size() / 3;
                const auto weights = test::some_weights(n, weight);
                c.options.weights = weight > 0 ? std::span<const double>(weights) : std::span<const double>();
                const Dual d(c.points, c.options);
                const auto parts = integrals(d);
                test::Random random(3);
                const auto duplicates = d.t.duplicate_of();
                std::vector<double> masses(n);
                double mass = 0;
                std::size_t without = 0;
                for (std::size_t i = 0; i < n; ++i) {
                    masses[i] = random.uniform();
                    const bool copy = !duplicates.empty() && duplicates[i] >= 0;
                    const double part = parts[copy ? static_cast<std::size_t>(duplicates[i]) : i];
                    if (part > 0) mass += masses[i];
                    without += part == 0;
                }
                if (d.t.periodic() == std::array<bool, 3>{true, true, true} && weight == 0) CHECK(without == 0);
                const votess::Diagram diagram(c.points, c.options);
                for (const auto& shape : {std::array<std::size_t, 3>{1, 1, 1}, {4, 8, 16}, {9, 7, 10}}) {
                    const votess::GridOptions options{.shape = shape, .method = votess::GridMethod::dtfe};
                    std::vector<double> grid(shape[0] * shape[1] * shape[2]);
                    CHECK(diagram.to_grid(masses, options, grid) == without);
                    double sum = 0;
                    for (const double x : grid) sum += x * test::grid_cell_volume(d.t, options);
                    CHECK(std::abs(sum - mass) <= 1e-12 * mass);
                }
            }
    }

    TEST_CASE("dtfe: each mass is where rational arithmetic has it, however flat the tetrahedra are") {
        std::size_t compared = 0;
        for (const FieldCase& c : hard_cases()) {
            CAPTURE(c.name);
            CAPTURE(c.points);
            const Dual d(c.points, c.options);
            REQUIRE(d.t.stats().duplicates == 0);
            const std::size_t n = c.points.size() / 3;
            const auto expected =
                d.simplices.polytope_centers.empty() ? masses_below(d, c.points) : std::vector<double>();
            std::set<std::int32_t> placed(d.simplices.tetrahedra.begin(), d.simplices.tetrahedra.end());
            placed.insert(d.simplices.polytope_indices.begin(), d.simplices.polytope_indices.end());
            if (d.t.periodic() == std::array{true, true, true}) REQUIRE(placed.size() == n);
            // A column for each seed.
            std::vector<double> masses(n * n, 0), grid(2 * n);
            for (std::size_t i = 0; i < n; ++i) masses[i * n + i] = 1;
            const votess::Diagram diagram(c.points, c.options);
            const votess::GridOptions options{.shape = {2, 1, 1}, .method = votess::GridMethod::dtfe, .columns = n};
            REQUIRE(diagram.to_grid(masses, options, grid) == n - placed.size());
            for (std::size_t i = 0; i < n; ++i) {
                const double all = placed.contains(static_cast<std::int32_t>(i)) ? 1 : 0;
                REQUIRE(std::abs((grid[i] + grid[n + i]) / 2 - all) < 1e-13);
                if (expected.empty() || all == 0) continue;
                ++compared;
                REQUIRE(std::abs(grid[i] / 2 - expected[i]) < 1e-12);
            }
        }
        CHECK(compared > 300);
    }

    TEST_CASE("dtfe: with seeds outside each grid cell has the mass of the tetrahedra in it") {
        // One tetrahedron around the box has one density.
        votess::Options around = with_faces(votess::Box{{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}}, false);
        around.outside = votess::Outside::keep;
        const votess::Diagram one(test::Coordinates{2, 2, 2, 2, -2, -2, -2, 2, -2, -2, -2, 2}, around);
        const std::vector<double> unit(4, 1);
        for (const double density : test::grid_of(one, unit, {.shape = {3, 2, 4}, .method = votess::GridMethod::dtfe}))
            CHECK(std::abs(density - 0.1875) < 1e-15);
        for (const double column :
             test::grid_of(one, unit, {.shape = {3, 2, 4}, .method = votess::GridMethod::dtfe, .project = 1}))
            CHECK(std::abs(column - 0.1875) < 1e-15);

        test::Random random(14);
        std::size_t compared = 0, partly = 0;
        for (std::size_t set = 0; set < test::by_size(40, 8); ++set) {
            CAPTURE(set);
            votess::Options options = with_faces(test::unit_box(), false);
            options.outside = votess::Outside::keep;
            options.periodic[2] = set % 4 == 3;
            if (set % 4 == 2) options.walls = {{{1, 1, 0}, 1.5}};
            const std::size_t n = 6 + random.below(5);
            test::Coordinates points;
            for (std::size_t i = 0; i < 3 * n; ++i)
                points.push_back(std::round(0x1p10 * (options.periodic[2] && i % 3 == 2 ? random.uniform()
                                                                                        : random.uniform(-0.4, 1.4))) *
                                 0x1p-10);
            CAPTURE(points);
            const Dual d(points, options);
            if (!d.simplices.polytope_centers.empty()) continue;
            const auto expected = masses_in_octants(d, d.places);
            std::vector<double> masses(n * n, 0), grid(8 * n), column(4 * n);
            for (std::size_t i = 0; i < n; ++i) masses[i * n + i] = 1;
            const votess::Diagram diagram(points, options);
            votess::GridOptions request{.shape = {2, 2, 2}, .method = votess::GridMethod::dtfe, .columns = n};
            const std::size_t without = diagram.to_grid(masses, request, grid);
            CHECK(static_cast<std::ptrdiff_t>(without) ==
                  std::ranges::count_if(expected, [](const auto& octants) { return octants[0] == -1; }));
            request.project = 0;
            (void)diagram.to_grid(masses, request, column);
            for (std::size_t i = 0; i < n; ++i) {
                if (expected[i][0] == -1) continue;
                double inside = 0;
                for (std::size_t o = 0; o < 8; ++o) {
                    REQUIRE(std::abs(grid[o * n + i] / 8 - expected[i][o]) < 1e-12);
                    inside += expected[i][o];
                }
                for (std::size_t o = 0; o < 4; ++o)
                    REQUIRE(std::abs(column[o * n + i] / 4 - expected[i][o] - expected[i][4 + o]) < 1e-12);
                ++compared;
                partly += inside > 1e-6 && inside < 1 - 1e-6 ? 1 : 0;
            }
        }
        CHECK(compared > 20);
        CHECK(partly > compared / 4);
    }

    TEST_CASE("dtfe: densities that float64 cannot hold are refused, and others are kept at any scale") {
        const auto points = test::uniform(40, 9).points;
        for (const double scale : {0x1p-330, 0x1p-345, 0x1p-1000, 0x1p300, 0x1p345, 0x1p1000}) {
            CAPTURE(scale);
            auto scaled = points;
            for (double& x : scaled) x *= scale;
            const votess::Diagram diagram(scaled, with_faces(votess::Box{{0, 0, 0}, {scale, scale, scale}}, true));
            for (const double mass : {0x1p-1074, 0x1p-300, 1.0, 0x1p300, 0x1p1023}) {
                CAPTURE(mass);
                const int exponent = std::ilogb(mass) - 3 * std::ilogb(scale);
                std::vector<double> grid(1);
                const std::vector<double> masses(40, mass);
                const votess::GridOptions options{.shape = {1, 1, 1}, .method = votess::GridMethod::dtfe};
                // 40 of these, in a subnormal number that happens to hold them or not.
                if (exponent + 5 < -1022 && exponent + 5 > -1080) continue;
                if (exponent + 6 > 1024 || exponent + 5 < -1022) {
                    try {
                        diagram.to_grid(masses, options, grid);
                        FAIL("no refusal");
                    } catch (const votess::Error& error) {
                        CHECK(error.code() == votess::ErrorCode::invalid_argument);
                        CHECK(std::string(error.what()).find("to_grid(): element 0 of the grid has the mass ") == 0);
                    }
                    continue;
                }
                CHECK(diagram.to_grid(masses, options, grid) == 0);
                CHECK(std::abs(std::ldexp(grid[0], -exponent) - 40) < 1e-12);
            }
            // A column density needs less.
            if (std::abs(std::ilogb(scale)) < 500) {
                std::vector<double> grid(1);
                diagram.to_grid(std::vector<double>(40, 1),
                                {.shape = {1, 1, 1}, .method = votess::GridMethod::dtfe, .project = 1}, grid);
                CHECK(std::abs(grid[0] * scale * scale - 40) < 1e-12);
            }
        }
        // What is given as infinite or not a number stays so.
        std::vector<double> masses(40, 1), grid(1);
        masses[7] = std::numeric_limits<double>::infinity();
        const votess::Diagram diagram(points, with_faces(test::unit_box(), true));
        diagram.to_grid(masses, {.shape = {1, 1, 1}, .method = votess::GridMethod::dtfe}, grid);
        CHECK_FALSE(std::isfinite(grid[0]));
    }

    TEST_CASE("dtfe: a periodic lattice of equal masses has one density") {
        for (const auto& set : {test::cubic(4, 0.25), test::bcc(3), test::fcc(3)}) {
            CAPTURE(set.name);
            const auto t = votess::tessellate(set.points, with_faces(set.box, true));
            const double density = static_cast<double>(set.size()) / t.stats().box_volume;
            for (const double x : test::grid_of(votess::Diagram(set.points, with_faces(set.box, true)),
                                                std::vector<double>(set.size(), 1),
                                                {.shape = {5, 4, 12}, .method = votess::GridMethod::dtfe}))
                REQUIRE(std::abs(x - density) <= 1e-12 * density);
        }
    }

    TEST_CASE("dtfe: a density that is linear has its value at the center of each grid cell") {
        const auto linear = [](const double* x) { return 3 + x[0] - 2 * x[1] + 0.5 * x[2]; };
        const test::PointSet uniform = test::uniform(test::by_size(2000, 500), 5), lattice = test::cubic(6, 1.0 / 6);
        for (const auto& points : {uniform.points, lattice.points}) {
            const Dual d(points, with_faces(test::unit_box(), false));
            const auto parts = integrals(d);
            std::vector<double> masses(points.size() / 3);
            for (std::size_t i = 0; i < masses.size(); ++i) masses[i] = parts[i] * linear(&points[3 * i]);
            const votess::GridOptions options{.shape = {12, 10, 16}, .method = votess::GridMethod::dtfe};
            const auto grid =
                test::grid_of(votess::Diagram(points, with_faces(test::unit_box(), false)), masses, options);
            std::size_t inside = 0;
            for (std::size_t cell = 0; cell < grid.size(); ++cell) {
                const double center[3] = {(static_cast<double>(cell / 160) + 0.5) / 12,
                                          (static_cast<double>(cell / 16 % 10) + 0.5) / 10,
                                          (static_cast<double>(cell % 16) + 0.5) / 16};
                // The hull of random seeds ends before the walls.
                if (std::ranges::any_of(center, [](double x) { return x < 0.3 || x > 0.7; })) continue;
                ++inside;
                REQUIRE(std::abs(grid[cell] - linear(center)) <= 1e-10);
            }
            CHECK(inside > 50);
        }
    }

    TEST_CASE("dtfe: flat tetrahedra and planes of seeds") {
        // Almost a plane: tetrahedra as thin as rounding allows. Around them enough seeds for a hull.
        test::Random random(8);
        test::Coordinates points;
        for (int i = 0; i < 60; ++i)
            points.insert(points.end(), {random.uniform(), random.uniform(), 0.5 + 1e-15 * random.uniform()});
        for (int i = 0; i < 60; ++i)
            points.insert(points.end(), {random.uniform(), random.uniform(), random.uniform()});
        for (const bool periodic : {false, true}) {
            const votess::Diagram diagram(points, with_faces(test::unit_box(), periodic));
            const std::vector<double> masses(points.size() / 3, 1);
            const votess::GridOptions options{.shape = {6, 6, 6}, .method = votess::GridMethod::dtfe};
            std::vector<double> grid(216);
            const std::size_t without = diagram.to_grid(masses, options, grid);
            double sum = 0;
            for (const double x : grid) sum += x / 216;
            CHECK(sum == doctest::Approx(static_cast<double>(masses.size() - without)).epsilon(1e-11));
        }
        // A plane alone has no tetrahedron at all.
        const test::PointSet plane = test::on_axis_plane(50, 1);
        const votess::Diagram diagram(plane.points, with_faces(plane.box, false));
        std::vector<double> grid(8, -1);
        CHECK(diagram.to_grid(std::vector<double>(50, 1), {.shape = {2, 2, 2}, .method = votess::GridMethod::dtfe},
                              grid) == 50);
        CHECK(grid == std::vector<double>(8, 0));
    }
}
