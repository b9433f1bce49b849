#include "read/input.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <span>

#include "core/system.hpp"
#include "failure.hpp"
#include "files/formats/hdf5_module.hpp"
#include "files/input_file.hpp"
#include "files/line_reader.hpp"
#include "files/numbers.hpp"
#include "files/text_source.hpp"
#include "read/frames.hpp"

namespace clvotess {
namespace {

bool is_int64(double number) {
    return number == std::floor(number) && number >= -0x1p63 && number < 0x1p63;
}

double bits_of(double integer) {
    return std::bit_cast<double>(static_cast<std::int64_t>(integer));
}

// Returns whether a number is the one that digits say.
bool is_exact(double number, std::string_view digits) {
    if (digits.starts_with('+')) digits.remove_prefix(1);
    std::array<char, 400> text;
    const auto [end, error] =
        std::to_chars(text.data(), text.data() + text.size(), number, std::chars_format::fixed, 0);
    return error == std::errc() && std::string_view(text.data(), end) == digits;
}

using Vector3 = std::array<double, 3>;
using votess::system::path_of;
using votess::system::text_of;

constexpr const char* known =
    "known are .xyz .extxyz .txt .dat .csv .npy .npz .h5 .hdf5 .h5md .dump .lammpstrj .data .lmp .vasp .ply .tess, "
    "POSCAR, "
    "text without an extension, and on stdin as -; text also as .gz";

void refuse_options_of_others(const std::string& path, const std::string& extension, const ReadRequest& request) {
    if (!request.dataset.empty() && extension != ".h5" && extension != ".npz") {
        throw bad_input("--dataset goes with .h5, .hdf5, .h5md and .npz only, not with " + in_quotes(path));
    }
    constexpr std::array<std::string_view, 9> by_name{".txt",  ".dat",       ".csv", "",    ".xyz",
                                                      ".dump", ".lammpstrj", ".npz", ".ply"};
    const auto of_rows = std::span(by_name).first(5);
    if (request.npy_holds_columns && extension != ".npy" && std::ranges::find(of_rows, extension) == of_rows.end())
        throw bad_input("rays are rows of text or of .npy, not " + in_quotes(path));
    const bool named = std::ranges::find(by_name, extension) != by_name.end() || request.npy_holds_columns;
    if (!request.coordinates.empty() && !named)
        throw bad_input("--columns goes with rows of text, .npz, .ply and LAMMPS dumps only, not with " +
                        in_quotes(path));
    const bool frames = extension == ".dump" || extension == ".lammpstrj" || extension == ".xyz" || extension == ".h5";
    if (request.frame && !frames)
        throw bad_input("--frame goes with .xyz, LAMMPS dumps (.dump, .lammpstrj) and .h5 only, not with " +
                        in_quotes(path));
}

void refuse_columns(const std::string& path, const ReadRequest& request) {
    if (!request.columns.empty() && !request.columns_may_lack && !request.npy_holds_columns)
        throw bad_input(path + ": a single array has no column " + in_quotes(request.columns[0]));
}

// Returns the extension that names the format. LAMMPS calls its examples data.NAME and dump.NAME, VASP its files
// POSCAR, CONTCAR, XDATCAR and OUTCAR with or without a suffix.
std::string kind_of(const std::string& path) {
    if (path == "-") return ".txt";
    const std::string extension = extension_of(path);
    if (extension == ".extxyz") return ".xyz";
    if (extension == ".hdf5" || extension == ".h5md") return ".h5";
    constexpr std::array<std::string_view, 14> extensions{".xyz", ".txt", ".dat",  ".csv",       ".npy",
                                                          ".npz", ".h5",  ".dump", ".lammpstrj", ".data",
                                                          ".lmp", ".ply", ".vasp", ".tess"};
    if (std::ranges::find(extensions, extension) != extensions.end()) return extension;
    const std::string name = text_of(path_of(path).filename());
    if (name.starts_with("data.")) return ".data";
    if (name.starts_with("dump.")) return ".dump";
    if (name.starts_with("POSCAR") || name.starts_with("CONTCAR")) return ".vasp";
    if (name.starts_with("XDATCAR") || name.starts_with("OUTCAR")) return ".xdatcar";
    return extension;
}

// Returns whether the path is the base of a snapshot in several files, without extension.
bool is_snapshot_base(const std::string& path) {
    std::error_code problem;
    if (std::filesystem::exists(path_of(path), problem)) return false;
    return std::filesystem::exists(path_of(path + ".0.hdf5"), problem) ||
           std::filesystem::exists(path_of(path + ".0.h5"), problem);
}

bool is_hdf5(const std::string& path, const ReadRequest& request) {
    if (request.text || path == "-") return false;
    return kind_of(path) == ".h5" || is_snapshot_base(path);
}

Input read_file(const std::string& path, const ReadRequest& request) {
    const bool packed = !request.text && path != "-" && extension_of(path) == ".gz";
    const std::string extension = request.text ? ".txt" : kind_of(packed ? path.substr(0, path.size() - 3) : path);
    const bool hdf5 = is_hdf5(path, request);
    refuse_options_of_others(path, hdf5 ? ".h5" : extension, request);
    if (hdf5) return load_hdf5("cannot read " + in_quotes(path)).read(path, request);
    constexpr std::array<std::string_view, 4> binary{".h5", ".npy", ".npz", ".ply"};
    if (packed && std::ranges::find(binary, extension) != binary.end()) {
        throw bad_input("cannot read " + in_quotes(path) + ": only text can be packed: unpack it with gunzip");
    }
    if (extension == ".npy") {
        refuse_columns(path, request);
        return read_npy(path, request);
    }
    const bool text = std::ranges::find(binary, extension) == binary.end();
    using Parser = Input (*)(std::string_view, const std::string&, const ReadRequest&);
    const auto parse = [&](Parser parser) {
        if (!text) return parser(read_whole(path), path, request);
        TextSource source(path, packed);
        return parser(rest_of(source), source.name(), request);
    };
    if (extension == ".txt" || extension == ".dat" || extension.empty()) {
        return parse(
            [](auto bytes, auto& name, auto& request) { return parse_text(bytes, TextKind::plain, name, request); });
    }
    if (extension == ".xyz") return read_xyz(std::make_unique<TextSource>(path, packed), request);
    if (extension == ".vasp") return parse(parse_poscar);
    if (extension == ".tess") return parse(parse_tess);
    if (extension == ".csv") {
        return parse(
            [](auto bytes, auto& name, auto& request) { return parse_text(bytes, TextKind::csv, name, request); });
    }
    if (extension == ".npz") return parse(parse_npz);
    if (extension == ".dump" || extension == ".lammpstrj")
        return read_frame(*open_dump_frames(std::make_unique<TextSource>(path, packed), request),
                          request.frame.value_or(0));
    if (extension == ".data" || extension == ".lmp") return parse(parse_lammps_data);
    if (extension == ".ply") return parse(parse_ply);
    const std::string remedy = conversion(extension);
    throw bad_input("cannot read " + in_quotes(path) + ": " + (remedy.empty() ? known : remedy));
}

}  // namespace

bool reads_shares(const std::string& path, const ReadRequest& request) {
    return is_hdf5(path, request) || (!request.text && path != "-" && extension_of(path) == ".npy");
}

std::string conversion(std::string_view extension) {
    struct Family {
        std::string_view extensions, to;
    };
    constexpr std::array<Family, 5> families{{
        {" .cif .pdb .pqr .gro .xsf .cube .traj .xdatcar ",
         "extended XYZ, for example with ASE: ase convert FILE out.extxyz"},
        {" .xtc .trr .dcd .gsd .nc ",
         "a LAMMPS dump with OVITO in Python: export_file(import_file('FILE'), 'out.dump', 'lammps/dump', "
         "multiple_frames=True, columns=['Particle Identifier', 'Position.X', 'Position.Y', 'Position.Z'])"},
        {" .vtk .stl .obj .off .pcd .las .laz ", ".ply, for example with PyVista, Open3D or PDAL"},
        {" .vtp .vtu ",
         ".npz in Python: m = meshio.read('FILE'), or pyvista.read('FILE') for .vtp; "
         "numpy.savez('out.npz', points=m.points, **m.point_data)"},
        {" .fits .parquet .xlsx .mat .json .pkl ", ".npy, .csv or .h5, for example with NumPy or pandas"},
    }};
    for (const Family& family : families) {
        if (!extension.empty() && family.extensions.find(" " + std::string(extension) + " ") != std::string_view::npos)
            return "this format is not read; convert it to " + std::string(family.to);
    }
    return {};
}

std::string extension_of(const std::string& path) {
    return lower_case(text_of(path_of(path).extension()));
}

bool names_hdf5(const std::string& path) {
    const std::string extension = path == "-" ? "" : extension_of(path);
    return extension == ".h5" || extension == ".hdf5";
}

std::span<const std::size_t> columns_of(Dimensions dimensions) {
    static constexpr std::array<std::size_t, 3> columns{3, 2, 3};
    const std::span<const std::size_t> all(columns);
    return dimensions == Dimensions::three    ? all.first(1)
           : dimensions == Dimensions::either ? all.first(2)
                                              : all.last(2);
}

std::string shapes_of(Dimensions dimensions) {
    std::string text;
    for (const std::size_t columns : columns_of(dimensions))
        text += (text.empty() ? "(N, " : " or (N, ") + std::to_string(columns) + ")";
    return text;
}

namespace {

// Throws Failure unless the corners of a box are in order, and around a cell if there is one. For each edge that a cell
// lacks, the box may lack its ends along one axis.
void check_stated(const std::string& file, const std::vector<double>& box, const std::vector<double>& cell,
                  const std::vector<double>& origin) {
    constexpr double rounding = 1e-6;  // of cells in single precision
    const std::size_t size = box.size() / 2;
    const bool is_corner = cell.empty() && std::ranges::equal(origin, std::span(box).first(size));
    if (cell.empty() != origin.empty() && !is_corner)
        throw bad_input(file + ": there is " + (cell.empty() ? "an origin, and no cell" : "a cell, and no origin") +
                        ": a cell needs both, a box neither");
    std::size_t missing = 0, endless = 0;  // edges and axes
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const auto is_endless = [&](std::size_t k) { return box[k] == -infinity && box[size + k] == infinity; };
    for (std::size_t k = 0; k < size; ++k) {
        const auto edge = std::span(cell).subspan(cell.empty() ? 0 : size * k, cell.empty() ? 0 : size);
        missing += std::ranges::count(edge, 0.0) == static_cast<std::ptrdiff_t>(size) ? 1 : 0;
        endless += is_endless(k) ? 1 : 0;
    }
    for (std::size_t k = 0; k < size; ++k) {
        const double lower = box[k], upper = box[size + k];
        const std::string axis(1, static_cast<char>('x' + k));
        if (lower == upper)
            throw bad_input(file + ": box is flat along " + axis + ", at " + to_text(lower) +
                            (k == 2 ? ": leave z out of points and box, and add --2d" : ": give it a length there"));
        if (!(lower < upper))
            throw bad_input(file + ": box goes from " + to_text(lower) + " to " + to_text(upper) + " along " + axis +
                            ": the first row must hold its lower corner");
        if (cell.empty() || (is_endless(k) && endless <= missing)) continue;
        double from = origin[k], to = origin[k];
        for (std::size_t j = 0; j < size; ++j) (cell[size * j + k] < 0 ? from : to) += cell[size * j + k];
        const double allowed = rounding * (to - from + std::abs(origin[k]));
        const auto differs = [&](double a, double b) { return !(std::abs(a - b) <= allowed); };
        if (differs(lower, from) || differs(upper, to))
            throw bad_input(file + ": box goes from " + to_text(lower) + " to " + to_text(upper) + " along " + axis +
                            ", the cell from " + to_text(from) + " to " + to_text(to) +
                            ": box holds the bounds of the cell, or leave cell and origin out");
    }
}

}  // namespace

FileDomain stated_domain(const std::string& file, const std::vector<double>& box, const std::vector<double>& flags,
                         const std::vector<double>& cell, const std::vector<double>& origin,
                         const std::vector<double>& walls) {
    const std::size_t size = box.size() / 2;  // of vectors
    const auto vector = [size](const std::vector<double>& from, std::size_t at) {
        return std::array<double, 3>{from[at], from[at + 1], size == 3 ? from[at + 2] : 0};
    };
    FileDomain domain;
    domain.periodic_from = flags.empty() ? DomainSource::by_default : DomainSource::stated;
    std::array<bool, 3> periodic{};
    for (std::size_t k = 0; k < flags.size(); ++k) {
        if (flags[k] != 0 && flags[k] != 1)
            throw bad_input(file + ": periodic holds " + to_text(flags[k]) + ", and not 0 or 1 alone");
        periodic[k] = flags[k] == 1;
    }
    check_stated(file, box, cell, origin);
    if (!cell.empty()) {
        domain.cell = votess::TriclinicBox{vector(origin, 0), vector(cell, 0), vector(cell, size),
                                           size == 3 ? vector(cell, 6) : std::array<double, 3>{}, periodic};
        return domain;
    }
    domain.box = votess::Box{vector(box, 0), vector(box, size)};
    domain.periodic = periodic;
    for (std::size_t w = 0; w + size < walls.size(); w += size + 1)
        domain.walls.push_back({vector(walls, w), walls[w + size]});
    return domain;
}

std::string note_of_unread(const std::string& names, std::size_t dimensions) {
    return names.empty()
               ? ""
               : "not read as the domain, which needs a box of shape (2, " + std::to_string(dimensions) + "): " + names;
}

void state_cell(FileDomain& domain, const votess::TriclinicBox& cell) {
    if (cell.a == Vector3{} && cell.b == Vector3{} && cell.c == Vector3{})
        domain.periodic = domain.periodic_from == DomainSource::stated ? cell.periodic : std::array<bool, 3>{};
    else
        domain.cell = cell;
}

votess::TriclinicBox cell_of(const Vector3& lengths, const Vector3& angles) {
    Vector3 cosine{};
    for (std::size_t k = 0; k < 3; ++k)  // right angles have a cosine of 0, which radians would miss
        cosine[k] = angles[k] == 90 ? 0 : std::cos(angles[k] * std::numbers::pi / 180);
    const auto [bc, ac, ab] = cosine;
    const double sine = std::sqrt(1 - ab * ab), y = (bc - ac * ab) / sine;
    return {.a = {lengths[0], 0, 0},
            .b = {lengths[1] * ab, lengths[1] * sine, 0},
            .c = {lengths[2] * ac, lengths[2] * y, lengths[2] * std::sqrt(1 - ac * ac - y * y)}};
}

void check_one_plane(const std::string& path, const Input& input, double z, std::optional<std::uint64_t> first) {
    for (std::size_t i = 0; i < input.size(); ++i)
        if (const double of_point = input.points[3 * i + 2]; of_point != z)
            throw bad_input(path + ": " + (first ? "point " + std::to_string(*first + i) : "a point") + " has z = " +
                            to_text(of_point) + ", " + (first ? "point 0" : "another") + " has " + to_text(z) +
                            ": points of the plane have one z; choose others, or name two --columns of a table");
}

void fit_dimensions(const std::string& path, const ReadRequest& request, Input& input) {
    if (request.dimensions != Dimensions::two && !input.planar()) return;
    if (!input.planar()) {
        const std::size_t count = input.size();
        const bool whole = request.share.parts == 1;
        if (count > 0)
            check_one_plane(path, input, input.dropped_z = input.points[2], whole ? std::optional(0) : std::nullopt);
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < 2; ++k) input.points[2 * i + k] = input.points[3 * i + k];
        input.points.resize(2 * count);
        input.dimensions = 2;
    }
    FileDomain& domain = input.domain;
    domain.periodic[2] = false;
    if (domain.box) domain.box->lower[2] = domain.box->upper[2] = 0;
    if (domain.cell) {
        votess::TriclinicBox& cell = *domain.cell;
        if (cell.a[2] != 0 || cell.b[2] != 0 || cell.c[0] != 0 || cell.c[1] != 0)
            throw bad_input(path + ": in two dimensions a and b of the cell have no z, and c has nothing else: give " +
                            "--cell ax,ay,bx,by");
        cell.origin[2] = cell.c[2] = 0;
        cell.periodic[2] = false;
    }
    for (const votess::Wall& wall : domain.walls)
        if (wall.normal[2] != 0)
            throw bad_input(path + ": a wall leans against the plane of two dimensions: give --box and --wall");
}

