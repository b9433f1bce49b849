#include "queries/probe.hpp"

#include <algorithm>
#include <array>

#include "failure.hpp"
#include "interrupt.hpp"
#include "queries/asked.hpp"
#include "write/output.hpp"

namespace clvotess {

void check_probed_outputs(const Arguments& arguments) {
    if (arguments.outputs.empty()) throw bad_input("--probe makes a cell for each query: add -o FILE, or - for stdout");
    for (const std::string& path : arguments.outputs)
        if (!carries_columns(path))  // a mesh of all cells
            throw bad_input("--probe writes text, .npz, .h5 and .vtu, not " + in_quotes(path) +
                            ", for cells of queries do not fit together");
}

std::string run_probe(const Arguments& arguments) {
    StageTimes times;
    Asked asked = read_and_sort(arguments, arguments.probe, request_of_queries(arguments), times);
    votess::ProbeOptions options;
    options.want = arguments.wanted;
    options.list_walls = arguments.options.list_walls;
    const std::vector<double> sizes = sizes_of_queries(arguments, asked);
    (arguments.has_radii ? options.radii : options.weights) = sizes;
    const votess::Tessellation cells =
        run_query(arguments, times, "probe", [&](const votess::ProgressCallback& callback) {
            options.progress = callback;
            return asked.diagram.probe(asked.queries.points, options);
        });

    const InterruptGuard guard;
    asked.queries.units = std::move(asked.seeds.units);
    const std::vector<InputColumn> carried;
    write_outputs(arguments.outputs, {asked.queries, cells, arguments.wanted, arguments.format, options.radii,
                                      asked.domain_from, carried, arguments.coloring});
    times.end("write");
    const auto count = [&](votess::CellStatus status) { return std::ranges::count(cells.status(), status); };
    const std::array counts{
        QueryCount{"outside", "outside of the domain", count(votess::CellStatus::outside)},
        QueryCount{"duplicates", "at the place of a seed", count(votess::CellStatus::duplicate)},
        QueryCount{"empty", "without a cell among heavier seeds", count(votess::CellStatus::empty)},
    };
    return query_summary(arguments, "probed", asked, counts, times);
}

}  // namespace clvotess
