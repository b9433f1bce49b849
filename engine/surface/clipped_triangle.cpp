#include "surface/clipped_triangle.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "core/arithmetic.hpp"
#include "core/box.hpp"
#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"

namespace votess::surface {
namespace {

using solid::unit;

constexpr double search_rounding = 0x1p-46;  // of squares of lengths, and weights

double length(const Vector3& x) {
    return std::sqrt(dot(x, x));
}

// Error of a value, from the sizes of its terms: each is rounded at most seven times.
constexpr double value_rounding = 8 * unit;

}  // namespace

void ClippedTriangle::set_triangle(std::int32_t triangle) {
    triangle_ = &surface_.triangles()[at(triangle)];
    longest_ = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        places_[i].x = surface_.vertex(triangle_->vertex[i]);
        longest_ = std::max(longest_, length(minus(surface_.vertex(triangle_->vertex[(i + 1) % 3]), places_[i].x)));
    }
    longest_ *= 1 + 0x1p-40;
}

void ClippedTriangle::set_seed(std::uint32_t number) {
    number_ = number;
    seed_ = tree_.seed(number);
    origin_ = tree_.place(number);
    bisectors_.clear();
    double farthest = 0;
    for (auto& place : places_) {
        place.relative = minus(place.x, origin_);
        farthest = std::max(farthest, dot(place.relative, place.relative));
    }
    rounding_ = 16 * unit * (std::sqrt(farthest) + 1);  // of the absolute place too
}

bool ClippedTriangle::clip(std::uint32_t number) {
    const std::size_t ties = signs_.ties();
    set_seed(number);
    lengthless_.clear();
    size_ = 3;
    if (polygon_.size() < 3) polygon_.resize(16), next_.resize(16);
    for (std::size_t i = 0; i < 3; ++i)
        polygon_[i] = {
            -1 - static_cast<Side>(i), places_[i].relative, rounding_, {i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0}, 0};
    find_radius();
    const NearSeeds::List near = near_.of(number);
    bool is_done = false;
    double reach = 4 * (1 + NearSeeds::order_rounding) * radius_ * radius_;
    for (const std::uint32_t other : near.numbers) {
        const Vector3 q = minus(tree_.place(other), origin_);
        const double square = dot(q, q);
        if (!surface_.has_weights() && square > reach) {
            is_done = true;
            break;
        }
        const double radius = radius_;
        if (!try_seed(other, q, square)) return false;
        if (radius_ != radius) reach = 4 * (1 + NearSeeds::order_rounding) * radius_ * radius_;
    }
    searched_ = surface_.has_weights() ? 0 : 0.5 * std::sqrt(near.complete);
    const bool is_complete = is_done || near.numbers.size() + 1 == tree_.size() || radius_ < searched_;
    if (!is_complete && !search_tree()) return false;
    is_tied_ = signs_.ties() != ties;
    return true;
}

// Tries all seeds within reach of corners that near seeds do not cover.
bool ClippedTriangle::search_tree() {
    bool is_empty = false;
    const std::uint32_t own = number_;
    find_balls();
    std::size_t clips = clips_;
    const auto skip = [&](const SeedTree::Node& node) {
        if (clips_ != clips) find_balls();
        clips = clips_;
        return is_empty || !in_reach(node);
    };
    tree_.visit_from(origin_, reach_, skip, [&](std::uint32_t number) {
        if (is_empty || number == own || std::ranges::find(bisectors_, number, &Bisector::number) != bisectors_.end())
            return;
        const Vector3 q = minus(tree_.place(number), origin_);
        is_empty = !try_seed(number, q, dot(q, q));
    });
    return !is_empty;
}

void ClippedTriangle::find_balls() {
    balls_.clear();
    farthest_ = 0;
    for (std::size_t i = 0; i < size_; ++i) {
        const Corner& c = polygon_[i];
        const double distance = length(c.x) * (1 + 4 * unit) + c.error;
        if (distance < searched_) continue;
        balls_.push_back({{origin_[0] + c.x[0], origin_[1] + c.x[1], origin_[2] + c.x[2]}, distance, c.error});
        farthest_ = std::max(farthest_, distance);
    }
    const double reach = farthest_ + radius_to(farthest_, tree_.root()) + error_;
    reach_ = reach * reach * (1 + 4 * search_rounding);
}

