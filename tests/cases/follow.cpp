// The option `follow`: cells of the last call are kept where they hold. Each call is compared with a fresh one.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "fuzz/kinds/kinds.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "votess/fit.hpp"

namespace {

using votess::Options;

struct Moving {
    std::vector<double> points;
    Options options;
    votess::Tessellator tessellator;
    double spacing = 1;
    test::Random random{5};

    explicit Moving(std::size_t count) {
        spacing = std::cbrt(1 / static_cast<double>(count));
        for (std::size_t c = 0; c < 3 * count; ++c) points.push_back(random.uniform());
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        options.device = "cpu";
        options.threads = 1;
        options.want.centroids = options.want.areas = options.want.counts = true;
    }
    // Removes the seeds beyond some wall.
    void enclose(std::vector<votess::Wall> walls) {
        options.walls = std::move(walls);
        std::vector<double> inside;
        for (std::size_t i = 0; i < points.size(); i += 3)
            if (is_inside(&points[i])) inside.insert(inside.end(), &points[i], &points[i] + 3);
        points = inside;
    }
    [[nodiscard]] bool is_inside(const double* x) const {
        return std::ranges::all_of(options.walls, [&](const votess::Wall& wall) {
            return wall.normal[0] * x[0] + wall.normal[1] * x[1] + wall.normal[2] * x[2] < wall.offset;
        });
    }
    // Moves by up to `by` spacings along each axis. Seeds do not cross walls.
    void move(double by) {
        const std::vector<double> before = points;
        for (std::size_t c = 0; c < points.size(); ++c) {
            points[c] += by * spacing * random.uniform(-1, 1);
            if (!options.periodic[c % 3]) points[c] = 1 - std::abs(1 - std::abs(points[c]));  // none is on a wall
        }
        for (std::size_t i = 0; i < points.size(); i += 3)
            if (!is_inside(&points[i])) std::copy_n(&before[i], 3, &points[i]);
    }
    // Returns the share of kept cells, or -1 if the result is not that of a fresh call.
    double call() {
        Options fresh = options, follow = options;
        follow.follow = true;
        const votess::Tessellation t = tessellator.tessellate(points, follow);
        const std::string wrong = test::check_identical(t, votess::tessellate(points, fresh));
        CHECK(wrong == "");
        return wrong.empty() ? static_cast<double>(t.stats().kept_cells) / static_cast<double>(t.size()) : -1;
    }
};

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("follow: cells that still hold are kept") {
        for (const bool periodic : {false, true})
            for (const bool weighted : {false, true}) {
                CAPTURE(periodic);
                CAPTURE(weighted);
                Moving m(test::by_size(3000, 1000));
                m.options.periodic = {periodic, periodic, periodic};
                std::vector<double> weights;
                for (std::size_t i = 0; weighted && i < m.points.size() / 3; ++i)
                    weights.push_back(0.1 * m.spacing * m.spacing * m.random.uniform());
                m.options.weights = weights;
                CHECK(m.call() == 0);
                CHECK(m.call() > 0.99);
                m.move(1e-5);
                CHECK(m.call() > 0.98);
                m.options.want = {};
                m.options.list_walls = true;
                m.move(1e-3);
                CHECK(m.call() > 0.8);
                m.move(1e-3);
                CHECK(m.call() > 0.9);
                m.move(5e-3);  // cells around wrong signs are changed, not made
                CHECK(m.call() > 0.9);
                m.move(0.5);  // far: all cells are made, and a sample is stored
                CHECK(m.call() == 0);
                CHECK(m.call() == 0);  // the sample holds: all are stored again
                CHECK(m.call() > 0.99);
                std::swap(m.points[0], m.points[30]);
                std::swap(m.points[1], m.points[31]);
                std::swap(m.points[2], m.points[32]);
                CHECK(m.call() > 0.8);
                std::copy_n(m.points.begin() + 60, 3, m.points.begin());  // a duplicate
                CHECK(m.call() == 0);
            }
    }

