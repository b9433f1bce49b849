// Frames that keep cells of the frame before: PlanOptions::follow.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>
#include <votess/vulkan.hpp>

#include "support/generators.hpp"
#include "support/gpu/frame.hpp"
#include "support/random.hpp"

using namespace test::frame;
using test::PointSet;

namespace {

// Seeds, whose frames are compared with the CPU.
struct Follower {
    Host& host;
    PlanOptions options;
    PointSet set;
    std::vector<double> weights;
    std::optional<Plan> plan;
    std::optional<Target> target;
    double spacing = 1;
    bool fresh = true;
    test::Random random{3};

    Follower(Host& with, std::size_t n, PlanOptions of = {}) : host(with), options(std::move(of)) {
        options.max_seeds = static_cast<std::uint32_t>(n);
        options.max_entries = 64 * options.max_seeds;
        options.format = SeedFormat::float64;
        options.follow = options.areas = options.list_walls = true;
        if (!options.cell) options.box = test::unit_box();
        spacing = 1 / std::cbrt(static_cast<double>(n));
        for (std::size_t c = 0; c < 3 * n; ++c) set.points.push_back(random.uniform());
        for (std::size_t i = 0; i < n && options.weights; ++i)
            weights.push_back(random.uniform(options.weights->least, options.weights->largest));
        plan = host.plan(options);
        target.emplace(host, *plan);
    }
    [[nodiscard]] bool repeats(std::size_t axis) const { return options.cell || options.periodic[axis]; }
    // Moves by up to `by` spacings along each axis.
    void move(double by) {
        for (std::size_t c = 0; c < set.points.size(); ++c) {
            double& x = set.points[c];
            x += by * spacing * random.uniform(-1, 1);
            if (!repeats(c % 3)) x = 1 - std::abs(1 - std::abs(x));
        }
    }
    // Returns the header of a frame with these seeds.
    Header frame() {
        const std::size_t n = set.size();
        target->write<double>(set.points, options.stride);
        if (options.weights) target->write_weights(weights);
        const Target* const one[] = {&*target};
        run(host, one, {.count = static_cast<std::uint32_t>(n), .fresh = std::exchange(fresh, false)});
        check_header(target->head(), target->cell(n));
        const auto expected = on_cpu(set, options, weights);
        Rows rows = collect<double>(*plan, *target, n);
        if (plan->sizes().shifts > 0)  // those of the library lie in the domain
            rows.centroids.assign(expected.centroids().begin(), expected.centroids().end());
        CHECK(compare(rows, expected) == "");
        return target->head();
    }
    // The share of cells that were kept.
    double kept() { return frame().kept / static_cast<double>(set.size()); }

    // Moves of all kinds. by_subgroup: few pending cells pay there, so that more cells are kept in small sets.
    void wander(bool by_subgroup) {
        CHECK(kept() == 0);
        CHECK(kept() > 0.98);
        for (const double by : {1e-4, 3e-3, 1e-2, 0.3}) {
            CAPTURE(by);
            move(by);
            const double share = kept();
            if (by < 1e-3 || (by_subgroup && by < 5e-3)) CHECK(share > 0.6);
        }
        const auto before = set.points;
        const auto put = [&](std::size_t i, std::size_t j) { std::copy_n(&set.points[3 * j], 3, &set.points[3 * i]); };
        for (std::size_t k = 0; k < 3; ++k) set.points[3 * 7 + k] = random.uniform();  // one goes anywhere
        CHECK((kept() > 0.5 || !by_subgroup));
        put(11, 50);  // a duplicate
        frame();
        set.points = before;
        frame();
        for (double& x : set.points) x = std::round(8 * x) / 8;  // ties
        frame();
        frame();
        set.points = before;
        CHECK(kept() == 0);
        const std::vector<double> all_weights = weights;  // some leave and come back
        set.points.resize(set.points.size() - 3 * std::size_t{4});
        if (options.weights) weights.resize(set.size());
        frame();
        set.points = before;
        weights = all_weights;
        CHECK((kept() > 0.3 || !by_subgroup));
        for (std::size_t c = 0; c < set.points.size(); c += 5)  // images
            if (!options.cell && options.periodic[c % 3]) set.points[c] += set.points[c] < 0.5 ? 1 : -1;
        CHECK(kept() > 0.9);
    }
};

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu frame: cells are kept, in a box and in periodic ones") {
        Host host;
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Follower(host, test::by_size(600, 150), {.periodic = {periodic, periodic, false}}).wander(false);
        }
    }

    TEST_CASE("gpu frame: cells of a triclinic box are kept") {
        Host host;
        PlanOptions options;
        options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.25, 1, 0}, {-0.125, 0.25, 1}};
        const test::UseKernel chosen(test::by_subgroup());
        Follower(host, 150, options).wander(true);
    }

    TEST_CASE("gpu frame: a subgroup per cell keeps cells") {
        Host host;
        const test::UseKernel chosen(test::by_subgroup());
        Follower(host, 200, {.periodic = {true, false, true}}).wander(true);
        Follower(host, 200).wander(true);
    }

    TEST_CASE("gpu frame: cells of power diagrams are kept, and seeds become hidden and return") {
        Host host;
        const test::UseKernel chosen(test::by_subgroup());
        const std::size_t n = 200;
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            PlanOptions options{.periodic = {periodic, periodic, periodic}};
            options.weights = WeightOptions{0, 0.1};
            Follower f(host, n, options);
            for (double& w : f.weights) w *= 0.03;
            f.frame();
            const bool keeps = f.frame().unresolved == 0;  // an unknown cell may be anywhere
            for (int step = 0; step < 4; ++step) {
                f.move(1e-3);
                for (double& w : f.weights) w = std::clamp(w + 1e-6 * f.random.uniform(-1, 1), 0.0, 0.1);
                const Header h = f.frame();
                if (keeps && h.unresolved == 0) CHECK(h.kept > n / 4);
            }
            const auto before = f.weights;
            f.weights[5] = 0.09;  // hides its neighbors
            CHECK(f.frame().empty > 0);
            f.frame();
            f.weights = before;
            f.frame();
            for (std::size_t i = 0; i < n; ++i) f.weights[i] = i % 2 == 0 ? 0.05 : 0.0;
            f.frame();
            for (std::size_t i = 0; i < n; ++i) f.weights[i] = i % 2 == 0 ? 0.0 : 0.05;
            f.frame();
        }
    }

    TEST_CASE("gpu frame: cells within walls of any direction are kept") {
        Host host;
        PlanOptions options;
        options.walls = {{{1, 0.3, 0.2}, 1.2}, {{-1, -1, 0.5}, 0.3}};
        Follower f(host, 200, options);
        f.frame();
        CHECK(f.frame().kept > 100);
        for (const double by : {1e-4, 1e-2, 0.2}) {
            f.move(by);
            f.frame();
        }
    }
}
