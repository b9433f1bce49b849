#include "queries/interpolate.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "failure.hpp"
#include "files/atomic_file.hpp"
#include "files/formats/npy_array.hpp"
#include "files/numbers.hpp"
#include "interrupt.hpp"
#include "queries/asked.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

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

}  // namespace

void check_interpolated_outputs(const Arguments& arguments) {
    check_number_outputs(arguments.outputs, {arguments.input, arguments.interpolate}, "--interpolate",
                         "makes numbers for each query");
}

std::string run_interpolate(const Arguments& arguments) {
    StageTimes times;
    const Asked asked = read_and_sort(arguments, arguments.interpolate, request_of_queries(arguments), times);
    const Values values = values_of(asked.seeds, arguments.has_weights ? 1 : 0);
    std::vector<double> weights = sizes_of_queries(arguments, asked);
    for (double& weight : weights)
        if (arguments.has_radii) weight *= weight;
    votess::NaturalOptions options;
    options.method = arguments.natural;
    options.weights = weights;
    const std::vector<double> field =
        run_query(arguments, times, "interpolate", [&](const votess::ProgressCallback& callback) {
            options.progress = callback;
            return asked.diagram.interpolate(values.rows, values.components, asked.queries.points, options).values;
        });

    write_numbers(arguments.outputs, [&](OutputFile& file, const std::string& path) {
        write_field(file, path, field, values.components);
    });
    times.end("write");
    std::ptrdiff_t without = 0;
    for (std::size_t k = 0; k < field.size(); k += values.components) without += std::isnan(field[k]) ? 1 : 0;
    const QueryCount nowhere{"without", "without natural neighbors", without};
    return query_summary(arguments, "interpolated", asked, {&nowhere, 1}, times);
}

}  // namespace clvotess
