#include "arguments/arguments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "arguments/only.hpp"
#include "arguments/typed.hpp"
#include "domain.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "help/help.hpp"
#include "queries/point_queries.hpp"
#include "queries/to_grid.hpp"
#include "run/frames.hpp"
#include "run/run.hpp"
#include "stream/stream.hpp"
#include "surface/surface_run.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

double read_number(const std::string& option, const std::string& text, std::string_view field) {
    const auto number = read_double(field);
    if (!number) throw bad_input(option + " " + in_quotes(text) + ": " + in_quotes(field) + " is not a number");
    return *number;
}

// Splits names of columns at commas. Quotes may hold commas and doubled quotes, as in .csv.
std::vector<std::string> split_names(const std::string& option, const std::string& text) {
    std::vector<std::string> names;
    for (std::size_t at = 0;; ++at) {
        std::string& name = names.emplace_back();
        bool quoted = at < text.size() && text[at] == '"';
        if (quoted) ++at;
        for (; at < text.size() && (quoted || text[at] != ','); ++at) {
            const bool quote = quoted && text[at] == '"';
            if (quote && text.compare(at, 2, "\"\"") != 0) {
                quoted = false;
                continue;
            }
            name += text[at];
            if (quote) ++at;
        }
        if (quoted) throw bad_input(option + " " + in_quotes(text) + ": a quote does not end");
        if (at >= text.size()) return names;
    }
}

// Marks the run as one in three dimensions. Throws Failure if another option says two.
void need_space(const std::string& what, Arguments& arguments) {
    if (!arguments.flat.empty())
        throw bad_input(what + " needs three dimensions, but " + arguments.flat + " means two: leave one of them out");
    arguments.read.dimensions = Dimensions::three;
}

// Returns whether a number of a domain is left out in two dimensions: z, or one of the edge c.
bool is_along_z(std::string_view number) {
    return number.find('z') != std::string_view::npos || number.starts_with('c');
}

// Reads as many numbers as the option names. In two dimensions those along z are left out, and are 0.
template <std::size_t count>
std::array<double, count> read_vectors(const std::string& option, const std::string& text, Arguments& arguments) {
    std::vector<std::size_t> places;
    std::string names;
    const std::string_view value = value_of(*find_option(option));
    const auto all = split(value, ',');
    for (std::size_t k = 0; k < count; ++k) {
        if (is_along_z(all[k])) continue;
        places.push_back(k);
        names += (names.empty() ? "" : ",") + std::string(all[k]);
    }
    const auto fields = split(text, ',');
    const std::string& other = arguments.flat;
    const bool may_be_flat = arguments.read.dimensions != Dimensions::three, fits_flat = fields.size() == places.size();
    const bool flat = may_be_flat && fits_flat;
    if (!flat && !(other.empty() && fields.size() == count)) {
        const std::string expected = other.empty() ? std::to_string(count) + " numbers " + std::string(value)
                                                   : std::to_string(places.size()) + " numbers " + names;
        throw bad_input(option + " must be " + expected + ", not " + in_quotes(text) +
                        (!other.empty() ? ": " + other + " means two dimensions"
                         : fits_flat    ? "; for two dimensions add --2d"
                                        : ""));
    }
    std::array<double, count> numbers{};
    for (std::size_t i = 0; i < fields.size(); ++i)
        numbers[flat ? places[i] : i] = read_number(option, text, fields[i]);
    if (flat && other.empty()) arguments.flat = option + " " + text;
    if (!flat) arguments.read.dimensions = Dimensions::three;
    return numbers;
}

template <std::size_t count>
std::array<double, count> read_numbers(const std::string& option, const std::string& text) {
    const auto fields = split(text, ',');
    if (fields.size() != count) {
        throw bad_input(option + " must be " + std::to_string(count) + " numbers " +
                        std::string(value_of(*find_option(option))) + ", not " + in_quotes(text));
    }
    std::array<double, count> numbers{};
    for (std::size_t i = 0; i < count; ++i) numbers[i] = read_number(option, text, fields[i]);
    return numbers;
}

