// The alpha complex, from the dual of the mesh: tetrahedra first, in the plane triangles, then the faces of each
// dimension from the simplices above. Points of the plane have z = 0 here.
//
// A simplex shows its faces which of them have another seed inside their smallest sphere (exact/orthosphere.hpp). The
// seeds of the simplices around a face are enough for that. Proof: let f be the convex function that is |x|^2 - w at
// the seeds and linear in each tetrahedron. The sphere of the face belongs to an affine function A, and f - A is 0 on
// the face. If f - A is not negative at the seeds around, the face is a local minimum, and so a global one. Ties do
// not matter: any triangulation of the polytopes has the same f.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/buffer.hpp"
#include "core/progress.hpp"
#include "core/system.hpp"
#include "domain/domain.hpp"
#include "exact/insphere.hpp"
#include "exact/orthosphere.hpp"
#include "input/domain_of_result.hpp"
#include "input/settle.hpp"
#include "input/supports.hpp"
#include "mesh/dual.hpp"
#include "plane/sheet.hpp"
#include "result/handle.hpp"
#include "unbounded/endless_box.hpp"
#include "votess/alpha.hpp"

namespace votess {
namespace {

using detail::Result;
using Replicate = std::array<std::int32_t, 3>;
constexpr std::size_t simplices_per_stop = 4096;

[[noreturn]] void refuse_alpha(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, "alpha_complex(): " + message);
}

[[noreturn]] void refuse_small(const std::string& text, const Replicate& replicate) {
    const std::int32_t more = *std::ranges::max_element(replicate) + 1;
    refuse_alpha(text + ": the box is too small for these seeds, replicate it " + std::to_string(more) +
                 " times or more along each vector");
}

// Reserves memory, in huge pages where it is large.
template <class T>
void reserve_huge(std::vector<T>& v, std::size_t count) {
    constexpr std::size_t page = std::size_t{2} << 20;
    v.reserve(count);
    auto* const memory = reinterpret_cast<std::byte*>(v.data());
    const std::size_t bytes = v.capacity() * sizeof(T), before = -reinterpret_cast<std::uintptr_t>(memory) % page;
    if (bytes >= before + page) system::prefer_huge_pages(memory + before, (bytes - before) / page * page);
}

exact::Point scaled_point(std::span<const double> points, std::size_t i, std::size_t dimensions, double scale) {
    exact::Point x{};
    for (std::size_t k = 0; k < dimensions; ++k) x[k] = points[dimensions * i + k] * scale;
    return x;
}

bool is_periodic(const Tessellation& t) {
    return t.periodic() != std::array<bool, 3>{};
}

std::size_t dimensions_of(const Tessellation& t) {
    return t.planar() ? 2 : 3;
}

// Returns the job of a periodic domain in space, with ends, with the weights of t. sheet: where the points of a plane
// stay.
Job periodic_job(const Tessellation& t, Region domain, std::span<const double> points, std::optional<Sheet>& sheet) {
    Settled run = run_of(t, points);
    run.region = std::move(domain);
    if (t.planar()) run = sheet.emplace(std::move(run)).in_space();
    if (EndlessSides(run.region).any()) end_near(run.region, run.points, run.weights);
    return make_job(std::move(run));
}

// Where the seeds lie exactly, at order one, and the copies of a periodic box.
class Places {
public:
    // added: the number of seeds at the end that are not the caller's. given: the domain whose ends may slant, so that
    // it wraps seeds to other places.
    Places(const Tessellation& t, std::span<const double> points, std::size_t added, const Tessellation& given,
           const Replicate& replicate)
        : count_(t.size()),
          added_(added),
          dimensions_(dimensions_of(t)),
          replicate_(replicate),
          copies_(replicate[0] * replicate[1] * replicate[2]) {
        std::vector<double> weights;
        if (is_periodic(t)) {
            std::optional<Sheet> sheet;
            const Job job = periodic_job(t, region_of(t), points, sheet);
            domain_ = job.domain;
            scale_ = job.scale;
            weights = domain_->weights;
        } else {
            double largest = 0;
            for (const double x : points) largest = std::max(largest, std::abs(x));
            scale_ = scale_for(largest);
            for (const double weight : t.weights()) weights.push_back(weight * scale_ * scale_);
        }
        is_weighted_ = !weights.empty();
        reserve_huge(seeds_, count_);
        for (std::size_t i = 0; i < count_; ++i)
            seeds_.push_back({scaled_point(points, i, dimensions_, scale_), is_weighted_ ? weights[i] : 0});
        if (domain_ == nullptr) return;
        wraps_.resize(count_);
        for (std::size_t i = 0; i < count_; ++i) wraps_[i] = wrap(*domain_, point(i)).value_or(exact::Shift{});
        if (!given.cell() || EndlessSides(region_of(given)).any()) return;
        std::optional<Sheet> sheet;
        const Job job = periodic_job(t, region_of(given), points, sheet);
        for (std::size_t i = 0; i < count_; ++i) {
            exact::Point x = point(i);
            for (double& c : x) c = c / scale_ * job.scale;
            const exact::Shift there = wrap(*job.domain, x).value_or(exact::Shift{});
            homes_.push_back({});
            for (std::size_t k = 0; k < 3; ++k) homes_[i][k] = static_cast<std::int8_t>(wraps_[i][k] - there[k]);
            wraps_[i] = there;
        }
    }

