#include "read/hdf5/hdf5_domain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "failure.hpp"
#include "files/line_reader.hpp"

namespace clvotess {
namespace {

using Numbers = std::vector<double>;

// Appends numbers or flags, at most as many as a cell has.
void append_few(const Hdf5Dataset& set, Numbers& numbers) {
    constexpr std::size_t edges = 9;
    const bool fits = set.is_float() || set.is_whole() || set.is_flags();
    if (fits && set.bytes() <= edges * sizeof(double)) set.append_to(numbers);
}

// Returns the numbers or flags of a dataset that has some for each frame, or the same for all.
Numbers numbers_of(const Hdf5File& file, const std::string& path, const std::optional<FrameOfFile>& frame) {
    Numbers numbers;
    if (!file.has(path)) return numbers;
    Hdf5Dataset set = file.open(path);
    if (frame && set.rank() >= 2 && set.rows() == frame->frames) set.choose_frame(frame->number);
    append_few(set, numbers);
    return numbers;
}

// Returns the step of row `row` of an element of H5MD. A scalar is the distance of steps, from the attribute `offset`
// on. Returns nothing without steps.
std::optional<std::int64_t> step_of(const Hdf5File& file, const std::string& element, std::uint64_t row) {
    const std::string path = element + "/step";
    if (!file.has(path)) return std::nullopt;
    const Hdf5Dataset steps = file.open(path);
    if (!steps.is_whole() || steps.rank() > 1 || (steps.rank() == 1 && row >= steps.rows())) return std::nullopt;
    std::vector<std::int64_t> step;
    steps.append_to(step, steps.rank() == 0 ? 0 : row, 1);
    if (steps.rank() == 1) return step[0];
    const Numbers offset = file.attribute(path, "offset");
    const double first = offset.size() == 1 && std::abs(offset[0]) < 0x1p62 ? offset[0] : 0;
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(step[0]) * row +
                                     static_cast<std::uint64_t>(static_cast<std::int64_t>(first)));
}

// Returns the row of an element for a frame: the same row if there are as many, else the last one that is not of a
// later step. Throws Failure if the steps do not decide it.
std::uint64_t row_of(const Hdf5File& file, const std::string& element, const Hdf5Dataset& set,
                     const std::string& positions, const FrameOfFile& frame) {
    if (set.rows() == frame.frames) return frame.number;
    const auto step = step_of(file, positions, frame.number);
    std::uint64_t begin = 0, end = set.rows();  // the rows before `begin` are not later, those from `end` on are
    while (step && begin < end) {
        const std::uint64_t middle = begin + (end - begin) / 2;
        const auto own = step_of(file, element, middle);
        if (!own) break;
        (*own <= *step ? begin : end) = *own <= *step ? middle + 1 : middle;
    }
    if (step && begin == end && begin > 0) return begin - 1;
    throw set.error("has " + set.description() + ", expected one row for each of the " + std::to_string(frame.frames) +
                    " frames, or steps of which one is not later than frame " + std::to_string(frame.number));
}

// Returns the numbers of an element of H5MD at a frame. Those that do not change may be a dataset or an attribute.
Numbers element_of(const Hdf5File& file, const std::string& group, const char* name, const std::string& positions,
                   const std::optional<FrameOfFile>& frame) {
    const std::string element = group + "/" + name;
    if (!file.has(element + "/value")) {
        const Numbers fixed = file.attribute(group, name);
        return fixed.empty() ? numbers_of(file, element, std::nullopt) : fixed;
    }
    Hdf5Dataset set = file.open(element + "/value");
    if (frame && set.rank() >= 2) set.choose_frame(row_of(file, element, set, positions, *frame));
    Numbers numbers;
    append_few(set, numbers);
    return numbers;
}

// Throws Failure for an element of the box of H5MD with another number of numbers.
void require_size(const Hdf5File& file, const std::string& element, const Numbers& numbers, std::size_t size,
                  std::size_t other) {
    if (numbers.size() == size || numbers.size() == other) return;
    throw bad_input(file.path() + ": " + element + " does not hold " + std::to_string(size) +
                    (other == size ? "" : " or " + std::to_string(other)) +
                    " numbers or words, as many as its points " + "have axes: write it so, or leave it out");
}

// Returns the periodic axes of a box of H5MD: its element `pbc` (ZnH5MD), or the words or flags of `boundary`.
std::optional<std::array<bool, 3>> periodic_of_h5md(const Hdf5File& file, const std::string& box,
                                                    const std::string& positions, std::size_t dimensions,
                                                    const std::optional<FrameOfFile>& frame) {
    Numbers flags = element_of(file, box, "pbc", positions, frame);
    const auto is_number = [](double flag) { return !std::isnan(flag); };
    const bool is_pbc = !flags.empty() && std::ranges::all_of(flags, is_number);
    if (!is_pbc) flags = file.attribute(box, "boundary");
    if (flags.empty())
        for (const std::string& word : file.texts(box, "boundary"))
            flags.push_back(lower_case(word) == "periodic" ? 1 : 0);
    const bool stated = file.has(box + "/pbc") || file.has_attribute(box, "pbc") || file.has_attribute(box, "boundary");
    if (!stated) return std::nullopt;
    require_size(file, box + (is_pbc ? "/pbc" : "/boundary"), flags, dimensions, dimensions);
    std::array<bool, 3> periodic{};
    for (std::size_t k = 0; k < flags.size(); ++k) periodic[k] = flags[k] != 0;
    return periodic;
}

// Reads the box of H5MD: edges of a box that begins at 0, or its three vectors. Along an edge that is 0 it has no end.
std::optional<FileDomain> domain_of_h5md(const Hdf5File& file, const std::string& points, std::size_t dimensions,
                                         const std::optional<FrameOfFile>& frame) {
    const std::string group = particles_of(points), box = group + "/box";
    if (group.empty() || !file.is_group(box)) return std::nullopt;
    FileDomain domain;
    const std::string positions = group + "/position";
    const auto flags = periodic_of_h5md(file, box, positions, dimensions, frame);
    const std::array<bool, 3> periodic = flags.value_or(std::array<bool, 3>{});
    if (flags) domain.periodic_from = DomainSource::stated;
    const Numbers edges = element_of(file, box, "edges", positions, frame);
    if (file.has(box + "/edges") || file.has_attribute(box, "edges"))
        require_size(file, box + "/edges", edges, dimensions, dimensions * dimensions);
    const bool flat = edges.size() == 2, upright = flat || edges.size() == 3;
    if (upright && std::ranges::count(edges, 0.0) == 0) {
        domain.box = votess::Box{{0, 0, 0}, {edges[0], edges[1], flat ? 0 : edges[2]}};
        domain.periodic = periodic;
    } else if (upright) {
        state_cell(
            domain,
            {.a = {edges[0], 0, 0}, .b = {0, edges[1], 0}, .c = {0, 0, flat ? 0 : edges[2]}, .periodic = periodic});
    } else if (edges.size() == 4) {
        domain.cell = votess::TriclinicBox{.a = {edges[0], edges[1]}, .b = {edges[2], edges[3]}, .periodic = periodic};
    } else if (edges.size() == 9) {
        state_cell(domain, {.a = {edges[0], edges[1], edges[2]},
                            .b = {edges[3], edges[4], edges[5]},
                            .c = {edges[6], edges[7], edges[8]},
                            .periodic = periodic});
    } else {
        domain.periodic = periodic;
    }
    return domain;
}

// Reads the cell of MDTraj, by lengths and angles in degrees.
std::optional<FileDomain> domain_of_mdtraj(const Hdf5File& file, const std::optional<FrameOfFile>& frame) {
    if (!file.has("cell_lengths") && !file.has("cell_angles")) return std::nullopt;
    const auto three = [&](const char* name) {
        Numbers numbers = numbers_of(file, name, frame);
        if (numbers.size() == 3) return numbers;
        const Hdf5Dataset set = file.open(name);  // throws if it is missing
        throw set.error("has " + set.description() + ", expected three numbers for each frame");
    };
    const Numbers lengths = three("cell_lengths"), angles = three("cell_angles");
    FileDomain domain;
    domain.periodic_from = DomainSource::assumed;
    domain.cell = cell_of({lengths[0], lengths[1], lengths[2]}, {angles[0], angles[1], angles[2]});
    return domain;
}

// Returns whether SWIFT ran with periodic boundaries; nothing for other codes, which do not state it.
std::optional<bool> periodic_of_swift(const Hdf5File& file) {
    if (file.has("RuntimePars")) {
        const Numbers flag = file.attribute("RuntimePars", "PeriodicBoundariesOn");
        if (flag.size() == 1) return flag[0] != 0;
    }
    if (file.has("Parameters")) {
        const std::vector<std::string> flag = file.texts("Parameters", "InitialConditions:periodic");
        if (flag.size() == 1 && (flag[0] == "0" || flag[0] == "1")) return flag[0] == "1";
    }
    return std::nullopt;
}

// Reads the box of a snapshot, which begins at 0.
FileDomain domain_of_snapshot(const Hdf5File& file) {
    const Numbers size = file.header("BoxSize");
    FileDomain domain;
    if (size.size() != 1 && size.size() != 3) return domain;
    votess::Box box{};
    for (std::size_t k = 0; k < 3; ++k) {
        box.upper[k] = size[size.size() == 3 ? k : 0];
        if (!(box.upper[k] > 0 && std::isfinite(box.upper[k]))) return domain;
    }
    domain.box = box;
    if (const auto periodic = periodic_of_swift(file)) {
        domain.periodic.fill(*periodic);
        domain.periodic_from = DomainSource::stated;
    }
    return domain;
}

// Reads the domain in the attributes that clvotess writes. Notes those that would state one beside a box.
std::optional<FileDomain> domain_of_attributes(const Hdf5File& file, const std::string& points, std::size_t dimensions,
                                               std::string& note) {
    const auto has = [&](const char* name) { return file.has_attribute("/", name); };
    const auto fits = [&](const char* name, std::size_t rows) {  // of one number for each axis
        return file.attribute("/", name).size() == rows * dimensions &&
               (rows == 1 || file.rows_of_attribute("/", name) == rows);
    };
    const auto numbers = [&](const char* name, std::size_t rows) {
        if (has(name) && !fits(name, rows))
            throw bad_input(file.path() + ": the attribute " + name + " does not hold " +
                            (rows == 1 ? "" : std::to_string(rows) + " rows of ") + std::to_string(dimensions) +
                            " numbers: write it so, or leave it out");
        return file.attribute("/", name);
    };
    std::optional<Hdf5Dataset> planes;
    if (file.has("walls") && !file.is_group("walls")) planes.emplace(file.open("walls"));
    const bool has_walls = planes && planes->has_columns(dimensions + 1);
    if (!has("box") || (!has("periodic") && !fits("box", 2))) {
        std::string names;
        for (const char* const name : {"box", "periodic", "cell", "origin"})
            if (has(name)) add_name(names, name);
        if (has_walls && points != "walls") add_name(names, "walls");
        note = note_of_unread(names, dimensions);
        return std::nullopt;
    }
    const Numbers box = numbers("box", 2), flags = numbers("periodic", 1), cell = numbers("cell", dimensions),
                  origin = numbers("origin", 1);
    Numbers walls;
    if (planes) {
        if (!has_walls)
            throw planes->error("has " + planes->description() + ", expected shape (W, " +
                                std::to_string(dimensions + 1) + ") of floats: rename it");
        file.check_unpacked(planes->bytes());
        planes->append_to(walls);
    }
    return stated_domain(file.path(), box, flags, cell, origin, walls);
}

}  // namespace

