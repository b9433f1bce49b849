#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "core/box.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "input/default_box.hpp"
#include "input/settle.hpp"
#include "polytope/cell.hpp"

namespace votess {
namespace {

constexpr std::size_t points_per_stop_check = 4096;
constexpr double max_scaled_weight = 0x1p500;  // its square does not overflow

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

// Rounds once where the volume is subnormal, as the sum of volumes of cells does. thickness: of a sheet.
double volume_of(const Box& box, double thickness) {
    double mantissa = 1;
    int exponent = 0, own = 0;
    for (std::size_t k = 0; k < (thickness > 0 ? 2 : 3); ++k) {
        mantissa *= std::frexp(box.upper[k] - box.lower[k], &own);
        exponent += own;
    }
    return std::ldexp(mantissa, exponent);
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
        if (job.region.cell) {
            for (const auto& [name, numbers] : vectors_of(*job.region.cell))
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

// Returns the bounds of the seeds from `begin` on, after a check of each. outside: as in the job.
Box check_each(const Points& points, std::size_t begin, std::size_t end, const Region& region,
               std::vector<CellStatus>& outside) {
    Box bounds = empty_box;
    for (std::size_t i = begin; i < end; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double value = points[3 * i + k];
            if (!std::isfinite(value))
                refuse("point " + std::to_string(points.first + i) + ": " + axis_name[k] + " = " + number(value) +
                       " is not finite");
            const bool beyond =
                region.box && !region.periodic[k] && !(value >= region.box->lower[k] && value <= region.box->upper[k]);
            if (beyond && region.outside == Outside::drop) {
                drop_seed(i, points.count(), outside);
            } else if (beyond && region.outside == Outside::error) {
                const double lower = region.box->lower[k], upper = region.box->upper[k];
                const double distance = std::max(lower - value, value - upper);
                refuse("point " + std::to_string(points.first + i) + ": " + axis_name[k] + " = " + number(value) +
                       " is outside the box, which spans " + number(lower) + " to " + number(upper) +
                       distance_text(distance, 0) + outside_remedy(distance, largest_side(*region.box)));
            }
            bounds.lower[k] = std::min(bounds.lower[k], value);
            bounds.upper[k] = std::max(bounds.upper[k], value);
        }
    }
    return bounds;
}

// Seeds outside do not count in the range.
void set_weights(Job& job, Domain& domain) {
    job.reports_weights = !job.weights.empty();
    domain.weights =
        scaled_weights(std::exchange(job.weights, {}), job.points.count(), "points", job.scale, job.points.first);
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
    const auto& walls = job.region.walls;
    for (std::size_t w = 0; w < walls.size(); ++w)
        domain.walls.push_back(domain_wall(walls[w], job.scale, "wall " + std::to_string(w)));
    if (walls.empty()) return;
    sort_walls(domain);
    // Seeds are compared as given: scaling could make those far outside infinite.
    std::vector<exact::Plane> as_given;
    for (const Wall& wall : walls) as_given.push_back(domain_wall(wall, 1, {}));
    std::optional<exact::Point> any_inside;
    const bool keep = job.region.outside == Outside::keep;
    const double largest = largest_coordinate(domain.box);
    for (std::size_t i = 0; i < job.points.count(); ++i) {
        if (i % points_per_stop_check == 0) check_stop();
        if (!job.outside.empty() && job.outside[i] == CellStatus::outside) continue;  // of the box
        const exact::Point x = point_of(job.points, i);
        const exact::Point at = scaled(x, job.scale);
        const std::size_t wall = first_outside(domain, as_given, x, at);
        if (wall == walls.size()) {
            if (!any_inside) any_inside = at;
            continue;
        }
        if (job.region.outside == Outside::error)
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
    if (faces.size() < 4) return;
    const cpu::CellGeometry geometry = polyhedron.measure(faces);
    job.box_volume = job.unit().volume(geometry.volume);
    for (const std::int32_t p : faces.planes)
        domain.facets.push_back(polyhedron.planes()[static_cast<std::size_t>(p)].id);
    for (std::size_t k = 0; k < 3; ++k)
        domain.middle[k] = (*any_inside)[k] + std::ldexp(geometry.centroid[k], geometry.exponent);
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
        const exact::Point x = point_of(job.points, i);
        const exact::Point at = scaled(x, job.scale);  // not finite for seeds far outside
        if (std::ranges::all_of(at, [](double c) { return std::isfinite(c); }) && inside_walls(domain, at)) continue;
        if (job.region.outside == Outside::error)
            refuse("point " + std::to_string(job.points.first + i) + ": " + in_parentheses(x) +
                   beyond_cell(*job.region.cell, x));
        if (job.region.outside == Outside::keep)
            keep_seed(job, i, at, largest_coordinate(domain.box));
        else
            drop_seed(i, job.points.count(), job.outside);
    }
}

// Marks the seeds beyond the walls of a box.
void keep_outside_box(Job& job, const Domain& domain) {
    if (job.region.outside != Outside::keep || !job.region.box) return;
    const double largest = largest_coordinate(domain.box);
    for (std::size_t i = 0; i < job.points.count(); ++i) {
        if (i % points_per_stop_check == 0) check_stop();
        bool beyond = false;
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = job.points[3 * i + k];
            beyond = beyond || (!domain.periodic[k] && !(x >= job.box.lower[k] && x <= job.box.upper[k]));
        }
        if (beyond) keep_seed(job, i, point_of(job.points, i, job.scale), largest);
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
        include(fractions, f);
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
    if (!job.subset) return;
    const std::vector<std::int64_t>& given = *job.subset;
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
    job.subset.reset();
}

void make_domain(Job& job) {
    auto domain = std::make_shared<Domain>();
    if (job.region.cell) {
        const TriclinicBox& cell = *job.region.cell;
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
        job.box_volume = job.unit().volume(domain->volume);
    } else {
        *domain = box_domain(scaled(job.box, job.scale), job.region.periodic);
        job.box_volume = volume_of(job.box, job.region.thickness);
        keep_outside_box(job, *domain);
    }
    set_walls(job, *domain);
    domain->seeds_beyond = !job.beyond.empty();
    widen_covering_radius(job, *domain);
    set_weights(job, *domain);
    job.domain = std::move(domain);
}

}  // namespace

Box check_points(const Points& points, const Region& region, std::vector<CellStatus>& outside, ThreadPool* pool) {
    constexpr std::size_t block = 4096;
    const std::size_t blocks = ceil_div(points.count(), block);
    std::vector<std::optional<Box>> found(blocks);  // none where points have to be checked one by one
    const auto task = [&](std::size_t index, unsigned) {
        const std::size_t begin = index * block, count = std::min(block, points.count() - begin);
        Box of_block = empty_box;
        bool good = points.f32.empty() ? find_bounds(points.f64.subspan(3 * begin, 3 * count), of_block)
                                       : find_bounds(points.f32.subspan(3 * begin, 3 * count), of_block);
        for (int k = 0; k < 3; ++k)
            if (region.box && !region.periodic[k])
                good &= of_block.lower[k] >= region.box->lower[k] && of_block.upper[k] <= region.box->upper[k];
        if (good) found[index] = of_block;
    };
    if (pool != nullptr && blocks > 1) pool->run(blocks, std::cref(task));
    Box bounds = empty_box;
    for (std::size_t index = 0; index < blocks; ++index) {
        check_stop();
        if (pool == nullptr || blocks == 1) task(index, 0);
        const std::size_t begin = index * block, end = std::min(points.count(), begin + block);
        include(bounds, found[index] ? *found[index] : check_each(points, begin, end, region, outside));
    }
    return bounds;
}

std::vector<double> scaled_weights(Weights given, std::size_t count, const char* of, double scale,
                                   std::uint64_t first) {
    const bool radii = given.are_radii;
    std::vector<double> weights = std::move(given.given);
    if (weights.empty()) return weights;
    if (weights.size() != count)
        refuse("Options::" + std::string(radii ? "radii" : "weights") + " hold " + std::to_string(weights.size()) +
               " numbers for " + std::to_string(count) + " " + of + ": give one for each");
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

Box box_of(const Region& region, const Box& bounds, std::uint64_t count) {
    if (region.box) return *region.box;
    Box box = default_box(bounds, count);
    if (region.walls.empty()) return box;
    box = bounds_of(region.walls, box);
    for (std::size_t k = 0; k < 3; ++k)
        if (!(box.lower[k] < box.upper[k]))
            refuse(std::string("Options::walls: they leave nothing of the box around the points: ") + "xyz"[k] +
                   " would go from " + number(box.lower[k]) + " to " + number(box.upper[k]) +
                   ": give other walls, or a box");
    return box;
}

Job make_job(Settled run, ThreadPool* pool) {
    if (run.region.box) check_box(*run.region.box);
    Job job;
    static_cast<Settled&>(job) = std::move(run);
    const Box bounds = check_points(job.points, job.region, job.outside, pool);
    imply(job);
    if (job.region.cell) {
        job.scale = scale_for(largest_number(*job.region.cell));
    } else {
        job.box = box_of(job.region, bounds, job.points.count());
        job.scale = scale_for(largest_coordinate(job.box));
    }
    check_scaled(job);
    make_domain(job);
    take_subset(job);
    return job;
}

}  // namespace votess
