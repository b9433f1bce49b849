// Changes of the cells around five seeds or walls.
//
// A corner belongs to four seeds or walls. Between five of them there are two ways to place corners: two corners at the
// ends of an edge, or three around a triangle that two cells share. Where seeds move, diagrams change by such flips
// only, unless more happens at once. A flip keeps all cells matched, and each of them a closed surface: in two cells a
// corner becomes a triangle, or a triangle a corner, and in three an edge is turned.
//
// The choice is a guess in floating point. Flipped cells are tested as all others, so a wrong flip costs time only.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "follow/loose_cell.hpp"
#include "follow/sign_test.hpp"

namespace votess::cpu {

struct Flip {
    // Seeds, or walls below 0; a seed comes first. All differ.
    std::array<std::int32_t, 5> id;
    std::array<NearShift, 5> shift;  // of images, from the first; {} for walls
    // Bit k: the corner of all but the k-th exists. Its orientation is that of their order, reversed for odd k. The
    // others replace these; their orientations are the opposite.
    std::uint8_t old;

    bool joins;  // there are two old corners, not three

    // The two that gain or lose a common face.
    [[nodiscard]] bool is_end(std::size_t member) const { return ((old >> member & 1) != 0) == joins; }
    // Whether some sign that changes belongs to the cell of a member, see LooseCell::pack().
    [[nodiscard]] bool has_sign(std::size_t member) const {
        return std::ranges::count_if(id, [&](std::int32_t i) { return i >= 0 && i < id[member]; }) < 3;
    }
    // Changes the cell of a member. order: of sorted seeds in rows. Returns false if it does not have the old corners.
    [[nodiscard]] bool apply(std::size_t member, std::span<const std::int32_t> order, LooseCell& cell) const;
};

// Finds a flip that takes a corner of a seed's cell away from the plane of another of its faces, and makes the signs
// right. Returns false if there is none. cells: records by sorted seed, or null. signs: the planes of the cell.
[[nodiscard]] bool find_flip(std::span<std::byte* const> cells, std::size_t seed, const SignTest& signs,
                             const KeptCell::Corner& corner, std::size_t plane, Flip& out);

}  // namespace votess::cpu
