#include "verify/plane_loops.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "core/arithmetic.hpp"
#include "polytope/cell_kernels.hpp"

namespace votess {
namespace {

using Real4 = double __attribute__((vector_size(32)));
using Mask4 = std::int64_t __attribute__((vector_size(32)));

#define VOTESS_INLINE inline __attribute__((always_inline))

VOTESS_INLINE void load(Real4& r, const double* p) {
    std::memcpy(&r, p, sizeof r);
}

VOTESS_INLINE void slacks_of(const PlaneArrays& planes, std::size_t f, const Vector3& at, Real4& slack) {
    Real4 x, y, z, d;
    load(x, &planes.nx[f]);
    load(y, &planes.ny[f]);
    load(z, &planes.nz[f]);
    load(d, &planes.d[f]);
    slack = d - (x * at[0] + y * at[1] + z * at[2]);
}

VOTESS_INLINE int sum_of(const Mask4& mask) {
    return static_cast<int>(mask[0] + mask[1] + mask[2] + mask[3]);
}

// As below with the bound of each plane by itself.
bool is_sure_by_plane(const PlaneArrays& planes, const PlaneCorner& corner) {
    std::size_t sure = 0;
    for (std::size_t f = 0; f < planes.count; ++f) {
        const double slack =
            planes.d[f] - (planes.nx[f] * corner.at[0] + planes.ny[f] * corner.at[1] + planes.nz[f] * corner.at[2]);
        sure += slack > planes.length[f] * corner.slope + planes.size[f] * corner.constant + filter_underflow ? 1 : 0;
    }
    return sure + 3 == planes.count;
}

template <bool with_inverses>
VOTESS_INLINE bool sure_corner_body(const PlaneArrays& planes, int a, int b, int c, PlaneCorner& corner,
                                    double* inverse) {
    if (!meet(planes, a, b, c, corner)) return false;
    // The three planes never count: exactly they are 0.
    const double bound = planes.longest * corner.slope + planes.largest * corner.constant + filter_underflow;
    Mask4 sure{};
    for (std::size_t f = 0; f < planes.padded; f += PlaneArrays::lanes) {
        Real4 slack;
        slacks_of(planes, f, corner.at, slack);
        sure -= slack > bound;  // true is -1
        if constexpr (with_inverses) {
            const Real4 inverses = 1 / slack;
            std::memcpy(inverse + f, &inverses, sizeof inverses);
        }
    }
    if constexpr (with_inverses)
        for (const int f : {a, b, c}) inverse[f] = 0;
    return sum_of(sure) == static_cast<int>(planes.padded) - 3 || is_sure_by_plane(planes, corner);
}

VOTESS_INLINE void inverses_body(const PlaneArrays& planes, const Vector3& at, double* inverse) {
    for (std::size_t f = 0; f < planes.padded; f += PlaneArrays::lanes) {
        Real4 slack;
        slacks_of(planes, f, at, slack);
        const Real4 inverses = 1 / slack;
        std::memcpy(inverse + f, &inverses, sizeof inverses);
    }
}

// The last bits of a quotient hold the number of its plane.
VOTESS_INLINE Hit first_hit_body(const PlaneArrays& planes, const double* inverse, const Vector3& along) {
    const auto places = static_cast<std::int64_t>(std::bit_ceil(planes.padded));
    const Mask4 rest = Mask4{} + ~(places - 1);
    Real4 most{};
    Mask4 index{0, 1, 2, 3};
    for (std::size_t f = 0; f < planes.padded; f += PlaneArrays::lanes) {
        Real4 x, y, z, times;
        load(x, &planes.nx[f]);
        load(y, &planes.ny[f]);
        load(z, &planes.nz[f]);
        load(times, inverse + f);
        const Mask4 bits = ((Mask4)((x * along[0] + y * along[1] + z * along[2]) * times) & rest) | index;
        most = (Real4)bits > most ? (Real4)bits : most;
        index += static_cast<std::int64_t>(PlaneArrays::lanes);
    }
    const double low = most[0] > most[1] ? most[0] : most[1], high = most[2] > most[3] ? most[2] : most[3],
                 first = low > high ? low : high;
    if (!(first > 0x1p-1000)) return {};
    return {static_cast<int>(std::bit_cast<std::int64_t>(first) & (places - 1)), 1 / first};
}

VOTESS_INLINE double largest_of(const std::vector<double>& values, std::size_t padded) {
    Real4 most{};
    for (std::size_t f = 0; f < padded; f += PlaneArrays::lanes) {
        Real4 some;
        load(some, &values[f]);
        most = some > most ? some : most;
    }
    return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

static_assert(offsetof(PlaneCorner, at) == 0);
VOTESS_INLINE void add_areas_body(std::span<const PlaneEdge> edges, const PlaneCorner* corners, const Vector3& origin,
                                  double* areas) {
    const Real4 middle{origin[0], origin[1], origin[2], 0};
    for (const PlaneEdge& edge : edges) {
        Real4 from, to, left, right;
        std::memcpy(&from, corners + edge.from, sizeof from);  // `at` and a number that does not count
        std::memcpy(&to, corners + edge.to, sizeof to);
        from -= middle, to -= middle;
        const Real4 turned = from * __builtin_shufflevector(to, to, 1, 2, 0, 3) -
                             __builtin_shufflevector(from, from, 1, 2, 0, 3) * to,
                    turn = __builtin_shufflevector(turned, turned, 1, 2, 0, 3);
        double *const of_left = areas + 4 * edge.left, *const of_right = areas + 4 * edge.right;
        load(left, of_left);
        left += turn;
        std::memcpy(of_left, &left, sizeof left);
        load(right, of_right);
        right -= turn;
        std::memcpy(of_right, &right, sizeof right);
    }
}

VOTESS_INLINE void add_areas_of_fans_body(std::span<const PlaneFan> fans, const PlaneCorner* corners,
                                          const Vector3& origin, double* areas) {
    const Real4 middle{origin[0], origin[1], origin[2], 0};
    for (std::size_t v = 0; v < fans.size(); ++v) {
        Real4 from, to, sum;
        std::memcpy(&from, corners + v, sizeof from);  // as above
        from -= middle;
        const Real4 turned = __builtin_shufflevector(from, from, 1, 2, 0, 3);
        for (std::size_t k = 0; k < 3; ++k) {
            std::memcpy(&to, corners + fans[v].after(k), sizeof to);
            to -= middle;
            const Real4 turn = from * __builtin_shufflevector(to, to, 1, 2, 0, 3) - turned * to;
            double* const of_plane = areas + 4 * fans[v].plane(k);
            load(sum, of_plane);
            sum += __builtin_shufflevector(turn, turn, 1, 2, 0, 3);
            std::memcpy(of_plane, &sum, sizeof sum);
        }
    }
}

VOTESS_INLINE void complete_body(PlaneArrays& planes, std::size_t first) {
    double* const __restrict d = planes.d.data();
    double* const __restrict length = planes.length.data();
    double* const __restrict size = planes.size.data();
    double* const __restrict inverse = planes.inverse.data();
    double* const __restrict distance = planes.distance.data();
    const double *const x = planes.nx.data(), *const y = planes.ny.data(), *const z = planes.nz.data(),
                        *const power = planes.power.data();
    double shortest = infinity;
    for (std::size_t f = first; f < planes.count; ++f) {
        const double square = x[f] * x[f] + y[f] * y[f] + z[f] * z[f];
        const double root = std::sqrt(square), most = 0.5 * (square + std::abs(power[f]));
        d[f] = 0.5 * (square + power[f]);
        length[f] = root;
        size[f] = is_ordinary(root, most) ? most : infinity;  // which no bound trusts
        inverse[f] = 1 / root;
        distance[f] = size[f] * inverse[f];
        shortest = root < shortest ? root : shortest;
    }
    for (std::size_t f = first; shortest * shortest <= least_square && f < planes.count; ++f) {
        length[f] = length3(x[f], y[f], z[f]);
        inverse[f] = 1 / length[f];
    }
    planes.longest = largest_of(planes.length, planes.padded);
    planes.largest = largest_of(planes.size, planes.padded);
}

#define VOTESS_LOOPS(NAME, TARGET)                                                                                    \
    TARGET void complete_##NAME(PlaneArrays& planes, std::size_t first) {                                             \
        complete_body(planes, first);                                                                                 \
    }                                                                                                                 \
    TARGET bool sure_corner_##NAME(const PlaneArrays& planes, int a, int b, int c, PlaneCorner& corner) {             \
        return sure_corner_body<false>(planes, a, b, c, corner, nullptr);                                             \
    }                                                                                                                 \
    TARGET bool sure_corner_and_inverses_##NAME(const PlaneArrays& planes, int a, int b, int c, PlaneCorner& corner,  \
                                                double* inverse) {                                                    \
        return sure_corner_body<true>(planes, a, b, c, corner, inverse);                                              \
    }                                                                                                                 \
    TARGET void inverses_##NAME(const PlaneArrays& planes, const Vector3& x, double* inverse) {                       \
        inverses_body(planes, x, inverse);                                                                            \
    }                                                                                                                 \
    TARGET Hit first_hit_##NAME(const PlaneArrays& planes, const double* inverse, const Vector3& along) {             \
        return first_hit_body(planes, inverse, along);                                                                \
    }                                                                                                                 \
    TARGET void add_areas_##NAME(std::span<const PlaneEdge> edges, const PlaneCorner* corners, const Vector3& origin, \
                                 double* areas) {                                                                     \
        add_areas_body(edges, corners, origin, areas);                                                                \
    }                                                                                                                 \
    TARGET void add_areas_of_fans_##NAME(std::span<const PlaneFan> fans, const PlaneCorner* corners,                  \
                                         const Vector3& origin, double* areas) {                                      \
        add_areas_of_fans_body(fans, corners, origin, areas);                                                         \
    }                                                                                                                 \
    constexpr PlaneLoops loops_##NAME{complete_##NAME,         sure_corner_##NAME, sure_corner_and_inverses_##NAME,   \
                                      inverses_##NAME,         first_hit_##NAME,   add_areas_##NAME,                  \
                                      add_areas_of_fans_##NAME};

VOTESS_LOOPS(baseline, )
#if defined(__x86_64__)
VOTESS_LOOPS(avx2, __attribute__((target("avx2"))))
#endif

}  // namespace

void PlaneArrays::clear() {
    count = padded = 0;
    longest = largest = 0;
}

std::size_t PlaneArrays::append(std::size_t more) {
    const std::size_t first = count;
    count += more;
    pad();
    return first;
}

void PlaneArrays::remove(std::size_t first) {
    count = first;
    pad();
}

void PlaneArrays::pad() {
    padded = (count + lanes - 1) / lanes * lanes;
    if (nx.size() < padded)
        for (auto* values : {&nx, &ny, &nz, &d, &length, &size, &inverse, &distance, &power})
            values->resize(2 * padded);
    for (std::size_t f = count; f < padded; ++f) {
        nx[f] = ny[f] = nz[f] = length[f] = size[f] = inverse[f] = distance[f] = power[f] = 0;
        d[f] = 1;
    }
}

const PlaneLoops& plane_loops() {
#if defined(__x86_64__)
    if (std::string_view(cpu::best_kernels().name) != "baseline") return loops_avx2;
#endif
    return loops_baseline;
}

}  // namespace votess
