// CGAL: Delaunay triangulation with exact predicates, points inserted in the order of a space-filling curve, one
// thread.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/version.h>

#include <stdexcept>

#include "bench.hpp"

namespace bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_3<std::int32_t, Kernel>;
using Cell = CGAL::Delaunay_triangulation_cell_base_3<Kernel>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>>;

class Cgal final : public Peer {
public:
    [[nodiscard]] std::string name() const override { return "cgal"; }
    [[nodiscard]] std::string version() const override { return CGAL_STR(CGAL_VERSION); }
    [[nodiscard]] bool can(const Input& input, Want want) const override { return input.plain() && want != Want::full; }
    [[nodiscard]] bool bounded(const Input&) const override { return false; }

    [[nodiscard]] Answer run(const Input& input, Want want, unsigned) const override {
        // Copied into CGAL's own type before the clock starts, as a user of CGAL would have them.
        std::vector<std::pair<Kernel::Point_3, std::int32_t>> points;
        points.reserve(input.size());
        for (std::size_t i = 0; i < input.size(); ++i) {
            const double* p = &input.points[3 * i];
            points.emplace_back(Kernel::Point_3(p[0], p[1], p[2]), static_cast<std::int32_t>(i));
        }

        const Stopwatch stopwatch;
        const Delaunay delaunay(points.begin(), points.end());  // sorts spatially by itself
        std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
        pairs.reserve(8 * input.size());
        for (auto edge = delaunay.finite_edges_begin(); edge != delaunay.finite_edges_end(); ++edge) {
            pairs.emplace_back(edge->first->vertex(edge->second)->info(), edge->first->vertex(edge->third)->info());
        }
        const Rows rows = rows_from_pairs(input.size(), pairs);
        if (want == Want::neighbors) return {stopwatch.seconds(), rows.indices.size(), 0};
        const Stopwatch checking;
        if (!delaunay.is_valid()) throw std::runtime_error("is_valid() fails");
        return {checking.seconds(), rows.indices.size(), 0};
    }
};

}  // namespace

std::unique_ptr<Peer> make_cgal() {
    return std::make_unique<Cgal>();
}

}  // namespace bench