    [[nodiscard]] bool periodic() const { return domain_ != nullptr; }
    [[nodiscard]] std::size_t seeds() const { return count_; }
    [[nodiscard]] std::size_t dimensions() const { return dimensions_; }
    [[nodiscard]] std::size_t copies() const { return at(copies_); }
    [[nodiscard]] bool any_added() const { return added_ > 0; }
    [[nodiscard]] bool is_added(std::int32_t id) const { return original(id) >= count_ - added_; }
    [[nodiscard]] bool has_added(std::span<const std::int32_t> ids) const {
        return any_added() && std::ranges::any_of(ids, [&](std::int32_t id) { return is_added(id); });
    }
    // Returns the id of a seed where none is added.
    [[nodiscard]] std::int32_t without_added(std::int32_t id) const {
        return id - static_cast<std::int32_t>(added_ * (at(id) / count_));
    }
    [[nodiscard]] double weight(std::int32_t id) const { return seeds_[original(id)].weight; }
    [[noreturn]] void refuse(const std::string& text) const { refuse_small(text, replicate_); }
    // Returns a squared length in the unit of the caller.
    [[nodiscard]] double unscaled(double square) const { return square / scale_ / scale_; }

    // Loads a seed into the cache: seeds in random order are far apart in memory.
    void prefetch(std::int32_t id) const { __builtin_prefetch(&seeds_[original(id)]); }
    // Returns a member of the dual with its shift from the place in the given domain.
    [[nodiscard]] Member at_home(const Member& m) const {
        return homes_.empty() ? m : Member{m.seed, sum(m.shift, homes_[at(m.seed)])};
    }
    // Returns the member of the large box that a member of a copy is.
    [[nodiscard]] Member in_copy(const Member& m, std::size_t copy) const {
        if (copies_ == 1) return m;
        std::array<std::int32_t, 3> place = place_of(copy);
        Member out{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t to = place[k] + m.shift[k], period = replicate_[k];
            const std::int32_t turns = to >= 0 ? to / period : -((period - 1 - to) / period);
            place[k] = to - turns * period;
            out.shift[k] = static_cast<std::int8_t>(turns);
        }
        const std::int32_t number = (place[0] * replicate_[1] + place[1]) * replicate_[2] + place[2];
        out.seed = static_cast<std::int32_t>(at(m.seed) + count_ * at(number));
        return out;
    }

    // Returns the smallest orthogonal sphere of members with ascending ids.
    template <std::size_t K>
    [[nodiscard]] exact::Orthosphere<K> sphere(const std::array<Member, K + 1>& members) const {
        const std::size_t first = original(members[0].seed);
        const exact::Point from = point(first);
        const double own = seeds_[first].weight;
        std::array<Vector3, K> seen;
        std::array<double, K> powers{};
        std::array<exact::Shift, K> shifts{};
        for (std::size_t i = 0; i < K; ++i) {
            const std::size_t seed = original(members[i + 1].seed);
            if (periodic()) shifts[i] = between(members[0], members[i + 1]);
            seen[i] = minus(point(seed), from);
            if (shifts[i] != exact::Shift{}) {
                const exact::Differences d = image_differences(from, bisector(seed, shifts[i]));
                for (std::size_t k = 0; k < 3; ++k) seen[i][k] = d.x[k].high;
            }
            powers[i] = own - seeds_[seed].weight;
        }
        if (const auto sure = exact::sure_orthosphere<K>(seen, powers, own)) return *sure;
        std::array<exact::Plane, K> bisectors;
        for (std::size_t i = 0; i < K; ++i) {
            const std::size_t seed = original(members[i + 1].seed);
            bisectors[i] = bisector(seed, shifts[i]);
            if (is_weighted_) bisectors[i].power = exact::two_sum(own, -seeds_[seed].weight);
        }
        return exact::orthosphere<K>(from, own, bisectors);
    }
    // See TurnSeenFrom.
    [[nodiscard]] int turn(const Member& from, const std::array<Member, 3>& around) const {
        std::array<exact::Plane, 3> planes;
        for (std::size_t i = 0; i < 3; ++i)
            planes[i] = bisector(at(around[i].seed), image_between(at_home(from), at_home(around[i])));
        return exact::orientation(point(at(from.seed)), planes[0], planes[1], planes[2]);
    }

private:
    [[nodiscard]] std::size_t original(std::int32_t id) const { return copies_ == 1 ? at(id) : at(id) % count_; }
    [[nodiscard]] std::array<std::int32_t, 3> place_of(std::size_t copy) const {
        const auto number = static_cast<std::int32_t>(copy);
        return {number / replicate_[2] / replicate_[1], number / replicate_[2] % replicate_[1], number % replicate_[2]};
    }
    [[nodiscard]] const exact::Point& point(std::size_t i) const { return seeds_[i].point; }
    [[nodiscard]] exact::Plane bisector(std::size_t seed, const exact::Shift& shift) const {
        return periodic() ? exact::Plane::bisector(point(seed), shift, domain_->lattice)
                          : exact::Plane::bisector(point(seed));
    }
    // Returns the shift of one seed's point as seen from another's, in one box.
    [[nodiscard]] exact::Shift image_between(const Member& from, const Member& to) const {
        exact::Shift shift{};
        for (std::size_t k = 0; k < 3 && periodic(); ++k)
            shift[k] = wraps_[at(to.seed)][k] + to.shift[k] - wraps_[at(from.seed)][k] - from.shift[k];
        return shift;
    }
    // Returns the same in the large box.
    [[nodiscard]] exact::Shift between(const Member& from, const Member& to) const {
        const exact::Shift a = shift_of(from), b = shift_of(to);
        return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    }
    [[nodiscard]] exact::Shift shift_of(const Member& m) const {
        exact::Shift shift = wraps_[original(m.seed)];
        if (copies_ == 1) {
            for (std::size_t k = 0; k < 3; ++k) shift[k] += m.shift[k];
            return shift;
        }
        const auto place = place_of(at(m.seed) / count_);
        for (std::size_t k = 0; k < 3; ++k) shift[k] += place[k] + replicate_[k] * m.shift[k];
        return shift;
    }

