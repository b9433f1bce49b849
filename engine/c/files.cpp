// votess_write_mesh(): its arrays are checked here and become a files::Mesh. votess_write_pieces().
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "c/handles.hpp"
#include "c/piece_arrays.hpp"
#include "files/joined_pieces.hpp"
#include "files/mesh.hpp"
#include "files/pieces.hpp"
#include "files/shared_mesh.hpp"
#include "result/closed_rows.hpp"

using namespace votess::c;

namespace {

namespace files = votess::files;

constexpr std::size_t first_mesh_size = offsetof(votess_mesh, box_upper) + sizeof(votess_mesh::box_upper);
static_assert(sizeof(votess_mesh) >= first_mesh_size && sizeof(votess_mesh) <= VOTESS_LARGEST_STRUCT);
constexpr std::size_t first_pieces_size =
    offsetof(votess_piece_arrays, centroids) + sizeof(votess_piece_arrays::centroids);
static_assert(sizeof(votess_piece_arrays) >= first_pieces_size && sizeof(votess_piece_arrays) <= VOTESS_LARGEST_STRUCT);
constexpr auto max_count = static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());

template <class Element>
std::span<const Element> array(const Element* values, std::uint64_t count, const char* name,
                               const char* owner = "mesh") {
    const std::string field = std::string(owner) + "." + name;
    if (values == nullptr && count != 0) refuse(field + " is NULL");
    return {values, count};
}

// count: of rows, which offsets delimit.
std::span<const std::int64_t> offsets(const std::int64_t* values, std::uint64_t count, const char* name,
                                      const char* owner = "mesh") {
    const auto result = array(values, count + 1, name, owner);
    if (result[0] != 0 || !std::ranges::is_sorted(result))
        refuse(std::string(owner) + "." + name + " must begin with 0 and ascend");
    return result;
}

// Refuses an index that is below the least, or is not below the number of these things.
std::span<const std::int32_t> indices(const std::int32_t* values, std::uint64_t count, const char* name,
                                      std::uint64_t end, const char* things = "vertices", std::int32_t least = 0) {
    const auto result = array(values, count, name);
    const auto wrong = std::ranges::find_if(
        result, [&](std::int32_t index) { return index < least || index >= static_cast<std::int64_t>(end); });
    if (wrong != result.end()) {
        refuse(std::string("mesh.") + name + "[" + std::to_string(wrong - result.begin()) + "] is " +
               std::to_string(*wrong) + ", but there are " + std::to_string(end) + " " + things);
    }
    return result;
}

double checked_length(double given, const char* name) {
    if (!(given >= 0 && std::isfinite(given)))
        refuse(std::string(name) + " is " + std::to_string(given) + ": give a length from 0 on");
    return given;
}

files::Column column(const votess_column& given, std::uint64_t cells) {
    require(given.name, "column.name");
    const std::string name = "the column " + std::string(given.name);
    constexpr std::uint64_t largest_width = 4096;
    if (given.width == 0 || given.width > largest_width)
        refuse(name + " has " + std::to_string(given.width) + " numbers for each cell: 1 to 4096 are possible");
    const bool is_float = given.kind == 'f';
    const bool known = given.bytes == 4 || given.bytes == 8 || (!is_float && (given.bytes == 1 || given.bytes == 2));
    if (!known || (!is_float && given.kind != 'i' && given.kind != 'u'))
        refuse(name + " has numbers of an unknown type: kind is 'f', 'i' or 'u', and bytes 1, 2, 4 or 8");
    if (given.values == nullptr && cells != 0) refuse(name + " has no values: the pointer is NULL");
    const std::string type = is_float ? "Float" : given.kind == 'i' ? "Int" : "UInt";
    const auto width = static_cast<std::size_t>(given.width);
    return {given.name, type + std::to_string(8 * given.bytes), static_cast<const char*>(given.values), width,
            width * given.bytes};
}

votess_mesh_quality quality_of(const files::SharedMesh& shared) {
    const files::MeshQuality q = files::measure(shared);
    votess_mesh_quality out{};
    out.struct_size = sizeof out;
    out.cells = shared.cells();
    out.faces = shared.faces.size();
    out.internal_faces = shared.inner();
    out.vertices = shared.vertices.size() / 3;
    out.max_non_orthogonality = q.max_non_orthogonality;
    out.mean_non_orthogonality = q.mean_non_orthogonality;
    out.severe_faces = q.severe_faces;
    out.max_skewness = q.max_skewness;
    out.skew_faces = q.skew_faces;
    out.min_area = q.min_area;
    out.min_volume = q.min_volume;
    out.min_edge = q.min_edge;
    out.wrong_faces = q.wrong_faces;
    out.wrong_cells = q.wrong_cells;
    out.short_edges = shared.short_edges;
    return out;
}

