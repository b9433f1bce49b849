#include "gpu/gpu_rows.hpp"

#include <cctype>
#include <cstdio>
#include <ctime>
#include <iomanip>
#include <map>
#include <sstream>

#include "measure.hpp"
#include "system/machine.hpp"

namespace bench {
namespace {

// No time to speak of: then there is no rate.
bool negligible(const GpuRow& row, double seconds) {
    return seconds < 1e-4 * median(row.seconds);
}

// Three digits, or a dash.
std::string rate_text(const GpuRow& row, double seconds) {
    if (negligible(row, seconds)) {
        return "-";
    }
    const double rate = row.rate(seconds);
    char text[32];
    std::snprintf(text, sizeof text, "%.*f",
                  rate >= 100   ? 0
                  : rate >= 10  ? 1
                  : rate >= 1   ? 2
                  : rate >= 0.1 ? 3
                                : 4,
                  rate);
    return text;
}

void write(std::ostream& out, const GpuRow& row) {
    out << "{\"input\": " << in_quotes(row.input) << ", \"n\": " << row.n
        << ", \"want\": " << in_quotes(name_of(row.want)) << ", \"kernel\": " << in_quotes(row.kernel)
        << ", \"local_size\": " << row.local_size << ", \"numbers\": " << in_quotes(row.numbers);
    if (!row.note.empty()) {
        out << ", \"note\": " << in_quotes(row.note) << '}';
        return;
    }
    const double middle = median(row.seconds);
    out << ", \"check\": " << in_quotes(row.check) << ", \"first_seconds\": " << row.first_seconds
        << ", \"seconds\": [";
    for (std::size_t i = 0; i < row.seconds.size(); ++i) {
        out << (i > 0 ? ", " : "") << row.seconds[i];
    }
    out << "], \"stage_seconds\": " << stages_json(row.stages)
        << ", \"million_cells_per_second\": {\"best\": " << row.rate(row.best())
        << ", \"median\": " << row.rate(middle);
    for (const Stage& stage : stages) {
        const double seconds = median_of(stage, row.stages);
        out << ", \"" << stage.name << "\": ";
        negligible(row, seconds) ? out << "null" : out << row.rate(seconds);
    }
    out << "}, \"fallback_cells\": " << row.stats.fallback_cells << ", \"exact_cells\": " << row.stats.exact_cells
        << ", \"mean_faces\": " << row.stats.mean_faces << ", \"max_volume_error\": ";
    row.want == Want::full&& row.check == "= CPU" ? out << row.volume_error : out << "null";
    out << ", \"peak_memory_bytes\": " << row.peak_memory << '}';
}

// 20250131-1605, local time.
std::string date() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    localtime_r(&now, &parts);
    char text[32];
    std::strftime(text, sizeof text, "%Y%m%d-%H%M", &parts);
    return text;
}

}  // namespace

void print_head(const GpuTable& table) {
    std::printf(
        "\nMillion cells per second after a warm-up run (device, pipelines, buffers): best and median of %d run%s,\n"
        "then all cells by the median seconds of a stage. Left: cells left to the CPU. MiB: peak of resident memory "
        "on\n"
        "the host. full: neighbors, volumes and centroids. Lists are compared with the CPU's up to %.0f seeds.\n\n",
        table.repeats, table.repeats == 1 ? "" : "s", table.check_limit);
    std::printf("%-10s %9s %-9s %-10s %5s %-9s %8s %8s ", "input", "n", "want", "kernel", "local", "numbers", "best",
                "median");
    for (const Stage& stage : stages) {
        std::printf(" %8s", stage.name);
    }
    std::printf(" %9s %7s  %s\n", "left", "MiB", "check");
    std::fflush(stdout);
}

void print(const GpuRow& row) {
    std::printf("%-10s %9zu %-9s %-10s %5u %-9s", row.input.c_str(), row.n, std::string(name_of(row.want)).c_str(),
                row.kernel.c_str(), row.local_size, row.numbers.c_str());
    if (!row.note.empty()) {
        std::printf("  %s\n", row.note.c_str());
    } else {
        std::printf(" %8s %8s ", rate_text(row, row.best()).c_str(), rate_text(row, median(row.seconds)).c_str());
        for (const Stage& stage : stages) {
            std::printf(" %8s", rate_text(row, median_of(stage, row.stages)).c_str());
        }
        std::printf(" %9llu %7.0f  %s\n", static_cast<unsigned long long>(row.stats.fallback_cells),
                    static_cast<double>(row.peak_memory) / (1024.0 * 1024.0), row.check.c_str());
    }
    std::fflush(stdout);
}

void print_best(const std::vector<GpuRow>& rows) {
    std::map<std::string, const GpuRow*> best;
    std::vector<std::string> order;
    for (const GpuRow& row : rows) {
        if (row.seconds.empty()) continue;
        const std::string what = row.input + " " + std::to_string(row.n) + " " + std::string(name_of(row.want));
        const GpuRow*& found = best[what];
        if (found == nullptr) order.push_back(what);
        if (found == nullptr || median(row.seconds) < median(found->seconds)) found = &row;
    }
    std::printf("\nfastest by median:\n");
    for (const std::string& what : order) {
        const GpuRow& row = *best[what];
        std::printf("  %-30s %-10s work-groups of %-4u %-9s %s million cells/s\n", what.c_str(), row.kernel.c_str(),
                    row.local_size, row.numbers.c_str(), rate_text(row, median(row.seconds)).c_str());
    }
}

std::string gpu_file_name(const std::string& device) {
    std::string name;
    for (const char c : device) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
            name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        } else if (!name.empty() && name.back() != '-') {
            name += '-';
        }
    }
    name.erase(name.find_last_not_of('-') + 1);
    return "gpu-" + name + '-' + date() + ".json";
}

void write(const std::string& file, const votess::DeviceInfo& device, unsigned threads, const std::vector<GpuRow>& rows,
           const std::vector<std::string>& frames) {
    std::ostringstream out;
    out << std::setprecision(6) << "{\n  \"device\": {\"id\": " << in_quotes(device.id)
        << ", \"name\": " << in_quotes(device.name) << ", \"description\": " << in_quotes(device.description)
        << "},\n  \"machine\": " << machine_json() << ",\n  \"votess\": " << in_quotes(VOTESS_VERSION_STRING)
        << ",\n  \"threads\": " << threads << ",\n  \"rows\": [";
    for (std::size_t i = 0; i < rows.size(); ++i) {
        out << (i > 0 ? ",\n    " : "\n    ");
        write(out, rows[i]);
    }
    out << "\n  ],\n  \"frames\": [";
    for (std::size_t i = 0; i < frames.size(); ++i) out << (i > 0 ? ",\n    " : "\n    ") << frames[i];
    out << "\n  ]\n}\n";
    write_whole(file, out.str());
}

}  // namespace bench
