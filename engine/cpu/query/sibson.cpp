#include "cpu/query/sibson.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

using Vector = Vector3;

constexpr std::size_t most_vertices = 128;
constexpr double never = 1e300;                 // h of a plane that is not there
constexpr double more_than_rounding = 0x1p-43;  // of the squared distances of neighbors

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
    for (const double moved : {0.0, more_than_rounding})
        if (read(shape, moved, moments, out) && add_rims(shape.polygons, out) && walk_inward(shape.polygons, out) &&
            walk_on(out) && out.finish())
            return true;
    return false;
}

bool Sibson::read(const ProbeShape& shape, double moved, bool moments, Division& out) {
    out.begin(moments);
    const std::size_t count = shape.planes.size();
    if (count > Division::most_neighbors) return false;
    for (std::size_t f = 0; f < count; ++f) {
        const ProbeShape::Plane& plane = shape.planes[f];
        if (plane.seed < 0) continue;
        const std::size_t a = out.add_neighbor(plane.seed, plane.n, plane.h);
        number_[f] = static_cast<std::uint8_t>(a);
        // By shares that follow no pattern.
        const double share = static_cast<double>(static_cast<std::uint32_t>(plane.seed) * 2654435761u) * 0x1p-32;
        h_[a] = plane.h + moved * share * dot(plane.n, plane.n);
        approached_[a] = 1;
    }
    for (std::size_t f = 0; f < count; ++f) {
        const ProbeShape::Plane& plane = shape.planes[f];
        if (plane.seed >= 0) continue;
        const std::size_t w = out.add_wall(plane.n, plane.h);
        number_[f] = static_cast<std::uint8_t>(w);
        h_[w] = plane.h;
        approached_[w] = 0;
    }
    normals_ = out.normals();
    padded_ = (count + 3) / 4 * 4;
    for (std::size_t i = count; i < padded_; ++i) h_[i] = never;
    return true;
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
            sides_[v][sides_known_[v]++] = {number_[f], static_cast<std::uint8_t>(w)};
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
            if (!out.is_wall(a) || !out.is_wall(back->face))
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
    const double excess = h_[a] - dot(n, from), speed = dot(n, along);
    alignas(32) std::array<double, Division::most_neighbors> times;
    for (std::size_t i = 0; i < padded_; i += 4) {
        const auto four = [i](const double* all) -> const Four& { return reinterpret_cast<const Four&>(all[i]); };
        const Four &nx = four(normals_.x), &ny = four(normals_.y), &nz = four(normals_.z);
        const Four& approached = four(approached_.data());
        const Four left = four(h_.data()) - nx * from[0] - ny * from[1] - nz * from[2] - approached * excess;
        const Four nearing = nx * along[0] + ny * along[1] + nz * along[2] - approached * speed;
        const Four none = Four{} + never;
        reinterpret_cast<Four&>(times[i]) = nearing > 0 ? left / nearing : none;
    }
    for (std::size_t i = normals_.count; i < padded_; ++i) times[i] = never;
    times[a] = times[b] = times[c] = never;
    double least = never;
    for (std::size_t i = 0; i < padded_; ++i) least = times[i] < least ? times[i] : least;
    if (!(least < never)) return false;
    std::size_t next = 0;
    while (times[next] != least) ++next;
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
        std::size_t a = sides_[v][0].face, b = sides_[v][1].face, c = sides_[v][2].face;
        // Neighbors have lower numbers than walls.
        if (b < a) std::swap(a, b);
        if (c < a) std::swap(a, c);
        if (out.is_wall(a)) continue;
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
