#include "follow/match_seeds.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "follow/kept_cell.hpp"

namespace votess::cpu {
namespace {

using Place = std::array<double, 3>;

constexpr std::size_t max_tried = 256, seeds_per_box = 4, next_rows = 4;
constexpr int max_steps = 64;       // from cell to cell
constexpr double near_share = 256;  // a point is near a seed if all others are 16 times as far

class SeedFinder {
public:
    explicit SeedFinder(const KeptSeeds& before)
        : before_(before),
          seed_of_(static_cast<std::size_t>(std::ranges::max(before.rows)) + 1, -1),
          table_(std::bit_ceil(2 * before.rows.size()), -1) {
        const std::size_t count = before.rows.size();
        boxes_ = static_cast<std::size_t>(std::cbrt(static_cast<double>(count) / seeds_per_box)) + 1;
        Place upper;
        lower_.fill(std::numeric_limits<double>::infinity());
        upper.fill(-std::numeric_limits<double>::infinity());
        for (std::size_t s = 0; s < count; ++s) {
            seed_of_[static_cast<std::size_t>(before.rows[s])] = static_cast<std::int32_t>(s);
            for (std::size_t k = 0; k < 3; ++k) {
                lower_[k] = std::min(lower_[k], before.frame.places[s].x[k]);
                upper[k] = std::max(upper[k], before.frame.places[s].x[k]);
            }
        }
        for (std::size_t k = 0; k < 3; ++k)
            per_length_[k] = upper[k] > lower_[k] ? static_cast<double>(boxes_) / (upper[k] - lower_[k]) : 0;
        some_.assign(boxes_ * boxes_ * boxes_, 0);
        for (std::size_t s = 0; s < count; ++s) {
            const double* const x = before.frame.places[s].x;
            some_[box({x[0], x[1], x[2]})] = static_cast<std::int32_t>(s);
            std::int32_t& same = seed_at({x[0], x[1], x[2]});
            if (same < 0) same = static_cast<std::int32_t>(s);
        }
    }

    struct Found {
        std::size_t seed;
        double away, other;  // squares of the distances of this seed and of the nearest other one that was met

        [[nodiscard]] bool is_near() const { return near_share * away < other; }  // `nothing` is not
    };
    // Looks among the seeds of rows from `row` on.
    [[nodiscard]] Found in_rows(std::size_t row, const Place& x) const {
        Found found = nothing;
        for (std::size_t r = row; r < std::min(row + next_rows, seed_of_.size()); ++r)
            if (seed_of_[r] >= 0) meet(static_cast<std::size_t>(seed_of_[r]), x, found);
        return found;
    }
    // Looks for a seed at the place: a walk may miss those whose cells lie beside them.
    [[nodiscard]] Found at(const Place& x) {
        const std::int32_t seed = seed_at(x);
        return seed < 0 ? nothing : Found{static_cast<std::size_t>(seed), 0, nothing.other};
    }
    // Walks to nearer cells, from the seed of `from` or one in the box of the place.
    [[nodiscard]] Found from(Found found, const Place& x) const {
        meet(static_cast<std::size_t>(some_[box(x)]), x, found);
        for (int step = 0; step < max_steps; ++step) {
            const std::size_t at = found.seed;
            if (before_.cells[at] == nullptr) {
                if (std::isinf(found.other)) found.other = 0;
                break;
            }
            found = {at, found.away, std::numeric_limits<double>::infinity()};
            for (const std::int32_t id : KeptCell(before_.cells[at]).ids())
                if (id >= 0) meet(static_cast<std::size_t>(id), x, found);
            if (found.seed == at) break;
        }
        return found;
    }
    static constexpr Found nothing{0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

private:
    [[nodiscard]] std::size_t box(const Place& x) const {
        std::size_t at = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double share = (x[k] - lower_[k]) * per_length_[k];  // not finite in the smallest boxes
            at = at * boxes_ +
                 (share > 0 ? static_cast<std::size_t>(std::min(share, static_cast<double>(boxes_ - 1))) : 0);
        }
        return at;
    }
    // Returns the entry of the seed at a place, -1 if there is none.
    [[nodiscard]] std::int32_t& seed_at(const Place& x) {
        std::uint64_t hash = 0;
        for (const double along : x)
            hash = (std::rotl(hash, 29) ^ std::bit_cast<std::uint64_t>(along)) * 0x9e3779b97f4a7c15ull;
        for (std::size_t at = hash >> 32;; ++at) {
            std::int32_t& seed = table_[at & (table_.size() - 1)];
            if (seed < 0) return seed;
            const double* const place = before_.frame.places[seed].x;
            if (std::equal(x.begin(), x.end(), place)) return seed;
        }
    }
    void meet(std::size_t seed, const Place& x, Found& found) const {
        const SeedPlace& place = before_.frame.places[seed];
        const auto [a, b, c] = nearest_way(before_.frame, place.x, x.data());
        const double away = a * a + b * b + c * c;
        if (away < found.away)
            found = {seed, away, found.away};
        else if (seed != found.seed)
            found.other = std::min(found.other, away);
    }

