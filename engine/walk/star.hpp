// A cell is a closed graph of vertices, and each edge lies on two planes. From a known vertex we shoot along an edge;
// the first plane hit is a guess. We then prove the new vertex: no nearby seed lies inside its ball, and doubtful signs
// go to exact/. A proven vertex is given to the cells that share it, so most cells start half built. When no edge is
// open the cell is complete; a cell that gives up goes to the clipper.
//
// This is gift wrapping (Chand and Kapur, J. ACM 17(1), 1970) in the dual. Guesses may have any precision, because
// every vertex is proven. It must lie strictly inside all other planes, by more than all rounding, or exact arithmetic
// decides. And all seeds within twice its distance (the security radius) must have been tested.
//
// A neighbor that is done has handed over every vertex of the common face (Neighborhood). So an open edge, and the
// vertex at its end, lie on no plane of a done seed, and done seeds are not tested again.
//
// In a power diagram cells may lie beside their seeds. Where weights have a slope, the walk sees cells moved by half of
// it, so that they lie around their seeds again (star_bounds.hpp). A vertex at the distance R is cut off only by seeds
// whose planes are nearer than R to the moved seed. Boxes far away are skipped by bounds of their weights, which have a
// slope too (Hierarchy).
//
// A vertex may be far from the seed, in sheets of seeds or among heavy ones. Then seeds in its ball are looked for in
// the hierarchy, and images that are not among the sorted seeds, once for each shift (any_missing_image()).
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
#include "input/settled.hpp"
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

    // Nothing of a cell's vertices but their number; which planes meet in each, for shape(); their places too, for
    // polygons().
    enum class Keep { nothing, corners, places };

    // Once a job, before begin(). The domain must outlive the job.
    virtual void begin_job(const Domain& domain) = 0;
    // Begins a stretch of seeds. `first` is a multiple of alignment. Call build() for its seeds in order.
    virtual void begin(std::size_t first, std::size_t last, Keep keep) = 0;
    // Returns false when this class cannot handle the cell. The caller clips it.
    virtual bool build(std::size_t seed) = 0;

    // Begins a run of probes instead. Each cell is built for itself; probes near each other share look_around(). group:
    // of sorted seeds, near the first probe.
    virtual void begin_probes(std::size_t group, Keep keep) = 0;
    // The following probes lie in this box and weigh no less than `lightest`.
    virtual void look_around(const Box& box, double lightest) = 0;
    // Returns false also where a seed may lie at the same place, or leave no cell.
    virtual bool build(const Probe& probe) = 0;
    // Averaged over recent vertices.
    [[nodiscard]] virtual double typical_reach() const = 0;

    // Returns the faces of the last cell built, in no particular order: sorted seeds, or walls -1, -2, ... None if the
    // cell of a power diagram is empty.
    [[nodiscard]] std::span<const std::int32_t> faces() const {
        return {face_.data(), static_cast<std::size_t>(faces_)};
    }
    [[nodiscard]] int vertex_count() const { return vertices_; }
    [[nodiscard]] int edge_count() const { return edges_; }
    [[nodiscard]] bool used_exact() const { return used_exact_; }
    // Whether more than four cells and walls share a vertex of the cell.
    [[nodiscard]] bool met_tie() const { return met_tie_; }
    // Returns the largest power, |v - seed|^2 - weight, of the vertices v that this cell found itself, and of all ties.
    // The other vertices have powers that their finders in the stretch return, so the largest of all bounds the reach
    // of the cell. Rounded up; min_power if it found none.
    [[nodiscard]] double power_found() const { return power_found_; }
    static constexpr double min_power = -1e300;

    // Writes outward unit vectors in the order of faces().
    virtual void normals(std::vector<std::array<double, 3>>& out) = 0;
    // Needs Keep::corners or more. ranks: of faces(), 0, 1, ... in the order of the row. Returns null if there is no
    // room.
    [[nodiscard]] virtual CellShape* shape(std::span<const std::uint32_t> ranks) = 0;
    // Needs Keep::places. Whether all vertices are known to 1e-9 of the distance of the farthest.
    [[nodiscard]] virtual bool knows_vertices() const = 0;
    // Needs Keep::places. Writes polygons in the order of faces(), with the numbers of vertices in the stretch. ranks:
    // as for shape().
    virtual void polygons(std::span<const std::uint32_t> ranks, CellPolygons& out) const = 0;

protected:
    int faces_ = 0, vertices_ = 0, edges_ = 0;
    std::array<std::int32_t, max_planes> face_{};
    bool used_exact_ = false, met_tie_ = false;
    double power_found_ = min_power;
};

[[nodiscard]] inline Star::Keep kept_for(const Want& want) {
    if (want.vertices) return Star::Keep::places;
    return needs_geometry(want) ? Star::Keep::corners : Star::Keep::nothing;
}

// instructions: see supported_kernels().
std::unique_ptr<Star> make_star(std::string_view instructions, const SortedSeeds& seeds, const Hierarchy& hierarchy);
std::unique_ptr<Star> make_star_baseline(const SortedSeeds& seeds, const Hierarchy& hierarchy);
std::unique_ptr<Star> make_star_avx2(const SortedSeeds& seeds, const Hierarchy& hierarchy);

}  // namespace votess::cpu
