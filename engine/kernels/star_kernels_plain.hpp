// The loops of StarKernels for any processor, in the compiler's vectors of four.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "kernels/star_kernels.hpp"
#include "kernels/weight_bend.hpp"

namespace votess::cpu {

// Together with GroupTest::slack more than 2e-8 (h + |v| sqrt(h)), h = |n|^2 / 2.
constexpr double relative_slack = 4e-8;

#define VOTESS_INLINE inline __attribute__((always_inline))

using Float4 __attribute__((vector_size(16))) = float;
using Int4 __attribute__((vector_size(16))) = std::int32_t;
using Double4 __attribute__((vector_size(32), may_alias)) = double;
using Long4 __attribute__((vector_size(32), may_alias)) = std::int64_t;

VOTESS_INLINE Float4 load(const float* from) {
    Float4 v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

VOTESS_INLINE Int4 load(const std::int32_t* from) {
    Int4 v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

// Returns a bit for each true lane.
VOTESS_INLINE unsigned mask_of(Int4 lanes) {
#if defined(__SSE2__)
    return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(lanes)));
#else
    unsigned mask = 0;
    for (int k = 0; k < 4; ++k) mask |= (static_cast<unsigned>(lanes[k]) & 1) << k;
    return mask;
#endif
}

// select() puts the far planes here at first.
constexpr int far_begin = CandidatePlanes::capacity + 16;
static_assert(far_begin % 16 == 0);

VOTESS_INLINE void pad(CandidatePlanes& c) {
    for (int i = 0; i < 16; ++i) {
        c.nx[c.count + i] = c.ny[c.count + i] = c.nz[c.count + i] = 0;
        c.h[c.count + i] = CandidatePlanes::never;
    }
}

// Moves `far` planes from far_begin to behind the first `near`. Returns false when they are too many.
VOTESS_INLINE bool join(CandidatePlanes& c, int near, int far) {
    if (near + far > CandidatePlanes::capacity) return false;
    c.near = near;
    c.count = near + far;
    constexpr int step = 8;
    static_assert(far_begin >= CandidatePlanes::capacity + step);
    for (int i = 0; i < far; i += step) {
        const auto move = [&](auto* values) { std::memcpy(values + near + i, values + far_begin + i, step * 4); };
        move(c.nx);
        move(c.ny);
        move(c.nz);
        move(c.h);
        move(c.id);
    }
    pad(c);
    return true;
}

// Rounding of a residual or an excess, in units of its terms.
constexpr double residual_slack = 4e-15;

VOTESS_INLINE void absolute(const Double4& v, Double4& out) {
    Long4 bits;
    std::memcpy(&bits, &v, sizeof bits);
    bits &= std::numeric_limits<std::int64_t>::max();  // a comparison would take three instructions
    std::memcpy(&out, &bits, sizeof out);
}

// The test of near_heavier() for four seeds. gaps2: D^2. rest: their residuals.
VOTESS_INLINE void heavier_seeds(const Double4& gaps2, const Double4& rest, const WeightTilt& tilt,
                                 const HeavierTest& test, Long4& out) {
    using Lanes = Double4;
    Lanes size;
    absolute(rest, size);
    const Long4 far =
        test.share * gaps2 * (1 - 1e-12) - (rest - tilt.least) - residual_slack * size > Lanes{} + test.limit;
    // Padding is infinitely far away. An excess that is NaN proves nothing.
    out = (gaps2 < std::numeric_limits<double>::infinity()) & ~far;
}

// Returns the square roots.
VOTESS_INLINE void square_roots(const Double4& v, Double4& out) {
    for (int i = 0; i < 4; ++i) out[i] = std::sqrt(v[i]);
}

// Members of HeavierTest that may differ from box to box, for four boxes.
struct FarLanes {
    Double4 share, turn, limit;
};

// The test of near_heavier() for four boxes: writes -1 for those that pass it. Place: home is one. Nearest:
// test.nearest is not 0. most: set to the excess of each box where it passes soonest.
//
// Each axis adds a convex function of the place to share D^2 - excess. It is least where the way from home is apart *
// turn, or at an end of the box. Rounding of that place changes it in second order.
template <bool Place, bool Nearest>
VOTESS_INLINE void heavier_boxes(const BoxBlock& b, const WeightBlock& w, const Box& home, const HeavierTest& test,
                                 const FarLanes& far, int first, Long4& out, Double4& most) {
    using Lanes = Double4;
    const Lanes none{};
    Lanes gaps2{}, excess = *reinterpret_cast<const Lanes*>(w.at_zero + first) - test.constant, largest = excess;
    for (int k = 0; k < 3; ++k) {
        const Lanes lower = *reinterpret_cast<const Lanes*>(b.lower[k] + first),
                    upper = *reinterpret_cast<const Lanes*>(b.upper[k] + first);
        const Lanes begin = home.lower[k] - none, end = home.upper[k] - none;  // no 0 is added to them
        const Lanes apart = *reinterpret_cast<const Lanes*>(w.slope[k] + first) - test.slope[k];
        Lanes x = begin;
        if constexpr (!Place) x = apart > none ? end : begin;
        x += far.turn * apart;
        x = x > lower ? x : lower;
        x = x < upper ? x : upper;
        Lanes nearest = begin;
        if constexpr (!Place) {
            nearest = x > begin ? x : begin;
            nearest = nearest < end ? nearest : end;
        }
        const Lanes gap = x - nearest;
        gaps2 += gap * gap;
        excess += apart * x;
        if constexpr (Nearest) {
            const Lanes at_lower = apart * lower, at_upper = apart * upper;
            largest += at_lower > at_upper ? at_lower : at_upper;
        }
    }
    const Lanes slack = residual_slack * *reinterpret_cast<const Lanes*>(w.size + first);
    Long4 fails = far.share * gaps2 - excess - slack > far.limit;
    if constexpr (Nearest) fails |= far.share * (test.nearest * test.nearest) - largest - slack > far.limit;
    // Missing boxes are infinitely far away. A sum that is NaN proves nothing.
    out = (*reinterpret_cast<const Lanes*>(b.lower[0] + first) <= *reinterpret_cast<const Lanes*>(b.upper[0] + first)) &
          ~fails;
    most = excess;
}

// Writes -1 for boxes that pass the test of near_heavier(), 0 for others. most: their excess.
template <bool Place, bool Nearest>
VOTESS_INLINE void near_heavier_boxes(const BoxBlock& b, const WeightBlock& w, const Box& home, const HeavierTest& test,
                                      Long4 (&out)[2], Double4 (&most)[2]) {
    const Double4 none{};
    const FarLanes far{test.share * (1 - 1e-12) - none, test.turn - none, test.limit - none};
    for (int i = 0; i < 2; ++i) heavier_boxes<Place, Nearest>(b, w, home, test, far, 4 * i, out[i], most[i]);
}

// Writes -1 for boxes so heavy that heavy_boxes() excludes more.
VOTESS_INLINE void much_heavier(const HeavierTest& test, const Double4& most, Long4& out) {
    constexpr double much = 4;
    out = most > much * (test.square + test.length * test.length);
}

// The test of near_heavier() with `far` as each box has it. most: as near_heavier_boxes() wrote it.
VOTESS_INLINE void heavy_boxes(const BoxBlock& b, const WeightBlock& w, const Box& home, const HeavierTest& test,
                               const Double4 (&most)[2], Long4 (&out)[2]) {
    using Lanes = Double4;
    for (int i = 0; i < 2; ++i) {
        const Lanes none{}, square = (most[i] > none ? most[i] : none) + (test.square + test.length * test.length);
        Lanes root;
        square_roots(square, root);
        const Lanes place = root + test.length, share = 1 - test.length / place;
        FarLanes far{share * (1 - 1e-12), 0.5 / share, {}};
        test.limit_at(place, far.limit);
        Lanes excess;
        heavier_boxes<false, false>(b, w, home, test, far, 4 * i, out[i], excess);
    }
}

// The test of near_bent() for seeds at places y whose lengths by A have squares of at least `squares`, and whose rho
// are larger than the least of the home by at most `excess`.
//
// A seed of the home lies within `radius`, so |n|_A is at least D = |y|_A - radius. From D^2 - 2 length D >= excess
// follows that the plane is farther away.
VOTESS_INLINE void within_bent(const Double4& squares, const Double4& excess, const WeightBend& bent, double length,
                               Long4& out) {
    using Lanes = Double4;
    Lanes root;
    square_roots((excess > 0 ? excess : Lanes{}) + length * length, root);
    const Lanes farthest = root + (length + bent.radius);
    // An excess that is NaN proves nothing.
    out = ~(squares > farthest * farthest * (1 + 1e-12)) | ~(excess == excess);
}

// Writes -1 for boxes that pass the test of near_bent(), 0 for others.
VOTESS_INLINE void near_bent_boxes(const BoxBlock& b, const WeightBlock& w, const WeightTilt& t, const WeightBend& bent,
                                   double length, Long4 (&out)[2]) {
    using Lanes = Double4;
    constexpr double rounding = 1e-12;
    for (int i = 0; i < box_fan; i += 4) {
        Lanes y[3], half[3], near[3], end[3], m[3], across{}, along{},
            excess = *reinterpret_cast<const Lanes*>(w.top + i) - t.base, size;
        absolute(excess, size);
        for (int k = 0; k < 3; ++k) {
            const Lanes lower = *reinterpret_cast<const Lanes*>(b.lower[k] + i),
                        upper = *reinterpret_cast<const Lanes*>(b.upper[k] + i);
            near[k] = lower - t.origin[k];
            end[k] = upper - t.origin[k];
            y[k] = 0.5 * (upper + lower) - t.origin[k];
            half[k] = 0.5 * (upper - lower);
            m[k] = near[k] > 0 ? near[k] : end[k] < 0 ? end[k] : Lanes{};
            Lanes distance;
            absolute(y[k], distance);
            across += distance + half[k];
        }
        for (int k = 0; k < 3; ++k) {
            const Lanes slope = *reinterpret_cast<const Lanes*>(w.slope[k] + i);
            const Lanes by = bent.bend[k][0] * y[0] + bent.bend[k][1] * y[1] + bent.bend[k][2] * y[2];
            Lanes apart, steep;
            absolute(slope - t.slope[k] - 2 * by, apart);
            absolute(slope, steep);
            excess += (apart + bent.downward[k] * half[k]) * half[k] - y[k] * (t.slope[k] + by);
            along += steep * half[k];
        }
        size += along + across * (bent.steepest_slope + (3 * bent.largest) * across);
        // As y.A.y is convex, it is at least 2 y.A.m - m.A.m for any m, which is least at a corner. m is about where
        // y.A.y is least.
        for (int k = 0; k < 3; ++k) {
            const int j = (k + 1) % 3, l = (k + 2) % 3;
            Lanes at = (bent.bend[k][j] * m[j] + bent.bend[k][l] * m[l]) * (1 / (1 - bent.bend[k][k]));
            at = at < near[k] ? near[k] : at;
            m[k] = at > end[k] ? end[k] : at;
        }
        Lanes least{};
        for (int k = 0; k < 3; ++k) {
            const Lanes am = m[k] - (bent.bend[k][0] * m[0] + bent.bend[k][1] * m[1] + bent.bend[k][2] * m[2]);
            least += am * (2 * (am > 0 ? near[k] : end[k]) - m[k]);
        }
        least -= rounding * (1 + 3 * bent.largest) * across * across;
        within_bent(least, excess - t.least + residual_slack * size, bent, length, out[i / 4]);
        // Missing boxes have no center.
        out[i / 4] &=
            *reinterpret_cast<const Lanes*>(b.lower[0] + i) <= *reinterpret_cast<const Lanes*>(b.upper[0] + i);
    }
}

// The same for four seeds.
VOTESS_INLINE void near_bent_seeds(const Double4 (&x)[3], const Double4& weight, const BentFrame& frame, Long4& out) {
    using Lanes = Double4;
    const WeightTilt& t = *frame.bent_tilt;
    const WeightBend& bent = *frame.bend;
    const Lanes y[3] = {x[0] - t.origin[0], x[1] - t.origin[1], x[2] - t.origin[2]};
    Lanes across{}, square{}, bends{}, excess = weight - t.base, size;
    absolute(excess, size);
    for (int k = 0; k < 3; ++k) {
        Lanes distance;
        absolute(y[k], distance);
        across += distance;
        square += y[k] * y[k];
        bends += y[k] * (bent.bend[k][0] * y[0] + bent.bend[k][1] * y[1] + bent.bend[k][2] * y[2]);
        excess -= y[k] * t.slope[k];
    }
    size += across * (bent.steepest_slope + (3 * bent.largest) * across);
    within_bent(square - bends - 1e-12 * (1 + 3 * bent.largest) * square,
                excess - bends - t.least + residual_slack * size, bent, frame.length, out);
    out &= x[0] < std::numeric_limits<double>::infinity();  // padding
}

// The residuals of four seeds, rounded.
VOTESS_INLINE void residuals(const Double4 (&x)[3], const Double4& weight, const WeightTilt& t, Double4& out) {
    out = weight - t.base;
    for (int k = 0; k < 3; ++k) out -= t.slope[k] * (x[k] - t.origin[k]);
}

struct Baseline {
    static constexpr const char* name = "baseline";

