// Seeds that travel between blocks, as the user gave them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace votess::blocks {

struct Seeds {
    std::vector<std::int64_t> ids;   // N, each seed of the run has one of its own
    std::vector<double> points;      // 3N
    std::vector<double> weights;     // N in a power diagram, else empty
    std::vector<std::int32_t> tags;  // N, see votess::Block; none: all 0

    [[nodiscard]] std::size_t size() const { return ids.size(); }
    void add(const Seeds& from, std::size_t i) {
        ids.push_back(from.ids[i]);
        points.insert(points.end(), from.points.begin() + static_cast<std::ptrdiff_t>(3 * i),
                      from.points.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
        if (!from.weights.empty()) weights.push_back(from.weights[i]);
        if (!from.tags.empty()) tags.push_back(from.tags[i]);
    }
    void add(const Seeds& all) {
        ids.insert(ids.end(), all.ids.begin(), all.ids.end());
        points.insert(points.end(), all.points.begin(), all.points.end());
        weights.insert(weights.end(), all.weights.begin(), all.weights.end());
        tags.insert(tags.end(), all.tags.begin(), all.tags.end());
    }
    // Room for so many, and no more.
    void reserve(std::size_t count) {
        ids.reserve(count);
        points.reserve(3 * count);
        if (!weights.empty()) weights.reserve(count);
        if (!tags.empty()) tags.reserve(count);
    }
    // Ascending by id, each once.
    [[nodiscard]] Seeds sorted() const {
        std::vector<std::uint32_t> order(size());
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::sort(order, {}, [this](std::uint32_t i) { return ids[i]; });
        Seeds out;
        for (const std::uint32_t i : order)
            if (out.ids.empty() || out.ids.back() != ids[i]) out.add(*this, i);
        return out;
    }
};

}  // namespace votess::blocks
