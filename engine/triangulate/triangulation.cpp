#include "triangulate/triangulation.hpp"

#include "exact/insphere.hpp"

namespace votess::cpu {
namespace {

int slot_of(const std::array<std::int32_t, 4>& a, std::int32_t x) {
    return a[0] == x ? 0 : (a[1] == x ? 1 : (a[2] == x ? 2 : 3));
}

}  // namespace

int PointSites::orient(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) const {
    return exact::orient(points_[a], points_[b], points_[c], points_[d]);
}

int PointSites::insphere(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d, std::int32_t p) const {
    return exact::insphere(points_[a], points_[b], points_[c], points_[d], points_[p]);
}

void Triangulation::begin(std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    if (sites_.orient(a, b, c, d) < 0) std::swap(a, b);
    cells_ = {{{a, b, c, d}, {1, 2, 3, 4}}};
    for (int k = 0; k < 4; ++k) {
        // Beyond face k the infinite vertex is on the other side, so two vertices are swapped.
        Tetrahedron t{cells_[0].vertex, {}};
        t.vertex[k] = infinite;
        for (int j = 0; j < 4; ++j) t.neighbor[j] = j == k ? 0 : 1 + j;
        const int i = (k + 1) % 4, j = (k + 2) % 4;
        std::swap(t.vertex[i], t.vertex[j]);
        std::swap(t.neighbor[i], t.neighbor[j]);
        cells_.push_back(t);
    }
    state_.assign(cells_.size(), State::unknown);
    free_.clear();
    last_ = 0;
}

void Triangulation::insert(std::int32_t point) {
    if (find_conflicts(point)) fill_hole(point);
}

// Returns the sign of the tetrahedron with the point in place of one vertex, which may be the infinite one.
int Triangulation::orient_with(const Tetrahedron& t, int slot, std::int32_t point) const {
    std::array<std::int32_t, 4> v = t.vertex;
    v[slot] = point;
    return sites_.orient(v[0], v[1], v[2], v[3]);
}

bool Triangulation::in_conflict(const Tetrahedron& t, std::int32_t point) const {
    const Tetrahedron* finite = &t;
    if (!is_finite(t)) {
        const int slot = slot_of(t.vertex, infinite);
        if (const int side = orient_with(t, slot, point); side != 0) return side > 0;
        finite = &cells_[t.neighbor[slot]];
    }
    const auto& v = finite->vertex;
    return sites_.insphere(v[0], v[1], v[2], v[3], point) > 0;
}

// Walks through any face that has the point strictly beyond it. In a regular triangulation this ends (Edelsbrunner, An
// acyclicity theorem for cell complexes in d dimensions, Combinatorica 10, 1990).
std::int32_t Triangulation::locate(std::int32_t point) {
    std::int32_t cell = last_, from = unused;
    for (bool moved = true; moved;) {
        moved = false;
        const Tetrahedron& t = cells_[cell];
        for (int k = 0; k < 4 && !moved; ++k) {
            if (t.neighbor[k] == from || orient_with(t, k, point) >= 0) continue;
            from = cell;
            cell = t.neighbor[k];
            moved = true;
        }
        if (!is_finite(cells_[cell])) break;  // strictly beyond the hull triangle
    }
    return cell;  // holds the point, or is infinite and beyond the hull
}

bool Triangulation::find_conflicts(std::int32_t point) {
    conflicts_.assign(1, locate(point));
    if (!in_conflict(cells_[conflicts_[0]], point)) return false;
    kept_.clear();
    boundary_.clear();
    state_[conflicts_[0]] = State::conflict;
    for (std::size_t i = 0; i < conflicts_.size(); ++i) {
        const std::int32_t cell = conflicts_[i];
        for (int k = 0; k < 4; ++k) {
            const std::int32_t n = cells_[cell].neighbor[k];
            if (state_[n] == State::unknown) {
                const bool conflict = in_conflict(cells_[n], point);
                state_[n] = conflict ? State::conflict : State::kept;
                (conflict ? conflicts_ : kept_).push_back(n);
            }
            if (state_[n] == State::kept) boundary_.push_back({cell, k, unused});
        }
    }
    return true;
}

void Triangulation::fill_hole(std::int32_t point) {
    for (Boundary& face : boundary_) {
        face.fresh = allocate_cell();
        Tetrahedron& old = cells_[face.cell];
        Tetrahedron& fresh = cells_[face.fresh];
        const std::int32_t outside = old.neighbor[face.slot];
        fresh = {old.vertex, {unused, unused, unused, unused}};
        fresh.vertex[face.slot] = point;
        fresh.neighbor[face.slot] = outside;
        auto& back = cells_[outside].neighbor;
        back[slot_of(back, face.cell)] = face.fresh;
        old.neighbor[face.slot] = face.fresh;  // leads link() to it
        state_[face.fresh] = State::fresh;
        if (is_finite(fresh)) last_ = face.fresh;
    }
    for (const Boundary& face : boundary_) link(face);
    for (const std::int32_t cell : conflicts_) {
        cells_[cell].vertex[0] = unused;
        state_[cell] = State::unknown;
        free_.push_back(cell);
    }
    for (const std::int32_t cell : kept_) state_[cell] = State::unknown;
    for (const Boundary& face : boundary_) state_[face.fresh] = State::unknown;
}

// Finds the neighbors of a fresh tetrahedron across its faces at the new point. Around each edge of the boundary face,
// old tetrahedra lead to the boundary face on the other side.
void Triangulation::link(const Boundary& face) {
    const std::array<std::int32_t, 4> old = cells_[face.cell].vertex;
    for (int k = 0; k < 4; ++k) {
        if (cells_[face.fresh].neighbor[k] != unused) continue;
        // The edge is the one without `across` and `kept`. The next face to cross is opposite to `across`.
        std::int32_t across = old[k], kept = old[face.slot];
        const std::int32_t edge = old[0] ^ old[1] ^ old[2] ^ old[3] ^ across ^ kept;
        std::int32_t cell = face.cell;
        for (;;) {
            const Tetrahedron& t = cells_[cell];
            cell = t.neighbor[slot_of(t.vertex, across)];
            if (state_[cell] == State::fresh) break;
            const auto& v = cells_[cell].vertex;
            across = kept;
            kept = v[0] ^ v[1] ^ v[2] ^ v[3] ^ edge ^ across;
        }
        cells_[face.fresh].neighbor[k] = cell;
        cells_[cell].neighbor[slot_of(cells_[cell].vertex, kept)] = face.fresh;
    }
}

std::int32_t Triangulation::allocate_cell() {
    if (free_.empty()) {
        cells_.emplace_back();
        state_.push_back(State::unknown);
        return static_cast<std::int32_t>(cells_.size()) - 1;
    }
    const std::int32_t place = free_.back();
    free_.pop_back();
    return place;
}

}  // namespace votess::cpu
