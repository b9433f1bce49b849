#include "verify/row_polytope.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <set>

#include "core/arithmetic.hpp"
#include "exact/wide_float.hpp"

namespace votess {
namespace {

constexpr int max_sure_planes = 512, max_exact_planes = 1000000, max_tried_planes = 40;
constexpr std::size_t block_size = 64, crowd = 16;
constexpr double sharpest = 0x1p-46;
}  // namespace

double RowPolytope::doubt_of(const RoundedPlane& plane, double length) {
    return filter_bound * (plane.length * length + plane.size) + filter_underflow;
}

void RowPolytope::begin(std::size_t seed, double length) {
    constexpr double usual = 0x1p40;
    constexpr int largest_unit = 230;  // moments of cells that reach far are numbers too
    seed_ = seed;
    const bool is_usual = length * usual >= 1 && length <= usual;
    unit_ = is_usual || !(length > 0x1p-500) ? 1 : power_of_two(std::min(-exponent_above(length), largest_unit));
    names_.clear();
    sources_.clear();
    p_.clear();
}

RoundedPlane RowPolytope::seen(const Name& name) const {
    RoundedPlane plane = planes_.rounded(seed_, name.id, name.shift);
    if (unit_ == 1) return plane;
    plane.d *= unit_, plane.size *= unit_;
    if (name.id < 0) return plane;
    for (double& x : plane.n) x *= unit_;
    plane.length *= unit_, plane.d *= unit_, plane.size *= unit_;
    return plane;
}

void RowPolytope::add(const Name& name, const RoundedPlane& plane) {
    names_.push_back(name);
    const std::size_t f = p_.append(1);
    p_.nx[f] = plane.n[0], p_.ny[f] = plane.n[1], p_.nz[f] = plane.n[2];
    p_.d[f] = plane.d, p_.length[f] = plane.length;
    p_.size[f] = is_ordinary(plane.length, plane.size) ? plane.size : infinity;  // which no bound trusts
    p_.inverse[f] = 1 / plane.length;
    p_.distance[f] = p_.size[f] * p_.inverse[f];
    p_.longest = std::max(p_.longest, p_.length[f]);
    p_.largest = std::max(p_.largest, p_.size[f]);
}

bool RowPolytope::add_seeds(std::span<const std::int32_t> ids) {
    if (unit_ != 1 || !planes_.are_inside()) return false;
    const std::size_t first = p_.append(ids.size());
    const exact::Point from = planes_.seed(seed_);
    names_.resize(first + ids.size(), {});
    Name* const names = &names_[first];
    for (std::size_t k = 0; k < ids.size(); ++k) {
        const auto j = static_cast<std::size_t>(ids[k]);
        const Vector3 n = minus(planes_.seed(j), from);
        p_.nx[first + k] = n[0], p_.ny[first + k] = n[1], p_.nz[first + k] = n[2];
        p_.power[first + k] = planes_.power(seed_, j);
        names[k].id = ids[k];
    }
    loops_.complete(p_, first);
    if (std::ranges::find(std::span(p_.length).subspan(first, ids.size()), 0.0) ==
        std::span(p_.length).subspan(first, ids.size()).end())
        return true;
    names_.resize(first);
    p_.remove(first);
    return false;
}

const exact::Plane& RowPolytope::source(int f) {
    while (sources_.size() < names_.size()) {
        const Name& name = names_[sources_.size()];
        sources_.push_back(planes_.plane(seed_, name.id, name.shift));
    }
    return sources_[at(f)];
}

// Returns the plane that a ray in planes a and b meets first, by rounded numbers.
Hit RowPolytope::first_hit(const Vector3& from, const Vector3& along, int a, int b) {
    if (inverses_.size() < p_.padded) inverses_.resize(p_.padded);
    loops_.inverses(p_, from, inverses_.data());
    for (const int f : {a, b})
        if (f >= 0) inverses_[at(f)] = 0;
    return loops_.first_hit(p_, inverses_.data(), along);
}

// From a seed well inside, its foot on the nearest plane lies in a face. Elsewhere lines of two planes are tried. They
// end far from the seed: many walls of a hull meet at its corner, a seed, but for rounding.
bool RowPolytope::guess_start(std::array<int, 3>& start) {
    int nearest = -1;
    double least = infinity, to_seed = infinity;
    for (int f = 0; f < planes(); ++f) {
        const double distance = p_.d[at(f)] / p_.length[at(f)];
        if (distance < least) least = distance, nearest = f;
        if (name(f).id >= 0) to_seed = std::min(to_seed, distance);
    }
    if (nearest >= 0 && least > 0 && (least >= 0x1p-30 * to_seed || to_seed == infinity)) {
        const int a = nearest;
        const Vector3 n = normal(a);
        const double turn = p_.d[at(a)] / dot(n, n);
        Vector3 foot{n[0] * turn, n[1] * turn, n[2] * turn}, across{};
        const std::size_t axis = std::abs(n[0]) < std::abs(n[1]) ? 0 : 1;
        Vector3 unit{};
        unit[axis] = 1;
        across = cross(n, unit);
        const Hit b = first_hit(foot, across, a, -1);
        if (b.plane < 0) return false;
        for (std::size_t k = 0; k < 3; ++k) foot[k] += b.time * across[k];
        const Hit c = first_hit(foot, cross(n, normal(b.plane)), a, b.plane);
        start = {a, b.plane, c.plane};
        return c.plane >= 0;
    }
    for (int a = 0; a < planes(); ++a)
        if (guess_from(a, start)) return true;
    return false;
}

bool RowPolytope::guess_from(int a, std::array<int, 3>& start) {
    const Vector3 na = normal(a);
    for (int b = 0; b < planes(); ++b) {
        const Vector3 nb = normal(b), along = cross(na, nb);
        const double square = dot(along, along);
        if (b == a || !(square > 0)) continue;
        const Vector3 u = cross(nb, along), v = cross(along, na);
        Vector3 from;
        for (std::size_t k = 0; k < 3; ++k) from[k] = (p_.d[at(a)] * u[k] + p_.d[at(b)] * v[k]) / square;
        double first = -infinity, last = infinity;
        int begin = -1, end = -1;
        for (int c = 0; c < planes() && first < last; ++c) {
            if (c == a || c == b) continue;
            const Vector3 n = normal(c);
            const double speed = dot(n, along), slack = p_.d[at(c)] - dot(n, from);
            if (speed > 0 && slack < last * speed)
                last = slack / speed, end = c;
            else if (speed < 0 && slack < first * speed)
                first = slack / speed, begin = c;
            else if (speed == 0 && slack < 0)
                last = -infinity;
        }
        if (!(first < last) || (begin < 0 && end < 0)) continue;
        start = end < 0 || (begin >= 0 && -first > last) ? std::array{b, a, begin} : std::array{a, b, end};
        return true;
    }
    return false;
}

// Each corner has a polygon in each of its three planes a, b, c. In turn, the corner after it in one is that before it
// in the next: both polygons have this edge, in opposite directions. So each edge of a corner has its second end among
// the corners, and a polygon follows the edges of its face. It meets no corner twice, if a, b, c differ.
bool RowPolytope::close_polygons(std::span<const std::int64_t> offsets, std::span<const std::int32_t> vertices,
                                 std::span<const std::int32_t> listed) {
    const auto n = names_.size();
    const std::size_t count = vertices.size() / 3;
    seems_open_ = false;
    // In a polytope with three faces at each corner, by Euler's formula
    if (n < 4 || n > max_sure_planes || vertices.size() != 3 * count || count != 2 * n - 4) return false;
    if (!listed.empty() && listed.size() != count) return false;
    vertices_.resize(vertices.size());
    fans_.resize(count);
    slots_.resize(vertices.size());
    if (!(listed.empty() ? number_vertices(vertices, count) : find_vertices(vertices, listed))) return false;
    std::uint16_t* const slots = slots_.data();
    Fan* const fans = fans_.data();
    used_.assign(count, 0);
    std::uint16_t* const used = used_.data();
    // Where a polygon ends is hard to foretell. So all places are taken in one loop, and those before polygons begin
    // and after they end are corrected first.
    constexpr std::size_t usual = 16;  // places that are filled at once
    sides_.resize(3 * (vertices.size() + usual));
    std::uint16_t *const faces = sides_.data(), *const before = faces + vertices.size() + usual,
                         *const after = before + vertices.size() + usual;
    std::copy_n(slots, vertices.size(), before + 1);
    std::copy_n(slots + 1, vertices.size() - 1, after);
    std::size_t begin = 0;
    for (std::size_t f = 0; f < n; ++f) {
        const auto end = static_cast<std::size_t>(offsets[f + 1] - offsets[0]);
        if (begin == end) return false;
        std::fill_n(faces + begin, usual, static_cast<std::uint16_t>(f));
        if (end - begin > usual) std::fill(faces + begin + usual, faces + end, static_cast<std::uint16_t>(f));
        before[begin] = slots[end - 1];
        after[end - 1] = slots[begin];
        begin = end;
    }
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        const std::size_t corner = slots[k];
        fans[corner].sides[used[corner]++ & 3] =
            faces[k] | std::uint64_t{before[k]} << 16 | std::uint64_t{after[k]} << 32;
    }
    std::uint64_t wrong = 0;
    for (std::size_t v = 0; v < count; ++v) {
        const auto after = [](std::uint64_t side) { return side >> 32; };
        const auto same = [](std::uint64_t x, std::uint64_t y) { return x == y ? std::uint64_t{1} : 0; };
        const auto differ = [](std::uint64_t before, std::uint64_t after) {
            return (before >> 16 ^ after >> 32) & 0xffff;
        };
        auto& [a, second, third, unused] = fans[v].sides;
        // Which one is next is hard to foretell as well.
        const std::uint64_t swap = (second ^ third) & -std::uint64_t{differ(second, a) == 0 ? 1u : 0u};
        const std::uint64_t b = second ^ swap, c = third ^ swap;
        wrong |= (used[v] ^ 3u) | differ(c, a) | differ(b, c) | differ(a, b);
        wrong |= same(after(a), after(b)) | same(after(b), after(c)) | same(after(c), after(a));
        second = b, third = c;
    }
    return wrong == 0;
}

