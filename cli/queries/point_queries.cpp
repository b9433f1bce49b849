#include "queries/point_queries.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "failure.hpp"
#include "files/formats/npy_array.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "write/output.hpp"
#include "write/result_arrays.hpp"

namespace clvotess {
namespace {

// Calls write(file, path) for each output. In text of several frames the line of this one comes first.
template <class Write>
void add_to_all(const Arguments& arguments, const QueryInput& input, Outputs& outputs, const Write& write) {
    for (const std::string& path : arguments.outputs) {
        const bool alone = outputs.place(path) == FramePlace::alone;
        outputs.add(path, [&](OutputFile& file) {
            if (!alone) file.write(frame_line(input.queries, input.queries.size(), "queries"));
            write(file, path);
        });
    }
}

// Writes `components` numbers for each query.
template <class Number>
void write_numbers(OutputFile& file, const std::string& path, const std::vector<Number>& numbers,
                   std::size_t components = 1) {
    constexpr bool whole = std::is_integral_v<Number>;
    if (is_npy_output(path)) {
        const std::array<std::uint64_t, 2> shape{numbers.size() / components, components};
        file.write(npy_header(whole ? "<i4" : "<f8", std::span(shape).first(components > 1 ? 2 : 1)));
        file.write(bytes_of(numbers));
        return;
    }
    std::string text;
    for (std::size_t k = 0; k < numbers.size(); ++k) {
        if constexpr (whole)
            text += std::to_string(numbers[k]);
        else
            text += to_text(numbers[k]);
        text += (k + 1) % components == 0 ? '\n' : ' ';
    }
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

class Locate : public Query {
public:
    explicit Locate(const Arguments& arguments) : Query(arguments, "locate", "located") {}
    void ask(const QueryInput& input, const votess::ProgressCallback& progress) override {
        seeds_ = input.diagram.locate(input.queries.points, progress);
        outside_ += std::ranges::count(seeds_, -1);
    }
    void write(const QueryInput& input, Outputs& outputs) override {
        add_to_all(arguments_, input, outputs, [&](auto& file, auto& path) { write_numbers(file, path, seeds_); });
    }
    std::vector<QueryCount> counts() const override { return {{"outside", "outside of the domain", outside_}}; }

private:
    std::vector<std::int32_t> seeds_;
    std::ptrdiff_t outside_ = 0;
};

class Probe : public Query {
public:
    explicit Probe(const Arguments& arguments) : Query(arguments, "probe", "probed") {}
    ReadRequest request(std::size_t) const override { return request_of_queries(arguments_); }
    void ask(const QueryInput& input, const votess::ProgressCallback& progress) override {
        for (const std::string& path : arguments_.outputs)
            if (!has_ends(input.seeds.options, arguments_.hull) && output_has(path, in_box))
                throw bad_input(
                    "output " + in_quotes(path) +
                    " needs a box with ends, and without a box cells of queries may reach infinity: give --box, "
                    "or write .npz, .h5 or text");
        votess::ProbeOptions options;
        options.want = arguments_.wanted;
        options.list_walls = arguments_.options.list_walls;
        options.progress = progress;
        sizes_ = sizes_of_queries(arguments_, input);
        (arguments_.has_radii ? options.radii : options.weights) = sizes_;
        cells_ = input.diagram.probe(input.queries.points, options);
        for (QueryCount& count : counts_) count.number += std::ranges::count(cells_.status(), status_of(count));
    }
    void write(const QueryInput& input, Outputs& outputs) override {
        const std::vector<InputColumn> carried;
        for (const std::string& path : arguments_.outputs)
            outputs.add(path,
                        {.input = input.queries,
                         .tessellation = cells_,
                         .wanted = arguments_.wanted,
                         .format = arguments_.format,
                         .radii = arguments_.has_radii ? std::span<const double>(sizes_) : std::span<const double>(),
                         .domain_from = input.seeds.domain_from,
                         .carried = carried,
                         .coloring = arguments_.coloring,
                         .place = outputs.place(path)});
    }
    std::vector<QueryCount> counts() const override { return {counts_.begin(), counts_.end()}; }

private:
    static constexpr std::array statuses{votess::CellStatus::outside, votess::CellStatus::duplicate,
                                         votess::CellStatus::empty};
    votess::CellStatus status_of(const QueryCount& count) const {
        return statuses[static_cast<std::size_t>(&count - counts_.data())];
    }

    std::vector<double> sizes_;
    votess::Tessellation cells_;
    std::array<QueryCount, 3> counts_{QueryCount{"outside", "outside of the domain"},
                                      QueryCount{"duplicates", "at the place of a seed"},
                                      QueryCount{"empty", "without a cell"}};
};

class Interpolate : public Query {
public:
    explicit Interpolate(const Arguments& arguments) : Query(arguments, "interpolate", "interpolated") {}
    ReadRequest request(std::size_t) const override { return request_of_queries(arguments_); }
    void ask(const QueryInput& input, const votess::ProgressCallback& progress) override {
        const Values values = values_of(input.seeds.input, arguments_.has_weights ? 1 : 0);
        std::vector<double> weights = sizes_of_queries(arguments_, input);
        for (double& weight : weights)
            if (arguments_.has_radii) weight *= weight;
        votess::NaturalOptions options;
        options.method = arguments_.natural;
        options.weights = weights;
        options.progress = progress;
        components_ = values.components;
        field_ = input.diagram.interpolate(values.rows, components_, input.queries.points, options).values;
        for (std::size_t k = 0; k < field_.size(); k += components_) without_ += std::isnan(field_[k]) ? 1 : 0;
    }
    void write(const QueryInput& input, Outputs& outputs) override {
        add_to_all(arguments_, input, outputs,
                   [&](auto& file, auto& path) { write_numbers(file, path, field_, components_); });
    }
    std::vector<QueryCount> counts() const override { return {{"without", "without natural neighbors", without_}}; }

private:
    std::vector<double> field_;
    std::size_t components_ = 1;
    std::ptrdiff_t without_ = 0;
};

class Trace : public Query {
public:
    explicit Trace(const Arguments& arguments) : Query(arguments, "trace", "traced") {}
    ReadRequest request(std::size_t dimensions) const override {
        ReadRequest rays;
        rays.threads = arguments_.read.threads;
        for (std::size_t k = 1; k <= 2 * dimensions + 1; ++k)
            (k <= dimensions ? rays.coordinates : rays.columns).push_back(std::to_string(k));
        rays.npy_holds_columns = true;
        return rays;
    }
    void ask(const QueryInput& input, const votess::ProgressCallback& progress) override {
        const std::size_t dimensions = input.seeds.input.dimensions;
        const std::vector<InputColumn>& columns = input.queries.columns;
        std::vector<double> directions, lengths;
        for (std::size_t r = 0; r < input.queries.size(); ++r) {
            for (std::size_t k = 0; k < dimensions; ++k) directions.push_back(columns[k].values[r]);
            lengths.push_back(columns[dimensions].values[r]);
        }
        cells_ = input.diagram.trace(input.queries.points, directions, lengths, {.progress = progress});
        for (std::size_t r = 0; r < input.queries.size(); ++r)
            without_ += cells_.offsets[r] == cells_.offsets[r + 1] ? 1 : 0;
    }
    void write(const QueryInput& input, Outputs& outputs) override {
        add_to_all(arguments_, input, outputs, [&](auto& file, auto& path) { write_traced(file, path, cells_); });
    }
    std::vector<QueryCount> counts() const override { return {{"without", "without cells", without_}}; }

private:
    votess::RayCells cells_;
    std::ptrdiff_t without_ = 0;
};

}  // namespace

void check_query_outputs(const Arguments& arguments) {
    const std::vector<std::string>& outputs = arguments.outputs;
    if (arguments.query == "--locate") return check_number_outputs(arguments, "finds a seed for each query");
    if (arguments.query == "--interpolate") return check_number_outputs(arguments, "computes numbers for each query");
    if (outputs.empty())
        throw bad_input(
            arguments.query + " needs an output: add -o " +
            (arguments.query == "--trace" ? "FILE.npz, FILE.txt or - for stdout" : "FILE, or -o - for stdout"));
    if (arguments.query == "--trace") {
        for (const std::string& path : outputs)
            if (!output_has(path, text_rows) && !is_npz_output(path))
                throw bad_input("--trace writes .npz and .txt, not " + in_quotes(path));
        return check_paths(outputs, {arguments.input, arguments.queries});
    }
    for (const std::string& path : outputs)
        if (!output_has(path, input_columns))  // a mesh of all cells, which share vertices
            throw bad_input("--probe writes text, .npz, .h5 and .vtu, not " + in_quotes(path) +
                            ": the cells of queries overlap and form no mesh");
}

std::unique_ptr<Query> make_point_query(const Arguments& arguments) {
    if (arguments.query == "--locate") return std::make_unique<Locate>(arguments);
    if (arguments.query == "--probe") return std::make_unique<Probe>(arguments);
    if (arguments.query == "--interpolate") return std::make_unique<Interpolate>(arguments);
    return std::make_unique<Trace>(arguments);
}

}  // namespace clvotess
