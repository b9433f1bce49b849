// star: what cells of a stretch hand to each other, and the window of seeds around a home.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "polytope/cell_kernels.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "walk/neighborhood.hpp"
#include "walk/window.hpp"

using namespace votess::cpu;
using test::Random;

namespace {

struct Sorted {
    explicit Sorted(std::span<const double> points) {
        votess::ThreadPool pool(1);
        SeedSorter().sort(points, 1, 0, pool, seeds);
        hierarchy.build(seeds, pool);
    }
    SortedSeeds seeds;
    Hierarchy hierarchy;

    [[nodiscard]] std::array<double, 3> at(std::size_t s) const { return {seeds.x[s], seeds.y[s], seeds.z[s]}; }
    // The bounds of the seeds of a home.
    [[nodiscard]] votess::Box home_box(std::size_t home) const {
        const std::size_t begin = home * Window::home_seeds, end = std::min(seeds.size(), begin + Window::home_seeds);
        votess::Box box;
        for (int k = 0; k < 3; ++k) {
            box.lower[k] = box.upper[k] = at(begin)[k];
            for (std::size_t s = begin; s < end; ++s) {
                box.lower[k] = std::min(box.lower[k], at(s)[k]);
                box.upper[k] = std::max(box.upper[k], at(s)[k]);
            }
        }
        return box;
    }
};

double distance(const votess::Box& box, const std::array<double, 3>& p) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += std::pow(std::max({0.0, box.lower[k] - p[k], p[k] - box.upper[k]}), 2);
    return std::sqrt(square);
}

// Seeds of the window that are not hidden.
std::set<std::int32_t> shown(const Window& window) {
    std::set<std::int32_t> ids;
    const WindowSeeds w = window.seeds();
    for (int i = 0; i < w.count; ++i)
        if (w.x[i] != far_away) REQUIRE(ids.insert(w.id[i]).second);
    for (int i = w.count; i < (w.count + 15) / 16 * 16; ++i) REQUIRE(w.x[i] == far_away);
    return ids;
}

// Complete within its reach and true to half a unit. Returns the reach.
double check_window(const Sorted& sorted, Window& window, std::size_t home, double radius, const Neighborhood& cells) {
    CAPTURE(home);
    REQUIRE(window.open(home, window.home_box(home), radius, 0, cells));
    const votess::Box box = sorted.home_box(home);
    const std::set<std::int32_t> ids = shown(window);
    const auto own = static_cast<std::size_t>(home * Window::home_seeds);
    const auto from = window.position(own);
    const WindowSeeds w = window.seeds();
    for (std::size_t s = 0; s < sorted.seeds.size(); ++s) {
        const bool own_home = s / Window::home_seeds == home;
        const bool done = !own_home && cells.group_done(s / group_size);
        const auto id = static_cast<std::int32_t>(s);
        if (done) REQUIRE(!ids.contains(id));
        if (!done && distance(box, sorted.at(s)) < window.reach() * (1 - 1e-9)) REQUIRE(ids.contains(id));
    }
    REQUIRE(std::abs(std::remainder(std::log2(window.scale()), 1)) == 0);
    for (int i = 0; i < w.count; ++i) {
        const std::int32_t at[3] = {w.x[i], w.y[i], w.z[i]};
        const bool padding = static_cast<std::size_t>(w.id[i]) >= sorted.seeds.size();
        for (int k = 0; k < 3; ++k) {
            REQUIRE(std::abs(at[k]) <= window_range);
            if (padding || std::abs(at[k]) == window_range) continue;
            const double exact = (sorted.at(static_cast<std::size_t>(w.id[i]))[k] - sorted.at(own)[k]) * window.scale();
            REQUIRE(std::abs(at[k] - from[k] - exact) <= 1 + 1e-6);
        }
        // What is clamped, padding too, lies beyond the reach of every seed of the home.
        bool clamped = padding;
        for (const std::int32_t x : at) clamped = clamped || std::abs(x) == window_range;
        for (std::size_t s = own; clamped && s < std::min(own + Window::home_seeds, sorted.seeds.size()); ++s) {
            const auto p = window.position(s);
            double square = 0;
            for (int k = 0; k < 3; ++k) square += std::pow(static_cast<double>(at[k]) - p[k], 2);
            REQUIRE(std::sqrt(square) > window.reach() * window.scale());
        }
    }
    return window.reach();
}

