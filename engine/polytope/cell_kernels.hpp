// Vector loops over the vertices of a cell, compiled for several instruction sets and chosen at run time. All sets do
// the same operations in the same order without contraction, so their results are equal.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "votess/votess.hpp"

namespace votess::cpu {

inline constexpr int lanes = 8;        // vertices per block
inline constexpr int word_slots = 64;  // vertices per mask word

// Vertices of one mask word, relative to the seed.
struct VertexBlock {
    const double* x;
    const double* y;
    const double* z;
    const double* tolerance;       // bound on the position error plus the rounding of n.x, see Cell
    const double* radius_squared;  // |x|^2, slightly larger if x is not exact
    int blocks;                    // number of 8-lane blocks in use, at most 8
};

struct FilterPlane {
    double nx, ny, nz, h;
    double norm;     // |n|
    double h_error;  // bound on the error of h and of the final subtraction
};

struct SideMasks {
    std::uint64_t possible = 0;  // bit set: not certainly inside
    std::uint64_t certain = 0;   // bit set: certainly outside
};

struct Kernels {
    const char* name;
    SideMasks (*classify)(const VertexBlock&, const FilterPlane&);
    // Whether the box reaches into the ball around any vertex that touches the seed: only there can a seed cut. The
    // squared radius counts as radius * slack + floor.
    bool (*box_in_reach)(const VertexBlock&, const Box& relative, double slack, double floor);
    double (*largest_radius)(const VertexBlock&);
    void (*squared_distances)(const double* x, const double* y, const double* z, int count, const double* p,
                              double* out);
    // Writes sort keys of the distances in [from, to): their high half, monotone for positive doubles, above their
    // index. keys has room for count + 8. Returns the number written, in order of index.
    int (*select_band)(const double* distances, int count, double from, double to, std::uint64_t* keys);
};

inline constexpr std::uint64_t key_distance_bits = 0xffffffff00000000ull;

// Returns the sets that this processor has, of "avx512", "avx2", "baseline", best first.
std::vector<const Kernels*> supported_kernels();
// For tests, before anything else runs: hides all better sets.
void set_best_kernels(const Kernels& kernels);
const Kernels& best_kernels();
// "" = the best; null if there is none.
const Kernels* find_kernels(std::string_view name);

}  // namespace votess::cpu
