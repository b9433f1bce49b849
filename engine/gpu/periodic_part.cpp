#include "gpu/periodic_part.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace votess::gpu {
namespace {

constexpr double margin_spacings = 4;  // of the mean distance between seeds
constexpr double slack = 1e-6;         // of a side: more than all rounding
constexpr double most_tries = 400;     // shifts tried for each image that is wanted, in skewed boxes

using Vector = std::array<double, 3>;

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

std::optional<PeriodicPart> periodic_part(const Job& job, std::uint32_t most_seeds) {
    const Domain& domain = *job.domain;
    if (domain.skewed) return std::nullopt;
    const std::size_t count = job.points.count();
    const double spacing = std::cbrt(domain.volume / static_cast<double>(std::max<std::size_t>(count, 1)));
    const double margin = std::min(margin_spacings * spacing, 2 * domain.covering_radius) / job.scale;
    PeriodicPart result;
    result.box = larger_box(job, margin);
    const Units units = Units::for_box(result.box);

    // Box vectors in units, exactly.
    std::array<std::array<std::uint64_t, 3>, 3> vector{};
    bool lossy = false;
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
            if (domain.triclinic)
                vector[j][k] = units.of(domain.vector[j][k] / job.scale, lossy);
            else if (j == k && domain.periodic[k])
                vector[j][k] = units.of(job.box.upper[k], lossy) - units.of(job.box.lower[k], lossy);
        }
    if (lossy) return std::nullopt;

    const auto fraction = [&](const exact::Point& x) {
        return domain.edges.fraction({x[0] - domain.origin[0], x[1] - domain.origin[1], x[2] - domain.origin[2]});
    };
    // Shifts that may carry a point of the domain into the box: those of its corners, in fractions.
    Vector lower = {0, 0, 0}, upper = {0, 0, 0};
    for (int corner = 0; corner < 8; ++corner) {
        exact::Point x;
        for (int k = 0; k < 3; ++k)
            x[k] = (((corner >> k) & 1) != 0 ? result.box.upper[k] : result.box.lower[k]) * job.scale;
        const Vector f = fraction(x);
        for (int j = 0; j < 3; ++j) {
            lower[j] = corner == 0 ? f[j] : std::min(lower[j], f[j]);
            upper[j] = corner == 0 ? f[j] : std::max(upper[j], f[j]);
        }
    }
    double tries = 1;
    for (int j = 0; j < 3; ++j)
        if (domain.periodic[j]) tries *= upper[j] - lower[j] + 1;
    if (tries > most_tries) return std::nullopt;

    Part& part = result.part;
    part.own_count = static_cast<std::uint32_t>(count);
    const auto add = [&](std::size_t i, const exact::Shift& wrap, const std::array<int, 3>& shift) {
        part.members.push_back(static_cast<std::int32_t>(i));
        result.shifts.push_back({static_cast<std::int8_t>(shift[0]), static_cast<std::int8_t>(shift[1]),
                                 static_cast<std::int8_t>(shift[2])});
        for (int k = 0; k < 3; ++k) {
            std::uint64_t x = units.of(job.points[3 * i + k], result.lossy);
            for (int j = 0; j < 3; ++j)
                x += static_cast<std::uint64_t>(static_cast<std::int64_t>(wrap[j]) + shift[j]) * vector[j][k];
            result.coordinates.push_back(x);
        }
    };
    const auto scaled = [&](std::size_t i) {
        return exact::Point{job.points[3 * i] * job.scale, job.points[3 * i + 1] * job.scale,
                            job.points[3 * i + 2] * job.scale};
    };
    std::vector<exact::Shift> wraps(count);
    bool moved = false;
    for (std::size_t i = 0; i < count; ++i) {
        const auto shift = wrap(domain, scaled(i));
        if (!shift) return std::nullopt;  // the exact clipper tells of it
        wraps[i] = *shift;
        moved = moved || wraps[i] != exact::Shift{};
        add(i, wraps[i], {});
    }
    for (std::size_t i = 0; moved && i < count; ++i) {
        const exact::Point by = domain.translation(wraps[i]);
        result.wraps.push_back({by[0] / job.scale, by[1] / job.scale, by[2] / job.scale});
    }
    for (std::size_t i = 0; i < count; ++i) {
        exact::Point x = scaled(i);
        const exact::Point by = domain.translation(wraps[i]);
        for (int k = 0; k < 3; ++k) x[k] += by[k];
        const Vector f = fraction(x);
        std::array<int, 3> least{}, most{};
        for (int j = 0; j < 3; ++j) {
            if (!domain.periodic[j]) continue;
            least[j] = static_cast<int>(std::ceil(lower[j] - f[j] - slack));
            most[j] = static_cast<int>(std::floor(upper[j] - f[j] + slack));
            if (least[j] < std::numeric_limits<std::int8_t>::min() || most[j] > std::numeric_limits<std::int8_t>::max())
                return std::nullopt;
        }
        for (int a = least[0]; a <= most[0]; ++a)
            for (int b = least[1]; b <= most[1]; ++b)
                for (int c = least[2]; c <= most[2]; ++c) {
                    if (a == 0 && b == 0 && c == 0) continue;
                    const exact::Point step = domain.translation({a, b, c});
                    bool inside = true;
                    for (int k = 0; k < 3; ++k) {
                        const double at = (x[k] + step[k]) / job.scale;
                        inside = inside && at >= result.box.lower[k] && at <= result.box.upper[k];
                    }
                    if (inside) add(i, wraps[i], {a, b, c});
                }
        if (part.members.size() > most_seeds) return std::nullopt;
    }
    // A little inside of the box, for members were chosen by rounded coordinates.
    for (int k = 0; k < 3; ++k) {
        if (!domain.periodic[k]) continue;
        bool rounded = false;
        const std::uint64_t extent = units.of(result.box.upper[k], rounded) - units.of(result.box.lower[k], rounded);
        const auto inward = static_cast<std::uint64_t>(slack * static_cast<double>(extent));
        part.bounded |= 9u << k;
        part.lower[k] = inward;
        part.upper[k] = extent - inward;
    }
    return result;
}

}  // namespace votess::gpu
