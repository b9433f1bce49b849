// The loops of StarKernels in AVX2. One file includes this.
#pragma once

#include <immintrin.h>

#include <array>
#include <bit>
#include <limits>

#include "kernels/star_kernels_plain.hpp"

#define VOTESS_AVX2 __attribute__((target("avx2,fma,popcnt,bmi")))

namespace votess::cpu {
namespace {

// Order of lanes for compress(), by mask, one byte for each lane: lanes whose bit is set come first.
constexpr std::array<std::uint64_t, 256> compress_orders = [] {
    std::array<std::uint64_t, 256> orders{};
    for (unsigned mask = 0; mask < 256; ++mask) {
        int at = 0;
        for (unsigned lane = 0; lane < 8; ++lane)
            if ((mask >> lane) & 1) orders[mask] |= std::uint64_t{lane} << (8 * at++);
    }
    return orders;
}();

VOTESS_AVX2 VOTESS_INLINE __m256i compress_order(unsigned mask) {
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(&compress_orders[mask])));
}

VOTESS_AVX2 VOTESS_INLINE void compress(std::int32_t* to, __m256i values, __m256i order) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32(values, order));
}

VOTESS_AVX2 VOTESS_INLINE void compress(float* to, __m256 values, __m256i order) {
    _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(values, order));
}

// Integers out of range become the smallest one.
VOTESS_AVX2 VOTESS_INLINE __m256i clamp(__m256i x) {
    return _mm256_min_epi32(_mm256_max_epi32(x, _mm256_set1_epi32(-window_range)), _mm256_set1_epi32(window_range));
}

VOTESS_AVX2 VOTESS_INLINE __m256 square_of(__m256 x, __m256 y, __m256 z) {
    return _mm256_fmadd_ps(x, x, _mm256_fmadd_ps(y, y, _mm256_mul_ps(z, z)));
}

// With weights: how far from the seed planes count as, in squares times those of their lengths.
struct PlanesMeasured {
    __m256 measured, square;
};
template <class Limits>
VOTESS_AVX2 VOTESS_INLINE PlanesMeasured measure_planes(__m256 nx, __m256 ny, __m256 nz, __m256 d, __m256 h,
                                                        const Limits& limits) {
    const __m256 less = _mm256_sub_ps(h, _mm256_set1_ps(2 * limits.slack));
    PlanesMeasured m{_mm256_mul_ps(less, _mm256_andnot_ps(_mm256_set1_ps(-0.0f), less)), d};
    if constexpr (std::is_same_v<Limits, BentLimits>) {
        const auto along = [&](__m256 n, int own, __m256 other, int both) VOTESS_AVX2 {
            return _mm256_mul_ps(n, _mm256_fmadd_ps(_mm256_set1_ps(limits.metric[own]), n,
                                                    _mm256_mul_ps(_mm256_set1_ps(limits.metric[both]), other)));
        };
        m.square = _mm256_add_ps(along(nx, 0, ny, 5), _mm256_add_ps(along(ny, 1, nz, 3), along(nz, 2, nx, 4)));
    }
    return m;
}

