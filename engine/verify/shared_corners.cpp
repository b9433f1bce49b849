#include "verify/shared_corners.hpp"

#include <algorithm>
#include <limits>

#include "core/at.hpp"
#include "core/scrambled.hpp"

namespace votess {
namespace {

constexpr std::uint32_t seed_code = 4;
// The factor of the j-th of k seeds is number 4 (k - 1) + j. Those of k seeds sum to 0.
constexpr std::array<std::uint64_t, 16> shares{0,
                                               0,
                                               0,
                                               0,  //
                                               factor_a,
                                               -factor_a,
                                               0,
                                               0,  //
                                               factor_b,
                                               factor_c,
                                               -(factor_b + factor_c),
                                               0,  //
                                               factor_d,
                                               factor_e,
                                               factor_f,
                                               -(factor_d + factor_e + factor_f)};

}  // namespace

void SharedCorners::look_along(const RowPolytope& polytope, std::size_t direction) {
    for (std::size_t f = 0; f < sides_.size(); ++f)
        static_cast<SeenNormal&>(sides_[f]) = seen_along(polytope.arrays(), f, direction);
}

bool SharedCorners::has_one_top(const RowPolytope& polytope) {
    int tops = 0;
    for (const RowPolytope::Fan& fan : polytope.fans())
        tops += top_of(sides_[at(fan.plane(0))], sides_[at(fan.plane(1))], sides_[at(fan.plane(2))]);
    return tops == 1;
}

void SharedCorners::name_sides(const RowPolytope& polytope, std::size_t seed) {
    const auto self = static_cast<std::int32_t>(seed);
    const std::span<const RowPolytope::Name> names = polytope.names();
    for (std::size_t f = 0; f < names.size(); ++f) {
        const RowPolytope::Name& other = names[f];
        Side& side = sides_[f];
        side.random = random_of(other.id);
        const bool is_before = other.id != self ? other.id < self : other.shift < exact::Shift{};
        side.code = other.id < 0 ? 0 : seed_code + (is_before ? 1 : 0);
        const bool is_lower = other.id >= 0 && is_before;
        side.as_left = is_lower ? std::numeric_limits<std::int32_t>::max() : static_cast<std::int32_t>(f);
        side.as_right = is_lower ? -1 : static_cast<std::int32_t>(f);
        if (images_.empty()) continue;
        side.shift = side.products = side.squares = 0;
        if (other.id < 0 || is_zero(other.shift)) continue;
        side.shift = static_cast<std::uint64_t>(other.shift[0]) * factor_a +
                     static_cast<std::uint64_t>(other.shift[1]) * factor_b +
                     static_cast<std::uint64_t>(other.shift[2]) * factor_c;
        side.products = side.random * side.shift;
        side.squares = side.shift * side.shift;
    }
}

bool SharedCorners::is_within_walls(const RowPolytope& polytope, std::size_t seed, int corner) {
    if (walls_of_ != seed) {
        walls_.clear();
        walls_of_ = seed;
        for (std::int32_t id = -1; - id <= planes_.walls(); --id)
            if (planes_.has_wall(id)) walls_.push_back({id, polytope.seen({id, {}})});
    }
    const RowPolytope::Corner& at = polytope.corners()[static_cast<std::size_t>(corner)];
    for (const auto& [id, plane] : walls_) {
        bool own = false;
        for (const int f : at.planes) own |= polytope.name(f).id == id;
        if (!own && !polytope.is_surely_inside(corner, plane)) return false;
    }
    return true;
}

// Whether the lowest of the seeds of a corner is seen without a shift. Then its cell has the corner at the same place.
inline bool SharedCorners::has_first_in_place(const RowPolytope& polytope, std::array<int, 3> planes) const {
    std::ranges::sort(planes);  // walls come first, seeds ascend
    for (const int f : planes)
        if (sides_[at(f)].code != 0) return is_zero(polytope.name(f).shift);
    return true;
}

template <bool with_images>
bool SharedCorners::add_names(const RowPolytope& polytope, std::size_t seed) {
    const std::span<const RowPolytope::Fan> fans = polytope.fans();
    const std::int32_t* const vertices = polytope.vertices().data();
    const Side* const sides = sides_.data();
    const std::uint64_t own = random_of(static_cast<std::int32_t>(seed));
    first_.resize(fans.size() + 1);
    edges_.resize(3 * fans.size() + 1);
    int* first = first_.data();
    int* edge = edges_.data();
    std::uint64_t names = 0;
    int tops = 0;
    for (int v = 0; v < static_cast<int>(fans.size()); ++v) {
        const RowPolytope::Fan& fan = fans[at(v)];
        const int a = fan.plane(0), b = fan.plane(1), c = fan.plane(2);
        const Side &A = sides[a], &B = sides[b], &C = sides[c];
        tops += top_of(A, B, C);
        const std::uint32_t code = A.code + B.code + C.code;
        // The planes ascend. So this is the turn of the seeds in their order.
        const std::uint32_t turn = (a < b ? 1u : 0u) ^ (b < c ? 1u : 0u) ^ (a < c ? 1u : 0u) ^ (code & 1);
        std::uint64_t sum = own + A.random + B.random + C.random;
        std::int32_t vertex = vertices[v];
        const bool is_first = code % seed_code == 0;
        *first = v;
        if constexpr (with_images) {
            // Neither the order of seeds nor a shift of all changes sums of (r - r')(s - s') and (s - s')^2 over pairs.
            const std::uint64_t count = code / seed_code + 1, shift = A.shift + B.shift + C.shift,
                                products = A.products + B.products + C.products,
                                squares = A.squares + B.squares + C.squares;
            std::uint64_t random = own;
            for (const Side* side : {&A, &B, &C}) random += side->code == 0 ? 0 : side->random;
            sum += (count * products - random * shift) * factor_b + (count * squares - shift * shift) * factor_c;
            const std::int32_t original = images_[at(vertex)];
            if (original != vertex) {
                if (is_first) return false;
                to_compare_.push_back(v);
            } else if (!is_first && !has_first_in_place(polytope, {a, b, c})) {
                return false;
            }
            vertex = original;
        }
        names += scrambled(sum + static_cast<std::uint32_t>(vertex) * factor_e + turn * factor_f) * shares[code];
        first += is_first ? 1 : 0;
        *edge = 4 * v;
        edge += A.as_left < C.as_right ? 1 : 0;
        *edge = 4 * v + 1;
        edge += B.as_left < A.as_right ? 1 : 0;
        *edge = 4 * v + 2;
        edge += C.as_left < B.as_right ? 1 : 0;
    }
    names_ += names;
    first_.resize(static_cast<std::size_t>(first - first_.data()));
    edges_.resize(static_cast<std::size_t>(edge - edges_.data()));
    if (tops == 1) return true;
    look_along(polytope, 1);
    return has_one_top(polytope);
}

// D
bool SharedCorners::check_edges(RowPolytope& polytope) {
    const std::span<const RowPolytope::Fan> fans = polytope.fans();
    for (const int edge : edges_) {
        const std::size_t k = at(edge % 4);
        const int from = edge / 4, to = fans[at(from)].after(k), left = fans[at(from)].plane(k),
                  right = fans[at(from)].plane(k == 0 ? 2 : k - 1);
        const bool turned = placed_[at(from)] == 0 && placed_[at(to)] != 0;
        const int v = turned ? to : from;
        if (placed_[at(v)] == 0) {
            placed_[at(v)] = 1;
            if (!polytope.place_corner(v)) return false;
        }
        const RowPolytope::Fan& other = fans[at(turned ? from : to)];
        if (!polytope.is_inside(v, other.plane(0) + other.plane(1) + other.plane(2) - left - right)) return false;
    }
    return true;
}

bool SharedCorners::add(RowPolytope& polytope, std::size_t seed) {
    sides_.resize(at(polytope.planes()));
    placed_.assign(polytope.fans().size(), 0);
    to_compare_.clear();
    name_sides(polytope, seed);
    look_along(polytope, 0);
    if (!(images_.empty() ? add_names<false>(polytope, seed) : add_names<true>(polytope, seed))) return false;
    for (const int v : to_compare_) {
        placed_[at(v)] = 1;
        if (!polytope.place_corner(v)) return false;
    }
    for (const int v : first_) {  // C
        placed_[at(v)] = 1;
        if (!polytope.place_corner(v)) return false;
        const auto& [a, b, c] = polytope.corners()[at(v)].planes;
        const bool on_wall = sides_[at(std::min({a, b, c}))].code == 0;
        if (on_wall && !is_within_walls(polytope, seed, v)) return false;
        if (images_.empty()) continue;
        const PlaneArrays& p = polytope.arrays();
        volume_ += filter_bound * p.length[at(a)] * p.length[at(b)] * p.length[at(c)] /
                   (6 * polytope.corners()[at(v)].constant);
    }
    to_compare_.insert(to_compare_.end(), first_.begin(), first_.end());
    return check_edges(polytope);
}

}  // namespace votess
