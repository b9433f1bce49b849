// StarWalk: volume, centroid and areas as sums over edges. With V, W the ends of an edge in counterclockwise order
// around a face of normal n (the difference of seeds, so that n.x = |n|^2/2 on it), V x W sums to twice the face's area
// vector A, and n.A/12 is the volume of the pyramid between seed and face. Its part over V, W and the foot n/2 of the
// plane has its centroid at (V + W + n/2)/4.
#pragma once

#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

template <class Isa>
bool StarWalk<Isa>::measure(Geometry& out) {
    constexpr double accepted_error = 5e-11;  // the promise is 1e-10
    constexpr double smallest_volume = 1e-140;
    // A cross product comes out as z, x, y; what is multiplied with it is kept in that order.
    alignas(64) Wide normal[most_planes], area[most_planes];
    double longest = 0;
    for (int p = 0; p < planes_; ++p) {
        need_plane(p);
        turn_twice(wide(n_[p]), normal[p]);
        // Twice the foot of the plane: n, where weights do not move it.
        normal[p] *= weighted_ ? 2 * h_[p] / square_[p] * unscale_ : unscale_;
        area[p] = Wide{};
        longest = std::max(longest, square_[p]);
        if (weighted_) longest = std::max(longest, 4 * square_[p] + 4 * h_[p] * h_[p] / square_[p]);
    }
    Wide moment{};
    for (int a = 0; a < planes_; ++a) {
        Wide area_a = area[a];
        const Wide normal_a = normal[a];
        // Each edge once: a -> b goes counterclockwise around b, and clockwise around a.
        for (std::uint64_t rest = out_[a] & ~((2ull << a) - 1); rest != 0; rest &= rest - 1) {
            const int b = std::countr_zero(rest);
            const Wide from = wide(position_[from_vertex_[a][b]]), to = wide(position_[from_vertex_[b][a]]);
            Wide from_turned, to_turned;
            turn(from, from_turned);
            turn(to, to_turned);
            const Wide across = from * to_turned - from_turned * to;
            area[b] += across;
            area_a -= across;
            const Wide part = across * (normal[b] - normal_a);
            Wide part_turned, part_turned_twice;
            turn(part, part_turned);
            turn_twice(part, part_turned_twice);
            moment += (part + (part_turned + part_turned_twice)) * (from + to);
        }
        area[a] = area_a;
    }
    Wide largest{};  // squares
    for (int v = 0; v < vertices_; ++v) {
        const Wide square = wide(position_[v]) * wide(position_[v]);
        largest = square > largest ? square : largest;
    }
    const double error = std::sqrt(largest[3]);
    double volume = 0;
    for (int p = 0; p < planes_; ++p) {
        const double part = dot(normal[p], area[p]);
        volume += part;
        Wide normal_turned;
        turn(normal[p], normal_turned);
        moment += 0.5 * part * normal_turned;
    }
    volume /= 12;
    if (!(volume > smallest_volume)) return false;
    const double reach = std::sqrt(largest[0] + largest[1] + largest[2]);
    const double length = std::sqrt(longest) * unscale_ + (weighted_ ? 2 * reach : 0);
    const double factor = weighted_ ? weighted_factor : solved_factor;
    const double bound = edges_ * 2 * length * (2 * factor * std::sqrt(error) * reach + 32 * unit * reach * reach) / 12;
    if (!(bound <= accepted_error * volume) && !(measure_error() <= accepted_error * volume)) return false;
    out.volume = volume;
    const Wide centroid = moment * (1 / (48 * volume));
    for (int k = 0; k < 3; ++k) out.centroid[k] = centroid[k];
    for (int p = 0, face = 0; p < planes_; ++p)
        if (out_[p] != 0) out.areas[face++] = 0.5 * std::sqrt(dot(area[p], area[p]));
    return true;
}

template <class Isa>
bool StarWalk<Isa>::knows_vertices() const {
    constexpr double accepted_error = 4e-10;
    Wide largest{};  // squares
    for (int v = 0; v < vertices_; ++v) {
        const Wide square = wide(position_[v]) * wide(position_[v]);
        largest = square > largest ? square : largest;
    }
    return solved_factor * std::sqrt(std::sqrt(largest[3])) <=
           accepted_error * std::sqrt(std::max({largest[0], largest[1], largest[2]}));
}