std::array<bool, 3> read_periodic(const std::string& axes) {
    std::array<bool, 3> periodic{};
    if (axes == "none") return periodic;
    for (const char axis : axes) {
        if (axis < 'x' || axis > 'z' || periodic[static_cast<std::size_t>(axis - 'x')]) {
            throw bad_input("--periodic must name axes, such as xyz or xy, or be none, not " + in_quotes(axes));
        }
        periodic[static_cast<std::size_t>(axis - 'x')] = true;
    }
    return periodic;
}

std::size_t read_faces(const char* option, double faces) {
    if (faces >= 0 && faces <= 1e9 && faces == std::floor(faces)) return static_cast<std::size_t>(faces);
    throw bad_input(std::string(option) + ": FACES must be a whole number, not " + to_text(faces));
}

void read_walls(const Typed& typed, Arguments& arguments) {
    std::vector<votess::Wall>& walls = arguments.options.walls;
    const auto add = [&walls](const std::vector<votess::Wall>& more) {
        walls.insert(walls.end(), more.begin(), more.end());
    };
    for (const std::string& text : typed.values("--wall")) {
        const auto n = read_vectors<4>("--wall", text, arguments);
        walls.push_back({.normal = {n[0], n[1], n[2]}, .offset = n[3]});
    }
    for (const std::string& text : typed.values("--wall-sphere")) {
        const auto n = read_numbers<5>("--wall-sphere", text);
        add(votess::sphere_walls({n[0], n[1], n[2]}, n[3], read_faces("--wall-sphere", n[4])));
    }
    for (const std::string& text : typed.values("--wall-cylinder")) {
        const auto n = read_numbers<8>("--wall-cylinder", text);
        add(votess::cylinder_walls({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], read_faces("--wall-cylinder", n[7])));
    }
    for (const std::string& text : typed.values("--wall-cone")) {
        const auto n = read_numbers<8>("--wall-cone", text);
        add(votess::cone_walls({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], read_faces("--wall-cone", n[7])));
    }
}

void read_domain(const Typed& typed, Arguments& arguments) {
    votess::Options& options = arguments.options;
    if (const std::string* text = typed.value("--box")) {
        if (*text == "none") {
            constexpr double inf = std::numeric_limits<double>::infinity();
            options.box = votess::Box{.lower = {-inf, -inf, -inf}, .upper = {inf, inf, inf}};
        } else if (*text == "hull") {
            options.box.reset();
            arguments.hull = true;
        } else {
            const auto n = read_vectors<6>("--box", *text, arguments);
            options.box = votess::Box{.lower = {n[0], n[1], n[2]}, .upper = {n[3], n[4], n[5]}};
        }
    }
    if (const std::string* axes = typed.value("--periodic")) {
        arguments.periodic = read_periodic(axes->empty() ? "xyz" : *axes);
        if (!axes->empty() && (*arguments.periodic)[2]) need_space("--periodic " + *axes, arguments);
    }
    if (const std::string* text = typed.value("--cell")) {
        if (!typed.has("--box")) options.box.reset();
        const auto n = read_vectors<9>("--cell", *text, arguments);
        votess::TriclinicBox& cell = options.cell.emplace();
        cell.a = {n[0], n[1], n[2]};
        cell.b = {n[3], n[4], n[5]};
        cell.c = {n[6], n[7], n[8]};
        const std::array edges{cell.a, cell.b, cell.c};
        for (std::size_t k = 0; k < 3; ++k) cell.periodic[k] = edges[k] != std::array<double, 3>{};
        if (const std::string* origin = typed.value("--origin"))
            cell.origin = read_vectors<3>("--origin", *origin, arguments);
    }
    read_walls(typed, arguments);
    options.planar = !arguments.flat.empty();
    set_ends_of_z(options);
    if (const std::string* file = typed.value("--mesh")) {
        if (file->empty()) throw bad_input("--mesh is empty: give the file of a triangle mesh");
        arguments.mesh_file = *file;
    }
    if (const std::string* gap = typed.value("--gap")) arguments.gap = read_numbers<1>("--gap", *gap)[0];
    if (const std::string* level = typed.value("--merge")) arguments.merge = read_numbers<1>("--merge", *level)[0];
    if (const std::string* angle = typed.value("--sharp")) arguments.sharp = read_numbers<1>("--sharp", *angle)[0];
    if (const std::string* edge = typed.value("--min-edge"))
        arguments.min_edge = read_numbers<1>("--min-edge", *edge)[0];
    if (arguments.min_edge < 0) throw bad_input("--min-edge is negative: give a length from 0 on");
    if (arguments.gap < 0) throw bad_input("--gap is negative: give a length from 0 on");
    if (const std::string* repair = typed.value("--mesh-repair")) {
        if (*repair != "merge") throw bad_input("--mesh-repair is " + in_quotes(*repair) + ": give merge");
        arguments.mesh.merge = true;
    }
    if (const std::string* share = typed.value("--mesh-tolerance"))
        arguments.mesh.tolerance = read_numbers<1>("--mesh-tolerance", *share)[0];
    const bool bounded = !options.walls.empty() || !arguments.mesh_file.empty();
    if (bounded && typed.has("--random") && !typed.has("--box")) options.box.reset();
}

