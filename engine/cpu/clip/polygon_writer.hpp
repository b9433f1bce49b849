// Brings the polygons of a cell to the form of records: see mesh_record.hpp. One per thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "cpu/clip/cell_polygons.hpp"
#include "mesh/mesh_record.hpp"

namespace votess::cpu {

class PolygonWriter {
public:
    // labels: by face; order: all faces by label, of which the first `hidden` are walls that rows do not list.
    void append(const CellPolygons& polygons, std::span<const FaceLabel> labels, std::span<const std::uint32_t> order,
                std::size_t hidden, const std::array<double, 3>& origin);
    void append_none() { block_.append_none(); }
    void clear() { block_.clear(); }
    [[nodiscard]] const MeshBlock& block() const { return block_; }

private:
    MeshBlock block_;
    std::vector<std::uint32_t> rank_;    // by face
    std::vector<std::uint32_t> number_;  // by vertex of the polygons, or none
    std::vector<double> positions_;
    std::vector<FaceLabel> labels_;
    std::vector<std::uint32_t> beginnings_, ends_, corners_;
};

}  // namespace votess::cpu