// In two passes without branches, which would be mispredicted: the seeds within the limit, then near ones and others.
// Storing takes most of the time of the first, so the second computes the squares again.
template <bool Weighted, class Limits>
VOTESS_AVX2 bool select_seeds(const WindowSeeds& w, const std::int32_t* p, [[maybe_unused]] float weight,
                              const Limits& limits, CandidatePlanes& c) {
    constexpr int most = 2 * CandidatePlanes::capacity;
    struct alignas(64) Found {
        float nx[most + 16], ny[most + 16], nz[most + 16];
        std::int32_t id[most + 16];
        float h[Weighted ? most + 16 : 8];  // twice h, with weights
    } f;
    const __m256i px = _mm256_set1_epi32(p[0]), py = _mm256_set1_epi32(p[1]), pz = _mm256_set1_epi32(p[2]);
    const __m256 limit = _mm256_set1_ps(limits.distance_squared), near_limit = _mm256_set1_ps(limits.near_squared);
    int found = 0;
    for (int i = 0; i < w.count; i += 8) {
        auto difference = [i](const std::int32_t* at, __m256i from) VOTESS_AVX2 {
            return _mm256_cvtepi32_ps(
                _mm256_sub_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(at + i)), from));
        };
        const __m256 nx = difference(w.x, px), ny = difference(w.y, py), nz = difference(w.z, pz);
        const __m256 d = square_of(nx, ny, nz);
        __m256 h = d, measured = d, bound = limit;
        if constexpr (Weighted) {
            __m256 more = _mm256_sub_ps(_mm256_set1_ps(weight), _mm256_loadu_ps(w.weight + i));
            if constexpr (std::is_same_v<Limits, BentLimits>) {
                more = _mm256_fmadd_ps(nx, _mm256_set1_ps(limits.turn[0]), more);
                more = _mm256_fmadd_ps(ny, _mm256_set1_ps(limits.turn[1]), more);
                more = _mm256_fmadd_ps(nz, _mm256_set1_ps(limits.turn[2]), more);
            }
            h = _mm256_add_ps(d, more);
            const PlanesMeasured m = measure_planes(nx, ny, nz, d, h, limits);
            measured = m.measured;
            bound = _mm256_mul_ps(limit, m.square);
        }
        const auto inside = static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(measured, bound, _CMP_LT_OQ)));
        const __m256i order = compress_order(inside);
        compress(f.nx + found, nx, order);
        compress(f.ny + found, ny, order);
        compress(f.nz + found, nz, order);
        if constexpr (Weighted) compress(f.h + found, h, order);
        compress(f.id + found, _mm256_loadu_si256(reinterpret_cast<const __m256i*>(w.id + i)), order);
        found += std::popcount(inside);
        if (found > most) return false;
    }
    const __m256i iota = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    int near = c.count, far = 0;
    [[maybe_unused]] __m256 longest = _mm256_setzero_ps();
    for (int i = 0; i < found; i += 8) {
        const __m256 there_lanes = _mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_set1_epi32(found - i), iota));
        const auto there = static_cast<unsigned>(_mm256_movemask_ps(there_lanes));
        const __m256 nx = _mm256_load_ps(f.nx + i), ny = _mm256_load_ps(f.ny + i), nz = _mm256_load_ps(f.nz + i);
        const __m256 d = square_of(nx, ny, nz);
        __m256 twice = d, beyond = _mm256_sub_ps(d, near_limit);
        if constexpr (Weighted) {
            twice = _mm256_load_ps(f.h + i);
            const PlanesMeasured m = measure_planes(nx, ny, nz, d, twice, limits);
            beyond = _mm256_fnmadd_ps(near_limit, m.square, m.measured);
            longest = _mm256_max_ps(longest, _mm256_and_ps(d, there_lanes));
        }
        const __m256 h = _mm256_mul_ps(twice, _mm256_set1_ps(0.5f));
        const unsigned is_near =
            there & static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(beyond, _mm256_setzero_ps(), _CMP_LT_OQ)));
        const unsigned is_far = there & ~is_near;
        if (near > CandidatePlanes::capacity || far > CandidatePlanes::capacity) return false;
        const auto put = [&](unsigned mask, int to) VOTESS_AVX2 {
            const __m256i order = compress_order(mask);
            compress(c.nx + to, nx, order);
            compress(c.ny + to, ny, order);
            compress(c.nz + to, nz, order);
            compress(c.h + to, h, order);
            compress(c.id + to, _mm256_load_si256(reinterpret_cast<const __m256i*>(f.id + i)), order);
        };
        put(is_near, near);
        put(is_far, far_begin + far);
        near += std::popcount(is_near);
        far += std::popcount(is_far);
    }
    if constexpr (Weighted) {
        const __m128 four = _mm_max_ps(_mm256_castps256_ps128(longest), _mm256_extractf128_ps(longest, 1));
        const __m128 two = _mm_max_ps(four, _mm_movehl_ps(four, four));
        c.longest_squared = _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)));
    }
    return join(c, near, far);
}

