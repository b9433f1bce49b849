// Tessellations of every domain, and sums over a grid.
#pragma once

#include <cmath>
#include <string>
#include <vector>
#include <votess/diagram.hpp>

#include "support/generators.hpp"
#include "support/random.hpp"

namespace test {

struct FieldCase {
    std::string name;
    Coordinates points;
    votess::Options options;
};

inline votess::TriclinicBox skewed_cell(bool left_handed) {
    votess::TriclinicBox cell{{0.25, -1, 3}, {1, 0, 0.125}, {0.4, 1.1, 0}, {-0.3, 0.25, 0.9}};
    if (left_handed) std::swap(cell.a, cell.b);
    return cell;
}

inline Coordinates inside(const votess::TriclinicBox& cell, const Coordinates& fractions) {
    Coordinates points;
    for (std::size_t i = 0; i < fractions.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k)
            points.push_back(cell.origin[k] + fractions[i] * cell.a[k] + fractions[i + 1] * cell.b[k] +
                             fractions[i + 2] * cell.c[k]);
    return points;
}

// Boxes, periodic ones, triclinic ones and polyhedra, with weights and without, with faces.
inline std::vector<FieldCase> field_cases(std::size_t n) {
    const Coordinates uniform = test::uniform(n, 1).points;
    std::vector<FieldCase> cases;
    const auto add = [&](const char* name, const Coordinates& points) -> votess::Options& {
        cases.push_back({name, points, {}});
        cases.back().options.box = unit_box();
        cases.back().options.want.faces = true;
        cases.back().options.device = "cpu";
        cases.back().options.threads = 1;
        return cases.back().options;
    };
    add("uniform", uniform);
    add("clustered", clustered(n, 2).points);
    add("duplicates", with_duplicates(n, n / 4, 3).points);
    add("periodic", uniform).periodic = {true, true, true};
    add("clustered, periodic", clustered(n, 2).points).periodic = {true, true, true};
    add("periodic along y", uniform).periodic = {false, true, false};
    add("two seeds, periodic", test::uniform(2, 4).points).periodic = {true, true, true};
    for (const bool left_handed : {false, true}) {
        const votess::TriclinicBox cell = skewed_cell(left_handed);
        votess::Options& options = add(left_handed ? "left-handed" : "triclinic", inside(cell, uniform));
        options.box.reset();
        options.cell = cell;
    }
    votess::TriclinicBox slab = skewed_cell(false);
    slab.periodic[2] = false;
    votess::Options& triclinic_slab = add("triclinic slab", inside(slab, uniform));
    triclinic_slab.box.reset();
    triclinic_slab.cell = slab;
    votess::Options& walls = add("walls", uniform);
    walls.walls = {{{1, 1, 1}, 2}, {{-1, 0.5, 0.25}, 0.3}};
    walls.outside = votess::Outside::drop;
    // Lattices whose faces lie in planes of a grid, or almost.
    for (const double spacing : {0.25, 0.1}) {
        const PointSet lattice = cubic(4, spacing);
        for (const bool periodic : {false, true}) {
            votess::Options& options = add("lattice", lattice.points);
            options.box = lattice.box;
            options.periodic = {periodic, periodic, periodic};
        }
    }
    return cases;
}

// Weights that leave some cells empty.
inline std::vector<double> some_weights(std::size_t n, double largest) {
    Random random(5);
    std::vector<double> weights(n);
    for (double& w : weights) w = random.uniform(0, largest);
    return weights;
}

inline double grid_cell_volume(const votess::Tessellation& t, const votess::GridOptions& o) {
    double volume = 1;
    if (t.cell()) {
        const auto& [origin, a, b, c, periodic] = *t.cell();
        volume = std::abs(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0]));
    } else {
        for (std::size_t k = 0; k < 3; ++k) volume *= t.box().upper[k] - t.box().lower[k];
    }
    for (const std::size_t n : o.shape) volume /= static_cast<double>(n);
    return volume;
}

inline std::vector<double> grid_of(const votess::Diagram& diagram, const std::vector<double>& values,
                                   const votess::GridOptions& options) {
    std::size_t cells = options.columns;
    for (int k = 0; k < 3; ++k)
        if (k != options.project) cells *= options.shape[static_cast<std::size_t>(k)];
    std::vector<double> grid(cells, -1);
    diagram.to_grid(values, options, grid);
    return grid;
}

}  // namespace test
