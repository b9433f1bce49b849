// Periodic, triclinic and power cells of Voro++ (Rycroft, Chaos 19, 041111, 2009) on the same seeds.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>
#include <voro++/voro++.hh>
#include <votess/votess.hpp>

#include "oracle/half_spaces.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using votess::Options;

struct TheirCell {
    bool there = false;
    double volume = 0, surface = 0;
    std::vector<std::pair<int, double>> faces;  // ids ascending, areas
};

template <class Container, class Loop>
std::vector<TheirCell> cells_of(Container& container, std::size_t count) {
    std::vector<TheirCell> cells(count);
    Loop loop(container);
    voro::voronoicell_neighbor cell;
    std::vector<int> ids;
    std::vector<double> areas;
    if (loop.start()) do {
            if (!container.compute_cell(cell, loop)) continue;
            TheirCell& theirs = cells[static_cast<std::size_t>(loop.pid())];
            theirs.there = true;
            theirs.volume = cell.volume();
            theirs.surface = cell.surface_area();
            cell.neighbors(ids);
            cell.face_areas(areas);
            for (std::size_t f = 0; f < ids.size(); ++f) theirs.faces.emplace_back(ids[f], areas[f]);
            std::ranges::sort(theirs.faces);
        } while (loop.inc());
    return cells;
}

int blocks_for(std::size_t count, double length, double volume) {
    return std::max(1, static_cast<int>(length * std::cbrt(static_cast<double>(count) / volume / 6)));
}

// Voro++ decides faces in floating point: what one has and the other has not must be too small for it to tell.
std::string compare(const votess::Tessellation& t, const std::vector<TheirCell>& cells) {
    constexpr double too_small = 1e-9;  // of a cell's surface
    for (std::size_t i = 0; i < t.size(); ++i) {
        const TheirCell& theirs = cells[i];
        const auto name = "cell " + std::to_string(i);
        if (theirs.there != (t.status()[i] == votess::CellStatus::certified)) return name + " is there in one only";
        if (!theirs.there) continue;
        if (!(std::abs(t.volumes()[i] - theirs.volume) <= 1e-9 * theirs.volume)) return name + " differs in volume";
        std::vector<std::pair<int, double>> ours;
        const auto row = t.neighbors(i);
        for (std::size_t k = 0; k < row.size(); ++k)
            ours.emplace_back(row[k], t.face_areas()[static_cast<std::size_t>(t.indptr()[i]) + k]);
        std::ranges::sort(ours);
        for (std::size_t a = 0, b = 0; a < ours.size() || b < theirs.faces.size();) {
            const bool same = a < ours.size() && b < theirs.faces.size() && ours[a].first == theirs.faces[b].first &&
                              std::abs(ours[a].second - theirs.faces[b].second) <= 1e-8 * theirs.surface;
            if (same) {
                ++a, ++b;
                continue;
            }
            const bool is_ours = b == theirs.faces.size() || (a < ours.size() && ours[a] < theirs.faces[b]);
            const auto& face = is_ours ? ours[a++] : theirs.faces[b++];
            if (face.second > too_small * theirs.surface)
                return name + ": only " + (is_ours ? "votess" : "Voro++") + " has a face with " +
                       std::to_string(face.first) + " of area " + std::to_string(face.second);
        }
    }
    return "";
}

Coordinates random_points(std::size_t n, std::uint64_t seed, const std::array<double, 3>& size) {
    test::Random random(seed);
    Coordinates points(3 * n);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = random.uniform(0, size[i % 3]);
    return points;
}

Options domain_options() {
    Options options = test::all_options(test::unit_box());
    options.want.areas = true;
    return options;
}

votess::Tessellation tessellate(const Coordinates& points, const Options& options) {
    return votess::tessellate(std::span<const double>(points), options);
}

}  // namespace

