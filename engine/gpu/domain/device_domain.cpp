#include "gpu/domain/device_domain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/box.hpp"
#include "gpu/domain/walls.hpp"

namespace votess::gpu {
namespace {

constexpr double margin_spacings = 4;                 // of the mean distance between seeds
constexpr double max_shifts = 1000;                   // tried for each seed
constexpr double max_images = 16, few_members = 1e5;  // images for each seed, where seeds are not few

// Returns the bounds of the cell that a basis spans at the domain's origin.
Box box_of_cell(const Job& job, const Basis& basis) {
    const Domain& domain = *job.domain;
    if (!domain.triclinic) return job.box;
    Box box{domain.origin, domain.origin};
    for (std::size_t k = 0; k < 3; ++k) {
        for (const auto& v : basis.vector) (v[k] < 0 ? box.lower[k] : box.upper[k]) += v[k];
        box.lower[k] /= job.scale;
        box.upper[k] /= job.scale;
    }
    return box;
}

std::size_t seeds_inside(const Job& job) {
    return job.points.count() - static_cast<std::size_t>(std::ranges::count(job.outside, CellStatus::outside));
}

// Enlarges the box beyond walls, so that no plane through corners of the domain's box passes through corners of this
// one.
void leave_room(Box& box) {
    constexpr std::array<double, 3> below{0.051, 0.063, 0.074}, above{0.084, 0.055, 0.067};
    for (std::size_t k = 0; k < 3; ++k) {
        const double side = box.upper[k] - box.lower[k];
        box.lower[k] -= below[k] * side;
        box.upper[k] += above[k] * side;
    }
}

}  // namespace

FractionRange fractions_of(const Domain& domain, const Basis& basis, const Box& box, double scale) {
    FractionRange range;
    range.lower.fill(std::numeric_limits<double>::infinity());
    range.upper.fill(-std::numeric_limits<double>::infinity());
    for (std::size_t corner = 0; corner < 8; ++corner) {
        exact::Point x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = (((corner >> k) & 1) != 0 ? box.upper[k] : box.lower[k]) * scale - domain.origin[k];
        const auto f = basis.fraction(x);
        for (std::size_t j = 0; j < 3; ++j) {
            range.lower[j] = std::min(range.lower[j], f[j]);
            range.upper[j] = std::max(range.upper[j], f[j]);
        }
    }
    return range;
}

double image_margin(double radius, double heavier) {
    constexpr double max_heavier = 8;  // squares of the radius: heavier seeds leave few cells
    return radius + std::sqrt(radius * radius + std::min(heavier, max_heavier * radius * radius));
}

Box device_box(const Job& job) {
    if (!has_device_walls(*job.domain)) return job.box;
    Box box = job.box;
    for (std::size_t i = 0; i < job.beyond.size(); ++i)
        if (job.beyond[i]) include(box, point_of(job.points, i));
    leave_room(box);
    return whole_box(box, {true, true, true});
}

namespace {

std::optional<ImageRange> image_range(const Job& job) {
    const Domain& domain = *job.domain;
    const auto count = static_cast<double>(std::max<std::size_t>(seeds_inside(job), 1));
    const double spacing = std::cbrt(domain.volume / count);
    const double usual = image_margin(0.5 * margin_spacings * spacing, domain.largest_weight - domain.min_weight);
    const double margin = std::min(usual, 2 * domain.covering_radius) / job.scale;
    ImageRange range;
    range.basis = domain.skewed ? &domain.reduced : &domain.edges;
    range.box = box_of_cell(job, *range.basis);
    if (domain.has_cell_walls()) leave_room(range.box);
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t j = 0; j < 3; ++j)
            range.extended[k] = range.extended[k] || (domain.periodic[j] && range.basis->vector[j][k] != 0);
        if (!range.extended[k]) continue;
        range.box.lower[k] -= margin;
        range.box.upper[k] += margin;
    }
    range.box = whole_box(range.box, domain.has_cell_walls() ? std::array{true, true, true} : range.extended);

    range.fractions = fractions_of(domain, *range.basis, range.box, job.scale);
    double members = count / domain.volume;
    for (std::size_t k = 0; k < 3; ++k) members *= (range.box.upper[k] - range.box.lower[k]) * job.scale;
    double tries = 1;
    for (std::size_t j = 0; j < 3; ++j)
        if (domain.periodic[j]) tries *= range.fractions.upper[j] - range.fractions.lower[j] + 1;
    if (!(tries <= max_shifts) || !(members <= std::max(max_images * count, few_members))) return std::nullopt;
    return range;
}

// Returns whether all seeds lie near enough to the domain for a device's numbers.
bool seeds_are_near(const Job& job, const Box& box) {
    constexpr double farthest = 64;  // sides of the domain
    if (job.beyond.empty()) return true;
    double longest = 0, side = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        longest = std::max(longest, box.upper[k] / 2 - box.lower[k] / 2);
        side = std::max(side, job.box.upper[k] / 2 - job.box.lower[k] / 2);
    }
    return !job.domain->is_periodic() && longest <= farthest * side;
}

}  // namespace

std::optional<DeviceDomain> device_domain(const Job& job) {
    DeviceDomain result;
    if (job.domain->is_periodic()) {
        result.images = image_range(job);
        if (!result.images) return std::nullopt;
        result.box = result.images->box;
    } else {
        result.box = device_box(job);
    }
    if (!seeds_are_near(job, result.box)) return std::nullopt;
    if (job.domain->has_weights() && !weight_units(*job.domain, Units::for_box(result.box), job.scale))
        return std::nullopt;
    return result;
}

}  // namespace votess::gpu
