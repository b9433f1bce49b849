#include "gpu/gpu_frames.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <sstream>

#include "host.hpp"
#include "measure.hpp"
#include "system/machine.hpp"

namespace bench {
namespace {

using votess::vulkan::Cell;
using votess::vulkan::Header;
using votess::vulkan::Plan;

constexpr double volume_error = 1e-5;
constexpr std::uint32_t entries_each = 20;
using votess::vulkan::Timestamps;

struct Buffers {
    host::Buffer seeds, workspace, header, cells, indices, geometry, shifts, weights;

    Buffers(const host::Device& device, const votess::vulkan::BufferSizes& sizes) {
        const auto make = [&](VkDeviceSize bytes) {
            return bytes == 0 ? host::Buffer()
                              : host::Buffer(device, bytes, votess::vulkan::buffer_usage, host::Place::device);
        };
        seeds = make(sizes.seeds);
        workspace = make(sizes.workspace);
        header = make(sizes.header);
        cells = make(sizes.cells);
        indices = make(sizes.indices);
        geometry = make(sizes.geometry);
        shifts = make(sizes.shifts);
        weights = make(sizes.weights);
    }
    [[nodiscard]] votess::vulkan::Buffers ranges() const {
        return {.seeds = {seeds.get()},
                .workspace = {workspace.get()},
                .header = {header.get()},
                .cells = {cells.get()},
                .indices = {indices.get()},
                .geometry = {geometry.get()},
                .areas = {},
                .shifts = {shifts.get()},
                .weights = {weights.get()}};
    }
    [[nodiscard]] std::uint64_t bytes() const {
        std::uint64_t sum = 0;
        for (const host::Buffer* b : {&seeds, &workspace, &header, &cells, &indices, &geometry, &shifts, &weights})
            sum += b->bytes();
        return sum;
    }
};

// An input as a frame has it.
struct Seeds {
    std::vector<float> points, weights;

    explicit Seeds(const Input& input)
        : points(input.points.begin(), input.points.end()), weights(input.weights.begin(), input.weights.end()) {
        for (const double radius : input.radii) weights.push_back(static_cast<float>(radius * radius));
    }
};

votess::vulkan::PlanOptions plan_options(const Input& input, const Seeds& seeds, const FrameRow& row) {
    votess::vulkan::PlanOptions options;
    options.max_seeds = static_cast<std::uint32_t>(input.size());
    if (input.cell) {
        options.cell = input.cell;
    } else {
        options.box = input.box;
        options.periodic = input.periodic;
    }
    if (!seeds.weights.empty()) {
        const auto [least, largest] = std::ranges::minmax(seeds.weights);
        options.weights = {.least = least, .largest = largest};
    }
    options.walls = input.walls;
    options.neighbors = row.rows;
    options.geometry = row.geometry;
    options.max_entries = entries_each * options.max_seeds;
    return options;
}

template <class T>
std::vector<T> read(const host::Device& device, const host::Buffer& buffer) {
    const std::vector<std::byte> bytes = host::download(device, buffer.get(), buffer.bytes());
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
}

void compare(FrameRow& row, const host::Device& device, const Buffers& buffers, const Input& input,
             const Seeds& seeds) {
    votess::Options options = input.options();
    const std::vector<double> weights(seeds.weights.begin(), seeds.weights.end());
    options.radii = {};
    options.weights = weights;
    options.outside = votess::Outside::drop;  // as frames do
    options.device = "cpu";
    const votess::Tessellation t = votess::tessellate(std::span<const float>(seeds.points), options);
    const auto cells = read<Cell>(device, buffers.cells);
    const auto geometry = row.geometry ? read<float>(device, buffers.geometry) : std::vector<float>();
    const auto indices = row.rows ? read<std::int32_t>(device, buffers.indices) : std::vector<std::int32_t>();
    row.check = "= CPU";
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (cells[i].status != static_cast<std::uint32_t>(votess::CellStatus::certified)) continue;
        const double volume = t.volumes()[i];
        const auto expected = t.neighbors(i);
        const bool same = !row.rows || (cells[i].row_length == expected.size() &&
                                        std::equal(expected.begin(), expected.end(),
                                                   indices.begin() + static_cast<std::ptrdiff_t>(cells[i].row_begin)));
        const bool full = !row.geometry || std::abs(double{geometry[4 * i + 3]} - volume) <= volume_error * volume;
        if (same && full) continue;
        row.check = "WRONG: cell " + std::to_string(i);
        row.wrong = true;
        return;
    }
}

}  // namespace

Frames::Frames(const std::string& device_name)
    : device_(std::make_unique<host::Device>(device_name, votess::vulkan::requirements)) {}
Frames::~Frames() = default;