// Returns the index in the last bits of the smallest of eight floats, or -1 if they are at least `none`.
VOTESS_AVX2 VOTESS_INLINE int hit_of(__m256 best, float none) {
    const __m128 four = _mm_min_ps(_mm256_castps256_ps128(best), _mm256_extractf128_ps(best, 1));
    const __m128 two = _mm_min_ps(four, _mm_movehl_ps(four, four));
    const __m128 least = _mm_min_ss(two, _mm_movehdup_ps(two));
    return _mm_cvtss_f32(least) < none ? _mm_cvtsi128_si32(_mm_castps_si128(least)) & CandidatePlanes::index_bits : -1;
}

template <int Blocks>
VOTESS_AVX2 VOTESS_INLINE void rank_blocks(const std::int32_t* ids, int count, std::uint32_t* places) {
    const __m256i iota = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i of[Blocks], smaller[Blocks];
    for (int b = 0; b < Blocks; ++b) {
        const __m256i there = _mm256_cmpgt_epi32(_mm256_set1_epi32(count - 8 * b), iota);
        of[b] = _mm256_maskload_epi32(ids + 8 * b, there);
        smaller[b] = _mm256_setzero_si256();
    }
    for (int i = 0; i < count; ++i) {
        const __m256i id = _mm256_set1_epi32(ids[i]);
        for (int b = 0; b < Blocks; ++b) smaller[b] = _mm256_sub_epi32(smaller[b], _mm256_cmpgt_epi32(of[b], id));
    }
    for (int b = 0; b < Blocks; ++b) _mm256_storeu_si256(reinterpret_cast<__m256i*>(places + 8 * b), smaller[b]);
}

// Writes the keys of up to 32 corners, see Avx2::order_corners().
VOTESS_AVX2 VOTESS_INLINE void corner_keys(const CellShape& shape, int begin, std::uint16_t* keys) {
    const __m256i table = _mm256_load_si256(reinterpret_cast<const __m256i*>(shape.rank.data()));
    const __m256i low = _mm256_permute2x128_si256(table, table, 0x00),
                  high = _mm256_permute2x128_si256(table, table, 0x11);
    const auto ranks = [&](const std::uint8_t* slots) VOTESS_AVX2 {
        const __m256i slot = _mm256_load_si256(reinterpret_cast<const __m256i*>(slots + begin));
        return _mm256_blendv_epi8(_mm256_shuffle_epi8(low, slot), _mm256_shuffle_epi8(high, slot),
                                  _mm256_slli_epi16(slot, 3));
    };
    const __m256i p = ranks(shape.a.data()), q = ranks(shape.b.data()), r = ranks(shape.c.data());
    const __m256i lower = _mm256_min_epu8(p, q), upper = _mm256_max_epu8(p, q);
    const __m256i least = _mm256_min_epu8(lower, r), rest = _mm256_max_epu8(lower, r);
    const __m256i other = _mm256_min_epu8(upper, rest), greatest = _mm256_max_epu8(upper, rest);
    for (int half = 0; half < 2; ++half) {
        const auto wide = [half](__m256i v) VOTESS_AVX2 {
            return _mm256_cvtepu8_epi16(half == 0 ? _mm256_castsi256_si128(v) : _mm256_extracti128_si256(v, 1));
        };
        const __m256i key = _mm256_or_si256(_mm256_slli_epi16(wide(least), 10),
                                            _mm256_or_si256(_mm256_slli_epi16(wide(other), 5), wide(greatest)));
        _mm256_store_si256(reinterpret_cast<__m256i*>(keys + begin + 16 * half), key);
    }
}

