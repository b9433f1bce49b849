#include "polytope/cell_kernels.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

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

VOTESS_INLINE bool box_in_reach_body(const VertexBlock& v, const Box& box, double slack, double floor) {
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
        any |= (dx * dx + dy * dy + dz * dz) < radius * slack + floor;
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

VOTESS_INLINE int select_band_body(const double* distances, int count, double from, double to, std::uint64_t* keys) {
    int selected = 0;
    for (int i = 0; i < count; ++i) {  // without branches, which would be mispredicted half of the time
        const double d = distances[i];
        keys[selected] = (std::bit_cast<std::uint64_t>(d) & key_distance_bits) | static_cast<std::uint32_t>(i);
        selected += static_cast<int>(d >= from) & static_cast<int>(d < to);
    }
    return selected;
}

// One set of functions for each instruction set. The bodies above are inlined into each.
#define VOTESS_KERNELS(NAME, TARGET)                                                                                 \
    TARGET SideMasks classify_##NAME(const VertexBlock& v, const FilterPlane& p) {                                   \
        return classify_body(v, p);                                                                                  \
    }                                                                                                                \
    TARGET bool box_in_reach_##NAME(const VertexBlock& v, const Box& box, double slack, double floor) {              \
        return box_in_reach_body(v, box, slack, floor);                                                              \
    }                                                                                                                \
    TARGET double largest_radius_##NAME(const VertexBlock& v) {                                                      \
        return largest_radius_body(v);                                                                               \
    }                                                                                                                \
    TARGET void squared_distances_##NAME(const double* x, const double* y, const double* z, int count,               \
                                         const double* p, double* out) {                                             \
        squared_distances_body(x, y, z, count, p, out);                                                              \
    }                                                                                                                \
    TARGET int select_band_##NAME(const double* distances, int count, double from, double to, std::uint64_t* keys) { \
        return select_band_body(distances, count, from, to, keys);                                                   \
    }                                                                                                                \
    constexpr Kernels kernels_##NAME{#NAME,                                                                          \
                                     classify_##NAME,                                                                \
                                     box_in_reach_##NAME,                                                            \
                                     largest_radius_##NAME,                                                          \
                                     squared_distances_##NAME,                                                       \
                                     select_band_##NAME};

VOTESS_KERNELS(baseline, )
#if defined(__x86_64__)
#ifdef __clang__
#define VOTESS_TARGET_512(instructions) __attribute__((target(instructions), min_vector_width(512)))
#else  // GCC would otherwise split vectors of 512 bits
#define VOTESS_TARGET_512(instructions) __attribute__((target(instructions ",prefer-vector-width=512")))
#endif
VOTESS_KERNELS(avx2, __attribute__((target("avx2"))))
VOTESS_KERNELS(avx512, VOTESS_TARGET_512("avx512f,avx512dq,avx512vl"))
#endif

#if defined(__x86_64__)
struct Instructions {
    bool avx2 = false, avx512 = false;
};

// All instructions that any code of a set is compiled for. A virtual machine may hide some, and the system must save
// the registers. Not __builtin_cpu_supports(), which some run-time libraries answer with no.
Instructions find_instructions() {
    unsigned a = 0, b = 0, c = 0, d = 0, registers = 0;
    if (__get_cpuid(1, &a, &b, &c, &d) == 0) return {};
    constexpr unsigned first = bit_FMA | bit_POPCNT | bit_OSXSAVE;
    if ((c & first) != first) return {};
    asm("xgetbv" : "=a"(registers), "=d"(d) : "c"(0));
    if (__get_cpuid(0x80000001, &a, &b, &c, &d) == 0 || (c & bit_LZCNT) == 0) return {};
    if (__get_cpuid_count(7, 0, &a, &b, &c, &d) == 0) return {};
    constexpr unsigned second = bit_AVX2 | bit_BMI | bit_BMI2;
    constexpr unsigned third = bit_AVX512F | bit_AVX512DQ | bit_AVX512VL | bit_AVX512BW;
    constexpr unsigned ymm = 0x6, zmm = 0xe6;  // and the narrower ones
    const bool avx2 = (b & second) == second && (registers & ymm) == ymm;
    return {avx2, avx2 && (b & third) == third && (registers & zmm) == zmm};
}
#endif

const Kernels* best = nullptr;  // set by set_best_kernels()

}  // namespace

std::vector<const Kernels*> supported_kernels() {
    std::vector<const Kernels*> supported;
#if defined(__x86_64__)
    static const Instructions instructions = find_instructions();
    if (instructions.avx512) supported.push_back(&kernels_avx512);
    if (instructions.avx2) supported.push_back(&kernels_avx2);
#endif
    supported.push_back(&kernels_baseline);
    if (best != nullptr) supported.erase(supported.begin(), std::ranges::find(supported, best));
    return supported;
}

void set_best_kernels(const Kernels& kernels) {
    best = &kernels;
}

const Kernels& best_kernels() {
    return *supported_kernels().front();
}

const Kernels* find_kernels(std::string_view name) {
    for (const Kernels* kernels : supported_kernels())
        if (name.empty() || name == kernels->name) return kernels;
    return nullptr;
}

}  // namespace votess::cpu
