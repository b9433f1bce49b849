#include "verify/shared_corners.hpp"

#include "core/scrambled.hpp"

namespace votess {
namespace {

constexpr std::uint32_t seed_code = 4, four_seeds = 3 * seed_code;
// Odd numbers without a pattern, which make sums of different terms differ.
constexpr std::uint64_t factor_a = 0x8ebc6af09c88c6e3, factor_b = 0x589965cc75374cc3, factor_c = 0x1d8e4e27c47d124f,
                        factor_d = 0xd6e8feb86659fd93, factor_e = 0xa0761d6478bd642f, factor_f = 0xe7037ed1a0b428db;

// The factor of the j-th of k seeds is number 4 (k - 1) + j. Those of k seeds sum to 0.
constexpr std::array<std::uint64_t, 16> shares{
    0,        0,        0,                      0,  //
    factor_a, -factor_a, 0,                     0,  //
    factor_b, factor_c, -(factor_b + factor_c), 0,  //
    factor_d, factor_e, factor_f,               -(factor_d + factor_e + factor_f)};

// Orthogonal triples: e, and two directions across it. Nothing lies along them in a common lattice.
using Frame = std::array<Vector3, 2>;
constexpr std::array<Frame, 2> frames{
    Frame{Vector3{0.3651483716701107, -0.8164965809277260, 0.4472135954999579},
          Vector3{0.8428282480371107, 0.4985132179123381, 0.2030197431285120}},
    Frame{Vector3{-0.7129384012837465, 0.2918374650192837, 0.6374829103847561},
          Vector3{0.2219384756102938, 0.9411029384756102, -0.2549182736450192}}};

}  // namespace

// A. The sign of det(e, f, g) is that of the turn from f to g about e. Frames need not be orthogonal: e is at right
// angles to both vectors, and any linear map of these keeps or turns all signs. Bounds as in row_polytope.hpp.
bool SharedCorners::has_one_top(const RowPolytope& polytope, std::size_t direction) {
    const auto& [first, second] = frames[direction];
    const PlaneArrays& p = polytope.arrays();
    for (std::size_t f = 0; f < sides_.size(); ++f) {
        const double inverse = 1 / p.length[f];
        sides_[f].across = (p.nx[f] * first[0] + p.ny[f] * first[1] + p.nz[f] * first[2]) * inverse;
        sides_[f].along = (p.nx[f] * second[0] + p.ny[f] * second[1] + p.nz[f] * second[2]) * inverse;
    }
    std::size_t tops = 0, others = 0;
    for (const RowPolytope::Fan& fan : polytope.fans()) {
        const Side &a = sides_[static_cast<std::size_t>(fan.planes[0])],
                   &b = sides_[static_cast<std::size_t>(fan.planes[1])],
                   &c = sides_[static_cast<std::size_t>(fan.planes[2])];
        const double ab = a.across * b.along - a.along * b.across, bc = b.across * c.along - b.along * c.across,
                     ca = c.across * a.along - c.along * a.across;
        const double low = std::min(ab, bc), least = std::min(low, ca);
        tops += least > filter_bound ? 1 : 0;
        others += least < -filter_bound ? 1 : 0;
    }
    return tops == 1 && others + 1 == polytope.fans().size();
}

void SharedCorners::name_sides(const RowPolytope& polytope, std::size_t seed) {
    const auto self = static_cast<std::int32_t>(seed);
    const std::span<const RowPolytope::Name> names = polytope.names();
    for (std::size_t f = 0; f < names.size(); ++f) {
        const RowPolytope::Name& other = names[f];
        Side& side = sides_[f];
        side.random = scrambled(0x243f6a8885a308d3 + static_cast<std::uint32_t>(other.id));
        const bool is_before = other.id != self ? other.id < self : other.shift < exact::Shift{};
        side.code = other.id < 0 ? 0 : seed_code + (is_before ? 1 : 0);
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
        for (std::int32_t id = -1; -id <= planes_.walls(); --id)
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

bool SharedCorners::add(RowPolytope& polytope, std::size_t seed) {
    const auto fans = polytope.fans();
    const auto vertices = polytope.vertices();
    const auto n = static_cast<std::size_t>(polytope.planes());
    sides_.resize(n);
    codes_.resize(fans.size());
    placed_.assign(fans.size(), 0);
    to_compare_.clear();
    if (!has_one_top(polytope, 0) && !has_one_top(polytope, 1)) return false;
    name_sides(polytope, seed);
    const std::uint64_t own = scrambled(0x243f6a8885a308d3 + static_cast<std::uint32_t>(seed));
    const auto place = [&](std::size_t v) {  // C
        if (placed_[v] != 0) return true;
        placed_[v] = 1;
        return polytope.place_corner(static_cast<int>(v));
    };
    bool good = true;
    for (std::size_t v = 0; v < fans.size(); ++v) {
        const auto& [a, b, c] = fans[v].planes;
        const Side &A = sides_[static_cast<std::size_t>(a)], &B = sides_[static_cast<std::size_t>(b)],
                   &C = sides_[static_cast<std::size_t>(c)];
        const std::uint32_t code = A.code + B.code + C.code;
        codes_[v] = code;
        // The planes ascend. So this is the turn of the seeds in their order.
        const unsigned turn = (a < b ? 1u : 0u) ^ (b < c ? 1u : 0u) ^ (a < c ? 1u : 0u) ^ (code & 1);
        std::int32_t vertex = vertices[v];
        std::uint64_t sum = own + A.random + B.random + C.random;
        bool is_image = false;
        if (!images_.empty()) {
            // Neither the order of seeds nor a shift of all changes sums of (r - r')(s - s') and (s - s')^2 over pairs.
            const std::uint64_t count = code / seed_code + 1, shift = A.shift + B.shift + C.shift,
                                products = A.products + B.products + C.products,
                                squares = A.squares + B.squares + C.squares;
            std::uint64_t random = own;
            for (const Side* side : {&A, &B, &C}) random += side->code == 0 ? 0 : side->random;
            sum = sum * factor_a + (count * products - random * shift) * factor_b +
                  (count * squares - shift * shift) * factor_c;
            const std::int32_t original = images_[static_cast<std::size_t>(vertex)];
            is_image = original != vertex;
            vertex = original;
        }
        names_ += scrambled(sum + static_cast<std::uint32_t>(vertex) * factor_e + turn * factor_f) * shares[code];
        const bool is_first = code % seed_code == 0;
        if (is_first) good = good && place(v) && (code == four_seeds || is_within_walls(polytope, seed, static_cast<int>(v)));
        if (is_first && !images_.empty()) {
            good = good && !is_image;
            const PlaneArrays& p = polytope.arrays();
            volume_ += filter_bound * p.length[static_cast<std::size_t>(a)] * p.length[static_cast<std::size_t>(b)] *
                       p.length[static_cast<std::size_t>(c)] / (6 * polytope.corners()[v].constant);
        }
        if (is_image) good = good && place(v);
        if (is_first || is_image) to_compare_.push_back(static_cast<int>(v));
    }
    if (!good) return false;
    for (std::size_t v = 0; v < fans.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) {  // D
            const auto to = static_cast<std::size_t>(fans[v].after[k]);
            const int f = fans[v].planes[k], g = fans[v].planes[k == 0 ? 2 : k - 1];
            const std::uint32_t before = sides_[static_cast<std::size_t>(f)].code | sides_[static_cast<std::size_t>(g)].code;
            if (v > to || (before & 1) != 0) continue;
            const std::size_t at = placed_[v] == 0 && placed_[to] != 0 ? to : v;
            const auto& [a, b, c] = fans[at == v ? to : v].planes;
            if (!place(at) || !polytope.is_inside(static_cast<int>(at), a + b + c - f - g)) return false;
        }
    return true;
}

}  // namespace votess
