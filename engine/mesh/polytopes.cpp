// A facet of a polytope of the dual is an edge of the mesh at the polytope's vertex. Its corners are the cells around
// the edge, in turn. No predicate is needed, except to say which edges to infinity are one.
#include <algorithm>
#include <limits>
#include <tuple>

#include "core/progress.hpp"
#include "mesh/dual.hpp"

namespace votess {
namespace {

using detail::Result;

// An edge of the mesh, by its other end as seen from the vertex.
struct FarEnd {
    std::size_t vertex;
    ByteShift shift;
    friend auto operator<=>(const FarEnd&, const FarEnd&) = default;
};

constexpr std::size_t at_infinity = std::numeric_limits<std::size_t>::max();  // the other end of any ray

// Around an edge one cell follows another.
struct Step {
    FarEnd edge;
    Member from, to;
};

class FacetFinder {
public:
    FacetFinder(const Result& result, const Delaunay& dual, const TurnSeenFrom& turn)
        : r_(result), dual_(dual), turn_(turn) {}

    PolytopeFacets find() {
        for (std::size_t p = 0; p < dual_.polytope_centers.size(); ++p) {
            check_stop();
            center_ = at(dual_.polytope_centers[p]);
            steps_.clear();
            for (auto k = at(dual_.polytope_indptr[p]); k < at(dual_.polytope_indptr[p + 1]); ++k)
                add_steps({dual_.polytope_indices[k], shift_in(dual_.polytope_shifts, k, 1)});
            std::ranges::sort(steps_, {}, [](const Step& s) { return std::tuple(s.edge, s.from); });
            for (auto begin = steps_.begin(); begin != steps_.end();) {
                const auto end =
                    std::find_if(begin, steps_.end(), [&](const Step& s) { return s.edge != begin->edge; });
                if (begin->edge.vertex == at_infinity)
                    add_open_facets({begin, end});
                else
                    add_facet({begin, end});
                begin = end;
            }
            out_.facet_begin.push_back(out_.corner_begin.size() - 1);
        }
        return std::move(out_);
    }

private:
    // Two faces of a cell share an edge at the vertex. One of them leaves the vertex along it.
    void add_steps(const Member& member) {
        const auto seed = at(member.seed);
        for (auto entry = at(r_.indptr[seed]); entry < at(r_.indptr[seed + 1]); ++entry) {
            const auto begin = r_.face_offsets[entry], end = r_.face_offsets[entry + 1];
            for (auto k = begin; k < end; ++k) {
                if (seen(r_.face_vertices[at(k)], member) != FarEnd{center_, {}}) continue;
                const std::int32_t after = r_.face_vertices[at(k + 1 == end ? begin : k + 1)];
                steps_.push_back({seen(after, member),
                                  member,
                                  {r_.indices[entry], sum(member.shift, shift_in(r_.shifts, entry, 1))}});
            }
        }
    }

    // A vertex of the member's cell, moved with it.
    [[nodiscard]] FarEnd seen(std::int32_t vertex, const Member& member) const {
        if (vertex < 0) return {at_infinity, {}};
        return {original(r_, vertex), sum(shift_in(r_.vertex_shifts, at(vertex), 1), member.shift)};
    }

    void add_facet(std::span<const Step> steps) {
        const Step* step = &steps.front();
        do {
            out_.corners.push_back(step->from);
            step = &*std::ranges::lower_bound(steps, step->to, {}, &Step::from);
        } while (step != &steps.front());
        out_.corner_begin.push_back(out_.corners.size());
    }

    // Divides steps around rays.
    void add_open_facets(std::span<const Step> steps) {
        std::vector<bool> done(steps.size());
        for (std::size_t first = 0; first < steps.size(); ++first) {
            if (done[first]) continue;
            for (std::size_t step = first; !done[step]; step = next_step(steps, step)) {
                done[step] = true;
                out_.corners.push_back(steps[step].from);
            }
            out_.corner_begin.push_back(out_.corners.size());
        }
    }
    // Returns the step that follows around the same ray. Seen from outside its cell, the faces of both steps are next
    // to each other, and all others of the vertex lie on one side.
    [[nodiscard]] std::size_t next_step(std::span<const Step> steps, std::size_t step) const {
        const Step& before = steps[step];
        const auto follows = [&](const Step& after) {
            if (after.to == before.from) return false;
            return std::ranges::all_of(steps_, [&](const Step& other) {
                return other.from != before.to || other.to == before.from || other.to == after.to ||
                       turn_(before.to, {before.from, after.to, other.to}) > 0;
            });
        };
        const auto leaving = std::ranges::equal_range(steps, before.to, {}, &Step::from);
        const auto found = std::ranges::find_if(leaving, follows);
        if (found == leaving.end())
            throw Error(ErrorCode::invalid_argument, "the points are not those of the tessellation");
        return static_cast<std::size_t>(&*found - steps.data());
    }

    const Result& r_;
    const Delaunay& dual_;
    const TurnSeenFrom& turn_;
    std::size_t center_ = 0;  // the vertex of the polytope at hand
    std::vector<Step> steps_;
    PolytopeFacets out_;
};

}  // namespace

PolytopeFacets polytope_facets(const Result& result, const Delaunay& dual, const TurnSeenFrom& turn) {
    return FacetFinder(result, dual, turn).find();
}

}  // namespace votess
