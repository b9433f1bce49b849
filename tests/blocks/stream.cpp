// tessellate_stream() against all seeds at once.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "blocks/streamed.hpp"
#include "input/settle.hpp"
#include "support/arrays.hpp"
#include "support/check.hpp"
#include "support/in_plane.hpp"
#include "support/random.hpp"
#include "support/scattered.hpp"
#include "verify/row_checker.hpp"

namespace {

using test::PointSet;

constexpr std::uint64_t little = votess::StreamOptions::least_memory;  // some 1500 seeds a block

votess::Options stream_options(const PointSet& set) {
    votess::Options options;
    options.device = "cpu";
    options.threads = 2;
    options.box = set.box;
    options.want.counts = options.want.centroids = options.want.normals = true;
    return options;
}

void check_stream(const PointSet& set, const votess::Options& options) {
    CAPTURE(set.name);
    const auto whole = votess::tessellate(set.points, options);
    const test::Streamed found = test::streamed(set.points, options, little, 777, false, true);
    CHECK(test::difference(found, whole) == "");
    CHECK(found.result.blocks > whole.size() / 3000);
    const votess::VerifyReport& report = found.result.verified.value();
    CHECK(report.passed);
    const auto tried = std::ranges::count_if(whole.status(), votess::takes_part);
    const bool rows = options.want.neighbors || whole.size() == 0;
    const bool endless = votess::EndlessSides(votess::settle(options).region).any();
    const bool hides = options.outside == votess::Outside::keep || !options.weights.empty() || !options.radii.empty();
    const bool gave_up = hides && report.unproven.ends_with("no cells of one block were found that exclude them");
    CHECK(report.proven == (rows && !endless && !gave_up));
    if (!gave_up)
        CHECK(report.unproven == (!rows     ? "the result has no neighbors"
                                  : endless ? "cells of a domain without end are sampled"
                                            : ""));
    const bool sampled = rows && (endless || gave_up || options.planar);
    CHECK(report.sampled == (sampled ? std::min<std::size_t>(64, static_cast<std::size_t>(tried)) : 0));
    CHECK(report.skipped ==
          (rows ? std::vector<std::string>() : std::vector<std::string>{"volumes", "symmetry", "euler", "sample"}));
}

// Seeds in two blocks. The rows come once.
struct Halves : votess::RunBlocks {
    explicit Halves(const PointSet& some) : set(some) {}
    void for_blocks(const std::function<void(votess::Seeds)>& task) override {
        for (const bool second : {false, true}) {
            votess::Seeds half;
            for (std::size_t i = 0; i < set.size(); ++i)
                if ((i >= set.size() / 2) == second) half.add(static_cast<std::int64_t>(i), set.points, {}, i);
            task(half);
        }
    }
    const PointSet& set;
};

std::string message(const auto& work) {
    try {
        work();
    } catch (const votess::Error& error) {
        return error.what();
    }
    return "nothing";
}

// The number of seeds of ordinary sets, which need several blocks.
const std::size_t some = test::by_size(3000, 1200);

}  // namespace

TEST_CASE("stream: seeds outside that are kept") {
    test::Scattered s;
    for (int kind = 0; kind < test::kinds_of_scattered; kind += test::reduced() ? 3 : 1) {
        CAPTURE(kind);
        test::scatter(kind, test::by_size(4000, 2000), 0.2, kind % 2 == 1, 21, s);
        check_stream({"scattered", s.points, s.options.box}, s.options);
    }
}

TEST_CASE("stream: the families have the lists of all seeds at once") {
    std::size_t number = 0;
    for (const PointSet& set :
         {test::uniform(3000, 1), test::clustered(3000, 2), test::nested_clusters(3000, 3), test::cubic(15),
          test::bcc(11), test::fcc(9), test::far_from_origin(3000, 4), test::on_walls(3000, 5),
          test::with_duplicates(2500, 500, 6), test::on_axis_plane(3000, 7), test::on_oblique_line(3000, 8),
          test::near_duplicates(3000, 9), test::reordered(test::clustered(3000, 2), test::Order::reversed)})
        if (number++ % test::by_size(1, 6) == 0) check_stream(set, stream_options(set));
    check_stream({"three", {0.1, 0.2, 0.3, 0.5, 0.5, 0.4, 0.9, 0.1, 0.8}, test::unit_box()},
                 stream_options({"", {}, test::unit_box()}));
    votess::Options options = stream_options({"", {}, test::unit_box()});
    check_stream({"none", {}, test::unit_box()}, options);
    options.box.reset();
    check_stream({"none, without a box", {}, test::unit_box()}, options);
    check_stream({"one, without a box", {1, 2, 3}, test::unit_box()}, options);
}

