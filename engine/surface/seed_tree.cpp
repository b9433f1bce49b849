#include "surface/seed_tree.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/at.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "index/sort.hpp"

namespace votess::surface {
namespace {

// Seeds around a group, whose distance is tried.
constexpr std::size_t min_listed = 32, max_listed = 192;
constexpr double first_distance = 1.0;  // in units of the longest side of the group's box
constexpr int max_tries = 40;

}  // namespace

SeedTree::SeedTree(std::span<const exact::Point> seeds, std::span<const double> weights, ThreadPool& pool)
    : kernels_(surface_kernels()) {
    check_stop();
    cpu::SeedSorter().sort(std::span(seeds[0].data(), 3 * seeds.size()), 1, 0, pool, seeds_);
    if (!weights.empty()) {
        // The first seed of each place is in the tree: the heaviest replaces it.
        std::vector<std::int32_t> heaviest(seeds.size());
        std::iota(heaviest.begin(), heaviest.end(), 0);
        for (std::size_t i = 0; i < seeds_.duplicate_of.size(); ++i)
            if (const std::int32_t first = seeds_.duplicate_of[i];
                first >= 0 && weights[i] > weights[at(heaviest[at(first)])])
                heaviest[at(first)] = static_cast<std::int32_t>(i);
        seeds_.weights.assign(seeds_.places(), 0);
        for (std::size_t k = 0; k < size(); ++k) {
            seeds_.input[k] = heaviest[at(seeds_.input[k])];
            seeds_.weights[k] = weights[at(seeds_.input[k])];
        }
    }
    hierarchy_.build(seeds_, pool);
}

const NearSeeds::Lists& NearSeeds::of_group(std::size_t index) const {
    std::atomic<const Lists*>& slot = of_group_[index];
    const Lists* lists = slot.load(std::memory_order_acquire);
    if (lists != nullptr) return *lists;
    std::unique_ptr<Lists> made = make(index);
    if (slot.compare_exchange_strong(lists, made.get(), std::memory_order_acq_rel)) return *made.release();
    return *lists;  // of another thread, equal
}

void NearSeeds::collect(const Box& box, double distance, std::vector<std::uint32_t>& found) const {
    found.clear();
    const double square = distance * distance;
    const auto skip = [&](const SeedTree::Node&) { return found.size() > max_listed; };
    tree_.visit(box, square, skip, [&](std::uint32_t k, std::uint32_t end) {
        for (; k < end; ++k)
            if (distance_squared(tree_.place(k), box) <= square) found.push_back(k);
    });
}

std::unique_ptr<NearSeeds::Lists> NearSeeds::make(std::size_t index) const {
    const auto longest = [](const Box& box) { return std::ranges::max(minus(box.upper, box.lower)); };
    const Box box = tree_.box({0, 0, static_cast<std::uint32_t>(index)});
    const auto first = static_cast<std::uint32_t>(group * index);
    const std::uint32_t end =
        std::min(first + static_cast<std::uint32_t>(group), static_cast<std::uint32_t>(tree_.size()));
    const std::size_t wanted = std::min(min_listed, tree_.size());
    double distance = first_distance * longest(box), low = 0, high = std::numeric_limits<double>::infinity();
    if (!(distance > 0)) distance = longest(tree_.box(tree_.root())) / std::sqrt(static_cast<double>(tree_.size()));
    std::vector<std::uint32_t> found;
    std::vector<std::uint64_t> near;
    found.reserve(max_listed + group);
    for (int tries = 0;; ++tries) {
        collect(box, distance, found);
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
    lists->begin.reserve(end - first + 1);
    lists->numbers.reserve((end - first) * found.size() / 2);
    for (std::uint32_t own = first; own < end; ++own) {
        lists->begin.push_back(static_cast<std::uint32_t>(lists->numbers.size()));
        near.resize(found.size());
        std::size_t count = 0;
        const exact::Point x = tree_.place(own);
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
