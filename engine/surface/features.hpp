// Edges of a surface that vertices of its remesh lie on: borders, sharp edges, those of more than two triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "solid/closed_mesh.hpp"
#include "votess/surface.hpp"

namespace votess::surface {

class Features {
public:
    // sharp: degrees.
    Features(const solid::MeshArrays& mesh, double sharp);

    // Moves places, one for each connected part of the cells, to a corner in the part, or to the middle of the features
    // in it if these are long enough.
    void attract(const SurfaceCells& cells, std::vector<std::array<double, 3>>& places) const;
    // Returns whether more than two triangles meet at the edge of the surface from a corner of a triangle.
    [[nodiscard]] bool is_crowded(std::size_t triangle, std::size_t corner) const {
        const std::int32_t edge = edge_of_[3 * triangle + corner];
        return edge >= 0 && counts_[static_cast<std::size_t>(edge)] > 2;
    }

private:
    std::vector<std::int32_t> edge_of_;     // 3 for each triangle, from its corners; -1 for one without area
    std::vector<std::int32_t> counts_;      // triangles, by edge
    std::vector<std::uint8_t> is_feature_;  // by edge
    std::vector<std::uint8_t> is_corner_;   // by vertex of the surface
};

}  // namespace votess::surface
