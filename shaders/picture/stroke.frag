// picture_stroke: covers what is within half the width of the line, with soft borders of one pixel.
#version 450

layout(location = 0) flat in vec4 color;
layout(location = 1) flat in float half_width;
layout(location = 2) flat in float size;
layout(location = 3) in vec2 place;
layout(location = 0) out vec4 pixel;

void main() {
    const vec2 off = vec2(place.x - clamp(place.x, 0.0, size), place.y);
    // Lines thinner than a pixel are fainter instead.
    const float width = max(half_width, 0.5);
    const float cover = clamp(width + 0.5 - length(off), 0.0, 1.0) * min(1.0, half_width / width);
    pixel = vec4(color.rgb, color.a * cover);
}
