#include "coloring.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "failure.hpp"

namespace clvotess {

void Coloring::add_needs(votess::Want& want) const {
    want.neighbors |= column == "neighbors";
    want.volumes |= column == "volume";
    want.surfaces |= column == "area";
}

std::string Coloring::label(bool planar) const {
    if (column == "volume") return planar ? "area" : column;
    if (column == "area") return planar ? "perimeter" : "surface area";
    return column;
}

void Coloring::check(const std::vector<InputColumn>& carried, bool planar) const {
    constexpr std::array<std::string_view, 7> own{"volume", "neighbors", "area", "x", "y", "z", "index"};
    const auto taken = std::ranges::find(carried, column, &InputColumn::name);
    if (taken != carried.end() && taken->of_words)
        throw bad_input("--color " + in_quotes(column) + " has words: name a column of numbers");
    if (taken != carried.end() && taken->width != 1) {
        throw bad_input("--color " + in_quotes(column) + " has " + std::to_string(taken->width) +
                        " numbers for each point: name a column that has one");
    }
    if (taken == carried.end() && planar && column == "z")
        throw bad_input("--color z: points of the plane have no z, name another column");
    if (taken == carried.end() && std::ranges::find(own, column) == own.end()) {
        throw bad_input(
            "--color must be volume, neighbors, area, x, y, z, index or a column of --copy or --density, not " +
            in_quotes(column));
    }
}

std::vector<double> Coloring::values(const Input& input, const votess::Tessellation& tessellation,
                                     const std::vector<InputColumn>& carried) const {
    const auto taken = std::ranges::find(carried, column, &InputColumn::name);
    if (taken != carried.end()) return taken->rounded();
    if (column == "volume") return {tessellation.volumes().begin(), tessellation.volumes().end()};
    if (column == "area") return {tessellation.surface_areas().begin(), tessellation.surface_areas().end()};
    std::vector<double> values(tessellation.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (column == "neighbors") {
            for (const auto j : tessellation.neighbors(i)) values[i] += j >= 0;
        } else if (column == "index") {
            values[i] = static_cast<double>(i);
        } else {
            values[i] = input.points[input.dimensions * i + static_cast<std::size_t>(column[0] - 'x')];
        }
    }
    return values;
}

}  // namespace clvotess