TEST_CASE("stream: everything that can be wanted, and nothing") {
    const PointSet set = test::clustered(3000, 7);
    votess::Options options = stream_options(set);
    options.box.reset();  // so that the bounds of all seeds count
    options.list_walls = true;
    auto& want = options.want;
    want.areas = want.normals = want.surfaces = want.radii = true;
    check_stream(set, options);
    options.want = {};
    options.want.neighbors = options.want.volumes = false;
    check_stream(set, options);
    options.want.radii = true;
    check_stream(set, options);
}

TEST_CASE("stream: periodic along subsets of the axes") {
    for (const unsigned axes : {1u, 3u, 7u})
        for (const PointSet& set : {test::uniform(some, axes), test::clustered(some, axes), test::cubic(14)}) {
            if (test::reduced() && axes != 3 && set.name == "cubic") continue;
            votess::Options options = stream_options(set);
            options.periodic = {(axes & 1) != 0, (axes & 2) != 0, (axes & 4) != 0};
            check_stream(set, options);
        }
}

TEST_CASE("stream: triclinic boxes, weights, walls and seeds that are dropped") {
    test::Random random(3);
    const PointSet set = test::clustered(some, 2);
    votess::Options options = stream_options(set);
    options.box.reset();
    options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}, {true, true, true}};
    check_stream(set, options);
    options.cell->periodic = {true, false, true};
    options.outside = votess::Outside::drop;
    check_stream(set, options);

    std::vector<double> radii(set.size());
    for (double& r : radii) r = random.uniform(0, 0.12);
    options = stream_options(set);
    options.radii = radii;
    check_stream(set, options);
    CHECK(test::difference(test::streamed(set.points, options, little, 1000, true),
                           votess::tessellate(set.points, options)) == "");
    options.radii = {};
    options.weights = radii;
    options.periodic = {true, true, true};
    check_stream(set, options);

    options = stream_options(set);
    options.box.reset();
    options.outside = votess::Outside::drop;
    options.walls = test::octahedron(0.6);
    check_stream(set, options);
}

TEST_CASE("stream: the plane") {
    test::Random random(5);
    for (const PointSet& space : {test::clustered(some, 2), test::cubic(14), test::with_duplicates(2500, 500, 6),
                                  test::nested_clusters(3000, 3)}) {
        if (test::reduced() && space.name != "clustered") continue;
        const PointSet set = test::in_plane(space);
        votess::Options options = stream_options(set);
        options.planar = true;
        options.periodic = {true, true, false};
        options.want.areas = options.want.surfaces = options.want.radii = true;
        if (set.box) check_stream(set, options);
        std::vector<double> radii(set.points.size() / 2);
        for (double& r : radii) r = random.uniform(0, 0.05);
        options.radii = radii;
        options.periodic = {};
        options.box.reset();
        options.list_walls = true;
        check_stream(set, options);
        options.radii = {};
        options.outside = votess::Outside::drop;
        options.walls = {{{1, 1, 0}, 1.1}, {{-1, 0.5, 0}, 0.2}};
        check_stream(set, options);
        options.outside = votess::Outside::keep;
        if (set.box) check_stream(set, options);
        if (!set.box) continue;
        options.outside = votess::Outside::error;
        options.walls.clear();
        options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {0, 0, 0}, {true, true, false}};
        if (set.box->upper[0] == 1) check_stream(set, options);
    }
    for (const double unit : {0x1p-500, 0x1p500}) {
        PointSet set = test::in_plane(test::clustered(some, 2));
        for (double& x : set.points) x *= unit;
        for (std::size_t k = 0; k < 2; ++k) set.box->lower[k] *= unit, set.box->upper[k] *= unit;
        votess::Options options = stream_options(set);
        options.planar = true;
        options.want.areas = true;
        check_stream(set, options);
    }
}

