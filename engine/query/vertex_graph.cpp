#include "query/vertex_graph.hpp"

#include <algorithm>
#include <cmath>

#include "core/progress.hpp"
#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

using Vector = Vector3;

constexpr double worst_condition = 64;  // product of lengths over the determinant: then a vertex is solved exactly
// Of the squared distance of a vertex from its seeds, which is known to less than that.
constexpr double uncertain = 0x1p-38;
constexpr double off_plane = 0x1p-46;          // of the terms that place a corner on a plane
constexpr std::size_t cells_per_check = 1024;  // or vertices, after which the user may stop

}  // namespace

VertexGraph::VertexGraph(const SortedSeeds& seeds, const Tessellation& t, double scale) {
    const std::size_t vertices = t.vertices().size() / 3;
    const auto indptr = t.cell_vertex_indptr();
    const auto indices = t.cell_vertex_indices();
    lengthen(cells_begin_, vertices + 1);
    in_pieces(indices.size(), [&](std::size_t begin, std::size_t end) {
        for (const std::int32_t v : indices.subspan(begin, end - begin))
            ++cells_begin_[static_cast<std::size_t>(v) + 1];
    });
    for (std::size_t v = 0; v < vertices; ++v) cells_begin_[v + 1] += cells_begin_[v];
    lengthen(cells_, indices.size());
    lengthen(first_, t.size(), none);
    std::vector<std::int64_t> next(cells_begin_.begin(), cells_begin_.end() - 1);
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (i % cells_per_check == 0) check_stop();
        const auto begin = static_cast<std::size_t>(indptr[i]), end = static_cast<std::size_t>(indptr[i + 1]);
        if (begin < end) first_[i] = indices[begin];
        for (std::size_t k = begin; k < end; ++k)
            cells_[static_cast<std::size_t>(next[static_cast<std::size_t>(indices[k])]++)] =
                static_cast<std::int32_t>(i);
    }
    lengthen(vertices_, vertices);
    place(seeds, t, scale);
    link(t);
    cells_begin_ = {};
    cells_ = {};
}

void VertexGraph::place(const SortedSeeds& seeds, const Tessellation& t, double scale) {
    const auto place_of = [&](std::int32_t seed) {
        const auto i = static_cast<std::size_t>(seed);
        return Vector{seeds.x[i], seeds.y[i], seeds.z[i]};
    };
    const auto weight_of = [&](std::int32_t seed) {
        return seeds.weights.empty() ? 0 : seeds.weights[static_cast<std::size_t>(seed)];
    };
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        if (v % cells_per_check == 0) check_stop();
        Vertex& vertex = vertices_[v];
        const auto begin = static_cast<std::size_t>(cells_begin_[v]);
        const std::size_t count = static_cast<std::size_t>(cells_begin_[v + 1]) - begin;
        vertex.next.fill(none);
        vertex.cells.fill(none);
        std::copy_n(&cells_[begin], std::min<std::size_t>(count, 4), vertex.cells.begin());
        const Vector first = place_of(vertex.cells[0]);
        std::array<Vector, 3> n{};
        std::array<double, 3> h{};
        for (std::size_t k = 0; k < 3 && count == 4; ++k) {
            const Vector other = place_of(vertex.cells[k + 1]);
            for (std::size_t c = 0; c < 3; ++c) n[k][c] = other[c] - first[c];
            h[k] = 0.5 * (dot(n[k], n[k]) + weight_of(vertex.cells[0]) - weight_of(vertex.cells[k + 1]));
        }
        const double determinant = count == 4 ? dot(n[0], cross(n[1], n[2])) : 0;
        const double size = count == 4 ? std::sqrt(dot(n[0], n[0]) * dot(n[1], n[1]) * dot(n[2], n[2])) : 0;
        int sign = determinant > 0 ? 1 : -1;
        if (size < worst_condition * std::abs(determinant)) {
            const Vector a = cross(n[1], n[2]), b = cross(n[2], n[0]), c = cross(n[0], n[1]);
            for (std::size_t k = 0; k < 3; ++k)
                vertex.from[k] = (h[0] * a[k] + h[1] * b[k] + h[2] * c[k]) / determinant;
        } else if (count == 4) {
            std::array<exact::Plane, 3> plane;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::int32_t other = vertex.cells[k + 1];
                plane[k] = exact::Plane::bisector(place_of(other));
                plane[k].power = exact::two_sum(weight_of(vertex.cells[0]), -weight_of(other));
            }
            sign = exact::orientation(first, plane[0], plane[1], plane[2]);
            if (sign != 0) vertex.from = exact::vertex_position<double>(first, plane[0], plane[1], plane[2]);
        }
        if (count != 4 || sign == 0) {
            vertex.cells[3] = none;
            for (std::size_t k = 0; k < 3; ++k) vertex.from[k] = t.vertices()[3 * v + k] * scale - first[k];
        } else if (sign > 0) {
            std::swap(vertex.cells[1], vertex.cells[2]);
        }
        vertex.power = dot(vertex.from, vertex.from) - weight_of(vertex.cells[0]);
    }
}

