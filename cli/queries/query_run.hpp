// Queries: places asked among the points, such as --locate. Reading, the diagram, outputs and the summary are common.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>
#include <votess/diagram.hpp>

#include "arguments/arguments.hpp"
#include "progress.hpp"
#include "read/input.hpp"
#include "run/settle.hpp"
#include "write/output.hpp"

namespace clvotess {

// The points of a frame, and the queries.
struct QueryInput {
    Settled seeds;
    const Input& queries;
    votess::Diagram diagram;
};

// The number of queries of one kind.
struct QueryCount {
    const char* name;  // in JSON
    const char* text;  // for people
    std::ptrdiff_t number = 0;
};

// A query of the command line. Counts are sums over the frames of a run.
class Query {
public:
    // stage: that answers. done: the word for it in the summary.
    Query(const Arguments& given, const char* stage_name, const char* done_word)
        : stage(stage_name), done(done_word), arguments_(given) {}
    virtual ~Query() = default;
    // Returns what to read from the file of the queries.
    [[nodiscard]] virtual ReadRequest request(std::size_t dimensions) const {
        (void)dimensions;
        return {};
    }
    // Answers, with progress. Throws Failure.
    virtual void ask(const QueryInput& input, const votess::ProgressCallback& progress) = 0;
    virtual void write(const QueryInput& input, Outputs& outputs) = 0;
    [[nodiscard]] virtual std::vector<QueryCount> counts() const = 0;
    // Returns further members of the JSON object, each ", \"name\": value", or their words for people.
    [[nodiscard]] virtual std::string note(bool json) const {
        (void)json;
        return {};
    }

    const char* const stage;
    const char* const done;

protected:
    const Arguments& arguments_;
};

// Runs the query of the arguments on all frames. Returns the text to print: the summary or its JSON object; empty with
// --quiet, and when rows go to stdout.
[[nodiscard]] std::string run_query(const Arguments& arguments);

// The columns of the seeds side by side, one row for each seed.
struct Values {
    std::vector<double> rows;
    std::size_t components = 0;
};
[[nodiscard]] Values values_of(const Input& seeds, std::size_t first_column);

// Returns what to read from the file of the queries: weights or radii, if the seeds have them.
[[nodiscard]] ReadRequest request_of_queries(const Arguments& arguments);
// Returns the weights or radii of the queries: 0 where their file lacks the column or the elements; empty where the
// seeds have none.
[[nodiscard]] std::vector<double> sizes_of_queries(const Arguments& arguments, const QueryInput& input);

// Returns whether the output is .npy.
[[nodiscard]] bool is_npy_output(const std::string& path);
// Throws Failure unless there are outputs, each .npy or text. does: for messages.
void check_number_outputs(const Arguments& arguments, const std::string& does);

}  // namespace clvotess
