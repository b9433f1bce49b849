// Zones of a watershed against plain code: steps followed cell by cell, minima flooded with a queue, zones joined one
// at a time.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <utility>
#include <votess/diagram.hpp>
#include <votess/zones.hpp>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using Values = std::vector<double>;
using Ids = std::vector<std::int32_t>;
using Pair = std::pair<std::int32_t, std::int32_t>;
constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t index(std::int32_t i) {
    return static_cast<std::size_t>(i);
}

struct Plain {
    const votess::Tessellation& t;
    const Values& values;
    bool maxima;

    [[nodiscard]] bool is_lower(std::int32_t i, std::int32_t j) const {
        const double a = values[index(i)], b = values[index(j)];
        return a == b ? i < j : maxima ? a > b : a < b;
    }
    [[nodiscard]] double rise(std::int32_t from, std::int32_t to) const {
        const double a = values[index(from)], b = values[index(to)];
        return a == b ? 0 : maxima ? a - b : b - a;
    }
    [[nodiscard]] std::int32_t end_of_steps(std::int32_t i) const {
        for (;;) {
            std::int32_t next = i;
            for (const std::int32_t j : t.neighbors(index(i)))
                if (j >= 0 && is_lower(j, next)) next = j;
            if (next == i) return i;
            i = next;
        }
    }
    // Returns how far a flood from a minimum rises before it finds a lower cell.
    [[nodiscard]] double persistence(std::int32_t minimum) const {
        const auto later = [this](std::int32_t i, std::int32_t j) { return is_lower(j, i); };
        std::priority_queue<std::int32_t, Ids, decltype(later)> rim(later);
        std::set<std::int32_t> seen{minimum};
        rim.push(minimum);
        std::int32_t highest = minimum;
        while (!rim.empty()) {
            const std::int32_t i = rim.top();
            rim.pop();
            if (is_lower(i, minimum)) return rise(minimum, highest);
            if (is_lower(highest, i)) highest = i;
            for (const std::int32_t j : t.neighbors(index(i)))
                if (j >= 0 && seen.insert(j).second) rim.push(j);
        }
        return infinity;
    }
    // Returns the lowest pass between each two zones: zones, higher cell, lower cell; in the order of the passes.
    [[nodiscard]] std::vector<std::pair<Pair, Pair>> passes(const Ids& labels) const {
        std::map<Pair, Pair> lowest;
        const auto below = [this](const Pair& x, const Pair& y) {
            return x.first == y.first ? is_lower(x.second, y.second) : is_lower(x.first, y.first);
        };
        for (std::size_t i = 0; i < t.size(); ++i) {
            for (const std::int32_t j : t.neighbors(i)) {
                if (j < 0 || labels[i] == labels[index(j)]) continue;
                const auto me = static_cast<std::int32_t>(i);
                const Pair pass = is_lower(me, j) ? Pair{j, me} : Pair{me, j};
                const auto [found, is_new] = lowest.try_emplace(std::minmax(labels[i], labels[index(j)]), pass);
                if (!is_new && below(pass, found->second)) found->second = pass;
            }
        }
        std::vector<std::pair<Pair, Pair>> sorted(lowest.begin(), lowest.end());
        std::ranges::sort(sorted, below, &std::pair<Pair, Pair>::second);
        return sorted;
    }
    // Joins the zone of least persistence to the one across its lowest pass, again and again.
    [[nodiscard]] Ids joined(Ids labels, Ids& cores, double threshold) const {
        for (;;) {
            double least = infinity;
            std::int32_t from = -1, to = -1;
            std::set<std::int32_t> met;  // passes ascend: the first one of a zone is its lowest
            for (const auto& [zones, pass] : passes(labels)) {
                for (const auto& [a, b] : {zones, Pair{zones.second, zones.first}}) {
                    if (!met.insert(a).second || is_lower(cores[index(a)], cores[index(b)])) continue;
                    const double height = rise(cores[index(a)], pass.first);
                    if (height <= threshold && (from < 0 || height < least)) {
                        least = height;
                        from = a;
                        to = b;
                    }
                }
            }
            if (from < 0) break;
            std::ranges::replace(labels, from, to);
        }
        Ids kept, number(cores.size(), -1);
        for (std::size_t z = 0; z < cores.size(); ++z) {
            if (std::ranges::count(labels, static_cast<std::int32_t>(z)) == 0) continue;
            number[z] = static_cast<std::int32_t>(kept.size());
            kept.push_back(cores[z]);
        }
        for (std::int32_t& label : labels)
            if (label >= 0) label = number[index(label)];
        cores = kept;
        return labels;
    }
};

