#include "follow/loose_cell.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/arithmetic.hpp"

namespace votess::cpu {

void LooseCell::read(const KeptCell& cell) {
    faces = cell.faces();
    corners = cell.corners().size();
    tied = cell.head().tied;
    used = cell.head().used;
    tests = cell.tests().size();
    planes = cell.planes().size();
    std::ranges::copy(cell.tests(), test.begin());
    std::ranges::copy(cell.planes(), plane.begin());
    std::ranges::copy(cell.ids(), id.begin());
    std::ranges::copy(cell.corners(), corner.begin());
    if (!cell.head().shifted)
        std::fill_n(shift.begin(), faces, NearShift{});
    else
        for (std::size_t f = 0; f < faces; ++f) shift[f] = cell.near_shift(f);
}

template <class Number>
void LooseCell::renumber(const Number& number) {
    for (std::size_t v = 0; v < corners; ++v)
        for (std::uint8_t& f : corner[v]) f = number(f);
    for (std::size_t t = 0; t < tests; ++t) test[t].plane = number(test[t].plane);
    for (std::size_t k = 0; k < planes; ++k) plane[k] = number(plane[k]);
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
    renumber([at](std::uint8_t f) { return static_cast<std::uint8_t>(f + (f >= at ? 1 : 0)); });
}

bool LooseCell::remove_face(std::size_t at) {
    for (std::size_t v = 0; v < corners; ++v)
        for (const std::uint8_t f : corner[v])
            if (f == at) return false;
    std::copy(id.begin() + at + 1, id.begin() + faces, id.begin() + at);
    std::copy(shift.begin() + at + 1, shift.begin() + faces, shift.begin() + at);
    --faces;
    renumber([at](std::uint8_t f) { return static_cast<std::uint8_t>(f - (f > at ? 1 : 0)); });
    return true;
}

// The tests stay the same: which seeds are later does not change.
void LooseCell::sort_faces(std::span<const std::int32_t> order) {
    std::array<std::uint64_t, CellShape::max_planes> key;
    for (std::size_t f = 0; f < faces; ++f) {
        const auto biased = [](std::int32_t number, int bits) {
            return static_cast<std::uint64_t>(number + (std::int64_t{1} << (bits - 1)));
        };
        key[f] = biased(id[f] < 0 ? id[f] : order[static_cast<std::size_t>(id[f])], 32);
        for (const std::int8_t by : shift[f]) key[f] = key[f] << 8 | biased(by, 8);
    }
    // Few faces, in any order: counting those before each is faster than sorting.
    std::array<std::uint8_t, CellShape::max_planes> to{};
    for (std::size_t f = 0; f < faces; ++f)
        for (std::size_t g = 0; g < f; ++g) {
            const std::uint8_t before = key[g] < key[f] ? 1 : 0;
            to[f] += before;
            to[g] += 1 - before;
        }
    const auto ids = id;
    const auto shifts = shift;
    for (std::size_t f = 0; f < faces; ++f) {
        id[to[f]] = ids[f];
        shift[to[f]] = shifts[f];
    }
    renumber([&](std::uint8_t f) { return to[f]; });
    std::sort(plane.begin(), plane.begin() + static_cast<std::ptrdiff_t>(planes));
}

void LooseCell::find_tests(std::size_t seed, CornerEdges& edges) {
    std::array<std::uint8_t, CellShape::max_planes> later;
    for (std::size_t f = 0; f < faces; ++f) later[f] = id[f] < 0 || id[f] >= static_cast<std::int32_t>(seed) ? 1 : 0;
    // A closed surface has each edge once in either direction. Which corners and edges count is hard to foretell, so
    // there are few branches.
    bool closed = corners + 4 == 2 * faces;  // Euler
    constexpr std::uint8_t unused = 255;
    std::array<std::uint8_t, CellShape::max_corners + 1> number, order;  // among the used ones
    used = 0;
    edges.begin();
    for (std::size_t v = 0; v < corners; ++v) {
        const auto [a, b, c] = corner[v];
        closed &= edges.add(a, b, static_cast<std::uint32_t>(v), c);
        closed &= edges.add(b, c, static_cast<std::uint32_t>(v), a);
        closed &= edges.add(c, a, static_cast<std::uint32_t>(v), b);
        const unsigned all_later = later[a] & later[b] & later[c];
        order[used] = static_cast<std::uint8_t>(v);
        number[v] = all_later != 0 ? static_cast<std::uint8_t>(used) : unused;
        used += all_later;
    }
    struct Tested {  // an edge: its corners, and their other planes
        std::uint8_t v, w, end, third;
    };
    std::array<Tested, SignTest::max_tests + 1> tested;
    tests = 0;
    for (std::size_t v = 0; v < corners; ++v) {
        const KeptCell::Corner& at = corner[v];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint8_t a = at[k], b = at[k == 2 ? 0 : k + 1];
            const auto [exists, w, third] = edges.find(b, a);
            closed &= exists;
            tested[tests] = {static_cast<std::uint8_t>(v), w, at[k == 0 ? 2 : k - 1], third};
            tests += later[a] & later[b] & (w > v ? 1u : 0u) & (tests < SignTest::max_tests ? 1u : 0u);
        }
    }
    tied |= !closed;
    if (tied) tests = 0;
    // From either end; the corner that is used anyway.
    std::array<std::uint8_t, CellShape::max_planes> needed;
    std::fill_n(needed.begin(), faces, std::uint8_t{0});
    for (std::size_t t = 0; t < tests; ++t) {
        const auto [v, w, end, third] = tested[t];
        const bool from_other = number[v] == unused && number[w] != unused;
        const std::uint8_t from = from_other ? w : v;
        if (number[from] == unused) {
            order[used] = from;
            number[from] = static_cast<std::uint8_t>(used++);
        }
        test[t] = {number[from], from_other ? end : third};
        needed[test[t].plane] = 1;
    }
    // The used corners come first.
    std::array<KeptCell::Corner, CellShape::max_corners> sorted;
    for (std::size_t v = 0; v < used; ++v) {
        sorted[v] = corner[order[v]];
        for (const std::uint8_t f : sorted[v]) needed[f] = 1;
    }
    for (std::size_t v = 0, next = used; v < corners; ++v)
        if (number[v] == unused) sorted[next++] = corner[v];
    std::copy_n(sorted.begin(), corners, corner.begin());
    planes = 0;
    for (std::size_t f = 0; f < faces; ++f) {
        plane[planes] = static_cast<std::uint8_t>(f);
        planes += needed[f];
    }
}

std::size_t LooseCell::pack(std::size_t room, std::span<std::byte> to) const {
    const auto narrow = [](std::size_t n) { return static_cast<std::uint8_t>(n); };
    KeptCell::Head head{0, narrow(faces), narrow(corners), narrow(used), narrow(tests), narrow(planes), false, tied};
    for (std::size_t f = 0; f < faces; ++f)
        if (shift[f] != NearShift{}) head.shifted = true;
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
    put(corner.data(), sizeof(KeptCell::Corner) * corners);
    put(test.data(), sizeof(KeptCell::Test) * tests);
    put(plane.data(), planes);
    return bytes;
}

}  // namespace votess::cpu
