#include "verify/brute_force.hpp"

#include <algorithm>
#include <cmath>

#include "core/progress.hpp"
#include "domain/domain.hpp"

namespace votess {
namespace {

// Work, in distance tests.
constexpr double work_of_cell = 1e4, work_of_range = 60, work_of_image = 150, work_of_plane = 100, work_of_vertex = 1;
constexpr std::size_t seeds_per_stop = 16384, images_per_stop = 256;  // after which the user may stop

}  // namespace

BruteForce::BruteForce(const Job& job) : job_(job), domain_(*job.domain), lattice_reach_(domain_) {
    place_.reserve(job.points.count());
    for (std::size_t i = 0; i < job.points.count(); ++i) place_.push_back(place_of(seed_of(i)));
}

exact::Point BruteForce::seed_of(std::size_t j) const {
    return {job_.points[3 * j] * job_.scale, job_.points[3 * j + 1] * job_.scale, job_.points[3 * j + 2] * job_.scale};
}

double BruteForce::weight_of(std::size_t j) const {
    return domain_.has_weights() ? domain_.weights[j] : 0;
}

// Rounds the place of a seed once, along axes that box vectors have a component of.
BruteForce::Place BruteForce::place_of(const exact::Point& seed) {
    Place place{{}, seed};
    if (!domain_.is_periodic()) return place;
    place.shift = wrap(domain_, seed).value_or(place.shift);
    const auto exact = exact::differences({}, exact::Plane::bisector(seed, place.shift, domain_.lattice)).x;
    place.at = {exact[0].high, exact[1].high, exact[2].high};
    for (std::size_t k = 0; k < 3; ++k) {
        largest_[k] = std::max(largest_[k], std::abs(place.at[k]));
        if (std::ranges::none_of(domain_.lattice.vector, [&](const auto& v) { return v[k].high != 0; })) continue;
        place_rounding_[k] = 0x1p-52 * largest_[k];
        rounding_ = std::max(rounding_, 2 * place_rounding_[k]);
    }
    return place;
}

void BruteForce::clip(std::size_t i, cpu::Cell& cell) {
    clip({seed_of(i), weight_of(i), place_[i], i}, cell);
}

void BruteForce::clip(const exact::Point& seed, double weight, cpu::Cell& cell) {
    clip({seed, weight, place_of(seed), place_.size()}, cell);
}

void BruteForce::clip(const Own& own, cpu::Cell& cell) {
    own_ = own;
    cell.start(own_.seed, domain_, static_cast<std::int32_t>(own_.index));
    work_ += work_of_cell;
    cut_by_nearest(cell);
    images_.clear();
    const double reach = reach_of(cell);
    for (std::size_t s = 0; s < place_.size(); ++s) {
        if (s % seeds_per_stop == 0) check_stop();
        const exact::Point& at = place_[s].at;
        const ShiftRange shifts = domain_.is_periodic() ? shifts_around(domain_, {at, at}, own_.place.at,
                                                                        std::min(reach, lattice_reach_.distance()))
                                                        : ShiftRange{};
        add(s, shifts, reach * reach);
    }
    work_ += static_cast<double>(place_.size()) * (domain_.is_periodic() ? work_of_range : 1);
    for (std::size_t tried = 1; !images_.empty() && !cell.empty(); ++tried) {
        if (tried % images_per_stop == 0) check_stop();
        std::ranges::pop_heap(images_, farther);
        const Images next = images_.back();
        images_.pop_back();
        work_ += work_of_image;
        const Box bounds = bounds_of(next.seed, next.shifts);
        const double more =
            domain_.has_weights() ? std::min(max_extra_weight(), weight_of(next.seed) - own_.weight) : 0;
        if (!cell.in_reach(bounds, more) || !cell.may_cut(bounds, more)) continue;
        if (next.shifts.is_single())
            cut(next.seed, next.shifts, cell);
        else
            halve(next);
    }
}

double BruteForce::max_extra_weight() const {
    return domain_.has_weights() ? domain_.max_heavier_by(own_.weight) : 0;
}

// Returns a distance beyond which no seed cuts: R + sqrt(R^2 + w - w_i) for the largest weight w.
double BruteForce::reach_of(cpu::Cell& cell) const {
    constexpr double slack = 1 + 1e-9, least = 1e-150;  // squares below the least number are lost
    const double square = cell.radius_squared();
    return (std::sqrt(square) + std::sqrt(square + max_extra_weight())) * slack + rounding_ + least;
}

Box BruteForce::bounds_of(std::size_t seed, const ShiftRange& shifts) const {
    const exact::Point& q = place_[seed].at;
    if (!domain_.is_periodic()) return cpu::seen_from(own_.place.at, {q, q});
    return cpu::seen_from({}, images_of(domain_, {q, q}, shifts, own_.place.at), place_rounding_);
}

void BruteForce::add(std::size_t seed, const ShiftRange& shifts, double max_square) {
    const Box box = bounds_of(seed, shifts);
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap = std::max({0.0, box.lower[k], -box.upper[k]});
        square += gap * gap;
    }
    const bool has_images = own_.index < place_.size();
    if (square > max_square || (has_images && !lattice_reach_.may_touch(box))) return;
    images_.push_back({square, seed, shifts});
    std::ranges::push_heap(images_, farther);
}

void BruteForce::halve(const Images& images) {
    const int axis = longest_extent(domain_, images.shifts).axis;
    for (const ShiftRange& half : halves(images.shifts, axis)) add(images.seed, half, infinity);
}

// Cuts by a few seeds, so that the others are soon out of reach.
void BruteForce::cut_by_nearest(cpu::Cell& cell) {
    constexpr std::size_t count = 48;
    images_.clear();
    for (std::size_t s = 0; s < place_.size(); ++s) {
        if (s % seeds_per_stop == 0) check_stop();
        const exact::Point &p = own_.place.at, &q = place_[s].at;
        const double x = q[0] - p[0], y = q[1] - p[1], z = q[2] - p[2];
        double key = x * x + y * y + z * z;
        if (domain_.has_weights()) key -= weight_of(s);
        if (images_.size() == count && !(key < images_.front().distance_squared)) continue;
        if (images_.size() == count) {
            std::ranges::pop_heap(images_, {}, &Images::distance_squared);
            images_.pop_back();
        }
        images_.push_back({key, s, {}});
        std::ranges::push_heap(images_, {}, &Images::distance_squared);
    }
    work_ += static_cast<double>(place_.size());
    std::ranges::sort(images_, {}, &Images::distance_squared);
    for (const Images& image : images_) cut(image.seed, {}, cell);
}

void BruteForce::cut(std::size_t seed, const ShiftRange& range, cpu::Cell& cell) {
    const exact::Shift shift = domain_.is_periodic() ? only_shift(domain_, range) : exact::Shift{};
    const auto id = static_cast<std::int32_t>(seed);
    if ((seed == own_.index && shift == exact::Shift{}) || cell.has_plane(id, shift)) return;
    exact::Shift total;
    for (std::size_t k = 0; k < 3; ++k) total[k] = shift[k] + place_[seed].shift[k] - own_.place.shift[k];
    exact::Plane plane = exact::Plane::bisector(seed_of(seed), total, domain_.lattice);
    if (domain_.has_weights()) plane.power = exact::two_sum(own_.weight, -domain_.weights[seed]);
    work_ += work_of_plane + work_of_vertex * cell.slots();
    cell.clip(id, plane, shift);
}

}  // namespace votess
