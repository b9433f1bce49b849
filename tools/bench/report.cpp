// The table on stdout and the JSON file.
#include <sys/utsname.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "bench.hpp"

namespace bench {
namespace {

struct Machine {
    std::string cpu = "unknown", system = "unknown", compiler, flags;
    unsigned logical_cores = std::thread::hardware_concurrency();
};

// The value of the first "key<separator>value" line of a file.
std::string value_of(const char* file, std::string_view key, char separator) {
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with(key)) {
            const std::size_t at = line.find(separator);
            if (at != std::string::npos) {
                const std::size_t first = line.find_first_not_of(" \"", at + 1);
                const std::size_t last = line.find_last_not_of(" \"");
                return first == std::string::npos ? "" : line.substr(first, last - first + 1);
            }
        }
    }
    return "";
}

Machine machine() {
    Machine m;
    if (const std::string cpu = value_of("/proc/cpuinfo", "model name", ':'); !cpu.empty()) {
        m.cpu = cpu;
    }
    utsname name{};
    if (uname(&name) == 0) {
        m.system = std::string(name.sysname) + ' ' + name.machine;
        if (const std::string pretty = value_of("/etc/os-release", "PRETTY_NAME", '='); !pretty.empty()) {
            m.system = pretty + ", " + m.system;
        }
    }
#if defined(__clang__)
    m.compiler = __VERSION__;
#else
    m.compiler = std::string("GCC ") + __VERSION__;
#endif
    m.flags = BENCH_FLAGS;
    return m;
}

void write_measurement(std::ostream& out, const Measurement& m, const std::vector<Measurement>& all) {
    out << "{\"input\": " << in_quotes(m.input) << ", \"n\": " << m.n << ", \"want\": " << in_quotes(name_of(m.want))
        << ", \"peer\": " << in_quotes(m.peer) << ", \"threads\": " << m.threads << ", \"seconds\": [";
    for (std::size_t i = 0; i < m.seconds.size(); ++i) {
        out << (i > 0 ? ", " : "") << m.seconds[i];
    }
    out << ']';
    if (m.seconds.empty()) {
        out << ", \"note\": " << in_quotes(m.note) << '}';
        return;
    }
    const double middle = median(m.seconds);
    out << ", \"median\": " << middle << ", \"kcells_per_second\": " << static_cast<double>(m.n) / middle / 1000
        << ", \"mean_neighbors\": " << static_cast<double>(m.answer.links) / static_cast<double>(m.n)
        << ", \"volume_sum\": " << m.answer.volume << ", \"times_votess\": {";
    bool first = true;
    for (const Measurement& v : all) {
        if (v.peer == "votess" && v.input == m.input && v.n == m.n && v.want == m.want && !v.seconds.empty()) {
            out << (first ? "" : ", ") << '"' << v.threads << "\": " << middle / median(v.seconds);
            first = false;
        }
    }
    out << '}';
    for (const Measurement& v : all) {
        if (m.peer.starts_with("votess") && v.peer == "voro++" && v.input == m.input && v.n == m.n &&
            v.want == m.want && !v.seconds.empty()) {
            out << ", \"rate_to_voropp\": " << median(v.seconds) / middle;
        }
    }
    if (m.answer.stats) {
        const votess::Stats& stats = *m.answer.stats;
        out << ", \"device\": " << in_quotes(stats.device) << ", \"stage_seconds\": " << stages_json(m.stages)
            << ", \"fallback_cells\": " << stats.fallback_cells << ", \"exact_cells\": " << stats.exact_cells;
    }
    out << '}';
}

// What a run on a device is made of, and how it compares. The seconds are the medians of the stages.
void print_device(const Measurement& m, const std::vector<Measurement>& group) {
    std::printf("%s, %s, after a warm-up run that compiles its pipelines:\n ", m.peer.c_str(),
                m.answer.stats->device.c_str());
    for (const Stage& stage : stages) {
        std::printf(" %s %.4f", stage.name, median_of(stage, m.stages));
    }
    std::printf(" seconds; %llu cells left to the CPU\n",
                static_cast<unsigned long long>(m.answer.stats->fallback_cells));
    for (const Measurement& v : group) {
        if ((v.peer == "votess" || v.peer == "voro++") && !v.seconds.empty()) {
            const double ratio = median(v.seconds) / median(m.seconds);
            std::printf("  rate of %s : %s, %u thread%s = %.3f (1 : %.2f)\n", m.peer.c_str(), v.peer.c_str(), v.threads,
                        v.threads == 1 ? "" : "s", ratio, 1 / ratio);
        }
    }
}

}  // namespace

std::string in_quotes(std::string_view text) {
    std::ostringstream out;
    out << '"';
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            out << '\\' << c;
        } else if (static_cast<unsigned char>(c) < 0x20) {
            out << "\\u00" << std::hex << std::setw(2) << std::setfill('0') << static_cast<int>(c) << std::dec;
        } else {
            out << c;
        }
    }
    out << '"';
    return out.str();
}