    std::size_t count_, added_, dimensions_;
    Replicate replicate_;
    std::int32_t copies_;
    double scale_ = 1;
    std::shared_ptr<const Domain> domain_;  // null unless periodic
    struct alignas(32) Seed {               // on one line of the cache
        exact::Point point;
        double weight;
    };
    std::vector<Seed> seeds_;
    bool is_weighted_ = false;
    std::vector<exact::Shift> wraps_;  // that bring the seeds into the given domain
    std::vector<ByteShift> homes_;     // from there to the places of the dual; empty: 0
};

// One simplex with K + 1 seeds.
template <std::size_t K>
struct Simplex {
    std::array<std::int32_t, K + 1> ids;  // ascending
    std::array<ByteShift, K + 1> shifts;  // the first is 0

    [[nodiscard]] std::array<Member, K + 1> members() const {
        std::array<Member, K + 1> out;
        for (std::size_t i = 0; i <= K; ++i) out[i] = {ids[i], shifts[i]};
        return out;
    }
};

// Where the seeds of a simplex lie, each seen from the smallest sphere of the face opposite to it. Bit i: seed i lies
// strictly outside. Bit 4 + i: strictly inside.
using SeedSides = std::uint8_t;

template <std::size_t K>
SeedSides sides_of(const exact::Orthosphere<K>& sphere) {
    unsigned sides = 0;
    for (std::size_t i = 0; i <= K; ++i) {
        sides |= static_cast<unsigned>(sphere.signs[i] > 0) << i;
        sides |= static_cast<unsigned>(sphere.signs[i] < 0) << (4 + i);
    }
    return static_cast<SeedSides>(sides);
}

// A simplex of the highest dimension.
template <std::size_t D>
struct Whole {
    Simplex<D> simplex;
    SeedSides sides;
    double value;
};

// Makes the simplices of the highest dimension: those of the dual, and the parts of its polytopes.
template <std::size_t D>
class Cutter {
public:
    Cutter(const Result& result, const Delaunay& dual, const Places& places)
        : result_(result), dual_(dual), places_(places) {}

    std::vector<Whole<D>> cut() {
        const std::size_t whole = dual_.tetrahedra.size() / corners_of;
        reserve_huge(out_, places_.copies() * whole);
        constexpr std::size_t ahead = 64;  // corners
        for (std::size_t t = 0; t < whole; ++t) {
            const std::size_t first = corners_of * t;
            for (std::size_t k = first + ahead; k < std::min(first + ahead + corners_of, dual_.tetrahedra.size()); ++k)
                places_.prefetch(dual_.tetrahedra[k]);
            std::array<Member, corners_of> corners;
            for (std::size_t k = 0; k < corners_of; ++k)
                corners[k] =
                    places_.at_home({dual_.tetrahedra[first + k], shift_in(dual_.tetrahedra_shifts, first + k, 1, D)});
            for (std::size_t copy = 0; copy < places_.copies(); ++copy) add(in_copy(corners, copy));
        }
        if (!dual_.polytope_centers.empty()) cut_polytopes();
        return std::move(out_);
    }

private:
    static constexpr std::size_t corners_of = D + 1;  // a simplex

    template <std::size_t N>
    [[nodiscard]] std::array<Member, N> in_copy(std::array<Member, N> members, std::size_t copy) const {
        for (Member& m : members) m = places_.in_copy(m, copy);
        return members;
    }

    void add(std::array<Member, corners_of> corners) {
        if (out_.size() % simplices_per_stop == 0) check_stop();
        std::ranges::sort(corners, {}, &Member::seed);
        Simplex<D> simplex{};
        for (std::size_t k = 0; k < corners_of; ++k) {
            const bool twice = k > 0 && corners[k].seed == corners[k - 1].seed;
            if (twice && places_.is_added(corners[k].seed)) return;  // others have its faces that count
            if (twice) places_.refuse("an edge joins seed " + std::to_string(corners[k].seed) + " to its own image");
            simplex.ids[k] = corners[k].seed;
            simplex.shifts[k] = sum(corners[k].shift, negative(corners[0].shift));
        }
        const exact::Orthosphere<D> sphere = places_.sphere<D>(simplex.members());
        out_.push_back({simplex, sides_of(sphere), places_.unscaled(sphere.square)});
    }

