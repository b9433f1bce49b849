#include "cpu/query/sibson.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace votess::cpu {
namespace {

using Vector = std::array<double, 3>;

constexpr std::size_t most_vertices = 128;
constexpr double never = 1e300;            // h of a plane that is not there
constexpr double most_unbalanced = 1e-12;  // of the sum of volumes times distances

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

std::size_t lowest(std::uint32_t bits) {
    return static_cast<std::size_t>(std::countr_zero(bits));
}

}  // namespace

std::span<const double> SibsonVolumes::find(const ProbeShape& shape) {
    volumes_.assign(shape.planes.size(), 0);
    if (!by_edges(shape)) by_cuts(shape);
    return volumes_;
}

bool SibsonVolumes::by_edges(const ProbeShape& shape) {
    if (!read(shape) || !walk_inward() || !walk_on() || !balanced()) return false;
    for (double& volume : volumes_) volume /= 6;
    return true;
}

// False where a wall bounds the cell, or more than three faces meet.
bool SibsonVolumes::read(const ProbeShape& shape) {
    count_ = shape.planes.size();
    if (count_ > most_planes) return false;
    const auto padded = std::min(most_planes, (count_ + 7) / 8 * 8);
    for (std::size_t f = 0; f < padded; ++f) {
        if (f < count_ && shape.planes[f].seed < 0) return false;
        const Vector n = f < count_ ? shape.planes[f].n : Vector{};
        nx_[f] = n[0], ny_[f] = n[1], nz_[f] = n[2];
        h_[f] = f < count_ ? shape.planes[f].h : never;
    }
    const CellPolygons& polygons = shape.polygons;
    const std::size_t vertices = polygons.positions.size();
    if (vertices > most_vertices) return false;
    sides_.resize(vertices);
    sides_known_.assign(vertices, 0);
    for (std::size_t f = 0; f < count_; ++f) {
        const std::uint32_t begin = polygons.offsets[f], end = polygons.offsets[f + 1];
        for (std::uint32_t k = begin; k < end; ++k) {
            const std::uint32_t v = polygons.corners[k], w = polygons.corners[k + 1 == end ? begin : k + 1];
            if (sides_known_[v] == 3) return false;
            sides_[v][sides_known_[v]++] = {static_cast<std::uint8_t>(f), static_cast<std::uint8_t>(w)};
        }
    }
    // Vertices that no face has are of no cell.
    if (!std::ranges::all_of(sides_known_, [](std::uint8_t known) { return known == 3 || known == 0; })) return false;
    // The edges of the cell itself: each bounds two faces of it, and the face between the two parts behind them.
    for (std::size_t v = 0; v < vertices; ++v) {
        if (sides_known_[v] == 0) continue;
        for (const auto& [a, w] : sides_[v]) {
            const auto back = std::ranges::find(sides_[w], static_cast<std::uint8_t>(v), &Side::to);
            if (back == sides_[w].end()) return false;
            const std::size_t b = back->face;
            const Vector across = cross(polygons.positions[v], polygons.positions[w]);
            const double foot = h_[a] / (nx_[a] * nx_[a] + ny_[a] * ny_[a] + nz_[a] * nz_[a]);
            const Vector middle = middle_of(a, b);
            volumes_[a] +=
                dot({foot * nx_[a] - middle[0], foot * ny_[a] - middle[1], foot * nz_[a] - middle[2]}, across);
        }
    }
    positions_ = polygons.positions.data();
    return true;
}

// Where the plane of equal distance from neighbors a and b is nearest to the probe.
Vector SibsonVolumes::middle_of(std::size_t a, std::size_t b) const {
    const Vector n{nx_[b] - nx_[a], ny_[b] - ny_[a], nz_[b] - nz_[a]};
    const double foot = (h_[b] - h_[a]) / dot(n, n);
    return {foot * n[0], foot * n[1], foot * n[2]};
}

Vector SibsonVolumes::direction(std::size_t a, std::size_t b, std::size_t c) const {
    return cross({nx_[b] - nx_[a], ny_[b] - ny_[a], nz_[b] - nz_[a]},
                 {nx_[c] - nx_[a], ny_[c] - ny_[a], nz_[c] - nz_[a]});
}

// Along an edge of three neighbors, from a vertex: to where the next neighbor is as near. That vertex may be known, but
// not its edge.
bool SibsonVolumes::leave(const Vector& from, std::uint32_t three, const Vector& along, Vector& to) {
    const std::size_t a = lowest(three);
    const auto excess = [&](std::size_t i) { return h_[i] - nx_[i] * from[0] - ny_[i] * from[1] - nz_[i] * from[2]; };
    const auto speed = [&](std::size_t i) { return nx_[i] * along[0] + ny_[i] * along[1] + nz_[i] * along[2]; };
    const double excess_a = excess(a), speed_a = speed(a);
    const std::size_t padded = (count_ + 7) / 8 * 8;
    alignas(64) std::array<double, most_planes> times;
    for (std::size_t i = 0; i < padded; ++i) {
        const double nearing = speed(i) - speed_a;
        const double time = (excess(i) - excess_a) / nearing;
        times[i] = nearing > 0 ? time : never;
    }
    for (std::uint32_t rest = three; rest != 0; rest &= rest - 1) times[lowest(rest)] = never;
    const auto next = static_cast<std::size_t>(std::min_element(times.begin(), times.begin() + padded) - times.begin());
    if (!(times[next] < never) || next >= count_) return false;
    const std::uint32_t four = three | 1u << next;
    const auto known = std::ranges::find(vertices_, four, &Vertex::near);
    if (known != vertices_.end()) {
        if ((known->done >> next & 1) != 0) return false;
        known->done |= 1u << next;
        to = known->x;
        return true;
    }
    if (vertices_.size() == most_vertices) return false;
    for (std::size_t k = 0; k < 3; ++k) to[k] = from[k] + times[next] * along[k];
    vertices_.push_back({four, 1u << next, to});
    return true;
}

