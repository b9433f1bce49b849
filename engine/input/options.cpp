#include "input/options.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "core/vector3.hpp"
#include "input/default_box.hpp"
#include "input/each_option.hpp"
#include "input/implied_wants.hpp"
#include "polytope/cell.hpp"
#include "polytope/cell_kernels.hpp"

namespace votess {
namespace {

constexpr std::size_t max_index_digits = 6;
constexpr std::size_t points_per_stop_check = 4096;
constexpr double max_scaled_weight = 0x1p500;  // its square does not overflow

[[noreturn]] void refuse(const std::string& message) {
    throw Error(ErrorCode::invalid_argument, message);
}

bool names_device(const std::string& device) {
    if (device == "auto" || device == "cpu" || device == "gpu" || device == "lavapipe") return true;
    return !device.empty() && device.size() <= max_index_digits &&
           std::all_of(device.begin(), device.end(), [](char c) { return c >= '0' && c <= '9'; });
}

template <class Value>
void check_option(const char* /*name*/, const Value& /*value*/, decltype(anything)) {}

template <class Number>
void check_option(const char* name, Number value, UpTo<Number> allowed) {
    if (value >= 0 && value <= allowed.max && std::isfinite(static_cast<double>(value))) return;
    const auto text = [](Number n) {
        if constexpr (std::is_integral_v<Number>)
            return std::to_string(n);
        else
            return number(n);
    };
    refuse("Options::" + std::string(name) + " = " + text(value) + ": give " +
           (std::isinf(static_cast<double>(allowed.max)) ? "a finite number from 0 up" : "0 to " + text(allowed.max)));
}

template <class Enum, std::size_t count>
void check_option(const char* name, Enum value, const std::array<const char*, count>& allowed) {
    const auto index = static_cast<std::int64_t>(value);
    if (index >= 0 && index < static_cast<std::int64_t>(count)) return;
    std::string known;
    for (std::size_t i = 0; i < count; ++i)
        known += (i == 0 ? "" : " or ") + std::to_string(i) + " (" + allowed[i] + ")";
    refuse("Options::" + std::string(name) + " = " + std::to_string(index) + ": give " + known);
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

Box scaled(const Box& box, double scale) {
    Box result;
    for (int k = 0; k < 3; ++k) result.lower[k] = box.lower[k] * scale, result.upper[k] = box.upper[k] * scale;
    return result;
}

std::array<double, 3> scaled(const std::array<double, 3>& x, double scale) {
    return {x[0] * scale, x[1] * scale, x[2] * scale};
}

exact::Point middle_of(const Box& box) {
    exact::Point middle;
    for (std::size_t k = 0; k < 3; ++k) middle[k] = 0.5 * box.lower[k] + 0.5 * box.upper[k];
    return middle;
}

double volume_of(const Box& box) {
    double volume = 1;
    for (int k = 0; k < 3; ++k) volume *= box.upper[k] - box.lower[k];
    return volume;
}

struct NamedVector {
    const char* name;
    const std::array<double, 3>& numbers;
};
std::array<NamedVector, 4> vectors_of(const TriclinicBox& cell) {
    return {{{"origin", cell.origin}, {"a", cell.a}, {"b", cell.b}, {"c", cell.c}}};
}

double largest_number(const TriclinicBox& cell) {
    double largest = 0;
    for (const auto& [name, numbers] : vectors_of(cell))
        for (const double x : numbers) largest = std::max(largest, std::abs(x));
    return largest;
}

std::string text(const char* word) {
    return word;
}
std::string text(std::size_t number) {
    return std::to_string(number);
}
// name: in pieces, so that a good value makes no string.
void check_scaled(double value, double scale, const auto&... name) {
    if (value * scale / scale != value)
        refuse((text(name) + ...) + " = " + number(value) +
               " is too small beside the box to represent both at one scale: move it to 0");
}

// Weights and the offsets of walls are checked by set_weights() and set_walls().
void check_scaled(const Job& job) {
    if (job.scale >= 1) return;  // only scaling down can lose bits
    for (std::size_t k = 0; k < 3; ++k) {
        if (job.options.cell) {
            for (const auto& [name, numbers] : vectors_of(*job.options.cell))
                check_scaled(numbers[k], job.scale, "cell: ", name, " ", axis_name[k]);
        } else {
            check_scaled(job.box.lower[k], job.scale, "box: lower ", axis_name[k]);
            check_scaled(job.box.upper[k], job.scale, "box: upper ", axis_name[k]);
        }
    }
    for (std::size_t i = 0; i < job.points.coordinates(); ++i) {
        if (i % points_per_stop_check == 0) check_stop();
        check_scaled(job.points[i], job.scale, "point ", job.points.first + i / 3, ": ", axis_name[i % 3]);
    }
}

void check_domain(const Options& options) {
    const bool periodic = options.periodic[0] || options.periodic[1] || options.periodic[2];
    if (periodic && !options.box && !options.cell)
        refuse("Options::periodic needs a box: give Options::box or Options::cell, whose lengths are the periods");
    if (options.box) check_box(*options.box);
    if (options.cell) {
        if (options.box) refuse("Options::box and Options::cell are both given: give one of them");
        if (periodic && options.periodic != options.cell->periodic)
            refuse(
                "Options::cell.periodic and Options::periodic contradict each other: set one of them, or both to the "
                "same");
        for (const auto& [name, numbers] : vectors_of(*options.cell))
            for (const double x : numbers)
                if (!std::isfinite(x))
                    refuse(std::string("Options::cell: ") + name + " holds " + number(x) + ", which is not finite");
        const auto vectors = vectors_of(*options.cell);
        for (std::size_t j = 0; j < 3; ++j)
            if (vectors[j + 1].numbers == std::array<double, 3>{} && options.cell->periodic[j])
                refuse(
                    std::string("Options::cell: ") + vectors[j + 1].name +
                    " is 0, but the cell repeats along it: give its length, or leave it out of Options::cell.periodic "
                    "for a domain without end");
    }
    if (!options.walls.empty() && options.cell)
        refuse("Options::walls and Options::cell are both given: walls need a box, leave one out");
    if (!options.walls.empty() && periodic)
        refuse("Options::walls and Options::periodic are both given: walls need a box that is not periodic");
    for (std::size_t w = 0; w < options.walls.size(); ++w)
        (void)domain_wall(options.walls[w], 1, "wall " + std::to_string(w));
    if (!options.weights.empty() && !options.radii.empty())
        refuse(
            "Options::weights and Options::radii are both given: give one of them, weights are the squares of radii");
}

void drop_seed(std::size_t i, std::size_t count, std::vector<CellStatus>& outside) {
    if (outside.empty()) outside.resize(count, CellStatus::certified);
    outside[i] = CellStatus::outside;
}

// Returns what to do about a seed that lies so far outside of a domain of that size. Files round coordinates: those
// with eight decimals put an atom on a wall up to 5e-9 beyond it.
std::string outside_remedy(double distance, double size) {
    constexpr double rounding = 1e-6;
    return distance <= rounding * size
               ? ": its coordinates may be rounded: keep points outside (Options::outside = keep)"
               : ": move it, or drop points outside (Options::outside = drop) or keep them (Options::outside = keep)";
}

double largest_side(const Box& box) {
    return std::max({box.upper[0] - box.lower[0], box.upper[1] - box.lower[1], box.upper[2] - box.lower[2]});
}
// A seed that is kept may lie this many times the largest coordinate of the domain away from 0, so that no product of
// lengths leaves the range of double.
constexpr double farthest_kept = 0x1p40;

// Refuses a seed that is too far outside to keep. at: scaled.
void keep_seed(Job& job, std::size_t i, const exact::Point& at, double largest) {
    for (std::size_t k = 0; k < 3; ++k)
        if (!(std::abs(at[k]) <= farthest_kept * largest))
            refuse("point " + std::to_string(job.points.first + i) + ": " + axis_name[k] + " = " +
                   number(job.points[3 * i + k]) +
                   " is too far outside to be kept: give at most 1e12 times the largest coordinate of the domain");
    if (job.beyond.empty()) job.beyond.resize(job.points.count());
    job.beyond[i] = true;
}

// Returns the distance of a seed outside, for a message; "" if it overflows. rounding: bound of its error.
std::string distance_text(double distance, double rounding) {
    if (!std::isfinite(distance)) return {};
    const double shown = std::max({distance, rounding, std::numeric_limits<double>::denorm_min()});
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.3g", shown);
    return (distance > rounding ? ", by " : ", by less than ") + std::string(digits.data());
}

std::string in_parentheses(const exact::Point& x) {
    return "(" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ")";
}

constexpr Box no_bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

// Returns whether all coordinates are finite. Has no branches.
template <class T>
bool find_bounds(std::span<const T> coordinates, Box& bounds) {
    std::array<double, 3> lower = bounds.lower, upper = bounds.upper, zero{};  // NaN after a value that is not finite
    for (std::size_t i = 0; i < coordinates.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k) {
            const double value = coordinates[i + k];
            lower[k] = value < lower[k] ? value : lower[k];
            upper[k] = value > upper[k] ? value : upper[k];
            zero[k] += value * 0;
        }
    bounds = {lower, upper};
    return zero == std::array<double, 3>{};
}

void include(Box& box, const Box& other) {
    for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(box.lower[k], other.lower[k]);
        box.upper[k] = std::max(box.upper[k], other.upper[k]);
    }
}

// Returns the bounds of the seeds from `begin` on, after a check of each. outside: as in the job.
Box check_each(const Points& points, std::size_t begin, std::size_t end, const Options& options,
               std::vector<CellStatus>& outside) {
    Box bounds = no_bounds;
    for (std::size_t i = begin; i < end; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double value = points[3 * i + k];
            if (!std::isfinite(value))
                refuse("point " + std::to_string(points.first + i) + ": " + axis_name[k] + " = " + number(value) +
                       " is not finite");
            const bool beyond = options.box && !options.periodic[k] &&
                                !(value >= options.box->lower[k] && value <= options.box->upper[k]);
            if (beyond && options.outside == Outside::drop) {
                drop_seed(i, points.count(), outside);
            } else if (beyond && options.outside == Outside::error) {
                const double lower = options.box->lower[k], upper = options.box->upper[k];
                const double distance = std::max(lower - value, value - upper);
                refuse("point " + std::to_string(points.first + i) + ": " + axis_name[k] + " = " + number(value) +
                       " is outside the box, which spans " + number(lower) + " to " + number(upper) +
                       distance_text(distance, 0) + outside_remedy(distance, largest_side(*options.box)));
            }
            bounds.lower[k] = std::min(bounds.lower[k], value);
            bounds.upper[k] = std::max(bounds.upper[k], value);
        }
    }
    return bounds;
}

// Seeds outside do not count in the range.
void set_weights(const Job& job, Domain& domain) {
    domain.weights = scaled_weights(job.options, job.points.count(), "points", job.scale, job.points.first);
    bool any = false;
    for (std::size_t i = 0; i < domain.weights.size(); ++i) {
        if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;
        const double weight = domain.weights[i];
        domain.min_weight = any ? std::min(domain.min_weight, weight) : weight;
        domain.largest_weight = any ? std::max(domain.largest_weight, weight) : weight;
        any = true;
    }
}

// Returns which wall x is beyond, how far, and what to do. side: of the domain.
std::string beyond_wall(std::span<const Wall> walls, std::size_t w, const exact::Plane& plane, const exact::Point& x,
                        double side) {
    double excess = -plane.wall, size = std::abs(plane.wall);
    for (int k = 0; k < 3; ++k) {
        excess += plane.seed[k] * x[k];
        size += std::abs(plane.seed[k] * x[k]);
    }
    const double length = length3(plane.seed[0], plane.seed[1], plane.seed[2]);
    const auto& n = walls[w].normal;
    return " is outside wall " + std::to_string(w) + " (" + number(n[0]) + " x + " + number(n[1]) + " y + " +
           number(n[2]) + " z <= " + number(walls[w].offset) + ", " + std::to_string(-7 - static_cast<int>(w)) +
           " in lists)" + distance_text(excess / length, 8 * 0x1p-53 * size / length) +
           outside_remedy(excess / length, side);
}

// Returns the first wall that x is outside of, or their number. at: x, scaled as the domain.
std::size_t first_outside(const Domain& domain, std::span<const exact::Plane> walls, const exact::Point& x,
                          const exact::Point& at) {
    const auto outside = [&](const exact::Plane& wall) { return !inside(wall, x); };
    const WallTree& tree = domain.wall_tree;
    if (tree.size() == 0) return static_cast<std::size_t>(std::ranges::find_if(walls, outside) - walls.begin());
    std::size_t first = walls.size();
    std::array<std::size_t, 128> pending{0};  // of a depth-first search
    for (std::size_t count = 1; count > 0;) {
        const std::size_t node = pending[--count], wall = tree.wall(node);
        if (!tree.may_exclude(node, at, 0)) continue;
        if (wall < first && outside(walls[wall])) first = wall;
        for (std::size_t child = 2 * node + 1; child <= 2 * node + 2 && child < tree.size(); ++child)
            pending[count++] = child;
    }
    return first;
}

void set_walls(Job& job, Domain& domain) {
    const auto& walls = job.options.walls;
    for (std::size_t w = 0; w < walls.size(); ++w)
        domain.walls.push_back(domain_wall(walls[w], job.scale, "wall " + std::to_string(w)));
    if (walls.empty()) return;
    sort_walls(domain);
    // Seeds are compared as given: scaling could make those far outside infinite.
    std::vector<exact::Plane> as_given;
    for (const Wall& wall : walls) as_given.push_back(domain_wall(wall, 1, {}));
    std::optional<exact::Point> any_inside;
    const bool keep = job.options.outside == Outside::keep;
    const double largest = largest_coordinate(domain.box);
    for (std::size_t i = 0; i < job.points.count(); ++i) {
        if (i % points_per_stop_check == 0) check_stop();
        if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;  // of the box
        const exact::Point x{job.points[3 * i], job.points[3 * i + 1], job.points[3 * i + 2]};
        const exact::Point at = scaled(x, job.scale);
        const std::size_t wall = first_outside(domain, as_given, x, at);
        if (wall == walls.size()) {
            if (!any_inside) any_inside = at;
            continue;
        }
        if (job.options.outside == Outside::error)
            refuse("point " + std::to_string(job.points.first + i) + ": " + in_parentheses(x) +
                   beyond_wall(walls, wall, as_given[wall], x, largest_side(job.box)));
        if (keep)
            keep_seed(job, i, at, largest);
        else
            drop_seed(i, job.points.count(), job.outside);
    }
    job.box_volume = 0;
    if (keep) any_inside = middle_of(domain.box);  // whichever seeds are inside
    if (!any_inside) return;
    cpu::Cell polyhedron;
    polyhedron.start(*any_inside, domain);
    cpu::CellFaces faces;
    polyhedron.canonical_faces(faces);
    if (faces.size() >= 4) job.box_volume = polyhedron.measure(faces).volume / job.scale / job.scale / job.scale;
}

// Returns the wall of a triclinic box that x is farthest beyond, how far, and what to do.
std::string beyond_cell(const TriclinicBox& cell, const exact::Point& x) {
    const std::array edges{cell.a, cell.b, cell.c};
    double farthest = -infinity, size = 0, side = 0;
    int edge = 0, upper = 0;
    for (int k = 0; k < 3; ++k) {
        if (cell.periodic[k]) continue;
        const auto &u = edges[(k + 1) % 3], &v = edges[(k + 2) % 3];
        const Vector3 normal = cross(u, v);
        const double length = length3(normal[0], normal[1], normal[2]);
        double place = 0, height = 0;
        for (int axis = 0; axis < 3; ++axis) {
            place += normal[axis] / length * (x[axis] - cell.origin[axis]);
            height += normal[axis] / length * edges[k][axis];
            size = std::max({size, std::abs(x[axis]), std::abs(cell.origin[axis])});
        }
        if (height < 0) place = -place, height = -height;
        const double beyond = std::max(-place, place - height);
        if (beyond <= farthest) continue;
        farthest = beyond, edge = k, upper = place > 0 ? 1 : 0, side = height;
    }
    return " is outside of the cell, whose edge " + std::string(1, "abc"[edge]) + " is not periodic (wall " +
           std::to_string(-1 - 2 * edge - upper) + ")" + distance_text(farthest, 0x1p-48 * size) +
           outside_remedy(farthest, side);
}

// Refuses, drops or keeps seeds beyond the walls of a triclinic box.
void check_inside_cell(Job& job, const Domain& domain) {
    if (!domain.has_cell_walls()) return;
    for (std::size_t i = 0; i < job.points.count(); ++i) {
        if (i % points_per_stop_check == 0) check_stop();
        const exact::Point x{job.points[3 * i], job.points[3 * i + 1], job.points[3 * i + 2]};
        const exact::Point at = scaled(x, job.scale);  // not finite for seeds far outside
        if (std::ranges::all_of(at, [](double c) { return std::isfinite(c); }) && inside_walls(domain, at)) continue;
        if (job.options.outside == Outside::error)
            refuse("point " + std::to_string(job.points.first + i) + ": " + in_parentheses(x) +
                   beyond_cell(*job.options.cell, x));
        if (job.options.outside == Outside::keep)
            keep_seed(job, i, at, largest_coordinate(domain.box));
        else
            drop_seed(i, job.points.count(), job.outside);
    }
}

// Marks the seeds beyond the walls of a box.
void keep_outside_box(Job& job, const Domain& domain) {
    if (job.options.outside != Outside::keep || !job.options.box) return;
    const double largest = largest_coordinate(domain.box);
    for (std::size_t i = 0; i < job.points.count(); ++i) {
        if (i % points_per_stop_check == 0) check_stop();
        bool beyond = false;
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = job.points[3 * i + k];
            beyond = beyond || (!domain.periodic[k] && !(x >= job.box.lower[k] && x <= job.box.upper[k]));
        }
        if (beyond)
            keep_seed(job, i,
                      scaled(exact::Point{job.points[3 * i], job.points[3 * i + 1], job.points[3 * i + 2]}, job.scale),
                      largest);
    }
}

