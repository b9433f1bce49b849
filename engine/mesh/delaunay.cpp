// The dual of the mesh, read off its polygons: no predicate, the cells are exact already. Where faces were dropped,
// tetrahedra become polytopes. In the plane triangles take the place of tetrahedra, polygons that of polytopes.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "core/progress.hpp"
#include "core/text.hpp"
#include "input/option_name.hpp"
#include "input/supports.hpp"
#include "mesh/dual.hpp"
#include "mesh/joined_corners.hpp"
#include "result/handle.hpp"

namespace votess {
namespace {

using detail::Result;
constexpr std::size_t entries_per_check = 4096, cells_per_check = 1024;  // after which the user may stop

// A face passes a vertex: it comes from `before` and goes to `after`.
struct Passage {
    std::int32_t vertex;
    std::size_t entry;
    std::int32_t before, after;
};

// In the plane: around a vertex, one cell follows another counterclockwise.
struct Turning {
    Member from, to;
};

// How many cells meet at each vertex; 0 on the walls, and for those that another one stands for.
std::vector<std::int32_t> count_cells(const Result& r, const JoinedCorners& joined) {
    std::vector<std::int32_t> cells;
    lengthen(cells, r.vertices.size() / dimensions_of(r));
    std::vector<std::pair<std::size_t, ByteShift>> of_cell;
    for (std::size_t i = 0; joined.any() && i < r.status.size(); ++i) {
        if (i % cells_per_check == 0) check_stop();
        of_cell.clear();
        for (auto k = at(r.cell_vertex_indptr[i]); k < at(r.cell_vertex_indptr[i + 1]); ++k) {
            const std::int32_t v = r.cell_vertex_indices[k];
            of_cell.emplace_back(joined.original(v), joined.shift(v));
        }
        std::ranges::sort(of_cell);
        for (std::size_t k = 0; k < of_cell.size(); ++k)
            if (k == 0 || of_cell[k] != of_cell[k - 1]) ++cells[of_cell[k].first];
    }
    if (!joined.any())
        in_pieces(r.cell_vertex_indices.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k) ++cells[joined.original(r.cell_vertex_indices[k])];
        });
    for (std::size_t entry = 0; entry < r.indices.size(); ++entry) {
        if (entry % entries_per_check == 0) check_stop();
        if (r.indices[entry] >= 0) continue;
        for (std::int64_t k = r.face_offsets[entry]; k < r.face_offsets[entry + 1]; ++k)
            if (const std::int32_t v = r.face_vertices[at(k)]; v >= 0) cells[joined.original(v)] = 0;
    }
    return cells;
}

class Dual {
public:
    explicit Dual(const Result& result) : r_(result), joined_(result), corners_(dimensions_of(result) + 1) {
        const std::vector<std::int32_t> cells = count_cells(result, joined_);
        const auto simple = static_cast<std::int32_t>(corners_);
        lengthen(centers_, cells.size());
        out_.polytope_indptr.assign(1, 0);
        for (std::size_t v = 0; v < cells.size(); ++v) {
            if (v % entries_per_check == 0) check_stop();
            centers_[v].cells = cells[v] < simple ? 0 : cells[v];
            if (cells[v] == simple) {
                centers_[v].place = static_cast<std::int32_t>(out_.tetrahedra_centers.size());
                out_.tetrahedra_centers.push_back(static_cast<std::int32_t>(v));
            } else if (cells[v] > simple) {
                centers_[v].place = static_cast<std::int32_t>(out_.polytope_centers.size());
                out_.polytope_centers.push_back(static_cast<std::int32_t>(v));
                out_.polytope_indptr.push_back(out_.polytope_indptr.back() + cells[v]);
            }
        }
        lengthen(out_.tetrahedra, corners_ * out_.tetrahedra_centers.size());
        lengthen(out_.polytope_indices, at(out_.polytope_indptr.back()));
        if (!r_.shifts.empty()) {
            lengthen(out_.tetrahedra_shifts, dimensions() * out_.tetrahedra.size());
            lengthen(out_.polytope_shifts, dimensions() * out_.polytope_indices.size());
        }
    }

    Delaunay make() {
        if (r_.planar) {
            add_polygons();
            return std::move(out_);
        }
        for (std::size_t i = 0; i < r_.status.size(); ++i) {
            if (i % cells_per_check == 0) check_stop();
            prefetch(i);
            add_tetrahedra(i);
        }
        if (r_.lone_tetrahedron)
            for (std::size_t k = 0; k < 4; ++k) put_corner(k, {(*r_.lone_tetrahedron)[k], {}});
        add_polytopes();
        return std::move(out_);
    }

private:
    // A vertex, as the center of a tetrahedron or polytope.
    struct Center {
        std::int32_t cells;  // that meet; 0 for a tetrahedron that is made
        std::int32_t place;  // number of the tetrahedron or polytope
    };

