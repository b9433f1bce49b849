// Cuts polygons into triangles, exactly.
//
// A plane across one axis shows the polygon without changing a coordinate, so the signs there are exact. Corners are
// swept from left to right; those at one abscissa count from below, as if turned by less than any angle. A status holds
// the sides that meet the sweep line, from below. Two sides that have a point in common become neighbors there before
// the line passes the first such point, and are then found (Shamos, Hoey 1976).
//
// Between each two sides of the status with the inside between them lies a part of the polygon. It keeps a chain of
// corners that wait for triangles, or two chains since two parts met in a corner. Each chain grows as in the cut of a
// monotone polygon (Garey, Johnson, Preparata, Tarjan 1978). So a polygon of n corners takes n log n steps, and its
// triangles have exactly its sides as their boundary, and an area unless corners lie at one place.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/vector3.hpp"
#include "exact/predicate.hpp"
#include "solid/mesh_signs.hpp"
#include "votess/votess.hpp"

namespace votess {
namespace {

using Id = std::int32_t;

constexpr double of_size = 3e-5;            // rounding of files with 6 decimal digits, of the size of all
constexpr double of_coordinates = 0x1p-22;  // rounding to float32

class PolygonCutter {
public:
    PolygonCutter(std::span<const double> vertices, std::int64_t first, std::vector<Id>& triangles)
        : vertices_(vertices), first_(first), triangles_(triangles) {
        double largest = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            double lower = infinity, upper = -infinity;
            for (std::size_t i = k; i < vertices.size(); i += 3)
                lower = std::min(lower, vertices[i]), upper = std::max(upper, vertices[i]);
            size_ = std::max(size_, upper - lower);
            largest = std::max({largest, upper, -lower});
        }
        rounding_ = of_size + of_coordinates * (largest / size_);
    }

    void cut(std::int64_t number, std::span<const Id> corners) {
        number_ = number;
        if (corners.size() < 3) refuse("has " + std::to_string(corners.size()) + " corners: give at least 3");
        for (const Id v : corners)
            if (v < 0 || at(v) >= vertices_.size() / 3)
                refuse("names vertex " + vertex_text(v) + ", but there are " + std::to_string(vertices_.size() / 3));
        if (corners.size() == 3) return add(corners[0], corners[1], corners[2]);
        remove_repeats(corners);
        if (ring_.size() < 3) return;
        if (ring_.size() > 3 && find_plane() && !is_convex()) return sweep();
        for (std::size_t k = 2; k < ring_.size(); ++k) add(ring_[0], ring_[k - 1], ring_[k]);
    }

private:
    enum class From : std::uint8_t { low, high };  // the side of a part that a corner belongs to
    // Corners from left to right. Those after the first lie on one side, and make no convex turn.
    struct Chain {
        std::vector<Id> corners;
        From from = From::low;
    };
    // Between a side and the next one above.
    struct Part {
        Chain low;
        std::optional<Chain> high;  // both end in one corner
    };

    [[noreturn]] void refuse(const std::string& what) const {
        throw Error(ErrorCode::invalid_argument, "face " + std::to_string(number_ + first_) + " " + what);
    }
    [[noreturn]] void refuse_sides(Id e, Id f) const {
        const auto side = [&](Id s) { return vertex_text(ring_[at(s)]) + " to " + vertex_text(ring_[at(next(s))]); };
        refuse("is not simple: its sides from vertex " + side(std::min(e, f)) + " and " + side(std::max(e, f)) +
               " touch or cross: cut it into triangles first");
    }
    [[nodiscard]] std::string vertex_text(Id v) const { return std::to_string(v + first_); }
    [[nodiscard]] exact::Point place(Id v) const {
        const double* x = &vertices_[3 * at(v)];
        return {x[0], x[1], x[2]};
    }
    void add(Id u, Id v, Id w) { triangles_.insert(triangles_.end(), {u, v, w}); }

