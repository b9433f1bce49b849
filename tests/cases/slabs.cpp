// Triclinic boxes that are periodic along some of their edges, and end at walls across the others: slabs and wires.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "oracle/certificate.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
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

// Seeds inside of all walls, and up to two periods off along the other edges.
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

std::string check(const Coordinates& points, const Options& options, int reach) {
    const auto t = votess::tessellate(std::span<const double>(points), options);
    if (auto failure = test::check_domain(t); !failure.empty()) return failure;
    if (auto failure = votess::verify(t, points).failure; !failure.empty()) return failure;
    return test::check_against_half_spaces(t, points, options, reach);
}

// Everything that can be wanted, certified.
std::string certify(const Coordinates& points, Options options) {
    options.want.faces = options.want.normals = options.want.areas = true;
    const auto t = votess::tessellate(std::span<const double>(points), options);
    if (auto failure = test::check_domain(t); !failure.empty()) return failure;
    if (auto failure = votess::verify(t, points).failure; !failure.empty()) return failure;
    return test::check_certificate(t, points, options);
}

std::string refusal(const Coordinates& points, const Options& options) {
    try {
        (void)votess::tessellate(std::span<const double>(points), options);
    } catch (const votess::Error& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("slabs: any edges of triclinic cells, few seeds, against exact half-spaces") {
        test::Random random(21);
        for (std::uint64_t round = 0; round < test::by_size(4, 1); ++round)
            for (unsigned mask = 0; mask < 7; ++mask)
                for (const std::size_t n : {1, 2, 6}) {
                    TriclinicBox cell = random_cell(random);
                    cell.periodic = axes_of(mask);
                    Options options = with_cell(cell);
                    const Coordinates points = points_in(cell, random, n);
                    CAPTURE(round);
                    CAPTURE(mask);
                    CAPTURE(n);
                    CHECK(check(points, options, 3) == "");
                    std::vector<double> weights(n);
                    for (double& w : weights) w = random.uniform(-0.05, 0.2);
                    options.weights = weights;
                    CHECK(check(points, options, 3) == "");
                }
    }

    TEST_CASE("slabs: seeds on the walls, edges and corners of cells, and ties") {
        test::Random random(22);
        for (std::uint64_t round = 0; round < test::by_size(12, 3); ++round)
            for (unsigned mask = 0; mask < 7; ++mask) {
                // Whole numbers, so that seeds lie on the walls exactly.
                TriclinicBox cell{{-1, 0, 2}, {4, 0, 0}, {1, 4, 0}, {-1, 2, 4}, axes_of(mask)};
                if (round % 2 == 1) cell = {{0, 0, 0}, {4, 1, 1}, {0, 4, 1}, {4, 0, 4}, axes_of(mask)};
                Coordinates points;
                for (int i = 0; i < 5; ++i) {
                    const auto step = [&] { return static_cast<double>(random.below(5)) / 4; };
                    const Vector x = at(cell, {step(), step(), step()});
                    points.insert(points.end(), x.begin(), x.end());
                }
                const Options options = with_cell(cell);
                CAPTURE(round);
                CAPTURE(mask);
                const auto t = votess::tessellate(std::span<const double>(points), options);
                CHECK(test::check_domain(t) == "");
                CHECK(votess::verify(t, points).failure == "");
                if (t.stats().duplicates == 0) CHECK(test::check_against_half_spaces(t, points, options, 3) == "");
            }
    }

    TEST_CASE("slabs: many seeds, certified, for all kinds of cells") {
        test::Random random(23);
        for (unsigned mask = 0; mask < 7; ++mask) {
            TriclinicBox cell = random_cell(random);
            cell.periodic = axes_of(mask);
            CAPTURE(mask);
            CHECK(certify(points_in(cell, random, test::by_size(400, 60)), with_cell(cell)) == "");
        }
        // Walls that lean far over the lattice; and an edge that is no short way to the opposite wall.
        CHECK(certify(points_in({{}, {1, 0, 0}, {0, 1, 0}, {7, -5, 1}, {true, true, false}}, random, 100),
                      with_cell({{}, {1, 0, 0}, {0, 1, 0}, {7, -5, 1}, {true, true, false}})) == "");
        CHECK(certify(points_in({{}, {0.1, 0, 0}, {3, 1, 0}, {7, -5, 1}, {true, false, false}}, random, 100),
                      with_cell({{}, {0.1, 0, 0}, {3, 1, 0}, {7, -5, 1}, {true, false, false}})) == "");
        CHECK(certify(points_in({{}, {1, 0, 0}, {30, 1, 0}, {0, 0, 1}, {true, true, false}}, random, 100),
                      with_cell({{}, {1, 0, 0}, {30, 1, 0}, {0, 0, 1}, {true, true, false}})) == "");
    }

    TEST_CASE("slabs: a cell along the axes is the box, to the last digit of its rows") {
        test::Random random(24);
        Coordinates points(3 * test::by_size(3000, 300));
        for (double& x : points) x = random.uniform();
        for (unsigned mask = 0; mask < 8; ++mask) {
            Options box = test::all_options(test::unit_box());
            box.periodic = axes_of(mask);
            Options cell = with_cell({{}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, axes_of(mask)});
            box.want.faces = cell.want.faces = true;
            const auto a = votess::tessellate(std::span<const double>(points), box);
            const auto b = votess::tessellate(std::span<const double>(points), cell);
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

    TEST_CASE("slabs: which seeds lie outside is exact") {
        // The wall across c goes through (1/3, 1/3, 1) as rounded: nobody can write down its normal in doubles.
        const TriclinicBox cell{{}, {1, 0, 1.0 / 3}, {0, 1, 1.0 / 7}, {1.0 / 3, 1.0 / 3, 1}, {true, true, false}};
        const Coordinates on{cell.c[0], cell.c[1], cell.c[2], 0.5, 0.5, 0.5};
        CHECK(refusal(on, with_cell(cell)) == "");
        Coordinates above = on;
        above[2] = std::nextafter(above[2], 2);
        CHECK(refusal(above, with_cell(cell)).find("point 0: (") == 0);
        CHECK(refusal(above, with_cell(cell)).find("is outside of the cell") != std::string::npos);
        Options options = with_cell(cell);
        options.outside = votess::Outside::drop;
        const auto t = votess::tessellate(std::span<const double>(above), options);
        CHECK(t.status()[0] == votess::CellStatus::outside);
        CHECK(t.status()[1] == votess::CellStatus::certified);
        CHECK(t.volumes()[1] == doctest::Approx(t.stats().box_volume).epsilon(1e-12));
        above[2] = 1e300;  // more periods away than there are
        CHECK(votess::tessellate(std::span<const double>(above), options).status()[0] == votess::CellStatus::outside);
        options.cell.reset();
        options.box = test::unit_box();
        options.periodic = {true, false, false};
        above[0] = 1e300;
        CHECK(votess::tessellate(std::span<const double>(above), options).status()[0] == votess::CellStatus::outside);
    }

    TEST_CASE("slabs: scales, far origins, and numbers too small for exact walls") {
        test::Random random(25);
        for (const int power : {-600, 40}) {
            TriclinicBox cell = random_cell(random);
            cell.periodic = {true, false, true};
            Coordinates points = points_in(cell, random, 5);
            for (auto* v : {&cell.origin, &cell.a, &cell.b, &cell.c})
                for (double& x : *v) x = std::ldexp(x, power);
            for (double& x : points) x = std::ldexp(x, power);
            Options options = with_cell(cell);
            options.want.areas = options.want.centroids = false;  // beyond the range of doubles
            const auto t = votess::tessellate(std::span<const double>(points), options);
            CAPTURE(power);
            CHECK(test::check_against_half_spaces(t, points, options,
                                                  std::abs(power) > 100 ? std::optional<int>{} : std::optional<int>{3})
                      .find("exact are") == std::string::npos);
        }
        TriclinicBox far = random_cell(random, 0.25);
        far.origin = {1e6, -3e5, 1e7};
        far.periodic = {false, true, true};
        CHECK(check(points_in(far, random, 5), with_cell(far), 3) == "");
        const TriclinicBox tiny{{}, {1, 1e-200, 0}, {0, 1, 0}, {0, 0, 1}, {true, true, false}};
        CHECK(refusal({0.5, 0.5, 0.5}, with_cell(tiny)).find("too small compared with the largest") !=
              std::string::npos);
        // Noise of a rotation is far from that.
        const TriclinicBox noise{{}, {1, 1e-17, 0}, {0, 1, 3e-17}, {6e-17, 0, 1}, {true, true, false}};
        CHECK(check({0.25, 0.5, 0.5, 0.75, 0.5, 0.5}, with_cell(noise), 2) == "");
    }

    // Inner atoms of a face-centered crystal have 12 neighbors; rows of the outer ones are those of brute force.
    TEST_CASE("slabs: the volume of leaning edges has all its digits") {
        // The edges span 3e-9 of the product of their lengths; what fuzz found had lost half of its digits.
        Options options = test::all_options();
        options.cell = TriclinicBox{.origin = {0x1p+1, 0x1.f7b766d9c9cf9p+0, 0x1.30a6f7f895ef9p+0},
                                    .a = {0x1.8p+2, 0, 0},
                                    .b = {0x1.7454866666666p+18, 0x1.2076a91aef7f4p-7, 0},
                                    .c = {-0x1.b933333333333p+9, -0x1.c0a0b528ea8d8p+8, 0x1.1a2c7b4001a36p+6},
                                    .periodic = {false, true, true}};
        const Coordinates points{0x1.03ddp+18,          -0x1.572c8bb61af36p+8, 0x1.bbb23747c5049p+5,
                                 0x1.0629266666666p+17, 0x1.f88280786063fp+0,  0x1.30a6f8098d01cp+0,
                                 -0x1.97b3333333333p+9, -0x1.9e20915e5d69ap+8, 0x1.0a78c15ef96d6p+6};
        const votess::Tessellation t = votess::tessellate(points, options);
        const double volume = 3.7260513700581526;  // in rational arithmetic
        CHECK(std::abs(t.stats().box_volume - volume) <= 1e-15 * volume);
        CHECK(std::abs(t.stats().volume_sum - volume) <= 1e-13 * volume);
    }

    TEST_CASE("slabs: a crystal's surface has nothing across the vacuum") {
        const double spacing = 3.61 / std::sqrt(2.0), layer = 3.61 / std::sqrt(3.0), vacuum = 5;
        TriclinicBox cell{
            {}, {4 * spacing, 0, 0}, {2 * spacing, 2 * std::sqrt(3.0) * spacing, 0}, {}, {true, true, false}};
        cell.c = {0, 0, 5 * layer + 2 * vacuum};
        Coordinates points;
        for (int k = 0; k < 6; ++k)
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i) {
                    const double off = k % 3 / 3.0, u = i + off, v = j + off;
                    points.insert(points.end(),
                                  {(u + v / 2) * spacing, v * std::sqrt(3.0) / 2 * spacing, vacuum + k * layer});
                }
        Options options = with_cell(cell);
        CHECK(certify(points, options) == "");
        options.min_face = 1e-6;
        options.list_walls = false;
        const auto t = votess::tessellate(std::span<const double>(points), options);
        for (std::size_t i = 0; i < t.size(); ++i) {
            CAPTURE(i);
            const bool outer = i < 16 || i >= 80;
            if (!outer) CHECK(t.neighbors(i).size() == 12);
            for (const std::int32_t j : t.neighbors(i)) CHECK(std::abs(static_cast<int>(i) / 16 - j / 16) < 3);
        }
        for (const std::int8_t* s = t.shifts().data(); s != t.shifts().data() + t.shifts().size(); s += 3)
            CHECK(s[2] == 0);
    }

    TEST_CASE("slabs: every instruction set gives the same") {
        test::Random random(26);
        for (unsigned mask : {0u, 3u, 4u}) {
            TriclinicBox cell = random_cell(random);
            cell.periodic = axes_of(mask);
            const Coordinates points = points_in(cell, random, 200);
            Options options = with_cell(cell);
            const auto cpu = votess::tessellate(std::span<const double>(points), options);
            for (const char* const instructions : {"baseline", "avx2"}) {
                options.instructions = instructions;
                try {
                    const auto t = votess::tessellate(std::span<const double>(points), options);
                    CHECK(test::check_same_cells(t, cpu) == "");
                } catch (const votess::Error& error) {
                    CHECK(error.code() == votess::ErrorCode::unsupported);
                }
            }
        }
    }
}