// Returns a bound on the distance from a corner up to which seeds in a box may be nearer to it than its own seed, which
// has a distance of at most `radius`; or -1.
double ClippedTriangle::radius_to(double radius, const SeedTree::Node& node) const {
    if (!surface_.has_weights()) return radius;
    const double own = surface_.weight(seed_), largest = tree_.weight(node), square = radius * radius;
    const double power = square - own + largest + search_rounding * (square + std::abs(own) + std::abs(largest));
    return power < 0 ? -1 : std::sqrt(power);
}

// Returns whether any seed in a box may be nearer to a corner than its own seed is, or as near.
bool ClippedTriangle::in_reach(const SeedTree::Node& node) const {
    const double most = radius_to(farthest_, node), reach = farthest_ + most + error_;
    if (most < 0 || node.square > reach * reach * (1 + 4 * search_rounding)) return false;
    const Box box = tree_.box(node);
    for (const Ball& ball : balls_) {
        double radius = radius_to(ball.radius, node);
        if (radius < 0) continue;
        radius += ball.error;
        if (distance_squared(ball.center, box) <= radius * radius * (1 + search_rounding)) return true;
    }
    return false;
}

// Clips by the bisector with a seed, at a place relative to its own. Returns whether any part is left.
bool ClippedTriangle::try_seed(std::uint32_t number, const Vector3& q, double square) {
    const double norm = std::abs(q[0]) + std::abs(q[1]) + std::abs(q[2]);
    double constant = square, slack = search_rounding * norm * (radius_ + norm);
    if (surface_.has_weights()) {
        const double own = surface_.weight(seed_), other = surface_.weight(tree_.seed(number));
        constant -= other - own;
        slack += search_rounding * (std::abs(own) + std::abs(other));
    }
    const double bound = 2 * norm * error_ + slack;
    const double q0 = q[0], q1 = q[1], q2 = q[2];
    const double* x = lanes_.data();
    std::array<double, lanes> largest, value;
    largest.fill(-infinity);
    for (std::size_t i = 0; i < size_; i += lanes, x += 3 * lanes) {
        for (std::size_t j = 0; j < lanes; ++j)
            value[j] = 2 * (q0 * x[j] + q1 * x[lanes + j] + q2 * x[2 * lanes + j]) - constant;
        for (std::size_t j = 0; j < lanes; ++j) largest[j] = value[j] > largest[j] ? value[j] : largest[j];
        std::copy(value.begin(), value.end(), &values_[i]);
    }
    if (std::max(std::max(largest[0], largest[1]), std::max(largest[2], largest[3])) < -bound) return true;
    add_bisector(number, q, square);
    const auto b = static_cast<Side>(bisectors_.size() - 1);
    std::size_t outside = 0;
    for (std::size_t i = 0; i < size_; ++i) {
        double& value = values_[i];
        if (std::abs(value) <= bound) {
            const double own_bound = 2 * norm * polygon_[i].error + slack;
            if (!(std::abs(value) > own_bound)) value = sign_at(before(i), polygon_[i].out, b);
        }
        outside += value > 0 ? 1 : 0;
    }
    if (outside == 0) {
        bisectors_.pop_back();
        return true;
    }
    if (outside == size_) return false;
    clip_by(b);
    return true;
}

void ClippedTriangle::add_bisector(std::uint32_t number, const Vector3& q, double square) {
    Bisector& b = bisectors_.emplace_back();
    b.seed = tree_.seed(number);
    b.number = number;
    double constant = square, size = square;
    if (surface_.has_weights()) {
        const double power = surface_.weight(seed_) - surface_.weight(b.seed);
        constant += power;
        size += std::abs(power);
    }
    b.largest = b.error = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3& r = places_[i].relative;
        const double x = q[0] * r[0], y = q[1] * r[1], z = q[2] * r[2];
        const double error = value_rounding * (2 * (std::abs(x) + std::abs(y) + std::abs(z)) + size) + solid::tiny;
        const double s = 2 * (x + y + z) - constant;
        b.values[i] = {s, error, s > error ? 1 : s < -error ? -1 : 0, false};
        if (b.values[i].sign == 0) {
            set_signs({static_cast<Side>(bisectors_.size() - 1)});
            signs_.find_sign(0, places_[i], b.values[i]);
        }
        b.largest = std::max(b.largest, std::abs(b.values[i].s));
        b.error = std::max(b.error, b.values[i].error);
    }
}

