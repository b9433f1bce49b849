#include "polytope/cell_shape.hpp"

#include <algorithm>

#include "polytope/cell.hpp"

namespace votess::cpu {

bool CellShape::add_polygon(std::span<const std::uint8_t> around) {
    const std::size_t count = around.size();
    if (corners + static_cast<int>(count) - 2 > max_corners) return false;
    const auto least = static_cast<std::size_t>(
        std::ranges::min_element(around, {}, [this](std::uint8_t slot) { return rank[slot]; }) - around.begin());
    for (std::size_t k = 1; k + 1 < count; ++k)
        add_corner(around[least], around[(least + k) % count], around[(least + k + 1) % count]);
    return true;
}

namespace {

CellShape::Plane plane_of(const CellPlane& plane) {
    const auto& [x, y, z] = plane.n;
    if (plane.source.is_bisector()) return {{0.5 * x, 0.5 * y, 0.5 * z}, 0.25 * plane.source.power.high};
    const auto [u, v, w] = mirror_image(plane);
    // Both normals then point outward.
    if (plane.h < 0) return {{-0.5 * u, -0.5 * v, -0.5 * w}, -0.5 * (u * u + v * v + w * w)};
    return {{0.5 * u, 0.5 * v, 0.5 * w}, 0};
}

}  // namespace

bool ShapeReader::read(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, bool beyond,
                       CellShape& out) {
    if (faces.size() > CellShape::max_planes) return false;
    out.planes = out.slots = static_cast<int>(faces.size());
    out.corners = 0;
    out.exact = this;
    cell_ = &cell;
    all_.clear();
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const CellPlane& plane = cell.planes()[static_cast<std::size_t>(faces.planes[f])];
        if (beyond && plane.id < 0 && !plane.reliable) return false;
        out.rank[f] = static_cast<std::uint8_t>(ranks[f]);
        plane_[ranks[f]] = faces.planes[f];
        out.plane[ranks[f]] = plane_of(plane);
        const std::span corners = std::span(faces.corners)
                                      .subspan(static_cast<std::size_t>(faces.offsets[f]),
                                               static_cast<std::size_t>(faces.offsets[f + 1] - faces.offsets[f]));
        for (std::size_t k = 0; k < corners.size(); ++k)
            all_.push_back({corners[k], corners[k == 0 ? corners.size() - 1 : k - 1],
                            corners[k + 1 == corners.size() ? 0 : k + 1], static_cast<std::uint8_t>(f)});
    }
    std::ranges::sort(all_, {}, &FaceAtVertex::vertex);
    for (auto begin = all_.begin(), end = begin; begin != all_.end(); begin = end) {
        end = std::find_if(begin, all_.end(), [&](const FaceAtVertex& f) { return f.vertex != begin->vertex; });
        around_.clear();
        // The next face is the one across the edge.
        for (auto f = begin; around_.size() < static_cast<std::size_t>(end - begin);) {
            around_.push_back(f->face);
            f = std::find_if(begin, end, [&](const FaceAtVertex& g) { return g.from == f->to; });
            if (f == end) return false;
        }
        if (!out.add_polygon(around_)) return false;
    }
    return true;
}

std::array<double, 3> ShapeReader::corner(const std::array<unsigned, 3>& ranks) const {
    const auto source = [&](std::size_t k) -> const exact::Plane& {
        return cell_->planes()[static_cast<std::size_t>(plane_[ranks[k]])].source;
    };
    return exact::near_vertex(cell_->seed(), source(0), source(1), source(2));
}

}  // namespace votess::cpu