// Numbers the vertices of polygons as they come. Returns false unless there are that many.
bool RowPolytope::number_vertices(std::span<const std::int32_t> vertices, std::size_t count) {
    begin_table();
    // Pointers and numbers that no store may change.
    std::uint64_t* const table = table_.data();
    std::uint16_t* const slots = slots_.data();
    std::int32_t* const known = vertices_.data();
    const std::uint64_t turn = table_turn_;
    std::uint64_t found = 0;
    std::int32_t any = 0;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        const std::int32_t vertex = vertices[k];
        any |= vertex;
        const auto id = static_cast<std::uint32_t>(vertex);
        const std::uint64_t wanted = std::uint64_t{id} << 32 | turn;
        std::size_t h = place_of(id);
        std::uint64_t off = table[h] ^ wanted;
        while (is_other(off)) h = place_after(h), off = table[h] ^ wanted;
        // Whether it is new is hard to foretell, so there is no branch.
        const std::uint64_t is_new = off >= turn_unit ? 1 : 0, corner = off ^ ((off ^ found) & -is_new);
        table[h] = wanted | corner;
        slots[k] = static_cast<std::uint16_t>(corner);
        known[corner] = vertex;
        found += is_new;
    }
    vertices_.resize(count);
    return found == count && any >= 0;
}