    // All parts of a polytope have the same empty sphere.
    void cut_polytopes() {
        PolytopeFacets facets;
        if constexpr (D == 3)
            facets = polytope_facets(result_, dual_, [&](const Member& from, const std::array<Member, 3>& around) {
                return places_.turn(from, around);
            });
        for (std::size_t p = 0; p < dual_.polytope_centers.size(); ++p)
            for (std::size_t copy = 0; copy < places_.copies(); ++copy) {
                const std::size_t first = out_.size();
                if constexpr (D == 3)
                    cut_polytope(facets, p, copy);
                else
                    cut_polygon(p, copy);
                for (std::size_t t = first; t < out_.size(); ++t) out_[t].value = out_[first].value;
            }
    }
    [[nodiscard]] std::vector<Member> members_of(std::size_t p, std::size_t copy) const {
        std::vector<Member> members;
        for (auto k = at(dual_.polytope_indptr[p]); k < at(dual_.polytope_indptr[p + 1]); ++k)
            members.push_back(places_.in_copy(
                places_.at_home({dual_.polytope_indices[k], shift_in(dual_.polytope_shifts, k, 1, D)}), copy));
        return members;
    }
    static std::size_t lowest_of(std::span<const Member> members) {
        return static_cast<std::size_t>(std::ranges::min_element(members) - members.begin());
    }
    // A polygon is a fan around its lowest seed.
    void cut_polygon(std::size_t p, std::size_t copy) {
        std::vector<Member> members = members_of(p, copy);
        std::ranges::rotate(members, members.begin() + static_cast<std::ptrdiff_t>(lowest_of(members)));
        for (std::size_t k = 1; k + 1 < members.size(); ++k) add({members[0], members[k], members[k + 1]});
    }
    void cut_polytope(const PolytopeFacets& facets, std::size_t p, std::size_t copy) {
        std::vector<Member> members = members_of(p, copy);
        const Member lowest = members[lowest_of(members)];
        for (std::size_t f = facets.facet_begin[p]; f < facets.facet_begin[p + 1]; ++f) {
            members.clear();
            for (std::size_t k = facets.corner_begin[f]; k < facets.corner_begin[f + 1]; ++k)
                members.push_back(places_.in_copy(places_.at_home(facets.corners[k]), copy));
            if (std::ranges::find(members, lowest) != members.end()) continue;
            std::ranges::rotate(members, members.begin() + static_cast<std::ptrdiff_t>(lowest_of(members)));
            for (std::size_t k = 1; k + 1 < members.size(); ++k) add({lowest, members[0], members[k], members[k + 1]});
        }
    }

    const Result& result_;
    const Delaunay& dual_;
    const Places& places_;
    std::vector<Whole<D>> out_;
};

// Refuses edges between neighbors that have the same ends, or one seed as both. Cells of added seeds reach so far
// around that such edges may be in none of the simplices. count: of seeds, without added ones.
void check_edges(const Tessellation& t, std::size_t count, const Replicate& replicate) {
    const auto same = [&](const auto& a, const auto& b) {  // the same copy
        for (std::size_t k = 0; k < a.size(); ++k)
            if ((a[k] - b[k]) % replicate[k] != 0) return false;
        return true;
    };
    const std::size_t size = dimensions_of(t);  // numbers of a shift
    const std::vector<std::int8_t> none(size);
    for (std::size_t i = 0; i < count; ++i) {
        if (i % simplices_per_stop == 0) check_stop();
        const auto shift = [&](std::size_t e) { return t.shifts().subspan(size * e, size); };
        for (auto e = at(t.indptr()[i]); e < at(t.indptr()[i + 1]); ++e) {
            const std::int32_t j = t.indices()[e];
            if (j < static_cast<std::int32_t>(i) || at(j) >= count) continue;
            if (at(j) == i && same(shift(e), std::span(none)))
                refuse_small("an edge joins seed " + std::to_string(i) + " to its own image", replicate);
            for (auto next = e + 1; next < at(t.indptr()[i + 1]) && t.indices()[next] == j; ++next)
                if (same(shift(e), shift(next)))
                    refuse_small("two edges join " +
                                     (at(j) == i ? "copies of seed " : "seeds " + std::to_string(i) + " and ") +
                                     std::to_string(j),
                                 replicate);
        }
    }
}

// Returns the edges between seeds on one line, which are those between neighbors.
std::vector<Whole<1>> edges_of_line(const Tessellation& t, const Places& places) {
    std::vector<Whole<1>> edges;
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (i % simplices_per_stop == 0) check_stop();
        for (const std::int32_t j : t.neighbors(i)) {
            if (j < static_cast<std::int32_t>(i)) continue;
            const Simplex<1> edge{{static_cast<std::int32_t>(i), j}, {}};
            const exact::Orthosphere<1> sphere = places.sphere<1>(edge.members());
            edges.push_back({edge, sides_of(sphere), places.unscaled(sphere.square)});
        }
    }
    return edges;
}