// Returns one line on the first difference, "" when all is right.
std::string check_passes(const votess::Zones& zones, const Plain& plain) {
    const auto expected = plain.passes(zones.labels);
    if (zones.saddles.size() != expected.size() || zones.pairs.size() != 2 * expected.size() ||
        zones.passes.size() != 2 * expected.size())
        return std::to_string(zones.saddles.size()) + " pairs, not " + std::to_string(expected.size());
    for (std::size_t p = 0; p < expected.size(); ++p)
        if (expected[p] != std::pair{Pair{zones.pairs[2 * p], zones.pairs[2 * p + 1]},
                                     Pair{zones.passes[2 * p], zones.passes[2 * p + 1]}} ||
            zones.saddles[p] != plain.values[index(zones.passes[2 * p])])
            return "pair " + std::to_string(p);
    return "";
}

std::string check_zones(const votess::Tessellation& t, const Values& values, bool maxima) {
    const Plain plain{t, values, maxima};
    const votess::Zones zones = votess::watershed(t, values, maxima);
    if (zones.maxima != maxima || zones.labels.size() != t.size()) return "size";
    Ids cores;
    for (std::size_t i = 0; i < t.size(); ++i) {
        const bool has_cell = t.status()[i] == votess::CellStatus::certified;
        if (has_cell != (zones.labels[i] >= 0)) return "label of cell " + std::to_string(i);
        if (!has_cell) continue;
        const std::int32_t end = plain.end_of_steps(static_cast<std::int32_t>(i));
        if (zones.cores.at(index(zones.labels[i])) != end) return "zone of cell " + std::to_string(i);
        if (index(end) == i) cores.push_back(end);
    }
    if (zones.cores != cores) return "cores";
    for (std::size_t i = 0; i < zones.at_walls.size(); ++i)
        if (zones.at_walls[i] != (!t.neighbors(i).empty() && t.neighbors(i)[0] < 0)) return "walls";
    if (zones.at_walls.size() != (t.lists_walls() ? t.size() : 0)) return "size of walls";
    if (const std::string wrong = check_passes(zones, plain); !wrong.empty()) return wrong;
    std::set<double> thresholds{-1, 0, infinity};
    for (std::size_t z = 0; z < zones.size(); ++z) {
        if (zones.persistence.at(z) != plain.persistence(cores[z])) return "persistence of zone " + std::to_string(z);
        if ((zones.parents.at(z) < 0) && zones.persistence[z] != infinity) return "root " + std::to_string(z);
        if (z % 3 == 0) thresholds.insert(zones.persistence[z]);
    }
    for (const double threshold : thresholds) {
        const votess::Zones merged = zones.merge(threshold);
        Ids kept = cores;
        const std::string at = "merge at " + std::to_string(threshold) + ": ";
        if (merged.labels != plain.joined(zones.labels, kept, threshold) || merged.cores != kept) return at + "zones";
        if (merged.maxima != maxima || merged.at_walls != zones.at_walls) return at + "flags";
        if (const std::string wrong = check_passes(merged, plain); !wrong.empty()) return at + wrong;
        for (std::size_t z = 0; z < merged.size(); ++z)
            if (merged.persistence.at(z) != plain.persistence(kept[z])) return at + "persistence";
        // Merging in two steps is the same.
        const votess::Zones twice = zones.merge(threshold / 2).merge(threshold);
        if (threshold >= 0 && (twice.labels != merged.labels || twice.parents != merged.parents ||
                               twice.pairs != merged.pairs || twice.persistence != merged.persistence))
            return at + "two steps";
    }
    return "";
}

Values random_values(std::size_t n, std::uint64_t kinds, std::uint64_t seed) {
    test::Random random(seed);
    Values values(n);
    for (double& value : values) value = kinds > 0 ? static_cast<double>(random.below(kinds)) : random.uniform();
    return values;
}

