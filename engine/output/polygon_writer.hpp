// Converts the polygons of a cell to records, see mesh_record.hpp. One for each thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesh/mesh_record.hpp"
#include "polytope/cell_polygons.hpp"

namespace votess::cpu {

class PolygonWriter {
public:
    // Numbers of CellPolygons::shared get a new meaning from here on.
    void begin_stretch() {
        group_ = block_.begin_group();
        in_block_.clear();
    }
    // labels: by face; order: all faces by label. The first `hidden` of them are walls that rows do not list.
    void append(const CellPolygons& polygons, std::span<const FaceLabel> labels, std::span<const std::uint32_t> order,
                std::size_t hidden, const std::array<double, 3>& origin);
    void append_none() { block_.append_none(); }
    void clear() {
        block_.clear();
        begin_stretch();
    }
    [[nodiscard]] const MeshBlock& block() const { return block_; }

private:
    MeshBlock block_;
    std::uint32_t group_ = 0;
    std::vector<std::uint32_t> in_block_;  // by shared number: the vertex of the block, or none
    std::vector<std::uint32_t> number_;    // by vertex of the polygons, or none
    std::vector<FaceLabel> hidden_labels_;
    std::vector<std::uint32_t> vertices_, first_across_, ends_, corners_;
};

}  // namespace votess::cpu
