// The mesh of a result: cells wait as records until all rows are known; then vertices that are one are merged.
//
// Two cells of a face have the same polygon, one clockwise where the other is counterclockwise, so matching the
// polygons of all faces by a turn tells which vertices are one: those around a vertex are joined by faces that end
// there. Nothing else is compared, no position across cells, so the mesh is as exact as the cells are.
#pragma once

#include <mutex>
#include <optional>
#include <span>

#include "arena.hpp"
#include "engine.hpp"
#include "mesh_record.hpp"
#include "thread_pool.hpp"
#include "vertex_sets.hpp"

namespace votess {

class MeshBuilder {
public:
    void begin(const Job& job);
    [[nodiscard]] bool wanted() const { return wanted_; }
    // From any thread. The records of these cells, whose faces are those of the rows; the block is the caller's again
    // on return.
    void add(std::span<const std::int32_t> cells, const MeshBlock& block);
    // Needs the rows, and fills vertices and all that refers to them. The records are used up.
    void finish(detail::Result& result, ThreadPool& pool);

private:
    [[nodiscard]] MeshCellView cell(std::size_t i) const { return MeshCellView(records_[i]); }
    void place_polygons(detail::Result& result, ThreadPool& pool) const;
    void number_vertices(detail::Result& result, VertexSets& sets, ThreadPool& pool) const;

    bool wanted_ = false, want_faces_ = false;
    double unscale_ = 1;
    std::mutex mutex_;  // of the memory
    Arena memory_;
    Buffer<const std::byte*> records_;  // by cell; null: none
};

// mesh_merge.cpp: unites the vertices of cell i with those of its neighbors, for each face whose other side is a later
// cell or, of two entries that i has for itself, the later one.
class FaceMatcher {
public:
    FaceMatcher(const detail::Result& result, std::span<const std::byte* const> records, VertexSets& sets)
        : result_(result), records_(records), sets_(sets) {}

    void unite_faces(std::size_t i);

private:
    struct Face {
        std::size_t cell;
        std::size_t row;  // its place in the cell's row
    };
    [[nodiscard]] FaceLabel label(std::size_t entry) const;
    [[nodiscard]] std::size_t find_entry(std::size_t cell, const FaceLabel& label) const;
    void unite_face(const Face& face, const Face& other, const Shift& shift);
    [[nodiscard]] std::uint32_t turn_by_distance(const MeshCellView& a, std::size_t row_a, const MeshCellView& b,
                                                 std::size_t row_b, bool& clear) const;
    [[nodiscard]] std::optional<std::uint32_t> turn_by_labels(const Face& face, const Face& other,
                                                              const Shift& shift) const;
    [[nodiscard]] bool label_across(const Face& face, std::uint32_t place, FaceLabel& out) const;

    const detail::Result& result_;
    std::span<const std::byte* const> records_;
    VertexSets& sets_;
};

}  // namespace votess
