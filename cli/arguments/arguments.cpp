#include "arguments/arguments.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "arguments/nearest.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "help/help.hpp"
#include "queries/point_queries.hpp"
#include "queries/to_grid.hpp"
#include "stream/stream.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

// Options as typed. CLI11 only splits the command line, so that our messages can name a remedy.
struct Typed {
    std::optional<std::string> input, random, rng_seed, format, want, box, device, precision, duplicates;
    std::optional<std::string> periodic, cell, origin, outside, min_face, min_area;
    std::optional<std::string> dataset, frame, weights, radii, copy, density, locate, probe, interpolate, values,
        natural;
    std::vector<std::string> walls, sphere_walls, cylinder_walls, cone_walls;
    std::optional<std::string> memory, temporary;
    std::optional<std::string> threads, grid_resolution, k_init, chunk_size, instructions;
    std::vector<std::string> outputs;
    bool list_walls = false, verify = false, json = false, quiet = false;
    bool help = false, help_all = false, man = false, version = false, list_devices = false;
    std::optional<std::string> completion;
    TypedPicture picture;
    TypedGrid grid;
};

// Drops a value after =, and all minus signs in front: a single one is a common slip.
[[noreturn]] void refuse_unknown(const CLI::App& app, const std::string& word) {
    if (word == "--voro++") throw bad_input("--voro++ must be the first argument: move it to the front");
    std::string name = word.substr(0, word.find('='));
    name.erase(0, name.find_first_not_of('-'));
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& known : option->get_lnames()) names.push_back(known);
    const auto nearest = nearest_word(name, names);
    throw bad_input("unknown option " + in_quotes(word) +
                    (nearest ? ": did you mean --" + *nearest + "?" : ": clvotess --help-all lists all options"));
}

// message: from CLI11; it begins with the name of the option.
[[noreturn]] void refuse_values(CLI::App& app, const std::string& message) {
    std::string name = message.substr(0, message.find_first_of(": "));
    if (!name.starts_with('-')) name.insert(0, "--");
    const CLI::Option* const option = app.get_option_no_throw(name);
    if (!option) throw bad_input(message + ", see clvotess --help");
    if (option->get_items_expected_max() == 0)
        throw bad_input(name + " takes no value: remove = and the text after it");
    const std::size_t given = option->results().size();
    if (given > 1) throw bad_input(name + " is given " + std::to_string(given) + " times: give it once");
    throw bad_input(name + " needs a value: " + std::string(usage_of(name)));
}

