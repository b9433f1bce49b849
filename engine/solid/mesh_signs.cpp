#include "solid/mesh_signs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/vector3.hpp"
#include "votess/votess.hpp"

namespace votess::solid {
namespace {

constexpr int narrow_bits = 55;  // a determinant of three values then fits six words

using exact::WideInt;

template <int W>
WideInt<6 * (W / 2)> determinant_of(int count, const std::array<std::array<WideInt<W>, 3>, 3>& m) {
    constexpr int out = 6 * (W / 2);
    if (count == 1) return exact::resize<out>(m[0][0]);
    const auto minor = [&](int r, int s, int c, int d) { return m[r][c] * m[s][d] - m[r][d] * m[s][c]; };
    if (count == 2) return exact::resize<out>(minor(0, 1, 0, 1));
    return m[0][0] * minor(1, 2, 1, 2) - m[0][1] * minor(1, 2, 0, 2) + m[0][2] * minor(1, 2, 0, 1);
}

template <int W>
std::array<WideInt<W>, 3> wide_place(const exact::Point& x, int quantum) {
    return {exact::to_wide<W>(x[0], quantum), exact::to_wide<W>(x[1], quantum), exact::to_wide<W>(x[2], quantum)};
}

// Returns minus the value at a place relative to the seed.
template <int W>
WideInt<2 * W> shrinkage(const exact::WideRow<W>& row, const std::array<WideInt<W>, 3>& center) {
    const auto half = dot(row.n, center);
    return row.s - half - half;
}

// Determinant of three rows whose entries have errors, and a bound on its error.
int sure_sign(const std::array<std::array<double, 3>, 3>& m, const std::array<double, 3>& error) {
    std::array<double, 3> size;
    for (int r = 0; r < 3; ++r)
        size[r] = std::max({std::abs(m[r][0]), std::abs(m[r][1]), std::abs(m[r][2])}) + error[r];
    const double det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                       m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                       m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    const double bound = 6.1 * (error[0] * size[1] * size[2] + size[0] * error[1] * size[2] +
                                size[0] * size[1] * error[2] + 8 * unit * size[0] * size[1] * size[2]) +
                         tiny;
    return det > bound ? 1 : det < -bound ? -1 : 0;
}

template <int W>
int cross_sign_in(const exact::Point& u, const exact::Point& v, const exact::Point& w, int y, int z, int quantum) {
    const auto at = [&](const exact::Point& x, int k) {
        return exact::to_wide<W>(x[k], quantum) - exact::to_wide<W>(u[k], quantum);
    };
    return (at(v, y) * at(w, z) - at(v, z) * at(w, y)).sign();
}

}  // namespace

void MeshSigns::add(const exact::Plane& bisector, std::int32_t rank) {
    Bisector b{};
    const auto difference = exact::differences(seed_, bisector).x;
    for (std::size_t k = 0; k < 3; ++k) b.n[k] = difference[k].high;
    const double square = b.n[0] * b.n[0] + b.n[1] * b.n[1] + b.n[2] * b.n[2];
    b.constant = square + bisector.power.high;
    b.size = square + std::abs(bisector.power.high);
    bisectors_.push_back(b);
    sources_.push_back(bisector);
    ranks_.push_back(rank);
}

void MeshSigns::find_sign(std::size_t k, const Place& u, Value& value) const {
    if (value.sign != 0) return;
    const int sign = exact_sign(1, {k, 0, 0}, {&u.x, nullptr, nullptr}, false);
    value.tie = sign == 2;
    value.sign = sign;
    if (!value.tie) return;
    value.s = value.error = 0;
    value.sign = rank_ < 0 ? sign_of_step(k) : ranks_[k] < rank_ ? 1 : -1;
    if (value.sign != 0) return;
    const std::array<double, 3>& n = bisectors_[k].n;
    std::size_t axis = 0;
    while (axis < 2 && n[axis] == 0) ++axis;
    value.sign = n[axis] > 0 ? 1 : -1;
}

int MeshSigns::edge_side(std::size_t f, std::size_t a, const Place& at_a, const Place& at_b, const Value& fa,
                         const Value& fb, const Value& aa, const Value& ab) const {
    const double left = fa.s * ab.s, right = fb.s * aa.s, det = left - right;
    const double f_size = std::max(std::abs(fa.s), std::abs(fb.s)), a_size = std::max(std::abs(aa.s), std::abs(ab.s));
    const double f_error = std::max(fa.error, fb.error), a_error = std::max(aa.error, ab.error);
    const double bound =
        2.1 * (f_error * (a_size + a_error) + f_size * a_error) + 4 * unit * (std::abs(left) + std::abs(right)) + tiny;
    const int sign = det > bound ? 1 : det < -bound ? -1 : exact_sign(2, {f, a, 0}, {&at_a.x, &at_b.x, nullptr}, false);
    return ab.sign * sign;
}

int MeshSigns::determinant(const std::array<std::size_t, 3>& k, const Places& u, const Values& a, const Values& b,
                           const Values& c) const {
    std::array<std::array<double, 3>, 3> m;
    std::array<double, 3> error{};
    const std::array<const Values*, 3> rows{&a, &b, &c};
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t i = 0; i < 3; ++i) {
            m[r][i] = (*rows[r])[i].s;
            error[r] = std::max(error[r], (*rows[r])[i].error);
        }
    const int sign = sure_sign(m, error);
    return sign != 0 ? sign : exact_sign(3, k, {&u[0].x, &u[1].x, &u[2].x}, false);
}

