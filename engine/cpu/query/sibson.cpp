#include "cpu/query/sibson.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

using Vector = Vector3;

constexpr std::size_t most_vertices = 128;

struct Three {
    std::size_t a, b, c;
};
// Swaps two of three neighbors, if need be, so that their direction leads away from where n.x > m.x. Returns it.
Vector turn(const Division& division, std::size_t a, std::size_t& b, std::size_t& c, const Vector& n, const Vector& m) {
    const Vector along = division.direction(a, b, c);
    if (!(dot(n, along) > dot(m, along))) return along;
    std::swap(b, c);
    return {-along[0], -along[1], -along[2]};
}

Three numbers_of(std::uint32_t three) {
    return {static_cast<std::size_t>(std::countr_zero(three)),
            static_cast<std::size_t>(std::countr_zero(three & (three - 1))),
            static_cast<std::size_t>(31 - std::countl_zero(three))};
}

}  // namespace

bool Sibson::divide(const ProbeShape& shape, bool moments, Division& out) {
    out.begin(moments);
    for (const ProbeShape::Plane& plane : shape.planes)
        if (plane.seed < 0 || out.add_neighbor(plane.seed, plane.n, plane.h) == Division::most_neighbors) return false;
    planes_ = out.planes();
    return add_rims(shape.polygons, out) && walk_inward(shape.polygons, out) && walk_on(out) && out.finish();
}

// False where more than three faces meet.
bool Sibson::add_rims(const CellPolygons& polygons, Division& out) {
    const std::size_t vertices = polygons.positions.size();
    if (vertices > most_vertices) return false;
    sides_.resize(vertices);
    sides_known_.assign(vertices, 0);
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        const std::uint32_t begin = polygons.offsets[f], end = polygons.offsets[f + 1];
        for (std::uint32_t k = begin; k < end; ++k) {
            const std::uint32_t v = polygons.corners[k], w = polygons.corners[k + 1 == end ? begin : k + 1];
            if (sides_known_[v] == 3) return false;
            sides_[v][sides_known_[v]++] = {static_cast<std::uint8_t>(f), static_cast<std::uint8_t>(w)};
        }
    }
    // Vertices of no face may be there, too.
    if (!std::ranges::all_of(sides_known_, [](std::uint8_t known) { return known == 3 || known == 0; })) return false;
    for (std::size_t v = 0; v < vertices; ++v) {
        for (std::size_t side = 0; side < sides_known_[v]; ++side) {
            const auto& [a, w] = sides_[v][side];
            if (w < v) continue;
            const auto back = std::ranges::find(sides_[w], static_cast<std::uint8_t>(v), &Side::to);
            if (back == sides_[w].end()) return false;
            out.add_rim(a, back->face, polygons.positions[v], polygons.positions[w]);
        }
    }
    return true;
}

// The vertex from number `begin` on that is as near to three neighbors.
Sibson::Vertex* Sibson::find(std::uint32_t three, std::size_t begin) {
    for (std::size_t v = begin; v < vertices_.size(); ++v)
        if ((vertices_[v].near & three) == three) return &vertices_[v];
    return nullptr;
}

// Along an edge of three neighbors, from a vertex to a new one: where the next neighbor is as near.
bool Sibson::leave(const Division& division, const Vector& from, std::uint32_t three, const Vector& along, Vector& to) {
    using Four __attribute__((vector_size(32), aligned(32), may_alias)) = double;
    const auto [a, b, c] = numbers_of(three);
    const Vector n = division.normal(a);
    const double excess = division.height(a) - dot(n, from), speed = dot(n, along);
    alignas(32) std::array<double, Division::most_neighbors> times;
    for (std::size_t i = 0; i < planes_.count; i += 4) {
        const auto four = [i](const double* all) -> const Four& { return reinterpret_cast<const Four&>(all[i]); };
        const Four &nx = four(planes_.nx), &ny = four(planes_.ny), &nz = four(planes_.nz);
        const Four left = four(planes_.h) - nx * from[0] - ny * from[1] - nz * from[2] - excess;
        const Four nearing = nx * along[0] + ny * along[1] + nz * along[2] - speed;
        const Four none = Four{} + Division::never;
        reinterpret_cast<Four&>(times[i]) = nearing > 0 ? left / nearing : none;
    }
    times[a] = times[b] = times[c] = Division::never;
    double least = Division::never;
    for (std::size_t i = 0; i < planes_.count; ++i) least = times[i] < least ? times[i] : least;
    if (!(least < Division::never)) return false;
    std::size_t next = 0;
    while (times[next] != least) ++next;
    if (next >= division.size()) return false;
    if (vertices_.size() == most_vertices) return false;
    for (std::size_t k = 0; k < 3; ++k) to[k] = from[k] + least * along[k];
    vertices_.push_back({three | 1u << next, 1u << next, to});
    return true;
}

// The edges that begin at the vertices of the cell.
bool Sibson::walk_inward(const CellPolygons& polygons, Division& out) {
    vertices_.clear();
    for (std::size_t v = 0; v < sides_.size(); ++v) {
        if (sides_known_[v] == 0) continue;
        const std::size_t a = sides_[v][0].face;
        std::size_t b = sides_[v][1].face, c = sides_[v][2].face;
        const Vector along = turn(out, a, b, c, out.normal(a), {});
        const std::uint32_t three = 1u << a | 1u << b | 1u << c;
        Vector to;
        // It meets each of these planes once, so it has one end inside.
        if (Vertex* const known = find(three, 0)) {
            if (!known->reach(three)) return false;
            to = known->x;
        } else if (!leave(out, polygons.positions[v], three, along, to)) {
            return false;
        }
        out.add_inner(a, b, c, polygons.positions[v], to);
    }
    return true;
}

// Those between two vertices inside.
bool Sibson::walk_on(Division& out) {
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        for (std::uint32_t left = vertices_[v].near & ~vertices_[v].done; left != 0; left &= left - 1) {
            const std::uint32_t without = left & -left, three = vertices_[v].near & ~without;
            auto [a, b, c] = numbers_of(three);
            // The neighbor that is left falls back.
            const std::size_t d = static_cast<std::size_t>(std::countr_zero(without));
            const Vector along = turn(out, a, b, c, out.normal(d), out.normal(a)), from = vertices_[v].x;
            vertices_[v].done |= without;
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

void Sibson::cut(const ProbeShape& shape, std::vector<double>& volumes) {
    whole_.clear();
    const CellPolygons& polygons = shape.polygons;
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        corners_.clear();
        for (std::uint32_t k = polygons.offsets[f]; k < polygons.offsets[f + 1]; ++k)
            corners_.push_back(polygons.positions[polygons.corners[k]]);
        whole_.add_polygon(corners_);
    }
    const auto& planes = shape.planes;
    volumes.assign(planes.size(), 0);
    for (std::size_t a = 0; a < planes.size(); ++a) {
        if (planes[a].seed < 0) continue;
        part_ = whole_;
        for (std::size_t b = 0; b < planes.size() && !part_.empty(); ++b) {
            if (a == b || planes[b].seed < 0) continue;
            Vector n;
            for (std::size_t k = 0; k < 3; ++k) n[k] = planes[b].n[k] - planes[a].n[k];
            part_.cut(n, planes[b].h - planes[a].h);
        }
        volumes[a] = std::max(0.0, part_.volume());
    }
}

}  // namespace votess::cpu
