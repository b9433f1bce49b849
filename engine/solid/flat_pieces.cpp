#include "solid/flat_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/at.hpp"
#include "exact/predicate.hpp"
#include "solid/mesh_cells.hpp"
#include "solid/mesh_signs.hpp"

namespace votess::solid {
namespace {

struct OutlineEdge {
    std::int32_t from, to;
    std::int32_t source;
    std::uint8_t on_surface;
};
bool is_same_line(const OutlineEdge& a, const OutlineEdge& b) {
    return a.on_surface != 0 && b.on_surface != 0 && a.source == b.source;
}
using Ring = std::vector<OutlineEdge>;

struct Polygon {
    std::vector<Ring> rings;  // the outline first, then holes
    double area = 0;
    std::array<double, 2> centroid{};
};

// One piece of a sheet. Rounding of corners may let edges meet that do not. Then one of them bends to an end of the
// other one, which is nearer than rounding. So corners keep their places, which cells share.
class PrismPiece {
public:
    PrismPiece(const Pieces& all, std::size_t p, const MeshCells& cells)
        : cells_(cells), area_(all.volumes[p]), centroid_{all.centroids[3 * p], all.centroids[3 * p + 1]} {
        places_.reserve(at(all.vertex_offsets[p + 1] - all.vertex_offsets[p]));
        for (std::int64_t v = all.vertex_offsets[p]; v < all.vertex_offsets[p + 1]; ++v)
            places_.push_back({all.vertices[at(3 * v)], all.vertices[at(3 * v + 1)], 0});
        for (std::int64_t t = all.triangle_offsets[p]; t < all.triangle_offsets[p + 1]; ++t) {
            const std::int32_t source = all.sources[at(t)];
            const std::uint8_t on_surface = all.on_surface[at(t)];
            const bool is_wall = on_surface == 0 && (source == MeshCells::below || source == MeshCells::above);
            if (is_wall && source == MeshCells::below) continue;
            auto& edges = is_wall ? top_ : sides_;
            for (std::size_t k = 0; k < 3; ++k)
                edges.push_back({all.triangles[at(3 * t) + k], all.triangles[at(3 * t) + (k + 1) % 3],
                                 on_surface != 0 ? source / 2 : source, on_surface});
        }
    }

    // Returns no polygon for a piece without an area, except for rounding. Returns several where the piece is as narrow
    // as rounding.
    [[nodiscard]] std::vector<Polygon> polygons() {
        find_outline();
        join_places();
        std::vector<Ring> rings = split();
        if (keep_mesh_vertices(rings)) {
            join_places();
            rings = split();
        }
        find_error();
        for (std::size_t round = 8 * outline_.size(); round > 0 && mend(rings); --round) rings = split();
        return apart(std::move(rings));
    }

    [[nodiscard]] const exact::Point& place(std::int32_t v) const { return places_[at(v)]; }

private:
    static bool by_ends(const OutlineEdge& a, const OutlineEdge& b) {
        return std::pair(a.from, a.to) < std::pair(b.from, b.to);
    }

