// Steps that --locate, --probe, --interpolate, --trace and --to-grid share: reading, the diagram, outputs, the summary.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>
#include <votess/diagram.hpp>

#include "arguments/arguments.hpp"
#include "domain.hpp"
#include "files/output_file.hpp"
#include "progress.hpp"
#include "read/input.hpp"

namespace clvotess {

// Wall-clock seconds of the stages of a run, in order.
class StageTimes {
public:
    // Ends a stage, which began when the previous one ended.
    void end(const char* stage);
    [[nodiscard]] std::string json() const;  // an object: the total, then each stage
    [[nodiscard]] Progress::Clock::time_point began() const { return began_; }

private:
    using Clock = Progress::Clock;
    Clock::time_point began_ = Clock::now(), last_ = began_;
    std::vector<std::pair<const char*, double>> stages_;
};

struct QueryInput {
    Input seeds, queries;
    DomainFrom domain_from;
    bool has_ends = true;  // false: all of space
    votess::Diagram diagram;
};

// Reads seeds and queries, and builds the diagram. Ends the stages read and sort. queries: a file, or empty;
// request_for(dimensions): what to read from it. Throws Failure for queries of other dimensions than the seeds.
[[nodiscard]] QueryInput read_and_sort(const Arguments& arguments, const std::string& queries,
                                       const std::function<ReadRequest(std::size_t dimensions)>& request_for,
                                       StageTimes& times);

// Returns query(callback) and ends the stage. The callback shows a bar and stops the query after Ctrl-C.
template <class Query>
[[nodiscard]] auto run_query(const Arguments& arguments, StageTimes& times, const char* stage, const Query& query) {
    Progress progress(!arguments.quiet, times.began());
    auto result = run_stoppable(progress, query);
    times.end(stage);
    return result;
}

// The columns of the seeds side by side, one row for each seed.
struct Values {
    std::vector<double> rows;
    std::size_t components = 0;
};
[[nodiscard]] Values values_of(const Input& seeds, std::size_t first_column);

// Returns what to read from the file of the queries: weights or radii, if the seeds have them.
[[nodiscard]] ReadRequest request_of_queries(const Arguments& arguments);
// Returns the weights or radii of the queries: 0 where their file lacks the column; empty where the seeds have none.
[[nodiscard]] std::vector<double> sizes_of_queries(const Arguments& arguments, const QueryInput& input);

// Returns whether the output is .npy.
[[nodiscard]] bool is_npy_output(const std::string& path);
// Throws Failure unless there are outputs, each .npy or text. option, does: for messages.
void check_number_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                          const std::string& option, const std::string& does);
// Writes all outputs, or none.
void write_numbers(const std::vector<std::string>& outputs,
                   const std::function<void(OutputFile&, const std::string& path)>& write);

// The number of queries of one kind.
struct QueryCount {
    const char* name;  // in JSON
    const char* text;  // for people
    std::ptrdiff_t number;
};

// Returns the summary or its JSON object; empty with --quiet, and when rows go to stdout. done: such as "located".
[[nodiscard]] std::string query_summary(const Arguments& arguments, const std::string& done, const QueryInput& input,
                                        std::span<const QueryCount> counts, const StageTimes& times);

}  // namespace clvotess