TEST_SUITE("oracle") {
    TEST_CASE("voro++: periodic boxes, each subset of the axes") {
        for (const std::size_t n : {std::size_t{1}, std::size_t{2}, std::size_t{8}, test::by_size(10000, 1000)})
            for (unsigned mask = 1; mask < 8; ++mask) {
                const Coordinates points = random_points(n, 10 * n + mask, {1, 1, 1});
                Options options = domain_options();
                for (unsigned k = 0; k < 3; ++k) options.periodic[k] = ((mask >> k) & 1) != 0;
                const auto t = tessellate(points, options);
                const int blocks = blocks_for(n, 1, 1);
                voro::container container(0, 1, 0, 1, 0, 1, blocks, blocks, blocks, options.periodic[0],
                                          options.periodic[1], options.periodic[2], 8);
                for (std::size_t i = 0; i < n; ++i)
                    container.put(static_cast<int>(i), points[3 * i], points[3 * i + 1], points[3 * i + 2]);
                CAPTURE(n);
                CAPTURE(mask);
                CHECK(test::check_domain(t) == "");
                CHECK(compare(t, cells_of<voro::container, voro::c_loop_all>(container, n)) == "");
            }
    }

    TEST_CASE("voro++: triclinic cells, tilted and of high aspect") {
        for (const double tilt : {-0.45, 0.45})
            for (const double aspect : {1.0, 20.0})
                for (const std::size_t n :
                     {std::size_t{1}, std::size_t{2}, std::size_t{8}, test::by_size(10000, 500)}) {
                    const double bx = aspect, by = 1, bz = 1;
                    const Coordinates points = random_points(n, n + 7, {bx, by, bz});
                    Options options = domain_options();
                    options.box.reset();
                    options.cell =
                        votess::TriclinicBox{{0, 0, 0}, {bx, 0, 0}, {tilt * bx, by, 0}, {-tilt * bx, tilt * by, bz}};
                    const auto t = tessellate(points, options);
                    voro::container_periodic container(bx, tilt * bx, by, -tilt * bx, tilt * by, bz,
                                                       blocks_for(n, bx, bx), blocks_for(n, by, bx),
                                                       blocks_for(n, bz, bx), 8);
                    for (std::size_t i = 0; i < n; ++i)
                        container.put(static_cast<int>(i), points[3 * i], points[3 * i + 1], points[3 * i + 2]);
                    CAPTURE(tilt);
                    CAPTURE(aspect);
                    CAPTURE(n);
                    CHECK(test::check_domain(t) == "");
                    CHECK(compare(t, cells_of<voro::container_periodic, voro::c_loop_all_periodic>(container, n)) ==
                          "");
                }
    }

    TEST_CASE("voro++: power diagrams of radii, in a box and periodic") {
        for (const bool periodic : {false, true}) {
            const std::size_t n = test::by_size(10000, 1000);
            const Coordinates points = random_points(n, 3, {1, 1, 1});
            test::Random random(4);
            std::vector<double> radii(n);
            for (double& r : radii) r = random.uniform(0, 0.05);
            Options options = domain_options();
            options.radii = radii;
            options.periodic = {periodic, periodic, periodic};
            const auto t = tessellate(points, options);
            const int blocks = blocks_for(n, 1, 1);
            voro::container_poly container(0, 1, 0, 1, 0, 1, blocks, blocks, blocks, periodic, periodic, periodic, 8);
            for (std::size_t i = 0; i < n; ++i)
                container.put(static_cast<int>(i), points[3 * i], points[3 * i + 1], points[3 * i + 2], radii[i]);
            CAPTURE(periodic);
            CHECK(test::check_domain(t) == "");
            CHECK(compare(t, cells_of<voro::container_poly, voro::c_loop_all>(container, n)) == "");
        }
    }

    TEST_CASE("power diagrams: weights that bury half of the seeds") {
        const std::size_t n = test::by_size(10000, 1000);
        const Coordinates points = random_points(n, 5, {1, 1, 1});
        test::Random random(6);
        std::vector<double> weights(n);
        for (double& w : weights) w = random.uniform(-0.5, 0.5) * std::pow(static_cast<double>(n), -2.0 / 3) * 2;
        Options options = domain_options();
        options.weights = weights;
        const auto t = tessellate(points, options);
        CHECK(t.stats().empty_cells > n / 4);
        CHECK(test::check_domain(t) == "");
        CHECK(votess::verify(t, points).failure == "");
    }
}
