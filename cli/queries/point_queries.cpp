#include "queries/point_queries.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "failure.hpp"
#include "files/formats/npy_array.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "queries/query_run.hpp"
#include "write/output.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

void write_located(OutputFile& file, const std::string& path, const std::vector<std::int32_t>& seeds) {
    if (is_npy_output(path)) {
        std::string shape = "(";
        shape += std::to_string(seeds.size());
        file.write(npy_header("<i4", shape + ",)"));
        file.write({reinterpret_cast<const char*>(seeds.data()), seeds.size() * sizeof(std::int32_t)});
        return;
    }
    std::string text;
    for (const std::int32_t seed : seeds) text += std::to_string(seed) + '\n';
    file.write(text);
}

void write_field(OutputFile& file, const std::string& path, const std::vector<double>& field, std::size_t components) {
    if (is_npy_output(path)) {
        std::string shape = "(";
        shape += std::to_string(field.size() / components);
        shape += ", ";
        if (components > 1) shape += std::to_string(components);
        file.write(npy_header("<f8", shape + ")"));
        file.write({reinterpret_cast<const char*>(field.data()), field.size() * sizeof(double)});
        return;
    }
    std::string text;
    for (std::size_t k = 0; k < field.size(); ++k) text += to_text(field[k]) + ((k + 1) % components == 0 ? '\n' : ' ');
    file.write(text);
}

bool is_npz_output(const std::string& path) {
    return path != "-" && extension_of(path) == ".npz";
}

void write_traced(OutputFile& file, const std::string& path, const votess::RayCells& cells) {
    if (is_npz_output(path)) {
        write_npz_arrays(
            file, std::array{as_array("offsets", std::span(cells.offsets)), as_array("seeds", std::span(cells.seeds)),
                             as_array("lengths", std::span(cells.lengths))});
        return;
    }
    std::string text;
    for (std::size_t r = 0; r + 1 < cells.offsets.size(); ++r) {
        const auto begin = static_cast<std::size_t>(cells.offsets[r]);
        for (std::size_t k = begin; k < static_cast<std::size_t>(cells.offsets[r + 1]); ++k) {
            if (k > begin) text += ' ';
            text += std::to_string(cells.seeds[k]);
            text += ' ';
            text += to_text(cells.lengths[k]);
        }
        text += '\n';
    }
    file.write(text);
}

}  // namespace

void check_located_outputs(const Arguments& arguments) {
    check_number_outputs(arguments.outputs, {arguments.input, arguments.locate}, "--locate",
                         "finds a seed for each query");
}

std::string run_locate(const Arguments& arguments) {
    StageTimes times;
    const auto request = [](std::size_t) { return ReadRequest(); };
    const QueryInput input = read_and_sort(arguments, arguments.locate, request, times);
    const std::vector<std::int32_t> seeds = run_query(
        arguments, times, "locate",
        [&](const votess::ProgressCallback& callback) { return input.diagram.locate(input.queries.points, callback); });

    write_numbers(arguments.outputs,
                  [&](OutputFile& file, const std::string& path) { write_located(file, path, seeds); });
    times.end("write");
    const QueryCount outside{"outside", "outside of the domain", std::ranges::count(seeds, -1)};
    return query_summary(arguments, "located", input, {&outside, 1}, times);
}

void check_probed_outputs(const Arguments& arguments) {
    if (arguments.outputs.empty()) throw bad_input("--probe needs an output: add -o FILE, or -o - for stdout");
    for (const std::string& path : arguments.outputs)
        if (!carries_columns(path))  // a mesh of all cells, which share vertices
            throw bad_input("--probe writes text, .npz, .h5 and .vtu, not " + in_quotes(path) +
                            ": the cells of queries overlap and form no mesh");
}

