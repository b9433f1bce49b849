#include "polytope/cell.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"

namespace votess::cpu {
namespace {

constexpr double unit = 0x1p-53;
// Below these, underflow may spoil the error bounds. Such planes are always decided exactly.
constexpr double smallest_square = 1e-240, smallest_product = 1e-200;
// Shorter normals are multiplied by CellPlane::unit, unless a part of them may be subnormal.
constexpr double short_normal = 0x1p-100, shortest_normal = 0x1p-900;
constexpr double smallest_height = 1e-300;  // differences of heights below it may come from underflow
constexpr double worst_condition = 1e4;     // |na||nb||nc| / |det|
constexpr int tests_before_refining = 8;    // a lattice meets fewer, all ties, which need the exact test
constexpr int passed_before_sharpening = 256;
constexpr std::size_t nodes_per_check = 256, crowded_nodes = 64;  // of the tree of walls
constexpr int few_slots = 256;           // of a cell whose vertices are all compared with a plane
constexpr int steps_at_first = 16;       // of a climb, before it starts again from the best of a sample
constexpr std::size_t max_nearby = 256;  // vertices tried around the last cut
constexpr std::int32_t no_plane = -1;    // walls are never refined
constexpr double solved_factor = 110 * unit, rounded_factor = 10 * unit;
constexpr double term_error = 32 * unit;  // of a term of Cramer's rule: 17 u, and the sum
constexpr double underflow = 0x1p-1060;   // above the rounding of terms of minors that underflow
// Covers the rounding of squared lengths and distances, and the outward rounding of a box.
constexpr double radius_slack = 1 + 32 * unit;
// The largest relative error of a vertex.
constexpr double worst_error = worst_condition * solved_factor;
// A seed q cuts off a vertex v only if |q - v|^2 < |v|^2 + more, where `more` is the excess of its weight. A relative
// error e of v changes both sides by less than 4.1 e (|v|^2 + more); it changes |q - v|^2 = D^2 by 2 e |v| D.
constexpr double reach_of_error(double e) {
    return 1 + 5 * e;
}
// Squared distances below this may have underflowed. A cell that small is searched as if it were larger.
constexpr double smallest_radius = 1e-280;

}  // namespace

Cell::Cell(const Kernels& kernels) : kernels_(kernels) {
    reserve_slots(word_slots);
}

void Cell::reserve_slots(int slots) {
    if (slots <= capacity_) return;
    const int capacity = std::max(round_up(slots, word_slots), 2 * capacity_);
    std::vector<double> storage(static_cast<std::size_t>(capacity) * 5 + lanes, 0.0);
    auto address = reinterpret_cast<std::uintptr_t>(storage.data());
    double* base = storage.data() + (64 - address % 64) % 64 / sizeof(double);
    double** arrays[] = {&x_, &y_, &z_, &tolerance_, &radius_};
    for (int k = 0; k < 5; ++k) {
        if (*arrays[k] != nullptr) std::copy_n(*arrays[k], slots_, base + static_cast<std::size_t>(k) * capacity);
        *arrays[k] = base + static_cast<std::size_t>(k) * capacity;
    }
    storage_ = std::move(storage);
    capacity_ = capacity;
    corners_.resize(capacity);
    refined_.resize(capacity);
    visited_.resize(capacity, 0);
    alive_.resize(capacity / word_slots, 0);
}

VertexBlock Cell::block(int word) const {
    const int first = word * word_slots;
    return {x_ + first,         y_ + first,      z_ + first,
            tolerance_ + first, radius_ + first, ceil_div(std::min(slots_ - first, word_slots), lanes)};
}

namespace {

CellPlane box_wall(const exact::Point& seed, const Box& box, int wall) {
    const int axis = wall / 2;
    const bool upper = wall % 2 == 1;
    CellPlane plane;
    plane.n = {};
    plane.n[axis] = upper ? 1 : -1;
    plane.h = upper ? box.upper[axis] - seed[axis] : seed[axis] - box.lower[axis];
    plane.norm = 1;
    plane.id = -1 - wall;
    plane.reliable = true;
    plane.source = upper ? exact::Plane::upper(axis, box.upper[axis]) : exact::Plane::lower(axis, box.lower[axis]);
    return plane;
}

// h is a sum that may cancel. At least half of all digits must remain.
constexpr double worst_cancellation = 0x1p-40;

// Returns CellPlane::unit for a normal. A plane of short n and large power lies far away, where unit^2 power might
// overflow.
double unit_for(const std::array<double, 3>& n, double power) {
    constexpr int largest_exponent = 1000;
    const double largest = std::max({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])});
    if (largest >= short_normal || largest < shortest_normal) return 1;
    const int wanted = -std::ilogb(largest);
    const int most = power == 0 ? wanted : std::max(0, (largest_exponent - std::ilogb(power)) / 2);
    return std::ldexp(1.0, std::min(wanted, most));
}

