#include "verify/seed_planes.hpp"

#include <algorithm>
#include <cmath>

#include "core/progress.hpp"

namespace votess {

SeedPlanes::SeedPlanes(const Job& job) : job_(job), domain_(*job.domain) {
    if (!domain_.is_periodic()) return;
    wrap_.resize(job.points.count());
    in_pieces(wrap_.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) wrap_[i] = wrap(domain_, seed(i)).value_or(exact::Shift{});
    });
    if (std::ranges::all_of(wrap_, [](const exact::Shift& shift) { return shift == exact::Shift{}; })) wrap_.clear();
}

Vector3 SeedPlanes::place(std::size_t i) const {
    if (wrap_.empty()) return seed(i);
    const auto x = exact::differences({}, exact::Plane::bisector(seed(i), wrap_[i], domain_.lattice)).x;
    return {x[0].high, x[1].high, x[2].high};
}

exact::Plane SeedPlanes::plane(std::size_t i, std::int32_t id, const exact::Shift& shift) const {
    if (id < -6) return domain_.walls[static_cast<std::size_t>(-7 - id)];
    if (id < 0) return domain_.box_wall(-1 - id);
    const auto j = static_cast<std::size_t>(id);
    exact::Shift total = shift;
    if (!wrap_.empty())
        for (std::size_t k = 0; k < 3; ++k) total[k] += wrap_[j][k] - wrap_[i][k];
    exact::Plane plane = exact::Plane::bisector(seed(j), total, domain_.lattice);
    if (domain_.has_weights()) plane.power = exact::two_sum(domain_.weights[i], -domain_.weights[j]);
    return plane;
}

RoundedPlane SeedPlanes::rounded_image(std::size_t i, std::int32_t id, const exact::Shift& shift) const {
    const auto difference = exact::differences(seed(i), plane(i, id, shift)).x;
    return bisector(i, static_cast<std::size_t>(id), {difference[0].high, difference[1].high, difference[2].high});
}

RoundedPlane SeedPlanes::rounded_wall(std::size_t i, std::int32_t id) const {
    const exact::Plane wall = plane(i, id, {});
    const exact::Point p = seed(i);
    RoundedPlane r;
    using Kind = exact::Plane::Kind;
    if (wall.kind == Kind::wall) {
        r.n = wall.seed;
        r.d = wall.wall - dot(r.n, p);
        r.size = std::abs(wall.wall);
        for (std::size_t k = 0; k < 3; ++k) r.size += std::abs(r.n[k] * p[k]);
    } else if (wall.kind == Kind::cell_wall) {
        const auto axis = static_cast<std::size_t>(wall.axis);
        r.n = wall.rounded_normal();
        for (std::size_t k = 0; k < 3; ++k) {
            const double step = wall.shift[axis] == 0 ? 0 : wall.lattice->vector[axis][k].high;
            r.d += r.n[k] * (wall.seed[k] + step - p[k]);
            r.size += std::abs(r.n[k]) * (std::abs(wall.seed[k]) + std::abs(step) + std::abs(p[k]));
        }
    } else {
        const auto axis = static_cast<std::size_t>(wall.axis);
        const bool upper = wall.kind == Kind::upper_wall;
        r.n[axis] = upper ? 1 : -1;
        r.d = upper ? wall.wall - p[axis] : p[axis] - wall.wall;
        r.size = std::abs(r.d);
    }
    r.length = length3(r.n[0], r.n[1], r.n[2]);
    return r;
}

bool SeedPlanes::same_place(std::size_t i, std::int32_t id, const exact::Shift& shift) const {
    const auto difference = exact::differences(seed(i), plane(i, id, shift));
    return difference.exact &&
           std::ranges::all_of(difference.x, [](const exact::DoubleDouble& x) { return x.high == 0 && x.low == 0; });
}

}  // namespace votess
