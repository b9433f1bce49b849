#include "solid/exact_places.hpp"

#include "core/vector3.hpp"

namespace votess::solid {
namespace {

using exact::BigInt;
using exact::middle;
using exact::widest;

template <int W>
std::array<BigInt, 3> big(const std::array<exact::WideInt<W>, 3>& x) {
    return {BigInt(x[0]), BigInt(x[1]), BigInt(x[2])};
}

ExactPlace positive(ExactPlace place) {
    if (place.w.sign() >= 0) return place;
    for (BigInt& x : place.x) x = -x;
    place.w = -place.w;
    return place;
}

std::array<BigInt, 3> difference(const std::array<BigInt, 3>& a, const std::array<BigInt, 3>& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

}  // namespace

void ExactPlaces::begin(const exact::Point& seed, const exact::Plane& image, const exact::Point& origin) {
    seed_ = seed;
    image_ = image;
    origin_ = origin;
    range_ = {};
    range_.add(seed);
    range_.add(image);
    range_.add(origin);
    planes_.clear();
}

void ExactPlaces::include(const exact::Plane& plane) {
    planes_.push_back(plane);
    range_.add(plane);
}

void ExactPlaces::prepare() {
    quantum_ = range_.quantum();
    rows_.clear();
    const auto add = [&](const auto& row) { rows_.push_back({big(row.n), BigInt(row.s)}); };
    for (const exact::Plane& plane : planes_) {
        if (narrow())
            add(exact::wide_row<middle>(seed_, plane, quantum_));
        else
            add(exact::wide_row<widest>(seed_, plane, quantum_));
    }
    for (std::size_t k = 0; k < 3; ++k) to_origin_[k] = BigInt(exact::to_wide<widest>(origin_[k], quantum_));
}

ExactPlaces::Integers ExactPlaces::relative(const exact::Point& u) const {
    Integers x = narrow() ? big(exact::wide_difference<middle>(u, image_, quantum_))
                          : big(exact::wide_difference<widest>(u, image_, quantum_));
    for (BigInt& coordinate : x) coordinate = -coordinate;
    return x;
}

BigInt ExactPlaces::value(std::size_t k, const Integers& u) const {
    const BigInt half = dot(rows_[k].n, u);
    return half + half - rows_[k].s;
}

ExactPlace ExactPlaces::vertex(const exact::Point& u) const {
    return {difference(relative(u), to_origin_), 1};
}

ExactPlace ExactPlaces::on_edge(std::size_t a, const exact::Point& from, const exact::Point& to) const {
    const Integers u = relative(from), v = relative(to);
    const BigInt at_u = value(a, u), at_v = value(a, v);
    const Integers from_u = difference(u, to_origin_), from_v = difference(v, to_origin_);
    ExactPlace place{{}, at_v - at_u};
    for (std::size_t k = 0; k < 3; ++k) place.x[k] = at_v * from_u[k] - at_u * from_v[k];
    return positive(std::move(place));
}

ExactPlace ExactPlaces::on_triangle(std::size_t a, std::size_t b, const std::array<exact::Point, 3>& u) const {
    std::array<Integers, 3> x;
    Integers at_a, at_b;
    for (std::size_t i = 0; i < 3; ++i) {
        x[i] = relative(u[i]);
        at_a[i] = value(a, x[i]);
        at_b[i] = value(b, x[i]);
        x[i] = difference(x[i], to_origin_);
    }
    const Integers weights = cross(at_a, at_b);
    ExactPlace place{{}, weights[0] + weights[1] + weights[2]};
    for (std::size_t k = 0; k < 3; ++k) place.x[k] = weights[0] * x[0][k] + weights[1] * x[1][k] + weights[2] * x[2][k];
    return positive(std::move(place));
}

ExactPlace ExactPlaces::meeting(std::size_t a, std::size_t b, std::size_t c) const {
    const Row &p = rows_[a], &q = rows_[b], &r = rows_[c];
    const Integers qr = cross(q.n, r.n), rp = cross(r.n, p.n), pq = cross(p.n, q.n);
    const BigInt half = dot(p.n, qr);
    ExactPlace place{{}, half + half};
    for (std::size_t k = 0; k < 3; ++k) place.x[k] = p.s * qr[k] + q.s * rp[k] + r.s * pq[k] - place.w * to_origin_[k];
    return positive(std::move(place));
}

}  // namespace votess::solid
