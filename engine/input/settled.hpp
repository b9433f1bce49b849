// A run, settled: points and options became these values once, in settle(), and nothing above knows the options. Parts
// of the run are copies with other seeds, another region or other wants.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "input/region.hpp"
#include "votess/row_arrays.hpp"

namespace votess {

// The input as given, in one of the two spans.
struct Points {
    std::span<const double> f64;
    std::span<const float> f32;
    std::uint64_t first = 0;  // number of the first one in messages

    [[nodiscard]] std::size_t coordinates() const { return f64.size() + f32.size(); }
    [[nodiscard]] std::size_t count() const { return coordinates() / 3; }
    [[nodiscard]] double operator[](std::size_t i) const { return f32.empty() ? f64[i] : f32[i]; }
};

// Weights as given, or radii, which mean their squares. Messages name them as given.
struct Weights {
    std::vector<double> given;
    bool are_radii = false;

    [[nodiscard]] bool empty() const { return given.empty(); }
    [[nodiscard]] double operator[](std::size_t i) const { return are_radii ? given[i] * given[i] : given[i]; }
};

// What the rows of a result hold.
struct Wanted {
    Want want;  // with all that these need, see imply()
    bool list_walls = false;
    double min_face = 0, min_area = 0;
    Duplicates duplicates = Duplicates::merge;
};

// Where and how a run works. It changes no list.
struct Execution {
    std::string device = "auto";
    Precision precision = Precision::single;
    unsigned threads = 0, grid_resolution = 0, k_init = 0, chunk_size = 0;
    bool follow = false;  // keep cells for the next call
    std::string instructions;
    ProgressCallback progress;
    LogCallback log;
};

struct Settled : Wanted, Execution {
    Points points;
    Weights weights;
    Region region;
    std::optional<std::vector<std::int64_t>> subset;  // seeds that have rows, as given
};

// Returns the arrays with those that they need.
inline Want with_implied(Want want) {
    want.vertices |= want.faces;
    want.neighbors |= want.areas || want.normals || want.vertices;
    return want;
}
inline void imply(Wanted& wanted) {
    wanted.want.areas |= wanted.min_face > 0 || wanted.min_area > 0;
    wanted.want = with_implied(wanted.want);
    wanted.list_walls |= wanted.want.faces;
}

// Returns whether arrays are wanted that are not in `known`.
inline bool exceeds(const Want& want, const Want& known) {
    return std::ranges::any_of(array_groups,
                               [&](const GroupInfo& group) { return want.*group.word && !(known.*group.word); });
}
// Whether whole polytopes are needed.
inline bool needs_polytopes(const Want& want) {
    return exceeds(want, {.centroids = true, .counts = true, .areas = true});
}

// Whether coordinates of vertices are needed.
inline bool needs_geometry(const Want& want) {
    return want.volumes || want.centroids || want.areas || want.surfaces || want.radii || want.vertices;
}

}  // namespace votess