    // The edges of the upper face that the sides end, each named by its side.
    void find_outline() {
        std::ranges::sort(top_, by_ends);
        std::ranges::sort(sides_, by_ends);
        for (const OutlineEdge& edge : top_) {
            const OutlineEdge back{edge.to, edge.from, 0, 0};
            const auto side = std::ranges::lower_bound(sides_, back, by_ends);
            if (side == sides_.end() || by_ends(back, *side)) continue;
            outline_.push_back({edge.from, edge.to, side->source, side->on_surface});
        }
    }
    // Ties leave vertices at one place, also where the outline touches itself. The first then stands for all.
    void join_places() {
        const std::vector<OutlineEdge> given = std::move(outline_);
        std::vector<std::int32_t> order(places_.size());
        std::iota(order.begin(), order.end(), 0);
        std::ranges::stable_sort(order, {}, [&](std::int32_t v) { return place(v); });
        std::vector<std::int32_t> first(order.size());
        for (std::size_t k = 0; k < order.size(); ++k)
            first[at(order[k])] = k > 0 && place(order[k]) == place(order[k - 1]) ? first[at(order[k - 1])] : order[k];
        outline_.clear();
        for (OutlineEdge edge : given) {
            edge.from = first[at(edge.from)];
            edge.to = first[at(edge.to)];
            if (edge.from != edge.to) outline_.push_back(edge);
        }
        std::ranges::stable_sort(outline_, by_ends);
    }
    // Two edges of the mesh meet in a vertex, which is not rounded. Returns whether places changed.
    bool keep_mesh_vertices(const std::vector<Ring>& rings) {
        const auto& side = cells_.mesh.given();
        bool moved = false;
        for (const Ring& ring : rings)
            for (std::size_t e = 0; e < ring.size(); ++e) {
                const OutlineEdge &edge = ring[e], &next = ring[(e + 1) % ring.size()];
                if (edge.on_surface == 0 || next.on_surface == 0 || edge.source == next.source) continue;
                const std::int32_t v = side[2 * at(edge.source)][1];  // u v v' of the edge u v
                if (side[2 * at(next.source)][0] != v) continue;
                const exact::Point& x = cells_.mesh.vertex(v);
                const exact::Point given{x[0] / cells_.scale, x[1] / cells_.scale, 0};
                moved = moved || given != place(edge.to);
                places_[at(edge.to)] = given;
            }
        return moved;
    }
    // Finds a bound on the errors of corners.
    void find_error() {
        constexpr double of_extent = 0x1p-40, of_coordinate = 0x1p-50;
        double extent = 0, coordinate = 0;
        for (const OutlineEdge& edge : outline_)
            for (std::size_t k = 0; k < 2; ++k) {
                extent = std::max(extent, std::abs(place(edge.from)[k] - place(outline_.front().from)[k]));
                coordinate = std::max(coordinate, std::abs(place(edge.from)[k]));
            }
        error_ = of_extent * extent + of_coordinate * coordinate;
    }
    // Returns the rings. Walks around the inside turn to it wherever edges meet, so that each one surrounds a connected
    // part, and a place where it comes twice ends a ring. So rings of a polygon that share corners do not cut it.
    [[nodiscard]] std::vector<Ring> split() const {
        std::vector<Ring> found;
        std::vector<bool> used(outline_.size());
        Ring path;
        for (std::size_t e = 0; e < outline_.size(); ++e)
            for (std::size_t next = e; next < outline_.size() && !used[next];) {
                used[next] = true;
                path.push_back(outline_[next]);
                const std::int32_t v = path.back().to;
                next = edge_from(v, path.back().from, used);
                const auto begin = std::ranges::find(path, v, &OutlineEdge::from);
                if (begin != path.end()) {
                    Ring ring(begin, path.end());
                    join_lines(ring);
                    if (ring.size() > 2) found.push_back(std::move(ring));
                    path.erase(begin, path.end());
                }
            }
        return found;
    }
    // Returns the edge not used yet that turns most to the inside behind the edge u v, or the number of edges.
    [[nodiscard]] std::size_t edge_from(std::int32_t v, std::int32_t u, const std::vector<bool>& used) const {
        const int inside = area_ < 0 ? -1 : 1;
        const auto side = [&](std::int32_t a, std::int32_t b) {
            return inside * cross_sign(place(v), place(a), place(b), 2);
        };
        const auto turns_more = [&](std::int32_t a, std::int32_t b) {  // seen from v
            const int of_a = side(u, a), of_b = side(u, b);
            return of_a != of_b ? of_a < of_b : side(a, b) < 0;
        };
        std::size_t found = outline_.size();
        for (auto e = at(std::ranges::lower_bound(outline_, v, {}, &OutlineEdge::from) - outline_.begin());
             e < outline_.size() && outline_[e].from == v; ++e)
            if (!used[e] && (found == outline_.size() || turns_more(outline_[e].to, outline_[found].to))) found = e;
        return found;
    }
    // Sides of a prism are two triangles, which meet within an edge of the mesh.
    static void join_lines(Ring& ring) {
        if (ring.size() < 2) return;
        const auto begins =
            std::ranges::adjacent_find(ring, [](const auto& a, const auto& b) { return !is_same_line(a, b); });
        if (begins == ring.end()) return;
        std::ranges::rotate(ring, begins + 1);
        std::size_t out = 0;
        for (std::size_t e = 1; e < ring.size(); ++e) {
            if (is_same_line(ring[out], ring[e]))
                ring[out].to = ring[e].to;
            else
                ring[++out] = ring[e];
        }
        ring.resize(out + 1);
    }