// Returns the squared length of unit * n.
double set_norm(CellPlane& plane) {
    const double x = plane.unit * plane.n[0], y = plane.unit * plane.n[1], z = plane.unit * plane.n[2];
    const double square = x * x + y * y + z * z;
    plane.norm = std::sqrt(square) / plane.unit;
    plane.reliable = square > smallest_square;
    return square;
}

FilterPlane filter_of(const CellPlane& plane) {
    return {plane.unit * plane.n[0], plane.unit * plane.n[1],
            plane.unit * plane.n[2], plane.h,
            plane.unit * plane.norm, 12 * unit * std::abs(plane.h) + (plane.reliable ? 0 : plane.h_error)};
}

}  // namespace

CellPlane make_plane(const exact::Point& p, std::int32_t id, const exact::Plane& source, const exact::Shift& shift) {
    using exact::DoubleDouble;
    CellPlane plane;
    plane.id = id;
    plane.source = source;
    plane.shift = shift;
    DoubleDouble h{};
    double size = 0;
    if (source.is_bisector()) {
        const exact::Differences d = exact::differences(p, source);
        for (int k = 0; k < 3; ++k) plane.n[k] = d.x[k].high;
        plane.unit = unit_for(plane.n, source.power.high);
        const auto in_units = [&plane](DoubleDouble x) {
            return DoubleDouble{plane.unit * x.high, plane.unit * x.low};
        };
        for (const DoubleDouble& x : d.x) h = h + in_units(x) * in_units(x);
        const DoubleDouble power = in_units(in_units(source.power));
        size = h.high + std::abs(power.high);
        h = h + power;
        h = {0.5 * h.high, 0.5 * h.low};
        if (source.is_reversed()) {
            for (double& n : plane.n) n = -n;
            h = {-h.high, -h.low};
        }
    } else if (source.kind == exact::Plane::Kind::cell_wall) {
        plane.n = source.rounded_normal();
        const exact::Lattice& lattice = *source.lattice;
        for (int k = 0; k < 3; ++k) {
            DoubleDouble from = exact::two_sum(source.seed[k], -p[k]);
            size += std::abs(plane.n[k]) * (std::abs(source.seed[k]) + std::abs(p[k]));
            if (source.shift[source.axis] != 0) {
                from = from + lattice.vector[source.axis][k];
                size += std::abs(plane.n[k] * lattice.vector[source.axis][k].high);
            }
            h = h + lattice.across[source.axis][k] * from;
        }
        h = {source.wall * h.high, source.wall * h.low};
    } else {
        plane.n = source.seed;
        h = {source.wall, 0};
        size = std::abs(source.wall);
        for (int k = 0; k < 3; ++k) {
            const DoubleDouble product = exact::two_product(source.seed[k], p[k]);
            h = h + DoubleDouble{-product.high, -product.low};
            size += std::abs(product.high);
        }
    }
    set_norm(plane);
    plane.h = h.high / plane.unit;
    // Each product and each sum adds less than 20 u^2 of its size. So a wall next to the seed may have no digits of h,
    // but vertices elsewhere have certain sides.
    if (plane.reliable && !source.is_bisector()) plane.h_error = 0x1p-98 * size + smallest_height;
    plane.reliable = plane.reliable && std::abs(h.high) > worst_cancellation * size;
    return plane;
}

std::array<double, 3> mirror_image(const CellPlane& wall) {
    const auto& [x, y, z] = wall.n;
    if (!wall.source.is_oblique()) return {2 * wall.h * x, 2 * wall.h * y, 2 * wall.h * z};
    if (!wall.reliable) return {};
    const double times = 2 * wall.h / (wall.norm * wall.norm);
    return {times * x, times * y, times * z};
}

void Cell::start(const exact::Point& seed, const Box& box) {
    Domain domain;
    domain.box = box;
    start(seed, domain);
}

void Cell::start(const exact::Point& seed, const Domain& domain, std::int32_t id) {
    start_without_walls(seed, domain, id);
    clip_walls(domain);
}

