// The only place that reads options.
#include "input/settle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "core/arithmetic.hpp"
#include "core/errors.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "input/each_option.hpp"
#include "input/option_name.hpp"
#include "polytope/cell_kernels.hpp"

namespace votess {
namespace {

constexpr std::size_t max_index_digits = 6;

bool names_device(const std::string& device) {
    if (device == "auto" || device == "cpu" || device == "gpu" || device == "lavapipe") return true;
    return !device.empty() && device.size() <= max_index_digits &&
           std::all_of(device.begin(), device.end(), [](char c) { return c >= '0' && c <= '9'; });
}

template <class Value>
void check_option(const std::string& /*name*/, const Value& /*value*/, decltype(anything)) {}

template <class Number>
void check_option(const std::string& name, Number value, UpTo<Number> allowed) {
    if (value >= 0 && value <= allowed.max && std::isfinite(static_cast<double>(value))) return;
    const auto text = [](Number n) {
        if constexpr (std::is_integral_v<Number>)
            return std::to_string(n);
        else
            return number(n);
    };
    refuse(name + " = " + text(value) + ": give " +
           (std::isinf(static_cast<double>(allowed.max)) ? "a finite number from 0 up" : "0 to " + text(allowed.max)));
}

template <class Enum, std::size_t count>
void check_option(const std::string& name, Enum value, const std::array<const char*, count>& allowed) {
    const auto index = static_cast<std::int64_t>(value);
    if (index >= 0 && index < static_cast<std::int64_t>(count)) return;
    std::string known;
    for (std::size_t i = 0; i < count; ++i)
        known += (i == 0 ? "" : " or ") + std::to_string(i) + " (" + allowed[i] + ")";
    refuse(name + " = " + std::to_string(index) + ": give " + known);
}

void check_instructions(const std::string& name) {
    if (name.empty() || cpu::find_kernels(name) != nullptr) return;
    if (name != "avx512" && name != "avx2")
        refuse("Options::instructions is " + in_quotes(name) + ", which are unknown: give baseline, avx2 or avx512");
    std::string available;
    for (const cpu::Kernels* kernels : cpu::supported_kernels())
        available += (available.empty() ? "" : ", ") + std::string(kernels->name);
    throw Error(ErrorCode::unsupported, "Options::instructions = " + name + ": this processor has only " + available);
}

void check_values(const Options& options) {
    each_option(
        [&](auto name, auto member, auto, auto allowed) { check_option(option(name), options.*member, allowed); });
    check_instructions(options.instructions);
    if (options.only && (options.min_face > 0 || options.min_area > 0))
        refuse("Options::min_face and Options::min_area need the faces of all cells: leave them out, or Options::only");
    if (!names_device(options.device))
        refuse("Options::device is " + in_quotes(options.device) +
               ", which is unknown: give auto, cpu, gpu, lavapipe or the index of a device, 0 to 999999");
    if (options.only && options.device != "auto" && options.device != "cpu")
        throw Error(ErrorCode::unsupported,
                    "Options::device = " + options.device +
                        ": the CPU makes the cells of some seeds, give cpu or auto with Options::only");
}

// Calls use(option, value) for each option and the value of a run that has it, except weights and subset.
void for_values(auto& options, auto& run, const auto& use) {
    use(options.box, run.region.box);
    use(options.periodic, run.region.periodic);
    use(options.cell, run.region.cell);
    use(options.walls, run.region.walls);
    use(options.mesh, run.region.mesh);
    use(options.outside, run.region.outside);
    use(options.planar, run.region.planar);
    use(options.want, run.want);
    use(options.list_walls, run.list_walls);
    use(options.min_face, run.min_face);
    use(options.min_area, run.min_area);
    use(options.duplicates, run.duplicates);
    use(options.device, run.device);
    use(options.precision, run.precision);
    use(options.threads, run.threads);
    use(options.grid_resolution, run.grid_resolution);
    use(options.k_init, run.k_init);
    use(options.chunk_size, run.chunk_size);
    use(options.follow, run.follow);
    use(options.instructions, run.instructions);
    use(options.progress, run.progress);
    use(options.log, run.log);
}

// Refuses sides so different that cells would leave the range of double in which they are measured.
void check_sides(const Box& box, const Want& want, std::size_t dimensions) {
    constexpr double thinnest = 0x1p-500;
    if (!want.volumes && !want.centroids && !want.areas && !want.surfaces && !want.radii) return;
    double shortest = std::numeric_limits<double>::infinity(), longest = 0;
    for (std::size_t k = 0; k < dimensions; ++k) {
        const double side = box.upper[k] - box.lower[k];
        if (std::isfinite(side)) shortest = std::min(shortest, side), longest = std::max(longest, side);
    }
    if (shortest < thinnest * longest)
        refuse(
            "Options::box: its sides are from " + number(shortest) + " to " + number(longest) +
            ", too different to measure cells: give a box whose sides differ by less than 1e150, or want no measures");
}

void take_values(const Options& options, Settled& run) {
    for_values(options, run, [](const auto& option, auto& value) { value = option; });
}

}  // namespace

void throw_no_threads(unsigned requested, unsigned given, const char* name) {
    throw Error(ErrorCode::no_threads, (name == nullptr ? option("threads") : name) + " = " +
                                           std::to_string(requested) + ", but the system gives only " +
                                           std::to_string(given) +
                                           ": request fewer, or raise its limits (ulimit -u, ulimit -v, pids.max of "
                                           "the container)");
}

void check_member(const char* name, unsigned value) {
    const std::string_view member = std::string_view(name).substr(std::string_view(name).rfind(':') + 1);
    each_option([&](std::string_view of, auto, auto, auto allowed) {
        if constexpr (std::is_same_v<decltype(allowed), UpTo<unsigned>>)
            if (of == member) check_option(name, value, allowed);
    });
}

Weights weights_of(std::span<const double> weights, std::span<const double> radii) {
    if (!weights.empty() && !radii.empty())
        refuse(
            "Options::weights and Options::radii are both given: give one of them, weights are the squares of radii");
    const std::span<const double> given = radii.empty() ? weights : radii;
    return {{given.begin(), given.end()}, !radii.empty()};  // read once, see input/snapshot.hpp
}

Region region_of(const Options& options) {
    Settled run;
    take_values(options, run);
    return run.region;
}

Settled settle(const Options& options) {
    check_values(options);
    Settled run;
    take_values(options, run);
    check_region(run.region);
    if (run.region.box) check_sides(*run.region.box, run.want, run.region.planar ? 2 : 3);
    run.weights = weights_of(options.weights, options.radii);
    if (options.only) run.subset.emplace(options.only->begin(), options.only->end());
    imply(run);
    return run;
}

Settled settle(const Points& points, const Options& options) {
    Settled run = settle(options);
    check_shape(points, options.planar);
    run.points = points;
    return run;
}

Options options_of(const Settled& run) {
    Options options;
    for_values(options, run, [](auto& option, const auto& value) { option = value; });
    return options;
}

void check_shape(const Points& points, bool planar) {
    const std::size_t dimensions = planar ? 2 : 3;
    if (points.coordinates() % dimensions != 0) {
        const std::string n = std::to_string(dimensions);
        refuse("points hold " + std::to_string(points.coordinates()) + " coordinates, not a multiple of " + n +
               ": the shape must be (N," + n + ")");
    }
    const std::size_t count = points.coordinates() / dimensions;
    if (count > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        throw Error(ErrorCode::unsupported,
                    std::to_string(count) + " seeds are too many: give at most 2147483647, or stream them");
}

}  // namespace votess