    // Bends edges that meet to a corner, by less than the error of corners. Returns whether it did.
    bool mend(const std::vector<Ring>& rings) {
        outline_.clear();
        links_.clear();
        for (const Ring& ring : rings)
            for (std::size_t e = 0; e < ring.size(); ++e) {
                const std::size_t first = outline_.size() - e;
                links_.push_back({first, first + (e + 1) % ring.size()});
                outline_.push_back(ring[e]);
            }
        std::vector<bool> bent(outline_.size());
        for (const auto& [e, f] : meetings())
            if (!bent[e] && !bent[f]) bend(e, f, bent);
        if (outline_.size() == bent.size()) return false;
        std::ranges::stable_sort(outline_, by_ends);
        open_lines();
        return true;
    }
    // Removes pairs of opposite edges: a ring along another one, or along itself, opens there.
    void open_lines() {
        std::vector<bool> removed(outline_.size());
        std::vector<OutlineEdge> kept;
        for (std::size_t e = 0; e < outline_.size(); ++e) {
            const OutlineEdge& edge = outline_[e];
            const auto [begin, end] =
                std::ranges::equal_range(outline_, OutlineEdge{edge.to, edge.from, 0, 0}, by_ends);
            auto back = begin;
            while (back != end && removed[at(back - outline_.begin())]) ++back;
            if (!removed[e] && back != end)
                removed[e] = removed[at(back - outline_.begin())] = true;
            else if (!removed[e])
                kept.push_back(edge);
        }
        outline_ = std::move(kept);
    }
    [[nodiscard]] bool is_beside(std::int32_t v, const OutlineEdge& edge) const {
        double before = 0, behind = 0;
        for (std::size_t k = 0; k < 2; ++k) {
            const double along = place(edge.to)[k] - place(edge.from)[k];
            before += along * (place(v)[k] - place(edge.from)[k]);
            behind += along * (place(edge.to)[k] - place(v)[k]);
        }
        return before > 0 && behind > 0;
    }
    // Bends one of two edges to an end of the other one, if that is near.
    void bend(std::size_t e, std::size_t f, std::vector<bool>& bent) {
        std::size_t which = none;
        std::int32_t corner = 0;
        double nearest = error_;
        for (const auto& [a, b] : {std::pair(e, f), std::pair(f, e)})
            for (const std::int32_t v : {outline_[b].from, outline_[b].to}) {
                const OutlineEdge& edge = outline_[a];
                const double away = std::abs(turn(edge.from, edge.to, v)) / length(edge);
                if (is_beside(v, edge) && away <= nearest) which = a, corner = v, nearest = away;
            }
        if (which == none) return;
        OutlineEdge half = outline_[which];
        outline_[which].to = half.from = corner;
        outline_.push_back(half);
        bent[which] = true;
    }
    // Returns the pairs of edges that have more in common than their ring or rings may.
    [[nodiscard]] std::vector<std::pair<std::size_t, std::size_t>> meetings() const {
        std::vector<std::size_t> order(outline_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::ranges::stable_sort(order, {}, [&](std::size_t e) { return span(outline_[e], 0).first; });
        std::vector<std::pair<std::size_t, std::size_t>> found;
        for (auto e = order.begin(); e != order.end(); ++e) {
            const double right = span(outline_[*e], 0).second;
            const auto [low, high] = span(outline_[*e], 1);
            for (auto f = e + 1; f != order.end() && span(outline_[*f], 0).first <= right; ++f)
                if (span(outline_[*f], 1).first <= high && low <= span(outline_[*f], 1).second && meet(*e, *f))
                    found.push_back({*e, *f});
        }
        return found;
    }
    // The boxes of the edges meet. Edges of one ring may share the corner between them, those of two rings corners.
    [[nodiscard]] bool meet(std::size_t e, std::size_t f) const {
        const OutlineEdge &a = outline_[e], &b = outline_[f];
        const auto side = [&](const OutlineEdge& edge, std::int32_t v) {
            return cross_sign(place(edge.from), place(edge.to), place(v), 2);
        };
        const auto overlap = [&](std::size_t k) {
            return std::max(span(a, k).first, span(b, k).first) < std::min(span(a, k).second, span(b, k).second);
        };
        const bool one_ring = links_[e].ring == links_[f].ring;
        const bool apart = one_ring && links_[e].next != f && links_[f].next != e;
        const std::array<int, 4> sides{side(a, b.from), side(a, b.to), side(b, a.from), side(b, a.to)};
        if (sides == std::array<int, 4>{}) return apart || overlap(0) || overlap(1);
        const int first = sides[0] * sides[1], second = sides[2] * sides[3];
        if (apart) return first <= 0 && second <= 0;
        const auto within = [&](int sign, std::int32_t v, const OutlineEdge& edge) {
            return sign == 0 && is_beside(v, edge);
        };
        return (first < 0 && second < 0) || (!one_ring && (within(sides[0], b.from, a) || within(sides[1], b.to, a) ||
                                                           within(sides[2], a.from, b) || within(sides[3], a.to, b)));
    }
    [[nodiscard]] std::pair<double, double> span(const OutlineEdge& edge, std::size_t k) const {
        return std::minmax({place(edge.from)[k], place(edge.to)[k]});
    }

    // Returns the outlines, each with its holes.
    [[nodiscard]] std::vector<Polygon> apart(std::vector<Ring> rings) const {
        std::ranges::stable_sort(rings, std::ranges::greater(), [&](const Ring& ring) { return std::abs(area(ring)); });
        if (!rings.empty() && (area(rings.front()) < 0) != (area_ < 0) && is_rounding(rings.front())) return {};
        if (!rings.empty())
            rings.erase(
                std::remove_if(rings.begin() + 1, rings.end(), [&](const Ring& ring) { return is_rounding(ring); }),
                rings.end());
        std::vector<Polygon> found;
        double first = 0;
        for (Ring& ring : rings) {
            const double own = area(ring);
            if (found.empty()) first = own;
            if ((own > 0) == (first > 0) || found.empty()) found.emplace_back();
            auto of = found.end() - 1;
            while (of != found.begin() && !of->rings.empty() && !contains(of->rings.front(), ring)) --of;
            of->rings.push_back(std::move(ring));
        }
        if (found.size() == 1) {
            found.front().area = area_;
            found.front().centroid = centroid_;
            return found;
        }
        double sum = 0;
        for (Polygon& polygon : found) sum += measure(polygon);
        for (Polygon& polygon : found) polygon.area *= area_ / sum;
        return found;
    }
    // Returns whether a ring other than the largest one has no area, except for rounding. Holes of a mesh may be as
    // thin.
    [[nodiscard]] bool is_rounding(const Ring& ring) const {
        double perimeter = 0;
        for (const OutlineEdge& edge : ring) perimeter += length(edge);
        return std::abs(area(ring)) <= error_ * perimeter && !std::ranges::all_of(ring, &OutlineEdge::on_surface);
    }
    // Returns whether a ring surrounds the middle of the first edge of another one.
    [[nodiscard]] bool contains(const Ring& ring, const Ring& other) const {
        const exact::Point &from = place(other.front().from), &to = place(other.front().to);
        const double x = 0.5 * (from[0] + to[0]), y = 0.5 * (from[1] + to[1]);
        bool inside = false;
        for (const OutlineEdge& edge : ring) {
            const exact::Point &a = place(edge.from), &b = place(edge.to);
            if ((a[1] <= y) != (b[1] <= y) && a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])) > x) inside = !inside;
        }
        return inside;
    }
    // Finds the area and the centroid from the rings. Returns the area.
    double measure(Polygon& polygon) const {
        const std::int32_t base = polygon.rings.front().front().from;
        for (const Ring& ring : polygon.rings)
            for (const OutlineEdge& edge : ring) {
                const double doubled = turn(base, edge.from, edge.to);
                polygon.area += 0.5 * doubled;
                for (std::size_t k = 0; k < 2; ++k)
                    polygon.centroid[k] +=
                        doubled * (place(edge.from)[k] - place(base)[k] + (place(edge.to)[k] - place(base)[k]));
            }
        for (std::size_t k = 0; k < 2; ++k)
            polygon.centroid[k] = place(base)[k] + polygon.centroid[k] / (6 * polygon.area);
        return polygon.area;
    }
    // Returns twice the area of a triangle, positive if it is counterclockwise.
    [[nodiscard]] double turn(std::int32_t a, std::int32_t b, std::int32_t c) const {
        const exact::Point &from = place(a), &to = place(b), &third = place(c);
        return (to[0] - from[0]) * (third[1] - from[1]) - (third[0] - from[0]) * (to[1] - from[1]);
    }
    // Returns twice the area within a ring.
    [[nodiscard]] double area(const Ring& ring) const {
        double sum = 0;
        for (const OutlineEdge& edge : ring) sum += turn(ring.front().from, edge.from, edge.to);
        return sum;
    }
    [[nodiscard]] double length(const OutlineEdge& edge) const {
        return std::hypot(place(edge.to)[0] - place(edge.from)[0], place(edge.to)[1] - place(edge.from)[1]);
    }

