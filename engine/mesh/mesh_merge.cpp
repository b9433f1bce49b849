// Matching the polygons of a face as its two cells have them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/errors.hpp"
#include "mesh/mesh_builder.hpp"

namespace votess {
namespace {

// The best turn is that of equal polygons when every other one is so much farther off, in squares.
constexpr double clearly_worse = 100;
// Relative to the largest, positions of a vertex in the cells that share it differ by less than this.
constexpr double position_error = 1e-9;
// And by this relative to the largest coordinate.
constexpr double absolute_error = 0x1p-50;

exact::Shift wide(const std::array<std::int8_t, 3>& s) {
    return {s[0], s[1], s[2]};
}

// Returns the label as a cell sees it that lies `shift` away from where the label counts from.
bool same(const FaceLabel& a, const FaceLabel& b, const exact::Shift& b_shift) {
    if (a.id != b.id) return false;
    return a.id < 0 || wide(a.shift) == VertexSets::sum(wide(b.shift), b_shift);
}

}  // namespace

void FaceMatcher::unite_faces(std::size_t row) {
    const MeshCellView cell(records_[row]);
    const std::size_t i = job_.only ? static_cast<std::size_t>(job_.only->ids()[row]) : row;
    const FaceLabel own{static_cast<std::int32_t>(i), {}};
    for (std::size_t face = 0; face < cell.faces(); ++face) {
        const FaceLabel there = label(row, face);
        if (there < own) continue;
        const std::int32_t of_other = job_.only ? job_.only->row_of(there.id) : there.id;
        if (of_other < 0) continue;  // not in the subset
        const auto j = static_cast<std::size_t>(of_other);
        if (there.shift == own.shift && MeshCellView::share(cell, records_[j])) continue;
        const MeshCellView other(records_[j]);
        const Side a{cell, row, i, face},
            b{other, j, static_cast<std::size_t>(there.id), rows_.find(j, there.seen_from_behind(i)) - rows_.begin(j)};
        if (b.face >= other.faces() || a.count() != b.count())
            bug("cells " + std::to_string(i) + " and " + std::to_string(there.id) +
                " differ in the face that they share");
        unite_sides(a, b, wide(there.shift));
    }
}

// The other cell's polygon runs the other way round: its corner t is this one's corner (turn - t).
void FaceMatcher::unite_sides(const Side& a, const Side& b, const exact::Shift& shift) {
    const std::uint32_t count = a.count();
    std::uint32_t turn = 1;  // both begin with the same edge
    if (!same(beginning(a), beginning(b), shift)) {
        bool clear = false;
        turn = turn_by_distance(a, b, clear);
        if (!clear) turn = turn_by_edges(a, b, shift).value_or(turn);
    }
    const std::uint32_t first_a = vertices_of_[a.cell.block()].first, first_b = vertices_of_[b.cell.block()].first;
    for (std::uint32_t t = 0; t < count; ++t) {
        const std::uint32_t s = turn + (turn < t ? count : 0) - t;
        sets_.unite(first_a + number(a.cell, a.cell.corner(a.begin() + (s == count ? 0 : s))),
                    first_b + number(b.cell, b.cell.corner(b.begin() + t)), shift);
    }
}

FaceLabel FaceMatcher::beginning(const Side& side) const {
    const std::size_t face = side.cell.beginning(side.face), hidden = side.cell.hidden();
    return face < hidden ? side.cell.hidden_label(face) : label(side.row, face - hidden);
}

// From the seed.
std::array<double, 3> FaceMatcher::position(const MeshCellView& cell, std::uint32_t vertex) const {
    const double* x = vertices_of_[cell.block()].positions.data() + std::size_t{3} * number(cell, vertex);
    const auto& o = cell.origin();
    return {x[0] - o[0], x[1] - o[1], x[2] - o[2]};
}

std::array<double, 3> FaceMatcher::middle(const Side& side) const {
    std::array<double, 3> sum{};
    for (std::uint32_t k = 0; k < side.count(); ++k) {
        const auto x = position(side.cell, side.cell.corner(side.begin() + k));
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += x[axis];
    }
    for (double& x : sum) x /= side.count();
    return sum;
}

// Where more than three cells meet at an edge, the cells of a face name different ones.
std::uint32_t FaceMatcher::turn_by_distance(const Side& a, const Side& b, bool& clear) const {
    const auto middle_a = middle(a), middle_b = middle(b);
    const std::uint32_t a_begin = a.begin(), b_begin = b.begin(), count = a.count();
    double best = std::numeric_limits<double>::infinity(), second = best, size = 0, offset = 0;
    for (std::uint32_t t = 0; t < count; ++t) {
        const auto x = position(a.cell, a.cell.corner(a_begin + t)), y = position(b.cell, b.cell.corner(b_begin + t));
        for (std::size_t axis = 0; axis < 3; ++axis) size = std::max({size, std::abs(x[axis]), std::abs(y[axis])});
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        offset = std::max({offset, std::abs(a.cell.origin()[axis]), std::abs(b.cell.origin()[axis])});
    std::uint32_t best_turn = 0;
    for (std::uint32_t turn = 0; turn < count; ++turn) {
        double sum = 0;
        for (std::uint32_t t = 0; t < count && sum < second; ++t) {
            const auto x = position(a.cell, a.cell.corner(a_begin + (turn + count - t) % count));
            const auto y = position(b.cell, b.cell.corner(b_begin + t));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double d = (x[axis] - middle_a[axis]) - (y[axis] - middle_b[axis]);
                sum += d * d;
            }
        }
        if (sum < best) {
            second = best;
            best = sum;
            best_turn = turn;
        } else {
            second = std::min(second, sum);
        }
    }
    const double rounding = position_error * size + absolute_error * (size + offset);
    clear = best * clearly_worse < second && second > count * rounding * rounding;
    return best_turn;
}

// For a polygon smaller than rounding errors: an edge of one side equals the edge of the other side on the same line.
// Exact arithmetic decides it from its two corners.
std::optional<std::uint32_t> FaceMatcher::turn_by_edges(const Side& a, const Side& b, const exact::Shift& shift) const {
    const std::uint32_t count = a.count();
    const std::size_t i = a.seed;
    const exact::Point p = point(i);
    const exact::Plane shared = plane(i, label(a.row, a.face), {});
    for (std::uint32_t k = 0; k < count; ++k) {
        const auto before = label_across(a, k == 0 ? count - 1 : k - 1), edge = label_across(a, k),
                   after = label_across(a, k + 1 == count ? 0 : k + 1);
        if (!before || !edge || !after) continue;
        const exact::Plane across = plane(i, *edge, {});
        for (std::uint32_t q = 0; q < count; ++q) {
            const auto theirs = label_across(b, q);
            if (!theirs) continue;
            const exact::Plane other = plane(i, *theirs, shift);
            if (exact::side_of_vertex(p, shared, plane(i, *before, {}), across, other) == 0 &&
                exact::side_of_vertex(p, shared, across, plane(i, *after, {}), other) == 0)
                return (k + 1 + q) % count;
        }
    }
    return std::nullopt;
}

exact::Shift FaceMatcher::wrapped(std::size_t i) const {
    return job_.domain->is_periodic() ? wrap(*job_.domain, point(i)).value_or(exact::Shift{}) : exact::Shift{};
}

// Returns the plane of a face of cell i, or of the cell that lies `shift` away. On the plane between these two cells,
// the bisectors of both with a third seed meet in one line.
exact::Plane FaceMatcher::plane(std::size_t i, const FaceLabel& label, const exact::Shift& shift) const {
    const Domain& domain = *job_.domain;
    if (label.id < -6) return domain.walls[static_cast<std::size_t>(-7 - label.id)];
    if (label.id < 0) return domain.box_wall(-1 - label.id);
    const auto j = static_cast<std::size_t>(label.id);
    const exact::Shift own = wrapped(i), theirs = wrapped(j);
    exact::Shift total;
    for (std::size_t k = 0; k < 3; ++k) total[k] = label.shift[k] + shift[k] + theirs[k] - own[k];
    exact::Plane plane = exact::Plane::bisector(point(j), total, domain.lattice);
    if (domain.has_weights()) plane.power = exact::two_sum(domain.weights[i], -domain.weights[j]);
    return plane;
}

// Returns the face across the edge that begins at a corner; nothing for a wall that has no place in the row.
std::optional<FaceLabel> FaceMatcher::label_across(const Side& side, std::uint32_t place) const {
    const MeshCellView& cell = side.cell;
    const auto next = [&](std::size_t face, std::uint32_t k) {
        return cell.corner(k + 1 == cell.end(face) ? cell.begin(face) : k + 1);
    };
    const std::uint32_t k = side.begin() + place, from = cell.corner(k), to = next(side.face, k);
    for (std::size_t face = 0; face < cell.faces(); ++face)
        for (std::uint32_t c = cell.begin(face); c < cell.end(face); ++c)
            if (cell.corner(c) == to && next(face, c) == from) return label(side.row, face);
    return std::nullopt;
}

}  // namespace votess