// Each edge of a polygon: of the four cells of one end, the other end has all but one.
void VertexGraph::link(const Tessellation& t) {
    const auto has = [this](std::int32_t v, std::int32_t cell) {
        const auto begin = cells_.begin() + cells_begin_[static_cast<std::size_t>(v)];
        const auto end = cells_.begin() + cells_begin_[static_cast<std::size_t>(v) + 1];
        return std::find(begin, end, cell) != end;
    };
    const auto join = [&](std::int32_t v, std::int32_t w) {
        Vertex& vertex = vertices_[static_cast<std::size_t>(v)];
        if (!vertex.is_plain()) return;
        std::size_t left = 4, lefts = 0;
        for (std::size_t k = 0; k < 4; ++k)
            if (!has(w, vertex.cells[k])) left = k, ++lefts;
        if (lefts == 1) vertex.next[left] = w;
    };
    const auto offsets = t.face_offsets();
    const auto corners = t.face_vertices();
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (i % cells_per_check == 0) check_stop();
        for (auto face = static_cast<std::size_t>(t.indptr()[i]); face < static_cast<std::size_t>(t.indptr()[i + 1]);
             ++face) {
            if (t.indices()[face] < static_cast<std::int32_t>(i)) continue;  // seen from the other side, or a wall
            const auto begin = static_cast<std::size_t>(offsets[face]),
                       end = static_cast<std::size_t>(offsets[face + 1]);
            for (std::size_t k = begin; k < end; ++k) {
                const std::int32_t v = corners[k], w = corners[k + 1 == end ? begin : k + 1];
                join(v, w);
                join(w, v);
            }
        }
    }
}

// Goes from vertex to vertex where the excess is less. It is a convex function of the tetrahedra, so the way ends in a
// vertex that is swallowed, if any is.
bool GraphDivider::find_first() {
    if (near_ == VertexGraph::none) return false;
    Place here = look(near_);
    for (bool going = true; going && !(here.excess < 0);) {
        going = false;
        if (!graph_->vertex(here.vertex).is_plain()) return false;
        for (const std::int32_t next : graph_->vertex(here.vertex).next) {
            if (next == VertexGraph::none) continue;
            const Place there = look(next);
            if (!(there.excess < here.excess)) continue;
            here = there;
            going = true;
            break;
        }
    }
    if (!(here.excess < 0)) return false;
    near_ = here.vertex;
    (void)see(near_);
    return true;
}

