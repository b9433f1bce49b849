#include <filesystem>
#include <optional>
#include <span>

#include "core/system.hpp"
#include "failure.hpp"
#include "files/formats/npy_array.hpp"
#include "files/input_file.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

class NpyFile {
public:
    // Refuses a FIFO before opening it, which would wait for a writer.
    explicit NpyFile(const std::string& path) {
        std::error_code problem;
        const auto status = std::filesystem::status(votess::system::path_of(path), problem);
        if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
            throw bad_input(path + ": not a regular file");
        file_.emplace(path);
        const auto read = [this](void* to, std::uint64_t count) {
            if (file_->read(static_cast<char*>(to), count) < count)
                throw bad_input(file_->name() + ": the file ends too early");
        };
        const auto skip = [this](std::uint64_t count) { file_->skip(count); };
        array_.emplace(ByteSource{file_->size(), read, skip}, path);
    }
    // widths: numbers of columns that points may have.
    NpyFile(const std::string& path, std::span<const std::size_t> widths) : NpyFile(path) {
        array_->check_points(widths);
    }
    [[nodiscard]] NpyArray& array() { return *array_; }

private:
    std::optional<InputFile> file_;
    std::optional<NpyArray> array_;
};

class NpyPieces : public InputPieces {
public:
    NpyPieces(const std::string& path, const ReadRequest& request, std::size_t rows)
        : path_(path), widths_(columns_of(request.dimensions)), rows_(rows), file_(std::in_place, path, widths_) {}

    bool restart() override {
        file_.emplace(path_, widths_);
        return true;
    }
    bool next(Input& piece) override {
        piece.dimensions = file_->array().shape()[1];
        file_->array().read_next(rows_, piece.points);
        return piece.size() > 0;
    }

private:
    std::string path_;
    std::span<const std::size_t> widths_;
    std::size_t rows_;
    std::optional<NpyFile> file_;
};

Input read_npy_with_columns(const std::string& path, std::size_t dimensions, const std::vector<std::string>& names) {
    const std::size_t width = dimensions + names.size();
    std::vector<double> rows;
    NpyFile(path, {&width, 1}).array().read_numbers(rows);
    Input input;
    input.dimensions = dimensions;
    for (const std::string& name : names) input.columns.push_back({.name = name});
    for (std::size_t k = 0; k < rows.size(); ++k)
        (k % width < dimensions ? input.points : input.columns[k % width - dimensions].values).push_back(rows[k]);
    return input;
}

}  // namespace

Input read_npy(const std::string& path, const ReadRequest& request) {
    if (request.npy_holds_columns) return read_npy_with_columns(path, request.coordinates.size(), request.columns);
    const Share& share = request.share;
    Input input;
    NpyFile file(path, columns_of(request.dimensions));
    input.dimensions = file.array().shape()[1];
    const std::uint64_t rows = file.array().shape()[0];
    if (share.parts == 1)
        file.array().read_numbers(input.points);
    else
        file.array().read_rows(input.points, share.begin(rows), share.end(rows));
    return input;
}

std::vector<std::int64_t> read_npy_indices(const std::string& path, std::size_t count) {
    NpyFile file(path);
    NpyArray& array = file.array();
    const bool mask = array.is_flags();
    if (!array.is_column() || !array.is_whole() || (mask && array.shape()[0] != count))
        throw bad_input(path + ": array of shape " + array.shape_text() +
                        ", expected a list of indices, or a flag for " + "each of the " + std::to_string(count) +
                        " points");
    const std::vector<std::int64_t> values = array.read_whole();
    if (!mask) return values;
    std::vector<std::int64_t> indices;
    for (std::size_t i = 0; i < count; ++i)
        if (values[i] != 0) indices.push_back(static_cast<std::int64_t>(i));
    return indices;
}

std::unique_ptr<InputPieces> open_npy(const std::string& path, const ReadRequest& request, std::size_t rows) {
    return std::make_unique<NpyPieces>(path, request, rows);
}

}  // namespace clvotess