TEST_CASE("stream: boxes without end") {
    constexpr double end = std::numeric_limits<double>::infinity();
    std::size_t number = 0;  // each set has another two of the kinds of ends
    for (const bool planar : {false, true})
        for (const PointSet& space :
             {test::uniform(some, 1), test::clustered(some, 2), test::cubic(14), test::on_sphere(200, 6),
              test::on_axis_plane(300, 7), test::with_duplicates(2500, 500, 6), PointSet{"none", {}, test::unit_box()},
              PointSet{"one", {1, 2, 3}, test::unit_box()}}) {
            if (test::reduced() && space.name != "clustered" && space.name != "one") continue;
            const PointSet set = planar ? test::in_plane(space) : space;
            for (const unsigned ends : {63u, 32u, 25u}) {
                CAPTURE(planar);
                CAPTURE(ends);
                votess::Options options = stream_options(set);
                options.planar = planar;
                options.box = votess::Box{{-1, -1, -1}, {30, 30, 30}};
                if (set.points.empty()) options.want.normals = false;
                for (std::size_t k = 0; k < 3; ++k) {
                    if ((ends >> 2 * k & 1) != 0) options.box->lower[k] = -end;
                    if ((ends >> 2 * k & 2) != 0) options.box->upper[k] = end;
                }
                if (planar) options.box->lower[2] = options.box->upper[2] = 0;
                if ((planar && ends == 32u) || (++number % 3 == 0 && space.name != "clustered")) continue;
                if (ends == 63u && space.name == "clustered") check_stream(set, options);
                options.list_walls = true;
                options.want.areas = options.want.surfaces = options.want.radii = true;
                check_stream(set, options);
            }
        }
    const PointSet set = test::uniform(500, 3);
    votess::Options options = stream_options(set);
    options.box = votess::Box{{-end, -end, -end}, {end, end, end}};
    std::vector<double> weights(set.size());
    weights[7] = 0.001;
    options.weights = weights;
    CHECK(test::difference(test::streamed(set.points, options, little), votess::tessellate(set.points, options)) == "");
    weights[7] = 100;  // no other seed near it has a cell there
    CHECK(message([&] { test::streamed(set.points, options, little); }).find("has no cell near the others") !=
          std::string::npos);
}

TEST_CASE("stream: the convex hull") {
    for (const bool planar : {false, true})
        for (const PointSet& space : {test::clustered(3000, 2), test::cubic(14), test::on_walls(2000, 5),
                                      test::with_duplicates(2500, 500, 6), test::on_sphere_and_center(300, 4)}) {
            if (test::reduced() && space.name != "on walls") continue;
            CAPTURE(space.name);
            const PointSet set = planar ? test::in_plane(space) : space;
            votess::Options options = stream_options(set);
            options.box.reset();
            options.planar = planar;
            options.list_walls = true;
            const auto found = test::streamed(set.points, options, little, 100, planar, true, true);
            options.walls = votess::hull_walls(set.points, options);
            CHECK(test::difference(found, votess::tessellate(set.points, options)) == "");
            CHECK(found.rows.head.options.walls.size() == options.walls.size());
        }
    const PointSet flat = test::on_oblique_plane(100, 1);
    votess::Options options = stream_options(flat);
    options.box.reset();
    CHECK(message([&] { test::streamed(flat.points, options, little, 7, false, false, true); }) ==
          message([&] { (void)votess::hull_walls(flat.points, options); }));
    options.periodic = {true, false, false};
    CHECK(message([&] { test::streamed(flat.points, options, little, 7, false, false, true); }) ==
          "the convex hull and Options::periodic are both given: leave one out");
}

