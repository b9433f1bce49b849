#include "cpu/star_kernels.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#if defined(__x86_64__)
// GCC 12 takes the undefined operands that its own header passes to masked instructions for mistakes (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#endif

namespace votess::cpu {
namespace {

// With GroupTest::slack this is more than 2e-8 (h + |v| sqrt(h)), h = |n|^2 / 2.
constexpr double relative_slack = 4e-8;

#define VOTESS_INLINE inline __attribute__((always_inline))

template <class T, int L>
using Vector __attribute__((vector_size(L * sizeof(T)))) = T;

VOTESS_INLINE void pad(CandidatePlanes& c) {
    for (int i = c.count; i < (c.count + 15) / 16 * 16; ++i) {
        c.nx[i] = c.ny[i] = c.nz[i] = 0;
        c.h[i] = CandidatePlanes::never;
    }
}

VOTESS_INLINE unsigned near_boxes_body(const BoxBlock& b, const BoundingBox& home, double distance_squared) {
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

template <int L>
VOTESS_INLINE bool select_body(const WindowSeeds& w, const std::int32_t* p, float distance_squared,
                               CandidatePlanes& c) {
    int count = 0;
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
        for (; inside != 0; inside &= inside - 1) {
            const int k = std::countr_zero(inside);
            if (count == CandidatePlanes::capacity) return false;
            c.nx[count] = nx[k];
            c.ny[count] = ny[k];
            c.nz[count] = nz[k];
            c.h[count] = 0.5f * d[k];
            c.id[count] = w.id[i + k];
            ++count;
        }
    }
    c.count = count;
    pad(c);
    return true;
}

template <int L>
VOTESS_INLINE void first_hits_body(const CandidatePlanes& c, const Ray* rays, int* hits) {
    using Real = Vector<float, L>;
    using Index = Vector<std::int32_t, L>;
    const float infinity = std::numeric_limits<float>::infinity();
    for (int r = 0; r < 2; ++r) {
        const auto& [o, d, s, least] = rays[r];
        Real best = Real{} + infinity;
        Index at = Index{} - 1;
        Index index;
        for (int k = 0; k < L; ++k) index[k] = k;
        for (int i = 0; i < c.count; i += L, index += L) {
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
VOTESS_INLINE int touching_body(const CandidatePlanes& c, const float* v, const std::int32_t* three, int begin) {
    for (int i = begin / L * L; i < c.count; i += L) {
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

#if defined(__x86_64__)
#define VOTESS_AVX2 __attribute__((target("avx2,fma,popcnt,bmi")))
#define VOTESS_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi,prefer-vector-width=512")))

VOTESS_AVX2 unsigned near_boxes_avx2(const BoxBlock& b, const BoundingBox& home, double distance_squared) {
    unsigned mask = 0;
    const __m256d limit = _mm256_set1_pd(distance_squared);
    for (int i = 0; i < box_fan; i += 4) {
        __m256d sum = _mm256_setzero_pd();
        for (int k = 0; k < 3; ++k) {
            __m256d gap = _mm256_max_pd(_mm256_sub_pd(_mm256_load_pd(b.lower[k] + i), _mm256_set1_pd(home.upper[k])),
                                        _mm256_sub_pd(_mm256_set1_pd(home.lower[k]), _mm256_load_pd(b.upper[k] + i)));
            gap = _mm256_max_pd(gap, _mm256_setzero_pd());
            sum = _mm256_add_pd(sum, _mm256_mul_pd(gap, gap));
        }
        mask |= static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(sum, limit, _CMP_LT_OQ))) << i;
    }
    return mask;
}

VOTESS_AVX2 unsigned inside_ball_avx2(const double* x, const double* y, const double* z, const GroupTest& t,
                                      double least) {
    return inside_ball_body(x, y, z, t, least);
}

VOTESS_AVX2 int to_window_avx2(const GroupSource& from, const WindowFrame& frame, std::int32_t* const* out,
                               std::int32_t* ids) {
    const __m256d range = _mm256_set1_pd(window_range), least = _mm256_set1_pd(-window_range);
    const __m256d scale = _mm256_set1_pd(frame.scale), limit = _mm256_set1_pd(frame.distance_squared);
    int count = 0;
    for (std::size_t g = 0; g < from.groups.size(); ++g)
        for (std::size_t i = 0; i < box_fan; i += 4) {
            const std::size_t seed = std::size_t{from.groups[g]} * box_fan + i;
            __m256d sum = _mm256_setzero_pd();
            alignas(16) std::int32_t at[3][4];
            for (int k = 0; k < 3; ++k) {
                const __m256d x = _mm256_loadu_pd(from.seeds[k] + seed);
                __m256d gap = _mm256_max_pd(_mm256_sub_pd(_mm256_set1_pd(frame.home.lower[k]), x),
                                            _mm256_sub_pd(x, _mm256_set1_pd(frame.home.upper[k])));
                gap = _mm256_max_pd(gap, _mm256_setzero_pd());
                sum = _mm256_add_pd(sum, _mm256_mul_pd(gap, gap));
                __m256d v = _mm256_mul_pd(_mm256_sub_pd(x, _mm256_set1_pd(frame.origin[k])), scale);
                v = _mm256_min_pd(_mm256_max_pd(v, least), range);
                _mm_store_si128(reinterpret_cast<__m128i*>(at[k]), _mm256_cvtpd_epi32(v));
            }
            auto inside = static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(sum, limit, _CMP_LT_OQ)));
            if (g < from.kept) inside = 15;
            for (; inside != 0; inside &= inside - 1, ++count) {
                const int lane = std::countr_zero(inside);
                for (int k = 0; k < 3; ++k) out[k][count] = at[k][lane];
                ids[count] = static_cast<std::int32_t>(seed) + lane;
            }
        }
    return count;
}

VOTESS_AVX2 bool select_avx2(const WindowSeeds& w, const std::int32_t* p, float distance_squared, CandidatePlanes& c) {
    const __m256i px = _mm256_set1_epi32(p[0]), py = _mm256_set1_epi32(p[1]), pz = _mm256_set1_epi32(p[2]);
    const __m256 limit = _mm256_set1_ps(distance_squared);
    int count = 0;
    for (int i = 0; i < w.count; i += 8) {
        auto difference = [i](const std::int32_t* at, __m256i from) VOTESS_AVX2 {
            return _mm256_cvtepi32_ps(
                _mm256_sub_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(at + i)), from));
        };
        const __m256 nx = difference(w.x, px), ny = difference(w.y, py), nz = difference(w.z, pz);
        const __m256 d = _mm256_fmadd_ps(nx, nx, _mm256_fmadd_ps(ny, ny, _mm256_mul_ps(nz, nz)));
        auto inside = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(d, limit, _CMP_LT_OQ)));
        if (inside == 0) continue;
        if (count > CandidatePlanes::capacity - 8) return false;
        alignas(32) float n[4][8];
        _mm256_store_ps(n[0], nx);
        _mm256_store_ps(n[1], ny);
        _mm256_store_ps(n[2], nz);
        _mm256_store_ps(n[3], _mm256_mul_ps(d, _mm256_set1_ps(0.5f)));
        for (; inside != 0; inside &= inside - 1, ++count) {
            const int k = std::countr_zero(inside);
            c.nx[count] = n[0][k];
            c.ny[count] = n[1][k];
            c.nz[count] = n[2][k];
            c.h[count] = n[3][k];
            c.id[count] = w.id[i + k];
        }
    }
    c.count = count;
    pad(c);
    return true;
}