int MeshSigns::upright_determinant(const std::array<std::size_t, 3>& k, const Place& u, const Place& v) const {
    std::array<std::array<double, 3>, 3> m;
    std::array<double, 3> error{};
    for (std::size_t r = 0; r < 3; ++r) {
        const Value at_u = value(k[r], u), at_v = value(k[r], v);
        const double z = bisectors_[k[r]].n[2];
        m[r] = {at_u.s, at_v.s, z};
        error[r] = std::max({at_u.error, at_v.error, 2 * unit * std::abs(z)});
    }
    const int sign = sure_sign(m, error);
    return sign != 0 ? sign : exact_sign(3, k, {&u.x, &v.x, nullptr}, true);
}

exact::BitRange MeshSigns::range_of(std::span<const std::size_t> rows) const {
    exact::BitRange range;
    range.add(seed_);
    range.add(image_);
    range.add(center_);
    for (const std::size_t k : rows) range.add(sources_[k]);
    return range;
}

bool MeshSigns::holds(const exact::Point& center) const {
    for (std::size_t k = 0; k < bisectors_.size(); ++k)
        if (value(k, {{}, center}).sign >= 0) return false;
    return true;
}

void MeshSigns::find_center(const exact::Point& middle) {
    for (const exact::Point& center : {exact::Point{}, middle})
        if (holds(center)) {
            center_ = center;
            return;
        }
    centered_ = false;
}

// Returns the sign of -s_k(center).
int MeshSigns::sign_of_step(std::size_t k) const {
    if (centered_) return 1;
    const std::array<std::size_t, 1> row{k};
    return exact::wide_row<exact::widest>(seed_, sources_[k], range_of(row).quantum()).s.sign();
}

// Returns 2 for one value that is exactly 0.
int MeshSigns::exact_sign(int count, const std::array<std::size_t, 3>& rows,
                          const std::array<const exact::Point*, 3>& columns, bool upright) const {
    exact::BitRange range = range_of(std::span(rows).first(static_cast<std::size_t>(count)));
    for (int r = 0; r < count; ++r)
        if (columns[r] != nullptr) range.add(*columns[r]);
    const int span = range.span(), quantum = range.quantum();
    if (span <= narrow_bits) return integer_sign<1>(count, rows, columns, upright, quantum);
    if (span <= exact::middle_bits - 10) return integer_sign<exact::middle>(count, rows, columns, upright, quantum);
    return integer_sign<exact::widest>(count, rows, columns, upright, quantum);
}

