// One cell as it waits for the mesh: its vertices, and the polygons of its row, packed into bytes.
//
// Vertices are numbered in order of first use, by the faces in the order of their labels, walls included. Each polygon
// begins with its edge to the face of least label. So records depend on the diagram alone, except the last digits of
// positions. Where each edge of a face has three cells, the two cells of the face begin at the same edge.
//
// Cells of a group share the vertices that the walk handed from one to the other. Other vertices are stored once for
// each group, and for each cell without a group. Vertices are stored beside the records, since they are freed earlier.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "result/rows.hpp"

namespace votess {

struct MeshCell {
    std::array<double, 3> origin{};           // absolute
    std::uint32_t group = 0;                  // from MeshBlock::begin_group(), or 0: shares no vertex
    std::span<const std::uint32_t> vertices;  // from MeshBlock::add_vertex()
    std::span<const FaceLabel> hidden;        // of walls that have no place in the row
    std::span<const std::uint32_t>
        first_across;                     // for each face of the row: that across its first edge, the hidden first
    std::span<const std::uint32_t> ends;  // for each face of the row, of its corners
    std::span<const std::uint32_t> corners;
};

// Records of one thread.
class MeshBlock {
public:
    [[nodiscard]] std::uint32_t begin_group() { return ++groups_; }
    // Where a vertex lies, absolute.
    [[nodiscard]] std::uint32_t add_vertex(const std::array<double, 3>& at) {
        positions_.insert(positions_.end(), at.begin(), at.end());
        return static_cast<std::uint32_t>(positions_.size() / 3 - 1);
    }
    void append(const MeshCell& cell);
    // A cell without a record.
    void append_none() { begins_.push_back(none); }
    void clear() {
        begins_.clear();
        positions_.clear();
        vertices_.clear();
        used_ = groups_ = 0;
    }

    static constexpr std::size_t none = ~std::size_t{0};
    [[nodiscard]] std::span<const std::byte> bytes() const { return std::span(bytes_).first(used_); }
    [[nodiscard]] std::span<const std::size_t> begins() const { return begins_; }  // by cell, or none
    [[nodiscard]] std::span<const double> positions() const { return positions_; }
    // Those of the cells, one cell after the other.
    [[nodiscard]] std::span<const std::uint32_t> vertices() const { return vertices_; }

private:
    std::vector<std::byte> bytes_;  // filled up to used_
    std::vector<std::size_t> begins_;
    std::vector<double> positions_;
    std::vector<std::uint32_t> vertices_;
    std::size_t used_ = 0;
    std::uint32_t groups_ = 0;
};

// A record, read in place; null stands for a cell that has nothing.
class MeshCellView {
public:
    explicit MeshCellView(const std::byte* record);

    [[nodiscard]] std::uint32_t vertices() const { return head_.vertices; }
    [[nodiscard]] std::uint32_t faces() const { return head_.faces; }  // of the row
    [[nodiscard]] std::uint32_t corners() const { return head_.corners; }
    [[nodiscard]] const std::array<double, 3>& origin() const { return head_.origin; }
    // The block of the record, as set_block() has noted.
    [[nodiscard]] std::uint32_t block() const { return head_.block; }
    static void set_block(std::byte* record, std::uint32_t block);
    // Whether two cells have their vertices in common.
    [[nodiscard]] static bool share(const MeshCellView& a, const std::byte* b);

    // The place of the cell's first vertex in MeshBlock::vertices().
    [[nodiscard]] std::uint32_t first() const { return head_.first; }
    // These are the faces that have no place in the row.
    [[nodiscard]] std::uint32_t hidden() const { return head_.hidden; }
    [[nodiscard]] const FaceLabel& hidden_label(std::size_t k) const { return labels_[k]; }
    // The face across the first edge of a face: hidden ones count first, then those of the row.
    [[nodiscard]] std::uint32_t beginning(std::size_t face) const { return number(face); }
    [[nodiscard]] std::uint32_t begin(std::size_t face) const { return face == 0 ? 0 : end(face - 1); }
    [[nodiscard]] std::uint32_t end(std::size_t face) const { return number(head_.faces + face); }
    [[nodiscard]] std::uint32_t corner(std::size_t place) const { return number(std::size_t{2} * head_.faces + place); }

private:
    friend class MeshBlock;
    struct Head {
        std::array<double, 3> origin{};
        std::uint32_t vertices = 0, faces = 0, hidden = 0, corners = 0;
        std::uint32_t block = 0, group = 0, first = 0;
        std::uint32_t number_size = 1;  // bytes: 1, 2 or 4
    };

    [[nodiscard]] std::uint32_t number(std::size_t place) const {
        if (head_.number_size == 1) return std::to_integer<std::uint32_t>(numbers_[place]);
        if (head_.number_size == 2) return reinterpret_cast<const std::uint16_t*>(numbers_)[place];
        return reinterpret_cast<const std::uint32_t*>(numbers_)[place];
    }

    Head head_;
    const FaceLabel* labels_ = nullptr;
    const std::byte* numbers_ = nullptr;
};

}  // namespace votess