std::string run_probe(const Arguments& arguments) {
    StageTimes times;
    const auto request = [&](std::size_t) { return request_of_queries(arguments); };
    QueryInput input = read_and_sort(arguments, arguments.probe, request, times);
    for (const std::string& path : arguments.outputs)
        if (!input.has_ends && needs_box(path))
            throw bad_input(
                "output " + in_quotes(path) +
                " needs a box with ends, and without a box cells of queries may reach infinity: give --box, "
                "or write .npz, .h5 or text");
    votess::ProbeOptions options;
    options.want = arguments.wanted;
    options.list_walls = arguments.options.list_walls;
    const std::vector<double> sizes = sizes_of_queries(arguments, input);
    (arguments.has_radii ? options.radii : options.weights) = sizes;
    const votess::Tessellation cells =
        run_query(arguments, times, "probe", [&](const votess::ProgressCallback& callback) {
            options.progress = callback;
            return input.diagram.probe(input.queries.points, options);
        });

    const InterruptGuard guard;
    input.queries.units = std::move(input.seeds.units);
    const std::vector<InputColumn> carried;
    write_outputs(arguments.outputs, {input.queries, cells, arguments.wanted, arguments.format, options.radii,
                                      input.domain_from, carried, arguments.coloring});
    times.end("write");
    const auto count = [&](votess::CellStatus status) { return std::ranges::count(cells.status(), status); };
    const std::array counts{
        QueryCount{"outside", "outside of the domain", count(votess::CellStatus::outside)},
        QueryCount{"duplicates", "at the place of a seed", count(votess::CellStatus::duplicate)},
        QueryCount{"empty", "without a cell among heavier seeds", count(votess::CellStatus::empty)},
    };
    return query_summary(arguments, "probed", input, counts, times);
}

void check_interpolated_outputs(const Arguments& arguments) {
    check_number_outputs(arguments.outputs, {arguments.input, arguments.interpolate}, "--interpolate",
                         "computes numbers for each query");
}

std::string run_interpolate(const Arguments& arguments) {
    StageTimes times;
    const auto request = [&](std::size_t) { return request_of_queries(arguments); };
    const QueryInput input = read_and_sort(arguments, arguments.interpolate, request, times);
    const Values values = values_of(input.seeds, arguments.has_weights ? 1 : 0);
    std::vector<double> weights = sizes_of_queries(arguments, input);
    for (double& weight : weights)
        if (arguments.has_radii) weight *= weight;
    votess::NaturalOptions options;
    options.method = arguments.natural;
    options.weights = weights;
    const std::vector<double> field =
        run_query(arguments, times, "interpolate", [&](const votess::ProgressCallback& callback) {
            options.progress = callback;
            return input.diagram.interpolate(values.rows, values.components, input.queries.points, options).values;
        });

    write_numbers(arguments.outputs, [&](OutputFile& file, const std::string& path) {
        write_field(file, path, field, values.components);
    });
    times.end("write");
    std::ptrdiff_t without = 0;
    for (std::size_t k = 0; k < field.size(); k += values.components) without += std::isnan(field[k]) ? 1 : 0;
    const QueryCount nowhere{"without", "without natural neighbors", without};
    return query_summary(arguments, "interpolated", input, {&nowhere, 1}, times);
}

void check_traced_outputs(const Arguments& arguments) {
    const std::vector<std::string>& outputs = arguments.outputs;
    if (outputs.empty()) throw bad_input("--trace needs an output: add -o FILE.npz, FILE.txt or - for stdout");
    for (const std::string& path : outputs)
        if (!is_text_output(path) && !is_npz_output(path))
            throw bad_input("--trace writes .npz and .txt, not " + in_quotes(path));
    check_paths(outputs, {arguments.input, arguments.trace});
}

std::string run_trace(const Arguments& arguments) {
    StageTimes times;
    const auto request = [&](std::size_t dimensions) {
        ReadRequest rays;
        rays.threads = arguments.read.threads;
        for (std::size_t k = 1; k <= 2 * dimensions + 1; ++k)
            (k <= dimensions ? rays.coordinates : rays.columns).push_back(std::to_string(k));
        rays.npy_holds_columns = true;
        return rays;
    };
    const QueryInput input = read_and_sort(arguments, arguments.trace, request, times);
    const std::size_t dimensions = input.seeds.dimensions;
    std::vector<double> directions, lengths;
    for (std::size_t r = 0; r < input.queries.size(); ++r) {
        for (std::size_t k = 0; k < dimensions; ++k) directions.push_back(input.queries.columns[k].values[r]);
        lengths.push_back(input.queries.columns[dimensions].values[r]);
    }
    const votess::RayCells cells = run_query(arguments, times, "trace", [&](const votess::ProgressCallback& callback) {
        return input.diagram.trace(input.queries.points, directions, lengths, {.progress = callback});
    });

    write_numbers(arguments.outputs,
                  [&](OutputFile& file, const std::string& path) { write_traced(file, path, cells); });
    times.end("write");
    std::ptrdiff_t without = 0;
    for (std::size_t r = 0; r < input.queries.size(); ++r) without += cells.offsets[r] == cells.offsets[r + 1] ? 1 : 0;
    const QueryCount nowhere{"without", "without cells", without};
    return query_summary(arguments, "traced", input, {&nowhere, 1}, times);
}

}  // namespace clvotess
