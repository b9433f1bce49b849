// One cell as it waits for the mesh: its vertices, and the polygons of its row, packed into bytes.
//
// Vertices are numbered in order of first use, by the faces in the order of their labels, walls included; each polygon
// begins with its edge to the face of least label. So records are facts of the diagram but for the last digits of
// positions, and where each edge of a face has three cells, as usual, the two cells of the face begin at the same edge.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace votess {

// What a row names a face by; rows are ordered by it.
struct FaceLabel {
    std::int32_t id = 0;  // of the neighbor, or a wall
    std::array<std::int8_t, 3> shift{};

    friend auto operator<=>(const FaceLabel&, const FaceLabel&) = default;
};

struct MeshCell {
    std::array<double, 3> origin{};         // absolute
    std::span<const double> positions;      // 3 for each vertex, from the origin
    std::span<const FaceLabel> beginnings;  // for each face: that of the face across its first edge
    std::span<const std::uint32_t> ends;    // for each face, of its corners
    std::span<const std::uint32_t> corners;
};

// Records of one thread.
class MeshBlock {
public:
    void append(const MeshCell& cell);
    // A cell without a record.
    void append_none() { begins_.push_back(none); }
    void clear() {
        bytes_.clear();
        begins_.clear();
    }

    static constexpr std::size_t none = ~std::size_t{0};
    [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
    [[nodiscard]] std::span<const std::size_t> begins() const { return begins_; }  // by cell, or none

private:
    std::vector<std::byte> bytes_;
    std::vector<std::size_t> begins_;
};

// A record, read in place. Without one: a cell that has nothing.
class MeshCellView {
public:
    explicit MeshCellView(const std::byte* record);

    [[nodiscard]] std::uint32_t vertices() const { return head_.vertices; }
    [[nodiscard]] std::uint32_t faces() const { return head_.faces; }
    [[nodiscard]] std::uint32_t corners() const { return head_.corners; }
    [[nodiscard]] const std::array<double, 3>& origin() const { return head_.origin; }
    [[nodiscard]] const double* position(std::uint32_t vertex) const { return positions_ + std::size_t{3} * vertex; }
    [[nodiscard]] const FaceLabel& beginning(std::size_t face) const { return beginnings_[face]; }
    [[nodiscard]] std::uint32_t begin(std::size_t face) const { return face == 0 ? 0 : number(face - 1); }
    [[nodiscard]] std::uint32_t end(std::size_t face) const { return number(face); }
    [[nodiscard]] std::uint32_t corner(std::size_t place) const { return number(head_.faces + place); }

private:
    friend class MeshBlock;
    struct Head {
        std::uint32_t vertices = 0, faces = 0, corners = 0;
        std::uint32_t wide = 0;  // numbers of 4 bytes instead of 2
        std::array<double, 3> origin{};
    };

    [[nodiscard]] std::uint32_t number(std::size_t place) const {
        return head_.wide != 0 ? wide_[place] : narrow_[place];
    }

    Head head_;
    const double* positions_ = nullptr;
    const FaceLabel* beginnings_ = nullptr;
    const std::uint16_t* narrow_ = nullptr;
    const std::uint32_t* wide_ = nullptr;
};

}  // namespace votess
