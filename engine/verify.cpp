// The public checker: global invariants, and sampled cells clipped anew by every seed.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "cpu/cell.hpp"
#include "options.hpp"
#include "result.hpp"
#include "rows.hpp"
#include "verify_mesh.hpp"

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
    // With no seed inside, no cell fills the domain.
    const bool none = std::ranges::none_of(t.status(), [](CellStatus c) { return c == CellStatus::certified; });
    const double expected = none ? 0 : s.box_volume;
    if (s.volume_sum == expected || std::abs(s.volume_sum - expected) <= allowed) return {};
    return "volumes sum to " + number(s.volume_sum) + ", the box holds " + number(s.box_volume);
}

Rows rows_of(const Tessellation& t) {
    return {t.indptr(), t.indices(), t.shifts()};
}

std::string check_symmetry(const Tessellation& t) {
    const Rows rows = rows_of(t);
    for (std::size_t i = 0; i < t.size(); ++i)
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
            const FaceLabel label = rows.label(entry);
            if (label.id < 0) continue;
            const auto j = static_cast<std::size_t>(label.id);
            if (rows.find(j, label.seen_from_behind(i)) == rows.end(j))
                return "seed " + std::to_string(i) + " lists " + std::to_string(j) + ", which does not list it";
        }
    return {};
}

