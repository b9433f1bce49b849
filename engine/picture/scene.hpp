// A scene to draw: triangles and strokes. It knows nothing of cells.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/vector3.hpp"
#include "votess/picture.hpp"

namespace votess::picture {

using Vec3 = Vector3;
// Red, green, blue, opacity; red in the lowest byte. Components are sRGB.
using Color = std::uint32_t;

[[nodiscard]] constexpr Color rgb(unsigned r, unsigned g, unsigned b, unsigned a = 255) {
    return r | g << 8 | b << 16 | a << 24;
}

using Floats = std::array<float, 3>;
[[nodiscard]] inline Floats floats(const Vec3& p) {
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

// A corner of a triangle. Triangles form polygons as fans around their middles, and `edge` falls from 1 in the middle
// to 0 at an edge that is drawn as a line.
struct FillVertex {
    Floats position;
    std::int8_t normal[4];  // times 127; 0: not lit
    Color color;
    float edge;
};

// A straight line with round ends, in pixels of the picture (x to the right, y down) and in depth (View::project: 0
// near, 1 far).
struct Stroke {
    Floats from, to;
    float half_width;
    Color color;
};
[[nodiscard]] inline Stroke stroke(const Vec3& from, const Vec3& to, double width, Color color) {
    return {floats(from), floats(to), static_cast<float>(0.5 * width), color};
}

// A perspective camera, or with `focal` 0 none: positions are pixels then, y down, and z the depth.
struct View {
    Vec3 right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};  // back: towards the camera
    double distance = 0;                              // from the origin to the camera
    double focal = 0;                                 // pixels
    std::array<double, 2> middle{};                   // pixel in which the origin is seen
    double near = 0, far = 1;                         // distances from the camera

    // Pixel and depth.
    [[nodiscard]] Vec3 project(const Vec3& p) const;
};

struct Scene {
    std::uint32_t width = 0, height = 0;
    std::array<std::uint8_t, 4> background{};
    View view;
    std::vector<FillVertex> solid;  // through the view, lit, with ambient occlusion
    std::vector<FillVertex> flat;   // pixels, not lit
    std::vector<Stroke> strokes;    // over both, as far as the depth allows; in this order
    double edge_width = 1.2;        // pixels, of lines along edges; 0: none
    double occlusion_radius = 0;    // in units of positions; 0: no ambient occlusion
};

[[nodiscard]] inline Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
[[nodiscard]] inline Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
[[nodiscard]] inline Vec3 operator*(double s, const Vec3& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
}  // namespace votess::picture
