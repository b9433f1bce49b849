// Every family of generators.hpp, small, against the exact diagram.
#include <doctest/doctest.h>

#include <cmath>
#include <optional>

#include "support/check.hpp"

namespace {

// False when the coordinates were refused as out of range; else the answer is the exact one, or the test fails.
bool right_or_refused(const test::PointSet& set) {
    std::optional<votess::Tessellation> t;
    try {
        t = test::run(set);
    } catch (const votess::Error& error) {  // which a CHECK around the call would keep to itself
        CHECK(error.code() == votess::ErrorCode::invalid_argument);
        return false;
    }
    CHECK(test::check_exact(*t, set.points) == "");
    return true;
}

}  // namespace

TEST_SUITE("oracle") {
    TEST_CASE("families of about 30 seeds equal the exact diagram") {
        const std::size_t seeds = test::by_size(8, 1);
        for (std::uint64_t seed = 1; seed <= seeds; ++seed)
            for (const test::PointSet& set : test::families(30, seed)) {
                CAPTURE(set.name);
                CAPTURE(seed);
                CHECK(test::check_exact(test::run(set), set.points) == "");
            }
    }

    TEST_CASE("families of about 90 seeds equal the exact diagram") {
        for (const test::PointSet& set : test::families(test::by_size(90, 40), 11)) {
            CAPTURE(set.name);
            CHECK(test::check_exact(test::run(set), set.points) == "");
        }
    }

    TEST_CASE("families in adversarial orders equal the exact diagram") {
        using test::Order;
        for (const Order order : {Order::reversed, Order::interleaved, Order::by_last_coordinate, Order::shuffled})
            for (const test::PointSet& base :
                 {test::cospherical(9), test::cospherical_and_center(14), test::cocircular(25, 3),
                  test::cocircular(50, 2), test::on_oblique_line(20, 7), test::on_oblique_plane(25, 8), test::cubic(3),
                  test::bcc(4), test::fcc(3), test::diamond(4)}) {
                const test::PointSet set = test::reordered(base, order);
                CAPTURE(set.name);
                CAPTURE(static_cast<int>(order));
                CHECK(test::check_exact(test::run(set), set.points) == "");
            }
    }

    TEST_CASE("seeds very close together in a box of order one: right, or refused as out of range") {
        for (const double step : {0x1p-40, 0x1p-80, 0x1p-120, 0x1p-160, 0x1p-200, 0x1p-250, 0x1p-300}) {
            CAPTURE(step);
            test::PointSet set{"close", {2, 1, 1, 3, 0, 0, 1, 2, 2}, std::nullopt};
            for (auto& x : set.points) x *= step;
            set.box = test::cube(-1, 3);
            if (!right_or_refused(set)) CHECK(step < 0x1p-100);  // that much every engine must take
        }
    }

    TEST_CASE("a pair one step apart near the origin of a box of order one: volume of a slab of 1e-29") {
        // Found by the fuzz test: its vertices are 1e28 times farther away than the cell is thick.
        const test::PointSet set{"pair near the origin",
                                 {0x1.42686b9eae49p-13, 0x1.4283de8594bdap-9, 0x1.d4d56da132bf2p-9,
                                  0x1.931e08274ea79p-39, 0x1.e85974c01f9dap-40, 0x1.ef345455d80cp-42,
                                  0x1.931e08274ea79p-39, 0x1.e85974c01f9dap-40, 0x1.ef345455d80c1p-42},
                                 votess::Box{{-0x1.d0ed2316922a8p-5, 0x1.e85974c01f9dap-40, 0x1.ef345455d80cp-42},
                                             {0x1.d0ed23171023ep-3, 0x1.0ff79c93ebcacp-3, 0x1.9c170852d067ep-3}}};
        CHECK(test::check_exact(test::run(set), set.points) == "");
    }

    TEST_CASE("cells so small that squared distances underflow: right, or refused as out of range") {
        for (int k = 20; k <= 1070; k += 10) {
            const double d = std::ldexp(1.0, -k);
            CAPTURE(k);
            const test::PointSet set{"small cell in a corner",
                                     {0, 0, 0, 0, 0, d, -2 * d, -2 * d, -d},
                                     votess::Box{{-2 * d, -2 * d, -d}, {1 + 0x1p-52, 1, 1}}};
            if (!right_or_refused(set)) CHECK(k > 100);  // that much every engine must take
        }
    }

    TEST_CASE("a corner cell whose moment underflows: right, or refused as out of range") {
        const double d = 0x1p-300, e = 0x1.0000000000001p-300;
        const test::PointSet set{"corner", {0, 0, d, d, 0, 0, 0, e, e}, test::unit_box()};
        right_or_refused(set);
    }

    TEST_CASE("one coordinate near zero: right, or refused as out of range") {
        for (const double tiny : {1e-30, 1e-100, 1e-200, 5e-324}) {
            CAPTURE(tiny);
            test::PointSet set = test::uniform(12, 4);
            set.points[0] = tiny;
            set.points[16] = tiny;
            if (!right_or_refused(set)) CHECK(tiny < 1e-30);  // that much every engine must take
        }
    }
}