    // Cuts off corners at the place of the one before.
    void remove_repeats(std::span<const Id> corners) {
        const auto cut_off = [&](Id before, Id here, Id after) {
            if (before != here && here != after && after != before) add(before, here, after);
        };
        ring_.clear();
        for (std::size_t k = 0; k < corners.size(); ++k) {
            if (ring_.empty() || place(ring_.back()) != place(corners[k]))
                ring_.push_back(corners[k]);
            else
                cut_off(ring_.back(), corners[k], corners[(k + 1) % corners.size()]);
        }
        while (ring_.size() > 1 && place(ring_.back()) == place(ring_.front())) {
            const Id last = ring_.back();
            ring_.pop_back();
            cut_off(ring_.back(), last, ring_.front());
        }
    }

    [[nodiscard]] Vector3 from_first(Id corner) const {
        Vector3 x = minus(place(ring_[at(corner)]), place(ring_[0]));
        for (double& coordinate : x) coordinate /= size_;
        return x;
    }

    // Finds the axis to look along. Returns false if all corners lie on one line, to rounding. Throws if they lie in no
    // plane.
    bool find_plane() {
        Vector3 farthest{}, normal{};  // of a wide triangle of corners
        for (Id k = 0; k < size(); ++k)
            if (const Vector3 x = from_first(k); dot(x, x) > dot(farthest, farthest)) farthest = x;
        for (Id k = 0; k < size(); ++k)
            if (const Vector3 n = cross(farthest, from_first(k)); dot(n, n) > dot(normal, normal)) normal = n;
        const double length = length3(normal);
        if (length <= rounding_ * length3(farthest)) return false;
        for (Id k = 0; k < size(); ++k)
            if (const double height = std::abs(dot(normal, from_first(k))); height > rounding_ * length)
                refuse("is not flat: its vertex " + vertex_text(ring_[at(k)]) + " lies " +
                       number(height / length * size_) + " off the plane of others: cut it into triangles first");
        axis_ = 0;
        for (std::size_t i = 1; i < 3; ++i)
            if (std::abs(normal[i]) > std::abs(normal[axis_])) axis_ = i;
        mirrored_ = false;
        Id leftmost = 0;
        for (Id k = 1; k < size(); ++k)
            if (seen(k) < seen(leftmost)) leftmost = k;
        mirrored_ = turn(previous(leftmost), leftmost, next(leftmost)) < 0;
        return true;
    }

    [[nodiscard]] Id size() const { return static_cast<Id>(ring_.size()); }
    [[nodiscard]] Id next(Id k) const { return k + 1 == size() ? 0 : k + 1; }
    [[nodiscard]] Id previous(Id k) const { return k == 0 ? size() - 1 : k - 1; }
    // Returns where a corner is seen, so that the polygon runs counterclockwise.
    [[nodiscard]] std::array<double, 2> seen(Id k) const {
        const exact::Point x = place(ring_[at(k)]);
        std::array<double, 2> flat{x[(axis_ + 1) % 3], x[(axis_ + 2) % 3]};
        if (mirrored_) std::swap(flat[0], flat[1]);
        return flat;
    }
    // Returns 1 for a turn to the left.
    [[nodiscard]] int turn(Id a, Id b, Id c) const {
        const int sign =
            solid::cross_sign(place(ring_[at(a)]), place(ring_[at(b)]), place(ring_[at(c)]), static_cast<int>(axis_));
        return mirrored_ ? -sign : sign;
    }

    // Returns whether all turns go left, once around.
    [[nodiscard]] bool is_convex() const {
        int reversals = 0;
        for (Id k = 0; k < size(); ++k) {
            if (turn(previous(k), k, next(k)) <= 0) return false;
            if ((seen(previous(k)) < seen(k)) != (seen(k) < seen(next(k)))) ++reversals;
        }
        return reversals == 2;
    }

    // A side is named by the corner where it begins.
    [[nodiscard]] bool runs_right(Id side) const { return rank_[at(side)] < rank_[at(next(side))]; }
    [[nodiscard]] Id left(Id side) const { return runs_right(side) ? side : next(side); }
    [[nodiscard]] Id right(Id side) const { return runs_right(side) ? next(side) : side; }
    [[nodiscard]] Id other_end(Id side, Id corner) const { return corner == side ? next(side) : side; }

