// Cells of power diagrams that heavy seeds take, and long cells: how many seeds and boxes a search tests before it
// knows.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "cpu/cell_builder.hpp"
#include "cpu/cpu_clipper.hpp"
#include "index/hierarchy.hpp"
#include "index/sort.hpp"
#include "input/settle.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

struct Tests {
    double mean = 0;
    std::size_t empty = 0;
};

test::Coordinates uniform(std::size_t count) {
    test::Random random(5);
    test::Coordinates points(3 * count);
    for (double& x : points) x = random.uniform();
    return points;
}

// Searches the cells of seeds in the unit box, or in one as long as that along z. weight(i, x): of seed i at x.
template <class Weight>
Tests search_all(const test::Coordinates& points, Weight weight, double length = 1) {
    const std::size_t count = points.size() / 3;
    votess::Options options;
    options.box = votess::Box{{0, 0, length == 1 ? 0 : -length}, {1, 1, length}};
    std::vector<double> weights;
    for (std::size_t i = 0; i < count; ++i)
        weights.push_back(weight(i, std::array{points[3 * i], points[3 * i + 1], points[3 * i + 2]}));
    options.weights = weights;
    const votess::Job job = votess::make_job(votess::settle({points, {}}, options));
    votess::ThreadPool pool(1);
    votess::cpu::SeedSorter sorter;
    votess::cpu::SortedSeeds seeds;
    sort_inside(job.points, job.scale, 0, job.outside, sorter, pool, seeds);
    for (const std::int32_t i : seeds.input) seeds.weights.push_back(job.domain->weights[static_cast<std::size_t>(i)]);
    votess::cpu::Hierarchy hierarchy;
    hierarchy.build(seeds, pool);
    votess::cpu::CellBuilder builder(seeds, hierarchy);
    builder.begin_job(*job.domain);
    Tests tests;
    for (std::size_t s = 0; s < count; ++s) {
        tests.empty += builder.build(s).empty() ? 1 : 0;
        tests.mean += static_cast<double>(builder.tests()) / static_cast<double>(count);
    }
    return tests;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("hidden cells: one heavy seed buries all others, at a cost that does not depend on their number") {
        for (const std::size_t count : {test::by_size(2000, 500), test::by_size(16'000, 2000)}) {
            const Tests tests =
                search_all(uniform(count), [](std::size_t i, const auto&) { return i == 77 ? 1000.0 : 0.0; });
            CAPTURE(count);
            CHECK(tests.empty == count - 1);
            CHECK(tests.mean < 20);
        }
    }

    TEST_CASE("hidden cells: a heavy seed that buries some adds only the search for it to the cost of others") {
        const std::size_t count = test::by_size(8000, 1000);
        const Tests none = search_all(uniform(count), [](std::size_t, const auto&) { return 0.0; });
        const Tests one = search_all(uniform(count), [](std::size_t i, const auto&) { return i == 77 ? 0.05 : 0.0; });
        CHECK(one.empty > 0);
        CHECK(one.mean < 6 * none.mean);
    }

    TEST_CASE("hidden cells: most seeds lie where others own all") {
        // The diagram of seeds twice as far from 0: seven of eight cells lie outside.
        const std::size_t count = test::by_size(8000, 1000);
        const Tests tests = search_all(uniform(count), [](std::size_t, const std::array<double, 3>& x) {
            return -(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        });
        CHECK(static_cast<double>(tests.empty) > 0.75 * static_cast<double>(count));
        CHECK(tests.mean < 400);
    }

    TEST_CASE("hidden cells: owners that buried the last seeds bury the next ones, with few searches") {
        const std::size_t count = test::by_size(8000, 2000);
        test::Random random(6);
        const Tests rough = search_all(uniform(count), [&](std::size_t, const auto&) { return random.uniform(); });
        CHECK(static_cast<double>(rough.empty) > 0.9 * static_cast<double>(count));
        CHECK(rough.mean < 40);
        // All planes pass through the middle.
        const Tests tied = search_all(uniform(count), [](std::size_t, const std::array<double, 3>& x) {
            double square = 0;
            for (const double at : x) square += (at - 0.5) * (at - 0.5);
            return square;
        });
        CHECK(static_cast<double>(tied.empty) > 0.9 * static_cast<double>(count));
        CHECK(tied.mean < 400);
    }

    TEST_CASE("hidden cells: seeds that are dropped after the sort have no cell") {
        using votess::cpu::CpuClipper;
        const std::size_t count = test::by_size(4000, 2000);
        for (const std::string_view domain : {"box", "slab", "periodic", "wrapped", "triclinic", "skewed"}) {
            CAPTURE(domain);
            test::Coordinates points = uniform(count);
            test::Random random(7);
            votess::Options options;
            options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
            options.periodic = std::array{domain != "box" && domain != "slab", domain != "box", domain != "box"};
            if (domain == "wrapped")
                for (double& x : points) x += static_cast<double>(random.below(7)) - 3;
            if (domain == "triclinic" || domain == "skewed") {
                const double skew = domain == "skewed" ? 20 : 0.4;
                options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {skew, 1, 0}, {-0.3, 0.2, 1}};
                options.box.reset();
                options.periodic = {};
            }
            std::vector<double> weights(count);
            for (double& weight : weights) weight = 2 * random.uniform();
            options.weights = weights;
            const votess::Job job = votess::make_job(votess::settle({points, {}}, options));
            CpuClipper all, few;
            for (CpuClipper* clipper : {&all, &few}) clipper->begin(job);
            all.prepare();
            few.sort({}, CpuClipper::Keep::unburied);
            std::vector<bool> is_kept(count);
            for (const std::int32_t i : few.seeds().input) is_kept[static_cast<std::size_t>(i)] = true;
            CHECK(few.seeds().size() < count / 2);
            votess::cpu::CellBuilder builder(all.seeds(), all.hierarchy());
            builder.begin_job(*job.domain);
            for (std::size_t s = 0; s < count; ++s)
                CHECK((is_kept[static_cast<std::size_t>(all.seeds().input[s])] || builder.build(s).empty()));
        }
    }

    TEST_CASE("long cells: seeds on a line do not test all others") {
        for (const std::size_t count : {std::size_t{500}, test::by_size(8000, 2000)}) {
            test::Coordinates points = uniform(count);
            for (std::size_t i = 0; i < points.size(); ++i)
                if (i % 3 != 0) points[i] = 0.5 + 1e-6 * (points[i] - 0.5) / static_cast<double>(count);
            CAPTURE(count);
            CHECK(search_all(points, [](std::size_t, const auto&) { return 0.0; }).mean < 150);
        }
    }

    TEST_CASE("long cells: seeds in a plane and one beside it, in a box whose ends are far") {
        for (const std::size_t count : {std::size_t{250}, test::by_size(1000, 500)}) {
            test::Coordinates points = uniform(count);
            for (std::size_t i = 5; i < points.size(); i += 3) points[i] = 0.5;
            CAPTURE(count);
            // The cell beside the plane touches most others.
            for (const double length : {0x1p60, 0x1p160})
                CHECK(search_all(
                          points, [](std::size_t, const auto&) { return 0.0; }, length)
                          .mean < 200);
        }
    }
}
