// A stretch of the sorted seeds whose cells are built by one thread. Cells of the stretch hand the Voronoi vertices
// that they have found to the other cells that share them, so each vertex is computed once.
//
// Vertices refer to cells by local ids: walls 0..5, the seeds of the stretch, then other seeds as they are met.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cpu/sort.hpp"

namespace votess::cpu {

// Cells 1, 2, 3 meet cell 0 in faces whose outward normals are positively oriented.
struct SharedVertex {
    std::array<std::int32_t, 4> cells;
};
struct Four {
    double x[4];
};
struct VertexPosition {
    Four at;  // x, y, z relative to the seed of cell 0, and (|na||nb||nc| / det)^2 |x|^2, which bounds the error
};

// A vertex of a cell, and which of the vertex's cells that is.
struct KnownVertex {
    std::uint32_t packed;
    [[nodiscard]] std::uint32_t vertex() const { return packed >> 2; }
    [[nodiscard]] unsigned corner() const { return packed & 3; }
};

class Neighborhood {
public:
    static constexpr int walls = 6;

    void begin(const SortedSeeds& seeds, std::size_t first, std::size_t last, bool positions);

    [[nodiscard]] std::size_t first() const { return first_; }
    [[nodiscard]] std::size_t last() const { return last_; }
    [[nodiscard]] bool holds(std::int64_t seed) const {
        return seed >= static_cast<std::int64_t>(first_) && seed < static_cast<std::int64_t>(last_);
    }
    // id: a sorted seed, or a wall -1..-6.
    [[nodiscard]] std::int32_t local(std::int32_t id) {
        if (id < 0) return -1 - id;
        if (holds(id)) return walls + id - static_cast<std::int32_t>(first_);
        return foreign(id);
    }
    [[nodiscard]] std::int32_t id(std::int32_t local) const {
        if (local < walls) return -1 - local;
        if (local < own_end_) return static_cast<std::int32_t>(first_) + local - walls;
        return foreign_ids_[local - own_end_];
    }
    [[nodiscard]] std::int32_t locals() const { return own_end_ + static_cast<std::int32_t>(foreign_ids_.size()); }
    [[nodiscard]] bool own(std::int32_t local) const { return local >= walls && local < own_end_; }

    // Whether a cell of the stretch has handed over all of its vertices.
    [[nodiscard]] bool done(std::size_t seed) const { return done_[seed - first_] != 0; }
    void set_done(std::size_t seed);
    [[nodiscard]] bool group_done(std::size_t group) const {
        const std::size_t begin = group * group_size;
        return begin >= first_ && begin + group_size <= last_ && group_done_[(begin - first_) / group_size] == group_size;
    }

    // Stores a vertex found by cells[0] and hands it to the other cells of the stretch.
    void add(const SharedVertex& vertex, const VertexPosition& position) {
        const std::uint32_t index = vertex_count_++;
        if (index == vertices_.size()) {
            vertices_.resize(2 * vertices_.size() + 16 * group_size);
            if (keep_positions_) positions_.resize(vertices_.size());
        }
        vertices_[index] = vertex;
        if (keep_positions_) positions_[index] = position;
        for (std::uint32_t k = 1; k < 4; ++k) {
            const std::int32_t cell = vertex.cells[k];
            const auto s = static_cast<std::size_t>((own(cell) ? cell : own_end_) - walls);
            const KnownVertex known{index << 2 | k};
            const unsigned count = known_count_[s]++;
            known_[s * primary + count % primary] = count < primary ? known : known_[s * primary + count % primary];
            if (count >= primary && own(cell)) spill(s, known);
        }
        known_count_[own_end_ - walls] = 0;
    }
    [[nodiscard]] const SharedVertex& vertex(std::uint32_t index) const { return vertices_[index]; }
    [[nodiscard]] const VertexPosition& position(std::uint32_t index) const { return positions_[index]; }
    // Coordinates of a seed of the stretch, when positions are kept.
    [[nodiscard]] const Four& seed(std::int32_t local) const { return seeds_[local - walls]; }
    // Calls visit(KnownVertex) for every vertex that was handed to a seed of the stretch.
    template <class Visit>
    void for_each_known(std::size_t seed, Visit visit) const {
        const std::size_t s = seed - first_;
        const unsigned count = known_count_[s];
        for (unsigned k = 0; k < std::min(count, primary); ++k) visit(known_[s * primary + k]);
        if (count > primary)
            for (std::int32_t node = spilled_[s]; node >= 0; node = spill_[node].next) visit(spill_[node].vertex);
    }

private:
    static constexpr unsigned primary = 32;  // vertices of a cell before they spill into a linked list
    struct Spill {
        KnownVertex vertex;
        std::int32_t next;
    };

    std::int32_t foreign(std::int32_t id);
    void grow_table();
    void spill(std::size_t s, KnownVertex vertex);

    std::size_t first_ = 0, last_ = 0;
    std::int32_t own_end_ = walls;
    bool keep_positions_ = false;
    std::vector<std::int32_t> foreign_ids_;
    std::vector<std::int32_t> table_;  // open addressing: index into foreign_ids_, or -1
    std::uint32_t vertex_count_ = 0;
    std::vector<SharedVertex> vertices_;
    std::vector<VertexPosition> positions_;
    std::vector<Four> seeds_;
    std::vector<KnownVertex> known_;
    std::vector<std::uint16_t> known_count_;
    std::vector<std::int32_t> spilled_;
    std::vector<Spill> spill_;
    std::vector<std::uint8_t> done_, group_done_;
};

}  // namespace votess::cpu