// A face, as a simplex sees it.
struct FaceSide {
    std::uint64_t key;   // the seeds of the face after its first
    std::uint64_t code;  // of side_of(), in this order: simplex, omitted seed, whether that lies outside, or inside
    double value;        // of the simplex

    [[nodiscard]] std::size_t simplex() const { return code >> 4; }
    [[nodiscard]] std::size_t omitted() const { return code >> 2 & 3; }
    [[nodiscard]] bool outside() const { return (code >> 1 & 1) != 0; }
    [[nodiscard]] bool inside() const { return (code & 1) != 0; }
};

// Simplices of one dimension, ascending.
template <std::size_t K>
struct Level {
    const AlphaSimplices& all;
    const Places& places;
    std::vector<SeedSides> sides;       // by simplex
    std::vector<std::size_t> first;     // by seed, and the end: the first simplex with this lowest seed
    std::vector<std::size_t> opposite;  // likewise: the first of the following with this lowest seed
    Buffer<FaceSide> opposite_sides{
        Buffer<FaceSide>::Pages::huge};  // of faces opposite to the lowest seed of a simplex

    [[nodiscard]] std::size_t size() const { return all.values.size(); }
    [[nodiscard]] FaceSide side_of(std::size_t simplex, std::size_t omitted) const {
        const std::int32_t* const ids = &all.seeds[(K + 1) * simplex];
        std::uint64_t key = 0;
        for (std::size_t i = omitted == 0 ? 2 : 1; i <= K; ++i)
            if (i != omitted) key = key << 32 | static_cast<std::uint32_t>(ids[i]);
        if (places.has_added({ids, K + 1}))
            return {key, simplex << 4 | omitted << 2 | 2, infinity};  // says nothing about the face
        const unsigned outside = sides[simplex] >> omitted & 1, inside = sides[simplex] >> (4 + omitted) & 1;
        return {key, simplex << 4 | omitted << 2 | outside << 1 | inside, all.values[simplex]};
    }
    // Fills the arrays after `sides`.
    void index(std::size_t seeds) {
        first.assign(seeds + 1, 0);
        opposite.assign(seeds + 2, 0);
        for (std::size_t t = 0; t < size(); ++t)
            ++first[at(all.seeds[(K + 1) * t]) + 1], ++opposite[at(all.seeds[(K + 1) * t + 1]) + 2];
        std::partial_sum(first.begin(), first.end(), first.begin());
        std::partial_sum(opposite.begin(), opposite.end(), opposite.begin());
        opposite_sides.resize_uninitialized(size());
        for (std::size_t t = 0; t < size(); ++t)
            opposite_sides[opposite[at(all.seeds[(K + 1) * t + 1]) + 1]++] = side_of(t, 0);
    }
};

// Collects from the simplices around a face.
struct Around {
    double least = infinity;  // of their values
    bool outside = true;      // all their seeds lie strictly outside
    bool inside = false;      // one lies strictly inside

    void add(const FaceSide& side) {
        least = std::min(least, side.value);
        outside = outside && side.outside();
        inside = inside || side.inside();
    }
    // Rounding must not put a face after the simplices around. A tie has one of their spheres.
    [[nodiscard]] double value(double own) const { return outside ? std::min(own, least) : least; }
};

template <std::size_t K>
void append(const Simplex<K>& s, double value, bool gabriel, const Places& places, AlphaSimplices& out) {
    out.seeds.insert(out.seeds.end(), s.ids.begin(), s.ids.end());
    if (places.periodic())
        for (const ByteShift& shift : s.shifts)
            out.shifts.insert(out.shifts.end(), shift.begin(), shift.begin() + places.dimensions());
    out.values.push_back(value);
    out.gabriel.push_back(static_cast<std::uint8_t>(gabriel));
}

template <std::size_t K>
void reserve(std::size_t count, const Places& places, AlphaSimplices& out) {
    reserve_huge(out.seeds, (K + 1) * count);
    if (places.periodic()) reserve_huge(out.shifts, places.dimensions() * (K + 1) * count);
    reserve_huge(out.values, count);
    reserve_huge(out.gabriel, count);
}

// Returns about how many facets simplices of this dimension have: as many as in the periodic case, and some for the
// hull.
std::size_t facets_of(std::size_t simplices, std::size_t dimension) {
    return (dimension + 1) * simplices / 2 + simplices / 16 + 4;
}

// Writes the simplices of the highest dimension in order.
template <std::size_t D>
Level<D> sorted_level(const std::vector<Whole<D>>& simplices, std::size_t seeds, const Places& places,
                      AlphaSimplices& out) {
    std::vector<std::size_t> begin(seeds + 2), order(simplices.size());
    for (const Whole<D>& t : simplices) ++begin[at(t.simplex.ids[0]) + 2];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (std::size_t i = 0; i < simplices.size(); ++i) order[begin[at(simplices[i].simplex.ids[0]) + 1]++] = i;
    Level<D> level{out, places, {}, {}, {}};
    reserve<D>(simplices.size(), places, out);
    level.sides.reserve(simplices.size());
    for (std::size_t v = 0; v < seeds; ++v) {
        if (v % simplices_per_stop == 0) check_stop();
        const auto own = std::span(order).subspan(begin[v], begin[v + 1] - begin[v]);
        for (const std::size_t i : own) __builtin_prefetch(&simplices[i]);
        std::ranges::sort(
            own, {}, [&](std::size_t i) -> const auto& { return simplices[i].simplex.ids; });
        for (const std::size_t i : own) {
            append(simplices[i].simplex, simplices[i].value, true, places, out);
            level.sides.push_back(simplices[i].sides);
        }
    }
    level.opposite_sides.resize_uninitialized(facets_of(simplices.size(), D));
    level.index(seeds);
    return level;
}