void Cell::start_without_walls(const exact::Point& seed, const Domain& domain, std::int32_t id) {
    seed_ = seed;
    planes_.clear();
    const bool is_box = !domain.is_periodic() && !domain.triclinic;
    for (int wall = 0; wall < 6; ++wall) {
        if (domain.has_box_wall(wall)) {
            planes_.push_back(domain.triclinic ? make_plane(seed, -1 - wall, domain.box_wall(wall), {})
                                               : box_wall(seed, domain.box, wall));
            continue;
        }
        exact::Shift shift = domain.reduced.shift[wall / 2];
        if (wall % 2 == 0)
            for (auto& times : shift) times = -times;
        planes_.push_back(make_plane(seed, id, exact::Plane::bisector(seed, shift, domain.lattice), shift));
    }
    // Corners assume that the upper walls form a right-handed basis.
    if (domain.triclinic && exact::orientation(seed, planes_[1].source, planes_[3].source, planes_[5].source) < 0)
        std::swap(planes_[0], planes_[1]);
    std::fill(alive_.begin(), alive_.end(), 0);
    alive_[0] = 0xff;
    slots_ = 8;
    free_.clear();
    last_ = 0;
    places_.clear();
    refined_plane_.id = no_plane;
    used_exact_ = met_tie_ = radius_known_ = moved_radius_known_ = empty_ = sharp_ = false;
    radius_squared_ = moved_radius_ = infinity;
    passed_ = 0;
    std::fill_n(refined_.begin(), 8, Refined{});
    for (int v = 0; v < 8; ++v) {  // bit k of v: upper wall of axis k
        const int px = v & 1, py = 2 + ((v >> 1) & 1), pz = 4 + ((v >> 2) & 1);
        const int nx = v ^ 1, ny = v ^ 2, nz = v ^ 4;  // neighbors along x, y, z
        // The edge on planes y, z runs along x. Positive orientation flips with the number of lower walls.
        const bool positive = std::popcount(static_cast<unsigned>(v)) % 2 == 1;
        corners_[v] = positive ? Corner{{px, py, pz}, {nz, nx, ny}} : Corner{{py, px, pz}, {nz, ny, nx}};
        if (!is_box) {
            place_vertex(v, px, py, pz);
            continue;
        }
        x_[v] = (v & 1) != 0 ? planes_[1].h : -planes_[0].h;
        y_[v] = (v & 2) != 0 ? planes_[3].h : -planes_[2].h;
        z_[v] = (v & 4) != 0 ? planes_[5].h : -planes_[4].h;
        tolerance_[v] = rounded_factor * (std::abs(x_[v]) + std::abs(y_[v]) + std::abs(z_[v]));
        radius_[v] = (x_[v] * x_[v] + y_[v] * y_[v] + z_[v] * z_[v]) * reach_of_error(rounded_factor);
    }
}

void Cell::clip_walls(const Domain& domain, const std::function<void()>& crowded) {
    const WallTree& tree = domain.wall_tree;
    const auto clip_by = [&](std::size_t w) { clip(-7 - static_cast<std::int32_t>(w), domain.walls[w]); };
    if (tree.size() == 0) {
        for (std::size_t w = 0; w < domain.walls.size(); ++w) clip_by(w);
        return;
    }
    // Level by level, so that a cell with many walls soon has some everywhere.
    wall_queue_.assign(1, 0);
    for (std::size_t k = 0; k < wall_queue_.size(); ++k) {
        if (k % nodes_per_check == 0) check_stop();
        if (k == crowded_nodes && crowded) crowded();
        const std::size_t node = wall_queue_[k];
        if (slots_ <= few_slots && !may_meet(tree, node)) continue;
        clip_by(tree.wall(node));
        for (std::size_t child = 2 * node + 1; child <= 2 * node + 2 && child < tree.size(); ++child)
            wall_queue_.push_back(static_cast<std::uint32_t>(child));
    }
}

bool Cell::may_meet(const WallTree& walls, std::size_t node) const {
    bool any = false;
    for_each_alive([&](int v) {
        any = any || walls.may_exclude(node, {seed_[0] + x_[v], seed_[1] + y_[v], seed_[2] + z_[v]}, tolerance_[v]);
    });
    return any;
}

double Cell::radius_squared() {
    // A large cell keeps its last bound, which stays valid, until as many requests as words of vertices have come.
    if (!radius_known_ && (slots_ <= few_slots || ++requests_ * word_slots >= slots_)) {
        requests_ = 0;
        double r = smallest_radius;
        for (int w = 0; w * word_slots < slots_; ++w) r = std::max(r, kernels_.largest_radius(block(w)));
        radius_squared_ = r * radius_slack;
        radius_known_ = true;
    }
    return radius_squared_;
}

// With R the distance to the farthest moved vertex and s = shrink, a seed at the distance n cuts the cell only if
// s n^2 - 2 n R < more.
double Cell::lifted_reach(const LiftedView& view, double more) {
    if (!moved_radius_known_ && (slots_ <= few_slots || ++requests_ * word_slots >= slots_)) {
        requests_ = 0;
        moved_radius_ = 0;
        for_each_alive([&](int slot) {
            const double v[3] = {x_[slot], y_[slot], z_[slot]};
            double square = smallest_radius, error = 2 * tolerance_[slot];
            for (std::size_t k = 0; k < 3; ++k) {
                square += (v[k] + view.move[k]) * (v[k] + view.move[k]);
                error += 8 * unit * (std::abs(v[k]) + std::abs(view.move[k]));
            }
            moved_radius_ = std::max(moved_radius_, std::sqrt(square) * radius_slack + error);
        });
        moved_radius_known_ = true;
    }
    const double r = moved_radius_;
    return (r + std::sqrt(r * r + view.shrink * more)) / view.shrink * radius_slack;
}

