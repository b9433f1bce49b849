// The loops of StarKernels in AVX-512. One file includes this.
#pragma once

#include <bit>
#include <limits>

#include "cpu/target.hpp"
#include "cpu/walk/kernels/star_kernels_plain.hpp"

// GCC 12 takes the undefined operands that its own header passes to masked instructions for mistakes (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#pragma GCC diagnostic pop

#define VOTESS_AVX512 VOTESS_TARGET_512("avx512f,avx512dq,avx512vl,avx512bw,fma,popcnt,bmi")

namespace votess::cpu {
namespace {

VOTESS_AVX512 unsigned near_boxes_avx512(const BoxBlock& b, const Box& home, double distance_squared) {
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
    const __m512d along =
        _mm512_fmadd_pd(nx, _mm512_set1_pd(t.v[0]),
                        _mm512_fmadd_pd(ny, _mm512_set1_pd(t.v[1]), _mm512_mul_pd(nz, _mm512_set1_pd(t.v[2]))));
    const __m512d excess =
        _mm512_fmadd_pd(square, _mm512_set1_pd(relative_slack - 0.5), _mm512_add_pd(along, _mm512_set1_pd(t.slack)));
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

// All are near: vectors are so long that it does not pay to look at fewer.
template <bool Weighted>
VOTESS_AVX512 bool select_seeds(const WindowSeeds& w, const std::int32_t* p, [[maybe_unused]] float weight,
                                float distance_squared, CandidatePlanes& c) {
    const __m512i px = _mm512_set1_epi32(p[0]), py = _mm512_set1_epi32(p[1]), pz = _mm512_set1_epi32(p[2]);
    const __m512 limit = _mm512_set1_ps(distance_squared), half = _mm512_set1_ps(0.5f);
    int count = c.count;
    for (int i = 0; i < w.count; i += 16) {
        const __m512 nx = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_loadu_si512(w.x + i), px));
        const __m512 ny = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_loadu_si512(w.y + i), py));
        const __m512 nz = _mm512_cvtepi32_ps(_mm512_sub_epi32(_mm512_loadu_si512(w.z + i), pz));
        const __m512 d = _mm512_fmadd_ps(nx, nx, _mm512_fmadd_ps(ny, ny, _mm512_mul_ps(nz, nz)));
        const __mmask16 inside = _mm512_cmp_ps_mask(d, limit, _CMP_LT_OQ);
        __m512 h = d;
        if constexpr (Weighted)
            h = _mm512_add_ps(d, _mm512_sub_ps(_mm512_set1_ps(weight), _mm512_loadu_ps(w.weight + i)));
        if (count > CandidatePlanes::capacity) return false;
        _mm512_storeu_ps(c.nx + count, _mm512_maskz_compress_ps(inside, nx));
        _mm512_storeu_ps(c.ny + count, _mm512_maskz_compress_ps(inside, ny));
        _mm512_storeu_ps(c.nz + count, _mm512_maskz_compress_ps(inside, nz));
        _mm512_storeu_ps(c.h + count, _mm512_maskz_compress_ps(inside, _mm512_mul_ps(h, half)));
        _mm512_storeu_si512(c.id + count, _mm512_maskz_compress_epi32(inside, _mm512_loadu_si512(w.id + i)));
        count += std::popcount(static_cast<unsigned>(inside));
    }
    return join(c, count, 0);
}

VOTESS_AVX512 bool select_avx512(const WindowSeeds& w, const std::int32_t* p, float weight, float,
                                 float distance_squared, CandidatePlanes& c) {
    return w.weight == nullptr ? select_seeds<false>(w, p, weight, distance_squared, c)
                               : select_seeds<true>(w, p, weight, distance_squared, c);
}

// The best planes of one ray so far: t in the high bits, as integers of the same order, over the index.
struct Best {
    __m512 ox, oy, oz, dx, dy, dz, s, limit;
    __m512i key;
};
constexpr int index_bits = 0x1ff;  // of CandidatePlanes::capacity

VOTESS_AVX512 VOTESS_INLINE Best start(const Ray& ray) {
    return {_mm512_set1_ps(ray.o[0]), _mm512_set1_ps(ray.o[1]),  _mm512_set1_ps(ray.o[2]),
            _mm512_set1_ps(ray.d[0]), _mm512_set1_ps(ray.d[1]),  _mm512_set1_ps(ray.d[2]),
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

VOTESS_AVX512 void first_hits_avx512(const CandidatePlanes& c, int count, const Ray* rays, int* hits) {
    Best first = start(rays[0]), second = start(rays[1]);
    __m512i index = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (int i = 0; i < count; i += 16) {
        const __m512 nx = _mm512_load_ps(c.nx + i), ny = _mm512_load_ps(c.ny + i), nz = _mm512_load_ps(c.nz + i);
        const __m512 h = _mm512_load_ps(c.h + i);
        update(first, nx, ny, nz, h, index);
        update(second, nx, ny, nz, h, index);
        index = _mm512_add_epi32(index, _mm512_set1_epi32(16));
    }
    hits[0] = hit_of(first);
    hits[1] = hit_of(second);
}

VOTESS_AVX512 int touching_avx512(const CandidatePlanes& c, int count, const float* v, const std::int32_t* three,
                                  int begin) {
    const __m512 vx = _mm512_set1_ps(v[0]), vy = _mm512_set1_ps(v[1]), vz = _mm512_set1_ps(v[2]);
    const __m512 limit = _mm512_set1_ps(v[3]);
    const __m512i i0 = _mm512_set1_epi32(three[0]), i1 = _mm512_set1_epi32(three[1]), i2 = _mm512_set1_epi32(three[2]);
    auto behind = static_cast<__mmask16>(~0u << (begin % 16));
    for (int i = begin / 16 * 16; i < count; i += 16, behind = 0xffff) {
        const __m512 gap =
            _mm512_fnmadd_ps(_mm512_load_ps(c.nx + i), vx,
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

VOTESS_AVX512 void rank_avx512(const std::int32_t* ids, int count, std::uint16_t* places) {
    if (count > 32) return rank_body(ids, count, places);
    const auto first = static_cast<__mmask16>(count >= 16 ? 0xffff : (1 << count) - 1);
    const auto second = static_cast<__mmask16>(count >= 32 ? 0xffff : (count > 16 ? (1 << (count - 16)) - 1 : 0));
    const __m512i largest = _mm512_set1_epi32(std::numeric_limits<std::int32_t>::max());
    const __m512i a = _mm512_mask_loadu_epi32(largest, first, ids);
    const __m512i b = _mm512_mask_loadu_epi32(largest, second, ids + 16);
    for (int i = 0; i < count; ++i) {
        const __m512i id = _mm512_set1_epi32(ids[i]);
        const unsigned smaller = _mm512_cmplt_epi32_mask(a, id) | static_cast<unsigned>(_mm512_cmplt_epi32_mask(b, id))
                                                                      << 16;
        places[i] = static_cast<std::uint16_t>(std::popcount(smaller));
    }
}

constexpr StarKernels kernels_avx512{"avx512",      near_boxes_avx512, inside_ball_avx512, to_window_avx512,
                                     select_avx512, first_hits_avx512, touching_avx512,    rank_avx512};

}  // namespace
}  // namespace votess::cpu