    struct Link {
        std::size_t ring, next;  // the first edge of the ring
    };
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

    const MeshCells& cells_;
    double area_;
    std::array<double, 2> centroid_;
    std::vector<exact::Point> places_;  // z = 0
    double error_ = 0;                  // of places
    std::vector<OutlineEdge> top_, sides_, outline_;
    std::vector<Link> links_;  // of the outline, while it is mended
};

}  // namespace

Pieces flat_pieces(const Pieces& prisms, const MeshCells& cells, std::span<const std::int32_t> edges) {
    Pieces flat;
    flat.indptr = flat.vertex_offsets = flat.triangle_offsets = {0};
    const auto add = [&](const PrismPiece& piece, const Polygon& polygon) {
        std::int32_t first = 0;  // vertex of the ring
        for (const Ring& ring : polygon.rings) {
            const auto size = static_cast<std::int32_t>(ring.size());
            for (std::int32_t v = 0; v < size; ++v) {
                const OutlineEdge& edge = ring[at(v)];
                const exact::Point& x = piece.place(edge.from);
                flat.vertices.insert(flat.vertices.end(), {x[0], x[1]});
                flat.triangles.insert(flat.triangles.end(), {first + v, first + (v + 1) % size});
                flat.on_surface.push_back(edge.on_surface);
                flat.sources.push_back(edge.on_surface != 0 ? edges[at(edge.source)] : edge.source);
            }
            first += size;
        }
        flat.vertex_offsets.push_back(static_cast<std::int64_t>(flat.vertices.size() / 2));
        flat.triangle_offsets.push_back(static_cast<std::int64_t>(flat.sources.size()));
        flat.volumes.push_back(polygon.area);
        flat.centroids.insert(flat.centroids.end(), polygon.centroid.begin(), polygon.centroid.end());
    };
    for (std::size_t row = 0; row + 1 < prisms.indptr.size(); ++row) {
        std::vector<PrismPiece> pieces;
        std::vector<std::pair<std::size_t, Polygon>> polygons;
        for (std::int64_t p = prisms.indptr[row]; p < prisms.indptr[row + 1]; ++p) {
            pieces.emplace_back(prisms, at(p), cells);
            for (Polygon& polygon : pieces.back().polygons())
                polygons.emplace_back(pieces.size() - 1, std::move(polygon));
        }
        std::ranges::stable_sort(polygons, std::ranges::greater(), [](const auto& one) { return one.second.area; });
        for (const auto& [piece, polygon] : polygons) add(pieces[piece], polygon);
        flat.indptr.push_back(static_cast<std::int64_t>(flat.size()));
    }
    return flat;
}

}  // namespace votess::solid
