// The seeds: from a file, from stdin, or random. One source file for each family of formats.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
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

class TextSource;

// The source of a property of the domain.
enum class DomainSource : std::uint8_t {
    option,     // from the command line
    stated,     // by the file
    assumed,    // by a rule of the format, where the file does not state it
    by_default  // the bounds of the points, no periodic axis
};

// The domain that a file states.
struct FileDomain {
    std::optional<votess::Box> box;
    std::array<bool, 3> periodic{};            // may be stated without a box
    std::optional<votess::TriclinicBox> cell;  // instead of box and periodic
    std::vector<votess::Wall> walls;           // cut the box
    DomainSource periodic_from = DomainSource::by_default;
    DomainSource corner_from = DomainSource::stated;  // assumed: the cell begins at 0 for want of another statement
};

// A number or a text that belongs to the whole file.
struct Attribute {
    std::string name;
    std::variant<double, std::string> value;
};

// Numbers or words of the points.
struct InputColumn {
    std::string name;
    std::size_t width = 1;
    std::vector<double> values = {};      // width N, row by row
    std::vector<std::string> words = {};  // N, instead of numbers
    bool of_words = false;
    bool keeps_integers = false;  // a column of integers has all of their digits; other numbers are doubles
    bool of_integers = false;     // `values` holds the bits of std::int64_t: a double would round one of these integers

    // Returns whether a number may stand for an integer that a double rounds.
    [[nodiscard]] bool may_round(double number) const {
        return keeps_integers && (of_integers || !(std::abs(number) < 0x1p53));
    }
    // Appends a number that may_round(). text: as the file has it, or empty. Throws Failure for an integer that neither
    // a double nor std::int64_t holds.
    void append(double number, std::string_view text);
    void append_integer(std::int64_t integer);
    void append_all(const InputColumn& rows);

    [[nodiscard]] std::int64_t integer(std::size_t k) const { return std::bit_cast<std::int64_t>(values[k]); }
    // Returns a number, rounded if no double holds it.
    [[nodiscard]] double rounded(std::size_t k) const {
        return of_integers ? static_cast<double>(integer(k)) : values[k];
    }
    [[nodiscard]] std::vector<double> rounded() const;

private:
    void hold_integers();  // if all numbers are integers; else they stay doubles from now on
    void hold_doubles();
};

struct Input {
    std::vector<double> points;        // 3N: x0 y0 z0 x1 ..., or 2N in the plane
    std::size_t dimensions = 3;        // 2 in the plane: z is 0 in the domain
    double dropped_z = 0;              // of all points, from a file that has one
    std::vector<std::int64_t> ids;     // N, or empty without a column of ids
    std::vector<InputColumn> columns;  // those of ReadRequest::columns, then all others with all_columns
    std::vector<std::string> species;  // N with ReadRequest::species, if the file names them; else empty
    FileDomain domain;
    std::vector<Attribute> units;        // stated by the file, for the output
    std::string note;                    // the part of the file that was read, for the summary; may be empty
    std::optional<std::uint64_t> frame;  // number from 0, of a file of frames
    std::string timestep;                // a number that the file states; may be empty

    [[nodiscard]] std::size_t size() const noexcept { return points.size() / dimensions; }
    [[nodiscard]] bool planar() const noexcept { return dimensions == 2; }
    // Appends points with the same columns.
    void append(const Input& rows);
};

// Throws Failure if a column holds integers that a double would round. place: what cannot hold them.
void refuse_large_integers(std::span<const InputColumn> columns, const std::string& place);

// Returns the numbers of a column with one number for each point. Throws Failure when it has more.
[[nodiscard]] std::span<const double> one_each(const InputColumn& column);

// Returns the domain in the arrays of .npz and .h5: box 6, periodic 3 or empty, cell 9 and origin 3 or empty, walls 4
// each. In the plane box 4, periodic 2, cell 4, origin 2, walls 3 each. Without `periodic` no axis repeats. file: for
// messages. Throws Failure if they contradict each other.
[[nodiscard]] FileDomain stated_domain(const std::string& file, const std::vector<double>& box,
                                       const std::vector<double>& periodic, const std::vector<double>& cell,
                                       const std::vector<double>& origin, const std::vector<double>& walls);
// Returns the note of arrays that would state a domain if there were a box; empty without names.
[[nodiscard]] std::string note_of_unread(const std::string& names, std::size_t dimensions);

// States a cell. One whose edges are all 0 states the periodic axes alone, as ASE writes atoms without a cell.
void state_cell(FileDomain& domain, const votess::TriclinicBox& cell);

// Returns the cell of edges with these lengths and the angles bc, ac, ab in degrees: a along x, b in the plane of x and
// y. It is periodic along all edges.
[[nodiscard]] votess::TriclinicBox cell_of(const std::array<double, 3>& lengths, const std::array<double, 3>& angles);

// Consecutive rows: one of `parts` parts of about equal length.
struct Share {
    std::uint64_t part = 0, parts = 1;

    [[nodiscard]] std::uint64_t begin(std::uint64_t rows) const noexcept {
        return rows / parts * part + std::min(part, rows % parts);
    }
    [[nodiscard]] std::uint64_t end(std::uint64_t rows) const noexcept { return Share{part + 1, parts}.begin(rows); }
};

// The numbers of coordinates that points may have.
enum class Dimensions : std::uint8_t { three, either, two };

// Returns the numbers of columns that arrays of points may have, the preferred one first.
[[nodiscard]] std::span<const std::size_t> columns_of(Dimensions dimensions);
// Returns their shapes for messages: "(N, 3) or (N, 2)".
[[nodiscard]] std::string shapes_of(Dimensions dimensions);

