// Files of pieces, each of them an object.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>
#include <votess/pieces.hpp>

#include "files/byte_sink.hpp"

namespace votess::files {

struct NamedPieces {
    const Pieces& pieces;
    std::vector<std::string> names;  // P
};

// Returns names of the rows: their ids, and after a point the number of the piece if a row has several.
[[nodiscard]] std::vector<std::string> piece_names(const Pieces& pieces, std::span<const std::int64_t> ids);

// Each writes a whole file. Throw invalid_argument for a file beyond 4 GiB.
void write_pieces_glb(const NamedPieces& given, ByteSink& out);
void write_pieces_obj(const NamedPieces& given, ByteSink& out);
void write_pieces_stl(const NamedPieces& given, ByteSink& out);
void write_pieces_3mf(const NamedPieces& given, ByteSink& out);

}  // namespace votess::files
