#include "oracle/integer_domain.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace test {
namespace {

// Exponent of the lowest bit of x; a large one for 0.
int lowest_bit(double x) {
    if (x == 0) return std::numeric_limits<int>::max();
    int exponent = 0;
    auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    exponent -= 53;
    for (; mantissa % 2 == 0; mantissa /= 2) ++exponent;
    return exponent;
}

// x / 2^quantum, which is whole.
mpz_class whole(double x, int quantum) {
    mpz_class result;
    if (x == 0) return result;
    int exponent = 0;
    result = std::ldexp(std::frexp(x, &exponent), 53);
    exponent -= 53 + quantum;
    if (exponent >= 0)
        result <<= static_cast<mp_bitcnt_t>(exponent);
    else
        result >>= static_cast<mp_bitcnt_t>(-exponent);
    return result;
}

Integers whole(const double* x, int quantum) {
    return {whole(x[0], quantum), whole(x[1], quantum), whole(x[2], quantum)};
}

// a / b to the nearest whole number.
mpz_class nearest(const mpz_class& a, const mpz_class& b) {
    mpz_class result;
    const mpz_class twice = 2 * a + b, divisor = 2 * b;
    mpz_fdiv_q(result.get_mpz_t(), twice.get_mpz_t(), divisor.get_mpz_t());
    return result;
}

}  // namespace

IntegerDomain::IntegerDomain(std::span<const double> points, const votess::Options& options)
    : has_cell_(options.cell.has_value()) {
    const std::size_t count = points.size() / 3;
    quantum_ = 1 << 20;
    const auto see = [&](double x) { quantum_ = std::min(quantum_, lowest_bit(x)); };
    for (const double x : points) see(x);
    if (has_cell_) {
        for (const auto* v : {&options.cell->origin, &options.cell->a, &options.cell->b, &options.cell->c})
            for (const double x : *v) see(x);
    } else {
        for (std::size_t k = 0; k < 3; ++k) see(options.box->lower[k]), see(options.box->upper[k]);
    }
    for (const double w : options.weights)
        if (w != 0) quantum_ = std::min(quantum_, static_cast<int>(std::floor(lowest_bit(w) / 2.0)));
    if (quantum_ > 2000) quantum_ = 0;

    if (has_cell_) {
        active_ = options.cell->periodic;
        lower_ = whole(options.cell->origin.data(), quantum_);
        vector_ = {whole(options.cell->a.data(), quantum_), whole(options.cell->b.data(), quantum_),
                   whole(options.cell->c.data(), quantum_)};
    } else {
        active_ = options.periodic;
        lower_ = whole(options.box->lower.data(), quantum_);
        upper_ = whole(options.box->upper.data(), quantum_);
        for (std::size_t k = 0; k < 3; ++k) vector_[k][k] = upper_[k] - lower_[k];
    }
    for (const votess::Wall& wall : options.walls) {
        // Multiplied by a power of two, which leaves the half-space as it is.
        int low =
            lowest_bit(wall.offset) == std::numeric_limits<int>::max() ? 1 << 20 : lowest_bit(wall.offset) - quantum_;
        for (const double n : wall.normal) low = std::min(low, lowest_bit(n));
        planes_.push_back({whole(wall.normal.data(), low), whole(wall.offset, low + quantum_)});
    }
    reduce();

    place_.resize(count);
    outside_.assign(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        Integers x = whole(&points[3 * i], quantum_);
        if (has_cell_) {
            Integers from, wraps;
            for (std::size_t k = 0; k < 3; ++k) from[k] = x[k] - lower_[k];
            for (std::size_t j = 0; j < 3; ++j) {
                const Integers across = cross(vector_[(j + 1) % 3], vector_[(j + 2) % 3]);
                const mpz_class along = dot(vector_[j], across), at = dot(from, across);
                if (!active_[j]) {
                    const int side = sgn(along);
                    if (sgn(at) * side < 0 || sgn(mpz_class(at - along)) * side > 0) outside_[i] = 1;
                    continue;
                }
                mpz_fdiv_q(wraps[j].get_mpz_t(), at.get_mpz_t(), along.get_mpz_t());
            }
            for (std::size_t j = 0; j < 3; ++j)
                for (std::size_t k = 0; k < 3; ++k) x[k] -= wraps[j] * vector_[j][k];
        } else {
            for (std::size_t k = 0; k < 3; ++k) {
                if (active_[k]) {
                    mpz_class from = x[k] - lower_[k], wraps;
                    mpz_fdiv_q(wraps.get_mpz_t(), from.get_mpz_t(), vector_[k][k].get_mpz_t());
                    x[k] -= wraps * vector_[k][k];
                } else if (x[k] < lower_[k] || x[k] > upper_[k]) {
                    outside_[i] = 1;
                }
            }
        }
        for (const Plane& plane : planes_)
            if (dot(plane.n, x) > plane.h) outside_[i] = 1;
        if (options.outside == votess::Outside::keep) outside_[i] = 0;
        place_[i] = std::move(x);
        weight_.push_back(options.weights.empty() ? mpz_class(0) : whole(options.weights[i], 2 * quantum_));
    }
}

