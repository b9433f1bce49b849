// Files of meshes, written by votess_write_mesh(). In a mesh those of pieces, written by votess_write_pieces().
#include <votess/votess.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <exception>
#include <numeric>
#include <string>
#include <type_traits>
#include <vector>
#include <votess/pieces.hpp>

#include "failure.hpp"
#include "files/output_file.hpp"
#include "words.hpp"
#include "write/columns.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

struct Target {
    OutputFile& file;
    bool reports_size;
    std::exception_ptr error;  // thrown in the callback
};

std::string megabytes(std::uint64_t bytes) {
    return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

int take(const votess_bytes* bytes, void* user) {
    Target& target = *static_cast<Target*>(user);
    try {
        if (target.reports_size)
            std::fprintf(stderr, "%s takes %s\n", target.file.description().c_str(), megabytes(bytes->total).c_str());
        target.reports_size = false;
        OutputFile& file = bytes->file ? target.file.beside(bytes->file) : target.file;
        file.write({static_cast<const char*>(bytes->data), bytes->count});
        return 1;
    } catch (...) {
        target.error = std::current_exception();
        return 0;
    }
}

// Returns a view of the tessellation, without colors and columns.
votess_mesh mesh_of(const OutputData& data) {
    const votess::Tessellation& cells = data.tessellation;
    votess_mesh mesh{};
    mesh.struct_size = sizeof mesh;
    mesh.cells = cells.size();
    mesh.planar = cells.planar();
    mesh.vertex_count = cells.vertices().size() / (cells.planar() ? 2 : 3);
    mesh.indptr = cells.indptr().data();
    mesh.indices = cells.indices().data();
    mesh.shifts = cells.shifts().empty() ? nullptr : cells.shifts().data();
    mesh.face_offsets = cells.face_offsets().data();
    mesh.face_vertices = cells.face_vertices().data();
    mesh.vertices = cells.vertices().data();
    mesh.cell_vertex_indptr = cells.cell_vertex_indptr().data();
    mesh.cell_vertex_indices = cells.cell_vertex_indices().data();
    std::ranges::copy(cells.box().lower, mesh.box_lower);
    std::ranges::copy(cells.box().upper, mesh.box_upper);
    if (cells.cell())
        for (std::size_t k = 0; k < 3; ++k)
            mesh.edges[k] = cells.cell()->a[k], mesh.edges[3 + k] = cells.cell()->b[k],
            mesh.edges[6 + k] = cells.cell()->c[k];
    const auto infinite = [](double x) { return std::isinf(x); };
    const bool endless =
        std::ranges::any_of(cells.box().lower, infinite) || std::ranges::any_of(cells.box().upper, infinite);
    if (endless && !data.skip_open)
        throw bad_input("meshes hold no cells that reach infinity: leave them out by --open skip, or give --box");
    mesh.skip_open = data.skip_open ? 1 : 0;
    return mesh;
}

// Throws the message of the C interface, with options as members, as cli/words.cpp expects them.
[[noreturn]] void throw_last_error(votess_status status, std::string message) {
    message += votess_last_error();
    constexpr std::string_view named = "options.";
    for (std::size_t at = 0; (at = message.find(named, at)) != std::string::npos;)
        message.replace(at, named.size(), "Options::");
    throw votess::Error(static_cast<votess::ErrorCode>(status), message);
}

// function: votess_write_mesh or votess_write_pieces.
template <typename Arrays>
void write_by(votess_status (*function)(const Arrays*, const char*, votess_write_callback, void*), const Arrays& arrays,
              OutputFile& file, const char* format, bool reports_size) {
    Target target{file, reports_size, nullptr};
    const votess_status status = function(&arrays, format, take, &target);
    if (target.error) std::rethrow_exception(target.error);
    if (status != VOTESS_OK) throw_last_error(status, "cannot write " + file.description() + ": ");
}

void print_short_edges(OutputFile& file, const OutputData& data, std::uint64_t count) {
    if (count > 0 && data.reports_size)
        std::fprintf(stderr,
                     "%s keeps %s edges below --min-edge, for cells would not remain polyhedra of about their volumes, "
                     "or vertices would leave their walls\n",
                     file.description().c_str(), std::to_string(count).c_str());
}

void write(OutputFile& file, const OutputData& data, votess_mesh mesh, const char* format) {
    std::uint64_t left_out = 0, short_edges = 0;
    mesh.left_out = &left_out;
    mesh.short_edges = &short_edges;
    mesh.min_edge = data.min_edge;
    write_by(votess_write_mesh, mesh, file, format, data.reports_size && std::string_view(format) == ".glb");
    if (left_out > 0 && data.reports_size)
        std::fprintf(stderr, "%s leaves out %s\n", file.description().c_str(), open_cells(left_out).c_str());
    print_short_edges(file, data, short_edges);
}

// Returns the ids of the rows, or their numbers.
std::vector<std::int64_t> ids_of(const OutputData& data) {
    std::vector<std::int64_t> ids = data.input.ids;
    if (!ids.empty()) return ids;
    ids.resize(data.tessellation.size());
    std::iota(ids.begin(), ids.end(), std::int64_t{0});
    return ids;
}

void print_quality(OutputFile& file, const votess_mesh_quality& quality) {
    std::fprintf(stderr,
                 "%s has non-orthogonality up to %.3g degrees, mean %.3g, skewness up to %.3g, edges from %.3g on\n",
                 file.description().c_str(), quality.max_non_orthogonality, quality.mean_non_orthogonality,
                 quality.max_skewness, quality.min_edge);
}

void write_pieces(OutputFile& file, const OutputData& data, const char* format) {
    votess::PieceOptions options;
    options.gap = data.gap;
    options.threads = data.threads;
    const votess::Pieces pieces = votess::pieces(data.tessellation, options);
    const std::vector<std::int64_t> ids = ids_of(data);
    votess_piece_arrays arrays{};
    arrays.struct_size = sizeof arrays;
    arrays.rows = ids.size();
    arrays.indptr = pieces.indptr.data();
    arrays.ids = ids.data();
    arrays.vertex_offsets = pieces.vertex_offsets.data();
    arrays.vertices = pieces.vertices.data();
    arrays.triangle_offsets = pieces.triangle_offsets.data();
    arrays.triangles = pieces.triangles.data();
    arrays.on_surface = pieces.on_surface.data();
    arrays.centroids = pieces.centroids.data();
    arrays.sources = pieces.sources.data();
    arrays.min_edge = data.min_edge;
    std::uint64_t short_edges = 0;
    arrays.short_edges = &short_edges;
    votess_mesh_quality quality{};
    quality.struct_size = sizeof quality;
    const std::string_view name = format;
    if (name == ".foam" && data.reports_size) arrays.quality = &quality;
    write_by(votess_write_pieces, arrays, file, format, name == ".glb" && data.reports_size);
    print_short_edges(file, data, short_edges);
    if (arrays.quality != nullptr) print_quality(file, quality);
}

template <typename Number>
votess_column column(const char* name, char kind, std::span<const Number> values, std::size_t width = 1) {
    return {name, values.data(), width, kind, sizeof(Number)};
}

// Each piece of a cell in a mesh is a polyhedron, with the numbers of its row except volume and centroid.
void write_vtu_of_pieces(OutputFile& file, const OutputData& data) {
    votess::PieceOptions options;
    options.gap = data.gap;
    options.threads = data.threads;
    const votess::Tessellation& cells = data.tessellation;
    const votess::Pieces pieces = votess::pieces(cells, options);
    const std::vector<std::int64_t> ids_of_rows = ids_of(data);
    std::vector<std::int64_t> ids;
    std::vector<std::int32_t> neighbors;
    std::vector<votess::CellStatus> status;
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < cells.size(); ++i)
        for (std::int64_t p = pieces.indptr[i]; p < pieces.indptr[i + 1]; ++p) {
            rows.push_back(i);
            ids.push_back(ids_of_rows[i]);
            neighbors.push_back(static_cast<std::int32_t>(cells.neighbors(i).size()));
            status.push_back(cells.status()[i]);
        }
    std::vector<votess_column> columns{
        column<std::int64_t>("id", 'i', ids), column<double>("volume", 'f', pieces.volumes),
        column<std::int32_t>("neighbors", 'i', neighbors), column<double>("centroid", 'f', pieces.centroids, 3),
        column<votess::CellStatus>("status", 'u', status)};
    std::vector<std::vector<double>> carried;
    for (const InputColumn& from : data.carried) {
        std::vector<double>& values = carried.emplace_back();
        for (const std::size_t i : rows)
            for (std::size_t k = 0; k < from.width; ++k) values.push_back(from.values[from.width * i + k]);
    }
    for (std::size_t k = 0; k < carried.size(); ++k)
        columns.push_back(column<double>(data.carried[k].name.c_str(), data.carried[k].of_integers ? 'i' : 'f',
                                         carried[k], data.carried[k].width));
    const std::size_t triangles = pieces.sources.size();
    const std::vector<std::int32_t> beyond(triangles, -1);
    std::vector<std::int64_t> offsets(triangles + 1);
    for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = static_cast<std::int64_t>(3 * t);
    std::vector<std::int32_t> corners = pieces.triangles, vertices(pieces.vertices.size() / 3);
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (auto k = static_cast<std::size_t>(3 * pieces.triangle_offsets[p]);
             k < static_cast<std::size_t>(3 * pieces.triangle_offsets[p + 1]); ++k)
            corners[k] += static_cast<std::int32_t>(pieces.vertex_offsets[p]);
    std::iota(vertices.begin(), vertices.end(), 0);
    votess_mesh mesh{};
    mesh.struct_size = sizeof mesh;
    mesh.cells = pieces.size();
    mesh.vertex_count = vertices.size();
    mesh.indptr = pieces.triangle_offsets.data();
    mesh.indices = beyond.data();
    mesh.face_offsets = offsets.data();
    mesh.face_vertices = corners.data();
    mesh.vertices = pieces.vertices.data();
    mesh.cell_vertex_indptr = pieces.vertex_offsets.data();
    mesh.cell_vertex_indices = vertices.data();
    mesh.columns = columns.data();
    mesh.column_count = static_cast<std::uint32_t>(columns.size());
    write(file, data, mesh, ".vtu");
}

}  // namespace

