#include "domain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <span>

#include "failure.hpp"
#include "files/numbers.hpp"

namespace clvotess {
namespace {

std::string short_list(std::span<const double> numbers) {
    std::string text;
    for (const double x : numbers) {
        char number[32];
        std::snprintf(number, sizeof number, "%.6g", x);
        text += (text.empty() ? "" : ",") + std::string(number);
    }
    return text;
}

// Writes null for infinity, which JSON lacks: bounds near the largest double may overflow.
std::string json_list(std::span<const double> numbers) {
    std::string text;
    for (const double x : numbers) text += (text.empty() ? "[" : ",") + (std::isfinite(x) ? to_text(x) : "null");
    return text + "]";
}

std::span<const double> components(const votess::Tessellation& cells, const std::array<double, 3>& vector) {
    return std::span<const double>(vector).first(size_of_vectors(cells));
}

bool reaches_infinity(double bound) {
    return std::isinf(bound);
}

const char* kind_of(const votess::Tessellation& cells) {
    return cells.in_mesh() ? "mesh" : cells.cell() ? "cell" : cells.walls().empty() ? "box" : "polyhedron";
}

std::string axes_of(const votess::Tessellation& cells) {
    std::string axes;
    for (std::size_t k = 0; k < 3; ++k) {
        if (cells.periodic()[k]) axes += (cells.cell() ? "abc" : "xyz")[k];
    }
    return axes;
}

}  // namespace

std::size_t size_of_vectors(const votess::Tessellation& cells) {
    return cells.planar() ? 2 : 3;
}

const char* word_of(DomainSource source) {
    switch (source) {
        case DomainSource::option:
            return "option";
        case DomainSource::stated:
            return "stated";
        case DomainSource::assumed:
            return "assumed";
        default:
            return "default";
    }
}

DomainFrom choose_domain(const FileDomain& stated, const std::optional<std::array<bool, 3>>& periodic,
                         votess::Options& options, bool hull) {
    const auto any = [](const std::array<bool, 3>& axes) { return std::ranges::count(axes, true) > 0; };
    if (hull) {
        if (periodic) options.periodic = *periodic;  // set_hull() refuses it
        return {DomainSource::option, periodic ? DomainSource::option : DomainSource::by_default};
    }
    if (options.mesh && !options.box && !options.cell) {  // a box around mesh and points
        if (periodic) options.periodic = *periodic;       // which votess refuses
        return {DomainSource::by_default, periodic ? DomainSource::option : DomainSource::by_default};
    }
    const bool given = options.box || options.cell;
    const bool stated_walls = !given && options.walls.empty();  // the walls are the file's, if there are some
    if (!given && stated.cell && !stated_walls)
        throw bad_input("the file states a cell, and walls need a box: give --box");
    if (!given) {
        options.box = stated.box;
        options.cell = stated.cell;
        if (options.walls.empty()) options.walls = stated.walls;
    }
    if (!options.box && !options.cell) {
        if (periodic && any(*periodic)) {
            throw bad_input("--periodic needs a box, and the file states none: give --box or --cell");
        }
        if (!periodic && any(stated.periodic)) {
            throw bad_input(
                "the file states periodic axes without their lengths: give --box or --cell, or "
                "--periodic none");
        }
        return {DomainSource::by_default, periodic ? DomainSource::option : DomainSource::by_default};
    }
    std::array<bool, 3>& axes = options.cell ? options.cell->periodic : options.periodic;
    const bool axes_alone = any(stated.periodic) && !stated.box;  // they apply to the user's box
    if (!periodic && (given ? axes_alone : options.box.has_value())) axes = stated.periodic;
    if (periodic) axes = *periodic;
    if (options.planar) axes[2] = false;        // which --periodic without a value names
    if (!options.walls.empty() && any(axes)) {  // the library refuses the rest, in the user's own options
        if (!periodic && stated_walls)
            throw bad_input(
                "the file states a domain that repeats and is not a box: add --periodic none, or give --box");
        if (!periodic) throw bad_input("the file states periodic axes, which walls exclude: add --periodic none");
        if (stated_walls) throw bad_input("--periodic needs a box, and the file's domain is a polyhedron: give --box");
    }
    return {given ? DomainSource::option : DomainSource::stated, periodic               ? DomainSource::option
                                                                 : given && !axes_alone ? DomainSource::by_default
                                                                                        : stated.periodic_from};
}

void check_edges(const std::string& path, const votess::TriclinicBox& cell) {
    const std::array edges{cell.a, cell.b, cell.c};
    for (std::size_t k = 0; k < 3; ++k)
        if (cell.periodic[k] && edges[k] == std::array<double, 3>{})
            throw bad_input(path + ": edge " + "abc"[k] +
                            " of its domain is 0, but the domain repeats along it: name other axes by --periodic, or " +
                            "give --cell");
}

void check_corner(const Input& input, const votess::Options& options, const DomainFrom& from) {
    if (input.domain.corner_from != DomainSource::assumed || from.box != DomainSource::stated || input.planar() ||
        options.outside != votess::Outside::error)
        return;
    const votess::TriclinicBox& cell = *options.cell;
    const std::array edges{cell.a, cell.b, cell.c};
    for (std::size_t k = 0; k < 3; ++k) {
        if (cell.periodic[k] || edges[k] == std::array<double, 3>{}) continue;
        const auto &u = edges[(k + 1) % 3], &v = edges[(k + 2) % 3];
        const std::array<double, 3> normal{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                           u[0] * v[1] - u[1] * v[0]};
        const double height = std::inner_product(normal.begin(), normal.end(), edges[k].begin(), 0.0);
        for (std::size_t i = 0; i < input.size(); ++i) {
            const double share = std::inner_product(normal.begin(), normal.end(),
                                                    input.points.begin() + static_cast<std::ptrdiff_t>(3 * i), 0.0) /
                                 height;
            constexpr double rounding = 1e-6;  // nearer ones are left to the library
            if (!(share < -rounding || share > 1 + rounding)) continue;
            throw bad_input(
                "point " + std::to_string(i) + " is at " + to_text(share) + " of edge " + "abc"[k] +
                " of the cell, which the file lets begin at 0, for it states no Origin (dump extxyz of LAMMPS "
                "writes none): add Origin=\"x y z\" to its comment, give --cell and --origin, or --outside");
        }
    }
}

void set_hull(std::span<const double> points, votess::Options& options) {
    options.walls = votess::hull_walls(points, options);
}

bool has_ends(const votess::Options& options, bool hull) {
    if (hull || options.mesh || !options.walls.empty() || options.cell) return true;
    return options.box && std::ranges::none_of(options.box->lower, reaches_infinity) &&
           std::ranges::none_of(options.box->upper, reaches_infinity);
}

void set_ends_of_z(votess::Options& options) {
    if (options.planar && options.box && std::isinf(options.box->lower[2]))
        options.box->lower[2] = options.box->upper[2] = 0;
}

void choose_dimensions(bool planar, votess::Options& options) {
    if (options.planar && !planar)
        throw bad_input(
            "the domain of the options has two dimensions, but the points have three coordinates: add --2d if their "
            "z does not matter, or give the domain with z");
    options.planar = planar;
    set_ends_of_z(options);
}

std::string domain_text(const votess::Tessellation& cells, const DomainFrom& from) {
    std::string text;
    const auto list = [&](const std::array<double, 3>& vector) { return short_list(components(cells, vector)); };
    if (const auto& cell = cells.cell()) {
        text = "cell " + list(cell->a) + " " + list(cell->b) + (cells.planar() ? "" : " " + list(cell->c)) + " at " +
               list(cell->origin);
    } else if (std::ranges::all_of(components(cells, cells.box().lower), reaches_infinity) &&
               std::ranges::all_of(components(cells, cells.box().upper), reaches_infinity)) {
        text = cells.planar() ? "all of the plane" : "all of space";
    } else {
        text = "box " + list(cells.box().lower) + " to " + list(cells.box().upper);
    }
    if (const auto count = cells.walls().size(); count > 0) {
        text += ", cut by " + std::to_string(count) + (count == 1 ? " wall" : " walls");
    }
    const std::string axes = axes_of(cells);
    text += axes.empty() ? ", not periodic" : ", periodic " + axes;
    if (from.box == DomainSource::by_default)
        text += cells.in_mesh() ? ", around points and mesh" : ", around the points";
    const std::string box = word_of(from.box), periodic = word_of(from.periodic);
    return text + "; " + (box == periodic ? box : "box " + box + ", periodicity " + periodic);
}

std::string domain_json(const votess::Tessellation& cells, const DomainFrom& from) {
    const auto& cell = cells.cell();
    const auto of_cell = [&](const std::array<double, 3> votess::TriclinicBox::*vector) {
        const bool edge_c = vector == &votess::TriclinicBox::c;
        return cell && !(cells.planar() && edge_c) ? json_list(components(cells, (*cell).*vector)) : "null";
    };
    std::string periodic;
    for (std::size_t k = 0; k < size_of_vectors(cells); ++k)
        periodic += std::string(periodic.empty() ? "" : ",") + (cells.periodic()[k] ? "true" : "false");
    using Cell = votess::TriclinicBox;
    return std::string(R"({"kind": ")") + kind_of(cells) + R"(", "lower": )" +
           json_list(components(cells, cells.box().lower)) + R"(, "upper": )" +
           json_list(components(cells, cells.box().upper)) + R"(, "origin": )" + of_cell(&Cell::origin) + R"(, "a": )" +
           of_cell(&Cell::a) + R"(, "b": )" + of_cell(&Cell::b) + R"(, "c": )" + of_cell(&Cell::c) +
           R"(, "periodic": [)" + periodic + R"(], "from": ")" + word_of(from.box) + R"(", "periodic_from": ")" +
           word_of(from.periodic) + "\"}";
}

}  // namespace clvotess
