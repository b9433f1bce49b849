#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

template <typename Number>
constexpr NumberType type_of() {
    if constexpr (std::is_same_v<Number, double>) return NumberType::float64;
    if constexpr (std::is_same_v<Number, std::int64_t>) return NumberType::int64;
    if constexpr (std::is_same_v<Number, std::int32_t>) return NumberType::int32;
    if constexpr (std::is_same_v<Number, std::uint32_t>) return NumberType::uint32;
    if constexpr (std::is_same_v<Number, std::int8_t>) return NumberType::int8;
    return NumberType::uint8;
}

}  // namespace

std::vector<ResultArray> result_arrays(const votess::Tessellation& cells, const votess::Want& wanted) {
    std::vector<ResultArray> arrays;
    const auto add = [&]<typename Number>(std::string_view name, std::span<const Number> values,
                                          std::size_t columns = 1) {
        const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
        arrays.push_back({name, type_of<Number>(), columns, bytes});
    };
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
    return arrays;
}

}  // namespace clvotess
