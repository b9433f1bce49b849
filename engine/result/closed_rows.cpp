#include "result/closed_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/at.hpp"
#include "core/box.hpp"

namespace votess::detail {
namespace {

std::span<const std::int32_t> row(std::span<const std::int64_t> offsets, std::span<const std::int32_t> values,
                                  std::size_t k) {
    return values.subspan(at(offsets[k]), at(offsets[k + 1] - offsets[k]));
}

}  // namespace

std::optional<ClosedRows> closed_rows(const RowsWithPolygons& rows) {
    const std::size_t cells = rows.indptr.size() - 1;
    std::vector<bool> open(cells);
    ClosedRows out;
    for (std::size_t i = 0; i < cells; ++i) {
        for (auto e = at(rows.indptr[i]); e < at(rows.indptr[i + 1]) && !open[i]; ++e) {
            const auto corners = row(rows.face_offsets, rows.face_vertices, e);
            open[i] = corners.empty() || std::ranges::find(corners, -1) != corners.end();
        }
        if (open[i]) ++out.left_out;
    }
    if (out.left_out == 0) return std::nullopt;
    out.bounds = empty_box;
    for (std::size_t i = 0; i < cells; ++i) {
        for (auto e = at(rows.indptr[i]); e < at(rows.indptr[i + 1]) && !open[i]; ++e) {
            const std::int32_t id = rows.indices[e];
            out.indices.push_back(id >= 0 && at(id) < cells && open[at(id)] ? -1 : id);
            for (std::size_t k = 0; k < rows.dimensions && !rows.shifts.empty(); ++k)
                out.shifts.push_back(out.indices.back() < 0 ? std::int8_t{0} : rows.shifts[rows.dimensions * e + k]);
            const auto corners = row(rows.face_offsets, rows.face_vertices, e);
            out.face_vertices.insert(out.face_vertices.end(), corners.begin(), corners.end());
            out.face_offsets.push_back(std::ssize(out.face_vertices));
        }
        out.indptr.push_back(std::ssize(out.indices));
        if (!open[i]) {
            const auto corners = row(rows.cell_vertex_indptr, rows.cell_vertex_indices, i);
            out.cell_vertex_indices.insert(out.cell_vertex_indices.end(), corners.begin(), corners.end());
            for (const std::int32_t v : corners)
                for (std::size_t k = 0; k < rows.dimensions; ++k) {
                    const double x = rows.vertices[rows.dimensions * at(v) + k];
                    out.bounds.lower[k] = std::min(out.bounds.lower[k], x);
                    out.bounds.upper[k] = std::max(out.bounds.upper[k], x);
                }
        }
        out.cell_vertex_indptr.push_back(std::ssize(out.cell_vertex_indices));
    }
    for (std::size_t k = 0; k < 3; ++k) {
        if (out.bounds.lower[k] > out.bounds.upper[k]) out.bounds.lower[k] = 0, out.bounds.upper[k] = 1;
        if (std::isfinite(rows.domain.lower[k])) out.bounds.lower[k] = rows.domain.lower[k];
        if (std::isfinite(rows.domain.upper[k])) out.bounds.upper[k] = rows.domain.upper[k];
    }
    return out;
}

std::string ClosedRows::open_cells() const {
    return std::to_string(left_out) + (left_out == 1 ? " cell reaches infinity" : " cells reach infinity");
}

}  // namespace votess::detail
