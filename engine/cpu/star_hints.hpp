// StarWalk: vertices that the cell had in an earlier job, when its seeds lay nearly the same. They are proven as any
// other, but need no search, and many at a time.
#pragma once

#include "cpu/star_walk.hpp"

namespace votess::cpu {

// Squared, of all candidates that the vertices hinted at need.
template <class Isa>
double StarWalk<Isa>::hinted_reach() const {
    constexpr double smallest = 1e-30;  // of a float with all digits
    const double reach2 = hints_->reach(seed_ - first_);
    return reach2 > smallest ? hint_growth_ * reach2 : largest_h;
}

// Loop by loop over all hints, for what comes out of one is hard to predict. False when the cell is beyond this class.
template <class Isa>
bool StarWalk<Isa>::take_hints() {
    constexpr double first_tries = 64, least_proven = 0.8;
    constexpr double least_growth = 1.05, most_growth = 4;
    const std::span<const std::int32_t> ids = hints_->of(seed_ - first_);
    std::uint64_t used = 0;
    int count = 0;
    for (std::size_t k = 0; k < ids.size() && count < most_hints && planes_ < most_planes - 8; k += 3) {
        Hint& hint = hint_[count++];
        for (int i = 0; i < 3; ++i) {
            const int slot = new_slot(ids[k + i]);
            hint.slot[i] = slot;
            id_[slot] = ids[k + i];
            used |= 1ull << slot;
        }
    }
    for (std::uint64_t m = used & ~planes_known_; m != 0; m &= m - 1) {
        const int slot = std::countr_zero(m);
        plane_through(id_[slot], n_[slot], h_[slot]);
    }
    planes_known_ |= used;
    int uncovered = 0;
    for (int k = 0; k < count; ++k) {
        Hint& hint = hint_[k];
        const auto& [a, b, c] = hint.slot;
        OpenEdge edge;
        hint.third.n = n_[c];
        hint.third.h = h_[c];
        hint.solved = span(b, a, edge) && solve(edge, hint.third, hint.x);
        const double x2 = dot(wide(hint.x), wide(hint.x));
        hint.needed = 4 * x2;
        narrow(wide(hint.x), hint.v);
        hint.v[3] = rounding_of(x2);
        const bool covered = hint.needed * (1 + margin) <= covered_;
        uncovered += hint.solved && !covered ? 1 : 0;
        hint.solved &= covered;
    }
    hint_growth_ = std::clamp(hint_growth_ * (uncovered > 0 ? 1.1 : 0.997), least_growth, most_growth);
    std::uint64_t proven = 0, touched = 0;
    for (int k = 0; k < count; ++k) {
        Hint& hint = hint_[k];
        if (!hint.solved) continue;
        const std::int32_t three[3] = {id_[hint.slot[0]], id_[hint.slot[1]], id_[hint.slot[2]]};
        hint.touching = kernels_.touching(candidates_, hint.v, three, 0);
        (hint.touching < 0 ? proven : touched) |= 1ull << k;
    }
    hints_tried_ += count;
    hints_proven_ += std::popcount(proven);
    // Seeds that have moved far: to fail costs more than to search.
    if (hints_tried_ >= first_tries && hints_proven_ < least_proven * hints_tried_) {
        hints_ = nullptr;
        if (found_ != nullptr) found_->give_up();
        found_ = nullptr;
    }
    return add_hinted(proven) && try_near(touched);
}

// A vertex counts only where it closes an open edge: elsewhere done seeds would have to be looked at, see star.hpp.
// What is left open is for the walk.
template <class Isa>
int StarWalk<Isa>::open_side(const Hint& hint) const {
    const auto& [a, b, c] = hint.slot;
    if ((open(b) >> a) & 1) return 0;
    if ((open(c) >> b) & 1) return 1;
    return (open(a) >> c) & 1 ? 2 : -1;
}

template <class Isa>
bool StarWalk<Isa>::add_hinted(std::uint64_t proven) {
    for (bool again = true; again && active_ != 0;) {
        again = false;
        for (std::uint64_t m = proven; m != 0; m &= m - 1) {
            const int k = std::countr_zero(m);
            const Hint& hint = hint_[k];
            if (open_side(hint) < 0) continue;
            proven &= ~(1ull << k);
            again = true;
            const auto& [a, b, c] = hint.slot;
            if (vertices_ > most_vertices - 4) return false;
            reached_ = std::max(reached_, hint.needed);
            add_corner(a, b, c, hint.third, hint.x);
        }
    }
    return true;
}

// What cuts off the old vertex often has the new one.
template <class Isa>
bool StarWalk<Isa>::try_near(std::uint64_t touched) {
    for (; touched != 0; touched &= touched - 1) {
        const Hint& hint = hint_[std::countr_zero(touched)];
        const int side = open_side(hint);
        if (side < 0) continue;
        const int next = side == 2 ? 0 : side + 1;
        OpenEdge edge;
        if (!span(hint.slot[next], hint.slot[side], edge)) return false;
        if (!try_vertex(edge, candidates_.id[hint.touching])) return false;
    }
    return true;
}

template <class Isa>
bool StarWalk<Isa>::try_vertex(const OpenEdge& edge, std::int32_t id) {
    const std::int32_t three[3] = {id_[edge.a], id_[edge.b], id};
    Third third;
    Four x;
    plane_through(id, third.n, third.h);
    if (!solve(edge, third, x)) return true;
    const double x2 = dot(wide(x), wide(x));
    if (!(4 * x2 * (1 + margin) <= covered_)) return true;
    const float v[4] = {static_cast<float>(x.x[0]), static_cast<float>(x.x[1]), static_cast<float>(x.x[2]),
                        rounding_of(x2)};
    const int touching = kernels_.touching(candidates_, v, three, 0);
    tied_.clear();
    if (touching >= 0 && examine(v, three, third, x, touching) >= 0) return true;
    reached_ = std::max(reached_, 4 * x2);
    return tied_.empty() ? add_vertex(edge, id, third, x) : add_tie(edge, id, third, x);
}

}  // namespace votess::cpu