// Numbers the vertices of polygons by their list. Returns false unless it ascends and has all of them.
bool RowPolytope::find_vertices(std::span<const std::int32_t> vertices, std::span<const std::int32_t> listed) {
    begin_table();
    std::uint64_t* const table = table_.data();
    std::uint16_t* const slots = slots_.data();
    const std::uint64_t turn = table_turn_;
    std::int32_t before = -1;
    bool ascends = true;
    for (std::size_t v = 0; v < listed.size(); ++v) {
        ascends = ascends && before < listed[v];
        before = listed[v];
        const auto id = static_cast<std::uint32_t>(before);
        std::size_t h = place_of(id);
        while (static_cast<std::uint32_t>(table[h] ^ turn) < turn_unit) h = place_after(h);
        table[h] = std::uint64_t{id} << 32 | turn | v;
    }
    if (!ascends) return false;
    std::uint64_t all = 0;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        const auto id = static_cast<std::uint32_t>(vertices[k]);
        const std::uint64_t wanted = std::uint64_t{id} << 32 | turn;
        std::size_t h = place_of(id);
        std::uint64_t off = table[h] ^ wanted;
        while (is_other(off)) h = place_after(h), off = table[h] ^ wanted;
        all |= off;
        slots[k] = static_cast<std::uint16_t>(off);
    }
    vertices_.assign(listed.begin(), listed.end());
    return all < turn_unit;
}

// Clears the table by a new turn.
void RowPolytope::begin_table() {
    static_assert(std::size_t{1} << table_bits >= 4 * max_sure_planes);
    table_turn_ += turn_unit;
    if (table_.size() == std::size_t{1} << table_bits && table_turn_ >> 32 == 0) return;
    table_.assign(std::size_t{1} << table_bits, 0);
    table_turn_ = turn_unit;
}

bool RowPolytope::is_exactly_inside(int v, int plane) {
    const auto& [a, b, c] = corners_[at(v)].planes;
    (void)source(a);
    return exact::side_of_vertex(planes_.seed(seed_), sources_[at(a)], sources_[at(b)], sources_[at(c)],
                                 sources_[at(plane)]) < 0;
}

bool RowPolytope::is_surely_inside(int v, const RoundedPlane& plane) const {
    const Corner& corner = corners_[at(v)];
    return is_ordinary(plane.length, plane.size) &&
           plane.d - dot(plane.n, corner.at) >
               corner.slope * plane.length + corner.constant * plane.size + filter_underflow;
}

void RowPolytope::begin_corners() {
    tight_.clear();
    corners_.resize(fans_.size());
}

void RowPolytope::take_fans() {
    faces_.assign(names_.size(), 1);
    edges_.clear();
}

bool RowPolytope::wrap_polygons(std::span<const std::int64_t> offsets, std::span<const std::int32_t> vertices) {
    if (!close_polygons(offsets, vertices, {})) return false;
    begin_corners();
    for (std::size_t v = 0; v < fans_.size(); ++v) {
        const Fan& fan = fans_[v];
        if (!loops_.sure_corner(p_, fan.plane(0), fan.plane(1), fan.plane(2), corners_[v])) return false;
    }
    take_fans();
    return true;
}

