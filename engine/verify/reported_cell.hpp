// Reported cells against the cells that every seed leaves, without any search structure.
//
// Two seeds that are neighbors among all seeds are neighbors in any subset that holds both. So each block clips the
// cell by its own seeds and replies with those that have faces. Clipped by the seeds of all replies, the cell is
// complete.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "input/seeds.hpp"
#include "plane/sheet.hpp"
#include "unbounded/endless_box.hpp"
#include "votess/votess.hpp"

namespace votess {

// Duplicates and seeds outside have no cell.
inline bool takes_part(CellStatus status) {
    return status != CellStatus::duplicate && status != CellStatus::outside;
}

// An error that subnormal numbers may have.
inline constexpr double smallest_double = std::numeric_limits<double>::denorm_min();

// Relative errors of the volume of one cell and of the sum of all. The error of a face's area is relative to the cell's
// surface, as that of the cell's volume.
struct VolumeTolerance {
    double cell, sum;
};
inline constexpr VolumeTolerance double_tolerance{1e-10, 1e-9}, single_tolerance{1e-5, 1e-4};

// The run whose cells are checked. In the plane it is that of a sheet, and the rows those of the plane.
struct CheckedRun {
    Settled settled;           // the domain, and whether rows list walls; without weights
    std::uint64_t seeds = 0;   // of all blocks
    double domain_volume = 0;  // that cells fill
    VolumeTolerance tolerance = double_tolerance;
    std::vector<std::int64_t> only{};  // of a subset: the seeds that have rows, ascending; otherwise empty
    bool planar = false;               // whether the rows are those of the plane
    EndlessSides ends{};               // where the domain has none: the run has near ones, whose cells are not tried

    // Whether the row of a neighbor is there.
    [[nodiscard]] bool has_row(std::int64_t id) const {
        return id >= 0 && (only.empty() || std::ranges::binary_search(only, id));
    }
    // Returns whether rows list a face with that id of a cell of the run.
    [[nodiscard]] bool lists(std::int32_t id) const {
        return id >= 0 || (settled.list_walls && !(planar && Sheet::bounds(id)));
    }
};

struct ReportedFace {
    std::int64_t id = 0;  // of the neighbor, or a wall
    std::array<std::int8_t, 3> shift{};
    double area = 0;

    [[nodiscard]] bool operator<(const ReportedFace& other) const {
        return id != other.id ? id < other.id : shift < other.shift;
    }
};

struct ReportedCell {
    std::int64_t id = 0;
    bool empty = false, has_areas = false;
    std::optional<std::vector<ReportedFace>> row;  // ascending
    std::optional<double> volume;
};

// A fault of the cell with that id. note() and merge() keep the fault of least id.
struct Fault {
    std::int64_t id = std::numeric_limits<std::int64_t>::max();
    std::string text;  // one line; "" without a fault

    template <class Describe>
    void note(std::int64_t at, const Describe& describe) {
        if (at < id) *this = {at, describe()};
    }
    void merge(Fault other) {
        if (other.id < id) *this = std::move(other);
    }
    void put_to(Writer& writer) const {
        writer.put(id);
        writer.put(std::vector<char>(text.begin(), text.end()));
    }
    void get_from(Reader& reader) {
        std::vector<char> characters;
        reader.get(id);
        reader.get(characters);
        text.assign(characters.begin(), characters.end());
    }
};

// Clips cells by every seed of a block, which ascend by id. Each request holds the seeds of some cells, its reply the
// seeds of the block that have faces with them. Adds to `work`, in distance tests.
std::vector<Message> clip_by_block(const CheckedRun& run, const Seeds& block, std::span<const Message> requests,
                                   double& work);

// Compares reported cells with those that the replies of all blocks leave. seeds: of the cells, in their order.
Fault first_difference(const CheckedRun& run, std::span<const ReportedCell> cells, const Seeds& seeds,
                       std::span<const Message> replies);

}  // namespace votess
