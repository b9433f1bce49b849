// Pictures up to what is handed to the device: sections, scales, colors, text, which triangles.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/thread_pool.hpp"
#include "picture/colors.hpp"
#include "picture/legend/text.hpp"
#include "picture/mesh.hpp"
#include "picture/raster.hpp"
#include "picture/shown.hpp"
#include "picture/solid.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using namespace votess::picture;
using votess::cross;
using votess::Cut;
using votess::dot;
using votess::PictureOptions;
using votess::Tessellation;

Tessellation with_faces(const test::PointSet& set) {
    votess::Options options = test::all_options(set.box);
    options.want.faces = true;
    return votess::tessellate(set.points, options);
}

Mesh mesh_of(const Tessellation& t) {
    return {t.indptr(), t.indices(), t.shifts(), t.face_offsets(), t.face_vertices(), t.vertices()};
}

votess::ThreadPool& pool() {
    static votess::ThreadPool two(2);
    return two;
}

double area_of(const Polygon& polygon) {
    Vec3 sum{};
    for (std::size_t i = 2; i < polygon.corners.size(); ++i) {
        sum = sum + cross(polygon.corners[i - 1] - polygon.corners[0], polygon.corners[i] - polygon.corners[0]);
    }
    return 0.5 * std::sqrt(dot(sum, sum));
}

double area_of(const std::vector<FillVertex>& triangles) {
    double area = 0;
    for (std::size_t i = 0; i < triangles.size(); i += 3) {
        Polygon triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            const Floats& p = triangles[i + k].position;
            triangle.add({p[0], p[1], p[2]}, true);
        }
        area += area_of(triangle);
    }
    return area;
}

Scene scene_of(const test::PointSet& set, const Tessellation& t, const PictureOptions& options) {
    return build_scene(mesh_of(t), {t.box(), {}, {}}, set.points, t.volumes(), options, pool());
}

