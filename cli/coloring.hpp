// --color and --colormap: one value for each cell, for pictures and .glb.
#pragma once

#include <string>
#include <vector>
#include <votess/picture.hpp>

#include "read/input.hpp"

namespace clvotess {

struct Coloring {
    std::string column = "volume";
    votess::Colormap colormap = votess::Colormap::tide;

    // Adds the array that holds the column.
    void add_needs(votess::Want& want) const;
    // Returns the label of the color bar.
    [[nodiscard]] std::string label(bool planar) const;
    // Throws Failure unless the column is known: of the cells, or of --copy or --density with one number for each.
    void check(const std::vector<InputColumn>& carried, bool planar) const;
    // Returns N values. The column must be checked before.
    [[nodiscard]] std::vector<double> values(const Input& input, const votess::Tessellation& tessellation,
                                             const std::vector<InputColumn>& carried) const;
};

}  // namespace clvotess
