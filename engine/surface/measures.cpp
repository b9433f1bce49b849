#include "surface/measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/sum.hpp"
#include "surface/nearest.hpp"

namespace votess::surface {

void CellOnSurface::measure(std::int32_t seed, std::span<const std::size_t> own) {
    seed_ = seed;
    area = border = energy = 0;
    Vector3 moment{};
    for (const std::size_t p : own) {
        const Part& part = parts_.list[p];
        area += part.area;
        border += part.border;
        energy += part.energy;
        for (std::size_t k = 0; k < 3; ++k) moment[k] += part.moment[k];
    }
    centroid = nearest = {nan, nan, nan};
    if (area > 0) {
        for (std::size_t k = 0; k < 3; ++k) centroid[k] = moment[k] / area;
        find_nearest(own);
    }
    if (want_ < SurfaceWant::polygons) return;
    sides_.clear();
    for (const std::size_t p : own) add_sides(p);
    find_pieces(own);
    if (want_ == SurfaceWant::all) find_row();
}

CellOnSurface::Frame CellOnSurface::frame(std::size_t p) const {
    const auto& vertex = surface_.triangles()[at(parts_.list[p].triangle)].vertex;
    const Vector3 u = surface_.vertex(vertex[0]);
    return {u, minus(surface_.vertex(vertex[1]), u), minus(surface_.vertex(vertex[2]), u)};
}

// Lists the sides on bisectors. Lengths come from shared corners, so that they are equal for both cells.
void CellOnSurface::add_sides(std::size_t p) {
    const auto [u, a, b] = frame(p);
    const std::size_t begin = parts_.begin(p), end = parts_.end(p);
    std::size_t known = end;  // the corner whose weights are in `from`
    std::array<double, 2> from{};
    for (std::size_t c = begin; c < end; ++c) {
        if (parts_.sides[c] < 0) continue;
        const std::size_t next = c + 1 == end ? begin : c + 1;
        const bool is_point = parts_.without_length[c] != 0;
        double length = 0;
        if (!is_point && want_ == SurfaceWant::all) {
            if (known != c) from = parts_.shared_weights(surface_, p, c);
            const auto to = parts_.shared_weights(surface_, p, next);
            const double s = to[0] - from[0], t = to[1] - from[1];
            length = length3(s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]);
            from = to;
            known = next;
        }
        sides_.push_back({parts_.sides[c], p, parts_.corners[c], parts_.corners[next], length, is_point});
    }
}

void CellOnSurface::find_nearest(std::span<const std::size_t> own) {
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t p : own) {
        if (!parts_.list[p].has_area) continue;
        places_.clear();
        const auto [u, a, b] = frame(p);
        const Vector3 base = minus(u, surface_.seed(seed_));
        double size = 0;  // square of the largest distance from the first corner
        for (std::size_t c = parts_.begin(p); c < parts_.end(p); ++c) {
            places_.push_back(along(along(base, a, parts_.weights[c][0]), b, parts_.weights[c][1]));
            size = std::max(size, square_distance(places_[0], places_.back()));
        }
        // The part lies in a ball around that corner.
        const double far = distance(places_[0], centroid) - std::sqrt(size) * (1 + 0x1p-40);
        if (far > 0 && far * far * (1 - 0x1p-40) > least) continue;
        for (std::size_t i = 1; i + 1 < places_.size(); ++i) {
            const Vector3 place = nearest_on_triangle(centroid, places_[0], places_[i], places_[i + 1]);
            if (const double square = square_distance(place, centroid); square < least) least = square, nearest = place;
        }
    }
}

std::size_t CellOnSurface::root(std::size_t i) {
    while (joined_[i] != i) i = joined_[i] = joined_[joined_[i]];
    return i;
}

// Joins parts with a side on one edge of the surface: there the cell is one segment. Counts corners, sides and parts.
void CellOnSurface::find_pieces(std::span<const std::size_t> own) {
    joined_.resize(own.size());
    std::iota(joined_.begin(), joined_.end(), std::size_t{0});
    on_edges_.clear();
    vertices_.clear();
    std::size_t edges = sides_.size();
    for (std::size_t i = 0; i < own.size(); ++i)
        for (std::size_t c = parts_.begin(own[i]); c < parts_.end(own[i]); ++c) {
            vertices_.push_back(parts_.corners[c]);
            const auto& of_triangle = surface_.triangles()[at(parts_.list[own[i]].triangle)].edge;
            if (parts_.sides[c] < 0) on_edges_.push_back({of_triangle[corner_of(parts_.sides[c])], i});
        }
    std::ranges::sort(on_edges_);
    for (std::size_t k = 0; k < on_edges_.size(); ++k) {
        if (k > 0 && on_edges_[k].first == on_edges_[k - 1].first)
            joined_[root(on_edges_[k].second)] = root(on_edges_[k - 1].second);
        else
            ++edges;
    }
    std::ranges::sort(vertices_);
    const auto vertices = std::unique(vertices_.begin(), vertices_.end()) - vertices_.begin();
    euler =
        static_cast<std::int32_t>(vertices) - static_cast<std::int32_t>(edges) + static_cast<std::int32_t>(own.size());
    pieces = 0;
    part_pieces.assign(own.size(), -1);
    for (std::size_t i = 0; i < own.size(); ++i) {
        std::int32_t& of_root = part_pieces[root(i)];
        if (of_root < 0) of_root = pieces++;
        part_pieces[i] = of_root;
    }
}

// Sums sides by the seed beyond them. Sides that end at one crossing with an edge of the surface belong to one curve.
void CellOnSurface::find_row() {
    row.clear();
    std::ranges::stable_sort(sides_, {}, &OnBisector::seed);
    for (std::size_t begin = 0, end = 0; begin < sides_.size(); begin = end) {
        while (end < sides_.size() && sides_[end].seed == sides_[begin].seed) ++end;
        Sum length;
        bool has_length = false;
        joined_.resize(end - begin);
        std::iota(joined_.begin(), joined_.end(), std::size_t{0});
        ends_.clear();
        for (std::size_t i = begin; i < end; ++i) {
            length += sides_[i].length;
            has_length |= !sides_[i].is_point;
            ends_.push_back({sides_[i].from, i - begin});
            ends_.push_back({sides_[i].to, i - begin});
        }
        if (!has_length) continue;
        std::ranges::sort(ends_);
        for (std::size_t k = 1; k < ends_.size(); ++k)
            if (ends_[k].first == ends_[k - 1].first) joined_[root(ends_[k].second)] = root(ends_[k - 1].second);
        Shared shared{sides_[begin].seed, length.value(), 0, 0};
        std::vector<std::uint8_t> is_open(end - begin);
        for (std::size_t k = 0; k < ends_.size(); ++k) {
            const bool is_alone = (k == 0 || ends_[k - 1].first != ends_[k].first) &&
                                  (k + 1 == ends_.size() || ends_[k + 1].first != ends_[k].first);
            if (is_alone) is_open[root(ends_[k].second)] = 1;
        }
        for (std::size_t i = 0; i < joined_.size(); ++i)
            if (joined_[i] == i) ++shared.curves, shared.loops += is_open[i] == 0 ? 1 : 0;
        row.push_back(shared);
    }
}

}  // namespace votess::surface