Typed split_command_line(int count, const char* const* values) {
    Typed typed;
    CLI::App app;
    app.set_help_flag();
    app.add_option("INPUT", typed.input);
    app.add_option("--random", typed.random);
    app.add_option("--rng-seed", typed.rng_seed);
    app.add_option("--dataset", typed.dataset);
    app.add_option("--frame", typed.frame);
    app.add_option("-o,--output", typed.outputs)->allow_extra_args(false);
    app.add_option("--format", typed.format);
    app.add_option("--want", typed.want);
    app.add_option("--box", typed.box);
    app.add_option("--periodic", typed.periodic)->expected(0, 1)->default_str("xyz");
    app.add_option("--cell", typed.cell);
    app.add_option("--origin", typed.origin);
    app.add_option("--wall", typed.walls)->allow_extra_args(false);
    app.add_option("--wall-sphere", typed.sphere_walls)->allow_extra_args(false);
    app.add_option("--wall-cylinder", typed.cylinder_walls)->allow_extra_args(false);
    app.add_option("--wall-cone", typed.cone_walls)->allow_extra_args(false);
    app.add_option("--outside", typed.outside);
    app.add_option("--min-face", typed.min_face);
    app.add_option("--min-area", typed.min_area);
    app.add_option("--weights", typed.weights);
    app.add_option("--radii", typed.radii);
    app.add_option("--copy", typed.copy);
    app.add_option("--density", typed.density);
    app.add_option("--locate", typed.locate);
    app.add_option("--probe", typed.probe);
    app.add_option("--interpolate", typed.interpolate);
    app.add_option("--values", typed.values);
    app.add_option("--natural", typed.natural);
    app.add_option("--to-grid", typed.grid.method);
    app.add_option("--shape", typed.grid.shape);
    app.add_option("--project", typed.grid.project);
    app.add_option("-x,--device", typed.device);
    app.add_option("--memory", typed.memory);
    app.add_option("--temporary", typed.temporary);
    app.add_option("-t,--threads", typed.threads);
    app.add_option("-g,--grid-resolution", typed.grid_resolution);
    app.add_option("-k,--k-init", typed.k_init);
    app.add_option("--chunk-size", typed.chunk_size);
    app.add_option("--instructions", typed.instructions);
    app.add_option("--precision", typed.precision);
    app.add_option("--duplicates", typed.duplicates);
    const auto add_flag = [&app](const char* names, bool& flag) { app.add_flag(names, flag)->disable_flag_override(); };
    add_flag("--list-walls", typed.list_walls);
    add_flag("--verify", typed.verify);
    add_flag("--json", typed.json);
    add_flag("-q,--quiet", typed.quiet);
    add_flag("-h,--help", typed.help);
    add_flag("--help-all", typed.help_all);
    add_flag("--man", typed.man);
    add_flag("--version", typed.version);
    app.add_option("--completion", typed.completion);
    add_flag("--list-devices", typed.list_devices);
    app.add_option("--image", typed.picture.image);
    app.add_option("--slice", typed.picture.slice);
    app.add_option("--image-size", typed.picture.size);
    app.add_option("--color", typed.picture.color);
    app.add_option("--colormap", typed.picture.colormap);
    app.add_option("--cut", typed.picture.cut);
    app.add_option("--view", typed.picture.view);
    add_flag("--seeds", typed.picture.seeds);
    try {
        app.parse(count, values);
    } catch (const CLI::ExtrasError&) {
        const auto extras = app.remaining();
        const std::string first = extras.empty() ? "" : extras.front();
        if (first.starts_with('-')) refuse_unknown(app, first);
        throw bad_input("only one INPUT is possible, but " + in_quotes(first) + " is a second: run clvotess for each");
    } catch (const CLI::ArgumentMismatch& error) {
        refuse_values(app, error.what());
    } catch (const CLI::ParseError& error) {
        throw bad_input(std::string(error.what()) + ", see clvotess --help");
    }
    return typed;
}

std::vector<std::string_view> split_at_commas(std::string_view list) {
    std::vector<std::string_view> words;
    for (;;) {
        const auto comma = list.find(',');
        words.push_back(list.substr(0, comma));
        if (comma == std::string_view::npos) return words;
        list.remove_prefix(comma + 1);
    }
}

std::uint64_t whole_number(const char* option, const std::string& text, std::uint64_t largest) {
    const auto value = read_uint64(text);
    if (!value || *value > largest) {
        throw bad_input(std::string(option) + " must be a whole number from 0 to " + std::to_string(largest) +
                        ", not " + in_quotes(text));
    }
    return *value;
}

// Reads a count, also in the form 1e6.
std::uint64_t read_random_count(const std::string& text) {
    constexpr std::uint64_t max = std::numeric_limits<std::int32_t>::max();
    const auto number = read_double(text);
    const bool whole = number && *number >= 0 && *number <= static_cast<double>(max) && *number == std::floor(*number);
    return whole ? static_cast<std::uint64_t>(*number) : whole_number("--random", text, max);
}

// The library checks the upper limit.
void read_count(const char* option, const std::optional<std::string>& text, unsigned& number) {
    constexpr unsigned largest = std::numeric_limits<unsigned>::max();
    if (text) number = static_cast<unsigned>(whole_number(option, *text, largest));
}

votess::Want read_want(const std::string& list) {
    try {
        return votess::want_of(list);
    } catch (const votess::Error& error) {  // "want has ..."
        throw bad_input(std::string("--") + error.what());
    }
}

