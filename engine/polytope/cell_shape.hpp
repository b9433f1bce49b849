// What volume, centroid and areas of a cell are computed from, and the numbers themselves. They depend on the seed and
// its neighbors alone: not on who found the cell, nor in which order. So planes stand in the order of the cell's row,
// and CellMeter brings the corners into an order of their own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace votess::cpu {

class Cell;
struct CellFaces;

// Solves corners exactly.
class ExactCorners {
public:
    // The corner of three planes, by their ranks, rounded.
    [[nodiscard]] virtual std::array<double, 3> corner(const std::array<unsigned, 3>& ranks) const = 0;

protected:
    ~ExactCorners() = default;
};

struct CellShape {
    static constexpr int max_planes = 64;
    static constexpr int max_corners = 2 * max_planes;
    // Planes behind all others that fill up vectors of corners: they meet in the seed, which adds nothing.
    static constexpr int fillers = 3;

    // n.x = |n|^2 + power, with n half of the difference of the seeds, rounded to doubles, or half of the way to the
    // seed's mirror image in a wall; power: a quarter of what the seed's weight exceeds the neighbor's by.
    struct alignas(32) Plane {
        double n[3] = {};
        double power = 0;
    };

    int planes = 0, corners = 0;
    int slots = 0;  // of planes, some of which may have no face; whoever fills this chooses them
    bool weighted = false;
    // The planes that meet in each corner, by slots, in any order. Where more than three meet, the corner stands here
    // several times: the polygon of their normals is cut into triangles from its plane of least rank.
    alignas(32) std::array<std::uint8_t, max_corners> a{}, b{}, c{};
    alignas(32) std::array<std::uint8_t, max_planes> rank{};  // by slot: the place in the row, walls first
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
    // Planes around one corner, after their ranks are known. False when there is no room.
    [[nodiscard]] bool add_polygon(std::span<const std::uint8_t> around);
};

struct CellMeasures {
    double volume = 0;
    double farthest_squared = 0;                                    // from the seed to a vertex
    std::array<double, 3> centroid{};                               // relative to the seed
    alignas(32) std::array<double, CellShape::max_planes> areas{};  // by rank
};

// Corners in their order: of each, the three ranks, ascending, times rank_step.
struct CornerOrder {
    static constexpr int rank_step = 4;  // an address is a multiple of what an instruction can multiply by
    alignas(32) std::array<std::array<std::uint16_t, CellShape::max_corners + 16>, 3> rank;
};

// The shapes of clipped cells. One per thread.
class ShapeReader final : private ExactCorners {
public:
    // ranks: by face. False for cells that are too large.
    [[nodiscard]] bool read(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks,
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

// For cells whose shape does not tell: from corners that are solved exactly. areas: by rank, to an absolute error of
// 1e-10 of their sum.
void measure_exactly(const Cell& cell, const CellFaces& faces, std::span<const std::uint32_t> ranks, CellMeasures& out,
                     std::vector<double>& areas);

}  // namespace votess::cpu
