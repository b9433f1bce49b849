#include "index/hilbert.hpp"

#include <bit>

namespace votess::cpu {
namespace {

// One octant of the curve: the corner where it enters and the axis along which it leaves. After Hamilton, Compact
// Hilbert indices, Dalhousie University CS-2006-07, 2006; comments name his functions.
struct Orientation {
    unsigned corner = 0, axis = 0;
    bool operator==(const Orientation&) const = default;
};

constexpr unsigned rotate_left(unsigned octant, unsigned by) {
    by %= 3;
    return (octant << by | octant >> (3 - by)) & 7;
}

constexpr unsigned gray(unsigned i) {  // gc
    return i ^ i >> 1;
}

constexpr unsigned inverse_gray(unsigned g) {  // gc^-1
    return g ^ g >> 1 ^ g >> 2;
}

constexpr unsigned entry_corner(unsigned i) {  // e(i)
    return i == 0 ? 0 : gray((i - 1) / 2 * 2);
}

constexpr unsigned leaving_axis(unsigned i) {  // d(i)
    if (i == 0) return 0;
    return static_cast<unsigned>(std::countr_one(i % 2 == 0 ? i - 1 : i)) % 3;
}

struct Step {
    unsigned index;
    Orientation within;
};

constexpr Step step(const Orientation& o, unsigned octant) {
    const unsigned index = inverse_gray(rotate_left(octant ^ o.corner, 3 - (o.axis + 1) % 3));
    return {index, {o.corner ^ rotate_left(entry_corner(index), o.axis + 1), (o.axis + leaving_axis(index) + 1) % 3}};
}

constexpr HilbertTables make_tables() {
    constexpr int orientations = HilbertTables::orientations;
    // Orientations are numbered in the order of discovery; single has one level for each.
    std::array<Orientation, orientations> met{};
    unsigned count = 1;
    std::array<std::array<std::uint16_t, 8>, orientations> single{};
    for (unsigned o = 0; o < count; ++o)
        for (unsigned octant = 0; octant < 8; ++octant) {
            const Step s = step(met[o], octant);
            unsigned number = 0;
            while (number < count && !(met[number] == s.within)) ++number;
            if (number == count) met[count++] = s.within;
            single[o][octant] = static_cast<std::uint16_t>(number << 9 | s.index);
        }

    HilbertTables tables{};
    tables.first = single[0];
    for (unsigned o = 0; o < orientations; ++o)
        for (unsigned octants = 0; octants < 512; ++octants) {
            unsigned orientation = o, index = 0;
            for (int shift = 6; shift >= 0; shift -= 3) {
                const unsigned entry = single[orientation][octants >> shift & 7];
                index = index << 3 | (entry & 7);
                orientation = entry >> 9;
            }
            tables.deeper[o << 9 | octants] = static_cast<std::uint16_t>(orientation << 9 | index);
        }
    for (unsigned i = 0; i < tables.spread.size(); ++i)
        for (int bit = 0; bit < hilbert_levels; ++bit) tables.spread[i] |= (i >> bit & 1) << 3 * bit;
    return tables;
}

}  // namespace

constexpr HilbertTables hilbert_tables = make_tables();

}  // namespace votess::cpu
