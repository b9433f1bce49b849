// Cells of blocks against those of all seeds at once.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "blocks/in_blocks.hpp"
#include "fuzz/kinds/kinds.hpp"
#include "input/settle.hpp"
#include "support/check.hpp"
#include "support/in_plane.hpp"
#include "support/random.hpp"
#include "support/scattered.hpp"

namespace {

using test::PointSet;

votess::Options block_options(const PointSet& set) {
    votess::Options options;
    options.device = "cpu";
    options.threads = 1;
    options.box = set.box;
    options.list_walls = true;
    options.want.counts = options.want.centroids = options.want.areas = options.want.normals = true;
    options.want.surfaces = options.want.radii = true;
    return options;
}

void check_blocks(const PointSet& set, const votess::Options& options) {
    const auto whole = votess::tessellate(set.points, options);
    for (const std::size_t blocks : {1, 3, 8}) {
        CAPTURE(set.name);
        CAPTURE(blocks);
        CHECK(test::difference(test::in_blocks(set.points, options, blocks), whole) == "");
    }
}

}  // namespace

TEST_CASE("blocks: the families have the lists of all seeds at once") {
    for (const PointSet& set : test::families(test::by_size(600, 80), 5)) check_blocks(set, block_options(set));
    check_blocks({"three", {0.1, 0.2, 0.3, 0.5, 0.5, 0.4, 0.9, 0.1, 0.8}, test::unit_box()},
                 block_options({"", {}, test::unit_box()}));
    check_blocks({"none", {}, test::unit_box()}, block_options({"", {}, test::unit_box()}));
}

TEST_CASE("blocks: periodic along each subset of the axes") {
    const std::size_t many = test::by_size(1000, 150);
    for (unsigned axes = 1; axes < 8; axes += test::reduced() ? 2 : 1)
        for (const PointSet& set :
             {test::uniform(many, axes), test::clustered(many, axes), test::cubic(many > 1000 ? 10 : 5)}) {
            votess::Options options = block_options(set);
            options.periodic = {(axes & 1) != 0, (axes & 2) != 0, (axes & 4) != 0};
            check_blocks(set, options);
        }
}

TEST_CASE("blocks: seeds outside that are kept") {
    test::Scattered s;
    for (int kind = 0; kind < test::kinds_of_scattered; ++kind)
        for (const bool weighted : {false, true}) {
            CAPTURE(kind);
            CAPTURE(weighted);
            test::scatter(kind, test::by_size(800, 150), kind % 2 == 0 ? 0.2 : 1.5, weighted, 9, s);
            check_blocks({"scattered", s.points, s.options.box}, s.options);
        }
}

TEST_CASE("blocks: triclinic boxes, weights and walls") {
    test::Random random(3);
    const std::size_t many = test::by_size(1000, 200);
    for (const PointSet& set : {test::uniform(many, 1), test::clustered(many, 2)}) {
        votess::Options options = block_options(set);
        options.box.reset();
        options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}, {true, true, true}};
        check_blocks(set, options);
        options.cell->c = {7.3, 5.2, 1};  // skewed
        check_blocks(set, options);
        options.cell->periodic = {true, false, true};
        options.outside = votess::Outside::drop;
        check_blocks(set, options);

        std::vector<double> radii(set.size());
        for (double& r : radii) r = random.uniform(0, 0.15);
        options = block_options(set);
        options.radii = radii;
        check_blocks(set, options);
        options.periodic = {true, true, true};
        check_blocks(set, options);

        options = block_options(set);
        options.outside = votess::Outside::drop;
        options.walls = test::octahedron(0.6);
        check_blocks(set, options);
    }
}

