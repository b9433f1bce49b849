// clip: the vector kernels agree bit for bit, and the filter never contradicts the exact test.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <tuple>

#include "core/progress.hpp"
#include "core/thread_pool.hpp"
#include "polytope/cell.hpp"
#include "polytope/cell_kernels.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

using namespace votess::cpu;
using test::Random;

TEST_SUITE("stages") {
    TEST_CASE("clip: kernels of every instruction set give the same bits") {
        const auto kernels = supported_kernels();
        REQUIRE(std::string(kernels.back()->name) == "baseline");
        Random random(1);
        alignas(64) double x[64], y[64], z[64], tolerance[64], radius[64];
        for (int round = 0; round < 500; ++round) {
            for (int i = 0; i < 64; ++i) {
                x[i] = random.uniform(-1, 1), y[i] = random.uniform(-1, 1), z[i] = random.uniform(-1, 1);
                if (random.chance(0.2)) x[i] = y[i] = z[i] = 0.5;  // on the plane below, up to rounding
                tolerance[i] = 1e-15;
                radius[i] = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
            }
            const VertexBlock block{x, y, z, tolerance, radius, static_cast<int>(1 + random.below(8))};
            const double n = random.uniform(0.1, 3);
            const FilterPlane plane{n, n, n, 1.5 * n, n * std::sqrt(3.0), 1e-15};
            votess::Box box;
            for (int k = 0; k < 3; ++k)
                box.lower[k] = random.uniform(-3, 3), box.upper[k] = box.lower[k] + random.uniform();
            const auto sides = kernels.back()->classify(block, plane);
            const bool reach = kernels.back()->box_in_reach(block, box, 1.0, 0.0);
            const double largest = kernels.back()->largest_radius(block);
            // The baseline against the definitions.
            for (int i = 0; i < 8 * block.blocks; ++i) {
                const double excess = n * x[i] + n * y[i] + n * z[i] - plane.h;
                const double bound = plane.norm * tolerance[i] + plane.h_error;
                REQUIRE(((sides.possible >> i) & 1) == (excess >= -bound));
                REQUIRE(((sides.certain >> i) & 1) == (excess > bound));
                REQUIRE(radius[i] <= largest);
            }
            double out[64], other[64];
            const double p[3] = {0.1, 0.2, 0.3};
            kernels.back()->squared_distances(x, y, z, 61, p, out);
            for (const Kernels* k : kernels) {
                INFO(k->name);
                const auto s = k->classify(block, plane);
                REQUIRE(s.possible == sides.possible);
                REQUIRE(s.certain == sides.certain);
                REQUIRE(k->box_in_reach(block, box, 1.0, 0.0) == reach);
                REQUIRE(k->largest_radius(block) == largest);
                k->squared_distances(x, y, z, 61, p, other);
                for (int i = 0; i < 61; ++i) REQUIRE(other[i] == out[i]);
                const double from = random.uniform(0, 2), to = from + random.uniform();
                std::uint64_t keys[72];
                const int selected = k->select_band(out, 61, from, to, keys);
                int next = 0;
                for (int i = 0; i < 61; ++i) {
                    if (!(out[i] >= from && out[i] < to)) continue;
                    REQUIRE(next < selected);
                    REQUIRE(static_cast<int>(keys[next] & ~key_distance_bits) == i);
                    const double key = std::bit_cast<double>(keys[next++] & key_distance_bits);
                    REQUIRE(key <= out[i]);
                    REQUIRE(key >= out[i] * (1 - 1e-6));
                }
                REQUIRE(next == selected);
            }
        }
    }

    TEST_CASE("clip: a cell does not depend on the order of its planes") {
        // Ties abound on small integers; the canonical cell must not show which plane came first.
        Random random(2);
        const int sets = static_cast<int>(test::by_size(300, 40));
        for (int s = 0; s < sets; ++s) {
            const std::int64_t range = random.chance(0.5) ? 2 : 1000;
            std::vector<votess::exact::Point> seeds;
            for (int i = 0; i < 30; ++i)
                seeds.push_back({static_cast<double>(random.integer(-range, range)),
                                 static_cast<double>(random.integer(-range, range)),
                                 static_cast<double>(random.integer(-range, range))});
            const votess::exact::Point center{0, 0, 0};
            const votess::Box box{{-3. * range, -3. * range, -3. * range}, {3. * range, 3. * range, 3. * range}};
            std::vector<std::vector<votess::exact::Point>> answers;
            std::vector<double> volumes;
            for (int order = 0; order < 4; ++order) {
                Cell cell;
                cell.start(center, box);
                for (const auto i : test::permutation(seeds.size(), random))
                    if (seeds[i] != center) cell.clip(static_cast<std::int32_t>(i), seeds[i]);
                CellFaces faces;
                cell.canonical_faces(faces);
                CHECK(static_cast<int>(faces.vertex_count + faces.size()) - static_cast<int>(faces.edge_count) == 2);
                std::vector<votess::exact::Point> neighbors;  // by coordinates: seeds may repeat
                for (const auto f : faces.planes) {
                    const auto& plane = cell.planes()[f];
                    neighbors.push_back(plane.id < 0
                                            ? votess::exact::Point{100. * range, 0, static_cast<double>(plane.id)}
                                            : plane.source.seed);
                }
                std::sort(neighbors.begin(), neighbors.end());
                answers.push_back(neighbors);
                volumes.push_back(cell.measure(faces).volume);
                CHECK(answers[0] == neighbors);
                CHECK(volumes[0] == doctest::Approx(volumes.back()).epsilon(1e-12));
            }
        }
    }

    TEST_CASE("clip: a vertex that many bisectors almost touch") {
        // The seeds are integer points of a sphere around (5, 0, 0) with squared radius 75, so that its center is a
        // vertex of the cell. A candidate on the sphere but for x = e cuts that vertex off when e > 0, by 5 e.
        const votess::exact::Point center{5, 0, 0};
        const auto on_sphere = [&](double x, double y, double z) {
            return votess::exact::Point{center[0] + x, center[1] + y, center[2] + z};
        };
        const auto has_center = [](Cell& cell) {
            CellFaces faces;
            cell.canonical_faces(faces);
            return std::ranges::any_of(faces.corners, [&](int slot) {
                return std::ranges::all_of(cell.corner_planes(slot),
                                           [](const CellPlane* plane) { return plane->id >= 0 && plane->id < 3; });
            });
        };
        for (int exponent = -40; exponent >= -400; exponent -= 3) {
            for (const double sign : {-1.0, 1.0}) {
                const double e = sign * std::ldexp(1.0, exponent);
                Cell cell;
                cell.start(on_sphere(5, 5, 5), test::cube(-40, 40));
                std::int32_t id = 0;
                for (const auto& q : {on_sphere(5, 5, -5), on_sphere(5, -5, 5), on_sphere(-5, 5, 5)})
                    cell.clip(id++, q);
                // Misses by so little that the tests on this vertex change to higher precision.
                for (int miss = 0; miss < 12; ++miss) cell.clip(id++, {-std::ldexp(1.0, -60 - miss), 1, 7});
                REQUIRE(has_center(cell));
                INFO("e = ", e);
                cell.clip(id++, {e, -7, 1});
                CHECK(has_center(cell) == (e < 0));
                CHECK(cell.used_exact());
            }
        }
    }

    TEST_CASE("clip: a cell with more vertices than one mask word") {
        const auto set = test::on_sphere_and_center(test::by_size(3000, 300), 7);
        const std::size_t last = set.size() - 1;
        Cell cell;
        const votess::Box box = test::cube(-4, 4);
        cell.start({set.points[3 * last], set.points[3 * last + 1], set.points[3 * last + 2]}, box);
        for (std::size_t i = 0; i < last; ++i)
            cell.clip(static_cast<std::int32_t>(i), {set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]});
        CellFaces faces;
        cell.canonical_faces(faces);
        CHECK(faces.size() == last);
        CHECK(static_cast<int>(faces.vertex_count + faces.size()) - static_cast<int>(faces.edge_count) == 2);
    }

    TEST_CASE("clip: a very small cell has the faces and measures of a larger one, without exact arithmetic") {
        // Powers of two change no digit. From 2^-340 on the volume itself is too small.
        const auto measure = [](int exponent) {
            const double unit = std::ldexp(1.0, exponent);
            Random random(9);
            Cell cell;
            cell.start({}, test::cube(-unit, unit));
            for (int i = 0; i < 60; ++i) {
                std::array<double, 3> q{};
                for (double& x : q) x = unit * random.uniform(-1, 1);
                cell.clip(i, q);
            }
            CHECK_FALSE(cell.used_exact());
            CellFaces faces;
            cell.canonical_faces(faces);
            std::vector<double> areas;
            CellGeometry g = cell.measure(faces, &areas);
            for (double& x : g.centroid) x /= unit;
            return std::tuple(faces.planes, g.centroid, std::ldexp(g.volume, -3 * exponent),
                              std::ldexp(areas.front(), -2 * exponent));
        };
        const auto [planes, centroid, volume, area] = measure(0);
        CHECK(volume > 0);
        for (const int exponent : {-90, -150, -300, -450, -800, -880}) {
            CAPTURE(exponent);
            const auto found = measure(exponent);
            CHECK(std::get<0>(found) == planes);
            CHECK(std::get<1>(found) == centroid);
            if (exponent >= -300) CHECK(std::get<2>(found) == volume);
            if (exponent >= -450) CHECK(std::get<3>(found) == area);
        }
    }

    TEST_CASE("clip: a prism of very many walls is measured to its promise") {
        const std::size_t count = test::by_size(200'000, 20'000);
        const auto walls = votess::cylinder_walls({0, 0, 0}, {1, 2, 3}, 1, count);
        votess::Domain domain;
        domain.box = test::cube(-2, 2);
        for (const auto& wall : walls) domain.walls.push_back(votess::domain_wall(wall, 1, {}));
        votess::sort_walls(domain);
        Cell cell;
        cell.start({0.1, 0.05, -0.02}, domain);
        // Two bisectors across the axis, at equal distances from 0.
        cell.clip(0, votess::exact::Plane::any_wall({1, 2, 3}, 1));
        cell.clip(1, votess::exact::Plane::any_wall({-1, -2, -3}, 1));
        CellFaces faces;
        cell.canonical_faces(faces);
        REQUIRE(faces.size() == count + 2);
        const double angle = std::numbers::pi / static_cast<double>(count), around = std::tan(angle) / angle;
        const double across = std::numbers::pi * around, height = 2 / std::sqrt(14.0);
        std::vector<double> areas;
        const CellGeometry g = cell.measure(faces, &areas);
        CHECK(g.volume == doctest::Approx(across * height).epsilon(1e-10));
        CHECK(std::accumulate(areas.begin(), areas.end(), 0.0) ==
              doctest::Approx(2 * across * (1 + height)).epsilon(1e-10));
    }

    TEST_CASE("clip: a pyramid of very many walls has one apex") {
        const int m = static_cast<int>(test::by_size(1000, 100));
        votess::Domain domain;
        domain.box = {{-8, -8, -2}, {8, 8, 2}};
        std::vector<double> angles;
        for (int k = 1 - m; k <= m; ++k)
            for (const double side : {1.0, -1.0}) {  // whole numbers: each passes exactly through (0, 0, 1)
                const double x = side * (m * m - k * k), y = side * 2 * m * k, z = m * m + k * k;
                domain.walls.push_back(votess::domain_wall({{x, y, z}, z}, 1, {}));
                angles.push_back(std::atan2(y, x));
            }
        votess::sort_walls(domain);
        std::ranges::sort(angles);
        double base = 9 * std::tan((angles.front() - angles.back()) / 2 + std::numbers::pi);
        for (std::size_t k = 1; k < angles.size(); ++k) base += 9 * std::tan((angles[k] - angles[k - 1]) / 2);
        for (const double z : {0.0, 0.75, 1.0}) {  // of the seed, at last at the apex
            CAPTURE(z);
            Cell cell;
            cell.start({0, 0, z}, domain);
            CellFaces faces;
            cell.canonical_faces(faces);
            const std::size_t count = angles.size() + 1;
            CHECK(faces.size() == count);
            CHECK(faces.vertex_count == count);
            CHECK(faces.edge_count == 2 * (count - 1));
            CHECK(cell.measure(faces).volume == doctest::Approx(base).epsilon(1e-10));
        }
    }

    TEST_CASE("thread pool: every task once, exceptions come back, cancelling stops, and it works again after") {
        votess::ThreadPool pool(4);
        for (std::size_t count : {0, 1, 3, 1000}) {
            std::vector<std::atomic<int>> runs(count);
            pool.run(count, [&](std::size_t i, unsigned) { ++runs[i]; });
            for (auto& r : runs) REQUIRE(r == 1);
        }
        CHECK_THROWS_AS(pool.run(1000,
                                 [](std::size_t i, unsigned) {
                                     if (i == 500) throw std::runtime_error("task");
                                 }),
                        std::runtime_error);
        // Tasks end only when the user asks to stop, which the calling thread learns while it waits for the others.
        std::atomic<int> done = 0;
        votess::Progress progress([&](double) { return done < 10; });
        const auto cancelled = test::error_of([&] {
            const votess::Stoppable stoppable(progress);
            pool.run(1000, [&](std::size_t, unsigned) {
                if (++done <= 10) return;
                while (true) votess::check_stop(), std::this_thread::yield();
            });
        });
        CHECK(cancelled == votess::ErrorCode::cancelled);
        CHECK(done >= 10);
        CHECK(done < 1000);
        done = 0;
        pool.run(10, [&](std::size_t, unsigned) { ++done; });
        CHECK(done == 10);
    }
}