// Returns cells on a line, with walls in the rows.
votess::Tessellation line(std::size_t n) {
    test::Coordinates points;
    for (std::size_t i = 0; i < n; ++i)
        points.insert(points.end(), {(static_cast<double>(i) + 0.5) / static_cast<double>(n), 0.5, 0.5});
    return votess::tessellate(points, test::all_options(test::unit_box()));
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("zones: seven cells in a line") {
        const votess::Zones zones = votess::watershed(line(7), Values{3, 1, 4, 0, 5, 2, 6});
        CHECK(zones.labels == Ids{0, 0, 1, 1, 1, 2, 2});
        CHECK(zones.cores == Ids{1, 3, 5});
        CHECK(zones.pairs == Ids{0, 1, 1, 2});
        CHECK(zones.saddles == Values{4, 5});
        CHECK(zones.passes == Ids{2, 1, 4, 5});
        CHECK(zones.parents == Ids{1, -1, 1});
        CHECK(zones.persistence == Values{3, infinity, 3});
        CHECK(zones.at_walls == std::vector<std::uint8_t>(7, 1));
        CHECK(zones.merge(2.9).labels == zones.labels);
        CHECK(zones.merge(3).labels == Ids(7, 0));
        const votess::Zones peaks = votess::watershed(line(7), Values{3, 1, 4, 0, 5, 2, 6}, true);
        CHECK(peaks.labels == Ids{0, 1, 1, 2, 2, 3, 3});
        CHECK(peaks.cores == Ids{0, 2, 4, 6});
        CHECK(peaks.saddles == Values{2, 1, 0});
        CHECK(peaks.persistence == Values{2, 4, 3, infinity});
    }

    TEST_CASE("zones: a zone joins the one that it touches, not the lowest") {
        const votess::Zones zones = votess::watershed(line(5), Values{5, 6, 1, 5, 0});
        CHECK(zones.parents == Ids{1, 2, -1});
        CHECK(zones.persistence == Values{1, 4, infinity});
        const votess::Zones merged = zones.merge(1);
        CHECK(merged.labels == Ids{0, 0, 0, 1, 1});
        CHECK(merged.cores == Ids{2, 4});
        CHECK(merged.pairs == Ids{0, 1});
        CHECK(merged.saddles == Values{5});
    }

    TEST_CASE("zones: equal and infinite values") {
        const votess::Zones equal = votess::watershed(line(4), Values{1, 0.0, -0.0, 1});
        CHECK(equal.labels == Ids(4, 0));
        CHECK(equal.cores == Ids{1});
        // Cell 0 touches only a cell with an equal value.
        const votess::Zones far = votess::watershed(line(5), Values{infinity, infinity, infinity, 2, infinity});
        CHECK(far.labels == Ids{0, 0, 1, 1, 1});
        CHECK(far.cores == Ids{0, 3});
        CHECK(far.persistence == Values{0, infinity});
        CHECK(far.merge(0).cores == Ids{3});
        const votess::Zones deep = votess::watershed(line(3), Values{-infinity, 0, -infinity});
        CHECK(deep.persistence == Values{infinity, infinity});
        CHECK(deep.parents == Ids{-1, 0});
        CHECK(deep.merge(1e308).size() == 2);
        CHECK(deep.merge(infinity).size() == 1);
    }

    TEST_CASE("zones: domains and values, against plain code") {
        const std::size_t n = test::by_size(300, 100);
        std::vector<std::pair<test::Coordinates, votess::Options>> sets;
        const auto add = [&](const test::PointSet& set, const auto& change) {
            votess::Options options = test::all_options(set.box);
            change(options);
            sets.emplace_back(set.points, options);
        };
        const auto unchanged = [](votess::Options&) {};
        add(test::uniform(n, 1), unchanged);
        add(test::clustered(n, 2), unchanged);
        add(test::with_duplicates(n / 2, 20, 3), [](votess::Options& options) { options.list_walls = false; });
        add(test::uniform(1, 4), unchanged);
        add(test::cubic(6), unchanged);
        const auto repeat = [](votess::Options& options) {
            options.box = test::unit_box();
            options.periodic = {true, true, true};
        };
        for (const std::size_t size : {n, std::size_t{30}, std::size_t{2}}) add(test::uniform(size, 5), repeat);
        add(test::uniform(n, 6), [](votess::Options& options) {
            options.box = test::cube(-infinity, infinity);
            options.want.counts = false;
        });
        const Values weights = random_values(n, 0, 7);
        add(test::uniform(n, 8), [&](votess::Options& options) { options.weights = weights; });
        std::size_t empty = 0;
        for (const auto& [points, options] : sets) {
            const auto t = votess::tessellate(points, options);
            empty += t.stats().empty_cells;
            INFO(t.size() << " seeds, box " << t.box().upper[0]);
            Values densities;
            for (const double volume : t.volumes()) densities.push_back(volume > 0 ? 1 / volume : std::nan(""));
            Values holes = random_values(t.size(), 0, 9);
            for (std::size_t i = 0; i < t.size(); i += 7) holes[i] = i % 2 ? infinity : -infinity;
            for (const bool maxima : {false, true})
                for (const Values& values : {densities, random_values(t.size(), 0, 10), random_values(t.size(), 4, 11),
                                             Values(t.size(), 1), holes})
                    CHECK(check_zones(t, values, maxima) == "");
        }
        CHECK(empty > 50);
        votess::Options planar = test::all_options();
        planar.planar = true;
        planar.want.counts = false;
        const test::Coordinates flat = random_values(2 * n, 0, 12);
        CHECK(check_zones(votess::tessellate(flat, planar), random_values(n, 0, 13), false) == "");
    }

    TEST_CASE("zones: the same in any order of the seeds") {
        const auto set = test::uniform(test::by_size(3000, 500), 20);
        votess::Options options;
        options.box = test::unit_box();
        options.periodic = {true, true, true};
        const Values values = random_values(set.size(), 0, 21);
        const votess::Zones zones = votess::watershed(votess::tessellate(set.points, options), values);
        test::Random random(22);
        const auto order = test::permutation(set.size(), random);
        test::Coordinates points;
        Values shuffled;
        for (const std::size_t i : order) {
            points.insert(points.end(), {set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]});
            shuffled.push_back(values[i]);
        }
        const votess::Zones other = votess::watershed(votess::tessellate(points, options), shuffled);
        REQUIRE(other.size() == zones.size());
        const auto old = [&](std::int32_t seed) { return static_cast<std::int32_t>(order[index(seed)]); };
        Ids number;  // of the same zone before
        for (const std::int32_t core : other.cores) number.push_back(zones.labels[index(old(core))]);
        for (std::size_t i = 0; i < order.size(); ++i)
            REQUIRE(number[index(other.labels[i])] == zones.labels[order[i]]);
        for (std::size_t z = 0; z < other.size(); ++z) {
            CHECK(old(other.cores[z]) == zones.cores[index(number[z])]);
            CHECK(other.persistence[z] == zones.persistence[index(number[z])]);
            const std::int32_t parent = zones.parents[index(number[z])];
            CHECK((other.parents[z] < 0 ? -1 : number[index(other.parents[z])]) == parent);
        }
        CHECK(other.saddles == zones.saddles);
        Ids passes;
        for (const std::int32_t seed : other.passes) passes.push_back(old(seed));
        CHECK(passes == zones.passes);
        CHECK(other.merge(0.3).size() == zones.merge(0.3).size());
    }

    TEST_CASE("zones: refusals name the row") {
        const auto set = test::with_duplicates(20, 1, 30);
        votess::Options options;
        const auto t = votess::tessellate(set.points, options);
        const auto message = [](const votess::Tessellation& cells, const Values& values) {
            std::string text;
            CHECK(test::error_of([&] { (void)votess::watershed(cells, values); }, &text) ==
                  votess::ErrorCode::invalid_argument);
            return text;
        };
        Values values(t.size(), 1);
        const auto copy =
            static_cast<std::size_t>(std::ranges::find(t.status(), votess::CellStatus::duplicate) - t.status().begin());
        values[copy] = std::nan("");
        CHECK(votess::watershed(t, values).labels[copy] == -1);
        values[7] = std::nan("");
        CHECK(message(t, values).find("value of seed 7 is nan") != std::string::npos);
        CHECK(message(t, Values(5, 1)).find("5 values for 20 seeds") != std::string::npos);
        const std::vector<std::int64_t> only{3, 4};
        options.only = only;
        CHECK(message(votess::tessellate(set.points, options), Values(2, 1)).find("only") != std::string::npos);
        options.only.reset();
        options.want.neighbors = false;
        CHECK(message(votess::tessellate(set.points, options), Values(t.size(), 1)).find("want") != std::string::npos);
        const auto probes = votess::Diagram(set.points).probe(Values{0.1, 0.2, 0.3});
        CHECK(message(probes, Values(1, 1)).find("probes") != std::string::npos);
        const votess::Zones zones = votess::watershed(t, Values(t.size(), 1));
        CHECK(test::error_of([&] { (void)zones.merge(std::nan("")); }) == votess::ErrorCode::invalid_argument);
        CHECK(votess::watershed(votess::tessellate(test::Coordinates{}), Values{}).merge(1).size() == 0);
    }
}
