// What stands around the cells: the color bar, the axes of a section.
#pragma once

#include <array>
#include <string>

#include "picture/colors.hpp"
#include "picture/legend/text.hpp"
#include "picture/solid.hpp"

namespace votess::picture {

// Sizes in pixels that fit the picture.
struct Sizes {
    double unit;  // 1 in a picture of 1600 x 1200
    double text;
    double line;

    Sizes(std::uint32_t width, std::uint32_t height);
    [[nodiscard]] TextStyle style(double scale, const std::array<std::uint8_t, 4>& background) const;
};

// The color of lines and text on this background.
[[nodiscard]] Color ink(const std::array<std::uint8_t, 4>& background);

// A bar at the right of the area, from its top to its bottom.
void add_color_bar(const Scale& scale, const PictureOptions& options, const Sizes& sizes, const Area& area,
                   Scene& scene);
// Width that the color bar takes with its margins and text.
[[nodiscard]] double color_bar_width(const Scale& scale, const PictureOptions& options, const Sizes& sizes);

// A frame around the area with ticks below and at the left. ranges: of the coordinates across and up.
struct Axes {
    std::array<std::array<double, 2>, 2> ranges;
    std::array<std::string, 2> names;
};
void add_axes(const Axes& axes, const Sizes& sizes, const Area& area, Scene& scene);

}  // namespace votess::picture
