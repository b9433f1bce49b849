// One cell as it waits for the mesh: its vertices, and the polygons of its row, packed into bytes.
//
// Vertices are numbered in order of first use, by the faces in the order of their labels, walls included; each polygon
// begins with its edge to the face of least label. So records are facts of the diagram but for the last digits of
// positions, and where each edge of a face has three cells, as usual, the two cells of the face begin at the same edge.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "result/rows.hpp"

namespace votess {

struct MeshCell {
    std::array<double, 3> origin{};             // absolute
    std::span<const double> positions;          // 3 for each vertex, from the origin
    std::span<const FaceLabel> labels;          // of all faces, ascending
    std::size_t hidden = 0;                     // so many of them, walls, have no place in the row: they come first
    std::span<const std::uint32_t> beginnings;  // for each other face: the label across its first edge
    std::span<const std::uint32_t> ends;        // for each other face, of its corners
    std::span<const std::uint32_t> corners;
};

// Records of one thread.
class MeshBlock {
public:
    void append(const MeshCell& cell);
    // A cell without a record.
    void append_none() { begins_.push_back(none); }
    void clear() {
        begins_.clear();
        used_ = vertices_ = 0;
    }

    static constexpr std::size_t none = ~std::size_t{0};
    [[nodiscard]] std::span<const std::byte> bytes() const { return std::span(bytes_).first(used_); }
    [[nodiscard]] std::span<const std::size_t> begins() const { return begins_; }  // by cell, or none
    [[nodiscard]] std::size_t vertices() const { return vertices_; }               // of all cells

private:
    std::vector<std::byte> bytes_;  // filled up to used_
    std::vector<std::size_t> begins_;
    std::size_t used_ = 0, vertices_ = 0;
};

// A record, read in place; null stands for a cell that has nothing.
class MeshCellView {
public:
    explicit MeshCellView(const std::byte* record);

    [[nodiscard]] std::uint32_t vertices() const { return head_.vertices; }
    [[nodiscard]] std::uint32_t faces() const { return head_.faces; }  // of the row
    [[nodiscard]] std::uint32_t corners() const { return head_.corners; }
    [[nodiscard]] const std::array<double, 3>& origin() const { return head_.origin; }
    // What set_first() has noted: the number of the cell's first vertex among those of all records.
    [[nodiscard]] std::uint32_t first() const { return head_.first; }
    static void set_first(std::byte* record, std::uint32_t first);

    [[nodiscard]] const double* position(std::uint32_t vertex) const { return positions_ + std::size_t{3} * vertex; }
    [[nodiscard]] const FaceLabel& label(std::size_t face) const { return labels_[head_.hidden + face]; }
    // The face with that label, or faces().
    [[nodiscard]] std::size_t find(const FaceLabel& label) const;
    [[nodiscard]] const FaceLabel& beginning(std::size_t face) const { return labels_[number(face)]; }
    [[nodiscard]] std::uint32_t begin(std::size_t face) const { return face == 0 ? 0 : end(face - 1); }
    [[nodiscard]] std::uint32_t end(std::size_t face) const { return number(head_.faces + face); }
    [[nodiscard]] std::uint32_t corner(std::size_t place) const { return number(std::size_t{2} * head_.faces + place); }

private:
    friend class MeshBlock;
    struct Head {
        std::uint32_t vertices = 0, faces = 0, hidden = 0, corners = 0, first = 0;
        std::uint32_t wide = 0;  // numbers of 4 bytes instead of 2
        std::array<double, 3> origin{};
    };

    [[nodiscard]] std::uint32_t number(std::size_t place) const {
        return head_.wide != 0 ? wide_[place] : narrow_[place];
    }

    Head head_;
    const double* positions_ = nullptr;
    const FaceLabel* labels_ = nullptr;
    const std::uint16_t* narrow_ = nullptr;
    const std::uint32_t* wide_ = nullptr;
};

}  // namespace votess
