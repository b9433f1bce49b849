// Outputs of --to-grid: .npy, .h5 and .vti, and a picture.
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
    const std::vector<double>& numbers;  // in the order of Diagram::to_grid()
    votess::GridOptions options;
    std::string method;
    std::vector<std::string> names;  // of the columns
    const votess::Tessellation& domain;
    const DomainFrom& domain_from;

    // Returns the shape of the array, without a projected axis. Several columns are its last axis.
    [[nodiscard]] std::vector<std::uint64_t> shape() const;
};

// Throws Failure unless there is an output or a picture, and each output can hold a grid.
void check_grid_outputs(const std::vector<std::string>& outputs, bool has_image, const std::string& input);
// Throws Failure for .vti with a triclinic domain.
void check_grid_domain(const std::vector<std::string>& outputs, const votess::Tessellation& domain);

void write_grid(OutputFile& file, const std::string& path, const GridOutput& grid);
void write_grid_hdf5(OutputFile& file, const GridOutput& grid);

// Returns the PNG file of a projected grid: one pixel for each number, the first axis to the right, the second up.
[[nodiscard]] std::string draw_grid(const GridOutput& grid, votess::Colormap colormap);

}  // namespace clvotess
