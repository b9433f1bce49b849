// Frames whose box changes, and periodic ones.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <votess/vulkan.hpp>

#include "support/generators.hpp"
#include "support/gpu/frame.hpp"
#include "support/random.hpp"

using namespace test::frame;
using test::Coordinates;
using test::PointSet;

TEST_SUITE("cases") {
    TEST_CASE("gpu frame: a box that changes from frame to frame") {
        Host host;
        PointSet set = test::uniform(300, 13);
        PlanOptions options = options_for(set);
        const Plan plan = host.plan(options);
        Target target(host, plan);
        const Target* const one[] = {&target};
        for (const double factor : {1.0, 0.5, 3.0, 1e4}) {
            for (double& x : set.points) x *= factor;
            target.write<double>(set.points, 3);
            const votess::Box box = test::cube(-factor * factor, 2e4 * factor);
            run(host, one, {.count = options.max_seeds, .box = box});
            options.box = box;
            CHECK(compare(collect<double>(plan, target, set.size(), box), on_cpu(set, options)) == "");
        }
        host.commands.begin();
        CHECK(test::error_of([&] {
                  target.frame.record(host.commands.handle(), {.count = 1, .box = test::cube(1, 0)});
              }) == votess::ErrorCode::invalid_argument);
        host.commands.end();
    }

    TEST_CASE("gpu frame: periodic boxes, seeds up to a side outside") {
        Host host;
        const auto axes = [](unsigned bits) {
            return std::array<bool, 3>{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
        };
        for (const std::size_t n : {std::size_t{1}, std::size_t{2}, std::size_t{9}, test::by_size(1500, 200)})
            for (unsigned bits = n == 2 ? 6 : 1; bits < 8; bits += static_cast<unsigned>(test::by_size(3, 6))) {
                CAPTURE(n);
                CAPTURE(bits);
                PointSet set = test::uniform(n, n + bits);
                set.box = votess::Box{{-0.25, 0, 0.5}, {0.75, 1.5, 1.75}};
                test::Random random(n * bits);
                for (std::size_t i = 0; i < set.points.size(); ++i) {
                    const std::size_t k = i % 3;
                    const double side = set.box->upper[k] - set.box->lower[k];
                    set.points[i] = set.box->lower[k] + set.points[i] * side;
                    if (axes(bits)[k] && random.below(4) == 0)
                        set.points[i] += side * (random.below(2) == 0 ? 1 : -1) * 0.999;
                }
                set.points[0] = (bits & 1) != 0 ? set.box->upper[0] : set.box->lower[0];
                const votess::Box box = *set.box;
                set.box.reset();
                PlanOptions options = options_for(set);
                options.box = box;
                options.periodic = axes(bits);
                options.list_walls = n == 9;
                options.chunk_size = n == 9 ? 5 : 0;
                const OneFrame frame(host, options, set.points);
                check_header(frame.head(), frame.cells());
                if (n > 1000) CHECK(frame.head().unresolved < n / 10);
                const Rows rows = frame.rows();
                Rows absolute = rows;  // centroids are relative to the seed as given; the library's lie in the box
                const auto t = on_cpu(set, options);
                for (std::size_t i = 0; i < rows.centroids.size(); ++i) {
                    const std::size_t k = i % 3;
                    const double side = box.upper[k] - box.lower[k];
                    if (options.periodic[k])
                        absolute.centroids[i] -= side * std::round((absolute.centroids[i] - t.centroids()[i]) / side);
                }
                CHECK(compare(absolute, t) == "");
            }
    }

    TEST_CASE("gpu frame: a seed just a side outside of a periodic box, as doubles have it") {
        Host host;
        PointSet set = test::uniform(60, 15);
        set.box.reset();
        test::Random random(16);
        for (int tries = 0; tries < 6; ++tries) {
            PlanOptions options = options_for(set);
            options.periodic = {true, true, true};
            for (std::size_t k = 0; k < 3; ++k) {
                double side = 0;
                do {  // until the rounded place is more than a side away
                    options.box.lower[k] = random.uniform(-1, 1);
                    options.box.upper[k] = options.box.lower[k] + random.uniform(0.7, 1.5);
                    side = options.box.upper[k] - options.box.lower[k];
                } while (!(static_cast<long double>(options.box.lower[k] - side) <
                           static_cast<long double>(options.box.lower[k]) * 2 - options.box.upper[k]));
                for (std::size_t i = k; i < set.points.size(); i += 3)
                    set.points[i] = options.box.lower[k] + random.uniform(0.01, 0.99) * side;
                set.points[k] = options.box.lower[k] - side;
            }
            const OneFrame frame(host, options, set.points);
            check_header(frame.head(), frame.cells());
            const auto rows = frame.rows().rows;
            const auto t = on_cpu(set, options);
            for (std::size_t i = 0; i < t.size(); ++i) CHECK(std::ranges::equal(rows[i], t.neighbors(i)));
        }
    }

    TEST_CASE("gpu frame: periodic lattices, too few places for images, short margins, far seeds") {
        Host host;
        PointSet set = test::uniform(300, 14);
        PlanOptions options = options_for(set);
        options.box = test::unit_box();
        options.periodic = {true, true, true};
        const auto expected = on_cpu(set, options);
        std::uint32_t images = 0;
        for (const double margin : {0.0, 1e-3, 0.1, 7.0}) {
            options.margin = margin;
            options.max_images = margin == 7 ? 30 * options.max_seeds : 0;
            const OneFrame frame(host, options, set.points);
            if (margin == 0) images = frame.head().images;
            CHECK((margin == 1e-3) == (frame.head().images < 20));
            CHECK(compare(frame.rows(), expected) == "");
        }
        options.margin = 0;
        REQUIRE(images > 10);
        for (const std::uint32_t places : {1u, images - 1, images}) {
            options.max_images = places;
            const OneFrame frame(host, options, set.points);
            CHECK(frame.head().images == images);
            CHECK((frame.head().unresolved == options.max_seeds) == (places < images));
            CHECK(compare(frame.rows(), expected) == "");
        }
        const PointSet lattice = test::bcc(4);
        options = options_for(lattice);
        options.box = test::cube(0, 4);
        options.periodic = {true, true, true};
        CHECK(check(host, lattice, options) == "");
        // The first tier leaves all cells of a lattice, more than a tile has.
        const PointSet large = test::cubic(11);
        const OneFrame whole(host, options_for(large), large.points);
        CHECK(whole.head().unresolved == 0);
        CHECK(compare(whole.rows(), on_cpu(large, options_for(large))) == "");
        // Farther away than a side, or along an axis that is not periodic.
        Coordinates far = set.points;
        far[0] = std::numeric_limits<double>::quiet_NaN();
        far[4] = -1.5;
        far[8] = 1.5;
        options = options_for(set);
        options.box = test::unit_box();
        options.periodic = {true, true, false};
        options.margin = 0.05;  // leaves cells to resolve()
        const OneFrame frame(host, options, far);
        CHECK(frame.head().outside == 3);
        const Rows rows = frame.rows();
        // The first three seeds are skipped, in resolve() too.
        const PointSet rest{"rest", {far.begin() + 9, far.end()}, test::unit_box()};
        const auto t = on_cpu(rest, options);
        CHECK(frame.head().unresolved > 0);
        for (std::size_t i = 0; i < t.size(); ++i) {
            std::vector<std::int32_t> row(t.neighbors(i).begin(), t.neighbors(i).end());
            for (std::int32_t& id : row) id += 3;
            CHECK(rows.rows[i + 3] == row);
        }
        // Bounds that no common unit divides.
        options.box.lower[0] = -1e-30;
        CHECK(test::error_of([&] { Plan(host.device(), options); }) == votess::ErrorCode::unsupported);
    }
}
