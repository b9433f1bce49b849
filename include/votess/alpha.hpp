// The alpha complex: vertices, edges, triangles and tetrahedra of the Delaunay triangulation, each with the value of
// alpha at which it appears. Tools of topological data analysis call this a filtration.
//
//     const votess::AlphaComplex complex = votess::alpha_complex(t, points);
//     complex.simplices[1].seeds   // two seeds for each edge
//     complex.simplices[1].values  // when the edge appears
//
// As alpha grows, balls of squared radius alpha grow around the seeds, each within its cell. A simplex appears when the
// balls of its seeds first have a point in common there (Edelsbrunner, Muecke: Three-dimensional alpha shapes, ACM
// Trans. Graph. 13, 1994). Values are squared radii, as in GUDHI and CGAL.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace votess {

// M simplices of one dimension k. Each holds k + 1 seeds, in ascending order. Simplices ascend too.
struct AlphaSimplices {
    std::vector<std::int32_t> seeds;  // (k + 1) M
    // 3 (k + 1) M in a periodic domain, in the plane 2 (k + 1) M, else empty: the numbers of box vectors that carry
    // each seed from its place inside the box to the simplex. They are 0 for the first seed.
    std::vector<std::int8_t> shifts;
    // M squared radii, length unit squared. Never less than the value of a face. In a power diagram a ball has the
    // squared radius alpha + w, so a seed appears at -w.
    std::vector<double> values;
    // M: 1 if no seed lies strictly inside the smallest sphere through the simplex's seeds. Then the value is the
    // squared radius of this sphere, else the least value of the simplices around. Weighted: the sphere is orthogonal
    // to the seeds' spheres, and no seed has a negative power distance to it.
    std::vector<std::uint8_t> gabriel;
};

struct AlphaComplex {
    std::array<AlphaSimplices, 4> simplices;  // by dimension; in the plane there are no tetrahedra
};

// Returns the alpha complex of the seeds in whole space or the whole plane. In a periodic domain this repeats along the
// same axes, and has no end along others. Faces of the tessellation, Want::faces, are used where they are those of this
// space; else the call tessellates again, on the CPU. So bounds, walls and dropped faces change nothing. Duplicates,
// seeds that Outside::drop dropped, and seeds that weights hide are in no simplex. Seeds in one plane have no
// tetrahedra, those in one line no triangles.
//
// Gabriel flags are exact. Values have a relative error below 1e-12. Where exact values of a simplex and a face are
// equal because of a tie, stored ones are too. Polytopes of more than four seeds on an empty sphere are cut from their
// lowest seed, and their facets from the lowest seed of each. So neighbors agree, images too.
//
// replicate: take this many copies of a periodic box along each of its vectors, 1 where it does not repeat. Copy (i, j,
// k) of seed s has the id s + N c, where c = (i * replicate[1] + j) * replicate[2] + k. The seed as it lies inside the
// box is copy (0, 0, 0). Shifts then count vectors of the large box.
//
// Throws invalid_argument if an edge leads to an image of its own seed, or two edges join the same seeds: replicate a
// small box. Refuses cells of a subset, of probes and in a mesh. In the plane replicate[2] must be 1.
[[nodiscard]] VOTESS_API AlphaComplex alpha_complex(const Tessellation& tessellation, std::span<const double> points,
                                                    const std::array<std::int32_t, 3>& replicate = {1, 1, 1});

}  // namespace votess
