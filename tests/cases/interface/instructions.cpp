// The instruction set changes no list, and volumes in their last digits only.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "polytope/cell_kernels.hpp"
#include "support/check.hpp"
#include "support/text.hpp"

namespace {

votess::Options with_instructions(const std::string& name) {
    votess::Options options = test::all_options();
    options.instructions = name;
    return options;
}

// Relative to `size`, and the smallest normal number for what underflows.
bool near(double a, double b, double size, double error) {
    return std::abs(a - b) <= error * size + 0x1p-1022 || (std::isnan(a) && std::isnan(b));
}

void compare(const votess::Tessellation& t, const votess::Tessellation& u) {
    CHECK(test::check_same_cells(t, u) == "");
    CHECK(t.stats().faces == u.stats().faces);
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("instructions change no list") {
        const auto supported = votess::cpu::supported_kernels();
        auto sets = test::families(test::by_size(2000, 300), 91);
        for (test::PointSet& set : std::vector{test::jittered(10, 1e-12, 92), test::scaled(test::fcc(6), 0x1p-200),
                                               test::on_sphere_and_center(test::by_size(200, 90), 93)})
            sets.push_back(std::move(set));
        for (const test::PointSet& set : sets) {
            CAPTURE(set.name);
            const auto baseline = test::run(set, with_instructions("baseline"));
            CHECK(test::check_invariants(baseline, set.points) == "");
            for (const auto* kernels : supported) {
                INFO(std::string(kernels->name));
                compare(baseline, test::run(set, with_instructions(kernels->name)));
            }
            CHECK(test::check_identical(test::run(set, with_instructions("")),
                                        test::run(set, with_instructions(supported.front()->name))) == "");
        }
    }

    TEST_CASE("instructions change volumes of ordinary cells by less than 1e-12") {
        for (const test::PointSet& set : {test::uniform(test::by_size(20000, 2000), 94), test::cubic(12), test::bcc(8),
                                          test::jittered(12, 0.1, 95)}) {
            CAPTURE(set.name);
            const auto baseline = test::run(set, with_instructions("baseline"));
            for (const auto* kernels : votess::cpu::supported_kernels()) {
                INFO(std::string(kernels->name));
                const auto t = test::run(set, with_instructions(kernels->name));
                for (std::size_t i = 0; i < t.size(); ++i) {
                    const double volume = baseline.volumes()[i];
                    if (!near(t.volumes()[i], volume, volume, 1e-12)) FAIL_CHECK("volume " << i);
                    for (std::size_t a = 3 * i; a < 3 * i + 3; ++a)
                        if (!near(t.centroids()[a], baseline.centroids()[a], std::cbrt(volume), 1e-11))
                            FAIL_CHECK("centroid " << i);
                }
            }
        }
    }

    TEST_CASE("a Tessellator whose instructions change gives what a new one gives") {
        // With ties the last digits depend on the instructions, so that workers of the wrong ones show.
        const std::vector<test::PointSet> sets{test::uniform(test::by_size(6000, 800), 96), test::cubic(10, 0.1),
                                               test::close_packed(6), test::jittered(8, 1e-12, 97)};
        votess::Tessellator tessellator;
        const auto supported = votess::cpu::supported_kernels();
        bool some_differ = supported.size() == 1;
        for (int round = 0; round < 2; ++round)
            for (const auto* kernels : supported)
                for (const test::PointSet& set : sets) {
                    auto options = with_instructions(kernels->name);
                    options.box = set.box;
                    options.threads = round == 0 ? 1 : 2;
                    const auto alone = votess::tessellate(set.points, options);
                    CHECK(test::check_identical(alone, tessellator.tessellate(set.points, options)) == "");
                    options.instructions = "baseline";
                    some_differ =
                        some_differ || test::check_identical(alone, votess::tessellate(set.points, options)) != "";
                    options.instructions = "mmx";
                    CHECK_THROWS_AS((void)tessellator.tessellate(set.points, options), votess::Error);
                }
        CHECK(some_differ);  // else the choice has no effect
    }

    TEST_CASE("instructions that the processor lacks are unsupported") {
        const auto supported = votess::cpu::supported_kernels();
        for (const std::string name : {"baseline", "avx2", "avx512"}) {
            CAPTURE(name);
            votess::Options options = test::all_options();
            options.instructions = name;
            const std::string message = test::refusal({0, 0, 0}, options, votess::ErrorCode::unsupported);
            CHECK(message.empty() == (votess::cpu::find_kernels(name) != nullptr));
            if (message.empty()) continue;
            CHECK(test::has(message, "Options::instructions = " + name));
            for (const auto* kernels : supported) CHECK(test::has(message, kernels->name));
        }
        CHECK(votess::cpu::find_kernels("") == supported.front());
        CHECK(test::has(votess::devices().front().description, supported.front()->name));
    }
}