Input read_input(const std::string& path, const ReadRequest& request) {
    Input input = read_file(path, request);
    fit_dimensions(path, request, input);
    return input;
}

std::unique_ptr<InputFrames> open_frames(const std::string& path, const ReadRequest& request) {
    const bool packed = path != "-" && extension_of(path) == ".gz";
    const std::string extension = kind_of(packed ? path.substr(0, path.size() - 3) : path);
    const bool hdf5 = is_hdf5(path, request);
    refuse_options_of_others(path, hdf5 ? ".h5" : extension, request);
    if (hdf5) return load_hdf5("cannot read " + in_quotes(path)).open_frames(path, request);
    const auto source = [&] { return std::make_unique<TextSource>(path, packed); };
    if (extension == ".dump" || extension == ".lammpstrj") return open_dump_frames(source(), request);
    if (extension == ".xyz") {
        auto text = source();
        std::string head;
        if (auto frames = open_xyz_frames(text, request, head)) return frames;
    }
    return one_frame(path, request);
}

namespace {

std::unique_ptr<InputPieces> open_whole_pieces(const std::string& path, const ReadRequest& request, std::size_t rows) {
    const std::string extension = kind_of(path);
    const bool hdf5 = is_hdf5(path, request);
    refuse_options_of_others(path, hdf5 ? ".h5" : extension, request);
    if (hdf5) return load_hdf5("cannot read " + in_quotes(path)).open(path, request, rows);
    if (extension == ".npy") {
        refuse_columns(path, request);
        return open_npy(path, request, rows);
    }
    if (extension == ".csv") return open_text(path, TextKind::csv, request, rows);
    if (extension == ".txt" || extension == ".dat" || extension.empty())
        return open_text(path, TextKind::plain, request, rows);
    if (extension == ".xyz") {
        if (auto pieces = open_xyz(path, request, rows)) return pieces;
    }
    throw bad_input(
        "--memory reads .npy, .h5 and rows of text (.txt .dat .csv, .xyz without frames, no extension, stdin as "
        "-), not " +
        in_quotes(path) + ": leave --memory out, or convert the file");
}

// Pieces of a file that may have two dimensions. The first one is read at once, since it has their number.
class FittedPieces : public InputPieces {
public:
    FittedPieces(const std::string& path, const ReadRequest& request, std::unique_ptr<InputPieces> pieces)
        : path_(path), request_(request), pieces_(std::move(pieces)) {
        (void)pieces_->restart();
        first_.emplace();
        if (!pieces_->next(*first_)) first_.reset();
        Input all;
        all.dimensions = first_ ? first_->dimensions : request.dimensions == Dimensions::two ? 2 : 3;
        all.domain = pieces_->domain;
        if (first_) fit(*first_);
        fit_dimensions(path_, request_, all);
        dimensions = all.dimensions;
        domain = all.domain;
        units = pieces_->units;
        note = pieces_->note;
    }

