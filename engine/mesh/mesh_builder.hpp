// The mesh of a result. Cells wait as records until all rows are known. Then equal vertices are merged. Cells of one
// group share theirs from the start.
//
// The two cells of a face have the same polygon, one clockwise, the other counterclockwise. Matching the polygons of
// all faces by a turn finds all equal vertices, because faces join the cells around a vertex. The turn follows from an
// edge that both cells name by the same third cell. Where more than three cells meet along all edges of a face, the
// turn is the one that brings the polygons together, or exact arithmetic matches the edges.
#pragma once

#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/arena.hpp"
#include "core/box.hpp"
#include "core/thread_pool.hpp"
#include "input/job.hpp"
#include "mesh/mesh_record.hpp"
#include "mesh/vertex_sets.hpp"
#include "result/result.hpp"

namespace votess {

// The vertices of a block of records.
struct BlockVertices {
    std::span<const double> positions;
    std::uint32_t first;            // the number of the first among those of all blocks
    const std::uint32_t* of_cells;  // MeshBlock::vertices()

    [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(positions.size() / 3); }
};

class MeshBuilder {
public:
    void begin(const Job& job);
    // From any thread. The records of these cells, whose faces are those of the rows. `cells` must stay as it is until
    // finish(); the block is the caller's again on return.
    void add(std::span<const std::int32_t> cells, const MeshBlock& block);
    // Needs the rows, and fills vertices and all that refers to them. The records are used up.
    void finish(detail::Result& result, ThreadPool& pool);

private:
    [[nodiscard]] MeshCellView cell(std::size_t i) const { return MeshCellView(records_[i]); }
    // task(block, cell) for all cells that have a record, neighbors in space together.
    template <class Task>
    void for_blocks(ThreadPool& pool, Task task) const;
    // task(begin, end) for the numbers of all vertices.
    template <class Task>
    void for_vertices(ThreadPool& pool, Task task) const;
    void count_vertices(detail::Result& result, ThreadPool& pool) const;
    void unite_vertices(VertexSets& sets, const detail::Result& result, ThreadPool& pool) const;
    void number_vertices(detail::Result& result, VertexSets& sets, ThreadPool& pool) const;
    void place_polygons(detail::Result& result, ThreadPool& pool) const;

    bool wanted_ = false, want_faces_ = false;
    Job job_;
    double unscale_ = 1;
    std::mutex mutex_;  // of the members below
    Arena records_memory_, vertices_memory_;
    std::vector<std::span<const std::int32_t>> blocks_;  // cells, in the order of the engine
    std::vector<BlockVertices> vertices_of_;             // by block
    std::size_t vertices_ = 0;                           // of all blocks
    Buffer<const std::byte*> records_;                   // by cell; null: none
};

// mesh_merge.cpp: unites the vertices of cell i with those of its neighbors in other groups. It visits each face whose
// other side is a later cell, and one of two faces that i has with itself.
class FaceMatcher {
public:
    FaceMatcher(const Job& job, const Rows& rows, std::span<const std::byte* const> records,
                std::span<const BlockVertices> vertices_of, VertexSets& sets)
        : job_(job), rows_(rows), records_(records), vertices_of_(vertices_of), sets_(sets) {}

    void unite_faces(std::size_t row);

private:
    struct Side {
        const MeshCellView& cell;
        std::size_t row, seed;
        std::size_t face;
        [[nodiscard]] std::uint32_t begin() const { return cell.begin(face); }
        [[nodiscard]] std::uint32_t count() const { return cell.end(face) - cell.begin(face); }
    };
    // Returns the label of a face of the row.
    [[nodiscard]] FaceLabel label(std::size_t row, std::size_t face) const {
        return rows_.label(rows_.begin(row) + face);
    }
    [[nodiscard]] FaceLabel beginning(const Side& side) const;
    // Returns the number that a vertex of a cell has in its block.
    [[nodiscard]] std::uint32_t number(const MeshCellView& cell, std::uint32_t vertex) const {
        return vertices_of_[cell.block()].of_cells[cell.first() + vertex];
    }
    [[nodiscard]] std::array<double, 3> position(const MeshCellView& cell, std::uint32_t vertex) const;
    [[nodiscard]] std::array<double, 3> middle(const Side& side) const;
    void unite_sides(const Side& a, const Side& b, const exact::Shift& shift);
    std::uint32_t turn_by_distance(const Side& a, const Side& b, bool& clear) const;
    [[nodiscard]] std::optional<std::uint32_t> turn_by_edges(const Side& a, const Side& b,
                                                             const exact::Shift& shift) const;
    [[nodiscard]] exact::Point point(std::size_t i) const { return point_of(job_.points, i, job_.scale); }
    [[nodiscard]] exact::Shift wrapped(std::size_t i) const;
    [[nodiscard]] exact::Plane plane(std::size_t i, const FaceLabel& label, const exact::Shift& shift) const;
    [[nodiscard]] std::optional<FaceLabel> label_across(const Side& side, std::uint32_t place) const;

    const Job& job_;
    Rows rows_;
    std::span<const std::byte* const> records_;
    std::span<const BlockVertices> vertices_of_;
    VertexSets& sets_;
};

}  // namespace votess
