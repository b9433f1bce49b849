#include "surface/surface.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"
#include "input/default_box.hpp"
#include "solid/closed_mesh.hpp"

namespace votess::surface {
namespace {

constexpr double thin = 1e-3;           // of the sine of an angle, below which areas are rounded from exact ones
constexpr double max_weight = 0x1p500;  // scaled
constexpr std::size_t max_seeds = 0x7fffffff;

// Returns a value at a scale.
double scaled(double value, double scale, const std::string& name) {
    if (value * scale / scale != value)
        refuse(name + " = " + number(value) +
               " is too small beside the others to represent both at one scale: move it to 0");
    return value * scale;
}

double area_of(const exact::Point& u, const exact::Point& v, const exact::Point& w) {
    const Vector3 a = minus(v, u), b = minus(w, u), n = cross(a, b);
    const double length = length3(n[0], n[1], n[2]);
    if (length > thin * length3(a[0], a[1], a[2]) * length3(b[0], b[1], b[2])) return 0.5 * length;
    exact::BitRange range;
    for (const exact::Point* x : {&u, &v, &w}) range.add(*x);
    const int quantum = range.quantum();
    const auto from_u = [&](const exact::Point& x, std::size_t k) {
        return exact::BigInt(exact::to_wide<exact::widest>(x[k], quantum) -
                             exact::to_wide<exact::widest>(u[k], quantum));
    };
    Vector3 normal;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t y = (k + 1) % 3, z = (k + 2) % 3;
        const exact::BigInt component = from_u(v, y) * from_u(w, z) - from_u(v, z) * from_u(w, y);
        normal[k] = static_cast<double>(ldexp(static_cast<exact::Quad>(component), 2 * quantum));
    }
    return 0.5 * length3(normal[0], normal[1], normal[2]);
}

}  // namespace

Surface::Surface(std::span<const double> points, const TriangleMesh& mesh, std::span<const double> weights,
                 ThreadPool& pool) {
    if (points.size() % 3 != 0)
        refuse("points hold " + std::to_string(points.size()) +
               " numbers, not a multiple of 3: the shape must be (N,3)");
    const std::size_t count = points.size() / 3;
    if (count == 0) refuse("there are no points: give at least one");
    if (count > max_seeds) refuse(std::to_string(count) + " points are too many: give at most 2147483647");
    if (!weights.empty() && weights.size() != count)
        refuse("SurfaceOptions::weights hold " + std::to_string(weights.size()) + " numbers for " +
               std::to_string(count) + " points: give one for each");
    const auto name = [](const char* what, std::size_t i, std::size_t k) {
        return std::string(what) + " " + std::to_string(i) + ": " + axis_name[k];
    };
    double largest = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!std::isfinite(points[i]))
            refuse(name("point", i / 3, i % 3) + " = " + number(points[i]) + " is not finite");
        largest = std::max(largest, std::abs(points[i]));
    }
    const auto given = solid::ClosedMesh::any_surface(mesh, "surface");
    for (const auto& triangle : given.given())
        for (const std::int32_t v : triangle)
            for (const double x : given.vertex(v)) largest = std::max(largest, std::abs(x));
    int exponent = 0;
    std::frexp(largest, &exponent);
    scale_ = std::ldexp(1.0, -std::clamp(exponent, -1000, 1000));
    seeds_.resize(count);
    for (std::size_t i = 0; i < points.size(); ++i)
        seeds_[i / 3][i % 3] =
            scale_ >= 1 ? points[i] * scale_ : scaled(points[i], scale_, name("point", i / 3, i % 3));
    std::vector<std::uint8_t> used(given.vertices());
    for (const auto& triangle : given.given())
        for (const std::int32_t v : triangle) used[at(v)] = 1;
    vertices_.resize(given.vertices());
    for (std::size_t v = 0; v < vertices_.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = given.vertex(static_cast<std::int32_t>(v))[k];
            vertices_[v][k] =
                used[v] == 0 || scale_ >= 1 ? x * scale_ : scaled(x, scale_, "surface: " + name("vertex", v, k));
        }
    read_weights(weights);
    double area = 0;
    for (const auto& vertex : given.given()) {
        check_stop();
        const auto& [u, v, w] = vertex;
        triangles_.push_back({vertex, {-1, -1, -1}, area_of(this->vertex(u), this->vertex(v), this->vertex(w))});
        area += triangles_.back().area;
    }
    if (!(area > 0)) refuse("surface: its triangles have no area");
    find_edges();
    tree_ = std::make_unique<SeedTree>(seeds_, weights_, pool);
}

void Surface::read_weights(std::span<const double> weights) {
    const double square = scale_ * scale_;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const std::string name = "SurfaceOptions::weights: weight " + std::to_string(i);
        if (!std::isfinite(weights[i])) refuse(name + " = " + number(weights[i]) + " is not finite");
        weights_.push_back(scaled(weights[i], square, name));
        if (std::abs(weights_.back()) > max_weight)
            refuse(name + " = " + number(weights[i]) +
                   " is too large beside the coordinates: subtract a constant from all");
    }
    if (std::ranges::all_of(weights_, [&](double w) { return w == weights_.front(); })) weights_.clear();
}

exact::Plane Surface::bisector(std::int32_t i, std::int32_t k) const {
    exact::Plane plane = exact::Plane::bisector(seed(k));
    if (!weights_.empty()) plane.power = exact::two_sum(weight(i), -weight(k));
    return plane;
}

void Surface::find_edges() {
    struct Side {
        std::int32_t low, high, triangle, slot;
        auto operator<=>(const Side&) const = default;
    };
    std::vector<Side> sides;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        if (triangles_[t].area == 0) continue;
        for (std::int32_t s = 0; s < 3; ++s) {
            const std::int32_t a = triangles_[t].vertex[at(s)], b = triangles_[t].vertex[at((s + 1) % 3)];
            sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), s});
        }
    }
    check_stop();
    std::ranges::sort(sides);
    for (const Side& side : sides) {
        if (edges_.empty() || edges_.back().low != side.low || edges_.back().high != side.high)
            edges_.push_back({side.low, side.high, side.triangle, 0});
        ++edges_.back().triangles;
        triangles_[at(side.triangle)].edge[at(side.slot)] = static_cast<std::int32_t>(edges_.size()) - 1;
    }
    for (const Edge& edge : edges_)
        if (edge.triangles == 1) triangles_[at(edge.first)].has_border = true;
}

}  // namespace votess::surface
