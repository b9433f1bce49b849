// Walls of any direction: the device clips the cells, with the CPU's answer.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>
#include <votess/votess.hpp>

#include "cases/gpu/gpu_domain_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"
#include "support/scattered.hpp"

namespace {

using test::compare_domain;
using test::Coordinates;
using test::domain_options;
using test::random_points;
using votess::Options;

// Its six corners touch the unit box, and four walls meet in each.
Options octahedron() {
    Options options = domain_options();
    options.walls = test::octahedron(0.5);
    options.outside = votess::Outside::drop;
    return options;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu walls: only the cells of an octahedron's corners are left to the CPU") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const auto counts = compare_domain(on_device, random_points(test::by_size(3000, 1200), 1), octahedron());
        CHECK(counts.failure == "");
        CHECK(counts.fallback <= 8);
        CHECK(compare_domain(on_device, random_points(100, 2), octahedron()).failure == "");
    }

    // The CPU makes the cells of seeds outside; of those inside, only uncertain ones.
    TEST_CASE("gpu walls: seeds outside that are kept") {
        votess::Tessellator& on_device = test::shared_tessellator();
        test::Scattered s;
        for (const int kind : {0, 2, 3, 4}) {
            CAPTURE(kind);
            test::scatter(kind, test::by_size(600, 300), 0.2, false, 3, s);
            const auto counts = compare_domain(on_device, s.points, s.options);
            CHECK(counts.failure == "");
            const bool periodic = kind == 2;
            if (kind == 0) CHECK(counts.fallback < s.points.size() / 3);
            if (periodic) CHECK(counts.fallback == s.points.size() / 3);
        }
    }

    TEST_CASE("gpu walls: one wall, a wedge, walls that cut nothing, both precisions") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(600, 300);
        Options options = domain_options();
        options.outside = votess::Outside::drop;
        options.walls = {{{1, 0.3, 0.2}, 0.9}, {{1, 0, 0}, 1}, {{1, 1, 1}, 3}};
        for (const bool twice : {false, true}) {
            if (twice) options.precision = test::double_precision();
            auto counts = compare_domain(on_device, random_points(many, 3), options);
            CHECK(counts.failure == "");
            CHECK(counts.fallback <= many / 50);
            Options wedge = options;
            wedge.walls.push_back({{-1, -0.3, -0.20001}, -0.88});
            counts = compare_domain(on_device, random_points(8 * many, 4), wedge);
            CHECK(counts.failure == "");
            CHECK(counts.fallback <= many / 50);
        }
    }

    TEST_CASE("gpu walls: a sphere of three hundred, a long box, a single cell") {
        votess::Tessellator& on_device = test::shared_tessellator();
        Options options = domain_options();
        options.outside = votess::Outside::drop;
        options.walls = votess::sphere_walls({0.5, 0.5, 0.5}, 0.4, 300);
        const std::size_t many = test::by_size(1500, 600);
        auto counts = compare_domain(on_device, random_points(many, 5), options);
        CHECK(counts.failure == "");
        CHECK(counts.fallback <= many / 50);
        options.box = votess::Box{{0, 0, 0}, {1000, 1, 1}};
        options.walls = {{{0.001, 1, 0}, 1.4}, {{-0.001, 0.5, -1}, -0.3}};
        Coordinates points = random_points(many, 6);
        for (std::size_t i = 0; i < points.size(); i += 3) points[i] *= 1000;
        CHECK(compare_domain(on_device, points, options).failure == "");
        // The cell is far smaller than the box, whose side is its unit of length.
        options.box = test::unit_box();
        options.walls = votess::sphere_walls({0.3, 0.6, 0.2}, 1e-5, 12);
        CHECK(compare_domain(on_device, {0.3, 0.6, 0.2}, options).failure == "");
    }

    TEST_CASE("gpu walls: seeds on walls, and on a lattice along them") {
        votess::Tessellator& on_device = test::shared_tessellator();
        Options options = domain_options();
        options.outside = votess::Outside::drop;
        options.walls = {{{1, 1, 0}, 1}, {{0.3, -0.2, 1}, 0.7}};
        Coordinates points = random_points(200, 7);
        for (std::size_t i = 0; i < points.size(); i += 6) {
            const votess::Wall& wall = options.walls[i / 6 % 2];
            double over = -wall.offset, square = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                over += wall.normal[k] * points[i + k];
                square += wall.normal[k] * wall.normal[k];
            }
            for (std::size_t k = 0; k < 3; ++k) points[i + k] -= over / square * wall.normal[k];
            for (std::size_t k = 0; k < 3; ++k) points[i + k] = std::clamp(points[i + k], 0.0, 1.0);
        }
        CHECK(compare_domain(on_device, points, options).failure == "");
        Coordinates lattice;
        for (int i = 0; i < 216; ++i) lattice.insert(lattice.end(), {i % 6 / 6.0, i / 6 % 6 / 6.0, i / 36 / 6.0});
        CHECK(compare_domain(on_device, lattice, options).failure == "");
    }

    TEST_CASE("gpu walls: triclinic boxes with walls, periodic or not, dropped seeds and duplicates") {
        votess::Tessellator& on_device = test::shared_tessellator();
        const std::size_t many = test::by_size(1000, 300);
        Options options = domain_options();
        options.box.reset();
        options.outside = votess::Outside::drop;
        const double third = 1.0 / 3;
        for (unsigned mask = 0; mask < 7; ++mask) {
            options.cell = votess::TriclinicBox{
                {0.1, 0.2, 0.3}, {1 + third, 0.1, 0}, {third, 1 - third / 7, 0}, {-third / 5, third * 1.1, 1}};
            options.cell->periodic = {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0};
            Coordinates points = random_points(many, 10 + mask, -0.1, 1.4);
            for (std::size_t i = 0; i < 30; ++i) points.push_back(points[90 + i]);
            CAPTURE(mask);
            const auto counts = compare_domain(on_device, points, options);
            CHECK(counts.failure == "");
            CHECK(counts.fallback <= many / 20);
        }
    }
}