template <std::size_t K>
[[noreturn]] void refuse_double(const Simplex<K>& a, const Simplex<K>& b, const Places& places) {
    std::size_t k = 1;
    while (a.shifts[k] == b.shifts[k]) ++k;
    places.refuse("two edges join seeds " + std::to_string(a.ids[0]) + " and " + std::to_string(a.ids[k]));
}

// Returns the faces of all simplices of a level, and takes its memory. expected: about their number.
template <std::size_t K>
Level<K - 1> faces_of(Level<K>&& level, std::size_t expected, const Places& places, AlphaSimplices& out) {
    const std::size_t seeds = level.first.size() - 1;
    const auto face_of = [&](const FaceSide& side, std::size_t lowest) {
        Simplex<K - 1> face{};
        face.ids[0] = static_cast<std::int32_t>(lowest);
        for (std::size_t k = 1; k < K; ++k) face.ids[k] = static_cast<std::int32_t>(side.key >> 32 * (K - 1 - k));
        if (!places.periodic()) return face;
        for (std::size_t i = 0, k = 0; i <= K; ++i)
            if (i != side.omitted())
                face.shifts[k++] = shift_in(level.all.shifts, (K + 1) * side.simplex() + i, 1, places.dimensions());
        const ByteShift back = negative(face.shifts[0]);
        for (ByteShift& shift : face.shifts) shift = sum(shift, back);
        return face;
    };
    reserve<K - 1>(expected, places, out);
    Level<K - 1> faces{out, places, {}, {}, {}};
    if constexpr (K > 1) faces.sides.reserve(expected);
    std::vector<FaceSide> sides;
    for (std::size_t v = 0; v < seeds; ++v) {
        if (v % simplices_per_stop == 0) check_stop();
        const FaceSide* const opposite = level.opposite_sides.data();
        sides.assign(opposite + level.opposite[v], opposite + level.opposite[v + 1]);
        for (std::size_t t = level.first[v]; t < level.first[v + 1]; ++t)
            for (std::size_t i = 1; i <= K; ++i) sides.push_back(level.side_of(t, i));
        for (const FaceSide& side : sides) {
            places.prefetch(static_cast<std::int32_t>(side.key));
            if constexpr (K == 3) places.prefetch(static_cast<std::int32_t>(side.key >> 32));
        }
        std::ranges::sort(sides, {}, &FaceSide::key);
        for (auto begin = sides.begin(); begin != sides.end();) {
            const Simplex<K - 1> face = face_of(*begin, v);
            Around around;
            auto end = begin;
            for (; end != sides.end() && end->key == begin->key; ++end) {
                around.add(*end);
                if (places.periodic() && end != begin && !places.has_added(face.ids))
                    if (const auto other = face_of(*end, v); other.shifts != face.shifts)
                        refuse_double(face, other, places);
            }
            begin = end;
            double own;
            if constexpr (K == 1) {
                own = 0 - places.weight(face.ids[0]);
            } else {
                const exact::Orthosphere<K - 1> sphere = places.sphere<K - 1>(face.members());
                faces.sides.push_back(sides_of(sphere));
                own = sphere.square;
            }
            append(face, around.value(places.unscaled(own)), !around.inside, places, out);
        }
    }
    faces.opposite_sides = std::move(level.opposite_sides);
    if constexpr (K > 1) faces.index(seeds);
    return faces;
}

// Seeds that take part, and their diagram in the space of the complex.
struct WholeDiagram {
    Tessellation tessellation;
    std::vector<double> points;
    std::vector<std::int32_t> ids;  // of the rows; empty: all
    std::size_t added = 0;          // seeds at the end, see points_beside()
    bool line = false;              // all seeds lie on one; none is added then
};

bool has_cell(CellStatus status) {
    return status == CellStatus::certified;
}