VOTESS_AVX2 int hit_of(__m256 best, __m256i at) {
    __m256 least = _mm256_min_ps(best, _mm256_permute2f128_ps(best, best, 1));
    least = _mm256_min_ps(least, _mm256_shuffle_ps(least, least, 0x4e));
    least = _mm256_min_ps(least, _mm256_shuffle_ps(least, least, 0xb1));
    const auto where = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(best, least, _CMP_EQ_OQ)));
    alignas(32) std::int32_t found[8];
    _mm256_store_si256(reinterpret_cast<__m256i*>(found), at);
    return found[std::countr_zero(where) & 7];
}

VOTESS_AVX2 void first_hits_avx2(const CandidatePlanes& c, const Ray* rays, int* hits) {
    const __m256 infinity = _mm256_set1_ps(std::numeric_limits<float>::infinity());
    for (int r = 0; r < 2; ++r) {
        const auto& [o, d, s, least] = rays[r];
        const __m256 ox = _mm256_set1_ps(o[0]), oy = _mm256_set1_ps(o[1]), oz = _mm256_set1_ps(o[2]);
        const __m256 dx = _mm256_set1_ps(d[0]), dy = _mm256_set1_ps(d[1]), dz = _mm256_set1_ps(d[2]);
        const __m256 limit = _mm256_set1_ps(least);
        __m256 best = infinity;
        __m256i at = _mm256_set1_epi32(-1), index = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        for (int i = 0; i < c.count; i += 8) {
            const __m256 nx = _mm256_load_ps(c.nx + i), ny = _mm256_load_ps(c.ny + i), nz = _mm256_load_ps(c.nz + i);
            const __m256 leaving = _mm256_fmadd_ps(nx, dx, _mm256_fmadd_ps(ny, dy, _mm256_mul_ps(nz, dz)));
            const __m256 hs = _mm256_mul_ps(_mm256_load_ps(c.h + i), _mm256_set1_ps(s));
            const __m256 gap = _mm256_fnmadd_ps(nx, ox, _mm256_fnmadd_ps(ny, oy, _mm256_fnmadd_ps(nz, oz, hs)));
            const __m256 t = _mm256_blendv_ps(infinity, _mm256_div_ps(gap, leaving),
                                              _mm256_cmp_ps(leaving, limit, _CMP_GT_OQ));
            const __m256 better = _mm256_cmp_ps(t, best, _CMP_LT_OQ);
            best = _mm256_blendv_ps(best, t, better);
            at = _mm256_blendv_epi8(at, index, _mm256_castps_si256(better));
            index = _mm256_add_epi32(index, _mm256_set1_epi32(8));
        }
        hits[r] = hit_of(best, at);
    }
}

