// Frames with weights from a buffer of the host, and with walls of any direction.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>
#include <votess/vulkan.hpp>

#include "support/allocations.hpp"
#include "support/generators.hpp"
#include "support/gpu/frame.hpp"
#include "support/random.hpp"

using namespace test::frame;
using test::PointSet;
using test::Random;
using votess::ErrorCode;

namespace {

PlanOptions plan_options(std::size_t n, const votess::Box& box) {
    PlanOptions options;
    options.max_seeds = static_cast<std::uint32_t>(n);
    options.format = SeedFormat::float64;
    options.max_entries = 64 * options.max_seeds;
    options.areas = true;
    options.box = box;
    return options;
}

struct Moving {
    PointSet set;
    std::vector<double> weights;  // empty: the plan has none
};

// Runs two frames in one command buffer, twice, each with seeds and weights of move(random). Returns the largest share
// of unresolved cells, and the number of empty cells.
struct Outcome {
    double left = 0;
    std::uint32_t empty = 0;
};
Outcome in_flight(Host& host, const PlanOptions& options, bool by_subgroup, const auto& move) {
    std::optional<test::UseKernel> kernel;
    if (by_subgroup) kernel.emplace(test::by_subgroup());
    const Plan plan = host.plan(options);
    Target first(host, plan), second(host, plan);
    const Target* const both[] = {&first, &second};
    Random random(7);
    Outcome outcome;
    const std::size_t n = options.max_seeds;
    for (int frame = 0; frame < 2; ++frame) {
        Moving moved[2];
        for (std::size_t t = 0; t < 2; ++t) {
            Target& target = t == 0 ? first : second;
            moved[t] = move(random);
            target.write<double>(moved[t].set.points, options.stride);
            if (options.weights) target.write_weights(moved[t].weights);
        }
        run(host, both, {.count = options.max_seeds});
        for (std::size_t t = 0; t < 2; ++t) {
            const Target& target = *both[t];
            const Header h = target.head();
            check_header(h, target.cell(n));
            outcome.left = std::max(outcome.left, static_cast<double>(h.unresolved) / static_cast<double>(n));
            outcome.empty += h.empty;
            Rows rows = collect<double>(plan, target, n);
            const auto expected = on_cpu(moved[t].set, options, moved[t].weights);
            if (plan.sizes().shifts > 0) take_centroids(rows, target, expected);
            CHECK(compare(rows, expected) == "");
        }
    }
    // Recording allocates nothing, except in the validation layer.
    host.commands.begin();
    const auto recording = test::allocations();
    first.frame.record(host.commands.handle(), {.count = options.max_seeds - 1});
    const auto after = test::allocations();
    host.commands.end();
    if (recording && !host.gpu.instance->validation()) CHECK(*recording == *after);
    return outcome;
}

Moving balls(Random& random, std::size_t n, double largest_radius) {
    Moving moving;
    for (std::size_t i = 0; i < 3 * n; ++i) moving.set.points.push_back(random.uniform());
    for (std::size_t i = 0; i < n; ++i) moving.weights.push_back(std::pow(random.uniform(0, largest_radius), 2));
    return moving;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu frame: weights that vary smoothly, in a periodic box and in a shifted one") {
        Host host;
        const std::size_t n = test::by_size(2000, 300);
        const double shift = 1 / std::cbrt(static_cast<double>(n));  // about the spacing
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            PlanOptions options = plan_options(n, test::unit_box());
            options.periodic = {periodic, periodic, periodic};
            options.weights = WeightOptions{-3 * shift, 3 * shift};
            const Outcome outcome = in_flight(host, options, false, [&](Random& random) {
                Moving moving = balls(random, n, 0);
                for (std::size_t i = 0; i < 3 * n; ++i) {
                    const double x = moving.set.points[i], turn = 2 * std::numbers::pi;
                    moving.weights[i / 3] += periodic ? 0.8 * shift / turn * std::sin(turn * x) : shift * x;
                }
                return moving;
            });
            CHECK(outcome.left < (periodic ? 0.15 : 0.03));
        }
    }

    TEST_CASE("gpu frame: weights, two frames in flight with moving seeds and weights") {
        Host host;
        struct Kind {
            double radius;
            bool periodic, by_subgroup;
        };
        const std::size_t n = test::by_size(300, 100);
        for (const Kind& kind : {Kind{0.1, false, false}, {1.0, false, true}, {0.1, true, true}, {1.0, true, false}}) {
            CAPTURE(kind.radius);
            CAPTURE(kind.periodic);
            PlanOptions options = plan_options(n, test::unit_box());
            options.periodic = {kind.periodic, kind.periodic, kind.periodic};
            options.weights = WeightOptions{0, kind.radius * kind.radius};
            options.chunk_size = kind.by_subgroup ? 0 : 97;
            const Outcome outcome = in_flight(host, options, kind.by_subgroup,
                                              [&](Random& random) { return balls(random, n, kind.radius); });
            CHECK(outcome.left < (kind.periodic && kind.radius == 1 ? 0.2 : 0.1));
            CHECK((outcome.empty > n) == (kind.radius == 1));
        }
    }

    TEST_CASE("gpu frame: weights in a triclinic box, two frames in flight") {
        Host host;
        const std::size_t n = 300;
        PlanOptions options = plan_options(n, {});
        options.cell = votess::TriclinicBox{{-0.3, 0.1, 0.7}, {1, 0, 0}, {0.45, 1, 0}, {-0.45, 1.0 / 3, 1}};
        options.weights = WeightOptions{-0.01, 0.01};
        const Outcome outcome = in_flight(host, options, true, [&](Random& random) {
            Moving moving = balls(random, n, 0.1);
            for (double& w : moving.weights) w = random.below(2) == 0 ? w : -w;
            return moving;
        });
        CHECK(outcome.left < 0.1);
    }

    TEST_CASE("gpu frame: float32 weights next to their seeds, some out of range") {
        Host host;
        const std::size_t n = 200;
        PlanOptions options = plan_options(n, test::unit_box());
        options.format = SeedFormat::float32;
        options.stride = 4;
        options.weights = WeightOptions{0.25, 0.5, 4, 3};
        const Plan plan = host.plan(options);
        REQUIRE(plan.sizes().weights == 16 * n);
        Target target(host, plan);
        // Seeds and weights in one buffer.
        target.frame = plan.frame({.seeds = {target.weights.handle()},
                                   .workspace = {target.workspace.handle()},
                                   .header = {target.header.handle()},
                                   .cells = {target.cells.handle()},
                                   .indices = {target.indices.handle()},
                                   .geometry = {target.geometry.handle()},
                                   .areas = {target.areas.handle()},
                                   .weights = {target.weights.handle()}});
        Random random(8);
        const auto both = target.weights.as<float>();
        for (std::size_t i = 0; i < both.size(); ++i)
            both[i] = static_cast<float>(i % 4 == 3 ? random.uniform(0.25, 0.27) : random.uniform());
        both[3] = 0.25f, both[7] = 0.5f;  // on the bounds
        const std::vector<float> bad{std::nextafter(0.25f, 0.0f), std::nextafter(0.5f, 1.0f), -0.3f,
                                     std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
        for (std::size_t k = 0; k < bad.size(); ++k) both[4 * (5 + k) + 3] = bad[k];
        target.weights.flush();
        run(host, target, options.max_seeds);
        const Header h = target.head();
        check_header(h, target.cell(n));
        CHECK(h.outside == bad.size());
        CHECK(h.unresolved < n / 10);
        const Resolved more = plan.resolve(std::span<const float>(both), std::span<const float>(both), target.cell(n));
        CHECK(more.cells.size() == h.unresolved);
        // The other rows are those of the good seeds.
        PointSet kept;
        std::vector<double> weights;
        std::vector<std::int32_t> ids;
        for (std::size_t i = 0; i < n; ++i) {
            const bool is_bad = i >= 5 && i < 5 + bad.size();
            CHECK(is_bad == (target.cell(n)[i].status == static_cast<std::uint32_t>(CellStatus::outside)));
            if (is_bad) continue;
            ids.push_back(static_cast<std::int32_t>(i));
            for (std::size_t k = 0; k < 3; ++k) kept.points.push_back(both[4 * i + k]);
            weights.push_back(both[4 * i + 3]);
        }
        const auto t = on_cpu(kept, options, weights);
        for (std::size_t k = 0, r = 0; k < t.size(); ++k) {
            const auto i = static_cast<std::size_t>(ids[k]);
            const Cell& cell = target.cell(n)[i];
            std::vector<std::int32_t> expected(t.neighbors(k).begin(), t.neighbors(k).end());
            for (std::int32_t& id : expected) id = ids[static_cast<std::size_t>(id)];
            std::vector<std::int32_t> row;
            if (r < more.cells.size() && more.cells[r] == i) {
                row.assign(more.indices.begin() + more.indptr[r], more.indices.begin() + more.indptr[r + 1]);
                ++r;
            } else {
                CHECK(cell.status == static_cast<std::uint32_t>(t.status()[k]));
                const auto words = target.indices.as<std::int32_t>().subspan(cell.row_begin, cell.row_length);
                row.assign(words.begin(), words.end());
            }
            CHECK(row == expected);
        }
    }

    TEST_CASE("gpu frame: seeds of several weights at a place, whole weights on a grid") {
        Host host;
        const std::size_t n = 200;
        PlanOptions options = plan_options(n, test::cube(-0.5, 4.5));
        options.weights = WeightOptions{0, 3};
        for (const bool periodic : {false, true}) {
            options.periodic = {periodic, false, periodic};
            in_flight(host, options, periodic, [&](Random& random) {
                Moving moving;
                for (std::size_t i = 0; i < n; ++i) {
                    for (std::size_t k = 0; k < 3; ++k)
                        moving.set.points.push_back(static_cast<double>(random.below(5)) +
                                                    (i < n / 2 ? 0 : random.uniform(-0.1, 0.1)));
                    moving.weights.push_back(static_cast<double>(random.below(4)));
                    if (i % 3 != 2) continue;
                    for (std::size_t k = 0; k < 3; ++k) moving.set.points[3 * i + k] = moving.set.points[3 * i + k - 3];
                }
                return moving;
            });
        }
    }

    TEST_CASE("gpu frame: walls, without and with weights, two frames in flight with moving seeds") {
        Host host;
        const std::size_t n = test::by_size(400, 150);
        for (const bool with_weights : {false, true}) {
            PlanOptions options = plan_options(n, test::unit_box());
            options.list_walls = true;
            options.walls =
                with_weights ? std::vector<votess::Wall>{{{1, 0.3, 0.2}, 0.9}, {{1, 1, 1}, 3}} : test::octahedron(0.5);
            if (with_weights) options.weights = WeightOptions{0, 0.04};
            const bool by_subgroup = with_weights;
            const Outcome outcome = in_flight(host, options, by_subgroup, [&](Random& random) {
                Moving moving = balls(random, n, 0.2);
                if (!with_weights) moving.weights.clear();
                return moving;
            });
            CHECK(outcome.left <= 0.05);
            CHECK((outcome.empty > 0) == with_weights);
        }
    }

    TEST_CASE("gpu frame: seeds on a wall and next to it, float32") {
        Host host;
        const std::size_t n = 150;
        PlanOptions options = plan_options(n, test::unit_box());
        options.walls = {{{1, 1, 0}, 1}};
        options.list_walls = true;
        options.format = SeedFormat::float32;
        const Plan plan = host.plan(options);
        Target target(host, plan);
        for (const float x : {0.25f, 0.2500001f, 0.2499999f}) {
            PointSet set = test::uniform(n, 9);
            for (double& c : set.points) c = static_cast<float>(c);
            set.points[30] = x, set.points[31] = 0.75;
            set.points[39] = 1.5;  // outside of the box
            target.write<float>(set.points, 3);
            run(host, target, options.max_seeds);
            const Header h = target.head();
            check_header(h, target.cell(n));
            CHECK(h.outside > n / 3);
            // On the wall within rounding: then resolve() makes all cells.
            CHECK((h.certified == 0) == (x == 0.25f));
            CHECK((target.cell(n)[10].status == static_cast<std::uint32_t>(CellStatus::outside)) == (x > 0.25f));
            votess::Options whole = test::all_options(options.box);
            whole.walls = options.walls;
            whole.list_walls = true;
            whole.outside = votess::Outside::drop;
            const auto t = votess::tessellate(std::span<const double>(set.points), whole);
            CHECK(compare(collect<float>(plan, target, n), t) == "");
        }
    }

    TEST_CASE("gpu frame: weights and walls that are refused") {
        Host host;
        const PlanOptions good = plan_options(20, test::unit_box());
        std::string said;
        const auto code_of = [&](auto change) {
            PlanOptions changed = good;
            change(changed);
            return test::error_of([&] { Plan(host.device(), changed); }, &said);
        };
        const double nan = std::numeric_limits<double>::quiet_NaN();
        CHECK(code_of([](PlanOptions& o) { o.weights = WeightOptions{1, 0}; }) == ErrorCode::invalid_argument);
        CHECK(said == "weights from 1 to 0 are no range: give finite numbers, the least first");
        CHECK(code_of([&](PlanOptions& o) { o.weights = WeightOptions{0, nan}; }) == ErrorCode::invalid_argument);
        CHECK(code_of([](PlanOptions& o) { o.weights = WeightOptions{0, 1, 0}; }) == ErrorCode::invalid_argument);
        CHECK(code_of([](PlanOptions& o) { o.weights = WeightOptions{0, 100}; }) == ErrorCode::unsupported);
        const votess::Wall wall{{1, 1, 1}, 1};
        CHECK(code_of([&](PlanOptions& o) { o.walls = {wall}, o.periodic[1] = true; }) == ErrorCode::invalid_argument);
        CHECK(code_of([&](PlanOptions& o) {
                  o.walls = {wall}, o.box = {};
                  o.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
              }) == ErrorCode::invalid_argument);
        CHECK(code_of([](PlanOptions& o) { o.walls = {{{0, 0, 0}, 1}}; }) == ErrorCode::invalid_argument);
        CHECK(code_of([](PlanOptions& o) {
                  o.walls = {{{1, 1, 0}, 2}, {{1, 1, 0}, -1e-9}};
              }) == ErrorCode::invalid_argument);
        CHECK(said == "wall 1 leaves nothing of the box");

        PlanOptions options = good;
        options.walls = {wall};
        const Plan with_walls = host.plan(options);
        options = good;
        options.weights = WeightOptions{0, 4};
        const Plan with_weights = host.plan(options);
        Target walls(host, with_walls), weights(host, with_weights);
        host.commands.begin();
        const auto record = [&](const Target& target, const votess::Box& box) {
            return test::error_of([&] { target.frame.record(host.commands.handle(), {.count = 20, .box = box}); });
        };
        CHECK(record(walls, test::unit_box()) == ErrorCode::invalid_argument);
        CHECK(record(weights, test::cube(0, 0.1)) == ErrorCode::unsupported);
        host.commands.end();
        Buffers none;
        none.workspace = {weights.workspace.handle()};
        none.seeds = {weights.seeds.handle()};
        CHECK(test::error_of([&] { static_cast<void>(with_weights.frame(none)); }, &said) ==
              ErrorCode::invalid_argument);
        CHECK(said == "the buffer of weights is null");
        const std::vector<double> seeds(60), values(20), few(19);
        const std::vector<Cell> cells(20);
        using Numbers = std::span<const double>;
        const auto resolved = [&](const Plan& plan, Numbers of) {
            return test::error_of([&] { static_cast<void>(plan.resolve(Numbers(seeds), of, cells)); });
        };
        CHECK(resolved(with_weights, {}) == ErrorCode::invalid_argument);
        CHECK(resolved(with_weights, few) == ErrorCode::invalid_argument);
        CHECK(!resolved(with_weights, values));
        CHECK(resolved(with_walls, values) == ErrorCode::invalid_argument);
    }
}
