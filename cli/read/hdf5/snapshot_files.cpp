#include "read/hdf5/snapshot_files.hpp"

#include <filesystem>

#include "files/numbers.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

bool exists(const std::string& path) {
    std::error_code problem;
    return std::filesystem::exists(path, problem);
}

}  // namespace

std::optional<SnapshotName> split_snapshot_name(const std::string& path) {
    const std::string extension = std::filesystem::path(path).extension().string();
    const std::string stem = path.substr(0, path.size() - extension.size());
    const auto dot = stem.rfind('.');
    if (dot == std::string::npos || dot + 1 == stem.size()) return std::nullopt;
    const std::string digits = stem.substr(dot + 1);
    if (digits.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    const auto part = read_uint64(digits);
    if (!part) return std::nullopt;
    return SnapshotName{stem.substr(0, dot), *part, extension};
}

std::string first_snapshot_file(const std::string& path) {
    if (exists(path)) return path;
    const std::string own = extension_of(path);
    if (own == ".h5" || own == ".hdf5") {
        const std::string extension = path.substr(path.size() - own.size());
        const std::string first = path.substr(0, path.size() - own.size()) + ".0" + extension;
        if (exists(first)) return first;
    }
    for (const char* const extension : {".hdf5", ".h5"}) {
        if (exists(path + ".0" + extension)) return path + ".0" + extension;
    }
    return path;
}

}  // namespace clvotess
