// The public checker: global invariants, and sampled cells clipped anew by every seed.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "cpu/cell.hpp"
#include "options.hpp"
#include "result.hpp"

namespace votess {
namespace {

// Relative errors of the volume of one cell and of the sum of all.
struct VolumeTolerance {
    double cell, sum;
};
// Face areas: errors relative to the cell's surface are those of a cell's volume.
constexpr VolumeTolerance double_tolerance{1e-10, 1e-9}, single_tolerance{1e-5, 1e-4};

const VolumeTolerance& volume_tolerance(const Tessellation& t) {
    return t.stats().precision == Precision::single ? single_tolerance : double_tolerance;
}

std::string check_volumes(const Tessellation& t) {
    const Stats& s = t.stats();
    // Subnormal volumes are rounded to a multiple of the least double.
    const double rounding = static_cast<double>(t.size() + 1) * std::numeric_limits<double>::denorm_min();
    const double allowed = volume_tolerance(t).sum * s.box_volume + rounding;
    if (t.size() == 0 || s.volume_sum == s.box_volume || std::abs(s.volume_sum - s.box_volume) <= allowed) return {};
    return "volumes sum to " + number(s.volume_sum) + ", the box holds " + number(s.box_volume);
}

std::string check_symmetry(const Tessellation& t) {
    for (std::size_t i = 0; i < t.size(); ++i) {
        for (const std::int32_t j : t.neighbors(i)) {
            if (j < 0) continue;
            const auto row = t.neighbors(static_cast<std::size_t>(j));
            if (!std::binary_search(row.begin(), row.end(), static_cast<std::int32_t>(i)))
                return "seed " + std::to_string(i) + " lists " + std::to_string(j) + ", which does not list it";
        }
    }
    return {};
}

std::string check_euler(const Tessellation& t) {
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (t.status()[i] == CellStatus::duplicate || t.status()[i] == CellStatus::empty) continue;
        const std::int64_t v = t.vertex_counts()[i], e = t.edge_counts()[i], f = t.face_counts()[i];
        if (v - e + f != 2)
            return "cell " + std::to_string(i) + " has " + std::to_string(v) + " vertices, " + std::to_string(e) +
                   " edges and " + std::to_string(f) + " faces, against Euler's formula";
    }
    return {};
}

// splitmix64 (Steele, Lea, Flood 2014): portable, so that a sample is the same everywhere.
struct Random {
    std::uint64_t state;
    std::uint64_t next() {
        std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
};

std::string check_cell(const Tessellation& t, const Job& job, std::size_t i, cpu::Cell& cell, cpu::CellFaces& faces) {
    auto seed = [&](std::size_t j) {
        return exact::Point{job.points[3 * j] * job.scale, job.points[3 * j + 1] * job.scale,
                            job.points[3 * j + 2] * job.scale};
    };
    const exact::Point p = seed(i);
    std::vector<std::pair<double, std::int32_t>> others;
    others.reserve(t.size());
    for (std::size_t j = 0; j < t.size(); ++j) {
        if (j == i || t.status()[j] == CellStatus::duplicate) continue;
        const exact::Point q = seed(j);
        others.emplace_back(
            (q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]) + (q[2] - p[2]) * (q[2] - p[2]),
            static_cast<std::int32_t>(j));
    }
    std::sort(others.begin(), others.end());  // for speed alone: every seed is tried
    cell.start(p, *job.domain);
    for (const auto& [distance, j] : others) cell.clip(j, seed(static_cast<std::size_t>(j)));
    cell.canonical_faces(faces);

    const double unscale = 1 / job.scale;
    std::vector<double> areas;
    const cpu::CellGeometry geometry = cell.measure(faces, &areas);
    if (!t.indptr().empty()) {
        std::vector<std::int32_t> row;
        std::vector<std::pair<std::int32_t, double>> row_areas;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const std::int32_t id = cell.planes()[faces.planes[f]].id;
            if (id < 0 && !t.lists_walls()) continue;
            row.push_back(id);
            row_areas.emplace_back(id, areas[f] * unscale * unscale);
        }
        std::sort(row.begin(), row.end());
        if (!std::ranges::equal(row, t.neighbors(i)))
            return "seed " + std::to_string(i) + " lists " + std::to_string(t.neighbors(i).size()) +
                   " neighbors that differ from the " + std::to_string(row.size()) + " found by trying every seed";
        std::sort(row_areas.begin(), row_areas.end());
        const double surface = std::accumulate(areas.begin(), areas.end(), 0.0) * unscale * unscale;
        const double allowed = (volume_tolerance(t).cell + double_tolerance.cell) * surface;
        for (std::size_t k = 0; k < row.size() && !t.face_areas().empty(); ++k) {
            const double area = row_areas[k].second;
            const double given = t.face_areas()[static_cast<std::size_t>(t.indptr()[i]) + k];
            if (area != given && !(std::abs(area - given) <= allowed + std::numeric_limits<double>::denorm_min()))
                return "the face of cell " + std::to_string(i) + " with " + std::to_string(row[k]) + " has area " +
                       number(given) + ", trying every seed gives " + number(area);
        }
    }
    if (!t.volumes().empty()) {
        const double volume = geometry.volume * unscale * unscale * unscale;
        const double allowed = (volume_tolerance(t).cell + double_tolerance.cell) * volume;  // both are rounded
        if (volume != t.volumes()[i] &&                                                      // both may be infinite
            !(std::abs(volume - t.volumes()[i]) <= allowed + std::numeric_limits<double>::denorm_min()))
            return "cell " + std::to_string(i) + " has volume " + number(t.volumes()[i]) +
                   ", trying every seed gives " + number(volume);
    }
    return {};
}

std::string check_sample(const Tessellation& t, std::span<const double> points, const VerifyOptions& options) {
    Options as_before;
    as_before.box = t.box();
    const Job job = validate({points, {}}, as_before);
    std::vector<std::size_t> cells;
    for (std::size_t i = 0; i < t.size(); ++i)
        if (t.status()[i] == CellStatus::certified) cells.push_back(i);
    Random random{options.rng_seed};
    const std::size_t count = std::min(options.sample, cells.size());
    cpu::Cell cell;
    cpu::CellFaces faces;
    for (std::size_t s = 0; s < count; ++s) {
        std::swap(cells[s], cells[s + random.next() % (cells.size() - s)]);
        if (auto failure = check_cell(t, job, cells[s], cell, faces); !failure.empty()) return failure;
    }
    return {};
}

}  // namespace

VerifyReport verify(const Tessellation& t, std::span<const double> points, const VerifyOptions& options) {
    if (points.size() != 3 * t.size())
        throw Error(ErrorCode::invalid_argument, "verify: points hold " + std::to_string(points.size()) +
                                                     " coordinates, the result has " + std::to_string(t.size()) +
                                                     " cells");
    VerifyReport report;
    auto check = [&](const char* name, bool possible, auto run) {
        if (!possible)
            report.skipped.emplace_back(name);
        else if (report.failure.empty())
            report.failure = run();
    };
    const bool any = t.size() > 0;
    check("volumes", !any || !t.volumes().empty(), [&] { return check_volumes(t); });
    check("symmetry", !any || !t.indptr().empty(), [&] { return check_symmetry(t); });
    check("euler", !any || !t.face_counts().empty(), [&] { return check_euler(t); });
    check("sample", !any || !t.indptr().empty() || !t.volumes().empty(),
          [&] { return any ? check_sample(t, points, options) : std::string(); });
    report.passed = report.failure.empty();
    return report;
}

}  // namespace votess
