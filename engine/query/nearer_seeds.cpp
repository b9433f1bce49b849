#include "query/nearer_seeds.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/vector3.hpp"

namespace votess::cpu {
namespace {

constexpr double slack = 0x1p-44;  // of sums of squares and weights

// Returns the squared distance of a box from a place relative to `at`, rounded as those of seeds.
double square_to(const Box& box, const exact::Point& at, const Vector3& x) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double gap = std::max({0.0, box.lower[k] - at[k] - x[k], x[k] - (box.upper[k] - at[k])});
        sum += gap * gap;
    }
    return sum;
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

bool NearerSeeds::may_be_nearer(const Vertex& vertex, double square, double weight) const {
    // An error e of the vertex changes |x|^2 by less than 2 e |x| + e^2, and 2 |x| is less than |x|^2 / f + f.
    const double of_square = slack + 2 * vertex.error / farthest_;
    const double error = of_square * square + slack * (std::abs(weight) + std::abs(vertex.power)) +
                         2 * vertex.error * (farthest_ + vertex.error);
    return !(of_square < 1) || square - weight <= vertex.power + error;
}

const std::vector<std::uint32_t>& NearerSeeds::vertices_near(int level, std::size_t index) {
    NearVertices& near = near_[static_cast<std::size_t>(level)];
    if (level > hierarchy_.top_level() || near.index == index) return near.numbers;
    const std::vector<std::uint32_t>& above = vertices_near(level + 1, index / Hierarchy::fan);
    near.index = index;
    near.numbers.clear();
    const Box& box = hierarchy_.box(level, index);
    const double weight = hierarchy_.largest_weight(level, index);
    for (const std::uint32_t v : above) {
        if (may_be_nearer(vertices_[v], square_to(box, at_, vertices_[v].x), weight)) near.numbers.push_back(v);
    }
    return near.numbers;
}

bool NearerSeeds::may_be_nearer(std::size_t place, double weight) {
    const Vector3 seed{seeds_.x[place] - at_[0], seeds_.y[place] - at_[1], seeds_.z[place] - at_[2]};
    const double limit = reach(weight);
    if (dot(seed, seed) > limit * limit) return false;
    return std::ranges::any_of(vertices_near(0, place / group_size), [&](std::uint32_t v) {
        const Vector3 from = minus(seed, vertices_[v].x);
        return may_be_nearer(vertices_[v], dot(from, from), weight);
    });
}

bool NearerSeeds::find(std::vector<Member>& members) {
    const int top = hierarchy_.top_level();
    if (seeds_.images != nullptr &&
        !(reach(hierarchy_.largest_weight(top, 0)) + 2 * rounding_ < seeds_.images->reach(at_)))
        return false;
    known_ = members;
    std::ranges::sort(known_);
    near_.resize(static_cast<std::size_t>(top) + 2);
    for (NearVertices& near : near_) near.index = ~std::size_t{0};
    near_.back().numbers.resize(vertices_.size());
    std::iota(near_.back().numbers.begin(), near_.back().numbers.end(), 0u);
    nodes_.assign(1, {top, 0});
    while (!nodes_.empty()) {
        const auto [level, index] = nodes_.back();
        nodes_.pop_back();
        if (!(std::sqrt(square_to(hierarchy_.box(level, index), at_, {})) <=
              reach(hierarchy_.largest_weight(level, index))))
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
