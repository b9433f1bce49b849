#include "polytope/cell_polygons.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/vector3.hpp"
#include "polytope/cell.hpp"

namespace votess::cpu {
namespace {

// Lengthens subnormal vectors first, because their length would be rounded to few bits.
std::array<double, 3> unit_vector(const std::array<double, 3>& n) {
    const double length = length3(n[0], n[1], n[2]);
    if (length < 0x1p-900) return unit_vector({n[0] * 0x1p500, n[1] * 0x1p500, n[2] * 0x1p500});
    return {n[0] / length, n[1] / length, n[2] / length};
}

}  // namespace

std::array<double, 3> unit_normal(const exact::Point& p, const exact::Plane& plane) {
    using Kind = exact::Plane::Kind;
    std::array<double, 3> n{};
    switch (plane.kind) {
        case Kind::bisector: {
            const auto d = exact::differences(p, plane).x;
            return unit_vector({d[0].high, d[1].high, d[2].high});
        }
        case Kind::wall:
            return unit_vector(plane.seed);
        case Kind::cell_wall:
            return unit_vector(plane.rounded_normal());
        case Kind::lower_wall:
            n[static_cast<std::size_t>(plane.axis)] = -1;
            return n;
        case Kind::upper_wall:
            n[static_cast<std::size_t>(plane.axis)] = 1;
            return n;
    }
    return n;
}

void read_polygons(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, CellPolygons& out) {
    out.clear();
    for (int slot = 0; slot < cell.slots(); ++slot) out.positions.push_back(cell.position(slot));
    out.offsets.assign(faces.offsets.begin(), faces.offsets.end());
    out.corners.assign(faces.corners.begin(), faces.corners.end());
    std::vector<std::uint32_t> beside(out.corners.size());  // the rank of the face across the edge from the corner
    // An edge occurs twice, once in each direction. Sorting by the ends brings both together.
    struct End {
        std::uint32_t low, high, face, place;
    };
    std::vector<End> ends;
    ends.reserve(out.corners.size());
    for (std::size_t f = 0; f < faces.size(); ++f)
        for (std::uint32_t k = out.offsets[f]; k < out.offsets[f + 1]; ++k) {
            const std::uint32_t v = out.corners[k],
                                w = out.corners[k + 1 == out.offsets[f + 1] ? out.offsets[f] : k + 1];
            ends.push_back({std::min(v, w), std::max(v, w), static_cast<std::uint32_t>(f), k});
        }
    std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
        return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
    });
    for (std::size_t e = 0; e + 1 < ends.size(); e += 2) {
        beside[ends[e].place] = ranks[ends[e + 1].face];
        beside[ends[e + 1].place] = ranks[ends[e].face];
    }
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto begin = static_cast<std::ptrdiff_t>(out.offsets[f]),
                   end = static_cast<std::ptrdiff_t>(out.offsets[f + 1]);
        const auto first = std::min_element(beside.begin() + begin, beside.begin() + end);
        out.first_across.push_back(*first);
        std::rotate(out.corners.begin() + begin, out.corners.begin() + (first - beside.begin()),
                    out.corners.begin() + end);
    }
}

}  // namespace votess::cpu
