#include "follow/loose_cell.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "core/arithmetic.hpp"

namespace votess::cpu {

void LooseCell::read(const KeptCell& cell) {
    faces = cell.faces();
    corners = cell.corners().size();
    tied = cell.head().tied;
    std::ranges::copy(cell.ids(), id.begin());
    std::ranges::copy(cell.corners(), corner.begin());
    if (!cell.head().shifted)
        std::fill_n(shift.begin(), faces, NearShift{});
    else
        for (std::size_t f = 0; f < faces; ++f) shift[f] = cell.near_shift(f);
}

std::size_t LooseCell::find(std::int32_t of, const NearShift& by) const {
    std::size_t f = 0;
    while (f < faces && (id[f] != of || shift[f] != by)) ++f;
    return f;
}

void LooseCell::insert_face(std::size_t at, std::int32_t of, const NearShift& by) {
    std::copy_backward(id.begin() + at, id.begin() + faces, id.begin() + faces + 1);
    std::copy_backward(shift.begin() + at, shift.begin() + faces, shift.begin() + faces + 1);
    id[at] = of;
    shift[at] = by;
    ++faces;
    for (std::size_t v = 0; v < corners; ++v)
        for (std::uint8_t& f : corner[v]) f += f >= at ? 1 : 0;
}

void LooseCell::remove_face(std::size_t at) {
    std::copy(id.begin() + at + 1, id.begin() + faces, id.begin() + at);
    std::copy(shift.begin() + at + 1, shift.begin() + faces, shift.begin() + at);
    --faces;
    for (std::size_t v = 0; v < corners; ++v)
        for (std::uint8_t& f : corner[v]) f -= f > at ? 1 : 0;
}

void LooseCell::sort_faces(std::span<const std::int32_t> order) {
    std::array<std::uint8_t, CellShape::max_planes> from, to;
    std::iota(from.begin(), from.begin() + faces, std::uint8_t{0});
    std::sort(from.begin(), from.begin() + faces, [&](std::uint8_t f, std::uint8_t g) {
        const auto key = [&](std::size_t k) {
            return std::pair(id[k] < 0 ? id[k] : order[static_cast<std::size_t>(id[k])], shift[k]);
        };
        return key(f) < key(g);
    });
    const auto ids = id;
    const auto shifts = shift;
    for (std::size_t f = 0; f < faces; ++f) {
        id[f] = ids[from[f]];
        shift[f] = shifts[from[f]];
        to[from[f]] = static_cast<std::uint8_t>(f);
    }
    for (std::size_t v = 0; v < corners; ++v)
        for (std::uint8_t& f : corner[v]) f = to[f];
}

std::size_t LooseCell::pack(std::size_t seed, CornerEdges& edges, std::size_t room, std::span<std::byte> to) const {
    KeptCell::Head head{0, static_cast<std::uint8_t>(faces), static_cast<std::uint8_t>(corners), 0, 0, false, tied};
    std::array<std::uint8_t, CellShape::max_planes> later;
    for (std::size_t f = 0; f < faces; ++f) {
        later[f] = id[f] < 0 || id[f] >= static_cast<std::int32_t>(seed) ? 1 : 0;
        head.shifted |= shift[f] != NearShift{};
    }
    // A closed surface has each edge once in either direction.
    bool closed = corners + 4 == 2 * faces;  // Euler
    edges.begin();
    for (std::size_t v = 0; v < corners; ++v) {
        const auto [a, b, c] = corner[v];
        closed &= edges.add(a, b, static_cast<std::uint32_t>(v), c) &&
                  edges.add(b, c, static_cast<std::uint32_t>(v), a) &&
                  edges.add(c, a, static_cast<std::uint32_t>(v), b);
    }
    for (std::size_t v = 0; v < corners; ++v) {
        const auto [a, b, c] = corner[v];
        closed &= edges.find(b, a).exists && edges.find(c, b).exists && edges.find(a, c).exists;
    }
    head.tied |= !closed;
    constexpr std::uint8_t unused = 255;
    std::array<std::uint8_t, CellShape::max_corners> number;  // among the used ones
    std::array<std::uint8_t, CellShape::max_corners> order;
    std::fill_n(number.begin(), corners, unused);
    std::size_t used = 0, tests = 0;
    const auto use = [&](std::size_t v) {
        if (number[v] == unused) order[number[v] = static_cast<std::uint8_t>(used++)] = static_cast<std::uint8_t>(v);
        return number[v];
    };
    for (std::size_t v = 0; v < corners; ++v)
        if (const auto& [a, b, c] = corner[v]; (later[a] & later[b] & later[c]) != 0) use(v);
    std::array<KeptCell::Test, SignTest::max_tests> test;
    for (std::size_t v = 0; v < corners && !head.tied; ++v) {
        const KeptCell::Corner& at = corner[v];
        if (later[at[0]] + later[at[1]] + later[at[2]] < 2) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint8_t a = at[k], b = at[(k + 1) % 3];
            if ((later[a] & later[b]) == 0) continue;
            const auto [exists, w, third] = edges.find(b, a);
            if (!exists || w < v) continue;
            // From either end; the corner that is used anyway.
            const std::uint8_t end = at[(k + 2) % 3];
            test[tests++] = number[v] == unused && number[w] != unused ? KeptCell::Test{use(w), end}
                                                                       : KeptCell::Test{use(v), third};
        }
    }
    head.used = static_cast<std::uint8_t>(used);
    head.tests = static_cast<std::uint8_t>(tests);
    for (std::size_t v = 0, next = used; v < corners; ++v)
        if (number[v] == unused) order[next++] = static_cast<std::uint8_t>(v);

    const std::size_t bytes = round_up(KeptCell::bytes(head), 8);
    head.room = static_cast<std::uint16_t>(std::max(room, bytes) / 8);
    std::byte* at = to.data();
    const auto put = [&](const void* from, std::size_t size) {
        std::memcpy(at, from, size);
        at += size;
    };
    put(&head, sizeof head);
    put(id.data(), 4 * faces);
    if (head.shifted) put(shift.data(), 3 * faces);
    for (std::size_t v = 0; v < corners; ++v) put(&corner[order[v]], sizeof(KeptCell::Corner));
    put(test.data(), 2 * tests);
    return bytes;
}

}  // namespace votess::cpu