// Reads which dimensions the options allow. read_domain() and read_outputs() go on.
void read_dimensions(const Typed& typed, Arguments& arguments) {
    arguments.read.dimensions = typed.has("--random") ? Dimensions::three : Dimensions::either;
    const std::string* columns = typed.value("--columns");
    const std::size_t axes = columns ? split_names("--columns", *columns).size() : 0;
    if (axes == 2) arguments.flat = "--columns " + *columns;
    const std::string* mesh = typed.value("--mesh");
    const bool has_polygons = mesh && !mesh->empty() && holds_polygons("--mesh", *mesh);
    if (has_polygons) arguments.flat = "--mesh " + *mesh;
    if (typed.has("--2d")) arguments.flat = "--2d";
    if (!arguments.flat.empty()) arguments.read.dimensions = Dimensions::two;
    if (axes == 3) need_space("--columns " + *columns, arguments);
    if (mesh && !has_polygons) need_space("--mesh " + *mesh, arguments);
    for (const Option* option : arguments.given)
        if (const std::string name = long_name(*option);
            option->traits.solid && !(typed.has("--to-grid") && (name == "--image" || name == "--colormap")))
            need_space(name, arguments);
}

void read_source(const Typed& typed, Arguments& arguments) {
    const std::string* input = typed.value("INPUT");
    const std::string* random = typed.value("--random");
    if (input && random) throw bad_input("give either INPUT or --random N, not both");
    if (!input && !random && !typed.has("--remesh"))
        throw bad_input(typed.has("--surface")
                            ? "there is no input: give a file of seeds as INPUT (- for stdin), --random N or --remesh N"
                            : "there is no input: give a file of points as INPUT (- for stdin) or --random N; "
                              "clvotess --help-all lists all options");
    if (input && input->empty()) throw bad_input("INPUT is empty: give a file, or - for stdin");
    if (input) arguments.input = *input;
    if (random && (typed.has("--dataset") || typed.has("--frame") || typed.has("--frames")))
        throw bad_input("--dataset, --frame and --frames go with INPUT, not with --random");
    arguments.has_radii = typed.has("--radii");
    arguments.has_weights = typed.has("--weights") || arguments.has_radii;
    arguments.has_volumes = typed.has("--volumes");
    arguments.has_density = typed.has("--density");
    arguments.has_zones = typed.has("--watershed");
    if (const std::string* text = typed.value("--tolerance"))
        arguments.fit.tolerance = read_numbers<1>("--tolerance", *text)[0];
    if (const std::string* text = typed.value("--max-steps"))
        arguments.fit.max_steps =
            static_cast<unsigned>(whole_number("--max-steps", *text, std::numeric_limits<unsigned>::max()));
    arguments.fit.normalize = typed.has("--normalize");
    if (typed.has("--weights") && arguments.has_radii) throw bad_input("give either --weights or --radii, not both");
    const std::string* copy = typed.value("--copy");
    arguments.read.all_columns = copy && *copy == "all" && !random;  // else refused below
    arguments.read.columns_may_lack = arguments.read.all_columns && arguments.points_alone;
    for (const std::string option :
         {"--weights", "--radii", "--volumes", "--density", "--watershed", "--values", "--copy"}) {
        const std::string* columns = typed.value(option);
        if (!columns || (columns == copy && arguments.read.all_columns)) continue;
        if (random) throw bad_input(option + " goes with INPUT, not with --random");
        const bool list = option == "--values" || option == "--copy";
        const auto names = list ? split_names(option, *columns) : std::vector<std::string>{*columns};
        for (const std::string& column : names) {
            if (column.empty()) {
                const bool none = std::ranges::all_of(names, &std::string::empty);
                throw bad_input(none ? option + " is empty: give the name or number of a column"
                                     : option + " " + in_quotes(*columns) +
                                           " holds an empty name: leave out a comma, or put the name between them");
            }
            if (option == "--radii" && column == "covalent") {
                arguments.covalent = arguments.read.species = true;
                continue;
            }
            if (option == "--watershed" && column == "density" && arguments.has_density) {
                arguments.zones_of_density = true;
                continue;
            }
            if (option == "--copy") {
                arguments.read.first_carried = std::min(arguments.read.first_carried, arguments.read.columns.size());
            }
            arguments.read.columns.push_back(column);
        }
    }
    constexpr auto max = std::numeric_limits<std::uint64_t>::max();
    if (const std::string* dataset = typed.value("--dataset")) {
        if (dataset->empty()) throw bad_input("--dataset is empty: give the name of the points in the file");
        arguments.read.dataset = *dataset;
    }
    if (const std::string* columns = typed.value("--columns")) {
        if (random) throw bad_input("--columns goes with INPUT, not with --random");
        if (typed.has("--dataset")) throw bad_input("give either --dataset or --columns, not both");
        const std::vector<std::string>& names = arguments.read.coordinates = split_names("--columns", *columns);
        if (names.size() < 2 || names.size() > 3 || std::ranges::count(names, std::string()) > 0)
            throw bad_input("--columns must be names or numbers of columns, X,Y,Z or X,Y in two dimensions, not " +
                            in_quotes(*columns));
    }
    if (const std::string* frames = typed.value("--frames")) arguments.frames = read_frame_range(*frames);
    if (const std::string* frame = typed.value("--frame")) arguments.read.frame = whole_number("--frame", *frame, max);
    if (random) {
        arguments.random_count = read_count("--random", *random, std::numeric_limits<std::int32_t>::max());
        const double height = arguments.read.dimensions == Dimensions::two ? 0 : 1;
        if (!typed.has("--mesh") && !typed.has("--surface"))
            arguments.options.box = votess::Box{.lower = {0, 0, 0}, .upper = {1, 1, height}};
    }
    if (const std::string* seed = typed.value("--rng-seed"))
        arguments.rng_seed = whole_number("--rng-seed", *seed, max);
}