void check_quality(const votess_mesh_quality* quality) {
    require(quality, "quality");
    require_struct_size(quality->struct_size, sizeof *quality, "quality.struct_size",
                        "give sizeof(votess_mesh_quality)");
}

// Returns what sets the quality of the mesh that is written. quality: may be NULL.
std::function<void(const files::SharedMesh&)> measure_into(votess_mesh_quality* quality) {
    if (quality == nullptr) return {};
    check_quality(quality);
    return [quality](const files::SharedMesh& mesh) { *quality = quality_of(mesh); };
}

struct CheckedMesh {
    files::Mesh mesh;
    std::optional<votess::detail::ClosedRows> closed;  // what the mesh holds of a domain without end
};

CheckedMesh checked(const votess_mesh& given, bool writes_faces_once) {
    if (given.cells > max_count || given.vertex_count > max_count)
        refuse("mesh.cells and mesh.vertex_count may be " + std::to_string(max_count) + " at most");
    CheckedMesh out;
    files::Mesh& mesh = out.mesh;
    mesh.planar = given.planar != 0;
    const std::size_t dimensions = mesh.planar ? 2 : 3;
    mesh.indptr = offsets(given.indptr, given.cells, "indptr");
    const auto entries = static_cast<std::uint64_t>(mesh.indptr.back());
    // Formats that write a face once for both cells need the neighbors among the cells. Those of probes are not.
    mesh.indices = writes_faces_once ? indices(given.indices, entries, "indices", given.cells, "cells",
                                               std::numeric_limits<int>::min())
                                     : array(given.indices, entries, "indices");
    if (given.shifts != nullptr) mesh.shifts = {given.shifts, dimensions * entries};
    mesh.vertices = array(given.vertices, dimensions * given.vertex_count, "vertices");
    mesh.face_offsets = offsets(given.face_offsets, entries, "face_offsets");
    mesh.face_vertices = indices(given.face_vertices, static_cast<std::uint64_t>(mesh.face_offsets.back()),
                                 "face_vertices", given.vertex_count, "vertices", -1);
    mesh.cell_vertex_indptr = offsets(given.cell_vertex_indptr, given.cells, "cell_vertex_indptr");
    mesh.cell_vertex_indices =
        indices(given.cell_vertex_indices, static_cast<std::uint64_t>(mesh.cell_vertex_indptr.back()),
                "cell_vertex_indices", given.vertex_count);
    votess::Box box;
    std::ranges::copy(given.box_lower, box.lower.begin());
    std::ranges::copy(given.box_upper, box.upper.begin());
    out.closed = votess::detail::closed_rows({mesh.indptr, mesh.face_offsets, mesh.cell_vertex_indptr, mesh.indices,
                                              mesh.face_vertices, mesh.cell_vertex_indices, mesh.shifts, mesh.vertices,
                                              box, dimensions});
    if (given.left_out != nullptr) *given.left_out = out.closed ? out.closed->left_out : 0;
    if (out.closed) {
        const auto& rows = *out.closed;
        if (given.skip_open == 0) refuse(rows.open_cells() + ": leave out such cells by mesh.skip_open");
        mesh.indptr = rows.indptr;
        mesh.indices = rows.indices;
        if (!mesh.shifts.empty()) mesh.shifts = rows.shifts;
        mesh.face_offsets = rows.face_offsets;
        mesh.face_vertices = rows.face_vertices;
        mesh.cell_vertex_indptr = rows.cell_vertex_indptr;
        mesh.cell_vertex_indices = rows.cell_vertex_indices;
        box = rows.bounds;
    }
    mesh.bounds = {box.lower, box.upper};
    for (std::size_t k = 0; k < 3; ++k) mesh.middle[k] = std::midpoint(box.lower[k], box.upper[k]);
    mesh.left_out = out.closed.has_value();
    std::ranges::copy(given.edges, mesh.edges.begin());
    mesh.skewed = std::ranges::any_of(mesh.edges, [](double x) { return x != 0; });
    for (std::size_t k = 0; k < 3 && !mesh.skewed; ++k) mesh.edges[4 * k] = box.upper[k] - box.lower[k];
    if (given.seeds != nullptr) mesh.seeds = {given.seeds, static_cast<std::size_t>(3 * given.cells)};
    if (given.weights != nullptr) mesh.weights = {given.weights, static_cast<std::size_t>(given.cells)};
    mesh.min_edge = checked_length(given.min_edge, "min_edge");
    mesh.short_edges = given.short_edges;
    mesh.measure = measure_into(given.quality);
    if (given.colors != nullptr) mesh.colors = {given.colors, static_cast<std::size_t>(3 * given.cells)};
    for (const votess_column& one : array(given.columns, given.column_count, "columns"))
        mesh.columns.push_back(column(one, given.cells));
    return out;
}