std::string check_euler(const Tessellation& t) {
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (t.status()[i] != CellStatus::certified) continue;
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

exact::Point scaled_seed(const Job& job, std::size_t j) {
    return {job.points[3 * j] * job.scale, job.points[3 * j + 1] * job.scale, job.points[3 * j + 2] * job.scale};
}

bool takes_part(const Tessellation& t, std::size_t j) {
    return t.status()[j] != CellStatus::duplicate && t.status()[j] != CellStatus::outside;
}

struct Wrapped {
    exact::Shift shift;
    exact::Point at;  // rounded
};
Wrapped wrapped_seed(const Job& job, std::size_t j) {
    const exact::Point p = scaled_seed(job, j);
    if (!job.domain->is_periodic()) return {{}, p};
    const exact::Shift shift = wrap(*job.domain, p).value_or(exact::Shift{});
    const auto at = exact::differences({}, exact::Plane::bisector(p, shift, job.domain->lattice)).x;
    return {shift, {at[0].high, at[1].high, at[2].high}};
}

// Images of one seed by a range of shifts.
struct Images {
    double distance_squared;  // of the nearest, or less
    std::int32_t id;
    ShiftRange shifts;
};

bool farther(const Images& a, const Images& b) {
    return a.distance_squared > b.distance_squared;
}

// By every seed, and in a periodic domain by every image that can reach what is left of the cell: ranges of shifts are
// halved until they hold one. Nearest first, for speed alone.
void clip_by_all(const Tessellation& t, const Job& job, std::size_t i, cpu::Cell& cell) {
    const Domain& domain = *job.domain;
    const Wrapped own = wrapped_seed(job, i);
    const double more = domain.has_weights() ? domain.most_more(domain.weights[i]) : 0;
    double largest = 0;
    for (int k = 0; k < 3; ++k)
        largest = std::max({largest, std::abs(domain.box.lower[k]), std::abs(domain.box.upper[k])});
    const double rounding = domain.is_periodic() ? 16 * 0x1p-53 * largest : 0;
    cell.start(scaled_seed(job, i), domain, static_cast<std::int32_t>(i));
    // R + sqrt(R^2 + w - w_i) for the largest weight w.
    const double square = cell.radius_squared() * (1 + 1e-9);
    const double distance = (std::sqrt(square) + std::sqrt(square + more)) * (1 + 1e-9) + rounding;

    std::vector<Images> images;
    const auto bounds_of = [&](const exact::Point& q, const ShiftRange& shifts) {
        return domain.is_periodic() ? images_of(domain, {q, q}, shifts) : Box{q, q};
    };
    const auto add = [&](std::int32_t id, const exact::Point& q, const ShiftRange& shifts) {
        const Box bounds = bounds_of(q, shifts);
        double square_there = 0;
        for (int k = 0; k < 3; ++k) {
            const double gap = std::max({0.0, bounds.lower[k] - own.at[k], own.at[k] - bounds.upper[k]});
            square_there += gap * gap;
        }
        images.push_back({square_there, id, shifts});
        std::ranges::push_heap(images, farther);
    };
    for (std::size_t j = 0; j < t.size(); ++j) {
        if (!takes_part(t, j) || (j == i && !domain.is_periodic())) continue;
        const exact::Point q = wrapped_seed(job, j).at;
        add(static_cast<std::int32_t>(j), q,
            domain.is_periodic() ? shifts_around(domain, {q, q}, own.at, distance) : ShiftRange{});
    }
    while (!images.empty()) {
        std::ranges::pop_heap(images, farther);
        Images next = images.back();
        images.pop_back();
        const auto j = static_cast<std::size_t>(next.id);
        const Wrapped theirs = wrapped_seed(job, j);
        const Box bounds = bounds_of(theirs.at, next.shifts);
        cpu::BoundingBox box;
        for (int k = 0; k < 3; ++k) box.lower[k] = bounds.lower[k], box.upper[k] = bounds.upper[k];
        if (!cell.in_reach(box, own.at, rounding, more)) continue;
        ShiftRange& range = next.shifts;
        if (!range.is_single()) {
            const auto axis = static_cast<std::size_t>(longest_extent(domain, range).axis);
            const std::int32_t most = range.most[axis];
            range.most[axis] = range.least[axis] + (most - range.least[axis]) / 2;
            add(next.id, theirs.at, range);
            range.least[axis] = range.most[axis] + 1;
            range.most[axis] = most;
            add(next.id, theirs.at, range);
            continue;
        }
        const exact::Shift shift = domain.is_periodic() ? only_shift(domain, range) : exact::Shift{};
        if ((j == i && shift == exact::Shift{}) || cell.knows(next.id, shift)) continue;
        exact::Shift total;
        for (std::size_t k = 0; k < 3; ++k) total[k] = shift[k] + theirs.shift[k] - own.shift[k];
        exact::Plane plane = exact::Plane::bisector(scaled_seed(job, j), total, domain.lattice);
        if (domain.has_weights()) plane.power = exact::two_sum(domain.weights[i], -domain.weights[j]);
        cell.clip(next.id, plane, shift);
    }
}

struct RowFace {
    FaceLabel label;
    double area;
};

// Faces whose area is that of the threshold may have stayed or gone.
std::string check_row(const Tessellation& t, std::size_t i, std::vector<RowFace>& found, double allowed) {
    const Rows rows = rows_of(t);
    const auto given = t.neighbors(i).size();
    std::ranges::sort(found, {}, &RowFace::label);
    std::size_t matched = 0;
    for (const RowFace& face : found) {
        const std::size_t entry = rows.find(i, face.label);
        const std::int32_t id = face.label.id;
        if (entry == rows.end(i)) {
            if (id >= 0 && t.least_face() > 0 && face.area < t.least_face() + allowed) continue;
            return "seed " + std::to_string(i) + " lists " + std::to_string(given) + " neighbors, without " +
                   std::to_string(id) + ", which is one of the " + std::to_string(found.size()) +
                   " found by trying every seed";
        }
        ++matched;
        if (t.face_areas().empty()) continue;
        const double area = t.face_areas()[entry];
        if (area != face.area && !(std::abs(area - face.area) <= allowed + std::numeric_limits<double>::denorm_min()))
            return "the face of cell " + std::to_string(i) + " with " + std::to_string(id) + " has area " +
                   number(area) + ", trying every seed gives " + number(face.area);
    }
    if (matched == given) return {};
    return "seed " + std::to_string(i) + " lists " + std::to_string(given) + " neighbors that differ from the " +
           std::to_string(found.size()) + " found by trying every seed";
}

std::string check_cell(const Tessellation& t, const Job& job, std::size_t i, cpu::Cell& cell, cpu::CellFaces& faces) {
    clip_by_all(t, job, i, cell);
    cell.canonical_faces(faces);

    const double unscale = 1 / job.scale;
    std::vector<double> areas;
    const cpu::CellGeometry geometry = cell.measure(faces, &areas);
    if (!t.indptr().empty()) {
        std::vector<RowFace> row;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const cpu::CellPlane& plane = cell.planes()[faces.planes[f]];
            if (plane.id < 0 && !t.lists_walls()) continue;
            RowFace face{{plane.id, {}}, areas[f] * unscale * unscale};
            for (std::size_t k = 0; k < 3; ++k) face.label.shift[k] = static_cast<std::int8_t>(plane.shift[k]);
            row.push_back(face);
        }
        const double surface = std::accumulate(areas.begin(), areas.end(), 0.0) * unscale * unscale;
        const double allowed = (volume_tolerance(t).cell + double_tolerance.cell) * surface;
        if (auto failure = check_row(t, i, row, allowed); !failure.empty()) return failure;
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
    if (t.cell())
        as_before.cell = t.cell();
    else
        as_before.box = t.box(), as_before.periodic = t.periodic();
    as_before.planes.assign(t.planes().begin(), t.planes().end());
    as_before.outside = Outside::drop;
    as_before.weights = t.weights();
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
    check("euler", !any || (!t.face_counts().empty() && t.least_face() == 0), [&] { return check_euler(t); });
    if (report.failure.empty() && has_mesh(*t.result_))
        report.failure = check_mesh(*t.result_, volume_tolerance(t).sum);
    check("sample", !any || !t.indptr().empty() || !t.volumes().empty(),
          [&] { return any ? check_sample(t, points, options) : std::string(); });
    report.passed = report.failure.empty();
    return report;
}

}  // namespace votess
