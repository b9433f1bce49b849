// The arrays that a mesh file holds, and the formats.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "files/byte_sink.hpp"

namespace votess::files {

// Values of the cells, for .vtu.
struct Column {
    std::string_view name;
    std::string type;    // VTK's name, such as Float64
    const char* values;  // one row for each cell
    std::size_t width;   // numbers in a row
    std::size_t row_bytes;
};

struct SharedMesh;

// A view of N cells. Indices lie inside their arrays, and offsets ascend from 0.
struct Mesh {
    [[nodiscard]] std::size_t cells() const { return indptr.size() - 1; }
    // Returns the vertices of a cell, ascending; in the plane counterclockwise.
    [[nodiscard]] std::span<const std::int32_t> vertices_of(std::size_t cell) const {
        return row(cell_vertex_indptr, cell_vertex_indices, cell);
    }
    // Returns the corners of the face behind an entry of the rows, counterclockwise seen from outside.
    [[nodiscard]] std::span<const std::int32_t> polygon(std::size_t entry) const {
        return row(face_offsets, face_vertices, entry);
    }
    // Returns the entries of a cell's row: the first, and one past the last.
    [[nodiscard]] std::pair<std::size_t, std::size_t> entries(std::size_t cell) const {
        return {static_cast<std::size_t>(indptr[cell]), static_cast<std::size_t>(indptr[cell + 1])};
    }
    [[nodiscard]] const double* vertex(std::int32_t index) const {
        return vertices.data() + 3 * static_cast<std::size_t>(index);
    }

    std::span<const std::int64_t> indptr;              // N + 1
    std::span<const std::int32_t> indices;             // neighbors and walls
    std::span<const std::int8_t> shifts;               // 3 an entry; empty unless periodic
    std::span<const double> vertices;                  // 3 each; 2 in the plane
    std::span<const std::int64_t> cell_vertex_indptr;  // N + 1
    std::span<const std::int32_t> cell_vertex_indices;
    std::span<const std::int64_t> face_offsets;  // one more than entries
    std::span<const std::int32_t> face_vertices;
    std::array<double, 3> middle{};  // of the domain
    std::array<std::array<double, 3>, 2> bounds{};
    std::span<const std::uint8_t> colors;  // 3 of sRGB a cell; may be empty
    std::vector<Column> columns;
    bool planar = false;                   // for .vtu alone
    std::array<double, 9> edges{};         // vectors of the domain
    bool skewed = false;                   // whether they are given, not those of a box
    bool left_out = false;                 // whether cells that reach infinity were, and the wall -1 is in their place
    double min_edge = 0;                   // collapse shorter edges, in files with shared faces
    std::uint64_t* short_edges = nullptr;  // receives the number of those that stay
    // Called with the faces that such a file holds, before it is written; may be empty.
    std::function<void(const SharedMesh&)> measure;
    std::span<const double> seeds;    // 3 a cell, for .tess
    std::span<const double> weights;  // of the cells, for .tess; may be empty
    // Of pieces of cells in a mesh, else empty. Two pieces may share several faces, whose order is the same in both,
    // and sides of one piece may meet in an edge.
    std::span<const std::int32_t> rows;    // the cell of each piece, ascending
    std::span<const std::string> patches;  // names of the walls
    std::span<const std::int32_t> planes;  // of the faces on walls: vertices stay on them

private:
    static std::span<const std::int32_t> row(std::span<const std::int64_t> offsets,
                                             std::span<const std::int32_t> values, std::size_t k) {
        const auto begin = static_cast<std::size_t>(offsets[k]);
        return values.subspan(begin, static_cast<std::size_t>(offsets[k + 1]) - begin);
    }
};

// Each writes a whole file. write_glb() needs colors, and throws invalid_argument beyond 4 GiB.
void write_vtu(const Mesh& mesh, ByteSink& out);
void write_ply(const Mesh& mesh, ByteSink& out);
void write_obj(const Mesh& mesh, ByteSink& out);
void write_glb(const Mesh& mesh, ByteSink& out);
// Throw invalid_argument for cells that are not closed. write_foam() writes several files, write_tess() needs seeds.
void write_foam(const Mesh& mesh, ByteSink& out);
void write_tess(const Mesh& mesh, ByteSink& out);
void write_msh(const Mesh& mesh, ByteSink& out);
void write_cgns(const Mesh& mesh, ByteSink& out);
void write_stl(const Mesh& mesh, ByteSink& out);

}  // namespace votess::files