void read_outputs(const Typed& typed, Arguments& arguments) {
    constexpr std::uint64_t max_copies = 1000;
    check_outputs(arguments.outputs, {arguments.input, arguments.queries});
    const bool text = any_output_has(arguments.outputs, text_rows);
    if (const std::string* format = typed.value("--format")) {
        if (!text) throw bad_input("--format goes with text output only: add -o FILE.txt, or -o - for stdout");
        arguments.format = TextFormat(*format);
        if (const char code = arguments.format.solid_code())
            need_space(std::string("--format with %") + code, arguments);
    }
    for (const std::string& path : arguments.outputs)
        if (output_has(path, in_space))
            need_space("output " + in_quotes(path), arguments);
        else if (output_has(path, cell_pieces) && !output_has(path, polyhedra) && arguments.flat.empty())
            throw bad_input("output " + in_quotes(path) + " holds polygons: add --mesh FILE.geojson");
    const bool pieces = any_output_has(arguments.outputs, cell_pieces);
    const bool in_mesh = !arguments.mesh_file.empty();
    if (typed.has("--min-edge") && !any_output_has(arguments.outputs, in_mesh ? joined_pieces : shared_faces))
        throw bad_input(std::string("--min-edge is for meshes of solvers: add -o FILE in ") +
                        (in_mesh ? ".foam, .msh or .cgns" : ".foam, .tess, .msh, .cgns or .stl"));
    for (const std::string& path : arguments.outputs)
        if (typed.has("--gap") && output_has(path, joined_pieces))
            throw bad_input("--gap parts the pieces, and output " + in_quotes(path) + " joins them: leave out --gap");
    if (typed.has("--gap") && !pieces && !typed.has("--image"))
        throw bad_input("--gap is between pieces: add -o FILE in .glb, .obj, .stl, .3mf or .geojson");
    for (const std::string& path : arguments.outputs)
        if (output_has(path, cell_pieces) && !output_has(path, polyhedra) && arguments.mesh_file.empty())
            throw bad_input("output " + in_quotes(path) + " holds pieces of cells in a mesh: add --mesh FILE");
    if ((typed.has("--copy") || typed.has("--density") || arguments.has_zones) && !typed.has("--image") &&
        !arguments.points_alone && !any_output_has(arguments.outputs, input_columns | cell_colors)) {
        throw bad_input(
            "--copy, --density and --watershed need text, .csv, .xyz, .dump, .npz, .h5 or .vtu, "
            "or --color with .glb or --image: add -o FILE");
    }
    if (const std::string* copies = typed.value("--alpha")) {
        arguments.alpha = static_cast<std::int32_t>(whole_number("--alpha", *copies, max_copies));
        if (arguments.alpha == 0) throw bad_input("--alpha is 0: give a number of copies, at least 1");
        if (!any_output_has(arguments.outputs, any_arrays)) throw bad_input("--alpha needs .npz or .h5: add -o FILE");
    }
    if (const std::string* list = typed.value("--want")) arguments.wanted = votess::want_of(*list);
    if (text) arguments.format.add_needs(arguments.wanted);
    for (const std::string& path : arguments.outputs)
        add_output_needs(path, typed.has("--want"), arguments.wanted, in_mesh);
    arguments.read.species |= any_output_has(arguments.outputs, species_column);
}

