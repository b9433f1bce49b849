#include "solid/flat_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "core/at.hpp"
#include "solid/mesh_cells.hpp"

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

// One piece of a sheet.
class PrismPiece {
public:
    PrismPiece(const Pieces& all, std::size_t p)
        : vertices_(std::span(all.vertices)
                        .subspan(at(3 * all.vertex_offsets[p]),
                                 at(3 * (all.vertex_offsets[p + 1] - all.vertex_offsets[p])))) {
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

    // Returns the rings of the outline, the longest one first. No ring visits a place twice, except where others than
    // the first would turn counterclockwise then: parts of the piece that touch in a point.
    [[nodiscard]] std::vector<Ring> rings() {
        find_outline();
        const std::vector<OutlineEdge> outline = outline_;
        join_places();
        std::vector<Ring> found = split();
        if (std::ranges::count_if(found, [&](const Ring& ring) { return area(ring) > 0; }) > 1) {
            outline_ = outline;
            found = split();
        }
        std::ranges::stable_sort(found, std::ranges::greater(), [&](const Ring& ring) { return length(ring); });
        return found;
    }

    [[nodiscard]] std::array<double, 2> place(std::int32_t v) const {
        return {vertices_[at(3 * v)], vertices_[at(3 * v) + 1]};
    }

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
        std::vector<std::int32_t> order(vertices_.size() / 3);
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
    [[nodiscard]] std::vector<Ring> split() const {
        std::vector<Ring> found;
        std::vector<bool> used(outline_.size());
        Ring path;
        for (std::size_t e = 0; e < outline_.size(); ++e)
            for (std::size_t next = e; next < outline_.size() && !used[next];) {
                used[next] = true;
                path.push_back(outline_[next]);
                const std::int32_t v = path.back().to;
                const auto begin = std::ranges::find(path, v, &OutlineEdge::from);
                if (begin != path.end()) {
                    Ring ring(begin, path.end());
                    join_lines(ring);
                    drop_short_edges(ring);
                    if (ring.size() > 2) found.push_back(std::move(ring));
                    path.erase(begin, path.end());
                }
                next = edge_from(v, used);
            }
        return found;
    }
    // Returns an edge that is not used yet, or the number of edges.
    [[nodiscard]] std::size_t edge_from(std::int32_t v, const std::vector<bool>& used) const {
        auto e = std::ranges::lower_bound(outline_, v, {}, &OutlineEdge::from);
        while (e != outline_.end() && e->from == v && used[at(e - outline_.begin())]) ++e;
        return e != outline_.end() && e->from == v ? at(e - outline_.begin()) : outline_.size();
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
    // Ties leave edges whose ends are at one place. Near ties leave edges as short as the errors of corners, which
    // rounding turns around: then the edges before and after cross.
    void drop_short_edges(Ring& ring) const {
        constexpr double of_extent = 0x1p-40, of_coordinate = 0x1p-50;
        const auto close = [&] {
            for (std::size_t e = 0; e < ring.size(); ++e) ring[e].to = ring[(e + 1) % ring.size()].from;
        };
        std::erase_if(ring, [&](const OutlineEdge& edge) { return place(edge.from) == place(edge.to); });
        close();
        double extent = 0, coordinate = 0;
        for (const OutlineEdge& edge : ring)
            for (std::size_t k = 0; k < 2; ++k) {
                extent = std::max(extent, std::abs(place(edge.from)[k] - place(ring.front().from)[k]));
                coordinate = std::max(coordinate, std::abs(place(edge.from)[k]));
            }
        const double error = of_extent * extent + of_coordinate * coordinate;
        for (std::size_t e = 0; e < ring.size();) {
            if (length({ring[e]}) > error ||
                !cross(ring[(e + ring.size() - 1) % ring.size()], ring[(e + 1) % ring.size()])) {
                ++e;
                continue;
            }
            ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(e));
            close();
            e = 0;
        }
    }
    [[nodiscard]] bool cross(const OutlineEdge& one, const OutlineEdge& other) const {
        const auto divides = [&](const OutlineEdge& edge, std::int32_t near, std::int32_t a, std::int32_t b) {
            const std::int32_t far = near == edge.from ? edge.to : edge.from;
            const double turn_a = turn(near, far, a), turn_b = turn(near, far, b);
            return (turn_a < 0 && turn_b > 0) || (turn_a > 0 && turn_b < 0);
        };
        return divides(one, one.to, other.from, other.to) && divides(other, other.from, one.from, one.to);
    }
    // Returns twice the area of a triangle, positive if it is counterclockwise.
    [[nodiscard]] double turn(std::int32_t a, std::int32_t b, std::int32_t c) const {
        const auto from = place(a), to = place(b), third = place(c);
        return (to[0] - from[0]) * (third[1] - from[1]) - (third[0] - from[0]) * (to[1] - from[1]);
    }
    [[nodiscard]] double area(const Ring& ring) const {
        double sum = 0;
        for (const OutlineEdge& edge : ring) sum += turn(ring.front().from, edge.from, edge.to);
        return sum;
    }
    [[nodiscard]] double length(const Ring& ring) const {
        double sum = 0;
        for (const OutlineEdge& edge : ring) {
            const auto a = place(edge.from), b = place(edge.to);
            sum += std::hypot(b[0] - a[0], b[1] - a[1]);
        }
        return sum;
    }

    std::span<const double> vertices_;
    std::vector<OutlineEdge> top_, sides_, outline_;
};

}  // namespace

