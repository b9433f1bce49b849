#include "queries/to_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "failure.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "queries/grid_files.hpp"

namespace clvotess {
namespace {

std::array<std::size_t, 3> read_shape(const std::string& text) {
    std::array<std::size_t, 3> shape{};
    std::size_t begin = 0, numbers = 0;
    for (; numbers < 3 && begin <= text.size(); ++numbers) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const auto number = read_uint64(std::string_view(text).substr(begin, end - begin));
        if (!number || *number == 0 || *number > (std::uint64_t{1} << 20)) break;
        shape[numbers] = *number;
        begin = end + 1;
    }
    if (begin <= text.size() || numbers == 0)
        throw bad_input("--shape must be NX,NY,NZ or N, whole numbers from 1 to 1048576, not " + in_quotes(text));
    return shape;
}

// Completes the shape and checks the picture.
void complete(const Arguments& arguments, std::size_t dimensions, votess::GridOptions& grid) {
    const auto named = static_cast<std::size_t>(3 - std::ranges::count(grid.shape, std::size_t{0}));
    if (named != 1 && named != dimensions)
        throw bad_input("--shape has " + std::to_string(named) + " numbers, but the points " +
                        std::to_string(dimensions) + " coordinates: give " +
                        (dimensions == 2 ? "NX,NY or N" : "NX,NY,NZ or N"));
    if (named == 1) grid.shape[1] = grid.shape[2] = grid.shape[0];
    if (dimensions == 2) grid.shape[2] = 1;
    if (dimensions == 2 && grid.project == 2) throw bad_input("--project z needs three dimensions: give x or y");
    if (!arguments.picture) return;
    if (dimensions == 3 && !grid.project) throw bad_input("--image shows a projected grid: add --project x, y or z");
    if (dimensions == 2 && grid.project) throw bad_input("--image shows a grid of two dimensions: leave --project out");
    for (int k = 0; k < 3; ++k)
        if (k != grid.project && grid.shape[static_cast<std::size_t>(k)] > 16384)
            throw bad_input(
                "--image has a pixel for each grid cell, 16384 at most along an axis: give a smaller --shape");
}

std::vector<std::string> names_of(const Input& seeds, std::size_t first_column) {
    std::vector<std::string> names;
    for (std::size_t c = first_column; c < seeds.columns.size(); ++c)
        for (std::size_t k = 0; k < seeds.columns[c].width; ++k)
            names.push_back(seeds.columns[c].width > 1 ? seeds.columns[c].name + '_' + std::to_string(k)
                                                       : seeds.columns[c].name);
    return names;
}

class ToGrid : public Query {
public:
    explicit ToGrid(const Arguments& arguments)
        : Query(arguments, "grid", "a grid of "), options_(*arguments.to_grid) {}
    void ask(const QueryInput& input, const votess::ProgressCallback& progress) override {
        const Input& seeds = input.seeds.input;
        options_ = *arguments_.to_grid;
        complete(arguments_, seeds.dimensions, options_);
        const std::size_t first_column = arguments_.has_weights ? 1 : 0;
        Values values = values_of(seeds, first_column);
        names_ = names_of(seeds, first_column);
        if (seeds.columns.size() == first_column) {  // default: masses of 1
            names_ = {"density"};
            values.rows.assign(seeds.size(), 1);
        }
        if (arguments_.picture && values.components > 1)
            throw bad_input("--image shows one column: name one with --values");
        domain_ = input.diagram.grid_domain();
        check_grid_domain(arguments_.outputs, domain_);
        options_.columns = values.components;
        std::size_t size = options_.columns;
        for (int k = 0; k < 3; ++k) {
            const std::size_t along = k == options_.project ? 1 : options_.shape[static_cast<std::size_t>(k)];
            if (size > (std::size_t{1} << 59) / along) throw std::bad_alloc();
            size *= along;
        }
        numbers_.assign(size, 0);
        options_.progress = progress;
        without_ += static_cast<std::ptrdiff_t>(input.diagram.to_grid(values.rows, options_, numbers_));
        options_.progress = nullptr;
    }
    void write(const QueryInput& input, Outputs& outputs) override {
        const GridOutput grid{numbers_, options_, method(), names_, domain_, input.seeds.domain_from};
        for (const std::string& path : arguments_.outputs)
            outputs.add(path, [&](OutputFile& file) { write_grid(file, path, grid); });
        if (arguments_.picture)
            outputs.add(arguments_.picture->file,
                        [&](OutputFile& file) { file.write(draw_grid(grid, arguments_.coloring.colormap)); });
    }
    std::vector<QueryCount> counts() const override {
        return {{"without", "in no tetrahedron, whose mass is left out", without_}};
    }
    std::string note(bool json) const override {
        std::string shape;
        for (std::size_t k = 0; k < (domain_.planar() ? 2 : 3); ++k)
            shape += (shape.empty() ? "" : ", ") + std::to_string(options_.shape[k]);
        return json ? ", \"shape\": [" + shape + "]" : shape + " cells by " + method();
    }

private:
    std::string method() const {
        return std::string(words_of(*find_option("--to-grid")).at(static_cast<std::size_t>(options_.method)));
    }

    votess::GridOptions options_;
    std::vector<double> numbers_;
    std::vector<std::string> names_;
    votess::Tessellation domain_;
    std::ptrdiff_t without_ = 0;
};

}  // namespace

votess::GridOptions read_grid(const Typed& typed) {
    votess::GridOptions grid;
    typed.read_word("--to-grid", grid.method);
    if (!typed.has("--shape")) throw bad_input("--to-grid needs the number of grid cells: add --shape NX,NY,NZ");
    grid.shape = read_shape(*typed.value("--shape"));
    if (!typed.has("--values") && grid.method != votess::GridMethod::dtfe)
        throw bad_input("--to-grid " + *typed.value("--to-grid") + " needs a field: add --values COLUMN");
    if (typed.has("--project")) typed.read_word("--project", grid.project.emplace());
    return grid;
}

void check_grid(const Arguments& arguments) {
    check_grid_outputs(arguments.outputs, arguments.picture.has_value(), arguments.input);
}

std::unique_ptr<Query> make_grid_query(const Arguments& arguments) {
    return std::make_unique<ToGrid>(arguments);
}

}  // namespace clvotess