// Rows of a run in memory, damaged in one place and fed to the checker as a stream does.
TEST_CASE("stream: damaged rows are found") {
    const PointSet set = test::uniform(300, 4);
    votess::Options options = stream_options(set);
    options.periodic = {true, true, true};
    options.want.areas = options.list_walls = true;
    const auto whole = votess::tessellate(set.points, options);
    votess::BlockCells cells;
    const auto failure = [&](const auto& damage) {
        test::copy_arrays(whole, cells);
        damage();
        const votess::StreamRows rows = votess::rows_of(cells);
        Halves halves(set);
        votess::RowChecker checker({votess::settle(options), set.size(), whole.stats().box_volume},
                                   {.max_cells = set.size()}, halves);
        checker.take(rows);
        const votess::VerifyReport report = checker.report();
        CHECK(report.passed == report.failure.empty());
        return report.failure;
    };
    const std::string asymmetric =
        "the lists of neighbors are not symmetric: some seed lists another which does not list it";
    CHECK(failure([] {}) == "");
    CHECK(failure([&] { cells.volumes[7] *= 1.001; }).starts_with("volumes sum to "));
    CHECK(failure([&] { ++cells.edge_counts[9]; }).starts_with("cell 9 has "));
    const auto row = static_cast<std::size_t>(cells.indptr[100]), end = static_cast<std::size_t>(cells.indptr[101]);
    CHECK(failure([&] {
              std::swap(cells.indices[row], cells.indices[row + 1]);
          }).starts_with("the row of seed 100 does not ascend at "));
    CHECK(failure([&] { cells.indices[end - 1] = 299 - (cells.indices[end - 1] == 299); }) == asymmetric);
    for (std::size_t entry = row; entry < end; ++entry)  // the last of several faces with one seed
        if (entry + 1 == end || cells.indices[entry] != cells.indices[entry + 1]) {
            CHECK(failure([&] { ++cells.shifts[3 * entry]; }) == asymmetric);
            CHECK(failure([&] { ++cells.indices[entry]; }) != "");
        }
    CHECK(failure([&] { --cells.indptr[100]; }) != "");
    CHECK(failure([&] {
              cells.face_normals[3 * row] += 0.001;
          }).starts_with("cell 100 is not closed: area times normal "));
    // Damage that keeps the sums is found by brute force.
    CHECK(failure([&] {
              cells.volumes[3] += 1e-6;
              cells.volumes[5] -= 1e-6;
          }).starts_with("cell 3 has volume "));
    CHECK(failure([&] {
              cells.face_normals.clear();
              cells.face_areas[row] *= 1.001;
          }).starts_with("the face of cell 100 with "));
}

TEST_CASE("stream: pieces and memory of any size, and seeds that come once, give the same") {
    PointSet set = test::uniform(4000, 4);
    for (std::size_t i = 0; i < 300; ++i)  // duplicates, of earlier and later seeds
        std::copy_n(&set.points[3 * (11 * i)], 3, &set.points[3 * (3999 - 7 * i)]);
    const votess::Options options = stream_options(set);
    const auto whole = votess::tessellate(set.points, options);
    for (const std::size_t piece : {1, 100, 100000})
        for (const std::uint64_t memory : {little, 9 * little, 1000 * little}) {
            if (test::reduced() && piece != 100) continue;
            CAPTURE(piece);
            CAPTURE(memory);
            const bool once = memory == 9 * little;
            const test::Streamed found = test::streamed(set.points, options, memory, piece, once);
            CHECK(test::difference(found, whole) == "");
            CHECK((found.result.blocks == 1) == (memory > little));
            CHECK(found.result.temporary_bytes > 25 * set.size());
        }
}

TEST_CASE("stream: coordinates that float32 holds take half the room, and runs without rows make none") {
    PointSet set = test::uniform(3000, 5);
    votess::Options options = stream_options(set);
    options.want = {};
    options.want.neighbors = false;
    options.want.counts = true;
    const auto bytes = [&] {
        const auto whole = votess::tessellate(set.points, options);
        const test::Streamed found = test::streamed(set.points, options, little);
        CHECK(test::difference(found, whole) == "");
        CHECK(found.result.blocks > 1);
        return static_cast<double>(found.result.temporary_bytes) / static_cast<double>(set.size());
    };
    const double wide = bytes();
    for (double& x : set.points) x = static_cast<float>(x);
    const double narrow = bytes();
    CHECK(narrow < 0.7 * wide);
}

