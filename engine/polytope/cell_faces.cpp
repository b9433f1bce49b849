// The canonical faces of a cell: equal corners become one, and faces that they leave without area go.
#include <algorithm>
#include <bit>

#include "polytope/cell.hpp"

namespace votess::cpu {

bool Cell::same_position(int v, int w, int shared_edge) {
    const double reach = tolerance_[v] + tolerance_[w];
    if (std::abs(x_[v] - x_[w]) > reach || std::abs(y_[v] - y_[w]) > reach || std::abs(z_[v] - z_[w]) > reach)
        return false;
    // Both lie on the line of the shared planes a, b; they coincide when v lies on the third plane of w.
    const std::int32_t a = corners_[v].plane[shared_edge],
                       b = corners_[v].plane[shared_edge == 2 ? 0 : shared_edge + 1];
    for (std::int32_t third : corners_[w].plane) {
        if (third == a || third == b) continue;
        const auto& [p0, p1, p2] = corners_[v].plane;
        used_exact_ = true;
        return exact::side_of_vertex(seed_, planes_[p0].source, planes_[p1].source, planes_[p2].source,
                                     planes_[third].source) == 0;
    }
    return false;
}

void Cell::merge_equal_corners() {
    merged_.resize(slots_);
    for (int v = 0; v < slots_; ++v) merged_[v] = v;
    if (!met_tie_) return;
    auto root = [this](int v) {
        while (merged_[v] != v) v = merged_[v] = merged_[merged_[v]];
        return v;
    };
    for_each_alive([&](int v) {
        for (int k = 0; k < 3; ++k) {
            const int w = corners_[v].next[k];
            if (w > v && same_position(v, w, k)) merged_[root(v)] = root(w);
        }
    });
    for (int v = 0; v < slots_; ++v) merged_[v] = root(v);
}

void Cell::canonical_faces(CellFaces& out) {
    merge_equal_corners();
    out.planes.clear();
    out.corners.clear();
    out.offsets.assign(1, 0);
    out.vertex_count = 0;
    start_.assign(planes_.size(), -1);
    for_each_alive([&](int v) {
        for (std::int32_t p : corners_[v].plane) start_[p] = v;
        if (merged_[v] == v) ++out.vertex_count;
    });
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const std::int32_t first = start_[p];
        if (first < 0) continue;
        const auto begin = out.corners.size();
        int v = first;
        do {
            const Corner& corner = corners_[v];
            const int k = corner.plane[0] == static_cast<std::int32_t>(p)
                              ? 0
                              : (corner.plane[1] == static_cast<std::int32_t>(p) ? 1 : 2);
            const std::int32_t representative = merged_[v];
            if (out.corners.size() == begin || out.corners.back() != representative)
                out.corners.push_back(representative);
            v = corner.next[k == 0 ? 2 : k - 1];
        } while (v != first);
        while (out.corners.size() > begin + 1 && out.corners.back() == out.corners[begin]) out.corners.pop_back();
        if (out.corners.size() < begin + 3) {
            out.corners.resize(begin);
            continue;
        }
        out.planes.push_back(static_cast<std::int32_t>(p));
        out.offsets.push_back(static_cast<std::int32_t>(out.corners.size()));
    }
    out.edge_count = static_cast<std::uint32_t>(out.corners.size() / 2);
}

void Cell::face_planes(std::vector<std::int32_t>& out) {
    out.clear();
    start_.assign(planes_.size(), -1);
    for_each_alive([&](int v) {
        for (std::int32_t p : corners_[v].plane) {
            if (start_[p] < 0) out.push_back(p);
            start_[p] = v;
        }
    });
}

}  // namespace votess::cpu