// What to read from a file.
struct ReadRequest {
    bool text = false;  // rows of text, whatever the extension is
    Dimensions dimensions = Dimensions::three;
    std::string dataset;  // path of the points in .h5, or member of .npz; empty: the only one that fits
    std::vector<std::string> coordinates;  // columns of x, y and perhaps z; empty: by the rules of the format
    std::vector<std::string> columns;      // names, or numbers from 1 in files of rows
    bool npy_holds_columns = false;  // side by side after `coordinates`; else a .npy has none. Text then has no others
    bool columns_may_lack = false;   // skip those of `columns` that the file lacks
    bool all_columns = false;        // read the others too
    std::size_t first_carried = SIZE_MAX;  // from this one on, columns go into the output
    bool carries_words = true;             // those may hold words
    bool species = false;                  // read those too
    std::optional<std::uint64_t> frame;    // number from 0, of LAMMPS dumps and XYZ; default the first
    unsigned threads = 1;                  // that parse text; 0: one per processor
    Share share;                           // of the points, for files that reads_shares() accepts
};

// Returns whether a share of the file can be read without the rest.
[[nodiscard]] bool reads_shares(const std::string& path, const ReadRequest& request);

// Throws Failure unless all points have this z. first: number of the first point, if it is known.
void check_one_plane(const std::string& path, const Input& input, double z, std::optional<std::uint64_t> first);

// Returns the points of a file with a known extension, or of text on stdin for "-". Throws Failure.
[[nodiscard]] Input read_input(const std::string& path, const ReadRequest& request = {});

// Drops z from points of one plane and from the domain, if the request is for two dimensions or the points have two
// coordinates. Throws Failure for points of several planes, and unless the domain is a prism along z.
void fit_dimensions(const std::string& path, const ReadRequest& request, Input& input);

enum class TextKind {
    plain,  // .txt and stdin
    csv,    // may begin with a line of names
};

// The readers of the formats. Messages begin with `name:`, or `name:line:` where there are lines. They throw Failure.
[[nodiscard]] Input parse_text(std::string_view text, TextKind kind, const std::string& name,
                               const ReadRequest& request = {});
// Returns whether the first line that is not blank is one whole number, the count of a frame.
[[nodiscard]] bool holds_frames(std::string_view text, const std::string& name);
// Reads .xyz: plain rows, or a frame.
[[nodiscard]] Input read_xyz(std::unique_ptr<TextSource> source, const ReadRequest& request);
[[nodiscard]] Input parse_poscar(std::string_view text, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_tess(std::string_view text, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_lammps_data(std::string_view text, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_ply(std::string_view bytes, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input parse_npz(std::string_view bytes, const std::string& name, const ReadRequest& request);
[[nodiscard]] Input read_npy(const std::string& path, const ReadRequest& request = {});
// Returns the indices in a .npy of whole numbers, or of a flag for each of `count` points.
[[nodiscard]] std::vector<std::int64_t> read_npy_indices(const std::string& path, std::size_t count);

// Returns random seeds in the unit box, or unit square. They depend on `rng_seed` alone, not on the machine.
[[nodiscard]] Input random_points(std::uint64_t count, std::uint64_t rng_seed, const ReadRequest& request = {});

// Returns random seeds inside of a mesh, equally likely everywhere. Throws Failure, and votess::Error for a mesh that
// is not closed.
[[nodiscard]] Input random_points_in(const votess::TriangleMesh& mesh, std::size_t dimensions, std::uint64_t count,
                                     std::uint64_t rng_seed, unsigned threads);

// The seeds of a file in pieces, for files larger than memory.
class InputPieces {
public:
    virtual ~InputPieces() = default;
    // Goes back to the first piece. Returns false where that is impossible or slow.
    virtual bool restart() = 0;
    // Reads the next points with ids and columns, into memory that is reused. Returns false at the end.
    virtual bool next(Input& piece) = 0;

    FileDomain domain;
    std::vector<Attribute> units;
    std::string note;            // complete after the last piece
    std::size_t dimensions = 3;  // of all points
};

// Opens a file in pieces of about `rows` rows. Throws Failure, also for formats that cannot be read in pieces.
[[nodiscard]] std::unique_ptr<InputPieces> open_pieces(const std::string& path, const ReadRequest& request,
                                                       std::size_t rows);

[[nodiscard]] std::unique_ptr<InputPieces> open_text(const std::string& path, TextKind kind, const ReadRequest& request,
                                                     std::size_t rows);
// Returns nothing when the file holds frames.
[[nodiscard]] std::unique_ptr<InputPieces> open_xyz(const std::string& path, const ReadRequest& request,
                                                    std::size_t rows);
[[nodiscard]] std::unique_ptr<InputPieces> open_npy(const std::string& path, const ReadRequest& request,
                                                    std::size_t rows);
[[nodiscard]] std::unique_ptr<InputPieces> open_random(std::uint64_t count, std::uint64_t rng_seed,
                                                       const ReadRequest& request, std::size_t rows);

// Returns how to convert a known format that cannot be read; empty for other extensions.
[[nodiscard]] std::string conversion(std::string_view extension);

// Returns the extension in lower case with its dot; "" without one.
[[nodiscard]] std::string extension_of(const std::string& path);
// Returns whether an output of that name is HDF5.
[[nodiscard]] bool names_hdf5(const std::string& path);

}  // namespace clvotess
