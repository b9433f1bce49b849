#include "cpu/seed_images.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cpu/sort_inside.hpp"

namespace votess::cpu {
namespace {

// Margin around the box in units of the mean spacing: most cells of uniform seeds need less.
constexpr double margin_spacings = 3.4;
constexpr std::size_t task_points = 32768;
constexpr double fraction_slack = 1e-9;  // more than the rounding of fractions

exact::Point point_of(const Points& points, std::size_t i, double scale) {
    return {points[3 * i] * scale, points[3 * i + 1] * scale, points[3 * i + 2] * scale};
}

std::size_t tasks_for(std::size_t count) {
    return (count + task_points - 1) / task_points;
}

}  // namespace

double SeedImages::reach(const exact::Point& seed) const {
    double least = std::numeric_limits<double>::infinity();
    const auto f = domain_->fraction(seed);
    for (int j = 0; j < 3; ++j)
        if (domain_->periodic[j]) least = std::min(least, (std::min(f[j], 1 - f[j]) + margin_[j]) * domain_->width[j]);
    return least * (1 - fraction_slack);
}

SeedImages::Base SeedImages::base(std::size_t seed) const {
    if (is_exact(seed)) return {{seeds_->x[seed], seeds_->y[seed], seeds_->z[seed]}, {}};
    const auto input = static_cast<std::size_t>(seeds_->input[seed]);
    return {point_of(points_, input, scale_), wraps_[input]};
}

exact::Plane SeedImages::bisector(const Base& seed, std::int32_t home, const exact::Shift& shift) const {
    const Base other = base(static_cast<std::size_t>(home));
    exact::Shift total;
    for (int j = 0; j < 3; ++j) total[j] = shift[j] + other.shift[j] - seed.shift[j];
    return exact::Plane::bisector(other.point, total, domain_->lattice);
}

exact::Differences SeedImages::position(std::size_t input, const exact::Shift& shift) const {
    return exact::differences({}, exact::Plane::bisector(point_of(points_, input, scale_), shift, domain_->lattice));
}

void SeedImages::wrap_points(ThreadPool& pool) {
    const std::size_t count = points_.count();
    wraps_.assign(count, {});
    std::vector<char> any(tasks_for(count), 0);
    std::vector<std::size_t> too_far(tasks_for(count), count);
    pool.run(tasks_for(count), [&](std::size_t task, unsigned) {
        for (std::size_t i = task * task_points; i < std::min(count, (task + 1) * task_points); ++i) {
            const auto shift = wrap(*domain_, point_of(points_, i, scale_));
            if (!shift) too_far[task] = std::min(too_far[task], i);
            wraps_[i] = shift.value_or(exact::Shift{});
            any[task] |= wraps_[i] != exact::Shift{};
        }
    });
    if (const auto first = std::ranges::min_element(too_far); first != too_far.end() && *first < count)
        throw Error(ErrorCode::invalid_argument,
                    "point " + std::to_string(*first) + " lies more than 500 million periods away from the box");
    wrapped_.clear();
    if (std::ranges::count(any, 0) == static_cast<std::ptrdiff_t>(any.size())) {
        wraps_.clear();
        return;
    }
    wrapped_.resize(3 * count);
    pool.run(tasks_for(count), [&](std::size_t task, unsigned) {
        for (std::size_t i = task * task_points; i < std::min(count, (task + 1) * task_points); ++i)
            for (int k = 0; k < 3; ++k) wrapped_[3 * i + k] = position(i, wraps_[i]).x[k].high;
    });
}

// Seeds that differ only by what rounding takes are not equal: one of each two moves by a unit in the last place, which
// its low part takes back.
bool SeedImages::part_false_duplicates(const SortedSeeds& seeds) {
    bool found = false;
    for (std::size_t i = 0; i < seeds.duplicate_of.size(); ++i) {
        const std::int32_t other = seeds.duplicate_of[i];
        if (other < 0) continue;
        const auto j = static_cast<std::size_t>(other);
        exact::Shift shift;
        for (int k = 0; k < 3; ++k) shift[k] = wraps_[j][k] - wraps_[i][k];
        const exact::Plane bisector = exact::Plane::bisector(point_of(points_, j, scale_), shift, domain_->lattice);
        const auto n = exact::difference<exact::Quad>(point_of(points_, i, scale_), bisector);
        if (n[0] == 0 && n[1] == 0 && n[2] == 0) continue;
        wrapped_[3 * i] = std::nextafter(wrapped_[3 * i], std::numeric_limits<double>::infinity());
        found = true;
    }
    return found;
}

template <class Visit>
void SeedImages::for_images(const exact::Point& x, Visit visit) const {
    const auto f = domain_->fraction(x);
    std::array<int, 3> least{}, most{};
    for (int j = 0; j < 3; ++j) {
        if (!domain_->periodic[j]) continue;
        least[j] = static_cast<int>(std::ceil(-margin_[j] - f[j]));
        most[j] = static_cast<int>(std::floor(1 + margin_[j] - f[j]));
    }
    for (int a = least[0]; a <= most[0]; ++a)
        for (int b = least[1]; b <= most[1]; ++b)
            for (int c = least[2]; c <= most[2]; ++c)
                if (a != 0 || b != 0 || c != 0) visit(exact::Shift{a, b, c});
}

void SeedImages::sort(const Job& job, SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out) {
    domain_ = job.domain;
    points_ = job.points;
    scale_ = job.scale;
    seeds_ = &out;
    const std::size_t count = points_.count();
    wrap_points(pool);
    do {
        const Points positions = wrapped_.empty() ? points_ : Points{wrapped_, {}};
        sort_inside(positions, wrapped_.empty() ? scale_ : 1, job.options.grid_resolution, job.outside, sorter, pool,
                    out);
    } while (out.duplicates > 0 && !wraps_.empty() && part_false_duplicates(out));

    const double spacing = std::cbrt(domain_->volume / static_cast<double>(std::max<std::size_t>(count, 1)));
    const double margin = std::min(margin_spacings * spacing, 2 * domain_->covering_radius);
    for (int j = 0; j < 3; ++j) margin_[j] = domain_->periodic[j] ? margin / domain_->width[j] + fraction_slack : 0;
    append(sorter, pool, out);
    out.images = this;
}

void SeedImages::append(SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out) {
    const std::size_t seeds = out.size();
    const auto at = [&](std::size_t s) { return exact::Point{out.x[s], out.y[s], out.z[s]}; };
    std::vector<std::size_t> begin(tasks_for(seeds) + 1, 0);
    pool.run(tasks_for(seeds), [&](std::size_t task, unsigned) {
        for (std::size_t s = task * task_points; s < std::min(seeds, (task + 1) * task_points); ++s)
            for_images(at(s), [&](const exact::Shift&) { ++begin[task + 1]; });
    });
    for (std::size_t t = 1; t < begin.size(); ++t) begin[t] += begin[t - 1];
    const std::size_t images = begin.back();
    const std::size_t padded = (seeds + group_size - 1) / group_size * group_size;
    if (padded + images > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) - group_size)
        throw Error(ErrorCode::unsupported, "seeds and their periodic images are too many: at most 2147483647");

