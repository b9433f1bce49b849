// clvotess: reads, tessellates, verifies, writes, prints a summary.
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/fit.hpp>
#include <votess/votess.hpp>

#include "arguments/arguments.hpp"
#include "arguments/carried.hpp"
#include "arguments/only.hpp"
#include "core/system.hpp"
#include "domain.hpp"
#include "failure.hpp"
#include "files/output_file.hpp"
#include "frames/frames.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "queries/point_queries.hpp"
#include "queries/to_grid.hpp"
#include "read/input.hpp"
#include "stream/stream.hpp"
#include "summary.hpp"
#include "words.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

using Clock = Progress::Clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

void print(const std::string& text) {
    errno = 0;
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
        if (errno == EPIPE) throw Interrupted(votess::system::closed_pipe);
        throw runtime_failure(std::string("cannot write to stdout: ") + std::strerror(errno));
    }
}

std::string json_devices() {
    std::string text;
    for (const votess::DeviceInfo& device : votess::devices())
        text += std::string(text.empty() ? "[" : ", ") + "{\"device\": " + json_string(device.id) +
                ", \"name\": " + json_string(device.name) + ", \"description\": " + json_string(device.description) +
                "}";
    return text + "]\n";
}

void print_devices() {
    std::vector<votess::DeviceInfo> rows = votess::devices();
    rows.insert(rows.begin(), {"device", "name", "description"});
    std::size_t id_width = 0, name_width = 0;
    for (const votess::DeviceInfo& row : rows) {
        id_width = std::max(id_width, row.id.size());
        name_width = std::max(name_width, row.name.size());
    }
    std::string text;
    for (votess::DeviceInfo& row : rows) {
        row.id.resize(id_width, ' ');
        row.name.resize(name_width, ' ');
        text += row.id + "  " + row.name + "  " + row.description + "\n";
    }
    print(text);
}

votess::Tessellation tessellate(const Input& input, votess::Options options, bool quiet, Clock::time_point run_began) {
    Progress progress(!quiet, run_began);
    return run_stoppable(progress, [&](const votess::ProgressCallback& callback) {
        options.progress = callback;
        return votess::tessellate(std::span<const double>(input.points), options);
    });
}

votess::VolumeFit fit_volumes(const Input& input, const Arguments& arguments, votess::Options options,
                              Clock::time_point run_began) {
    Progress progress(!arguments.quiet, run_began);
    return run_stoppable(progress, [&](const votess::ProgressCallback& callback) {
        options.progress = callback;
        return votess::fit_volumes(input.points, targets_of(arguments, input), options, arguments.fit);
    });
}

void print_summary(const Summary& summary, const Arguments& arguments) {
    if (arguments.json) {
        print(json_summary(summary));
    } else if (!arguments.quiet) {
        bool stdout_taken = false;
        for (const std::string& path : arguments.outputs) stdout_taken |= path == "-";
        if (stdout_taken) {
            std::fputs(plain_summary(summary).c_str(), stderr);
        } else {
            print(plain_summary(summary));
        }
    }
}