    // Loads into the cache what the cell after cell i reads of its vertices: for seeds in random order these lie far
    // apart in memory.
    void prefetch(std::size_t i) const {
        constexpr std::size_t ahead = 2;
        if (i + ahead >= r_.status.size()) return;
        for (auto k = at(r_.cell_vertex_indptr[i + ahead]); k < at(r_.cell_vertex_indptr[i + ahead + 1]); ++k)
            __builtin_prefetch(&centers_[joined_.original(r_.cell_vertex_indices[k])]);
    }

    // Those that cell i is the first to have. Seen from outside of it, its three faces lie counterclockwise around the
    // vertex as their seeds lie around the cell.
    void add_tetrahedra(std::size_t i) {
        passages_.clear();
        for (auto entry = at(r_.indptr[i]); entry < at(r_.indptr[i + 1]); ++entry) {
            const auto begin = r_.face_offsets[entry], end = r_.face_offsets[entry + 1];
            for (auto k = begin; k < end; ++k) {
                const std::int32_t v = r_.face_vertices[at(k)];
                if (v < 0) continue;  // infinity
                if (joined_.original(v) != at(v) || centers_[at(v)].cells != 4) continue;
                passages_.push_back({v, entry, r_.face_vertices[at(k == begin ? end - 1 : k - 1)],
                                     r_.face_vertices[at(k + 1 == end ? begin : k + 1)]});
            }
        }
        std::ranges::sort(passages_, {}, [](const Passage& p) { return std::tuple(p.vertex, p.entry); });
        for (std::size_t p = 0; p + 2 < passages_.size(); p += 3) {
            const Passage &a = passages_[p], &b = passages_[p + 1], &c = passages_[p + 2];
            // Two edges may go to infinity. The finite one decides the turn; a cell without it leaves that to a later
            // cell.
            const auto meets = [](const Passage& x, const Passage& y) { return x.after >= 0 && x.after == y.before; };
            const bool open = std::min({a.before, b.before, c.before}) < 0;
            if (open ? meets(b, a) || meets(a, c) || meets(c, b) : meets(b, a))
                put_tetrahedron(i, a, b, c);
            else if (!open || meets(c, a) || meets(a, b) || meets(b, c))
                put_tetrahedron(i, a, c, b);
        }
    }

    // Seen from outside of cell i, the faces lie counterclockwise around the vertex.
    void put_tetrahedron(std::size_t i, const Passage& a, const Passage& b, const Passage& c) {
        std::array<Member, 4> corners{Member{static_cast<std::int32_t>(i), {}}, across(a.entry), across(b.entry),
                                      across(c.entry)};
        const auto lowest = std::ranges::min_element(corners, {}, &Member::seed) - corners.begin();
        if (lowest != 0) {  // two swaps keep the turn
            std::swap(corners[0], corners[static_cast<std::size_t>(lowest)]);
            std::swap(corners[static_cast<std::size_t>(lowest % 3 + 1)],
                      corners[static_cast<std::size_t>((lowest + 1) % 3 + 1)]);
        }
        Center& center = centers_[at(a.vertex)];
        const std::size_t simplex = 4 * at(center.place);
        center.cells = 0;
        for (std::size_t k = 0; k < 4; ++k) put_corner(simplex + k, corners[k]);
    }

