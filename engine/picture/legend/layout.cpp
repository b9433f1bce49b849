#include "picture/legend/layout.hpp"

#include <algorithm>
#include <cmath>

namespace votess::picture {
namespace {

constexpr int bar_ticks = 6;
constexpr double bar_width = 30, bar_gap = 34, tick_length = 9, text_gap = 9, margin = 26;

FillVertex flat_vertex(double x, double y, Color color) {
    FillVertex vertex{};
    vertex.position = floats({x, y, 0});
    vertex.color = color;
    vertex.edge = 1;
    return vertex;
}

void add_rectangle(const Area& area, Color color, std::vector<FillVertex>& out) {
    const FillVertex corners[4] = {flat_vertex(area.left, area.top, color), flat_vertex(area.right, area.top, color),
                                   flat_vertex(area.right, area.bottom, color),
                                   flat_vertex(area.left, area.bottom, color)};
    for (const int i : {0, 1, 2, 0, 2, 3}) out.push_back(corners[i]);
}

void add_line(double x0, double y0, double x1, double y1, double width, Color color, std::vector<Stroke>& out) {
    out.push_back(stroke({x0, y0, 0}, {x1, y1, 0}, width, color));
}

void add_outline(const Area& a, double width, Color color, std::vector<Stroke>& out) {
    add_line(a.left, a.top, a.right, a.top, width, color, out);
    add_line(a.right, a.top, a.right, a.bottom, width, color, out);
    add_line(a.right, a.bottom, a.left, a.bottom, width, color, out);
    add_line(a.left, a.bottom, a.left, a.top, width, color, out);
}

double widest(const Ticks& ticks, const TextStyle& style) {
    double width = text_width(ticks.factor, style);
    for (const Tick& tick : ticks.marks) width = std::max(width, text_width(tick.text, style));
    return width;
}

// A triangle beyond an end of the bar: there are values beyond the scale.
void add_point(double left, double right, double y, double tip, Color color, Scene& scene) {
    scene.flat.push_back(flat_vertex(left, y, color));
    scene.flat.push_back(flat_vertex(right, y, color));
    scene.flat.push_back(flat_vertex(0.5 * (left + right), tip, color));
}

}  // namespace

Sizes::Sizes(std::uint32_t width, std::uint32_t height)
    : unit(std::min(width / 1600.0, height / 1200.0)), text(20 * unit), line(std::max(1.0, 1.5 * unit)) {}

TextStyle Sizes::style(double scale, const std::array<std::uint8_t, 4>& background) const {
    return {.size = scale * text, .color = ink(background)};
}

Color ink(const std::array<std::uint8_t, 4>& background) {
    const double light = 0.3 * background[0] + 0.6 * background[1] + 0.1 * background[2];
    return light > 110 || background[3] < 128 ? rgb(45, 45, 50) : rgb(225, 225, 230);
}

double color_bar_width(const Scale& scale, const PictureOptions& options, const Sizes& sizes) {
    if (!options.color_bar) return 0;
    const TextStyle style = sizes.style(1, options.background);
    const double label = options.label.empty() ? 0 : 2.4 * style.size;
    return sizes.unit * (bar_gap + bar_width + tick_length + text_gap + margin) +
           widest(scale.ticks(bar_ticks), style) + label;
}

void add_color_bar(const Scale& scale, const PictureOptions& options, const Sizes& sizes, const Area& whole,
                   Scene& scene) {
    if (!options.color_bar) return;
    const TextStyle style = sizes.style(1, options.background);
    const double u = sizes.unit, point = 0.9 * bar_width * u;
    const double left = whole.right + bar_gap * u, right = left + bar_width * u;
    Area area = whole;  // without the points at its ends
    if (scale.above) area.top += point;
    if (scale.below) area.bottom -= point;
    const int steps = scale.steps > 0 ? scale.steps : 256;
    const double tall = area.bottom - area.top;
    for (int i = 0; i < steps; ++i) {
        const double top = area.bottom - tall * (i + 1) / steps, bottom = area.bottom - tall * i / steps;
        add_rectangle({left, top, right, bottom}, scale_color(scale, options.colormap, (i + 0.5) / steps), scene.flat);
    }
    const double mid = 0.5 * (left + right), w = sizes.line;
    const double top_tip = whole.top, bottom_tip = whole.bottom;
    if (scale.above) add_point(left, right, area.top, top_tip, scale_color(scale, options.colormap, 1), scene);
    if (scale.below) add_point(left, right, area.bottom, bottom_tip, scale_color(scale, options.colormap, 0), scene);
    std::vector<Stroke>& out = scene.strokes;
    add_line(left, area.top, left, area.bottom, w, style.color, out);
    add_line(right, area.top, right, area.bottom, w, style.color, out);
    for (const double x : {left, right}) {
        add_line(x, area.top, mid, top_tip, w, style.color, out);
        add_line(x, area.bottom, mid, bottom_tip, w, style.color, out);
    }
    if (!scale.above) add_line(left, area.top, right, area.top, w, style.color, out);
    if (!scale.below) add_line(left, area.bottom, right, area.bottom, w, style.color, out);

    const Ticks ticks = scale.ticks(bar_ticks);
    for (const Tick& tick : ticks.marks) {
        const double y = area.bottom - tick.at * tall;
        add_line(right, y, right + (tick.text.empty() ? 0.55 : 1) * tick_length * u, y, w, style.color, out);
        draw_text(tick.text, right + (tick_length + text_gap) * u, y, 0, style, out);
    }
    // Beside the tip, above the highest number.
    if (!ticks.factor.empty()) {
        draw_text(ticks.factor, right + (tick_length + text_gap) * u, whole.top - 0.9 * style.size, 0, style, out);
    }
    if (!options.label.empty()) {
        const double x = right + (tick_length + text_gap) * u + widest(ticks, style) + 1.5 * style.size;
        TextStyle upwards = sizes.style(1.15, options.background);
        upwards.upwards = true;
        draw_text(options.label, x, 0.5 * (area.top + area.bottom), 0.5, upwards, out);
    }
}

void add_axes(const Axes& axes, const Sizes& sizes, const Area& area, Scene& scene) {
    const TextStyle style = sizes.style(1, scene.background), names = sizes.style(1.15, scene.background);
    std::vector<Stroke>& out = scene.strokes;
    add_outline(area, sizes.line, style.color, out);
    const double long_tick = tick_length * sizes.unit, gap = text_gap * sizes.unit;
    const Scale across{.low = axes.ranges[0][0], .high = axes.ranges[0][1]};
    const Ticks in_x = across.ticks(6);
    for (const Tick& tick : in_x.marks) {
        const double x = std::lerp(area.left, area.right, tick.at);
        add_line(x, area.bottom, x, area.bottom + long_tick, sizes.line, style.color, out);
        draw_text(tick.text, x, area.bottom + long_tick + gap + 0.5 * style.size, 0.5, style, out);
    }
    if (!in_x.factor.empty()) {
        draw_text(in_x.factor, area.right, area.bottom + long_tick + 2 * gap + 2 * style.size, 1, style, out);
    }
    const Scale up{.low = axes.ranges[1][0], .high = axes.ranges[1][1]};
    const Ticks ticks = up.ticks(6);
    for (const Tick& tick : ticks.marks) {
        const double y = std::lerp(area.bottom, area.top, tick.at);
        add_line(area.left - long_tick, y, area.left, y, sizes.line, style.color, out);
        draw_text(tick.text, area.left - long_tick - gap, y, 1, style, out);
    }
    draw_text(axes.names[0], 0.5 * (area.left + area.right), area.bottom + long_tick + 2 * gap + 2 * style.size, 0.5,
              names, out);
    if (!ticks.factor.empty()) draw_text(ticks.factor, area.left, area.top - 1.2 * style.size, 0, style, out);
    draw_text(axes.names[1], area.left - long_tick - 2 * gap - widest(ticks, style) - style.size,
              0.5 * (area.top + area.bottom), 0.5, names, out);
}

}  // namespace votess::picture
