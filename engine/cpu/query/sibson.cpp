#include "cpu/query/sibson.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/progress.hpp"
#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

using Vector = Vector3;

constexpr std::size_t most_vertices = 128, none = ~std::size_t{0};
constexpr double never = 1e300;                 // h of a plane that is not there
constexpr double more_than_rounding = 0x1p-43;  // of the squared distances of neighbors

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

bool Sibson::divide(const ProbeShape& shape, bool moments, Division& out) {
    if (shape.planes.size() > Division::most_neighbors) return false;
    for (const double moved : {0.0, more_than_rounding}) {
        read(shape, moved, moments, out);
        const bool known = moved == 0 ? read_corners(shape.polygons) : walk_surface(shape.polygons, out);
        if (known && walk_inward(out) && walk_on(out) && out.add_rims() && out.finish()) return true;
    }
    return false;
}

void Sibson::read(const ProbeShape& shape, double moved, bool moments, Division& out) {
    out.begin(shape.weighted, moments);
    const auto& planes = shape.planes;
    for (std::size_t f = 0; f < planes.size(); ++f) {
        if (planes[f].seed < 0) continue;
        const std::size_t a = out.add_neighbor(planes[f].seed, planes[f].n, planes[f].h);
        number_[f] = static_cast<std::uint8_t>(a);
        // The shares follow no pattern; images of one seed have others.
        const double share = static_cast<double>((static_cast<std::uint32_t>(f) + 1) * 2654435761u) * 0x1p-32;
        h_[a] = planes[f].h + moved * share * dot(planes[f].n, planes[f].n);
        approached_[a] = 1;
    }
    for (std::size_t f = 0; f < planes.size(); ++f) {
        if (planes[f].seed >= 0) continue;
        const std::size_t w = out.add_wall(planes[f].n, planes[f].h);
        number_[f] = static_cast<std::uint8_t>(w);
        h_[w] = planes[f].h;
        approached_[w] = 0;
    }
    normals_ = out.normals();
    padded_ = (planes.size() + 3) / 4 * 4;
    for (std::size_t i = planes.size(); i < padded_; ++i) h_[i] = never, approached_[i] = 0;
}

// False where more than three faces meet.
bool Sibson::read_corners(const CellPolygons& polygons) {
    const std::size_t vertices = polygons.positions.size();
    planes_known_.assign(vertices, 0);
    corners_.resize(vertices);
    for (std::size_t f = 0; f < polygons.size(); ++f)
        for (std::uint32_t k = polygons.offsets[f]; k < polygons.offsets[f + 1]; ++k) {
            const std::uint32_t v = polygons.corners[k];
            if (planes_known_[v] == 3) return false;
            corners_[v].planes[planes_known_[v]++] = number_[f];
        }
    // Vertices of no face may be there, too.
    std::size_t count = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        if (planes_known_[v] == 0) continue;
        if (planes_known_[v] != 3) return false;
        corners_[count++] = {corners_[v].planes, polygons.positions[v]};
    }
    corners_.resize(count);
    return true;
}