    // Makes the polygons of the plane, triangles among them. A polygon is counterclockwise and begins with its lowest
    // seed.
    void add_polygons() {
        const std::size_t in_triangles = out_.tetrahedra.size();
        std::vector<std::size_t> end(centers_.size());  // of the steps around each vertex
        std::vector<Turning> steps;
        lengthen(steps, in_triangles + out_.polytope_indices.size());
        for (std::size_t v = 0; v < centers_.size(); ++v) end[v] = first_step(v);
        for (std::size_t i = 0; i < r_.status.size(); ++i) {
            if (i % cells_per_check == 0) check_stop();
            for (auto entry = at(r_.indptr[i]); entry < at(r_.indptr[i + 1]); ++entry) {
                // Beyond the edge that ends here is the next cell.
                const std::int32_t v = r_.face_vertices[2 * entry + 1];
                if (v < 0) continue;
                const std::size_t center = joined_.original(v);
                if (centers_[center].cells == 0) continue;
                const Member own{static_cast<std::int32_t>(i), negative(joined_.shift(v))}, next = across(entry);
                if (end[center] == first_step(center) + at(centers_[center].cells)) refuse_ring(center);
                steps[end[center]++] = {own, {next.seed, sum(own.shift, next.shift)}};
            }
        }
        for (std::size_t v = 0; v < centers_.size(); ++v) {
            if (v % entries_per_check == 0) check_stop();
            const std::size_t first = first_step(v), count = at(centers_[v].cells);
            if (count == 0) continue;
            const auto around = std::span(steps).subspan(first, count);
            if (end[v] != first + count || !put_in_turn(around)) refuse_ring(v);
            const bool is_triangle = count == corners_;
            const std::size_t corner = is_triangle ? first : first - in_triangles;
            auto& seeds = is_triangle ? out_.tetrahedra : out_.polytope_indices;
            auto& shifts = is_triangle ? out_.tetrahedra_shifts : out_.polytope_shifts;
            for (std::size_t k = 0; k < count; ++k) {
                seeds[corner + k] = around[k].from.seed;
                if (!shifts.empty()) std::copy_n(around[k].from.shift.begin(), 2, &shifts[2 * (corner + k)]);
            }
        }
    }
    // Those of triangles come before those of polygons.
    [[nodiscard]] std::size_t first_step(std::size_t center) const {
        const Center& c = centers_[center];
        if (c.cells == 0) return 0;
        if (at(c.cells) == corners_) return corners_ * at(c.place);
        return out_.tetrahedra.size() + at(out_.polytope_indptr[at(c.place)]);
    }
    // Sorts steps so that each begins where the one before ends, the lowest first. Returns false if they do not close.
    static bool put_in_turn(std::span<Turning> steps) {
        std::swap(steps.front(), *std::ranges::min_element(steps, {}, &Turning::from));
        for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
            const auto rest = steps.subspan(k + 1);
            const auto next = std::ranges::find(rest, steps[k].to, &Turning::from);
            if (next == rest.end()) return false;
            std::swap(*next, rest.front());
        }
        return steps.back().to == steps.front().from;
    }
    [[noreturn]] void refuse_ring(std::size_t center) const {
        throw Error(r_.dropped_offsets.empty() ? ErrorCode::internal : ErrorCode::invalid_argument,
                    "delaunay(): edges below a length of " + number(r_.least_face) +
                        " were dropped, and without them a cell at vertex " + std::to_string(center) +
                        " has no area: give a smaller " + option("min_face") + " or " + option("min_area"));
    }

    void add_polytopes() {
        std::vector<std::vector<Member>> members(out_.polytope_centers.size());
        for (std::size_t i = 0; i < r_.status.size(); ++i) {
            if (i % cells_per_check == 0) check_stop();
            for (auto k = at(r_.cell_vertex_indptr[i]); k < at(r_.cell_vertex_indptr[i + 1]); ++k) {
                const std::int32_t v = r_.cell_vertex_indices[k];
                const std::size_t center = joined_.original(v);
                if (centers_[center].cells > 4)
                    members[at(centers_[center].place)].push_back(
                        {static_cast<std::int32_t>(i), negative(joined_.shift(v))});
            }
        }
        std::size_t to = 0;
        for (auto& polytope : members) {
            std::ranges::sort(polytope);
            const auto rest = std::ranges::unique(polytope);
            polytope.erase(rest.begin(), rest.end());
            for (const Member& m : polytope) {
                if (!out_.polytope_shifts.empty()) std::ranges::copy(m.shift, &out_.polytope_shifts[3 * to]);
                out_.polytope_indices[to++] = m.seed;
            }
        }
    }

    [[nodiscard]] Member across(std::size_t entry) const {
        return {r_.indices[entry], shift_in(r_.shifts, entry, 1, dimensions())};
    }
    [[nodiscard]] std::size_t dimensions() const { return corners_ - 1; }
    void put_corner(std::size_t corner, const Member& m) {
        out_.tetrahedra[corner] = m.seed;
        if (!out_.tetrahedra_shifts.empty()) std::ranges::copy(m.shift, &out_.tetrahedra_shifts[3 * corner]);
    }

    const Result& r_;
    const JoinedCorners joined_;
    const std::size_t corners_;    // of a simplex
    std::vector<Center> centers_;  // by vertex
    std::vector<Passage> passages_;
    Delaunay out_;
};

}  // namespace

Delaunay delaunay(const Tessellation& tessellation) {
    require(tessellation, "delaunay");
    const Result& result = detail::result_of(tessellation);
    if (result.face_offsets.empty() && !result.status.empty())
        throw Error(ErrorCode::invalid_argument,
                    "delaunay(): the tessellation has no polygons, set " + option("want.faces"));
    return Dual(result).make();
}

}  // namespace votess