PictureOptions plain(Cut cut) {
    PictureOptions options;
    options.width = 400;
    options.height = 300;
    options.cut = cut;
    options.color_bar = options.frame = false;
    return options;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("picture: the sections of all cells fill the plane") {
        for (const auto& set : {test::uniform(300, 5), test::cubic(5), test::clustered(300, 6)}) {
            const Tessellation t = with_faces(set);
            const votess::Box& box = t.box();
            for (int axis = 0; axis < 3; ++axis) {
                const auto k = static_cast<std::size_t>(axis);
                // The second one goes through seeds and vertices of the lattice.
                for (const double part : {0.37, 0.5, 0.999}) {
                    const CutPlane plane{axis, std::lerp(box.lower[k], box.upper[k], part), 1};
                    double sum = 0, whole = 1;
                    for (std::size_t other = 0; other < 3; ++other)
                        if (other != k) whole *= box.upper[other] - box.lower[other];
                    Polygon polygon;
                    for (std::size_t i = 0; i < t.size(); ++i) {
                        section(mesh_of(t), i, plane, polygon);
                        for (const Vec3& corner : polygon.corners) CHECK(corner[k] == plane.value);
                        sum += area_of(polygon);
                    }
                    CAPTURE(set.name);
                    CHECK(sum == doctest::Approx(whole).epsilon(1e-10));
                }
            }
        }
    }

    TEST_CASE("picture: a clipped polygon's two parts make the whole, with lines only where it had them") {
        test::Random random(7);
        for (int round = 0; round < 200; ++round) {
            Polygon polygon, front, behind;
            const std::size_t n = 3 + static_cast<std::size_t>(round) % 6;
            for (std::size_t i = 0; i < n; ++i) {
                const double angle = 6.28 * (static_cast<double>(i) + 0.3 * random.uniform()) / static_cast<double>(n);
                polygon.add({std::cos(angle), std::sin(angle), 0.5}, true);
            }
            const CutPlane plane{round % 2, random.uniform(-1.2, 1.2), round % 3 == 0 ? 1.0 : -1.0};
            clip(polygon, plane, false, false, front);
            clip(polygon, plane, true, false, behind);
            CHECK(area_of(front) + area_of(behind) == doctest::Approx(area_of(polygon)));
            for (const Vec3& p : front.corners) CHECK(plane.height(p) > -1e-12);
            for (const Vec3& p : behind.corners) CHECK(plane.height(p) < 1e-12);
            for (const Polygon* part : {&front, &behind}) {
                const bool cut = part->corners.size() > 0 && !front.corners.empty() && !behind.corners.empty();
                CHECK(std::count(part->line.begin(), part->line.end(), 0) == (cut ? 1 : 0));
            }
        }
    }

    TEST_CASE("picture: a cut box shows exactly its surface towards the camera") {
        const auto set = test::uniform(300, 8);
        const Tessellation t = with_faces(set);
        // The scene's box has sides of length 2. The notch has as much surface as the corner it replaces.
        CHECK(area_of(scene_of(set, t, plain(Cut::none)).solid) == doctest::Approx(12).epsilon(1e-5));
        CHECK(area_of(scene_of(set, t, plain(Cut::corner)).solid) == doctest::Approx(12).epsilon(1e-5));
        CHECK(area_of(scene_of(set, t, plain(Cut::half)).solid) == doctest::Approx(8).epsilon(1e-5));
        // Whole cells stick out, so there is more of it.
        CHECK(area_of(scene_of(set, t, plain(Cut::cells)).solid) > 12.5);

        PictureOptions off_center = plain(Cut::corner);
        off_center.cut_at = {0.25, 0.6, 0.7};
        off_center.azimuth = 200;  // the octant of low x and y now
        CHECK(area_of(scene_of(set, t, off_center).solid) == doctest::Approx(12).epsilon(1e-5));
    }

    TEST_CASE("picture: no edge of the box crosses the opening") {
        const auto set = test::uniform(50, 8);
        const Tessellation t = with_faces(set);
        DomainShape domain{t.box(), {}, {}};
        for (unsigned corner = 0; corner < 8; ++corner)
            domain.corners.push_back({corner & 1 ? 1.0 : 0.0, corner & 2 ? 1.0 : 0.0, corner & 4 ? 1.0 : 0.0});
        // Of twelve edges three are halved by the octant; eight are halved or removed by the half.
        const auto length_of = [&](Cut cut) {
            PictureOptions options = plain(cut);
            options.frame = true;
            double sum = 0;
            for (const Stroke& s : build_scene(mesh_of(t), domain, set.points, t.volumes(), options, pool()).strokes)
                sum += std::hypot(s.to[0] - s.from[0], s.to[1] - s.from[1]);
            return sum;
        };
        const double all = length_of(Cut::none), corner = length_of(Cut::corner), cells = length_of(Cut::cells);
        CHECK(corner < 0.92 * all);
        CHECK(corner > 0.8 * all);
        CHECK(cells == doctest::Approx(corner));
        CHECK(length_of(Cut::half) < 0.6 * all);
    }

    TEST_CASE("picture: triangles that share sides leave no gap, and cover their area") {
        test::Random random(14);
        for (int round = 0; round < 20; ++round) {
            // A rectangle, cut into a fan around a point inside.
            const float x[4] = {20.3f, 110.7f, 110.7f, 20.3f}, y[4] = {15.2f, 15.2f, 90.6f, 90.6f};
            const float mx = static_cast<float>(random.uniform(25, 105)),
                        my = static_cast<float>(random.uniform(20, 85));
            Scene scene;
            scene.width = 130;
            scene.height = 101;
            scene.edge_width = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                const std::size_t next = (k + 1) % 4;
                for (const auto& [px, py] : {std::pair{x[k], y[k]}, std::pair{x[next], y[next]}, std::pair{mx, my}}) {
                    FillVertex v{{px, py, 0}, {}, rgb(200, 100, 50), 1};
                    scene.flat.push_back(v);
                }
                if (round % 2 != 0) std::swap(scene.flat[3 * k], scene.flat[3 * k + 1]);
            }
            const auto pixels = draw(scene, pool());
            double covered = 0;
            for (std::uint32_t py = 0; py < scene.height; ++py) {
                for (std::uint32_t px = 0; px < scene.width; ++px) {
                    const std::uint8_t* p = &pixels[4 * (std::size_t{py} * scene.width + px)];
                    covered += p[3] / 255.0;
                    if (px > 20 && px < 110 && py > 15 && py < 90) CHECK((p[3] == 255 && p[0] == 200 && p[2] == 50));
                    if (px < 20 || px > 110 || py < 15 || py > 90) CHECK(p[3] == 0);
                }
            }
            CHECK(covered == doctest::Approx(90.4 * 75.4).epsilon(0.005));
        }
    }

    TEST_CASE("picture: the nearer of two triangles is seen, and strokes lie where their depth says") {
        Scene scene;
        scene.width = scene.height = 100;
        scene.background = {255, 255, 255, 255};
        scene.edge_width = 0;
        scene.view.focal = 100;
        scene.view.distance = 5;
        scene.view.middle = {50, 50};
        scene.view.near = 1;
        scene.view.far = 9;
        const auto add = [&](float z, Color color) {
            for (const auto& [px, py] : {std::pair{-2.f, -2.f}, std::pair{2.f, -2.f}, std::pair{0.f, 2.f}})
                scene.solid.push_back({{px, py, z}, {0, 0, 127, 0}, color, 1});
        };
        const auto middle = [&](std::size_t channel) {
            return int{draw(scene, pool())[4 * (50 * 100 + 50) + channel]};
        };
        add(0, rgb(255, 0, 0));
        add(1, rgb(0, 255, 0));
        add(-1, rgb(0, 0, 255));
        CHECK((middle(1) > 150 && middle(0) == 0 && middle(2) == 0));
        const auto depth = [&](double z) { return static_cast<float>(scene.view.project({0, 0, z})[2]); };
        scene.strokes.push_back({{40, 50, depth(0.5)}, {60, 50, depth(0.5)}, 4, rgb(0, 0, 0)});
        CHECK(middle(1) > 150);  // behind the green one
        scene.strokes.push_back({{40, 50, depth(1.5)}, {60, 50, depth(1.5)}, 4, rgb(9, 9, 9)});
        CHECK(middle(1) == 9);
    }

    TEST_CASE("picture: a slice of a periodic domain has no gaps and no overlaps") {
        votess::Options box = test::all_options(test::unit_box()), sheared = test::all_options();
        box.periodic = {true, true, true};
        sheared.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.5, 1}};
        const auto set = test::uniform(60, 12);
        for (votess::Options options : {box, sheared}) {
            options.want.faces = true;
            auto points = set.points;
            if (options.cell) {
                for (std::size_t i = 0; i < points.size(); i += 3) {
                    points[i] += 0.4 * points[i + 1] - 0.3 * points[i + 2];
                    points[i + 1] += 0.5 * points[i + 2];
                }
            }
            const Tessellation t = votess::tessellate(points, options);
            DomainShape domain{t.box(), {}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
            if (options.cell) domain.periods = {options.cell->a, options.cell->b, options.cell->c};
            for (int axis = 0; axis < 3; ++axis) {
                PictureOptions slice = plain(Cut::none);
                const auto k = static_cast<std::size_t>(axis);
                slice.slice = votess::Slice{axis, std::lerp(t.box().lower[k], t.box().upper[k], 0.03)};
                const Scene scene = build_scene(mesh_of(t), domain, points, t.volumes(), slice, pool());
                double low[2] = {1e9, 1e9}, high[2] = {0, 0};
                for (const FillVertex& v : scene.flat) {
                    for (std::size_t c = 0; c < 2; ++c) {
                        low[c] = std::min<double>(low[c], v.position[c]);
                        high[c] = std::max<double>(high[c], v.position[c]);
                    }
                }
                CHECK(area_of(scene.flat) == doctest::Approx((high[0] - low[0]) * (high[1] - low[1])).epsilon(1e-4));
            }
        }
    }

    TEST_CASE("picture: everything shown lies inside the picture") {
        const auto set = test::uniform(100, 9);
        const Tessellation t = with_faces(set);
        for (const double azimuth : {-170.0, -20.0, 36.0, 100.0}) {
            for (const double elevation : {-60.0, 0.0, 27.0, 89.0}) {
                PictureOptions options = plain(Cut::none);
                options.azimuth = azimuth;
                options.elevation = elevation;
                const Scene scene = scene_of(set, t, options);
                double lowest = 1e9, highest = -1e9;
                for (const FillVertex& v : scene.solid) {
                    const Vec3 p = scene.view.project({v.position[0], v.position[1], v.position[2]});
                    CHECK((p[0] > 0 && p[0] < scene.width && p[1] > 0 && p[1] < scene.height));
                    CHECK((p[2] > 0 && p[2] < 1));
                    lowest = std::min(lowest, p[1]);
                    highest = std::max(highest, p[1]);
                }
                CHECK(highest - lowest > 0.6 * scene.height);  // and fills it
            }
        }
    }

    TEST_CASE("picture: walls are left out where their cells dwarf the others") {
        votess::ThreadPool pool(2);
        const auto even = test::uniform(500, 10);
        const Tessellation t = with_faces(even);
        const Shown all = choose_cells(mesh_of(t), t.box(), votess::WallCells::automatic, pool);
        CHECK_FALSE(all.walls_hidden);
        CHECK(std::count(all.cells.begin(), all.cells.end(), 1) == 500);

        test::PointSet ball{"ball", {}, test::cube(-10, 10)};
        test::Random random(11);
        while (ball.size() < 2000) {
            const double p[3] = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < 1) ball.points.insert(ball.points.end(), p, p + 3);
        }
        const Tessellation b = with_faces(ball);
        const Shown inner = choose_cells(mesh_of(b), b.box(), votess::WallCells::automatic, pool);
        CHECK(inner.walls_hidden);
        CHECK(std::count(inner.cells.begin(), inner.cells.end(), 1) > 500);
        for (std::size_t k = 0; k < 3; ++k) CHECK((inner.bounds.lower[k] > -1.5 && inner.bounds.upper[k] < 1.5));
        CHECK_FALSE(choose_cells(mesh_of(b), b.box(), votess::WallCells::show, pool).walls_hidden);
    }

    TEST_CASE("picture: scales") {
        std::vector<double> values(1001);
        std::iota(values.begin(), values.end(), 1000.0);
        std::vector<char> shown(values.size(), 1);
        const Scale narrow = choose_scale(values, shown, {});
        CHECK_FALSE(narrow.logarithmic);
        CHECK(narrow.low == 1005);
        CHECK(narrow.high == 1995);
        CHECK((narrow.below && narrow.above));
        CHECK(narrow.at(1500) == doctest::Approx(0.5));

        for (double& v : values) v = std::pow(10, (v - 1500) / 100);  // 1e-5 to 1e5
        const Scale wide = choose_scale(values, shown, {});
        CHECK(wide.logarithmic);
        CHECK(wide.low == doctest::Approx(std::pow(10, -4.7)));
        CHECK(wide.at(std::sqrt(wide.low * wide.high)) == doctest::Approx(0.5));

        // Whole numbers in a narrow range have a color each, up to the ends of the map.
        std::vector<double> whole(700);
        for (std::size_t i = 0; i < whole.size(); ++i) whole[i] = static_cast<double>(10 + i % 7);
        const Scale discrete = choose_scale(whole, std::vector<char>(whole.size(), 1), {});
        CHECK(discrete.steps == 7);
        CHECK((discrete.low == 9.5 && discrete.high == 16.5));
        const auto seven = color_cells(whole, discrete, votess::Colormap::tide);
        for (std::size_t i = 0; i < 14; ++i)
            for (std::size_t j = 0; j < 14; ++j) CHECK((seven[i] == seven[j]) == (i % 7 == j % 7));
        for (const Tick& tick : discrete.ticks(20).marks) CHECK(tick.value == std::nearbyint(tick.value));
        whole[0] += 0.5;
        CHECK(choose_scale(whole, std::vector<char>(whole.size(), 1), {}).steps == 0);

        const std::vector<double> same(50, 3.5);
        const Scale one = choose_scale(same, std::vector<char>(50, 1), {});
        CHECK(one.at(3.5) == doctest::Approx(0.5));

        PictureOptions given;
        given.range = {{-1, 4}};
        given.scale = votess::ColorScale::logarithmic;
        CHECK_THROWS_AS(static_cast<void>(choose_scale(values, shown, given)), votess::Error);
        given.scale = votess::ColorScale::linear;
        CHECK(choose_scale(values, shown, given).high == 4);
    }

    TEST_CASE("picture: ticks are round, ordered and inside") {
        for (const bool logarithmic : {false, true}) {
            for (const double low : {1e-7, 0.03, 1.0, 123.0, 4.5e6}) {
                for (const double factor : {1.5, 4.0, 70.0, 1e4, 1e9}) {
                    const Scale scale{low, low * factor, logarithmic};
                    const Ticks ticks = scale.ticks(6);
                    const auto texts = std::count_if(ticks.marks.begin(), ticks.marks.end(),
                                                     [](const Tick& tick) { return !tick.text.empty(); });
                    CAPTURE(low);
                    CAPTURE(factor);
                    CHECK(texts >= 2);
                    CHECK(texts <= 8);
                    double before = -1;
                    for (const Tick& tick : ticks.marks) {
                        CHECK(tick.at > before);
                        CHECK((tick.at >= -1e-6 && tick.at <= 1 + 1e-6));
                        before = tick.at;
                    }
                }
            }
        }
        const Ticks small = Scale{2e-5, 9e-5, false}.ticks(6);
        CHECK(small.factor == "*10^-5");
        CHECK(small.marks.front().text == "2");
        const Ticks negative = Scale{-1, 1, false}.ticks(6);
        CHECK(negative.marks[2].text == "0.0");
        CHECK(Scale{0.5, 2000, true}.ticks(6).marks.back().text == "");  // 2000 between 1000 and 10000
    }

    TEST_CASE("picture: every printable character is drawn, inside its line") {
        const TextStyle style{.size = 20};
        for (char c = '!'; c <= '~'; ++c) {
            std::vector<Stroke> strokes;
            const std::string text = {'\\', c};
            draw_text(text, 100, 50, 0, style, strokes);
            CAPTURE(c);
            CHECK(strokes.size() >= 1);
            for (const Stroke& s : strokes) {
                for (const Floats& p : {s.from, s.to}) {
                    CHECK((p[0] >= 100 && p[0] <= 100 + text_width(text, style) + 0.01));
                    CHECK((p[1] >= 50 - 13 && p[1] <= 50 + 17));
                }
            }
        }
        CHECK(text_width("10^12", style) < text_width("1012", style));
        CHECK(text_width("", style) == 0);
        std::vector<Stroke> upwards;
        draw_text("volume", 100, 50, 0.5, {.size = 20, .upwards = true}, upwards);
        for (const Stroke& s : upwards) CHECK(std::abs(s.from[0] - 100) <= 17);
    }
}