// Greedy reduction: no vector becomes shorter by a sum of others of the lattice.
void IntegerDomain::reduce() {
    short_ = vector_;
    for (std::size_t j = 0; j < 3; ++j) short_shift_[j][j] = active_[j] ? 1 : 0;
    const auto take = [&](std::size_t i, std::size_t j, const mpz_class& times) {
        for (std::size_t k = 0; k < 3; ++k) {
            short_[i][k] -= times * short_[j][k];
            if (active_[i]) short_shift_[i][k] -= times.get_si() * short_shift_[j][k];  // others have no images
        }
    };
    for (bool shorter = has_cell_; shorter;) {
        shorter = false;
        for (std::size_t i = 0; i < 3; ++i) {
            for (const std::size_t j : {(i + 1) % 3, (i + 2) % 3}) {
                if (!active_[j]) continue;
                const mpz_class times = nearest(dot(short_[i], short_[j]), dot(short_[j], short_[j]));
                if (times == 0) continue;
                const mpz_class before = dot(short_[i], short_[i]);
                take(i, j, times);
                if (dot(short_[i], short_[i]) < before) {
                    shorter = true;
                } else {
                    take(i, j, -times);
                }
            }
            const std::size_t u = (i + 1) % 3, v = (i + 2) % 3;
            if (!active_[u] || !active_[v]) continue;
            for (const int a : {-1, 1})
                for (const int b : {-1, 1}) {
                    const mpz_class before = dot(short_[i], short_[i]);
                    take(i, u, a), take(i, v, b);
                    if (dot(short_[i], short_[i]) < before) {
                        shorter = true;
                    } else {
                        take(i, u, -a), take(i, v, -b);
                    }
                }
        }
    }
    // The other vectors stand across the lattice, so coordinates along it are those of the projection on it.
    for (std::size_t j = 0; j < 3; ++j)
        if (!active_[j]) short_[j] = cross(short_[(j + 1) % 3], short_[(j + 2) % 3]);
    for (std::size_t j = 0; j < 3; ++j) {
        short_dual_[j] = cross(short_[(j + 1) % 3], short_[(j + 2) % 3]);
        for (std::size_t k = 0; k < 3 && active_[j]; ++k) rounded_short_[j][k] = short_[j][k].get_d();
    }
    determinant_ = dot(short_[0], short_dual_[0]);
    for (int a = -1; a <= 1; ++a)
        for (int b = -1; b <= 1; ++b)
            for (int c = -1; c <= 1; ++c) {
                const int times[3] = {a, b, c};
                bool used = (a != 0 || b != 0 || c != 0);
                for (std::size_t j = 0; j < 3; ++j) used = used && (times[j] == 0 || active_[j]);
                if (!used) continue;
                std::array<double, 3> v{};
                for (std::size_t k = 0; k < 3; ++k)
                    v[k] = mpz_class(a * short_[0][k] + b * short_[1][k] + c * short_[2][k]).get_d();
                relevant_.push_back(v);
            }
}