// Joins known corners. Lists their edges, and those that have one end yet. Returns false if an edge has three.
bool RowPolytope::take_known(std::size_t known, std::size_t& waiting, std::size_t& edges) {
    const int n = planes();
    const std::uint32_t turn = pairs_turn_;
    std::uint32_t* const pairs = pairs_.data();
    const Corner* const corners = corners_.data();
    std::uint32_t nearest = pair_step;
    for (std::size_t v = 0; v < known; ++v) {
        const int a = corners[v].planes[0], b = corners[v].planes[1], c = corners[v].planes[2];
        std::uint32_t &ab = pairs[a * n + b], &bc = pairs[b * n + c], &ca = pairs[c * n + a];
        nearest = std::min({nearest, ab ^ turn, bc ^ turn, ca ^ turn});
        ab = bc = ca = turn | static_cast<std::uint32_t>(v);
    }
    // Which ends are missing is hard to foretell, so there is no branch. The ends of an edge are two numbers in a row.
    Half* half = waiting_.data();
    Edge* edge = edges_.data();
    const auto both = [](int first, int second) { return std::bit_cast<std::uint64_t>(std::array{first, second}); };
    const auto add = [&](int v, int f, int g) {
        const std::uint32_t other = pairs[g * n + f] ^ turn;
        half->corner = v, half->a = f, half->b = g;
        half += other >= pair_step ? 1 : 0;
        const std::array<std::uint64_t, 2> values{both(static_cast<int>(other), v), both(f, g)};
        static_assert(sizeof values == sizeof(Edge));
        std::memcpy(edge, &values[0], sizeof values[0]);
        std::memcpy(&edge->left, &values[1], sizeof values[1]);
        edge += other < static_cast<std::uint32_t>(v) ? 1 : 0;
    };
    for (std::size_t v = 0; v < known; ++v) {
        const int a = corners[v].planes[0], b = corners[v].planes[1], c = corners[v].planes[2];
        add(static_cast<int>(v), a, b);
        add(static_cast<int>(v), b, c);
        add(static_cast<int>(v), c, a);
    }
    waiting = static_cast<std::size_t>(half - waiting_.data());
    edges = known_edges_ = static_cast<std::size_t>(edge - edges_.data());
    return nearest >= pair_step;
}

bool RowPolytope::wrap_surely(std::size_t known) {
    const int n = planes();
    const std::size_t room = at(2 * n), padded = p_.padded;  // more corners than a polytope of n faces has
    seems_open_ = false;
    if (n < 4) return seems_open_ = true, false;
    if (n > max_sure_planes || known > room) return false;
    tight_.clear();
    std::array<int, 3> start{};
    if (known == 0 && !guess_start(start)) {
        corners_.clear();
        edges_.clear();
        return seems_open_ = true, false;
    }
    if (corners_.size() < room) corners_.resize(room);
    if (edges_.size() < room + room / 2 + 1) edges_.resize(room + room / 2 + 1);
    if (waiting_.size() < 3 * room + 1) waiting_.resize(3 * room + 1);
    static_assert(pair_step >= 2 * max_sure_planes);
    pairs_turn_ += pair_step;
    if (pairs_turn_ == 0) pairs_.clear(), pairs_turn_ = pair_step;
    if (pairs_.size() < at(n * n)) pairs_.resize(at(n * n), 0);
    std::size_t corners = known, waiting = 0, edges = 0;
    // The first row is that of the known corner in question.
    const auto row = [&](std::size_t v) {
        const std::size_t end = (v < known ? 1 : v - known + 2) * padded;
        if (inverses_.size() < end) inverses_.resize(2 * end);
        return &inverses_[end - padded];
    };
    const auto is_free = [&](int f, int g) { return (pairs_[at(f * n + g)] ^ pairs_turn_) >= pair_step; };
    const auto add = [&](int a, int b, int c) {
        if (corners == room || !loops_.sure_corner_and_inverses(p_, a, b, c, corners_[corners], row(corners)))
            return false;
        const int v = static_cast<int>(corners++);
        for (const auto& [f, g] : {std::array{a, b}, {b, c}, {c, a}}) {
            if (!is_free(f, g)) return false;
            pairs_[at(f * n + g)] = pairs_turn_ | static_cast<std::uint32_t>(v);
            if (is_free(g, f))
                waiting_[waiting++] = {v, f, g};
            else
                edges_[edges++] = {static_cast<int>(pairs_[at(g * n + f)] ^ pairs_turn_), v, f, g};
        }
        return true;
    };
    const auto wrap = [&] {
        if (!take_known(known, waiting, edges)) return false;
        if (known == 0 && !add(start[0], start[1], start[2])) return false;
        while (waiting > 0) {
            const Half& half = waiting_[--waiting];
            const int v = half.corner, a = half.a, b = half.b;  // one by one, as they were stored
            if (!is_free(b, a)) continue;                       // it has an end
            double* const inverses = row(at(v));
            if (at(v) < known) {
                loops_.inverses(p_, corners_[at(v)].at, inverses);
                for (const int f : corners_[at(v)].planes) inverses[f] = 0;
            }
            const int c = loops_.first_hit(p_, inverses, cross(normal(b), normal(a))).plane;
            if (c < 0) return seems_open_ = true, false;
            if (!add(b, a, c)) return false;
        }
        return true;
    };
    const bool sure = wrap();
    corners_.resize(corners);
    edges_.resize(edges);
    faces_.assign(at(n), 0);
    std::uint8_t* const faces = faces_.data();
    for (const Edge& edge : edges_) faces[edge.left] = faces[edge.right] = 1;
    return sure;
}

int RowPolytope::side(int v, const Name& name) {
    const Corner& corner = corners_[at(v)];
    const RoundedPlane plane = seen(name);
    const double slack = plane.d - dot(plane.n, corner.at),
                 bound = corner.slope * plane.length + corner.constant * plane.size + filter_underflow;
    if (is_ordinary(plane.length, plane.size)) {
        if (slack > bound) return -1;
        if (slack < -bound) return 1;
    }
    const auto& [a, b, c] = corner.planes;
    (void)source(a);
    return exact::side_of_vertex(planes_.seed(seed_), sources_[at(a)], sources_[at(b)], sources_[at(c)],
                                 planes_.plane(seed_, name.id, name.shift));
}

