#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

#include "failure.hpp"
#include "files/formats/npy_array.hpp"
#include "interrupt.hpp"
#include "read/input.hpp"
#include "stream/pieces.hpp"

namespace clvotess {
namespace {

class NpyFile {
public:
    explicit NpyFile(const std::string& path) : stream_(path, std::ios::binary) {
        if (!stream_) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
        std::error_code problem;
        const std::uint64_t size = std::filesystem::file_size(path, problem);
        if (problem) throw bad_input(path + ": not a regular file");
        const auto read = [this, path](void* to, std::uint64_t count) {
            stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
            if (!stream_) throw bad_input(path + ": the file ends too early");
        };
        const auto skip = [this](std::uint64_t count) {
            stream_.seekg(static_cast<std::streamoff>(count), std::ios::cur);
        };
        array_.emplace(ByteSource{size, read, skip}, path);
        array_->check_points();
    }
    [[nodiscard]] NpyArray& array() { return *array_; }

private:
    std::ifstream stream_;
    std::optional<NpyArray> array_;
};

class NpyPieces : public InputPieces {
public:
    NpyPieces(const std::string& path, std::size_t rows) : path_(path), rows_(rows), file_(std::in_place, path) {}

    bool restart() override {
        file_.emplace(path_);
        return true;
    }
    bool next(Input& piece) override {
        throw_if_interrupted();
        file_->array().read_next(rows_, piece.points);
        return piece.size() > 0;
    }

private:
    std::string path_;
    std::size_t rows_;
    std::optional<NpyFile> file_;
};

}  // namespace

Input read_npy(const std::string& path, const Share& share) {
    Input input;
    NpyFile file(path);
    const std::uint64_t rows = file.array().shape()[0];
    if (share.parts == 1)
        file.array().read_floats(input.points);
    else
        file.array().read_rows(input.points, share.begin(rows), share.end(rows));
    return input;
}

std::unique_ptr<InputPieces> open_npy(const std::string& path, std::size_t rows) {
    return std::make_unique<NpyPieces>(path, rows);
}

}  // namespace clvotess