std::string particles_of(const std::string& points) {
    constexpr std::string_view element = "/position", fixed = "/position/value";
    for (const std::string_view end : {fixed, element})
        if (points.ends_with(end)) return points.substr(0, points.size() - end.size());
    return {};
}

FileDomain domain_of_hdf5(const Hdf5File& file, const std::string& points, std::size_t dimensions,
                          const std::optional<FrameOfFile>& frame, std::string& note) {
    if (const auto domain = domain_of_attributes(file, points, dimensions, note)) return *domain;
    if (const auto domain = domain_of_h5md(file, points, dimensions, frame)) return *domain;
    if (const auto domain = domain_of_mdtraj(file, frame)) return *domain;
    FileDomain domain = domain_of_snapshot(file);
    if (!domain.box && file.has("Header") && file.has_attribute("Header", "BoxSize"))
        note += (note.empty() ? "" : "; ") + std::string("not read as the domain, for it is no length: BoxSize");
    return domain;
}

std::string timestep_of_hdf5(const Hdf5File& file, const std::string& points, std::uint64_t frame) {
    const std::string group = particles_of(points);
    const auto step = group.empty() ? std::nullopt : step_of(file, group + "/position", frame);
    return step ? std::to_string(*step) : "";
}

}  // namespace clvotess