RowPolytope::Extent RowPolytope::extent() const {
    Extent e;
    double sum = 0;  // NaN if any term is NaN
    for (const Corner& corner : corners_) {
        const double square = dot(corner.at, corner.at);
        e.nearest = square < e.nearest ? square : e.nearest;
        e.farthest = square > e.farthest ? square : e.farthest;
        e.error = corner.error > e.error ? corner.error : e.error;
        sum += square + corner.error;
    }
    if (!(sum < infinity)) e.farthest = e.error = infinity;
    return e;
}

double RowPolytope::Extent::reach() const {
    const bool is_usual = farthest > filter_underflow && farthest <= 1 / filter_underflow && error < infinity;
    return is_usual ? std::sqrt(farthest) * (1 + 0x1p-50) + error : infinity;
}

bool RowPolytope::is_beyond(const RoundedPlane& plane, double reach) const {
    if (is_out_of_reach(plane, reach)) return true;
    return std::ranges::all_of(corners_, [&](const Corner& corner) {
        const double along = dot(plane.n, corner.at);
        return plane.d - along - plane.length * corner.error > 0x1p-40 * (std::abs(along) + plane.size);
    });
}

int RowPolytope::orientation(int a, int b, int c) {
    (void)source(a);
    return exact::orientation(planes_.seed(seed_), sources_[at(a)], sources_[at(b)], sources_[at(c)]);
}

// Sorts many planes into blocks, halving them by the coordinate of normals that varies most. A wall has any length of
// normal: the seed's mirror image gives one that suits its distance.
void RowPolytope::make_blocks() {
    blocks_.clear();
    if (planes() <= max_sure_planes) return;
    std::vector<Vector3> normals;
    std::vector<double> scales(at(planes()), 1);
    for (int f = 0; f < planes(); ++f) {
        const double square = p_.length[at(f)] * p_.length[at(f)], scale = 2 * p_.d[at(f)] / square;
        if (name(f).id < 0 && is_ordinary(scale, 0)) scales[at(f)] = scale;
        normals.push_back(normal(f));
        for (double& x : normals.back()) x *= scales[at(f)];
    }
    blocks_order_.resize(at(planes()));
    std::iota(blocks_order_.begin(), blocks_order_.end(), 0);
    const auto add = [&](const auto& self, std::size_t begin, std::size_t end) -> void {
        Block block{
            normals[at(blocks_order_[begin])], normals[at(blocks_order_[begin])], infinity, 0, 0, 0, begin, end};
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t f = at(blocks_order_[k]);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                block.lower[axis] = std::min(block.lower[axis], normals[f][axis]);
                block.upper[axis] = std::max(block.upper[axis], normals[f][axis]);
            }
            const double square = dot(normals[f], normals[f]), c = scales[f] * p_.d[f] - 0.5 * square;
            block.least_c = std::min(block.least_c, c);
            block.length = std::max(block.length, scales[f] * p_.length[f]);
            block.size = std::max(block.size, scales[f] * p_.size[f]);
            block.far = std::max(block.far, square + std::abs(c));
        }
        if (end - begin <= block_size) return blocks_.push_back(block);
        std::size_t widest = 0;
        for (std::size_t k = 1; k < 3; ++k)
            if (block.upper[k] - block.lower[k] > block.upper[widest] - block.lower[widest]) widest = k;
        const auto first = blocks_order_.begin();
        const std::size_t middle = begin + (end - begin) / 2;
        std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
                         first + static_cast<std::ptrdiff_t>(end),
                         [&](int f, int g) { return normals[at(f)][widest] < normals[at(g)][widest]; });
        self(self, begin, middle);
        self(self, middle, end);
    };
    add(add, 0, blocks_order_.size());
}

// Visits all planes that a corner is not certainly inside of, and others.
template <class Visit>
void RowPolytope::for_planes_near(const Corner& corner, const Visit& visit) const {
    if (blocks_.empty()) {
        for (int f = 0; f < planes(); ++f) visit(f);
        return;
    }
    constexpr double rounding = 0x1p-47;
    const double square = dot(corner.at, corner.at);
    for (const Block& block : blocks_) {
        double from_box = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = corner.at[k], beside = std::max({block.lower[k] - x, x - block.upper[k], 0.0});
            from_box += beside * beside;
        }
        const double slack = 0.5 * (from_box - square) + block.least_c - rounding * (square + block.far);
        if (slack > corner.slope * block.length + corner.constant * block.size + filter_underflow) continue;
        for (std::size_t k = block.begin; k < block.end; ++k) visit(blocks_order_[k]);
    }
}

// Returns a plane that a ray in planes a and b meets early, or -1: of many planes, the first among one of each block.
int RowPolytope::guess_end(const Vector3& from, const Vector3& along, int a, int b) {
    double first = infinity;
    int found = -1;
    for (const Block& block : blocks_) {
        const int f = blocks_order_[block.begin];
        const double speed = dot(normal(f), along), slack = p_.d[at(f)] - dot(normal(f), from);
        if (f != a && f != b && speed > 0 && slack < first * speed) first = slack / speed, found = f;
    }
    return found >= 0 ? found : first_hit(from, along, a, b).plane;
}

