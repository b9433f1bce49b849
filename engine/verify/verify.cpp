// The public checker: what holds for all cells, and the sampled ones of verify_sample.cpp.
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "input/domain_of_result.hpp"
#include "input/options.hpp"
#include "result/result.hpp"
#include "result/rows.hpp"
#include "verify/verify_mesh.hpp"
#include "verify/verify_sample.hpp"

namespace votess {
namespace {

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

// Rows ascend, so that none lists a face twice, and each entry is answered by one of the cell behind the face.
std::string check_symmetry(const Tessellation& t) {
    const Rows rows{t.indptr(), t.indices(), t.shifts()};
    for (std::size_t i = 0; i < t.size(); ++i)
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
            const FaceLabel label = rows.label(entry);
            if (entry > rows.begin(i) && !(rows.label(entry - 1) < label))
                return "the row of seed " + std::to_string(i) + " does not ascend at " + std::to_string(label.id);
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

}  // namespace

VerifyReport verify(const Tessellation& t, std::span<const double> points, const VerifyOptions& options) {
    require_whole_diagram(t, "verify");
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
          [&] { return any ? check_sample(t, points, options, report.sampled) : std::string(); });
    report.passed = report.failure.empty();
    return report;
}

}  // namespace votess
