// The loops of StarKernels in plain C++: the baseline, and for other sets where the compiler does as well.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "cpu/walk/kernels/star_kernels.hpp"

namespace votess::cpu {

extern const StarKernels star_kernels_avx2, star_kernels_avx512;

// With GroupTest::slack this is more than 2e-8 (h + |v| sqrt(h)), h = |n|^2 / 2.
constexpr double relative_slack = 4e-8;

#define VOTESS_INLINE inline __attribute__((always_inline))

template <class T, int L>
using Vector __attribute__((vector_size(L * sizeof(T)))) = T;

// select() puts the far planes here at first.
constexpr int far_begin = CandidatePlanes::capacity + 16;
static_assert(far_begin % 16 == 0);

VOTESS_INLINE void pad(CandidatePlanes& c) {
    for (int i = 0; i < 16; ++i) {
        c.nx[c.count + i] = c.ny[c.count + i] = c.nz[c.count + i] = 0;
        c.h[c.count + i] = CandidatePlanes::never;
    }
}

VOTESS_INLINE unsigned near_boxes_body(const BoxBlock& b, const Box& home, double distance_squared) {
    double sum[box_fan] = {};
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < box_fan; ++i) {
            const double below = b.lower[k][i] - home.upper[k], above = home.lower[k] - b.upper[k][i];
            double gap = below > above ? below : above;
            gap = gap > 0 ? gap : 0;
            sum[i] += gap * gap;
        }
    unsigned mask = 0;
    for (int i = 0; i < box_fan; ++i) mask |= static_cast<unsigned>(sum[i] < distance_squared) << i;
    return mask;
}

VOTESS_INLINE unsigned inside_ball_body(const double* x, const double* y, const double* z, const GroupTest& t,
                                        double least) {
    unsigned mask = 0;
    for (int i = 0; i < box_fan; ++i) {
        const double nx = (x[i] - t.p[0]) * t.scale, ny = (y[i] - t.p[1]) * t.scale, nz = (z[i] - t.p[2]) * t.scale;
        const double square = nx * nx + ny * ny + nz * nz;
        const double excess = nx * t.v[0] + ny * t.v[1] + nz * t.v[2] - 0.5 * square;
        // Not a number where the seed is padding, infinitely far away.
        const double margin = excess + (relative_slack * square + t.slack);
        mask |= static_cast<unsigned>((margin >= 0) & (square >= least)) << i;
    }
    return mask;
}

VOTESS_INLINE int to_window_body(const GroupSource& from, const WindowFrame& frame, std::int32_t* const* out,
                                 std::int32_t* ids) {
    constexpr double range = window_range;
    int count = 0;
    for (std::size_t g = 0; g < from.groups.size(); ++g)
        for (std::size_t i = 0; i < box_fan; ++i) {
            const std::size_t seed = std::size_t{from.groups[g]} * box_fan + i;
            double sum = 0;
            for (int k = 0; k < 3; ++k) {
                const double x = from.seeds[k][seed];
                const double below = frame.home.lower[k] - x, above = x - frame.home.upper[k];
                double gap = below > above ? below : above;
                gap = gap > 0 ? gap : 0;
                sum += gap * gap;
                double v = (x - frame.origin[k]) * frame.scale;
                v = v > -range ? v : -range;
                v = v < range ? v : range;
                out[k][count] = static_cast<std::int32_t>(v + (v < 0 ? -0.5 : 0.5));
            }
            ids[count] = static_cast<std::int32_t>(seed);
            count += static_cast<int>(g < from.kept) | static_cast<int>(sum < frame.distance_squared);
        }
    return count;
}

// Moves `far` planes from far_begin to behind the first `near`; false when they are too many.
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