TEST_CASE("stream: errors name the seed of the whole input, and leave nothing behind") {
    const PointSet set = test::uniform(4000, 9);
    const auto with = [&](std::size_t at, double value) {
        std::vector<double> points = set.points;
        points[at] = value;
        return points;
    };
    votess::Options options = stream_options(set);
    CHECK(message([&] { test::streamed(with(3 * 3000 + 1, NAN), options, little); }) ==
          "point 3000: y = nan is not finite");
    CHECK(message([&] { test::streamed(with(3 * 3999 + 2, 2), options, little); }) ==
          "point 3999: z = 2 is outside the box, which spans 0 to 1, by 1: move it, or drop points outside "
          "(Options::outside = drop) or keep them (Options::outside = keep)");
    std::vector<double> radii(set.size(), 0.1);
    radii[2500] = -1;
    options.radii = radii;
    CHECK(message([&] { test::streamed(set.points, options, little); }) == "radius 2500 = -1 is negative");
    options.radii = {};
    options.walls.push_back({{1, 0, 0}, 0.9});
    options.outside = votess::Outside::error;
    CHECK(message([&] { test::streamed(set.points, options, little); }).starts_with("point "));
    options.walls.clear();

    test::StreamedRows rows;
    test::Pieces pieces(set.points, options, 100);
    const auto run = [&](const votess::Options& some, const votess::StreamOptions& stream) {
        return message([&] { (void)votess::tessellate_stream(pieces, rows, some, stream); });
    };
    CHECK(run(options, {.memory = 5, .temporary = ""}) ==
          "StreamOptions::memory = 5 bytes is too little: give at least 1000000");
    CHECK(run(options, {.memory = little, .temporary = "/nowhere at all"})
              .starts_with("the folder of temporary files '/nowhere at all' cannot be used: "));
    for (const unsigned what : {0u, 1u, 2u, 3u, 4u}) {
        votess::Options wrong = options;
        if (what == 0) wrong.want.faces = true;
        if (what == 1) wrong.min_face = 0.1;
        if (what == 2) wrong.duplicates = votess::Duplicates::error;
        if (what == 3) wrong.device = "gpu";
        if (what == 4) wrong.weights = radii;
        CHECK(run(wrong, {.memory = little, .temporary = ""}) != "nothing");
    }
    CHECK(rows.pieces == 0);
}

TEST_CASE("stream: log, progress, and stops") {
    const PointSet set = test::uniform(3000, 9);
    votess::Options options = stream_options(set);
    std::vector<std::string> logged;
    std::vector<double> fractions;
    options.log = [&](std::string_view text) { logged.emplace_back(text); };
    options.progress = [&](double fraction) {
        fractions.push_back(fraction);
        return true;
    };
    const test::Streamed found = test::streamed(set.points, options, little);
    CHECK(logged.size() == 6 + found.result.blocks);
    CHECK(logged[1].starts_with("about "));
    CHECK(std::ranges::is_sorted(fractions));
    CHECK(fractions.back() == 1);
    CHECK(found.result.stats.volume_sum == doctest::Approx(1).epsilon(1e-12));
    // After a stop at any call of progress the run ends with an error.
    for (std::size_t calls = 0; calls < fractions.size(); calls += test::by_size(2, 19)) {
        std::size_t left = calls;
        bool stops = false;  // a run may make fewer calls than the first one: their number depends on the time
        options.progress = [&](double) {
            stops |= left-- == 0;
            return !stops;
        };
        const std::string end = message([&] { test::streamed(set.points, options, little); });
        CHECK(end == (stops ? "cancelled by the progress callback" : "nothing"));
        CHECK((stops || calls > 0));
    }
    // An exception of the sink reaches the caller.
    struct Broken : votess::StreamSink {
        void rows(const votess::StreamRows&) override { throw std::runtime_error("the disk is full"); }
    } broken;
    test::Pieces pieces(set.points, options, 100);
    options.progress = {};
    CHECK_THROWS_WITH((void)votess::tessellate_stream(pieces, broken, options, {.memory = little, .temporary = ""}),
                      "the disk is full");
}
