// Seeds that travel between blocks or ranks, as the user gave them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "core/bytes.hpp"

namespace votess {

struct Seeds {
    std::vector<std::int64_t> ids;   // N, unique among all seeds of the run
    std::vector<double> points;      // (N, 3)
    std::vector<double> weights;     // N in a power diagram, else empty
    std::vector<std::int32_t> tags;  // N, see Block; or empty: all 0

    [[nodiscard]] std::size_t size() const { return ids.size(); }
    // Adds seed i of arrays.
    void add(std::int64_t id, std::span<const double> all_points, std::span<const double> all_weights, std::size_t i) {
        ids.push_back(id);
        points.insert(points.end(), &all_points[3 * i], &all_points[3 * i] + 3);
        if (!all_weights.empty()) weights.push_back(all_weights[i]);
    }
    void add(const Seeds& from, std::size_t i) {
        add(from.ids[i], from.points, from.weights, i);
        if (!from.tags.empty()) tags.push_back(from.tags[i]);
    }
    void add(const Seeds& all) {
        ids.insert(ids.end(), all.ids.begin(), all.ids.end());
        points.insert(points.end(), all.points.begin(), all.points.end());
        weights.insert(weights.end(), all.weights.begin(), all.weights.end());
        tags.insert(tags.end(), all.tags.begin(), all.tags.end());
    }
    void reserve(std::size_t count) {
        ids.reserve(count);
        points.reserve(3 * count);
        if (!weights.empty()) weights.reserve(count);
        if (!tags.empty()) tags.reserve(count);
    }
    // Returns the seeds ascending by id, each once.
    [[nodiscard]] Seeds sorted() const {
        std::vector<std::uint32_t> order(size());
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::sort(order, {}, [this](std::uint32_t i) { return ids[i]; });
        Seeds out;
        for (const std::uint32_t i : order)
            if (out.ids.empty() || out.ids.back() != ids[i]) out.add(*this, i);
        return out;
    }

    void put_to(Writer& writer) const {
        writer.pack(ids);
        writer.pack(points);
        writer.pack(weights);
        writer.pack(tags);
    }
    void get_from(Reader& reader) {
        reader.unpack(ids, reader.left());  // each takes a byte or more
        reader.unpack(points, 3 * ids.size());
        reader.unpack(weights, ids.size());
        reader.unpack(tags, ids.size());
    }
};

// Returns the place of an id among ascending ones, or their number where it is not there.
inline std::size_t place_of(std::int64_t id, std::span<const std::int64_t> ids) {
    const auto at = std::ranges::lower_bound(ids, id);
    return at != ids.end() && *at == id ? static_cast<std::size_t>(at - ids.begin()) : ids.size();
}

}  // namespace votess