// Returns the option of the query; "" if the run makes cells of the points.
std::string query_of(const Typed& typed) {
    std::string query;
    for (const char* option : {"--locate", "--probe", "--interpolate", "--trace", "--to-grid"}) {
        if (!typed.has(option)) continue;
        if (!query.empty())
            throw bad_input("give one of --locate, --probe, --interpolate, --trace and --to-grid, not several");
        query = option;
    }
    return query;
}

// Options of cells mean nothing to a query, except for the cells of probes and pictures of grids.
void refuse_options_of_cells(const Arguments& arguments, const std::string& query) {
    std::vector<std::string> allowed;
    if (query == "--probe") allowed = {"--format", "--want", "--list-walls"};
    if (query == "--to-grid") allowed = {"--image", "--colormap"};
    if (const Option* option = arguments.find_needing({Needs::cells, Needs::all_cells}, allowed))
        throw bad_input(long_name(*option) + " is for cells of the points, but " + query +
                        " computes none: leave it out");
}

void read_query(const Typed& typed, const std::string& option, Arguments& arguments) {
    if (option == "--to-grid") {
        arguments.to_grid = read_grid(typed);
        arguments.picture = read_picture(typed, arguments.input, arguments.outputs);
        arguments.coloring = read_coloring(typed);
        check_grid(arguments);
        return;
    }
    arguments.queries = *typed.value(option);
    if (arguments.queries.empty()) throw bad_input(option + " is empty: give the file of the queries");
    if (arguments.queries == "-" && arguments.input == "-")
        throw bad_input("INPUT and " + option + " are both stdin: give one as a file");
    if (option == "--interpolate") {
        if (!typed.has("--values")) throw bad_input("--interpolate needs a field: add --values COLUMN");
        typed.read_word("--natural", arguments.natural);
    }
    if (option == "--probe") {
        read_outputs(typed, arguments);
        arguments.options.want = arguments.wanted;
        arguments.wanted = votess::implied_want(arguments.options);
    }
    check_query_outputs(arguments);
}

