// The mesh: globally shared vertices, polygons, normals.
#include "../support/mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "../support/check.hpp"

namespace {

votess::Options mesh_options(const std::optional<votess::Box>& box = std::nullopt) {
    votess::Options options = test::all_options(box);
    options.want.normals = options.want.surfaces = options.want.radii = options.want.faces = true;
    return options;
}

votess::Tessellation mesh_of(const test::PointSet& set) {
    return votess::tessellate(set.points, mesh_options(set.box));
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("mesh: uniform seeds, each interior vertex is shared by four cells") {
        const auto set = test::uniform(test::by_size(100000, 5000), 71);
        const auto t = mesh_of(set);
        CHECK(test::check_mesh(t, set.points) == "");
        const auto cells = test::cells_of_vertices(t);
        const auto interior = test::interior_vertices(t);
        std::size_t inside = 0;
        for (std::size_t v = 0; v < cells.size(); ++v) {
            if (!interior[v]) continue;
            ++inside;
            REQUIRE(cells[v] == 4);
        }
        CHECK(inside > 6 * set.size());
        double worst = 0;
        for (std::size_t i = 0; i < t.size(); ++i) {
            double sum[3]{};
            for (auto e = static_cast<std::size_t>(t.indptr()[i]); e < static_cast<std::size_t>(t.indptr()[i + 1]); ++e)
                for (std::size_t k = 0; k < 3; ++k) sum[k] += t.face_areas()[e] * t.face_normals()[3 * e + k];
            worst = std::max(worst, std::hypot(sum[0], sum[1], sum[2]) / t.surface_areas()[i]);
        }
        CHECK(worst <= 1e-12);
    }

    TEST_CASE("mesh: every family") {
        for (const auto& set : test::families(test::by_size(600, 150), 5)) {
            INFO(set.name);
            CHECK(test::check_mesh(mesh_of(set), set.points) == "");
        }
    }
}