void Frames::measure(FrameRow& row, const Input& input, int repeats, bool to_compare) const {
    const host::Device& device = *device_;
    const Seeds seeds(input);
    const votess::vulkan::PlanOptions options = plan_options(input, seeds, row);
    const Plan plan(device.for_votess(), options);
    const Buffers buffers(device, plan.sizes());
    row.device_bytes = buffers.bytes();
    host::upload(device, std::as_bytes(std::span(seeds.points)), buffers.seeds.get());
    if (!seeds.weights.empty()) host::upload(device, std::as_bytes(std::span(seeds.weights)), buffers.weights.get());
    const votess::vulkan::Frame frame = plan.frame(buffers.ranges());

    const host::Owned<VkQueryPool> times = host::make_timestamps(device, Timestamps::slots);
    for (int repeat = -1; repeat < repeats; ++repeat) {
        const Stopwatch stopwatch;
        host::run_once(device, [&](VkCommandBuffer commands) {
            if (times.get()) vkCmdResetQueryPool(commands, times.get(), 0, Timestamps::slots);
            frame.record(commands, {.count = options.max_seeds, .timestamps = {times.get(), 0}});
        });
        const double seconds = stopwatch.seconds();
        if (repeat < 0) {
            row.first_seconds = seconds;
            continue;
        }
        row.seconds.push_back(seconds);
        const std::vector<double> at = host::seconds_of(device, times.get(), Timestamps::slots);
        std::array<double, 4> stages{};
        for (std::size_t s = 0; s < stages.size() && s + 1 < at.size(); ++s) stages[s] = at[s + 1] - at[s];
        row.stages.push_back(stages);
    }
    const auto header = read<Header>(device, buffers.header).at(0);
    row.unresolved = header.unresolved;
    row.check = "not compared";
    if (to_compare) compare(row, device, buffers, input, seeds);
    if (header.entries > options.max_entries) {
        row.check = "WRONG: rows need more room than was given";
        row.wrong = true;
    }
}

void print_frames_head() {
    std::printf(
        "\nRecorded frames, seeds and results on the device: million cells per second by the time from submission to "
        "the\nend, then all seeds or cells by the device's time of a stage. full: neighbors, volumes and centroids; "
        "geometry:\nthe last two. Left: cells left to resolve(). MiB: buffers on the device.\n\n%-10s %9s %-9s %-10s "
        "%8s %8s  "
        "%8s %8s %9s %8s %9s %7s  check\n",
        "input", "n", "want", "kernel", "best", "median", "upload", "sort", "hierarchy", "cells", "left", "MiB");
    std::fflush(stdout);
}

namespace {

std::vector<double> stage_of(const FrameRow& row, std::size_t stage) {
    std::vector<double> seconds;
    for (const auto& each : row.stages) seconds.push_back(each[stage]);
    return seconds;
}

double rate(const FrameRow& row, double seconds) {
    return seconds > 0 ? static_cast<double>(row.n) / seconds / 1e6 : 0;
}

const char* want_of(const FrameRow& row) {
    if (!row.geometry) return "neighbors";
    return row.rows ? "full" : "geometry";
}

}  // namespace

void print(const FrameRow& row) {
    std::printf("%-10s %9zu %-9s %-10s", row.input.c_str(), row.n, want_of(row), row.kernel.c_str());
    if (!row.note.empty()) {
        std::printf("  %s\n", row.note.c_str());
    } else {
        std::printf(" %8.4g %8.4g ", rate(row, *std::min_element(row.seconds.begin(), row.seconds.end())),
                    rate(row, median(row.seconds)));
        for (std::size_t s = 0; s < 4; ++s)
            std::printf(s == 2 ? " %9.4g" : " %8.4g", rate(row, median(stage_of(row, s))));
        std::printf(" %9llu %7.0f  %s\n", static_cast<unsigned long long>(row.unresolved),
                    static_cast<double>(row.device_bytes) / (1024.0 * 1024.0), row.check.c_str());
    }
    std::fflush(stdout);
}

std::string json(const FrameRow& row) {
    std::ostringstream out;
    out.precision(6);
    out << "{\"input\": " << in_quotes(row.input) << ", \"n\": " << row.n << ", \"want\": " << in_quotes(want_of(row))
        << ", \"kernel\": " << in_quotes(row.kernel);
    if (!row.note.empty()) {
        out << ", \"note\": " << in_quotes(row.note) << '}';
        return out.str();
    }
    const auto list = [&](const std::vector<double>& values) {
        out << '[';
        for (std::size_t i = 0; i < values.size(); ++i) out << (i > 0 ? ", " : "") << values[i];
        out << ']';
    };
    out << ", \"check\": " << in_quotes(row.check) << ", \"first_seconds\": " << row.first_seconds << ", \"seconds\": ";
    list(row.seconds);
    constexpr std::array names{"upload", "sort", "hierarchy", "cells"};
    for (std::size_t s = 0; s < names.size(); ++s) {
        out << ", \"" << names[s] << "_seconds\": ";
        list(stage_of(row, s));
    }
    out << ", \"million_cells_per_second\": " << rate(row, median(row.seconds))
        << ", \"unresolved\": " << row.unresolved << ", \"device_bytes\": " << row.device_bytes << '}';
    return out.str();
}

}  // namespace bench
