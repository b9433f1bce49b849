#include "query/sibson.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/progress.hpp"
#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

using Vector = Vector3;
using Two __attribute__((vector_size(16), aligned(16), may_alias)) = double;  // as wide as any processor has

constexpr std::size_t max_vertices = 128, none = ~std::size_t{0};
constexpr double never = 1e300;                 // h of a plane that is not there
constexpr double residual_rounding = 0x1p-47;   // 64 u
constexpr double min_determinant = 0x1p-30;     // of N^3: the sign of a smaller one may be rounding
constexpr double min_bisectors_apart = 0x1p-8;  // of N: bisectors of nearer neighbors have lost digits

const Two& two(const double* all, std::size_t i) {
    return reinterpret_cast<const Two&>(all[i]);
}
Two& two(double* all, std::size_t i) {
    return reinterpret_cast<Two&>(all[i]);
}

// Returns the smallest of an even number, or a large one.
double smallest(const double* all, std::size_t count) {
    Two least = Two{} + never;
    for (std::size_t i = 0; i < count; i += 2) least = two(all, i) < least ? two(all, i) : least;
    return std::min(least[0], least[1]);
}

// Swaps two of three neighbors, if need be, so that their direction leads away from where n.x > m.x. Returns it.
Vector turn(const Division& division, std::size_t a, std::size_t& b, std::size_t& c, const Vector& n, const Vector& m) {
    const Vector along = division.direction(a, b, c);
    if (!(dot(n, along) > dot(m, along))) return along;
    std::swap(b, c);
    return {-along[0], -along[1], -along[2]};
}

struct Three {
    std::size_t a, b, c;
};
Three numbers_of(std::uint32_t three) {
    return {static_cast<std::size_t>(std::countr_zero(three)),
            static_cast<std::size_t>(std::countr_zero(three & (three - 1))),
            static_cast<std::size_t>(31 - std::countl_zero(three))};
}

}  // namespace

bool ProbeShape::find_corners() {
    const std::size_t vertices = polygons.positions.size();
    planes_known_.assign(vertices, 0);
    corners.resize(vertices);
    for (std::size_t f = 0; f < polygons.size(); ++f)
        for (const std::uint32_t v : polygons.face(f)) {
            if (planes_known_[v] == 3) return false;
            corners[v].planes[planes_known_[v]++] = static_cast<std::uint8_t>(f);
        }
    // Vertices of no face may be there, too.
    std::size_t count = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        if (planes_known_[v] == 0) continue;
        if (planes_known_[v] != 3) return false;
        corners[count++] = {corners[v].planes, polygons.positions[v]};
    }
    corners.resize(count);
    return true;
}

bool Sibson::divide(const ProbeShape& shape, bool moments, Division& out) {
    if (shape.planes.size() > Division::max_neighbors) return false;
    read(shape, moments, out);
    return neighbors_are_apart(out.size()) && walk_inward(shape, out) && walk_on(out) && out.add_rims() && out.finish();
}

void Sibson::read(const ProbeShape& shape, bool moments, Division& out) {
    out.begin(shape.weighted, moments);
    const auto& planes = shape.planes;
    double highest = 0;
    longest_squared_ = 0;
    for (std::size_t f = 0; f < planes.size(); ++f) {
        if (planes[f].seed < 0) continue;
        const std::size_t a = out.add_neighbor(planes[f].seed, planes[f].n, planes[f].h);
        number_[f] = static_cast<std::uint8_t>(a);
        h_[a] = planes[f].h;
        approached_[a] = 1;
        far_[a] = 0;
        longest_squared_ = std::max(longest_squared_, dot(planes[f].n, planes[f].n));
        highest = std::max(highest, std::abs(planes[f].h));
    }
    const double longest = longest_ = std::sqrt(longest_squared_);
    for (std::size_t f = 0; f < planes.size(); ++f) {
        if (planes[f].seed >= 0) continue;
        // Normals of walls become as long as the longest of neighbors.
        const Vector& n = planes[f].n;
        const double scale = longest / std::sqrt(dot(n, n));
        const std::size_t w = out.add_wall({scale * n[0], scale * n[1], scale * n[2]}, scale * planes[f].h);
        number_[f] = static_cast<std::uint8_t>(w);
        h_[w] = scale * planes[f].h;
        approached_[w] = 0;
        far_[w] = never;
        highest = std::max(highest, std::abs(h_[w]));
    }
    double farthest_squared = 0;
    for (const auto& corner : shape.corners) farthest_squared = std::max(farthest_squared, dot(corner.x, corner.x));
    rounding_ = residual_rounding * (longest * std::sqrt(farthest_squared) + highest);
    longest_cubed_ = longest * longest_squared_;
    normals_ = out.normals();
    padded_ = (planes.size() + 1) / 2 * 2;
    for (std::size_t i = planes.size(); i < padded_; ++i) h_[i] = far_[i] = never, approached_[i] = 0;
}

bool Sibson::neighbors_are_apart(std::size_t neighbors) const {
    Two least = Two{} + never;
    for (std::size_t a = 0; a + 1 < neighbors; ++a)
        for (std::size_t i = (a + 1) / 2 * 2; i < neighbors; i += 2) {
            const Two x = two(normals_.x, i) - normals_.x[a], y = two(normals_.y, i) - normals_.y[a],
                      z = two(normals_.z, i) - normals_.z[a];
            Two square = x * x + y * y + z * z + two(far_.data(), i);
            if (i <= a) square[a - i] = never;
            least = square < least ? square : least;
        }
    return std::min(least[0], least[1]) >= min_bisectors_apart * min_bisectors_apart * longest_squared_;
}

