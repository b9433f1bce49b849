// Tessellator::update() gives the lists of tessellate(), whatever became of the seeds since the last call.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "../support/check.hpp"
#include "../support/random.hpp"

namespace {

template <class T>
bool same(std::span<const T> a, std::span<const T> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

// Lists, counts and statuses are equal; what is measured may differ in the last digits.
std::string differ(const votess::Tessellation& a, const votess::Tessellation& b) {
    if (!same(a.indptr(), b.indptr()) || !same(a.indices(), b.indices())) return "lists";
    if (!same(a.face_counts(), b.face_counts()) || !same(a.edge_counts(), b.edge_counts()) ||
        !same(a.vertex_counts(), b.vertex_counts()))
        return "counts";
    if (!same(a.status(), b.status()) || !same(a.duplicate_of(), b.duplicate_of())) return "statuses";
    if (a.volumes().size() != b.volumes().size()) return "number of volumes";
    for (std::size_t i = 0; i < a.volumes().size(); ++i)
        if (!(std::abs(a.volumes()[i] - b.volumes()[i]) <= 2e-10 * std::abs(b.volumes()[i])))
            return "volume " + std::to_string(i);
    return "";
}

// Moves each seed by `distance` in a random direction, and back inside the box where it would leave.
void move(test::Coordinates& points, double distance, const votess::Box& box, test::Random& random) {
    for (std::size_t i = 0; i < points.size(); i += 3) {
        double d[3], square;
        do {
            square = 0;
            for (double& x : d) x = random.uniform(-1, 1), square += x * x;
        } while (square > 1 || square < 1e-3);
        for (int k = 0; k < 3; ++k)
            points[i + k] = std::clamp(points[i + k] + d[k] * distance / std::sqrt(square), box.lower[k], box.upper[k]);
    }
}

void swap_seeds(test::Coordinates& points, std::size_t i, std::size_t j) {
    for (int k = 0; k < 3; ++k) std::swap(points[3 * i + k], points[3 * j + k]);
}

void copy_seed(test::Coordinates& points, std::size_t from, std::size_t to) {
    for (int k = 0; k < 3; ++k) points[3 * to + k] = points[3 * from + k];
}

}  // namespace

TEST_SUITE("update") {
    TEST_CASE("seeds that move by any distance") {
        const std::size_t n = test::by_size(6000, 600);
        const double spacing = 1 / std::cbrt(static_cast<double>(n));
        for (const unsigned threads : {1u, 3u})
            for (const double distance : {0.0, 1e-12, 0.01, 0.1, 1.0, 100.0}) {
                CAPTURE(distance);
                test::Random random(71);
                auto points = test::uniform(n, 72).points;
                auto options = test::all_options(test::unit_box());
                options.threads = threads;
                votess::Tessellator tessellator;
                for (int step = 0; step < 4; ++step) {
                    const auto t = tessellator.update(points, options);
                    CHECK(differ(t, votess::tessellate(points, options)) == "");
                    CHECK(test::check_invariants(t, points) == "");
                    move(points, distance * spacing, *options.box, random);
                }
            }
    }

    TEST_CASE("the families, moved a little and back") {
        for (test::PointSet& set : test::families(test::by_size(1500, 200), 73)) {
            CAPTURE(set.name);
            const auto options = test::all_options(set.box);
            votess::Tessellator tessellator;
            (void)tessellator.update(set.points, options);
            const votess::Box box = tessellator.update(set.points, options).box();
            const double side = box.upper[0] - box.lower[0];
            const double spacing = side / std::cbrt(static_cast<double>(set.size()));
            test::Random random(74);
            for (const double distance : {1e-9, 0.02, 0.3}) {
                auto moved = set.points;
                move(moved, distance * spacing, box, random);
                CHECK(differ(tessellator.update(moved, options), votess::tessellate(moved, options)) == "");
                CHECK(differ(tessellator.update(set.points, options), votess::tessellate(set.points, options)) == "");
            }
        }
    }

    TEST_CASE("threads do not show") {
        const std::size_t n = test::by_size(20000, 2500);
        const test::PointSet set = test::clustered(n, 75);
        const auto run = [&](unsigned threads) {
            auto points = set.points;
            auto options = test::all_options(test::unit_box());
            options.threads = threads;
            test::Random random(76);
            votess::Tessellator tessellator;
            std::vector<votess::Tessellation> all;
            for (int step = 0; step < 4; ++step) {
                all.push_back(tessellator.update(points, options));
                move(points, 3e-4, *options.box, random);
            }
            return all;
        };
        const auto one = run(1);
        for (const unsigned threads : {2u, 5u}) {
            const auto other = run(threads);
            for (std::size_t k = 0; k < one.size(); ++k) CHECK(test::check_identical(one[k], other[k]) == "");
        }
    }

    TEST_CASE("seeds that change places") {
        const std::size_t n = test::by_size(5000, 500);
        auto points = test::uniform(n, 77).points;
        const auto options = test::all_options(test::unit_box());
        test::Random random(78);
        votess::Tessellator tessellator;
        (void)tessellator.update(points, options);
        for (const std::size_t swaps : {std::size_t{1}, n / 100, n}) {
            for (std::size_t k = 0; k < swaps; ++k) swap_seeds(points, random.below(n), random.below(n));
            CHECK(differ(tessellator.update(points, options), votess::tessellate(points, options)) == "");
        }
    }

    TEST_CASE("seeds that become equal, near and far in the old order, and part again") {
        const std::size_t n = test::by_size(5000, 500);
        for (const test::PointSet& set :
             {test::uniform(n, 79), test::cubic(test::by_size(14, 7)), test::on_sphere(n / 8, 80),
              test::on_axis_plane(n / 8, 81), test::on_oblique_line(n / 8, 82)}) {
            CAPTURE(set.name);
            const auto options = test::all_options(set.box);
            test::Random random(83);
            votess::Tessellator tessellator;
            const auto alone = tessellator.update(set.points, options);
            // The nearest in space is near in the order.
            for (int round = 0; round < 12; ++round) {
                CAPTURE(round);
                auto points = set.points;
                const auto pairs = static_cast<std::size_t>(round % 4 == 3 ? 20 : 1);
                for (std::size_t k = 0; k < pairs; ++k) {
                    const std::size_t i = random.below(set.size());
                    std::size_t j = random.below(set.size());
                    if (round % 2 == 0)
                        for (const std::int32_t other : alone.neighbors(i))
                            if (other >= 0) j = static_cast<std::size_t>(other);
                    copy_seed(points, i, j);
                }
                const auto t = tessellator.update(points, options);
                CHECK(differ(t, votess::tessellate(points, options)) == "");
                auto refusing = options;
                refusing.duplicates = votess::Duplicates::error;
                (void)tessellator.update(set.points, options);
                (void)tessellator.update(set.points, options);
                if (t.stats().duplicates > 0)
                    CHECK_THROWS_AS((void)tessellator.update(points, refusing), votess::Error);
                CHECK(differ(tessellator.update(set.points, options), alone) == "");
                CHECK(differ(tessellator.update(set.points, options), alone) == "");
            }
        }
    }

    // Few enough among many, so that the order is kept.
    TEST_CASE("equal seeds from anywhere in an order that is kept") {
        const std::size_t n = test::by_size(40000, 16000);
        const auto points = test::uniform(n, 94).points;
        votess::Options options;
        options.device = "cpu";
        options.box = test::unit_box();
        test::Random random(95);
        votess::Tessellator tessellator;
        const auto alone = tessellator.update(points, options);
        for (int round = 0; round < (test::reduced() ? 4 : 16); ++round) {
            auto moved = points;
            for (int pairs = 0; pairs <= round % 3; ++pairs) copy_seed(moved, random.below(n), random.below(n));
            const auto t = tessellator.update(moved, options);
            CHECK(t.stats().duplicates > 0);
            CHECK(differ(t, votess::tessellate(moved, options)) == "");
            CHECK(differ(tessellator.update(points, options), alone) == "");
        }
    }

    TEST_CASE("all seeds become one") {
        auto points = test::uniform(300, 84).points;
        const auto options = test::all_options(test::unit_box());
        votess::Tessellator tessellator;
        (void)tessellator.update(points, options);
        const auto before = points;
        for (std::size_t i = 1; i < 300; ++i) copy_seed(points, 0, i);
        CHECK(differ(tessellator.update(points, options), votess::tessellate(points, options)) == "");
        CHECK(differ(tessellator.update(before, options), votess::tessellate(before, options)) == "");
    }

    TEST_CASE("the hint does not hold") {
        const std::size_t n = test::by_size(3000, 400);
        const auto first = test::uniform(n, 85), other = test::clustered(n, 86), fewer = test::uniform(n / 3, 87);
        votess::Tessellator tessellator;
        auto options = test::all_options(test::unit_box());
        const auto check = [&](const test::Coordinates& points) {
            CHECK(differ(tessellator.update(points, options), votess::tessellate(points, options)) == "");
        };
        check(first.points);
        check(other.points);
        check(fewer.points);
        check(first.points);
        CHECK(tessellator.update(test::Coordinates{}, options).size() == 0);
        check(first.points);
        check({0.5, 0.5, 0.5});
        check({0.25, 0.5, 0.5});
        check(first.points);
        options.box = test::cube(-3, 40);  // another scale
        check(first.points);
        options.box.reset();
        check(first.points);
        (void)tessellator.tessellate(fewer.points, options);
        check(fewer.points);
        (void)tessellator.tessellate(other.points, options);
        check(first.points);
    }

    TEST_CASE("float32 input, other wishes and other threads from call to call") {
        const std::size_t n = test::by_size(4000, 500);
        auto points = test::uniform(n, 88).points;
        test::Random random(89);
        votess::Tessellator tessellator;
        for (int step = 0; step < 8; ++step) {
            auto options = test::all_options(test::unit_box());
            options.threads = static_cast<unsigned>(1 + step % 3);
            options.want = {step % 2 == 0, step % 3 == 0, step == 4, step % 4 != 2, step < 3};
            options.walls = step % 2 == 1;
            move(points, 1e-4, *options.box, random);
            const std::vector<float> narrow(points.begin(), points.end());
            const auto t =
                step % 2 == 0 ? tessellator.update(points, options) : tessellator.update(std::span(narrow), options);
            CHECK(differ(t, step % 2 == 0 ? votess::tessellate(points, options)
                                          : votess::tessellate(std::span(narrow), options)) == "");
        }
    }

    TEST_CASE("after a cancelled call and after a refused one") {
        const test::PointSet set = test::uniform(test::by_size(200000, 60000), 90);
        const auto options = [] {
            votess::Options o;
            o.device = "cpu";
            o.box = test::unit_box();
            return o;
        }();
        const auto expected = votess::tessellate(set.points, options);
        votess::Tessellator tessellator;
        (void)tessellator.update(set.points, options);
        auto stopping = options;
        stopping.progress = [](double fraction) { return fraction < 0.1; };
        CHECK_THROWS_AS((void)tessellator.update(set.points, stopping), votess::Error);
        CHECK(differ(tessellator.update(set.points, options), expected) == "");
        auto outside = set.points;
        outside[5] = 2;
        CHECK_THROWS_AS((void)tessellator.update(outside, options), votess::Error);
        CHECK(differ(tessellator.update(set.points, options), expected) == "");
        auto throwing = options;
        throwing.progress = [](double) -> bool { throw 7; };
        CHECK_THROWS_AS((void)tessellator.update(set.points, throwing), int);
        CHECK(differ(tessellator.update(set.points, options), expected) == "");
        CHECK(differ(tessellator.update(set.points, options), expected) == "");
    }

    TEST_CASE("progress grows, also when equal seeds make it begin anew") {
        const test::PointSet set = test::uniform(test::by_size(300000, 60000), 91);
        votess::Options options;
        options.device = "cpu";
        options.box = test::unit_box();
        votess::Tessellator tessellator;
        (void)tessellator.update(set.points, options);
        auto points = set.points;
        copy_seed(points, 10, set.size() - 1);
        double last = 0;
        bool grows = true;
        options.progress = [&](double fraction) {
            grows = grows && fraction >= last && fraction <= 1;
            last = fraction;
            return true;
        };
        CHECK(tessellator.update(points, options).stats().duplicates == 1);
        CHECK(grows);
        CHECK(last == 1);
    }

    TEST_CASE("a Tessellator that was moved goes on") {
        auto points = test::uniform(500, 92).points;
        const auto options = test::all_options(test::unit_box());
        test::Random random(93);
        votess::Tessellator first;
        (void)first.update(points, options);
        move(points, 1e-3, *options.box, random);
        votess::Tessellator second = std::move(first);
        CHECK(differ(second.update(points, options), votess::tessellate(points, options)) == "");
    }
}
