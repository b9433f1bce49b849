// The vector loops over the candidates of a star, compiled for several instruction sets and chosen at run time. What
// they return is checked or exact, so the answer does not depend on the choice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "polytope/cell_kernels.hpp"
#include "polytope/cell_shape.hpp"

namespace votess::cpu {

inline constexpr int box_fan = 8;

// Boxes of eight siblings in the tree; those that do not exist are infinitely far away.
struct alignas(64) BoxBlock {
    double lower[3][box_fan];
    double upper[3][box_fan];
};

// Seeds near a home group as integers: (coordinate - origin) * scale, rounded, or one of +-window_range where that is
// beyond them; `far_away` for seeds that are no candidates.
inline constexpr std::int32_t window_range = 1 << 29;
inline constexpr std::int32_t far_away = (1 << 30) - 1;
struct WindowSeeds {
    const std::int32_t* x;
    const std::int32_t* y;
    const std::int32_t* z;
    const std::int32_t* id;
    const float* weight;  // in a power diagram, less that of some seed of the window, in squared units; else null
    int count;            // readable up to the next multiple of 16, where seeds are far away
};

// Candidate planes n.x = h of a cell in window units, h = |n|^2 / 2, in a power diagram (|n|^2 + w_p - w_q) / 2; a wall
// is the bisector with the seed's mirror image. Beyond `count` and up to the next multiple of 16 stand planes that
// nothing touches.
struct CandidatePlanes {
    static constexpr int capacity = 256;
    static constexpr float never = 1e30f;           // h of a plane that nothing touches
    static constexpr int room = 2 * capacity + 32;  // select() puts the far ones behind the others at first
    alignas(64) float nx[room];
    alignas(64) float ny[room];
    alignas(64) float nz[room];
    alignas(64) float h[room];
    alignas(64) std::int32_t id[room];
    int count = 0;
    int near = 0;  // planes of the walls and of the nearest seeds come first
};

struct Ray {  // (o + t d) / s; o[3] and d[3] are free
    float o[4], d[4];
    float s, limit;
};

// Seeds q that may lie in the ball around p + v / scale through p: n.v >= |n|^2 / 2 but for the slack.
struct GroupTest {
    std::array<double, 3> p;
    double scale;
    std::array<double, 3> v;
    double slack;
};

struct GroupSource {
    const double* seeds[3];  // coordinates
    std::span<const std::uint32_t> groups;
    std::size_t kept;
};
struct WindowFrame {
    Box home;
    double distance_squared;
    double origin[3], scale;
};

struct StarKernels {
    const char* name;
    // Bit k: box k comes nearer than sqrt(distance_squared) to the box home; for a point, lower = upper.
    unsigned (*near_boxes)(const BoxBlock&, const Box& home, double distance_squared);
    // Bits of those of eight seeds that may lie in the ball, and not nearer to p than sqrt(least) / scale.
    unsigned (*inside_ball)(const double* x, const double* y, const double* z, const GroupTest&, double least);
    // The seeds of groups as window integers, and their ids: all of the first `kept` groups, of the others those nearer
    // to the box `home` than sqrt(distance_squared). Returns their number; there is room for all.
    int (*to_window)(const GroupSource&, const WindowFrame&, std::int32_t* const* out, std::int32_t* ids);
    // Adds the planes of all window seeds nearer to p than sqrt(distance_squared); the near ones, at least those of
    // seeds nearer than sqrt(near_squared), come first. weight: that of p, as those of the window. False when they are
    // too many.
    bool (*select)(const WindowSeeds&, const std::int32_t* p, float weight, float near_squared, float distance_squared,
                   CandidatePlanes&);
    // The plane that each of two rays meets first among those of the first `count` that it leaves (n.d > limit), -1 if
    // none. A guess: which of those within 2^-12 of the least t it is may vary, and it may be one beyond `count`.
    void (*first_hits)(const CandidatePlanes&, int count, const Ray* rays, int* hits);
    // The first plane with h - n.v <= v[3] that is none of the three, from plane `begin` on; -1 if there is none among
    // the first `count`.
    int (*touching)(const CandidatePlanes&, int count, const float* v, const std::int32_t* three, int begin);
    // places[k] = how many of `count` different ids are smaller than ids[k]. There is room for 32 places or more.
    void (*rank)(const std::int32_t* ids, int count, std::uint32_t* places);
    // Orders the corners, with three fillers behind them.
    void (*order_corners)(const CellShape&, CornerOrder&);
    // False where rounding might spoil the digits promised. Last digits depend on the instruction set.
    bool (*measure)(CellShape&, CellMeasures&);
};

template <class Isa>
class CellMeter;

// Those of one instruction set, whose functions the walk calls by their names, so that they can be inlined.
template <class Isa>
inline constexpr StarKernels kernels_of{Isa::name,          Isa::near_boxes,        Isa::inside_ball, Isa::to_window,
                                        Isa::select,        Isa::first_hits,        Isa::touching,    Isa::rank,
                                        Isa::order_corners, CellMeter<Isa>::measure};
extern const StarKernels star_kernels_avx2;

// The ones for a set of supported_kernels(). With avx512 they are those of AVX2: loops over vectors of 512 bits took
// 4 to 12 % longer for a cell, on a processor that has them.
const StarKernels& star_kernels(std::string_view name);

}  // namespace votess::cpu