Box seen_from(const exact::Point& at, const Box& box, const exact::Point& rounding) {
    Box relative;
    for (int k = 0; k < 3; ++k) {
        relative.lower[k] = box.lower[k] - at[k];
        relative.lower[k] -= 2 * unit * std::abs(relative.lower[k]) + 2 * rounding[k];
        relative.upper[k] = box.upper[k] - at[k];
        relative.upper[k] += 2 * unit * std::abs(relative.upper[k]) + 2 * rounding[k];
    }
    return relative;
}

bool Cell::in_reach(const Box& relative, double more) const {
    // A negative excess needs no slack except for its own rounding, since |q - v| is less than |v|.
    const double floor =
        smallest_radius + more * (more > 0 ? reach_of_error(worst_error) * radius_slack : 1 - 8 * unit);
    for (int w = 0; w * word_slots < slots_; ++w)
        if (kernels_.box_in_reach(block(w), relative, radius_slack, floor)) return true;
    return false;
}

// A seed q cuts off v when s |q|^2 - 2 q.X < more, with X = v + move and s = shrink of the view. Along each axis the
// sum is least at q = X / s or at an end of the box. The terms are rounded by 4 u of their sizes. An error t of X moves
// the sum by 2 |q| t, where q is that of an X within t.
bool Cell::may_cut(const Box& relative, double more, const LiftedView& view) {
    bool found = false;
    const double inverse = 1 / view.shrink;
    for_each_alive([&](int slot) {
        const Refined& vertex = by_axis(slot);
        double sum = 0, size = 0, moved = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double lower = relative.lower[k], upper = relative.upper[k], x = vertex.at[k] + view.move[k];
            const double t = vertex.error[k] + unit * (8 * std::abs(view.move[k]) + 2 * std::abs(x));
            const double q = std::clamp(x * inverse, lower, upper), shrunk = view.shrink * q;
            const double term = q * (shrunk - 2 * x);
            sum += term;
            size += std::abs(term) + q * shrunk;
            const double least = std::clamp((x - t) * inverse, lower, upper);
            const double most = std::clamp((x + t) * inverse, lower, upper);
            moved += std::max(std::abs(least), std::abs(most)) * t;
        }
        const double slack = 8 * unit * (size + std::abs(more)) + 2 * moved * (1 + 8 * unit) + smallest_radius;
        found = found || !(sum > more + slack);
    });
    if (found && ++passed_ == passed_before_sharpening) sharpen();
    return found;
}

void Cell::sharpen() {
    sharp_ = true;
    for_each_alive([&](int slot) {
        const auto [a, b, c] = corners_[slot].plane;
        place_vertex(slot, a, b, c);
    });
    radius_known_ = moved_radius_known_ = false;
}

bool Cell::has_plane(std::int32_t id, const exact::Shift& shift) const {
    return std::ranges::any_of(planes_, [&](const CellPlane& p) { return p.id == id && p.shift == shift; });
}

std::array<double, 3> Cell::middle() const {
    std::array<double, 3> sum{};
    double count = 0;
    for_each_alive([&](int v) {
        sum[0] += x_[v], sum[1] += y_[v], sum[2] += z_[v];
        ++count;
    });
    return {sum[0] / count, sum[1] / count, sum[2] / count};
}

void Cell::drop_if_flat() {
    int first = 0;
    while (!alive(first)) ++first;
    for (const std::int32_t p : std::array(corners_[first].plane)) {
        const CellPlane& plane = planes_[p];
        const FilterPlane filter = filter_of(plane);
        ++test_;
        bool flat = true;
        for_each_alive([&](int v) {
            const auto& [a, b, c] = corners_[v].plane;
            if (!flat || a == p || b == p || c == p) return;
            const double excess = filter.nx * x_[v] + filter.ny * y_[v] + filter.nz * z_[v] - filter.h;
            flat = !(std::abs(excess) > filter.norm * tolerance_[v] + filter.h_error) && side_exact(v, plane) == 0;
        });
        if (!flat) continue;
        std::ranges::fill(alive_, 0);
        empty_ = true;
        return;
    }
}

