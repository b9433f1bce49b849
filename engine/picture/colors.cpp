#include "picture/colors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/errors.hpp"
#include "core/text.hpp"

namespace votess::picture {
namespace {

// A path through the Oklab space, in which equal distances look alike: lightness, chroma and hue at its ends and
// middle.
struct Path {
    double light[2];
    double chroma[3];
    double hue[2];  // degrees, unwrapped
};

// Lightness grows linearly, so that order can be seen, also in gray.
constexpr Path paths[] = {
    {{0.33, 0.93}, {0.130, 0.130, 0.150}, {300, 102}},  // tide
    {{0.25, 0.91}, {0.100, 0.190, 0.130}, {-55, 96}},   // ember
    {{0.20, 0.95}, {0, 0, 0}, {0, 0}},                  // gray
};

using Linear = std::array<double, 3>;

// Oklab to linear sRGB, after its definition.
Linear from_oklab(double light, double a, double b) {
    const double l = std::pow(light + 0.3963377774 * a + 0.2158037573 * b, 3);
    const double m = std::pow(light - 0.1055613458 * a - 0.0638541728 * b, 3);
    const double s = std::pow(light - 0.0894841775 * a - 1.2914855480 * b, 3);
    return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
            -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
            -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

bool displayable(const Linear& c) {
    return std::all_of(c.begin(), c.end(), [](double x) { return x >= 0 && x <= 1; });
}

unsigned encode(double x) {
    const double s = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return static_cast<unsigned>(std::lround(255 * std::clamp(s, 0.0, 1.0)));
}

// The smallest step of 1, 2, 5 times a power of ten that gives at most `most` steps.
double round_step(double span, int most) {
    const double rough = span / most, power = std::pow(10, std::floor(std::log10(rough)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= rough * (1 - 1e-9)) return factor * power;
    return 10 * power;
}

int decade(double x) {
    return static_cast<int>(std::floor(std::log10(x) + 1e-9));
}

std::string power_text(int exponent, int factor) {
    if (exponent >= -3 && exponent <= 4) {
        std::array<char, 32> text;
        std::snprintf(text.data(), text.size(), "%.*f", std::max(0, -exponent), factor * std::pow(10, exponent));
        return text.data();
    }
    const std::string power = "10^" + std::to_string(exponent);
    return factor == 1 ? power : std::to_string(factor) + "*" + power;
}

Ticks linear_ticks(const Scale& scale, int wanted) {
    Ticks ticks;
    if (!std::isfinite(scale.high - scale.low)) return ticks;
    const double round = round_step(scale.high - scale.low, wanted);
    const double step = scale.steps > 0 ? std::max(1.0, round) : round, slack = 1e-9 * (scale.high - scale.low);
    // Numbers with many zeros share a power of ten.
    const int largest = decade(std::max({std::abs(scale.low), std::abs(scale.high), step}));
    const int exponent = largest >= 5 || decade(step) < -3 ? largest : 0;
    const int digits = std::clamp(exponent - decade(step), 0, 15);
    if (exponent != 0) ticks.factor = "*10^" + std::to_string(exponent);
    for (double k = std::ceil((scale.low - slack) / step); k * step <= scale.high + slack; ++k) {
        std::array<char, 64> text;
        // No minus before a zero.
        const double value = k == 0 ? 0 : k * step / std::pow(10, exponent);
        std::snprintf(text.data(), text.size(), "%.*f", digits, value);
        ticks.marks.push_back({k * step, text.data(), scale.at(k * step)});
    }
    return ticks;
}

Ticks logarithmic_ticks(const Scale& scale, int wanted) {
    Ticks ticks;
    const double decades = std::log10(scale.high) - std::log10(scale.low);
    const int first = static_cast<int>(std::floor(std::log10(scale.low)));
    const int last = static_cast<int>(std::ceil(std::log10(scale.high)));
    const int every = std::max(1, static_cast<int>(std::ceil(decades / (wanted + 1.5))));
    for (int exponent = first; exponent <= last; ++exponent) {
        for (int factor = 1; factor < 10; ++factor) {
            const double value = factor * std::pow(10, exponent), at = scale.at(value);
            if (value < scale.low * (1 - 1e-9) || value > scale.high * (1 + 1e-9)) continue;
            const bool whole = factor == 1 && ((exponent % every) + every) % every == 0;
            const bool between = decades < 2.2 && (factor == 2 || factor == 5);
            if (every > 1 && factor > 1) continue;
            ticks.marks.push_back({value, whole || between ? power_text(exponent, factor) : "", at});
        }
    }
    return ticks;
}

}  // namespace

Color map_color(Colormap map, double t) {
    const Path& path = paths[static_cast<std::size_t>(map)];
    t = std::clamp(t, 0.0, 1.0);
    const double light = std::lerp(path.light[0], path.light[1], t);
    const double hue = std::lerp(path.hue[0], path.hue[1], t) * std::numbers::pi / 180;
    // The parabola through the chroma at both ends and in the middle.
    const auto& [c0, c1, c2] = path.chroma;
    double chroma = c0 * (1 - t) * (1 - 2 * t) + 4 * c1 * t * (1 - t) + c2 * t * (2 * t - 1);
    Linear color = from_oklab(light, chroma * std::cos(hue), chroma * std::sin(hue));
    for (int i = 0; i < 64 && !displayable(color); ++i) {
        chroma *= 0.98;
        color = from_oklab(light, chroma * std::cos(hue), chroma * std::sin(hue));
    }
    return rgb(encode(color[0]), encode(color[1]), encode(color[2]));
}

Color scale_color(const Scale& scale, Colormap map, double t) {
    if (scale.steps > 0) t = (std::clamp(std::floor(t * scale.steps), 0.0, scale.steps - 1.0) + 0.5) / scale.steps;
    return map_color(map, t);
}

double Scale::at(double value) const {
    if (!logarithmic) return (value / 2 - low / 2) / (high / 2 - low / 2);  // the range may exceed the largest double
    if (std::isinf(high / low)) return (std::log(value) - std::log(low)) / (std::log(high) - std::log(low));
    return std::log(value / low) / std::log(high / low);
}

Ticks Scale::ticks(int wanted) const {
    // Within a factor of ten there may be too few round powers.
    if (logarithmic && high / low >= 10) return logarithmic_ticks(*this, wanted);
    return linear_ticks(*this, wanted);
}

namespace {
bool is_logarithmic(const PictureOptions& options, const Scale& scale) {
    constexpr double wide = 30;
    return options.scale == ColorScale::logarithmic ||
           (options.scale == ColorScale::automatic && scale.low > 0 && scale.high / scale.low > wide);
}
}  // namespace

Scale choose_scale(std::span<const double> values, std::span<const char> shown, const PictureOptions& options) {
    std::vector<double> sorted;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (shown[i] && std::isfinite(values[i])) sorted.push_back(values[i]);
    std::sort(sorted.begin(), sorted.end());

    Scale scale;
    if (options.range) {
        scale.low = (*options.range)[0];
        scale.high = (*options.range)[1];
    } else if (!sorted.empty()) {
        const auto last = static_cast<double>(sorted.size() - 1);
        const auto quantile = [&](double q) { return sorted[static_cast<std::size_t>(std::lround(q * last))]; };
        scale.low = quantile(0.005);
        scale.high = quantile(0.995);
        scale.logarithmic = is_logarithmic(options, scale);
        // Small values are drawn out there, while their cells are hardly seen.
        if (scale.logarithmic) scale.low = quantile(0.03);
    }
    scale.logarithmic = is_logarithmic(options, scale) || scale.logarithmic;
    constexpr double max_steps = 24;
    if (!options.range && !sorted.empty() && !scale.logarithmic && scale.high - scale.low < max_steps &&
        std::ranges::all_of(sorted, [](double v) { return v == std::nearbyint(v); })) {
        scale.steps = static_cast<int>(scale.high - scale.low) + 1;
        scale.low -= 0.5;
        scale.high += 0.5;
    }
    // One value, or values that differ by rounding only, are no range; theirs is the middle of the map.
    const double size = std::max(std::abs(scale.low), std::abs(scale.high));
    if (!options.range && scale.high - scale.low <= 1e-9 * size) {
        const double middle = scale.low, margin = middle == 0 ? 1 : 0.5 * std::abs(middle);
        scale.low = middle - margin;
        scale.high = middle + margin;
    }
    if (!sorted.empty()) {
        const double slack = 1e-9 * (scale.high - scale.low);
        scale.below = sorted.front() < scale.low - slack;
        scale.above = sorted.back() > scale.high + slack;
    }
    if (scale.logarithmic && !(scale.low > 0)) {
        refuse("a logarithmic color scale needs values above 0: give a range or take the linear scale");
    }
    return scale;
}

std::vector<Color> color_cells(std::span<const double> values, const Scale& scale, Colormap map) {
    constexpr int steps = 1024;
    std::vector<Color> table(steps + 1);
    for (int i = 0; i <= steps; ++i)
        table[static_cast<std::size_t>(i)] = scale_color(scale, map, static_cast<double>(i) / steps);
    std::vector<Color> colors(values.size(), no_value);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (std::isnan(values[i])) continue;
        // Some of what lies beyond a logarithmic scale has no logarithm.
        const double t = values[i] <= scale.low ? 0 : values[i] >= scale.high ? 1 : scale.at(values[i]);
        colors[i] = table[static_cast<std::size_t>(std::lround(t * steps))];
    }
    return colors;
}

void check_colors(const PictureOptions& options) {
    if (options.colormap > Colormap::gray) refuse("picture: no such color map");
    if (!options.range) return;
    const auto& [low, high] = *options.range;
    if (!std::isfinite(low) || !std::isfinite(high) || !(low < high)) {
        refuse("picture: color range " + number(low) + " to " + number(high) + ": give a lower and a higher number");
    }
}

}  // namespace votess::picture

namespace votess {

std::vector<std::uint8_t> value_colors(const PictureOptions& options) {
    picture::check_colors(options);
    const std::vector<char> all(options.values.size(), 1);
    const picture::Scale scale = picture::choose_scale(options.values, all, options);
    std::vector<std::uint8_t> colors;
    for (const picture::Color color : picture::color_cells(options.values, scale, options.colormap)) {
        for (const unsigned shift : {0U, 8U, 16U}) colors.push_back(static_cast<std::uint8_t>(color >> shift & 0xFF));
    }
    return colors;
}

}  // namespace votess