// Walks from a point inside to a face, an edge and a corner of the cell, and along the edges to all others.
bool Sibson::walk_surface(const CellPolygons& polygons, const Division& division) {
    Vector x{};
    for (const std::uint32_t corner : polygons.corners)
        for (std::size_t k = 0; k < 3; ++k)
            x[k] += polygons.positions[corner][k] / static_cast<double>(polygons.corners.size());
    const std::size_t a = go(x, division.normal(0), 0);
    if (a == none) return false;
    const std::size_t b = go(x, cross(division.normal(a), {0.36, 0.48, 0.8}), 1u << a);
    if (b == none) return false;
    const std::size_t c = go(x, cross(division.normal(a), division.normal(b)), 1u << a | 1u << b);
    if (c == none) return false;
    const auto corner_at = [](std::size_t i, std::size_t j, std::size_t k, const Vector& at) {
        return Corner{{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j), static_cast<std::uint8_t>(k)}, at};
    };
    corners_.assign(1, corner_at(a, b, c, x));
    for (std::size_t v = 0; v < corners_.size(); ++v)
        for (std::size_t leaving = 0; leaving < 3; ++leaving) {
            const std::size_t i = corners_[v].planes[(leaving + 1) % 3], j = corners_[v].planes[(leaving + 2) % 3];
            const auto has_both = [i, j, v, this](const Corner& corner) {
                return &corner != &corners_[v] && std::ranges::find(corner.planes, i) != corner.planes.end() &&
                       std::ranges::find(corner.planes, j) != corner.planes.end();
            };
            if (std::ranges::any_of(corners_, has_both)) continue;
            Vector along = cross(division.normal(i), division.normal(j)), to = corners_[v].x;
            if (dot(along, division.normal(corners_[v].planes[leaving])) > 0) along = {-along[0], -along[1], -along[2]};
            const std::size_t next = go(to, along, 1u << i | 1u << j);
            if (next == none || corners_.size() == most_vertices) return false;
            corners_.push_back(corner_at(i, j, next, to));
        }
    return true;
}

// The vertex from number `begin` on that is as near to three neighbors.
Sibson::Vertex* Sibson::find(std::uint32_t three, std::size_t begin) {
    for (std::size_t v = begin; v < vertices_.size(); ++v)
        if ((vertices_[v].near & three) == three) return &vertices_[v];
    return nullptr;
}

// The plane that a ray meets first, but for some; neighbors come nearer than one with that excess and speed. none: it
// meets none.
std::size_t Sibson::meet(const Vector& from, const Vector& along, std::uint32_t without, double excess, double speed,
                         double& time) const {
    using Four __attribute__((vector_size(32), aligned(32), may_alias)) = double;
    alignas(32) std::array<double, Division::most_neighbors> times;
    for (std::size_t i = 0; i < padded_; i += 4) {
        const auto four = [i](const double* all) -> const Four& { return reinterpret_cast<const Four&>(all[i]); };
        const Four &nx = four(normals_.x), &ny = four(normals_.y), &nz = four(normals_.z);
        const Four& approached = four(approached_.data());
        const Four left = four(h_.data()) - nx * from[0] - ny * from[1] - nz * from[2] - approached * excess;
        const Four nearing = nx * along[0] + ny * along[1] + nz * along[2] - approached * speed;
        const Four never_met = Four{} + never;
        reinterpret_cast<Four&>(times[i]) = nearing > 0 ? left / nearing : never_met;
    }
    for (std::size_t i = normals_.count; i < padded_; ++i) times[i] = never;
    for (; without != 0; without &= without - 1) times[static_cast<std::size_t>(std::countr_zero(without))] = never;
    time = never;
    for (std::size_t i = 0; i < padded_; ++i) time = times[i] < time ? times[i] : time;
    if (!(time < never)) return none;
    std::size_t next = 0;
    while (times[next] != time) ++next;
    return next;
}

// Moves x to the plane that a ray meets first.
std::size_t Sibson::go(Vector& x, const Vector& along, std::uint32_t without) const {
    double time = 0;
    const std::size_t next = meet(x, along, without, 0, 0, time);
    for (std::size_t k = 0; k < 3 && next != none; ++k) x[k] += time * along[k];
    return next;
}

// Goes along an edge of three neighbors from a vertex to a new one, where the next neighbor is as near.
bool Sibson::leave(const Division& division, const Vector& from, std::uint32_t three, const Vector& along, Vector& to) {
    const std::size_t a = numbers_of(three).a;
    const Vector n = division.normal(a);
    double time = 0;
    const std::size_t next = meet(from, along, three, h_[a] - dot(n, from), dot(n, along), time);
    if (next == none || vertices_.size() == most_vertices) return false;
    for (std::size_t k = 0; k < 3; ++k) to[k] = from[k] + time * along[k];
    vertices_.push_back({three | 1u << next, 1u << next, to});
    return true;
}