    bool restart() override {
        const bool restarts = pieces_->restart();
        if (restarts) first_.reset(), rows_ = 0;
        return restarts;
    }
    bool next(Input& piece) override {
        if (first_) {
            piece = std::move(*first_);
            first_.reset();
            return true;
        }
        if (!pieces_->next(piece)) return false;
        fit(piece);
        note = pieces_->note;
        return true;
    }

private:
    // Drops z, which is that of the first row.
    void fit(Input& piece) {
        const std::size_t count = piece.size();
        if (rows_ == 0 && count > 0 && !piece.planar()) z_ = piece.points[2];
        if (request_.dimensions == Dimensions::two && !piece.planar()) check_one_plane(path_, piece, z_, rows_);
        fit_dimensions(path_, request_, piece);
        rows_ += count;
    }

    std::string path_;
    ReadRequest request_;
    std::unique_ptr<InputPieces> pieces_;
    std::optional<Input> first_;  // unless it was given
    std::uint64_t rows_ = 0;
    double z_ = 0;
};

}  // namespace

std::unique_ptr<InputPieces> open_pieces(const std::string& path, const ReadRequest& request, std::size_t rows) {
    auto pieces = open_whole_pieces(path, request, rows);
    if (request.dimensions == Dimensions::three) return pieces;
    return std::make_unique<FittedPieces>(path, request, std::move(pieces));
}