// Sorts keys in blocks of 16. All are different, except fillers behind the last key up to a multiple of four, which are
// larger than all others.
template <int Blocks>
VOTESS_AVX2 VOTESS_INLINE void sort_keys(const std::uint16_t* keys, int count, std::uint16_t* sorted) {
    __m256i of[Blocks], smaller[Blocks];
    for (int b = 0; b < Blocks; ++b) {
        of[b] = _mm256_load_si256(reinterpret_cast<const __m256i*>(keys + 16 * b));
        smaller[b] = _mm256_setzero_si256();
    }
    for (int i = 0; i < count; i += 4)
        for (int k = 0; k < 4; ++k) {
            const __m256i key = _mm256_set1_epi16(static_cast<short>(keys[i + k]));
            for (int b = 0; b < Blocks; ++b) smaller[b] = _mm256_sub_epi16(smaller[b], _mm256_cmpgt_epi16(of[b], key));
        }
    alignas(32) std::uint16_t places[16 * Blocks];
    for (int b = 0; b < Blocks; ++b) _mm256_store_si256(reinterpret_cast<__m256i*>(places + 16 * b), smaller[b]);
    for (int i = 0; i < count; i += 4)
        for (int k = 0; k < 4; ++k) sorted[places[i + k]] = keys[i + k];
}

}  // namespace

struct Avx2 {
    static constexpr const char* name = "avx2";

    using Lanes = Double4;
    VOTESS_AVX2 VOTESS_INLINE static void multiply_add(const Lanes& a, const Lanes& b, const Lanes& c, Lanes& out) {
        out = _mm256_fmadd_pd(a, b, c);
    }
    // True for NaN too.
    VOTESS_AVX2 VOTESS_INLINE static bool any_above(const Lanes& a, double limit) {
        return _mm256_movemask_pd(_mm256_cmp_pd(a, _mm256_set1_pd(limit), _CMP_NLE_UQ)) != 0;
    }
    VOTESS_AVX2 VOTESS_INLINE static void multiply_subtract(const Lanes& a, const Lanes& b, const Lanes& c,
                                                            Lanes& out) {
        out = _mm256_fmsub_pd(a, b, c);
    }