VOTESS_AVX2 int touching_avx2(const CandidatePlanes& c, const float* v, const std::int32_t* three, int begin) {
    const __m256 vx = _mm256_set1_ps(v[0]), vy = _mm256_set1_ps(v[1]), vz = _mm256_set1_ps(v[2]);
    const __m256 limit = _mm256_set1_ps(v[3]);
    const __m256i i0 = _mm256_set1_epi32(three[0]), i1 = _mm256_set1_epi32(three[1]), i2 = _mm256_set1_epi32(three[2]);
    unsigned behind = ~0u << (begin % 8);
    for (int i = begin / 8 * 8; i < c.count; i += 8, behind = ~0u) {
        const __m256 gap = _mm256_fnmadd_ps(
            _mm256_load_ps(c.nx + i), vx,
            _mm256_fnmadd_ps(_mm256_load_ps(c.ny + i), vy,
                             _mm256_fnmadd_ps(_mm256_load_ps(c.nz + i), vz, _mm256_load_ps(c.h + i))));
        const __m256i id = _mm256_load_si256(reinterpret_cast<const __m256i*>(c.id + i));
        const __m256i same = _mm256_or_si256(_mm256_cmpeq_epi32(id, i0),
                                             _mm256_or_si256(_mm256_cmpeq_epi32(id, i1), _mm256_cmpeq_epi32(id, i2)));
        const auto mask = static_cast<unsigned>(_mm256_movemask_ps(
                              _mm256_andnot_ps(_mm256_castsi256_ps(same), _mm256_cmp_ps(gap, limit, _CMP_LE_OQ)))) &
                          behind;
        if (mask != 0) return i + std::countr_zero(mask);
    }
    return -1;
}

VOTESS_AVX512 unsigned near_boxes_avx512(const BoxBlock& b, const BoundingBox& home, double distance_squared) {
    __m512d sum = _mm512_setzero_pd();
    for (int k = 0; k < 3; ++k) {
        __m512d gap = _mm512_max_pd(_mm512_sub_pd(_mm512_load_pd(b.lower[k]), _mm512_set1_pd(home.upper[k])),
                                    _mm512_sub_pd(_mm512_set1_pd(home.lower[k]), _mm512_load_pd(b.upper[k])));
        gap = _mm512_max_pd(gap, _mm512_setzero_pd());
        sum = _mm512_add_pd(sum, _mm512_mul_pd(gap, gap));
    }
    return _mm512_cmp_pd_mask(sum, _mm512_set1_pd(distance_squared), _CMP_LT_OQ);
}

