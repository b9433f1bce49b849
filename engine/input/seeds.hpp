// Seeds that travel between blocks or ranks, as the user gave them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "core/bytes.hpp"
#include "core/scrambled.hpp"

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
    void drop_last() {
        ids.pop_back();
        points.resize(3 * ids.size());
        if (!weights.empty()) weights.pop_back();
        if (!tags.empty()) tags.pop_back();
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

// Finds seeds by their ids.
class SeedIndex {
public:
    // ids: of all seeds that are there; they must outlive this object. more: how many seeds will be added.
    explicit SeedIndex(const std::vector<std::int64_t>& ids, std::size_t more = 0) : ids_(ids) {
        std::size_t slots = 16;
        while (slots < 2 * (ids.size() + more)) slots *= 2;
        slots_.assign(slots, -1);
        for (std::size_t i = 0; i < ids.size(); ++i) add(i);
    }
    // Adds a seed by its number. Returns false if the id is there.
    bool add(std::size_t number) {
        std::int32_t& slot = slots_[slot_of(ids_[number])];
        if (slot >= 0) return false;
        slot = static_cast<std::int32_t>(number);
        return true;
    }
    // Returns the number of the seed, or -1.
    [[nodiscard]] std::int32_t find(std::int64_t id) const { return slots_[slot_of(id)]; }

private:
    // Returns where the seed is, or the free place for it.
    [[nodiscard]] std::size_t slot_of(std::int64_t id) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = scrambled(static_cast<std::uint64_t>(id)) & mask;
        while (slots_[slot] >= 0 && ids_[static_cast<std::size_t>(slots_[slot])] != id) slot = (slot + 1) & mask;
        return slot;
    }

    const std::vector<std::int64_t>& ids_;
    std::vector<std::int32_t> slots_;
};

}  // namespace votess