files::ByteSink sink(votess_write_callback write, void* user) {
    if (write == nullptr) refuse("write is NULL");
    return files::ByteSink([write, user](std::string_view bytes, std::uint64_t total, const std::string& file) {
        const votess_bytes piece{bytes.data(), bytes.size(), total, file.empty() ? nullptr : file.c_str()};
        if (call_back("write", [&] { return write(&piece, user); }) == 0)
            throw votess::Error(votess::ErrorCode::cancelled, "the callback write stopped the file");
    });
}

template <class Arrays>
struct Format {
    std::string_view name;
    void (*write)(const Arrays&, files::ByteSink&);
};

constexpr Format<files::Mesh> mesh_formats[] = {
    {".vtu", files::write_vtu}, {".ply", files::write_ply},   {".obj", files::write_obj},
    {".glb", files::write_glb}, {".foam", files::write_foam}, {".tess", files::write_tess},
    {".msh", files::write_msh}, {".stl", files::write_stl},   {".cgns", files::write_cgns}};

constexpr Format<files::Pieces> piece_formats[] = {
    {".glb", files::write_pieces_glb},   {".obj", files::write_pieces_obj},        {".stl", files::write_pieces_stl},
    {".3mf", files::write_pieces_3mf},   {".foam", files::write_pieces_foam},      {".msh", files::write_pieces_msh},
    {".cgns", files::write_pieces_cgns}, {".geojson", files::write_pieces_geojson}};

template <class Arrays>
void write_format(std::span<const Format<Arrays>> formats, std::string_view name, const Arrays& arrays,
                  files::ByteSink& out) {
    const auto found = std::ranges::find(formats, name, &Format<Arrays>::name);
    if (found == formats.end()) {
        std::string message = "the format is '" + std::string(name) + "': known are";
        for (const auto& format : formats) message += " " + std::string(format.name);
        refuse(message);
    }
    found->write(arrays, out);
    out.flush();
}

// Pieces are joined by what lies beyond their triangles.
void check_joined(const files::Pieces& pieces) {
    if (pieces.sources.empty() && !pieces.triangles.empty()) refuse("pieces.sources is NULL");
    if (!std::ranges::all_of(pieces.vertices, [](double x) { return std::isfinite(x); }))
        refuse("pieces.vertices must be finite");
    for (std::size_t t = 0; t < pieces.sources.size(); ++t) {
        const std::int32_t source = pieces.sources[t];
        if (source < 0 || (pieces.on_surface[t] == 0 && static_cast<std::size_t>(source) >= pieces.ids.size()))
            refuse("pieces.sources[" + std::to_string(t) + "] is " + std::to_string(source) + ", but there are " +
                   std::to_string(pieces.ids.size()) + " rows: give the pieces of all cells");
    }
}

votess_mesh mesh_of(const votess_mesh* mesh) {
    require(mesh, "mesh");
    return read_struct(*mesh, "mesh.struct_size", "give sizeof(votess_mesh)", first_mesh_size);
}

}  // namespace