void Input::append(const Input& rows) {
    if (!rows.points.empty()) dimensions = rows.dimensions;
    points.insert(points.end(), rows.points.begin(), rows.points.end());
    ids.insert(ids.end(), rows.ids.begin(), rows.ids.end());
    species.insert(species.end(), rows.species.begin(), rows.species.end());
    if (columns.empty()) {
        columns = rows.columns;
        return;
    }
    for (std::size_t c = 0; c < rows.columns.size(); ++c) columns[c].append_all(rows.columns[c]);
}

void InputColumn::append(double number, std::string_view text) {
    if (const auto integer = read_int64(text)) return append_integer(*integer);
    const bool digits = !text.empty() && text.find_first_not_of("+-0123456789") == std::string_view::npos;
    if (digits && !is_exact(number, text)) {
        throw bad_input("the column " + in_quotes(name) + " holds the integer " + std::string(text) +
                        ", which 64 bits cannot hold: leave it out of --copy");
    }
    if (!is_int64(number)) hold_doubles();
    values.push_back(of_integers ? bits_of(number) : number);
}

void InputColumn::append_integer(std::int64_t integer) {
    const auto number = static_cast<double>(integer);
    const bool exact = number < 0x1p63 && static_cast<std::int64_t>(number) == integer;
    if (!exact && keeps_integers) hold_integers();
    values.push_back(of_integers ? std::bit_cast<double>(integer) : number);
}

