#include "surface/clipped_triangle.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "core/arithmetic.hpp"
#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"

namespace votess::surface {
namespace {

using solid::unit;

constexpr double place_rounding = 0x1p-43;  // of the size of the triangle and the distance of its seed
constexpr double weight_rounding = 0x1p-36;
constexpr double search_rounding = 0x1p-46;  // of squares of lengths, and weights

double length(const Vector3& x) {
    return std::sqrt(dot(x, x));
}

double largest(const solid::MeshSigns::Values& values) {
    return std::max({std::abs(values[0].s), std::abs(values[1].s), std::abs(values[2].s)});
}

double error_of(const solid::MeshSigns::Values& values) {
    return std::max({values[0].error, values[1].error, values[2].error});
}

}  // namespace

bool ClippedTriangle::clip(std::int32_t triangle, std::int32_t seed, std::span<const std::int32_t> near) {
    triangle_ = &surface_.triangles()[at(triangle)];
    seed_ = seed;
    const exact::Point& origin = surface_.seed(seed);
    const std::size_t ties = signs_.ties();
    signs_.begin(origin, exact::Plane::bisector(origin), seed);
    ids_.clear();
    values_.clear();
    for (std::size_t i = 0; i < 3; ++i) places_[i] = signs_.place(surface_.vertex(triangle_->vertex[i]));
    size_ = 0;
    for (std::size_t i = 0; i < 3; ++i)
        size_ = std::max(size_, length(minus(places_[(i + 1) % 3].relative, places_[i].relative)) * (1 + 8 * unit));
    sides_ = {-1, -2, -3};
    corners_.clear();
    for (std::size_t i = 0; i < 3; ++i) corners_.push_back(corner(before(i), sides_[i]));
    lengthless_.clear();
    bool is_done = near.size() + 1 == surface_.tree().size();
    for (const std::int32_t id : near) {
        if (!surface_.has_weights()) {
            double radius = 0;
            for (const Corner& c : corners_) radius = std::max(radius, c.radius);
            const Vector3 q = minus(surface_.seed(id), origin);
            if (dot(q, q) > 4 * (1 + search_rounding) * radius * radius) {
                is_done = true;
                break;
            }
        }
        if (in_reach(id) && !try_seed(id)) return false;
    }
    bool is_empty = false;
    if (!is_done) {
        const auto skip = [&](const SeedTree::Node& node, double) { return is_empty || !in_reach(node); };
        surface_.tree().visit_from(origin, skip, [&](std::int32_t id, const exact::Point&) {
            if (is_empty || id == seed || !in_reach(id) || std::ranges::find(ids_, id) != ids_.end()) return;
            is_empty = !try_seed(id);
        });
    }
    is_tied_ = signs_.ties() != ties;
    return !is_empty;
}

// Returns whether the seed may be nearer to a corner than its own seed is, or as near.
bool ClippedTriangle::in_reach(std::int32_t id) const {
    const Vector3 q = minus(surface_.seed(id), surface_.seed(seed_));
    const double square = dot(q, q), own = surface_.weight(seed_), other = surface_.weight(id);
    for (const Corner& c : corners_) {
        const double s = 2 * dot(q, c.x) - square + (other - own);
        const double size = std::sqrt(square);
        const double error =
            2 * size * c.error + search_rounding * (size * (c.radius + size) + std::abs(own) + std::abs(other));
        if (!(s < -error)) return true;
    }
    return false;
}

// Returns whether any seed in a box may be.
bool ClippedTriangle::in_reach(const SeedTree::Node& node) const {
    const exact::Point& origin = surface_.seed(seed_);
    for (const Corner& c : corners_) {
        const exact::Point x{origin[0] + c.x[0], origin[1] + c.x[1], origin[2] + c.x[2]};
        double reach = c.reach;
        if (surface_.has_weights()) {
            const double own = surface_.weight(seed_);
            const double square = c.radius * c.radius - own + node.weight +
                                  search_rounding * (c.radius * c.radius + std::abs(own) + std::abs(node.weight));
            if (square < 0) continue;
            const double radius = std::sqrt(square) + c.error;
            reach = radius * radius;
        }
        if (SeedTree::square_distance(node, x) <= reach * (1 + search_rounding)) return true;
    }
    return false;
}

// Clips by the bisector with a seed. Returns whether any part is left.
bool ClippedTriangle::try_seed(std::int32_t id) {
    const std::size_t b = ids_.size();
    signs_.add(surface_.bisector(seed_, id), id);
    ids_.push_back(id);
    solid::MeshSigns::Values& values = values_.emplace_back();
    int outside = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        values[i] = signs_.value(b, places_[i]);
        signs_.find_sign(b, places_[i], values[i]);
        outside += values[i].sign > 0 ? 1 : 0;
    }
    return outside == 0 || (outside < 3 && clip_by(b));
}

