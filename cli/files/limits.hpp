// Limits of input files, so that a hostile file takes neither much memory nor much time. The page command-line.md lists
// them for users.
#pragma once

#include <cstddef>
#include <cstdint>

namespace clvotess {

inline constexpr std::size_t max_line = std::size_t{1} << 20;  // bytes of text
inline constexpr std::size_t max_columns = 4096;               // of a row, a property or an array
inline constexpr std::size_t max_arrays = 4096;                // members of an archive, elements of .ply
inline constexpr int max_depth = 64;                           // of HDF5

// Returns the largest number of bytes that a file of `size` bytes may unpack to. Scientific files rarely pack better
// than 20 to 1.
[[nodiscard]] constexpr std::uint64_t max_unpacked(std::uint64_t size) {
    constexpr std::uint64_t any_file = std::uint64_t{256} << 20, ratio = 100;
    return size > (UINT64_MAX - any_file) / ratio ? UINT64_MAX : any_file + ratio * size;
}

}  // namespace clvotess