    // Cells whose seeds all stay are kept without a test, unless the box has changed.
    TEST_CASE("follow: some seeds move and others stay") {
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Moving m(1000);
            m.options.periodic = {periodic, periodic, periodic};
            CHECK(m.call() == 0);
            for (int step = 0; step < 12; ++step) {
                if (step == 6) m.options.box = votess::Box{{0, 0, 0}, {1.01, 1, 1}};
                const std::size_t middle = 3 * m.random.below(1000);
                for (std::size_t i = 0; i < m.points.size(); i += 3) {
                    const double x = m.points[i] - m.points[middle], y = m.points[i + 1] - m.points[middle + 1];
                    if (x * x + y * y > 0.02) continue;
                    for (std::size_t k = 0; k < 3; ++k)
                        m.points[i + k] = std::clamp(
                            m.points[i + k] + 0.02 * step * m.spacing * m.random.uniform(-1, 1), 1e-9, 1 - 1e-9);
                }
                CHECK(m.call() >= 0);
            }
            CHECK(m.call() > 0.99);
        }
    }

    // All seeds move by the same way, so no cell changes.
    TEST_CASE("follow: seeds cross edges of a periodic box") {
        for (const bool tilted : {false, true})
            for (const bool wrapped : {false, true}) {
                CAPTURE(tilted);
                CAPTURE(wrapped);
                Moving m(1000);
                m.options.periodic = {true, true, true};
                if (tilted) {
                    m.options.box.reset();
                    m.options.periodic = {};
                    m.options.cell = votess::TriclinicBox{.a = {1, 0, 0}, .b = {0.4, 1, 0}, .c = {-0.3, 0.2, 1}};
                }
                CHECK(m.call() == 0);
                for (int step = 0; step < 5; ++step) {
                    for (std::size_t i = 0; i < m.points.size(); i += 3) {
                        m.points[i] += 0.011;
                        m.points[i + 1] -= 0.017;
                        m.points[i + 2] += 0.003;
                        if (wrapped && m.points[i] > 1) m.points[i] -= 1;
                    }
                    CHECK(m.call() == 1);
                }
            }
        // Shifts may be too long to be stored.
        Moving few(12);
        few.options.periodic = {true, true, true};
        CHECK(few.call() == 0);
        for (int step = 0; step < 30; ++step) {
            few.move(0.1);
            if (step % 3 == 0) few.points[0] += 1;
            CHECK(few.call() >= 0);
        }
    }

    TEST_CASE("follow: most seeds are buried by heavier ones") {
        Moving m(800);
        std::vector<double> weights(800);
        for (double& weight : weights) weight = m.random.uniform(0, 0.3);
        m.options.weights = weights;
        m.options.periodic = {true, true, true};
        m.options.want.faces = true;
        for (int step = 0; step < 4; ++step) {
            CHECK(m.call() >= 0);
            m.move(0.01);
        }
    }

    TEST_CASE("follow: hidden seeds stay so, appear, and become equal") {
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Moving m(2000);
            m.options.periodic = {periodic, periodic, periodic};
            std::vector<double> weights(2000);
            for (double& weight : weights) weight = 1.2 * m.spacing * m.spacing * m.random.uniform();
            m.options.weights = weights;
            std::vector<std::size_t> hidden;
            const votess::Tessellation t = votess::tessellate(m.points, m.options);
            for (std::size_t i = 0; i < weights.size(); ++i)
                if (t.status()[i] == votess::CellStatus::empty) hidden.push_back(i);
            REQUIRE(hidden.size() > 100);
            const double share = 1 - static_cast<double>(hidden.size()) / 2000;
            CHECK(m.call() == 0);
            CHECK(m.call() == share);
            m.move(1e-5);
            CHECK(m.call() > 0.95 * share);
            for (std::size_t k = 0; k < 3; ++k) weights[hidden[k]] += 2 * m.spacing * m.spacing;  // three appear
            m.options.weights = weights;
            CHECK(m.call() > 0.9 * share);
            for (std::size_t k = 0; k < 3; ++k) weights[hidden[k]] -= 2 * m.spacing * m.spacing;
            m.options.weights = weights;
            CHECK(m.call() > 0.9 * share);
            CHECK(m.call() == share);
            const std::size_t from = hidden[10], to = hidden[11];
            std::copy_n(&m.points[3 * from], 3, &m.points[3 * to]);
            weights[to] = 0.5 * weights[from];
            m.options.weights = weights;
            CHECK(m.call() >= 0);
            weights[to] = weights[from];
            m.options.weights = weights;
            CHECK(m.call() == 0);
        }
    }

    TEST_CASE("follow: the weight of one seed hides others that stay") {
        for (int set = 0; set < 20; ++set) {  // each of few seeds is over the point of the count at some time
            CAPTURE(set);
            Moving m(7);
            test::Random random(300 + static_cast<std::uint64_t>(set));
            for (double& x : m.points) x = random.uniform();
            std::vector<double> weights(7);
            for (double& weight : weights) weight = random.uniform(0, 0.03);
            for (std::size_t heavy = 0; heavy < 7; ++heavy) {
                m.options.weights = weights;
                CHECK(m.call() >= 0);
                CHECK(m.call() >= 0);
                std::vector<double> changed = weights;
                changed[heavy] += random.uniform(0.1, 0.2);
                m.options.weights = changed;
                CHECK(m.call() >= 0);
                CHECK(m.call() >= 0);
            }
        }
    }

    // All seeds that are surely hidden are left out, which takes less time.
    TEST_CASE("follow: nothing is kept where most seeds are surely hidden") {
        Moving m(5000);
        std::vector<double> weights(5000);
        for (double& weight : weights) weight = m.random.uniform();
        m.options.weights = weights;
        for (int step = 0; step < 3; ++step) CHECK(m.call() == 0);
    }

    // Neighbors of the same cluster are near, those of others far, and corners are far from all of them.
    TEST_CASE("follow: tight clusters whose cells fill much of the box") {
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Moving m(400);
            m.options.periodic = {periodic, periodic, periodic};
            for (std::size_t c = periodic ? 1080 : 0; c < m.points.size(); ++c)  // in a period cells cannot be farther
                m.points[c] = 0.3 + 0.4 * (periodic ? 0.5 : (c / 3 >> c % 3 & 1) != 0) + 1e-4 * m.random.gaussian();
            const std::vector<double> equal(400, 0.0025);
            std::vector<double> weights =
                votess::fit_volumes(m.points, equal, m.options, {.tolerance = 1e-2, .normalize = true}).weights;
            m.options.weights = weights;
            CHECK(m.call() == 0);
            CHECK(m.call() > 0.9);
            for (double& weight : weights) weight += 1e-9 * m.random.uniform();
            m.options.weights = weights;
            CHECK(m.call() > 0.9);
            // No walk from cell to cell finds their seeds in other rows.
            for (std::size_t i = 1; i < weights.size(); ++i) {
                const std::size_t other = m.random.below(i);
                std::swap(weights[i], weights[other]);
                std::swap_ranges(&m.points[3 * i], &m.points[3 * i] + 3, &m.points[3 * other]);
            }
            m.options.weights = weights;
            CHECK(m.call() > 0.9);
        }
    }

    // Threads flip in ranges of seeds, which begin elsewhere the second time.
    TEST_CASE("follow: threads change cells together") {
        Moving m(test::by_size(12000, 9000));
        m.options.threads = 2;
        m.options.want = {};
        m.options.periodic = {true, false, true};
        CHECK(m.call() == 0);
        for (int step = 0; step < 3; ++step) {
            m.move(5e-3);
            CHECK(m.call() > 0.95);
        }
    }

    TEST_CASE("follow: triclinic boxes, which may change") {
        Moving m(test::by_size(1500, 1000));
        m.options.box.reset();
        votess::TriclinicBox& cell = m.options.cell.emplace();
        cell.a = {1, 0, 0};
        cell.b = {0.3, 1, 0};
        cell.c = {0.2, -0.4, 0.9};
        CHECK(m.call() == 0);
        m.move(5e-3);
        CHECK(m.call() > 0.9);
        cell.b[0] += 1e-4;
        m.move(1e-3);
        CHECK(m.call() > 0.9);
    }

    TEST_CASE("follow: walls of any direction") {
        std::vector<votess::Wall> corners, ball;
        for (int k = 0; k < 8; ++k)  // a box without corners
            corners.push_back({{k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0}, 0});
        for (votess::Wall& wall : corners) wall.offset = 0.5 * (wall.normal[0] + wall.normal[1] + wall.normal[2]) + 1;
        test::Random random(3);
        for (int k = 0; k < 200; ++k) {
            votess::Wall wall{{random.gaussian(), random.gaussian(), random.gaussian()}, 0};
            const auto [x, y, z] = wall.normal;
            wall.offset = 0.5 * (x + y + z) + 0.4 * std::sqrt(x * x + y * y + z * z);
            ball.push_back(wall);
        }
        for (const auto& walls : {corners, ball})
            for (const bool weighted : {false, true}) {
                CAPTURE(walls.size());
                CAPTURE(weighted);
                Moving m(4000);
                m.enclose(walls);
                std::vector<double> weights;
                for (std::size_t i = 0; weighted && i < m.points.size() / 3; ++i)
                    weights.push_back(0.1 * m.spacing * m.spacing * m.random.uniform());
                m.options.weights = weights;
                m.options.want.normals = true;
                m.options.list_walls = true;
                CHECK(m.call() == 0);
                CHECK(m.call() > 0.95);
                m.move(1e-5);
                CHECK(m.call() > 0.95);
                m.move(5e-3);
                CHECK(m.call() > 0.85);
                const auto& [normal, offset] = walls[2];  // the nearest seed goes to it
                double least = 1;
                std::size_t nearest = 0;
                for (std::size_t i = 0; i < m.points.size(); i += 3) {
                    const double* const x = &m.points[i];
                    const double way = offset - normal[0] * x[0] - normal[1] * x[1] - normal[2] * x[2];
                    if (way < least) least = way, nearest = i;
                }
                const double square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
                for (std::size_t k = 0; k < 3; ++k) m.points[nearest + k] += normal[k] * (least - 1e-14) / square;
                CHECK(m.is_inside(&m.points[nearest]));
                CHECK(m.call() > 0.9);
                m.options.walls.pop_back();  // of another domain no cell is kept
                CHECK(m.call() == 0);
                CHECK(m.call() == 0);
                CHECK(m.call() > 0.9);
            }
    }

    TEST_CASE("follow: seeds come and go, and rows change places") {
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Moving m(2500);  // of fewer, too many are new in the end
            m.options.periodic = {periodic, periodic, periodic};
            CHECK(m.call() == 0);
            m.points.erase(m.points.begin() + 300, m.points.begin() + 309);  // three leave
            m.move(1e-4);
            CHECK(m.call() > 0.8);
            for (int c = 0; c < 9; ++c) m.points.insert(m.points.begin() + 600, m.random.uniform());  // three come
            m.move(1e-4);
            CHECK(m.call() > 0.8);
            m.points.erase(m.points.begin(), m.points.begin() + 3);  // one each
            for (int axis = 0; axis < 3; ++axis) m.points.push_back(m.random.uniform());
            CHECK(m.call() > 0.8);
            for (std::size_t i = 1; i < m.points.size() / 3; ++i)
                std::swap_ranges(&m.points[3 * i], &m.points[3 * i] + 3, &m.points[3 * m.random.below(i)]);
            m.move(1e-4);
            CHECK(m.call() > 0.9);
            m.move(1e-4);
            CHECK(m.call() > 0.9);
            m.points.resize(m.points.size() / 2);
            for (double& x : m.points) x = m.random.uniform();  // others
            CHECK(m.call() == 0);
        }
    }

    TEST_CASE("follow: seeds leave the domain, where they are dropped, and return") {
        for (const bool walls : {false, true}) {
            CAPTURE(walls);
            Moving m(3000);
            m.options.outside = votess::Outside::drop;
            m.options.periodic = {!walls, false, !walls};
            if (walls) m.options.walls = {{{1, 1, 0.5}, 2.2}, {{-1, 0.3, 0.2}, 0.2}};
            for (double& x : m.points) x = 1.02 * x - 0.01;  // some are outside
            CHECK(m.call() == 0);
            CHECK(m.call() > 0.7);
            const std::vector<double> first = m.points;
            for (const double to : {1.5, 0.5}) {  // one leaves, one comes
                for (std::size_t k = 0; k < 3; ++k) m.points[k] = to + 0.01 * static_cast<double>(k);
                CHECK(m.call() > 0.7);
                CHECK(m.call() > 0.7);
            }
            for (double& x : m.points) x += 1e-3 * m.spacing * m.random.uniform(-1, 1);
            CHECK(m.call() > 0.6);
            m.points = first;
            CHECK(m.call() > 0.6);
            for (double& x : m.points) x += 2;  // all, along axes that do not repeat
            CHECK(m.call() == 0);
            CHECK(m.call() == 0);
            m.points = first;
            CHECK(m.call() >= 0);
        }
    }

    TEST_CASE("follow: ties are proven at each call") {
        Moving m(1);
        m.points.clear();
        constexpr int side = 6;
        for (int i = 0; i < side * side * side; ++i)
            for (const int at : {i % side, i / side % side, i / side / side}) m.points.push_back((at + 0.5) / side);
        m.spacing = 1.0 / side;
        CHECK(m.call() == 0);
        CHECK(m.call() == 0);
        m.move(1e-4);  // no sign is wrong, but all lists change
        CHECK(m.call() == 0);
        CHECK(m.call() == 0);
        CHECK(m.call() > 0.9);
        // A tie among a few of many.
        Moving few(5000);
        CHECK(few.call() == 0);
        for (int k = 0; k < 8; ++k)
            for (int axis = 0; axis < 3; ++axis)
                few.points[static_cast<std::size_t>(3 * k + axis)] = 0.5 + 0.03125 * ((k >> axis & 1) != 0 ? 1 : -1);
        CHECK(few.call() > 0.8);
        CHECK(few.call() > 0.8);
        few.move(1e-4);
        CHECK(few.call() > 0.8);
    }

    TEST_CASE("follow: histories") {
        test::Random random(11);
        std::uint64_t kept = 0, parts = 0;
        for (std::size_t history = 0; history < test::by_size(150, 15); ++history) {
            CAPTURE(history);
            votess::Tessellator tessellator;
            for (const test::fuzz::Job& job : test::fuzz::moving_seeds(random)) {
                Options options = job.options("cpu");
                votess::Tessellation t, fresh;
                const auto code = test::error_of([&] { t = tessellator.tessellate(job.points, options); });
                options.follow = false;
                CHECK(code == test::error_of([&] { fresh = votess::tessellate(job.points, options); }));
                CHECK(test::check_identical(t, fresh) == "");
                const votess::Stats &s = t.stats(), &other = fresh.stats();
                CHECK(s.faces == other.faces);
                CHECK(s.volume_sum == other.volume_sum);
                CHECK(s.empty_cells == other.empty_cells);
                CHECK(s.tiny_faces == other.tiny_faces);
                CHECK(other.kept_cells == 0);
                kept += s.kept_cells;
                parts += s.kept_cells > 0 && s.kept_cells < t.size() ? 1 : 0;
            }
        }
        CHECK(kept > test::by_size(10000, 100));
        CHECK(parts > test::by_size(30, 1));
    }
}