// Returns points that make seeds in one plane span space: one beside the plane, two beside a line; in the plane one
// beside a line. Simplices without them are those of the plane. Wherever the points are, the seeds are a face
// of their convex hull.
std::vector<double> points_beside(std::span<const double> points, std::span<const CellStatus> status,
                                  std::size_t dimensions) {
    double largest = 0;
    for (const double x : points) largest = std::max(largest, std::abs(x));
    const double scale = scale_for(largest);
    const std::array<exact::Point, 4> corners{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    std::vector<exact::Point> seeds;
    for (std::size_t i = 0; i < status.size(); ++i)
        if (has_cell(status[i])) seeds.push_back(scaled_point(points, i, dimensions, scale));
    const exact::Point a = seeds[0], b = seeds[1];
    const auto not_in_line = [&](const exact::Point& c) {
        return std::ranges::any_of(corners, [&](const auto& corner) { return exact::orient(a, b, c, corner) != 0; });
    };
    std::vector<double> out;
    const auto add = [&](const exact::Point& x) {
        for (std::size_t k = 0; k < dimensions; ++k) out.push_back(x[k] / scale);
    };
    auto third = std::ranges::find_if(seeds, not_in_line);
    exact::Point c;
    if (third != seeds.end()) {
        c = *third;
    } else {
        c = *std::ranges::find_if(corners, not_in_line);
        add(c);
    }
    if (dimensions == 3)
        add(*std::ranges::find_if(corners, [&](const auto& corner) { return exact::orient(a, b, c, corner) != 0; }));
    return out;
}

// Returns the same in a domain that is periodic along some axes, as lists of points to try one after the other: beside
// a plane some point along the other axes is enough, beside a line two of them.
std::vector<std::vector<double>> images_beside(const Region& domain, const Tessellation& t,
                                               std::span<const double> points) {
    const auto first = std::ranges::find_if(t.status(), has_cell) - t.status().begin();
    const std::size_t dimensions = dimensions_of(t);
    double far = 0;  // no weight reaches so far
    for (const double x : points) far = std::max(far, std::abs(x));
    for (const double weight : t.weights()) far = std::max(far, std::sqrt(std::abs(weight)));
    if (far == 0) far = 1;
    std::vector<std::vector<double>> tries;
    std::vector<double> all;
    for (const int axis : endless_axes(t.planar() ? in_sheet(domain, 1) : domain)) {
        if (axis < 0) continue;
        std::vector<double> x(&points[dimensions * at(first)], &points[dimensions * at(first)] + dimensions);
        x[static_cast<std::size_t>(axis)] += 4 * far;
        all.insert(all.end(), x.begin(), x.end());
        tries.push_back(std::move(x));
    }
    if (tries.size() > 1) tries.push_back(std::move(all));
    return tries;
}

// Returns the space of the complex: the domain without ends.
Region space_of(const Tessellation& t) {
    Region region = region_of(t);
    region.walls.clear();
    if (!region.cell) {
        for (std::size_t k = 0; k < dimensions_of(t); ++k)
            if (!region.periodic[k]) region.box->lower[k] = -infinity, region.box->upper[k] = infinity;
        return region;
    }
    for (std::size_t k = 0; k < 3; ++k)
        if (!region.cell->periodic[k]) (k == 0 ? region.cell->a : k == 1 ? region.cell->b : region.cell->c) = {0, 0, 0};
    return region;
}

// Whether the polygons of a tessellation are those of all of its space.
bool has_whole_cells(const Tessellation& t) {
    const EndlessSides sides(region_of(t));
    bool whole = !t.face_offsets().empty() && t.least_face() == 0 && t.walls().empty();
    for (std::size_t k = 0; k < dimensions_of(t); ++k) {
        const auto lower = -1 - 2 * static_cast<std::int32_t>(k);
        whole = whole && (t.periodic()[k] || (sides.has(lower) && sides.has(lower - 1)));
    }
    return whole;
}

WholeDiagram whole_diagram(const Tessellation& t, std::span<const double> points) {
    WholeDiagram out{t, {points.begin(), points.end()}, {}};
    const std::size_t dimensions = dimensions_of(t);
    const bool periodic = is_periodic(t);
    std::vector<double> weights(t.weights().begin(), t.weights().end());
    const bool drops = std::ranges::find(t.status(), CellStatus::outside) != t.status().end();
    if (drops) {
        out.points.clear();
        weights.clear();
        for (std::size_t i = 0; i < t.size(); ++i) {
            if (t.status()[i] == CellStatus::outside) continue;
            out.ids.push_back(static_cast<std::int32_t>(i));
            out.points.insert(out.points.end(), &points[dimensions * i], &points[dimensions * i] + dimensions);
            if (!t.weights().empty()) weights.push_back(t.weights()[i]);
        }
    }
    const auto make = [&] {
        Settled run = run_of(t, out.points);
        run.region = space_of(t);
        run.weights = {weights};
        run.threads = t.stats().threads;
        run.want.volumes = false;
        run.want.faces = true;
        out.tessellation = tessellate(std::move(run));
    };
    if (!has_whole_cells(t) || drops) make();
    const auto status = out.tessellation.status();
    if (!out.tessellation.vertices().empty() || std::ranges::count_if(status, has_cell) < (periodic ? 1 : 2))
        return out;
    const std::vector<double> seeds = out.points;
    const auto tries = periodic ? images_beside(space_of(t), out.tessellation, seeds)
                                : std::vector<std::vector<double>>{points_beside(seeds, status, dimensions)};
    out.line = !periodic && tries[0].size() == dimensions * (dimensions - 1);
    if (out.line) return out;
    for (const std::vector<double>& beside : tries) {
        if (out.added > 0 && !out.tessellation.vertices().empty()) break;
        out.added = beside.size() / dimensions;
        out.points = seeds;
        out.points.insert(out.points.end(), beside.begin(), beside.end());
        if (!weights.empty()) weights.resize(out.points.size() / dimensions);
        make();
    }
    return out;
}

// Drops simplices with added seeds.
void drop_added(const Places& places, std::size_t corners, AlphaSimplices& simplices) {
    const std::size_t numbers = places.dimensions() * corners;  // of shifts
    std::size_t kept = 0;
    for (std::size_t s = 0; s < simplices.values.size(); ++s) {
        const std::span seeds(&simplices.seeds[corners * s], corners);
        if (places.has_added(seeds)) continue;
        std::ranges::transform(seeds, &simplices.seeds[corners * kept],
                               [&](std::int32_t id) { return places.without_added(id); });
        if (!simplices.shifts.empty())
            std::copy_n(&simplices.shifts[numbers * s], numbers, &simplices.shifts[numbers * kept]);
        simplices.values[kept] = simplices.values[s];
        simplices.gabriel[kept++] = simplices.gabriel[s];
    }
    simplices.seeds.resize(corners * kept);
    if (!simplices.shifts.empty()) simplices.shifts.resize(numbers * kept);
    simplices.values.resize(kept);
    simplices.gabriel.resize(kept);
}

}  // namespace

