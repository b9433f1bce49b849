// The shape of a cell, and the measures computed from it. They depend on the seed and its neighbors only, so planes are
// in the order of the cell's row, and CellMeter sorts the corners.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace votess::cpu {

class Cell;
struct CellFaces;

class ExactCorners {
public:
    // Returns the corner of three planes, given by rank, wrong by at most 2^-52 of its length.
    [[nodiscard]] virtual std::array<double, 3> corner(const std::array<unsigned, 3>& ranks) const = 0;

protected:
    ~ExactCorners() = default;
};

struct CellShape {
    static constexpr int max_planes = 64;
    static constexpr int max_corners = 2 * max_planes;
    // Planes behind all others that fill up vectors of corners. They meet in the seed, which adds nothing.
    static constexpr int fillers = 3;

    // n.x = |n|^2 + power. n: half of the difference of the seeds, rounded to doubles, or half of the way to the mirror
    // image in a wall, reversed if the seed lies beyond it. power: (own weight - neighbor's weight) / 4; 0 for a wall
    // before the seed.
    struct alignas(32) Plane {
        double n[3] = {};
        double power = 0;
    };

    int planes = 0, corners = 0;
    int slots = 0;  // of planes, chosen by the writer; some may have no face
    bool weighted = false;
    // The slots of the planes that meet in each corner, in any order. A corner of more than three planes occurs several
    // times: the polygon of normals is cut into triangles from its plane of least rank.
    alignas(32) std::array<std::uint8_t, max_corners> a{}, b{}, c{};
    alignas(32) std::array<std::uint8_t, max_planes> rank{};  // by slot: position in the row, walls first
    std::array<Plane, max_planes + fillers> plane{};          // by rank; measuring changes them
    const ExactCorners* exact = nullptr;                      // of the same cell

    CellShape() {
        for (std::size_t k = 0; k < fillers; ++k) plane[max_planes + k].n[k] = 1;
    }
    void add_corner(unsigned p, unsigned q, unsigned r) {
        const auto at = static_cast<std::size_t>(corners++);
        a[at] = static_cast<std::uint8_t>(p);
        b[at] = static_cast<std::uint8_t>(q);
        c[at] = static_cast<std::uint8_t>(r);
    }
    // Adds the planes around one corner, whose ranks must be set. Returns false when there is no room.
    [[nodiscard]] bool add_polygon(std::span<const std::uint8_t> around);
};

struct CellMeasures {
    int exponent = 0;  // of the unit of lengths in the volume, the areas and the farthest vertex, a power of two
    double volume = 0;
    double farthest_squared = 0;                                    // from the seed to a vertex
    std::array<double, 3> centroid{};                               // relative to the seed, always in units of one
    alignas(32) std::array<double, CellShape::max_planes> areas{};  // by rank
};

// Corners in order: the three ranks of each, ascending, times rank_step.
struct CornerOrder {
    static constexpr int rank_step = 4;  // addresses are a multiple of a factor that an instruction has
    alignas(32) std::array<std::array<std::uint16_t, CellShape::max_corners + 16>, 3> rank;
};

// Reads the shapes of clipped cells. One for each thread.
class ShapeReader final : private ExactCorners {
public:
    // ranks: by face. beyond: the seed lies beyond some wall; out.weighted must be set. Returns false for cells that
    // are too large, or if the seed is too near to a wall that it may lie beyond.
    [[nodiscard]] bool read(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, bool beyond,
                            CellShape& out);

private:
    // A face at a vertex, between the ends of its two edges there.
    struct FaceAtVertex {
        std::int32_t vertex, from, to;
        std::uint8_t face;
    };
    [[nodiscard]] std::array<double, 3> corner(const std::array<unsigned, 3>& ranks) const override;

    const Cell* cell_ = nullptr;
    std::array<std::int32_t, CellShape::max_planes> plane_{};  // of the cell, by rank
    std::vector<FaceAtVertex> all_;
    std::vector<std::uint8_t> around_;
};

// Measures from exactly solved corners. areas: by rank, in the unit of `out`, to an absolute error of 1e-10 of their
// sum.
void measure_exactly(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, CellMeasures& out,
                     std::vector<double>& areas);

}  // namespace votess::cpu
