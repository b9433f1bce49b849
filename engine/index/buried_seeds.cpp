#include "index/buried_seeds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t chunk_seeds = 1024;  // consecutive, so near each other
constexpr std::size_t task_chunks = 32;
constexpr std::size_t sample_step = 32;     // seeds of a chunk that show whether it has buried ones
constexpr std::size_t owners = 32;          // the heaviest of a chunk, which may bury the others
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
        double bound = seed_.weight - owner.weight + slack_, size = std::abs(owner.weight), sum = 0;
        std::array<double, 3> n, least;  // of 2 n.x along each axis
        for (std::size_t k = 0; k < 3; ++k) {
            n[k] = owner.x[k] - seed_.x[k];
            const double square = n[k] * n[k], length = std::abs(n[k]);
            bound += square + error_ * length;
            size += square + 2 * length * side_[k];
            least[k] = 2 * std::min(n[k] * lower_[k], n[k] * upper_[k]);
            sum += least[k];
        }
        bound += rounding * size;
        bool empty = bound < sum;
        for (std::size_t k = 0; k < 3; ++k) {
            if (n[k] == 0) continue;
            const double at = (bound - (sum - least[k])) / (2 * n[k]), slack = rounding * std::abs(at);
            if (n[k] > 0)
                upper_[k] = std::min(upper_[k], at + slack);
            else
                lower_[k] = std::max(lower_[k], at - slack);
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

}  // namespace

void drop_buried(const Domain& domain, ThreadPool& pool, SortedSeeds& seeds, std::vector<std::int32_t>& buried) {
    if (domain.has_cell_walls()) return;
    const std::size_t count = seeds.size(), chunks = ceil_div(count, chunk_seeds);
    const auto seed_at = [&](std::size_t s) {
        return Seed{{seeds.x[s], seeds.y[s], seeds.z[s]}, domain.weights[static_cast<std::size_t>(seeds.input[s])]};
    };
    std::vector<std::vector<std::int32_t>> found(chunks);  // sorted seeds
    pool.run(ceil_div(chunks, task_chunks), [&](std::size_t task, unsigned) {
        CellBounds bounds(domain);
        std::vector<Seed> near, heaviest;
        for (std::size_t c = task * task_chunks; c < std::min(chunks, (task + 1) * task_chunks); ++c) {
            check_stop();
            const std::size_t begin = c * chunk_seeds, end = std::min(count, begin + chunk_seeds);
            near.clear();
            for (std::size_t s = begin; s < end; ++s) near.push_back(seed_at(s));
            const auto heavier = [](const Seed& a, const Seed& b) { return a.weight > b.weight; };
            heaviest.assign(1, *std::ranges::min_element(near, heavier));
            double size = 0;
            for (const Seed& seed : near)
                for (const double x : seed.x) size = std::max(size, std::abs(x));
            const auto is_buried = [&](const Seed& seed) {
                bounds.set_seed(seed, size);
                return std::ranges::any_of(heaviest, [&](const Seed& owner) { return bounds.cut_by(owner); });
            };
            bool any = false;
            for (std::size_t k = 0; k < near.size() && !any; k += sample_step) any = is_buried(near[k]);
            if (!any) continue;
            heaviest.resize(std::min(owners, near.size()));
            std::ranges::partial_sort_copy(near, heaviest, heavier);
            for (std::size_t k = 0; k < near.size(); ++k)
                if (is_buried(near[k])) found[c].push_back(static_cast<std::int32_t>(begin + k));
        }
    });
    const std::size_t dropped =
        std::accumulate(found.begin(), found.end(), std::size_t{0}, [](auto n, const auto& f) { return n + f.size(); });
    if (dropped == 0) return;
    buried.reserve(buried.size() + dropped);
    std::size_t kept = 0;
    for (std::size_t c = 0; c < chunks; ++c) {
        auto next = found[c].begin();
        for (std::size_t s = c * chunk_seeds; s < std::min(count, (c + 1) * chunk_seeds); ++s) {
            if (next != found[c].end() && static_cast<std::size_t>(*next) == s) {
                buried.push_back(seeds.input[s]);
                ++next;
                continue;
            }
            seeds.input[kept] = seeds.input[s];
            for (auto* axis : {&seeds.x, &seeds.y, &seeds.z}) (*axis)[kept] = (*axis)[s];
            ++kept;
        }
    }
    seeds.input.resize_uninitialized(kept);
    for (auto* axis : {&seeds.x, &seeds.y, &seeds.z}) {
        axis->resize_uninitialized(round_up(kept, group_size));
        std::fill(axis->begin() + kept, axis->end(), std::numeric_limits<double>::infinity());
    }
}

}  // namespace votess::cpu
