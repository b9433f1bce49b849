// The seeds: from a file, from stdin, or made up. One source file per family of formats.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>
#include <votess/votess.hpp>

namespace clvotess {

// Where a property of the domain comes from.
enum class DomainSource : std::uint8_t {
    option,     // of the command line
    stated,     // by the file
    assumed,    // by a rule of the format, because the file does not state it
    by_default  // because nothing says otherwise: the bounds of the points, no periodic axis
};

// The domain that a file gives to its points.
struct FileDomain {
    std::optional<votess::Box> box;
    std::array<bool, 3> periodic{};            // may be stated without a box
    std::optional<votess::TriclinicBox> cell;  // instead of box and periodic, with its own
    std::vector<votess::Wall> walls;           // that cut the box
    DomainSource periodic_from = DomainSource::by_default;
};

// A number or a word that belongs to the whole of a file.
struct Attribute {
    std::string name;
    std::variant<double, std::string> value;
};

// Numbers beside the points.
struct InputColumn {
    std::string name;
    std::size_t width = 1;
    std::vector<double> values;  // width N, row by row
};

struct Input {
    std::vector<double> points;        // 3N: x0 y0 z0 x1 ...
    std::vector<std::int64_t> ids;     // N when the file has a column of ids, else empty
    std::vector<InputColumn> columns;  // those that ReadRequest names, in its order, then all others if it says so
    FileDomain domain;
    std::vector<Attribute> units;  // that the file states, for the output
    std::string
        note;  // what was taken out of a file that holds more; for the summary, empty when there is nothing to say

    [[nodiscard]] std::size_t size() const noexcept { return points.size() / 3; }
};

// The numbers of a column that has one for each point. Throws Failure when it has more.
[[nodiscard]] std::span<const double> one_each(const InputColumn& column);

// Makes a domain of the arrays that .npz and .h5 hold: 6 numbers of box, 3 flags, 9 and 3 or none, and 4 for each wall.
[[nodiscard]] FileDomain stated_domain(const std::vector<double>& box, const std::array<bool, 3>& periodic,
                                       const std::vector<double>& cell, const std::vector<double>& origin,
                                       const std::vector<double>& walls);

// Consecutive rows: one of so many parts of about equal length.
struct Share {
    std::uint64_t part = 0, parts = 1;

    [[nodiscard]] std::uint64_t begin(std::uint64_t rows) const noexcept {
        return rows / parts * part + std::min(part, rows % parts);
    }
    [[nodiscard]] std::uint64_t end(std::uint64_t rows) const noexcept { return Share{part + 1, parts}.begin(rows); }
};

// What to take out of a file.
struct ReadRequest {
    bool text = false;    // rows, whatever the name of the file says
    std::string dataset;  // HDF5: path of the points; .npz: name of their member; empty: the only one that fits
    std::vector<std::string> columns;    // by names, or in files of rows numbers from 1
    bool columns_may_lack = false;       // leaves out those of `columns` that the file has not
    bool all_columns = false;            // the others too
    std::optional<std::uint64_t> frame;  // LAMMPS dump, XYZ: which one, from 0; default the first
    Share share;                         // of the points, where reads_shares() says so; others read all
};

// Whether a share of the file can be read without the rest.
[[nodiscard]] bool reads_shares(const std::string& path, const ReadRequest& request);

// path: a file with a known extension, or "-" for text on stdin. Throws Failure.
[[nodiscard]] Input read_input(const std::string& path, const ReadRequest& request = {});

enum class TextKind {
    plain,  // .txt and stdin
    csv,    // may begin with a line of names
};

// The readers. `name` and `path` are for messages, which begin `name:` or, where there are lines, `name:line:`.
[[nodiscard]] Input parse_text(std::string_view text, TextKind kind, const std::string& name,
                               const ReadRequest& request = {});
// Returns whether the first line that is not blank is one whole number, the count of a frame.
[[nodiscard]] bool holds_frames(std::string_view text, const std::string& name);
// .xyz: plain text, or frames.
[[nodiscard]] Input parse_xyz(std::string_view text, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_poscar(std::string_view text, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_lammps_dump(std::string_view text, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_lammps_data(std::string_view text, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_ply(std::string_view bytes, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_npz(std::string_view bytes, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input read_npy(const std::string& path, const Share& share = {});

// `count` seeds in the unit box, the same on every machine for the same `rng_seed`.
[[nodiscard]] Input random_points(std::uint64_t count, std::uint64_t rng_seed, const Share& share = {});

// The seeds of a file in pieces, for those that do not fit into memory.
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

// Returns how files of a known format that is not read become one that is; empty for other extensions.
[[nodiscard]] std::string conversion(std::string_view extension);

// Extension in lower case with its dot; "" when there is none.
[[nodiscard]] std::string extension_of(const std::string& path);

}  // namespace clvotess
