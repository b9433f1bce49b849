#include "index/lift.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/arithmetic.hpp"
#include "index/sorted_seeds.hpp"

namespace votess::cpu {
namespace {

constexpr double max_curvature = 1 - 0x1p-12;
constexpr double curvature_step = 0x1p-40;  // a multiple of it, so that 1 - k is not rounded
constexpr double min_gain = 4;              // in how far the heaviest is above the mean
constexpr double lift_ridge = 1e-12;        // of the mean square, for seeds in a plane or on a line
constexpr std::size_t min_seeds = 8;

struct Excess {  // of the heaviest above the mean
    double sum = 0, most = -infinity;
    std::size_t count = 0;
    void add(double weight) {
        sum += weight;
        most = std::max(most, weight);
        ++count;
    }
    [[nodiscard]] double value() const { return most - sum / static_cast<double>(count); }
};

}  // namespace

Lift fit_lift(const SortedSeeds& seeds) {
    const std::size_t count = seeds.size();
    if (count < min_seeds) return {};
    constexpr std::size_t terms = 4;  // x, y, z and the square; then the weight
    const auto at = [&](std::size_t s) { return exact::Point{seeds.x[s], seeds.y[s], seeds.z[s]}; };
    exact::Point middle{};
    for (std::size_t s = 0; s < count; ++s)
        for (std::size_t k = 0; k < 3; ++k) middle[k] += at(s)[k] / static_cast<double>(count);
    const auto row = [&](std::size_t s) {
        std::array<double, terms + 1> v{};
        for (std::size_t k = 0; k < 3; ++k) {
            v[k] = at(s)[k] - middle[k];
            v[3] += v[k] * v[k];
        }
        v[terms] = seeds.weights[s];
        return v;
    };
    std::array<double, terms + 1> mean{};
    for (std::size_t s = 0; s < count; ++s)
        for (std::size_t i = 0; i <= terms; ++i) mean[i] += row(s)[i] / static_cast<double>(count);
    double m[terms][terms + 1] = {};
    for (std::size_t s = 0; s < count; ++s) {
        auto v = row(s);
        for (std::size_t i = 0; i <= terms; ++i) v[i] -= mean[i];
        for (std::size_t i = 0; i < terms; ++i)
            for (std::size_t j = 0; j <= terms; ++j) m[i][j] += v[i] * v[j];
    }
    const double spread = m[0][0] + m[1][1] + m[2][2];
    for (std::size_t i = 0; i < terms; ++i) m[i][i] += lift_ridge * (i < 3 ? spread : m[i][i]);
    for (std::size_t i = 0; i < terms; ++i)
        for (std::size_t j = 0; j < terms; ++j) {
            if (j == i) continue;
            const double by = m[j][i] / m[i][i];
            for (std::size_t k = i; k <= terms; ++k) m[j][k] -= by * m[i][k];
        }
    Lift lift;
    const double curvature = std::round(m[3][terms] / m[3][3] / curvature_step) * curvature_step;
    if (!(curvature > curvature_step && curvature < max_curvature)) return {};
    lift.curvature = curvature;
    lift.shrink = 1 - curvature;
    for (std::size_t k = 0; k < 3; ++k) lift.center[k] = middle[k] - 0.5 * m[k][terms] / m[k][k] / curvature;
    Excess before, after;
    lift.rests.resize(seeds.places(), -infinity);
    for (std::size_t s = 0; s < count; ++s) {
        lift.rests[s] = lift.max_rest(at(s), seeds.weights[s]);
        before.add(seeds.weights[s]);
        after.add(lift.rests[s]);
    }
    if (!(min_gain * after.value() < before.value())) return {};
    return lift;
}

}  // namespace votess::cpu
