#include "gpu/gpu_table.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string_view>
#include <utility>

#include "bench.hpp"
#if BENCH_FRAMES
#include "gpu/gpu_frames.hpp"
#endif
#include "gpu/gpu_rows.hpp"
#include "measure.hpp"
#include "system/machine.hpp"

namespace bench {
namespace {

constexpr double promised_volume_error = 1e-5;  // of Precision::single

// Resets the peak of resident memory on Linux; elsewhere it stays that of the whole process.
void forget_peak_memory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

// The library reads it when it makes its pipelines.
void choose(const std::string& kernel, const std::string& numbers) {
    ::setenv("VOTESS_VULKAN_KERNEL", kernel.c_str(), 1);
    ::setenv("VOTESS_VULKAN_MEASURE", numbers.c_str(), 1);
}

votess::Options options_for(const GpuTable& table, const Input& input, Want want, const std::string& device) {
    votess::Options options = input.options();
    options.device = device;
    options.threads = table.threads;
    options.want.neighbors = true;
    options.want.volumes = options.want.centroids = want == Want::full;
    return options;
}

// Writes the check of a result into its row.
void compare(GpuRow& row, const votess::Tessellation& mine, const votess::Tessellation& cpu) {
    const auto fail = [&row](const std::string& what) {
        row.check = "WRONG: " + what;
        row.wrong = true;
    };
    row.check = "= CPU";
    for (std::size_t i = 0; i < cpu.size(); ++i) {
        const auto a = mine.neighbors(i), b = cpu.neighbors(i);
        if (!std::equal(a.begin(), a.end(), b.begin(), b.end())) {
            return fail("neighbors of seed " + std::to_string(i));
        }
    }
    if (!std::equal(mine.status().begin(), mine.status().end(), cpu.status().begin(), cpu.status().end())) {
        return fail("status bytes");
    }
    for (std::size_t i = 0; i < cpu.volumes().size(); ++i) {
        const double error = std::abs(mine.volumes()[i] - cpu.volumes()[i]);
        if (!(error <= promised_volume_error * cpu.volumes()[i])) {
            return fail("volume of seed " + std::to_string(i));
        }
        row.volume_error = std::max(row.volume_error, error > 0 ? error / cpu.volumes()[i] : 0.0);
    }
}

void check(GpuRow& row, const GpuTable& table, const Input& input, bool to_compare, const votess::Tessellation& mine) {
    const votess::Stats& stats = mine.stats();
    row.check = "not compared";
    if (to_compare) {
        compare(row, mine, votess::tessellate(input.points, options_for(table, input, row.want, "cpu")));
    } else if (row.want == Want::full &&
               !(std::abs(stats.volume_sum - stats.box_volume) <= promised_volume_error * stats.box_volume)) {
        row.check = "WRONG: the volumes do not fill the box";
        row.wrong = true;
    }
}

// A Tessellator of its own, so that the memory is that of this row.
void measure(GpuRow& row, const GpuTable& table, const Input& input, bool to_compare) {
    votess::Options options = options_for(table, input, row.want, table.device);
    choose(row.kernel, row.numbers);
    ::setenv("VOTESS_VULKAN_LOCAL_SIZE", std::to_string(row.local_size).c_str(), 1);
    votess::Tessellation t;
    {
        forget_peak_memory();
        votess::Tessellator tessellator;
        const Stopwatch first;
        t = tessellator.tessellate(input.points, options);
        row.first_seconds = first.seconds();
        for (int repeat = 0; repeat < table.repeats; ++repeat) {
            t = {};  // not timed, and not in memory beside the next
            const Stopwatch stopwatch;
            t = tessellator.tessellate(input.points, options);
            row.seconds.push_back(stopwatch.seconds());
            row.stages.push_back(t.stats().seconds);
        }
        row.stats = t.stats();
        row.peak_memory = row.stats.peak_memory_bytes;
    }
    check(row, table, input, to_compare, t);
}

bool has_variants(const std::string& input) {
    return input == "uniform" || input == "clustered" || input == "lattice";
}

std::vector<GpuRow> variants_of(const GpuTable& table, const Input& input) {
    const bool varies = has_variants(input.name);
    std::vector<GpuRow> rows;
    for (const std::string& want : table.wants) {
        const std::size_t first = rows.size();
        for (const std::string& kernel : table.kernels) {
            for (const unsigned local_size : table.local_sizes) {
                for (const std::string& numbers : table.numbers) {
                    GpuRow row;
                    row.input = input.name;
                    row.n = input.size();
                    row.want = want == "full" ? Want::full : Want::neighbors;
                    row.kernel = kernel;
                    row.local_size = local_size;
                    const bool measured = row.want == Want::full && varies;  // lists have no numbers
                    row.numbers = measured ? numbers : "automatic";
                    rows.push_back(std::move(row));
                    // The size of work-groups says nothing about the second ones.
                    if (!measured || local_size != table.local_sizes.front()) break;
                }
            }
        }
        if (!varies) rows.resize(first + 1);
    }
    return rows;
}

// Opens the device. Throws votess::Error, which names the devices of the machine.
votess::DeviceInfo open(const std::string& device) {
    votess::Options options;
    options.device = device;
    options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
    const std::array<double, 3> seed{0.5, 0.5, 0.5};
    const votess::Tessellation t = votess::tessellate(std::span<const double>(seed), options);
    return describe(device, t.stats().device);
}

// Measures a row of n seeds unless that would take too long by the pace so far, in seconds a seed.
template <class AnyRow, class Measure>
void attempt(AnyRow& row, std::size_t n, double& pace, double limit, Measure measure) {
    if (pace * static_cast<double>(n) > limit) {
        row.note = "left out: over --limit";
        return;
    }
    try {
        measure(row);
        pace = std::max(pace, median(row.seconds) / static_cast<double>(n));
    } catch (const votess::Error& error) {
        // A device that cannot run a kernel is not a failure.
        row.wrong = error.code() != votess::ErrorCode::unsupported;
        row.note = (row.wrong ? "failed: " : "left out: ") + std::string(error.what());
    } catch (const std::exception& error) {
        row.note = std::string("failed: ") + error.what();
        row.wrong = true;
    }
}

// Ends the process when a row takes far too long, for example when a device hangs. Earlier rows are on disk.
class Watch {
public:
    explicit Watch(const GpuTable& table) {
        std::signal(SIGALRM, [](int) {
            constexpr std::string_view text =
                "\nstopped: that row did not come to an end. The rows before it are in the JSON file.\n";
            static_cast<void>(!::write(STDERR_FILENO, text.data(), text.size()));
            ::_exit(1);
        });
        ::alarm(static_cast<unsigned>((table.repeats + 2) * table.limit + 60));
    }
    ~Watch() { ::alarm(0); }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
};

// Writes the rows to disk after every row, and before it, so that a row that ends the process is named.
class Report {
public:
    Report(const GpuTable& table, votess::DeviceInfo device)
        : table_(table),
          device_(std::move(device)),
          file_(table.json.empty() ? gpu_file_name(device_.name) : table.json) {
        save();  // fails now rather than after an hour
    }

