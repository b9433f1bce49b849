// The vertex of planes a, b, c, for many planes d.
#pragma once

#include "exact/predicate.hpp"

namespace votess::exact {

// a, b, c must meet in one point.
class ExactVertex {
public:
    ExactVertex(const Point& p, const Plane& a, const Plane& b, const Plane& c) : p_(p), a_(a), b_(b), c_(c) {}
    [[nodiscard]] int side(const Plane& d) const { return side_of_vertex(p_, a_, b_, c_, d); }

private:
    Point p_;
    Plane a_, b_, c_;
};

}  // namespace votess::exact