    VOTESS_AVX2 VOTESS_INLINE static unsigned bits(const Long4& m) {
        return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<const __m256d&>(m)));
    }

    template <bool Place, bool Nearest>
    [[gnu::noinline]] VOTESS_AVX2 static unsigned heavier_bits(const BoxBlock& b, const WeightBlock& w, const Box& home,
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
    [[gnu::noinline]] VOTESS_AVX2 static unsigned heavy_bits(const BoxBlock& b, const WeightBlock& w, const Box& home,
                                                             const HeavierTest& test, const Double4 (&most)[2]) {
        Long4 near[2];
        heavy_boxes(b, w, home, test, most, near);
        return bits(near[0]) | bits(near[1]) << 4;
    }
    VOTESS_AVX2 static unsigned near_heavier(const BoxBlock& b, const WeightBlock& w, const Box& home,
                                             const HeavierTest& test) {
        if (test.nearest > 0) return heavier_bits<false, true>(b, w, home, test);
        return home.lower == home.upper ? heavier_bits<true, false>(b, w, home, test)
                                        : heavier_bits<false, false>(b, w, home, test);
    }

    VOTESS_AVX2 static unsigned near_bent(const BoxBlock& b, const WeightBlock& w, const WeightTilt& t,
                                          const WeightBend& bend, double length) {
        Long4 near[2];
        near_bent_boxes(b, w, t, bend, length, near);
        return bits(near[0]) | bits(near[1]) << 4;
    }

    VOTESS_AVX2 VOTESS_INLINE static unsigned near_boxes(const BoxBlock& b, const Box& home, double distance_squared) {
        unsigned mask = 0;
        const __m256d limit = _mm256_set1_pd(distance_squared);
        for (int i = 0; i < box_fan; i += 4) {
            __m256d sum = _mm256_setzero_pd();
            for (int k = 0; k < 3; ++k) {
                __m256d gap =
                    _mm256_max_pd(_mm256_sub_pd(_mm256_load_pd(b.lower[k] + i), _mm256_set1_pd(home.upper[k])),
                                  _mm256_sub_pd(_mm256_set1_pd(home.lower[k]), _mm256_load_pd(b.upper[k] + i)));
                gap = _mm256_max_pd(gap, _mm256_setzero_pd());
                sum = _mm256_fmadd_pd(gap, gap, sum);
            }
            mask |= static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(sum, limit, _CMP_LT_OQ))) << i;
        }
        return mask;
    }

    VOTESS_AVX2 VOTESS_INLINE static int list_bits(unsigned mask, std::uint32_t first, std::uint32_t* out) {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                            _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(first)), compress_order(mask)));
        return std::popcount(mask);
    }

    VOTESS_AVX2 VOTESS_INLINE static unsigned inside_ball(const double* x, const double* y, const double* z,
                                                          const GroupTest& t, double least) {
        const __m256d scale = _mm256_set1_pd(t.scale);
        unsigned mask = 0;
        for (int i = 0; i < box_fan; i += 4) {
            const auto difference = [&](const double* from, int k) VOTESS_AVX2 {
                return _mm256_mul_pd(_mm256_sub_pd(_mm256_loadu_pd(from + i), _mm256_set1_pd(t.p[k])), scale);
            };
            const __m256d nx = difference(x, 0), ny = difference(y, 1), nz = difference(z, 2);
            const __m256d square = _mm256_fmadd_pd(nx, nx, _mm256_fmadd_pd(ny, ny, _mm256_mul_pd(nz, nz)));
            const __m256d along =
                _mm256_fmadd_pd(nx, _mm256_set1_pd(t.v[0]),
                                _mm256_fmadd_pd(ny, _mm256_set1_pd(t.v[1]), _mm256_mul_pd(nz, _mm256_set1_pd(t.v[2]))));
            const __m256d excess = _mm256_fmadd_pd(square, _mm256_set1_pd(relative_slack - 0.5),
                                                   _mm256_add_pd(along, _mm256_set1_pd(t.slack)));
            // NaN if the seed is padding, infinitely far away.
            const __m256d inside = _mm256_and_pd(_mm256_cmp_pd(excess, _mm256_setzero_pd(), _CMP_GE_OQ),
                                                 _mm256_cmp_pd(square, _mm256_set1_pd(least), _CMP_GE_OQ));
            mask |= static_cast<unsigned>(_mm256_movemask_pd(inside)) << i;
        }
        return mask;
    }

    VOTESS_AVX2 static int to_window(const GroupSource& from, const WindowFrame& frame, std::int32_t* const* out,
                                     std::int32_t* ids, float* residual) {
        return frame.tilt == nullptr ? write_window<false>(from, frame, out, ids, residual)
                                     : write_window<true>(from, frame, out, ids, residual);
    }
    VOTESS_AVX2 static int to_bent_window(const GroupSource& from, const BentFrame& frame, std::int32_t* const* out,
                                          std::int32_t* ids, float* residual) {
        return write_window<true>(from, frame, out, ids, residual);
    }
    template <bool Weighted, class Frame>
    VOTESS_AVX2 static int write_window(const GroupSource& from, const Frame& frame, std::int32_t* const* out,
                                        std::int32_t* ids, [[maybe_unused]] float* residual) {
        const __m256d scale = _mm256_set1_pd(frame.scale), limit = _mm256_set1_pd(frame.distance_squared);
        const __m256i iota = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        const HeavierTest test(Weighted ? *frame.tilt : WeightTilt{}, frame.length, 0, 0);
        int count = 0;
        for (std::size_t g = 0; g < from.groups.size(); ++g) {
            const std::size_t seed = std::size_t{from.groups[g]} * box_fan;
            __m128i at[2][3];
            __m128 rest[2];
            unsigned inside = 0;
            for (int half = 0; half < 2; ++half) {
                __m256d sum = _mm256_setzero_pd();
                Lanes x[3];
                for (int k = 0; k < 3; ++k) {
                    x[k] = _mm256_loadu_pd(from.seeds[k] + seed + 4 * half);
                    __m256d gap = _mm256_max_pd(_mm256_sub_pd(_mm256_set1_pd(frame.home.lower[k]), x[k]),
                                                _mm256_sub_pd(x[k], _mm256_set1_pd(frame.home.upper[k])));
                    gap = _mm256_max_pd(gap, _mm256_setzero_pd());
                    sum = _mm256_fmadd_pd(gap, gap, sum);
                    at[half][k] =
                        _mm256_cvtpd_epi32(_mm256_mul_pd(_mm256_sub_pd(x[k], _mm256_set1_pd(frame.origin[k])), scale));
                }
                if constexpr (Weighted) {
                    const Lanes weight = _mm256_loadu_pd(from.weights + seed + 4 * half);
                    Lanes r;
                    residuals(x, weight, *frame.tilt, r);
                    Long4 within;
                    if constexpr (std::is_same_v<Frame, BentFrame>)
                        near_bent_seeds(x, weight, frame, within);
                    else
                        heavier_seeds(Lanes(sum), r, *frame.tilt, test, within);
                    inside |= bits(within) << (4 * half);
                    rest[half] = _mm256_cvtpd_ps(r * (frame.scale * frame.scale));
                } else {
                    inside |= static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(sum, limit, _CMP_LT_OQ)))
                              << (4 * half);
                }
            }
            if (g < from.kept) inside = 255;
            const __m256i order = compress_order(inside);
            for (int k = 0; k < 3; ++k) compress(out[k] + count, clamp(_mm256_set_m128i(at[1][k], at[0][k])), order);
            if constexpr (Weighted) compress(residual + count, _mm256_set_m128(rest[1], rest[0]), order);
            compress(ids + count, _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(seed)), iota), order);
            count += std::popcount(inside);
        }
        return count;
    }

    VOTESS_AVX2 static bool select(const WindowSeeds& w, const std::int32_t* p, float weight,
                                   const SelectLimits& limits, CandidatePlanes& c) {
        return w.weight == nullptr ? select_seeds<false>(w, p, weight, limits, c)
                                   : select_seeds<true>(w, p, weight, limits, c);
    }
    VOTESS_AVX2 static bool select_bent(const WindowSeeds& w, const std::int32_t* p, float weight,
                                        const BentLimits& limits, CandidatePlanes& c) {
        return select_seeds<true>(w, p, weight, limits, c);
    }

    // The index of a plane takes the place of the last bits of t. The reciprocals of _mm256_rcp_ps() would take 1 %
    // less time of a cell, but they depend on the processor, and so would the last digits of vertices of ties.
    VOTESS_AVX2 VOTESS_INLINE static void first_hits(const CandidatePlanes& c, int count, const Ray* rays, int number,
                                                     int* hits) {
        constexpr float none = 0x1p127f;
        const __m256 no_hit = _mm256_set1_ps(none);
        const __m256i upper = _mm256_set1_epi32(~CandidatePlanes::index_bits);
        for (int r = 0; r < number; ++r) {
            const auto& [o, d, least] = rays[r];
            const __m256 ox = _mm256_set1_ps(o[0]), oy = _mm256_set1_ps(o[1]), oz = _mm256_set1_ps(o[2]);
            const __m256 dx = _mm256_set1_ps(d[0]), dy = _mm256_set1_ps(d[1]), dz = _mm256_set1_ps(d[2]);
            const __m256 limit = _mm256_set1_ps(least);
            __m256 best = no_hit;
            __m256i index = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            const auto hit = [&](int i) VOTESS_AVX2 {
                const __m256 nx = _mm256_load_ps(c.nx + i), ny = _mm256_load_ps(c.ny + i),
                             nz = _mm256_load_ps(c.nz + i);
                const __m256 leaving = _mm256_fmadd_ps(nx, dx, _mm256_fmadd_ps(ny, dy, _mm256_mul_ps(nz, dz)));
                const __m256 gap = _mm256_fnmadd_ps(
                    nx, ox, _mm256_fnmadd_ps(ny, oy, _mm256_fnmadd_ps(nz, oz, _mm256_load_ps(c.h + i))));
                const __m256 t =
                    _mm256_blendv_ps(no_hit, _mm256_div_ps(gap, leaving), _mm256_cmp_ps(leaving, limit, _CMP_GT_OQ));
                const __m256i named = _mm256_or_si256(_mm256_and_si256(_mm256_castps_si256(t), upper), index);
                best = _mm256_min_ps(_mm256_castsi256_ps(named), best);  // not NaN
                index = _mm256_add_epi32(index, _mm256_set1_epi32(8));
            };
            for (int i = 0; i < count; i += 16) {  // its end is predicted more often than that of eights
                hit(i);
                hit(i + 8);
            }
            hits[r] = hit_of(best, none);
        }
    }

    VOTESS_AVX2 VOTESS_INLINE static int touching(const CandidatePlanes& c, int count, const float* v,
                                                  const std::int32_t* three, int begin) {
        const __m256 vx = _mm256_set1_ps(v[0]), vy = _mm256_set1_ps(v[1]), vz = _mm256_set1_ps(v[2]);
        const __m256 limit = _mm256_set1_ps(v[3]);
        const __m256i i0 = _mm256_set1_epi32(three[0]), i1 = _mm256_set1_epi32(three[1]),
                      i2 = _mm256_set1_epi32(three[2]);
        unsigned behind = ~0u << (begin % 16);
        for (int i = begin / 16 * 16; i < count; i += 16, behind = ~0u) {
            const auto near = [&](int k) VOTESS_AVX2 {
                const __m256 gap = _mm256_fnmadd_ps(
                    _mm256_load_ps(c.nx + k), vx,
                    _mm256_fnmadd_ps(_mm256_load_ps(c.ny + k), vy,
                                     _mm256_fnmadd_ps(_mm256_load_ps(c.nz + k), vz, _mm256_load_ps(c.h + k))));
                const __m256i id = _mm256_load_si256(reinterpret_cast<const __m256i*>(c.id + k));
                const __m256i same =
                    _mm256_or_si256(_mm256_cmpeq_epi32(id, i0),
                                    _mm256_or_si256(_mm256_cmpeq_epi32(id, i1), _mm256_cmpeq_epi32(id, i2)));
                return static_cast<unsigned>(_mm256_movemask_ps(
                    _mm256_andnot_ps(_mm256_castsi256_ps(same), _mm256_cmp_ps(gap, limit, _CMP_LE_OQ))));
            };
            const unsigned mask = (near(i) | near(i + 8) << 8) & behind;
            if (mask != 0) return i + std::countr_zero(mask);
        }
        return -1;
    }

    VOTESS_AVX2 static void rank(const std::int32_t* ids, int count, std::uint32_t* places) {
        if (count <= 16) return rank_blocks<2>(ids, count, places);
        if (count <= 32) return rank_blocks<4>(ids, count, places);
        Baseline::rank(ids, count, places);
    }

    // Sorts by keys of 16 bits: three ranks of five bits, ascending.
    VOTESS_AVX2 static void order_corners(const CellShape& shape, CornerOrder& out) {
        constexpr int max_keys = 64;
        constexpr std::uint64_t fillers = 0x7fff7fff7fff7fff;
        if (shape.slots > 32 || shape.corners > max_keys) return Baseline::order_corners(shape, out);
        alignas(32) std::uint16_t keys[max_keys + 16], sorted[max_keys + 16];
        corner_keys(shape, 0, keys);
        if (shape.corners > 32) corner_keys(shape, 32, keys);
        std::memcpy(keys + shape.corners, &fillers, sizeof fillers);
        if (shape.corners <= 32)
            sort_keys<2>(keys, shape.corners, sorted);
        else if (shape.corners <= 48)
            sort_keys<3>(keys, shape.corners, sorted);
        else
            sort_keys<4>(keys, shape.corners, sorted);
        const __m256i mask = _mm256_set1_epi16(31 * CornerOrder::rank_step);
        for (int i = 0; i < shape.corners; i += 16) {
            const __m256i key = _mm256_load_si256(reinterpret_cast<const __m256i*>(sorted + i));
            const auto store = [&](std::uint16_t* to, __m256i ranks) VOTESS_AVX2 {
                _mm256_store_si256(reinterpret_cast<__m256i*>(to + i), _mm256_and_si256(ranks, mask));
            };
            store(out.rank[0].data(), _mm256_srli_epi16(key, 8));
            store(out.rank[1].data(), _mm256_srli_epi16(key, 3));
            store(out.rank[2].data(), _mm256_slli_epi16(key, 2));
        }
        Baseline::fill_corners(shape.corners, out);
    }
};

}  // namespace votess::cpu
