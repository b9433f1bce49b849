// What is behind a Tessellation, in input order; see votess.hpp for shapes and units, and votess/row_arrays.hpp for the
// table of the arrays.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/buffer.hpp"
#include "votess/row_arrays.hpp"

namespace votess::solid {
struct MeshCells;
}

namespace votess::detail {

// What the rows of a subset leave open about the other seeds. Arrays are by seed.
struct AllSeeds {
    std::size_t count = 0;           // N
    std::vector<CellStatus> status;  // `duplicate` and `outside` where they hold; empty if nowhere
    std::vector<double> weights;     // in a power diagram
};

struct Result : RowArrays<Buffer, std::int32_t> {
    // Large arrays that are written at once: faults of small pages would take as long as copying rows into them.
    Result() {
        const auto use_huge_pages = [](auto&... arrays) {
            ((arrays =
                  std::remove_reference_t<decltype(arrays)>(std::remove_reference_t<decltype(arrays)>::Pages::huge)),
             ...);
        };
        use_huge_pages(indptr, indices, shifts, centroids, volumes);
    }
    Box box;
    std::array<bool, 3> periodic{};
    std::optional<TriclinicBox> cell;
    std::vector<Wall> walls;
    bool planar = false;   // in two dimensions: vectors have two components
    double thickness = 0;  // of a sheet whose result is not flat yet, see plane/sheet.hpp
    bool lists_walls = false;
    bool probed = false;  // the cells of probes, which do not fit together
    bool is_subset = false;
    std::shared_ptr<const AllSeeds> all_seeds;           // of a subset
    std::shared_ptr<const solid::MeshCells> mesh_cells;  // of a run in a mesh: what pieces() reads
    std::shared_ptr<const std::vector<std::int32_t>>
        mesh_edges;  // in the plane: those given, of the edges in mesh_cells
    double least_face = 0;
    // The polygons that were dropped, each as one of its cells has it: those of face_vertices, one after the other.
    Buffer<std::int64_t> dropped_offsets;
    Buffer<std::int32_t> dropped_vertices;
    // Seeds of positive turn, if the diagram of all of space has only one vertex: its polygons leave the turn open.
    std::optional<std::array<std::int32_t, 4>> lone_tetrahedron;
    // In periodic domains, of each vertex: the first one that it is an image of, and the box vectors from there.
    Buffer<std::int32_t> vertex_image_of;
    Buffer<std::int8_t> vertex_shifts;
#define VOTESS_OTHER_ARRAY(name, type, ...) Buffer<type> name;
#include "votess/arrays.h"
    Stats stats;
};

}  // namespace votess::detail
