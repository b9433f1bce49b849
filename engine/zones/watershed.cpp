// Zones by ranks: the order of all cells by value is found once. All that follows compares whole numbers.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/at.hpp"
#include "core/progress.hpp"
#include "input/option_name.hpp"
#include "input/supports.hpp"
#include "votess/zones.hpp"

namespace votess {
namespace {

using Rank = std::uint32_t;
constexpr std::int32_t none = -1;
constexpr std::size_t cells_per_stop = 4096;  // after which the user may stop

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, "watershed(): " + message);
}

void check(const Tessellation& t, std::span<const double> values) {
    require(t, "watershed");
    if (t.indptr().size() != t.size() + 1) refuse("the tessellation has no rows, set " + option("want.neighbors"));
    if (values.size() != t.size())
        refuse(std::to_string(values.size()) + " values for " + std::to_string(t.size()) + " seeds: give one for each");
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::isnan(values[i]) && t.status()[i] == CellStatus::certified)
            refuse("the value of seed " + std::to_string(i) +
                   " is nan: give a number; infinity keeps a cell from being a minimum");
}

// Cells from lowest to highest, as ranks.
struct Order {
    std::vector<std::int32_t> seeds;  // of each rank
    std::vector<Rank> ranks;          // of each seed; the highest without a cell
};

Order order_of(const Tessellation& t, std::span<const double> values, bool maxima) {
    struct Entry {
        double height;
        std::int32_t seed;
    };
    std::vector<Entry> entries;
    entries.reserve(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
        if (t.status()[i] == CellStatus::certified)
            entries.push_back({maxima ? -values[i] : values[i], static_cast<std::int32_t>(i)});
    std::ranges::sort(entries, [](const Entry& a, const Entry& b) {
        return a.height < b.height || (a.height == b.height && a.seed < b.seed);
    });
    Order order;
    order.seeds.reserve(entries.size());
    order.ranks.assign(values.size(), std::numeric_limits<Rank>::max());
    for (const Entry& entry : entries) {
        order.ranks[at(entry.seed)] = static_cast<Rank>(order.seeds.size());
        order.seeds.push_back(entry.seed);
    }
    return order;
}

// Fills labels, cores and at_walls.
void descend(const Tessellation& t, const Order& order, Zones& out) {
    out.labels.assign(t.size(), none);
    if (t.lists_walls()) out.at_walls.assign(t.size(), 0);
    std::vector<Rank> lowest(t.size());  // rank of the lowest of each cell and its neighbors
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (i % cells_per_stop == 0) check_stop();
        if (t.status()[i] != CellStatus::certified) continue;
        lowest[i] = order.ranks[i];
        for (const std::int32_t j : t.neighbors(i)) {
            if (j >= 0)
                lowest[i] = std::min(lowest[i], order.ranks[at(j)]);
            else
                out.at_walls[i] = 1;
        }
        if (lowest[i] != order.ranks[i]) continue;
        out.labels[i] = static_cast<std::int32_t>(out.cores.size());
        out.cores.push_back(static_cast<std::int32_t>(i));
    }
    for (const std::int32_t seed : order.seeds)  // a step leads to a cell that comes before
        if (out.labels[at(seed)] == none) out.labels[at(seed)] = out.labels[at(order.seeds[lowest[at(seed)]])];
}

// The lowest step between two zones.
struct Pass {
    std::uint64_t ranks;  // of the higher cell, then of the lower one: two zones share no such pair with others
    std::int32_t a, b;    // zones
};

// Returns the seeds with a cell, zone by zone.
std::vector<std::int32_t> by_zone(const Order& order, const Zones& zones) {
    std::vector<std::size_t> ends(zones.size() + 1);
    for (const std::int32_t seed : order.seeds) ++ends[at(zones.labels[at(seed)]) + 1];
    std::partial_sum(ends.begin(), ends.end(), ends.begin());
    std::vector<std::int32_t> members(order.seeds.size());
    for (std::size_t i = 0; i < zones.labels.size(); ++i)
        if (zones.labels[i] != none) members[ends[at(zones.labels[i])]++] = static_cast<std::int32_t>(i);
    return members;
}

// Returns the passes, ascending. Rows are symmetric, so those of the zone of lower number have all.
std::vector<Pass> find_passes(const Tessellation& t, const Order& order, const Zones& zones) {
    constexpr std::uint64_t unset = std::numeric_limits<std::uint64_t>::max();
    std::vector<std::uint64_t> best(zones.size(), unset);  // between the zone at hand and each other one
    std::vector<std::int32_t> met;
    std::vector<Pass> passes;
    std::int32_t zone = 0;
    const auto finish_zone = [&] {
        for (const std::int32_t other : met) {
            passes.push_back({best[at(other)], zone, other});
            best[at(other)] = unset;
        }
        met.clear();
    };
    const std::vector<std::int32_t> members = by_zone(order, zones);
    for (std::size_t k = 0; k < members.size(); ++k) {
        if (k % cells_per_stop == 0) check_stop();
        const std::int32_t i = members[k];
        if (zones.labels[at(i)] != zone) {
            finish_zone();
            zone = zones.labels[at(i)];
        }
        for (const std::int32_t j : t.neighbors(at(i))) {
            if (j < 0) continue;
            const std::int32_t other = zones.labels[at(j)];
            if (other <= zone) continue;
            const auto [low, high] = std::minmax(order.ranks[at(i)], order.ranks[at(j)]);
            std::uint64_t& lowest = best[at(other)];
            if (lowest == unset) met.push_back(other);
            lowest = std::min(lowest, std::uint64_t{high} << 32 | low);
        }
    }
    finish_zone();
    std::ranges::sort(passes, {}, &Pass::ranks);
    return passes;
}