template <int W>
int MeshSigns::integer_sign(int count, const std::array<std::size_t, 3>& rows,
                            const std::array<const exact::Point*, 3>& columns, bool upright, int quantum) const {
    std::array<std::array<WideInt<2 * W>, 3>, 3> value;
    std::array<std::array<WideInt<W>, 3>, 3> n;
    std::array<std::array<WideInt<W>, 3>, 3> to_seed;  // from each column
    std::array<WideInt<2 * W>, 3> shrunk;              // -s_k(center)
    const auto center = wide_place<W>(center_, quantum);
    const int moving = count - (upright ? 1 : 0);  // columns that ties move
    for (int c = 0; c < moving; ++c) to_seed[c] = exact::wide_difference<W>(*columns[c], image_, quantum);
    for (int r = 0; r < count; ++r) {
        const auto row = exact::wide_row<W>(seed_, sources_[rows[r]], quantum);
        n[r] = row.n;
        shrunk[r] = shrinkage(row, center);
        for (int c = 0; c < moving; ++c) {
            const auto half = dot(n[r], to_seed[c]);
            value[r][c] = -(half + half) - row.s;
        }
        if (upright) value[r][count - 1] = exact::resize<2 * W>(n[r][2]);
    }
    if (const int sign = determinant_of<2 * W>(count, value).sign(); sign != 0) return sign;
    ++ties_;
    if (count == 1) return 2;
    // step: by which the values of each row grow.
    const auto sign_after = [&](const std::array<WideInt<2 * W>, 3>& step) {
        WideInt<6 * W> sum{};
        for (int c = 0; c < moving; ++c) {
            auto moved = value;
            for (int r = 0; r < count; ++r) moved[r][c] = step[r];
            sum = sum + determinant_of<2 * W>(count, moved);
        }
        return sum.sign();
    };
    if (rank_ >= 0) return rank_sign<2 * W>(count, rows, sign_after);
    if (const int sign = sign_after(shrunk); sign != 0) return sign;
    for (int axis = 0; axis < 3; ++axis) {
        std::array<WideInt<2 * W>, 3> step;
        for (int r = 0; r < count; ++r) step[r] = exact::resize<2 * W>(n[r][axis]);
        if (const int sign = sign_after(step); sign != 0) return sign;
    }
    return -1;  // of planes that share a line, and do not all have faces
}

template <int W, class SignAfter>
int MeshSigns::rank_sign(int count, const std::array<std::size_t, 3>& rows, SignAfter sign_after) const {
    for (std::int32_t last = -1, next = rank_;; last = next) {
        next = rank_ > last ? rank_ : std::numeric_limits<std::int32_t>::max();  // the lowest above the last
        for (int r = 0; r < count; ++r)
            if (ranks_[rows[r]] > last) next = std::min(next, ranks_[rows[r]]);
        if (next == std::numeric_limits<std::int32_t>::max()) break;
        std::array<WideInt<W>, 3> step;
        for (int r = 0; r < count; ++r)
            step[r] = exact::from_int128<W>((ranks_[rows[r]] == next ? 1 : 0) - (rank_ == next ? 1 : 0));
        if (const int sign = sign_after(step); sign != 0) return sign;
    }
    throw Error(ErrorCode::internal, "ranks do not decide a tie");
}

int MeshSigns::crossing_order(std::size_t a, std::size_t b, const Places& u, const Places& v) const {
    const std::array<std::size_t, 2> rows{a, b};
    exact::BitRange range = range_of(rows);
    for (const Places* places : {&u, &v})
        for (const Place& place : *places) range.add(place.x);
    const int span = range.span(), quantum = range.quantum();
    if (span <= narrow_bits) return integer_order<1>(rows, {&u, &v}, quantum);
    if (span <= exact::middle_bits - 10) return integer_order<exact::middle>(rows, {&u, &v}, quantum);
    return integer_order<exact::widest>(rows, {&u, &v}, quantum);
}

