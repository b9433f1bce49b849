#include "fields/frame.hpp"

#include <cmath>
#include <string>

namespace votess::fields {
namespace {

// They depend on the grid alone, and with them the order of all sums.
constexpr std::int64_t tiles_along_axis = 8;

// Beyond this many grid cells from the domain's corner a body's place has no digits.
constexpr double farthest = 0x1p31;

}  // namespace

Frame::Domain Frame::domain_of(const Box& box, const std::optional<TriclinicBox>& cell, double scale) {
    const auto scaled = [&](const Vector& x) { return Vector{x[0] * scale, x[1] * scale, x[2] * scale}; };
    if (cell) return {scaled(cell->origin), {scaled(cell->a), scaled(cell->b), scaled(cell->c)}, scale};
    Domain domain{scaled(box.lower), {}, scale};
    const Vector upper = scaled(box.upper);
    for (std::size_t k = 0; k < 3; ++k) domain.edges[k][k] = upper[k] - domain.origin[k];
    return domain;
}

Frame::Domain Frame::domain_of(const Tessellation& t) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k)
        largest = std::max({largest, std::abs(t.box().lower[k]), std::abs(t.box().upper[k])});
    Domain domain = domain_of(t.box(), t.cell(), std::ldexp(1.0, -std::ilogb(largest)));
    if (t.planar()) domain.edges[2] = {0, 0, domain.scale};
    return domain;
}

Frame::Frame(const Job& job, const std::array<std::size_t, 3>& shape)
    : Frame(domain_of(job.box, job.region.cell, job.scale), job.domain->periodic, shape) {
    if (job.region.thickness > 0) flat_exponent_ = std::ilogb(job.region.thickness);
}
Frame::Frame(const Tessellation& t, const std::array<std::size_t, 3>& shape)
    : Frame(domain_of(t), t.periodic(), shape) {}

Frame::Frame(const Domain& domain, const std::array<bool, 3>& periodic, const std::array<std::size_t, 3>& shape)
    : scale_(domain.scale), origin_(domain.origin), edges_(domain.edges) {
    std::array<Vector, 3> unit = edges_;  // of order one
    for (std::size_t k = 0; k < 3; ++k) {
        axes_[k].count = static_cast<std::int64_t>(shape[k]);
        axes_[k].periodic = periodic[k];
        axes_[k].tile = ceil_div(axes_[k].count, tiles_along_axis);
        exponents_[k] = std::ilogb(std::max({std::abs(unit[k][0]), std::abs(unit[k][1]), std::abs(unit[k][2])}));
        for (double& x : unit[k]) x = std::ldexp(x, -exponents_[k]);
        const int half = exponents_[k] / 2;
        powers_[k] = {std::ldexp(1.0, -half), std::ldexp(1.0, half - exponents_[k])};
        lengths_[k] = std::sqrt(dot(unit[k], unit[k]));
        axes_[k].length = std::ldexp(lengths_[k], exponents_[k] - std::ilogb(scale_));
    }
    determinant_ = dot(unit[0], cross(unit[1], unit[2]));
    mirrored_ = determinant_ < 0;
    for (std::size_t k = 0; k < 3; ++k) {
        rows_[k] = cross(unit[(k + 1) % 3], unit[(k + 2) % 3]);
        for (double& x : rows_[k]) x = x / determinant_ * static_cast<double>(axes_[k].count);
    }
}

Size Frame::cell_size(std::optional<int> projected) const {
    Size size{std::abs(determinant_), -flat_exponent_};
    for (int k = 0; k < 3; ++k) {
        const auto i = static_cast<std::size_t>(k);
        size.mantissa /= k == projected ? lengths_[i] : static_cast<double>(axes_[i].count);
        if (k != projected) size.exponent += exponents_[i] - std::ilogb(scale_);
    }
    return size;
}

std::size_t Frame::cells() const {
    return index({axes_[0].count - 1, axes_[1].count - 1, axes_[2].count - 1}) + 1;
}

Vector Frame::position(const double* x) const {
    return in_grid({x[0] * scale_ - origin_[0], x[1] * scale_ - origin_[1], x[2] * scale_ - origin_[2]});
}

Vector Frame::difference(const double* from, const double* to) const {
    return in_grid(
        {to[0] * scale_ - from[0] * scale_, to[1] * scale_ - from[1] * scale_, to[2] * scale_ - from[2] * scale_});
}

Vector Frame::in_grid(const Vector& difference) const {
    Vector x;
    for (std::size_t k = 0; k < 3; ++k) {
        x[k] = dot(rows_[k], difference) * powers_[k][0] * powers_[k][1];
        if (!(std::abs(x[k]) < farthest))
            throw Error(ErrorCode::unsupported,
                        std::string("an edge of the domain is so short beside the others, or beside the distance of a "
                                    "seed outside, that a grid along it has no digits, edge ") +
                            "abc"[k]);
    }
    return x;
}

Vector Frame::in_space(const Vector& difference) const {
    Vector x{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 3; ++i)
            x[i] += difference[k] * (edges_[k][i] / static_cast<double>(axes_[k].count));
    for (double& c : x) c /= scale_;
    return x;
}

Vector Frame::center(const Cell& cell) const {
    Vector x = origin_;
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 3; ++i)
            x[i] += (static_cast<double>(cell[k]) + 0.5) * (edges_[k][i] / static_cast<double>(axes_[k].count));
    for (double& c : x) c /= scale_;
    return x;
}

std::size_t Frame::index(const Cell& cell, std::optional<int> projected) const {
    std::int64_t at = 0;
    for (int k = 0; k < 3; ++k) {
        const std::int64_t count = axes_[k].count;
        if (k != projected) at = at * count + modulo(cell[k], count);
    }
    return static_cast<std::size_t>(at);
}

Cell Frame::cell(std::size_t index) const {
    Cell cell{};
    auto rest = static_cast<std::int64_t>(index);
    for (std::size_t k = 3; k-- > 0; rest /= axes_[k].count) cell[k] = rest % axes_[k].count;
    return cell;
}

// Whole numbers are compared relative to `at`, where nothing near is rounded.
Range Frame::cover(std::size_t k, double at, double least, double largest) const {
    const Axis& axis = axes_[k];
    const auto from_at = [at](std::int64_t number) { return static_cast<double>(number) - at; };
    Range range{static_cast<std::int64_t>(std::floor(at + least)),
                static_cast<std::int64_t>(std::ceil(at + largest)) - 1};
    if (least < from_at(range.first)) --range.first;
    if (least >= from_at(range.first + 1)) ++range.first;
    if (largest > from_at(range.last + 1)) ++range.last;
    if (largest <= from_at(range.last)) --range.last;
    range.last = std::max(range.last, range.first);
    // Rounding may put the rim of the domain outside of it.
    if (!axis.periodic) {
        range.first = std::clamp<std::int64_t>(range.first, 0, axis.count - 1);
        range.last = std::clamp<std::int64_t>(range.last, 0, axis.count - 1);
    }
    return range;
}

}  // namespace votess::fields
