// From values to colors: the range, the color map, the ticks of a scale.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "picture/scene.hpp"

namespace votess::picture {

// The color of t, 0 to 1.
[[nodiscard]] Color map_color(Colormap map, double t);
inline constexpr Color no_value = rgb(150, 150, 150);

struct Tick {
    double value = 0;
    std::string text;  // as draw_text takes it; empty: a small tick between
    double at = 0;     // 0 to 1 along the scale
};

struct Ticks {
    std::vector<Tick> marks;
    std::string factor;  // of all texts, "*10^-5"; empty: none
};

// Maps values to 0 .. 1.
struct Scale {
    double low = 0, high = 1;
    bool logarithmic = false;
    bool below = false, above = false;  // some values lie outside
    // 0: colors change smoothly. Else values are whole numbers, and the scale has so many colors, one each.
    int steps = 0;

    [[nodiscard]] double at(double value) const;
    // Round numbers, at most about so many of them with text.
    [[nodiscard]] Ticks ticks(int wanted) const;
};

// The color at t along the scale, 0 to 1.
[[nodiscard]] Color scale_color(const Scale& scale, Colormap map, double t);

// The scale for the values of the cells shown, as the options want it. Whole numbers in a narrow range have a color
// each.
[[nodiscard]] Scale choose_scale(std::span<const double> values, std::span<const char> shown,
                                 const PictureOptions& options);

// A color for each value; gray where there is none.
[[nodiscard]] std::vector<Color> color_cells(std::span<const double> values, const Scale& scale, Colormap map);

// Throws Error when range or map of the options are none.
void check_colors(const PictureOptions& options);

}  // namespace votess::picture
