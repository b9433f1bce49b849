#include "query/locator.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "index/seed_images.hpp"

namespace votess::cpu {
namespace {

constexpr double unit = 0x1p-53;
constexpr double tiny = 1e-290;  // above the underflow of a square

}  // namespace

Locator::Locator(const Job& job, const SortedSeeds& seeds, const Hierarchy& hierarchy)
    : domain_(*job.domain),
      lattice_reach_(domain_),
      seeds_(seeds),
      hierarchy_(hierarchy),
      kernels_(*find_kernels(job.instructions)),
      box_kernels_(star_kernels(kernels_.name)) {
    if (seeds_.images != nullptr)
        for (const double largest : seeds_.images->largest_rounded())
            image_rounding_ = std::max(image_rounding_, 8 * unit * largest);
}

std::optional<Place> Locator::place(const exact::Point& x, std::size_t number) const {
    for (int k = 0; k < 3; ++k)
        if (!domain_.triclinic && !domain_.periodic[k] &&
            !(x[k] >= domain_.box.lower[k] && x[k] <= domain_.box.upper[k]))
            return std::nullopt;
    if (domain_.has_cell_walls() && !inside_walls(domain_, x)) return std::nullopt;
    if (!std::ranges::all_of(domain_.walls, [&](const exact::Plane& wall) { return inside(wall, x); }))
        return std::nullopt;
    const auto place = place_in(domain_, x);
    if (!place) refuse("query " + std::to_string(number) + " lies more than 500 million periods away from the box");
    return place;
}

std::optional<Place> wrapped_into(const Domain& domain, const exact::Point& x) {
    Place place{x};
    const auto move = [&](const exact::Shift& shift) {
        for (std::size_t j = 0; j < 3; ++j) place.shift[j] += shift[j];
        const auto moved = exact::differences({}, exact::Plane::bisector(x, place.shift, domain.lattice));
        for (std::size_t k = 0; k < 3; ++k) place.at[k] = moved.x[k].high, place.low[k] = moved.x[k].low;
    };
    const auto shift = wrap(domain, x);
    if (!shift) return std::nullopt;
    if (*shift != exact::Shift{}) move(*shift);
    if (domain.skewed) move(place.move = shift_into_reduced(domain, place.at));
    return place;
}

// |at - q|^2 is wrong by the rounding of both places and of the arithmetic; the difference by that of the weight, too.
double Locator::error_of(double distance_squared, double weight) const {
    return 16 * unit * (distance_squared + std::abs(weight)) +
           4 * rounding_ * (std::sqrt(distance_squared) + rounding_) + tiny;
}

double Locator::reach_squared(double weight) const {
    if (best_ == infinity) return infinity;
    const double reach = std::max(0.0, best_ + weight);
    return reach + 4 * error_of(reach, weight);
}

void Locator::keep(std::int32_t home, const exact::Shift& shift, double distance_squared) {
    const double weight = seeds_.weights.empty() ? 0 : seeds_.weights[static_cast<std::size_t>(home)];
    const double error = error_of(distance_squared, weight), value = distance_squared - weight;
    if (!(value - error <= best_)) return;
    candidates_.push_back({value - error, value + error, home, shift});
    if (!(value + error < best_)) return;
    best_ = value + error;
    reach_ = reach_squared(0);
}

void Locator::try_group(std::size_t group) {
    const std::size_t begin = group * group_size, end = seeds_.group_end(begin);
    double distance[group_size];
    kernels_.squared_distances(&seeds_.x[begin], &seeds_.y[begin], &seeds_.z[begin], static_cast<int>(end - begin),
                               at_.data(), distance);
    const auto try_seed = [&](std::size_t i) {
        const auto id = static_cast<std::int32_t>(begin + i);
        if (seeds_.images == nullptr)
            keep(id, {}, distance[i]);
        else
            keep(seeds_.images->home(id), seeds_.images->shift(id), distance[i]);
    };
    const std::size_t count = end - begin;
    if (best_ == infinity) try_seed(static_cast<std::size_t>(std::min_element(distance, distance + count) - distance));
    const double weight = hierarchy_.largest_weight(0, group);
    double reach = reach_to(weight);
    for (std::size_t i = 0; i < count; ++i) {
        if (!(distance[i] <= reach)) continue;
        try_seed(i);
        reach = reach_to(weight);
    }
}

// Descends from box to box: into the box with the nearest center among those that hold the point, else among all. The
// search then starts from a near seed.
std::size_t Locator::group_near(const exact::Point& at) const {
    const Box here{at, at};
    std::size_t node = 0;
    for (int level = hierarchy_.top_level(); level >= 0; --level) {
        const BoxBlock& block = hierarchy_.block(level, node);
        const std::size_t begin = node * Hierarchy::fan;
        const std::size_t count = std::min(Hierarchy::fan, hierarchy_.count(level) - begin);
        unsigned children = box_kernels_.near_boxes(block, here, tiny);
        if (children == 0 || !seeds_.weights.empty()) children = (1u << count) - 1;
        double least = infinity;
        for (; children != 0; children &= children - 1) {
            const auto i = static_cast<std::size_t>(std::countr_zero(children));
            double value = -hierarchy_.largest_weight(level, begin + i);
            for (std::size_t k = 0; k < 3; ++k) {
                const double from_middle = 0.5 * (block.lower[k][i] + block.upper[k][i]) - at[k];
                value += from_middle * from_middle;
            }
            if (value < least) least = value, node = begin + i;
        }
    }
    return node;
}

void Locator::search() {
    const Box here{at_, at_};
    std::size_t nodes = 1;
    nodes_[0] = {hierarchy_.top_level(), 0};
    while (nodes > 0) {
        const auto [level, index] = nodes_[--nodes];
        const BoxBlock& block = hierarchy_.block(level, index);
        const double weight = hierarchy_.largest_weight_of_block(level, index);
        double reach = reach_to(weight);
        unsigned near = box_kernels_.near_boxes(block, here, reach);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            if (level > 0) {
                nodes_[nodes++] = {level - 1, child};
            } else if (child != first_group_) {
                try_group(child);
                if (const double now = reach_to(weight); now < reach)
                    near &= box_kernels_.near_boxes(block, here, reach = now) | (near & -near);
            }
        }
    }
}

