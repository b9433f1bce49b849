// The arrays of a result and their groups: the only list of them. A new array is a row here, its maker and its test.
//
// votess.hpp makes Want and the accessors of Tessellation of these rows, votess.h the bits VOTESS_WANT_*,
// row_arrays.hpp the table that copies, joins, packs, writes and exposes arrays. tools/arrays.py copies them to Python
// and to the page on files. A file that includes this one defines the macros that it reads; all end here.
//
// VOTESS_GROUP(name, NAME, bit, value): a field of Want, which requests arrays; its bit in C, and its default.
//
// VOTESS_ROW_ARRAY(name, type, per, components, group, column, text): an array with values for each cell or entry.
// Those of a Tessellation, a stream and a rank have the same names.
//   type        of a value; Id: 32 bits, in a stream and a rank 64
//   per         cell: N; entry: indptr[N], the faces behind the rows; vertex: V; other: the text begins with the shape
//   components  of each. 3: a vector, which has two components in the plane
//   group       that requests it; every: part of every result
//   column      its name in tables of cells (.csv, .xyz, .dump, .vtu); "": none
//   text        its meaning and unit; "; only" where an array may be missing: empty in C++ and C, None in Python
//
// VOTESS_ROW_STARTS: the same, of the offsets of the rows. VOTESS_OTHER_ARRAY: of a Tessellation alone.
#ifndef VOTESS_GROUP
#define VOTESS_GROUP(...)
#endif
#ifndef VOTESS_ROW_ARRAY
#define VOTESS_ROW_ARRAY(...)
#endif
#ifndef VOTESS_ROW_STARTS
#define VOTESS_ROW_STARTS(...)
#endif
#ifndef VOTESS_OTHER_ARRAY
#define VOTESS_OTHER_ARRAY(...)
#endif

VOTESS_GROUP(neighbors, NEIGHBORS, 1, true)
VOTESS_GROUP(volumes, VOLUMES, 2, true)
VOTESS_GROUP(centroids, CENTROIDS, 4, false)
VOTESS_GROUP(counts, COUNTS, 8, false)
VOTESS_GROUP(areas, AREAS, 16, false)      // adds neighbors
VOTESS_GROUP(normals, NORMALS, 32, false)  // adds neighbors
VOTESS_GROUP(surfaces, SURFACES, 64, false)
VOTESS_GROUP(radii, RADII, 128, false)
VOTESS_GROUP(vertices, VERTICES, 256, false)  // adds neighbors
VOTESS_GROUP(faces, FACES, 512, false)        // adds vertices, neighbors, and walls in the rows

VOTESS_ROW_ARRAY(indices, Id, entry, 1, neighbors, "",
                 "the concatenated rows: ids of neighbors, ascending, then by shift; walls come first, being negative")
VOTESS_ROW_ARRAY(shifts, std::int8_t, entry, 3, neighbors, "",
                 "numbers of box vectors that carry each neighbor to where it touches, if both seeds are inside the "
                 "box; only in a periodic domain")
VOTESS_ROW_ARRAY(face_areas, double, entry, 1, areas, "",
                 "areas of faces, length unit squared, with walls where the rows list them. The absolute error is at "
                 "most 1e-10 of the surface of the cell, or 1e-5 in single precision, so a tiny face may have area 0")
VOTESS_ROW_ARRAY(face_normals, double, entry, 3, normals, "", "outward unit normals of faces")
VOTESS_ROW_ARRAY(volumes, double, cell, 1, volumes, "volume", "volumes, length unit cubed; 0 for a seed without a cell")
VOTESS_ROW_ARRAY(centroids, double, cell, 3, centroids, "centroid",
                 "centers of mass, in the coordinates of the points; NaN for a seed without a cell")
VOTESS_ROW_ARRAY(surface_areas, double, cell, 1, surfaces, "surface_area",
                 "surface areas of the cells, walls included, length unit squared")
VOTESS_ROW_ARRAY(security_radii, double, cell, 1, radii, "security_radius",
                 "twice the distance from each seed to the farthest vertex of its cell, length unit")
VOTESS_ROW_ARRAY(face_counts, std::uint32_t, cell, 1, counts, "face_count", "numbers of faces, walls included")
VOTESS_ROW_ARRAY(edge_counts, std::uint32_t, cell, 1, counts, "edge_count", "numbers of edges")
VOTESS_ROW_ARRAY(vertex_counts, std::uint32_t, cell, 1, counts, "vertex_count", "numbers of vertices")
VOTESS_ROW_ARRAY(status, CellStatus, cell, 1, every, "", "values of CellStatus")
VOTESS_ROW_ARRAY(duplicate_of, Id, cell, 1, every, "",
                 "the seed that keeps the cell, -1 for seeds with a cell; only with duplicates")

VOTESS_ROW_STARTS(indptr, std::int64_t, other, 1, neighbors, "",
                  "(N + 1,) row i of the neighbors begins at indices[indptr[i]]")
VOTESS_OTHER_ARRAY(mesh_areas, double, cell, 1, surfaces, "mesh_area",
                   "areas of the surface of the mesh in each cell, length unit squared; only in a mesh")
VOTESS_OTHER_ARRAY(vertices, double, vertex, 3, vertices, "",
                   "coordinates of the vertices. Those that are equal in exact arithmetic occur once, except for their "
                   "periodic images")
VOTESS_OTHER_ARRAY(cell_vertex_indptr, std::int64_t, other, 1, vertices, "",
                   "(N + 1,) the vertices of cell i begin at cell_vertex_indices[cell_vertex_indptr[i]]")
VOTESS_OTHER_ARRAY(cell_vertex_indices, std::int32_t, other, 1, vertices, "",
                   "(cell_vertex_indptr[N],) rows of vertices, ascending for each cell; in the plane counterclockwise")
VOTESS_OTHER_ARRAY(face_offsets, std::int64_t, other, 1, faces, "",
                   "(indptr[N] + 1,) the polygon of entry k begins at face_vertices[face_offsets[k]]")
VOTESS_OTHER_ARRAY(face_vertices, std::int32_t, other, 1, faces, "",
                   "(face_offsets[indptr[N]],) rows of vertices, the concatenated polygons, counterclockwise seen from "
                   "outside the cell; -1 at infinity")
VOTESS_OTHER_ARRAY(ids, std::int32_t, cell, 1, every, "", "the seeds of the rows; only in a subset")
VOTESS_OTHER_ARRAY(weights, double, other, 1, every, "", "(N,) the weights of the points; only in a power diagram")

#undef VOTESS_GROUP
#undef VOTESS_ROW_ARRAY
#undef VOTESS_ROW_STARTS
#undef VOTESS_OTHER_ARRAY
