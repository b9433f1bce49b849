// Bad input: a one-line error that names the first offending index and its value, and nothing else happens.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <type_traits>

#include "input/each_option.hpp"
#include "polytope/cell_kernels.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

// The message of the error, "" when there was none; one line with this code, or the test fails.
std::string refusal(const test::Coordinates& points, const votess::Options& options = {},
                    votess::ErrorCode code = votess::ErrorCode::invalid_argument) {
    try {
        const auto t = votess::tessellate(points, options);
        return "";
    } catch (const votess::Error& error) {
        const std::string message = error.what();
        CHECK(error.code() == code);
        CHECK(message.find('\n') == std::string::npos);
        return message;
    }
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

votess::Options boxed(const votess::Box& box) {
    votess::Options options;
    options.box = box;
    return options;
}

}  // namespace

TEST_SUITE("api") {
    TEST_CASE("a coordinate that is not finite") {
        for (const auto& [value, name] :
             {std::pair{not_a_number, "nan"}, std::pair{infinity, "inf"}, std::pair{-infinity, "-inf"}}) {
            for (const bool with_box : {false, true}) {
                test::Coordinates points = test::uniform(300, 71).points;
                points[3 * 217 + 1] = value;
                points[3 * 290] = not_a_number;  // not the first
                const auto message = refusal(points, with_box ? boxed(test::unit_box()) : votess::Options{});
                CAPTURE(message);
                CHECK(has(message, "217"));
                CHECK(has(message, name));
                CHECK_FALSE(has(message, "290"));
            }
        }
        const float narrow[] = {0, 0, 0, 1, std::numeric_limits<float>::infinity(), 0};
        CHECK_THROWS_AS((void)votess::tessellate(std::span<const float>(narrow)), votess::Error);
    }

    TEST_CASE("how far a seed is outside, and of what") {
        const auto distance_in = [](const std::string& message) {
            const auto at = message.find(", by ");
            return at == std::string::npos ? -1 : std::stod(message.substr(at + 5));
        };
        test::Random random(17);
        for (int run = 0; run < 60; ++run) {
            const double scale = std::ldexp(1, static_cast<int>(random.below(800)) - 400);
            const double beyond = scale * std::ldexp(random.uniform(0.5, 1), -static_cast<int>(random.below(30)));
            const auto axis = static_cast<std::size_t>(random.below(3));
            const double sign = random.below(2) == 0 ? -1 : 1;
            // Box -scale..scale.
            test::Coordinates points(9, 0.25 * scale);
            points[3] = points[7] = -0.5 * scale;
            points[6 + axis] = sign * (scale + beyond);
            votess::Options options = boxed(test::cube(-scale, scale));
            std::string message = refusal(points, options);
            CAPTURE(message);
            CHECK(has(message, "point 2: " + std::string(1, "xyz"[axis]) + " = "));
            CHECK(distance_in(message) == doctest::Approx(beyond).epsilon(0.01));
            CHECK(has(message, "outside = drop"));
            // The same box as a cell.
            options.box.reset();
            options.cell = {{-scale, -scale, -scale}, {2 * scale, 0, 0}, {0, 2 * scale, 0}, {0, 0, 2 * scale}, {}};
            message = refusal(points, options);
            CHECK(has(message, "wall " + std::to_string(-1 - 2 * static_cast<int>(axis) - (sign > 0)) + ")"));
            CHECK(distance_in(message) == doctest::Approx(beyond).epsilon(0.01));
            // Walls whose normals have the length 7.
            options = {};
            options.walls = {{{-1, 0, 0}, 2 * scale}, {{2, 3, -6}, 7 * scale}, {{-2, -3, 6}, 7 * scale}};
            for (std::size_t k = 0; k < 3; ++k)
                points[6 + k] = sign * options.walls[1].normal[k] / 7 * (scale + beyond);
            message = refusal(points, options);
            CHECK(has(message, sign > 0 ? "wall 1 (2 x + 3 y + -6 z <= " : "wall 2 (-2 x + -3 y + 6 z <= "));
            CHECK(has(message, sign > 0 ? ", -8 in lists)" : ", -9 in lists)"));
            CHECK(distance_in(message) == doctest::Approx(beyond).epsilon(0.01));
        }
        // Beyond a wall by less than rounding shows: 3 times 0.1 is more than 0.3.
        votess::Options options = boxed(test::unit_box());
        options.walls = {{{3, 0, 0}, 0.3}};
        CHECK(has(refusal({0.1, 0.5, 0.5}, options), ", by less than "));
        CHECK(distance_in(refusal({-1e308, 0, 0, 1e308, 0, 0}, boxed(test::cube(-1e308, 0.9e308)))) > 0);
    }

    TEST_CASE("a seed outside the given box") {
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const double value : {2.25, -0.125, std::nextafter(1.0, 2.0), -0x1p-1074}) {
                test::Coordinates points = test::uniform(300, 72).points;
                points[3 * 217 + axis] = value;
                points[3 * 290] = 7;
                const auto message = refusal(points, boxed(test::unit_box()));
                CAPTURE(message);
                CHECK(has(message, "217"));
                if (value == 2.25) CHECK(has(message, "2.25"));
                if (value == -0.125) CHECK(has(message, "-0.125"));
                CHECK_FALSE(has(message, "290"));
            }
        CHECK(refusal({0, 0, 0, 1, 1, 1, 0, 1, 0}, boxed(test::unit_box())) == "");  // the walls belong to it
    }

    TEST_CASE("an empty, inverted or infinite box") {
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const auto& [lower, upper] :
                 {std::pair{0.5, 0.5}, std::pair{0.75, 0.25}, std::pair{not_a_number, 1.0},
                  std::pair{0.0, not_a_number}, std::pair{-infinity, 1.0}, std::pair{0.0, infinity}}) {
                votess::Box box = test::unit_box();
                box.lower[axis] = lower;
                box.upper[axis] = upper;
                CAPTURE(lower);
                CAPTURE(upper);
                CHECK(refusal({0.5, 0.5, 0.5}, boxed(box)) != "");
                CHECK(refusal({}, boxed(box)) != "");
            }
    }

    TEST_CASE("a number of coordinates that is not a multiple of three") {
        CHECK(has(refusal({1}), "1"));
        CHECK(has(refusal({1, 2, 3, 4}), "4"));
        CHECK(has(refusal(test::Coordinates(3002, 0.5)), "3002"));
    }

    TEST_CASE("unknown options") {
        votess::Options options;
        options.device = "toaster";
        CHECK(has(refusal({0, 0, 0}, options), "toaster"));
        for (const std::string device :
             {"", " ", "GPU", "cpu ", "auto\n", "-1", "+1", "1.0", "0x1", "1000000", "0000001"}) {
            CAPTURE(device);
            options.device = device;
            CHECK(has(refusal({0, 0, 0}, options), "auto, cpu, gpu, lavapipe"));
        }
        for (const std::string name : {"sse", "AVX2", "avx2 ", " ", "avx512\n"}) {
            options = {};
            options.instructions = name;
            CHECK(has(refusal({0, 0, 0}, options), "baseline, avx2 or avx512"));
        }
        options = {};
        options.device = "cpu";
        CHECK(refusal({0, 0, 0}, options) == "");
    }

    TEST_CASE("options out of their range") {
        votess::each_option([](const std::string& name, auto member, auto, auto allowed) {
            votess::Options options;
            auto& value = options.*member;
            using Value = std::remove_reference_t<decltype(value)>;
            if constexpr (std::is_same_v<decltype(allowed), votess::UpTo<Value>>) {
                if (allowed.max == std::numeric_limits<Value>::max()) return;
                value = allowed.max + 1;  // or infinity
            } else if constexpr (std::is_enum_v<Value>) {
                value = static_cast<Value>(allowed.size());
            } else {
                return;
            }
            CHECK(has(refusal({0, 0, 0}, options), name + " = "));
        });
        for (double votess::Options::*const limit : {&votess::Options::min_face, &votess::Options::min_area})
            for (const double value : {-1e-300, not_a_number}) {
                votess::Options options;
                options.*limit = value;
                CHECK(has(refusal({0, 0, 0}, options), "give a finite number from 0 up"));
            }
    }

    TEST_CASE("votess_options has no padding at its end, where a field could be added unseen") {
        const votess_options options{};
        const auto end_of = [&](const auto& field) {
            return reinterpret_cast<const char*>(&field + 1) - reinterpret_cast<const char*>(&options);
        };
        auto end = end_of(options.log_user);
        votess::each_option([&](auto, auto, auto c_member, auto) { end = std::max(end, end_of(options.*c_member)); });
        CHECK(end == sizeof options);
    }

    TEST_CASE("periodic of a cell: Options::periodic is unset or equal") {
        votess::Options options;
        options.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0.25, 1, 0}, {0, 0, 1}};
        for (unsigned axes = 0; axes < 8; ++axes) {
            CAPTURE(axes);
            options.periodic = {(axes & 1) != 0, (axes & 2) != 0, (axes & 4) != 0};
            const std::string message = refusal({0.5, 0.5, 0.5}, options);
            if (axes == 0 || axes == 7)
                CHECK(message == "");
            else
                CHECK(has(message, "cell and periodic contradict each other"));
            options.cell->periodic = options.periodic;
            CHECK(refusal({0.5, 0.5, 0.5}, options) == "");
            options.cell->periodic = {true, true, true};
        }
        options.cell.reset();
        CHECK(has(refusal({0.5, 0.5, 0.5}, options), "a periodic axis needs a box"));
    }

    TEST_CASE("what is wanted with what it implies") {
        const auto implied = [](votess::Want want, double min_face = 0) {
            votess::Options options;
            options.want = want;
            options.min_face = min_face;
            const votess::Want w = votess::implied_want(options);
            const auto t = votess::tessellate(test::uniform(20, 75).points, options);
            CHECK(t.indptr().empty() == !w.neighbors);
            CHECK(t.volumes().empty() == !w.volumes);
            CHECK(t.face_areas().empty() == !w.areas);
            CHECK(t.face_normals().empty() == !w.normals);
            CHECK(t.vertices().empty() == !w.vertices);
            CHECK(t.face_vertices().empty() == !w.faces);
            CHECK(t.lists_walls() == w.faces);
            return w;
        };
        const votess::Want none{.neighbors = false, .volumes = false};
        auto want = none;
        CHECK_FALSE(implied(want).neighbors);
        CHECK(implied(want, 0.1).areas);
        want.faces = true;
        CHECK(implied(want).vertices);
        for (bool votess::Want::*array : {&votess::Want::areas, &votess::Want::normals, &votess::Want::vertices}) {
            want = none;
            want.*array = true;
            CHECK(implied(want).neighbors);
            CHECK_FALSE(implied(want).volumes);
        }
        votess::Options wrong;
        wrong.threads = 1025;
        CHECK_THROWS_AS((void)votess::implied_want(wrong), votess::Error);
    }

    TEST_CASE("want_of takes words and the arrays that they stand for") {
        using votess::Want;
        const auto bits = [](const Want& w) {
            return std::array{w.neighbors, w.volumes,  w.centroids, w.counts,   w.areas,
                              w.normals,   w.surfaces, w.radii,     w.vertices, w.faces};
        };
        struct Case {
            const char* names;
            std::initializer_list<bool Want::*> words;
        };
        for (const Case& c : {Case{"neighbors,volumes", {&Want::neighbors, &Want::volumes}},
                              {" indptr , shifts", {&Want::neighbors}},
                              {"face_areas,areas", {&Want::areas}},
                              {"face_normals", {&Want::normals}},
                              {"surface_areas", {&Want::surfaces}},
                              {"security_radii,centroids", {&Want::radii, &Want::centroids}},
                              {"edge_counts", {&Want::counts}},
                              {"cell_vertices", {&Want::vertices}},
                              {"face_vertices", {&Want::faces}},
                              {"status,duplicate_of,ids", {}}}) {
            Want expected{.neighbors = false, .volumes = false};
            for (bool Want::*const word : c.words) expected.*word = true;
            CHECK_MESSAGE(bits(votess::want_of(c.names)) == bits(expected), c.names);
        }
        for (const char* wrong : {"", "volumes,", "face_area", "Volumes", "volumes;areas", "\n"})
            CHECK_THROWS_WITH_AS((void)votess::want_of(wrong), doctest::Contains("want has '"), votess::Error);
    }

    TEST_CASE("the largest values of the tuning options change nothing") {
        const test::PointSet set = test::uniform(300, 74);
        votess::Options options = test::all_options(set.box);
        options.device = "cpu";
        const auto expected = votess::tessellate(set.points, options);
        options.k_init = 1024;
        options.chunk_size = std::numeric_limits<unsigned>::max();
        options.grid_resolution = 1u << 20;
        for (const auto precision : {votess::Precision::single, votess::Precision::double_}) {
            options.precision = precision;
            const auto t = votess::tessellate(set.points, options);
            CHECK(test::check_identical(expected, t) == "");
            CHECK(t.stats().precision == votess::Precision::double_);
        }
    }

    TEST_CASE("instructions that the processor lacks are unsupported") {
        const auto supported = votess::cpu::supported_kernels();
        for (const std::string name : {"baseline", "avx2", "avx512"}) {
            CAPTURE(name);
            votess::Options options = test::all_options();
            options.instructions = name;
            const std::string message = refusal({0, 0, 0}, options, votess::ErrorCode::unsupported);
            CHECK(message.empty() == (votess::cpu::find_kernels(name) != nullptr));
            if (message.empty()) continue;
            CHECK(has(message, "'" + name + "'"));
            for (const auto* kernels : supported) CHECK(has(message, kernels->name));
        }
        CHECK(votess::cpu::find_kernels("") == supported.front());
        CHECK(has(votess::devices().front().description, supported.front()->name));
    }

    TEST_CASE("a device that is not there is unsupported") {
        for (const std::string device : {"gpu", "lavapipe", "0", "7", "999999"}) {
            CAPTURE(device);
            votess::Options options;
            options.device = device;
            try {
                const auto t = votess::tessellate(test::Coordinates{0, 0, 0}, options);
                CHECK(t.size() == 1);  // this machine has it
            } catch (const votess::Error& error) {
                const std::string message = error.what();
                CHECK(error.code() == votess::ErrorCode::unsupported);
                CHECK(message != "");
                CHECK(message.find('\n') == std::string::npos);
            }
        }
    }

    TEST_CASE("coordinates beyond the range of exact arithmetic are refused, never guessed") {
        const double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();
        for (const test::Coordinates& points :
             {test::Coordinates{-huge, 0, 0, huge, 1, 2}, test::Coordinates{0, 0, 0, tiny, 0, 0, 0, tiny, tiny},
              test::Coordinates{huge, huge, huge}, test::Coordinates{0, 0, 0, 1, 1, 1, 1, tiny, 0}}) {
            try {
                const auto t = votess::tessellate(points, test::all_options());
                CHECK(test::check_invariants(t, points, true) == "");
            } catch (const votess::Error& error) {
                CHECK(error.code() == votess::ErrorCode::invalid_argument);
                CHECK(std::string(error.what()) != "");
            }
        }
    }

    TEST_CASE("an error leaves the Tessellator usable") {
        const test::PointSet set = test::uniform(500, 73);
        const auto expected = test::run(set);
        votess::Tessellator tessellator;
        const auto options = test::all_options(set.box);
        for (int round = 0; round < 3; ++round) {
            test::Coordinates bad = set.points;
            bad[3 * 400] = round == 1 ? 5 : not_a_number;
            CHECK_THROWS_AS((void)tessellator.tessellate(bad, options), votess::Error);
            bad.pop_back();
            CHECK_THROWS_AS((void)tessellator.tessellate(bad, options), votess::Error);
            CHECK(test::check_identical(expected, tessellator.tessellate(set.points, options)) == "");
        }
    }
}
