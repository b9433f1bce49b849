// A facet of a polytope of the dual is an edge of the mesh at the polytope's vertex. Its corners are the cells around
// the edge, in turn. No predicate is needed.
#include <algorithm>
#include <tuple>

#include "core/progress.hpp"
#include "mesh/dual.hpp"

namespace votess {
namespace {

using detail::Result;

// An edge of the mesh, by its other end as seen from the vertex.
struct End {
    std::size_t vertex;
    ByteShift shift;
    friend auto operator<=>(const End&, const End&) = default;
};

// Around an edge one cell follows another.
struct Step {
    End edge;
    Member from, to;
};

class FacetFinder {
public:
    FacetFinder(const Result& result, const Delaunay& dual) : r_(result), dual_(dual) {}

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
                if (seen(r_.face_vertices[at(k)], member) != End{center_, {}}) continue;
                const std::int32_t after = r_.face_vertices[at(k + 1 == end ? begin : k + 1)];
                steps_.push_back({seen(after, member),
                                  member,
                                  {r_.indices[entry], sum(member.shift, shift_in(r_.shifts, entry, 1))}});
            }
        }
    }

    // A vertex of the member's cell, moved with it.
    [[nodiscard]] End seen(std::int32_t vertex, const Member& member) const {
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

    const Result& r_;
    const Delaunay& dual_;
    std::size_t center_ = 0;  // the vertex of the polytope at hand
    std::vector<Step> steps_;
    PolytopeFacets out_;
};

}  // namespace

PolytopeFacets polytope_facets(const Result& result, const Delaunay& dual) {
    return FacetFinder(result, dual).find();
}

}  // namespace votess