AlphaComplex alpha_complex(const Tessellation& tessellation, std::span<const double> points,
                           const std::array<std::int32_t, 3>& replicate) {
    require(tessellation, "alpha_complex");
    require_finite_points(tessellation, points, "alpha_complex");
    const auto& periodic = tessellation.periodic();
    const bool planar = tessellation.planar();
    if (planar && replicate[2] != 1)
        refuse_alpha("replicate holds " + std::to_string(replicate[2]) +
                     " for z, but points of the plane have none: give 1 there");
    double copies = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t n = replicate[k];
        if (n < 1) refuse_alpha("replicate holds " + std::to_string(n) + ": give numbers of copies, at least 1");
        if (n > 1 && !periodic[k])
            refuse_alpha(is_periodic(tessellation) ? "replicate copies the box along axis " + std::to_string(k) +
                                                         ", along which it does not repeat: give 1 there"
                                                   : "replicate copies a periodic box, this domain is not periodic");
        copies *= n;
    }
    if (copies * std::max(static_cast<double>(tessellation.size()), 1.0) > std::numeric_limits<std::int32_t>::max())
        throw Error(ErrorCode::unsupported, "alpha_complex(): replicate makes more than 2^31 seeds");

    const WholeDiagram diagram = whole_diagram(tessellation, points);
    const Places places(diagram.tessellation, diagram.points, diagram.added, tessellation, replicate);
    const std::size_t seeds = places.seeds() * places.copies();
    if (is_periodic(tessellation) && diagram.added > 0)
        check_edges(diagram.tessellation, diagram.tessellation.size() - diagram.added, replicate);
    AlphaComplex out;
    auto& [vertices, edges, triangles, tetrahedra] = out.simplices;
    const auto highest_level = [&]<std::size_t D>(std::integral_constant<std::size_t, D>, AlphaSimplices& simplices) {
        const Delaunay dual = delaunay(diagram.tessellation);
        Cutter<D> cutter(detail::result_of(diagram.tessellation), dual, places);
        return sorted_level<D>(cutter.cut(), seeds, places, simplices);
    };
    const auto add_faces = [&](Level<2>&& of_triangles, std::size_t max_edges) {
        faces_of<1>(faces_of<2>(std::move(of_triangles), max_edges, places, edges), seeds, places, vertices);
    };
    if (diagram.line) {
        faces_of<1>(sorted_level<1>(edges_of_line(diagram.tessellation, places), seeds, places, edges), seeds, places,
                    vertices);
    } else if (planar) {
        auto of_triangles = highest_level(std::integral_constant<std::size_t, 2>(), triangles);
        const std::size_t max_edges = seeds + of_triangles.size();  // by Euler's formula
        add_faces(std::move(of_triangles), max_edges);
    } else {
        auto level = highest_level(std::integral_constant<std::size_t, 3>(), tetrahedra);
        const std::size_t count = level.size();
        auto of_triangles = faces_of<3>(std::move(level), facets_of(count, 3), places, triangles);
        const std::size_t max_edges = seeds + of_triangles.size() - count;  // by Euler's formula
        add_faces(std::move(of_triangles), max_edges);
    }
    const auto status = diagram.tessellation.status();
    if (const auto only = std::ranges::find_if(status, has_cell); vertices.values.empty() && only != status.end()) {
        const auto id = static_cast<std::int32_t>(only - status.begin());
        append(Simplex<0>{{id}, {}}, places.unscaled(0 - places.weight(id)), true, places, vertices);
    }
    for (std::size_t k = 0; k < 4 && places.any_added(); ++k) drop_added(places, k + 1, out.simplices[k]);
    if (diagram.ids.empty()) return out;
    for (AlphaSimplices& simplices : out.simplices)
        for (std::int32_t& id : simplices.seeds)
            id = diagram.ids[at(id) % diagram.ids.size()] +
                 static_cast<std::int32_t>(tessellation.size() * (at(id) / diagram.ids.size()));
    return out;
}

}  // namespace votess
