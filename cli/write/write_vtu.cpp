// VTK's .vtu: one polyhedron for each cell, with data. The XML in front says where each array begins behind it, where
// they lie raw, so everything is written front to back. The cells ascend by their number of vertices, because readers
// that keep them in blocks of equal numbers (meshio 5) take the data in that order.
#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "files/output_buffer.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

constexpr std::uint8_t polyhedron = 42;  // vtkCellType.h

struct Block {
    std::string attributes;
    std::uint64_t bytes = 0;
    std::function<void(OutputBuffer&)> write;
};

template <typename Number>
Block as_it_is(std::string attributes, std::span<const Number> values) {
    const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    return {std::move(attributes), values.size_bytes(), [bytes](OutputBuffer& out) { out.put(bytes); }};
}

class VtuWriter {
public:
    explicit VtuWriter(const OutputData& data) : data_(data), cells_(data.tessellation) {
        const auto vertices_of = [&](std::size_t i) {
            return cells_.cell_vertex_indptr()[i + 1] - cells_.cell_vertex_indptr()[i];
        };
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            if (vertices_of(i) > 0) rows_.push_back(i);
        }
        std::ranges::stable_sort(rows_, {}, vertices_of);
        points_.push_back(as_it_is(R"(type="Float64" Name="Points" NumberOfComponents="3")", cells_.vertices()));
        topology_.push_back({R"(type="Int32" Name="connectivity")", cells_.cell_vertex_indices().size_bytes(),
                             [&](OutputBuffer& out) { put_vertices(out); }});
        add<std::int64_t>(topology_, "offsets", "Int64", [vertices_of, end = std::int64_t{0}](std::size_t i) mutable {
            return end += vertices_of(i);
        });
        add<std::uint8_t>(topology_, "types", "UInt8", [](std::size_t) { return polyhedron; });
        topology_.push_back(
            {R"(type="Int32" Name="faces")", faces_bytes(), [&](OutputBuffer& out) { put_faces(out); }});
        add<std::int64_t>(topology_, "faceoffsets", "Int64",
                          [&, end = std::int64_t{0}](std::size_t i) mutable { return end += faces_length(i); });
        add<std::int64_t>(values_, "id", "Int64", [&](std::size_t i) {
            return data_.input.ids.empty() ? static_cast<std::int64_t>(i) : data_.input.ids[i];
        });
        add_columns("volume", 1, cells_.volumes());
        add<std::int32_t>(values_, "neighbors", "Int32", [&](std::size_t i) {
            std::int32_t count = 0;
            for (const std::int32_t j : cells_.neighbors(i)) count += j >= 0;
            return count;
        });
        add_columns("centroid", 3, cells_.centroids());
        add<std::uint8_t>(values_, "status", "UInt8", [&](std::size_t i) { return cells_.status()[i]; });
        for (const InputColumn& column : data_.carried) add_columns(column.name, column.width, column.values);
    }

    void write(OutputFile& file) {
        OutputBuffer out(file);
        out.put(
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
            "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
            std::to_string(cells_.vertices().size() / 3) + "\" NumberOfCells=\"" + std::to_string(rows_.size()) +
            "\">\n");
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
        out.flush();
    }

private:
    // An array of one number for each cell.
    template <typename Number, typename Value>
    void add(std::vector<Block>& section, const std::string& name, const std::string& type, Value value) {
        section.push_back({"type=\"" + type + "\" Name=\"" + name + "\"", rows_.size() * sizeof(Number),
                           [this, value](OutputBuffer& out) mutable {
                               for (const std::size_t i : rows_) out.put_binary(static_cast<Number>(value(i)));
                           }});
    }

    // Data of the cells: so many columns of a table that has a row for each seed.
    void add_columns(const std::string& name, std::size_t width, std::span<const double> table) {
        const std::string components = width == 1 ? "" : " NumberOfComponents=\"" + std::to_string(width) + "\"";
        values_.push_back({"type=\"Float64\" Name=\"" + xml_escaped(name) + "\"" + components,
                           rows_.size() * width * sizeof(double), [this, width, table](OutputBuffer& out) {
                               for (const std::size_t i : rows_) {
                                   for (const double x : table.subspan(width * i, width)) out.put_binary(x);
                               }
                           }});
    }

    static void put_section(OutputBuffer& out, const std::string& name, const std::vector<Block>& blocks,
                            std::uint64_t& offset) {
        out.put("<" + name + ">\n");
        for (const Block& block : blocks) {
            out.put("<DataArray " + block.attributes + " format=\"appended\" offset=\"" + std::to_string(offset) +
                    "\"/>\n");
            offset += sizeof block.bytes + block.bytes;
        }
        out.put("</" + name + ">\n");
    }

    void put_vertices(OutputBuffer& out) const {
        for (const std::size_t i : rows_) {
            const auto begin = static_cast<std::size_t>(cells_.cell_vertex_indptr()[i]);
            const auto end = static_cast<std::size_t>(cells_.cell_vertex_indptr()[i + 1]);
            for (const std::int32_t vertex : cells_.cell_vertex_indices().subspan(begin, end - begin)) {
                out.put_binary(vertex);
            }
        }
    }

    // `faces` holds for each cell its number of faces, then for each face its number of vertices and the vertices.
    [[nodiscard]] std::int64_t faces_length(std::size_t i) const {
        const std::int64_t begin = cells_.indptr()[i], end = cells_.indptr()[i + 1];
        const auto offsets = cells_.face_offsets();
        return 1 + (end - begin) + offsets[static_cast<std::size_t>(end)] - offsets[static_cast<std::size_t>(begin)];
    }

    [[nodiscard]] std::uint64_t faces_bytes() const {
        std::uint64_t numbers = 0;
        for (const std::size_t i : rows_) numbers += static_cast<std::uint64_t>(faces_length(i));
        return numbers * sizeof(std::int32_t);
    }

    void put_faces(OutputBuffer& out) const {
        const auto offsets = cells_.face_offsets();
        for (const std::size_t i : rows_) {
            const auto begin = static_cast<std::size_t>(cells_.indptr()[i]);
            const auto end = static_cast<std::size_t>(cells_.indptr()[i + 1]);
            out.put_binary(static_cast<std::int32_t>(end - begin));
            for (std::size_t face = begin; face < end; ++face) {
                const auto first = static_cast<std::size_t>(offsets[face]);
                const auto count = static_cast<std::size_t>(offsets[face + 1]) - first;
                out.put_binary(static_cast<std::int32_t>(count));
                for (const std::int32_t vertex : cells_.face_vertices().subspan(first, count)) out.put_binary(vertex);
            }
        }
    }

    const OutputData& data_;
    const votess::Tessellation& cells_;
    std::vector<std::size_t> rows_;  // the cells in the order of the file
    std::vector<Block> points_, topology_, values_;
};

}  // namespace

std::string xml_escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
    }
    return result;
}

bool is_vtu_array(std::string_view name) {
    constexpr std::array<std::string_view, 5> names{"id", "volume", "neighbors", "centroid", "status"};
    return std::ranges::find(names, name) != names.end();
}

void write_vtu(OutputFile& file, const OutputData& data) {
    VtuWriter(data).write(file);
}

}  // namespace clvotess