// The line meets a triangle where the weights of its vertices are the cross product of its two rows of values, over
// their sum D. A shift of the mesh leaves D as it is.
template <int W>
int MeshSigns::integer_order(const std::array<std::size_t, 2>& rows, const std::array<const Places*, 2>& u,
                             int quantum) const {
    std::array<std::array<WideInt<W>, 3>, 2> n;
    std::array<WideInt<2 * W>, 2> constant, shrunk;
    const auto center = wide_place<W>(center_, quantum);
    for (std::size_t r = 0; r < 2; ++r) {
        const auto row = exact::wide_row<W>(seed_, sources_[rows[r]], quantum);
        n[r] = row.n;
        constant[r] = row.s;
        shrunk[r] = shrinkage(row, center);
    }
    const auto across = cross(n[0], n[1]);
    std::size_t axis = 0;
    while (axis < 2 && across[axis].zero()) ++axis;
    const auto sum = [](const auto& x) { return x[0] + x[1] + x[2]; };
    std::array<WideInt<4 * W>, 2> d;
    std::array<WideInt<5 * W>, 2> place;                 // along the axis, times d
    std::array<WideInt<5 * W>, 2> shrinking;             // derivative of that, if the cell shrinks
    std::array<std::array<WideInt<5 * W>, 3>, 2> moved;  // by a shift along each axis
    for (std::size_t t = 0; t < 2; ++t) {
        std::array<std::array<WideInt<2 * W>, 3>, 2> s;
        std::array<WideInt<W>, 3> x;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto to_seed = exact::wide_difference<W>((*u[t])[i].x, image_, quantum);
            x[i] = -to_seed[axis];
            for (std::size_t r = 0; r < 2; ++r) {
                const auto half = dot(n[r], to_seed);
                s[r][i] = -(half + half) - constant[r];
            }
        }
        const auto at = [&](const std::array<WideInt<4 * W>, 3>& weights) {
            return weights[0] * x[0] + weights[1] * x[1] + weights[2] * x[2];
        };
        const auto weights = cross(s[0], s[1]);
        d[t] = sum(weights);
        place[t] = at(weights);
        const auto change = [&](const WideInt<2 * W>& of_a, const WideInt<2 * W>& of_b) {
            std::array<WideInt<2 * W>, 3> by_a, by_b;
            by_a.fill(of_a);
            by_b.fill(of_b);
            const auto one = cross(by_a, s[1]), other = cross(s[0], by_b);
            return at({one[0] + other[0], one[1] + other[1], one[2] + other[2]});
        };
        shrinking[t] = change(shrunk[0], shrunk[1]);
        for (std::size_t k = 0; k < 3; ++k) {
            moved[t][k] = change(exact::resize<2 * W>(n[0][k] + n[0][k]), exact::resize<2 * W>(n[1][k] + n[1][k]));
            if (k == axis) moved[t][k] = moved[t][k] + exact::resize<5 * W>(d[t]);
        }
    }
    const int turn = across[axis].sign() * d[0].sign() * d[1].sign();
    const auto order = [&](const WideInt<5 * W>& first, const WideInt<5 * W>& second) {
        return turn * (first * d[1] - second * d[0]).sign();
    };
    if (const int sign = order(place[0], place[1]); sign != 0) return sign;
    if (const int sign = order(shrinking[0], shrinking[1]); sign != 0) return sign;
    for (std::size_t k = 0; k < 3; ++k)
        if (const int sign = order(moved[0][k], moved[1][k]); sign != 0) return sign;
    return 0;
}

int cross_sign(const exact::Point& u, const exact::Point& v, const exact::Point& w, int axis) {
    const int y = (axis + 1) % 3, z = (axis + 2) % 3;
    const double left = (v[y] - u[y]) * (w[z] - u[z]), right = (v[z] - u[z]) * (w[y] - u[y]);
    const double bound = 5 * unit * (std::abs(left) + std::abs(right)) + tiny;
    if (std::abs(left - right) > bound) return left > right ? 1 : -1;
    exact::BitRange range;
    for (const exact::Point* x : {&u, &v, &w}) range.add((*x)[y]), range.add((*x)[z]);
    const int quantum = range.quantum();
    if (range.span() <= exact::middle_bits) return cross_sign_in<exact::middle>(u, v, w, y, z, quantum);
    return cross_sign_in<exact::widest>(u, v, w, y, z, quantum);
}

}  // namespace votess::solid
