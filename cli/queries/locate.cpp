#include "queries/locate.hpp"

#include <algorithm>

#include "files/atomic_file.hpp"
#include "files/formats/npy_array.hpp"
#include "queries/asked.hpp"

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

}  // namespace

void check_located_outputs(const Arguments& arguments) {
    check_number_outputs(arguments.outputs, {arguments.input, arguments.locate}, "--locate",
                         "finds a seed for each query");
}

std::string run_locate(const Arguments& arguments) {
    StageTimes times;
    const Asked asked = read_and_sort(arguments, arguments.locate, {}, times);
    const std::vector<std::int32_t> seeds = run_query(
        arguments, times, "locate",
        [&](const votess::ProgressCallback& callback) { return asked.diagram.locate(asked.queries.points, callback); });

    write_numbers(arguments.outputs,
                  [&](OutputFile& file, const std::string& path) { write_located(file, path, seeds); });
    times.end("write");
    const QueryCount outside{"outside", "outside of the domain", std::ranges::count(seeds, -1)};
    return query_summary(arguments, "located", asked, {&outside, 1}, times);
}

}  // namespace clvotess
