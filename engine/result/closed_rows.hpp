// The cells of a domain without end that do not reach infinity, for files and pictures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "votess/votess.hpp"

namespace votess::detail {

// Rows with their polygons, as in Result. Those of cells that reach infinity are empty.
struct ClosedRows {
    std::vector<std::int64_t> indptr{0}, face_offsets{0}, cell_vertex_indptr{0};
    std::vector<std::int32_t> indices, face_vertices, cell_vertex_indices;  // wall -1 for neighbors that are left out
    std::vector<std::int8_t> shifts;
    Box bounds;  // of the vertices of the cells, `otherwise` on sides of a domain that have ends
    std::uint64_t left_out = 0;

    // Returns "1 cell reaches infinity", or "2 cells reach infinity".
    [[nodiscard]] std::string open_cells() const;
};

// The arrays of a result.
struct RowsWithPolygons {
    std::span<const std::int64_t> indptr, face_offsets, cell_vertex_indptr;
    std::span<const std::int32_t> indices, face_vertices, cell_vertex_indices;
    std::span<const std::int8_t> shifts;
    std::span<const double> vertices;
    Box domain;
    std::size_t dimensions = 3;  // components of shifts and vertices
};

// Returns the rows, or nothing if no cell reaches infinity.
[[nodiscard]] std::optional<ClosedRows> closed_rows(const RowsWithPolygons& rows);

}  // namespace votess::detail
