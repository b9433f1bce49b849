// The Voronoi vertices of the seeds, and the edges from each to its four neighbors: the dual of the Delaunay
// tetrahedra. The cell of a probe swallows the vertices that are nearer to the probe than to their seeds. Swallowed
// vertices are connected, so a search along the edges finds them all (Bowyer and Watson, The Computer Journal 24,
// 1981). Edges between them lie inside the cell, edges to others end on its surface.
//
// The graph takes some 430 bytes a seed. It works in floating point: where a sign is uncertain, the caller divides the
// cell in another way.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "domain/probe.hpp"
#include "index/sorted_seeds.hpp"
#include "query/division.hpp"
#include "votess/votess.hpp"

namespace votess::cpu {

class VertexGraph {
public:
    // t: of the sorted seeds, in their order, with faces; the domain is not periodic. scale: of the job.
    VertexGraph(const SortedSeeds& seeds, const Tessellation& t, double scale);

    struct alignas(64) Vertex {
        std::array<double, 3> from;  // relative to the seed cells[0]
        double power;                // squared distance of its seeds, less their weight
        std::array<std::int32_t, 4>
            cells;                         // seeds, with det(p1 - p0, p2 - p0, p3 - p0) < 0; cells[3] = none: no search
        std::array<std::int32_t, 4> next;  // the vertex behind the edge that leaves the cell, or none

        [[nodiscard]] bool is_plain() const { return cells[3] != none; }
    };
    // A vertex on a wall or of more than four cells is not plain; next[k] of others may be one.
    static constexpr std::int32_t none = -1;

    [[nodiscard]] const Vertex& vertex(std::int32_t v) const { return vertices_[static_cast<std::size_t>(v)]; }
    // Some vertex of a seed's cell, or none.
    [[nodiscard]] std::int32_t vertex_of(std::size_t seed) const { return first_[seed]; }

private:
    void place(const SortedSeeds& seeds, const Tessellation& t, double scale);
    void link(const Tessellation& t);

    std::vector<Vertex> vertices_;
    std::vector<std::int32_t> first_;
    std::vector<std::int64_t> cells_begin_;  // by vertex, into cells_; while it is built
    std::vector<std::int32_t> cells_;
};

// Divides the cells of probes. One per thread.
class GraphDivider {
public:
    explicit GraphDivider(const SortedSeeds& seeds) : seeds_(seeds) {}

    // Begins a job with the largest weight of a seed, by its size.
    void begin_job(double largest_weight) { largest_weight_ = largest_weight; }
    // Begins probes that lie elsewhere: near a seed.
    void begin(const VertexGraph& graph, std::size_t seed) {
        graph_ = &graph;
        near_ = graph.vertex_of(seed);
    }
    // Returns false where that cannot be: near walls and vertices of many cells, on a seed, and where rounding might
    // matter. Fastest when the last probe was near.
    [[nodiscard]] bool divide(const Probe& probe, bool moments, Division& out);

private:
    using Vector = std::array<double, 3>;
    struct Seen {
        std::int32_t vertex, place;  // in places_
        std::uint32_t turn = 0;
    };
    struct Place {
        Vector x;  // relative to the probe
        // The squared distance of the probe, less its weight and the vertex's power: negative when it is swallowed.
        double excess;
        std::int32_t vertex;
    };
    [[nodiscard]] Place look(std::int32_t vertex) const {
        const VertexGraph::Vertex& v = graph_->vertex(vertex);
        const auto seed = static_cast<std::size_t>(v.cells[0]);
        const Vector x{(seeds_.x[seed] - at_[0]) + v.from[0], (seeds_.y[seed] - at_[1]) + v.from[1],
                       (seeds_.z[seed] - at_[2]) + v.from[2]};
        return {x, x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - weight_ - v.power, vertex};
    }
    [[nodiscard]] bool find_first();
    [[nodiscard]] std::size_t see(std::int32_t vertex);
    [[nodiscard]] std::size_t neighbor(std::int32_t seed, Division& out);
    [[nodiscard]] bool search(Division& out);

    static constexpr std::size_t table_size = 1024, max_swallowed = 128;

    const SortedSeeds& seeds_;
    const VertexGraph* graph_ = nullptr;
    std::int32_t near_ = VertexGraph::none;  // a vertex near the last probe
    exact::Point at_{};
    double weight_ = 0, largest_weight_ = 0, uncertain_weight_ = 0;
    bool uncertain_ = false;                       // whether some vertex seen is swallowed
    std::array<Place, 5 * max_swallowed> places_;  // of the vertices seen
    std::size_t place_count_ = 0;
    std::array<std::uint16_t, max_swallowed + 4> swallowed_;  // of these
    std::size_t swallowed_count_ = 0;
    std::array<Seen, table_size> seen_{};
    struct Number {  // of a seed in the division
        std::int32_t seed;
        std::uint32_t turn = 0, neighbor;
    };
    std::array<Number, 128> numbers_{};
    std::uint32_t turn_ = 0;
};

}  // namespace votess::cpu
