#include "queries/locate.hpp"

#include <algorithm>
#include <chrono>
#include <deque>
#include <votess/diagram.hpp>

#include "domain.hpp"
#include "failure.hpp"
#include "files/atomic_file.hpp"
#include "files/formats/npy_array.hpp"
#include "files/numbers.hpp"
#include "interrupt.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_between(Clock::time_point begin, Clock::time_point end) {
    return std::chrono::duration<double>(end - begin).count();
}

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
    const std::vector<std::string>& paths = arguments.outputs;
    if (paths.empty())
        throw bad_input("--locate finds a seed for each query: add -o FILE.npy, FILE.txt or - for stdout");
    std::vector<std::string> taken;
    for (const std::string& input : {arguments.input, arguments.locate})
        if (!input.empty() && input != "-") taken.push_back(identity_of(input));
    for (const std::string& path : paths) {
        const bool text = path == "-" || extension_of(path) == ".txt" || is_special_file(path);
        if (!text && !is_npy(path)) throw bad_input("--locate writes .npy and .txt, not " + in_quotes(path));
        if (path != "-" && !is_special_file(path)) check_writable(path);
        const std::string identity = path == "-" ? path : identity_of(path);
        if (std::ranges::count(taken, identity) > 0)
            throw bad_input("-o " + in_quotes(path) + " is read by this run, or written twice: give another name");
        taken.push_back(identity);
    }
}

std::string run_locate(const Arguments& arguments) {
    const auto began = Clock::now();
    const Input input = arguments.random_count ? random_points(*arguments.random_count, arguments.rng_seed)
                                               : read_input(arguments.input, arguments.read);
    const Input queries = read_input(arguments.locate);
    votess::Options options = arguments.options;
    if (arguments.has_weights) {
        const InputColumn none{arguments.read.columns.at(0), 1, {}};
        const InputColumn& column = input.columns.empty() ? none : input.columns.front();
        (arguments.has_radii ? options.radii : options.weights) = one_each(column);
    }
    choose_domain(input.domain, arguments.periodic, options);
    const auto read = Clock::now();
    const votess::Diagram diagram(input.points, options);
    const auto sorted = Clock::now();
    const std::vector<std::int32_t> seeds = diagram.locate(queries.points);
    const auto located = Clock::now();

    const InterruptGuard guard;
    std::deque<OutputFile> files;
    for (const std::string& path : arguments.outputs) {
        write_located(files.emplace_back(path), path, seeds);
        files.back().finish();
    }
    throw_if_interrupted();
    for (OutputFile& file : files) file.publish();

    const auto ended = Clock::now();
    const auto outside = std::ranges::count(seeds, -1);
    if (arguments.json) {
        return "{\"version\": \"" VOTESS_VERSION_STRING "\", \"points\": " + std::to_string(diagram.size()) +
               ", \"queries\": " + std::to_string(seeds.size()) + ", \"outside\": " + std::to_string(outside) +
               ", \"seconds\": {\"total\": " + to_text(seconds_between(began, ended)) +
               ", \"read\": " + to_text(seconds_between(began, read)) +
               ", \"sort\": " + to_text(seconds_between(read, sorted)) +
               ", \"locate\": " + to_text(seconds_between(sorted, located)) +
               ", \"write\": " + to_text(seconds_between(located, ended)) + "}}\n";
    }
    if (arguments.quiet) return "";
    // With -o - the numbers have stdout to themselves.
    if (std::ranges::count(arguments.outputs, "-") > 0) return "";
    std::string text = "located " + std::to_string(seeds.size());
    text += " queries among " + std::to_string(diagram.size()) + " seeds";
    if (outside > 0) text += ", " + std::to_string(outside) + " of them outside of the domain";
    return text + '\n';
}

}  // namespace clvotess
