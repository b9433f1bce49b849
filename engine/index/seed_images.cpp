#include "index/seed_images.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>
#include <utility>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "domain/lattice_reach.hpp"

namespace votess::cpu {
namespace {

// Margin around the box in units of the mean spacing. Most cells of uniform seeds need less, long ones more.
constexpr double margin_spacings = 2.5, wide_margin_spacings = 4;
constexpr std::size_t task_points = 32768;
constexpr double fraction_slack = 1e-9;
// Thin or long boxes would have too many images. Cells search for images beyond the margin.
constexpr double max_images_per_seed = 16, max_images_of_few = 4096;
constexpr double max_wide_images_per_seed = 64, max_wide_images = 0x1p22;
constexpr double least_widening = 1.25;  // less is not worth another sort
constexpr double longer_cells = 2.5;     // where weights move them, they also stretch them
constexpr double max_images_beside = 2;  // for cells beside their seeds

// Returns an estimate of the distance of cells from their seeds: half of the slope of the weights, from a sample of
// pairs of consecutive seeds.
double distance_of_cells(const SortedSeeds& seeds, const std::vector<double>& weights) {
    constexpr std::size_t max_samples = 1024;
    std::vector<double> sample;
    if (weights.empty()) return 0;
    const auto weight = [&](std::size_t s) { return weights[static_cast<std::size_t>(seeds.input[s])]; };
    for (std::size_t s = 0; s + 1 < seeds.size(); s += ceil_div(seeds.size(), max_samples)) {
        const double apart =
            length3(seeds.x[s + 1] - seeds.x[s], seeds.y[s + 1] - seeds.y[s], seeds.z[s + 1] - seeds.z[s]);
        if (apart > 0) sample.push_back(std::abs(weight(s + 1) - weight(s)) / (2 * apart));
    }
    if (sample.empty()) return 0;
    std::ranges::sort(sample);
    return sample[sample.size() - 1 - sample.size() / 20];
}

}  // namespace

double mean_spacing(const std::array<double, 3>& sides, double count) {
    std::array<double, 3> sorted = sides;
    std::ranges::sort(sorted, std::greater());
    double spacing = 0, product = 1;
    for (int k = 0; k < 3 && sorted[static_cast<std::size_t>(k)] > spacing; ++k) {
        product *= sorted[static_cast<std::size_t>(k)];
        spacing = std::pow(product / count, 1.0 / (k + 1));
    }
    return spacing;
}

inline std::array<double, 3> SeedImages::fraction(const exact::Point& x) const {
    const exact::Point& o = domain_->origin;
    const exact::Point d{x[0] - o[0], x[1] - o[1], x[2] - o[2]};
    const auto& dual = basis_->dual;
    if (axis_aligned_) return {d[0] * dual[0][0], d[1] * dual[1][1], d[2] * dual[2][2]};  // other products are 0
    return basis_->fraction(d);
}

std::array<double, 3> SeedImages::depths(const Box& box) const {
    exact::Point middle, half;
    for (std::size_t k = 0; k < 3; ++k) {
        middle[k] = 0.5 * (box.lower[k] + box.upper[k]);
        half[k] = box.upper[k] - middle[k];
    }
    const auto f = fraction(middle);
    std::array<double, 3> depths;
    for (std::size_t j = 0; j < 3; ++j) {
        double extent = 0;
        for (std::size_t k = 0; k < 3; ++k) extent += std::abs(basis_->dual[j][k]) * half[k];
        depths[j] = 0.5 + margin_[j] - 2 * error_[j] - std::abs(f[j] - 0.5) - extent * (1 + fraction_slack);
    }
    return depths;
}

double SeedImages::reach(const Box& places) const {
    double least = std::numeric_limits<double>::infinity();
    const auto inside = depths(places);
    for (std::size_t j = 0; j < 3; ++j)
        if (domain_->periodic[j]) least = std::min(least, inside[j] * basis_->width[j]);
    return std::max(least * (1 - fraction_slack), 0.0);
}

double SeedImages::reach(const exact::Point& seed) const {
    return reach(Box{seed, seed});
}

bool SeedImages::is_present(const exact::Point& image) const {
    return are_present({image, image});
}

bool SeedImages::are_present(const Box& images) const {
    const auto inside = depths(images);
    for (std::size_t j = 0; j < 3; ++j)
        if (domain_->periodic[j] && !(inside[j] > 0)) return false;
    return true;
}

exact::Shift SeedImages::shift_in_domain(std::int32_t home, const exact::Shift& moved) const {
    exact::Shift shift = moves_.empty() ? exact::Shift{} : moves_[static_cast<std::size_t>(home)];
    for (std::size_t j = 0; j < 3; ++j) shift[j] -= moved[j];
    return shift;
}

exact::Point SeedImages::place_in_domain(std::size_t seed) const {
    if (moves_.empty()) return {seeds_->x[seed], seeds_->y[seed], seeds_->z[seed]};
    const auto input = static_cast<std::size_t>(seeds_->input[seed]);
    exact::Shift shift;
    for (int j = 0; j < 3; ++j) shift[j] = wraps_[input][j] - moves_[seed][j];
    const auto at = position(input, shift);
    return {at.x[0].high, at.x[1].high, at.x[2].high};
}

exact::Point SeedImages::place(std::size_t seed, const exact::Shift& shift) const {
    const Base home = base(seed);
    exact::Shift total = shift;
    for (std::size_t j = 0; j < 3; ++j) total[j] += home.shift[j];
    const auto at = position(home.point, total);
    return {at.x[0].high, at.x[1].high, at.x[2].high};
}

SeedImages::Base SeedImages::base(std::size_t seed) const {
    if (!any_wrapped() || is_exact(seed)) return {{seeds_->x[seed], seeds_->y[seed], seeds_->z[seed]}, {}};
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
    return position(point_of(points_, input, scale_), shift);
}

exact::Differences SeedImages::position(const exact::Point& x, const exact::Shift& shift) const {
    exact::Differences at;
    bool all = axis_aligned_;
    for (std::size_t k = 0; k < 3 && all; ++k) {
        at.x[k] = {x[k], 0};
        if (shift[k] == 0) continue;
        const auto by = exact::two_product(domain_->lattice.vector[k][k].high, static_cast<double>(shift[k]));
        at.x[k] = exact::two_sum(x[k], by.high);
        all = by.low == 0;
    }
    return all ? at : exact::differences({}, exact::Plane::bisector(x, shift, domain_->lattice));
}

// Axis-aligned boxes need no distance limit.
bool SeedImages::surely_inside(const exact::Point& x) const {
    for (int k = 0; k < 3; ++k)
        if (!axis_aligned_ && !(std::abs(x[k]) <= domain_size_)) return false;
    const auto f = axis_aligned_ ? fraction(x) : domain_->fraction(x);
    for (int j = 0; j < 3; ++j)
        if (domain_->periodic[j] && !(f[j] > edge_error_[j] && f[j] < 1 - edge_error_[j])) return false;
    return true;
}

// outside: as in the job; such seeds stay in place.
void SeedImages::wrap_points(const std::vector<CellStatus>& outside, ThreadPool& pool) {
    const std::size_t count = points_.count();
    std::array<double, 3> sizes{};
    for (std::size_t k = 0; k < 3; ++k) {
        sizes[k] = std::abs(domain_->origin[k]);
        for (std::size_t j = 0; j < 3; ++j) sizes[k] += std::abs(domain_->edges.vector[j][k]);
    }
    domain_size_ = 0;
    for (int j = 0; j < 3; ++j)
        if (domain_->periodic[j]) domain_size_ = std::max(domain_size_, size_for(domain_->edges, j, sizes));
    for (int j = 0; j < 3; ++j) edge_error_[j] = domain_->edges.fraction_error(j, domain_size_);
    const auto resize = [&](std::size_t shifts, std::size_t places) {
        wraps_.resize_uninitialized(shifts);
        moves_.resize_uninitialized(domain_->skewed ? shifts : 0);
        for (auto* coordinates : {&wrapped_, &wrapped_low_}) coordinates->resize_uninitialized(3 * places);
        wrapped_rough_.resize_uninitialized(places);
    };
    resize(0, 0);
    std::vector<char> any(ceil_div(count, task_points), domain_->skewed ? 1 : 0);
    const auto none = [&] { return std::ranges::find(any, 1) == any.end(); };
    if (!domain_->skewed)
        pool.run(any.size(), [&](std::size_t task, unsigned) {
            for (std::size_t i = task * task_points; i < std::min(count, (task + 1) * task_points); ++i)
                if (outside.empty() || outside[i] != CellStatus::outside)
                    any[task] |= surely_inside(point_of(points_, i, scale_)) ? 0 : 1;
        });
    if (none()) return;
    resize(count, 0);
    std::ranges::fill(any, 0);
    std::vector<std::size_t> too_far(ceil_div(count, task_points), count);
    pool.run(ceil_div(count, task_points), [&](std::size_t task, unsigned) {
        for (std::size_t i = task * task_points; i < std::min(count, (task + 1) * task_points); ++i) {
            wraps_[i] = {};
            if (domain_->skewed) moves_[i] = {};
            if (!outside.empty() && outside[i] == CellStatus::outside) continue;
            const exact::Point x = point_of(points_, i, scale_);
            const bool inside = surely_inside(x);
            if (inside && !domain_->skewed) continue;
            const auto shift = inside ? exact::Shift{} : wrap(*domain_, x);
            if (!shift) too_far[task] = std::min(too_far[task], i);
            wraps_[i] = shift.value_or(exact::Shift{});
            if (shift && domain_->skewed) {
                const auto at = position(i, *shift);
                moves_[i] = shift_into_reduced(*domain_, {at.x[0].high, at.x[1].high, at.x[2].high});
                for (int j = 0; j < 3; ++j) wraps_[i][j] += moves_[i][j];
            }
            any[task] |= wraps_[i] != exact::Shift{} || (domain_->skewed && moves_[i] != exact::Shift{});
        }
    });
    if (const auto first = std::ranges::min_element(too_far); first != too_far.end() && *first < count)
        refuse("point " + std::to_string(*first) +
               " lies more than 500 million periods away from the box: wrap it into the box first");
    resize(none() ? 0 : count, none() ? 0 : count);
    if (none()) return;
    pool.run(ceil_div(count, task_points), [&](std::size_t task, unsigned) {
        for (std::size_t i = task * task_points; i < std::min(count, (task + 1) * task_points); ++i) {
            const auto at = position(i, wraps_[i]);
            wrapped_rough_[i] = at.exact ? 0 : 1;
            for (int k = 0; k < 3; ++k) wrapped_[3 * i + k] = at.x[k].high, wrapped_low_[3 * i + k] = at.x[k].low;
        }
    });
}

// The sorter drops seeds whose rounded positions are equal. Those that differ exactly are appended, sorted by position.
// The lowest index of each place keeps it for its duplicates.
void SeedImages::restore_false_duplicates(SortedSeeds& out) const {
    if (out.duplicates == 0 || wraps_.empty()) return;
    struct Member {
        std::size_t at;  // the sorted seed that has the rounded position
        std::array<double, 3> low;
        bool rough;
        std::int32_t input;
    };
    std::vector<std::size_t> sorted(points_.count());
    for (std::size_t s = 0; s < out.size(); ++s) sorted[static_cast<std::size_t>(out.input[s])] = s;
    std::vector<Member> members;
    const auto add = [&](std::size_t i, std::size_t at) {
        const auto position = this->position(i, wraps_[i]);
        const auto& [x, y, z] = position.x;
        members.push_back({at, {x.low, y.low, z.low}, !position.exact, static_cast<std::int32_t>(i)});
    };
    std::vector<bool> shared(out.size(), false);
    for (std::size_t i = 0; i < out.duplicate_of.size(); ++i) {
        if (out.duplicate_of[i] < 0) continue;
        const std::size_t at = sorted[static_cast<std::size_t>(out.duplicate_of[i])];
        if (!shared[at]) add(static_cast<std::size_t>(out.input[at]), at);
        shared[at] = true;
        add(i, at);
    }
    std::ranges::sort(members, {}, [](const Member& m) { return std::tie(m.at, m.low, m.input); });
    const auto equal = [this](const Member& a, const Member& b) {
        if (a.at != b.at || a.low != b.low) return false;
        if (!a.rough && !b.rough) return true;
        const auto i = static_cast<std::size_t>(a.input), j = static_cast<std::size_t>(b.input);
        exact::Shift shift;
        for (int k = 0; k < 3; ++k) shift[k] = wraps_[j][k] - wraps_[i][k];
        return exact::difference<exact::Quad>(point_of(points_, i, scale_),
                                              exact::Plane::bisector(point_of(points_, j, scale_), shift,
                                                                     domain_->lattice)) == std::array<exact::Quad, 3>{};
    };
    std::vector<const Member*> first, apart;  // of each place with these rounded coordinates and lows; all to append
    out.duplicates = 0;
    for (const Member& member : members) {
        if (!first.empty() && (first[0]->at != member.at || first[0]->low != member.low)) first.clear();
        const auto same = std::ranges::find_if(first, [&](const Member* f) { return equal(*f, member); });
        std::int32_t& duplicate_of = out.duplicate_of[static_cast<std::size_t>(member.input)];
        if (same != first.end()) {
            duplicate_of = (*same)->input;
            ++out.duplicates;
            continue;
        }
        first.push_back(&member);
        if (duplicate_of >= 0) apart.push_back(&member);
        duplicate_of = -1;
    }
    if (out.duplicates == 0) out.duplicate_of.clear();

    const std::size_t kept = out.size(), count = kept + apart.size();
    for (auto* axis : {&out.x, &out.y, &out.z}) {
        Buffer<double> all(SortedSeeds::pages);
        all.resize_uninitialized(round_up(count, group_size));
        std::copy_n(axis->begin(), kept, all.begin());
        for (std::size_t k = 0; k < apart.size(); ++k) all[kept + k] = all[apart[k]->at];
        std::fill(all.begin() + count, all.end(), std::numeric_limits<double>::infinity());
        *axis = std::move(all);
    }
    Buffer<std::int32_t> input;
    input.resize_uninitialized(count);
    std::copy_n(out.input.begin(), kept, input.begin());
    for (std::size_t k = 0; k < apart.size(); ++k) input[kept + k] = apart[k]->input;
    out.input = std::move(input);
}

// Seeds may fill a part of the domain only: a sheet, a wire, a slab. Across its empty rest, images are as far apart.
// wide: as far as cells may reach, if there are at most so many images; 0 for a margin as cells mostly need it. Returns
// false if a wide margin would not be much wider than it is.
bool SeedImages::choose_margin(const SortedSeeds& seeds, ThreadPool& pool, double wide) {
    const auto count = static_cast<double>(std::max<std::size_t>(seeds.size(), 1));
    const double most = wide > 0 ? wide : max_images_per_seed * count + max_images_of_few;
    constexpr Box nowhere{{1, 1, 1}, {0, 0, 0}};
    std::vector<Box> parts(ceil_div(seeds.size(), task_points), nowhere);  // bounds of fractions
    pool.run(parts.size(), [&](std::size_t task, unsigned) {
        for (std::size_t s = task * task_points; s < std::min(seeds.size(), (task + 1) * task_points); ++s)
            include(parts[task], fraction({seeds.x[s], seeds.y[s], seeds.z[s]}));
    });
    Box all = nowhere;
    for (const Box& part : parts) include(all, part);
    std::array<double, 3> filled{}, empty{};
    for (std::size_t j = 0; j < 3; ++j) {
        filled[j] = std::clamp(all.upper[j] - all.lower[j], 0.0, 1.0) * basis_->width[j];
        empty[j] = std::clamp(std::max(all.lower[j], 1 - all.upper[j]), 0.0, 1.0) * basis_->width[j];
    }
    const double spacing = mean_spacing(filled, count);
    const bool sheet = std::ranges::any_of(filled, [&](double side) { return side < spacing; });
    const double spacings = sheet ? wide_margin_spacings : margin_spacings;
    const auto images = [&](double margin) {
        double cells = 1;
        for (std::size_t j = 0; j < 3; ++j)
            cells *= domain_->periodic[j] ? 1 + 2 * (margin + empty[j]) / basis_->width[j] : 1;
        return count * (cells - 1);
    };
    double margin = 2 * domain_->covering_radius;
    if (wide > 0)
        empty = {};
    else
        margin = std::min(margin, spacings * spacing);
    while (images(margin) > most && margin > 0) {
        margin *= 0.8;
        for (double& e : empty) e *= 0.8;
    }
    if (wide > 0) {
        if (!(margin > least_widening * min_reach_)) return false;
    } else {
        // Rough weights seem steep, and their cells lie beside their seeds by less.
        double beside =
            std::min(longer_cells * distance_of_cells(seeds, domain_->weights), 2 * domain_->covering_radius - margin);
        while (beside > 0.1 * margin && images(margin + beside) > max_images_beside * count + max_images_of_few)
            beside *= 0.8;
        if (beside > 0.1 * margin) margin += beside;
    }
    double widest = margin;
    for (std::size_t j = 0; j < 3; ++j)
        if (domain_->periodic[j]) widest = std::max(widest, margin + empty[j]);
    std::array<double, 3> size{};
    for (std::size_t k = 0; k < 3; ++k) {
        size[k] = std::abs(domain_->origin[k]) + widest;
        for (std::size_t j = 0; j < 3; ++j) {  // seeds may lie beyond walls
            const double farthest = 1 + std::max(std::abs(all.lower[j]), std::abs(all.upper[j]));
            size[k] += std::max(2.0, farthest) * std::abs(basis_->vector[j][k]);
        }
    }
    for (int j = 0; j < 3; ++j) {
        error_[j] = fraction_slack + basis_->fraction_error(j, size_for(*basis_, j, size));
        margin_[j] = domain_->periodic[j] ? (margin + empty[static_cast<std::size_t>(j)]) / basis_->width[j] : 0;
    }
    min_reach_ = std::numeric_limits<double>::infinity();
    for (int j = 0; j < 3; ++j)
        if (domain_->periodic[j]) min_reach_ = std::min(min_reach_, (margin_[j] - 4 * error_[j]) * basis_->width[j]);
    min_reach_ = std::max(min_reach_ * (1 - fraction_slack), 0.0);
    return true;
}

template <class Visit>
void SeedImages::for_images(const exact::Point& x, Visit visit) const {
    const auto f = fraction(x);
    bool near = false;
    for (int j = 0; j < 3; ++j) near |= domain_->periodic[j] && !(f[j] > margin_[j] && f[j] < 1 - margin_[j]);
    if (!near) return;
    std::array<int, 3> least{}, most{};
    for (int j = 0; j < 3; ++j) {
        if (!domain_->periodic[j]) continue;
        least[j] = static_cast<int>(std::ceil(-margin_[j] - f[j]));
        most[j] = static_cast<int>(std::floor(1 + margin_[j] - f[j]));
    }
    for (int a = least[0]; a <= most[0]; ++a)
        for (int b = least[1]; b <= most[1]; ++b)
            for (int c = least[2]; c <= most[2]; ++c) {
                if (a == 0 && b == 0 && c == 0) continue;
                const auto& [u, v, w] = basis_->shift;
                visit(exact::Shift{a * u[0] + b * v[0] + c * w[0], a * u[1] + b * v[1] + c * w[1],
                                   a * u[2] + b * v[2] + c * w[2]});
            }
}

void SeedImages::sort(const Job& job, std::span<const std::int32_t> order, SeedSorter& sorter, ThreadPool& pool,
                      SortedSeeds& out, const std::function<void()>& drop) {
    domain_ = job.domain;
    points_ = job.points;
    scale_ = job.scale;
    seeds_ = &out;
    basis_ = domain_->skewed ? &domain_->reduced : &domain_->edges;
    axis_aligned_ = !domain_->skewed;
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
            const exact::DoubleDouble& v = domain_->lattice.vector[j][k];
            axis_aligned_ = axis_aligned_ && v.low == 0 && (j == k || (v.high == 0 && domain_->edges.dual[j][k] == 0));
        }
    wrap_points(job.outside, pool);
    const Points positions = wrapped_.empty() ? points_ : Points{wrapped_, {}};
    const double scale = wrapped_.empty() ? scale_ : 1;
    if (order.empty()) {
        sort_inside(positions, scale, job.grid_resolution, job.outside, sorter, pool, out);
        restore_false_duplicates(out);
    } else {
        put_in_order(positions, scale, order, pool, out);
    }
    if (drop) drop();
    if (!moves_.empty()) {
        Buffer<exact::Shift> moves;
        moves.resize_uninitialized(out.size());
        pool.run(ceil_div(moves.size(), task_points), [&](std::size_t task, unsigned) {
            for (std::size_t s = task * task_points; s < std::min(moves.size(), (task + 1) * task_points); ++s)
                moves[s] = moves_[static_cast<std::size_t>(out.input[s])];
        });
        moves_ = std::move(moves);
    }
    wide_ = false;
    out.images = this;
    if (order.empty())
        add(sorter, pool, out);
    else
        append(Images::none, sorter, pool, out);
}