void read_colors(const Typed& typed, Arguments& arguments) {
    arguments.coloring = read_coloring(typed);
    const bool colored = any_output_has(arguments.outputs, cell_colors);
    if (colored) arguments.coloring.add_needs(arguments.wanted);
    for (const std::string option : {"--color", "--colormap"})
        if (!colored && !arguments.picture && typed.has(option))
            throw bad_input(option + " is for pictures and .glb: add --image FILE.png or -o FILE.glb");
}

// Files of meshes and of atoms, and pictures, need a box with ends.
void check_endless(const Arguments& arguments) {
    const auto& [lower, upper] = arguments.options.box.value_or(votess::Box{});
    const auto infinite = [](double x) { return std::isinf(x); };
    if (std::ranges::none_of(lower, infinite) && std::ranges::none_of(upper, infinite)) return;
    const std::string remedy = " without end: leave out cells that reach infinity by --open skip, or give --box";
    if (arguments.picture && !arguments.skip_open) throw bad_input("--image in a domain" + remedy);
    for (const std::string& path : arguments.outputs) {
        const bool is_mesh = output_has(path, polyhedra);
        if (!output_has(path, in_box) || (is_mesh && arguments.skip_open)) continue;
        throw bad_input("output " + in_quotes(path) +
                        (is_mesh ? " in a domain" + remedy : " holds a box with ends: give other bounds by --box"));
    }
}

// Parts of cells in a mesh have no polygons.
void check_mesh(const Arguments& arguments) {
    if (arguments.mesh_file.empty()) return;
    for (const std::string& path : arguments.outputs)
        if (output_has(path, polyhedra) && !output_has(path, cell_pieces))
            throw bad_input(
                "output " + in_quotes(path) +
                " holds polygons of whole cells: write pieces as .vtu, .glb, .obj, .stl, .3mf, .foam, .msh or "
                ".cgns");
    for (const std::string& path : arguments.outputs)
        if (arguments.options.planar && output_has(path, polyhedra))
            throw bad_input("output " + in_quotes(path) + " holds no polygons with holes: write pieces as .geojson");
    for (const Option* option : arguments.given)
        if (const std::string name = long_name(*option);
            (name == "--color" || name == "--colormap") && !arguments.picture)
            throw bad_input(name + " does not color pieces, which have the materials inside and surface: leave it out");
}

// Refuses options that mean nothing without another one.
void check_companions(const Typed& typed, const Arguments& arguments) {
    for (const Option* option : arguments.given) {
        if (option->traits.with.empty()) continue;
        std::string names;
        bool found = false;
        for (const std::string_view other : split(option->traits.with, '|')) {
            found |= typed.has(other);
            names += (names.empty() ? "" : " or ") + std::string(find_option(other)->names);
        }
        if (!found) throw bad_input(long_name(*option) + " goes with " + names + " only");
    }
}

void check_names(const Arguments& arguments) {
    std::vector<std::string> files = arguments.outputs;
    if (arguments.picture) files.push_back(arguments.picture->file);
    check_frame_names(files, arguments.frames.has_value());
}

std::string answer_to(const Typed& typed) {
    if (typed.has("--help")) return usual_help();
    if (typed.has("--help-all")) return whole_help();
    if (typed.has("--man")) return manual_page();
    if (const std::string* shell = typed.value("--completion")) return completion(*shell);
    if (typed.has("--version")) return "clvotess " VOTESS_VERSION_STRING "\n";
    return {};
}

}  // namespace

