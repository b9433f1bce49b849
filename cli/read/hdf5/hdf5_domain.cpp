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

// Returns the periodic axes of a box of H5MD: its element `pbc` (ZnH5MD), or the words or flags of `boundary`.
std::optional<std::array<bool, 3>> periodic_of_h5md(const Hdf5File& file, const std::string& box,
                                                    const std::string& positions,
                                                    const std::optional<FrameOfFile>& frame) {
    Numbers flags = element_of(file, box, "pbc", positions, frame);
    const auto is_number = [](double flag) { return !std::isnan(flag); };
    if (flags.empty() || !std::ranges::all_of(flags, is_number)) flags = file.attribute(box, "boundary");
    if (flags.empty())
        for (const std::string& word : file.texts(box, "boundary"))
            flags.push_back(lower_case(word) == "periodic" ? 1 : 0);
    if (flags.size() != 2 && flags.size() != 3) return std::nullopt;
    std::array<bool, 3> periodic{};
    for (std::size_t k = 0; k < flags.size(); ++k) periodic[k] = flags[k] != 0;
    return periodic;
}

// Reads the box of H5MD: edges of a box that begins at 0, or its three vectors. Along an edge that is 0 it has no end.
std::optional<FileDomain> domain_of_h5md(const Hdf5File& file, const std::string& points,
                                         const std::optional<FrameOfFile>& frame) {
    const std::string group = particles_of(points), box = group + "/box";
    if (group.empty() || !file.is_group(box)) return std::nullopt;
    FileDomain domain;
    const std::string positions = group + "/position";
    const auto flags = periodic_of_h5md(file, box, positions, frame);
    const std::array<bool, 3> periodic = flags.value_or(std::array<bool, 3>{});
    if (flags) domain.periodic_from = DomainSource::stated;
    const Numbers edges = element_of(file, box, "edges", positions, frame);
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

}  // namespace

std::string particles_of(const std::string& points) {
    constexpr std::string_view element = "/position", fixed = "/position/value";
    for (const std::string_view end : {fixed, element})
        if (points.ends_with(end)) return points.substr(0, points.size() - end.size());
    return {};
}

FileDomain domain_of_hdf5(const Hdf5File& file, const std::string& points, const std::optional<FrameOfFile>& frame) {
    const Numbers axes = file.attribute("/", "periodic");
    if (axes.size() == 2 || axes.size() == 3) {  // a file that clvotess wrote
        Numbers walls;
        if (file.has("walls") && file.open("walls").has_columns(axes.size() + 1)) {
            const Hdf5Dataset planes = file.open("walls");
            file.check_unpacked(planes.bytes());
            planes.append_to(walls);
        }
        std::array<bool, 3> periodic{};
        for (std::size_t k = 0; k < axes.size(); ++k) periodic[k] = axes[k] != 0;
        return stated_domain(file.path(), file.attribute("/", "box"), periodic, file.attribute("/", "cell"),
                             file.attribute("/", "origin"), walls);
    }
    if (const auto domain = domain_of_h5md(file, points, frame)) return *domain;
    if (const auto domain = domain_of_mdtraj(file, frame)) return *domain;
    return domain_of_snapshot(file);
}

std::string timestep_of_hdf5(const Hdf5File& file, const std::string& points, std::uint64_t frame) {
    const std::string group = particles_of(points);
    const auto step = group.empty() ? std::nullopt : step_of(file, group + "/position", frame);
    return step ? std::to_string(*step) : "";
}

}  // namespace clvotess
