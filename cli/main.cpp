// clvotess: reads, tessellates, verifies, writes, prints a summary.
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "arguments/arguments.hpp"
#include "core/system.hpp"
#include "failure.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "queries/query_run.hpp"
#include "run/frames.hpp"
#include "run/run.hpp"
#include "stream/stream.hpp"
#include "summary.hpp"
#include "surface/surface_run.hpp"
#include "words.hpp"

namespace clvotess {
namespace {

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
    Summary summary = arguments.memory > 0 ? run_streamed(arguments, run_began) : run_cells(arguments, run_began);
    summary.set_mesh(arguments.mesh_file, arguments.mesh);
    summary.seconds_total = seconds_since(run_began);
    print_summary(summary, arguments);
    const std::string failure = summary.failure();
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
        } else if (!arguments.query.empty()) {
            print(run_query(arguments));
        } else if (!arguments.surface_file.empty()) {
            print(run_on_surface(arguments));
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
