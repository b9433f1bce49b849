// The faces of all cells as text: .ply, each once, and .obj, cell by cell.
#include <algorithm>
#include <limits>

#include "files/mesh.hpp"

namespace votess::files {
namespace {

struct Face {
    std::size_t cell, entry;
};

// Returns one of the two entries that a face has. It is the entry of the cell with the lower index; where a cell is
// its own neighbor across a periodic boundary, the entry with the greater shift.
std::vector<Face> faces_once(const Mesh& mesh) {
    std::vector<Face> faces;
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        const auto cell = static_cast<std::int32_t>(i);
        const auto [begin, end] = mesh.entries(i);
        for (std::size_t k = begin; k < end; ++k) {
            const std::int32_t neighbor = mesh.indices[k];
            const bool taken =
                neighbor == cell && !mesh.shifts.empty()
                    ? std::ranges::lexicographical_compare(std::array<std::int8_t, 3>{}, mesh.shifts.subspan(3 * k, 3))
                    : neighbor < 0 || cell < neighbor;
            if (taken) faces.push_back({i, k});
        }
    }
    return faces;
}

void put_vertices(const Mesh& mesh, std::string_view prefix, ByteSink& out) {
    for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
        out.put(k % 3 == 0 ? prefix : " ");
        out.put_number(mesh.vertices[k]);
        if (k % 3 == 2) out.put("\n");
    }
}

}  // namespace

// Text, and faces that ascend by their number of corners, because readers differ: trimesh expects binary lists of one
// length, and meshio 5 reads data in blocks of equal lengths. With colors the faces become triangles, because a reader
// that splits polygons gives their colors to the wrong triangles.
void write_ply(const Mesh& mesh, ByteSink& out) {
    std::vector<Face> faces = faces_once(mesh);
    const auto size = [&](const Face& face) { return mesh.polygon(face.entry).size(); };
    const bool colored = !mesh.colors.empty();
    std::size_t count = faces.size();
    if (colored) {
        count = 0;
        for (const Face& face : faces) count += std::max<std::size_t>(size(face), 2) - 2;
    } else {
        std::ranges::stable_sort(faces, {}, size);
    }
    const bool small = colored || faces.empty() || size(faces.back()) <= std::numeric_limits<std::uint8_t>::max();
    out.put(
        "ply\nformat ascii 1.0\n"
        "comment Voronoi cells by votess: each face once, counterclockwise seen from outside `cell`\n"
        "comment cell and neighbor are rows of the input from 0; a negative neighbor is a wall\n"
        "element vertex " +
        std::to_string(mesh.vertices.size() / 3) +
        "\nproperty double x\nproperty double y\nproperty double z\nelement face " + std::to_string(count) +
        "\nproperty list " + (small ? "uchar" : "int") +
        " int vertex_indices\nproperty int cell\nproperty int neighbor\n" +
        (colored ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "") + "end_header\n");
    put_vertices(mesh, "", out);
    const auto put_face = [&](const Face& face, std::span<const std::int32_t> corners) {
        out.put_number(corners.size());
        for (const std::int32_t corner : corners) put_next(out, corner);
        put_next(out, face.cell);
        put_next(out, mesh.indices[face.entry]);
        if (colored)
            for (const std::uint8_t part : mesh.colors.subspan(3 * face.cell, 3)) put_next(out, unsigned{part});
        out.put("\n");
    };
    for (const Face& face : faces) {
        const auto polygon = mesh.polygon(face.entry);
        if (!colored) {
            put_face(face, polygon);
            continue;
        }
        for (std::size_t k = 2; k < polygon.size(); ++k)
            put_face(face, std::array{polygon[0], polygon[k - 1], polygon[k]});
    }
}

void write_obj(const Mesh& mesh, ByteSink& out) {
    out.put("# Voronoi cells by votess: a group for each, with its faces counterclockwise seen from outside\n");
    put_vertices(mesh, "v ", out);
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        const auto [begin, end] = mesh.entries(i);
        if (begin < end) out.put("g " + std::to_string(i) + "\n");
        for (std::size_t k = begin; k < end; ++k) {
            out.put("f");
            for (const std::int32_t corner : mesh.polygon(k)) put_next(out, std::int64_t{corner} + 1);
            out.put("\n");
        }
    }
}

}  // namespace votess::files