VOTESS_AVX512 unsigned inside_ball_avx512(const double* x, const double* y, const double* z, const GroupTest& t,
                                          double least) {
    const __m512d scale = _mm512_set1_pd(t.scale);
    const __m512d nx = _mm512_mul_pd(_mm512_sub_pd(_mm512_loadu_pd(x), _mm512_set1_pd(t.p[0])), scale);
    const __m512d ny = _mm512_mul_pd(_mm512_sub_pd(_mm512_loadu_pd(y), _mm512_set1_pd(t.p[1])), scale);
    const __m512d nz = _mm512_mul_pd(_mm512_sub_pd(_mm512_loadu_pd(z), _mm512_set1_pd(t.p[2])), scale);
    const __m512d square = _mm512_fmadd_pd(nx, nx, _mm512_fmadd_pd(ny, ny, _mm512_mul_pd(nz, nz)));
    const __m512d along = _mm512_fmadd_pd(
        nx, _mm512_set1_pd(t.v[0]),
        _mm512_fmadd_pd(ny, _mm512_set1_pd(t.v[1]), _mm512_mul_pd(nz, _mm512_set1_pd(t.v[2]))));
    const __m512d excess = _mm512_fmadd_pd(square, _mm512_set1_pd(relative_slack - 0.5),
                                           _mm512_add_pd(along, _mm512_set1_pd(t.slack)));
    return _mm512_mask_cmp_pd_mask(_mm512_cmp_pd_mask(square, _mm512_set1_pd(least), _CMP_GE_OQ), excess,
                                   _mm512_setzero_pd(), _CMP_GE_OQ);
}

VOTESS_AVX512 int to_window_avx512(const GroupSource& from, const WindowFrame& frame, std::int32_t* const* out,
                                   std::int32_t* ids) {
    const __m512d range = _mm512_set1_pd(window_range), least = _mm512_set1_pd(-window_range);
    const __m512d scale = _mm512_set1_pd(frame.scale), limit = _mm512_set1_pd(frame.distance_squared);
    const __m256i iota = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    int count = 0;
    for (std::size_t g = 0; g < from.groups.size(); ++g) {
        const std::size_t seed = std::size_t{from.groups[g]} * box_fan;
        __m512d sum = _mm512_setzero_pd();
        __m256i at[3];
        for (int k = 0; k < 3; ++k) {
            const __m512d x = _mm512_loadu_pd(from.seeds[k] + seed);
            __m512d gap = _mm512_max_pd(_mm512_sub_pd(_mm512_set1_pd(frame.home.lower[k]), x),
                                        _mm512_sub_pd(x, _mm512_set1_pd(frame.home.upper[k])));
            gap = _mm512_max_pd(gap, _mm512_setzero_pd());
            sum = _mm512_fmadd_pd(gap, gap, sum);
            __m512d v = _mm512_mul_pd(_mm512_sub_pd(x, _mm512_set1_pd(frame.origin[k])), scale);
            v = _mm512_min_pd(_mm512_max_pd(v, least), range);
            at[k] = _mm512_cvtpd_epi32(v);
        }
        __mmask8 inside = _mm512_cmp_pd_mask(sum, limit, _CMP_LT_OQ);
        if (g < from.kept) inside = 0xff;
        for (int k = 0; k < 3; ++k)
            _mm256_storeu_si256(reinterpret_cast<__m256i*>(out[k] + count), _mm256_maskz_compress_epi32(inside, at[k]));
        const __m256i id = _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(seed)), iota);
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(ids + count), _mm256_maskz_compress_epi32(inside, id));
        count += std::popcount(static_cast<unsigned>(inside));
    }
    return count;
}

