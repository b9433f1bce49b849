#include "fields/frame.hpp"

#include <cmath>

namespace votess::fields {
namespace {

// They depend on the grid alone, and with them the order of all sums.
constexpr std::int64_t tiles_along_axis = 8;

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

Frame::Frame(const Job& job, const std::array<std::size_t, 3>& shape) {
    std::array<Vector, 3> box_edges{};
    if (job.options.cell) {
        origin_ = job.options.cell->origin;
        box_edges = {job.options.cell->a, job.options.cell->b, job.options.cell->c};
    } else {
        origin_ = job.box.lower;
        for (std::size_t k = 0; k < 3; ++k) box_edges[k][k] = job.box.upper[k] - job.box.lower[k];
    }
    // A power of two keeps products of lengths in range.
    double largest = 0;
    for (const Vector& edge : box_edges)
        for (const double x : edge) largest = std::max(largest, std::abs(x));
    const double scale = std::ldexp(1.0, -std::ilogb(largest));
    for (std::size_t k = 0; k < 3; ++k) {
        axes_[k].count = static_cast<std::int64_t>(shape[k]);
        axes_[k].periodic = job.domain->periodic[k];
        axes_[k].tile = ceil_div(axes_[k].count, tiles_along_axis);
        for (double& x : box_edges[k]) x *= scale;
        axes_[k].length = std::sqrt(dot(box_edges[k], box_edges[k])) / scale;
    }
    const double determinant = dot(box_edges[0], cross(box_edges[1], box_edges[2]));
    mirrored_ = determinant < 0;
    cell_volume_ = std::abs(determinant);
    for (std::size_t k = 0; k < 3; ++k) {
        const auto count = static_cast<double>(axes_[k].count);
        const Vector across = cross(box_edges[(k + 1) % 3], box_edges[(k + 2) % 3]);
        for (std::size_t i = 0; i < 3; ++i) {
            rows_[k][i] = across[i] / determinant * scale * count;
            edges_[k][i] = box_edges[k][i] / scale / count;
        }
        cell_volume_ = cell_volume_ / count / scale;
    }
}

std::size_t Frame::cells() const {
    return index({axes_[0].count - 1, axes_[1].count - 1, axes_[2].count - 1}) + 1;
}

Vector Frame::position(const double* x) const {
    return difference(origin_.data(), x);
}

Vector Frame::difference(const double* from, const double* to) const {
    const Vector d{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    return {dot(rows_[0], d), dot(rows_[1], d), dot(rows_[2], d)};
}

Vector Frame::center(const Cell& cell) const {
    Vector x = origin_;
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = 0; i < 3; ++i) x[i] += (static_cast<double>(cell[k]) + 0.5) * edges_[k][i];
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

Range Frame::cover(std::size_t k, double least, double largest) const {
    const Axis& axis = axes_[k];
    Range range{static_cast<std::int64_t>(std::floor(least)), static_cast<std::int64_t>(std::ceil(largest)) - 1};
    range.last = std::max(range.last, range.first);
    // Rounding may put the rim of the domain outside of it.
    if (!axis.periodic) {
        range.first = std::clamp<std::int64_t>(range.first, 0, axis.count - 1);
        range.last = std::clamp<std::int64_t>(range.last, 0, axis.count - 1);
    }
    return range;
}

}  // namespace votess::fields