void RowPolytope::sharpen(double relative_error) {
    for (Corner& corner : corners_) sharpen(corner, relative_error);
}

// Makes the place of a corner exact to rounding, where it may err by more.
void RowPolytope::sharpen(Corner& corner, double relative_error) {
    const double square = dot(corner.at, corner.at), allowed = relative_error * relative_error * square;
    if (corner.error * corner.error < allowed) return;
    if (square > filter_underflow)
        corner.error = std::min(corner.error, corner.slope + corner.constant * std::sqrt(square));
    if (corner.error * corner.error < allowed) return;
    const auto plane = [&](std::size_t k) {
        const Name& other = name(corner.planes[k]);
        return planes_.plane(seed_, other.id, other.shift);
    };
    corner.at = exact::near_vertex(planes_.seed(seed_), plane(0), plane(1), plane(2));
    for (double& x : corner.at) x *= unit_;
    corner.error = 0x1p-51 * length3(corner.at[0], corner.at[1], corner.at[2]);
}

// Makes the corner of three planes that meet in a point. Returns the plane that cuts off the most beside it, or -1 and
// all planes through it.
int RowPolytope::place(int a, int b, int c, Corner& corner, std::vector<int>& through) {
    if (!meet(p_, a, b, c, corner) && !meet(p_, a, c, b, corner)) {
        corner.error = corner.slope = corner.constant = infinity;
        corner.planes = {a, b, c};
    }
    const exact::Plane &pa = source(a), &pb = source(b), &pc = source(c);
    sharpen(corner, sharp);
    through.clear();
    int deepest = -1;
    double depth = 0;
    for_planes_near(corner, [&](int f) {
        int sign = 0;
        if (f != a && f != b && f != c) {
            const double slack = p_.d[at(f)] - dot(normal(f), corner.at),
                         bound = corner.slope * p_.length[at(f)] + corner.constant * p_.size[at(f)] + filter_underflow;
            const bool certain = slack < -bound;
            if (slack > bound || (deepest >= 0 && !certain)) return;
            sign = certain ? 1 : exact::side_of_vertex(planes_.seed(seed_), pa, pb, pc, source(f));
            const double beyond = -slack / p_.length[at(f)];
            if (sign > 0 && (deepest < 0 || beyond > depth)) deepest = f, depth = beyond;
        }
        if (sign == 0) through.push_back(f);
    });
    std::ranges::sort(through);
    return deepest;
}

int RowPolytope::corner_of(const Corner& corner, const std::vector<int>& through) {
    const auto [known, is_new] = corner_through_.emplace(through, static_cast<int>(tight_.size()));
    if (is_new) {
        corners_.push_back(corner);
        tight_.push_back(through);
        if (through.size() > crowd) crowded_.push_back(known->second);
    }
    return known->second;
}

// Makes the first corner from three planes that may meet in one.
bool RowPolytope::start_at(const std::array<int, 3>& guess) {
    auto [a, b, c] = guess;
    Corner corner;
    std::vector<int> through;
    for (int tries = 0; tries < planes() && orientation(a, b, c) != 0; ++tries) {
        const int cut = place(a, b, c, corner, through);
        if (cut < 0) return corner_of(corner, through), true;
        if (orientation(a, b, cut) != orientation(a, b, c)) return false;
        c = cut;
    }
    return false;
}

bool RowPolytope::find_start() {
    std::array<int, 3> guess{};
    if (guess_start(guess) && start_at(guess)) return true;
    for (int a = 0; a < planes(); ++a)
        if (guess_from(a, guess) && start_at(guess)) return true;
    if (planes() > max_tried_planes) return false;
    for (int a = 0; a < planes(); ++a)
        for (int b = a + 1; b < planes(); ++b)
            for (int c = b + 1; c < planes(); ++c)
                if (start_at({a, b, c})) return true;
    return false;
}

// Follows the ray sign * cross(na, nb), along an edge. Returns the corner at its end, or -1 if it has none.
int RowPolytope::end_of_edge(int from, int a, int b, int sign) {
    const Vector3 turn = cross(normal(a), normal(b));
    const Vector3 along{sign * turn[0], sign * turn[1], sign * turn[2]};
    const auto ends = [&](int c) { return sign * orientation(a, b, c) > 0; };
    int c = guess_end(corners_[at(from)].at, along, a, b);
    if (c < 0 || !ends(c)) {
        c = 0;
        while (c < planes() && (c == a || c == b || !ends(c))) ++c;
        if (c == planes()) return -1;
    }
    // A plane that cuts off the corner meets the ray before it.
    Corner corner;
    std::vector<int> through;
    while (true) {
        for (const int v : crowded_)
            if (std::ranges::all_of(std::array{a, b, c},
                                    [&](int f) { return std::ranges::binary_search(tight_[at(v)], f); }))
                return v;
        const int cut = place(a, b, c, corner, through);
        if (cut < 0) return corner_of(corner, through);
        c = cut;
    }
}

