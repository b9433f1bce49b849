#include "input/region.hpp"

#include <bit>
#include <cmath>
#include <string>

#include "core/arithmetic.hpp"
#include "core/errors.hpp"
#include "core/text.hpp"
#include "domain/domain.hpp"

namespace votess {
namespace {

[[noreturn]] void refuse_with_mesh(const std::string& what) {
    throw Error(ErrorCode::unsupported, "Options::mesh: " + what);
}

void check_flat(double z, const std::string& what) {
    if (z != 0) refuse(what + " has z = " + number(z) + ": leave z 0 in two dimensions");
}

void check_with_mesh(const Region& region) {
    if (region.cell && (region.planar || region.thickness > 0))
        refuse_with_mesh("a triclinic box needs three dimensions: give Options::box, which may be periodic");
    if (region.cell && region.cell->periodic != std::array{true, true, true})
        refuse_with_mesh(
            "a triclinic box must repeat along all its edges: set Options::cell.periodic so, or give Options::box");
    if (!region.walls.empty()) refuse_with_mesh("it replaces Options::walls: leave them out");
    if (region.outside != Outside::error)
        refuse_with_mesh("seeds may lie outside of the mesh, but not outside of the box: leave out Options::outside");
    if (region.box && EndlessSides(region).any())
        refuse_with_mesh("Options::box needs ends: leave it out, the default holds the mesh");
}

void check_endless(const Region& region) {
    for (std::size_t k = 0; region.box && k < 3; ++k)
        if (region.periodic[k] && !(std::isfinite(region.box->lower[k]) && std::isfinite(region.box->upper[k])))
            refuse(std::string("Options::periodic: ") + axis_name[k] +
                   " repeats, but Options::box has no end along it: give both of its bounds");
    if (!region.walls.empty())
        refuse("Options::box without end and Options::walls are both given: walls bound the domain alone");
    if (region.box && region.cell) refuse("Options::box and Options::cell are both given: give one of them");
}

}  // namespace

EndlessSides::EndlessSides(const Region& region) {
    for (std::size_t k = 0; region.box && k < 3; ++k) {
        if (region.box->lower[k] == -infinity) sides_ |= 1u << 2 * k;
        if (region.box->upper[k] == infinity) sides_ |= 2u << 2 * k;
    }
    if (!region.cell) return;
    const auto& [origin, a, b, c, periodic] = *region.cell;
    for (std::size_t j = 0; j < (region.planar ? 2 : 3); ++j)
        if (std::array{a, b, c}[j] == std::array<double, 3>{} && !periodic[j]) sides_ |= 3u << 2 * j;
}

std::int32_t EndlessSides::id() const {
    return -1 - std::countr_zero(sides_);
}

Region in_sheet(Region region, double height) {
    region.planar = false;
    region.thickness = 2 * height;
    if (region.periodic[2]) refuse("Options::periodic: z repeats, but points of the plane have none: leave it out");
    if (region.box) {
        check_flat(region.box->lower[2], "Options::box");
        check_flat(region.box->upper[2], "Options::box");
        region.box->lower[2] = -height, region.box->upper[2] = height;
    }
    if (region.cell) {
        TriclinicBox& cell = *region.cell;
        check_flat(cell.origin[2], "cell: origin");
        check_flat(cell.a[2], "cell: a");
        check_flat(cell.b[2], "cell: b");
        for (const double x : cell.c)
            if (x != 0) refuse("Options::cell: c is given: leave it 0 in two dimensions");
        cell.origin[2] = -height;
        cell.c = {0, 0, 2 * height};
        cell.periodic[2] = false;
    }
    for (std::size_t w = 0; w < region.walls.size(); ++w)
        check_flat(region.walls[w].normal[2], "wall " + std::to_string(w));
    return region;
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

void check_region(const Region& region) {
    if (region.mesh) check_with_mesh(region);
    if (region.planar) return check_region(in_sheet(region, 1));
    const bool endless = EndlessSides(region).any();
    if (endless) check_endless(region);
    const bool periodic = region.periodic != std::array<bool, 3>{};
    if (periodic && !region.box && !region.cell)
        refuse("Options::periodic needs a box: give Options::box or Options::cell, whose lengths are the periods");
    if (region.box && !endless) check_box(*region.box);
    if (region.cell) {
        if (region.box) refuse("Options::box and Options::cell are both given: give one of them");
        if (periodic && region.periodic != region.cell->periodic)
            refuse(
                "Options::cell.periodic and Options::periodic contradict each other: set one of them, or both to the "
                "same");
        const auto vectors = vectors_of(*region.cell);
        for (const auto& [name, numbers] : vectors)
            for (const double x : numbers)
                if (!std::isfinite(x))
                    refuse(std::string("Options::cell: ") + name + " holds " + number(x) + ", which is not finite");
        for (std::size_t j = 0; j < 3; ++j)
            if (vectors[j + 1].numbers == std::array<double, 3>{} && region.cell->periodic[j])
                refuse(
                    std::string("Options::cell: ") + vectors[j + 1].name +
                    " is 0, but the cell repeats along it: give its length, or leave it out of Options::cell.periodic "
                    "for a domain without end");
    }
    if (!region.walls.empty() && region.cell)
        refuse("Options::walls and Options::cell are both given: walls need a box, leave one out");
    if (!region.walls.empty() && periodic)
        refuse("Options::walls and Options::periodic are both given: walls need a box that is not periodic");
    for (std::size_t w = 0; w < region.walls.size(); ++w)
        (void)domain_wall(region.walls[w], 1, "wall " + std::to_string(w));
}

}  // namespace votess
