// What --to-grid writes: .npy, .h5 and .vti, and a picture.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
#include <votess/diagram.hpp>
#include <votess/picture.hpp>

#include "domain.hpp"

namespace clvotess {

class OutputFile;

struct GridOutput {
    const std::vector<double>& numbers;  // as Diagram::to_grid() makes them
    votess::GridOptions options;
    std::string method;
    std::vector<std::string> names;  // of the columns
    const votess::Tessellation& domain;
    const DomainFrom& domain_from;

    // Of the array: without the axis that is projected, and with the columns where there are several.
    [[nodiscard]] std::vector<std::uint64_t> shape() const;
};

// Throws Failure: some output or a picture, each of a kind that holds a grid.
void check_grid_outputs(const std::vector<std::string>& outputs, bool has_image, const std::string& input);
// Throws Failure for .vti of a domain that VTK's grids cannot have.
void check_grid_domain(const std::vector<std::string>& outputs, const votess::Tessellation& domain);

void write_grid(OutputFile& file, const std::string& path, const GridOutput& grid);
void write_grid_hdf5(OutputFile& file, const GridOutput& grid);

// The PNG file of a projected grid: a pixel for each number, the first axis to the right, the second upwards.
[[nodiscard]] std::string draw_grid(const GridOutput& grid, votess::Colormap colormap);

}  // namespace clvotess