RowPolytope::Shape RowPolytope::wrap_exactly() {
    corners_.clear();
    edges_.clear();
    tight_.clear();
    crowded_.clear();
    corner_through_.clear();
    rays_.clear();
    faces_.assign(names_.size(), 0);
    make_blocks();
    if (planes() > max_exact_planes) return Shape::unsettled;
    if (!find_start()) return planes() > max_tried_planes ? Shape::unsettled : Shape::empty;
    std::set<std::vector<int>> known;
    for (int v = 0; v < static_cast<int>(corners_.size()); ++v) {
        const std::vector<int> through = tight_[at(v)];
        int above = through.front(), below = above;  // planes beyond either end of the last line that is no edge
        for (std::size_t k = 0; k < through.size(); ++k)
            for (std::size_t l = k + 1; l < through.size(); ++l) {
                const int a = through[k], b = through[l];
                const auto turn = [&](int c) { return c == a || c == b ? 0 : orientation(a, b, c); };
                if (turn(above) * turn(below) < 0) continue;
                std::vector<int> along;  // planes that hold the line of a and b
                bool positive = false, negative = false;
                for (const int c : through) {
                    const int sign = turn(c);
                    if (sign == 0) along.push_back(c);
                    if (sign > 0) positive = true, above = c;
                    if (sign < 0) negative = true, below = c;
                    if (positive && negative) break;
                }
                if (positive == negative || !known.insert(along).second) continue;  // no edge, or parallel planes
                const int w = end_of_edge(v, a, b, positive ? -1 : 1);
                if (w < 0) return seems_open_ = true, Shape::open;
                rays_.push_back({v, w, std::move(along)});
            }
    }
    return find_faces();
}

// A plane has a face if three corners lie in it: no corner lies between two others.
RowPolytope::Shape RowPolytope::find_faces() {
    std::vector<std::size_t> count(names_.size());
    for (const auto& through : tight_)
        for (const int f : through) ++count[at(f)];
    for (std::size_t f = 0; f < count.size(); ++f) {
        if (count[f] == corners_.size()) return Shape::flat;
        faces_[f] = count[f] >= 3 ? 1 : 0;
    }
    const auto faces_of = [&](const Ray& ray) {
        std::vector<int> faces;
        for (const int f : ray.planes)
            if (faces_[at(f)] != 0) faces.push_back(f);
        return faces;
    };
    // Two faces meet in an edge. Others in it lie in one plane with one of them.
    for (const Ray& ray : rays_) {
        std::vector<int> faces = faces_of(ray);
        for (std::size_t k = 0; k < faces.size() && faces.size() > 2; ++k)
            for (std::size_t l = k + 1; l < faces.size() && faces.size() > 2; ++l) {
                const int f = faces[k], g = faces[l];
                const auto both = std::ranges::count_if(tight_, [&](const std::vector<int>& through) {
                    return std::ranges::binary_search(through, f) && std::ranges::binary_search(through, g);
                });
                if (both < 3) continue;
                repeated_ = {f, g};
                if (name(f).id >= 0 || name(g).id >= 0) return Shape::repeated;
                const std::size_t drop = name(f).id > name(g).id ? l : k;  // the first wall counts
                faces_[at(faces[drop])] = 0;
                faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(drop));
                k = 0, l = 0;
            }
    }
    for (const Ray& ray : rays_) {
        const std::vector<int> faces = faces_of(ray);
        if (faces.size() != 2) return Shape::unsettled;
        int third = -1;
        for (const int c : tight_[at(ray.from)])
            if (!std::ranges::binary_search(ray.planes, c)) third = c;
        const bool turned = orientation(faces[0], faces[1], third) > 0;
        edges_.push_back({ray.from, ray.to, faces[turned ? 1 : 0], faces[turned ? 0 : 1]});
    }
    return Shape::solid;
}

// Visits both sides of each edge: from, to, face. Seen from outside, the face lies on the left.
template <class Visit>
void RowPolytope::for_sides(const Visit& visit) const {
    for (const Edge& edge : edges_) {
        visit(edge.from, edge.to, edge.left);
        visit(edge.to, edge.from, edge.right);
    }
    if (!edges_.empty()) return;
    for (std::size_t v = 0; v < fans_.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) visit(static_cast<int>(v), fans_[v].after(k), fans_[v].plane(k));
}

