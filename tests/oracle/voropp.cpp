// Against Voro++, which works in plain floating point: where the two differ, the exact test of that pair must side with
// votess.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <voro++/voro++.hh>

#include "oracle/brute_force.hpp"
#include "support/check.hpp"

namespace {

struct VoroppResult {
    test::Rows rows;
    std::vector<std::vector<double>> areas;    // beside the rows
    std::vector<std::vector<double>> normals;  // three for each area
    std::vector<double> volumes;
};

VoroppResult voropp(const test::PointSet& set) {
    const votess::Box& box = *set.box;
    const int blocks = std::max(1, static_cast<int>(std::cbrt(static_cast<double>(set.size()) / 6)));
    voro::container container(box.lower[0], box.upper[0], box.lower[1], box.upper[1], box.lower[2], box.upper[2],
                              blocks, blocks, blocks, false, false, false, 8);
    for (std::size_t i = 0; i < set.size(); ++i)
        container.put(static_cast<int>(i), set.points[3 * i], set.points[3 * i + 1], set.points[3 * i + 2]);
    const std::vector<std::vector<double>> no_values(set.size());
    VoroppResult result{test::Rows(set.size()), no_values, no_values, std::vector<double>(set.size())};
    voro::c_loop_all loop(container);
    voro::voronoicell_neighbor cell;
    if (loop.start()) do {
            if (!container.compute_cell(cell, loop)) continue;
            const auto i = static_cast<std::size_t>(loop.pid());
            std::vector<int> ids;
            std::vector<double> areas, normals;
            cell.neighbors(ids);
            cell.normals(normals);
            cell.face_areas(areas);
            std::vector<std::pair<int, std::size_t>> row;
            for (std::size_t k = 0; k < ids.size(); ++k) row.emplace_back(ids[k], k);
            std::sort(row.begin(), row.end());
            for (const auto& [id, k] : row) {
                result.rows[i].push_back(id);
                result.areas[i].push_back(areas[k]);
                for (std::size_t axis = 0; axis < 3; ++axis) result.normals[i].push_back(normals[3 * k + axis]);
            }
            result.volumes[i] = cell.volume();
        } while (loop.inc());
    return result;
}

// A cell is that of its seed and its neighbors alone.
double exact_cell_volume(const test::PointSet& set, const votess::Tessellation& t, std::size_t i) {
    test::Coordinates few(set.points.begin() + static_cast<std::ptrdiff_t>(3 * i),
                          set.points.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    for (const std::int32_t j : t.neighbors(i))
        for (std::size_t a = 0; j >= 0 && a < 3; ++a) few.push_back(set.points[3 * static_cast<std::size_t>(j) + a]);
    return test::brute_force(few, *set.box).cells[0].volume.get_d();
}

void compare(const test::PointSet& set) {
    votess::Options options = test::all_options(set.box);
    options.threads = 2;
    options.want.normals = true;
    const auto t = votess::tessellate(set.points, options);
    CHECK(test::check_invariants(t, set.points) == "");
    const VoroppResult theirs = voropp(set);

    std::size_t areas_apart = 0, normals_apart = 0;
    std::size_t differing = 0, in_our_favor = 0, cells_apart = 0, volumes_apart = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
        const auto ours = t.neighbors(i);
        std::vector<std::int32_t> pairs;
        std::set_symmetric_difference(ours.begin(), ours.end(), theirs.rows[i].begin(), theirs.rows[i].end(),
                                      std::back_inserter(pairs));
        cells_apart += !pairs.empty();
        const auto areas = t.face_areas().subspan(static_cast<std::size_t>(t.indptr()[i]), ours.size());
        const double surface = std::accumulate(areas.begin(), areas.end(), 0.0);
        const auto normals = t.face_normals().subspan(static_cast<std::size_t>(3 * t.indptr()[i]), 3 * ours.size());
        for (std::size_t k = 0; k < ours.size() && pairs.empty(); ++k) {
            areas_apart += std::abs(areas[k] - theirs.areas[i][k]) > 1e-9 * surface;
            // Theirs are cross products of edges: of a tiny face they have few digits, or are 0.
            double apart = 0;
            for (std::size_t axis = 3 * k; axis < 3 * k + 3; ++axis)
                apart = std::max(apart, std::abs(normals[axis] - theirs.normals[i][axis]));
            normals_apart += areas[k] > 1e-3 * surface && apart > 1e-6;
        }
        for (const std::int32_t j : pairs) {
            if (++differing > 500) continue;
            const bool we_list = std::binary_search(ours.begin(), ours.end(), j);
            const bool right = test::exact_face(set.points, *set.box, i, j) == we_list;
            in_our_favor += right;
            if (!right) FAIL_CHECK(set.name << ": votess is wrong on " << i << " " << j << ", listed " << we_list);
        }
        // Voro++ cuts with an absolute tolerance, which small cells feel: there the exact volume decides.
        const double volume = t.volumes()[i];
        if (std::abs(volume - theirs.volumes[i]) > 1e-9 * volume && ++volumes_apart <= 500) {
            const double exact = exact_cell_volume(set, t, i);
            if (std::abs(volume - exact) > 1e-10 * exact)
                FAIL_CHECK(set.name << ": volume " << i << " is " << volume << " instead of " << exact);
        }
    }
    CHECK(differing <= 500);
    CHECK(volumes_apart <= 500);
    // As with volumes, their tolerance shows in small cells.
    CHECK(areas_apart <= set.size() / 1000);
    CHECK(normals_apart <= set.size() / 1000);
    MESSAGE(set.name << " " << set.size() << ": " << differing << " entries in " << cells_apart
                     << " cells differ from Voro++, " << in_our_favor << " of them exactly in favor of votess; "
                     << volumes_apart << " volumes and " << areas_apart << " areas differ by more than 1e-9");
}

}  // namespace

TEST_SUITE("oracle") {
    TEST_CASE("Voro++: uniform seeds") {
        compare(test::uniform(test::by_size(100000, 5000), 101));
    }
    TEST_CASE("Voro++: clustered seeds") {
        compare(test::clustered(test::by_size(100000, 5000), 102));
    }
    TEST_CASE("Voro++: jittered lattice") {
        compare(test::jittered(test::by_size(27, 12), 0.2, 103));
    }
}
