// A cell of an earlier call: which seeds are its neighbors and which of their planes meet in corners. It has no places,
// so it can be tested at others.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "exact/predicate.hpp"

namespace votess::cpu {

// A view of a stored cell. Planes are numbered in the order of the cell's row.
class KeptCell {
public:
    struct Head {
        std::uint16_t room;  // bytes / 8 of the storage
        std::uint8_t faces, corners, used, tests, planes;
        bool shifted : 1, tied : 1;  // some neighbor is an image; some sign was 0
    };
    static constexpr int max_shift = 2;  // of neighbors whose signs are tested
    using NearShift = std::array<std::int8_t, 3>;
    using Corner = std::array<std::uint8_t, 3>;  // planes, counterclockwise seen from outside
    // An edge: a corner at one end, and the plane that ends it at the other, outside of which the corner must not lie.
    struct Test {
        std::uint8_t corner, plane;
    };

    KeptCell() = default;
    explicit KeptCell(const std::byte* at) : at_(at) {}
    [[nodiscard]] bool exists() const { return at_ != nullptr; }

    [[nodiscard]] const Head& head() const { return *reinterpret_cast<const Head*>(at_); }
    [[nodiscard]] std::size_t faces() const { return head().faces; }
    // Sorted seeds, or walls below 0.
    [[nodiscard]] std::span<const std::int32_t> ids() const {
        return {reinterpret_cast<const std::int32_t*>(at_ + sizeof(Head)), faces()};
    }
    [[nodiscard]] exact::Shift shift(std::size_t face) const {
        const auto [x, y, z] = near_shift(face);
        return {x, y, z};
    }
    [[nodiscard]] NearShift near_shift(std::size_t face) const {
        if (!head().shifted) return {};
        const std::int8_t* s = shifts() + 3 * face;
        return {s[0], s[1], s[2]};
    }
    // The first head().used of them are those that this cell tests.
    [[nodiscard]] std::span<const Corner> corners() const {
        return {reinterpret_cast<const Corner*>(shifts() + (head().shifted ? 3 * faces() : 0)), head().corners};
    }
    [[nodiscard]] std::span<const Test> tests() const {
        return {reinterpret_cast<const Test*>(corners().data() + head().corners), head().tests};
    }
    // The planes of the used corners and of tests(), ascending.
    [[nodiscard]] std::span<const std::uint8_t> planes() const {
        return {reinterpret_cast<const std::uint8_t*>(tests().data() + head().tests), head().planes};
    }
    [[nodiscard]] static std::size_t bytes(const Head& head) {
        return sizeof(Head) + (head.shifted ? 7u : 4u) * head.faces + 3u * head.corners + 2u * head.tests + head.planes;
    }

    // For other numbers of seeds. A cell next to a seed that has left becomes tied, and has `no_seed` in its place.
    static constexpr std::int32_t no_seed = std::numeric_limits<std::int32_t>::min();
    static std::span<std::int32_t> ids_of(std::byte* record) {
        return {reinterpret_cast<std::int32_t*>(record + sizeof(Head)), KeptCell(record).faces()};
    }
    static void set_tied(std::byte* record) { reinterpret_cast<Head*>(record)->tied = true; }

private:
    [[nodiscard]] const std::int8_t* shifts() const {
        return reinterpret_cast<const std::int8_t*>(at_ + sizeof(Head) + 4 * faces());
    }
    const std::byte* at_ = nullptr;
};
static_assert(sizeof(KeptCell::Head) == 8 && sizeof(KeptCell::Corner) == 3 && sizeof(KeptCell::Test) == 2);

}  // namespace votess::cpu
