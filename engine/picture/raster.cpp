#include "picture/raster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

namespace votess::picture {
namespace {

constexpr std::int32_t no_triangle = -1;
constexpr std::size_t samples = 4;
constexpr std::uint32_t tile_size = 64;  // pixels

// Pixels are divided into units, in which corners are whole numbers: a sample on a common side of two triangles belongs
// to exactly one of them.
constexpr std::int64_t units = 256;
// Where the samples of a pixel lie from its middle: one in each row and column of a square of four by four.
constexpr std::int64_t sample_x[samples] = {-32, 96, 32, -96}, sample_y[samples] = {-96, -32, 96, 32};

// A function that is linear over the picture, in pixels.
struct LinearFunction {
    double at_origin = 0, by_x = 0, by_y = 0;

    [[nodiscard]] double at(double x, double y) const { return at_origin + by_x * x + by_y * y; }
};

struct Triangle {
    std::array<std::int64_t, 3> x{}, y{};  // units, counterclockwise in the sense of rising y
    LinearFunction nearness;               // one over the distance from the camera; 0 in the flat part
    LinearFunction edge;                   // FillVertex::edge times nearness; in the flat part the edge itself
    Vec3 normal{};                         // 0: not lit
    Color color = 0;
    bool has_lines = false;
};

struct Tile {
    std::uint32_t left, top, right, bottom;  // pixels

    [[nodiscard]] std::uint32_t width() const { return right - left; }
    [[nodiscard]] std::size_t size() const { return std::size_t{width()} * (bottom - top); }
};

// The samples of a tile: pixel by pixel of each kind of sample.
struct Samples {
    std::array<std::vector<std::int32_t>, samples> triangle;
    std::array<std::vector<float>, samples> nearness;