bool is_vtu_array(std::string_view name) {
    return name == "id" || name == "neighbors" || name == "status" || is_column(name);
}

void write_vtu(OutputFile& file, const OutputData& data) {
    const votess::Tessellation& cells = data.tessellation;
    if (cells.in_mesh()) return write_vtu_of_pieces(file, data);
    const std::vector<std::int64_t> ids = ids_of(data);
    std::vector<std::int32_t> neighbors;
    for (std::size_t i = 0; i < cells.size(); ++i)
        neighbors.push_back(static_cast<std::int32_t>(
            std::ranges::count_if(cells.neighbors(i), [](std::int32_t j) { return j >= 0; })));
    std::vector<votess_column> columns{column<std::int64_t>("id", 'i', ids)};
    std::deque<std::vector<double>> in_space;  // VTK's vectors have three components
    for_columns(cells, data.wanted, [&](const auto& array, const auto& values) {
        using Number = typename std::remove_cvref_t<decltype(values)>::value_type;
        if constexpr (std::is_same_v<Number, double>) {
            if (cells.planar() && array.components == 3) {
                std::vector<double>& vectors = in_space.emplace_back(3 * cells.size());
                for (std::size_t k = 0; k < values.size(); ++k) vectors[k / 2 * 3 + k % 2] = values[k];
                return columns.push_back(column<double>(array.column.data(), 'f', vectors, 3));
            }
        }
        const char kind = std::is_floating_point_v<Number> ? 'f' : 'u';
        columns.push_back(column<Number>(array.column.data(), kind, values, array.components));
    });
    // Volumes and centroids are always wanted here, see add_output_needs().
    columns.insert(columns.begin() + 2, column<std::int32_t>("neighbors", 'i', neighbors));
    columns.insert(columns.begin() + 4, column("status", 'u', cells.status()));
    for (const InputColumn& carried : data.carried)
        columns.push_back(
            column<double>(carried.name.c_str(), carried.of_integers ? 'i' : 'f', carried.values, carried.width));
    votess_mesh mesh = mesh_of(data);
    mesh.columns = columns.data();
    mesh.column_count = static_cast<std::uint32_t>(columns.size());
    write(file, data, mesh, ".vtu");
}