// Seeds may be farther from places in a periodic domain where some lie beyond its walls.
void widen_covering_radius(const Job& job, Domain& domain) {
    if (!domain.is_periodic() || job.beyond.empty()) return;
    Box fractions{{0, 0, 0}, {1, 1, 1}};
    for (std::size_t i = 0; i < job.beyond.size(); ++i) {
        if (!job.beyond[i]) continue;
        exact::Point d;
        for (std::size_t k = 0; k < 3; ++k) d[k] = job.points[3 * i + k] * job.scale - domain.origin[k];
        const auto f = domain.reduced.fraction(d);
        include(fractions, {f, f});
    }
    constexpr double rounding = 1 + 1e-6;
    double more = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        const auto& [x, y, z] = domain.reduced.vector[j];
        if (!domain.periodic[j]) more += (fractions.upper[j] - fractions.lower[j] - 1) * length3(x, y, z);
    }
    domain.covering_radius = (domain.covering_radius + more) * rounding;
}

// Checks and copies the seeds of the rows.
void take_subset(Job& job) {
    if (!job.options.only) return;
    const auto given = *job.options.only;
    const std::size_t count = job.points.count();
    std::vector<bool> taken(count);
    std::vector<std::int32_t> ids;
    ids.reserve(given.size());
    for (std::size_t k = 0; k < given.size(); ++k) {
        const std::int64_t id = given[k];
        const auto name = [&] {
            return "Options::only: seed " + std::to_string(id) + " at place " + std::to_string(k);
        };
        if (id < 0 || static_cast<std::uint64_t>(id) >= count)
            refuse(name() + " is not among the " + std::to_string(count) + " points: give indices from 0 on");
        if (taken[static_cast<std::size_t>(id)]) refuse(name() + " was named before: give each seed once");
        taken[static_cast<std::size_t>(id)] = true;
        ids.push_back(static_cast<std::int32_t>(id));
    }
    job.only = std::make_shared<const Subset>(std::move(ids));
    job.options.only.reset();
}