template <std::size_t count>
std::array<double, count> read_numbers(const char* option, const char* form, const std::string& text) {
    const auto fields = split_at_commas(text);
    if (fields.size() != count) {
        throw bad_input(std::string(option) + " must be " + std::to_string(count) + " numbers " + form + ", not " +
                        in_quotes(text));
    }
    std::array<double, count> numbers{};
    for (std::size_t i = 0; i < count; ++i) {
        const auto number = read_double(fields[i]);
        if (!number) {
            throw bad_input(std::string(option) + " " + in_quotes(text) + ": " + in_quotes(fields[i]) +
                            " is not a number");
        }
        numbers[i] = *number;
    }
    return numbers;
}

votess::Box read_box(const std::string& text) {
    const auto n = read_numbers<6>("--box", "x0,y0,z0,x1,y1,z1", text);
    return {.lower = {n[0], n[1], n[2]}, .upper = {n[3], n[4], n[5]}};
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

votess::Wall read_wall(const std::string& text) {
    const auto n = read_numbers<4>("--wall", "nx,ny,nz,d", text);
    return {.normal = {n[0], n[1], n[2]}, .offset = n[3]};
}

std::size_t read_faces(const char* option, double faces) {
    if (faces >= 0 && faces <= 1e9 && faces == std::floor(faces)) return static_cast<std::size_t>(faces);
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%g", faces);
    throw bad_input(std::string(option) + ": FACES must be a whole number, not " + digits.data());
}

void read_walls(const Typed& typed, std::vector<votess::Wall>& walls) {
    const auto add = [&walls](const std::vector<votess::Wall>& more) {
        walls.insert(walls.end(), more.begin(), more.end());
    };
    for (const std::string& wall : typed.walls) walls.push_back(read_wall(wall));
    for (const std::string& text : typed.sphere_walls) {
        const auto n = read_numbers<5>("--wall-sphere", "x,y,z,r,FACES", text);
        add(votess::sphere_walls({n[0], n[1], n[2]}, n[3], read_faces("--wall-sphere", n[4])));
    }
    for (const std::string& text : typed.cylinder_walls) {
        const auto n = read_numbers<8>("--wall-cylinder", "x,y,z,ax,ay,az,r,FACES", text);
        add(votess::cylinder_walls({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], read_faces("--wall-cylinder", n[7])));
    }
    for (const std::string& text : typed.cone_walls) {
        const auto n = read_numbers<8>("--wall-cone", "x,y,z,ax,ay,az,ANGLE,FACES", text);
        add(votess::cone_walls({n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], read_faces("--wall-cone", n[7])));
    }
}

votess::Outside read_outside(const std::string& word) {
    if (word == "error") return votess::Outside::error;
    if (word == "drop") return votess::Outside::drop;
    throw bad_input("--outside must be error or drop, not " + in_quotes(word));
}

double read_limit(const char* option, const std::string& text) {
    const auto limit = read_double(text);
    if (!limit) throw bad_input(std::string(option) + " must be a number, not " + in_quotes(text));
    return *limit;
}

void read_domain(const Typed& typed, Arguments& arguments) {
    votess::Options& options = arguments.options;
    if (typed.box) options.box = read_box(*typed.box);
    if (typed.periodic) arguments.periodic = read_periodic(typed.periodic->empty() ? "xyz" : *typed.periodic);
    if (typed.cell) {
        if (!typed.box) options.box.reset();
        const auto n = read_numbers<9>("--cell", "ax,ay,az,bx,by,bz,cx,cy,cz", *typed.cell);
        votess::TriclinicBox& cell = options.cell.emplace();
        cell.a = {n[0], n[1], n[2]};
        cell.b = {n[3], n[4], n[5]};
        cell.c = {n[6], n[7], n[8]};
        if (typed.origin) cell.origin = read_numbers<3>("--origin", "x,y,z", *typed.origin);
    } else if (typed.origin) {
        throw bad_input("--origin goes with --cell only: --box has its corners");
    }
    read_walls(typed, options.walls);
    if (!options.walls.empty() && typed.random && !typed.box) options.box.reset();
    if (typed.outside) options.outside = read_outside(*typed.outside);
    if (typed.min_face) options.min_face = read_limit("--min-face", *typed.min_face);
    if (typed.min_area) options.min_area = read_limit("--min-area", *typed.min_area);
}

votess::Precision read_precision(const std::string& word) {
    if (word == "single") return votess::Precision::single;
    if (word == "double") return votess::Precision::double_;
    throw bad_input("--precision must be single or double, not " + in_quotes(word));
}

votess::Duplicates read_duplicates(const std::string& word) {
    if (word == "merge") return votess::Duplicates::merge;
    if (word == "error") return votess::Duplicates::error;
    throw bad_input("--duplicates must be merge or error, not " + in_quotes(word));
}

votess::NaturalMethod read_natural(const std::string& word) {
    if (word == "sibson") return votess::NaturalMethod::sibson;
    if (word == "laplace") return votess::NaturalMethod::laplace;
    throw bad_input("--natural must be sibson or laplace, not " + in_quotes(word));
}

void read_source(const Typed& typed, Arguments& arguments) {
    if (typed.input && typed.random) throw bad_input("give either INPUT or --random N, not both");
    if (!typed.input && !typed.random) {
        throw bad_input("there is no input: give INPUT or --random N, see clvotess --help");
    }
    if (typed.rng_seed && !typed.random) throw bad_input("--rng-seed goes with --random N only");
    if (typed.input) {
        if (typed.input->empty()) throw bad_input("INPUT is empty: give a file, or - for stdin");
        arguments.input = *typed.input;
    }
    if (typed.random && (typed.dataset || typed.frame)) {
        throw bad_input("--dataset and --frame go with INPUT, not with --random");
    }
    if (typed.weights && typed.radii) throw bad_input("give either --weights or --radii, not both");
    const auto add_column = [&](const char* option, const std::string& column) {
        if (typed.random) throw bad_input(std::string(option) + " goes with INPUT, not with --random");
        if (column.empty()) throw bad_input(std::string(option) + " is empty: give the name or number of a column");
        arguments.read.columns.push_back(column);
    };
    if (typed.weights) add_column("--weights", *typed.weights);
    if (typed.radii) add_column("--radii", *typed.radii);
    if (typed.density) add_column("--density", *typed.density);
    arguments.has_radii = typed.radii.has_value();
    arguments.has_weights = typed.weights || typed.radii;
    arguments.has_density = typed.density.has_value();
    if (typed.values)
        for (const std::string_view column : split_at_commas(*typed.values))
            add_column("--values", std::string(column));
    arguments.read.all_columns = typed.copy == "all" && !typed.random;  // else refused below
    if (typed.copy && !arguments.read.all_columns) {
        for (const std::string_view column : split_at_commas(*typed.copy)) add_column("--copy", std::string(column));
    }
    if (typed.dataset) {
        if (typed.dataset->empty()) throw bad_input("--dataset is empty: give the name of the points in the file");
        arguments.read.dataset = *typed.dataset;
    }
    if (typed.frame) {
        arguments.read.frame = whole_number("--frame", *typed.frame, std::numeric_limits<std::uint64_t>::max());
    }
    if (typed.random) {
        arguments.random_count = read_random_count(*typed.random);
        arguments.options.box = votess::Box{.lower = {0, 0, 0}, .upper = {1, 1, 1}};
    }
    if (typed.rng_seed) {
        arguments.rng_seed = whole_number("--rng-seed", *typed.rng_seed, std::numeric_limits<std::uint64_t>::max());
    }
}

void read_outputs(const Typed& typed, Arguments& arguments) {
    arguments.outputs = typed.outputs;
    check_outputs(arguments.outputs, {arguments.input, arguments.probe});
    const bool text = std::any_of(arguments.outputs.begin(), arguments.outputs.end(), is_text_output);
    if (typed.format) {
        if (!text) throw bad_input("--format goes with text output only: add -o FILE.txt, or -o - for stdout");
        arguments.format = TextFormat(*typed.format);
    }
    if ((typed.copy || typed.density) && !typed.picture.image &&
        std::ranges::none_of(arguments.outputs, [](auto& path) { return carries_columns(path) || is_colored(path); })) {
        throw bad_input(
            "--copy and --density need text, .npz, .h5 or .vtu, or --color with .glb or --image: add -o FILE");
    }
    if (typed.want) arguments.wanted = read_want(*typed.want);
    if (text) arguments.format.add_needs(arguments.wanted);
    for (const std::string& path : arguments.outputs) add_output_needs(path, arguments.wanted);
}

// Refuses options of the seeds' cells, because a query computes none.
void refuse_options_of_cells(const Typed& typed, const std::string& by) {
    const bool no_cells = !typed.probe, no_picture = !typed.grid.method;
    const std::pair<const char*, bool> of_cells[] = {{"--format", no_cells && typed.format},
                                                     {"--want", no_cells && typed.want},
                                                     {"--list-walls", no_cells && typed.list_walls},
                                                     {"--min-face", typed.min_face.has_value()},
                                                     {"--min-area", typed.min_area.has_value()},
                                                     {"--copy", typed.copy.has_value()},
                                                     {"--density", typed.density.has_value()},
                                                     {"--image", no_picture && typed.picture.image},
                                                     {"--slice", typed.picture.slice.has_value()},
                                                     {"--image-size", typed.picture.size.has_value()},
                                                     {"--cut", typed.picture.cut.has_value()},
                                                     {"--view", typed.picture.view.has_value()},
                                                     {"--seeds", typed.picture.seeds},
                                                     {"--color", typed.picture.color.has_value()},
                                                     {"--colormap", no_picture && typed.picture.colormap},
                                                     {"--precision", typed.precision.has_value()},
                                                     {"--k-init", typed.k_init.has_value()},
                                                     {"--chunk-size", typed.chunk_size.has_value()},
                                                     {"--verify", typed.verify}};
    for (const auto& [option, given] : of_cells)
        if (given)
            throw bad_input(std::string(option) + " is for cells of the points, but " + by +
                            " computes none: leave it out");
}

void read_queries(const Typed& typed, Arguments& arguments) {
    if (typed.locate.has_value() + typed.probe.has_value() + typed.interpolate.has_value() +
            typed.grid.method.has_value() >
        1)
        throw bad_input("give one of --locate, --probe, --interpolate and --to-grid, not several");
    const std::string option = typed.probe         ? "--probe"
                               : typed.locate      ? "--locate"
                               : typed.interpolate ? "--interpolate"
                                                   : "--to-grid";
    refuse_options_of_cells(typed, option);
    if (typed.grid.method) {
        arguments.outputs = typed.outputs;
        arguments.to_grid = read_grid(typed.grid, typed.values.has_value());
        arguments.picture = read_picture(typed.picture, arguments.input, arguments.outputs);
        arguments.coloring = read_coloring(typed.picture);
        check_grid(arguments);
        return;
    }
    std::string& queries = typed.probe ? arguments.probe : typed.locate ? arguments.locate : arguments.interpolate;
    queries = typed.probe ? *typed.probe : typed.locate ? *typed.locate : *typed.interpolate;
    if (queries.empty()) throw bad_input(option + " is empty: give the file of the queries");
    if (queries == "-" && arguments.input == "-")
        throw bad_input("INPUT and " + option + " are both stdin: give one as a file");
    if (typed.locate) {
        arguments.outputs = typed.outputs;
        check_located_outputs(arguments);
        return;
    }
    if (typed.interpolate) {
        if (!typed.values) throw bad_input("--interpolate needs a field: add --values COLUMN");
        arguments.outputs = typed.outputs;
        if (typed.natural) arguments.natural = read_natural(*typed.natural);
        check_interpolated_outputs(arguments);
        return;
    }
    read_outputs(typed, arguments);
    check_probed_outputs(arguments);
    arguments.options.want = arguments.wanted;
    arguments.wanted = votess::implied_want(arguments.options);
}

void read_colors(const Typed& typed, Arguments& arguments) {
    arguments.coloring = read_coloring(typed.picture);
    const bool colored = std::ranges::any_of(arguments.outputs, is_colored);
    if (colored) arguments.coloring.add_needs(arguments.wanted);
    if (!colored && !arguments.picture && (typed.picture.color || typed.picture.colormap)) {
        throw bad_input(std::string(typed.picture.color ? "--color" : "--colormap") +
                        " is for pictures and .glb: add --image FILE.png or -o FILE.glb");
    }
}

std::string answer_to(const Typed& typed) {
    if (typed.help) return usual_help();
    if (typed.help_all) return whole_help();
    if (typed.man) return manual_page();
    if (typed.completion) return completion(*typed.completion);
    if (typed.version) return "clvotess " VOTESS_VERSION_STRING "\n";
    return {};
}

}  // namespace