TEST_CASE("blocks: sets of the kinds of the fuzz") {
    std::uint64_t sets = 0;
    for (const test::fuzz::Kind& kind : test::fuzz::all_kinds()) {
        const std::uint64_t usual = kind.name == "many" ? 1 : 12;
        const std::uint64_t count = test::by_size(usual, usual / 10 + 1);
        for (std::uint64_t number = 1; number <= count; ++number) {
            CAPTURE(kind.name);
            CAPTURE(number);
            for (const test::fuzz::Job& job : test::fuzz::make_case(kind, number).jobs) {
                votess::Options options = job.options("cpu");
                options.want = {};
                options.want.counts = options.want.centroids = options.want.areas = options.want.normals = true;
                options.want.surfaces = options.want.radii = true;
                try {
                    const auto whole = votess::tessellate(job.points, options);
                    ++sets;
                    const std::string wrong =
                        test::difference(test::in_blocks(job.points, options, 2 + number % 4), whole);
                    CHECK(wrong == "");
                } catch (const votess::Error& error) {
                    // Some sets are refused on purpose. In a skewed cell a block may meet neighbors too far away.
                    CHECK(error.code() != votess::ErrorCode::internal);
                }
            }
        }
    }
    CHECK(sets > 10);
}

// Each set in its hull, and its x and y in the plane, in a box and in their hull.
TEST_CASE("blocks: sets of the kinds of the fuzz in the plane and in their hull") {
    std::uint64_t sets = 0;
    const std::uint64_t usual = test::by_size(4, 1);
    for (const test::fuzz::Kind& kind : test::fuzz::all_kinds()) {
        const std::uint64_t count = kind.name == "many" ? usual / 4 : usual;
        for (std::uint64_t number = 1; number <= count; ++number)
            for (const test::fuzz::Job& job : test::fuzz::make_case(kind, number).jobs)
                for (const int domain : {0, 2, 4}) {
                    CAPTURE(kind.name);
                    CAPTURE(number);
                    CAPTURE(domain);
                    PointSet set{"", job.points, {}};
                    votess::Options options = job.options("cpu");
                    options.planar = domain < 3;
                    options.want = {};
                    options.want.counts = options.want.centroids = options.want.areas = options.want.normals = true;
                    options.want.surfaces = options.want.radii = true;
                    options.walls.clear();
                    options.cell.reset();
                    options.box.reset();
                    options.outside = votess::Outside::error;
                    options.periodic = {};
                    if (options.planar) set = test::in_plane(set);
                    try {
                        if (domain != 0) options.walls = votess::hull_walls(set.points, options);
                        const auto whole = votess::tessellate(set.points, options);
                        const auto found = test::in_blocks(set.points, options, 2 + number % 4);
                        CHECK(test::difference(found, whole) == "");
                        ++sets;
                    } catch (const votess::Error& error) {
                        CHECK(error.code() != votess::ErrorCode::internal);
                    }
                }
    }
    CHECK(sets > 10);
}

TEST_CASE("blocks: what is refused, and by which words") {
    const auto message = [](const auto& work) {
        try {
            work();
        } catch (const votess::Error& error) {
            return std::string(error.what());
        }
        return std::string("nothing");
    };
    const votess::Box box = test::unit_box();
    votess::Options options;
    options.box = box;
    const votess::BlockDomain domain(votess::settle(options), box, 2);
    const std::vector<double> points{0.1, 0.2, 0.3, 0.7, 0.6, 0.5}, outside{0.1, 0.2, 0.3, 0.7, 1.5, 0.5};
    const std::vector<std::int64_t> ids{4, 9}, equal{4, 4};
    CHECK(message([&] { (void)domain.check(outside); }).starts_with("point 1: y = 1.5 is outside the box"));
    CHECK(message([&] { (void)domain.blocks_of(points); }) == "blocks_of() before split()");
    CHECK(message([&] { votess::Block(domain, equal, points); }) ==
          "ids of a block must ascend from 0 on: the one at 1 is 4");
    CHECK(message([&] { votess::Block(domain, ids, std::span(points).first(3)); }).starts_with("ids, points, weights"));
    for (const unsigned what : {0u, 1u, 2u, 3u}) {
        votess::Options wrong = options;
        if (what == 0) wrong.want.faces = true;
        if (what == 1) wrong.min_face = 0.1;
        if (what == 2) wrong.duplicates = votess::Duplicates::error;
        if (what == 3) wrong.device = "gpu";
        CHECK(message([&] { votess::BlockDomain(votess::settle(wrong), box, 2); }) != "nothing");
    }
    votess::Block block(domain, ids, points);
    votess::Message outline = block.outline();
    CHECK(!outline.empty());
    outline.pop_back();
    CHECK(message([&] { (void)block.halo_for(outline); }) ==
          "a message between blocks was not written by this version of votess");
    CHECK(block.halo_for({}).empty());
}
