#include "query/nearer_seeds.hpp"

#include <algorithm>
#include <cmath>

#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

constexpr double slack = 0x1p-44;  // of sums of squares and weights

double distance_to(const Box& box, const exact::Point& x) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double gap = std::max({0.0, box.lower[k] - x[k], x[k] - box.upper[k]});
        sum += gap * gap;
    }
    return std::sqrt(sum);
}

}  // namespace

void NearerSeeds::begin(const Probe& probe) {
    at_ = probe.place.at;
    rounding_ = 0;
    for (std::size_t k = 0; k < 3; ++k)
        if (seeds_.images != nullptr)
            rounding_ = std::max({rounding_, slack * std::abs(at_[k]), slack * seeds_.images->largest_rounded()[k]});
    farthest_ = highest_ = 0;
    vertices_.clear();
}

void NearerSeeds::add_vertex(const std::array<double, 3>& x, double power, double error) {
    vertices_.push_back({x, power, error + rounding_});
    farthest_ = std::max(farthest_, std::sqrt(dot(x, x)) + error + rounding_);
    highest_ = std::max(highest_, power);
}

double NearerSeeds::reach(double weight) const {
    return (farthest_ + std::sqrt(std::max(0.0, highest_ + weight) + slack * (highest_ + std::abs(weight)))) *
           (1 + slack);
}

bool NearerSeeds::may_be_nearer(std::size_t place, double weight) const {
    const Vector3 seed{seeds_.x[place] - at_[0], seeds_.y[place] - at_[1], seeds_.z[place] - at_[2]};
    const double limit = reach(weight);
    if (dot(seed, seed) > limit * limit) return false;
    // An error e of the vertex changes |x|^2 by less than 2 e |x| + e^2, and 2 |x| is less than |x|^2 / f + f.
    const double per_farthest = 1 / farthest_, of_weight = slack * std::abs(weight);
    return std::ranges::any_of(vertices_, [&](const Vertex& vertex) {
        const Vector3 from = minus(seed, vertex.x);
        const double square = dot(from, from);
        const double error = of_weight + slack * (square + std::abs(vertex.power)) +
                             2 * vertex.error * (square * per_farthest + farthest_ + vertex.error);
        return square - weight <= vertex.power + error;
    });
}

bool NearerSeeds::find(std::vector<Member>& members) {
    const int top = hierarchy_.top_level();
    if (seeds_.images != nullptr &&
        !(reach(hierarchy_.largest_weight(top, 0)) + 2 * rounding_ < seeds_.images->reach(at_)))
        return false;
    known_ = members;
    std::ranges::sort(known_);
    nodes_.assign(1, {top, 0});
    while (!nodes_.empty()) {
        const auto [level, index] = nodes_.back();
        nodes_.pop_back();
        if (!(distance_to(hierarchy_.box(level, index), at_) <= reach(hierarchy_.largest_weight(level, index))))
            continue;
        if (level > 0) {
            const std::size_t begin = index * Hierarchy::fan;
            const std::size_t end = std::min(begin + Hierarchy::fan, hierarchy_.count(level - 1));
            for (std::size_t child = begin; child < end; ++child) nodes_.push_back({level - 1, child});
            continue;
        }
        const std::size_t begin = index * group_size, end = seeds_.group_end(begin);
        for (std::size_t place = begin; place < end; ++place) {
            const auto id = static_cast<std::int32_t>(place);
            const Member member =
                seeds_.images == nullptr ? Member{id} : Member{seeds_.images->home(id), seeds_.images->shift(id)};
            const auto home = static_cast<std::size_t>(member.home);
            if (seeds_.weights.empty() && !seeds_.is_beyond(home)) continue;  // it has a face
            const double weight = seeds_.weights.empty() ? 0 : seeds_.weights[home];
            if (!std::ranges::binary_search(known_, member) && may_be_nearer(place, weight)) members.push_back(member);
        }
    }
    return true;
}

}  // namespace votess::cpu
