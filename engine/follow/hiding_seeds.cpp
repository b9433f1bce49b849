#include "follow/hiding_seeds.hpp"

#include <algorithm>
#include <cstdlib>

#include "follow/loose_cell.hpp"

namespace votess::cpu {
namespace {

using Way = std::array<double, 3>;

constexpr std::size_t max_seeds_without = 64;  // seeds without a cell, before the first one with
constexpr int max_cells_on_way = 32;

Way difference(const SignFrame& frame, std::size_t from, std::size_t to, const NearShift& shift) {
    Way way;
    for (std::size_t k = 0; k < 3; ++k) {
        way[k] = frame.places[to].x[k] - frame.places[from].x[k];
        for (std::size_t j = 0; j < 3; ++j) way[k] += shift[j] * frame.vector[j][k];
    }
    return way;
}

bool add(NearShift& to, const NearShift& shift) {
    for (std::size_t j = 0; j < 3; ++j) {
        to[j] = static_cast<std::int8_t>(to[j] + shift[j]);
        if (std::abs(to[j]) > KeptCell::max_shift) return false;
    }
    return true;
}

}  // namespace

// A corner of a cell belongs to a tetrahedron of its seed and three neighbors. Those of all corners fill the space
// around the seed.
bool find_hiding_seeds(const SignFrame& frame, std::span<std::byte* const> cells, std::size_t seed,
                       std::span<std::byte, hiding_bytes> out) {
    std::size_t at = seed;
    for (std::size_t away = 1; away <= max_seeds_without && cells[at] == nullptr; ++away) {
        if (seed >= away) at = seed - away;
        if (cells[at] == nullptr && seed + away < cells.size()) at = seed + away;
    }
    NearShift shift{};  // of that seed, from the hidden one
    std::array<Way, CellShape::max_planes> way;
    for (int step = 0; step < max_cells_on_way; ++step) {
        const KeptCell cell(cells[at]);
        if (!cell.exists()) return false;
        const auto ids = cell.ids();
        for (std::size_t f = 0; f < ids.size(); ++f)
            if (ids[f] >= 0) way[f] = difference(frame, at, static_cast<std::size_t>(ids[f]), cell.near_shift(f));
        Way target = difference(frame, seed, at, shift);
        for (double& x : target) x = -x;
        double share[3] = {}, total = 0;
        const auto corner = std::ranges::find_if(cell.corners(), [&](const KeptCell::Corner& v) {
            if (ids[v[0]] < 0 || ids[v[1]] < 0 || ids[v[2]] < 0) return false;
            const double *const a = way[v[0]].data(), *const b = way[v[1]].data(), *const c = way[v[2]].data();
            share[0] = determinant(target.data(), b, c);
            share[1] = determinant(a, target.data(), c);
            share[2] = determinant(a, b, target.data());
            total = determinant(a, b, c);
            return share[0] >= 0 && share[1] >= 0 && share[2] >= 0 && total > 0;
        });
        if (corner == cell.corners().end()) return false;
        if (share[0] + share[1] + share[2] <= total) {
            LooseCell four;
            four.faces = four.corners = four.used = four.planes = 4;
            four.tests = 1;
            four.id[0] = static_cast<std::int32_t>(at);
            four.shift[0] = shift;
            for (std::size_t k = 0; k < 3; ++k) {
                four.id[k + 1] = ids[(*corner)[k]];
                four.shift[k + 1] = shift;
                if (!add(four.shift[k + 1], cell.near_shift((*corner)[k]))) return false;
            }
            four.corner[0] = {1, 2, 3};
            four.corner[1] = {2, 1, 0};
            four.corner[2] = {1, 3, 0};
            four.corner[3] = {3, 2, 0};
            four.test[0] = {0, 0};
            for (std::uint8_t f = 0; f < 4; ++f) four.plane[f] = f;
            four.pack(hiding_bytes, out);
            return true;
        }
        const auto next = (*corner)[static_cast<std::size_t>(std::ranges::max_element(share) - share)];
        if (!add(shift, cell.near_shift(next))) return false;
        at = static_cast<std::size_t>(ids[next]);
    }
    return false;
}

bool hide(const SignFrame& frame, SignTester test, std::size_t seed, const KeptCell& four, SignTest& signs) {
    (void)test(frame, seed, four, signs);
    return signs.tested &&
           std::ranges::all_of(std::span(signs.corner_margin).first(4), [](double m) { return m > 0; }) &&
           signs.test_margin[0] < -2 * signs.test_bound;
}

}  // namespace votess::cpu