    // Orders sides that the sweep line meets.
    struct Below {
        const PolygonCutter* cutter;
        bool operator()(Id e, Id f) const { return e != f && cutter->is_below(e, f); }
    };
    [[nodiscard]] bool is_below(Id e, Id f) const {
        const Id a = left(e), b = left(f);
        int sign = 0;  // 1 if f is above e
        if (a == b)
            sign = turn(a, right(e), right(f));
        else
            sign = rank_[at(a)] < rank_[at(b)] ? turn(a, right(e), b) : -turn(b, right(f), a);
        if (sign == 0) refuse_sides(e, f);
        return sign > 0;
    }

    // Throws if two sides have more in common than the corner between them.
    void check_apart(Id e, Id f) const {
        if (next(e) == f || next(f) == e) {
            const Id shared = next(e) == f ? f : e, p = other_end(e, shared), q = other_end(f, shared);
            if (turn(shared, p, q) == 0 && (rank_[at(p)] < rank_[at(shared)]) == (rank_[at(q)] < rank_[at(shared)]))
                refuse_sides(e, f);
            return;
        }
        const auto across = [&](Id s, Id t) { return turn(s, next(s), t) * turn(s, next(s), next(t)) <= 0; };
        const bool overlap = rank_[at(left(e))] <= rank_[at(right(f))] && rank_[at(left(f))] <= rank_[at(right(e))];
        if (overlap && across(e, f) && across(f, e)) refuse_sides(e, f);
    }

    using Status = std::set<Id, Below>;

    void insert(Status& status, Id side) {
        const auto it = status.insert(side).first;
        if (it != status.begin()) check_apart(*std::prev(it), side);
        if (std::next(it) != status.end()) check_apart(side, *std::next(it));
    }
    void remove(Status& status, Id side) {
        const auto it = status.find(side);
        const auto after = std::next(it);
        if (it != status.begin() && after != status.end()) check_apart(*std::prev(it), *after);
        status.erase(it);
    }
    // Returns the side below the part that lies below a side.
    [[nodiscard]] Id low_side(const Status& status, Id high) const {
        const auto it = status.find(high);
        if (it == status.begin() || !runs_right(*std::prev(it))) refuse_sides(high, next(high));
        return *std::prev(it);
    }

    // Adds a corner to a chain, and the triangles that it closes.
    void grow(Chain& chain, Id corner, From from) {
        auto& c = chain.corners;
        if (from == chain.from || c.size() == 1) {
            const int convex = from == From::low ? 1 : -1;
            for (; c.size() > 1 && turn(c[c.size() - 2], c.back(), corner) == convex; c.pop_back())
                close(from, c[c.size() - 2], c.back(), corner);
        } else {
            finish(chain, corner);
            c.erase(c.begin(), c.end() - 1);
        }
        chain.from = from;
        c.push_back(corner);
    }
    void close(From from, Id u, Id v, Id corner) {
        if (from == From::high) std::swap(u, v);
        add(ring_[at(u)], ring_[at(v)], ring_[at(corner)]);
    }
    // Joins a corner to all of a chain.
    void finish(const Chain& chain, Id corner) {
        for (std::size_t k = 1; k < chain.corners.size(); ++k)
            close(chain.from, chain.corners[k - 1], chain.corners[k], corner);
    }
    // Adds a corner on a side of a part.
    void grow(Part& part, Id corner, From from) {
        if (part.high) {
            finish(from == From::high ? *part.high : part.low, corner);
            if (from == From::low) part.low = std::move(*part.high);
            part.high.reset();
        }
        grow(part.low, corner, from);
    }

