// The public checker: what holds for all cells, and the sampled ones of verify_sample.cpp.
#include <algorithm>

#include "input/domain_of_result.hpp"
#include "input/options.hpp"
#include "result/result.hpp"
#include "result/rows.hpp"
#include "verify/invariants.hpp"
#include "verify/verify_mesh.hpp"
#include "verify/verify_sample.hpp"

namespace votess {
namespace {

std::string check_volumes(const Tessellation& t) {
    const bool certified = std::ranges::count(t.status(), CellStatus::certified) > 0;
    return check_volume_sum(t.stats(), certified, volume_tolerance(t).sum);
}

// Rows ascend, so that none lists a face twice, and each entry is answered by one of the cell behind the face.
std::string check_symmetry(const Tessellation& t) {
    const Rows rows{t.indptr(), t.indices(), t.shifts()};
    for (std::size_t i = 0; i < t.size(); ++i)
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
            const FaceLabel label = rows.label(entry);
            if (entry > rows.begin(i) && !(rows.label(entry - 1) < label))
                return not_ascending(static_cast<std::int64_t>(i), label.id);
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
        auto wrong = check_euler_formula(static_cast<std::int64_t>(i), t.vertex_counts()[i], t.edge_counts()[i],
                                         t.face_counts()[i]);
        if (!wrong.empty()) return wrong;
    }
    return {};
}

}  // namespace

std::uint64_t count_tiny_faces(const Tessellation& t, std::span<const double> points) {
    require_whole_diagram(t, "count_tiny_faces");
    if (t.stats().tiny_faces) return *t.stats().tiny_faces;
    if (points.size() != 3 * t.size())
        throw Error(ErrorCode::invalid_argument, "count_tiny_faces: points hold " + std::to_string(points.size()) +
                                                     " coordinates, the result has " + std::to_string(t.size()) +
                                                     " cells");
    Options options = domain_options(t);
    options.weights = t.weights();
    options.device = "cpu";
    options.want = {};
    options.want.neighbors = false;
    return tessellate(points, options).stats().tiny_faces.value();
}

VerifyReport verify(const Tessellation& t, std::span<const double> given, const VerifyOptions& options) {
    require_whole_diagram(t, "verify");
    if (given.size() != 3 * t.size())
        throw Error(ErrorCode::invalid_argument, "verify: points hold " + std::to_string(given.size()) +
                                                     " coordinates, the result has " + std::to_string(t.size()) +
                                                     " cells");
    const std::vector<double> points(given.begin(), given.end());  // read once, see input/snapshot.hpp
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
    report.tiny_faces = count_tiny_faces(t, points);
    return report;
}

}  // namespace votess
