// The option `want`: which arrays a result has.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <initializer_list>

#include "support/check.hpp"

TEST_SUITE("interface") {
    TEST_CASE("want: what is wanted with what it implies") {
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

    TEST_CASE("want: want_of takes words and the arrays that they stand for") {
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
            CHECK_THROWS_WITH_AS((void)votess::want_of(wrong), doctest::Contains("Options::want has '"), votess::Error);
        for (const auto& [wrong, meant] :
             {std::pair{"volume", "volumes"}, {"face", "faces"}, {"face_n", "face_normals"}})
            CHECK_THROWS_WITH_AS((void)votess::want_of(wrong),
                                 doctest::Contains((std::string("did you mean ") + meant + "?").c_str()),
                                 votess::Error);
    }

    TEST_CASE("want: what is wanted changes nothing in the rest") {
        const test::PointSet set = test::uniform(test::by_size(2000, 300), 53);
        const auto full = test::run(set);
        for (int bits = 0; bits < 32; ++bits) {
            votess::Options options = test::all_options();
            options.want = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0, (bits & 16) != 0};
            CAPTURE(bits);
            const auto t = test::run(set, options);
            CHECK(t.size() == set.size());
            CHECK(t.status().size() == set.size());
            if (bits & 17)  // areas add neighbors
                CHECK(test::rows_of(full) == test::rows_of(t));
            else
                CHECK(t.indices().empty());
            CHECK(t.face_areas().size() == (bits & 16 ? full.indices().size() : 0));
            CHECK(std::equal(t.face_areas().begin(), t.face_areas().end(), full.face_areas().begin()));
            CHECK(t.volumes().size() == (bits & 2 ? set.size() : 0));
            CHECK(std::equal(t.volumes().begin(), t.volumes().end(), full.volumes().begin()));
            CHECK(t.centroids().size() == (bits & 4 ? 3 * set.size() : 0));
            CHECK(std::equal(t.centroids().begin(), t.centroids().end(), full.centroids().begin()));
            CHECK(t.face_counts().size() == (bits & 8 ? set.size() : 0));
            CHECK(std::equal(t.vertex_counts().begin(), t.vertex_counts().end(), full.vertex_counts().begin()));
        }
    }
}