// Cramer's rule again, with the terms of each coordinate in place of the length of the vertex: where the normals have
// no part along an axis, a long coordinate there does not blur the others.
const Cell::Refined& Cell::by_axis(int slot) {
    Refined& vertex = refined_[slot];
    if (vertex.split) return vertex;
    vertex.split = true;
    vertex.at = position(slot);
    vertex.error.fill(tolerance_[slot]);
    const auto planes = corner_planes(slot);
    if (!planes[0]->reliable || !planes[1]->reliable || !planes[2]->reliable) return vertex;
    std::array<double, 3> sum{}, size{};
    double determinant = 0, determinant_size = 0, heights = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const CellPlane &p = *planes[i], &q = *planes[(i + 1) % 3], &r = *planes[(i + 2) % 3];
        heights += std::abs(p.h);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            const double first = (q.unit * q.n[l]) * (r.unit * r.n[m]), second = (q.unit * q.n[m]) * (r.unit * r.n[l]);
            const double minor = first - second, minor_size = std::abs(first) + std::abs(second);
            sum[k] += p.h * minor;
            size[k] += std::abs(p.h) * minor_size;
            if (i != 0) continue;
            determinant += p.unit * p.n[k] * minor;
            determinant_size += std::abs(p.unit * p.n[k]) * minor_size;
        }
    }
    const double least = std::max(smallest_product, 2 * term_error * determinant_size);
    if (!(std::abs(determinant) > least)) return vertex;
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = sum[k] / determinant;
        const double terms = term_error * (size[k] + std::abs(x) * determinant_size) + underflow * (1 + heights);
        const double error = 2 * terms / std::abs(determinant);
        if (error < vertex.error[k]) vertex.at[k] = x, vertex.error[k] = error;
    }
    return vertex;
}

int Cell::side_by_axis(int slot, const CellPlane& plane) {
    if (!plane.reliable) return 0;
    const Refined& vertex = by_axis(slot);
    double excess = -plane.h, bound = 12 * unit * std::abs(plane.h) + smallest_height;
    for (std::size_t k = 0; k < 3; ++k) {
        const double n = plane.unit * plane.n[k];
        excess += n * vertex.at[k];
        bound += std::abs(n) * (vertex.error[k] + 6 * unit * std::abs(vertex.at[k]));
    }
    return excess > bound ? 1 : excess < -bound ? -1 : 0;
}

int Cell::refined_side(int slot, const CellPlane& plane) {
    using exact::DoubleDouble;
    Refined& vertex = refined_[slot];
    if (++vertex.tests < tests_before_refining || !plane.reliable || plane.unit != 1 || !plane.source.is_bisector() ||
        plane.source.is_reversed())
        return 0;
    if (!vertex.solved) {
        vertex.solved = true;
        const auto& [a, b, c] = corners_[slot].plane;
        const auto solved =
            exact::vertex_position<exact::Quad>(seed_, planes_[a].source, planes_[b].source, planes_[c].source);
        for (int k = 0; k < 3; ++k) {
            const auto high = static_cast<double>(solved[k]);
            vertex.position[k] = {high, static_cast<double>(solved[k] - high)};
        }
    }
    if (refined_plane_.id != plane.id || refined_plane_.shift != plane.shift) {
        const exact::Differences d = exact::differences(seed_, plane.source);
        DoubleDouble square{};
        for (int k = 0; k < 3; ++k) square = square + d.x[k] * d.x[k];
        refined_plane_ = {plane.id, plane.shift, d.x, {}, 0.5 * (square.high + std::abs(plane.source.power.high))};
        square = square + plane.source.power;
        refined_plane_.minus_h = {-0.5 * square.high, -0.5 * square.low};
    }
    DoubleDouble excess = refined_plane_.minus_h;
    for (int k = 0; k < 3; ++k) excess = excess + refined_plane_.n[k] * vertex.position[k];
    // Each product, each sum and the rounding of the vertex add at most 20 u^2.
    const double bound = 0x1p-98 * (plane.norm * std::sqrt(radius_[slot]) + refined_plane_.size);
    return excess.high > bound ? 1 : (excess.high < -bound ? -1 : 0);
}

int Cell::side_exact(int slot, const CellPlane& plane) {
    used_exact_ = true;
    std::int32_t& place = refined_[slot].place;
    if (place >= 0 && places_[place].test == test_) return places_[place].side;
    int side = side_by_axis(slot, plane);
    if (side == 0) side = refined_side(slot, plane);
    if (side == 0) {
        const auto& [a, b, c] = corners_[slot].plane;
        side = exact::side_of_vertex(seed_, planes_[a].source, planes_[b].source, planes_[c].source, plane.source);
    }
    if (side == 0) met_tie_ = true;
    if (side == 0 && place < 0) {
        place = static_cast<std::int32_t>(places_.size());
        places_.emplace_back();
    }
    if (place >= 0) places_[place] = {test_, side};
    return side;
}

int Cell::allocate_slot() {
    if (free_.empty()) {  // adds a whole block, with its lanes at the origin, where no plane cuts
        reserve_slots(slots_ + lanes);
        for (int i = slots_ + lanes - 1; i >= slots_; --i) {
            x_[i] = y_[i] = z_[i] = tolerance_[i] = radius_[i] = 0;
            free_.push_back(i);
        }
        slots_ += lanes;
    }
    const int slot = free_.back();
    free_.pop_back();
    return slot;
}