// Returns the vertex from number `begin` on that is as near to three neighbors.
Sibson::Vertex* Sibson::find(std::uint32_t three, std::size_t begin) {
    for (std::size_t v = begin; v < vertices_.size(); ++v)
        if ((vertices_[v].near & three) == three) return &vertices_[v];
    return nullptr;
}

// Returns the plane that a ray meets first, except for some; neighbors come nearer than one with that excess and speed.
// none: it meets none. Fills left_ and nearing_.
std::size_t Sibson::meet(const Vector& from, const Vector& along, std::uint32_t without, double excess, double speed,
                         double& time) {
    alignas(32) std::array<double, Division::max_neighbors> times;
    for (std::size_t i = 0; i < padded_; i += 2) {
        const Two &nx = two(normals_.x, i), &ny = two(normals_.y, i), &nz = two(normals_.z, i);
        const Two& approached = two(approached_.data(), i);
        const Two left = two(h_.data(), i) - nx * from[0] - ny * from[1] - nz * from[2] - approached * excess;
        const Two nearing = nx * along[0] + ny * along[1] + nz * along[2] - approached * speed;
        const Two never_met = Two{} + never;
        two(left_.data(), i) = left;
        two(nearing_.data(), i) = nearing;
        two(times.data(), i) = nearing > 0 ? left / nearing : never_met;
    }
    for (std::size_t i = normals_.count; i < padded_; ++i) times[i] = never;
    for (; without != 0; without &= without - 1) times[static_cast<std::size_t>(std::countr_zero(without))] = never;
    time = smallest(times.data(), padded_);
    if (!(time < never)) return none;
    std::size_t next = 0;
    while (times[next] != time) ++next;
    return next;
}

// Whether, after meet() and that time, the ray has reached the vertex of four neighbors, and no other plane is as near.
// own: the residual of the first of them.
bool Sibson::is_proven(double time, double own, std::uint32_t near, double margin) {
    for (std::uint32_t rest = near; rest != 0; rest &= rest - 1) {
        const auto i = static_cast<std::size_t>(std::countr_zero(rest));
        if (!(std::abs(left_[i] - nearing_[i] * time) <= rounding_)) return false;
        left_[i] = never;
    }
    Two least = Two{} + own;
    for (std::size_t i = 0; i < padded_; i += 2) {
        const Two residual = two(left_.data(), i) - two(nearing_.data(), i) * time;
        least = residual < least ? residual : least;
    }
    return std::min(least[0], least[1]) > margin;
}

// Goes along an edge of three neighbors from a vertex to a new one, where the next neighbor is as near.
bool Sibson::leave(const Division& division, const Vector& from, std::uint32_t three, const Vector& along, Vector& to) {
    const std::size_t a = numbers_of(three).a;
    const Vector n = division.normal(a);
    const double excess = division.residual(a, from), speed = dot(n, along);
    double time = 0;
    const std::size_t next = meet(from, along, three, excess, speed, time);
    if (next == none || vertices_.size() == max_vertices) return false;
    const double own = excess - time * speed, determinant = std::abs(nearing_[next]);
    const double margin = rounding_ * (2 + 24 * longest_cubed_ / determinant);
    if (!(determinant >= min_determinant * longest_cubed_)) return false;
    if (!is_proven(time, own, three | 1u << next, margin)) return false;
    for (std::size_t k = 0; k < 3; ++k) to[k] = from[k] + time * along[k];
    vertices_.push_back({three | 1u << next, 1u << next, to, own, 0.5 * margin / longest_});
    return true;
}

// Walks along the edges that begin at the corners of the cell.
bool Sibson::walk_inward(const ProbeShape& shape, Division& out) {
    vertices_.clear();
    for (const auto& corner : shape.corners) {
        std::size_t a = number_[corner.planes[0]], b = number_[corner.planes[1]], c = number_[corner.planes[2]];
        // Neighbors have lower numbers than walls.
        if (b < a) std::swap(a, b);
        if (c < a) std::swap(a, c);
        if (out.is_wall(a)) continue;
        const Vector along = turn(out, a, b, c, out.normal(a), {});
        if (!(std::abs(dot(out.normal(a), along)) >= min_determinant * longest_cubed_)) return false;
        const std::uint32_t three = 1u << a | 1u << b | 1u << c;
        for (const std::size_t i : {a, b, c})
            if (!(std::abs(out.residual(i, corner.x)) <= rounding_)) return false;
        if (!out.add_corner(a, c, b, corner.x)) return false;
        Vector to;
        // It meets each of these planes once, so it has one end inside.
        if (Vertex* const known = find(three, 0)) {
            if (!known->reach(three)) return false;
            to = known->x;
        } else if (!leave(out, corner.x, three, along, to)) {
            return false;
        }
        out.add_inner(a, b, c, corner.x, to);
    }
    return true;
}

// Walks along those between two vertices inside.
bool Sibson::walk_on(Division& out) {
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        for (std::uint32_t left = vertices_[v].near & ~vertices_[v].done; left != 0; left &= left - 1) {
            const std::uint32_t without = left & -left, three = vertices_[v].near & ~without;
            vertices_[v].done |= without;
            auto [a, b, c] = numbers_of(three);
            if (out.is_wall(a)) continue;
            // The one that is left falls back.
            const std::size_t d = static_cast<std::size_t>(std::countr_zero(without));
            const Vector than = out.is_wall(d) ? Vector{} : out.normal(a), from = vertices_[v].x;
            const Vector along = turn(out, a, b, c, out.normal(d), than);
            Vector to;
            // Vertices before this one have no edges left.
            if (Vertex* const known = find(three, v + 1)) {
                if (!known->reach(three)) return false;
                to = known->x;
            } else if (!leave(out, from, three, along, to)) {
                return false;
            }
            out.add_inner(a, b, c, from, to);
        }
    }
    return true;
}

}  // namespace votess::cpu
