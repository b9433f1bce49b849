// Pictures of a tessellation: its cells cut open, or a plane section. Drawn on the CPU by all threads.
//
//     options.want.faces = options.want.volumes = true;
//     votess::Tessellation t = votess::tessellate(points, options);
//     votess::Picture picture = votess::render(t, points, {});      // RGBA8, for any PNG writer
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/pieces.hpp>
#include <votess/votess.hpp>

namespace votess {

// The part that is cut away to show the inside. The sections are filled.
enum class Cut : std::uint8_t {
    corner = 0,  // the octant towards the camera
    half = 1,    // the half towards the camera, along the axis nearest to its direction
    cells = 2,   // whole cells whose seeds lie in that octant
    none = 3,
};

enum class ColorScale : std::uint8_t {
    automatic = 0,  // logarithmic when the values are positive and their range is wide
    linear = 1,
    logarithmic = 2,
};

// Perceived lightness grows evenly along each.
enum class Colormap : std::uint8_t {
    tide = 0,   // violet, blue, green, yellow
    ember = 1,  // purple, red, orange, yellow
    gray = 2,
};

enum class WallCells : std::uint8_t {
    automatic = 0,  // hide them when their median size is 8 times that of the others; show them in a slice
    show = 1,
    hide = 2,  // hide cells at the walls and their neighbors, to show the inside of a ragged set
};

struct Slice {
    int axis = 2;      // 0, 1, 2 = x, y, z
    double value = 0;  // coordinate of the plane on that axis; the plane must meet the domain
};

struct PictureOptions {
    std::uint32_t width = 1600, height = 1200;  // pixels, 64 to 16384 each

    // N values to color the cells by; NaN is gray. Empty: the volumes, which the tessellation must hold.
    std::span<const double> values;
    std::string label = "volume";  // beside the color bar; printable ASCII; ^ raises the next number
    std::optional<std::array<double, 2>>
        range;  // default: the cells shown without 0.5 % at each end, without the lower 3 % on a logarithmic scale
    ColorScale scale = ColorScale::automatic;
    Colormap colormap = Colormap::tide;

    // Position of the camera in degrees: azimuth from the x axis towards y, elevation from -89 to 89 above the xy
    // plane. Not with a slice.
    double azimuth = 36, elevation = 27;
    Cut cut = Cut::corner;
    // Where the cut planes meet; default: the middle of the cells shown.
    std::optional<std::array<double, 3>> cut_at;
    WallCells wall_cells = WallCells::automatic;

    // Draws a section by a plane instead, seen along its axis. Cells of the plane are drawn like a section.
    std::optional<Slice> slice;

    bool edges = true;   // lines along the edges of cells, fading where cells are small
    bool seeds = false;  // with a slice or in the plane: dots for the seeds near it
    bool color_bar = true;
    // Leaves out cells that reach infinity, in a domain without end; else it is refused.
    bool skip_open = false;
    bool frame = true;  // the box as lines; with a slice axes with ticks
    double gap = 0;     // between the pieces of cells of a result in a mesh, see PieceOptions::gap
    std::array<std::uint8_t, 4> background{255, 255, 255, 255};

    unsigned threads = 0;  // CPU threads, 0 = all
};

struct Picture {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> pixels;  // 4 width height: RGBA, rows from the top, from the left
    std::uint64_t left_out = 0;        // cells that reach infinity, see PictureOptions::skip_open
};

// Returns a picture of the cells, in the plane of their polygons, in a mesh of their pieces. The tessellation needs
// Want::faces, but not in a mesh. points: the array given to tessellate(), read during the call only. Pixels do not
// depend on the number of threads. Throws Error: invalid_argument (names the missing or wrong value), out_of_memory.
[[nodiscard]] VOTESS_API Picture render(const Tessellation& tessellation, std::span<const double> points,
                                        const PictureOptions& options = {});

// Returns a picture of pieces, with lines where their planes end. options.values: P; empty: the volumes. Cuts remove
// whole pieces, whose centroids lie there. Pieces of the plane are drawn like a section. Throws invalid_argument for
// seeds, for a slice in the plane or one that meets no piece, and without pieces; else as above.
[[nodiscard]] VOTESS_API Picture render(const Pieces& pieces, const PictureOptions& options = {});

// Returns red, green and blue of sRGB for each of options.values, as render() colors cells. Uses range, scale and
// colormap of the options; NaN is gray. Throws Error: invalid_argument.
[[nodiscard]] VOTESS_API std::vector<std::uint8_t> value_colors(const PictureOptions& options);

}  // namespace votess
