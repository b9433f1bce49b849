// Options that are refused, each by one line that names the first wrong value, and their defaults.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "input/each_option.hpp"
#include "support/check.hpp"
#include "support/text.hpp"

namespace {

using test::has;
using test::refusal;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_SUITE("interface") {
    TEST_CASE("options: a coordinate that is not finite") {
        for (const auto& [value, name] :
             {std::pair{not_a_number, "nan"}, std::pair{infinity, "inf"}, std::pair{-infinity, "-inf"}}) {
            for (const bool with_box : {false, true}) {
                test::Coordinates points = test::uniform(300, 71).points;
                points[3 * 217 + 1] = value;
                points[3 * 290] = not_a_number;  // not the first
                const auto message =
                    refusal(points, with_box ? test::all_options(test::unit_box()) : votess::Options{});
                CAPTURE(message);
                CHECK(has(message, "217"));
                CHECK(has(message, name));
                CHECK_FALSE(has(message, "290"));
            }
        }
        const float narrow[] = {0, 0, 0, 1, std::numeric_limits<float>::infinity(), 0};
        CHECK_THROWS_AS((void)votess::tessellate(std::span<const float>(narrow)), votess::Error);
    }

    TEST_CASE("options: a number of coordinates that is not a multiple of three") {
        CHECK(has(refusal({1}), "1"));
        CHECK(has(refusal({1, 2, 3, 4}), "4"));
        CHECK(has(refusal(test::Coordinates(3002, 0.5)), "3002"));
    }

    TEST_CASE("options: unknown options") {
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

    TEST_CASE("options: out of their range") {
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

    TEST_CASE("options: votess_options has no padding at its end, where a field could be added unseen") {
        const votess_options options{};
        const auto end_of = [&](const auto& field) {
            return reinterpret_cast<const char*>(&field + 1) - reinterpret_cast<const char*>(&options);
        };
        auto end = end_of(options.mesh_tolerance);
        votess::each_option([&](auto, auto, auto c_member, auto) { end = std::max(end, end_of(options.*c_member)); });
        CHECK(end == sizeof options);
    }

    TEST_CASE("options: the largest values of the tuning options change nothing") {
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

    TEST_CASE("options: a device that is not there is unsupported") {
        for (const std::string device : {"gpu", "lavapipe", "0", "7", "999999"}) {
            CAPTURE(device);
            votess::Options options;
            options.device = device;
            const std::string message = refusal({0, 0, 0}, options, votess::ErrorCode::unsupported);
            CHECK_FALSE(has(message, "another code"));
            CHECK_FALSE(has(message, "several lines"));
        }
    }

    TEST_CASE("options: the default options give neighbors and volumes, without walls") {
        const test::PointSet set = test::uniform(200, 86);
        const auto t = votess::tessellate(set.points);
        CHECK(t.indptr().size() == 201);
        CHECK(t.volumes().size() == 200);
        CHECK(t.centroids().empty());
        CHECK(t.face_counts().empty());
        CHECK_FALSE(t.lists_walls());
        CHECK(t.stats().device != "");
        CHECK(t.stats().threads >= 1);
        CHECK(t.stats().seconds.total > 0);
        CHECK(test::check_invariants(t, set.points) == "");
    }
}
