// Against Qhull's Delaunay triangulation: a cell that no wall cuts has the Delaunay edges of its seed for neighbors.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <set>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "oracle/certificate.hpp"
#include "support/check.hpp"

namespace {

// The seeds of each simplex, ascending.
std::set<std::vector<std::int32_t>> delaunay_simplices(const test::Coordinates& points) {
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

    std::set<std::vector<std::int32_t>> simplices;
    facetT* facet;
    FORALLfacets {
        if (facet->upperdelaunay) continue;
        vertexT *vertex, **vertexp;
        std::vector<std::int32_t> ids;
        FOREACHvertex_(facet->vertices) ids.push_back(qh_pointid(qh, vertex->point));
        std::sort(ids.begin(), ids.end());
        simplices.insert(ids);
    }
    qh_freeqhull(qh, !qh_ALL);
    int long_blocks, long_bytes;
    qh_memfreeshort(qh, &long_blocks, &long_bytes);
    std::fclose(quiet);
    return simplices;
}

test::Rows delaunay_edges(const test::Coordinates& points) {
    std::vector<std::set<std::int32_t>> edges(points.size() / 3);
    for (const auto& ids : delaunay_simplices(points))
        for (const auto a : ids)
            for (const auto b : ids)
                if (a != b) edges[static_cast<std::size_t>(a)].insert(b);
    test::Rows rows;
    for (const auto& row : edges) rows.emplace_back(row.begin(), row.end());
    return rows;
}

void compare(const test::PointSet& set) {
    const auto t = test::run(set);
    const test::Rows theirs = delaunay_edges(set.points);
    std::size_t interior = 0, differing = 0;
    std::vector<std::size_t> apart;
    for (std::size_t i = 0; i < set.size(); ++i) {
        const auto ours = t.neighbors(i);
        if (ours.empty() || ours[0] < 0) continue;
        ++interior;
        std::vector<std::int32_t> pairs;
        std::set_symmetric_difference(ours.begin(), ours.end(), theirs[i].begin(), theirs[i].end(),
                                      std::back_inserter(pairs));
        differing += pairs.size();
        if (!pairs.empty()) apart.push_back(i);
    }
    CHECK(differing <= 200);
    if (!apart.empty()) CHECK(test::check_certificate(t, set.points, test::all_options(set.box), apart) == "");
    CHECK(interior > set.size() / 3);  // else this compared nothing
    MESSAGE(set.name << " " << set.size() << ": " << interior << " interior cells, " << differing
                     << " entries differ from Qhull");
}

// Of our simplices Qhull has each; of Qhull's we have those whose sphere has its center inside the box.
void compare_tetrahedra(const test::PointSet& set) {
    votess::Options options = test::all_options(set.box);
    options.want.faces = true;
    const auto t = votess::tessellate(set.points, options);
    const auto dual = votess::delaunay(t);
    const auto theirs = delaunay_simplices(set.points);
    std::size_t found = 0, cells_inside = 0;
    for (std::size_t s = 0; s < dual.tetrahedra_centers.size(); ++s) {
        std::vector<std::int32_t> ids(dual.tetrahedra.begin() + static_cast<std::ptrdiff_t>(4 * s),
                                      dual.tetrahedra.begin() + static_cast<std::ptrdiff_t>(4 * s + 4));
        const auto p = [&](std::size_t k, std::size_t axis) {
            return set.points[3 * static_cast<std::size_t>(ids[k]) + axis] -
                   set.points[3 * static_cast<std::size_t>(ids[0]) + axis];
        };
        const double six = p(1, 0) * (p(2, 1) * p(3, 2) - p(2, 2) * p(3, 1)) +
                           p(1, 1) * (p(2, 2) * p(3, 0) - p(2, 0) * p(3, 2)) +
                           p(1, 2) * (p(2, 0) * p(3, 1) - p(2, 1) * p(3, 0));
        REQUIRE(six > -1e-18);
        REQUIRE(ids[0] == std::ranges::min(ids));
        std::sort(ids.begin(), ids.end());
        found += theirs.contains(ids) ? 1 : 0;
    }
    CHECK(dual.polytope_centers.empty());
    CHECK(found == dual.tetrahedra_centers.size());
    // A cell off the walls has all its vertices, and so has its seed all its simplices.
    std::vector<bool> whole(set.size());
    for (std::size_t i = 0; i < set.size(); ++i) whole[i] = t.neighbors(i)[0] >= 0;
    for (const auto& ids : theirs)
        cells_inside += std::ranges::any_of(ids, [&](auto i) { return whole[static_cast<std::size_t>(i)]; }) ? 1 : 0;
    CHECK(cells_inside > 3 * set.size());
    CHECK(cells_inside <= found);
}

}  // namespace

TEST_SUITE("oracle") {
    TEST_CASE("Qhull: Delaunay tetrahedra of uniform seeds") {
        compare_tetrahedra(test::uniform(test::by_size(20000, 2000), 203));
    }
    TEST_CASE("Qhull: uniform seeds") {
        compare(test::uniform(test::by_size(20000, 2000), 201));
    }
    TEST_CASE("Qhull: clustered seeds") {
        compare(test::clustered(test::by_size(20000, 2000), 202));
    }
}
