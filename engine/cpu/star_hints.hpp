// StarWalk: vertices that the cell had in an earlier job, when its seeds lay nearly the same. They are proven as any
// other, but need no search.
#pragma once

#include "cpu/star_walk.hpp"

namespace votess::cpu {

// no_slot when the cell has no such plane yet.
template <class Isa>
unsigned StarWalk<Isa>::known_slot(std::int32_t id) {
    const std::int32_t local = cells_.local(id);
    make_room(local);
    return slot_[static_cast<std::size_t>(local)];
}

// A hint counts only where it closes an open edge: elsewhere done seeds would have to be looked at, see star.hpp. What
// is left open is for the walk.
template <class Isa>
bool StarWalk<Isa>::take_hints() {
    constexpr std::size_t first_tries = 64;
    const std::span<const std::int32_t> ids = hints_->of(seed_ - first_);
    const auto is_open = [this](unsigned a, unsigned b) {
        return a != no_slot && b != no_slot && ((open(static_cast<int>(a)) >> b) & 1) != 0;
    };
    for (std::size_t k = 0; k < ids.size() && active_ != 0; k += 3) {
        const std::int32_t* three = &ids[k];
        const unsigned slots[3] = {known_slot(three[0]), known_slot(three[1]), known_slot(three[2])};
        for (int i = 0; i < 3; ++i) {
            const int j = i == 2 ? 0 : i + 1;
            if (!is_open(slots[j], slots[i])) continue;
            OpenEdge edge;
            ++hints_tried_;
            if (!span(static_cast<int>(slots[j]), static_cast<int>(slots[i]), edge)) return false;
            const int before = vertices_;
            if (!try_vertex(edge, three[3 - i - j])) return false;
            hints_proven_ += vertices_ > before ? 1 : 0;
            break;
        }
    }
    // Seeds that have moved far.
    if (hints_tried_ >= first_tries && 5 * hints_proven_ < 2 * hints_tried_) hints_ = nullptr;
    return true;
}

// False when the cell is beyond this class; a vertex that cannot be proven is not added.
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