// Returns the place of a vertex, which is new at first, and swallowed if it is nearer to the probe than to its seeds.
std::size_t GraphDivider::see(std::int32_t vertex) {
    std::size_t at = (static_cast<std::uint32_t>(vertex) * 2654435761u) >> 22;
    while (seen_[at].turn == turn_ && seen_[at].vertex != vertex) at = (at + 1) % table_size;
    Seen& seen = seen_[at];
    if (seen.turn != turn_) {
        seen = {vertex, static_cast<std::int32_t>(place_count_), turn_};
        places_[place_count_] = look(vertex);
        const double power = graph_->vertex(vertex).power, excess = places_[place_count_].excess;
        if (!(std::abs(excess) > uncertain * std::abs(power) + uncertain_weight_)) uncertain_ = true;
        if (places_[place_count_].excess < 0) {
            swallowed_[swallowed_count_++] = static_cast<std::uint16_t>(place_count_);
            // The search will ask for these.
            for (const std::int32_t next : graph_->vertex(vertex).next)
                if (next != VertexGraph::none) __builtin_prefetch(&graph_->vertex(next));
        }
        ++place_count_;
    }
    return static_cast<std::size_t>(seen.place);
}

inline std::size_t GraphDivider::neighbor(std::int32_t seed, Division& out) {
    std::size_t at = (static_cast<std::uint32_t>(seed) * 2654435761u) >> 25;
    while (numbers_[at].turn == turn_ && numbers_[at].seed != seed) at = (at + 1) % numbers_.size();
    Number& number = numbers_[at];
    if (number.turn == turn_) return number.neighbor;
    number = {seed, turn_, static_cast<std::uint32_t>(out.size())};
    const auto i = static_cast<std::size_t>(seed);
    const Vector n{seeds_.x[i] - at_[0], seeds_.y[i] - at_[1], seeds_.z[i] - at_[2]};
    const double more = seeds_.weights.empty() ? 0 : weight_ - seeds_.weights[i];
    return out.add_neighbor(seed, n, 0.5 * (dot(n, n) + more));
}

bool GraphDivider::divide(const Probe& probe, bool moments, Division& out) {
    out.begin(!seeds_.weights.empty(), moments);
    at_ = probe.place.at;
    weight_ = probe.weight;
    place_count_ = swallowed_count_ = 0;
    uncertain_ = false;
    uncertain_weight_ = uncertain * (largest_weight_ + std::abs(weight_));
    ++turn_;
    return find_first() && search(out) && !uncertain_ && out.add_rims() && out.finish();
}

// Where a wall cuts the cell, a vertex on the wall is swallowed. Swallowed vertices are connected beyond walls too, and
// an edge between two of them is nearer to the probe everywhere.
bool GraphDivider::search(Division& out) {
    // The three others of four cells: they turn so that their edge leads away.
    constexpr std::size_t others[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
    for (std::size_t s = 0; s < swallowed_count_; ++s) {
        const std::size_t own = swallowed_[s];
        const Place& here = places_[own];
        const VertexGraph::Vertex& v = graph_->vertex(here.vertex);
        if (!v.is_plain() || swallowed_count_ > max_swallowed) return false;
        std::array<std::size_t, 4> near;
        for (std::size_t k = 0; k < 4; ++k) {
            near[k] = neighbor(v.cells[k], out);
            if (near[k] == Division::max_neighbors) return false;
        }
        for (std::size_t k = 0; k < 4; ++k) {
            if (v.next[k] == VertexGraph::none) return false;
            const std::size_t a = near[others[k][0]], b = near[others[k][1]], c = near[others[k][2]];
            const std::size_t place = see(v.next[k]);
            const Place& there = places_[place];
            if (there.excess < 0) {
                if (place > own) out.add_inner(a, b, c, here.x, there.x);  // such an edge comes twice
                continue;
            }
            // Along the edge the excess is linear.
            const double share = here.excess / (here.excess - there.excess);
            Vector corner;
            for (std::size_t i = 0; i < 3; ++i) corner[i] = here.x[i] + share * (there.x[i] - here.x[i]);
            // It has lost digits where the vertex there is far.
            if (!(std::abs(out.residual(a, corner)) <= off_plane * (std::abs(out.height(a)) + dot(corner, corner))))
                return false;
            if (!out.add_corner(a, b, c, corner)) return false;
            out.add_inner(a, b, c, here.x, corner);
        }
    }
    return true;
}

}  // namespace votess::cpu
