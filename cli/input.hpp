// The seeds: from a file, from stdin, or made up. One source file per family of formats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clvotess {

struct Input {
    std::vector<double> points;     // 3N: x0 y0 z0 x1 ...
    std::vector<std::int64_t> ids;  // N when the file has a column of ids, else empty

    [[nodiscard]] std::size_t size() const noexcept { return points.size() / 3; }
};

enum class TextKind {
    plain,  // .txt and stdin
    xyz,    // may also be the classic layout: count, comment, then `Element x y z`
    csv,    // may begin with a line of names
};

// path: a file with a known extension, or "-" for text on stdin.
[[nodiscard]] Input read_input(const std::string& path);

// name: for messages, which begin `name:line:`.
[[nodiscard]] Input parse_text(std::string_view text, TextKind kind, const std::string& name);

[[nodiscard]] Input read_npy(const std::string& path);

// `count` seeds in the unit box, the same on every machine for the same `rng_seed`.
[[nodiscard]] Input random_points(std::uint64_t count, std::uint64_t rng_seed);

// Extension in lower case with its dot; "" when there is none.
[[nodiscard]] std::string extension_of(const std::string& path);

}  // namespace clvotess
