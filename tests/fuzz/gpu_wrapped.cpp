// Periodic domains on a Vulkan device whose seeds nearly coincide once they are brought into the box: points, and their
// translations by the box's vectors as doubles have them, or one step beside; clusters with spacings down to 1e-13 of
// the coordinates, beside faces and far from 0. Against exact half-spaces, and against verify() where seeds are many.
// VOTESS_FUZZ_WRAPPED sets, from VOTESS_FUZZ_SEED on.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/gpu/gpu.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::Random;
using Point = std::array<double, 3>;

struct Case {
    Coordinates points;
    votess::Options options;
};

// Box vectors as doubles have them; zero along axes that do not repeat.
std::array<Point, 3> vectors_of(const votess::Options& options) {
    if (options.cell) return {options.cell->a, options.cell->b, options.cell->c};
    std::array<Point, 3> vectors{};
    for (std::size_t k = 0; k < 3; ++k)
        if (options.periodic[k]) vectors[k][k] = options.box->upper[k] - options.box->lower[k];
    return vectors;
}

votess::Options random_domain(Random& random) {
    votess::Options options = test::all_options(test::unit_box());
    // Far from 0 digits are lost; doubles there still have common units with the box.
    const double away = random.chance(0.7) ? 0 : std::ldexp(random.uniform(-1, 1), static_cast<int>(random.below(30)));
    if (random.chance(0.3)) {
        options.box.reset();
        options.cell = votess::TriclinicBox{{away, random.uniform(-1, 1), 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        votess::TriclinicBox& cell = *options.cell;
        cell.a[0] = random.uniform(0.8, 1.3);
        for (double* x : {&cell.b[0], &cell.c[0], &cell.c[1]}) *x = random.uniform(-0.4, 0.4);
        return options;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        options.box->lower[k] = away + random.uniform(-1, 1);
        options.box->upper[k] = options.box->lower[k] + random.uniform(0.7, 2);
    }
    const auto mask = 1 + random.below(7);
    for (std::size_t k = 0; k < 3; ++k) options.periodic[k] = (mask >> k & 1) != 0;
    return options;
}

// In the domain, here and there on a face.
Point inside(const votess::Options& options, Random& random) {
    Point x = options.cell ? options.cell->origin : options.box->lower;
    const bool on_face = random.chance(0.3);
    if (!options.cell) {
        for (std::size_t k = 0; k < 3; ++k)
            if (!(on_face && random.chance(0.4)))
                x[k] = std::clamp(random.uniform(options.box->lower[k], options.box->upper[k]), options.box->lower[k],
                                  options.box->upper[k]);
        return x;
    }
    for (const Point& v : vectors_of(options)) {
        const double f = on_face && random.chance(0.4) ? 0 : random.uniform();
        for (std::size_t k = 0; k < 3; ++k) x[k] += f * v[k];
    }
    return x;
}

bool is_free(const votess::Options& options, std::size_t k) {
    return options.cell || options.periodic[k];
}

Case random_case(Random& random, std::size_t n, bool clusters) {
    Case c{{}, random_domain(random)};
    const auto vectors = vectors_of(c.options);
    std::vector<Point> points;
    const auto within = [&](Point x) {  // walls hold
        for (std::size_t k = 0; k < 3; ++k)
            if (!is_free(c.options, k)) x[k] = std::clamp(x[k], c.options.box->lower[k], c.options.box->upper[k]);
        return x;
    };
    while (points.size() < n) {
        const Point p = inside(c.options, random);
        points.push_back(p);
        if (clusters && random.chance(0.2)) {
            double size = 0;
            for (const double x : p) size = std::max(size, std::abs(x));
            const double spacing = std::exp2(random.uniform(-43, -10)) * std::max(size, 0.1);
            for (std::size_t i = 0; i < 8 && points.size() < n; ++i) {
                Point q = p;
                for (double& x : q) x += spacing * random.uniform(-1, 1);
                points.push_back(within(q));
            }
        }
        // Most get a translation by a period or a few.
        while (points.size() < n && random.chance(clusters ? 0.2 : 0.6)) {
            Point q = points[random.below(points.size())];
            for (const Point& v : vectors) {
                const auto times = static_cast<double>(random.integer(-2, 2));
                for (std::size_t k = 0; k < 3; ++k) q[k] += times * v[k];
            }
            if (random.chance(0.4)) {
                const std::size_t k = random.below(3);
                q[k] = std::nextafter(q[k], random.chance(0.5) ? 1e300 : -1e300);
            }
            points.push_back(within(q));
        }
    }
    for (const std::size_t i : test::permutation(points.size(), random))
        c.points.insert(c.points.end(), points[i].begin(), points[i].end());
    return c;
}

std::string print(const Case& c) {
    votess::Box box = c.options.box.value_or(votess::Box{});
    std::string text = test::print_points(c.points, box);
    if (c.options.cell)
        for (const Point& v : {c.options.cell->origin, c.options.cell->a, c.options.cell->b, c.options.cell->c})
            text += test::print_points(Coordinates(v.begin(), v.end()), box);
    return text;
}

struct Tally {
    std::uint64_t cells = 0, on_device = 0, sets = 0;
};

// "" when the rows are right.
std::string judge(votess::Tessellator& tessellator, const Case& c, votess::gpu::Kernel kernel, bool few, Tally& tally) {
    votess::Options options = c.options;
    options.device = test::device_name();
    const test::UseKernel chosen(kernel);
    const auto t = tessellator.tessellate(std::span<const double>(c.points), options);
    std::string wrong = test::check_domain(t);
    if (wrong.empty()) wrong = votess::verify(t, c.points).failure;
    // Rows of seeds at one place depend on which of them has the cell.
    if (wrong.empty() && few && t.stats().duplicates == 0)
        wrong = test::check_against_half_spaces(t, c.points, c.options, 2);
    ++tally.sets;
    tally.cells += t.size();
    tally.on_device += t.size() - t.stats().fallback_cells;
    return wrong;
}

void run_sets(std::uint64_t sets, bool clusters, const auto& size) {
    const std::uint64_t first = test::environment("VOTESS_FUZZ_SEED", 1);
    votess::Tessellator tessellator;
    Tally tally;
    std::uint64_t failures = 0;
    for (std::uint64_t seed = first; seed < first + sets; ++seed) {
        Random random(seed);
        const std::size_t n = size(random);
        const Case c = random_case(random, n, clusters);
        // Other pipelines take long to make: one kernel after the other.
        const votess::gpu::Kernel kernel =
            seed - first < sets / 4 ? test::by_subgroup() : votess::gpu::Kernel::invocation;
        const std::string wrong = judge(tessellator, c, kernel, n < 10, tally);
        if (wrong.empty()) continue;
        votess::Options on_cpu = c.options;
        const auto cpu = votess::tessellate(std::span<const double>(c.points), on_cpu);
        const std::string also = votess::verify(cpu, c.points).failure;
        if (++failures <= 5) FAIL_CHECK("seed " << seed << ": " << wrong << "; the CPU: " << also << "\n" << print(c));
    }
    INFO(failures << " of " << tally.sets << " sets, " << tally.on_device << " of " << tally.cells << " on device");
    CHECK(failures == 0);
    CHECK(tally.on_device > tally.cells / 50);
}

}  // namespace

TEST_SUITE("fuzz") {
    TEST_CASE("gpu: seeds and their translations by rounded periods against exact half-spaces") {
        run_sets(test::environment("VOTESS_FUZZ_WRAPPED", test::by_size(30, 8)), false,
                 [](Random& random) { return 2 + random.below(4); });
    }
    TEST_CASE("gpu: many seeds and their translations by rounded periods verify") {
        run_sets(test::environment("VOTESS_FUZZ_WRAPPED", test::by_size(25, 4)), false,
                 [](Random& random) { return 20 + random.below(200); });
    }
    TEST_CASE("gpu: clusters of tiny spacings beside periodic faces verify") {
        run_sets(test::environment("VOTESS_FUZZ_WRAPPED", test::by_size(25, 4)), true,
                 [](Random& random) { return 5 + random.below(random.chance(0.5) ? 30 : 150); });
    }
}
