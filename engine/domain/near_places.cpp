#include "domain/near_places.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace votess {

NearPlaces::NearPlaces(const Domain& domain, double spacing) : domain_(domain) {
    constexpr double max_steps = 128;
    constexpr double max_periods = 8;  // how far away places may be; fractions of farther ones err by more
    const double size = max_periods * std::max(largest_coordinate(domain.box), domain.covering_radius);
    for (std::size_t j = 0; j < 3; ++j) {
        steps_[j] = static_cast<std::int64_t>(std::clamp(domain.reduced.width[j] / spacing, 1.0, max_steps));
        error_[j] = domain.reduced.fraction_error(static_cast<int>(j), size);
    }
    marked_.assign(static_cast<std::size_t>(steps_[0] * steps_[1] * steps_[2]), 0);
}

std::array<double, 3> NearPlaces::fraction(const exact::Point& x) const {
    const auto& origin = domain_.origin;
    return domain_.reduced.fraction({x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]});
}

// Returns a step of the grid for any fraction, also for NaN and infinity, which frames may hold. Fractions beyond the
// ends of an axis that does not repeat get the last step there.
std::int64_t NearPlaces::step(std::size_t j, double fraction) const {
    const double f = domain_.periodic[j] ? fraction - std::floor(fraction) : fraction;
    const double at = f * static_cast<double>(steps_[j]);
    if (!(at > 0)) return 0;
    return static_cast<std::int64_t>(std::min(at, static_cast<double>(steps_[j] - 1)));
}

// A fraction that differs by d moves a place by d times the width of the domain.
void NearPlaces::add(const exact::Point& x, double distance) {
    const auto f = fraction(x);
    std::array<std::int64_t, 3> first{}, count{};
    for (std::size_t j = 0; j < 3; ++j) {
        const double around = distance / domain_.reduced.width[j] * (1 + 1e-9) + 2 * error_[j];
        const double periods = domain_.periodic[j] ? 0.5 : 1;
        if (around + 1 / static_cast<double>(steps_[j]) < periods) {
            first[j] = step(j, f[j] - around);
            count[j] = step(j, f[j] + around) - first[j];
            if (domain_.periodic[j]) count[j] = (count[j] + steps_[j]) % steps_[j];
            ++count[j];
        } else {
            count[j] = steps_[j];
        }
    }
    for (std::int64_t a = 0; a < count[0]; ++a)
        for (std::int64_t b = 0; b < count[1]; ++b)
            for (std::int64_t c = 0; c < count[2]; ++c) {
                const std::int64_t i = (first[0] + a) % steps_[0], j = (first[1] + b) % steps_[1];
                marked_[static_cast<std::size_t>((i * steps_[1] + j) * steps_[2] + (first[2] + c) % steps_[2])] = 1;
            }
}

bool NearPlaces::holds(const exact::Point& x) const {
    const auto f = fraction(x);
    return marked_[static_cast<std::size_t>((step(0, f[0]) * steps_[1] + step(1, f[1])) * steps_[2] + step(2, f[2]))] !=
           0;
}

double NearPlaces::share() const {
    return std::accumulate(marked_.begin(), marked_.end(), 0.0) / static_cast<double>(marked_.size());
}

}  // namespace votess
