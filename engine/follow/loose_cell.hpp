// A kept cell while it is made or changed: arrays with room.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "follow/kept_cell.hpp"
#include "follow/sign_test.hpp"
#include "polytope/cell_shape.hpp"

namespace votess::cpu {

using NearShift = KeptCell::NearShift;

// Scratch. By ordered pair of planes: a corner that has one after the other; undefined for pairs without an edge.
using CornerOfEdge = std::array<std::array<std::uint8_t, CellShape::max_planes>, CellShape::max_planes>;

struct LooseCell {
    static constexpr std::size_t most_bytes = sizeof(KeptCell::Head) + 7 * CellShape::max_planes +
                                              3 * CellShape::max_corners + 2 * SignTest::max_tests + 8;

    std::size_t faces = 0, corners = 0;
    bool tied = false;
    std::array<std::int32_t, CellShape::max_planes> id;  // in the order of the row, as the other arrays
    std::array<NearShift, CellShape::max_planes> shift;
    std::array<KeptCell::Corner, CellShape::max_corners> corner;

    void read(const KeptCell& cell);
    // Returns the face, or `faces`.
    [[nodiscard]] std::size_t find(std::int32_t of, const NearShift& by) const;
    void insert_face(std::size_t at, std::int32_t of, const NearShift& by);
    void remove_face(std::size_t at);
    // Writes a record and returns its size, a multiple of 8. seed: of the cell; a sign belongs to the lowest seed around
    // it. A cell whose corners do not join to a closed surface becomes tied. room: least bytes of the storage.
    std::size_t pack(std::size_t seed, CornerOfEdge& corner_of, std::size_t room, std::span<std::byte> to) const;
};

}  // namespace votess::cpu
