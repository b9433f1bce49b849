#include "queries/locate.hpp"

#include <algorithm>
#include <deque>

#include "failure.hpp"
#include "files/atomic_file.hpp"
#include "files/formats/npy_array.hpp"
#include "interrupt.hpp"
#include "queries/asked.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

bool is_npy(const std::string& path) {
    return path != "-" && extension_of(path) == ".npy";
}

void write_located(OutputFile& file, const std::string& path, const std::vector<std::int32_t>& seeds) {
    if (is_npy(path)) {
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
    if (arguments.outputs.empty())
        throw bad_input("--locate finds a seed for each query: add -o FILE.npy, FILE.txt or - for stdout");
    for (const std::string& path : arguments.outputs) {
        const bool text = path == "-" || extension_of(path) == ".txt" || is_special_file(path);
        if (!text && !is_npy(path)) throw bad_input("--locate writes .npy and .txt, not " + in_quotes(path));
    }
    check_paths(arguments.outputs, {arguments.input, arguments.locate});
}

std::string run_locate(const Arguments& arguments) {
    StageTimes times;
    const Asked asked = read_and_sort(arguments, arguments.locate, {}, times);
    const std::vector<std::int32_t> seeds = asked.diagram.locate(asked.queries.points);
    times.end("locate");

    const InterruptGuard guard;
    std::deque<OutputFile> files;
    for (const std::string& path : arguments.outputs) {
        write_located(files.emplace_back(path), path, seeds);
        files.back().finish();
    }
    throw_if_interrupted();
    for (OutputFile& file : files) file.publish();
    times.end("write");
    const QueryCount outside{"outside", "outside of the domain", std::ranges::count(seeds, -1)};
    return query_summary(arguments, "located", asked, {&outside, 1}, times);
}

}  // namespace clvotess
