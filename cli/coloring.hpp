// --color and --colormap: a value for each cell, for pictures and .glb.
#pragma once

#include <string>
#include <vector>
#include <votess/picture.hpp>

#include "read/input.hpp"

namespace clvotess {

struct Coloring {
    std::string column = "volume";
    votess::Colormap colormap = votess::Colormap::tide;

    // Adds the array that the column is made of.
    void add_needs(votess::Want& want) const;
    // What stands beside the color bar.
    [[nodiscard]] std::string label() const;
    // Throws Failure when the column is neither of the cells nor one of --copy and --density with a number each.
    void check(const std::vector<InputColumn>& carried) const;
    // N values of a column that was checked.
    [[nodiscard]] std::vector<double> values(const Input& input, const votess::Tessellation& tessellation,
                                             const std::vector<InputColumn>& carried) const;
};

}  // namespace clvotess
