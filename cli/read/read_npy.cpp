#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "failure.hpp"
#include "files/formats/npy_array.hpp"
#include "read/input.hpp"

namespace clvotess {

Input read_npy(const std::string& path, const Share& share) {
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
    std::error_code problem;
    const std::uint64_t size = std::filesystem::file_size(path, problem);
    if (problem) throw bad_input(path + ": not a regular file");
    const auto read = [&](void* to, std::uint64_t count) {
        stream.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
        if (!stream) throw bad_input(path + ": the file ends too early");
    };
    const auto skip = [&](std::uint64_t count) { stream.seekg(static_cast<std::streamoff>(count), std::ios::cur); };
    NpyArray array({size, read, skip}, path);
    array.check_points();
    Input input;
    const std::uint64_t rows = array.shape()[0];
    if (share.parts == 1)
        array.read_floats(input.points);
    else
        array.read_rows(input.points, share.begin(rows), share.end(rows));
    return input;
}

}  // namespace clvotess
