// Natural-neighbor coordinates of probes, normalized to sum 1. Sibson: the volume that the cell takes from each
// neighbor. Laplace: the area of each face over the distance of its neighbor (Belikov, Ivanov, Kontorovich, Korytnik,
// Semenov, Comput. Math. Math. Phys. 37, 1997).
//
// Three ways lead to Sibson's volumes. The graph of all vertices needs 4.8 us a query and pays off for many queries.
// The walk through one cell needs 12 to 17 us and no graph. Exact clipping needs 1 ms, and decides where the others
// cannot (100,000 uniform seeds, 200,000 queries, one thread, medians of one run).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "query/parts.hpp"
#include "query/prober.hpp"
#include "query/sibson.hpp"
#include "query/vertex_graph.hpp"
#include "votess/diagram.hpp"

namespace votess::cpu {

// The coordinates of one probe: indices of seeds in the input, ascending. None where there are no coordinates.
struct NaturalRow {
    std::span<const std::int32_t> seeds;
    std::span<const double> weights;
    std::span<const std::array<double, 3>> gradients;  // of the weights, if they are wanted
};

// Walls at which cells have no coordinates.
struct FieldEnds {
    std::uint32_t sides = 0;  // bit k: wall -1 - k
    bool others = false;      // walls below -6

    [[nodiscard]] bool has(std::int32_t id) const { return id < -6 ? others : id < 0 && (sides >> (-1 - id) & 1) != 0; }
};

class NaturalSink {
public:
    virtual ~NaturalSink() = default;
    virtual void take(std::size_t k, const NaturalRow& row) = 0;
};

// One per thread.
class NaturalRows final : public ProbeSink {
public:
    NaturalRows(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels)
        : seeds_(seeds), divider_(seeds), parts_(seeds, hierarchy, kernels), nearer_(seeds, hierarchy) {}

    // options: at_walls is in `ends`.
    void begin_job(const Job& job, const NaturalOptions& options, const FieldEnds& ends);
    void begin_run(std::span<const Probe> probes, NaturalSink& out) {
        probes_ = probes;
        out_ = &out;
    }

    // By the graph; near: a seed near the first probe of the run. False when the probe's own cell is needed.
    void begin_graph(const VertexGraph& graph, std::size_t near) { divider_.begin(graph, near); }
    [[nodiscard]] bool take_by_graph(std::size_t k);

    bool take(std::size_t k, Star& star) override;
    void take(std::size_t k, Cell& cell) override;
    bool taken(std::size_t k, std::size_t seed) override;

private:
    struct Entry {
        std::int32_t seed;  // in the input
        double weight;
        std::array<double, 3> gradient;
    };
    void read_shape(std::size_t k, Star& star);
    [[nodiscard]] bool buries_none(std::size_t k);
    void give_division(std::size_t k);
    void give_parts(std::size_t k);
    // Laplace's. Returns false when rounding might matter.
    [[nodiscard]] bool give_areas(std::size_t k);
    void give_areas(std::size_t k, const Cell& cell);
    [[nodiscard]] bool knows_corners(double accepted_error) const;
    void add_entry(std::int32_t seed, double weight, const std::array<double, 3>& moment, double distance);
    void finish(std::size_t k);
    void add_gradients(double total);
    void give(std::size_t k);

    const SortedSeeds& seeds_;
    const Domain* domain_ = nullptr;
    NaturalOptions options_;
    FieldEnds ends_;
    double unscale_ = 1;
    std::span<const Probe> probes_;
    NaturalSink* out_ = nullptr;

    ProbeShape shape_;
    Sibson sibson_;
    GraphDivider divider_;
    Division division_;
    Parts parts_;
    NearerSeeds nearer_;
    std::vector<Member> neighbors_;
    CellFaces faces_;
    std::vector<Measured> areas_;  // by face
    std::vector<std::uint32_t> ranks_;
    std::vector<std::array<double, 3>> normals_;
    std::vector<Entry> entries_;
    std::vector<std::uint64_t> order_;  // by seed, then entry
    std::vector<std::int32_t> row_seeds_;
    std::vector<double> row_weights_;
    std::vector<std::array<double, 3>> row_gradients_;
};

}  // namespace votess::cpu