    // Measures a row of either table unless that would take too long by the pace so far, in seconds a seed.
    template <class AnyRow, class Measure>
    void add(std::vector<AnyRow>& rows, AnyRow row, double& pace, Measure measure) {
        rows.push_back(row);
        rows.back().note = "did not finish";
        save();
        {
            const Watch watch(table_);
            attempt(row, row.n, pace, table_.limit, measure);
        }
        good_ = good_ && !row.wrong;
        print(row);
        rows.back() = std::move(row);
        save();
    }

    std::vector<GpuRow> rows;
#if BENCH_FRAMES
    std::vector<FrameRow> frames;
#endif
    [[nodiscard]] bool good() const {
        return good_;
    }
    [[nodiscard]] const std::string& file() const {
        return file_;
    }

private:
    void save() const {
        std::vector<std::string> of_frames;
#if BENCH_FRAMES
        for (const FrameRow& row : frames) of_frames.push_back(bench::json(row));
#endif
        write(file_, device_, table_.threads, rows, of_frames);
    }

    const GpuTable& table_;
    votess::DeviceInfo device_;
    std::string file_;
    bool good_ = true;
};

using Paces = std::map<std::string, double>;  // seconds per seed, by kind of row

void measure_engine(Report& report, const GpuTable& table, const Input& input, Paces& paces) {
    for (const GpuRow& row : variants_of(table, input)) {
        double& pace = paces[input.name + " " + std::string(name_of(row.want)) + row.kernel];
        report.add(report.rows, row, pace, [&](GpuRow& measured) {
            measure(measured, table, input, static_cast<double>(measured.n) <= table.check_limit);
        });
    }
}

#if BENCH_FRAMES
void measure_frames(Report& report, const GpuTable& table, const Frames& frames, const Input& input, Paces& paces) {
    constexpr std::array<std::pair<bool, bool>, 3> wants{{{true, false}, {false, true}, {true, true}}};
    for (const auto& [rows, geometry] : wants)
        for (const std::string& kernel : table.kernels) {
            FrameRow row;
            row.input = input.name;
            row.n = input.size();
            row.rows = rows;
            row.geometry = geometry;
            row.kernel = kernel;
            report.add(report.frames, row, paces[input.name + " frame " + kernel], [&](FrameRow& measured) {
                choose(kernel, "automatic");
                frames.measure(measured, input, table.repeats, static_cast<double>(input.size()) <= table.check_limit);
            });
        }
}
#endif

}  // namespace

int run_gpu_table(const GpuTable& table) {
    const votess::DeviceInfo device = open(table.device);
    std::printf("device %s: %s\n%s\n", device.id.c_str(), device.name.c_str(), device.description.c_str());
    print_machine();
    Report report(table, device);
#if BENCH_FRAMES
    const Frames frames(device.name);
#endif
    Paces paces;
    // The small ones of all inputs first. Files have a size of their own.
    for (std::size_t step = 0; step < table.sizes.size(); ++step) {
        std::vector<Input> inputs;
        for (const std::string& name : table.inputs)
            if (!is_file(name) || step == 0)
                inputs.push_back(make_input(name, is_file(name) ? 0 : table.sizes[step], table.rng_seed));
        print_head(table);
        for (const Input& input : inputs) measure_engine(report, table, input, paces);
#if BENCH_FRAMES
        print_frames_head();
        for (const Input& input : inputs) measure_frames(report, table, frames, input, paces);
#endif
    }
    print_best(report.rows);
    std::printf("\nwritten to %s\n", report.file().c_str());
    return report.good() ? 0 : 1;
}

}  // namespace bench
