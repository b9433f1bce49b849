// What a result says of one cell, beside the cell that brute force made.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polytope/cell.hpp"

namespace votess {

struct ToldFace {
    std::int64_t id = 0;  // of the neighbor, or a wall
    std::array<std::int8_t, 3> shift{};
    double area = 0;

    [[nodiscard]] bool operator<(const ToldFace& other) const {
        return id != other.id ? id < other.id : shift < other.shift;
    }
};

struct ToldCell {
    std::int64_t id = 0;
    bool empty = false;
    std::optional<std::vector<ToldFace>> row;  // ascending
    bool lists_walls = false, has_areas = false;
    std::optional<double> volume;
    double least_face = 0;  // smaller ones were dropped
    double tolerance = 0;   // relative, of the volume
};

// "" or one line on what differs. scale: of the lengths in `cell`; ids: those of its planes' seeds, ascending, or none:
// they are numbers of seeds.
std::string difference(const ToldCell& told, double scale, std::span<const std::int64_t> ids, cpu::Cell& cell,
                       cpu::CellFaces& faces);

}  // namespace votess
