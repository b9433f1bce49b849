#include "picture/vulkan/parts.hpp"

#include <algorithm>

namespace votess::gpu {

using picture::Scene;
using picture::Vec3;
using picture::operator*;
using picture::operator+;

namespace {

constexpr std::uint32_t border = 164;  // pixels around a part that its occlusion is computed from; a multiple of 4

vec4 vector4(const Vec3& v, double w) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), static_cast<float>(w)};
}

// Takes positions, or with `flat` pixels, to the clip space of the whole picture.
void set_matrix(const Scene& scene, bool flat, PicturePush& push) {
    const double width = scene.width, height = scene.height;
    const picture::View& v = scene.view;
    // Rows first: x, y, z, w of the clip space as functions of the position.
    double rows[4][4] = {{2 / width, 0, 0, -1}, {0, 2 / height, 0, -1}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    if (!flat) {
        const double far = v.far / (v.far - v.near);
        for (std::size_t k = 0; k < 3; ++k) {
            rows[3][k] = -v.back[k];
            rows[0][k] = 2 * v.focal / width * v.right[k] + (2 * v.middle[0] / width - 1) * rows[3][k];
            rows[1][k] = -2 * v.focal / height * v.up[k] + (2 * v.middle[1] / height - 1) * rows[3][k];
            rows[2][k] = far * rows[3][k];
        }
        rows[3][3] = v.distance;
        rows[0][3] = (2 * v.middle[0] / width - 1) * v.distance;
        rows[1][3] = (2 * v.middle[1] / height - 1) * v.distance;
        rows[2][3] = far * (v.distance - v.near);
    }
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) push.matrix[column][row] = static_cast<float>(rows[row][column]);
    }
}

}  // namespace

std::vector<PicturePart> cut_picture(const Scene& scene, std::uint32_t most) {
    std::vector<PicturePart> parts;
    const bool whole = scene.width <= most && scene.height <= most;
    const std::uint32_t around = whole ? 0 : border;
    const std::uint32_t step = whole ? most : std::max(most / 4 * 4, 2 * border + 64) - 2 * border;
    for (std::uint32_t top = 0; top < scene.height; top += step) {
        for (std::uint32_t left = 0; left < scene.width; left += step) {
            PicturePart p{left, top, std::min(step, scene.width - left), std::min(step, scene.height - top), 0, 0,
                          0,    0};
            p.draw_left = left - std::min(left, around);
            p.draw_top = top - std::min(top, around);
            p.draw_w = std::min(scene.width, left + p.width + around) - p.draw_left;
            p.draw_h = std::min(scene.height, top + p.height + around) - p.draw_top;
            parts.push_back(p);
        }
    }
    return parts;
}

PicturePush push_for(const Scene& scene, const PicturePart& part, bool flat) {
    const picture::View& v = scene.view;
    PicturePush push{};
    set_matrix(scene, flat, push);
    const auto scale = [](double whole, double drawn) { return static_cast<float>(whole / drawn); };
    const auto offset = [](double whole, double drawn, double begin) {
        return static_cast<float>((whole - 2 * begin) / drawn - 1);
    };
    push.tile = {scale(scene.width, part.draw_w), scale(scene.height, part.draw_h),
                 offset(scene.width, part.draw_w, part.draw_left), offset(scene.height, part.draw_h, part.draw_top)};
    // From above, the left and the camera's side, so that the three sides of a box differ.
    const Vec3 light = -0.38 * v.right + 0.72 * v.up + 0.58 * v.back;
    push.light = vector4(light, 0.5 * scene.edge_width);
    push.sky = vector4({0, 0, 1}, scene.occlusion_radius);
    push.lens = {static_cast<float>(v.middle[0] - part.draw_left), static_cast<float>(v.middle[1] - part.draw_top),
                 static_cast<float>(v.focal), 0.0f};
    return push;
}

}  // namespace votess::gpu
