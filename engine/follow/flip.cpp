#include "follow/flip.hpp"

#include <utility>

namespace votess::cpu {
namespace {

NearShift minus(const NearShift& a, const NearShift& b) {
    NearShift c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = static_cast<std::int8_t>(a[k] - b[k]);
    return c;
}

bool is_short(const NearShift& shift) {
    return std::ranges::all_of(shift, [](int by) { return by >= -KeptCell::max_shift && by <= KeptCell::max_shift; });
}

// The shift of one member as another sees it.
NearShift from(const Flip& flip, std::size_t member, std::size_t other) {
    return flip.id[other] < 0 ? NearShift{} : minus(flip.shift[other], flip.shift[member]);
}

// The other three of a corner that has all but one of the five.
std::array<std::size_t, 3> others(std::size_t member, std::size_t omitted) {
    std::array<std::size_t, 3> out;
    std::size_t next = 0;
    for (std::size_t k = 0; k < 5; ++k)
        if (k != member && k != omitted) out[next++] = k;
    return out;
}

std::size_t find_face(const KeptCell& cell, std::int32_t id, const NearShift& shift) {
    const auto ids = cell.ids();
    std::size_t f = 0;
    while (f < ids.size() && (ids[f] != id || cell.near_shift(f) != shift)) ++f;
    return f;
}

bool same_planes(const KeptCell::Corner& corner, const std::array<std::size_t, 3>& faces) {
    return std::ranges::all_of(faces, [&](std::size_t f) { return std::ranges::find(corner, f) != corner.end(); });
}

}  // namespace

bool Flip::apply(std::size_t member, std::span<const std::int32_t> order, LooseCell& cell) const {
    std::array<std::size_t, 5> face{};
    const auto key = [&](std::int32_t of, const NearShift& by) {
        return std::pair(of < 0 ? of : order[static_cast<std::size_t>(of)], by);
    };
    for (std::size_t k = 0; k < 5; ++k) {
        if (k == member) continue;
        const NearShift by = from(*this, member, k);
        face[k] = cell.find(id[k], by);
        if (face[k] < cell.faces) continue;
        if (!joins || !is_end(member) || !is_end(k) || cell.faces == CellShape::max_planes) return false;
        std::size_t at = 0;
        while (at < cell.faces && key(cell.id[at], cell.shift[at]) < key(id[k], by)) ++at;
        cell.insert_face(at, id[k], by);
        for (std::size_t j = 0; j < k; ++j) face[j] += j != member && face[j] >= at ? 1 : 0;
        face[k] = at;
    }
    for (std::size_t k = 0; k < 5; ++k) {
        if (k == member || (old >> k & 1) == 0) continue;
        const auto three = others(member, k);
        const std::array<std::size_t, 3> planes{face[three[0]], face[three[1]], face[three[2]]};
        std::size_t v = 0;
        while (v < cell.corners && !same_planes(cell.corner[v], planes)) ++v;
        if (v == cell.corners) return false;
        cell.corner[v] = cell.corner[--cell.corners];
    }
    for (std::size_t k = 0; k < 5; ++k) {
        if (k == member || (old >> k & 1) != 0) continue;
        if (cell.corners == CellShape::max_corners) return false;
        const auto three = others(member, k);
        const std::size_t before = member < k ? member : member - 1;  // of the four
        const bool turned = (k + before) % 2 == 0;
        const auto a = static_cast<std::uint8_t>(face[three[0]]), b = static_cast<std::uint8_t>(face[three[1]]),
                   c = static_cast<std::uint8_t>(face[three[2]]);
        cell.corner[cell.corners++] = turned ? KeptCell::Corner{a, c, b} : KeptCell::Corner{a, b, c};
    }
    if (!joins && is_end(member))
        for (std::size_t k = 0; k < 5; ++k)
            if (k != member && is_end(k)) return cell.remove_face(face[k]);
    return true;
}

// With O(k) the volume of the tetrahedron of all but the k-th, (-1)^k O(k) > 0 holds for the corners of one way to
// place them, and < 0 for those of the other.
bool find_flip(std::span<std::byte* const> cells, std::size_t seed, const SignTest& signs, const KeptCell::Corner& at,
               std::size_t plane, Flip& out) {
    const KeptCell cell(cells[seed]);
    const std::array<std::size_t, 5> face{0, at[0], at[1], at[2], plane};  // of the members but the first
    const auto ids = cell.ids();
    out.id[0] = static_cast<std::int32_t>(seed);
    out.shift[0] = {};
    for (std::size_t k = 1; k < 5; ++k) {
        out.id[k] = ids[face[k]];
        out.shift[k] = cell.near_shift(face[k]);
        for (std::size_t j = 0; j < k; ++j)
            if (out.id[j] == out.id[k]) return false;
    }
    // Corners that exist.
    out.old = 0;
    std::array<std::uint8_t, CellShape::max_planes> bit{};
    for (std::size_t k = 1; k < 5; ++k) bit[face[k]] = static_cast<std::uint8_t>(1u << k);
    int corners = 0;
    for (const auto [a, b, c] : cell.corners()) {
        if (bit[a] == 0 || bit[b] == 0 || bit[c] == 0) continue;
        out.old |= static_cast<std::uint8_t>(0x1e & ~(bit[a] | bit[b] | bit[c]));
        ++corners;
    }
    if (corners != 2 && corners != 3) return false;
    std::array<KeptCell, 5> member;
    std::size_t of_last = 5;  // a seed other than the first
    for (std::size_t k = 0; k < 5; ++k) {
        if (out.id[k] < 0) continue;
        member[k] = KeptCell(cells[static_cast<std::size_t>(out.id[k])]);
        if (!member[k].exists() || member[k].head().tied) return false;
        if (k > 0) of_last = k;
    }
    if (of_last < 5) {
        const auto three = others(of_last, 0);
        std::array<std::size_t, 3> planes;
        for (std::size_t j = 0; j < 3; ++j)
            planes[j] = find_face(member[of_last], out.id[three[j]], from(out, of_last, three[j]));
        if (std::ranges::any_of(member[of_last].corners(), [&](const auto& v) { return same_planes(v, planes); }))
            out.old |= 1, ++corners;
    }
    if (corners > 3) return false;
    out.joins = corners == 2;
    // Signs.
    std::array<std::array<double, 4>, 5> normal{};
    for (std::size_t k = 1; k < 5; ++k)
        for (std::size_t j = 0; j < 4; ++j) normal[k][j] = signs.plane[face[k]][j] / signs.scale[face[k]];
    double volume[5];  // of the tetrahedra of all members but one
    for (std::size_t k = 1; k < 5; ++k) {
        const auto three = others(0, k);
        volume[k] = determinant(normal[three[0]].data(), normal[three[1]].data(), normal[three[2]].data());
    }
    volume[0] = 0;
    double side = 0;  // of the last plane from the corner
    for (std::size_t k = 1; k < 5; ++k) {
        const double signed_volume = k % 2 != 0 ? volume[k] : -volume[k];
        if (out.id[k] >= 0) volume[0] += signed_volume;
        side -= signed_volume * normal[k][3];
    }
    if (!(side > 0)) return false;
    for (std::size_t k = 0; k < 5; ++k)
        if ((out.old >> k & 1) == 0 && !((k % 2 != 0 ? volume[k] : -volume[k]) > 0)) return false;
    if (!out.joins) return true;
    // The two are not neighbors yet.
    std::array<std::size_t, 2> ends;
    for (std::size_t k = 0, next = 0; k < 5; ++k)
        if (out.is_end(k)) ends[next++] = k;
    if (!is_short(from(out, ends[0], ends[1]))) return false;
    for (std::size_t e = 0; e < 2; ++e) {
        const KeptCell& grows = member[ends[e]];
        if (out.id[ends[e]] < 0) continue;
        if (grows.faces() == CellShape::max_planes || grows.corners().size() + 2 > CellShape::max_corners) return false;
        const std::size_t other = ends[1 - e];
        if (find_face(grows, out.id[other], from(out, ends[e], other)) < grows.faces()) return false;
    }
    return true;
}

}  // namespace votess::cpu