// Around face b: from the vertex that has a -> b along both of them to the one that has b -> a.
template <class Isa>
void StarWalk<Isa>::polygons(std::span<const std::uint32_t> ranks, CellPolygons& out) const {
    out.clear();
    out.positions.resize(static_cast<std::size_t>(vertices_));
    for (std::size_t v = 0; v < out.positions.size(); ++v) {
        const auto& x = position_[v].x;
        out.positions[v] = {x[0], x[1], x[2]};
    }
    out.shared.assign(numbers_.begin(), numbers_.begin() + vertices_);
    std::array<unsigned, most_planes> key;  // the rank, then the plane
    for (unsigned p = 0, faces = 0; p < static_cast<unsigned>(planes_); ++p)
        if (out_[p] != 0) key[p] = ranks[faces++] << 8 | p;
    out.corners.resize(static_cast<std::size_t>(ends_));
    std::uint32_t* corner = out.corners.data();
    std::array<std::uint8_t, most_vertices> next;  // a, by the vertex that has a -> b
    for (int b = 0; b < planes_; ++b) {
        if (out_[b] == 0) continue;
        unsigned least = ~0u;
        for (std::uint64_t rest = out_[b]; rest != 0; rest &= rest - 1) {
            const int a = std::countr_zero(rest);
            next[from_vertex_[a][b]] = static_cast<std::uint8_t>(a);
            least = std::min(least, key[a]);
        }
        out.beginnings.push_back(least >> 8);
        const unsigned first = from_vertex_[least & 0xff][b];
        unsigned v = first;
        do {
            *corner++ = v;
            v = from_vertex_[b][next[v]];
        } while (v != first);
        out.offsets.push_back(static_cast<std::uint32_t>(corner - out.corners.data()));
    }
}

template <class Isa>
double StarWalk<Isa>::farthest_squared() const {
    double farthest = 0;
    for (int v = 0; v < vertices_; ++v) {
        const auto& x = position_[v].x;
        farthest = std::max(farthest, x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    }
    return farthest;
}

template <class Isa>
void StarWalk<Isa>::normals(std::vector<std::array<double, 3>>& out) {
    out.clear();
    for (int p = 0; p < planes_; ++p) {
        if (out_[p] == 0) continue;
        need_plane(p);
        if (id_[p] < 0) {
            out.push_back(wall_of(id_[p]).normal);
        } else {
            out.push_back(unit_vector({n_[p].x[0], n_[p].x[1], n_[p].x[2]}));
        }
    }
}

// A bound on the error of the volume, edge by edge. Twice the foot of a plane, N, is wrong by the rounding of n and h,
// the ends V, W of an edge are wrong by their conditions, and the products are rounded.
template <class Isa>
double StarWalk<Isa>::measure_error() const {
    const double factor = weighted_ ? weighted_factor : solved_factor;
    double bound = 0;
    auto length = [this](int v) {
        const auto& x = position_[v].x;
        return std::abs(x[0]) + std::abs(x[1]) + std::abs(x[2]);
    };
    for (int b = 0; b < planes_; ++b) {
        const double n = std::sqrt(square_[b]), foot = weighted_ ? 2 * std::abs(h_[b]) / n : n;
        const double rounded = weighted_ ? 2 * n + foot : n;  // what the error of N is measured by
        double ends = 0, products = 0;
        for (std::uint64_t rest = out_[b]; rest != 0; rest &= rest - 1) {
            const int a = std::countr_zero(rest);
            const int v = from_vertex_[a][b], w = from_vertex_[b][a];
            ends += std::sqrt(position_[v].x[3]) * length(w) + std::sqrt(position_[w].x[3]) * length(v);
            products += length(v) * length(w);
        }
        bound += (foot * factor * ends + rounded * 32 * unit * products) * unscale_;
    }
    return bound / 12;
}

}  // namespace votess::cpu
