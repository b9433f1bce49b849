#include "core/convex_piece.hpp"

#include <algorithm>
#include <cmath>

#include "core/progress.hpp"

namespace votess {
namespace {

constexpr std::size_t long_rim = 1024;  // edges

}  // namespace

void ConvexPiece::Surface::clear() {
    corners.clear();
    ends.clear();
}

// Drops a polygon of fewer than three corners.
void ConvexPiece::Surface::end_polygon() {
    const std::size_t begin = ends.empty() ? 0 : ends.back();
    if (corners.size() < begin + 3)
        corners.resize(begin);
    else
        ends.push_back(corners.size());
}

void ConvexPiece::clear() {
    surface_.clear();
}

void ConvexPiece::add_polygon(std::span<const Vector> corners) {
    surface_.corners.insert(surface_.corners.end(), corners.begin(), corners.end());
    surface_.end_polygon();
}

ConvexPiece::Sides ConvexPiece::sides() const {
    Sides sides;
    for (const double beyond : beyond_) {
        sides.within |= beyond < 0;
        sides.beyond |= beyond > 0;
    }
    return sides;
}

// Writes the closed half of the surface on one side of the plane: -1 within, 1 beyond. The closing polygons replace
// polygons in the plane.
void ConvexPiece::clip_half(double side, Surface& half) {
    const std::vector<Vector>& corners = surface_.corners;
    half.clear();
    rim_.clear();
    for (std::size_t f = 0, begin = 0; f < surface_.ends.size(); begin = surface_.ends[f++]) {
        const std::size_t end = surface_.ends[f];
        bool any = false, all = true;
        for (std::size_t c = begin; c < end; ++c) {
            any |= side * beyond_[c] > 0;
            all &= side * beyond_[c] > 0;
        }
        if (!any) continue;
        if (all) {
            half.corners.insert(half.corners.end(), &corners[begin], &corners[begin] + (end - begin));
            half.end_polygon();
            continue;
        }
        const std::size_t first = half.corners.size();
        bool first_on = false, last_on = false;
        const auto add = [&](const Vector& corner, bool on_plane) {
            if (half.corners.size() == first) first_on = on_plane;
            if (on_plane && last_on) rim_.push_back({corner, half.corners.back()});
            half.corners.push_back(corner);
            last_on = on_plane;
        };
        for (std::size_t c = begin; c < end; ++c) {
            const std::size_t next = c + 1 == end ? begin : c + 1;
            if (side * beyond_[c] >= 0) add(corners[c], beyond_[c] == 0);
            if (!(beyond_[c] < 0 && beyond_[next] > 0) && !(beyond_[c] > 0 && beyond_[next] < 0)) continue;
            // computed from the same end in both directions
            const std::size_t in = beyond_[c] < 0 ? c : next, out = beyond_[c] < 0 ? next : c;
            const double share = beyond_[in] / (beyond_[in] - beyond_[out]);
            Vector at;
            for (std::size_t k = 0; k < 3; ++k) at[k] = corners[in][k] + share * (corners[out][k] - corners[in][k]);
            add(at, true);
        }
        if (first_on && last_on) rim_.push_back({half.corners[first], half.corners.back()});
        half.end_polygon();
    }
    close_rim(half);
}

// Joins edges that follow each other into polygons. As many edges begin at a point as end there, so each walk returns.
void ConvexPiece::close_rim(Surface& half) {
    while (!rim_.empty()) {
        const Vector start = rim_.back().from;
        auto edge = rim_.end() - 1;
        while (edge != rim_.end()) {
            const Vector at = edge->to;
            if (edge->from != at) half.corners.push_back(edge->from);
            *edge = rim_.back();
            rim_.pop_back();
            if (at == start) break;
            if (rim_.size() > long_rim) check_stop();
            edge = std::ranges::find(rim_, at, &Edge::from);
        }
        half.end_polygon();
    }
}

bool ConvexPiece::cut(const Vector& n, double h) {
    beyond_.clear();
    for (const Vector& corner : surface_.corners) beyond_.push_back(dot(n, corner) - h);
    const Sides at = sides();
    if (at.beyond && !at.within) clear();
    if (at.beyond && at.within) {
        clip_half(-1, kept_);
        std::swap(surface_, kept_);
    }
    return !empty();
}

void ConvexPiece::split(const Vector& n, double h, ConvexPiece& below) {
    beyond_.clear();
    for (const Vector& corner : surface_.corners) beyond_.push_back(dot(n, corner) - h);
    const Sides at = sides();
    below.clear();
    if (!at.beyond) {
        std::swap(surface_, below.surface_);
    } else if (at.within) {
        clip_half(-1, below.surface_);
        clip_half(1, kept_);
        std::swap(surface_, kept_);
    }
}

std::pair<double, double> ConvexPiece::extent(const Vector& n) const {
    double least = dot(n, surface_.corners.front()), largest = least;
    for (const Vector& corner : surface_.corners) {
        const double x = dot(n, corner);
        least = std::min(least, x);
        largest = std::max(largest, x);
    }
    return {least, largest};
}

ConvexPiece::Ball ConvexPiece::ball() const {
    Ball ball;
    if (empty()) return ball;
    for (const Vector& corner : surface_.corners)
        for (std::size_t k = 0; k < 3; ++k) ball.center[k] += corner[k] / static_cast<double>(surface_.corners.size());
    double square = 0;
    for (const Vector& corner : surface_.corners) {
        const Vector d = minus(corner, ball.center);
        square = std::max(square, dot(d, d));
    }
    ball.radius = std::sqrt(square);
    return ball;
}

// Sums tetrahedra from one corner, so that terms that cancel stay small.
ConvexPiece::Measure ConvexPiece::measure(std::size_t corner) const {
    Measure sum;
    if (empty()) return sum;
    const Vector apex = surface_.corners.front();
    for (std::size_t f = 0; f < polygons(); ++f) {
        const auto corners = polygon(f);
        const auto at = [&](std::size_t c) { return minus(corners[(corner + c) % corners.size()], apex); };
        const Vector a = at(0);
        for (std::size_t c = 1; c + 1 < corners.size(); ++c) {
            const Vector b = at(c), d = at(c + 1);
            const double volume = dot(a, cross(b, d)) / 6;
            sum.volume += volume;
            for (std::size_t k = 0; k < 3; ++k) sum.moment[k] += volume * (a[k] + b[k] + d[k]) / 4;
        }
    }
    for (std::size_t k = 0; k < 3; ++k) sum.moment[k] += sum.volume * apex[k];
    return sum;
}

}  // namespace votess
