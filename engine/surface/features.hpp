// Edges of a surface that vertices of its remesh lie on: borders, sharp edges, those of more than two triangles.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>
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
    struct Gap {
        std::size_t piece;
        std::array<double, 3> place;  // where a vertex would close it, in the part
        bool is_near;                 // the part's vertex is on no feature: it may move to the place
        bool is_corner, is_border;
    };
    // Returns where triangles may miss a feature in a connected part: a corner that is no vertex, or a line that the
    // part's vertex is not on. A part with a vertex on one sharp edge may hold others, or further corners near by;
    // those of borders are gaps. vertices: by part.
    [[nodiscard]] std::vector<Gap> gaps(const SurfaceCells& cells, const std::vector<double>& vertices) const;

private:
    enum class Corner : std::uint8_t { none, sharp, of_border };
    // Returns the corner of features at a corner of a polygon, or -1.
    [[nodiscard]] std::int32_t corner_at(const SurfaceCells& cells, std::size_t polygon, std::size_t c) const;
    // Calls use(piece, from, to, triangles at the edge) for the sides of polygons on features.
    template <class Use>
    void each_stretch(const SurfaceCells& cells, const Use& use) const;
    struct Stretch {
        std::size_t piece;
        std::int32_t from, to;  // vertices of cells
        bool is_border;
        auto operator<=>(const Stretch&) const = default;
    };
    static void add_gaps(std::span<const Stretch> stretches, const SurfaceCells& cells,
                         const std::array<double, 3>& vertex, double enough, std::vector<Gap>& gaps);

    std::vector<std::int32_t> triangles_;   // as given
    std::vector<std::int32_t> edge_of_;     // 3 for each triangle, from its corners; -1 for one without area
    std::vector<std::int32_t> counts_;      // triangles, by edge
    std::vector<std::uint8_t> is_feature_;  // by edge
    std::vector<Corner> corners_;           // by vertex of the surface
};

}  // namespace votess::surface
