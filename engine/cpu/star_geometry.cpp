// Volume, centroid and areas of a star as sums over its edges. With V, W the ends of an edge in counterclockwise order
// around a face of normal n (the difference of seeds, so that n.x = |n|^2/2 on it), V x W sums to twice the face's area
// vector, and n.(V x W)/12 to the volume of the pyramid between seed and face.
#include <algorithm>
#include <bit>
#include <cmath>

#include "cpu/star.hpp"

namespace votess::cpu {
namespace {

// The promise is 1e-10.
constexpr double accepted_error = 5e-11;
constexpr double smallest_volume = 1e-140;
constexpr double unit = 0x1p-53;

}  // namespace

bool Star::measure(Geometry& out) {
    double volume = 0, error = 0;
    Vector moment{};
    std::array<Vector, most_planes> area{};
    std::array<double, most_planes> norm{};
    std::array<Vector, most_planes> n;
    const double unscale = 1 / scale_;
    need_all_planes();
    for (int p = 0; p < planes_; ++p) {
        norm[p] = std::sqrt(2 * h_[p]) * unscale;
        for (int k = 0; k < 3; ++k) n[p][k] = n_[p][k] * unscale;
    }
    for (int p = 0; p < planes_; ++p)
        for (std::uint64_t others = links_[p].out >> p; others != 0; others &= others - 1) {
        const int q = p + std::countr_zero(others);
        const int from = from_vertex_[p][q], to = from_vertex_[q][p];
        const Vector &v = position_[from], &w = position_[to];
        const Vector &left = n[q], &right = n[p];
        const Vector c{v[1] * w[2] - v[2] * w[1], v[2] * w[0] - v[0] * w[2], v[0] * w[1] - v[1] * w[0]};
        double in_left = 0, in_right = 0;
        for (int k = 0; k < 3; ++k) {
            area[q][k] += c[k];
            area[p][k] -= c[k];
            in_left += left[k] * c[k];
            in_right -= right[k] * c[k];
        }
        const double both = in_left + in_right;
        volume += both;
        // The pyramid over the triangle of V, W and the foot n/2 of the plane.
        for (int k = 0; k < 3; ++k)
            moment[k] += both * (v[k] + w[k]) + 0.5 * (in_left * left[k] + in_right * right[k]);
        const double long_v = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
        const double long_w = std::abs(w[0]) + std::abs(w[1]) + std::abs(w[2]);
        error += (norm[q] + norm[p]) *
                 (error_[from] * long_w + error_[to] * long_v + 8 * unit * long_v * long_w);
    }
    volume /= 12;
    if (!(volume > smallest_volume && error / 12 <= accepted_error * volume)) return false;
    out.volume = volume;
    for (int k = 0; k < 3; ++k) out.centroid[k] = moment[k] / (48 * volume);
    for (int p = 0; p < planes_; ++p)
        out.areas[p] = 0.5 * std::sqrt(area[p][0] * area[p][0] + area[p][1] * area[p][1] + area[p][2] * area[p][2]);
    return true;
}

}  // namespace votess::cpu
