#include "queries/to_grid.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <span>

#include "failure.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "interrupt.hpp"
#include "queries/grid_files.hpp"
#include "queries/query_run.hpp"

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

// Returns the domain of a grid over points without a box: the default box, which holds a mesh too.
votess::Tessellation default_domain(const Input& seeds, const std::optional<votess::TriangleMesh>& mesh) {
    votess::Options options;
    options.planar = seeds.planar();
    options.mesh = mesh;
    options.only.emplace();
    return votess::tessellate(std::span<const double>(seeds.points), options);
}

std::vector<std::string> names_of(const Input& seeds, std::size_t first_column) {
    std::vector<std::string> names;
    for (std::size_t c = first_column; c < seeds.columns.size(); ++c)
        for (std::size_t k = 0; k < seeds.columns[c].width; ++k)
            names.push_back(seeds.columns[c].width > 1 ? seeds.columns[c].name + '_' + std::to_string(k)
                                                       : seeds.columns[c].name);
    return names;
}

std::string summary(const Arguments& arguments, const GridOutput& grid, std::size_t points, std::size_t without,
                    const StageTimes& times) {
    std::string shape;
    for (std::size_t k = 0; k < size_of_vectors(grid.domain); ++k) {
        if (!shape.empty()) shape += ", ";
        shape += std::to_string(grid.options.shape[k]);
    }
    if (arguments.json)
        return "{\"version\": \"" VOTESS_VERSION_STRING "\", \"points\": " + std::to_string(points) + ", \"shape\": [" +
               shape + "], \"without\": " + std::to_string(without) + ", \"seconds\": " + times.json() + "}\n";
    if (arguments.quiet) return "";
    std::string text = "a grid of " + shape + " cells by " + grid.method + " from " + std::to_string(points) + " seeds";
    if (without > 0) text += ", the mass of " + std::to_string(without) + " in no tetrahedron left out";
    return text + '\n';
}

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

std::string run_to_grid(const Arguments& arguments) {
    StageTimes times;
    const QueryInput input = read_and_sort(arguments, "", {}, times);
    votess::GridOptions options = *arguments.to_grid;
    complete(arguments, input.seeds.dimensions, options);
    const std::size_t first_column = arguments.has_weights ? 1 : 0;
    Values values = values_of(input.seeds, first_column);
    std::vector<std::string> names = names_of(input.seeds, first_column);
    if (arguments.read.columns.size() == first_column) {  // default: masses of 1
        names = {"density"};
        values.rows.assign(input.diagram.size(), 1);
    }
    names.resize(values.components);  // for a file of no points
    if (arguments.picture && values.components > 1) throw bad_input("--image shows one column: name one with --values");
    const votess::Options& given = arguments.options;
    const bool has_box = input.has_ends && (!given.mesh || given.box || given.cell);
    const votess::Tessellation domain = has_box ? input.diagram.probe({}) : default_domain(input.seeds, given.mesh);
    check_grid_domain(arguments.outputs, domain);
    options.columns = values.components;
    std::size_t size = options.columns;
    for (int k = 0; k < 3; ++k) {
        const std::size_t along = k == options.project ? 1 : options.shape[static_cast<std::size_t>(k)];
        if (size > (std::size_t{1} << 59) / along) throw std::bad_alloc();
        size *= along;
    }
    std::vector<double> numbers(size);
    const std::size_t without = run_query(arguments, times, "grid", [&](const votess::ProgressCallback& callback) {
        options.progress = callback;
        return input.diagram.to_grid(values.rows, options, numbers);
    });
    options.progress = nullptr;

    const GridOutput grid{numbers,
                          options,
                          std::string(words_of(*find_option("--to-grid")).at(static_cast<std::size_t>(options.method))),
                          std::move(names),
                          domain,
                          input.domain_from};
    const InterruptGuard guard;
    std::deque<OutputFile> files;
    for (const std::string& path : arguments.outputs) {
        write_grid(files.emplace_back(path), path, grid);
        files.back().finish();
    }
    if (arguments.picture) {
        files.emplace_back(arguments.picture->file).write(draw_grid(grid, arguments.coloring.colormap));
        files.back().finish();
    }
    throw_if_interrupted();
    for (OutputFile& file : files) file.publish();
    times.end("write");
    return summary(arguments, grid, input.diagram.size(), without, times);
}

}  // namespace clvotess
