// The faces of all cells, each once, as text: .ply with the two cells of each face, and .obj.
#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "files/output_buffer.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

// It takes one of the two entries of a pair of cells: that of the cell of lower index, or, where a cell is its own
// neighbor across a periodic boundary, that of the greater shift.
class FacesOnce {
public:
    explicit FacesOnce(const votess::Tessellation& cells) : cells_(cells) {}

    // Calls use(cell, neighbor, polygon).
    template <typename Use>
    void each(Use use) const {
        const auto offsets = cells_.face_offsets();
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            const auto row = cells_.neighbors(i);
            const auto begin = static_cast<std::size_t>(cells_.indptr()[i]);
            for (std::size_t k = 0; k < row.size(); ++k) {
                if (!is_taken(static_cast<std::int32_t>(i), row[k], begin + k)) continue;
                const auto first = static_cast<std::size_t>(offsets[begin + k]);
                const auto end = static_cast<std::size_t>(offsets[begin + k + 1]);
                use(static_cast<std::int32_t>(i), row[k], cells_.face_vertices().subspan(first, end - first));
            }
        }
    }

private:
    [[nodiscard]] bool is_taken(std::int32_t cell, std::int32_t neighbor, std::size_t entry) const {
        if (neighbor != cell) return neighbor < 0 || cell < neighbor;
        const auto shift = cells_.shifts().subspan(3 * entry, 3);
        return std::ranges::lexicographical_compare(std::array<std::int8_t, 3>{}, shift);
    }

    const votess::Tessellation& cells_;
};

}  // namespace

// Text, and faces that ascend by their number of corners: readers differ in what they take. Some expect lists of one
// length in binary rows (trimesh), some no numbers beside them, and data by blocks of equal lengths (meshio 5).
void write_ply(OutputFile& file, const OutputData& data) {
    struct Face {
        std::int32_t cell, neighbor;
        std::span<const std::int32_t> polygon;
        [[nodiscard]] std::size_t size() const { return polygon.size(); }
    };
    const votess::Tessellation& cells = data.tessellation;
    std::vector<Face> faces;
    FacesOnce(cells).each([&](std::int32_t cell, std::int32_t neighbor, std::span<const std::int32_t> polygon) {
        faces.push_back({cell, neighbor, polygon});
    });
    std::ranges::stable_sort(faces, {}, &Face::size);
    const bool small = faces.empty() || faces.back().size() <= std::numeric_limits<std::uint8_t>::max();
    OutputBuffer out(file);
    out.put(
        "ply\nformat ascii 1.0\n"
        "comment Voronoi cells by clvotess: each face once, counterclockwise seen from outside `cell`\n"
        "comment cell and neighbor are rows of the input from 0; a negative neighbor is a wall\n"
        "element vertex " +
        std::to_string(cells.vertices().size() / 3) +
        "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(faces.size()) +
        "\nproperty list " + (small ? "uchar" : "int") +
        " int vertex_indices\nproperty int cell\nproperty int neighbor\nend_header\n");
    const auto vertices = cells.vertices();
    for (std::size_t k = 0; k + 2 < vertices.size(); k += 3) {
        out.put_three(vertices[k], vertices[k + 1], vertices[k + 2]);
        out.put('\n');
    }
    for (const Face& face : faces) {
        out.put_number(face.size());
        for (const std::int32_t vertex : face.polygon) {
            out.put(' ');
            out.put_number(vertex);
        }
        out.put(' ');
        out.put_number(face.cell);
        out.put(' ');
        out.put_number(face.neighbor);
        out.put('\n');
    }
    out.flush();
}

void write_obj(OutputFile& file, const OutputData& data) {
    const votess::Tessellation& cells = data.tessellation;
    OutputBuffer out(file);
    out.put("# Voronoi cells by clvotess: each face once\n");
    const auto vertices = cells.vertices();
    for (std::size_t k = 0; k + 2 < vertices.size(); k += 3) {
        out.put("v ");
        out.put_three(vertices[k], vertices[k + 1], vertices[k + 2]);
        out.put('\n');
    }
    FacesOnce(cells).each([&](std::int32_t, std::int32_t, std::span<const std::int32_t> polygon) {
        out.put('f');
        for (const std::int32_t vertex : polygon) {
            out.put(' ');
            out.put_number(std::int64_t{vertex} + 1);
        }
        out.put('\n');
    });
    out.flush();
}

}  // namespace clvotess
