// The option `periodic`, and `cell` where it is periodic along all edges.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fuzz/kinds/kinds.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using votess::Box;
using votess::Options;

Options periodic_options(const Box& box = test::unit_box(), std::array<bool, 3> periodic = {true, true, true}) {
    Options options = test::all_options(box);
    options.periodic = periodic;
    return options;
}

Options cell_options(const votess::TriclinicBox& cell) {
    Options options = test::all_options();
    options.cell = cell;
    return options;
}

Coordinates lattice(int length, std::initializer_list<std::array<double, 3>> motif) {
    Coordinates points;
    for (int i = 0; i < length; ++i)
        for (int j = 0; j < length; ++j)
            for (int k = 0; k < length; ++k)
                for (const auto& m : motif)
                    points.insert(points.end(), {(i + m[0]) / length, (j + m[1]) / length, (k + m[2]) / length});
    return points;
}

// Returns the row of a seed with the seeds renamed, sorted.
std::vector<test::ExactFace> row_of(const votess::Tessellation& t, std::size_t i,
                                    const std::vector<std::size_t>& name) {
    std::vector<test::ExactFace> row;
    for (auto e = static_cast<std::size_t>(t.indptr()[i]); e < static_cast<std::size_t>(t.indptr()[i + 1]); ++e) {
        test::ExactFace face{t.indices()[e], {}};
        if (face.id >= 0) face.id = static_cast<std::int32_t>(name[static_cast<std::size_t>(face.id)]);
        if (!t.shifts().empty()) std::copy_n(&t.shifts()[3 * e], 3, face.shift.begin());
        row.push_back(face);
    }
    std::ranges::sort(row);
    return row;
}