void Locator::push_far(const ImageNode& node) {
    const Box images = images_of(domain_, box_of(node, seeds_, hierarchy_), node.shifts, at_);
    if (!lattice_reach_.may_touch(images)) return;
    const double weight = node.level < 0 && !seeds_.weights.empty()
                              ? seeds_.weights[node.node]
                              : hierarchy_.largest_weight(std::max(node.level, 0), node.node);
    if (distance_squared(Vector3{}, images) <= reach_squared(weight)) far_.push_back(node);
}

// Searches images that are not among the sorted seeds, for points far from every seed.
void Locator::search_images() {
    const double known = std::max(0.0, seeds_.images->reach(at_) - 2 * rounding_);
    const double reach = reach_squared(hierarchy_.largest_weight(hierarchy_.top_level(), 0));
    if (reach < known * known) return;
    const int top = hierarchy_.top_level();
    far_.clear();
    push_far(
        {top, 0,
         shifts_around(domain_, hierarchy_.box(top, 0), at_, std::min(std::sqrt(reach), lattice_reach_.distance()))});
    while (!far_.empty()) {
        const ImageNode node = far_.back();
        far_.pop_back();
        if (node.shifts == ShiftRange{}) continue;  // the seeds themselves
        if (!node.is_single()) {
            for_each_part(node, domain_, seeds_, hierarchy_, [this](const ImageNode& part) { push_far(part); });
            continue;
        }
        const Box image = images_of(domain_, box_of(node, seeds_, hierarchy_), node.shifts, at_);
        exact::Point to;
        for (std::size_t k = 0; k < 3; ++k) to[k] = 0.5 * (image.lower[k] + image.upper[k]);
        keep(static_cast<std::int32_t>(node.node), only_shift(domain_, node.shifts),
             to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
    }
}

std::int32_t Locator::find(const exact::Point& x, const Place& place) {
    const std::int32_t home = nearest(x, place).home;
    return home < 0 ? -1 : seeds_.input[static_cast<std::size_t>(home)];
}

Locator::Nearest Locator::nearest(const exact::Point& x, const Place& place) {
    if (seeds_.size() == 0) return {};
    at_ = place.at;
    rounding_ = image_rounding_;
    if (place.shift != exact::Shift{})
        for (const double c : at_) rounding_ = std::max(rounding_, image_rounding_ + 4 * unit * std::abs(c));
    best_ = reach_ = infinity;
    candidates_.clear();
    first_group_ = group_near(at_);
    try_group(first_group_);
    search();
    if (seeds_.images != nullptr) search_images();
    std::erase_if(candidates_, [this](const Candidate& c) { return !(c.least <= best_); });
    return decide(x, place.shift);
}

exact::Plane Locator::plane_of(const Candidate& candidate, const exact::Shift& by) const {
    const auto home = static_cast<std::size_t>(candidate.home);
    exact::Plane plane;
    if (seeds_.images == nullptr) {
        plane = exact::Plane::bisector({seeds_.x[home], seeds_.y[home], seeds_.z[home]});
    } else {
        SeedImages::Base seed = seeds_.images->base(home);
        for (std::size_t j = 0; j < 3; ++j) seed.shift[j] += candidate.shift[j] - by[j];
        plane = exact::Plane::bisector(seed.point, seed.shift, domain_.lattice);
    }
    if (!seeds_.weights.empty()) plane.power = {-seeds_.weights[home], 0};
    return plane;
}

Locator::Nearest Locator::decide(const exact::Point& x, const exact::Shift& by) {
    const auto index = [this](const Candidate& c) { return seeds_.input[static_cast<std::size_t>(c.home)]; };
    const Candidate* nearest = &candidates_.front();
    for (const Candidate& c : candidates_) {
        if (c.home == nearest->home && c.shift == nearest->shift) continue;
        const int order = exact::farther(x, plane_of(*nearest, by), plane_of(c, by));
        if (order > 0 || (order == 0 && index(c) < index(*nearest))) nearest = &c;
    }
    return {nearest->home, nearest->shift};
}

}  // namespace votess::cpu
