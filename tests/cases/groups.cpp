// Sums over groups against plain code.
#include <doctest/doctest.h>

#include <map>
#include <set>
#include <utility>
#include <vector>
#include <votess/groups.hpp>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

std::size_t index(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

std::vector<double> random_points(std::size_t count, std::uint64_t rng_seed) {
    test::Random random(rng_seed);
    std::vector<double> points(3 * count);
    for (double& x : points) x = random.uniform();
    return points;
}

}  // namespace

TEST_CASE("groups: sums of volumes, areas and counts by plain code") {
    const std::size_t count = 90;
    std::vector<double> points = random_points(count, 3);
    points.insert(points.end(), points.begin(), points.begin() + 6);  // two duplicates
    std::vector<std::int64_t> labels;
    for (std::size_t i = 0; i < count + 2; ++i) labels.push_back(static_cast<std::int64_t>(i * i % 7) - 3);
    for (const bool periodic : {false, true}) {
        votess::Options options;
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        options.periodic.fill(periodic);
        options.want.areas = options.want.surfaces = true;
        options.list_walls = true;
        const votess::Tessellation t = votess::tessellate(points, options);
        const votess::Groups g = votess::groups(t, labels);
        std::map<std::pair<std::int64_t, std::int64_t>, std::pair<std::int64_t, double>> contacts;
        std::map<std::int64_t, double> volumes, surfaces;
        for (std::size_t i = 0; i < t.size(); ++i) {
            volumes[labels[i]] += t.volumes()[i];
            for (auto k = index(t.indptr()[i]); k < index(t.indptr()[i + 1]); ++k) {
                const std::int32_t j = t.indices()[k];
                const std::int64_t other = j < 0 ? 100 - j : labels[index(j)];
                if (other == labels[i]) continue;
                auto& [faces, area] = contacts[{labels[i], other}];
                ++faces;
                area += t.face_areas()[k];
                surfaces[labels[i]] += t.face_areas()[k];
            }
        }
        CHECK(g.labels == std::vector<std::int64_t>{-3, -2, -1, 1});
        CHECK(g.indices.size() == contacts.size());
        for (std::size_t a = 0; a < g.size(); ++a) {
            CHECK(g.volumes[a] == doctest::Approx(volumes[g.labels[a]]).epsilon(1e-12));
            CHECK(g.surface_areas[a] == doctest::Approx(surfaces[g.labels[a]]).epsilon(1e-12));
            for (auto k = index(g.indptr[a]); k < index(g.indptr[a + 1]); ++k) {
                const std::int32_t b = g.indices[k];
                const auto& [faces, area] = contacts[{g.labels[a], b < 0 ? 100 - b : g.labels[index(b)]}];
                CHECK(g.counts[k] == faces);
                CHECK(g.areas[k] == doctest::Approx(area).epsilon(1e-12));
            }
            for (auto m = index(g.member_indptr[a]); m < index(g.member_indptr[a + 1]); ++m)
                CHECK(labels[index(g.members[m])] == g.labels[a]);
        }
        CHECK(std::set<std::int32_t>(g.members.begin(), g.members.end()).size() == t.size());
    }
}

TEST_CASE("groups: refusals") {
    const std::vector<double> points = random_points(20, 1);
    votess::Options options;
    const std::vector<std::int64_t> labels(20);
    const auto t = votess::tessellate(points, options);
    CHECK_THROWS_WITH_AS((void)votess::groups(t, std::span(labels).subspan(1)),
                         "groups(): 19 labels for 20 seeds: give one for each", votess::Error);
    options.want.neighbors = false;
    CHECK_THROWS_WITH_AS((void)votess::groups(votess::tessellate(points, options), labels),
                         "groups(): the tessellation has no rows, set Options::want.neighbors", votess::Error);
}
