// Masses of cells under a density that is constant in the boxes of a grid: an image, a field.
//
//     const votess::Density image{{width, height, 1}, pixels};
//     const votess::Masses of = votess::masses(t, image);  // a tessellation with Want::faces
//     of.masses[i], of.centroids[2 * i]                    // of cell i
//
// fit_volumes() in fit.hpp gives each cell the mass that the caller wants.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace votess {

// The grid divides the box of the domain along x, y and z, or a triclinic box along its edges a, b and c, as that of
// Diagram::to_grid(). Value (i * ny + j) * nz + k is the density in box (i, j, k): mass per volume, in the plane per
// area. x comes first: an image whose rows run from top to bottom must be turned.
struct Density {
    std::array<std::size_t, 3> shape{};  // nx, ny, nz: 1 to 2^20 each; nz is 1 in the plane
    std::span<const double> values;      // nx * ny * nz, finite, not negative
};

struct Masses {
    std::vector<double> masses;          // N: the density integrated over each cell; 0 without a cell
    std::vector<double> centroids;       // 3N, in the plane 2N: centers of mass, absolute; NaN without mass
    std::vector<double> second_moments;  // N: the density times the squared distance from that center, integrated
    // indptr[N]: the density integrated over the face of each entry. Half of it over the distance of two seeds is the
    // derivative of a mass by a weight. On a face between boxes of the grid the density is the mean of both sides.
    std::vector<double> face_masses;
};

// Integrates a density over cells and faces: the grid cuts their polygons, nothing is sampled. Masses have a relative
// error of about 1e-14 of the mass near the cell. threads: 0 for one for each processor.
// Throws invalid_argument for a density that is not as above, cells in a mesh, cells that reach infinity, cells without
// Want::faces and with dropped faces.
[[nodiscard]] VOTESS_API Masses masses(const Tessellation& tessellation, const Density& density, unsigned threads = 0);

}  // namespace votess