constexpr std::int32_t walls = 9;

// No seed is done.
Neighborhood fresh(const Sorted& sorted) {
    Neighborhood cells;
    cells.begin(sorted.seeds, 0, std::min<std::size_t>(sorted.seeds.size(), 4096), 6, false);
    return cells;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("star neighborhood: local ids of walls, own seeds and many foreign ones") {
        const Sorted sorted(test::uniform(100, 1).points);
        Neighborhood cells;
        Random random(2);
        for (int round = 0; round < 3; ++round) {  // the table that has grown is used again
            cells.begin(sorted.seeds, 16, 80, walls, false);
            CHECK(cells.locals() == walls + 64);
            for (std::int32_t wall = -walls; wall < 0; ++wall) CHECK(cells.id(cells.local(wall)) == wall);
            for (std::int32_t s = 16; s < 80; ++s) CHECK(cells.id(cells.local(s)) == s);
            std::vector<std::int32_t> ids{0, 15, 80, 81, std::numeric_limits<std::int32_t>::max()};
            // Multiples of a power of two collide in many a hash.
            for (std::int32_t i = 1; i < 3000; ++i) ids.push_back(i << 16);
            while (ids.size() < (round == 1 ? 40000 : 20000))
                ids.push_back(static_cast<std::int32_t>(80 + random.below(1 << 30)));
            std::vector<std::int32_t> locals;
            for (const std::int32_t id : ids) locals.push_back(cells.local(id));
            std::set<std::int32_t> different(ids.begin(), ids.end());
            CHECK(cells.locals() == walls + 64 + static_cast<std::int32_t>(different.size()));
            for (std::size_t i = 0; i < ids.size(); ++i) {
                REQUIRE(cells.local(ids[i]) == locals[i]);
                REQUIRE(cells.id(locals[i]) == ids[i]);
            }
        }
    }

    TEST_CASE("star neighborhood: vertices reach every cell that shares them, however many there are") {
        const Sorted sorted(test::uniform(400, 3).points);
        Neighborhood cells;
        Random random(4);
        for (const std::size_t vertices : {0, 1, 31, 32, 33, 64, 65, 500, 5000}) {
            CAPTURE(vertices);
            cells.begin(sorted.seeds, 32, 96, walls, true);
            // By owner: (positions in their order, cells); hub is a cell of most vertices.
            const std::int32_t hub = cells.local(50), foreign = cells.local(200), wall = cells.local(-8);
            using Handed = std::pair<std::array<std::int32_t, 3>, double>;  // the three others, smallest first
            std::vector<std::vector<Handed>> expected(64);
            auto expect = [&](std::int32_t cell, std::array<std::int32_t, 3> others, double position) {
                if (cell < walls || cell >= walls + 64) return;
                std::rotate(others.begin(), std::ranges::min_element(others), others.end());
                expected[static_cast<std::size_t>(cell - walls)].emplace_back(others, position);
            };
            for (std::size_t v = 0; v < vertices; ++v) {
                const auto owner = cells.local(static_cast<std::int32_t>(60 + random.below(30)));
                const auto other = random.chance(0.3)   ? foreign
                                   : random.chance(0.3) ? wall
                                                        : cells.local(static_cast<std::int32_t>(32 + random.below(18)));
                const auto fourth = cells.local(static_cast<std::int32_t>(51 + random.below(9)));
                const auto position = static_cast<double>(v);
                cells.give({owner, hub, other, fourth}, cells.place(owner, {{position, 1, 2, 3}}));
                expect(hub, {owner, fourth, other}, position);
                expect(other, {owner, hub, fourth}, position);
                expect(fourth, {owner, other, hub}, position);
            }
            for (std::size_t s = 0; s < 64; ++s) {
                std::vector<Handed> found;
                for (const KnownVertex& known : cells.known(32 + s)) {
                    REQUIRE_FALSE(known.is_tie());
                    auto others = known.cells;
                    std::rotate(others.begin(), std::ranges::min_element(others), others.end());
                    found.emplace_back(others, cells.position(known.vertex).x[0]);
                    const auto& owner = cells.seed_position(cells.owner(known.vertex)).x;  // one of 60 .. 89
                    bool is_seed = false;
                    for (std::size_t i = 60; i < 90; ++i) is_seed = is_seed || owner[0] == sorted.seeds.x[i];
                    REQUIRE(is_seed);
                }
                std::ranges::sort(found);
                std::ranges::sort(expected[s]);
                REQUIRE(found == expected[s]);
            }
            if (vertices > 0) CHECK(cells.known(50).size() == vertices);
        }
        cells.begin(sorted.seeds, 0, 64, walls, false);  // nothing of another stretch is left
        for (std::size_t s = 0; s < 64; ++s) CHECK(cells.known(s).empty());
    }

    TEST_CASE("star neighborhood: ties") {
        const Sorted sorted(test::uniform(200, 5).points);
        Neighborhood cells;
        cells.begin(sorted.seeds, 0, 64, walls, true);
        std::vector<std::int32_t> few{cells.local(3), cells.local(40), cells.local(-1), cells.local(150),
                                      cells.local(7)};
        std::vector<std::int32_t> many;  // most of them not of the stretch
        for (std::int32_t s = 60; s < 130; ++s) many.push_back(cells.local(s));
        cells.give_tie(few, cells.place(few[0], {{1, 0, 0, 0}}), 1);
        cells.give_tie(many, cells.place(many[0], {{2, 0, 0, 0}}), 4);
        cells.give({cells.local(63), cells.local(7), cells.local(8), cells.local(9)},
                   cells.place(cells.local(63), {{3, 0, 0, 0}}));
        auto handed = [&](std::size_t seed) {
            std::vector<double> positions;
            for (const KnownVertex& known : cells.known(seed)) {
                positions.push_back(cells.position(known.vertex).x[0]);
                if (known.is_tie()) CHECK(std::ranges::equal(cells.tie(known), positions.back() == 1 ? few : many));
            }
            return positions;
        };
        using Positions = std::vector<double>;
        CHECK(handed(3) == Positions{});  // its own
        CHECK(handed(40) == Positions{1});
        CHECK(handed(7) == Positions{1, 3});
        CHECK(handed(9) == Positions{3});
        CHECK(handed(60) == Positions{});
        CHECK(handed(61) == Positions{2});
        CHECK(handed(63) == Positions{2});
        CHECK(handed(0) == Positions{});
    }

    TEST_CASE("star neighborhood: groups that are done") {
        const Sorted sorted(test::uniform(100, 6).points);
        Neighborhood cells;
        cells.begin(sorted.seeds, 16, 45, walls, false);
        for (std::size_t s = 16; s < 45; ++s) {
            CHECK_FALSE(cells.done(s));
            if (s != 27) cells.set_done(s);
        }
        // 24..31 lacks a seed, 40..47 is not all of the stretch.
        for (std::size_t group = 0; group < 13; ++group) CHECK(cells.group_done(group) == (group == 2 || group == 4));
        CHECK(cells.done(26));
        CHECK_FALSE(cells.done(27));
    }

    TEST_CASE("star window: complete within its reach, for any radius") {
        for (const test::PointSet& set : {test::uniform(3001, 7), test::clustered(3001, 8), test::cubic(9),
                                          test::far_from_origin(500, 9), test::uniform(5, 10), test::uniform(17, 11)}) {
            CAPTURE(set.name);
            const Sorted sorted(set.points);
            const Neighborhood cells = fresh(sorted);
            for (const Kernels* supported : supported_kernels()) {
                INFO(std::string(supported->name));
                Window window(sorted.seeds, sorted.hierarchy, star_kernels(supported->name));
                const std::size_t homes = (sorted.seeds.size() + Window::home_seeds - 1) / Window::home_seeds;
                for (std::size_t home = 0; home < homes; home += 1 + homes / 7) {
                    const votess::Box box = sorted.home_box(home);
                    const double size = std::max(box.upper[0] - box.lower[0], 1e-3);
                    for (const double factor : {0.01, 0.5, 1.0, 3.0})
                        check_window(sorted, window, home, factor * size, cells);
                }
            }
        }
    }

    TEST_CASE("star window: the radius shrinks where seeds are many and grows where they are few") {
        const Sorted dense(test::uniform(20000, 12).points);
        const Neighborhood dense_cells = fresh(dense);
        test::Coordinates clusters;  // of a home each, far from each other
        for (int i = 0; i < 64; ++i) {
            const auto cluster = test::uniform(Window::home_seeds, 13).points;
            const int place[3] = {i % 4, i / 4 % 4, i / 16};
            for (std::size_t k = 0; k < cluster.size(); ++k) clusters.push_back(cluster[k] + 20 * place[k % 3]);
        }
        const Sorted sparse(clusters);
        const Neighborhood sparse_cells = fresh(sparse);
        for (const Kernels* supported : supported_kernels()) {
            INFO(std::string(supported->name));
            Window window(dense.seeds, dense.hierarchy, star_kernels(supported->name));
            const double reach = check_window(dense, window, 600, 0.8, dense_cells);
            CHECK(reach < 0.5);
            CHECK(reach > 0.05);
            CHECK(window.seeds().count <= 160 * 8);
            CHECK(window.seeds().count > 30 * 8);
            Window few(sparse.seeds, sparse.hierarchy, star_kernels(supported->name));
            for (std::size_t home = 0; home < 64; ++home) {
                CHECK(check_window(sparse, few, home, 2, sparse_cells) > 2);
                CHECK(few.seeds().count > static_cast<int>(Window::home_seeds));
            }
        }
        // Shrinking ends where the radius was unreasonable.
        test::Coordinates points;
        Random random(14);
        for (int i = 0; i < 5000; ++i) points.insert(points.end(), {random.uniform(), 0, 0});
        const Sorted line(points);
        const Neighborhood line_cells = fresh(line);
        Window window(line.seeds, line.hierarchy, star_kernels("baseline"));
        CHECK(check_window(line, window, 100, 5, line_cells) < 0.2);
        CHECK_FALSE(window.open(100, window.home_box(100), 1e3, 0, line_cells));
    }

    TEST_CASE("star window: seeds far beyond it are clamped") {
        // Each group near the home holds seeds that are far away: whatever the order, some group joins both.
        test::Coordinates points = test::uniform(37, 15).points;
        for (double& x : points) x *= 1e-9;
        points.insert(points.end(), {1, 1, 1, -1, 1, 1, 1e6, 0, 0, 0, -1e9, 0});
        const Sorted sorted(points);
        const Neighborhood cells = fresh(sorted);
        std::size_t clamped = 0;
        for (const Kernels* supported : supported_kernels()) {
            INFO(std::string(supported->name));
            Window window(sorted.seeds, sorted.hierarchy, star_kernels(supported->name));
            for (std::size_t home = 0; home * Window::home_seeds < sorted.seeds.size(); ++home) {
                check_window(sorted, window, home, 1e-9, cells);
                const WindowSeeds w = window.seeds();
                for (int i = 0; i < w.count; ++i)
                    clamped += std::abs(w.x[i]) == window_range || std::abs(w.y[i]) == window_range;
            }
        }
        CHECK(clamped > 0);
    }

    TEST_CASE("star window: done groups are left out but for the home's, hidden seeds come back") {
        const Sorted sorted(test::uniform(1000, 16).points);
        Neighborhood cells = fresh(sorted);
        for (std::size_t s = 0; s < 216; ++s)
            if (s != 100) cells.set_done(s);
        Window window(sorted.seeds, sorted.hierarchy, star_kernels(best_kernels().name));
        check_window(sorted, window, 13, 0.3, cells);  // seeds 208 .. 223, of which half are done
        const auto all = shown(window);
        CHECK(all.contains(208));
        const std::int32_t x = window.position(220)[0];
        window.hide(220);
        CHECK_FALSE(shown(window).contains(220));
        CHECK(shown(window).size() == all.size() - 1);
        window.show(220, x);
        CHECK(shown(window) == all);
        // No window where units would overflow.
        test::Coordinates tiny;
        for (int i = 0; i < 40; ++i) tiny.insert(tiny.end(), {i * 0x1p-1060, 0, 0});
        const Sorted small(tiny);
        const Neighborhood small_cells = fresh(small);
        Window none(small.seeds, small.hierarchy, star_kernels("baseline"));
        CHECK_FALSE(none.open(0, none.home_box(0), 1e-310, 0, small_cells));
    }
}
