// Sketches of the ways from a cell's seed to its neighbors, 16 bits a coordinate. They suffice to skip most neighbors
// when a ray leaves the cell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace votess::cpu {

// Some neighbors; those behind the last are 0.
struct RaySketch {
    static constexpr std::size_t lanes = 8;
    static constexpr float units = 0x1p15F;  // of `way`, in a unit of the cell
    std::array<std::array<std::int16_t, lanes>, 3> way;
    std::array<std::int32_t, lanes> seed;
};
// The squared length of each way less its seed's weight, plus that of the cell's own.
using SketchConstants = std::array<float, RaySketch::lanes>;

// A ray and bounds, by which a neighbor of way n is crossed at a / b, with a = constant + n.twice_place and b =
// n.direction.
struct SketchRay {
    std::array<float, 3> direction, twice_place;  // over RaySketch::units
    // Below -min_slope the ray surely recedes. Above, the error of a / b is at most (rise + slope |a / b|) / b +
    // constant + relative |a / b|.
    float rise, slope, min_slope, constant, relative;
    float max_relative;  // relative |a|, at most
};

struct SketchedCell {
    std::span<const RaySketch> sketches;
    const SketchConstants* constants;  // null: the squared lengths of the ways
    std::size_t count;                 // of the neighbors
};

// Writes the numbers of all neighbors that may be crossed first, or that the ray may run along. Returns how many.
// scratch: 2 floats for each lane of the sketches.
using SelectCrossings = std::size_t (*)(const SketchedCell& cell, const SketchRay& ray, float* scratch,
                                        std::uint32_t* selected);
// instructions: of Kernels.
SelectCrossings select_crossings(std::string_view instructions);

}  // namespace votess::cpu
