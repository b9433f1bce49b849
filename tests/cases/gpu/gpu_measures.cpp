// The bounds of shaders/measure/polyhedron.glsl. A device proves for each cell that its errors in float32 are below a
// tolerance, or leaves the cell. So with many tolerances, no error may ever be larger than the tolerance.
#include <doctest/doctest.h>

#include <cmath>
#include <optional>

#include "cases/gpu/gpu_domain_cases.hpp"

namespace {

using test::Coordinates;
using test::Random;
using votess::Options;
using votess::Tessellation;

constexpr std::size_t count = 200;

struct Set {
    std::string name;
    Coordinates points;
    Options options = test::domain_options();
    std::vector<double> weights{};
};

// Returns uniform seeds in a box of this size.
Set box_of(const std::string& name, std::array<double, 3> size, std::uint64_t seed) {
    Set set{name, test::random_points(count, seed)};
    for (std::size_t i = 0; i < set.points.size(); ++i) set.points[i] *= size[i % 3];
    set.options.box = votess::Box{{0, 0, 0}, size};
    return set;
}

// Returns seeds in a thin shell: their cells are needles.
Set shell(double thickness, std::uint64_t seed) {
    Random random(seed);
    Set set{"a shell of " + std::to_string(thickness), {}};
    while (set.points.size() < 3 * count) {
        const std::array<double, 3> x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        const double length = std::hypot(x[0], x[1], x[2]), radius = 0.4 + random.uniform(0, thickness);
        if (length > 1 || length < 0.1) continue;
        for (const double c : x) set.points.push_back(0.5 + c / length * radius);
    }
    return set;
}

// Returns a power diagram between walls of any direction.
Set in_octahedron(double radius, std::uint64_t seed) {
    Set set{"radii up to " + std::to_string(radius), test::random_points(count, seed, 0.34, 0.66)};
    set.options.walls = test::octahedron(0.5);
    Random random(seed);
    for (std::size_t i = 0; i < count; ++i) set.weights.push_back(std::pow(random.uniform(0, radius), 2));
    return set;
}

std::vector<Set> sets() {
    std::vector<Set> all;
    for (const test::PointSet& set : {test::uniform(count, 1), test::clustered(count, 2),
                                      test::far_from_origin(count, 3), test::jittered(6, 1e-3, 4)}) {
        all.push_back({set.name, set.points});
        all.back().options.box = set.box;
    }
    all.push_back(box_of("a plate", {1, 1, 1e-3}, 5));
    all.push_back(box_of("a column", {1e-4, 1e-4, 1}, 6));
    for (const double thickness : {1e-2, 1e-3}) all.push_back(shell(thickness, 7));
    for (const double radius : {0.05, 1.0}) all.push_back(in_octahedron(radius, 8));
    return all;
}

// Returns the diagonal of a box around each cell.
std::vector<double> diagonals(const Set& set) {
    Options options = set.options;
    options.want.faces = true;
    const Tessellation t = votess::tessellate(set.points, options);
    std::vector<double> all;
    for (std::size_t i = 0; i < t.size(); ++i) {
        std::array<double, 3> lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};
        for (auto f = t.face_offsets()[static_cast<std::size_t>(t.indptr()[i])];
             f < t.face_offsets()[static_cast<std::size_t>(t.indptr()[i + 1])]; ++f)
            for (std::size_t a = 0; a < 3; ++a) {
                const double x =
                    t.vertices()[3 * static_cast<std::size_t>(t.face_vertices()[static_cast<std::size_t>(f)]) + a];
                lower[a] = std::min(lower[a], x);
                upper[a] = std::max(upper[a], x);
            }
        all.push_back(std::hypot(upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]));
    }
    return all;
}

// Largest relative errors. Those of centroids and areas are in the units of the header of polyhedron.glsl, so that one
// tolerance bounds all three.
struct Errors {
    double volume = 0, centroid = 0, areas = 0;
};

Errors errors(const Tessellation& gpu, const Tessellation& cpu, std::span<const double> sizes) {
    Errors largest;
    const auto note = [](double& all, double error) { all = error <= all ? all : error; };  // NaN too
    for (std::size_t i = 0; i < cpu.size(); ++i) {
        const double volume = cpu.volumes()[i];
        if (cpu.status()[i] != votess::CellStatus::certified || volume == 0) continue;
        note(largest.volume, std::abs(gpu.volumes()[i] - volume) / volume);
        double moved = 0, areas = 0;
        for (std::size_t a = 3 * i; a < 3 * i + 3; ++a)
            moved = std::hypot(moved, gpu.centroids()[a] - cpu.centroids()[a]);
        note(largest.centroid, moved / (3.65 * sizes[i]));
        for (auto e = static_cast<std::size_t>(cpu.indptr()[i]); e < static_cast<std::size_t>(cpu.indptr()[i + 1]); ++e)
            areas += std::abs(gpu.face_areas()[e] - cpu.face_areas()[e]);
        note(largest.areas, areas / (4.84 * std::pow(volume, 2.0 / 3)));
    }
    return largest;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu measures: errors in float32 are below each tolerance") {
        const test::Environment numbers("VOTESS_VULKAN_MEASURE", "float32");
        const test::UseKernel chosen(test::by_subgroup());
        test::Gpu gpu({.float64 = false});
        for (Set& set : sets()) {
            CAPTURE(set.name);
            // A coordinate that is rounded to units, so that no passes are made that decide ties.
            set.points[0] += (set.points[3] - set.points[0]) * 0x1p-20 / 3;
            set.options.weights = set.weights;
            const Tessellation cpu = votess::tessellate(set.points, set.options);
            const std::vector<double> sizes = diagonals(set);
            for (const double tolerance : {1e-7, 2e-6, 3e-6, 5e-6, 1e-5, 1e-3}) {
                CAPTURE(tolerance);
                test::GpuRunner runner(gpu, {.volume_tolerance = tolerance});
                const Tessellation t = runner.run({set.name, set.points, set.options.box}, set.options);
                const Errors largest = errors(t, cpu, sizes);
                CHECK(largest.volume <= tolerance);
                CHECK(largest.centroid <= tolerance);
                CHECK(largest.areas <= tolerance);
                if (tolerance < 1e-3) continue;
                // The device measured most cells, in float32.
                CHECK(t.stats().fallback_cells < cpu.size() / 3);
                CHECK(largest.volume > 1e-8);
            }
        }
    }
}
