// The planes of a job as its seeds see them: exact for signs, and rounded with a bound for filters.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/vector3.hpp"
#include "input/job.hpp"
#include "verify/plane_loops.hpp"

namespace votess {

inline bool is_zero(const exact::Shift& shift) {
    return (shift[0] | shift[1] | shift[2]) == 0;
}

// The half-space n.x <= d, of x relative to a seed. With u = 2^-53, n errs by at most 4 u length and d by 8 u size.
struct RoundedPlane {
    Vector3 n{};
    double d = 0, length = 0, size = 0;
};

class SeedPlanes {
public:
    // The job must outlive this object.
    explicit SeedPlanes(const Job& job);

    [[nodiscard]] const Domain& domain() const { return domain_; }
    [[nodiscard]] exact::Point seed(std::size_t i) const {
        return {job_.points[3 * i] * job_.scale, job_.points[3 * i + 1] * job_.scale,
                job_.points[3 * i + 2] * job_.scale};
    }
    // Returns where the seed lies inside the domain, rounded.
    [[nodiscard]] Vector3 place(std::size_t i) const;
    // Whether all seeds lie inside the domain.
    [[nodiscard]] bool are_inside() const { return wrap_.empty(); }
    // Returns the difference of weights.
    [[nodiscard]] double power(std::size_t i, std::size_t j) const {
        return domain_.has_weights() ? weight(i) - weight(j) : 0;
    }
    [[nodiscard]] double weight(std::size_t i) const { return domain_.has_weights() ? domain_.weights[i] : 0; }
    // Returns how many walls the domain has. Walls are -1 to -6, then -7, -8, ...; has_wall() knows those of the box.
    [[nodiscard]] std::int32_t walls() const { return 6 + static_cast<std::int32_t>(domain_.walls.size()); }
    [[nodiscard]] bool has_wall(std::int32_t id) const {
        return id < -6 ? -id <= walls() : domain_.has_box_wall(-1 - id);
    }
    // Returns the bisector of seed i with the image of seed `id`, or a wall. Shifts are between places inside the
    // domain.
    [[nodiscard]] exact::Plane plane(std::size_t i, std::int32_t id, const exact::Shift& shift) const;
    [[nodiscard]] RoundedPlane rounded(std::size_t i, std::int32_t id, const exact::Shift& shift) const {
        if (id >= 0 && is_zero(shift) && wrap_.empty()) {
            const auto j = static_cast<std::size_t>(id);
            return bisector(i, j, minus(seed(j), seed(i)));
        }
        return id < 0 ? rounded_wall(i, id) : rounded_image(i, id, shift);
    }
    // Whether the image lies where seed i does.
    [[nodiscard]] bool same_place(std::size_t i, std::int32_t id, const exact::Shift& shift) const;

private:
    [[nodiscard]] RoundedPlane bisector(std::size_t i, std::size_t j, const Vector3& difference) const {
        RoundedPlane r;
        r.n = difference;
        const double square = dot(r.n, r.n), power = this->power(i, j);
        r.d = 0.5 * (square + power);
        r.size = 0.5 * (square + std::abs(power));
        r.length = square > least_square ? std::sqrt(square) : length3(r.n[0], r.n[1], r.n[2]);
        return r;
    }
    [[nodiscard]] RoundedPlane rounded_image(std::size_t i, std::int32_t id, const exact::Shift& shift) const;
    [[nodiscard]] RoundedPlane rounded_wall(std::size_t i, std::int32_t id) const;

    const Job& job_;
    const Domain& domain_;
    std::vector<exact::Shift> wrap_;  // of each seed; empty if all lie inside the domain
};

}  // namespace votess
