// Against Voro++ (Rycroft, Chaos 19, 041111, 2009), which works in plain floating point and cuts with an absolute
// tolerance. Cells that differ are proven exactly.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <voro++/voro++.hh>

#include "oracle/certificate.hpp"
#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using votess::Options;

struct TheirFace {
    int id = 0;
    double area = 0;
    std::array<double, 3> normal{};
};

struct TheirCell {
    bool exists = false;
    double volume = 0;
    std::vector<TheirFace> faces;  // ids ascending, then areas
};

template <class Container, class Loop>
std::vector<TheirCell> cells_of(Container& container, std::size_t count) {
    std::vector<TheirCell> cells(count);
    Loop loop(container);
    voro::voronoicell_neighbor cell;
    std::vector<int> ids;
    std::vector<double> areas, normals;
    if (loop.start()) do {
            if (!container.compute_cell(cell, loop)) continue;
            TheirCell& theirs = cells[static_cast<std::size_t>(loop.pid())];
            theirs.exists = true;
            theirs.volume = cell.volume();
            cell.neighbors(ids);
            cell.face_areas(areas);
            cell.normals(normals);
            for (std::size_t f = 0; f < ids.size(); ++f)
                theirs.faces.push_back({ids[f], areas[f], {normals[3 * f], normals[3 * f + 1], normals[3 * f + 2]}});
            std::ranges::sort(theirs.faces, {}, [](const TheirFace& face) { return std::pair(face.id, face.area); });
        } while (loop.inc());
    return cells;
}

// Returns whether rows, volumes, areas and normals agree. Normals are theirs only of faces that are not tiny.
bool agrees(const votess::Tessellation& t, std::size_t i, const TheirCell& theirs) {
    if (theirs.exists != (t.status()[i] == votess::CellStatus::certified)) return false;
    if (!theirs.exists) return true;
    const auto row = t.neighbors(i);
    if (row.size() != theirs.faces.size() || !(std::abs(t.volumes()[i] - theirs.volume) <= 1e-9 * theirs.volume))
        return false;
    std::vector<std::size_t> order;  // of images with the same id, by area
    double surface = 0;
    const auto first = static_cast<std::size_t>(t.indptr()[i]);
    for (std::size_t e = first; e < first + row.size(); ++e) order.push_back(e), surface += t.face_areas()[e];
    std::ranges::sort(order, {}, [&](std::size_t e) { return std::pair(t.indices()[e], t.face_areas()[e]); });
    for (std::size_t k = 0; k < order.size(); ++k) {
        const TheirFace& face = theirs.faces[k];
        const double area = t.face_areas()[order[k]];
        if (t.indices()[order[k]] != face.id || std::abs(area - face.area) > 1e-9 * surface) return false;
        // Images with the same id and nearly the same area may stand in another order.
        const bool alone = std::ranges::count(row, face.id) == 1;
        for (std::size_t axis = 0; axis < 3 && alone && area > 1e-3 * surface; ++axis)
            if (std::abs(t.face_normals()[3 * order[k] + axis] - face.normal[axis]) > 1e-6) return false;
    }
    return true;
}

void compare(const Coordinates& points, const Options& options, const std::vector<TheirCell>& cells) {
    const auto t = votess::tessellate(points, options);
    const bool is_box = !options.cell && options.periodic == std::array<bool, 3>{} && options.weights.empty();
    CHECK((is_box ? test::check_invariants(t, points) : test::check_domain(t)) == "");
    std::vector<std::size_t> apart;
    for (std::size_t i = 0; i < t.size(); ++i)
        if (!agrees(t, i, cells[i])) apart.push_back(i);
    INFO(apart.size() << " of " << t.size() << " cells differ");
    CHECK(apart.size() <= 1 + t.size() / 500);
    if (!apart.empty()) CHECK(test::check_certificate(t, points, options, apart) == "");
}

int blocks_for(std::size_t count, double length, double volume) {
    return std::max(1, static_cast<int>(length * std::cbrt(static_cast<double>(count) / volume / 6)));
}

Coordinates random_points(std::size_t n, std::uint64_t seed, const std::array<double, 3>& size) {
    test::Random random(seed);
    Coordinates points(3 * n);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = random.uniform(0, size[i % 3]);
    return points;
}

