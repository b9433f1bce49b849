#include "gpu/seeds/periodic_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace votess::gpu {
namespace {

// This share of a period is more than fractions err by. They are 3 terms of at most most_shifts for each period that a
// seed is away, below 5e8 a vector (wrap), in float64: 3 * 3 * 400 * 5e8 * 2^-53 = 2e-4, and as much for the rounded
// inverse.
constexpr double slack = 0.01;
using Vector = std::array<double, 3>;

}  // namespace

std::optional<PeriodicPart> periodic_part(const Job& job, std::uint32_t most_seeds) {
    const Domain& domain = *job.domain;
    const auto on_device = periodic_units(job);
    if (!on_device) return std::nullopt;
    const auto& [box, units, vector, lower, upper] = *on_device;
    const std::size_t count = job.points.count();
    PeriodicPart result;
    result.box = box;

    // The box in units, modulo 2^64.
    std::array<std::uint64_t, 3> origin{}, extent{};
    bool rounded = false;
    for (int k = 0; k < 3; ++k) {
        origin[k] = units.of(result.box.lower[k], rounded);
        extent[k] = units.of(result.box.upper[k], rounded) - origin[k];
    }
    Part& part = result.part;
    using Units3 = std::array<std::uint64_t, 3>;
    const auto moved = [&](Units3 x, const auto& shift) {
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                x[k] += static_cast<std::uint64_t>(static_cast<std::int64_t>(shift[j])) * vector[j][k];
        return x;
    };
    const auto add = [&](std::size_t i, const Units3& x, const std::array<int, 3>& shift) {
        part.members.push_back(static_cast<std::int32_t>(i));
        result.shifts.push_back({static_cast<std::int8_t>(shift[0]), static_cast<std::int8_t>(shift[1]),
                                 static_cast<std::int8_t>(shift[2])});
        result.coordinates.insert(result.coordinates.end(), x.begin(), x.end());
    };
    const auto scaled = [&](std::size_t i) {
        return exact::Point{job.points[3 * i] * job.scale, job.points[3 * i + 1] * job.scale,
                            job.points[3 * i + 2] * job.scale};
    };
    std::vector<exact::Shift> wraps(count);
    bool any_moved = false;
    for (std::size_t i = 0; i < count; ++i) {
        if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;
        const auto shift = wrap(domain, scaled(i));
        if (!shift) return std::nullopt;  // the exact clipper tells of it
        wraps[i] = *shift;
        any_moved = any_moved || wraps[i] != exact::Shift{};
        Units3 x;
        for (int k = 0; k < 3; ++k) x[k] = units.of(job.points[3 * i + k], result.lossy);
        add(i, moved(x, wraps[i]), {});
    }
    part.own_count = static_cast<std::uint32_t>(part.members.size());
    if (part.own_count == 0) return std::nullopt;
    for (std::size_t i = 0; any_moved && i < count; ++i) {
        const exact::Point by = domain.translation(wraps[i]);
        result.wraps.push_back({by[0] / job.scale, by[1] / job.scale, by[2] / job.scale});
    }
    // Whether an image lies in the box, by its units; these tell places 2^64 apart not from each other, which are at
    // least four of the box's sides, but its fractions do.
    const auto is_inside = [&](const Units3& x, const Vector& fraction) {
        for (int k = 0; k < 3; ++k) {
            if (x[k] - origin[k] > extent[k]) return false;
            if (!domain.periodic[k]) continue;
            double at = 0;
            for (int j = 0; j < 3; ++j) at += fraction[j] * domain.vector[j][k];
            const double begin = result.box.lower[k] * job.scale - domain.origin[k];
            const double side = (result.box.upper[k] - result.box.lower[k]) * job.scale;
            if (at < begin - side || at > begin + 2 * side) return false;
        }
        return true;
    };
    for (std::size_t own = 0; own < part.own_count; ++own) {
        const auto i = static_cast<std::size_t>(part.members[own]);
        Units3 x;
        std::copy_n(result.coordinates.begin() + static_cast<std::ptrdiff_t>(3 * own), 3, x.begin());
        Vector f = domain.fraction(scaled(i));
        std::array<int, 3> least{}, most{};
        for (int j = 0; j < 3; ++j) {
            if (!domain.periodic[j]) continue;
            f[j] += wraps[i][j];
            least[j] = static_cast<int>(std::ceil(lower[j] - f[j] - slack));
            most[j] = static_cast<int>(std::floor(upper[j] - f[j] + slack));
            if (least[j] < std::numeric_limits<std::int8_t>::min() || most[j] > std::numeric_limits<std::int8_t>::max())
                return std::nullopt;
        }
        for (int a = least[0]; a <= most[0]; ++a)
            for (int b = least[1]; b <= most[1]; ++b)
                for (int c = least[2]; c <= most[2]; ++c) {
                    if (a == 0 && b == 0 && c == 0) continue;
                    const std::array<int, 3> shift{a, b, c};
                    const Units3 image = moved(x, shift);
                    if (is_inside(image, {f[0] + a, f[1] + b, f[2] + c})) add(i, image, shift);
                }
        if (part.members.size() > most_seeds) return std::nullopt;
    }
    // All images in the box are members. What lies beyond its upper end may, rounded down, lie a unit nearer.
    for (int k = 0; k < 3; ++k) {
        if (!domain.periodic[k]) continue;
        part.bounded |= 9u << k;
        part.upper[k] = extent[k] - 1;
    }
    return result;
}

}  // namespace votess::gpu
