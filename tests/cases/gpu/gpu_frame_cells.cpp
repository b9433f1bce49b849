// Frames in triclinic boxes and with areas, and few cells that resolve() makes from the seeds near them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>
#include <votess/vulkan.hpp>

#include "support/generators.hpp"
#include "support/gpu/frame.hpp"
#include "support/random.hpp"

using namespace test::frame;
using test::PointSet;

namespace {

// Checks that `some` are the cells that need exact arithmetic, and that they equal those of t.
void check_resolved(const Resolved& some, const std::vector<Cell>& cells, const votess::Tessellation& t) {
    std::size_t r = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells[i].status != static_cast<std::uint32_t>(CellStatus::needs_exact)) continue;
        REQUIRE(r < some.cells.size());
        REQUIRE(some.cells[r] == i);
        const auto length = static_cast<std::size_t>(some.indptr[r + 1] - some.indptr[r]);
        CHECK(some.status[r] == t.status()[i]);
        CHECK(std::ranges::equal(std::span(some.indices).subspan(static_cast<std::size_t>(some.indptr[r]), length),
                                 t.neighbors(i)));
        CHECK(some.volumes[r] == doctest::Approx(t.volumes()[i]).epsilon(1e-13));
        ++r;
    }
    CHECK(r == some.cells.size());
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu frame: triclinic boxes, two frames in flight with moving seeds") {
        Host host;
        const double third = 1.0 / 3;
        const std::vector<votess::TriclinicBox> cells{
            {{-0.3, 0.1, 0.7}, {1, 0, 0}, {0.45, 1, 0}, {-0.45, 0.45, 1}},
            {{0, 0, 0}, {third, 0.1, 0}, {0, 0.7 * third, -0.05}, {0.02, 0.1, 1.1}},
            {{2, 2, 2}, {0, 1, 0}, {1, 0, 0}, {0, 0.25, 0.3}}};
        for (const votess::TriclinicBox& cell : cells)
            for (const bool by_subgroup : {false, true}) {
                if (by_subgroup && &cell != &cells.front()) continue;
                std::optional<test::UseKernel> kernel;
                if (by_subgroup) kernel.emplace(test::by_subgroup());
                const std::size_t n = test::by_size(500, 150);
                PlanOptions options;
                options.max_seeds = static_cast<std::uint32_t>(n);
                options.format = SeedFormat::float64;
                options.max_entries = 64 * options.max_seeds;
                options.areas = true;
                options.cell = cell;
                const Plan plan = host.plan(options);
                Target first(host, plan), second(host, plan);
                const Target* const both[] = {&first, &second};
                test::Random random(31);
                for (int frame = 0; frame < 2; ++frame) {
                    PointSet sets[2];
                    for (int t = 0; t < 2; ++t) {
                        for (std::size_t i = 0; i < n; ++i) {
                            const double f[3] = {random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2),
                                                 random.uniform(-0.2, 1.2)};
                            for (std::size_t k = 0; k < 3; ++k)
                                sets[t].points.push_back(cell.origin[k] + f[0] * cell.a[k] + f[1] * cell.b[k] +
                                                         f[2] * cell.c[k]);
                        }
                    }
                    first.write<double>(sets[0].points, 3);
                    second.write<double>(sets[1].points, 3);
                    run(host, both, {.count = options.max_seeds});
                    for (int t = 0; t < 2; ++t) {
                        const Target& target = *both[t];
                        check_header(target.head(), target.cell(n));
                        CHECK(target.head().outside == 0);
                        CHECK(target.head().unresolved < n / 5);
                        Rows rows = collect<double>(plan, target, n);
                        const auto expected = on_cpu(sets[t], options);
                        // The library's centroids lie in the box; those of frames are relative to the seed as given.
                        for (std::size_t i = 0; i < n; ++i)
                            if (target.cell(n)[i].status == 0)
                                std::copy_n(expected.centroids().begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                                            rows.centroids.begin() + static_cast<std::ptrdiff_t>(3 * i));
                        CHECK(compare(rows, expected) == "");
                    }
                }
            }
    }

    TEST_CASE("gpu frame: areas beside the rows") {
        const PointSet set = test::uniform(300, 33);
        for (const unsigned mode : {0u, 1u, 2u, 3u}) {
            CAPTURE(mode);
            Host host(mode != 0);
            std::optional<test::UseKernel> kernel;
            if (mode == 1) kernel.emplace(test::by_subgroup());
            std::optional<test::Environment> sums;
            if (mode == 3) sums.emplace("VOTESS_VULKAN_MEASURE", "float32");
            PlanOptions options = options_for(set);
            options.list_walls = true;
            options.geometry = mode != 0;
            options.chunk_size = 100;
            options.k_init = mode == 3 ? 12 : 0;  // leaves cells to the second tier
            if (mode == 2) options.box = test::unit_box(), options.periodic = {true, true, false};
            const OneFrame frame(host, options, set.points);
            CHECK(frame.head().certified > 200);
            CHECK(compare(frame.rows(), on_cpu(set, options)) == "");
        }
        Host host;
        PlanOptions options = options_for(set);
        options.neighbors = false;
        CHECK(test::error_of([&] { Plan(host.device(), options); }) == votess::ErrorCode::invalid_argument);
    }

    TEST_CASE("gpu frame: seeds on the faces of a triclinic box, and too far to be wrapped; a cell of each frame") {
        Host host;
        PointSet set = test::uniform(200, 32);
        set.box.reset();
        PlanOptions options;
        options.max_seeds = 200;
        options.format = SeedFormat::float64;
        options.max_entries = 64 * options.max_seeds;
        options.areas = true;
        options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.25, 1, 0}, {0, 0.125, 1}};
        for (std::size_t i = 0; i < set.size(); ++i) {
            double* const x = set.points.data() + 3 * i;
            x[1] += 0.125 * x[2], x[0] += 0.25 * (x[1] - 0.125 * x[2]);
        }
        const Plan plan = host.plan(options);
        Target target(host, plan);
        const auto check_frame = [&](const std::optional<votess::TriclinicBox>& cell) {
            target.write<double>(set.points, 3);
            const Target* const one[] = {&target};
            run(host, one, {.count = options.max_seeds, .cell = cell});
            check_header(target.head(), target.cell(set.size()));
            PlanOptions used = options;
            if (cell) used.cell = cell;
            const auto t = on_cpu(set, used);
            const Rows rows = collect<double>(plan, target, set.size(), {}, cell);
            for (std::size_t i = 0; i < t.size(); ++i) {
                CHECK(std::ranges::equal(rows.rows[i], t.neighbors(i)));
                CHECK(std::ranges::equal(rows.shifts[i], t.shifts().subspan(3 * static_cast<std::size_t>(t.indptr()[i]),
                                                                            3 * t.neighbors(i).size())));
            }
            return target.head().unresolved;
        };
        CHECK(check_frame({}) < 40);
        CHECK(check_frame(votess::TriclinicBox{{0.1, 0, 0}, {1, 0, 0}, {0.2, 1, 0}, {0, 0.1, 1}}) < 40);
        set.points[2] = 0;  // certainly on a face
        CHECK(check_frame({}) < 40);
        set.points[5] = 1;  // on the opposite one, not certainly
        CHECK(check_frame({}) == options.max_seeds);
        set.points[5] = 4;
        target.write<double>(set.points, 3);
        run(host, target, options.max_seeds);
        CHECK(target.head().outside == 1);

        const auto code_of = [&](auto change) {
            PlanOptions changed = options;
            change(changed);
            return test::error_of([&] { Plan(host.device(), changed); });
        };
        using votess::ErrorCode;
        CHECK(code_of([](PlanOptions& o) { o.box = test::unit_box(); }) == ErrorCode::invalid_argument);
        CHECK(code_of([](PlanOptions& o) { o.periodic[1] = true; }) == ErrorCode::invalid_argument);
        CHECK(code_of([](PlanOptions& o) { o.cell->c = o.cell->a; }) == ErrorCode::invalid_argument);
        CHECK(code_of([](PlanOptions& o) { o.cell->periodic[2] = false; }) == ErrorCode::unsupported);
        CHECK(code_of([](PlanOptions& o) { o.cell->c = {20, 3, 1}; }) == ErrorCode::unsupported);
        host.commands.begin();
        CHECK(test::error_of([&] {
                  target.frame.record(host.commands.handle(), {.count = 1, .box = test::unit_box()});
              }) == ErrorCode::invalid_argument);
        host.commands.end();
    }

    // No frame is recorded: resolve() uses the given cells.
    TEST_CASE("gpu frame: few cells are resolved from the seeds near them") {
        Host host;
        for (const unsigned bits : {0u, 7u, 2u})
            for (PointSet set : {test::uniform(20000, 20), test::clustered(20000, 21), test::uniform(30000, 22)}) {
                CAPTURE(set.name);
                CAPTURE(bits);
                if (set.size() == 30000)  // a void that cells reach across
                    for (std::size_t i = 0; i < set.points.size(); i += 3)
                        if (std::hypot(set.points[i] - 0.5, set.points[i + 1] - 0.5, set.points[i + 2] - 0.5) < 0.3)
                            set.points[i] *= 0.1;
                set.box.reset();
                PlanOptions options = options_for(set);
                options.periodic = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
                options.list_walls = true;
                const Plan plan = host.plan(options);
                const auto t = on_cpu(set, options);
                std::vector<Cell> cells(set.size());
                test::Random random(23);
                std::size_t left = 0;
                for (std::size_t i = 0; i < set.size(); ++i) {
                    cells[i].status = static_cast<std::uint32_t>(t.status()[i]);
                    if (random.below(1500) != 0) continue;
                    cells[i].status = static_cast<std::uint32_t>(CellStatus::needs_exact);
                    ++left;
                }
                REQUIRE(left > 5);
                check_resolved(plan.resolve(std::span<const double>(set.points), cells), cells, t);
            }
    }

    TEST_CASE("gpu frame: few cells with weights or between walls are resolved from the seeds near them") {
        Host host;
        for (const unsigned kind : {0u, 1u, 2u}) {
            CAPTURE(kind);
            const bool with_walls = kind == 2;
            PointSet set = test::uniform(10000, 24);
            set.box.reset();
            PlanOptions options = options_for(set);
            options.box = test::unit_box();
            options.periodic[0] = kind == 1;
            options.list_walls = true;
            std::vector<double> weights;
            if (with_walls) {
                options.walls = {{{1, 1, 0}, 1.1}, {{-1, 0.2, 0.5}, 0.6}};
            } else {
                options.weights = WeightOptions{0, 0.1};
                test::Random random(25);
                for (std::size_t i = 0; i < set.size(); ++i) weights.push_back(random.uniform(0, 1e-3));
                weights[0] = 0.1;  // reaches far
                std::fill_n(set.points.begin(), 3, 1e-3);
            }
            const Plan plan = host.plan(options);
            const auto t = on_cpu(set, options, weights);
            // All near each other, so that some places are far from them.
            std::vector<Cell> cells(set.size());
            std::size_t left = 0;
            const double* near = nullptr;
            for (std::size_t i = 0; i < set.size(); ++i) {
                cells[i].status = static_cast<std::uint32_t>(t.status()[i]);
                const double* const x = set.points.data() + 3 * i;
                const bool chosen = with_walls ? cells[i].status == 0
                                               : i > 0 && x[0] > 0.29 && std::ranges::count(t.neighbors(i), 0) > 0;
                if (!chosen || left == 6) continue;
                if (near == nullptr) near = x;
                if (std::hypot(x[0] - near[0], x[1] - near[1], x[2] - near[2]) > 0.05) continue;
                cells[i].status = static_cast<std::uint32_t>(CellStatus::needs_exact);
                ++left;
            }
            REQUIRE(left > 1);
            check_resolved(plan.resolve(std::span<const double>(set.points), std::span<const double>(weights), cells),
                           cells, t);
        }
    }
}