void SeedImages::add(SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out) {
    choose_margin(out, pool, 0);
    append(Images::within_margin, sorter, pool, out);
}

bool SeedImages::widen(double most, ThreadPool& pool, SortedSeeds& out) {
    if (std::exchange(wide_, true)) return false;
    const auto count = static_cast<double>(out.size());
    most = std::min({most, max_wide_images, max_wide_images_per_seed * count});
    if (!(most > 0) || !choose_margin(out, pool, most)) return false;
    SeedSorter sorter;  // the memory of the other one is lent
    append(Images::within_margin, sorter, pool, out);
    return true;
}

void SeedImages::append(Images wanted, SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out) {
    const std::size_t seeds = out.size();
    const auto at = [&](std::size_t s) { return exact::Point{out.x[s], out.y[s], out.z[s]}; };
    struct Image {
        std::int32_t home;
        exact::Shift shift;
    };
    std::vector<std::vector<Image>> found(ceil_div(seeds, task_points));
    pool.run(wanted == Images::none ? 0 : found.size(), [&](std::size_t task, unsigned) {
        for (std::size_t s = task * task_points; s < std::min(seeds, (task + 1) * task_points); ++s)
            for_images(at(s), [&](const exact::Shift& shift) {
                found[task].push_back({static_cast<std::int32_t>(s), shift});
            });
    });
    std::vector<std::size_t> begin(found.size() + 1, 0);
    for (std::size_t t = 0; t < found.size(); ++t) begin[t + 1] = begin[t] + found[t].size();
    const std::size_t images = begin.back();
    const std::size_t padded = round_up(seeds, group_size);
    if (padded + images > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()) - group_size)
        throw Error(ErrorCode::unsupported,
                    "seeds and their periodic images are more than 2147483647: tessellate in blocks");

    Buffer<Image> unsorted;
    Buffer<double> coordinates;
    Buffer<std::array<double, 3>> lows;
    Buffer<char> rough;
    unsorted.resize_uninitialized(images);
    coordinates.resize_uninitialized(3 * images);
    lows.resize_uninitialized(images);
    rough.resize_uninitialized(images);
    pool.run(found.size(), [&](std::size_t task, unsigned) {
        std::ranges::copy(found[task], unsorted.begin() + begin[task]);
        for (std::size_t i = begin[task]; i < begin[task + 1]; ++i) {
            const auto home = static_cast<std::size_t>(unsorted[i].home),
                       input = static_cast<std::size_t>(out.input[home]);
            exact::Shift total = unsorted[i].shift;
            for (int j = 0; j < 3 && !wraps_.empty(); ++j) total[j] += wraps_[input][j];
            // Points that have not been wrapped may be gone.
            const auto position = wraps_.empty() ? this->position(at(home), total) : this->position(input, total);
            rough[i] = position.exact ? 0 : 1;
            for (int k = 0; k < 3; ++k) {
                coordinates[3 * i + k] = position.x[k].high;
                lows[i][k] = position.x[k].low;
            }
        }
    });
    sorter.sort(std::span<const double>(coordinates), 1, 0, pool, sorted_images_);
    // Images that are rounded to the same coordinates are appended, in no particular order.
    std::vector<std::int32_t> order(sorted_images_.input.begin(), sorted_images_.input.end());
    for (std::size_t i = 0; i < sorted_images_.duplicate_of.size(); ++i)
        if (sorted_images_.duplicate_of[i] >= 0) order.push_back(static_cast<std::int32_t>(i));

    first_ = padded;
    out.images_end = first_ + images;
    const std::size_t places = padded + round_up(images, group_size);
    home_.resize_uninitialized(images);
    shift_.resize_uninitialized(images);
    first_low_ = wraps_.empty() ? first_ : 0;
    low_.resize_uninitialized(places - first_low_);
    rounded_.assign(wraps_.empty() ? 0 : padded, false);
    const std::size_t tasks = ceil_div(low_.size(), task_points);
    static_assert(task_points % 64 == 0);  // each task has its own words of bits
    std::vector<exact::Point> rounding(tasks, exact::Point{});
    pool.run(tasks, [&](std::size_t task, unsigned) {
        const std::size_t begin = first_low_ + task * task_points;
        for (std::size_t id = begin; id < std::min(places, begin + task_points); ++id) {
            auto& low = low_[id - first_low_] = {};
            if (id >= first_ && id < out.images_end) {
                const auto from = static_cast<std::size_t>(order[id - first_]);
                home_[id - first_] = unsorted[from].home;
                shift_[id - first_] = unsorted[from].shift;
                low = lows[from];
            } else if (id < seeds) {
                const auto input = static_cast<std::size_t>(out.input[id]);
                if (wraps_[input] == exact::Shift{}) continue;
                for (std::size_t k = 0; k < 3; ++k) {
                    low[k] = wrapped_low_[3 * input + k];
                    rounding[task][k] = std::max(rounding[task][k], std::abs(low[k]) * (1 + 0x1p-50));
                }
                rounded_[id] = low != std::array<double, 3>{};
            }
        }
    });
    rounding_of_seeds_ = {};
    for (const exact::Point& part : rounding)
        for (std::size_t k = 0; k < 3; ++k) rounding_of_seeds_[k] = std::max(rounding_of_seeds_[k], part[k]);

    rough_.clear();
    if (std::ranges::find(rough, 1) != rough.end() || std::ranges::find(wrapped_rough_, 1) != wrapped_rough_.end()) {
        rough_.assign(places, false);
        for (std::size_t i = 0; i < images; ++i) rough_[first_ + i] = rough[static_cast<std::size_t>(order[i])] != 0;
        for (std::size_t s = 0; s < seeds && !wraps_.empty(); ++s)
            rough_[s] = wrapped_rough_[static_cast<std::size_t>(out.input[s])] != 0;
    }

    largest_coordinate_ = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto coordinate = [&](std::size_t image) {
            return coordinates[3 * static_cast<std::size_t>(order[image]) + k];
        };
        Buffer<double>& axis = k == 0 ? out.x : k == 1 ? out.y : out.z;
        Buffer<double> seeds_only(SortedSeeds::pages);
        if (places > axis.capacity()) seeds_only = std::move(axis);
        axis.resize_uninitialized(places);
        axis.touch(seeds_only.empty() ? padded : 0, places, pool);
        std::vector<double> largest(ceil_div(places, task_points), 0.0);
        pool.run(largest.size(), [&](std::size_t task, unsigned) {
            const std::size_t begin = task * task_points, end = std::min(places, begin + task_points);
            for (std::size_t id = begin; id < end; ++id) {
                if (id >= first_)
                    axis[id] = id < out.images_end ? coordinate(id - first_) : std::numeric_limits<double>::infinity();
                else if (!seeds_only.empty())
                    axis[id] = seeds_only[id];
                if (const double x = std::abs(axis[id]); std::isfinite(x)) largest[task] = std::max(largest[task], x);
            }
        });
        const double of_all = largest.empty() ? 0 : *std::ranges::max_element(largest);
        largest_coordinate_ = std::max(largest_coordinate_, of_all);
        const bool rounds = std::ranges::any_of(domain_->lattice.vector, [&](const auto& v) { return v[k].high != 0; });
        largest_rounded_[k] = rounds ? of_all : 0;
    }
}

}  // namespace votess::cpu