    std::vector<std::int32_t> homes(images);
    std::vector<exact::Shift> shifts(images);
    std::vector<double> coordinates(3 * images);
    std::vector<std::array<double, 3>> lows(images);
    pool.run(tasks_for(seeds), [&](std::size_t task, unsigned) {
        std::size_t i = begin[task];
        for (std::size_t s = task * task_points; s < std::min(seeds, (task + 1) * task_points); ++s) {
            const auto input = static_cast<std::size_t>(out.input[s]);
            for_images(at(s), [&](const exact::Shift& shift) {
                homes[i] = static_cast<std::int32_t>(s);
                shifts[i] = shift;
                exact::Shift total = shift;
                for (int j = 0; j < 3 && !wraps_.empty(); ++j) total[j] += wraps_[input][j];
                const auto position = this->position(input, total);
                for (int k = 0; k < 3; ++k) {
                    coordinates[3 * i + k] = position.x[k].high;
                    lows[i][k] = position.x[k].low;
                }
                ++i;
            });
        }
    });
    sorter.sort(coordinates, 1, 0, pool, sorted_images_);
    // Images that are rounded to the same coordinates stay apart: behind the others, in no order.
    std::vector<std::int32_t> order(sorted_images_.input.begin(), sorted_images_.input.end());
    for (std::size_t i = 0; i < sorted_images_.duplicate_of.size(); ++i)
        if (sorted_images_.duplicate_of[i] >= 0) order.push_back(static_cast<std::int32_t>(i));

    first_ = padded;
    out.images_end = first_ + images;
    const std::size_t places = padded + (images + group_size - 1) / group_size * group_size;
    home_.resize(images);
    shift_.resize(images);
    low_.assign(places, {});
    largest_coordinate_ = 0;
    Buffer<double>* const axes[3] = {&out.x, &out.y, &out.z};
    for (int k = 0; k < 3; ++k) {
        Buffer<double> all(SortedSeeds::pages);
        all.resize_uninitialized(places);
        std::copy_n(axes[k]->begin(), padded, all.begin());
        for (std::size_t i = 0; i < images; ++i)
            all[first_ + i] = coordinates[3 * static_cast<std::size_t>(order[i]) + k];
        std::fill(all.begin() + first_ + images, all.end(), std::numeric_limits<double>::infinity());
        for (std::size_t i = 0; i < seeds; ++i) largest_coordinate_ = std::max(largest_coordinate_, std::abs(all[i]));
        for (std::size_t i = first_; i < first_ + images; ++i)
            largest_coordinate_ = std::max(largest_coordinate_, std::abs(all[i]));
        *axes[k] = std::move(all);
    }
    for (std::size_t i = 0; i < images; ++i) {
        const auto from = static_cast<std::size_t>(order[i]);
        home_[i] = homes[from];
        shift_[i] = shifts[from];
        low_[first_ + i] = lows[from];
    }
    for (std::size_t s = 0; s < seeds && !wraps_.empty(); ++s) {
        const auto input = static_cast<std::size_t>(out.input[s]);
        if (wraps_[input] == exact::Shift{}) continue;
        exact::Plane seed = exact::Plane::bisector(point_of(points_, input, scale_), wraps_[input], domain_->lattice);
        const auto rest = exact::differences({out.x[s], out.y[s], out.z[s]}, seed);
        for (int k = 0; k < 3; ++k) low_[s][k] = rest.x[k].high;
    }
}

}  // namespace votess::cpu