void make_domain(Job& job) {
    auto domain = std::make_shared<Domain>();
    if (job.options.cell) {
        const TriclinicBox& cell = *job.options.cell;
        *domain = triclinic_domain({scaled(cell.origin, job.scale), scaled(cell.a, job.scale),
                                    scaled(cell.b, job.scale), scaled(cell.c, job.scale), cell.periodic});
        check_inside_cell(job, *domain);
        for (std::size_t k = 0; k < 3; ++k) {
            job.box.lower[k] = domain->box.lower[k] / job.scale, job.box.upper[k] = domain->box.upper[k] / job.scale;
            for (const double x : {job.box.lower[k], job.box.upper[k]})
                if (!std::isfinite(x))
                    refuse(std::string("Options::cell: it exceeds the largest double along ") + axis_name[k] +
                           ": give lengths in a larger unit");
        }
        job.box_volume = domain->volume / job.scale / job.scale / job.scale;
    } else {
        *domain = box_domain(scaled(job.box, job.scale), job.options.periodic);
        job.box_volume = volume_of(job.box);
        keep_outside_box(job, *domain);
    }
    set_walls(job, *domain);
    domain->seeds_beyond = !job.beyond.empty();
    widen_covering_radius(job, *domain);
    set_weights(job, *domain);
    job.domain = std::move(domain);
}

}  // namespace

