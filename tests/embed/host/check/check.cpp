#include "check/check.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

namespace host {
namespace {

using votess::CellStatus;
using votess::vulkan::Cell;
using votess::vulkan::Header;

constexpr double cpu_tolerance = 1e-10;

struct Difference {
    std::string text;
};

template <class... Parts>
void require(bool condition, const Parts&... parts) {
    if (condition) return;
    std::ostringstream text;
    text.precision(9);
    (text << ... << parts);
    throw Difference{text.str()};
}

bool unresolved(const Cell& cell) {
    return cell.status >= static_cast<std::uint32_t>(CellStatus::needs_exact) &&
           cell.status <= static_cast<std::uint32_t>(CellStatus::candidates_exhausted);
}

// What the CPU says about the same seeds.
votess::Tessellation expected_cells(const votess::vulkan::PlanOptions& plan, std::span<const float> seeds) {
    std::vector<float> points;
    points.reserve(seeds.size() / 4 * 3);
    for (std::size_t i = 0; i < seeds.size(); i += 4) points.insert(points.end(), &seeds[i], &seeds[i] + 3);
    votess::Options options;
    options.device = "cpu";
    options.box = plan.box;
    options.outside = votess::Outside::drop;
    options.list_walls = plan.list_walls;
    options.want.centroids = options.want.counts = options.want.radii = true;
    return votess::tessellate(points, options);
}

// The counts of the header are those of the cells.
void check_header(const votess::vulkan::PlanOptions& plan, const Header& header, std::span<const Cell> cells) {
    const auto with_status = [&](CellStatus status) {
        return static_cast<std::uint32_t>(std::count_if(
            cells.begin(), cells.end(), [&](const Cell& c) { return c.status == static_cast<std::uint32_t>(status); }));
    };
    require(header.seeds == cells.size(), "header: ", header.seeds, " seeds instead of ", cells.size());
    require(header.certified == with_status(CellStatus::certified), "header: ", header.certified, " certified");
    require(header.duplicates == with_status(CellStatus::duplicate), "header: ", header.duplicates, " duplicates");
    require(header.outside == with_status(CellStatus::outside), "header: ", header.outside, " outside");
    const auto left = static_cast<std::uint32_t>(std::count_if(cells.begin(), cells.end(), unresolved));
    require(header.unresolved == left, "header: ", header.unresolved, " unresolved instead of ", left);
    require(header.certified + header.unresolved + header.duplicates + header.outside == header.seeds,
            "header: the counts are not all seeds");
    std::uint64_t entries = 0, faces = 0;
    for (const Cell& cell : cells) {
        entries += cell.row_length;
        faces += cell.faces;
    }
    if (plan.neighbors) require(header.entries == entries, "header: ", header.entries, " entries instead of ", entries);
    require(header.faces == faces, "header: ", header.faces, " faces instead of ", faces);
}

template <class Row>
void check_row(std::size_t i, const Row& row, std::span<const std::int32_t> expected, const char* by) {
    require(std::equal(row.begin(), row.end(), expected.begin(), expected.end()), "cell ", i, ": another row ", by);
}

void check_centroid(std::size_t i, const std::array<double, 3>& centroid, std::span<const double> expected, double size,
                    double tolerance) {
    for (std::size_t a = 0; a < 3; ++a) {
        require(std::abs(centroid[a] - expected[3 * i + a]) <= tolerance * size, "cell ", i, ": centroid ", centroid[a],
                " instead of ", expected[3 * i + a], " on axis ", a);
    }
}

}  // namespace

Comparison compare(const votess::vulkan::Plan& plan, std::span<const float> seeds, const Results& results,
                   double tolerance) {
    Comparison comparison;
    const votess::vulkan::PlanOptions& options = plan.options();
    const std::size_t count = results.cells.size();
    try {
        check_header(options, results.header, results.cells);
        const votess::Tessellation expected = expected_cells(options, seeds);
        const votess::vulkan::Resolved resolved = plan.resolve(seeds, results.cells);
        require(resolved.cells.size() == results.header.unresolved, "resolve() made ", resolved.cells.size(),
                " cells instead of ", results.header.unresolved);
        std::size_t r = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Cell& cell = results.cells[i];
            // The security radius is twice the distance to the farthest vertex, so at least the cell's size.
            const double size = expected.security_radii()[i];
            if (unresolved(cell)) {
                require(cell.row_length == 0 && cell.faces == 0, "cell ", i, ": a row without certificate");
                require(resolved.cells[r] == i, "resolve() left out cell ", i);
                require(resolved.status[r] == expected.status()[i], "cell ", i, ": another status by resolve()");
                const auto begin = resolved.indices.begin() + resolved.indptr[r],
                           end = resolved.indices.begin() + resolved.indptr[r + 1];
                check_row(i, std::span(begin, end), expected.neighbors(i), "by resolve()");
                require(std::abs(resolved.volumes[r] - expected.volumes()[i]) <= cpu_tolerance * expected.volumes()[i],
                        "cell ", i, ": volume ", resolved.volumes[r], " by resolve()");
                if (expected.volumes()[i] > 0) {
                    check_centroid(
                        i, {resolved.centroids[3 * r], resolved.centroids[3 * r + 1], resolved.centroids[3 * r + 2]},
                        expected.centroids(), size, cpu_tolerance);
                }
                ++r;
                continue;
            }
            require(cell.status == static_cast<std::uint32_t>(expected.status()[i]), "cell ", i, ": status ",
                    cell.status, " instead of ", static_cast<int>(expected.status()[i]));
            require(cell.faces == expected.face_counts()[i], "cell ", i, ": ", cell.faces, " faces instead of ",
                    expected.face_counts()[i]);
            if (options.neighbors) {
                require(std::size_t{cell.row_begin} + cell.row_length <= results.indices.size(), "cell ", i,
                        ": its row is beyond the buffer");
                check_row(i, std::span(results.indices).subspan(cell.row_begin, cell.row_length), expected.neighbors(i),
                          "in the buffer");
            }
            if (!options.geometry) continue;
            const float* geometry = &results.geometry[4 * i];
            const double volume = expected.volumes()[i];
            if (volume == 0) {
                require(std::all_of(geometry, geometry + 4, [](float x) { return x == 0; }), "cell ", i,
                        ": geometry without a cell");
                continue;
            }
            const double error = std::abs(geometry[3] - volume) / volume;
            comparison.worst_volume = std::max(comparison.worst_volume, error);
            require(error <= tolerance, "cell ", i, ": volume ", geometry[3], " instead of ", volume);
            check_centroid(i,
                           {double{seeds[4 * i]} + geometry[0], double{seeds[4 * i + 1]} + geometry[1],
                            double{seeds[4 * i + 2]} + geometry[2]},
                           expected.centroids(), size, tolerance);
        }
        comparison.resolved = static_cast<std::uint32_t>(r);
    } catch (const Difference& difference) {
        comparison.difference = difference.text;
    }
    return comparison;
}

}  // namespace host
