// A mesh of the plane is a set of closed rings of edges, with the domain on their left. In the sheet it is the prism
// over it. The caps lie far above and below the sheet, so that no cell meets them.
#pragma once

#include <cstdint>
#include <vector>

#include "votess/votess.hpp"

namespace votess {

class Prism {
public:
    // rings: vertices (V,2) and edges (E,2). height: of the caps above and below the plane.
    // Throws invalid_argument for edges that are not closed rings, or that turn clockwise on the whole.
    Prism(const TriangleMesh& rings, double height);

    // Returns vertices, V below and V above, and triangles: two for each edge, then the caps. Refers to the prism.
    [[nodiscard]] TriangleMesh view() const { return {vertices_, triangles_}; }

private:
    void add_sides();
    void add_caps();
    void add_cap(const std::vector<std::int32_t>& ring, std::size_t begin, std::size_t end);

    std::vector<std::int32_t> edges_;
    std::vector<double> vertices_;
    std::vector<std::int32_t> triangles_;
};

// The rings below a prism.
struct Rings {
    explicit Rings(const TriangleMesh& prism);
    [[nodiscard]] TriangleMesh view() const { return {vertices, edges}; }

    std::vector<double> vertices;
    std::vector<std::int32_t> edges;
};

}  // namespace votess