// Returns what is wrong with the answer in the order of the job, or with the rows in any other order.
std::string check_in_every_order(const test::fuzz::Job& job) {
    std::vector<std::size_t> order(job.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto first = votess::tessellate(job.points, job.options("cpu"));
    if (auto failure = test::check_domain(first); !failure.empty()) return failure;
    if (first.stats().duplicates > 0) return "";  // the first in the order has the cell
    if (auto failure = test::check_against_half_spaces(first, job.points, job.options("cpu")); !failure.empty())
        return failure;
    std::vector<std::vector<test::ExactFace>> rows;
    for (std::size_t i = 0; i < order.size(); ++i) rows.push_back(row_of(first, i, order));
    while (std::ranges::next_permutation(order).found) {
        test::fuzz::Job other = job;
        for (std::size_t i = 0; i < order.size(); ++i) {
            std::copy_n(&job.points[3 * order[i]], 3, &other.points[3 * i]);
            if (!job.weights.empty()) other.weights[i] = job.weights[order[i]];
        }
        const auto t = votess::tessellate(other.points, other.options("cpu"));
        for (std::size_t i = 0; i < order.size(); ++i)
            if (row_of(t, i, order) != rows[order[i]]) return "the row of a seed depends on the order of seeds";
    }
    return "";
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("periodic: seeds far outside the box are wrapped without rounding") {
        test::Random random(2);
        const Options options = periodic_options({{-0.1, 0.3, 1e-3}, {0.7, 1.1, 0.9}});  // lengths are not doubles
        for (std::uint64_t round = 0; round < test::by_size(5, 2); ++round)
            for (const double far : {5.0, 1e6}) {
                Coordinates points(12);
                for (double& x : points) x = random.uniform(-far, far);
                CHECK(test::check_right(points, options) == "");
            }
    }

    // Each image needs three doubles. Deciding all such planes exactly took minutes a cell.
    TEST_CASE("periodic: a flat set with noise in a thin box") {
        test::Random random(11);
        Options options = periodic_options({{-10, -10, -0.5}, {10, 10, 0.5}}, {false, false, true});
        CHECK(test::check_right({1, 2, 1e-30, 5, 3, -1e-17, -4, -3, 3e-22}, options) == "");
        Coordinates many;
        for (int i = 0; i < 60; ++i)
            many.insert(many.end(), {random.uniform(-10, 10), random.uniform(-10, 10),
                                     random.uniform(-1, 1) * std::pow(10.0, random.uniform(-30, -15))});
        options.periodic = {true, true, true};
        const auto t = votess::tessellate(many, options);
        CHECK(test::check_domain(t) == "");
        CHECK(votess::verify(t, many).failure == "");
    }

    TEST_CASE("periodic: lines and planes of seeds, turned and rounded, are among wide images") {
        test::Random random(41);
        for (const bool plane : {false, true})
            for (const unsigned mask : {0U, 1U, 2U, 5U})
                for (const double noise : {1e-16, 1e-9}) {
                    Coordinates points;
                    const std::size_t n = test::by_size(120, 40);
                    for (std::size_t i = 0; i < n; ++i) {
                        const double u = random.uniform(-0.4, 0.4), v = plane ? random.uniform(-0.3, 0.3) : 0.0;
                        for (const double at : {0.7 * u + 0.3 * v, 0.5 * u - 0.9 * v, 0.6 * u + 0.2 * v})
                            points.push_back(0.5 + at + noise * random.uniform(-1, 1));
                    }
                    std::array<bool, 3> periodic{};
                    for (unsigned k = 0; k < 3; ++k) periodic[k] = ((mask >> k) & 1) == 0;
                    CAPTURE(plane);
                    CAPTURE(mask);
                    CAPTURE(noise);
                    CHECK(test::check_right(points, periodic_options(test::unit_box(), periodic)) == "");
                }
    }

    TEST_CASE("periodic: the faces of boxes of any aspect are those of a long one") {
        const std::vector<std::size_t> names{0, 1, 2, 3, 4, 5, 6};
        test::Random random(29);
        for (const std::size_t count : {std::size_t{1}, std::size_t{2}, names.size()})
            for (const std::size_t axis : {std::size_t{1}, std::size_t{2}})
                for (const bool weighted : {false, true}) {
                    Coordinates points(3 * count), weights(weighted ? count : 0);
                    for (double& x : points) x = random.uniform();
                    for (double& w : weights) w = random.uniform();
                    votess::Tessellation first;
                    for (const int exponent : {20, 34, 38, 60, 100}) {
                        Box box = test::unit_box();
                        box.upper[axis] = std::ldexp(1.0, exponent);
                        Coordinates places = points;
                        for (std::size_t i = 0; i < count; ++i) places[3 * i + axis] *= box.upper[axis];
                        Options options = periodic_options(box, {true, true, axis == 2});
                        options.weights = weights;
                        auto t = votess::tessellate(places, options);
                        if (exponent == 20) first = std::move(t);
                        CAPTURE(count);
                        CAPTURE(axis);
                        CAPTURE(weighted);
                        CAPTURE(exponent);
                        for (std::size_t i = 0; i < count && exponent > 20; ++i)
                            CHECK(row_of(t, i, names) == row_of(first, i, names));
                    }
                }
    }

    TEST_CASE("periodic: the same seed one period on is a duplicate, one bit off it is not") {
        const Coordinates points{0.25, 0.25, 0.25, 1.25, 0.25, 0.25, 0.5, 0.75, 0.5, -1.75, 5.25, 0.25};
        const auto t = votess::tessellate(points, periodic_options());
        CHECK(t.stats().duplicates == 2);
        CHECK(std::ranges::equal(t.duplicate_of(), std::vector<std::int32_t>{-1, 0, -1, 0}));
        CHECK(test::check_domain(t) == "");
        // 1 - 1e-20 and 1 - 2e-20 round to the same double.
        CHECK(test::check_right({-1e-20, 0.5, 0.5, -2e-20, 0.5, 0.5, 0.5, 0.5, 0.5}, periodic_options()) == "");
        // Images of neighboring doubles are equal once they are rounded.
        const double x = 0.6;
        for (const bool y : {false, true})
            CHECK(test::check_right({0.1, 0.2, 0.3, std::nextafter(x, 1), 0.5, 0.5, x, 0.5, 0.5, 0.3, 0.8, 0.2},
                                    periodic_options(test::unit_box(), {true, y, true})) == "");
        // A wrapped seed rounds onto another.
        const double a = -0.3492714367344718, b = 1.527212794076232;
        const Options one_axis = periodic_options({{-0.23936944299295215, 0, 0}, {1.6371147878177517, 1, 1}}, {true});
        CHECK(test::check_right({a, 0.5, 0.5, b, 0.5, 0.5}, one_axis) == "");
        CHECK(test::check_right({b, 0.5, 0.5, a, 0.5, 0.5}, one_axis) == "");
    }

    TEST_CASE("periodic: one seed in a cube has six faces, with itself") {
        const auto t = votess::tessellate(Coordinates{0.1, 0.7, 0.3}, periodic_options());
        CHECK(std::ranges::equal(t.indices(), std::vector<std::int32_t>{0, 0, 0, 0, 0, 0}));
        const std::vector<std::int8_t> shifts{-1, 0, 0, 0, -1, 0, 0, 0, -1, 0, 0, 1, 0, 1, 0, 1, 0, 0};
        CHECK(std::ranges::equal(t.shifts(), shifts));
        CHECK(t.volumes()[0] == doctest::Approx(1).epsilon(1e-14));
    }

    TEST_CASE("periodic: perfect lattices") {
        for (const int length : {1, 2, 3, 5, 7}) {
            CAPTURE(length);
            const auto faces_are = [&](const Coordinates& points, std::size_t count) {
                const auto t = votess::tessellate(points, periodic_options());
                CHECK(test::check_domain(t) == "");
                for (std::size_t i = 0; i < t.size(); ++i) CHECK(t.neighbors(i).size() == count);
            };
            faces_are(lattice(length, {{0, 0, 0}}), 6);
            if (length % 2 == 1 && length > 1) continue;  // (i + 1/2) / length is rounded
            faces_are(lattice(length, {{0, 0, 0}, {0.5, 0.5, 0.5}}), 14);
            faces_are(lattice(length, {{0, 0, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}), 12);
        }
        // A sheared lattice of integers.
        const Options sheared = cell_options({{0, 0, 0}, {2, 0, 0}, {1, 2, 0}, {-1, 1, 2}});
        CHECK(test::check_right({0, 0, 0, 1, 1, 0}, sheared) == "");
    }

    // Rows without normals were read from behind the seeds.
    TEST_CASE("periodic: in a skewed cell some images have no shift") {
        Options options = cell_options({{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {7.3, 5.2, 1}});
        options.want = {};
        options.list_walls = false;
        for (std::uint64_t n = 1; n <= 3; ++n) {
            const Coordinates points = test::uniform(test::by_size(2000, 500), n).points;
            options.want.normals = false;
            const auto t = votess::tessellate(points, options);
            options.want.normals = true;
            const auto same = votess::tessellate(points, options);
            CHECK(std::ranges::equal(t.indptr(), same.indptr()));
            CHECK(std::ranges::equal(t.indices(), same.indices()));
            CHECK(std::ranges::equal(t.shifts(), same.shifts()));
        }
    }

    TEST_CASE("periodic: seeds and their rounded translations, in every order") {
        const std::size_t sets = test::by_size(150, 15);
        for (std::uint64_t number = 1, tried = 0; tried < sets; ++number) {
            test::Random random(number);
            for (const test::fuzz::Job& job : test::fuzz::wrapped_pairs(random)) {
                if (job.size() > 4) continue;
                ++tried;
                CAPTURE(number);
                REQUIRE(check_in_every_order(job) == "");
            }
        }
    }

    TEST_CASE("periodic: many seeds fill the box for any number of threads") {
        for (const auto& set : {test::uniform(test::by_size(20000, 2000), 7),
                                test::clustered(test::by_size(20000, 2000), 8), test::uniform(10, 9)}) {
            CAPTURE(set.name);
            Options options = periodic_options();
            const auto t = votess::tessellate(set.points, options);
            CHECK(test::check_domain(t) == "");
            options.threads = 3;
            CHECK(test::check_identical(t, votess::tessellate(set.points, options)) == "");
        }
    }
}
