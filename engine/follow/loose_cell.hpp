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
    void begin() {
        if (++now_ == 0) edges_ = {}, now_ = 1;
    }
    // An edge that leaves the corner, counterclockwise between the planes a and b; third: its other plane. Returns
    // false if there is one on these planes.
    bool add(std::size_t a, std::size_t b, std::size_t corner, std::uint8_t third) {
        Edge& edge = edges_[a][b];
        const bool first = edge.of != now_;
        edge = {now_, static_cast<std::uint8_t>(corner), third};
        return first;
    }
    [[nodiscard]] bool has(std::size_t a, std::size_t b) const { return edges_[a][b].of == now_; }
    // Returns the corner that has this edge, and its other plane. The edge must exist.
    [[nodiscard]] std::pair<std::size_t, std::uint8_t> end(std::size_t a, std::size_t b) const {
        return {edges_[a][b].corner, edges_[a][b].third};
    }

private:
    struct Edge {
        std::uint16_t of;
        std::uint8_t corner, third;
    };
    std::array<std::array<Edge, CellShape::max_planes>, CellShape::max_planes> edges_{};
    std::uint16_t now_ = 0;
};

struct LooseCell {
    static constexpr std::size_t most_bytes =
        sizeof(KeptCell::Head) + 7 * CellShape::max_planes + 3 * CellShape::max_corners + 2 * SignTest::max_tests + 8;

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
    // Writes a record and returns its size, a multiple of 8. seed: of the cell; a sign belongs to the lowest seed
    // around it. A cell whose corners do not join to a closed surface becomes tied. room: least bytes of the storage.
    std::size_t pack(std::size_t seed, CornerEdges& edges, std::size_t room, std::span<std::byte> to) const;
};

}  // namespace votess::cpu
