// The option `cell`: triclinic boxes that are periodic along some of their edges, slabs and wires.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"

namespace {

using test::Coordinates;
using test::has;
using test::refusal;
using votess::Options;
using votess::TriclinicBox;
using Vector = std::array<double, 3>;

std::array<bool, 3> axes_of(unsigned mask) {
    return {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
}

Options with_cell(const TriclinicBox& cell) {
    Options options = test::all_options();
    options.cell = cell;
    return options;
}

Vector at(const TriclinicBox& cell, const Vector& f) {
    Vector x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = cell.origin[k] + f[0] * cell.a[k] + f[1] * cell.b[k] + f[2] * cell.c[k];
    return x;
}

TriclinicBox random_cell(test::Random& random, double tilt = 0.4) {
    TriclinicBox cell;
    for (auto* v : {&cell.origin, &cell.a, &cell.b, &cell.c})
        for (double& x : *v) x = random.uniform(-tilt, tilt);
    cell.a[0] += 1, cell.b[1] += 1, cell.c[2] += 1;
    if (random.below(2) == 0) std::swap(cell.a, cell.b);  // left-handed
    return cell;
}

// Seeds inside all walls, and up to two periods off along the other edges.
Coordinates points_in(const TriclinicBox& cell, test::Random& random, std::size_t n) {
    Coordinates points;
    for (std::size_t i = 0; i < n; ++i) {
        Vector f;
        for (std::size_t k = 0; k < 3; ++k)
            f[k] = cell.periodic[k] ? random.uniform(-2, 3) : random.uniform(1e-9, 1 - 1e-9);
        const Vector x = at(cell, f);
        points.insert(points.end(), x.begin(), x.end());
    }
    return points;
}

TriclinicBox times(TriclinicBox cell, double factor) {
    for (auto* vector : {&cell.origin, &cell.a, &cell.b, &cell.c})
        for (double& x : *vector) x *= factor;
    return cell;
}

Coordinates times(Coordinates points, double factor) {
    for (double& x : points) x *= factor;
    return points;
}

// Proves every array of an answer.
std::string certify(const TriclinicBox& cell, test::Random& random, std::size_t n) {
    Options options = with_cell(cell);
    options.want.faces = options.want.normals = options.want.areas = true;
    return test::check_right(points_in(cell, random, n), options);
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("cell: many seeds, periodic along any edges") {
        test::Random random(23);
        for (unsigned mask = 0; mask < 7; ++mask) {
            TriclinicBox cell = random_cell(random);
            cell.periodic = axes_of(mask);
            CAPTURE(mask);
            CHECK(certify(cell, random, test::by_size(300, 60)) == "");
        }
        // Walls that lean far over the lattice, and edges that are long ways to the opposite wall.
        for (const TriclinicBox& cell : {TriclinicBox{{}, {1, 0, 0}, {0, 1, 0}, {7, -5, 1}, {true, true, false}},
                                         {{}, {0.1, 0, 0}, {3, 1, 0}, {7, -5, 1}, {true, false, false}},
                                         {{}, {1, 0, 0}, {30, 1, 0}, {0, 0, 1}, {true, true, false}}})
            CHECK(certify(cell, random, 100) == "");
    }

    TEST_CASE("cell: along the axes it is the box, to the last digit of its rows") {
        const Coordinates points = test::uniform(test::by_size(3000, 300), 24).points;
        for (unsigned mask = 0; mask < 8; ++mask) {
            Options box = test::all_options(test::unit_box());
            box.periodic = axes_of(mask);
            Options cell = with_cell({{}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, axes_of(mask)});
            box.want.faces = cell.want.faces = true;
            const auto a = votess::tessellate(points, box), b = votess::tessellate(points, cell);
            CAPTURE(mask);
            CHECK(std::ranges::equal(a.indptr(), b.indptr()));
            CHECK(std::ranges::equal(a.indices(), b.indices()));
            CHECK(std::ranges::equal(a.shifts(), b.shifts()));
            CHECK(std::ranges::equal(a.face_offsets(), b.face_offsets()));
            CHECK(std::ranges::equal(a.face_vertices(), b.face_vertices()));
            const auto c = votess::delaunay(a), d = votess::delaunay(b);
            CHECK(!c.tetrahedra.empty());
            CHECK(c.tetrahedra == d.tetrahedra);
            CHECK(c.tetrahedra_shifts == d.tetrahedra_shifts);
            CHECK(c.tetrahedra_centers == d.tetrahedra_centers);
            CHECK(a.stats().box_volume == doctest::Approx(b.stats().box_volume).epsilon(1e-14));
            CHECK(b.periodic() == axes_of(mask));
            CHECK(b.cell()->periodic == axes_of(mask));
        }
    }

    TEST_CASE("cell: scales, far origins, and numbers too small for exact walls") {
        test::Random random(25);
        for (const int power : {-600, 40}) {
            TriclinicBox cell = random_cell(random);
            cell.periodic = {true, false, true};
            const Coordinates points = times(points_in(cell, random, 5), std::ldexp(1, power));
            Options options = with_cell(times(cell, std::ldexp(1, power)));
            options.want.areas = options.want.centroids = false;  // beyond the range of doubles
            CAPTURE(power);
            // Volumes underflow; rows must be right.
            CHECK_FALSE(has(test::check_against_half_spaces(votess::tessellate(points, options), points, options),
                            "exact are"));
        }
        TriclinicBox far = random_cell(random, 0.25);
        far.origin = {1e6, -3e5, 1e7};
        far.periodic = {false, true, true};
        CHECK(certify(far, random, 5) == "");
        const TriclinicBox tiny{{}, {1, 1e-200, 0}, {0, 1, 0}, {0, 0, 1}, {true, true, false}};
        CHECK(has(refusal({0.5, 0.5, 0.5}, with_cell(tiny)), "too small compared with the largest"));
        // Noise of a rotation is far from that.
        const TriclinicBox noise{{}, {1, 1e-17, 0}, {0, 1, 3e-17}, {6e-17, 0, 1}, {true, true, false}};
        CHECK(test::check_right({0.25, 0.5, 0.5, 0.75, 0.5, 0.5}, with_cell(noise)) == "");
    }

    // The edges span 3e-9 of the product of their lengths. The fuzz found that half of the digits were lost.
    TEST_CASE("cell: the volume of leaning edges has all its digits") {
        const Options options = with_cell({.origin = {0x1p+1, 0x1.f7b766d9c9cf9p+0, 0x1.30a6f7f895ef9p+0},
                                           .a = {0x1.8p+2, 0, 0},
                                           .b = {0x1.7454866666666p+18, 0x1.2076a91aef7f4p-7, 0},
                                           .c = {-0x1.b933333333333p+9, -0x1.c0a0b528ea8d8p+8, 0x1.1a2c7b4001a36p+6},
                                           .periodic = {false, true, true}});
        const Coordinates points{0x1.03ddp+18,          -0x1.572c8bb61af36p+8, 0x1.bbb23747c5049p+5,
                                 0x1.0629266666666p+17, 0x1.f88280786063fp+0,  0x1.30a6f8098d01cp+0,
                                 -0x1.97b3333333333p+9, -0x1.9e20915e5d69ap+8, 0x1.0a78c15ef96d6p+6};
        const votess::Tessellation t = votess::tessellate(points, options);
        const double volume = 3.7260513700581526;  // in rational arithmetic
        CHECK(std::abs(t.stats().box_volume - volume) <= 1e-15 * volume);
        CHECK(std::abs(t.stats().volume_sum - volume) <= 1e-13 * volume);
    }

    // Inner atoms of a face-centered crystal have 12 neighbors.
    TEST_CASE("cell: a crystal's surface has no neighbors across the vacuum") {
        const double spacing = 3.61 / std::sqrt(2.0), layer = 3.61 / std::sqrt(3.0), vacuum = 5;
        Options options = with_cell({{},
                                     {4 * spacing, 0, 0},
                                     {2 * spacing, 2 * std::sqrt(3.0) * spacing, 0},
                                     {0, 0, 5 * layer + 2 * vacuum},
                                     {true, true, false}});
        Coordinates points;
        for (int k = 0; k < 6; ++k)
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i) {
                    const double off = k % 3 / 3.0, u = i + off, v = j + off;
                    points.insert(points.end(),
                                  {(u + v / 2) * spacing, v * std::sqrt(3.0) / 2 * spacing, vacuum + k * layer});
                }
        CHECK(test::check_right(points, options) == "");
        options.min_face = 1e-6;
        options.list_walls = false;
        const auto t = votess::tessellate(points, options);
        for (std::size_t i = 0; i < t.size(); ++i) {
            CAPTURE(i);
            if (i >= 16 && i < 80) CHECK(t.neighbors(i).size() == 12);
            for (const std::int32_t j : t.neighbors(i)) CHECK(std::abs(static_cast<int>(i) / 16 - j / 16) < 3);
        }
        for (std::size_t e = 2; e < t.shifts().size(); e += 3) CHECK(t.shifts()[e] == 0);
    }

    TEST_CASE("cell: any size gives the same lists") {
        const TriclinicBox cell{{0.125, 0.25, 0}, {1, 0.25, 0}, {-0.25, 1.5, 0.125}, {0.5, 0, 1.25}};
        const Coordinates points{0.5, 0.5, 0.5, 0.25, 1, 0.75, 1, 0.75, 0.25, 0.75, 0.75, 1};
        CHECK(test::check_right(points, with_cell(cell)) == "");
        const auto expected = votess::tessellate(points, with_cell(cell));
        // 1e-110 and 1e103 are about 2^-365 and 2^342.
        for (const double factor :
             {0x1p-1000, 0x1p-400, 0x1p-365, 0x1p-110, 0x1p-64, 0x1p100, 0x1p342, 0x1p600, 0x1p1000}) {
            CAPTURE(factor);
            const Coordinates there = times(points, factor);
            const auto t = votess::tessellate(there, with_cell(times(cell, factor)));
            CHECK(std::ranges::equal(t.indptr(), expected.indptr()));
            CHECK(std::ranges::equal(t.indices(), expected.indices()));
            CHECK(std::ranges::equal(t.shifts(), expected.shifts()));
            for (std::size_t k = 0; k < 3; ++k) CHECK(t.box().upper[k] == expected.box().upper[k] * factor);
            for (std::size_t i = 0; i < t.size(); ++i)
                CHECK(t.volumes()[i] == expected.volumes()[i] * factor * factor * factor);
            CHECK(votess::verify(t, there).failure == "");
        }
        for (const double factor : {1e-110, 1e103, 1e-300, 1e300}) {
            CAPTURE(factor);
            const Coordinates there = times(points, factor);
            const auto t = votess::tessellate(there, with_cell(times(cell, factor)));
            CHECK(votess::verify(t, there).failure == "");
            CHECK(t.indices().size() == expected.indices().size());
        }
    }

    TEST_CASE("cell: without a volume it is refused, of any size") {
        for (const double factor : {0x1p-1060, 1e-110, 1.0, 1e103, 0x1p1000}) {
            CAPTURE(factor);
            for (const TriclinicBox& cell : {TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
                                             TriclinicBox{{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {0, 0, 1}}})
                CHECK(has(refusal({0, 0, 0}, with_cell(times(cell, factor))), "one plane"));
            const TriclinicBox without_edge{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 0, 1}};
            CHECK(has(refusal({0, 0, 0}, with_cell(times(without_edge, factor))), "b is 0, but the cell repeats"));
        }
        CHECK(has(refusal({}, with_cell({})), "a is 0, but the cell repeats"));
        const double length = 1e-110, huge = 1.5e308;
        CHECK(has(refusal({1, 1, 1}, with_cell({{1, 1, 1}, {length, 0, 0}, {0, length, 0}, {0, 0, length}})),
                  "too short"));
        CHECK(has(refusal({huge, 0, 0}, with_cell({{huge, 0, 0}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}})),
                  "largest double"));
    }

