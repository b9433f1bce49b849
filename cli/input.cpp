#include "input.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "failure.hpp"

namespace clvotess {
namespace {

struct CloseFile {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};

std::string read_all(std::FILE* file, const std::string& name) {
    struct stat facts {};
    std::size_t expected = 0;
    if (fstat(fileno(file), &facts) == 0 && S_ISREG(facts.st_mode)) {
        expected = static_cast<std::size_t>(facts.st_size);
    }
    constexpr std::size_t piece = std::size_t{1} << 20;
    std::string text(expected + 1, '\0');  // one byte more, so that the first read also finds the end
    std::size_t used = 0;
    for (;;) {
        if (used == text.size()) text.resize(text.size() + std::max(piece, text.size() / 2));
        const std::size_t got = std::fread(text.data() + used, 1, text.size() - used, file);
        used += got;
        if (std::ferror(file)) throw bad_input("cannot read " + in_quotes(name) + ": " + std::strerror(errno));
        if (got == 0) break;
    }
    text.resize(used);
    return text;
}

std::string read_file(const std::string& path) {
    const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
    if (!file) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
    return read_all(file.get(), path);
}

}  // namespace

std::string extension_of(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return extension;
}

Input read_input(const std::string& path) {
    if (path == "-") return parse_text(read_all(stdin, "stdin"), TextKind::plain, "stdin");
    const std::string extension = extension_of(path);
    if (extension == ".npy") return read_npy(path);
    if (extension == ".txt") return parse_text(read_file(path), TextKind::plain, path);
    if (extension == ".xyz") return parse_text(read_file(path), TextKind::xyz, path);
    if (extension == ".csv") return parse_text(read_file(path), TextKind::csv, path);
    throw bad_input("cannot read " + in_quotes(path) +
                    ": this version reads .xyz, .txt, .csv and .npy, and text on stdin as -");
}

}  // namespace clvotess