void InputColumn::append_all(const InputColumn& rows) {
    if (!rows.keeps_integers) hold_doubles();
    if (rows.of_integers) hold_integers();
    if (of_integers && !rows.of_integers && !std::ranges::all_of(rows.values, is_int64)) hold_doubles();
    values.reserve(values.size() + rows.values.size());
    for (std::size_t k = 0; k < rows.values.size(); ++k)
        values.push_back(!of_integers ? rows.rounded(k) : rows.of_integers ? rows.values[k] : bits_of(rows.values[k]));
    words.insert(words.end(), rows.words.begin(), rows.words.end());
}

void InputColumn::hold_integers() {
    if (of_integers || !keeps_integers) return;
    if (!std::ranges::all_of(values, is_int64)) return hold_doubles();
    std::ranges::transform(values, values.begin(), bits_of);
    of_integers = true;
}

void InputColumn::hold_doubles() {
    values = rounded();
    keeps_integers = of_integers = false;
}

std::vector<double> InputColumn::rounded() const {
    std::vector<double> numbers(values.size());
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = rounded(k);
    return numbers;
}

void refuse_large_integers(std::span<const InputColumn> columns, const std::string& place) {
    for (const InputColumn& column : columns)
        if (column.of_integers)
            throw bad_input("the column " + in_quotes(column.name) + " holds integers beyond 2^53, which " + place +
                            " would round: leave it out, or name it id to read it as the ids");
}

std::span<const double> one_each(const InputColumn& column) {
    if (column.width == 1) return column.values;
    throw bad_input("the column " + in_quotes(column.name) + " has " + std::to_string(column.width) +
                    " numbers for each point: name a column with one");
}

}  // namespace clvotess
