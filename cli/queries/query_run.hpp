// What --locate, --probe, --interpolate and --to-grid share: files of points, the seeds sorted, and what the run tells
// at its end.
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

// Wall-clock seconds of the stages of a run, in their order.
class StageTimes {
public:
    // Ends the stage of that name, which began where the one before has ended.
    void end(const char* stage);
    [[nodiscard]] std::string json() const;  // an object: the total, then the stages
    [[nodiscard]] Progress::Clock::time_point began() const { return began_; }

private:
    using Clock = Progress::Clock;
    Clock::time_point began_ = Clock::now(), last_ = began_;
    std::vector<std::pair<const char*, double>> stages_;
};

struct Asked {
    Input seeds, queries;
    DomainFrom domain_from;
    votess::Diagram diagram;
};

// Ends the stages read and sort. queries: their file, or none; of_queries: what to take out of it.
[[nodiscard]] Asked read_and_sort(const Arguments& arguments, const std::string& queries, const ReadRequest& of_queries,
                                  StageTimes& times);

// Returns query(callback), which shows a bar and which Ctrl-C stops. Ends the stage of that name.
template <class Query>
[[nodiscard]] auto run_query(const Arguments& arguments, StageTimes& times, const char* stage, const Query& query) {
    Progress progress(!arguments.quiet, times.began());
    auto result = run_stoppable(progress, query);
    times.end(stage);
    return result;
}

// Columns of the seeds side by side, a row for each.
struct Values {
    std::vector<double> rows;
    std::size_t components = 0;
};
[[nodiscard]] Values values_of(const Input& seeds, std::size_t first_column);

// What to take out of the file of the queries: their weights or radii, if the seeds have them.
[[nodiscard]] ReadRequest request_of_queries(const Arguments& arguments);
// These, 0 where their file lacks that column; none where the seeds have none.
[[nodiscard]] std::vector<double> sizes_of_queries(const Arguments& arguments, const Asked& asked);

// Outputs that hold nothing but numbers.
[[nodiscard]] bool is_npy_output(const std::string& path);
// Throws Failure: some output, .npy or text each. option, does: for messages.
void check_number_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs,
                          const std::string& option, const std::string& does);
// All of them, or none.
void write_numbers(const std::vector<std::string>& outputs,
                   const std::function<void(OutputFile&, const std::string& path)>& write);

// Queries of one kind.
struct QueryCount {
    const char* name;  // in JSON
    const char* text;  // for people
    std::ptrdiff_t number;
};

// The summary or its JSON object; empty with --quiet, and where rows have stdout to themselves. done: "located".
[[nodiscard]] std::string query_summary(const Arguments& arguments, const std::string& done, const Asked& asked,
                                        std::span<const QueryCount> counts, const StageTimes& times);

}  // namespace clvotess
