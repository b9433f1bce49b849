#include "solid/ear_clipping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/progress.hpp"

namespace votess::solid {
namespace {

constexpr double thin_ear = 1e-7;  // twice the area of a thick ear, over its longest side squared

constexpr std::size_t corners_per_stop = 64;  // after which the user may stop
constexpr double same_direction = 1e-9;       // of the sine of an angle
constexpr double grid = 0x1p-36;              // of the size of a polygon: nearer corners count as touching

// Returns a key of an edge without a direction.
std::uint64_t edge(std::int32_t a, std::int32_t b) {
    return static_cast<std::uint64_t>(std::max(a, b)) << 32 | static_cast<std::uint32_t>(std::min(a, b));
}

}  // namespace

double doubled_area(const std::vector<FlatCorner>& loop) {
    double sum = 0;
    const FlatCorner& base = loop.front();
    for (std::size_t i = 2; i < loop.size(); ++i)
        sum += (loop[i - 1].x - base.x) * (loop[i].y - base.y) - (loop[i].x - base.x) * (loop[i - 1].y - base.y);
    return sum;
}

const std::vector<std::array<std::int32_t, 3>>& EarClipping::cut(std::span<const std::vector<FlatCorner>> loops) {
    nodes_.clear();
    triangles_.clear();
    const double mirror = doubled_area(loops.front()) < 0 ? -1 : 1;
    double size = 0;
    for (const FlatCorner& c : loops.front()) size = std::max({size, std::abs(c.x), std::abs(c.y)});
    unit_ = size > 0 ? std::exp2(std::ceil(std::log2(size))) * grid : 1;
    slack_ = unit_ * size;
    const std::int32_t outline = add_loop(loops.front(), mirror);
    holes_.clear();
    for (const auto& loop : loops.subspan(1)) {
        const std::int32_t first = add_loop(loop, mirror);
        std::int32_t right = first;
        for (std::int32_t n = node(first).next; n != first; n = node(n).next)
            if (node(n).x > node(right).x) right = n;
        holes_.push_back(right);
    }
    // From the right, so that a ray meets the outline or a hole that is joined to it.
    std::ranges::stable_sort(holes_, std::ranges::greater(), [&](std::int32_t n) { return node(n).x; });
    for (const std::int32_t hole : holes_) join(hole, outline);
    clip(outline);
    return triangles_;
}

double EarClipping::turn(std::int32_t a, std::int32_t b, std::int32_t c) const {
    const Node &p = node(a), &q = node(b), &r = node(c);
    return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

std::int32_t EarClipping::add_loop(const std::vector<FlatCorner>& loop, double mirror) {
    const auto first = static_cast<std::int32_t>(nodes_.size()), count = static_cast<std::int32_t>(loop.size());
    for (std::int32_t i = 0; i < count; ++i) {
        const FlatCorner& c = loop[static_cast<std::size_t>(i)];
        nodes_.push_back({std::round(c.x / unit_) * unit_, std::round(mirror * c.y / unit_) * unit_, c.id,
                          first + (i + count - 1) % count, first + (i + 1) % count, false, false});
    }
    return first;
}

// Joins a hole by two edges between the same corners, in opposite directions.
void EarClipping::join(std::int32_t hole, std::int32_t outline) {
    check_stop();
    const std::int32_t bridge = find_bridge(hole, outline);
    const auto hole_again = static_cast<std::int32_t>(nodes_.size()), bridge_again = hole_again + 1;
    nodes_.push_back(node(hole));
    nodes_.push_back(node(bridge));
    const std::int32_t after = node(bridge).next, before = node(hole).previous;
    node(bridge).next = hole;
    node(hole).previous = bridge;
    node(before).next = hole_again;
    node(hole_again).previous = before;
    node(hole_again).next = bridge_again;
    node(bridge_again).previous = hole_again;
    node(bridge_again).next = after;
    node(after).previous = bridge_again;
}

// Returns a corner of the outline that the rightmost corner of a hole sees. It is the end of the edge to its right, or
// a corner in front of that.
std::int32_t EarClipping::find_bridge(std::int32_t hole, std::int32_t outline) const {
    const Node& m = node(hole);
    double hit = std::numeric_limits<double>::infinity();
    std::int32_t best = -1, nearest = outline;
    double nearest_square = std::numeric_limits<double>::infinity();
    std::int32_t n = outline;
    do {
        const Node &a = node(n), &b = node(a.next);
        const double square = (a.x - m.x) * (a.x - m.x) + (a.y - m.y) * (a.y - m.y);
        if (square < nearest_square) nearest_square = square, nearest = n;
        if (a.y <= m.y && m.y <= b.y && a.y < b.y) {  // upward
            const double x = a.x + (m.y - a.y) / (b.y - a.y) * (b.x - a.x);
            if (x >= m.x && x < hit) {
                hit = x;
                best = m.y == a.y ? n : m.y == b.y ? a.next : a.x > b.x ? n : a.next;
            }
        }
        n = a.next;
    } while (n != outline);
    if (best < 0) return nearest;
    const Node end = node(best);
    const auto in_front = [&](const Node& p) {
        const auto side = [](double ax, double ay, double bx, double by, const Node& q) {
            return (bx - ax) * (q.y - ay) - (by - ay) * (q.x - ax);
        };
        const double s0 = side(m.x, m.y, hit, m.y, p), s1 = side(hit, m.y, end.x, end.y, p),
                     s2 = side(end.x, end.y, m.x, m.y, p);
        return (s0 >= 0 && s1 >= 0 && s2 >= 0) || (s0 <= 0 && s1 <= 0 && s2 <= 0);
    };
    double slope = std::numeric_limits<double>::infinity();
    n = outline;
    do {
        const Node& p = node(n);
        if (p.x > m.x && in_front(p)) {
            const double its = std::abs(p.y - m.y) / (p.x - m.x);
            const bool nearer = its == slope && p.x < node(best).x;
            // Two corners may be at one place: the angle of the right one holds the hole.
            const bool left_of_first = turn(p.previous, n, hole) >= 0, left_of_second = turn(n, p.next, hole) >= 0;
            const bool opens =
                turn(p.previous, n, p.next) > 0 ? left_of_first && left_of_second : left_of_first || left_of_second;
            if ((its < slope || nearer) && opens) slope = its, best = n;
        }
        n = p.next;
    } while (n != outline);
    return best;
}

// Returns whether two angles at a corner, each below 180 degrees, have directions in common.
bool EarClipping::overlap(std::int32_t corner, const Angle& one, const Angle& other) const {
    const Node& at = node(corner);
    struct Direction {
        double x, y;
    };
    const auto towards = [&](std::int32_t k) {
        const double x = node(k).x - at.x, y = node(k).y - at.y, length = std::hypot(x, y);
        return length > 0 ? Direction{x / length, y / length} : Direction{0, 0};
    };
    const std::array<Direction, 2> a{towards(one.from), towards(one.to)}, b{towards(other.from), towards(other.to)};
    const auto inside = [](const Direction& d, const std::array<Direction, 2>& angle) {
        const auto turn = [](const Direction& u, const Direction& v) { return u.x * v.y - u.y * v.x; };
        return turn(angle[0], d) > same_direction && turn(d, angle[1]) > same_direction &&
               turn(angle[0], angle[1]) > same_direction;
    };
    const auto any_inside = [&](const auto& u, const auto& v) {
        return inside(u[0], v) || inside(u[1], v) || inside({u[0].x + u[1].x, u[0].y + u[1].y}, v);
    };
    return any_inside(a, b) || any_inside(b, a);
}

void EarClipping::set_reflex(std::int32_t n) {
    node(n).reflex = turn(node(n).previous, n, node(n).next) <= 0;
}

bool EarClipping::is_ear(std::int32_t n, Demand demand) const {
    const Node &b = node(n), &a = node(b.previous), &c = node(b.next);
    if (demand == Demand::any) return true;
    if (a.id == b.id || b.id == c.id || c.id == a.id) return false;
    const double area = turn(b.previous, n, b.next);
    const auto square = [](const Node& p, const Node& q) {
        return (q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y);
    };
    if (demand == Demand::flat ? area < 0 : !(area > 0)) return false;
    if (demand == Demand::overlapping) return true;
    if (edges_.contains(edge(a.id, c.id))) return false;
    if (demand == Demand::thick && area < thin_ear * std::max({square(a, b), square(b, c), square(c, a)})) return false;
    const auto same_place = [](const Node& p, const Node& q) { return p.x == q.x && p.y == q.y; };
    const double left = std::min({a.x, b.x, c.x}), right = std::max({a.x, b.x, c.x});
    const double low = std::min({a.y, b.y, c.y}), high = std::max({a.y, b.y, c.y});
    const auto at = std::ranges::lower_bound(by_x_, left, {}, [&](std::int32_t k) { return node(k).x; });
    for (auto it = at; it != by_x_.end() && node(*it).x <= right; ++it) {
        const Node& p = node(*it);
        if (p.gone || p.y < low || p.y > high || *it == n || *it == b.previous || *it == b.next) continue;
        if (same_place(p, a) || same_place(p, b) || same_place(p, c)) {
            const std::int32_t corner = same_place(p, a) ? b.previous : same_place(p, b) ? n : b.next;
            const Angle ear{corner == n        ? b.next
                            : corner == b.next ? b.previous
                                               : n,
                            corner == n        ? b.previous
                            : corner == b.next ? n
                                               : b.next};
            // A corner of a hole that touches: the hole must stay outside. A pinch, or a bridge: both angles are
            // inside.
            const bool hole = p.reflex && p.id != node(corner).id;
            if (overlap(corner, ear, hole ? Angle{p.previous, p.next} : Angle{p.next, p.previous})) return false;
        } else if (p.reflex && turn(b.previous, n, *it) >= -slack_ && turn(n, b.next, *it) >= -slack_ &&
                   turn(b.next, b.previous, *it) >= -slack_) {
            return false;
        }
    }
    return true;
}

void EarClipping::clip(std::int32_t start) {
    by_x_.clear();
    edges_.clear();
    std::int32_t n = start;
    do {
        set_reflex(n);
        by_x_.push_back(n);
        edges_.insert(edge(node(n).id, node(node(n).next).id));
        n = node(n).next;
    } while (n != start);
    std::ranges::sort(by_x_, {}, [&](std::int32_t k) { return node(k).x; });
    std::size_t count = by_x_.size(), tried = 0, looks = 0;
    for (auto demand = Demand::thick; count >= 3;) {
        if (++looks % corners_per_stop == 0) check_stop();
        if (count == 3 || is_ear(n, demand)) {
            const std::int32_t previous = node(n).previous, next = node(n).next;
            triangles_.push_back({node(previous).id, node(n).id, node(next).id});
            edges_.insert(edge(node(previous).id, node(next).id));
            node(n).gone = true;
            if (--count < 3) return;
            node(previous).next = next;
            node(next).previous = previous;
            set_reflex(previous);
            set_reflex(next);
            n = node(next).next;  // not a fan around one corner
            demand = Demand::thick;
            tried = 0;
            continue;
        }
        n = node(n).next;
        if (++tried < count) continue;
        demand = static_cast<Demand>(static_cast<std::uint8_t>(demand) + 1);
        tried = 0;
    }
}

}  // namespace votess::solid