// Options for two threads, with areas and normals.
Options measured(const std::optional<votess::Box>& box) {
    Options options = test::all_options(box);
    options.want.normals = true;
    options.threads = 2;
    return options;
}

void compare_box(const Coordinates& points, const votess::Box& box, const std::array<bool, 3>& periodic = {}) {
    const std::size_t n = points.size() / 3;
    Options options = measured(box);
    options.periodic = periodic;
    const int blocks = blocks_for(n, 1, 1);
    voro::container container(box.lower[0], box.upper[0], box.lower[1], box.upper[1], box.lower[2], box.upper[2],
                              blocks, blocks, blocks, periodic[0], periodic[1], periodic[2], 8);
    for (std::size_t i = 0; i < n; ++i)
        container.put(static_cast<int>(i), points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    compare(points, options, cells_of<voro::container, voro::c_loop_all>(container, n));
}

}  // namespace

TEST_SUITE("oracle") {
    TEST_CASE("Voro++: boxes") {
        for (const test::PointSet& set :
             {test::uniform(test::by_size(20000, 5000), 101), test::clustered(test::by_size(20000, 5000), 102),
              test::jittered(test::by_size(27, 12), 0.2, 103)}) {
            CAPTURE(set.name);
            compare_box(set.points, *set.box);
        }
    }

    TEST_CASE("Voro++: periodic boxes, each subset of the axes") {
        for (const std::size_t n : {std::size_t{1}, std::size_t{2}, std::size_t{8}, test::by_size(4000, 1000)})
            for (unsigned mask = 1; mask < 8; ++mask) {
                CAPTURE(n);
                CAPTURE(mask);
                compare_box(random_points(n, 10 * n + mask, {1, 1, 1}), test::unit_box(),
                            {(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0});
            }
    }

    TEST_CASE("Voro++: triclinic cells, tilted and of high aspect") {
        for (const double tilt : {-0.45, 0.45})
            for (const double aspect : {1.0, 20.0})
                for (const std::size_t n : {std::size_t{1}, std::size_t{2}, std::size_t{8}, test::by_size(4000, 500)}) {
                    CAPTURE(tilt);
                    CAPTURE(aspect);
                    CAPTURE(n);
                    const double bx = aspect, by = 1, bz = 1;
                    const Coordinates points = random_points(n, n + 7, {bx, by, bz});
                    Options options = measured({});
                    options.cell =
                        votess::TriclinicBox{{0, 0, 0}, {bx, 0, 0}, {tilt * bx, by, 0}, {-tilt * bx, tilt * by, bz}};
                    voro::container_periodic container(bx, tilt * bx, by, -tilt * bx, tilt * by, bz,
                                                       blocks_for(n, bx, bx), blocks_for(n, by, bx),
                                                       blocks_for(n, bz, bx), 8);
                    for (std::size_t i = 0; i < n; ++i)
                        container.put(static_cast<int>(i), points[3 * i], points[3 * i + 1], points[3 * i + 2]);
                    compare(points, options,
                            cells_of<voro::container_periodic, voro::c_loop_all_periodic>(container, n));
                }
    }

    TEST_CASE("Voro++: power diagrams of radii, in a box and periodic") {
        const std::size_t n = test::by_size(10000, 1000);
        const Coordinates points = random_points(n, 3, {1, 1, 1});
        test::Random random(4);
        std::vector<double> radii(n), weights;
        for (double& r : radii) r = random.uniform(0, 0.05), weights.push_back(r * r);
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            Options options = measured(test::unit_box());
            options.weights = weights;
            options.periodic = {periodic, periodic, periodic};
            const int blocks = blocks_for(n, 1, 1);
            voro::container_poly container(0, 1, 0, 1, 0, 1, blocks, blocks, blocks, periodic, periodic, periodic, 8);
            for (std::size_t i = 0; i < n; ++i)
                container.put(static_cast<int>(i), points[3 * i], points[3 * i + 1], points[3 * i + 2], radii[i]);
            compare(points, options, cells_of<voro::container_poly, voro::c_loop_all>(container, n));
            Options of_radii = options;
            of_radii.weights = {};
            of_radii.radii = radii;
            CHECK(test::check_identical(votess::tessellate(points, options), votess::tessellate(points, of_radii)) ==
                  "");
        }
    }
}
