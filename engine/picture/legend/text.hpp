// Text as strokes: a font of lines and curves.
#pragma once

#include <string_view>
#include <vector>

#include "picture/scene.hpp"

namespace votess::picture {

struct TextStyle {
    double size = 20;  // pixels, height of capitals
    Color color = rgb(40, 40, 40);
    double weight = 0.11;  // width of lines over size
    bool upwards = false;  // turned by 90 degrees, read from below
};

// Printable ASCII; others are drawn as a box. ^ raises digits and signs that follow, * is a raised dot of
// multiplication; \ keeps the character after it as it is.
[[nodiscard]] double text_width(std::string_view text, const TextStyle& style);

// align: 0 = the text begins at x, 0.5 = centered, 1 = ends there; along y for text upwards. (x, y) is on the line
// that halves the capitals.
void draw_text(std::string_view text, double x, double y, double align, const TextStyle& style,
               std::vector<Stroke>& strokes);

}  // namespace votess::picture