VOTESS_AVX512 bool select_avx512(const WindowSeeds& w, const std::int32_t* p, float distance_squared,
                                 CandidatePlanes& c) {
    const __m512i px = _mm512_set1_epi32(p[0]), py = _mm512_set1_epi32(p[1]), pz = _mm512_set1_epi32(p[2]);
    const __m512 limit = _mm512_set1_ps(distance_squared), half = _mm512_set1_ps(0.5f);
    int count = 0;
    for (int i = 0; i < w.count; i += 16) {
        const __m512 nx = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_loadu_si512(w.x + i), px));
        const __m512 ny = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_loadu_si512(w.y + i), py));
        const __m512 nz = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_loadu_si512(w.z + i), pz));
        const __m512 d = _mm512_fmadd_ps(nx, nx, _mm512_fmadd_ps(ny, ny, _mm512_mul_ps(nz, nz)));
        const __mmask16 inside = _mm512_cmp_ps_mask(d, limit, _CMP_LT_OQ);
        if (count > CandidatePlanes::capacity) return false;
        _mm512_storeu_ps(c.nx + count, _mm512_maskz_compress_ps(inside, nx));
        _mm512_storeu_ps(c.ny + count, _mm512_maskz_compress_ps(inside, ny));
        _mm512_storeu_ps(c.nz + count, _mm512_maskz_compress_ps(inside, nz));
        _mm512_storeu_ps(c.h + count, _mm512_maskz_compress_ps(inside, _mm512_mul_ps(d, half)));
        _mm512_storeu_si512(c.id + count, _mm512_maskz_compress_epi32(inside, _mm512_loadu_si512(w.id + i)));
        count += std::popcount(static_cast<unsigned>(inside));
    }
    if (count > CandidatePlanes::capacity) return false;
    c.count = count;
    pad(c);
    return true;
}

// The best planes of one ray so far: t in the high bits, as integers of the same order, over the index.
struct Best {
    __m512 ox, oy, oz, dx, dy, dz, s, limit;
    __m512i key;
};
constexpr int index_bits = 0x1ff;  // of CandidatePlanes::capacity

VOTESS_AVX512 VOTESS_INLINE Best start(const Ray& ray) {
    return {_mm512_set1_ps(ray.o[0]), _mm512_set1_ps(ray.o[1]), _mm512_set1_ps(ray.o[2]),
            _mm512_set1_ps(ray.d[0]), _mm512_set1_ps(ray.d[1]), _mm512_set1_ps(ray.d[2]),
            _mm512_set1_ps(ray.s),    _mm512_set1_ps(ray.least), _mm512_set1_epi32(-1 ^ (1 << 31))};
}

VOTESS_AVX512 VOTESS_INLINE void update(Best& b, __m512 nx, __m512 ny, __m512 nz, __m512 h, __m512i index) {
    const __m512 leaving = _mm512_fmadd_ps(nx, b.dx, _mm512_fmadd_ps(ny, b.dy, _mm512_mul_ps(nz, b.dz)));
    const __m512 gap =
        _mm512_fnmadd_ps(nx, b.ox, _mm512_fnmadd_ps(ny, b.oy, _mm512_fnmadd_ps(nz, b.oz, _mm512_mul_ps(h, b.s))));
    const __m512i t = _mm512_castps_si512(_mm512_mul_ps(gap, _mm512_rcp14_ps(leaving)));
    // Negative floats order the other way round.
    const __m512i ordered = _mm512_xor_si512(t, _mm512_srli_epi32(_mm512_srai_epi32(t, 31), 1));
    const __m512i key = _mm512_or_si512(_mm512_andnot_si512(_mm512_set1_epi32(index_bits), ordered), index);
    b.key = _mm512_mask_min_epi32(b.key, _mm512_cmp_ps_mask(leaving, b.limit, _CMP_GT_OQ), b.key, key);
}

VOTESS_AVX512 VOTESS_INLINE int hit_of(const Best& b) {
    const int key = _mm512_reduce_min_epi32(b.key) & index_bits;
    return key == index_bits ? -1 : key;
}