// The edges that begin at the vertices of the cell.
bool SibsonVolumes::walk_inward() {
    vertices_.clear();
    for (std::size_t v = 0; v < sides_.size(); ++v) {
        if (sides_known_[v] == 0) continue;
        const std::size_t a = sides_[v][0].face, b = sides_[v][1].face, c = sides_[v][2].face;
        Vector along = direction(a, b, c);
        if (nx_[a] * along[0] + ny_[a] * along[1] + nz_[a] * along[2] > 0)
            for (double& x : along) x = -x;
        const std::uint32_t three = 1u << a | 1u << b | 1u << c;
        Vector to;
        if (!leave(positions_[v], three, along, to)) return false;
        add_edge(three, positions_[v], to);
    }
    return true;
}

// Those between two vertices inside.
bool SibsonVolumes::walk_on() {
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        for (std::uint32_t left = vertices_[v].near; left != 0; left &= left - 1) {
            const std::uint32_t without = left & -left;
            if ((vertices_[v].done & without) != 0) continue;
            const std::uint32_t three = vertices_[v].near & ~without;
            vertices_[v].done |= without;
            const Vector from = vertices_[v].x;
            const auto other = std::ranges::find_if(vertices_, [three, this, v](const Vertex& w) {
                return (w.near & three) == three && w.near != vertices_[v].near;
            });
            Vector to;
            if (other != vertices_.end()) {
                const std::uint32_t its = other->near & ~three;
                if ((other->done & its) != 0) return false;
                other->done |= its;
                to = other->x;
            } else {
                const std::size_t a = lowest(three), d = lowest(without);
                Vector along = direction(a, lowest(three & (three - 1)), 31 - std::countl_zero(three));
                // The neighbor that is left falls back.
                const Vector n{nx_[d] - nx_[a], ny_[d] - ny_[a], nz_[d] - nz_[a]};
                if (dot(n, along) > 0)
                    for (double& x : along) x = -x;
                if (!leave(from, three, along, to)) return false;
            }
            add_edge(three, from, to);
        }
    }
    return true;
}

// Of the three faces between parts that meet in an edge.
void SibsonVolumes::add_edge(std::uint32_t three, const Vector& from, const Vector& to) {
    const std::size_t a = lowest(three), b = lowest(three & (three - 1)),
                      c = static_cast<std::size_t>(31 - std::countl_zero(three));
    Vector across = cross(from, to);
    if (dot(direction(a, b, c), {to[0] - from[0], to[1] - from[1], to[2] - from[2]}) < 0)
        for (double& x : across) x = -x;
    add_across(a, b, across);
    add_across(b, c, across);
    add_across(c, a, across);
}

void SibsonVolumes::add_across(std::size_t a, std::size_t b, const Vector& across) {
    const double part = dot(middle_of(a, b), across);
    volumes_[a] += part;
    volumes_[b] -= part;
}

// The sum of volume times neighbor is 0, by Sibson's identity: a wrong vertex would show.
bool SibsonVolumes::balanced() const {
    Vector sum{};
    double size = 0;
    bool positive = true;
    for (std::size_t i = 0; i < count_; ++i) {
        const Vector n{nx_[i], ny_[i], nz_[i]};
        for (std::size_t k = 0; k < 3; ++k) sum[k] += volumes_[i] * n[k];
        size += std::abs(volumes_[i]) * std::sqrt(dot(n, n));
        positive &= volumes_[i] >= 0;
    }
    return positive && dot(sum, sum) <= most_unbalanced * most_unbalanced * size * size;
}

void SibsonVolumes::by_cuts(const ProbeShape& shape) {
    whole_.clear();
    const CellPolygons& polygons = shape.polygons;
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        corners_.clear();
        for (std::uint32_t k = polygons.offsets[f]; k < polygons.offsets[f + 1]; ++k)
            corners_.push_back(polygons.positions[polygons.corners[k]]);
        whole_.add_polygon(corners_);
    }
    const auto& planes = shape.planes;
    for (std::size_t a = 0; a < planes.size(); ++a) {
        volumes_[a] = 0;
        if (planes[a].seed < 0) continue;
        part_ = whole_;
        for (std::size_t b = 0; b < planes.size() && !part_.empty(); ++b) {
            if (a == b || planes[b].seed < 0) continue;
            Vector n;
            for (std::size_t k = 0; k < 3; ++k) n[k] = planes[b].n[k] - planes[a].n[k];
            part_.cut(n, planes[b].h - planes[a].h);
        }
        volumes_[a] = std::max(0.0, part_.volume());
    }
}

}  // namespace votess::cpu
