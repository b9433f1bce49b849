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
    links_.assign(piece_size, 0);
    free_found_.clear();
    free_pieces_.clear();
    cells_.assign(end - begin, {});
}

// Finds which planes are those of cells of the block.
void HandedCorners::look_around(const RowPolytope& polytope, std::uint32_t cell) {
    const std::span<const RowPolytope::Name> names = polytope.names();
    sides_.assign(names.size(), Side::other);
    locals_.resize(names.size());
    for (std::size_t f = 0; f < names.size(); ++f) {
        if (names[f].id < 0 || !is_zero(names[f].shift)) continue;
        const std::uint32_t number = local(names[f].id);
        if (number >= order_.size()) continue;
        Cell& other = cells_[number];
        other.seen_by = cell;
        other.plane = static_cast<std::uint16_t>(f);
        locals_[f] = number;
        sides_[f] = other.left ? Side::other : number < cell ? Side::earlier : Side::later;
    }
}

// Returns false if a cell that a corner needs is not in the row.
bool HandedCorners::take_handed(RowPolytope& polytope, std::uint32_t cell) {
    const PlaneArrays& p = polytope.arrays();
    const std::span<RowPolytope::Corner> corners = polytope.begin_known(at(2 * polytope.planes()));
    done_.resize(corners.size() + 1);
    std::uint32_t* const done = done_.data();
    std::size_t handed = 0, freed = 0;
    const bool taken = for_handed(cell, [&](const Found& found, std::size_t k) {
        const std::array<std::uint32_t, 3> others = found.seen_from(k);
        const Cell &a = cells_[others[0]], &b = cells_[others[1]], &c = cells_[others[2]];
        const std::size_t from = cells_[found.cells[0]].plane;
        if (((a.seen_by ^ cell) | (b.seen_by ^ cell) | (c.seen_by ^ cell)) != 0 || handed == corners.size())
            return false;
        done[freed] = static_cast<std::uint32_t>(&found - found_.data());
        freed += found.last_cell() == cell ? 1 : 0;
        RowPolytope::Corner& corner = corners[handed++];
        const double x = found.at[0] + p.nx[from], y = found.at[1] + p.ny[from], z = found.at[2] + p.nz[from],
                     reach = std::abs(x) + std::abs(y) + std::abs(z),
                     error = found.error + 0x1p-50 * (reach + p.length[from]);
        corner.planes[0] = a.plane, corner.planes[1] = b.plane, corner.planes[2] = c.plane;
        corner.at[0] = x, corner.at[1] = y, corner.at[2] = z;
        corner.error = error, corner.slope = error + 0x1p-49 * reach, corner.constant = 0x1p-49;
        return true;
    });
    handed_ = handed;
    done_.resize(freed);
    return taken;
}

bool HandedCorners::has_one_top(const RowPolytope& polytope, std::size_t direction) {
    const PlaneArrays& p = polytope.arrays();
    across_.resize(p.count);
    along_.resize(p.count);
    double *const across = across_.data(), *const along = along_.data();
    for (std::size_t f = 0; f < p.count; ++f) {
        const SeenNormal seen = seen_along(p, f, direction);
        across[f] = seen.across;
        along[f] = seen.along;
    }
    int tops = 0;
    for (const RowPolytope::Corner& corner : polytope.corners()) {
        const auto& [a, b, c] = corner.planes;
        tops += top_of({across[a], along[a]}, {across[b], along[b]}, {across[c], along[c]});
    }
    return tops == 1;
}

// D
bool HandedCorners::check_edges(RowPolytope& polytope) {
    const std::span<const RowPolytope::Edge> edges = polytope.known_edges();
    // Which edges these are is hard to foretell, so there is no branch.
    to_compare_.resize(edges.size() + 1);
    int* next = to_compare_.data();
    const Side* const sides = sides_.data();
    for (std::size_t e = 0; e < edges.size(); ++e) {
        *next = static_cast<int>(e);
        const int left = sides[edges[e].left] != Side::earlier ? 1 : 0,
                  right = sides[edges[e].right] != Side::earlier ? 1 : 0;
        next += left & right;
    }
    return std::all_of(to_compare_.data(), next, [&](int e) {
        const RowPolytope::Edge& edge = edges[at(e)];
        const auto& [a, b, c] = polytope.corners()[at(edge.to)].planes;
        return polytope.is_inside(edge.from, a + b + c - edge.left - edge.right);
    });
}

bool HandedCorners::close(RowPolytope& polytope, std::size_t seed, std::size_t faces) {
    cell_ = local(static_cast<std::int32_t>(seed));
    look_around(polytope, cell_);
    if (polytope.unit() != 1 || !take_handed(polytope, cell_) || !polytope.wrap_surely(handed_)) return false;
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
    free_found_.insert(free_found_.end(), done_.begin(), done_.end());
    free_pieces_of(cell_);
    for (const int v : new_) {
        const RowPolytope::Corner& corner = corners[at(v)];
        const auto& [a, b, c] = corner.planes;
        if (free_found_.empty()) {
            free_found_.push_back(static_cast<std::uint32_t>(found_.size()));
            found_.emplace_back();
        }
        const std::uint32_t n = free_found_.back();
        free_found_.pop_back();
        Found& found = found_[n];
        const std::array cells{cell_, locals_[at(a)], locals_[at(b)], locals_[at(c)]};
        found.cells = cells, found.at = corner.at, found.error = corner.error;
        hand(cells[1], 4 * n + 1);
        hand(cells[2], 4 * n + 2);
        hand(cells[3], 4 * n + 3);
    }
    return true;
}

void HandedCorners::hand(std::uint32_t cell, std::uint32_t link) {
    std::uint32_t& end = cells_[cell].end;
    if ((end & last) == last) {
        if (free_pieces_.empty()) {
            free_pieces_.push_back(static_cast<std::uint32_t>(links_.size()));
            links_.resize(links_.size() + piece_size);
        }
        const std::uint32_t piece = free_pieces_.back();
        free_pieces_.pop_back();
        links_[piece + last] = end & ~last;
        end = piece;
    }
    links_[end++] = link;
}

void HandedCorners::free_pieces_of(std::uint32_t cell) {
    std::uint32_t& end = cells_[cell].end;
    for (; end > last; end = links_[end | last] + last) free_pieces_.push_back(end & ~last);
}

}  // namespace votess
