#include "index/unwrapped.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

constexpr double relative_cell = 0.6;         // of the mean distance of seeds; uniform ones are connected then
constexpr double least_connected = 1.0 / 16;  // of the pairs of seeds
constexpr std::size_t least_gain = 2;         // factor of pairs of cells that are parted

// A grid over the domain, or over the part of it that seeds fill, of a few cells for each seed.
class PeriodicGrid {
public:
    PeriodicGrid(const SortedSeeds& seeds, const Domain& domain) : domain_(domain) {
        exact::Point lower, upper;
        lower.fill(std::numeric_limits<double>::infinity());
        for (std::size_t j = 0; j < 3; ++j) upper[j] = -lower[j];
        for_fractions(seeds, [&](std::size_t, const exact::Point& f) {
            for (std::size_t j = 0; j < 3; ++j)
                lower[j] = std::min(lower[j], f[j]), upper[j] = std::max(upper[j], f[j]);
        });
        exact::Point sides;  // along x, y and z, since fractions of far ends are rounded
        for (std::size_t j = 0; j < 3; ++j) {
            const Buffer<double>& axis = j == 0 ? seeds.x : j == 1 ? seeds.y : seeds.z;
            const auto [least, most] = std::minmax_element(axis.begin(), axis.begin() + seeds.size());
            sides[j] = *most - *least;
            if (domain.periodic[j]) lower[j] = 0, upper[j] = 1;
            lower_[j] = lower[j];
        }
        const double distance = mean_spacing(sides, static_cast<double>(seeds.size()));
        is_sheet_ = std::ranges::any_of(sides, [&](double side) { return side < distance; });
        const double spacing = relative_cell * distance;
        for (std::size_t j = 0; j < 3; ++j) {
            const double side = std::max(0.0, upper[j] - lower[j]),
                         most = std::min(static_cast<double>(seeds.size()), 0x1p20);
            const double cells = std::floor(side * domain.reduced.width[j] / spacing);
            size_[j] = spacing > 0 && cells > 1 ? static_cast<std::int64_t>(std::min(cells, most)) : 1;
            per_side_[j] = side > 0 ? static_cast<double>(size_[j]) / side : 0;
        }
        while (cells() > 8 * static_cast<std::int64_t>(seeds.size()) + 8)  // a sheet in a long domain
            for (std::size_t j = 0; j < 3; ++j) {
                per_side_[j] *=
                    static_cast<double>(ceil_div(size_[j], std::int64_t{2})) / static_cast<double>(size_[j]);
                size_[j] = ceil_div(size_[j], std::int64_t{2});
            }
        cell_of_.resize(seeds.size());
        count_.resize(static_cast<std::size_t>(cells()));
        sum_.resize(count_.size());
        for_fractions(seeds, [&](std::size_t s, const exact::Point& f) {
            std::int64_t cell = 0;
            for (std::size_t j = 0; j < 3; ++j) {
                const auto at = static_cast<std::int64_t>((f[j] - lower_[j]) * per_side_[j]);
                cell = cell * size_[j] + std::clamp<std::int64_t>(at, 0, size_[j] - 1);
            }
            cell_of_[s] = static_cast<std::int32_t>(cell);
            ++count_[static_cast<std::size_t>(cell)];
            for (std::size_t j = 0; j < 3; ++j) sum_[static_cast<std::size_t>(cell)][j] += f[j];
        });
    }