template <int L>
VOTESS_INLINE bool select_body(const WindowSeeds& w, const std::int32_t* p, float weight, float near_squared,
                               float distance_squared, CandidatePlanes& c) {
    int near = c.count, far = 0;
    for (int i = 0; i < w.count; i += L) {
        float nx[L], ny[L], nz[L], d[L];
        for (int k = 0; k < L; ++k) {
            nx[k] = static_cast<float>(w.x[i + k] - p[0]);
            ny[k] = static_cast<float>(w.y[i + k] - p[1]);
            nz[k] = static_cast<float>(w.z[i + k] - p[2]);
            d[k] = nx[k] * nx[k] + ny[k] * ny[k] + nz[k] * nz[k];
        }
        unsigned inside = 0;
        for (int k = 0; k < L; ++k) inside |= static_cast<unsigned>(d[k] < distance_squared) << k;
        if (near > CandidatePlanes::capacity - L || far > CandidatePlanes::capacity - L) return false;
        for (; inside != 0; inside &= inside - 1) {
            const int k = std::countr_zero(inside);
            int& at = d[k] < near_squared ? near : far;
            const int to = &at == &near ? near : far_begin + far;
            c.nx[to] = nx[k];
            c.ny[to] = ny[k];
            c.nz[to] = nz[k];
            c.h[to] = 0.5f * (w.weight == nullptr ? d[k] : d[k] + (weight - w.weight[i + k]));
            c.id[to] = w.id[i + k];
            ++at;
        }
    }
    return join(c, near, far);
}

template <int L>
VOTESS_INLINE void first_hits_body(const CandidatePlanes& c, int count, const Ray* rays, int* hits) {
    using Real = Vector<float, L>;
    using Index = Vector<std::int32_t, L>;
    const float infinity = std::numeric_limits<float>::infinity();
    for (int r = 0; r < 2; ++r) {
        const auto& [o, d, s, least] = rays[r];
        Real best = Real{} + infinity;
        Index at = Index{} - 1;
        Index index;
        for (int k = 0; k < L; ++k) index[k] = k;
        for (int i = 0; i < count; i += L, index += L) {
            Real nx, ny, nz, h;
            std::memcpy(&nx, c.nx + i, sizeof nx);
            std::memcpy(&ny, c.ny + i, sizeof ny);
            std::memcpy(&nz, c.nz + i, sizeof nz);
            std::memcpy(&h, c.h + i, sizeof h);
            const Real leaving = nx * d[0] + ny * d[1] + nz * d[2];
            const Real t = (h * s - nx * o[0] - ny * o[1] - nz * o[2]) / leaving;
            const Index better = (leaving > least) & (t < best);
            best = better ? t : best;
            at = better ? index : at;
        }
        hits[r] = -1;
        float nearest = infinity;
        for (int k = 0; k < L; ++k)
            if (best[k] < nearest) nearest = best[k], hits[r] = at[k];
    }
}

template <int L>
VOTESS_INLINE int touching_body(const CandidatePlanes& c, int count, const float* v, const std::int32_t* three,
                                int begin) {
    for (int i = begin / L * L; i < count; i += L) {
        unsigned mask = 0;
        for (int k = 0; k < L; ++k) {
            const float gap = c.h[i + k] - c.nx[i + k] * v[0] - c.ny[i + k] * v[1] - c.nz[i + k] * v[2];
            const std::int32_t id = c.id[i + k];
            const bool other = (id != three[0]) & (id != three[1]) & (id != three[2]);
            mask |= static_cast<unsigned>((gap <= v[3]) & other & (i + k >= begin)) << k;
        }
        if (mask != 0) return i + std::countr_zero(mask);
    }
    return -1;
}

VOTESS_INLINE void rank_body(const std::int32_t* ids, int count, std::uint16_t* places) {
    for (int i = 0; i < count; ++i) {
        int smaller = 0;
        for (int k = 0; k < count; ++k) smaller += ids[k] < ids[i] ? 1 : 0;
        places[i] = static_cast<std::uint16_t>(smaller);
    }
}

inline constexpr StarKernels kernels_baseline{"baseline",     near_boxes_body,    inside_ball_body, to_window_body,
                                              select_body<4>, first_hits_body<4>, touching_body<4>, rank_body};

}  // namespace votess::cpu