// Makes signs_ hold some bisectors.
void ClippedTriangle::set_signs(std::initializer_list<Side> bisectors) {
    signs_.begin(origin_, exact::Plane::bisector(origin_), seed_);
    for (const Side b : bisectors) {
        const std::int32_t id = bisectors_[at(b)].seed;
        signs_.add(surface_.bisector(seed_, id), id);
    }
}

// Clips off the corners with a positive value of a bisector.
void ClippedTriangle::clip_by(Side b) {
    if (next_.size() < 2 * size_) next_.resize(4 * size_);
    std::size_t count = 0;
    bool from = values_[0] > 0;
    for (std::size_t i = 0; i < size_; ++i) {
        const std::size_t next = i + 1 == size_ ? 0 : i + 1;
        const bool to = values_[next] > 0;
        if (!from) {
            next_[count++] = polygon_[i];
            if (to) set_corner(next_[count++], polygon_[i].out, b);
        } else if (!to) {
            set_corner(next_[count++], b, polygon_[i].out);
        }
        from = to;
    }
    std::swap(polygon_, next_);
    size_ = count;
    ++clips_;
    find_radius();
}

// Finds the largest distance of a corner, and lists the places of all.
void ClippedTriangle::find_radius() {
    double square = 0, error = 0;
    const std::size_t padded = (size_ + lanes - 1) / lanes * lanes;
    if (values_.size() < padded) {
        values_.resize(2 * padded);
        lanes_.resize(3 * values_.size());
    }
    const auto set = [&](std::size_t i, const Vector3& x) {
        double* const to = &lanes_[3 * (i - i % lanes) + i % lanes];
        to[0] = x[0];
        to[lanes] = x[1];
        to[2 * lanes] = x[2];
    };
    for (std::size_t i = size_; i < padded; ++i) set(i, polygon_[0].x);
    for (std::size_t i = 0; i < size_; ++i) {
        const Corner& c = polygon_[i];
        set(i, c.x);
        const double own = dot(c.x, c.x);
        square = own > square ? own : square;
        error = c.error > error ? c.error : error;
    }
    error_ = error;
    radius_ = std::sqrt(square) * (1 + 8 * unit) + error;
}

// Returns +1 if the corner between two sides lies outside of a bisector, else -1.
int ClippedTriangle::sign_at(Side in, Side out, Side b) {
    const solid::MeshSigns::Values& f = bisectors_[at(b)].values;
    if (in < 0 && out < 0) return f[corner_of(out)].sign;
    if (in < 0 || out < 0) {
        const std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3;
        if (f[from].sign == f[to].sign) return f[from].sign;
        const solid::MeshSigns::Values& a = bisectors_[at(std::max(in, out))].values;
        set_signs({b, std::max(in, out)});
        return signs_.edge_side(0, 1, places_[from], places_[to], f[from], f[to], a[from], a[to]);
    }
    set_signs({in, out, b});
    return signs_.determinant({0, 1, 2}, places_, bisectors_[at(in)].values, bisectors_[at(out)].values, f);
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
        const solid::MeshSigns::Values& a = bisectors_[at(std::max(in, out))].values;
        const double across = a[from].s - a[to].s, share = a[from].s / across;
        const double error = a[from].error + a[to].error, sure = std::abs(across) - error;
        Weights w{{}, sure > 0 ? 2 * error / sure + 4 * unit : infinity};
        w.of[from] = 1 - share;
        w.of[to] = share;
        return w;
    }
    // In one order for all cells that share the corner.
    const bool turned = bisectors_[at(in)].seed > bisectors_[at(out)].seed;
    const Bisector &a = bisectors_[at(turned ? out : in)], &b = bisectors_[at(turned ? in : out)];
    const Vector3 of = cross(Vector3{a.values[0].s, a.values[1].s, a.values[2].s},
                             Vector3{b.values[0].s, b.values[1].s, b.values[2].s});
    const double error =
        2 * (a.largest * b.error + a.error * b.largest + a.error * b.error) + 4 * unit * a.largest * b.largest;
    const double sum = of[0] + of[1] + of[2], sure = std::abs(sum) - 3 * error;
    const double inverse = 1 / sum;
    return {{of[0] * inverse, of[1] * inverse, of[2] * inverse}, sure > 0 ? 4 * error / sure + 8 * unit : infinity};
}

