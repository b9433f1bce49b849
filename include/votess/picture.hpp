// Pictures of a tessellation: its cells cut open, or a plane section. Drawn on the CPU, by all threads.
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
#include <votess/votess.hpp>

namespace votess {

// What is taken away so that the inside is seen. The sections are filled.
enum class Cut : std::uint8_t {
    corner = 0,  // the octant towards the camera
    half = 1,    // the half towards the camera, along the axis nearest to its direction
    cells = 2,   // the cells whose seeds lie in that octant, as wholes
    none = 3,
};

enum class ColorScale : std::uint8_t {
    automatic = 0,  // logarithmic when the values are positive and their range is wide
    linear = 1,
    logarithmic = 2,
};

// Each grows evenly in perceived lightness.
enum class Colormap : std::uint8_t {
    tide = 0,   // violet, blue, green, yellow
    ember = 1,  // purple, red, orange, yellow
    gray = 2,
};

enum class WallCells : std::uint8_t {
    automatic = 0,  // hide them where they dwarf the others (a median size of 8 times theirs), but not in a slice
    show = 1,
    hide = 2,  // those at the walls and their neighbors: what is left is the inside of a ragged set
};

struct Slice {
    int axis = 2;      // 0, 1, 2 = x, y, z
    double value = 0;  // the plane is where that coordinate has this value; it must meet the domain
};

struct PictureOptions {
    std::uint32_t width = 1600, height = 1200;  // pixels, 64 to 16384 each

    // N values to color the cells by; NaN: gray. Empty: the volumes, which must have been wanted then.
    std::span<const double> values;
    std::string label = "volume";  // beside the color bar; printable ASCII, ^2 raises what follows
    std::optional<std::array<double, 2>>
        range;  // default: that of the cells shown but for 0.5 % at each end, at the lower 3 % in a logarithmic scale
    ColorScale scale = ColorScale::automatic;
    Colormap colormap = Colormap::tide;

    // Where the camera stands, in degrees: azimuth from the x axis towards y, elevation above the plane of x and y,
    // at most 89 either way. Not with a slice.
    double azimuth = 36, elevation = 27;
    Cut cut = Cut::corner;
    // Where the cut planes meet; default: the middle of what is shown.
    std::optional<std::array<double, 3>> cut_at;
    WallCells wall_cells = WallCells::automatic;

    // A section by a plane instead, seen along its axis.
    std::optional<Slice> slice;

    bool edges = true;   // lines along the edges of cells, fading where cells are small
    bool seeds = false;  // with a slice: dots for the seeds near the plane
    bool color_bar = true;
    bool frame = true;  // the box as lines; with a slice axes with ticks
    std::array<std::uint8_t, 4> background{255, 255, 255, 255};

    unsigned threads = 0;  // CPU threads, 0 = all
};

struct Picture {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> pixels;  // 4 width height: RGBA, rows from the top, from the left
};

// Draws the cells. The tessellation needs Want::faces. points: the array given to tessellate(); read during the call
// only. The same input gives the same pixels for any number of threads.
// Throws Error: invalid_argument (names the missing or wrong value), out_of_memory.
[[nodiscard]] VOTESS_API Picture render(const Tessellation& tessellation, std::span<const double> points,
                                        const PictureOptions& options = {});

// Returns red, green and blue of sRGB for each of the values, as render() colors cells: range, scale and colormap of
// the options are used, and NaN is gray. Throws Error: invalid_argument.
[[nodiscard]] VOTESS_API std::vector<std::uint8_t> value_colors(const PictureOptions& options);

}  // namespace votess