void RowPolytope::measure(Measures& out, bool centroid) const {
    Vector3 origin{};  // the seed, or a corner if the seed lies outside
    for (int f = 0; f < planes(); ++f)
        if (has_face(f) && !(p_.d[at(f)] > 0)) origin = corners_[0].at;
    out.areas.assign(names_.size(), 0);
    out.anchors.assign(names_.size(), -1);
    double* const areas = out.areas.data();
    int* const anchors = out.anchors.data();
    const auto place = [&](int corner) { return minus(corners_[at(corner)].at, origin); };
    out.vectors.assign(4 * names_.size(), 0);
    if (edges_.empty())
        loops_.add_areas_of_fans(fans_, corners_.data(), origin, out.vectors.data());
    else
        loops_.add_areas(edges_, corners_.data(), origin, out.vectors.data());
    for_sides([&](int from, int, int f) { anchors[f] = from; });
    for (int f = 0; f < planes(); ++f) {
        const double* const twice = &out.vectors[at(4 * f)];
        const double half = 0.5 * p_.inverse[at(f)];  // before products of short ones
        areas[f] =
            twice[0] * (half * p_.nx[at(f)]) + twice[1] * (half * p_.ny[at(f)]) + twice[2] * (half * p_.nz[at(f)]);
    }
    out.volume = out.surface = 0;
    for (int f = 0; f < planes(); ++f) {
        if (!has_face(f)) continue;
        // Corners have more digits than d.
        out.volume += areas[f] * dot(place(anchors[f]), normal(f)) * p_.inverse[at(f)] / 3;
        out.surface += areas[f];
    }
    if (centroid) {
        const double longer = out.volume < 0x1p-700 ? 0x1p600 : 1;  // so that no product of three loses its digits
        double sum = 0;  // of the volumes of tetrahedra, six times; of a face, they share its anchor
        Vector3 moment{};
        for_sides([&](int first, int second, int f) {
            const Vector3 from = place(first), to = place(second), third = place(anchors[f]);
            Vector3 across = cross(from, to);
            for (double& x : across) x *= longer;
            const double volume = dot(across, third);
            sum += volume;
            for (std::size_t k = 0; k < 3; ++k) moment[k] += volume * (from[k] + to[k] + third[k]);
        });
        for (std::size_t k = 0; k < 3; ++k) out.centroid[k] = origin[k] + moment[k] / (4 * sum);
    }
    out.rounding = rounding_of_sums * planes();
    measure_corners(out);
    out.span = (origin == Vector3{} ? out.reach : out.diameter) + out.error;
}

void RowPolytope::measure_corners(Measures& out) const {
    double wide = 0, far = 0;  // squares
    out.error = out.errors = 0;
    std::size_t v = 0;
    for (const Corner& corner : corners_) {
        const Vector3 from = minus(corner.at, corners_[0].at);
        wide = std::max(wide, dot(from, from));
        far = std::max(far, dot(corner.at, corner.at));
        out.error = std::max(out.error, corner.error);
        out.errors += corner.error * (tight_.empty() ? 3 : static_cast<double>(tight_[v++].size()));
    }
    out.diameter = 2 * std::sqrt(wide);
    out.reach = std::sqrt(far);
    if (far > filter_underflow && far < 1 / filter_underflow) return;
    out.reach = 0;
    for (const Corner& corner : corners_) out.reach = std::max(out.reach, length3(corner.at));
}

void RowPolytope::measure_within(Measures& out, double of_volume, double of_surface, bool centroid) {
    const auto is_rough = [&] {
        return !(out.doubt_of_volume() <= of_volume * out.volume) || !(out.doubt_of_area() <= of_surface * out.surface);
    };
    sharpen(sharp);
    measure(out, centroid);
    if (is_rough()) sharpen(sharpest), measure(out, centroid);
    if (is_rough()) measure_in<exact::Quad>(out, 0x1p-110);
    if (is_rough()) measure_in<exact::WideFloat>(out, 0);
}

// Solves all corners again. roundoff: a bound on all errors, relative to the lengths.
template <class Real>
void RowPolytope::measure_in(Measures& out, double roundoff) {
    using Place = std::array<Real, 3>;
    std::vector<Place> places, doubled(names_.size());
    for (Corner& corner : corners_) {
        const auto& [a, b, c] = corner.planes;
        Place place = exact::vertex_position<Real>(planes_.seed(seed_), source(a), source(b), source(c));
        for (std::size_t k = 0; k < 3; ++k) {
            place[k] = place[k] * Real(unit_);
            corner.at[k] = static_cast<double>(place[k]);
        }
        corner.error = 0x1p-51 * length3(corner.at);
        places.push_back(place);
    }
    const auto between = [](const Place& from, const Place& to) {
        return Place{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    };
    Real sum = 0;  // as above
    Place moment{};
    for_sides([&](int first, int second, int f) {
        const Place& anchor = places[at(out.anchors[at(f)])];
        const Place from = between(anchor, places[at(first)]), to = between(anchor, places[at(second)]),
                    third = between(places[0], anchor), turn = cross(from, to);
        const Real volume = dot(turn, third);
        sum += volume;
        for (std::size_t k = 0; k < 3; ++k) {
            doubled[at(f)][k] += turn[k];
            moment[k] += volume * (from[k] + to[k] + third[k] + third[k] + third[k]);
        }
    });
    out.volume = static_cast<double>(sum / 6);
    for (std::size_t k = 0; k < 3; ++k) out.centroid[k] = static_cast<double>(places[0][k] + moment[k] / (sum * 4));
    out.surface = 0;
    for (std::size_t f = 0; f < doubled.size(); ++f) {
        out.areas[f] = 0.5 * length3(static_cast<double>(doubled[f][0]), static_cast<double>(doubled[f][1]),
                                     static_cast<double>(doubled[f][2]));
        out.surface += out.areas[f];
    }
    measure_corners(out);
    out.error = roundoff * out.reach;
    out.errors *= roundoff * 0x1p51;
    out.rounding = roundoff * planes();
    out.span = out.diameter;
}

}  // namespace votess
