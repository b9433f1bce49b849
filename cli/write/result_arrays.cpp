#include "write/result_arrays.hpp"

#include <algorithm>
#include <array>

namespace clvotess {

namespace {

struct AlphaNames {
    std::string_view seeds, shifts, values, gabriel;
};
constexpr std::array<AlphaNames, 4> alpha_names{
    {{"alpha_seeds_0", "alpha_shifts_0", "alpha_values_0", "alpha_gabriel_0"},
     {"alpha_seeds_1", "alpha_shifts_1", "alpha_values_1", "alpha_gabriel_1"},
     {"alpha_seeds_2", "alpha_shifts_2", "alpha_values_2", "alpha_gabriel_2"},
     {"alpha_seeds_3", "alpha_shifts_3", "alpha_values_3", "alpha_gabriel_3"}}};

// dimensions: of the points.
void add_alpha(const votess::AlphaComplex& alpha, std::size_t dimensions, bool periodic,
               std::vector<ResultArray>& arrays) {
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        arrays.push_back(as_array(name, std::span(values), columns));
    };
    for (std::size_t k = 0; k <= dimensions; ++k) {
        const votess::AlphaSimplices& simplices = alpha.simplices[k];
        add(alpha_names[k].seeds, simplices.seeds, k + 1);
        if (periodic) add(alpha_names[k].shifts, simplices.shifts, dimensions * (k + 1));
        add(alpha_names[k].values, simplices.values);
        add(alpha_names[k].gabriel, simplices.gabriel);
    }
}

}  // namespace

bool is_result_array(std::string_view name) {
    const auto of_alpha = [&](const AlphaNames& names) {
        return name == names.seeds || name == names.shifts || name == names.values || name == names.gabriel;
    };
    if (std::ranges::any_of(alpha_names, of_alpha)) return true;
    constexpr std::array<std::string_view, 29> names{"ids",
                                                     "indptr",
                                                     "indices",
                                                     "shifts",
                                                     "face_areas",
                                                     "face_normals",
                                                     "volumes",
                                                     "centroids",
                                                     "surface_areas",
                                                     "mesh_areas",
                                                     "security_radii",
                                                     "face_counts",
                                                     "edge_counts",
                                                     "vertex_counts",
                                                     "vertices",
                                                     "cell_vertex_indptr",
                                                     "cell_vertex_indices",
                                                     "face_offsets",
                                                     "face_vertices",
                                                     "status",
                                                     "duplicate_of",
                                                     "box",
                                                     "periodic",
                                                     "cell",
                                                     "origin",
                                                     "walls",
                                                     "version",
                                                     "domain_from",
                                                     "periodic_from"};
    return std::ranges::find(names, name) != names.end();
}

// Returns texts of equal length, filled with zeros.
ResultArray as_array(std::string_view name, const std::vector<std::string>& words) {
    std::size_t longest = 1;
    for (const std::string& word : words) longest = std::max(longest, word.size());
    auto bytes = std::make_shared<std::string>();
    bytes->reserve(longest * words.size());
    for (const std::string& word : words) (*bytes += word).resize(bytes->size() + longest - word.size());
    return {.name = name, .bytes = *bytes, .text = longest, .owner = bytes};
}

