#include "surface/seed_tree.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/progress.hpp"
#include "core/vector3.hpp"

namespace votess::surface {
namespace {

constexpr std::uint32_t leaf_seeds = 8;
// Seeds around a leaf, whose distance is tried.
constexpr std::size_t min_listed = 32, max_listed = 192;
constexpr double first_distance = 1.0;  // in units of the leaf's longest side
constexpr int max_tries = 40;

}  // namespace

SeedTree::SeedTree(std::span<const exact::Point> seeds, std::span<const double> weights) : order_(seeds.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    const auto seed = [&](std::int32_t i) -> const exact::Point& { return seeds[static_cast<std::size_t>(i)]; };
    const auto weight = [&](std::int32_t i) { return weights.empty() ? 0 : weights[static_cast<std::size_t>(i)]; };
    std::ranges::sort(order_, [&](std::int32_t i, std::int32_t j) {
        if (seed(i) != seed(j)) return seed(i) < seed(j);
        return weight(i) != weight(j) ? weight(i) > weight(j) : i < j;
    });
    order_.erase(
        std::unique(order_.begin(), order_.end(), [&](std::int32_t i, std::int32_t j) { return seed(i) == seed(j); }),
        order_.end());
    nodes_.push_back({{}, {}, 0, 0, static_cast<std::uint32_t>(order_.size()), 0});
    for (std::uint32_t at = 0; at < nodes_.size(); ++at) {
        if (at % 1024 == 0) check_stop();
        split(at, seeds, weights);
    }
    places_.reserve(order_.size());
    for (const std::int32_t id : order_) places_.push_back(seeds[static_cast<std::size_t>(id)]);
    leaf_of_.resize(order_.size());
    for (std::uint32_t at = 0; at < nodes_.size(); ++at)
        if (nodes_[at].child == 0) std::fill(&leaf_of_[nodes_[at].begin], &leaf_of_[nodes_[at].end - 1] + 1, at);
}

// Finds the box of a node and, unless it is a leaf, makes its children.
void SeedTree::split(std::uint32_t at, std::span<const exact::Point> seeds, std::span<const double> weights) {
    const auto seed = [&](std::int32_t i) -> const exact::Point& { return seeds[static_cast<std::size_t>(i)]; };
    const auto [begin, end] = std::pair(nodes_[at].begin, nodes_[at].end);
    exact::Point lower = seed(order_[begin]), upper = lower;
    double weight = weights.empty() ? 0 : weights[static_cast<std::size_t>(order_[begin])];
    for (std::uint32_t i = begin; i < end; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], seed(order_[i])[k]);
            upper[k] = std::max(upper[k], seed(order_[i])[k]);
        }
        if (!weights.empty()) weight = std::max(weight, weights[static_cast<std::size_t>(order_[i])]);
    }
    nodes_[at] = {lower, upper, weight, begin, end, 0};
    if (end - begin <= leaf_seeds) return;
    const Vector3 size = minus(upper, lower);
    const auto axis = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                     [&](std::int32_t i, std::int32_t j) {
                         return seed(i)[axis] != seed(j)[axis] ? seed(i)[axis] < seed(j)[axis] : i < j;
                     });
    nodes_[at].child = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{}, {}, 0, begin, half, 0});
    nodes_.push_back({{}, {}, 0, half, end, 0});
}

const NearSeeds::Lists& NearSeeds::of_leaf(const SeedTree::Node& leaf) const {
    std::atomic<const Lists*>& slot = of_leaf_[static_cast<std::size_t>(&leaf - tree_.nodes().data())];
    const Lists* lists = slot.load(std::memory_order_acquire);
    if (lists != nullptr) return *lists;
    std::unique_ptr<Lists> made = make(leaf);
    if (slot.compare_exchange_strong(lists, made.get(), std::memory_order_acq_rel)) return *made.release();
    return *lists;  // of another thread, equal
}

void NearSeeds::collect(const SeedTree::Node& leaf, double distance, std::vector<std::uint32_t>& found) const {
    found.clear();
    const double square = distance * distance;
    const auto is_near = [&](const exact::Point& lower, const exact::Point& upper) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double gap = std::max({0.0, lower[k] - leaf.upper[k], leaf.lower[k] - upper[k]});
            sum += gap * gap;
        }
        return sum <= square;
    };
    std::array<std::uint32_t, 160> pending;
    pending[0] = 0;
    for (std::size_t count = 1; count > 0 && found.size() <= max_listed;) {
        const SeedTree::Node& node = tree_.nodes()[pending[--count]];
        if (!is_near(node.lower, node.upper)) continue;
        if (node.child == 0) {
            for (std::uint32_t k = node.begin; k < node.end; ++k)
                if (is_near(tree_.place(k), tree_.place(k))) found.push_back(k);
        } else {
            pending[count++] = node.child + 1;
            pending[count++] = node.child;
        }
    }
}

std::unique_ptr<NearSeeds::Lists> NearSeeds::make(const SeedTree::Node& leaf) const {
    const auto longest = [](const SeedTree::Node& node) { return std::ranges::max(minus(node.upper, node.lower)); };
    const std::size_t wanted = std::min(min_listed, tree_.size());
    double distance = first_distance * longest(leaf), low = 0, high = std::numeric_limits<double>::infinity();
    if (!(distance > 0)) distance = longest(tree_.nodes()[0]) / std::sqrt(static_cast<double>(tree_.size()));
    std::vector<std::uint32_t> found;
    std::vector<std::uint64_t> near;
    found.reserve(max_listed + leaf_seeds);
    for (int tries = 0;; ++tries) {
        collect(leaf, distance, found);
        const bool is_last = tries == max_tries;
        if (found.size() > max_listed) {
            high = distance;
            if (is_last) found.clear(), distance = 0;
        } else if (found.size() < wanted) {
            low = distance;
        } else {
            break;
        }
        if (is_last) break;
        distance = std::isinf(high) ? 2 * low : low == 0 ? high / 4 : 0.5 * (low + high);
    }
    auto lists = std::make_unique<Lists>();
    const double square = distance * distance;
    lists->complete = square * (1 - 0x1p-40);
    lists->begin.reserve(leaf.end - leaf.begin + 1);
    lists->numbers.reserve((leaf.end - leaf.begin) * found.size() / 2);
    for (std::uint32_t own = leaf.begin; own < leaf.end; ++own) {
        lists->begin.push_back(static_cast<std::uint32_t>(lists->numbers.size()));
        near.resize(found.size());
        std::size_t count = 0;
        const exact::Point& x = tree_.place(own);
        for (const std::uint32_t k : found) {
            const Vector3 d = minus(tree_.place(k), x);
            const double far = dot(d, d);
            near[count] = std::uint64_t{std::bit_cast<std::uint32_t>(static_cast<float>(far))} << 32 | k;
            count += far <= square && k != own ? 1 : 0;
        }
        std::sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count));
        for (std::size_t i = 0; i < count; ++i) lists->numbers.push_back(static_cast<std::uint32_t>(near[i]));
    }
    lists->begin.push_back(static_cast<std::uint32_t>(lists->numbers.size()));
    return lists;
}

}  // namespace votess::surface
