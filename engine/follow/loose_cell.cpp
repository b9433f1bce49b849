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
    // A closed surface has each edge once in either direction. Of such pairs an edge is tested if it is this cell's.
    // What decides is added up instead of branched on: no processor predicts it.
    edges.begin();
    std::array<std::uint8_t, 3 * CellShape::max_corners> is_own;  // by corner and place of an edge there
    bool once = true;
    std::size_t pairs = 0;
    for (std::size_t v = 0; v < corners; ++v) {
        const auto add = [&](std::uint8_t a, std::uint8_t b, std::uint8_t end, std::size_t k) {
            once &= edges.add(a, b, static_cast<std::uint32_t>(v), end);
            const bool exists = edges.find(b, a).exists;
            is_own[3 * v + k] = exists & later[a] & later[b];
            pairs += exists;
        };
        const auto [a, b, c] = corner[v];
        add(a, b, c, 0);
        add(b, c, a, 1);
        add(c, a, b, 2);
    }
    std::array<std::uint16_t, 3 * CellShape::max_corners> own;
    std::size_t tests = 0;
    for (std::size_t e = 0; e < 3 * corners; ++e) {
        own[tests] = static_cast<std::uint16_t>(e);
        tests += is_own[e];
    }
    if (tied || !once || 2 * pairs != 3 * corners || corners + 4 != 2 * faces) {  // Euler
        head.tied = true;
        tests = 0;
    }
    std::array<std::uint8_t, CellShape::max_corners> is_used, order, number;
    for (std::size_t v = 0; v < corners; ++v) {
        const auto [a, b, c] = corner[v];
        is_used[v] = later[a] & later[b] & later[c];
    }
    std::array<KeptCell::Test, SignTest::max_tests> test;
    for (std::size_t t = 0; t < tests; ++t) {
        const std::size_t v = own[t] / 3, k = own[t] % 3;
        const KeptCell::Corner& at = corner[v];
        const CornerEdges::Edge other = edges.find(at[(k + 1) % 3], at[k]);
        // From either end; the corner that is used anyway.
        const bool there = is_used[v] < is_used[other.corner];
        test[t] = {there ? other.corner : static_cast<std::uint8_t>(v), there ? at[(k + 2) % 3] : other.third};
        is_used[test[t].corner] = 1;
    }
    std::size_t used = 0;
    for (std::size_t v = 0; v < corners; ++v)
        if (is_used[v] != 0) order[number[v] = static_cast<std::uint8_t>(used++)] = static_cast<std::uint8_t>(v);
    for (std::size_t v = 0, next = used; v < corners; ++v)
        if (is_used[v] == 0) order[next++] = static_cast<std::uint8_t>(v);
    for (std::size_t t = 0; t < tests; ++t) test[t].corner = number[test[t].corner];
    head.used = static_cast<std::uint8_t>(used);
    head.tests = static_cast<std::uint8_t>(tests);

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