Box check_points(const Points& points, const Options& options, std::vector<CellStatus>& outside, ThreadPool* pool) {
    constexpr std::size_t block = 4096;
    const std::size_t blocks = ceil_div(points.count(), block);
    std::vector<std::optional<Box>> found(blocks);  // none where points have to be checked one by one
    const auto task = [&](std::size_t index, unsigned) {
        const std::size_t begin = index * block, count = std::min(block, points.count() - begin);
        Box of_block = no_bounds;
        bool good = points.f32.empty() ? find_bounds(points.f64.subspan(3 * begin, 3 * count), of_block)
                                       : find_bounds(points.f32.subspan(3 * begin, 3 * count), of_block);
        for (int k = 0; k < 3; ++k)
            if (options.box && !options.periodic[k])
                good &= of_block.lower[k] >= options.box->lower[k] && of_block.upper[k] <= options.box->upper[k];
        if (good) found[index] = of_block;
    };
    if (pool != nullptr && blocks > 1) pool->run(blocks, std::cref(task));
    Box bounds = no_bounds;
    for (std::size_t index = 0; index < blocks; ++index) {
        check_stop();
        if (pool == nullptr || blocks == 1) task(index, 0);
        const std::size_t begin = index * block, end = std::min(points.count(), begin + block);
        include(bounds, found[index] ? *found[index] : check_each(points, begin, end, options, outside));
    }
    return bounds;
}