std::vector<std::array<int, 3>> IntegerDomain::near_shifts(std::size_t i, std::size_t j) const {
    if (!is_periodic()) return {{0, 0, 0}};
    const Integers d = difference(i, j, {});
    mpz_class begin[3];
    double rest[3]{};
    int reach[3]{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (!active_[k]) continue;
        const mpz_class at = dot(d, short_dual_[k]);
        begin[k] = -nearest(at, determinant_);
        reach[k] = 3;
        mpq_class fraction(at + begin[k] * determinant_, determinant_);
        fraction.canonicalize();
        rest[k] = fraction.get_d();
    }
    std::vector<std::array<int, 3>> shifts;
    for (int a = -reach[0]; a <= reach[0]; ++a)
        for (int b = -reach[1]; b <= reach[1]; ++b)
            for (int c = -reach[2]; c <= reach[2]; ++c) {
                const double f[3] = {rest[0] + a, rest[1] + b, rest[2] + c};
                double x[3], square = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    x[k] = f[0] * rounded_short_[0][k] + f[1] * rounded_short_[1][k] + f[2] * rounded_short_[2][k];
                    square += x[k] * x[k];
                }
                const bool far = std::ranges::any_of(relevant_, [&](const std::array<double, 3>& v) {
                    const double length = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
                    const double slack = 1e-9 * length + 1e-14 * std::sqrt(length * square);
                    return std::abs(x[0] * v[0] + x[1] * v[1] + x[2] * v[2]) > length + slack;
                });
                if (far) continue;
                std::array<int, 3> shift{};
                const mpz_class times[3] = {begin[0] + a, begin[1] + b, begin[2] + c};
                for (std::size_t k = 0; k < 3; ++k)
                    for (std::size_t m = 0; m < 3; ++m)
                        shift[k] += static_cast<int>(times[m].get_si() * short_shift_[m][k]);
                shifts.push_back(shift);
            }
    return shifts;
}

Integers IntegerDomain::difference(std::size_t i, std::size_t j, const std::array<int, 3>& shift) const {
    Integers d;
    for (std::size_t k = 0; k < 3; ++k) {
        d[k] = place_[j][k] - place_[i][k];
        for (std::size_t m = 0; m < 3; ++m)
            if (shift[m] != 0) d[k] += shift[m] * vector_[m][k];
    }
    return d;
}

IntegerPlane IntegerDomain::bisector(std::size_t i, std::size_t j, const std::array<int, 3>& shift) const {
    IntegerPlane plane{difference(i, j, shift), {}, {static_cast<std::int32_t>(j), shift}};
    plane.h = dot(plane.n, plane.n) + weight_[i] - weight_[j];
    for (mpz_class& x : plane.n) x *= 2;
    return plane;
}

std::vector<IntegerPlane> IntegerDomain::walls(std::size_t i) const {
    std::vector<IntegerPlane> all;
    for (std::size_t k = 0; k < 3; ++k) {
        if (active_[k]) continue;
        for (const int sign : {-1, 1}) {
            IntegerPlane wall;
            wall.face.id = -1 - static_cast<std::int32_t>(2 * k) - (sign > 0 ? 1 : 0);
            if (has_cell_) {
                wall.n = cross(vector_[(k + 1) % 3], vector_[(k + 2) % 3]);
                const int outward = sign * sgn(dot(vector_[k], wall.n));
                for (std::size_t m = 0; m < 3; ++m) {
                    wall.n[m] *= outward;
                    wall.h += wall.n[m] * (lower_[m] + (sign > 0 ? vector_[k][m] : mpz_class(0)) - place_[i][m]);
                }
                all.push_back(std::move(wall));
                continue;
            }
            wall.n[k] = sign;
            wall.h = sign * ((sign > 0 ? upper_[k] : lower_[k]) - place_[i][k]);
            all.push_back(std::move(wall));
        }
    }
    for (std::size_t w = 0; w < planes_.size(); ++w)
        all.push_back(
            {planes_[w].n, planes_[w].h - dot(planes_[w].n, place_[i]), {-7 - static_cast<std::int32_t>(w), {}}});
    return all;
}

}  // namespace test