void Cell::place_vertex(int slot, std::int32_t a, std::int32_t b, std::int32_t c) {
    const CellPlane &pa = planes_[a], &pb = planes_[b], &pc = planes_[c];
    const double a_unit = pa.unit, b_unit = pb.unit, c_unit = pc.unit;
    const double ax = a_unit * pa.n[0], ay = a_unit * pa.n[1], az = a_unit * pa.n[2];
    const double bx = b_unit * pb.n[0], by = b_unit * pb.n[1], bz = b_unit * pb.n[2];
    const double cx = c_unit * pc.n[0], cy = c_unit * pc.n[1], cz = c_unit * pc.n[2];
    const double bcx = by * cz - bz * cy, bcy = bz * cx - bx * cz, bcz = bx * cy - by * cx;
    const double cax = cy * az - cz * ay, cay = cz * ax - cx * az, caz = cx * ay - cy * ax;
    const double abx = ay * bz - az * by, aby = az * bx - ax * bz, abz = ax * by - ay * bx;
    const double determinant = ax * bcx + ay * bcy + az * bcz;
    const double inverse = 1 / determinant;
    const double product = (a_unit * pa.norm) * (b_unit * pb.norm) * (c_unit * pc.norm);
    const double condition = product * std::abs(inverse);
    double x, y, z, factor;
    refined_[slot].tests = 0;
    refined_[slot].solved = refined_[slot].split = false;
    if (!sharp_ && condition < worst_condition && product > smallest_product && pa.reliable && pb.reliable &&
        pc.reliable) {
        x = (pa.h * bcx + pb.h * cax + pc.h * abx) * inverse;
        y = (pa.h * bcy + pb.h * cay + pc.h * aby) * inverse;
        z = (pa.h * bcz + pb.h * caz + pc.h * abz) * inverse;
        factor = solved_factor * condition;
    } else {
        const auto position = exact::near_vertex(seed_, pa.source, pb.source, pc.source);
        x = position[0], y = position[1], z = position[2];
        factor = rounded_factor;
    }
    x_[slot] = x, y_[slot] = y, z_[slot] = z;
    tolerance_[slot] = factor * (std::abs(x) + std::abs(y) + std::abs(z));
    radius_[slot] = (x * x + y * y + z * z) * reach_of_error(factor);
}

bool Cell::clip(std::int32_t id, const exact::Point& q) {
    CellPlane plane;
    for (int k = 0; k < 3; ++k) plane.n[k] = q[k] - seed_[k];
    plane.unit = unit_for(plane.n, 0);
    plane.h = 0.5 * set_norm(plane) / plane.unit;
    plane.id = id;
    plane.source = exact::Plane::bisector(q);
    return clip(plane);
}

bool Cell::clip(std::int32_t id, const exact::Plane& source, const exact::Shift& shift) {
    return clip(make_plane(seed_, id, source, shift));
}

// In a power diagram the bisector with a farther seed may lie on the plane of a face. The face becomes the farther
// seed's, whose power is least beyond the plane. A wall takes the face of a bisector, and the first of equal walls has
// it, in whatever order clip_walls() clips by them. Returns whether the planes are equal.
bool Cell::replace_equal_face(const CellPlane& plane, int slot) {
    const bool is_wall = plane.source.kind == exact::Plane::Kind::wall;
    if (!is_wall && (!plane.source.is_bisector() || plane.source.is_reversed())) return false;
    for (const std::int32_t p : corners_[slot].plane) {
        CellPlane& face = planes_[p];
        const bool of_seed = face.source.is_bisector() && !face.source.is_reversed();
        if (is_wall ? !of_seed && face.source.kind != plane.source.kind
                    : !of_seed || (!face.source.has_power() && !plane.source.has_power()))
            continue;
        double along = 0;  // of the normals, whose rounding is far smaller
        for (std::size_t k = 0; k < 3; ++k) along += (face.unit * face.n[k]) * (plane.unit * plane.n[k]);
        if (along < 0.99 * (face.unit * face.norm) * (plane.unit * plane.norm)) continue;
        if (!exact::same_plane(seed_, face.source, plane.source)) continue;
        if (is_wall ? of_seed || plane.id > face.id : exact::longer_normal(seed_, plane.source, face.source))
            face = plane;
        return true;
    }
    return false;
}

bool Cell::scan(const CellPlane& plane, const FilterPlane& filter) {
    for (int w = 0; w * word_slots < slots_; ++w) {
        auto [possible, certain] = kernels_.classify(block(w), filter);
        possible &= alive_[w];
        certain &= possible;
        for (std::uint64_t m = possible & ~certain; m != 0; m &= m - 1) {
            const int bit = std::countr_zero(m);
            const int side = side_exact(w * word_slots + bit, plane);
            if (side > 0) certain |= 1ull << bit;
            if (side == 0 && replace_equal_face(plane, w * word_slots + bit)) return false;
        }
        for (std::uint64_t m = certain; m != 0; m &= m - 1) killed_.push_back(w * word_slots + std::countr_zero(m));
    }
    return !killed_.empty();
}

