// StarWalk: what a cell looks like: for measuring, as polygons, normals.
#pragma once

#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

// Whether the vector to a seed is the difference of two doubles each.
template <class Isa>
bool StarWalk<Isa>::is_difference(std::int32_t id) const {
    return seeds_.images == nullptr ||
           (!moved_ && !seeds_.images->is_rough(id) && seeds_.images->low(id) == std::array<double, 3>{});
}

// Plain: neither weights nor images.
template <class Isa>
template <bool Plain>
void StarWalk<Isa>::shape_planes(std::span<const std::uint32_t> ranks) {
    CellShape& shape = shape_;
    const Wide at{p_[0], p_[1], p_[2], 0};
    const double *x = seeds_.x.begin(), *y = seeds_.y.begin(), *z = seeds_.z.begin();  // kept in registers
    for (int face = 0; face < faces_; ++face) {
        const std::uint32_t rank = ranks[static_cast<std::size_t>(face)];
        shape.rank[face_slot_[face]] = static_cast<std::uint8_t>(rank);
        const std::int32_t id = face_[face];
        Wide& plane = reinterpret_cast<Wide&>(shape.plane[rank]);
        if (id < 0) {
            Four n;
            double h;
            wall_plane(id, n, h);
            plane = 0.5 * unscale_ * wide(n);
            continue;
        }
        if (Plain || is_difference(id)) {
            plane = 0.5 * (Wide{x[id], y[id], z[id], 0} - at);
        } else {
            const auto difference = exact::differences(base_.point, exact_plane(id)).x;
            plane = 0.5 * Wide{difference[0].high, difference[1].high, difference[2].high, 0};
        }
        if (!Plain && weighted_) plane[3] = 0.25 * (weight_ - weight_of(id));
    }
}

template <class Isa>
std::array<double, 3> StarWalk<Isa>::corner(const std::array<unsigned, 3>& ranks) const {
    const auto plane = [&](unsigned rank) {
        int face = 0;
        while (shape_.rank[face_slot_[face]] != rank) ++face;
        return exact_plane(face_[face]);
    };
    return exact::vertex_position<double>(base_.point, plane(ranks[0]), plane(ranks[1]), plane(ranks[2]));
}

template <class Isa>
CellShape* StarWalk<Isa>::shape(std::span<const std::uint32_t> ranks) {
    CellShape& shape = shape_;
    shape.planes = faces_;
    shape.slots = planes_;
    shape.corners = vertices_;
    shape.weighted = weighted_;
    shape.exact = this;
    if (plain_)
        shape_planes<true>(ranks);
    else
        shape_planes<false>(ranks);
    for (const Tie& tie : ties_) {
        if (!shape.add_polygon(std::span(tie_slots_.begin() + tie.begin, tie_slots_.begin() + tie.end))) return nullptr;
        // The last corner takes the place of the vertex.
        const auto from = static_cast<std::size_t>(--shape.corners), to = static_cast<std::size_t>(tie.vertex);
        shape.a[to] = shape.a[from], shape.b[to] = shape.b[from], shape.c[to] = shape.c[from];
    }
    return &shape;
}

template <class Isa>
bool StarWalk<Isa>::knows_vertices() const {
    constexpr double accepted_error = 4e-10;
    Wide largest{};  // squares
    for (int v = 0; v < vertices_; ++v) {
        const Wide square = wide(position_[v]) * wide(position_[v]);
        largest = square > largest ? square : largest;
    }
    return bounds::solved_factor * std::sqrt(std::sqrt(largest[3])) <=
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
void StarWalk<Isa>::normals(std::vector<std::array<double, 3>>& out) {
    out.clear();
    for (const std::int32_t id : faces()) out.push_back(unit_normal(base_.point, exact_plane(id)));
}

}  // namespace votess::cpu
