// The seeds of a file in pieces, for those that do not fit into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "read/input.hpp"

namespace clvotess {

class InputPieces {
public:
    virtual ~InputPieces() = default;
    // Begins with the first one, at first and again; false where that cannot be, or would take long.
    virtual bool restart() = 0;
    // The next points with ids and columns, in memory that is used again; false when there are no more.
    virtual bool next(Input& piece) = 0;

    FileDomain domain;
    std::vector<Attribute> units;
    std::string note;  // complete after the last piece
};

// rows: about so many in a piece. Throws Failure, also for formats that cannot be read piece by piece.
[[nodiscard]] std::unique_ptr<InputPieces> open_pieces(const std::string& path, const ReadRequest& request,
                                                       std::size_t rows);

[[nodiscard]] std::unique_ptr<InputPieces> open_text(const std::string& path, TextKind kind, const ReadRequest& request,
                                                     std::size_t rows);
// Returns nothing when the file holds frames.
[[nodiscard]] std::unique_ptr<InputPieces> open_xyz(const std::string& path, const ReadRequest& request,
                                                    std::size_t rows);
[[nodiscard]] std::unique_ptr<InputPieces> open_npy(const std::string& path, std::size_t rows);
[[nodiscard]] std::unique_ptr<InputPieces> open_random(std::uint64_t count, std::uint64_t rng_seed, std::size_t rows);

}  // namespace clvotess
