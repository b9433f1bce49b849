#include "core/convex_piece.hpp"

#include <algorithm>
#include <cmath>

namespace votess {

void ConvexPiece::clear() {
    corners_.clear();
    ends_.clear();
}

void ConvexPiece::add_polygon(std::span<const Vector> corners) {
    corners_.insert(corners_.end(), corners.begin(), corners.end());
    ends_.push_back(corners_.size());
}

void ConvexPiece::add_box(const Vector& lower, const Vector& upper) {
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        std::array<Vector, 4> low{lower, lower, lower, lower};
        low[1][i] = low[2][i] = upper[i];
        low[2][j] = low[3][j] = upper[j];
        std::array<Vector, 4> high = low;
        for (Vector& corner : high) corner[k] = upper[k];
        std::ranges::reverse(low);
        add_polygon(low);
        add_polygon(high);
    }
}

bool ConvexPiece::cut(const Vector& n, double h) {
    outside_.resize(corners_.size());
    bool any_outside = false, any_inside = false;
    for (std::size_t c = 0; c < corners_.size(); ++c) {
        outside_[c] = dot(n, corners_[c]) - h;
        any_outside |= outside_[c] > 0;
        any_inside |= outside_[c] < 0;
    }
    if (!any_outside) return !empty();
    kept_corners_.clear();
    kept_ends_.clear();
    rim_.clear();
    for (std::size_t f = 0, begin = 0; f < ends_.size() && any_inside; begin = ends_[f++]) {
        const std::size_t before = kept_corners_.size(), end = ends_[f];
        for (std::size_t c = begin; c < end; ++c) {
            const std::size_t next = c + 1 == end ? begin : c + 1;
            if (outside_[c] <= 0) kept_corners_.push_back(corners_[c]);
            if (outside_[c] == 0) rim_.push_back(corners_[c]);
            if ((outside_[c] > 0) == (outside_[next] > 0) || outside_[c] == 0 || outside_[next] == 0) continue;
            // From the same end whichever way the edge goes: both of its faces get the same corner.
            const std::size_t in = outside_[c] < 0 ? c : next, out = outside_[c] < 0 ? next : c;
            const double share = outside_[in] / (outside_[in] - outside_[out]);
            Vector at;
            for (std::size_t k = 0; k < 3; ++k) at[k] = corners_[in][k] + share * (corners_[out][k] - corners_[in][k]);
            kept_corners_.push_back(at);
            rim_.push_back(at);
        }
        if (kept_corners_.size() < before + 3)
            kept_corners_.resize(before);
        else
            kept_ends_.push_back(kept_corners_.size());
    }
    corners_.swap(kept_corners_);
    ends_.swap(kept_ends_);
    if (!empty()) close(n);
    return !empty();
}

// The new face: the corners of the rim, which is convex, by their angles around its middle.
void ConvexPiece::close(const Vector& n) {
    Vector middle{};
    for (const Vector& x : rim_)
        for (std::size_t k = 0; k < 3; ++k) middle[k] += x[k] / static_cast<double>(rim_.size());
    const auto largest =
        static_cast<std::size_t>(std::ranges::max_element(n, {}, [](double c) { return std::abs(c); }) - n.begin());
    Vector along{};
    along[(largest + 1) % 3] = n[largest];
    along[largest] = -n[(largest + 1) % 3];
    const Vector up = cross(n, along);
    const double along_size = std::sqrt(dot(along, along)), up_size = std::sqrt(dot(up, up));
    angles_.clear();
    for (std::uint32_t i = 0; i < rim_.size(); ++i) {
        const Vector from = minus(rim_[i], middle);
        angles_.emplace_back(std::atan2(dot(from, up) / up_size, dot(from, along) / along_size), i);
    }
    std::ranges::sort(angles_);
    const std::size_t begin = corners_.size();
    for (const auto& [angle, i] : angles_)
        if (corners_.size() == begin || corners_.back() != rim_[i]) corners_.push_back(rim_[i]);
    if (corners_.size() < begin + 3)
        corners_.resize(begin);
    else
        ends_.push_back(corners_.size());
}

// Sums over tetrahedra from a corner, which keeps what cancels small.
ConvexPiece::Measure ConvexPiece::measure() const {
    Measure sum;
    if (empty()) return sum;
    const Vector apex = corners_.front();
    for (std::size_t f = 0; f < polygons(); ++f) {
        const auto corners = polygon(f);
        const Vector a = minus(corners[0], apex);
        for (std::size_t c = 1; c + 1 < corners.size(); ++c) {
            const Vector b = minus(corners[c], apex), d = minus(corners[c + 1], apex);
            const double volume = dot(a, cross(b, d)) / 6;
            sum.volume += volume;
            for (std::size_t k = 0; k < 3; ++k) sum.moment[k] += volume * (a[k] + b[k] + d[k]) / 4;
        }
    }
    for (std::size_t k = 0; k < 3; ++k) sum.moment[k] += sum.volume * apex[k];
    return sum;
}

}  // namespace votess