files::Pieces votess::c::checked_pieces(const votess_piece_arrays* arrays, std::size_t dimensions) {
    require(arrays, "pieces");
    const votess_piece_arrays given =
        read_struct(*arrays, "pieces.struct_size", "give sizeof(votess_piece_arrays)", first_pieces_size);
    if (given.rows > max_count) refuse("pieces.rows may be " + std::to_string(max_count) + " at most");
    files::Pieces pieces;
    pieces.indptr = offsets(given.indptr, given.rows, "indptr", "pieces");
    const auto count = static_cast<std::uint64_t>(pieces.indptr.back());
    pieces.ids = array(given.ids, given.rows, "ids", "pieces");
    pieces.vertex_offsets = offsets(given.vertex_offsets, count, "vertex_offsets", "pieces");
    pieces.vertices = array(given.vertices, dimensions * static_cast<std::uint64_t>(pieces.vertex_offsets.back()),
                            "vertices", "pieces");
    pieces.triangle_offsets = offsets(given.triangle_offsets, count, "triangle_offsets", "pieces");
    const auto triangles = static_cast<std::uint64_t>(pieces.triangle_offsets.back());
    pieces.triangles = array(given.triangles, dimensions * triangles, "triangles", "pieces");
    for (std::size_t p = 0; p < count; ++p) {
        const std::int64_t vertices = pieces.vertex_offsets[p + 1] - pieces.vertex_offsets[p];
        if (vertices == 0) refuse("the piece " + std::to_string(p) + " has no vertices");
        const auto end = dimensions * static_cast<std::size_t>(pieces.triangle_offsets[p + 1]);
        for (auto k = dimensions * static_cast<std::size_t>(pieces.triangle_offsets[p]); k < end; ++k) {
            const std::int32_t v = pieces.triangles[k];
            if (v < 0 || v >= vertices)
                refuse("pieces.triangles[" + std::to_string(k) + "] is " + std::to_string(v) + ", but the piece has " +
                       std::to_string(vertices) + " vertices");
        }
    }
    pieces.on_surface = array(given.on_surface, triangles, "on_surface", "pieces");
    if (std::ranges::any_of(pieces.on_surface, [](std::uint8_t flag) { return flag > 1; }))
        refuse("pieces.on_surface must hold 0 and 1");
    if (given.sources != nullptr) pieces.sources = {given.sources, triangles};
    pieces.centroids = array(given.centroids, dimensions * count, "centroids", "pieces");
    pieces.min_edge = checked_length(given.min_edge, "pieces.min_edge");
    pieces.short_edges = given.short_edges;
    pieces.measure = measure_into(given.quality);
    return pieces;
}

votess_status votess_write_mesh(const votess_mesh* mesh, const char* format, votess_write_callback write, void* user) {
    return guarded([&] {
        require(format, "format");
        const votess_mesh given = mesh_of(mesh);
        const std::string_view name = format;
        if (given.planar != 0 && name != ".vtu")
            refuse("mesh.planar is set, but '" + std::string(name) + "' holds faces of space: give .vtu");
        const CheckedMesh checked_mesh = checked(given, name != ".vtu" && name != ".glb");
        const files::Mesh& arrays = checked_mesh.mesh;
        files::ByteSink out = sink(write, user);
        if (name == ".glb" && arrays.colors.empty() && given.cells != 0)
            refuse("mesh.colors is NULL, but .glb needs colors");
        write_format<files::Mesh>(mesh_formats, name, arrays, out);
    });
}

votess_status votess_measure_mesh(const votess_mesh* mesh, votess_mesh_quality* quality) {
    return guarded([&] {
        const votess_mesh given = mesh_of(mesh);
        check_quality(quality);
        if (given.planar != 0) refuse("mesh.planar is set, but quality is that of cells in space");
        const CheckedMesh checked_mesh = checked(given, true);
        *quality = quality_of(files::SharedMesh(checked_mesh.mesh));
    });
}

votess_status votess_measure_pieces(const votess_piece_arrays* pieces, votess_mesh_quality* quality) {
    return guarded([&] {
        check_quality(quality);
        const files::Pieces arrays = checked_pieces(pieces, 3);
        check_joined(arrays);
        const files::JoinedPieces joined(arrays);
        *quality = quality_of(files::SharedMesh(joined.mesh()));
    });
}

votess_status votess_write_pieces(const votess_piece_arrays* pieces, const char* format, votess_write_callback write,
                                  void* user) {
    return guarded([&] {
        require(pieces, "pieces");
        require(format, "format");
        const std::string_view name = format;
        const files::Pieces arrays = checked_pieces(pieces, name == ".geojson" ? 2 : 3);
        if (name == ".foam" || name == ".msh" || name == ".cgns") check_joined(arrays);
        files::ByteSink out = sink(write, user);
        write_format<files::Pieces>(piece_formats, name, arrays, out);
    });
}
