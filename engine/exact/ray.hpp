// Exact signs along a ray o + t d. At time t the power distance of seed q is |q - o|^2 - w - 2 t (q - o).d + t^2 |d|^2.
// Its last term is the same for all seeds. So each seed is a line over t, and the ray's cells are the lower envelope.
#pragma once

#include "exact/predicate.hpp"

namespace votess::exact {

struct Ray {
    Point origin{}, direction{};
};

// A time. The power of a bisector is minus the weight of its seed.
struct Crossing {
    enum class Kind : std::uint8_t { time, wall, bisector };
    Kind kind = Kind::time;
    double time = 0;     // as it is
    Plane to{}, from{};  // where the ray crosses the wall `to`; from the cell of one seed into that of another

    static Crossing at(double time) {
        Crossing crossing;
        crossing.time = time;
        return crossing;
    }
    static Crossing through(const Plane& wall) { return {Kind::wall, 0, wall, {}}; }
    static Crossing between(const Plane& from, const Plane& to) { return {Kind::bisector, 0, to, from}; }
};

// Returns +1 when the ray approaches the wall, or the second seed faster than the first; -1 when it recedes; 0 else.
int approach(const Ray& ray, const Crossing& crossing);
// Returns the sign of the time of a minus that of b. The ray approaches both.
int later(const Ray& ray, const Crossing& a, const Crossing& b);
// Returns the time, wrong by at most 2^-50 of it. The ray approaches the crossing.
double time_of(const Ray& ray, const Crossing& crossing);

}  // namespace votess::exact
