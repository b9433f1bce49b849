#include "index/buried_seeds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t near_seeds = 512;  // consecutive, so near each other
constexpr std::size_t task_groups = 64;
constexpr std::size_t sample_step = 16;  // seeds of a chunk that show whether it has buried ones
// The heaviest of a chunk, which may bury the others; four times as many in each further pass, which follows one that
// has removed most seeds.
constexpr std::size_t few_owners = 32;
constexpr double half_slack = 1 + 1e-6;     // as of covering radii
constexpr double place_rounding = 0x1p-50;  // of the largest coordinate, for both places of a difference
constexpr double rounding = 0x1p-48;        // of a sum, in its terms

struct Seed {
    double x[3], weight;
};

// A box that holds the cell of a seed, as seen from it: at first that of the domain along axes that do not repeat, and
// up to `half` on either side along others.
class CellBounds {
public:
    explicit CellBounds(const Domain& domain) : domain_(domain) {
        for (std::size_t k = 0; k < 3; ++k)
            half_[k] = half_slack * (domain.triclinic ? domain.covering_radius : 0.5 * std::abs(domain.vector[k][k]));
    }
    // size: bound on coordinates of seeds.
    void set_seed(const Seed& seed, double size) {
        seed_ = seed;
        error_ = 4 * place_rounding * size;
        slack_ = rounding * std::abs(seed.weight) + 3 * error_ * place_rounding * size;
        for (std::size_t k = 0; k < 3; ++k) {
            lower_[k] = domain_.periodic[k] ? -half_[k] : domain_.box.lower[k] - seed.x[k];
            upper_[k] = domain_.periodic[k] ? half_[k] : domain_.box.upper[k] - seed.x[k];
            side_[k] = std::max(std::abs(lower_[k]), std::abs(upper_[k]));
            slack_ += error_ * side_[k];
        }
    }
    // Cuts the box by the part of space that an owner q leaves to the cell. Returns whether nothing is left.
    //
    // With q = p + n that is 2 n.x <= |n|^2 + w_p - w_q. An error r of n changes it by at most r (2 |n| + 2 |x| + r)
    // along an axis.
    bool cut_by(const Seed& owner) {
        double left = seed_.weight - owner.weight + slack_, size = std::abs(owner.weight), widest = 0;
        std::array<double, 3> n;
        for (std::size_t k = 0; k < 3; ++k) {
            n[k] = owner.x[k] - seed_.x[k];
            const double square = n[k] * n[k], length = std::abs(n[k]);
            left += square - 2 * std::min(n[k] * lower_[k], n[k] * upper_[k]) + error_ * length;
            size += square + 2 * length * side_[k];
            widest = std::max(widest, 2 * length * (upper_[k] - lower_[k]));
        }
        left += rounding * size;  // by so much 2 n.x is at most above its least in the box
        if (!(left < widest)) return false;
        bool empty = left < 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double slack = rounding * side_[k];
            if (n[k] > 0)
                upper_[k] = std::min(upper_[k], lower_[k] + left / (2 * n[k]) + slack);
            else if (n[k] < 0)
                lower_[k] = std::max(lower_[k], upper_[k] + left / (2 * n[k]) - slack);
            empty |= lower_[k] > upper_[k];
        }
        return empty;
    }

private:
    const Domain& domain_;
    std::array<double, 3> half_{}, lower_{}, upper_{}, side_{};
    Seed seed_{};
    double error_ = 0, slack_ = 0;
};

// Returns the sorted seeds that some of the heaviest of their chunk bury, by chunk. owners: how many of these are
// tried.
std::vector<std::vector<std::size_t>> find_buried(const Domain& domain, ThreadPool& pool, const SortedSeeds& seeds,
                                                  std::size_t owners) {
    const std::size_t count = seeds.size(), chunks = ceil_div(count, near_seeds);
    std::vector<std::vector<std::size_t>> found(chunks);
    pool.run(ceil_div(chunks, task_groups), [&](std::size_t task, unsigned) {
        CellBounds bounds(domain);
        std::vector<Seed> near, heaviest;
        for (std::size_t c = task * task_groups; c < std::min(chunks, (task + 1) * task_groups); ++c) {
            check_stop();
            const std::size_t begin = c * near_seeds, end = std::min(count, begin + near_seeds);
            near.clear();
            double size = 0;
            for (std::size_t s = begin; s < end; ++s) {
                near.push_back(
                    {{seeds.x[s], seeds.y[s], seeds.z[s]}, domain.weights[static_cast<std::size_t>(seeds.input[s])]});
                for (const double x : near.back().x) size = std::max(size, std::abs(x));
            }
            const auto take_heaviest = [&](std::size_t most) {
                heaviest.resize(std::min(most, near.size()));
                std::ranges::partial_sort_copy(near, heaviest, std::ranges::greater(), &Seed::weight, &Seed::weight);
            };
            const auto is_buried = [&](const Seed& seed) {
                bounds.set_seed(seed, size);
                return std::ranges::any_of(heaviest, [&](const Seed& owner) { return bounds.cut_by(owner); });
            };
            take_heaviest(owners == few_owners ? 1 : owners);  // enough to show where none are buried
            bool any = false;
            for (std::size_t k = 0; k < near.size() && !any; k += sample_step) any = is_buried(near[k]);
            if (!any) continue;
            take_heaviest(owners);
            for (std::size_t k = 0; k < near.size(); ++k)
                if (is_buried(near[k])) found[c].push_back(begin + k);
        }
    });
    return found;
}

// Moves the input indices of seeds to `buried`.
void remove(const std::vector<std::vector<std::size_t>>& found, SortedSeeds& seeds, std::vector<std::int32_t>& buried) {
    std::size_t kept = 0, next = 0;  // of the seeds up to `next`
    const auto keep_until = [&](std::size_t end) {
        for (; next < end; ++next, ++kept) {
            if (kept == next) continue;
            seeds.input[kept] = seeds.input[next];
            for (auto* axis : {&seeds.x, &seeds.y, &seeds.z}) (*axis)[kept] = (*axis)[next];
        }
    };
    for (const auto& chunk : found)
        for (const std::size_t s : chunk) {
            keep_until(s);
            buried.push_back(seeds.input[next++]);
        }
    if (next == 0) return;
    keep_until(seeds.size());
    seeds.input.resize_uninitialized(kept);
    for (auto* axis : {&seeds.x, &seeds.y, &seeds.z}) {
        axis->resize_uninitialized(round_up(kept, group_size));
        std::fill(axis->begin() + kept, axis->end(), std::numeric_limits<double>::infinity());
    }
}

}  // namespace

void drop_buried(const Domain& domain, ThreadPool& pool, bool only_most, SortedSeeds& seeds,
                 std::vector<std::int32_t>& buried) {
    if (domain.has_cell_walls()) return;
    for (std::size_t owners = few_owners;; owners *= 4) {
        const std::size_t count = seeds.size();
        const auto found = find_buried(domain, pool, seeds, owners);
        std::size_t total = 0;
        for (const auto& chunk : found) total += chunk.size();
        if (only_most && owners == few_owners && 2 * total < count) return;
        remove(found, seeds, buried);
        if (2 * seeds.size() > count || owners == near_seeds) return;
    }
}

}  // namespace votess::cpu