void store_passes(const std::vector<Pass>& passes, const Order& order, std::span<const double> values, Zones& out) {
    out.pairs.reserve(2 * passes.size());
    out.passes.reserve(2 * passes.size());
    out.saddles.reserve(passes.size());
    for (const Pass& pass : passes) {
        const std::int32_t high = order.seeds[pass.ranks >> 32], low = order.seeds[pass.ranks & 0xffffffff];
        out.pairs.insert(out.pairs.end(), {pass.a, pass.b});
        out.passes.insert(out.passes.end(), {high, low});
        out.saddles.push_back(values[at(high)]);
    }
}

// Follows `up` to its end, and shortens the way.
std::int32_t root_of(std::vector<std::int32_t>& up, std::int32_t zone) {
    while (up[at(zone)] != zone) zone = up[at(zone)] = up[at(up[at(zone)])];
    return zone;
}

// Fills parents and persistence. Zones that have met are a tree whose root has their lowest minimum.
//
// The parent is the zone across the saddle, not that root: a zone touches its parent. merge() may follow parents in any
// order. Zones that met the younger root before have at most its persistence.
void build_tree(const Order& order, std::span<const double> values, Zones& out) {
    out.parents.assign(out.size(), none);
    out.persistence.assign(out.size(), std::numeric_limits<double>::infinity());
    std::vector<std::int32_t> up(out.size());
    std::iota(up.begin(), up.end(), 0);
    for (std::size_t p = 0; p < out.saddles.size(); ++p) {
        if (p % cells_per_stop == 0) check_stop();
        std::int32_t mine = out.pairs[2 * p], other = out.pairs[2 * p + 1];
        std::int32_t younger = root_of(up, mine), older = root_of(up, other);
        if (younger == older) continue;
        if (order.ranks[at(out.cores[at(younger)])] < order.ranks[at(out.cores[at(older)])]) {
            std::swap(younger, older);
            std::swap(mine, other);
        }
        up[at(younger)] = older;
        out.parents[at(younger)] = other;
        const double minimum = values[at(out.cores[at(younger)])];
        out.persistence[at(younger)] = out.saddles[p] == minimum ? 0 : std::abs(out.saddles[p] - minimum);
    }
}

}  // namespace

Zones watershed(const Tessellation& tessellation, std::span<const double> values, bool maxima) {
    check(tessellation, values);
    Zones zones;
    zones.maxima = maxima;
    const Order order = order_of(tessellation, values, maxima);
    descend(tessellation, order, zones);
    store_passes(find_passes(tessellation, order, zones), order, values, zones);
    build_tree(order, values, zones);
    return zones;
}

Zones Zones::merge(double threshold) const {
    if (std::isnan(threshold)) throw Error(ErrorCode::invalid_argument, "merge(): threshold is nan: give a number");
    Zones out;
    out.maxima = maxima;
    out.at_walls = at_walls;
    std::vector<std::int32_t> up(size()), number(size());
    for (std::size_t z = 0; z < size(); ++z) {
        const bool joins = parents[z] != none && persistence[z] <= threshold;
        up[z] = joins ? parents[z] : static_cast<std::int32_t>(z);
        if (joins) continue;
        number[z] = static_cast<std::int32_t>(out.cores.size());
        out.cores.push_back(cores[z]);
        out.persistence.push_back(persistence[z]);
    }
    for (std::size_t z = 0; z < size(); ++z) number[z] = number[at(root_of(up, static_cast<std::int32_t>(z)))];
    out.labels.reserve(labels.size());
    for (const std::int32_t zone : labels) out.labels.push_back(zone == none ? none : number[at(zone)]);
    for (std::size_t z = 0; z < size(); ++z)
        if (at(up[z]) == z) out.parents.push_back(parents[z] == none ? none : number[at(parents[z])]);

    // The first pair of two zones has their lowest saddle.
    std::vector<std::tuple<std::int32_t, std::int32_t, std::size_t>> between;
    for (std::size_t p = 0; p < saddles.size(); ++p) {
        const auto [a, b] = std::minmax(number[at(pairs[2 * p])], number[at(pairs[2 * p + 1])]);
        if (a != b) between.emplace_back(a, b, p);
    }
    std::ranges::sort(between);
    const auto same_zones = [](const auto& x, const auto& y) {
        return std::get<0>(x) == std::get<0>(y) && std::get<1>(x) == std::get<1>(y);
    };
    between.erase(std::unique(between.begin(), between.end(), same_zones), between.end());
    std::ranges::sort(between, {}, [](const auto& x) { return std::get<2>(x); });
    for (const auto& [a, b, p] : between) {
        out.pairs.insert(out.pairs.end(), {a, b});
        out.passes.insert(out.passes.end(), {passes[2 * p], passes[2 * p + 1]});
        out.saddles.push_back(saddles[p]);
    }
    return out;
}

}  // namespace votess