    const KeptSeeds& before_;
    std::vector<std::int32_t> seed_of_;  // by row, or -1
    std::vector<std::int32_t> table_;    // seeds by hashes of their places; open addressing
    std::size_t boxes_ = 1;              // of a grid, along each axis
    Place lower_, per_length_;
    std::vector<std::int32_t> some_;  // seed of each box; the first where there is none
};

}  // namespace

std::optional<MatchedSeeds> match_seeds(const KeptSeeds& before, std::span<const std::int32_t> rows, bool same_rows,
                                        const std::function<Place(std::size_t row)>& now) {
    const std::size_t count = rows.size();
    SeedFinder finder(before);
    const std::size_t sample = std::min(count, max_tried);
    std::size_t near = 0, same = 0;
    for (std::size_t k = 0; k < sample; ++k) {
        const auto row = static_cast<std::size_t>(rows[k * count / sample]);
        const Place x = now(row);
        SeedFinder::Found found = finder.at(x);
        if (!found.is_near()) found = finder.from(found, x);
        near += found.is_near() ? 1 : 0;
        same += static_cast<std::size_t>(before.rows[found.seed]) == row ? 1 : 0;
    }
    if (8 * near < 7 * sample) return std::nullopt;
    if (same_rows && 16 * (sample - same) < sample) return std::nullopt;

    // The nearest point of each seed is the seed. All others are new.
    std::vector<std::int32_t> point(before.rows.size(), -1);
    std::vector<double> away(before.rows.size());
    struct New {
        std::size_t beside;
        std::int32_t row;
        auto operator<=>(const New&) const = default;
    };
    std::vector<New> added;
    std::size_t next_row = 0;
    for (const std::int32_t row : rows) {
        const Place x = now(static_cast<std::size_t>(row));
        SeedFinder::Found found = finder.at(x);
        if (!found.is_near()) found = finder.in_rows(next_row, x);
        if (!found.is_near()) found = finder.from(found, x);
        next_row = static_cast<std::size_t>(before.rows[found.seed]) + 1;
        std::int32_t& nearest = point[found.seed];
        std::int32_t farther = row;
        if (nearest < 0 || found.away < away[found.seed]) {
            std::swap(nearest, farther);
            away[found.seed] = found.away;
            if (farther < 0) continue;
        }
        added.push_back({found.seed, farther});
    }
    std::ranges::sort(added);
    MatchedSeeds matched;
    matched.order.reserve(count);
    matched.number.assign(point.size(), -1);
    auto next = added.begin();
    for (std::size_t s = 0; s < point.size(); ++s) {
        if (point[s] >= 0) {
            matched.number[s] = static_cast<std::int32_t>(matched.order.size());
            matched.order.push_back(point[s]);
        }
        for (; next != added.end() && next->beside == s; ++next) matched.order.push_back(next->row);
    }
    return matched;
}

}  // namespace votess::cpu
