// Few seeds in every kind of domain against exact half-spaces.
#include <doctest/doctest.h>

#include "fuzz/kinds/kinds.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"

TEST_SUITE("oracle") {
    TEST_CASE("half-spaces: boxes, triclinic cells, walls and weights") {
        for (const test::fuzz::Kind& kind : test::fuzz::all_kinds()) {
            // The polygons of half-spaces begin in a cube that is too small for long skewed cells.
            if (kind.name == "many" || kind.name == "jobs" || kind.name == "moving" || kind.name == "extremes" ||
                kind.name == "skewed")
                continue;
            std::size_t tried = 0;
            const std::uint64_t sets = test::by_size(25, 4);
            for (std::uint64_t number = 1; number <= sets; ++number) {
                const test::fuzz::Job job = test::fuzz::make_case(kind, number).jobs[0];
                if (job.size() > 12) continue;
                votess::Options options = job.options("cpu");
                options.want = {};
                options.list_walls = true;
                CAPTURE(std::string(kind.name));
                CAPTURE(number);
                votess::Tessellation t;
                if (test::error_of([&] { t = votess::tessellate(job.points, options); })) {
                    REQUIRE(job.may_refuse);
                    continue;
                }
                if (t.stats().duplicates > 0) continue;
                ++tried;
                if (!options.cell) options.box = t.box();
                REQUIRE(test::check_against_half_spaces(t, job.points, options) == "");
            }
            CHECK(tried >= sets / 10);
        }
    }
}