void write_solid(OutputFile& file, const OutputData& data, const char* extension) {
    if (data.tessellation.in_mesh()) return write_pieces(file, data, extension);
    write(file, data, mesh_of(data), extension);
}

void write_tess(OutputFile& file, const OutputData& data) {
    votess_mesh mesh = mesh_of(data);
    mesh.seeds = data.input.points.data();
    if (!data.tessellation.weights().empty()) mesh.weights = data.tessellation.weights().data();
    write(file, data, mesh, ".tess");
}

// The file itself is empty, as ParaView wants it. The folder constant/polyMesh beside it has the mesh.
void write_foam(OutputFile& file, const OutputData& data) {
    if (data.tessellation.in_mesh()) return write_pieces(file, data, ".foam");
    votess_mesh mesh = mesh_of(data);
    votess_mesh_quality quality{};
    quality.struct_size = sizeof quality;
    if (data.reports_size) mesh.quality = &quality;
    write(file, data, mesh, ".foam");
    if (data.reports_size) print_quality(file, quality);
}

void write_glb(OutputFile& file, const OutputData& data) {
    if (data.tessellation.in_mesh()) return write_pieces(file, data, ".glb");
    votess::PictureOptions options;
    options.colormap = data.coloring.colormap;
    const std::vector<double> values = data.coloring.values(data.input, data.tessellation, data.carried);
    options.values = values;
    const std::vector<std::uint8_t> colors = votess::value_colors(options);
    votess_mesh mesh = mesh_of(data);
    mesh.colors = colors.data();
    write(file, data, mesh, ".glb");
}

}  // namespace clvotess