    void clear(std::size_t pixels) {
        for (std::size_t s = 0; s < samples; ++s) {
            triangle[s].assign(pixels, no_triangle);
            nearness[s].assign(pixels, 0);
        }
    }
};

// What a pixel shows of the solid in its first sample.
struct Surface {
    std::int32_t triangle = no_triangle;
    float away = 0;  // distance from the camera, along its direction
};

struct Rgba {
    double r = 0, g = 0, b = 0, a = 0;  // the colors times a
};

double decode(unsigned byte) {
    const double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double encoded(double c) {
    return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

unsigned byte_of(Color color, unsigned k) {
    return color >> (8 * k) & 255;
}

// The linear function with the values v at the corners.
LinearFunction through(const std::array<double, 3>& x, const std::array<double, 3>& y, const std::array<double, 3>& v,
                       double twice_area) {
    LinearFunction f;
    f.by_x = ((v[1] - v[0]) * (y[2] - y[0]) - (v[2] - v[0]) * (y[1] - y[0])) / twice_area;
    f.by_y = ((v[2] - v[0]) * (x[1] - x[0]) - (v[1] - v[0]) * (x[2] - x[0])) / twice_area;
    f.at_origin = v[0] - f.by_x * x[0] - f.by_y * y[0];
    return f;
}

class Raster {
public:
    Raster(const Scene& scene, ThreadPool& pool) : scene_(scene), pool_(pool) {}

    std::vector<std::uint8_t> draw() {
        const View& view = scene_.view;
        light_ = -0.38 * view.right + 0.72 * view.up + 0.58 * view.back;  // the three sides of a box differ
        set_up_triangles();
        bin();
        surfaces_.resize(std::size_t{scene_.width} * scene_.height);
        open_.assign(surfaces_.size(), 255);
        pixels_.resize(4 * surfaces_.size());
        over_tiles([this](std::size_t tile, Samples& of_tile) { find_surfaces(tile, of_tile); });
        if (scene_.occlusion_radius > 0) {
            set_up_spirals();
            over_tiles([this](std::size_t tile, Samples&) { find_open_parts(tiles_[tile]); });
        }
        over_tiles([this](std::size_t tile, Samples& of_tile) { color(tile, of_tile); });
        return std::move(pixels_);
    }

private:
    template <class Task>
    void over_tiles(const Task& task) {
        std::vector<Samples> scratch(pool_.size());
        pool_.run(tiles_.size(), [&](std::size_t tile, unsigned worker) { task(tile, scratch[worker]); });
    }

    void set_up_triangles() {
        solid_count_ = scene_.solid.size() / 3;
        const std::size_t count = solid_count_ + scene_.flat.size() / 3;
        triangles_.resize(count);
        constexpr std::size_t block = 4096;
        pool_.run((count + block - 1) / block, [&](std::size_t b, unsigned) {
            for (std::size_t t = b * block; t < std::min(count, (b + 1) * block); ++t) {
                triangles_[t] = t < solid_count_ ? set_up(&scene_.solid[3 * t], false)
                                                 : set_up(&scene_.flat[3 * (t - solid_count_)], true);
            }
        });
    }

    // Returns a triangle of three equal corners for one that cannot be seen.
    [[nodiscard]] Triangle set_up(const FillVertex* corners, bool flat) const {
        std::array<double, 3> x{}, y{}, nearness{}, edge{};
        Triangle t;
        for (std::size_t k = 0; k < 3; ++k) {
            const FillVertex& v = corners[k];
            const Vec3 p{v.position[0], v.position[1], v.position[2]};
            edge[k] = v.edge;
            if (flat) {
                x[k] = p[0], y[k] = p[1];
            } else {
                const View& view = scene_.view;
                const double away = view.distance - dot(view.back, p);
                if (!(away > view.near)) return {};  // beside the camera
                nearness[k] = 1 / away;
                x[k] = view.middle[0] + view.focal * dot(view.right, p) * nearness[k];
                y[k] = view.middle[1] - view.focal * dot(view.up, p) * nearness[k];
                edge[k] *= nearness[k];
            }
            constexpr double farthest = 1 << 20;  // pixels: products of units stay below 2^60
            if (!(std::abs(x[k]) < farthest) || !(std::abs(y[k]) < farthest)) return {};
            t.x[k] = std::llround(x[k] * units);
            t.y[k] = std::llround(y[k] * units);
        }
        const std::int64_t area = (t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - (t.x[2] - t.x[0]) * (t.y[1] - t.y[0]);
        const double twice_area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        if (area == 0 || twice_area == 0) return {};
        if (area < 0) {
            std::swap(t.x[1], t.x[2]);
            std::swap(t.y[1], t.y[2]);
        }
        if (!flat) t.nearness = through(x, y, nearness, twice_area);
        t.edge = through(x, y, edge, twice_area);
        t.has_lines =
            scene_.edge_width > 0 && (corners[0].edge != corners[1].edge || corners[0].edge != corners[2].edge);
        for (std::size_t k = 0; k < 3; ++k) t.normal[k] = corners[0].normal[k];
        const double length = std::sqrt(dot(t.normal, t.normal));
        if (length > 0) t.normal = (1 / length) * t.normal;
        t.color = corners[0].color;
        return t;
    }

    // The range of tiles that a range of pixels may touch; empty when it lies outside.
    struct Range {
        std::size_t begin, end;
    };
    [[nodiscard]] static Range tiles_of(double lowest, double highest, std::uint32_t size) {
        if (!(highest >= 0) || !(lowest < size)) return {0, 0};
        const auto first = static_cast<std::size_t>(std::max(0.0, lowest)) / tile_size;
        const auto last = static_cast<std::size_t>(std::min<double>(highest, size - 1)) / tile_size;
        return {first, last + 1};
    }

    // Makes the tiles, and of each the lists of triangles and strokes that it may show, in their order.
    void bin() {
        const std::size_t columns = (scene_.width + tile_size - 1) / tile_size;
        for (std::uint32_t top = 0; top < scene_.height; top += tile_size)
            for (std::uint32_t left = 0; left < scene_.width; left += tile_size)
                tiles_.push_back(
                    {left, top, std::min(left + tile_size, scene_.width), std::min(top + tile_size, scene_.height)});
        of_tiles_.resize(tiles_.size());
        strokes_of_tiles_.resize(tiles_.size());
        const auto add = [&](std::vector<std::vector<std::uint32_t>>& lists, std::size_t item, Range across,
                             Range down) {
            for (std::size_t row = down.begin; row < down.end; ++row)
                for (std::size_t column = across.begin; column < across.end; ++column)
                    lists[row * columns + column].push_back(static_cast<std::uint32_t>(item));
        };
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            const Triangle& t = triangles_[i];
            const auto [x0, x1] = std::minmax({t.x[0], t.x[1], t.x[2]});
            const auto [y0, y1] = std::minmax({t.y[0], t.y[1], t.y[2]});
            if (x0 == x1 || y0 == y1) continue;
            const auto pixel = [](std::int64_t u) { return static_cast<double>(u) / units; };
            add(of_tiles_, i, tiles_of(pixel(x0), pixel(x1), scene_.width),
                tiles_of(pixel(y0), pixel(y1), scene_.height));
        }
        for (std::size_t i = 0; i < scene_.strokes.size(); ++i) {
            const Stroke& s = scene_.strokes[i];
            const double room = s.half_width + 1;
            const auto [x0, x1] = std::minmax(s.from[0], s.to[0]);
            const auto [y0, y1] = std::minmax(s.from[1], s.to[1]);
            add(strokes_of_tiles_, i, tiles_of(x0 - room, x1 + room, scene_.width),
                tiles_of(y0 - room, y1 + room, scene_.height));
        }
    }

    // Finds the nearest triangle in each sample of a tile.
    void rasterize(std::size_t tile, Samples& out) const {
        const Tile& area = tiles_[tile];
        out.clear(area.size());
        for (const std::uint32_t t : of_tiles_[tile])
            for (std::size_t s = 0; s < samples; ++s) rasterize(t, area, s, out);
    }

    void rasterize(std::uint32_t index, const Tile& area, std::size_t s, Samples& out) const {
        const Triangle& t = triangles_[index];
        // Pixels whose sample may lie inside.
        const auto range = [](const std::array<std::int64_t, 3>& c, std::int64_t sample, std::uint32_t low,
                              std::uint32_t high) {
            const auto [least, largest] = std::minmax({c[0], c[1], c[2]});
            const std::int64_t middle = units / 2 + sample;
            const auto pixel = [&](std::int64_t u) { return (u - middle) >> 8; };
            return std::pair{std::max<std::int64_t>(low, pixel(least)),
                             std::min<std::int64_t>(std::int64_t{high} - 1, pixel(largest) + 1)};
        };
        static_assert(units == 1 << 8);
        const auto [x_first, x_last] = range(t.x, sample_x[s], area.left, area.right);
        const auto [y_first, y_last] = range(t.y, sample_y[s], area.top, area.bottom);
        if (x_first > x_last || y_first > y_last) return;
        const std::int64_t x0 = x_first * units + units / 2 + sample_x[s],
                           y0 = y_first * units + units / 2 + sample_y[s];
        // Each side is a function that is not negative inside. A sample on a side belongs to the triangle where the
        // side is the left or an upper one.
        std::array<std::int64_t, 3> value{}, by_x{}, by_y{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t next = (k + 1) % 3;
            const std::int64_t dx = t.x[next] - t.x[k], dy = t.y[next] - t.y[k];
            const bool owns = dy < 0 || (dy == 0 && dx > 0);
            value[k] = dx * (y0 - t.y[k]) - dy * (x0 - t.x[k]) - (owns ? 0 : 1);
            by_x[k] = -dy * units;
            by_y[k] = dx * units;
        }
        const double px = static_cast<double>(x0) / units, py = static_cast<double>(y0) / units;
        const bool flat = index >= solid_count_;
        std::int32_t* const triangles = out.triangle[s].data();
        float* const nearest = out.nearness[s].data();
        for (std::int64_t y = y_first; y <= y_last; ++y) {
            auto [a, b, c] = value;
            std::size_t at =
                static_cast<std::size_t>(y - area.top) * area.width() + static_cast<std::size_t>(x_first - area.left);
            const double row = t.nearness.at(px, py + static_cast<double>(y - y_first));
            for (std::int64_t x = x_first; x <= x_last; ++x, ++at) {
                if ((a | b | c) >= 0) {
                    const auto near = static_cast<float>(row + t.nearness.by_x * static_cast<double>(x - x_first));
                    if (flat) {
                        nearest[at] = std::numeric_limits<float>::max();
                        triangles[at] = static_cast<std::int32_t>(index);
                    } else if (near > nearest[at]) {
                        nearest[at] = near;
                        triangles[at] = static_cast<std::int32_t>(index);
                    }
                }
                a += by_x[0];
                b += by_x[1];
                c += by_x[2];
            }
            for (std::size_t k = 0; k < 3; ++k) value[k] += by_y[k];
        }
    }

    [[nodiscard]] std::size_t pixel(std::uint32_t x, std::uint32_t y) const {
        return std::size_t{y} * scene_.width + x;
    }

    void find_surfaces(std::size_t tile, Samples& of_tile) {
        rasterize(tile, of_tile);
        const Tile& area = tiles_[tile];
        std::size_t at = 0;
        for (std::uint32_t y = area.top; y < area.bottom; ++y) {
            for (std::uint32_t x = area.left; x < area.right; ++x, ++at) {
                const std::int32_t t = of_tile.triangle[0][at];
                if (t < 0 || static_cast<std::size_t>(t) >= solid_count_) continue;
                surfaces_[pixel(x, y)] = {t, 1 / of_tile.nearness[0][at]};
            }
        }
    }

    // Offsets of the samples of occlusion, in units of the reach: a spiral by the golden angle, which never lines up,
    // turned by another angle in each pixel of a block of 4 x 4, over which the light is then averaged.
    void set_up_spirals() {
        constexpr double turn = std::numbers::pi * (3 - 2.2360679774997896964);
        for (std::uint32_t step = 0; step < spirals_.size(); ++step) {
            for (std::size_t i = 0; i < occlusion_samples; ++i) {
                const double angle = step * std::numbers::pi / 8 + turn * static_cast<double>(i);
                const double along = (static_cast<double>(i) + 0.5) / occlusion_samples;
                spirals_[step][i] = {along * std::cos(angle), along * std::sin(angle)};
            }
        }
    }

    // Where the pixel's surface lies: right, down and away from the camera.
    [[nodiscard]] Vec3 place(double x, double y, double away) const {
        const View& view = scene_.view;
        const double scale = away / view.focal;
        return {(x - view.middle[0]) * scale, (y - view.middle[1]) * scale, away};
    }

    void find_open_parts(const Tile& area) {
        constexpr double bias = 0.12;  // cosine that flat surfaces reach by rounding
        constexpr double max_pixels = 160;
        const View& view = scene_.view;
        const double radius = scene_.occlusion_radius;
        for (std::uint32_t y = area.top; y < area.bottom; ++y) {
            for (std::uint32_t x = area.left; x < area.right; ++x) {
                const Surface& here = surfaces_[pixel(x, y)];
                if (here.triangle == no_triangle) continue;
                const Vec3& n = triangles_[static_cast<std::size_t>(here.triangle)].normal;
                const Vec3 normal{dot(view.right, n), -dot(view.up, n), -dot(view.back, n)};
                const Vec3 from = place(x, y, here.away);
                const double reach = std::min(radius * view.focal / here.away, max_pixels);
                double hidden = 0;
                for (const auto& [dx, dy] : spirals_[((x & 3) * 4 + ((y & 3) * 7 & 15)) & 15]) {
                    const auto to_x =
                        std::clamp<long>(static_cast<long>(x) + std::lround(reach * dx), 0, scene_.width - 1L);
                    const auto to_y =
                        std::clamp<long>(static_cast<long>(y) + std::lround(reach * dy), 0, scene_.height - 1L);
                    const Surface& there =
                        surfaces_[pixel(static_cast<std::uint32_t>(to_x), static_cast<std::uint32_t>(to_y))];
                    if (there.triangle == no_triangle) continue;
                    const Vec3 to = place(static_cast<double>(to_x), static_cast<double>(to_y), there.away) - from;
                    const double square = dot(to, to);
                    if (square == 0 || square >= radius * radius) continue;
                    hidden +=
                        (1 - square / (radius * radius)) * std::max(0.0, dot(to, normal) / std::sqrt(square) - bias);
                }
                const double open = std::clamp(1 - 1.7 * hidden / occlusion_samples, 0.0, 1.0);
                open_[pixel(x, y)] = static_cast<std::uint8_t>(std::lround(255 * open));
            }
        }
    }

    // The mean over a block of pixels, without those of other surfaces.
    [[nodiscard]] double open_part(std::uint32_t x, std::uint32_t y, double away) const {
        if (!(scene_.occlusion_radius > 0)) return 1;
        double sum = 0, weight = 0;
        for (long dy = -2; dy < 2; ++dy) {
            for (long dx = -2; dx < 2; ++dx) {
                const auto near_x = static_cast<std::uint32_t>(std::clamp<long>(x + dx, 0, scene_.width - 1L));
                const auto near_y = static_cast<std::uint32_t>(std::clamp<long>(y + dy, 0, scene_.height - 1L));
                const std::size_t at = pixel(near_x, near_y);
                if (surfaces_[at].triangle == no_triangle) continue;
                if (std::abs(surfaces_[at].away - away) > 0.1 * scene_.occlusion_radius) continue;
                sum += open_[at];
                weight += 255;
            }
        }
        return weight > 0 ? sum / weight : 1;
    }

    // The color of a triangle in a pixel; px, py: the middle of its samples there.
    [[nodiscard]] Rgba shade(const Triangle& t, double px, double py, std::uint32_t x, std::uint32_t y) const {
        double edge = t.edge.at(px, py), slope_x = t.edge.by_x, slope_y = t.edge.by_y, light = 1;
        const double nearness = t.nearness.at(px, py);
        if (nearness > 0) {
            edge /= nearness;
            slope_x = (slope_x - edge * t.nearness.by_x) / nearness;
            slope_y = (slope_y - edge * t.nearness.by_y) / nearness;
            const double direct = std::max(0.0, 0.4 + 0.6 * dot(t.normal, light_));  // it comes from an area
            const double around = 0.5 + 0.5 * t.normal[2], open = open_part(x, y, 1 / nearness);
            light = 0.60 * direct * (0.6 + 0.4 * open) + (0.42 + 0.16 * around) * open;
        }
        double line = 0;
        if (t.has_lines) {
            const double half_width = 0.5 * scene_.edge_width, slope = std::hypot(slope_x, slope_y);
            // `edge` falls from 1 to 0 over so many pixels. Lines fade where cells are as small as lines.
            const double size = slope > 0 ? 1 / slope : 0;
            const double presence = std::clamp(0.05 * size / half_width - 0.1, 0.0, 1.0);
            const double u = std::clamp((edge * size - (half_width - 0.5)) / 1.1, 0.0, 1.0);
            line = presence * (1 - u * u * (3 - 2 * u));
        }
        const double darkened = 1 - 0.85 * 0.84 * line;
        std::array<double, 3> c{};
        for (unsigned k = 0; k < 3; ++k) {
            c[k] = byte_of(t.color, k) / 255.0;
            if (nearness > 0) c[k] = encoded(std::min(1.0, decode(byte_of(t.color, k)) * light));
            c[k] *= darkened;
        }
        const double a = byte_of(t.color, 3) / 255.0;
        return {c[0] * a, c[1] * a, c[2] * a, a};
    }

    void color(std::size_t tile, Samples& of_tile) {
        rasterize(tile, of_tile);
        const Tile& area = tiles_[tile];
        std::vector<Rgba> colors(area.size());
        const auto channel = [&](std::size_t k) { return scene_.background[k] / 255.0; };
        const Rgba empty{channel(0) * channel(3), channel(1) * channel(3), channel(2) * channel(3), channel(3)};
        std::size_t at = 0;
        for (std::uint32_t y = area.top; y < area.bottom; ++y)
            for (std::uint32_t x = area.left; x < area.right; ++x, ++at) colors[at] = mix(of_tile, at, x, y, empty);
        for (const std::uint32_t s : strokes_of_tiles_[tile]) cover(scene_.strokes[s], area, of_tile, colors);
        at = 0;
        for (std::uint32_t y = area.top; y < area.bottom; ++y)
            for (std::uint32_t x = area.left; x < area.right; ++x, ++at) write(colors[at], &pixels_[4 * pixel(x, y)]);
    }

    // Shades each triangle of a pixel once, as much as it has of the samples.
    [[nodiscard]] Rgba mix(const Samples& of_tile, std::size_t at, std::uint32_t x, std::uint32_t y,
                           const Rgba& empty) const {
        Rgba sum;
        unsigned done = 0;
        for (std::size_t s = 0; s < samples; ++s) {
            if (done >> s & 1) continue;
            const std::int32_t t = of_tile.triangle[s][at];
            double count = 0, px = 0, py = 0;
            for (std::size_t other = s; other < samples; ++other) {
                if (of_tile.triangle[other][at] != t) continue;
                done |= 1u << other;
                ++count;
                px += static_cast<double>(sample_x[other]);
                py += static_cast<double>(sample_y[other]);
            }
            const double share = count / samples;
            const Rgba c = t == no_triangle ? empty
                                            : shade(triangles_[static_cast<std::size_t>(t)],
                                                    x + 0.5 + px / count / units, y + 0.5 + py / count / units, x, y);
            sum = {sum.r + share * c.r, sum.g + share * c.g, sum.b + share * c.b, sum.a + share * c.a};
        }
        return sum;
    }

    // One over the distance from the camera at which View::project() gives the depth.
    [[nodiscard]] double nearness_of(double depth) const {
        const View& view = scene_.view;
        if (view.focal == 0 || depth <= 0) return std::numeric_limits<double>::infinity();
        return (1 - depth * (view.far - view.near) / view.far) / view.near;
    }

    // Draws a line with round ends and soft borders of one pixel. Lines thinner than a pixel are fainter instead.
    void cover(const Stroke& s, const Tile& area, const Samples& of_tile, std::vector<Rgba>& colors) const {
        const double x0 = s.from[0], y0 = s.from[1], dx = s.to[0] - x0, dy = s.to[1] - y0;
        const double square = dx * dx + dy * dy;
        const double half = std::max<double>(s.half_width, 0.5), strength = std::min(1.0, s.half_width / half);
        const double alpha = strength * byte_of(s.color, 3) / 255.0;
        const double room = half + 1;
        const auto [left, right] = std::minmax({x0, x0 + dx});
        const auto [top, bottom] = std::minmax({y0, y0 + dy});
        const auto first = [](double at, std::uint32_t low) { return std::max<double>(low, std::floor(at)); };
        const auto x_first = static_cast<std::uint32_t>(first(left - room, area.left));
        const auto y_first = static_cast<std::uint32_t>(first(top - room, area.top));
        for (std::uint32_t y = y_first; y < area.bottom && y <= bottom + room; ++y) {
            for (std::uint32_t x = x_first; x < area.right && x <= right + room; ++x) {
                const double px = x + 0.5 - x0, py = y + 0.5 - y0;
                const double along = square > 0 ? std::clamp((px * dx + py * dy) / square, 0.0, 1.0) : 0;
                const double away = std::hypot(px - along * dx, py - along * dy);
                const double covered = std::clamp(half + 0.5 - away, 0.0, 1.0) * alpha;
                if (!(covered > 0)) continue;
                const std::size_t at = std::size_t{y - area.top} * area.width() + (x - area.left);
                const double nearness = nearness_of(std::lerp<double>(s.from[2], s.to[2], along));
                double seen = 0;
                for (std::size_t k = 0; k < samples; ++k) seen += of_tile.nearness[k][at] <= nearness;
                const double a = covered * seen / samples;
                Rgba& c = colors[at];
                c = {std::lerp(c.r, byte_of(s.color, 0) / 255.0, a), std::lerp(c.g, byte_of(s.color, 1) / 255.0, a),
                     std::lerp(c.b, byte_of(s.color, 2) / 255.0, a), std::lerp(c.a, 1.0, a)};
            }
        }
    }

    static void write(const Rgba& c, std::uint8_t* out) {
        const double by = c.a > 0 ? 255 / c.a : 0;
        const double channels[4] = {c.r * by, c.g * by, c.b * by, 255 * c.a};
        for (std::size_t k = 0; k < 4; ++k)
            out[k] = static_cast<std::uint8_t>(std::lround(std::clamp(channels[k], 0.0, 255.0)));
    }

    static constexpr std::size_t occlusion_samples = 20;

    const Scene& scene_;
    ThreadPool& pool_;
    Vec3 light_{};
    std::vector<Triangle> triangles_;  // of the solid, then the flat ones
    std::size_t solid_count_ = 0;
    std::vector<Tile> tiles_;
    std::vector<std::vector<std::uint32_t>> of_tiles_, strokes_of_tiles_;
    std::vector<Surface> surfaces_;   // of all pixels
    std::vector<std::uint8_t> open_;  // how much of the light from all around reaches the pixel, 255: all
    std::array<std::array<std::array<double, 2>, occlusion_samples>, 16> spirals_{};
    std::vector<std::uint8_t> pixels_;
};

}  // namespace

std::vector<std::uint8_t> draw(const Scene& scene, ThreadPool& pool) {
    return Raster(scene, pool).draw();
}

}  // namespace votess::picture
