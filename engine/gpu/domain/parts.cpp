#include "gpu/domain/parts.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/box.hpp"

namespace votess::gpu {
namespace {

// The margin in mean distances between the part's seeds: twice the security radius of most cells.
constexpr double part_margin_spacings = 5;

}  // namespace

Parts::Parts(const Job& job, std::span<const std::int32_t> duplicate_of, const Box& box, std::uint32_t max_seeds)
    : job_(job), box_(box), units_(Units::for_box(box)), max_seeds_(std::max(max_seeds, 2u)) {
    const std::size_t count = job.points.count();
    if (count <= max_seeds_ && job.outside.empty() && job.beyond.empty()) {
        ends_.assign(1, count);
        return;
    }
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0);
    std::erase_if(order_, [&](std::int32_t i) {
        const auto seed = static_cast<std::size_t>(i);
        return (!job.outside.empty() && job.outside[seed] == CellStatus::outside) ||
               (!duplicate_of.empty() && duplicate_of[seed] >= 0);
    });
    if (order_.empty()) return;
    inside_ = order_.size();
    if (!job.beyond.empty()) {
        const auto beyond = std::ranges::stable_partition(
            order_, [&](std::int32_t i) { return !job.beyond[static_cast<std::size_t>(i)]; });
        inside_ -= beyond.size();
        ends_.assign(1, order_.size());
        return;
    }
    split(0, order_.size(), order_.size() <= max_seeds_ ? max_seeds_ : max_seeds_ / 2);
}

Box Parts::bounds(std::size_t begin, std::size_t end) const {
    Box box = empty_box;
    for (std::size_t i = begin; i < end; ++i) include(box, point_of(job_.points, static_cast<std::size_t>(order_[i])));
    return box;
}

// Halves the set along its longest side until it is small enough.
void Parts::split(std::size_t begin, std::size_t end, std::size_t max_own) {
    if (end - begin <= max_own) {
        ends_.push_back(end);
        return;
    }
    const Box box = bounds(begin, end);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (box.upper[k] / 2 - box.lower[k] / 2 > box.upper[axis] / 2 - box.lower[axis] / 2) axis = k;
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::int32_t a, std::int32_t b) {
        return job_.points[3 * static_cast<std::size_t>(a) + axis] <
               job_.points[3 * static_cast<std::size_t>(b) + axis];
    });
    split(begin, middle, max_own);
    split(middle, end, max_own);
}

Part Parts::get(std::size_t index) const {
    Part part;
    if (order_.empty()) {
        part.own_count = static_cast<std::uint32_t>(job_.points.count());
        return part;
    }
    const std::size_t begin = index == 0 ? 0 : ends_[index - 1], end = ends_[index];
    part.own_count = static_cast<std::uint32_t>(end - begin);
    if (ends_.size() == 1) {
        part.own_count = static_cast<std::uint32_t>(inside_);
        part.members = order_;
        return part;
    }
    const Box own = bounds(begin, end);
    double volume = 1;
    for (int k = 0; k < 3; ++k) volume *= own.upper[k] * job_.scale - own.lower[k] * job_.scale;
    double margin = part_margin_spacings * std::cbrt(volume / static_cast<double>(end - begin));
    if (job_.domain->has_weights()) {  // the farthest seed that cuts such a cell, if it is not much heavier than most
        const double heavier = job_.domain->largest_weight - *std::ranges::min_element(job_.domain->weights);
        margin = 0.5 * margin + std::sqrt(0.25 * margin * margin + std::min(heavier, 2 * margin * margin));
    }
    margin /= job_.scale;

    Box box;
    // Adds the seeds around the part, with a smaller margin when they do not fit.
    for (;; margin *= 0.5) {
        if (!(margin > 0)) margin = 0;
        part.members.assign(order_.begin() + static_cast<std::ptrdiff_t>(begin),
                            order_.begin() + static_cast<std::ptrdiff_t>(end));
        for (int k = 0; k < 3; ++k) {
            box.lower[k] = own.lower[k] - margin;
            box.upper[k] = own.upper[k] + margin;
        }
        const auto add_around = [&](std::size_t from, std::size_t to) {
            for (std::size_t i = from; i < to && part.members.size() <= max_seeds_; ++i) {
                bool inside = true;
                for (int k = 0; k < 3; ++k) {
                    const double x = job_.points[3 * static_cast<std::size_t>(order_[i]) + k];
                    inside = inside && x >= box.lower[k] && x <= box.upper[k];
                }
                if (inside) part.members.push_back(order_[i]);
            }
        };
        add_around(0, begin);
        add_around(end, order_.size());
        if (part.members.size() <= max_seeds_) break;
        if (margin == 0) {  // many seeds on the bounds themselves: the CPU clips them all
            part.members.resize(part.own_count);
            box = own;
            for (int k = 0; k < 3; ++k) box.upper[k] = box.lower[k];
            break;
        }
    }

    bool lossy = false;
    for (int k = 0; k < 3; ++k) {
        const std::uint64_t origin = units_.of(box_.lower[k], lossy);
        // Rounded towards the part, as if seeds were rounded away from it.
        if (box.lower[k] > box_.lower[k]) {
            part.bounded |= 1u << k;
            part.lower[k] = units_.of(box.lower[k], lossy) - origin + 1;
        }
        if (box.upper[k] < box_.upper[k]) {
            part.bounded |= 8u << k;
            part.upper[k] = std::max<std::uint64_t>(units_.of(box.upper[k], lossy) - origin, 1) - 1;
        }
    }
    return part;
}

}  // namespace votess::gpu
