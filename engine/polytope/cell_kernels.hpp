// The vector loops over the vertices of a cell, compiled for several instruction sets and chosen at run time. All of
// them do the same operations in the same order without contraction, so the answer does not depend on the choice.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "votess/votess.hpp"

namespace votess::cpu {

inline constexpr int lanes = 8;        // vertices per block
inline constexpr int word_slots = 64;  // vertices per mask word

// Vertices of one mask word, structure of arrays; positions are relative to the seed.
struct VertexBlock {
    const double* x;
    const double* y;
    const double* z;
    const double* tolerance;       // bound on the position error plus the rounding of n.x, see Cell
    const double* radius_squared;  // |x|^2, and a little more where x is not exact
    int blocks;                    // number of 8-lane blocks in use, at most 8
};

// The plane n.x = h with the error terms of its filter.
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
    // out[i] = squared distance of (x,y,z)[i] from p.
    void (*squared_distances)(const double* x, const double* y, const double* z, int count, const double* p,
                              double* out);
    // Sort keys of the distances in [from, to): their high half, monotone for positive doubles, over their index.
    // keys has room for count + 8; returns how many were written, in order of index.
    int (*select_band)(const double* distances, int count, double from, double to, std::uint64_t* keys);
};

inline constexpr std::uint64_t key_distance_bits = 0xffffffff00000000ull;

// Returns those of "avx512", "avx2", "baseline" that this processor has, the best first.
std::vector<const Kernels*> supported_kernels();
// For tests, before anything else runs: from now on the processor is taken to have none that are better.
void set_best_kernels(const Kernels& kernels);
const Kernels& best_kernels();
// One of them by name, "" = the best; null when there is none.
const Kernels* find_kernels(std::string_view name);

}  // namespace votess::cpu