int Cell::best_of_sample(const FilterPlane& filter, int slot) const {
    const auto height = [&](int v) { return filter.nx * x_[v] + filter.ny * y_[v] + filter.nz * z_[v]; };
    const int step = static_cast<int>(std::sqrt(static_cast<double>(slots_)));
    double highest = height(slot);
    for (int v = 0; v < slots_; v += step) {
        if (!alive(v) || !(height(v) > highest)) continue;
        highest = height(v);
        slot = v;
    }
    return slot;
}

// The cell is convex, and simple if later planes are pushed outward by far larger infinitesimals. So a vertex that
// certainly lies higher than the three next to it lies higher than all. If it is certainly inside, so are all others.
// The vertices outside are connected by edges between them.
std::optional<bool> Cell::climb(const CellPlane& plane, const FilterPlane& filter) {
    if (!plane.reliable) return std::nullopt;
    const auto height = [&](int v) { return filter.nx * x_[v] + filter.ny * y_[v] + filter.nz * z_[v]; };
    const auto bound = [&](int v) { return filter.norm * tolerance_[v]; };
    // Far vertices may be known so badly that heights say nothing. Successive planes mostly cut near each other: this
    // asks for exact signs a few edges around the last cut. Returns -1 if none is found outside.
    const auto outside_near_last = [&] {
        int found = -1;
        spared_.assign(1, last_);
        visited_[last_] = 1;
        for (std::size_t i = 0; i < spared_.size() && found < 0; ++i) {
            const std::int32_t v = spared_[i];
            const double excess = height(v) - filter.h, doubt = bound(v) + filter.h_error;
            if (excess > doubt || (excess >= -doubt && side_exact(v, plane) > 0)) found = v;
            for (const std::int32_t next : corners_[v].next) {
                if (visited_[next] != 0 || spared_.size() == max_nearby) continue;
                visited_[next] = 1;
                spared_.push_back(next);
            }
        }
        for (const std::int32_t v : spared_) visited_[v] = 0;
        return found;
    };
    int slot = last_;
    double highest = height(slot);
    for (int steps = 0;; ++steps) {
        if (highest - filter.h > bound(slot) + filter.h_error) break;
        if (steps == steps_at_first) {
            slot = best_of_sample(filter, slot);
            highest = height(slot);
        }
        int higher = slot;
        bool certain = true;
        const double from = highest;
        for (const std::int32_t next : corners_[slot].next) {
            const double at = height(next);
            certain = certain && from - at > 2 * (bound(slot) + bound(next)) + smallest_height;
            if (at > highest) highest = at, higher = next;
        }
        if (higher != slot) {
            slot = higher;
            continue;
        }
        if (certain && highest - filter.h < -(bound(slot) + filter.h_error)) return false;
        slot = outside_near_last();
        if (slot < 0) return std::nullopt;
        break;
    }
    killed_.push_back(slot);
    spread(plane, filter);
    return true;
}

void Cell::spread(const CellPlane& plane, const FilterPlane& filter) {
    spared_.clear();
    visited_[killed_.front()] = 1;
    for (std::size_t i = 0; i < killed_.size(); ++i)
        for (const std::int32_t v : corners_[killed_[i]].next) {
            if (visited_[v] != 0) continue;
            visited_[v] = 1;
            const double excess = filter.nx * x_[v] + filter.ny * y_[v] + filter.nz * z_[v] - filter.h;
            const double bound = filter.norm * tolerance_[v] + filter.h_error;
            const bool outside = excess > bound || (excess >= -bound && side_exact(v, plane) > 0);
            (outside ? killed_ : spared_).push_back(v);
        }
    for (const auto* slots : {&killed_, &spared_})
        for (const std::int32_t v : *slots) visited_[v] = 0;
}

