#include "surface/seed_tree.hpp"

#include <bit>
#include <cmath>
#include <limits>

#include "core/at.hpp"
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

SeedTree::SeedTree(std::span<const exact::Point> seeds, std::span<const double> weights) {
    std::vector<Item> items(seeds.size());
    for (std::size_t i = 0; i < seeds.size(); ++i) items[i] = {seeds[i], static_cast<std::int32_t>(i)};
    const auto weight = [&](const Item& item) { return weights.empty() ? 0 : weights[at(item.seed)]; };
    std::ranges::sort(items, [&](const Item& a, const Item& b) {
        for (std::size_t k = 0; k < 3; ++k)
            if (a.place[k] != b.place[k]) return a.place[k] < b.place[k];
        return weight(a) != weight(b) ? weight(a) > weight(b) : a.seed < b.seed;
    });
    items.erase(
        std::unique(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.place == b.place; }),
        items.end());
    nodes_.reserve(items.size());
    nodes_.push_back({{}, {}, 0, 0, static_cast<std::uint32_t>(items.size()), 0, 0});
    std::vector<std::uint32_t> pending{0};  // the last first, so that the nodes of a box follow each other in memory
    for (std::size_t count = 0; !pending.empty(); ++count) {
        if (count % 1024 == 0) check_stop();
        const std::uint32_t node = pending.back();
        pending.pop_back();
        split(node, items, weights);
        if (nodes_[node].child == 0) continue;
        pending.push_back(nodes_[node].child + 1);
        pending.push_back(nodes_[node].child);
    }
    order_.reserve(items.size());
    places_.reserve(items.size());
    for (const Item& item : items) {
        order_.push_back(item.seed);
        places_.push_back(item.place);
    }
    leaf_of_.resize(order_.size());
    for (std::uint32_t n = 0; n < nodes_.size(); ++n)
        if (nodes_[n].child == 0) std::fill(&leaf_of_[nodes_[n].begin], &leaf_of_[nodes_[n].end - 1] + 1, n);
}

// Finds the box of a node and, unless it is a leaf, makes its children.
void SeedTree::split(std::uint32_t node, std::span<Item> items, std::span<const double> weights) {
    const auto [begin, end] = std::pair(nodes_[node].begin, nodes_[node].end);
    const std::span<Item> own = items.subspan(begin, end - begin);
    exact::Point lower = own[0].place, upper = lower;
    for (const Item& item : own)
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = item.place[k] < lower[k] ? item.place[k] : lower[k];
            upper[k] = item.place[k] > upper[k] ? item.place[k] : upper[k];
        }
    double weight = weights.empty() ? 0 : weights[at(own[0].seed)];
    if (!weights.empty())
        for (const Item& item : own) weight = std::max(weight, weights[at(item.seed)]);
    nodes_[node] = {lower, upper, weight, begin, end, 0, 0};
    if (end - begin <= leaf_seeds) return;
    const Vector3 size = minus(upper, lower);
    const auto axis = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
    const std::uint32_t half = (end - begin) / 2;
    std::nth_element(own.begin(), own.begin() + half, own.end(), [&](const Item& a, const Item& b) {
        return a.place[axis] != b.place[axis] ? a.place[axis] < b.place[axis] : a.seed < b.seed;
    });
    nodes_[node].child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[node].axis = static_cast<std::uint32_t>(axis);
    nodes_.push_back({{}, {}, 0, begin, begin + half, 0, 0});
    nodes_.push_back({{}, {}, 0, begin + half, end, 0, 0});
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