    TEST_CASE("cell: numbers that scaling would round are refused") {
        const double huge = 0x1p100, tiny = 0x1p-1000;
        const TriclinicBox cube{{0, 0, 0}, {huge, 0, 0}, {0, huge, 0}, {0, 0, huge}};
        CHECK(refusal({1, 1, 1}, with_cell(cube)) == "");
        const auto refused = [&](const TriclinicBox& cell, const std::string& what) {
            const std::string message = refusal({1, 1, 1}, with_cell(cell));
            CAPTURE(message);
            CHECK(has(message, what));
            CHECK(has(message, "9.33263618503"));
        };
        for (std::size_t k = 0; k < 3; ++k) {
            const std::string axis(1, "xyz"[k]);
            TriclinicBox cell = cube;
            cell.origin[k] = tiny;
            refused(cell, "cell: origin " + axis);
            cell = cube, cell.a[k] = tiny, cell.a[(k + 1) % 3] = huge, cell.b = {0, 0, 0}, cell.c = {0, 0, 0};
            cell.b[k] = cell.c[(k + 2) % 3] = huge;
            refused(cell, "cell: a " + axis);
            std::swap(cell.a, cell.b);
            refused(cell, "cell: b " + axis);
            std::swap(cell.b, cell.c);
            refused(cell, "cell: c " + axis);
        }
        // The scale leaves this one exact: eight faces, because the tilt parts ties.
        const TriclinicBox tilted{{0, 0, 0}, {huge, 0x1p-900, 0}, {0, huge, 0}, {0, 0, huge}};
        CHECK(votess::tessellate(Coordinates{0, 0, 0}, with_cell(tilted)).neighbors(0).size() == 8);
    }

    TEST_CASE("cell: periodic contradicts it, repeats it or is not set") {
        Options options = with_cell({{}, {1, 0, 0}, {0.25, 1, 0}, {0, 0, 1}});
        for (unsigned axes = 0; axes < 8; ++axes) {
            CAPTURE(axes);
            options.periodic = axes_of(axes);
            const std::string message = refusal({0.5, 0.5, 0.5}, options);
            if (axes == 0 || axes == 7)
                CHECK(message == "");
            else
                CHECK(has(message, "Options::cell.periodic and Options::periodic contradict each other"));
            options.cell->periodic = options.periodic;
            CHECK(refusal({0.5, 0.5, 0.5}, options) == "");
            options.cell->periodic = {true, true, true};
        }
        options.cell.reset();
        CHECK(has(refusal({0.5, 0.5, 0.5}, options), "Options::periodic needs a box"));
    }
}