ClippedTriangle::Weights ClippedTriangle::exact_weights(Side in, Side out) const {
    exact::BitRange range;
    range.add(surface_.seed(seed_));
    for (const auto& place : places_) range.add(place.x);
    std::vector<std::int32_t> ids;
    for (const Side side : {in, out})
        if (side >= 0) ids.push_back(bisectors_[at(side)].seed);
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

void ClippedTriangle::set_corner(Corner& corner, Side in, Side out) const {
    corner.out = out;
    set_weights(corner, weights(in, out));
}

void ClippedTriangle::set_weights(Corner& corner, const Weights& weights) const {
    corner.weights = {weights.of[1], weights.of[2]};
    corner.weight_error = weights.error;
    double error = 3 * weights.error * longest_;
    const std::array<double, 3>* of = &weights.of;
    static constexpr std::array<double, 3> first{1, 0, 0};
    if (!(error < longest_)) of = &first, error = longest_;  // somewhere in the triangle
    for (std::size_t k = 0; k < 3; ++k)
        corner.x[k] =
            (*of)[0] * places_[0].relative[k] + (*of)[1] * places_[1].relative[k] + (*of)[2] * places_[2].relative[k];
    corner.error = error + rounding_;
}

void ClippedTriangle::settle() {
    for (std::size_t i = 0; i < size_; ++i) {
        Corner& c = polygon_[i];
        if (!is_accurate(c.weight_error, longest_, length(c.x))) set_weights(c, exact_weights(before(i), c.out));
    }
}

std::array<double, 2> ClippedTriangle::corner(std::uint32_t number, Side in, Side out) {
    set_seed(number);
    for (Side* side : {&in, &out}) {
        if (*side < 0) continue;
        const auto other = static_cast<std::uint32_t>(*side);
        const Vector3 q = minus(tree_.place(other), origin_);
        add_bisector(other, q, dot(q, q));
        *side = static_cast<Side>(bisectors_.size() - 1);
    }
    Corner c;
    set_corner(c, in, out);
    if (!is_accurate(c.weight_error, longest_, length(c.x))) set_weights(c, exact_weights(in, out));
    return c.weights;
}

void ClippedTriangle::find_ties() {
    has_area_ = true;
    if (!is_tied_) return;
    const std::size_t size = size_;
    const auto side_from = [&](std::size_t i) { return polygon_[i].out; };
    const auto values_of = [&](Side b) -> const solid::MeshSigns::Values& { return bisectors_[at(b)].values; };
    const auto is_on = [&](std::size_t i, Side bisector) {
        const Side in = before(i), out = side_from(i);
        const solid::MeshSigns::Values& f = values_of(bisector);
        if (in == bisector || out == bisector) return true;
        if (in < 0 && out < 0) return f[corner_of(out)].tie;
        if (in < 0 || out < 0) {
            const std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3;
            if (f[from].tie && f[to].tie) return true;
        }
        const std::size_t ties = signs_.ties();
        if (in >= 0 && out >= 0) {
            set_signs({in, out, bisector});
            (void)signs_.determinant({0, 1, 2}, places_, values_of(in), values_of(out), f);
        } else {
            const std::size_t from = corner_of(std::min(in, out)), to = (from + 1) % 3;
            const solid::MeshSigns::Values& a = values_of(std::max(in, out));
            set_signs({bisector, std::max(in, out)});
            (void)signs_.edge_side(0, 1, places_[from], places_[to], f[from], f[to], a[from], a[to]);
        }
        return signs_.ties() != ties;
    };
    lengthless_.assign(size, 0);
    Side first = -1;  // a bisector with a side that has a length
    std::size_t lengths = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t next = i + 1 == size ? 0 : i + 1;
        bool is_point = false;
        if (side_from(next) >= 0) {
            is_point = is_on(i, side_from(next));
        } else if (before(i) >= 0) {
            is_point = is_on(next, before(i));
        } else if (side_from(i) >= 0) {  // between two edges, of which one begins where the other ends
            const std::size_t a = corner_of(before(i)), b = corner_of(side_from(next));
            is_point = values_of(side_from(i))[(a + 1) % 3 == b ? b : a].tie;
        }
        lengthless_[i] = is_point ? 1 : 0;
        if (is_point) continue;
        ++lengths;
        if (first < 0) first = side_from(i);
    }
    has_area_ = lengths >= 2;
    if (!has_area_ || first < 0) return;
    has_area_ = false;
    for (std::size_t i = 0; i < size; ++i) has_area_ |= !is_on(i, first);
}

}  // namespace votess::surface
