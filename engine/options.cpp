#include "options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "cpu/kernels.hpp"
#include "implied_wants.hpp"

namespace votess {
namespace {

constexpr const char* axis_name[3] = {"x", "y", "z"};
constexpr unsigned most_threads = 1024, most_resolution = 1u << 20, most_k_init = 1024;
constexpr std::size_t most_index_digits = 6;

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, message);
}

bool names_device(const std::string& device) {
    if (device == "auto" || device == "cpu" || device == "gpu" || device == "lavapipe") return true;
    return !device.empty() && device.size() <= most_index_digits &&
           std::all_of(device.begin(), device.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Control bytes become question marks, so that a message stays one line.
std::string in_quotes(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return "'" + text + "'";
}

void check_instructions(const std::string& name) {
    if (name.empty() || cpu::find_kernels(name) != nullptr) return;
    if (name != "avx512" && name != "avx2")
        refuse("instructions " + in_quotes(name) + " are not known: give baseline, avx2 or avx512");
    std::string available;
    for (const cpu::Kernels* kernels : cpu::supported_kernels())
        available += (available.empty() ? "" : ", ") + std::string(kernels->name);
    throw Error(ErrorCode::unsupported, "instructions '" + name + "': this processor has only " + available);
}

// Bounds of the seeds, moved out by half of (longest side / cbrt(N)), at least to the next double.
Box default_box(const Box& bounds, std::size_t count) {
    if (count == 0) return {{0, 0, 0}, {1, 1, 1}};
    double longest = 0, largest = 0;
    for (int k = 0; k < 3; ++k) {
        longest = std::max(longest, bounds.upper[k] - bounds.lower[k]);
        largest = std::max({largest, std::abs(bounds.lower[k]), std::abs(bounds.upper[k])});
    }
    double margin = 0.5 * longest / std::cbrt(static_cast<double>(count));
    if (longest == 0) margin = largest == 0 ? 0.5 : 0.5 * largest;
    Box box;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(bounds.lower[k] - margin, std::nextafter(bounds.lower[k], -infinity));
        box.upper[k] = std::max(bounds.upper[k] + margin, std::nextafter(bounds.upper[k], infinity));
        if (!std::isfinite(box.lower[k]) || !std::isfinite(box.upper[k]))
            refuse(std::string("the seeds span ") + axis_name[k] + " from " + number(bounds.lower[k]) + " to " +
                   number(bounds.upper[k]) + ", too near the largest double for a default box: give a box");
    }
    return box;
}

// Power of two that brings the largest coordinate of the domain to order one; 1 when it is ordinary already.
double scale_for(const Box& box) {
    double largest = 0;
    for (int k = 0; k < 3; ++k) largest = std::max({largest, std::abs(box.lower[k]), std::abs(box.upper[k])});
    const int exponent = std::ilogb(largest);
    if (std::abs(exponent) < 64) return 1;
    // 2^1023 is the largest power; a subnormal box of 2^-1074 is brought to 2^-51, which is near enough.
    return std::ldexp(1.0, std::clamp(-exponent, -1021, 1023));
}

void check_scaled(double value, double scale, const std::string& what) {
    if (value * scale / scale != value)
        refuse(what + " = " + number(value) +
               " is too small beside the box to be represented at one scale: move it to 0");
}

}  // namespace

std::string number(double value) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, value).ptr;
    return {text, end};
}

void check_options(const Options& options) {
    if (options.threads > most_threads)
        refuse("threads = " + std::to_string(options.threads) + " is too many: give at most " +
               std::to_string(most_threads) + ", or 0 for all");
    if (options.grid_resolution > most_resolution)
        refuse("grid resolution = " + std::to_string(options.grid_resolution) + " is too fine: give at most " +
               std::to_string(most_resolution) + ", or 0 for automatic");
    if (options.k_init > most_k_init)
        refuse("k_init = " + std::to_string(options.k_init) + " is too many: give at most " +
               std::to_string(most_k_init) + ", or 0 for automatic");
    check_instructions(options.instructions);
    if (!names_device(options.device))
        refuse("device " + in_quotes(options.device) +
               " is not known: give auto, cpu, gpu, lavapipe or the index of a device, 0 to 999999");
    if (options.precision != Precision::single && options.precision != Precision::double_)
        refuse("precision = " + std::to_string(static_cast<int>(options.precision)) + " is neither single nor double");
    if (options.duplicates != Duplicates::merge && options.duplicates != Duplicates::error)
        refuse("duplicates = " + std::to_string(static_cast<int>(options.duplicates)) + " is neither merge nor error");
    if (!(options.min_face >= 0 && std::isfinite(options.min_face)))
        refuse("min_face = " + number(options.min_face) + " is no share of the mean face: give a number from 0 on");
    if (!options.box) return;
    for (int k = 0; k < 3; ++k) {
        const double lower = options.box->lower[k], upper = options.box->upper[k];
        if (!std::isfinite(lower) || !std::isfinite(upper))
            refuse(std::string("box: ") + axis_name[k] + " from " + number(lower) + " to " + number(upper) +
                   " is not finite");
        if (!(lower < upper))
            refuse(std::string("box: ") + axis_name[k] + " from " + number(lower) + " to " + number(upper) +
                   (lower == upper ? " is empty" : " is inverted") + ": give the lower bounds first, then the upper");
    }
}

Job validate(const Points& points, const Options& options) {
    check_options(options);
    if (points.coordinates() % 3 != 0)
        refuse("points hold " + std::to_string(points.coordinates()) +
               " coordinates, which is not a multiple of 3: the shape must be (N,3)");
    if (points.count() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        throw Error(ErrorCode::unsupported, std::to_string(points.count()) + " seeds are too many: at most 2147483647");

    constexpr double infinity = std::numeric_limits<double>::infinity();
    Box bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for (std::size_t i = 0; i < points.count(); ++i) {
        for (int k = 0; k < 3; ++k) {
            const double value = points[3 * i + k];
            if (!std::isfinite(value))
                refuse("point " + std::to_string(i) + ": " + axis_name[k] + " = " + number(value) + " is not finite");
            if (options.box && !(value >= options.box->lower[k] && value <= options.box->upper[k]))
                refuse("point " + std::to_string(i) + ": " + axis_name[k] + " = " + number(value) +
                       " is outside the box, which spans " + number(options.box->lower[k]) + " to " +
                       number(options.box->upper[k]));
            bounds.lower[k] = std::min(bounds.lower[k], value);
            bounds.upper[k] = std::max(bounds.upper[k], value);
        }
    }

    Job job{points, options, options.box ? *options.box : default_box(bounds, points.count()), {}, 1};
    add_implied(job.options);
    job.scale = scale_for(job.box);
    for (int k = 0; k < 3; ++k) {
        job.scaled_box.lower[k] = job.box.lower[k] * job.scale;
        job.scaled_box.upper[k] = job.box.upper[k] * job.scale;
    }
    if (job.scale < 1) {  // only scaling down can lose bits
        for (int k = 0; k < 3; ++k) {
            check_scaled(job.box.lower[k], job.scale, std::string("box: lower ") + axis_name[k]);
            check_scaled(job.box.upper[k], job.scale, std::string("box: upper ") + axis_name[k]);
        }
        for (std::size_t i = 0; i < points.coordinates(); ++i)
            check_scaled(points[i], job.scale, "point " + std::to_string(i / 3) + ": " + axis_name[i % 3]);
    }
    return job;
}

}  // namespace votess
