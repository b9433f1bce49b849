// Inputs for ranks, in domains of all kinds.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

#include "support/generators.hpp"
#include "support/in_plane.hpp"
#include "support/random.hpp"

namespace test {

struct Input {
    std::string name;
    std::vector<double> points;
    votess::Options options;
    std::vector<double> radii;
    bool hull = false;  // the domain is that of the points
    [[nodiscard]] std::size_t dimensions() const { return options.planar ? 2 : 3; }
    [[nodiscard]] std::size_t size() const { return points.size() / dimensions(); }
};

inline votess::Options usual_options() {
    votess::Options options;
    options.device = "cpu";
    options.threads = 1;
    options.list_walls = true;
    options.want.counts = options.want.centroids = options.want.areas = true;
    return options;
}

inline Input input_of(const PointSet& set, const std::string& more = "") {
    Input input{set.name + more, set.points, usual_options(), {}};
    input.options.box = set.box;
    return input;
}

// A few inputs, for tests of something else.
inline std::vector<Input> some_inputs(std::uint64_t seed) {
    return {input_of(uniform(1000, seed)), input_of(clustered(1000, seed))};
}

inline std::vector<Input> all_inputs() {
    std::vector<Input> all;
    all.push_back(input_of(uniform(2000, 1)));
    all.push_back(input_of(clustered(2000, 2)));
    Input corner = input_of(clustered(2000, 3), ", all in one corner");
    for (double& x : corner.points) x *= 1e-3;
    all.push_back(corner);
    all.push_back(input_of(cubic(10)));
    all.push_back(input_of(bcc(8)));
    all.push_back(input_of(with_duplicates(500, 100, 4)));
    all.push_back(input_of(near_duplicates(500, 5)));
    const std::vector<double> three{0.1, 0.2, 0.3, 0.5, 0.5, 0.4, 0.9, 0.1, 0.8};
    all.push_back(input_of({"three", three, unit_box()}));
    all.push_back(input_of({"three without a box", three, {}}));
    all.push_back(input_of({"none", {}, unit_box()}));
    for (unsigned axes = 1; axes < 8; ++axes)
        for (const PointSet& set : {uniform(1000, axes), cubic(8)}) {
            all.push_back(input_of(set, ", periodic along " + std::to_string(axes)));
            all.back().options.periodic = {(axes & 1) != 0, (axes & 2) != 0, (axes & 4) != 0};
        }
    Input tilted = input_of(uniform(1500, 6), ", triclinic");
    tilted.options.box.reset();
    tilted.options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}, {true, true, true}};
    all.push_back(tilted);
    Random random(7);
    for (const bool periodic : {false, true}) {
        Input radii = input_of(uniform(1500, 8), ", radii");
        radii.options.periodic = {periodic, periodic, periodic};
        for (std::size_t i = 0; i < radii.size(); ++i) radii.radii.push_back(random.uniform(0, 0.15));
        all.push_back(radii);
    }
    Input octahedron = input_of(uniform(1500, 9), ", octahedron");
    octahedron.options.outside = votess::Outside::drop;
    octahedron.options.walls = test::octahedron(0.6);
    all.push_back(octahedron);
    // In slices some ranks hand in dropped seeds alone.
    Input dropped = input_of(uniform(1000, 12), ", the first half is dropped");
    for (std::size_t i = 0; i < dropped.points.size() / 2; i += 3) dropped.points[i] += 1.5;
    dropped.options.outside = votess::Outside::drop;
    dropped.options.want.surfaces = dropped.options.want.radii = true;
    all.push_back(dropped);
    for (const bool periodic : {false, true}) {
        Input kept = input_of(uniform(1500, 10), ", seeds outside kept");
        kept.options.box = cube(0.2, 0.7);
        kept.options.outside = votess::Outside::keep;
        kept.options.periodic = {periodic, false, false};
        all.push_back(kept);
        for (std::size_t i = 0; i < kept.size(); ++i) kept.radii.push_back(random.uniform(0, 0.15));
        all.push_back(kept);
    }
    for (const bool planar : {false, true}) {
        constexpr double end = std::numeric_limits<double>::infinity();
        Input endless = input_of(planar ? in_plane(clustered(1000, 15)) : clustered(1000, 15), ", without end");
        endless.options.planar = planar;
        endless.options.box = votess::Box{{-end, -end, planar ? 0 : -end}, {end, end, planar ? 0 : end}};
        all.push_back(endless);
    }
    for (const bool planar : {false, true}) {
        Input hull = input_of(planar ? in_plane(on_walls(1000, 14)) : on_walls(1000, 14), ", in its hull");
        hull.options.planar = planar;
        hull.options.box.reset();
        hull.hull = true;
        all.push_back(hull);
    }
    for (const bool periodic : {false, true}) {
        Input plane = input_of(in_plane(clustered(1000, 13)), periodic ? ", periodic plane" : ", plane");
        plane.options.planar = true;
        plane.options.periodic = {periodic, periodic, false};
        plane.options.want.surfaces = plane.options.want.radii = true;
        all.push_back(plane);
        for (std::size_t i = 0; i < plane.size(); ++i) plane.radii.push_back(random.uniform(0, 0.05));
        plane.options.box.reset();
        plane.options.periodic = {};
        if (!periodic) all.push_back(plane);
    }
    return all;
}

}  // namespace test
