#include "queries/query_run.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "domain.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "interrupt.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

double seconds_between(std::chrono::steady_clock::time_point begin, std::chrono::steady_clock::time_point end) {
    return std::chrono::duration<double>(end - begin).count();
}

Input read_queries(const Arguments& arguments, const std::string& queries, ReadRequest request,
                   std::size_t dimensions) {
    // Points of the plane may be known by their two coordinates, and queries too.
    if (dimensions == 2) request.dimensions = arguments.read.dimensions;
    Input input = read_input(queries, request);
    if (input.size() == 0) input.dimensions = dimensions;
    if (input.dimensions != dimensions)
        throw bad_input(queries + ": these have three coordinates, but the points of " + arguments.input +
                        " two: add --2d if their z does not matter");
    return input;
}

}  // namespace

void StageTimes::end(const char* stage) {
    const auto now = Clock::now();
    stages_.emplace_back(stage, seconds_between(last_, now));
    last_ = now;
}

std::string StageTimes::json() const {
    std::string text = "{\"total\": " + to_text(seconds_between(began_, last_));
    for (const auto& [stage, seconds] : stages_) text += std::string(", \"") + stage + "\": " + to_text(seconds);
    return text + "}";
}

QueryInput read_and_sort(const Arguments& arguments, const std::string& queries,
                         const std::function<ReadRequest(std::size_t dimensions)>& request_for, StageTimes& times) {
    QueryInput input;
    input.seeds = arguments.random_count ? random_points(*arguments.random_count, arguments.rng_seed, arguments.read)
                                         : read_input(arguments.input, arguments.read);
    const std::size_t dimensions = input.seeds.dimensions;
    if (!queries.empty()) input.queries = read_queries(arguments, queries, request_for(dimensions), dimensions);
    votess::Options options = arguments.options;
    choose_dimensions(input.seeds, options);
    if (arguments.has_weights) {
        const InputColumn none{arguments.read.columns.at(0), 1, {}};  // for a file of no points
        const InputColumn& column = input.seeds.columns.empty() ? none : input.seeds.columns.front();
        (arguments.has_radii ? options.radii : options.weights) = one_each(column);
    }
    input.domain_from = choose_domain(input.seeds.domain, arguments.periodic, options, arguments.hull);
    check_corner(input.seeds, options, input.domain_from);
    // As votess::Diagram takes it. Its box has all of its ends or none.
    input.has_ends = arguments.hull || options.mesh || !options.walls.empty() || options.cell ||
                     (options.box && !std::isinf(options.box->upper[0]));
    times.end("read");
    input.diagram = run_query(arguments, times, "sort", [&](const votess::ProgressCallback& callback) {
        options.progress = callback;
        if (arguments.hull) set_hull(input.seeds.points, options);
        return votess::Diagram(input.seeds.points, options);
    });
    return input;
}

Values values_of(const Input& seeds, std::size_t first_column) {
    Values values;
    const auto columns = std::span(seeds.columns).subspan(std::min(first_column, seeds.columns.size()));
    for (const InputColumn& column : columns) values.components += column.width;
    for (std::size_t i = 0; i < seeds.size(); ++i)
        for (const InputColumn& column : columns)
            for (std::size_t k = 0; k < column.width; ++k) values.rows.push_back(column.values[column.width * i + k]);
    values.components = std::max<std::size_t>(values.components, 1);  // for a file of no points
    return values;
}

ReadRequest request_of_queries(const Arguments& arguments) {
    ReadRequest request;
    request.threads = arguments.read.threads;
    if (!arguments.has_weights) return request;
    request.columns = {arguments.read.columns.at(0)};
    request.columns_may_lack = true;
    return request;
}

std::vector<double> sizes_of_queries(const Arguments& arguments, const QueryInput& input) {
    if (!arguments.has_weights || input.diagram.size() == 0) return {};
    if (input.queries.columns.empty()) return std::vector<double>(input.queries.size());
    const auto column = one_each(input.queries.columns.front());
    return {column.begin(), column.end()};
}

bool is_npy_output(const std::string& path) {
    return path != "-" && extension_of(path) == ".npy";
}

void check_number_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                          const std::string& option, const std::string& does) {
    if (outputs.empty()) throw bad_input(option + " " + does + ": add -o FILE.npy, FILE.txt or - for stdout");
    for (const std::string& path : outputs) {
        const bool text = path == "-" || extension_of(path) == ".txt" || is_special_file(path);
        if (!text && !is_npy_output(path)) throw bad_input(option + " writes .npy and .txt, not " + in_quotes(path));
    }
    check_paths(outputs, inputs);
}

void write_numbers(const std::vector<std::string>& outputs,
                   const std::function<void(OutputFile&, const std::string& path)>& write) {
    const InterruptGuard guard;
    std::deque<OutputFile> files;
    for (const std::string& path : outputs) {
        write(files.emplace_back(path), path);
        files.back().finish();
    }
    throw_if_interrupted();
    for (OutputFile& file : files) file.publish();
}

std::string query_summary(const Arguments& arguments, const std::string& done, const QueryInput& input,
                          std::span<const QueryCount> counts, const StageTimes& times) {
    const std::string points = std::to_string(input.diagram.size()), queries = std::to_string(input.queries.size());
    if (arguments.json) {
        std::string text = "{\"version\": \"" VOTESS_VERSION_STRING "\", \"points\": " + points;
        text += ", \"queries\": " + queries;
        for (const auto& [name, _, number] : counts)
            text += std::string(", \"") + name + "\": " + std::to_string(number);
        return text + ", \"seconds\": " + times.json() + "}\n";
    }
    if (arguments.quiet || std::ranges::count(arguments.outputs, "-") > 0) return "";
    std::string text = done + " " + queries + " queries among " + points + " seeds";
    for (const auto& [_, words, number] : counts)
        if (number > 0) text += ", " + std::to_string(number) + " " + words;
    return text + '\n';
}

}  // namespace clvotess