std::vector<ResultArray> result_arrays(const ResultPiece& piece, const votess::Want& wanted,
                                       const std::vector<InputColumn>& carried) {
    std::vector<ResultArray> arrays;
    const std::size_t size = piece.size;
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        arrays.push_back(as_array(name, std::span(values), columns));
    };
    const auto add_entries = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        add(name, values, columns);
        arrays.back().of_entries = true;
    };
    if (piece.has_ids) add("ids", piece.ids);
    if (wanted.neighbors) {
        add("indptr", piece.indptr);
        piece.wide ? add_entries("indices", piece.wide_indices) : add_entries("indices", piece.indices);
        if (piece.has_shifts) add_entries("shifts", piece.shifts, size);
    }
    if (wanted.areas) add_entries("face_areas", piece.face_areas);
    if (wanted.normals) add_entries("face_normals", piece.face_normals, size);
    if (wanted.volumes) add("volumes", piece.volumes);
    if (wanted.centroids) add("centroids", piece.centroids, size);
    if (wanted.surfaces) add("surface_areas", piece.surface_areas);
    if (wanted.surfaces && piece.in_mesh) add("mesh_areas", piece.mesh_areas);
    if (wanted.radii) add("security_radii", piece.security_radii);
    if (wanted.counts) {
        add("face_counts", piece.face_counts);
        add("edge_counts", piece.edge_counts);
        add("vertex_counts", piece.vertex_counts);
    }
    add("status", piece.status);
    if (piece.has_duplicates)
        piece.wide ? add("duplicate_of", piece.wide_duplicate_of) : add("duplicate_of", piece.duplicate_of);
    for (const InputColumn& column : carried)
        column.of_words ? arrays.push_back(as_array(column.name, column.words))
                        : add(column.name, column.values, column.width);
    return arrays;
}

std::vector<ResultArray> result_arrays(const OutputData& data) {
    const votess::Tessellation& cells = data.tessellation;
    const votess::Want& wanted = data.wanted;
    ResultPiece whole;
    whole.size = size_of_vectors(cells);
    whole.ids = data.input.ids;
    whole.has_ids = !whole.ids.empty();
    whole.indptr = cells.indptr();
    whole.indices = cells.indices();
    whole.shifts = cells.shifts();
    whole.face_areas = cells.face_areas();
    whole.face_normals = cells.face_normals();
    whole.volumes = cells.volumes();
    whole.centroids = cells.centroids();
    whole.surface_areas = cells.surface_areas();
    whole.in_mesh = cells.in_mesh();
    whole.mesh_areas = cells.mesh_areas();
    whole.security_radii = cells.security_radii();
    whole.face_counts = cells.face_counts();
    whole.edge_counts = cells.edge_counts();
    whole.vertex_counts = cells.vertex_counts();
    whole.status = cells.status();
    whole.duplicate_of = cells.duplicate_of();
    whole.has_shifts = !whole.shifts.empty();
    whole.has_duplicates = !whole.duplicate_of.empty();
    std::vector<ResultArray> arrays = result_arrays(whole, wanted, data.carried), mesh;
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        mesh.push_back(as_array(name, values, columns));
    };
    if (wanted.vertices) {
        add("vertices", cells.vertices(), whole.size);
        add("cell_vertex_indptr", cells.cell_vertex_indptr());
        add("cell_vertex_indices", cells.cell_vertex_indices());
    }
    if (wanted.faces) {
        add("face_offsets", cells.face_offsets());
        add("face_vertices", cells.face_vertices());
    }
    arrays.insert(std::ranges::find(arrays, "status", &ResultArray::name), mesh.begin(), mesh.end());
    if (data.alpha != nullptr) add_alpha(*data.alpha, whole.size, cells.periodic() != std::array<bool, 3>{}, arrays);
    return arrays;
}

DomainArrays::DomainArrays(const votess::Tessellation& cells) {
    const std::size_t size = size_of_vectors(cells);
    const auto append = [size](const auto& vector, auto& to) {
        to.insert(to.end(), vector.begin(), vector.begin() + static_cast<std::ptrdiff_t>(size));
    };
    append(cells.box().lower, box_);
    append(cells.box().upper, box_);
    append(cells.periodic(), periodic_);
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        arrays_.push_back(as_array(name, std::span(values.data(), values.size()), columns));
    };
    add("box", box_, size);
    add("periodic", periodic_);
    if (const auto& cell = cells.cell()) {
        append(cell->a, cell_);
        append(cell->b, cell_);
        if (size == 3) append(cell->c, cell_);
        append(cell->origin, origin_);
        add("cell", cell_, size);
        add("origin", origin_);
    }
    for (const votess::Wall& wall : cells.walls()) {
        append(wall.normal, walls_);
        walls_.push_back(wall.offset);
    }
    if (!walls_.empty()) add("walls", walls_, size + 1);
}

}  // namespace clvotess
