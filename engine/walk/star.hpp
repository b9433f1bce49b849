// The star of a seed: the vertices, edges and faces of its Voronoi cell, found by walking along its edges.
//
// From a vertex on planes a, b, c an edge runs along a and b; its other end is where the first of all other bisectors
// meets it (gift wrapping, Chand and Kapur, J. ACM 17(1), 1970, in the dual). Which plane that is may be guessed in any
// precision, because every vertex is proven afterwards: it must lie strictly inside all other planes, with a margin
// larger than all rounding, or exact arithmetic decides; and all seeds within twice its distance (the security radius)
// must have been looked at. A closed surface of proven vertices is the cell.
//
// A neighbor that is done has handed over every vertex of their common face (Neighborhood), so an edge that is still
// open lies on no plane of a done seed, and the other end of it neither: done seeds need not be looked at again.
//
// In a power diagram a seed may lie outside of its cell. A seed of weight w cuts off a vertex at the distance R only if
// it is nearer than R + sqrt(R^2 + w - w_p), which stands for 2 R below. star_bounds.hpp says what rounding may do.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "domain/domain.hpp"
#include "domain/probe.hpp"
#include "index/hierarchy.hpp"
#include "index/sort.hpp"
#include "input/implied_wants.hpp"
#include "polytope/cell_polygons.hpp"
#include "polytope/cell_shape.hpp"
#include "votess/votess.hpp"

namespace votess::cpu {

class Star {
public:
    static constexpr int max_planes = CellShape::max_planes;
    static constexpr int max_vertices = CellShape::max_corners;

    virtual ~Star() = default;

    static constexpr std::size_t alignment = 16;  // of the first seed of a stretch

    // What is known of a cell's vertices beside that they are there: which planes meet in each, for shape(); or their
    // places, too, for polygons().
    enum class Keep { nothing, corners, places };

    // Once a job and before begin(). The domain stays with the caller.
    virtual void begin_job(const Domain& domain) = 0;
    // Begins a stretch of seeds, aligned but for the end; build() is then called for its seeds in order.
    virtual void begin(std::size_t first, std::size_t last, Keep keep) = 0;
    // False when the cell is beyond what this class handles: the caller clips it.
    virtual bool build(std::size_t seed) = 0;

    // Begins a run of probes instead: each cell is built for itself, and a look around serves those near each other.
    // group: of sorted seeds, near the first.
    virtual void begin_probes(std::size_t group, Keep keep) = 0;
    // The probes that follow lie in this box, and weigh no less.
    virtual void look_around(const Box& box, double lightest) = 0;
    // False also where a seed may lie at the same place, or leave no cell.
    virtual bool build(const Probe& probe) = 0;
    // The security radius that vertices of late needed.
    [[nodiscard]] virtual double typical_reach() const = 0;

    // These are the faces of the last cell built, in no particular order: sorted seeds, or walls -1, -2, ... There are
    // none where the cell of a power diagram is empty.
    [[nodiscard]] std::span<const std::int32_t> faces() const {
        return {face_.data(), static_cast<std::size_t>(faces_)};
    }
    [[nodiscard]] int vertex_count() const { return vertices_; }
    [[nodiscard]] int edge_count() const { return edges_; }
    [[nodiscard]] bool used_exact() const { return used_exact_; }
    // The largest power, |v - seed|^2 - weight, of those vertices v that this cell was not handed by others, and of all
    // ties. Of the other vertices it is no larger than what the neighbors of the stretch found: with theirs it bounds
    // how far the cell reaches. Rounded up; min_power where it found none.
    [[nodiscard]] double power_found() const { return power_found_; }
    static constexpr double min_power = -1e300;

    // Outward unit vectors in the order of faces().
    virtual void normals(std::vector<std::array<double, 3>>& out) = 0;
    // Needs Keep::corners or more. ranks: of faces(), 0, 1, ... in the order of the row. Null where there is no room.
    [[nodiscard]] virtual CellShape* shape(std::span<const std::uint32_t> ranks) = 0;
    // What follows needs Keep::places. Whether all vertices are known to 1e-9 of the distance of the farthest.
    [[nodiscard]] virtual bool knows_vertices() const = 0;
    // In the order of faces(), as the ranks; with the numbers that vertices have in the stretch.
    virtual void polygons(std::span<const std::uint32_t> ranks, CellPolygons& out) const = 0;

protected:
    int faces_ = 0, vertices_ = 0, edges_ = 0;
    std::array<std::int32_t, max_planes> face_{};
    bool used_exact_ = false;
    double power_found_ = min_power;
};

// What a run that wants this needs to know of vertices.
[[nodiscard]] inline Star::Keep kept_for(const Want& want) {
    if (want.vertices) return Star::Keep::places;
    return needs_geometry(want) ? Star::Keep::corners : Star::Keep::nothing;
}

// For the instruction set of that name, see supported_kernels().
std::unique_ptr<Star> make_star(std::string_view instructions, const SortedSeeds& seeds, const Hierarchy& hierarchy);
std::unique_ptr<Star> make_star_baseline(const SortedSeeds& seeds, const Hierarchy& hierarchy);
std::unique_ptr<Star> make_star_avx2(const SortedSeeds& seeds, const Hierarchy& hierarchy);

}  // namespace votess::cpu
