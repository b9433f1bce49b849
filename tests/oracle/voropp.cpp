// Against Voro++, which works in plain floating point. Cells that differ must be proven exactly.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <voro++/voro++.hh>

#include "oracle/certificate.hpp"
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

void compare(const test::PointSet& set) {
    votess::Options options = test::all_options(set.box);
    options.threads = 2;
    options.want.normals = true;
    const auto t = votess::tessellate(set.points, options);
    CHECK(test::check_invariants(t, set.points) == "");
    const VoroppResult theirs = voropp(set);

    std::size_t areas_apart = 0, normals_apart = 0;
    std::size_t differing = 0, volumes_apart = 0;
    std::vector<std::size_t> apart;
    for (std::size_t i = 0; i < set.size(); ++i) {
        const auto ours = t.neighbors(i);
        std::vector<std::int32_t> pairs;
        std::set_symmetric_difference(ours.begin(), ours.end(), theirs.rows[i].begin(), theirs.rows[i].end(),
                                      std::back_inserter(pairs));
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
        differing += pairs.size();
        // Voro++ cuts with an absolute tolerance, which small cells feel.
        const bool volume_apart = std::abs(t.volumes()[i] - theirs.volumes[i]) > 1e-9 * t.volumes()[i];
        volumes_apart += volume_apart;
        if (volume_apart || !pairs.empty()) apart.push_back(i);
    }
    CHECK(differing <= 500);
    CHECK(volumes_apart <= 500);
    // As with volumes, their tolerance shows in small cells.
    CHECK(areas_apart <= set.size() / 1000);
    CHECK(normals_apart <= set.size() / 1000);
    if (!apart.empty()) CHECK(test::check_certificate(t, set.points, options, apart) == "");
    MESSAGE(set.name << " " << set.size() << ": " << differing << " entries, " << volumes_apart << " volumes and "
                     << areas_apart << " areas differ from Voro++");
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