// Walks along the edges that begin at the corners of the cell.
bool Sibson::walk_inward(Division& out) {
    vertices_.clear();
    for (const Corner& corner : corners_) {
        std::size_t a = corner.planes[0], b = corner.planes[1], c = corner.planes[2];
        // Neighbors have lower numbers than walls.
        if (b < a) std::swap(a, b);
        if (c < a) std::swap(a, c);
        if (out.is_wall(a)) continue;
        const Vector along = turn(out, a, b, c, out.normal(a), {});
        const std::uint32_t three = 1u << a | 1u << b | 1u << c;
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

// What a neighbor had of the cell is nearer to it than to the others, and nearer to the probe than to it: the faces of
// the others are implied. Those whose faces meet its own cut first, for they leave little to look at.
void Sibson::cut(const ProbeShape& shape, std::vector<double>& volumes) {
    const CellPolygons& polygons = shape.polygons;
    const auto& planes = shape.planes;
    Vector lower{}, upper{};
    for (const std::uint32_t corner : polygons.corners)
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], polygons.positions[corner][k]);
            upper[k] = std::max(upper[k], polygons.positions[corner][k]);
        }
    for (std::size_t k = 0; k < 3; ++k) {
        const double room = (upper[k] - lower[k]) / 8;
        lower[k] -= room, upper[k] += room;
    }
    read_meetings(polygons);
    volumes.assign(planes.size(), 0);
    for (std::size_t a = 0; a < planes.size(); ++a) {
        if (planes[a].seed < 0) continue;
        part_.clear();
        part_.add_box(lower, upper);
        part_.cut(planes[a].n, planes[a].h);
        cut_done_.assign(planes.size(), false);
        cut_done_[a] = true;
        for (const std::uint32_t corner : polygons.face(a))
            for (std::uint32_t m = meeting_begin_[corner]; m < meeting_begin_[corner + 1]; ++m)
                if (!cut_done_[meeting_[m]]) cut_by(shape, a, meeting_[m]);
        const auto [center, radius] = part_.ball();
        for (std::size_t b = 0; b < planes.size() && !part_.empty(); ++b) {
            if (cut_done_[b]) continue;
            const auto [n, h] = limit(shape, a, b);
            if (h - dot(n, center) < radius * std::sqrt(dot(n, n))) cut_by(shape, a, b);
        }
        volumes[a] = std::max(0.0, part_.volume());
    }
}

// The faces that meet at each vertex.
void Sibson::read_meetings(const CellPolygons& polygons) {
    meeting_begin_.assign(polygons.positions.size() + 1, 0);
    for (const std::uint32_t corner : polygons.corners) ++meeting_begin_[corner + 1];
    std::partial_sum(meeting_begin_.begin(), meeting_begin_.end(), meeting_begin_.begin());
    meeting_.resize(polygons.corners.size());
    std::vector<std::uint32_t>& next = meeting_next_;
    next.assign(meeting_begin_.begin(), meeting_begin_.end() - 1);
    for (std::uint32_t f = 0; f < polygons.size(); ++f)
        for (const std::uint32_t corner : polygons.face(f)) meeting_[next[corner]++] = f;
}

// Where plane b ends what neighbor a had: n.x <= h.
Sibson::Limit Sibson::limit(const ProbeShape& shape, std::size_t a, std::size_t b) {
    const ProbeShape::Plane &of_a = shape.planes[a], &of_b = shape.planes[b];
    if (of_b.seed < 0) return {of_b.n, of_b.h};
    return {minus(of_b.n, of_a.n), of_b.h - of_a.h};
}

void Sibson::cut_by(const ProbeShape& shape, std::size_t a, std::size_t b) {
    check_stop();
    cut_done_[b] = true;
    const auto [n, h] = limit(shape, a, b);
    part_.cut(n, h);
}

}  // namespace votess::cpu