int run(Arguments& arguments) {
    const auto run_began = Clock::now();
    if (arguments.points_alone) {
        write_points(arguments);
        return exit_code::done;
    }
    if (arguments.memory > 0 || arguments.frames) {
        Summary summary = arguments.frames ? run_frames(arguments, run_began) : run_streamed(arguments, run_began);
        summary.set_mesh(arguments.mesh_file, arguments.mesh);
        summary.seconds_total = seconds_since(run_began);
        print_summary(summary, arguments);
        if (!summary.failure().empty()) throw Failure(exit_code::verification_failed, summary.failure());
        return exit_code::done;
    }
    Summary summary;
    summary.set_mesh(arguments.mesh_file, arguments.mesh);
    Input input = arguments.random_count ? random_points(*arguments.random_count, arguments.rng_seed, arguments.read)
                                         : read_input(arguments.input, arguments.read);
    summary.seconds_read = seconds_since(run_began);
    drop_upper_walls(arguments, input);

    votess::Options options = arguments.options;
    complete_columns(arguments, input);
    take_weights(arguments, input, options);
    std::vector<InputColumn> carried = take_carried(arguments, input);
    arguments.coloring.check(carried, input.planar());
    if (arguments.picture) check_picture(*arguments.picture, input.planar());
    summary.input_note = input.note;
    choose_dimensions(input, options);
    summary.set_dimensions(options.planar, arguments.read.dimensions);
    const DomainFrom domain_from = choose_domain(input.domain, arguments.periodic, options, arguments.hull);
    check_corner(input, options, domain_from);
    if (arguments.hull) {
        Progress progress(!arguments.quiet, run_began);
        run_stoppable(progress, [&](const votess::ProgressCallback& callback) {
            options.progress = callback;
            set_hull(input.points, options);
            options.progress = {};
            return 0;
        });
    }
    std::vector<std::int64_t> only;
    if (!arguments.only.empty()) options.only = only = read_only(arguments.only, input.size());
    // Faces for a picture add walls to the rows. An output without --list-walls then needs a second run.
    const bool once = !arguments.picture || options.list_walls || arguments.outputs.empty() || options.mesh;
    votess::Options for_picture = options;
    if (arguments.picture) {
        for_picture.want.faces = !options.mesh;
        arguments.coloring.add_needs(for_picture.want);
    }
    votess::VolumeFit fit;
    if (arguments.has_volumes) {
        fit = fit_volumes(input, arguments, once ? for_picture : options, run_began);
        for_picture.weights = fit.weights;
        for_picture.radii = {};
        summary.fit = {fit.steps, fit.residual};
    }
    const votess::Tessellation tessellation =
        arguments.has_volumes ? fit.tessellation
                              : tessellate(input, once ? for_picture : options, arguments.quiet, run_began);
    fill_weights(arguments, fit.weights, carried);
    std::vector<double> masses = masses_of(arguments, input);
    merge_masses(tessellation.duplicate_of(), masses);
    fill_density(arguments, masses, tessellation.volumes(), carried);
    const std::optional<votess::AlphaComplex> alpha = run_watched(arguments.quiet, run_began, [&] {
        fill_zones(arguments, input, tessellation, carried);
        const std::int32_t n = arguments.alpha;
        if (n == 0) return std::optional<votess::AlphaComplex>();
        const auto& periodic = tessellation.periodic();
        std::array<std::int32_t, 3> copies{n, n, options.planar ? 1 : n};
        const bool any = periodic != std::array<bool, 3>{};
        for (std::size_t k = 0; k < 3 && any; ++k)
            if (!periodic[k]) copies[k] = 1;
        return std::optional(votess::alpha_complex(tessellation, input.points, copies));
    });
    summary.stats = tessellation.stats();
    summary.domain = domain_text(tessellation, domain_from);
    summary.domain_json = domain_json(tessellation, domain_from);
    summary.has_volumes = arguments.wanted.volumes;

    if (arguments.verify)
        summary.verified =
            run_watched(arguments.quiet, run_began, [&] { return votess::verify(tessellation, input.points); });
    const std::string failure = summary.failure();

    if (failure.empty()) {
        const auto write_began = Clock::now();
        std::string png;
        if (arguments.picture) {
            png = draw_picture(*arguments.picture, arguments.coloring, input,
                               once ? tessellation : tessellate(input, for_picture, arguments.quiet, run_began),
                               carried, arguments.gap);
        }
        const InterruptGuard guard;
        std::optional<OutputFile> image;
        if (arguments.picture) {
            image.emplace(arguments.picture->file).write(png);
            image->finish();
        }
        const std::vector<std::int64_t> all_ids = input.ids;
        std::span<const double> radii = options.radii;
        InputColumn radii_of_rows;
        if (options.only) {
            input = points_of(input, only);
            for (InputColumn& column : carried) column = rows_of(column, only);
            if (!radii.empty())
                radii = (radii_of_rows = rows_of({"radii", 1, {radii.begin(), radii.end()}}, only)).values;
        }
        write_outputs(arguments.outputs,
                      {input, tessellation, arguments.wanted, arguments.format, radii, domain_from, carried,
                       arguments.coloring, !arguments.quiet, options.threads, FramePlace::alone, arguments.has_radii,
                       all_ids, arguments.gap, alpha ? &*alpha : nullptr, arguments.skip_open});
        if (image) image->publish();
        summary.seconds_write = seconds_since(write_began);
    }
    summary.seconds_total = seconds_since(run_began);
    print_summary(summary, arguments);
    if (!failure.empty()) throw Failure(exit_code::verification_failed, failure);
    return exit_code::done;
}

// Prints one line of UTF-8. Names in files and paths may hold other bytes, which become \xNN.
int complain(int code, const std::string& message) {
    std::string line = "clvotess: ";
    const std::string whole = one_line(message);
    for (std::string_view rest = whole; !rest.empty();) {
        const std::size_t length = utf8_length(rest);
        char byte[8];
        std::snprintf(byte, sizeof byte, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(rest[0])));
        line += length > 0 ? rest.substr(0, length) : std::string_view(byte);
        rest.remove_prefix(std::max<std::size_t>(length, 1));
    }
    std::fprintf(stderr, "%s\n", line.c_str());
    return code;
}

int main_inside(int count, const char* const* values) {
    try {
        const bool as_voropp = count > 1 && std::strcmp(values[1], "--voro++") == 0;
        Arguments arguments = as_voropp ? read_voropp_arguments(count - 1, values + 1) : read_arguments(count, values);
        load_mesh(arguments);
        if (!arguments.answer.empty()) {
            print(arguments.answer);
        } else if (arguments.list_devices) {
            if (arguments.json)
                print(json_devices());
            else
                print_devices();
        } else if (!arguments.locate.empty()) {
            print(run_locate(arguments));
        } else if (!arguments.probe.empty()) {
            print(run_probe(arguments));
        } else if (!arguments.interpolate.empty()) {
            print(run_interpolate(arguments));
        } else if (!arguments.trace.empty()) {
            print(run_trace(arguments));
        } else if (arguments.to_grid) {
            print(run_to_grid(arguments));
        } else {
            return run(arguments);
        }
        return exit_code::done;
    } catch (const Failure& failure) {
        return complain(failure.code(), failure.what());
    } catch (const Interrupted& interrupted) {
        // A reader that closes stdout early, such as head, is not an error.
        const int code = exit_code::signal_base + interrupted.signal();
        return interrupted.signal() == votess::system::closed_pipe ? code : complain(code, interrupted.what());
    } catch (const votess::Error& error) {
        return complain(exit_code_of(error.code()), in_words_of_options(error.what()));
    } catch (const std::bad_alloc&) {
        return complain(exit_code::runtime_failure, "out of memory");
    } catch (const std::exception& error) {
        return complain(exit_code::runtime_failure, error.what());
    }
}

}  // namespace
}  // namespace clvotess

int main(int argc, char** argv) {
    const std::vector<std::string> arguments = votess::system::begin_program(argc, argv);
    std::vector<const char*> values;
    for (const std::string& argument : arguments) values.push_back(argument.c_str());
    return clvotess::main_inside(static_cast<int>(values.size()), values.data());
}
