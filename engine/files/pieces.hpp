// Files of pieces, each of them an object.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "files/byte_sink.hpp"

namespace votess::files {

struct SharedMesh;

// A view of P pieces. Indices lie inside their arrays, and offsets ascend from 0.
struct Pieces {
    std::span<const std::int64_t> indptr;  // of the rows
    std::span<const std::int64_t> ids;     // of the rows
    std::span<const std::int64_t> vertex_offsets;
    std::span<const double> vertices;
    std::span<const std::int64_t> triangle_offsets;
    std::span<const std::int32_t> triangles;
    std::span<const std::uint8_t> on_surface;
    std::span<const std::int32_t> sources;  // for files of all pieces as one mesh; may be empty
    std::span<const double> centroids;
    double min_edge = 0;  // these three as Mesh has them
    std::uint64_t* short_edges = nullptr;
    std::function<void(const SharedMesh&)> measure;

    [[nodiscard]] std::size_t size() const { return vertex_offsets.size() - 1; }
};

// Each writes a whole file. Throw invalid_argument for a file beyond 4 GiB.
void write_pieces_glb(const Pieces& pieces, ByteSink& out);
void write_pieces_obj(const Pieces& pieces, ByteSink& out);
void write_pieces_stl(const Pieces& pieces, ByteSink& out);
void write_pieces_3mf(const Pieces& pieces, ByteSink& out);
// These join the pieces, and need all of them.
void write_pieces_foam(const Pieces& pieces, ByteSink& out);
void write_pieces_msh(const Pieces& pieces, ByteSink& out);
void write_pieces_cgns(const Pieces& pieces, ByteSink& out);
// Pieces of the plane: vertices with two components, and edges instead of triangles, ring after ring.
void write_pieces_geojson(const Pieces& pieces, ByteSink& out);

}  // namespace votess::files
