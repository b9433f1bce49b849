// Pictures as pixels.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <votess/diagram.hpp>

#include "picture/colors.hpp"
#include "picture/mesh.hpp"
#include "picture/solid.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"

namespace {

using votess::Cut;
using votess::Picture;
using votess::PictureOptions;
using votess::Tessellation;
using votess::picture::operator-;

Tessellation with_faces(const test::PointSet& set) {
    votess::Options options = test::all_options(set.box);
    options.want.faces = true;
    return votess::tessellate(set.points, options);
}

// Small, and only cells.
PictureOptions bare() {
    PictureOptions options;
    options.width = 320;
    options.height = 240;
    options.color_bar = options.frame = options.edges = false;
    return options;
}

struct Pixel {
    int r, g, b, a;
};

Pixel at(const Picture& picture, std::uint32_t x, std::uint32_t y) {
    const std::uint8_t* p = &picture.pixels[4 * (std::size_t{y} * picture.width + x)];
    return {p[0], p[1], p[2], p[3]};
}

template <class Condition>
std::size_t count(const Picture& picture, const Condition& condition) {
    std::size_t found = 0;
    for (std::uint32_t y = 0; y < picture.height; ++y)
        for (std::uint32_t x = 0; x < picture.width; ++x) found += condition(at(picture, x, y));
    return found;
}

std::size_t distinct_colors(const Picture& picture) {
    std::vector<int> colors;
    for (std::uint32_t y = 0; y < picture.height; ++y) {
        for (std::uint32_t x = 0; x < picture.width; ++x) {
            const Pixel p = at(picture, x, y);
            colors.push_back(p.r << 16 | p.g << 8 | p.b);
        }
    }
    std::sort(colors.begin(), colors.end());
    return static_cast<std::size_t>(std::unique(colors.begin(), colors.end()) - colors.begin());
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("pictures: a picture has its size, its background, many colors, and is the same each time") {
        const auto set = test::uniform(test::by_size(1000, 200), 21);
        const Tessellation t = with_faces(set);
        PictureOptions options;
        options.width = 500;
        options.height = 320;
        options.background = {250, 240, 230, 255};
        const Picture picture = votess::render(t, set.points, options);
        CHECK(picture.width == 500);
        CHECK(picture.height == 320);
        REQUIRE(picture.pixels.size() == 4u * 500 * 320);
        for (const std::uint32_t x : {0u, 499u}) {
            for (const std::uint32_t y : {0u, 319u}) {
                const Pixel p = at(picture, x, y);
                CHECK((p.r == 250 && p.g == 240 && p.b == 230 && p.a == 255));
            }
        }
        CHECK(distinct_colors(picture) > 2000);
        const auto background = count(picture, [](const Pixel& p) { return p.r == 250 && p.g == 240 && p.b == 230; });
        CHECK(background > 320u * 500 / 5);
        CHECK(background < 320u * 500 * 4 / 5);
        CHECK(votess::render(t, set.points, options).pixels == picture.pixels);
        options.threads = 1;
        CHECK(votess::render(t, set.points, options).pixels == picture.pixels);
    }

    TEST_CASE("pictures: in a slice every cell has the area of its section, in the color of its value") {
        const auto set = test::uniform(24, 22);
        const Tessellation t = with_faces(set);
        for (int axis = 0; axis < 3; ++axis) {
            PictureOptions options = bare();
            options.width = options.height = 400;
            options.slice = votess::Slice{axis, 0.45};
            std::vector<double> values(set.size());
            std::iota(values.begin(), values.end(), 0.0);
            options.values = values;
            options.range = {{0, 23}};
            const Picture picture = votess::render(t, set.points, options);

            // The square as it was placed: all that is not background.
            const std::size_t drawn =
                count(picture, [](const Pixel& p) { return !(p.r == 255 && p.g == 255 && p.b == 255); });
            const double side = std::sqrt(static_cast<double>(drawn));
            CHECK(side > 300);
            const votess::picture::Mesh mesh{t.indptr(),       t.indices(),       t.shifts(),
                                             t.face_offsets(), t.face_vertices(), t.vertices()};
            votess::picture::Polygon polygon;
            std::size_t cut = 0;
            for (std::size_t i = 0; i < set.size(); ++i) {
                votess::picture::section(mesh, i, {axis, 0.45, 1}, polygon);
                double area = 0, around = 0;
                const auto& corners = polygon.corners;
                for (std::size_t k = 0; k < corners.size(); ++k) {
                    const auto side_of = corners[(k + 1) % corners.size()] - corners[k];
                    around += std::sqrt(votess::dot(side_of, side_of));
                    if (k < 2) continue;
                    const auto twice = votess::cross(corners[k - 1] - corners[0], corners[k] - corners[0]);
                    area += 0.5 * std::sqrt(votess::dot(twice, twice));
                }
                const votess::picture::Color c = votess::picture::map_color(options.colormap, values[i] / 23);
                const std::size_t found = count(picture, [&](const Pixel& p) {
                    return std::abs(p.r - static_cast<int>(c & 255)) <= 2 &&
                           std::abs(p.g - static_cast<int>(c >> 8 & 255)) <= 2 &&
                           std::abs(p.b - static_cast<int>(c >> 16 & 255)) <= 2;
                });
                CAPTURE(i);
                // Pixels that a border crosses are mixtures, which may have the color of a third cell.
                CHECK(std::abs(static_cast<double>(found) - area * side * side) <= around * side + 24);
                cut += !corners.empty();
            }
            CHECK(cut > 5);
        }
    }

    TEST_CASE("pictures: a cut shows the inside") {
        const auto set = test::uniform(test::by_size(1000, 300), 23);
        const Tessellation t = with_faces(set);
        PictureOptions options = bare();
        options.background = {0, 0, 0, 0};
        options.colormap = votess::Colormap::gray;
        options.range = {{0, 1}};
        // Cells inside are nearly white, those at the walls dark.
        std::vector<double> inside(set.size(), 1);
        for (std::size_t i = 0; i < set.size(); ++i)
            for (const auto j : t.neighbors(i))
                if (j < 0) inside[i] = 0;
        options.values = inside;
        const auto bright = [](const Pixel& p) { return p.g > 110; };
        const auto drawn = [](const Pixel& p) { return p.a > 0; };
        options.cut = Cut::none;
        const Picture whole = votess::render(t, set.points, options);
        CHECK(count(whole, bright) == 0);
        for (const Cut cut : {Cut::corner, Cut::half, Cut::cells}) {
            options.cut = cut;
            const Picture open = votess::render(t, set.points, options);
            CHECK(count(open, bright) > count(open, drawn) / 12);
            // Corner and cells leave the outline of the box as it is.
            if (cut == Cut::corner) CHECK(count(open, drawn) == count(whole, drawn));
        }
        // What was the nearest corner of the box is seen in the middle of the notch.
        options.cut = Cut::corner;
        const Picture open = votess::render(t, set.points, options);
        CHECK(bright(at(open, open.width / 2, open.height / 2)));
        CHECK_FALSE(bright(at(whole, whole.width / 2, whole.height / 2)));
    }

    TEST_CASE("pictures: pictures of few, tied, clustered and ragged seeds") {
        for (const auto& set :
             {test::uniform(1, 25), test::uniform(2, 26), test::cubic(4), test::fcc(3), test::clustered(200, 27),
              test::with_duplicates(100, 20, 28), test::on_sphere(150, 29), test::far_from_origin(100, 30)}) {
            const Tessellation t = with_faces(set);
            CAPTURE(set.name);
            for (const Cut cut : {Cut::corner, Cut::half, Cut::cells}) {
                PictureOptions options = bare();
                options.cut = cut;
                options.edges = options.frame = options.color_bar = true;
                const Picture picture = votess::render(t, set.points, options);
                CHECK(count(picture, [](const Pixel& p) { return p.r != 255; }) > 2000);
            }
            PictureOptions options = bare();
            const auto& box = t.box();
            options.slice = votess::Slice{1, 0.4 * box.lower[1] + 0.6 * box.upper[1]};
            options.seeds = true;
            CHECK(count(votess::render(t, set.points, options), [](const Pixel& p) { return p.r != 255; }) > 2000);
        }
    }

    TEST_CASE("pictures: what a picture cannot be made of is refused, with the reason") {
        const auto set = test::uniform(20, 31);
        const Tessellation t = with_faces(set);
        const auto message = [&](const Tessellation& cells, const PictureOptions& options) {
            std::string text;
            CHECK(test::error_of([&] { static_cast<void>(votess::render(cells, set.points, options)); }, &text) ==
                  votess::ErrorCode::invalid_argument);
            return text;
        };
        const auto names = [](const std::string& text, const char* word) {
            CAPTURE(text);
            CHECK(text.find(word) != std::string::npos);
        };
        const Tessellation lists = votess::tessellate(set.points, test::all_options(set.box));
        names(message(lists, bare()), "Options::want.faces");
        votess::ProbeOptions of_probes;
        of_probes.want.faces = true;
        names(message(votess::Diagram(set.points).probe(set.points, of_probes), bare()), "cells of probes");
        PictureOptions options = bare();
        options.width = 20;
        names(message(t, options), "width = 20");
        options = bare();
        options.slice = votess::Slice{2, 1.5};
        names(message(t, options), "z = 1.5");
        options.slice = votess::Slice{3, 0.5};
        names(message(t, options), "axis 3");
        options = bare();
        const std::vector<double> few(19, 1.0);
        options.values = few;
        names(message(t, options), "19 values for 20 cells");
        options = bare();
        options.range = {{2, 1}};
        names(message(t, options), "range 2 to 1");
        options = bare();
        options.elevation = 90;
        names(message(t, options), "90");
        options = bare();
        options.azimuth = std::numeric_limits<double>::infinity();
        names(message(t, options), "inf");
        options = bare();
        const std::vector<double> moved(set.points.begin(), set.points.end() - 3);
        CHECK(test::error_of([&] { static_cast<void>(votess::render(t, moved, bare())); }) ==
              votess::ErrorCode::invalid_argument);
        CHECK(test::error_of([&] { static_cast<void>(votess::render({}, {}, bare())); }) ==
              votess::ErrorCode::invalid_argument);
    }

    TEST_CASE("pictures: values whose range exceeds the largest double") {
        const std::vector<double> points{0.2, 0.5, 0.5, 0.5, 0.5, 0.5, 0.8, 0.5, 0.5};
        votess::Options run = test::all_options(test::unit_box());
        run.want.faces = true;
        const votess::Tessellation t = votess::tessellate(points, run);
        for (const std::vector<double>& values : {std::vector{-1e308, 0.0, 1e308}, std::vector{5e-324, 1.0, 1e308}}) {
            PictureOptions options;
            options.width = options.height = 64;
            options.values = values;
            const std::vector<std::uint8_t> colors = votess::value_colors(options);
            std::set<std::vector<std::uint8_t>> distinct;
            for (int i = 0; i < 3; ++i) distinct.insert({colors.begin() + 3 * i, colors.begin() + 3 * i + 3});
            CHECK(distinct.size() == 3);
            CHECK(votess::render(t, points, options).pixels.size() == std::size_t{4} * 64 * 64);
        }
    }

    TEST_CASE("pictures: pieces of cells in a mesh") {
        const test::Solid unit = test::cuboid(0, 1);
        votess::Options run = test::all_options(test::cube(-1, 2));
        run.want = {};
        run.mesh = unit.mesh();
        // Four columns; the nearest one to the camera is cut away, so that inner faces show.
        const std::vector<double> points{0.25, 0.25, 0.5, 0.75, 0.25, 0.5, 0.25, 0.75, 0.5, 0.75, 0.75, 0.5};
        const votess::Tessellation cells = votess::tessellate(points, run);
        votess::Pieces pieces = votess::pieces(cells);
        PictureOptions options = bare();
        options.cut = Cut::none;
        const std::vector<double> values{0, 1, 2, 3};
        options.values = values;
        options.azimuth = 45;
        const auto shown = [](const Pixel& p) { return p.r != 255 || p.g != 255 || p.b != 255; };
        const Picture whole = votess::render(pieces, options);
        CHECK(count(whole, shown) > 10000);
        CHECK(votess::render(cells, points, options).pixels == whole.pixels);
        options.gap = 0.2;
        CHECK(votess::render(cells, points, options).pixels !=
              votess::render(votess::pieces(cells, {.gap = 0.1}), options).pixels);
        CHECK(votess::render(cells, points, options).pixels ==
              votess::render(votess::pieces(cells, {.gap = 0.2}), options).pixels);
        options.gap = 0;
        options.edges = true;
        CHECK(votess::render(pieces, options).pixels != whole.pixels);
        options.edges = false;
        options.cut = Cut::half;  // along x, the nearer of two axes: the columns of larger x
        const Picture half = votess::render(pieces, options);
        CHECK(count(half, shown) > 5000);
        CHECK(count(half, shown) < count(whole, shown));
        options.slice = votess::Slice{2, 0.5};
        const Picture section = votess::render(pieces, options);
        CHECK(count(section, shown) > 5000);
        CHECK(section.pixels != half.pixels);
        options.seeds = true;
        CHECK(test::error_of([&] { (void)votess::render(pieces, options); }) == votess::ErrorCode::invalid_argument);
        options.seeds = false;
        options.slice->value = 1.5;
        CHECK(test::error_of([&] { (void)votess::render(pieces, options); }) == votess::ErrorCode::invalid_argument);
        options.slice.reset();
        options.values = std::span(values).first(3);
        CHECK(test::error_of([&] { (void)votess::render(pieces, options); }) == votess::ErrorCode::invalid_argument);
        CHECK(test::error_of([&] { (void)votess::render(votess::Pieces{}, bare()); }) ==
              votess::ErrorCode::invalid_argument);
    }
}
