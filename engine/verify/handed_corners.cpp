#include "verify/handed_corners.hpp"

#include <algorithm>
#include <cmath>

namespace votess {

void HandedCorners::begin(std::span<const std::int32_t> order, std::span<const std::int32_t> ranks, std::size_t begin,
                          std::size_t end) {
    order_ = order.subspan(begin, end - begin);
    ranks_ = ranks;
    begin_ = static_cast<std::int32_t>(begin);
    found_.clear();
    free_ = none;
    first_.assign(end - begin, none);
    left_.assign(end - begin, 0);
    slots_.assign(end - begin, {none, 0});
}

// Finds which planes are those of cells of the block.
void HandedCorners::look_around(const RowPolytope& polytope, std::uint32_t cell) {
    const std::span<const RowPolytope::Name> names = polytope.names();
    sides_.assign(names.size(), Side::other);
    cells_.resize(names.size());
    for (std::size_t f = 0; f < names.size(); ++f) {
        if (names[f].id < 0 || !is_zero(names[f].shift)) continue;
        const std::uint32_t other = local(names[f].id);
        if (other >= order_.size()) continue;
        slots_[other] = {cell, static_cast<std::int32_t>(f)};
        cells_[f] = other;
        if (left_[other] == 0) sides_[f] = other < cell ? Side::earlier : Side::later;
    }
}

// Returns false if a cell that the corner needs is not in the row.
bool HandedCorners::take_handed(const RowPolytope& polytope, std::uint32_t cell) {
    const PlaneArrays& p = polytope.arrays();
    if (known_.size() < at(2 * polytope.planes())) known_.resize(at(2 * polytope.planes()));
    handed_ = 0;
    return for_handed(cell, [&](const Found& found, std::size_t k) {
        const std::array<std::uint32_t, 3> others = found.seen_from(k);
        const Slot &a = slots_[others[0]], &b = slots_[others[1]], &c = slots_[others[2]];
        const auto from = static_cast<std::size_t>(slots_[found.cells[0]].plane);
        if (a.cell != cell || b.cell != cell || c.cell != cell || handed_ == known_.size()) return false;
        RowPolytope::KnownCorner& corner = known_[handed_++];
        const double x = found.at[0] + p.nx[from], y = found.at[1] + p.ny[from], z = found.at[2] + p.nz[from];
        corner.planes[0] = a.plane, corner.planes[1] = b.plane, corner.planes[2] = c.plane;
        corner.at[0] = x, corner.at[1] = y, corner.at[2] = z;
        corner.error = found.error + 0x1p-50 * (std::abs(x) + std::abs(y) + std::abs(z) + p.length[from]);
        return true;
    });
}

bool HandedCorners::has_one_top(const RowPolytope& polytope, std::size_t direction) {
    normals_.resize(at(polytope.planes()));
    for (std::size_t f = 0; f < normals_.size(); ++f) normals_[f] = seen_along(polytope.arrays(), f, direction);
    int tops = 0;
    for (const RowPolytope::Corner& corner : polytope.corners()) {
        const auto& [a, b, c] = corner.planes;
        tops += top_of(normals_[at(a)], normals_[at(b)], normals_[at(c)]);
    }
    return tops == 1;
}

// D
bool HandedCorners::check_edges(RowPolytope& polytope) {
    const int known = static_cast<int>(handed_);
    for (const RowPolytope::Edge& edge : polytope.edges()) {
        if (edge.from >= known || edge.to >= known) continue;
        if (sides_[at(edge.left)] == Side::earlier || sides_[at(edge.right)] == Side::earlier) continue;
        const auto& [a, b, c] = polytope.corners()[at(edge.to)].planes;
        if (!polytope.is_inside(edge.from, a + b + c - edge.left - edge.right)) return false;
    }
    return true;
}

bool HandedCorners::close(RowPolytope& polytope, std::size_t seed, std::size_t faces) {
    cell_ = local(static_cast<std::int32_t>(seed));
    look_around(polytope, cell_);
    if (polytope.unit() != 1 || !take_handed(polytope, cell_) || !polytope.wrap_surely(std::span(known_).first(handed_))) return false;
    for (std::size_t f = 0; f < faces; ++f)
        if (!polytope.has_face(static_cast<int>(f))) return false;
    if (!has_one_top(polytope, 0) && !has_one_top(polytope, 1)) return false;
    return check_edges(polytope);
}

bool HandedCorners::hand_on(const RowPolytope& polytope) {
    const std::span<const RowPolytope::Corner> corners = polytope.corners();
    new_.clear();
    to_name_.clear();
    for (std::size_t v = handed_; v < corners.size(); ++v) {
        const auto& [a, b, c] = corners[v].planes;
        const std::array sides{sides_[at(a)], sides_[at(b)], sides_[at(c)]};
        if (std::ranges::count(sides, Side::other) > 0)
            to_name_.push_back(static_cast<int>(v));
        else if (std::ranges::count(sides, Side::earlier) > 0)
            return false;
        else
            new_.push_back(static_cast<int>(v));
    }
    forget_handed(cell_);
    for (const int v : new_) {
        const RowPolytope::Corner& corner = corners[at(v)];
        const auto& [a, b, c] = corner.planes;
        if (free_ == none) {
            free_ = static_cast<std::uint32_t>(found_.size());
            found_.emplace_back().next[0] = none;
        }
        const std::uint32_t n = free_;
        Found& found = found_[n];
        free_ = found.next[0];
        found.cells = {cell_, cells_[at(a)], cells_[at(b)], cells_[at(c)]};
        found.at = corner.at, found.error = corner.error;
        for (std::uint32_t k = 1; k < 4; ++k) {
            std::uint32_t& first = first_[found.cells[k]];
            found.next[k - 1] = first;
            first = 4 * n + k;
        }
    }
    return true;
}

void HandedCorners::forget_handed(std::uint32_t cell) {
    for (std::uint32_t link = first_[cell]; link != none;) {
        const std::uint32_t n = link >> 2;
        Found& found = found_[n];
        link = found.next[(link & 3) - 1];
        if (std::max({found.cells[1], found.cells[2], found.cells[3]}) != cell) continue;
        found.next[0] = free_;
        free_ = n;
    }
}

}  // namespace votess
