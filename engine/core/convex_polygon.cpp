#include "core/convex_polygon.hpp"

#include <algorithm>

namespace votess {

std::pair<double, double> ConvexPolygon::extent(const Vector3& n) const {
    double least = dot(n, corners.front()), largest = least;
    for (const Vector3& corner : corners) {
        const double x = dot(n, corner);
        least = std::min(least, x);
        largest = std::max(largest, x);
    }
    return {least, largest};
}

void ConvexPolygon::split(const Vector3& n, double h, ConvexPolygon& below) {
    beyond_.clear();
    for (const Vector3& corner : corners) beyond_.push_back(dot(n, corner) - h);
    below.corners.clear();
    const auto farthest = std::ranges::max_element(beyond_);
    if (!(*farthest > 0)) {
        std::swap(corners, below.corners);
        return;
    }
    if (!(std::ranges::min(beyond_) < 0)) return;

    const auto after = [&](std::size_t c) { return c + 1 == corners.size() ? 0 : c + 1; };
    const auto before = [&](std::size_t c) { return (c == 0 ? corners.size() : c) - 1; };
    // The corners beyond around the farthest one are kept, from `first` to `last`.
    auto first = static_cast<std::size_t>(farthest - beyond_.begin()), last = first;
    while (beyond_[before(first)] > 0) first = before(first);
    while (beyond_[after(last)] > 0) last = after(last);
    const std::size_t begin = after(last), end = before(first);  // of the rest
    const auto crossing = [&](std::size_t in, std::size_t out) {
        const double share = beyond_[in] / (beyond_[in] - beyond_[out]);
        Vector3 at = corners[in];
        for (std::size_t k = 0; k < 3; ++k) at[k] += share * (corners[out][k] - at[k]);
        return at;
    };
    const Vector3 enters = crossing(end, first), leaves = crossing(begin, last);

    kept_.assign(1, enters);
    for (std::size_t c = first; c != begin; c = after(c)) kept_.push_back(corners[c]);
    kept_.push_back(leaves);
    below.corners.push_back(leaves);
    for (std::size_t c = begin;; c = after(c)) {
        // An end in the plane is the crossing itself.
        if (beyond_[c] != 0 || (c != begin && c != end)) below.corners.push_back(corners[c]);
        if (c == end) break;
    }
    below.corners.push_back(enters);
    std::swap(corners, kept_);
}

}  // namespace votess