VOTESS_AVX512 void first_hits_avx512(const CandidatePlanes& c, const Ray* rays, int* hits) {
    Best first = start(rays[0]), second = start(rays[1]);
    __m512i index = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (int i = 0; i < c.count; i += 16) {
        const __m512 nx = _mm512_load_ps(c.nx + i), ny = _mm512_load_ps(c.ny + i), nz = _mm512_load_ps(c.nz + i);
        const __m512 h = _mm512_load_ps(c.h + i);
        update(first, nx, ny, nz, h, index);
        update(second, nx, ny, nz, h, index);
        index = _mm512_add_epi32(index, _mm512_set1_epi32(16));
    }
    hits[0] = hit_of(first);
    hits[1] = hit_of(second);
}

VOTESS_AVX512 int touching_avx512(const CandidatePlanes& c, const float* v, const std::int32_t* three, int begin) {
    const __m512 vx = _mm512_set1_ps(v[0]), vy = _mm512_set1_ps(v[1]), vz = _mm512_set1_ps(v[2]);
    const __m512 limit = _mm512_set1_ps(v[3]);
    const __m512i i0 = _mm512_set1_epi32(three[0]), i1 = _mm512_set1_epi32(three[1]), i2 = _mm512_set1_epi32(three[2]);
    auto behind = static_cast<__mmask16>(~0u << (begin % 16));
    for (int i = begin / 16 * 16; i < c.count; i += 16, behind = 0xffff) {
        const __m512 gap = _mm512_fnmadd_ps(
            _mm512_load_ps(c.nx + i), vx,
            _mm512_fnmadd_ps(_mm512_load_ps(c.ny + i), vy,
                             _mm512_fnmadd_ps(_mm512_load_ps(c.nz + i), vz, _mm512_load_ps(c.h + i))));
        const __m512i id = _mm512_load_si512(c.id + i);
        __mmask16 mask = _mm512_mask_cmp_ps_mask(behind, gap, limit, _CMP_LE_OQ);
        mask = _mm512_mask_cmpneq_epi32_mask(mask, id, i0);
        mask = _mm512_mask_cmpneq_epi32_mask(mask, id, i1);
        mask = _mm512_mask_cmpneq_epi32_mask(mask, id, i2);
        if (mask != 0) return i + std::countr_zero(static_cast<unsigned>(mask));
    }
    return -1;
}

VOTESS_AVX2 void rank_avx2(const std::int32_t* ids, int count, std::uint16_t* places) {
    rank_body(ids, count, places);
}

VOTESS_AVX512 void rank_avx512(const std::int32_t* ids, int count, std::uint16_t* places) {
    if (count > 32) return rank_body(ids, count, places);
    const auto first = static_cast<__mmask16>(count >= 16 ? 0xffff : (1 << count) - 1);
    const auto second = static_cast<__mmask16>(count >= 32 ? 0xffff : (count > 16 ? (1 << (count - 16)) - 1 : 0));
    const __m512i largest = _mm512_set1_epi32(std::numeric_limits<std::int32_t>::max());
    const __m512i a = _mm512_mask_loadu_epi32(largest, first, ids);
    const __m512i b = _mm512_mask_loadu_epi32(largest, second, ids + 16);
    for (int i = 0; i < count; ++i) {
        const __m512i id = _mm512_set1_epi32(ids[i]);
        const unsigned smaller =
            _mm512_cmplt_epi32_mask(a, id) | static_cast<unsigned>(_mm512_cmplt_epi32_mask(b, id)) << 16;
        places[i] = static_cast<std::uint16_t>(std::popcount(smaller));
    }
}

constexpr StarKernels kernels_avx2{"avx2", near_boxes_avx2, inside_ball_avx2, to_window_avx2, select_avx2, first_hits_avx2, touching_avx2, rank_avx2};
constexpr StarKernels kernels_avx512{"avx512",      near_boxes_avx512, inside_ball_avx512, to_window_avx512,
                                     select_avx512, first_hits_avx512, touching_avx512, rank_avx512};
#endif

constexpr StarKernels kernels_baseline{"baseline",     near_boxes_body, inside_ball_body, to_window_body,
                                       select_body<4>, first_hits_body<4>, touching_body<4>, rank_body};

}  // namespace

const StarKernels& star_kernels(std::string_view name) {
#if defined(__x86_64__)
    if (name == kernels_avx512.name) return kernels_avx512;
    if (name == kernels_avx2.name) return kernels_avx2;
#endif
    return kernels_baseline;
}

}  // namespace votess::cpu
