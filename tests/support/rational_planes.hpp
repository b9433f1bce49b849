// Planes of a cell in rational arithmetic, for tests of the exact decisions.
#pragma once

#include <gmpxx.h>

#include "exact/predicate.hpp"
#include "support/random.hpp"
#include "support/vectors.hpp"

namespace test {

using votess::exact::Plane;
using votess::exact::Point;

struct RationalPlane {
    RationalVector n;
    mpq_class h;  // n.x = h
};

inline RationalPlane rational(const Point& p, const Plane& plane) {
    RationalPlane r;
    if (plane.kind == Plane::Kind::bisector) {
        for (int k = 0; k < 3; ++k) {
            r.n[k] = mpq_class(plane.seed[k]) - mpq_class(p[k]);
            r.h += r.n[k] * r.n[k] / 2;
        }
        r.h += (mpq_class(plane.power.high) + mpq_class(plane.power.low)) / 2;
        if (plane.is_reversed()) {
            for (mpq_class& x : r.n) x = -x;
            r.h = -r.h;
        }
    } else {
        const int sign = plane.kind == Plane::Kind::lower_wall ? -1 : 1;
        r.n[plane.axis] = sign;
        r.h = sign * (mpq_class(plane.wall) - mpq_class(p[plane.axis]));
    }
    return r;
}

// Cramer's rule column by column, unlike the engine's cross products. False when the planes meet in no single point.
inline bool solve(const RationalPlane& a, const RationalPlane& b, const RationalPlane& c, RationalVector& x) {
    const mpq_class d = determinant(a.n, b.n, c.n);
    if (d == 0) return false;
    for (int k = 0; k < 3; ++k) {
        RationalPlane m[3] = {a, b, c};
        for (auto& row : m) row.n[k] = row.h;
        x[k] = determinant(m[0].n, m[1].n, m[2].n) / d;
    }
    return true;
}

inline Plane random_plane(Random& random, const auto& coordinate) {
    const auto kind = random.below(8);
    if (kind == 0) return Plane::lower(static_cast<int>(random.below(3)), coordinate());
    if (kind == 1) return Plane::upper(static_cast<int>(random.below(3)), coordinate());
    Plane bisector = Plane::bisector({coordinate(), coordinate(), coordinate()});
    if (kind == 2) bisector.reverse();
    return bisector;
}

// Which side of `plane` x lies on: +1 outside.
inline int side_of(const RationalVector& x, const RationalPlane& plane) {
    return sgn(mpq_class(dot(plane.n, x) - plane.h));
}

}  // namespace test