    // Numbers of reduced periods.
    using Steps = std::array<std::int32_t, 3>;
    // Joins neighboring cells, those first whose seeds are nearest to each other.
    bool unwrap() {
        if (is_sheet_) return false;
        struct Pair {
            double distance;
            std::int32_t from, to;
            Steps across;
        };
        std::vector<Pair> pairs;
        for (std::size_t c = 0; c < count_.size(); ++c) {
            if (c % 4096 == 0) check_stop();
            if (count_[c] == 0) continue;
            const auto from = static_cast<std::int32_t>(c);
            for_neighbors(from, [&](std::int32_t to, const Steps& across) {
                if (count_[static_cast<std::size_t>(to)] > 0)
                    pairs.push_back({distance(from, to, across), from, to, across});
            });
        }
        std::ranges::sort(pairs, {}, [](const Pair& p) { return std::tuple(p.distance, p.from, p.to, p.across); });
        check_stop();
        steps_.assign(count_.size(), {});
        parent_.resize(count_.size());
        std::iota(parent_.begin(), parent_.end(), 0);
        for (const Pair& pair : pairs) {
            const std::int32_t a = root_of(pair.from), b = root_of(pair.to);
            if (a == b) continue;
            parent_[static_cast<std::size_t>(b)] = a;
            for (std::size_t j = 0; j < 3; ++j)
                steps_[static_cast<std::size_t>(b)][j] = steps_[static_cast<std::size_t>(pair.from)][j] +
                                                         pair.across[j] - steps_[static_cast<std::size_t>(pair.to)][j];
        }
        std::vector<double> sizes(count_.size());  // of connected parts, by root
        for (std::size_t c = 0; c < count_.size(); ++c)
            sizes[static_cast<std::size_t>(root_of(static_cast<std::int32_t>(c)))] += count_[c];
        double connected = 0;
        for (const double size : sizes) connected += size * size;
        const auto seeds = static_cast<double>(cell_of_.size());
        if (!(connected >= least_connected * seeds * seeds)) return false;
        std::size_t parted = 0, parted_before = 0;
        for (const Pair& pair : pairs) {
            Steps apart;
            for (std::size_t j = 0; j < 3; ++j)
                apart[j] = steps_[static_cast<std::size_t>(pair.from)][j] + pair.across[j] -
                           steps_[static_cast<std::size_t>(pair.to)][j];
            parted += apart != Steps{} ? 1 : 0;
            parted_before += pair.across != Steps{} ? 1 : 0;
        }
        return parted_before > 0 && least_gain * parted <= parted_before;
    }
    [[nodiscard]] const Steps& steps_of(std::size_t seed) const {
        return steps_[static_cast<std::size_t>(cell_of_[seed])];
    }

private:
    template <class Visit>
    void for_fractions(const SortedSeeds& seeds, const Visit& visit) const {
        const exact::Point& o = domain_.origin;
        in_pieces(seeds.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s)
                visit(s, domain_.reduced.fraction({seeds.x[s] - o[0], seeds.y[s] - o[1], seeds.z[s] - o[2]}));
        });
    }
    // Returns the distance of the means of two cells.
    [[nodiscard]] double distance(std::int32_t from, std::int32_t to, const Steps& across) const {
        const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
        exact::Point way{};
        for (std::size_t j = 0; j < 3; ++j) {
            const double f = sum_[b][j] / count_[b] + across[j] - sum_[a][j] / count_[a];
            for (std::size_t k = 0; k < 3; ++k) way[k] += f * domain_.reduced.vector[j][k];
        }
        return length3(way[0], way[1], way[2]);
    }
    // Returns the cell that stands for all that have been joined to this one, and makes its steps count from there.
    std::int32_t root_of(std::int32_t cell) {
        std::vector<std::int32_t>& way = way_;
        way.clear();
        for (; parent_[static_cast<std::size_t>(cell)] != cell; cell = parent_[static_cast<std::size_t>(cell)])
            way.push_back(cell);
        if (!way.empty()) way.pop_back();  // a child of the root
        for (; !way.empty(); way.pop_back()) {
            const auto c = static_cast<std::size_t>(way.back());
            const auto above = static_cast<std::size_t>(parent_[c]);
            for (std::size_t j = 0; j < 3; ++j) steps_[c][j] += steps_[above][j];
            parent_[c] = cell;
        }
        return cell;
    }
    [[nodiscard]] std::int64_t cells() const { return size_[0] * size_[1] * size_[2]; }
    // Calls visit(cell, periods that lie between) for the cells around a cell.
    template <class Visit>
    void for_neighbors(std::int32_t cell, const Visit& visit) const {
        const std::array<std::int64_t, 3> at{cell / (size_[1] * size_[2]), cell / size_[2] % size_[1], cell % size_[2]};
        for (int step = 0; step < 27; ++step) {
            const std::array<int, 3> by{step / 9 - 1, step / 3 % 3 - 1, step % 3 - 1};
            std::int64_t next = 0;
            Steps across{};
            bool inside = step != 13;
            for (std::size_t j = 0; j < 3; ++j) {
                std::int64_t x = at[j] + by[j];
                if (x < 0 || x >= size_[j]) {
                    inside = inside && domain_.periodic[j];
                    across[j] = by[j];
                    x -= by[j] * size_[j];
                }
                next = next * size_[j] + x;
            }
            if (inside) visit(static_cast<std::int32_t>(next), across);
        }
    }

    const Domain& domain_;
    bool is_sheet_ = false;  // whose seeds are not connected in such cells
    exact::Point lower_{}, per_side_{};
    std::array<std::int64_t, 3> size_{};
    std::vector<std::int32_t> cell_of_;  // by seed
    // By cell.
    std::vector<std::int32_t> count_;
    std::vector<exact::Point> sum_;  // of the fractions of its seeds
    std::vector<std::int32_t> parent_;
    std::vector<Steps> steps_;  // from the parent
    std::vector<std::int32_t> way_;
};

}  // namespace

std::optional<Unwrapped> unwrap(const SortedSeeds& seeds, ThreadPool& pool) {
    const SeedImages& images = *seeds.images;
    const Domain& domain = images.domain();
    PeriodicGrid grid(seeds, domain);
    if (!grid.unwrap()) return {};
    std::optional<Unwrapped> out(std::in_place);
    const std::size_t count = seeds.size(), places = round_up(count, group_size);
    out->shifts.resize(count);
    for (auto* axis : {&out->seeds.x, &out->seeds.y, &out->seeds.z}) {
        axis->resize_uninitialized(places);
        std::fill(axis->begin() + count, axis->end(), std::numeric_limits<double>::infinity());
    }
    out->seeds.input.resize_uninitialized(count);
    exact::Point largest{};
    in_pieces(count, [&](std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            ShiftRange steps;
            for (std::size_t j = 0; j < 3; ++j) steps.lower[j] = grid.steps_of(s)[j];
            out->shifts[s] = only_shift(domain, steps);
            const exact::Point at = images.place(s, out->shifts[s]);
            out->seeds.input[s] = seeds.input[s];
            out->seeds.x[s] = at[0], out->seeds.y[s] = at[1], out->seeds.z[s] = at[2];
            for (std::size_t k = 0; k < 3; ++k) largest[k] = std::max(largest[k], std::abs(at[k]));
        }
    });
    for (std::size_t k = 0; k < 3; ++k) out->rounding[k] = 0x1p-51 * largest[k];  // of two places
    out->hierarchy.build(out->seeds, pool);
    return out;
}

}  // namespace votess::cpu