    // For rounded numbers: a * b may be rounded before c is added.
    using Lanes = Double4;
    VOTESS_INLINE static void multiply_add(const Lanes& a, const Lanes& b, const Lanes& c, Lanes& out) {
        out = a * b + c;
    }
    // True for NaN too.
    VOTESS_INLINE static bool any_above(const Lanes& a, double limit) {
        return !(a[0] <= limit && a[1] <= limit && a[2] <= limit && a[3] <= limit);
    }
    VOTESS_INLINE static void multiply_subtract(const Lanes& a, const Lanes& b, const Lanes& c, Lanes& out) {
        out = a * b - c;
    }

    VOTESS_INLINE static unsigned bits(const Long4& m) {
        return static_cast<unsigned>((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
    }

    // Each case is a function by itself: compilers compute the constants of all cases before they branch.
    template <bool Place, bool Nearest>
    [[gnu::noinline]] static unsigned heavier_bits(const BoxBlock& b, const WeightBlock& w, const Box& home,
                                                   const HeavierTest& test) {
        Long4 near[2];
        Double4 most[2];
        near_heavier_boxes<Place, Nearest>(b, w, home, test, near, most);
        unsigned found = bits(near[0]) | bits(near[1]) << 4;
        if constexpr (!Place && !Nearest) {
            Long4 heavy[2];
            for (int i = 0; i < 2; ++i) much_heavier(test, most[i], heavy[i]);
            if ((found & (bits(heavy[0]) | bits(heavy[1]) << 4)) != 0) found &= heavy_bits(b, w, home, test, most);
        }
        return found;
    }
    [[gnu::noinline]] static unsigned heavy_bits(const BoxBlock& b, const WeightBlock& w, const Box& home,
                                                 const HeavierTest& test, const Double4 (&most)[2]) {
        Long4 near[2];
        heavy_boxes(b, w, home, test, most, near);
        return bits(near[0]) | bits(near[1]) << 4;
    }
    static unsigned near_heavier(const BoxBlock& b, const WeightBlock& w, const Box& home, const HeavierTest& test) {
        if (test.nearest > 0) return heavier_bits<false, true>(b, w, home, test);
        return home.lower == home.upper ? heavier_bits<true, false>(b, w, home, test)
                                        : heavier_bits<false, false>(b, w, home, test);
    }

    static unsigned near_bent(const BoxBlock& b, const WeightBlock& w, const WeightTilt& t, const WeightBend& bend,
                              double length) {
        Long4 near[2];
        near_bent_boxes(b, w, t, bend, length, near);
        return bits(near[0]) | bits(near[1]) << 4;
    }

    VOTESS_INLINE static unsigned near_boxes(const BoxBlock& b, const Box& home, double distance_squared) {
        double sum[box_fan] = {};
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < box_fan; ++i) {
                const double gap = gap_between(b.lower[k][i] - home.upper[k], home.lower[k] - b.upper[k][i]);
                sum[i] += gap * gap;
            }
        unsigned mask = 0;
        for (int i = 0; i < box_fan; ++i) mask |= static_cast<unsigned>(sum[i] < distance_squared) << i;
        return mask;
    }

    VOTESS_INLINE static int list_bits(unsigned mask, std::uint32_t first, std::uint32_t* out) {
        int count = 0;
        for (std::uint32_t k = 0; k < box_fan; ++k) {
            out[count] = first + k;
            count += static_cast<int>((mask >> k) & 1);
        }
        return count;
    }

    VOTESS_INLINE static unsigned inside_ball(const double* x, const double* y, const double* z, const GroupTest& t,
                                              double least) {
        unsigned mask = 0;
        for (int i = 0; i < box_fan; ++i) {
            const double nx = (x[i] - t.p[0]) * t.scale, ny = (y[i] - t.p[1]) * t.scale, nz = (z[i] - t.p[2]) * t.scale;
            const double square = nx * nx + ny * ny + nz * nz;
            const double excess = nx * t.v[0] + ny * t.v[1] + nz * t.v[2] - 0.5 * square;
            // NaN if the seed is padding, infinitely far away.
            const double margin = excess + (relative_slack * square + t.slack);
            mask |= static_cast<unsigned>((margin >= 0) & (square >= least)) << i;
        }
        return mask;
    }

    static int to_window(const GroupSource& from, const WindowFrame& frame, std::int32_t* const* out, std::int32_t* ids,
                         float* residual) {
        return frame.tilt == nullptr ? write_window<false>(from, frame, out, ids, residual)
                                     : write_window<true>(from, frame, out, ids, residual);
    }
    static int to_bent_window(const GroupSource& from, const BentFrame& frame, std::int32_t* const* out,
                              std::int32_t* ids, float* residual) {
        return write_window<true>(from, frame, out, ids, residual);
    }
    template <bool Weighted, class Frame>
    static int write_window(const GroupSource& from, const Frame& frame, std::int32_t* const* out, std::int32_t* ids,
                            [[maybe_unused]] float* residual) {
        constexpr double range = window_range;
        const HeavierTest test(Weighted ? *frame.tilt : WeightTilt{}, frame.length, 0, 0);
        int count = 0;
        for (std::size_t g = 0; g < from.groups.size(); ++g) {
            const std::size_t seed = std::size_t{from.groups[g]} * box_fan;
            double sum[box_fan] = {};
            std::int32_t at[3][box_fan];
            for (int k = 0; k < 3; ++k) {
                const double* x = from.seeds[k] + seed;
                for (int i = 0; i < box_fan; ++i) {
                    const double gap = gap_between(frame.home.lower[k] - x[i], x[i] - frame.home.upper[k]);
                    sum[i] += gap * gap;
                    double v = (x[i] - frame.origin[k]) * frame.scale;
                    v = v > -range ? v : -range;
                    v = v < range ? v : range;
                    at[k][i] = static_cast<std::int32_t>(v + (v < 0 ? -0.5 : 0.5));
                }
            }
            unsigned inside = 0;
            float rest[box_fan];
            if constexpr (Weighted) {
                for (int i = 0; i < box_fan; i += 4) {
                    Lanes x[3], weight, gaps2, r;
                    std::memcpy(&gaps2, sum + i, sizeof gaps2);
                    std::memcpy(&weight, from.weights + seed + i, sizeof weight);
                    for (int k = 0; k < 3; ++k) std::memcpy(&x[k], from.seeds[k] + seed + i, sizeof x[k]);
                    residuals(x, weight, *frame.tilt, r);
                    Long4 within;
                    if constexpr (std::is_same_v<Frame, BentFrame>)
                        near_bent_seeds(x, weight, frame, within);
                    else
                        heavier_seeds(gaps2, r, *frame.tilt, test, within);
                    inside |= bits(within) << i;
                    for (int k = 0; k < 4; ++k) rest[i + k] = static_cast<float>(r[k] * (frame.scale * frame.scale));
                }
            } else {
                for (int i = 0; i < box_fan; ++i) inside |= static_cast<unsigned>(sum[i] < frame.distance_squared) << i;
            }
            if (g < from.kept) inside = (1u << box_fan) - 1;
            for (int i = 0; i < box_fan; ++i) {
                for (int k = 0; k < 3; ++k) out[k][count] = at[k][i];
                ids[count] = static_cast<std::int32_t>(seed) + i;
                if constexpr (Weighted) residual[count] = rest[i];
                count += static_cast<int>(inside >> i & 1);
            }
        }
        return count;
    }

    static bool select(const WindowSeeds& w, const std::int32_t* p, float weight, const SelectLimits& limits,
                       CandidatePlanes& c) {
        return w.weight == nullptr ? select_seeds<false>(w, p, weight, limits, c)
                                   : select_seeds<true>(w, p, weight, limits, c);
    }
    static bool select_bent(const WindowSeeds& w, const std::int32_t* p, float weight, const BentLimits& limits,
                            CandidatePlanes& c) {
        return select_seeds<true>(w, p, weight, limits, c);
    }
    template <bool Weighted, class Limits>
    static bool select_seeds(const WindowSeeds& w, const std::int32_t* p, [[maybe_unused]] float weight,
                             const Limits& limits, CandidatePlanes& c) {
        int near = c.count, far = 0;
        float longest = 0;
        for (int i = 0; i < w.count; i += 4) {
            const auto difference = [i](const std::int32_t* at, std::int32_t from) {
                return __builtin_convertvector(load(at + i) - from, Float4);
            };
            const Float4 nx = difference(w.x, p[0]), ny = difference(w.y, p[1]), nz = difference(w.z, p[2]);
            const Float4 d = nx * nx + ny * ny + nz * nz;
            Float4 h = 0.5f * d;
            if constexpr (Weighted) h = 0.5f * (d + (weight - load(w.weight + i)));
            Float4 square = d;
            if constexpr (std::is_same_v<Limits, BentLimits>) {
                h += 0.5f * (nx * limits.turn[0] + ny * limits.turn[1] + nz * limits.turn[2]);
                const float* g = limits.metric;
                square = nx * (g[0] * nx + g[5] * ny) + ny * (g[1] * ny + g[3] * nz) + nz * (g[2] * nz + g[4] * nx);
            }
            const auto within = [&](float squared) {
                if constexpr (!Weighted) return mask_of(d < squared);
                const Float4 less = h - limits.slack;
                return mask_of(4 * less * (less < 0 ? -less : less) < squared * square);
            };
            unsigned inside = within(limits.distance_squared);
            if (inside == 0) continue;
            const unsigned is_near = within(limits.near_squared);
            if (near > CandidatePlanes::capacity - 4 || far > CandidatePlanes::capacity - 4) return false;
            for (int k = 0; k < 4; ++k)
                if ((inside >> k & 1) != 0) longest = std::max(longest, d[k]);
            for (; inside != 0; inside &= inside - 1) {
                const int k = std::countr_zero(inside);
                const int one = static_cast<int>(is_near >> k & 1);
                const int to = one != 0 ? near : far_begin + far;
                c.nx[to] = nx[k];
                c.ny[to] = ny[k];
                c.nz[to] = nz[k];
                c.h[to] = h[k];
                c.id[to] = w.id[i + k];
                near += one;
                far += 1 - one;
            }
        }
        c.longest_squared = longest;
        return join(c, near, far);
    }

    VOTESS_INLINE static void first_hits(const CandidatePlanes& c, int count, const Ray* rays, int number, int* hits) {
        const float infinity = std::numeric_limits<float>::infinity();
        for (int r = 0; r < number; ++r) {
            const auto& [o, d, least] = rays[r];
            Float4 best = Float4{} + infinity;
            Int4 at = Int4{} - 1, index{0, 1, 2, 3};
            for (int i = 0; i < count; i += 4, index += 4) {
                const Float4 nx = load(c.nx + i), ny = load(c.ny + i), nz = load(c.nz + i), h = load(c.h + i);
                const Float4 leaving = nx * d[0] + ny * d[1] + nz * d[2];
                const Float4 t = (h - nx * o[0] - ny * o[1] - nz * o[2]) / leaving;
                const Int4 better = (leaving > least) & (t < best);
                best = better ? t : best;
                at = better ? index : at;
            }
            hits[r] = -1;
            float nearest = infinity;
            for (int k = 0; k < 4; ++k)
                if (best[k] < nearest) nearest = best[k], hits[r] = at[k];
        }
    }

    VOTESS_INLINE static int touching(const CandidatePlanes& c, int count, const float* v, const std::int32_t* three,
                                      int begin) {
        unsigned behind = ~0u << (begin % 4);
        for (int i = begin / 4 * 4; i < count; i += 4, behind = ~0u) {
            const Float4 gap = load(c.h + i) - load(c.nx + i) * v[0] - load(c.ny + i) * v[1] - load(c.nz + i) * v[2];
            const Int4 id = load(c.id + i);
            const Int4 other = (id != three[0]) & (id != three[1]) & (id != three[2]);
            const unsigned mask = mask_of((gap <= v[3]) & other) & behind;
            if (mask != 0) return i + std::countr_zero(mask);
        }
        return -1;
    }

    static void rank(const std::int32_t* ids, int count, std::uint32_t* places) {
        for (int i = 0; i < count; ++i) {
            int smaller = 0;
            for (int k = 0; k < count; ++k) smaller += ids[k] < ids[i] ? 1 : 0;
            places[i] = static_cast<std::uint32_t>(smaller);
        }
    }

    [[gnu::noinline]] static void order_corners(const CellShape& shape, CornerOrder& out) {
        constexpr int bits = 6, most = (1 << bits) - 1;
        static_assert(most + 1 == CellShape::max_planes);
        std::array<std::int32_t, CellShape::max_corners> keys;
        for (int k = 0; k < shape.corners; ++k) {
            const int p = shape.rank[shape.a[k]], q = shape.rank[shape.b[k]], r = shape.rank[shape.c[k]];
            const int low = p < q ? p : q, high = p < q ? q : p;
            const int least = low < r ? low : r, greatest = high > r ? high : r, other = p + q + r - least - greatest;
            keys[k] = least << (2 * bits) | other << bits | greatest;
        }
        std::array<std::uint32_t, CellShape::max_corners> places;
        rank(keys.data(), shape.corners, places.data());
        for (int k = 0; k < shape.corners; ++k) {
            out.rank[0][places[k]] = static_cast<std::uint16_t>(CornerOrder::rank_step * (keys[k] >> (2 * bits)));
            out.rank[1][places[k]] = static_cast<std::uint16_t>(CornerOrder::rank_step * (keys[k] >> bits & most));
            out.rank[2][places[k]] = static_cast<std::uint16_t>(CornerOrder::rank_step * (keys[k] & most));
        }
        fill_corners(shape.corners, out);
    }
    VOTESS_INLINE static void fill_corners(int corners, CornerOrder& out) {
        for (int p = 0; p < 3; ++p)
            for (int k = 0; k < 4; ++k)
                out.rank[p][corners + k] =
                    static_cast<std::uint16_t>(CornerOrder::rank_step * (CellShape::max_planes + p));
    }

private:
    // Returns the gap between two intervals whose distances are given, one of which is positive if they are apart.
    VOTESS_INLINE static double gap_between(double below, double above) {
        const double gap = below > above ? below : above;
        return gap > 0 ? gap : 0;
    }
};

}  // namespace votess::cpu