std::string machine_json() {
    const Machine m = machine();
    return "{\"cpu\": " + in_quotes(m.cpu) + ", \"logical_cores\": " + std::to_string(m.logical_cores) +
           ", \"system\": " + in_quotes(m.system) + ", \"compiler\": " + in_quotes(m.compiler) +
           ", \"flags\": " + in_quotes(m.flags) + '}';
}

double median_of(const Stage& stage, const std::vector<votess::StageSeconds>& runs) {
    std::vector<double> seconds;
    for (const votess::StageSeconds& run : runs) {
        seconds.push_back(run.*stage.seconds);
    }
    return median(std::move(seconds));
}

std::string stages_json(const std::vector<votess::StageSeconds>& runs) {
    std::ostringstream out;
    out << std::setprecision(6) << '{';
    for (const Stage& stage : stages) {
        out << (&stage == stages ? "\"" : ", \"") << stage.name << "\": [";
        for (std::size_t i = 0; i < runs.size(); ++i) {
            out << (i > 0 ? ", " : "") << runs[i].*stage.seconds;
        }
        out << ']';
    }
    out << '}';
    return out.str();
}

std::string_view name_of(Want want) {
    return want == Want::full ? "full" : "neighbors";
}

void print_machine() {
    const Machine m = machine();
    std::printf("%s, %u logical cores, %s\n%s, flags:%s\n", m.cpu.c_str(), m.logical_cores, m.system.c_str(),
                m.compiler.c_str(), m.flags.c_str());
}

void print_table(const std::vector<Measurement>& group) {
    if (group.empty()) {
        return;
    }
    const Measurement& head = group.front();
    int name_width = 8;
    for (const Measurement& m : group) {
        name_width = std::max(name_width, static_cast<int>(m.peer.size()));
    }
    std::printf("\n%s, n = %zu, %s\n%-*s %7s %11s %10s %15s", head.input.c_str(), head.n,
                std::string(name_of(head.want)).c_str(), name_width, "", "threads", "seconds", "kcells/s",
                "neighbors/cell");
    for (const Measurement& v : group) {
        if (v.peer == "votess") {
            const std::string title = "votess(" + std::to_string(v.threads) + ")";
            std::printf("  time / %s", title.c_str());
        }
    }
    std::printf("\n");
    for (const Measurement& m : group) {
        std::printf("%-*s %7u ", name_width, m.peer.c_str(), m.threads);
        if (m.seconds.empty()) {
            std::printf(" %s\n", m.note.c_str());
            continue;
        }
        const double middle = median(m.seconds);
        std::printf("%11.4f %10.1f %14.3f%s", middle, static_cast<double>(m.n) / middle / 1000,
                    static_cast<double>(m.answer.links) / static_cast<double>(m.n), m.bounded ? " " : "*");
        for (const Measurement& v : group) {
            if (v.peer == "votess" && !v.seconds.empty()) {
                const int width = 9 + static_cast<int>(std::to_string(v.threads).size()) + 6;
                std::printf("  %*.2f", width, middle / median(v.seconds));
            }
        }
        std::printf("\n");
    }
    if (std::any_of(group.begin(), group.end(), [](const Measurement& m) { return !m.bounded; })) {
        std::printf("* of the unbounded diagram, without the box\n");
    }
    for (const Measurement& m : group) {
        if (m.peer.starts_with("votess:") && !m.seconds.empty()) {
            print_device(m, group);
        }
    }
}

void write_json(const std::string& file, const std::vector<PeerVersion>& peers,
                const std::vector<Measurement>& measurements) {
    std::ostringstream out;
    out << std::setprecision(std::numeric_limits<double>::max_digits10);
    out << "{\n  \"machine\": " << machine_json() << ",\n  \"versions\": {";
    for (std::size_t i = 0; i < peers.size(); ++i) {
        out << (i > 0 ? ", " : "") << in_quotes(peers[i].name) << ": " << in_quotes(peers[i].version);
    }
    out << "},\n  \"measurements\": [";
    for (std::size_t i = 0; i < measurements.size(); ++i) {
        out << (i > 0 ? ",\n    " : "\n    ");
        write_measurement(out, measurements[i], measurements);
    }
    out << "\n  ]\n}\n";
    write_whole(file, out.str());
}

void write_whole(const std::string& file, const std::string& text) {
    const std::string temporary = file + ".part";
    std::ofstream stream(temporary);
    stream << text;
    stream.close();
    std::error_code error;
    if (stream.fail() || (std::filesystem::rename(temporary, file, error), error)) {
        std::filesystem::remove(temporary, error);
        throw std::runtime_error("cannot write " + file);
    }
}

}  // namespace bench
