#include "read/hdf5/hdf5_domain.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "failure.hpp"
#include "files/line_reader.hpp"

namespace clvotess {
namespace {

using Numbers = std::vector<double>;

// Returns the group of the particles in H5MD; empty for other files.
std::string particles_of(const std::string& points) {
    constexpr std::string_view element = "/position", fixed = "/position/value";
    for (const std::string_view end : {fixed, element})
        if (points.ends_with(end)) return points.substr(0, points.size() - end.size());
    return {};
}

// Returns the numbers of a dataset that has some for each frame, or the same for all.
Numbers numbers_of(const Hdf5File& file, const std::string& path, const std::optional<FrameOfFile>& frame) {
    Numbers numbers;
    if (!file.has(path)) return numbers;
    Hdf5Dataset set = file.open(path);
    if (!set.is_float() && !set.is_whole()) return numbers;
    constexpr std::size_t edges = 9;
    if (frame && set.rank() >= 2 && set.rows() == frame->frames) set.choose_frame(frame->number);
    if (set.bytes() > edges * sizeof(double)) return numbers;
    set.append_to(numbers);
    return numbers;
}

// Reads the box of H5MD: edges of a box that begins at 0, or its three vectors; `boundary` names the periodic ones.
std::optional<FileDomain> domain_of_h5md(const Hdf5File& file, const std::string& points,
                                         const std::optional<FrameOfFile>& frame) {
    const std::string group = particles_of(points), box = group + "/box";
    if (group.empty() || !file.is_group(box)) return std::nullopt;
    FileDomain domain;
    const std::vector<std::string> boundary = file.texts(box, "boundary");
    std::array<bool, 3> periodic{};
    if (boundary.size() == 2 || boundary.size() == 3) {
        domain.periodic_from = DomainSource::stated;
        for (std::size_t k = 0; k < boundary.size(); ++k) periodic[k] = lower_case(boundary[k]) == "periodic";
    }
    Numbers edges = file.attribute(box.c_str(), "edges");
    if (file.has(box + "/edges/value")) {
        Hdf5Dataset set = file.open(box + "/edges/value");
        if (frame && set.rows() != frame->frames) {
            throw set.error("has " + set.description() + ", expected one row for each of the " +
                            std::to_string(frame->frames) + " frames");
        }
        if (frame && set.rank() >= 2) set.choose_frame(frame->number);
        if (set.bytes() <= 10 * sizeof(double)) set.append_to(edges);
    } else if (edges.empty()) {
        edges = numbers_of(file, box + "/edges", std::nullopt);
    }
    if (edges.size() == 2 || edges.size() == 3) {
        domain.box = votess::Box{{0, 0, 0}, {edges[0], edges[1], edges.size() == 3 ? edges[2] : 0}};
        domain.periodic = periodic;
    } else if (edges.size() == 4) {
        domain.cell = votess::TriclinicBox{.a = {edges[0], edges[1]}, .b = {edges[2], edges[3]}, .periodic = periodic};
    } else if (edges.size() == 9) {
        domain.cell = votess::TriclinicBox{.a = {edges[0], edges[1], edges[2]},
                                           .b = {edges[3], edges[4], edges[5]},
                                           .c = {edges[6], edges[7], edges[8]},
                                           .periodic = periodic};
    } else {
        domain.periodic = periodic;
    }
    return domain;
}

// Reads the cell of MDTraj, by lengths and angles in degrees: a along x, b in the plane of x and y.
std::optional<FileDomain> domain_of_mdtraj(const Hdf5File& file, const std::optional<FrameOfFile>& frame) {
    if (!file.has("cell_lengths") && !file.has("cell_angles")) return std::nullopt;
    const auto three = [&](const char* name) {
        Numbers numbers = numbers_of(file, name, frame);
        if (numbers.size() == 3) return numbers;
        const Hdf5Dataset set = file.open(name);  // throws if it is missing
        throw set.error("has " + set.description() + ", expected three numbers for each frame");
    };
    const Numbers lengths = three("cell_lengths"), angles = three("cell_angles");
    std::array<double, 3> cosine{};
    for (std::size_t k = 0; k < 3; ++k)  // right angles have a cosine of 0, which radians would miss
        cosine[k] = angles[k] == 90 ? 0 : std::cos(angles[k] * std::numbers::pi / 180);
    const auto [bc, ac, ab] = cosine;
    const double sine = std::sqrt(1 - ab * ab), y = (bc - ac * ab) / sine;
    FileDomain domain;
    domain.periodic_from = DomainSource::assumed;
    domain.cell =
        votess::TriclinicBox{.a = {lengths[0], 0, 0},
                             .b = {lengths[1] * ab, lengths[1] * sine, 0},
                             .c = {lengths[2] * ac, lengths[2] * y, lengths[2] * std::sqrt(1 - ac * ac - y * y)}};
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
        return stated_domain(file.attribute("/", "box"), periodic, file.attribute("/", "cell"),
                             file.attribute("/", "origin"), walls);
    }
    if (const auto domain = domain_of_h5md(file, points, frame)) return *domain;
    if (const auto domain = domain_of_mdtraj(file, frame)) return *domain;
    return domain_of_snapshot(file);
}

std::string timestep_of_hdf5(const Hdf5File& file, const std::string& points, std::uint64_t frame) {
    const std::string group = particles_of(points);
    if (group.empty() || !file.has(group + "/position/step")) return {};
    const Hdf5Dataset steps = file.open(group + "/position/step");
    if (!steps.is_whole()) return {};
    std::vector<std::int64_t> step;
    if (steps.rank() != 1 || frame >= steps.rows()) return {};
    steps.append_to(step, frame, 1);
    return std::to_string(step[0]);
}

}  // namespace clvotess
