#include "write/result_arrays.hpp"

#include <algorithm>
#include <array>

namespace clvotess {

bool is_result_array(std::string_view name) {
    constexpr std::array<std::string_view, 27> names{"ids",
                                                     "indptr",
                                                     "indices",
                                                     "shifts",
                                                     "face_areas",
                                                     "face_normals",
                                                     "volumes",
                                                     "centroids",
                                                     "surface_areas",
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
                                                     "domain_from"};
    return std::ranges::find(names, name) != names.end();
}

std::vector<ResultArray> result_arrays(const OutputData& data) {
    const votess::Tessellation& cells = data.tessellation;
    const votess::Want& wanted = data.wanted;
    std::vector<ResultArray> arrays;
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        arrays.push_back(as_array(name, values, columns));
    };
    if (!data.input.ids.empty()) add("ids", std::span(data.input.ids));
    if (wanted.neighbors) {
        add("indptr", cells.indptr());
        add("indices", cells.indices());
        if (!cells.shifts().empty()) add("shifts", cells.shifts(), 3);
    }
    if (wanted.areas) add("face_areas", cells.face_areas());
    if (wanted.normals) add("face_normals", cells.face_normals(), 3);
    if (wanted.volumes) add("volumes", cells.volumes());
    if (wanted.centroids) add("centroids", cells.centroids(), 3);
    if (wanted.surfaces) add("surface_areas", cells.surface_areas());
    if (wanted.radii) add("security_radii", cells.security_radii());
    if (wanted.counts) {
        add("face_counts", cells.face_counts());
        add("edge_counts", cells.edge_counts());
        add("vertex_counts", cells.vertex_counts());
    }
    if (wanted.vertices) {
        add("vertices", cells.vertices(), 3);
        add("cell_vertex_indptr", cells.cell_vertex_indptr());
        add("cell_vertex_indices", cells.cell_vertex_indices());
    }
    if (wanted.faces) {
        add("face_offsets", cells.face_offsets());
        add("face_vertices", cells.face_vertices());
    }
    add("status", cells.status());
    if (!cells.duplicate_of().empty()) add("duplicate_of", cells.duplicate_of());
    for (const InputColumn& column : data.carried) add(column.name, std::span(column.values), column.width);
    return arrays;
}

DomainArrays::DomainArrays(const votess::Tessellation& cells)
    : box_(cells.box().lower.begin(), cells.box().lower.end()),
      periodic_(cells.periodic().begin(), cells.periodic().end()) {
    box_.insert(box_.end(), cells.box().upper.begin(), cells.box().upper.end());
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        arrays_.push_back(as_array(name, std::span(values.data(), values.size()), columns));
    };
    add("box", box_, 3);
    add("periodic", periodic_);
    if (const auto& cell = cells.cell()) {
        for (const auto* edge : {&cell->a, &cell->b, &cell->c}) cell_.insert(cell_.end(), edge->begin(), edge->end());
        add("cell", cell_, 3);
        add("origin", cell->origin);
    }
    for (const votess::Wall& wall : cells.walls()) {
        walls_.insert(walls_.end(), wall.normal.begin(), wall.normal.end());
        walls_.push_back(wall.offset);
    }
    if (!walls_.empty()) add("walls", walls_, 4);
}

}  // namespace clvotess
