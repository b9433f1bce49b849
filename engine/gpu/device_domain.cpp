#include "gpu/device_domain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace votess::gpu {
namespace {

constexpr double margin_spacings = 4;  // of the mean distance between seeds
constexpr double most_shifts = 400;    // shifts tried for each image that is wanted, in skewed boxes

Box larger_box(const Job& job, double margin) {
    const Domain& domain = *job.domain;
    Box box = job.box;
    for (int k = 0; k < 3; ++k) {
        if (!domain.periodic[k]) continue;
        box.lower[k] = domain.box.lower[k] / job.scale - margin;
        box.upper[k] = domain.box.upper[k] / job.scale + margin;
    }
    return whole_box(box, domain.periodic);
}

}  // namespace

std::optional<PeriodicUnits> periodic_units(const Job& job) {
    const Domain& domain = *job.domain;
    if (domain.skewed) return std::nullopt;
    const auto count =
        job.points.count() - static_cast<std::size_t>(std::ranges::count(job.outside, CellStatus::outside));
    const double spacing = std::cbrt(domain.volume / static_cast<double>(std::max<std::size_t>(count, 1)));
    const double margin = std::min(margin_spacings * spacing, 2 * domain.covering_radius) / job.scale;
    PeriodicUnits result;
    result.box = larger_box(job, margin);
    result.units = Units::for_box(result.box);
    bool lossy = false;
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) {
            if (domain.triclinic)
                result.vector[j][k] = result.units.of(domain.vector[j][k] / job.scale, lossy);
            else if (j == k && domain.periodic[k])
                result.vector[j][k] =
                    result.units.of(job.box.upper[k], lossy) - result.units.of(job.box.lower[k], lossy);
        }
    if (lossy) return std::nullopt;

    result.lower.fill(std::numeric_limits<double>::infinity());
    result.upper.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t corner = 0; corner < 8; ++corner) {
        exact::Point x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = (((corner >> k) & 1) != 0 ? result.box.upper[k] : result.box.lower[k]) * job.scale;
        const auto f = domain.fraction(x);
        for (std::size_t j = 0; j < 3; ++j) {
            result.lower[j] = std::min(result.lower[j], f[j]);
            result.upper[j] = std::max(result.upper[j], f[j]);
        }
    }
    double tries = 1;
    for (std::size_t j = 0; j < 3; ++j)
        if (domain.periodic[j]) tries *= result.upper[j] - result.lower[j] + 1;
    if (tries > most_shifts) return std::nullopt;
    return result;
}

bool device_clips(const Job& job) {
    const Domain& domain = *job.domain;
    if (domain.has_weights() || !domain.walls.empty() || domain.has_cell_walls()) return false;
    return !domain.is_periodic() || periodic_units(job).has_value();
}

}  // namespace votess::gpu