Pieces flat_pieces(const Pieces& prisms, const MeshCells& cells, std::span<const std::int32_t> edges) {
    // Returns the vertex of the mesh that ends an edge of an outline, if the next one lies on another edge there.
    const auto mesh_vertex = [&](const OutlineEdge& edge,
                                 const OutlineEdge& next) -> std::optional<std::array<double, 2>> {
        if (edge.on_surface == 0 || next.on_surface == 0 || edge.source == next.source) return std::nullopt;
        const auto& side = cells.mesh.given();
        const std::int32_t v = side[2 * at(edge.source)][1];  // u v v' of the edge u v
        if (side[2 * at(next.source)][0] != v) return std::nullopt;
        const exact::Point& x = cells.mesh.vertex(v);
        return std::array{x[0] / cells.scale, x[1] / cells.scale};
    };
    Pieces flat;
    flat.indptr = flat.vertex_offsets = flat.triangle_offsets = {0};
    const auto add = [&](std::size_t p) {
        PrismPiece piece(prisms, p);
        const std::vector<Ring> rings = piece.rings();
        if (rings.empty()) return;  // without an area, except for rounding
        std::int32_t first = 0;     // vertex of the ring
        for (const Ring& ring : rings)
            for (std::size_t e = 0; e < ring.size(); ++e) {
                const OutlineEdge &edge = ring[e], &before = ring[e > 0 ? e - 1 : ring.size() - 1];
                const auto x = mesh_vertex(before, edge).value_or(piece.place(edge.from));
                flat.vertices.insert(flat.vertices.end(), x.begin(), x.end());
                const auto v = static_cast<std::int32_t>(e);
                const std::int32_t next = e + 1 < ring.size() ? v + 1 : 0;
                flat.triangles.insert(flat.triangles.end(), {first + v, first + next});
                flat.on_surface.push_back(edge.on_surface);
                flat.sources.push_back(edge.on_surface != 0 ? edges[at(edge.source)] : edge.source);
                if (next == 0) first += static_cast<std::int32_t>(ring.size());
            }
        flat.vertex_offsets.push_back(static_cast<std::int64_t>(flat.vertices.size() / 2));
        flat.triangle_offsets.push_back(static_cast<std::int64_t>(flat.sources.size()));
        flat.volumes.push_back(prisms.volumes[p]);
        for (std::size_t k = 0; k < 2; ++k) flat.centroids.push_back(prisms.centroids[3 * p + k]);
    };
    for (std::size_t row = 0; row + 1 < prisms.indptr.size(); ++row) {
        for (std::int64_t p = prisms.indptr[row]; p < prisms.indptr[row + 1]; ++p) add(at(p));
        flat.indptr.push_back(static_cast<std::int64_t>(flat.size()));
    }
    return flat;
}

}  // namespace votess::solid