    void sweep() {
        std::vector<Id> order(ring_.size());
        std::iota(order.begin(), order.end(), 0);
        std::ranges::sort(order, {}, [&](Id k) { return std::pair(seen(k), k); });
        rank_.resize(order.size());
        for (Id r = 0; r < size(); ++r) rank_[at(order[at(r)])] = r;
        for (std::size_t k = 1; k < order.size(); ++k)
            if (const Id a = order[k - 1], b = order[k]; seen(a) == seen(b))
                refuse("is not simple: its vertices " + vertex_text(ring_[at(a)]) + " and " +
                       vertex_text(ring_[at(b)]) + " lie at one place: cut it into triangles first");
        Status status(Below{this});
        parts_.assign(order.size(), {});  // by the side below
        for (const Id corner : order) {
            check_stop();
            const Id before = previous(corner), after = corner;  // sides
            if (runs_right(after)) {
                if (runs_right(before))
                    pass_low(status, corner, before, after);
                else
                    begin(status, corner, before, after);
            } else {
                if (runs_right(before))
                    end(status, corner, before, after);
                else
                    pass_high(status, corner, before, after);
            }
        }
    }
    void pass_low(Status& status, Id corner, Id before, Id after) {
        Part part = std::move(parts_[at(before)]);
        remove(status, before);
        insert(status, after);
        grow(part, corner, From::low);
        parts_[at(after)] = std::move(part);
    }
    void pass_high(Status& status, Id corner, Id before, Id after) {
        grow(parts_[at(low_side(status, after))], corner, From::high);
        remove(status, after);
        insert(status, before);
    }
    // Both neighbors are to the right.
    void begin(Status& status, Id corner, Id before, Id after) {
        insert(status, before);
        insert(status, after);
        Part& made = parts_[at(after)];
        if (turn(previous(corner), corner, next(corner)) > 0) {
            const auto it = status.find(after);
            if (it != status.begin() && runs_right(*std::prev(it))) refuse_sides(after, *std::prev(it));
            made.low.corners = {corner};
            return;
        }
        Part& split = parts_[at(low_side(status, before))];
        if (split.high) {
            made.low = std::move(*split.high);
            split.high.reset();
        } else if (const Id nearest = split.low.corners.back(); split.low.from == From::high) {
            made.low.corners = {nearest};
        } else {
            made.low = std::exchange(split.low, {{nearest}, From::high});
        }
        grow(split.low, corner, From::high);
        grow(made.low, corner, From::low);
    }
    // Both neighbors are to the left.
    void end(Status& status, Id corner, Id before, Id after) {
        const Id low = low_side(status, after);
        Part& below = parts_[at(low)];
        if (turn(previous(corner), corner, next(corner)) > 0) {
            if (low != before) refuse_sides(before, low);
            finish(below.low, corner);
            if (below.high) finish(*below.high, corner);
        } else {
            Part& above = parts_[at(before)];
            grow(below, corner, From::high);
            grow(above, corner, From::low);
            below.high = std::move(above.low);
        }
        remove(status, before);
        remove(status, after);
    }

    std::span<const double> vertices_;
    std::int64_t first_;
    double size_ = 0, rounding_ = 0;  // of all vertices; of places, as a share of the size
    std::vector<Id>& triangles_;
    std::int64_t number_ = 0;
    std::vector<Id> ring_;  // the corners
    std::size_t axis_ = 0;  // to look along
    bool mirrored_ = false;
    std::vector<Id> rank_;  // of corners, from the left
    std::vector<Part> parts_;
};

}  // namespace

std::vector<std::int32_t> triangulate(const PolygonMesh& mesh) {
    const auto refuse = [](const std::string& message) { throw Error(ErrorCode::invalid_argument, message); };
    if (mesh.vertices.size() % 3 != 0)
        refuse("vertices hold " + std::to_string(mesh.vertices.size()) + " numbers, not a multiple of 3");
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        if (!std::isfinite(mesh.vertices[i]))
            refuse("vertex " + std::to_string(static_cast<std::int64_t>(i / 3) + mesh.first) + ": " + axis_name[i % 3] +
                   " = " + number(mesh.vertices[i]) + " is not finite");
    std::vector<std::int32_t> triangles;
    PolygonCutter cutter(mesh.vertices, mesh.first, triangles);
    for (std::size_t f = 0; f + 1 < mesh.offsets.size(); ++f) {
        const std::int64_t begin = mesh.offsets[f], end = mesh.offsets[f + 1];
        if (begin < 0 || end < begin || static_cast<std::uint64_t>(end) > mesh.corners.size())
            refuse("offsets hold " + std::to_string(begin) + " and " + std::to_string(end) +
                   ": give numbers from 0 to " + std::to_string(mesh.corners.size()) + " that do not fall");
        cutter.cut(static_cast<std::int64_t>(f),
                   mesh.corners.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)));
    }
    return triangles;
}

}  // namespace votess