bool ClippedTriangle::clip_by(std::size_t b) {
    const std::size_t size = sides_.size();
    outside_.resize(size);
    int corners_outside = 0;
    for (std::size_t i = 0; i < size; ++i) {
        outside_[i] = sign_at(before(i), sides_[i], b) > 0 ? 1 : 0;
        corners_outside += outside_[i];
    }
    if (corners_outside == 0) return true;
    if (corners_outside == static_cast<int>(size)) return false;
    const auto cut = static_cast<Side>(b);
    next_sides_.clear();
    next_corners_.clear();
    for (std::size_t i = 0; i < size; ++i) {
        const bool from = outside_[i] != 0, to = outside_[i + 1 == size ? 0 : i + 1] != 0;
        if (!from || !to) {
            next_sides_.push_back(sides_[i]);
            next_corners_.push_back(from ? corner(cut, sides_[i]) : corners_[i]);
        }
        if (!from && to) {
            next_sides_.push_back(cut);
            next_corners_.push_back(corner(sides_[i], cut));
        }
    }
    std::swap(sides_, next_sides_);
    std::swap(corners_, next_corners_);
    return true;
}

// Returns +1 if the corner between two sides lies outside of a bisector, else -1.
int ClippedTriangle::sign_at(Side in, Side out, std::size_t b) const {
    const solid::MeshSigns::Values& f = values_[b];
    if (in < 0 && out < 0) return f[corner_of(out)].sign;
    if (in < 0 || out < 0) {
        const std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3, a = at(std::max(in, out));
        if (f[from].sign == f[to].sign) return f[from].sign;
        return signs_.edge_side(b, a, places_[from], places_[to], f[from], f[to], values_[a][from], values_[a][to]);
    }
    const std::size_t a = at(in), c = at(out);
    return signs_.determinant({a, c, b}, places_, values_[a], values_[c], f);
}

// Values are linear in the triangle, so a corner on bisectors a and b has the weights a x b, over their sum.
ClippedTriangle::Weights ClippedTriangle::weights(Side in, Side out) const {
    if (in < 0 && out < 0) {
        Weights w{{}, 0};
        w.of[corner_of(out)] = 1;
        return w;
    }
    if (in < 0 || out < 0) {
        std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3;
        if (triangle_->vertex[from] > triangle_->vertex[to]) std::swap(from, to);
        const solid::MeshSigns::Values& a = values_[at(std::max(in, out))];
        const double across = a[from].s - a[to].s, share = a[from].s / across;
        const double error = a[from].error + a[to].error, sure = std::abs(across) - error;
        Weights w{{}, sure > 0 ? 2 * error / sure + 4 * unit : infinity};
        w.of[from] = 1 - share;
        w.of[to] = share;
        return w;
    }
    // In one order for all cells that share the corner.
    const bool turned = ids_[at(in)] > ids_[at(out)];
    const solid::MeshSigns::Values &a = values_[at(turned ? out : in)], &b = values_[at(turned ? in : out)];
    const Vector3 of = cross(Vector3{a[0].s, a[1].s, a[2].s}, Vector3{b[0].s, b[1].s, b[2].s});
    const double a_size = largest(a), b_size = largest(b), a_error = error_of(a), b_error = error_of(b);
    const double error = 2 * (a_size * b_error + a_error * b_size + a_error * b_error) + 4 * unit * a_size * b_size;
    const double sum = of[0] + of[1] + of[2], sure = std::abs(sum) - 3 * error;
    return {{of[0] / sum, of[1] / sum, of[2] / sum}, sure > 0 ? 4 * error / sure + 4 * unit : infinity};
}

ClippedTriangle::Weights ClippedTriangle::exact_weights(Side in, Side out) const {
    exact::BitRange range;
    range.add(surface_.seed(seed_));
    for (const auto& place : places_) range.add(place.x);
    std::vector<std::int32_t> ids;
    for (const Side side : {in, out})
        if (side >= 0) ids.push_back(ids_[at(side)]);
    std::ranges::sort(ids);
    for (const std::int32_t id : ids) range.add(surface_.bisector(seed_, id));
    std::array<exact::BigInt, 3> of;
    const auto a = exact_values(ids[0], range);
    if (ids.size() == 2) {
        of = cross(a, exact_values(ids[1], range));
    } else {
        const std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3;
        of[from] = -a[to];
        of[to] = a[from];
    }
    const auto sum = static_cast<exact::Quad>(of[0] + of[1] + of[2]);
    Weights w{{}, unit};
    for (std::size_t i = 0; i < 3; ++i)
        if (of[i].sign() != 0) w.of[i] = static_cast<double>(static_cast<exact::Quad>(of[i]) / sum);
    return w;
}