std::vector<double> scaled_weights(const Options& options, std::size_t count, const char* of, double scale,
                                   std::uint64_t first) {
    const bool radii = !options.radii.empty();
    const auto given = radii ? options.radii : options.weights;
    if (given.empty()) return {};
    if (given.size() != count)
        refuse("Options::" + std::string(radii ? "radii" : "weights") + " hold " + std::to_string(given.size()) +
               " numbers for " + std::to_string(count) + " " + of + ": give one for each");
    std::vector<double> weights(given.begin(), given.end());  // read once, see input/snapshot.hpp
    for (std::size_t i = 0; i < count; ++i) {
        if (i % points_per_stop_check == 0) check_stop();
        const double value = weights[i];
        const auto place = [&] { return std::string(radii ? "radius " : "weight ") + std::to_string(first + i); };
        if (!std::isfinite(value)) refuse(place() + " = " + number(value) + " is not finite");
        if (radii && value < 0) refuse(place() + " = " + number(value) + " is negative");
        const double weight = radii ? value * value : value;
        if (!std::isfinite(weight)) refuse(place() + " = " + number(value) + " is too large: its square overflows");
        const double in_units = weight * scale * scale;
        if (in_units / scale / scale != weight || std::abs(in_units) > max_scaled_weight)
            refuse(place() + " = " + number(value) +
                   " is too large or too small for the box: give all lengths in one unit");
        weights[i] = in_units;
    }
    return weights;
}

