#include "cpu/kernels.hpp"

#include <cstring>

namespace votess::cpu {
namespace {

using Real8 = double __attribute__((vector_size(64)));
using Mask8 = std::int64_t __attribute__((vector_size(64)));

#define VOTESS_INLINE inline __attribute__((always_inline))

VOTESS_INLINE void load(Real8& r, const double* p) {
    std::memcpy(&r, p, sizeof r);
}
VOTESS_INLINE std::uint64_t combine(const Mask8& m) {
    return static_cast<std::uint64_t>(((m[0] | m[1]) | (m[2] | m[3])) | ((m[4] | m[5]) | (m[6] | m[7])));
}
VOTESS_INLINE void maximum(Real8& a, const Real8& b) {
    a = a > b ? a : b;
}

VOTESS_INLINE SideMasks classify_body(const VertexBlock& v, const FilterPlane& plane) {
    Mask8 possible{}, certain{};
    Mask8 bit{1, 2, 4, 8, 16, 32, 64, 128};
    for (int b = 0; b < v.blocks; ++b, bit <<= lanes) {
        Real8 x, y, z, tolerance;
        load(x, v.x + lanes * b);
        load(y, v.y + lanes * b);
        load(z, v.z + lanes * b);
        load(tolerance, v.tolerance + lanes * b);
        const Real8 excess = plane.nx * x + plane.ny * y + plane.nz * z - plane.h;
        const Real8 bound = plane.norm * tolerance + plane.h_error;
        possible |= (excess >= -bound) & bit;
        certain |= (excess > bound) & bit;
    }
    return {combine(possible), combine(certain)};
}

VOTESS_INLINE bool box_in_reach_body(const VertexBlock& v, const BoundingBox& box, double slack) {
    Mask8 any{};
    const Real8 zero{};
    for (int b = 0; b < v.blocks; ++b) {
        Real8 x, y, z, radius;
        load(x, v.x + lanes * b);
        load(y, v.y + lanes * b);
        load(z, v.z + lanes * b);
        load(radius, v.radius_squared + lanes * b);
        Real8 dx = box.lower[0] - x, dy = box.lower[1] - y, dz = box.lower[2] - z;
        maximum(dx, x - box.upper[0]);
        maximum(dy, y - box.upper[1]);
        maximum(dz, z - box.upper[2]);
        maximum(dx, zero);
        maximum(dy, zero);
        maximum(dz, zero);
        any |= (dx * dx + dy * dy + dz * dz) < radius * slack;
    }
    return combine(any) != 0;
}

VOTESS_INLINE double largest_radius_body(const VertexBlock& v) {
    Real8 r{};
    for (int b = 0; b < v.blocks; ++b) {
        Real8 radius;
        load(radius, v.radius_squared + lanes * b);
        maximum(r, radius);
    }
    double m = r[0];
    for (int i = 1; i < lanes; ++i) m = r[i] > m ? r[i] : m;
    return m;
}

VOTESS_INLINE void squared_distances_body(const double* x, const double* y, const double* z, int count, const double* p,
                                          double* out) {
    const double px = p[0], py = p[1], pz = p[2];
    for (int i = 0; i < count; ++i) {
        const double dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
        out[i] = dx * dx + dy * dy + dz * dz;
    }
}

// One set of functions per instruction set; the bodies above are inlined into each.
#define VOTESS_KERNELS(NAME, TARGET)                                                                     \
    TARGET SideMasks classify_##NAME(const VertexBlock& v, const FilterPlane& p) {                       \
        return classify_body(v, p);                                                                      \
    }                                                                                                    \
    TARGET bool box_in_reach_##NAME(const VertexBlock& v, const BoundingBox& box, double slack) {        \
        return box_in_reach_body(v, box, slack);                                                         \
    }                                                                                                    \
    TARGET double largest_radius_##NAME(const VertexBlock& v) {                                          \
        return largest_radius_body(v);                                                                   \
    }                                                                                                    \
    TARGET void squared_distances_##NAME(const double* x, const double* y, const double* z, int count,   \
                                         const double* p, double* out) {                                 \
        squared_distances_body(x, y, z, count, p, out);                                                  \
    }                                                                                                    \
    constexpr Kernels kernels_##NAME{#NAME, classify_##NAME, box_in_reach_##NAME, largest_radius_##NAME, \
                                     squared_distances_##NAME};

VOTESS_KERNELS(baseline, )
#if defined(__x86_64__)
VOTESS_KERNELS(avx2, __attribute__((target("avx2"))))
VOTESS_KERNELS(avx512, __attribute__((target("avx512f,avx512dq,avx512vl,prefer-vector-width=512"))))
#endif

}  // namespace

std::vector<const Kernels*> supported_kernels() {
    std::vector<const Kernels*> supported;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        supported.push_back(&kernels_avx512);
    if (__builtin_cpu_supports("avx2")) supported.push_back(&kernels_avx2);
#endif
    supported.push_back(&kernels_baseline);
    return supported;
}

const Kernels& best_kernels() {
    return *supported_kernels().front();
}

}  // namespace votess::cpu
