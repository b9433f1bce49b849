// The box of a LAMMPS file: bounds and the tilts xy, xz, yz of its edge vectors, or any three vectors and a corner.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "read/input.hpp"

namespace clvotess {

struct LammpsBox {
    using Vector3 = std::array<double, 3>;

    std::array<double, 3> lower{}, upper{};
    double xy = 0, xz = 0, yz = 0;
    bool general = false;  // the box is `edges` at `corner`
    std::array<Vector3, 3> edges{};
    Vector3 corner{};
    // LAMMPS boxes are periodic by default. Dumps may state boundaries, data files cannot.
    std::array<bool, 3> periodic{true, true, true};
    DomainSource periodic_from = DomainSource::assumed;

    [[nodiscard]] bool tilted() const noexcept { return xy != 0 || xz != 0 || yz != 0; }

    // Converts the bounds of a tilted box, which dumps state, to the ends of its edges.
    void take_off_bounds() noexcept {
        lower[0] -= std::min({0.0, xy, xz, xy + xz});
        upper[0] -= std::max({0.0, xy, xz, xy + xz});
        lower[1] -= std::min(0.0, yz);
        upper[1] -= std::max(0.0, yz);
    }

    // Returns why the box cannot be a domain; empty if it can.
    [[nodiscard]] std::string problem() const {
        if (general) {
            const auto finite = [](double x) { return std::isfinite(x); };
            bool good = std::ranges::all_of(corner, finite);
            for (std::size_t k = 0; k < 3; ++k) {
                good = good && std::ranges::all_of(edges[k], finite);
                if (good && std::ranges::count(edges[k], 0.0) == 3)
                    return std::string("the box has no edge ") + "abc"[k];
            }
            return good ? "" : "the edges of the box are not finite";
        }
        for (std::size_t k = 0; k < 3; ++k) {
            if (!std::isfinite(lower[k]) || !std::isfinite(upper[k]) || !(lower[k] < upper[k])) {
                return std::string("the box has no extent along ") + "xyz"[k];
            }
        }
        if (!std::isfinite(xy) || !std::isfinite(xz) || !std::isfinite(yz)) return "the tilt of the box is not finite";
        return {};
    }

    [[nodiscard]] std::array<double, 3> unscaled(const std::array<double, 3>& s) const {
        if (general) {
            Vector3 place = corner;
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t axis = 0; axis < 3; ++axis) place[axis] += s[k] * edges[k][axis];
            return place;
        }
        const double x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
        return {lower[0] + x * s[0] + xy * s[1] + xz * s[2], lower[1] + y * s[1] + yz * s[2], lower[2] + z * s[2]};
    }

    [[nodiscard]] FileDomain domain() const {
        FileDomain domain;
        domain.periodic_from = periodic_from;
        if (general) {
            domain.cell = votess::TriclinicBox{
                .origin = corner, .a = edges[0], .b = edges[1], .c = edges[2], .periodic = periodic};
            return domain;
        }
        if (!tilted()) {
            domain.box = votess::Box{lower, upper};
            domain.periodic = periodic;
            return domain;
        }
        domain.cell = votess::TriclinicBox{.origin = lower,
                                           .a = {upper[0] - lower[0], 0, 0},
                                           .b = {xy, upper[1] - lower[1], 0},
                                           .c = {xz, yz, upper[2] - lower[2]},
                                           .periodic = periodic};
        return domain;
    }
};

}  // namespace clvotess