Arguments read_arguments(int count, const char* const* values) {
    const Typed typed = split_command_line(count, values);
    Arguments arguments;
    arguments.list_devices = typed.list_devices;
    arguments.answer = answer_to(typed);
    if (arguments.list_devices || !arguments.answer.empty()) return arguments;

    arguments.verify = typed.verify;
    arguments.json = typed.json;
    arguments.quiet = typed.quiet;
    votess::Options& options = arguments.options;
    if (typed.device) options.device = *typed.device;
    read_count("--threads", typed.threads, options.threads);
    arguments.threads_given = typed.threads.has_value();
    read_count("--grid-resolution", typed.grid_resolution, options.grid_resolution);
    read_count("--k-init", typed.k_init, options.k_init);
    read_count("--chunk-size", typed.chunk_size, options.chunk_size);
    if (typed.instructions) options.instructions = *typed.instructions;
    if (typed.precision) options.precision = read_precision(*typed.precision);
    if (typed.duplicates) options.duplicates = read_duplicates(*typed.duplicates);
    options.list_walls = typed.list_walls;
    read_source(typed, arguments);
    read_domain(typed, arguments);
    if (typed.json && std::ranges::count(typed.outputs, "-") > 0)
        throw bad_input("-o - and --json both write to stdout: give -o a file");
    if (typed.natural && !typed.interpolate) throw bad_input("--natural goes with --interpolate QUERIES only");
    if (typed.values && !typed.interpolate && !typed.grid.method)
        throw bad_input("--values goes with --interpolate QUERIES or --to-grid METHOD only");
    if (!typed.grid.method && (typed.grid.shape || typed.grid.project))
        throw bad_input(std::string(typed.grid.shape ? "--shape" : "--project") + " goes with --to-grid METHOD only");
    read_memory(typed.memory, typed.temporary, arguments);
    if (typed.locate || typed.probe || typed.interpolate || typed.grid.method) {
        if (typed.memory)
            throw bad_input("--memory does not work with queries, which need all points in memory: leave it out");
        read_queries(typed, arguments);
        return arguments;
    }
    read_outputs(typed, arguments);
    arguments.picture = read_picture(typed.picture, arguments.input, arguments.outputs);
    read_colors(typed, arguments);
    if (arguments.picture) {
        arguments.picture->options.threads = options.threads;
    }

    options.want = arguments.wanted;
    votess::Options to_write = options;
    to_write.min_face = to_write.min_area = 0;  // they imply areas, which a file holds only by --want
    arguments.wanted = votess::implied_want(to_write);
    options.want.volumes |= arguments.has_density;
    if (arguments.verify) options.want.neighbors = options.want.volumes = options.want.counts = true;
    if (arguments.memory > 0) check_streamed(arguments);
    return arguments;
}

}  // namespace clvotess
