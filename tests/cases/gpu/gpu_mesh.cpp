// Polytopes made from the device's lists equal the CPU's.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/gpu/gpu.hpp"
#include "support/mesh.hpp"

namespace {

votess::Options mesh_options(const std::optional<votess::Box>& box) {
    votess::Options options = test::all_options(box);
    options.want.normals = options.want.surfaces = options.want.radii = options.want.faces = true;
    return options;
}

// Equal rows and polygons, vertices within 1e-9 of the box.
std::string check_same_mesh(const votess::Tessellation& a, const votess::Tessellation& b) {
    if (!std::ranges::equal(a.indices(), b.indices())) return "rows differ";
    if (!std::ranges::equal(a.face_offsets(), b.face_offsets())) return "face_offsets differ";
    if (!std::ranges::equal(a.face_vertices(), b.face_vertices())) return "face_vertices differ";
    if (!std::ranges::equal(a.cell_vertex_indptr(), b.cell_vertex_indptr())) return "cell_vertex_indptr differs";
    if (!std::ranges::equal(a.cell_vertex_indices(), b.cell_vertex_indices())) return "cell_vertex_indices differ";
    if (a.vertices().size() != b.vertices().size()) return "other vertices";
    const double size = b.box().upper[0] - b.box().lower[0];
    for (std::size_t k = 0; k < a.vertices().size(); ++k)
        if (!(std::abs(a.vertices()[k] - b.vertices()[k]) <= 1e-9 * size))
            return "vertex " + std::to_string(k / 3) + " lies elsewhere";
    return "";
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu: the mesh equals the CPU's") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        const std::size_t n = test::by_size(1500, 200);
        for (const auto& set :
             {test::uniform(n, 161), test::clustered(n, 162), test::near_duplicates(n, 163), test::on_walls(n, 164),
              test::with_duplicates(n, n / 10, 165), test::fcc(5), test::cubic(6), test::on_sphere_and_center(n, 166),
              test::PointSet{"one", {0.5, 0.25, 0.125}, test::unit_box()}}) {
            CAPTURE(set.name);
            votess::Options options = mesh_options(set.box);
            const auto cpu = votess::tessellate(set.points, options);
            options.device = test::device_name();
            const auto gpu = tessellator.tessellate(set.points, options);
            CHECK(test::check_same_cells(gpu, cpu) == "");
            CHECK(check_same_mesh(gpu, cpu) == "");
            CHECK(test::check_mesh(gpu, set.points) == "");
            CHECK(gpu.stats().precision == votess::Precision::double_);
            CHECK(gpu.stats().faces == cpu.stats().faces);
        }
    }

    TEST_CASE("gpu: lists still come from the device when polytopes are requested") {
        votess::Tessellator& tessellator = test::shared_tessellator();
        const auto set = test::uniform(test::by_size(8000, 1500), 171);
        votess::Options options;
        options.box = set.box;
        options.device = test::device_name();
        options.want.neighbors = false;
        options.want.surfaces = true;
        const auto t = tessellator.tessellate(set.points, options);
        CHECK(t.stats().fallback_cells < set.size() / 20);
        CHECK(t.indices().empty());
        options.device = "cpu";
        const auto cpu = votess::tessellate(set.points, options);
        for (std::size_t i = 0; i < t.size(); ++i)
            REQUIRE(t.surface_areas()[i] == doctest::Approx(cpu.surface_areas()[i]).epsilon(1e-10));
    }

    TEST_CASE("gpu: a mesh in parts") {
        const test::SharedGpu shared;
        const auto set = test::uniform(test::by_size(6000, 1500), 181);
        votess::gpu::EngineLimits limits;
        limits.max_seeds = static_cast<std::uint32_t>(set.size() / 2);
        test::GpuRunner runner(shared.gpu, limits);
        const votess::Options options = mesh_options(set.box);
        CHECK(check_same_mesh(runner.run(set, options), votess::tessellate(set.points, options)) == "");
    }
}