std::uint64_t read_count(const std::string& option, const std::string& text, std::uint64_t max) {
    const auto number = read_double(text);
    const bool whole = number && *number >= 0 && *number <= static_cast<double>(max) && *number == std::floor(*number);
    return whole ? static_cast<std::uint64_t>(*number) : whole_number(option, text, max);
}

const Option* Arguments::find_needing(std::initializer_list<Needs> needs,
                                      const std::vector<std::string>& except) const {
    for (const Option* option : given)
        if (std::ranges::count(needs, option->traits.needs) > 0 && std::ranges::count(except, long_name(*option)) == 0)
            return option;
    return nullptr;
}

void load_mesh(Arguments& arguments) {
    if (arguments.mesh_file.empty()) return;
    const bool merge = arguments.mesh.merge;
    const double tolerance = arguments.mesh.tolerance;
    arguments.mesh = read_surface("--mesh", arguments.mesh_file);
    arguments.mesh.merge |= merge;
    arguments.mesh.tolerance = tolerance;
    arguments.options.mesh = arguments.mesh.view();
}

Arguments read_arguments(int count, const char* const* values) {
    const Typed typed(count, values);
    Arguments arguments;
    arguments.list_devices = typed.has("--list-devices");
    arguments.json = typed.has("--json");
    arguments.answer = answer_to(typed);
    if (arguments.list_devices || !arguments.answer.empty()) return arguments;

    arguments.verify = typed.has("--verify");
    if (const std::string* open = typed.value("--open")) {
        if (*open != "skip") throw bad_input("--open is " + in_quotes(*open) + ": give skip");
        arguments.skip_open = true;
    }
    arguments.points_alone = arguments.read.species = typed.has("--points");
    arguments.quiet = typed.has("--quiet");
    arguments.outputs = typed.values("--output");
    arguments.threads_given = typed.has("--threads");
    each_option([&](const Option& option) {
        if (typed.has(long_name(option))) arguments.given.push_back(&option);
    });
    const std::string& query = arguments.query = query_of(typed);
    if (!query.empty()) refuse_options_of_cells(arguments, query);
    if (typed.has("--surface")) refuse_beside_surface(arguments);
    check_companions(typed, arguments);
    votess::Options& options = arguments.options;
    typed.read_members(options);
    arguments.read.threads = options.threads;
    read_dimensions(typed, arguments);
    read_source(typed, arguments);
    read_domain(typed, arguments);
    if (typed.has("--surface")) {
        read_surface_options(typed, arguments);
        return arguments;
    }
    if (arguments.json && std::ranges::count(arguments.outputs, "-") > 0)
        throw bad_input("-o - and --json both write to stdout: give -o a file");
    read_memory(typed, arguments);
    if (arguments.frames) check_frames(arguments);
    if (!query.empty()) {
        read_query(typed, query, arguments);
        check_names(arguments);
        return arguments;
    }
    read_outputs(typed, arguments);
    if (const std::string* only = typed.value("--only")) {
        arguments.only = *only;
        check_only(arguments);
    }
    arguments.picture = read_picture(typed, arguments.input, arguments.outputs);
    read_colors(typed, arguments);
    check_endless(arguments);
    check_mesh(arguments);
    if (arguments.picture) arguments.picture->options.threads = options.threads;
    check_names(arguments);

    options.want = arguments.wanted;
    votess::Options to_write = options;
    to_write.min_face = to_write.min_area = 0;  // they imply areas, which a file holds only by --want
    arguments.wanted = votess::implied_want(to_write);
    options.want.volumes |= arguments.has_density;
    options.want.neighbors |= arguments.has_zones;
    if (arguments.verify) {
        options.want.neighbors = options.want.volumes = true;
        options.want.counts |= arguments.mesh_file.empty();
    }
    if (arguments.memory > 0) {
        check_streamed(arguments);
        arguments.read.carries_words = false;  // temporary files hold numbers
    }
    return arguments;
}

}  // namespace clvotess