// Returns the values of the bisector with a seed at the vertices, as integers.
std::array<exact::BigInt, 3> ClippedTriangle::exact_values(std::int32_t id, const exact::BitRange& range) const {
    const auto in_limbs = [&]<int W>(std::integral_constant<int, W>) {
        const exact::Plane origin = exact::Plane::bisector(surface_.seed(seed_));
        const auto row = exact::wide_row<W>(surface_.seed(seed_), surface_.bisector(seed_, id), range.quantum());
        std::array<exact::BigInt, 3> values;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto half = dot(row.n, exact::wide_difference<W>(places_[i].x, origin, range.quantum()));
            values[i] = exact::BigInt(-(half + half) - row.s);
        }
        return values;
    };
    if (range.span() <= exact::middle_bits - 10) return in_limbs(std::integral_constant<int, exact::middle>());
    return in_limbs(std::integral_constant<int, exact::widest>());
}

ClippedTriangle::Corner ClippedTriangle::corner(Side in, Side out) const {
    Weights w = weights(in, out);
    double error = 3 * w.error * size_;
    if (!(error < size_)) {  // somewhere in the triangle
        w.of = {1, 0, 0};
        error = size_;
    }
    Corner c{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k) c.x[k] += w.of[i] * places_[i].relative[k];
    double farthest = 0;
    for (const auto& place : places_) farthest = std::max(farthest, length(place.relative));
    c.error = error + 16 * unit * (farthest + 1);  // of the absolute place too
    c.radius = length(c.x) * (1 + 4 * unit) + c.error;
    const double reach = c.radius + c.error;
    c.reach = reach * reach;
    return c;
}

std::array<double, 2> ClippedTriangle::place(std::size_t i) const {
    const Side in = before(i), out = sides_[i];
    Weights w = weights(in, out);
    const bool is_sure =
        w.error <= weight_rounding && w.error * size_ <= place_rounding * (size_ + length(corners_[i].x));
    if (!is_sure) w = exact_weights(in, out);
    if (in >= 0 && out >= 0) return {w.of[1], w.of[2]};
    std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3;
    if (triangle_->vertex[from] > triangle_->vertex[to]) std::swap(from, to);
    return {w.of[to], 0};
}

void ClippedTriangle::find_ties() {
    has_area_ = true;
    if (!is_tied_) return;
    const std::size_t size = sides_.size();
    const auto is_on = [&](std::size_t i, Side bisector) {
        const Side in = before(i), out = sides_[i];
        const solid::MeshSigns::Values& f = values_[at(bisector)];
        if (in == bisector || out == bisector) return true;
        if (in < 0 && out < 0) return f[corner_of(out)].tie;
        if (in < 0 || out < 0) {
            const std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3;
            if (f[from].tie && f[to].tie) return true;
        }
        const std::size_t ties = signs_.ties();
        if (in >= 0 && out >= 0) {
            (void)signs_.determinant({at(in), at(out), at(bisector)}, places_, values_[at(in)], values_[at(out)], f);
        } else {
            const std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3, a = at(std::max(in, out));
            (void)signs_.edge_side(at(bisector), a, places_[from], places_[to], f[from], f[to], values_[a][from],
                                   values_[a][to]);
        }
        return signs_.ties() != ties;
    };
    lengthless_.assign(size, 0);
    Side first = -1;  // a bisector with a side that has a length
    std::size_t lengths = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t next = i + 1 == size ? 0 : i + 1;
        bool is_point = false;
        if (sides_[next] >= 0) {
            is_point = is_on(i, sides_[next]);
        } else if (before(i) >= 0) {
            is_point = is_on(next, before(i));
        } else if (sides_[i] >= 0) {  // between two edges, of which one begins where the other ends
            const std::size_t a = corner_of(before(i)), b = corner_of(sides_[next]);
            is_point = values_[at(sides_[i])][(a + 1) % 3 == b ? b : a].tie;
        }
        lengthless_[i] = is_point ? 1 : 0;
        if (is_point) continue;
        ++lengths;
        if (first < 0) first = sides_[i];
    }
    has_area_ = lengths >= 2;
    if (!has_area_ || first < 0) return;
    has_area_ = false;
    for (std::size_t i = 0; i < size; ++i) has_area_ |= !is_on(i, first);
}

}  // namespace votess::surface
