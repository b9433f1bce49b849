#include "queries/asked.hpp"

#include <algorithm>

#include "domain.hpp"
#include "files/numbers.hpp"

namespace clvotess {
namespace {

double seconds_between(std::chrono::steady_clock::time_point begin, std::chrono::steady_clock::time_point end) {
    return std::chrono::duration<double>(end - begin).count();
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

Asked read_and_sort(const Arguments& arguments, const std::string& queries, const ReadRequest& of_queries,
                    StageTimes& times) {
    Asked asked;
    asked.seeds = arguments.random_count ? random_points(*arguments.random_count, arguments.rng_seed)
                                         : read_input(arguments.input, arguments.read);
    asked.queries = read_input(queries, of_queries);
    votess::Options options = arguments.options;
    if (arguments.has_weights) {
        const InputColumn none{arguments.read.columns.at(0), 1, {}};  // of a file of no points
        const InputColumn& column = asked.seeds.columns.empty() ? none : asked.seeds.columns.front();
        (arguments.has_radii ? options.radii : options.weights) = one_each(column);
    }
    asked.domain_from = choose_domain(asked.seeds.domain, arguments.periodic, options);
    times.end("read");
    asked.diagram = votess::Diagram(asked.seeds.points, options);
    times.end("sort");
    return asked;
}

std::string query_summary(const Arguments& arguments, const std::string& done, const Asked& asked,
                          std::span<const QueryCount> counts, const StageTimes& times) {
    const std::string points = std::to_string(asked.diagram.size()), queries = std::to_string(asked.queries.size());
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