void check_box(const Box& box) {
    for (int k = 0; k < 3; ++k) {
        const double lower = box.lower[k], upper = box.upper[k];
        if (!std::isfinite(lower) || !std::isfinite(upper))
            refuse(std::string("Options::box: ") + axis_name[k] + " from " + number(lower) + " to " + number(upper) +
                   " is not finite");
        if (!(lower < upper))
            refuse(std::string("Options::box: ") + axis_name[k] + " from " + number(lower) + " to " + number(upper) +
                   (lower == upper ? " is empty" : " is inverted") + ": give the lower bound first, then the upper");
    }
}

void check_options(const Options& options) {
    each_option([&](auto name, auto member, auto, auto allowed) { check_option(name, options.*member, allowed); });
    check_instructions(options.instructions);
    if (options.only && (options.min_face > 0 || options.min_area > 0))
        refuse("Options::min_face and Options::min_area need the faces of all cells: leave them out, or Options::only");
    if (!names_device(options.device))
        refuse("Options::device is " + in_quotes(options.device) +
               ", which is unknown: give auto, cpu, gpu, lavapipe or the index of a device, 0 to 999999");
    if (options.mesh)
        refuse("Options::mesh: only tessellate(), fit_volumes() and Diagram clip by a mesh, leave it out");
    if (options.planar)
        refuse("Options::planar: only tessellate(), fit_volumes() and Diagram work in two dimensions, leave it out");
    if (options.only && options.device != "auto" && options.device != "cpu")
        throw Error(ErrorCode::unsupported,
                    "Options::device = " + options.device +
                        ": the CPU makes the cells of some seeds, give cpu or auto with Options::only");
    check_domain(options);
}

Box box_of(const Options& options, const Box& bounds, std::uint64_t count) {
    if (options.box) return *options.box;
    Box box = default_box(bounds, count);
    if (!options.walls.empty()) check_box(box = bounds_of(options.walls, box));
    return box;
}

void check_shape(const Points& points) {
    if (points.coordinates() % 3 != 0)
        refuse("points hold " + std::to_string(points.coordinates()) +
               " coordinates, not a multiple of 3: the shape must be (N,3)");
    if (points.count() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        throw Error(ErrorCode::unsupported,
                    std::to_string(points.count()) + " seeds are too many: give at most 2147483647, or stream them");
}

Job validate(const Points& points, const Options& options, ThreadPool* pool) {
    check_options(options);
    check_shape(points);
    Job job;
    const Box bounds = check_points(points, options, job.outside, pool);
    job.points = points;
    job.options = options;
    job.options.want = with_implied(options);
    job.options.list_walls |= options.want.faces;
    if (options.cell) {
        job.scale = scale_for(largest_number(*options.cell));
    } else {
        job.box = box_of(options, bounds, points.count());
        job.scale = scale_for(largest_coordinate(job.box));
    }
    check_scaled(job);
    make_domain(job);
    take_subset(job);
    return job;
}

}  // namespace votess
