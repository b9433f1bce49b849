#include "verify/verify_sample.hpp"

#include <algorithm>

#include "input/domain_of_result.hpp"
#include "input/options.hpp"
#include "result/rows.hpp"
#include "verify/brute_force.hpp"
#include "verify/told_cell.hpp"

namespace votess {
namespace {

ToldCell told_cell(const Tessellation& t, std::size_t i) {
    ToldCell told{static_cast<std::int64_t>(i),
                  t.status()[i] == CellStatus::empty,
                  {},
                  t.lists_walls(),
                  !t.face_areas().empty(),
                  {},
                  t.least_face(),
                  volume_tolerance(t).cell};
    if (!t.volumes().empty()) told.volume = t.volumes()[i];
    if (t.indptr().empty()) return told;
    const Rows rows{t.indptr(), t.indices(), t.shifts()};
    told.row.emplace();
    for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
        const FaceLabel label = rows.label(entry);
        told.row->push_back({label.id, label.shift, told.has_areas ? t.face_areas()[entry] : 0});
    }
    return told;
}

}  // namespace

std::string check_sample(const Tessellation& t, std::span<const double> points, const VerifyOptions& options,
                         std::size_t& sampled) {
    Options as_before = domain_options(t);
    as_before.weights = t.weights();
    const Job job = validate({points, {}}, as_before);
    std::vector<std::size_t> cells;
    for (std::size_t i = 0; i < t.size(); ++i)
        if (takes_part(t.status()[i])) cells.push_back(i);
    SampleRandom random{options.rng_seed};
    BruteForce brute_force(job, t.status());
    cpu::Cell cell;
    cpu::CellFaces faces;
    const auto enough = [&] {
        return options.sample ? sampled >= *options.sample
                              : sampled >= min_sample && brute_force.work() >= sample_budget;
    };
    while (sampled < cells.size() && !enough()) {
        std::swap(cells[sampled], cells[sampled + random.next() % (cells.size() - sampled)]);
        const std::size_t i = cells[sampled++];
        brute_force.clip(i, cell);
        if (auto failure = difference(told_cell(t, i), job.scale, {}, cell, faces); !failure.empty()) return failure;
    }
    return {};
}

}  // namespace votess
