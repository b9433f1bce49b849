// VTK's .vtu: a polyhedron for each cell, in the plane a polygon, with its columns. The XML states where each array
// begins; the arrays follow it as raw bytes. Cells ascend by their number of vertices, because meshio 5 takes the data
// in that order.
#include <algorithm>

#include "files/mesh.hpp"

namespace votess::files {
namespace {

constexpr std::uint8_t polygon = 7, polyhedron = 42;  // vtkCellType.h

struct Block {
    std::string attributes;
    std::uint64_t bytes = 0;
    std::function<void(ByteSink&)> write;
};

std::string xml_escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        const bool space = c == '\t' || c == '\n' || c == '\r';
        result += c == '&'   ? "&amp;"
                  : c == '<' ? "&lt;"
                  : c == '"' ? "&quot;"
                  : space    ? "&#" + std::to_string(int{c}) + ";"
                             : std::string(1, c);
    }
    return result;
}

std::string_view bytes_of(const auto& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

class VtuWriter {
public:
    explicit VtuWriter(const Mesh& mesh) : mesh_(mesh) {
        const auto vertex_count = [&](std::size_t i) { return mesh.vertices_of(i).size(); };
        for (std::size_t i = 0; i < mesh.cells(); ++i)
            if (vertex_count(i) > 0) rows_.push_back(i);
        std::ranges::stable_sort(rows_, {}, vertex_count);

        points_.push_back({R"(type="Float64" Name="Points" NumberOfComponents="3")", 3 * points() * sizeof(double),
                           [&](ByteSink& out) { put_points(out); }});
        add("Int32", "connectivity", mesh.cell_vertex_indices.size_bytes(),
            [&](std::size_t i, ByteSink& out) { out.put(bytes_of(mesh.vertices_of(i))); });
        add("Int64", "offsets", rows_.size() * sizeof(std::int64_t),
            [&, end = std::int64_t{0}](std::size_t i, ByteSink& out) mutable {
                out.put_binary(end += static_cast<std::int64_t>(mesh.vertices_of(i).size()));
            });
        const std::uint8_t type = mesh.planar ? polygon : polyhedron;
        add("UInt8", "types", rows_.size(), [type](std::size_t, ByteSink& out) { out.put_binary(type); });
        if (!mesh.planar) add_faces();
        for (const Column& column : mesh.columns) {
            const std::string width =
                column.width == 1 ? "" : " NumberOfComponents=\"" + std::to_string(column.width) + "\"";
            values_.push_back({"type=\"" + column.type + "\" Name=\"" + xml_escaped(column.name) + "\"" + width,
                               rows_.size() * column.row_bytes, [this, &column](ByteSink& out) {
                                   for (const std::size_t i : rows_)
                                       out.put({column.values + i * column.row_bytes, column.row_bytes});
                               }});
        }
    }

    void write(ByteSink& out) const {
        out.put(
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
            std::to_string(points()) + "\" NumberOfCells=\"" + std::to_string(rows_.size()) + "\">\n");
        std::uint64_t offset = 0;
        put_section(out, "Points", points_, offset);
        put_section(out, "Cells", topology_, offset);
        put_section(out, "CellData", values_, offset);
        out.put("</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
        for (const auto* const section : {&points_, &topology_, &values_}) {
            for (const Block& block : *section) {
                out.put_binary(block.bytes);
                block.write(out);
            }
        }
        out.put("\n</AppendedData>\n</VTKFile>\n");
    }

private:
    [[nodiscard]] std::size_t points() const { return mesh_.vertices.size() / (mesh_.planar ? 2 : 3); }
    void put_points(ByteSink& out) const {
        if (!mesh_.planar) return out.put(bytes_of(mesh_.vertices));
        for (std::size_t v = 0; v < points(); ++v) {
            out.put(bytes_of(mesh_.vertices.subspan(2 * v, 2)));
            out.put_binary(0.0);
        }
    }
    void add_faces() {
        std::uint64_t numbers = 0;
        for (const std::size_t i : rows_) numbers += faces_length(i);
        add("Int32", "faces", numbers * sizeof(std::int32_t), [&](std::size_t i, ByteSink& out) { put_faces(i, out); });
        add("Int64", "faceoffsets", rows_.size() * sizeof(std::int64_t),
            [&, end = std::int64_t{0}](std::size_t i, ByteSink& out) mutable {
                out.put_binary(end += static_cast<std::int64_t>(faces_length(i)));
            });
    }

    // An array of the topology. put(cell, out) writes the part of one cell.
    template <class Put>
    void add(const std::string& type, const std::string& name, std::uint64_t bytes, Put put) {
        topology_.push_back({"type=\"" + type + "\" Name=\"" + name + "\"", bytes, [this, put](ByteSink& out) mutable {
                                 for (const std::size_t i : rows_) put(i, out);
                             }});
    }

    static void put_section(ByteSink& out, const std::string& name, const std::vector<Block>& blocks,
                            std::uint64_t& offset) {
        out.put("<" + name + ">\n");
        for (const Block& block : blocks) {
            out.put("<DataArray " + block.attributes + " format=\"appended\" offset=\"" + std::to_string(offset) +
                    "\"/>\n");
            offset += sizeof block.bytes + block.bytes;
        }
        out.put("</" + name + ">\n");
    }

    // The array `faces` holds for each cell its number of faces; then for each face its number of vertices, and these.
    [[nodiscard]] std::uint64_t faces_length(std::size_t i) const {
        const auto [begin, end] = mesh_.entries(i);
        return 1 + (end - begin) + static_cast<std::uint64_t>(mesh_.face_offsets[end] - mesh_.face_offsets[begin]);
    }

    void put_faces(std::size_t i, ByteSink& out) const {
        const auto [begin, end] = mesh_.entries(i);
        out.put_binary(static_cast<std::int32_t>(end - begin));
        for (std::size_t entry = begin; entry < end; ++entry) {
            const auto corners = mesh_.polygon(entry);
            out.put_binary(static_cast<std::int32_t>(corners.size()));
            out.put(bytes_of(corners));
        }
    }

    const Mesh& mesh_;
    std::vector<std::size_t> rows_;  // the cells in the order of the file
    std::vector<Block> points_, topology_, values_;
};

}  // namespace

void write_vtu(const Mesh& mesh, ByteSink& out) {
    VtuWriter(mesh).write(out);
}

}  // namespace votess::files
