// A kept cell while it is made or changed: arrays with room.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "follow/kept_cell.hpp"
#include "follow/sign_test.hpp"
#include "polytope/cell_shape.hpp"

namespace votess::cpu {

using NearShift = KeptCell::NearShift;

inline double determinant(const double* a, const double* b, const double* c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// Scratch: the edges of a cell from corner to corner, by ordered pair of planes.
class CornerEdges {
public:
    struct Edge {
        bool exists;
        std::uint8_t corner, third;  // the corner that it leaves, and the other plane there; any if it does not exist
    };
    void begin() {
        if (++now_ == 0) edges_ = {}, now_ = 1;
    }
    // Adds an edge that leaves the corner, counterclockwise between the planes a and b. Returns false if there was one.
    bool add(std::uint32_t a, std::uint32_t b, std::uint32_t corner, std::uint32_t third) {
        std::uint32_t& edge = edges_[a * CellShape::max_planes + b];
        const bool first = edge >> 16 != now_;
        edge = std::uint32_t{now_} << 16 | corner << 8 | third;
        return first;
    }
    [[nodiscard]] Edge find(std::uint32_t a, std::uint32_t b) const {
        const std::uint32_t edge = edges_[a * CellShape::max_planes + b];
        return {edge >> 16 == now_, static_cast<std::uint8_t>(edge >> 8), static_cast<std::uint8_t>(edge)};
    }

private:
    std::array<std::uint32_t, CellShape::max_planes * CellShape::max_planes> edges_{};  // of, corner, third
    std::uint16_t now_ = 0;
};

struct LooseCell {
    static constexpr std::size_t max_bytes =
        sizeof(KeptCell::Head) + 8 * CellShape::max_planes + 3 * CellShape::max_corners + 2 * SignTest::max_tests + 8;

    std::size_t faces = 0, corners = 0, used = 0, tests = 0, planes = 0;
    bool tied = false;
    std::array<std::int32_t, CellShape::max_planes> id;  // in the order of the row, as the other arrays
    std::array<NearShift, CellShape::max_planes> shift;
    std::array<KeptCell::Corner, CellShape::max_corners> corner;
    // What the cell tests, see KeptCell; pack() finds it.
    std::array<KeptCell::Test, SignTest::max_tests> test;
    std::array<std::uint8_t, CellShape::max_planes + 1> plane;

    void read(const KeptCell& cell);
    // Returns the face, or `faces`.
    [[nodiscard]] std::size_t find(std::int32_t of, const NearShift& by) const;
    void insert_face(std::size_t at, std::int32_t of, const NearShift& by);
    // Returns false if some corner is in the face.
    [[nodiscard]] bool remove_face(std::size_t at);
    template <class Number>
    void renumber(const Number& number);
    // Puts the faces in the order of a row. order: of sorted seeds in rows.
    void sort_faces(std::span<const std::int32_t> order);
    // Finds the signs of a seed's cell; each belongs to the lowest seed around it. A cell whose corners do not join to
    // a closed surface becomes tied.
    void find_tests(std::size_t seed, CornerEdges& edges);
    // Writes a record and returns its size, a multiple of 8. room: least bytes of the storage.
    std::size_t pack(std::size_t room, std::span<std::byte> to) const;
    std::size_t pack(std::size_t seed, CornerEdges& edges, std::size_t room, std::span<std::byte> to) {
        find_tests(seed, edges);
        return pack(room, to);
    }
};

}  // namespace votess::cpu
