// Against Qhull's Delaunay triangulation: a cell that no wall cuts has the Delaunay edges of its seed for neighbors.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <set>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "../support/check.hpp"
#include "brute_force.hpp"

namespace {

test::Rows delaunay_edges(const test::Coordinates& points) {
    const auto n = points.size() / 3;
    test::Coordinates copy = points;  // Qhull scales its input in place
    qhT memory;
    qhT* qh = &memory;
    QHULL_LIB_CHECK
    qh_zero(qh, nullptr);
    char options[] = "qhull d Qbb Qt Pp";
    std::FILE* quiet = std::tmpfile();
    REQUIRE(quiet != nullptr);
    const int exit_code = qh_new_qhull(qh, 3, static_cast<int>(n), copy.data(), False, options, quiet, quiet);
    REQUIRE(exit_code == 0);

    std::vector<std::set<std::int32_t>> edges(n);
    facetT* facet;
    FORALLfacets {
        if (facet->upperdelaunay) continue;
        vertexT *vertex, **vertexp;
        std::vector<std::int32_t> ids;
        FOREACHvertex_(facet->vertices) ids.push_back(qh_pointid(qh, vertex->point));
        for (const auto a : ids)
            for (const auto b : ids)
                if (a != b) edges[static_cast<std::size_t>(a)].insert(b);
    }
    qh_freeqhull(qh, !qh_ALL);
    int long_blocks, long_bytes;
    qh_memfreeshort(qh, &long_blocks, &long_bytes);
    std::fclose(quiet);

    test::Rows rows;
    for (const auto& row : edges) rows.emplace_back(row.begin(), row.end());
    return rows;
}

void compare(const test::PointSet& set) {
    const auto t = test::run(set);
    const test::Rows theirs = delaunay_edges(set.points);
    std::size_t interior = 0, differing = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
        const auto ours = t.neighbors(i);
        if (ours.empty() || ours[0] < 0) continue;
        ++interior;
        std::vector<std::int32_t> pairs;
        std::set_symmetric_difference(ours.begin(), ours.end(), theirs[i].begin(), theirs[i].end(),
                                      std::back_inserter(pairs));
        for (const std::int32_t j : pairs) {
            if (++differing > 200) continue;
            const bool we_list = std::binary_search(ours.begin(), ours.end(), j);
            if (test::exact_face(set.points, *set.box, i, j) != we_list)
                FAIL_CHECK(set.name << ": votess is wrong on " << i << " " << j << ", listed " << we_list);
        }
    }
    CHECK(differing <= 200);
    CHECK(interior > set.size() / 3);  // else this compared nothing
    MESSAGE(set.name << " " << set.size() << ": " << interior << " interior cells, " << differing
                     << " entries differ from Qhull");
}

}  // namespace

TEST_SUITE("oracle") {
    TEST_CASE("Qhull: uniform seeds") {
        compare(test::uniform(test::by_size(20000, 2000), 201));
    }
    TEST_CASE("Qhull: clustered seeds") {
        compare(test::clustered(test::by_size(20000, 2000), 202));
    }
}