bool Cell::clip(const CellPlane& plane) {
    ++test_;
    const FilterPlane filter = filter_of(plane);
    killed_.clear();
    std::optional<bool> any;
    if (slots_ > few_slots && !empty_) any = climb(plane, filter);
    if (!any) any = scan(plane, filter);
    if (!*any) return false;

    // The horizon: edges with one end cut off.
    horizon_.clear();
    for (const std::int32_t v : killed_) visited_[v] = 1;
    for (const std::int32_t v : killed_) {
        const Corner& corner = corners_[v];
        for (int k = 0; k < 3; ++k) {
            const std::int32_t survivor = corner.next[k];
            if (visited_[survivor] == 0)
                horizon_.push_back({corner.plane[k], corner.plane[k == 2 ? 0 : k + 1], survivor});
        }
    }
    if (horizon_.empty()) empty_ = true;
    const auto added = static_cast<std::int32_t>(planes_.size());
    planes_.push_back(plane);
    ring_.resize(planes_.size());
    for (std::size_t k = killed_.size(); k-- > 0;) {  // horizon_ holds all that is needed of them
        const std::int32_t v = killed_[k];
        x_[v] = y_[v] = z_[v] = tolerance_[v] = radius_[v] = 0;
        alive_[v / word_slots] &= ~(1ull << (v % word_slots));
        visited_[v] = 0;
        free_.push_back(v);
    }

    // One new vertex for each horizon edge, linked around the new face by the planes that they share.
    for (const HorizonEdge& edge : horizon_) {
        const int v = allocate_slot();
        alive_[v / word_slots] |= 1ull << (v % word_slots);
        corners_[v].plane = {edge.first, edge.second, added};
        corners_[v].next[0] = edge.survivor;
        Corner& survivor = corners_[edge.survivor];
        for (int k = 0; k < 3; ++k)
            if (survivor.plane[k] == edge.second && survivor.plane[k == 2 ? 0 : k + 1] == edge.first)
                survivor.next[k] = v;
        ring_[edge.first] = v;
        place_vertex(v, edge.first, edge.second, added);
        const std::int32_t place = refined_[edge.survivor].place;
        const bool coincide = place >= 0 && places_[place].test == test_ && places_[place].side == 0;
        refined_[v].place = coincide ? place : -1;
    }
    for (const HorizonEdge& edge : horizon_) {
        const int v = ring_[edge.first], w = ring_[edge.second];
        corners_[v].next[1] = w;  // along planes second, added
        corners_[w].next[2] = v;
        last_ = v;
    }
    radius_known_ = moved_radius_known_ = false;
    return true;
}

bool Cell::same_position(int v, int w, int shared_edge) {
    if (refined_[v].place >= 0 && refined_[v].place == refined_[w].place) return true;
    const double reach = tolerance_[v] + tolerance_[w];
    if (std::abs(x_[v] - x_[w]) > reach || std::abs(y_[v] - y_[w]) > reach || std::abs(z_[v] - z_[w]) > reach)
        return false;
    // Both lie on the line of the shared planes a, b. They coincide when v lies on the third plane of w.
    const std::int32_t a = corners_[v].plane[shared_edge],
                       b = corners_[v].plane[shared_edge == 2 ? 0 : shared_edge + 1];
    for (std::int32_t third : corners_[w].plane) {
        if (third == a || third == b) continue;
        const auto& [p0, p1, p2] = corners_[v].plane;
        used_exact_ = true;
        return exact::side_of_vertex(seed_, planes_[p0].source, planes_[p1].source, planes_[p2].source,
                                     planes_[third].source) == 0;
    }
    return false;
}

void Cell::merge_equal_corners() {
    merged_.resize(slots_);
    for (int v = 0; v < slots_; ++v) merged_[v] = v;
    if (!met_tie_) return;
    auto root = [this](int v) {
        while (merged_[v] != v) v = merged_[v] = merged_[merged_[v]];
        return v;
    };
    for_each_alive([&](int v) {
        for (int k = 0; k < 3; ++k) {
            const int w = corners_[v].next[k];
            if (w > v && same_position(v, w, k)) merged_[root(v)] = root(w);
        }
    });
    for (int v = 0; v < slots_; ++v) merged_[v] = root(v);
}

void Cell::canonical_faces(CellFaces& out) {
    merge_equal_corners();
    out.planes.clear();
    out.corners.clear();
    out.offsets.assign(1, 0);
    out.vertex_count = 0;
    start_.assign(planes_.size(), -1);
    for_each_alive([&](int v) {
        for (std::int32_t p : corners_[v].plane) start_[p] = v;
        if (merged_[v] == v) ++out.vertex_count;
    });
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const std::int32_t first = start_[p];
        if (first < 0) continue;
        const auto begin = out.corners.size();
        int v = first;
        do {
            const Corner& corner = corners_[v];
            const int k = corner.plane[0] == static_cast<std::int32_t>(p)
                              ? 0
                              : (corner.plane[1] == static_cast<std::int32_t>(p) ? 1 : 2);
            const std::int32_t representative = merged_[v];
            if (out.corners.size() == begin || out.corners.back() != representative)
                out.corners.push_back(representative);
            v = corner.next[k == 0 ? 2 : k - 1];
        } while (v != first);
        while (out.corners.size() > begin + 1 && out.corners.back() == out.corners[begin]) out.corners.pop_back();
        if (out.corners.size() < begin + 3) {
            out.corners.resize(begin);
            continue;
        }
        out.planes.push_back(static_cast<std::int32_t>(p));
        out.offsets.push_back(static_cast<std::int32_t>(out.corners.size()));
    }
    out.edge_count = static_cast<std::uint32_t>(out.corners.size() / 2);
}

void Cell::face_planes(std::vector<std::int32_t>& out) {
    out.clear();
    start_.assign(planes_.size(), -1);
    for_each_alive([&](int v) {
        for (std::int32_t p : corners_[v].plane) {
            if (start_[p] < 0) out.push_back(p);
            start_[p] = v;
        }
    });
}

}  // namespace votess::cpu
