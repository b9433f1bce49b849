#include "gpu/domain/cell_images.hpp"

#include <algorithm>
#include <cmath>

#include "domain/domain.hpp"
#include "gpu/domain/device_domain.hpp"

namespace votess::gpu {
namespace {

constexpr int max_steps = 3;            // along an edge, to an image
constexpr double max_fraction = 7;      // of a seed's place as given
constexpr double min_margin = 0x1p-16;  // of the longest side: more than rounding moves seeds out of the box
constexpr double slack = 0.01;          // of fractions, see gpu/domain/periodic_part.cpp
constexpr int fraction_bits = FRACTION_BITS;

[[noreturn]] void refuse() {
    throw Error(ErrorCode::unsupported,
                "the triclinic box leans or is thin so much that recorded frames do not find its images: give shorter "
                "edges of the same lattice");
}

// Rounds to the nearest whole number, modulo 2^64.
std::uint64_t to_units(double value, int shift, bool& lossy) {
    const double units = std::ldexp(value, shift);
    if (!(std::abs(units) < 0x1p63)) refuse();
    const double rounded = std::nearbyint(units);
    lossy = lossy || rounded != units;
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(rounded));
}

// Finds the box and the steps. Reduces the margin until max_steps along each edge are enough.
void find_steps(const Domain& domain, double scale, double margin, CellImages& out) {
    const Box bounds{{domain.box.lower[0] / scale, domain.box.lower[1] / scale, domain.box.lower[2] / scale},
                     {domain.box.upper[0] / scale, domain.box.upper[1] / scale, domain.box.upper[2] / scale}};
    double longest = 0;
    out.allowed = bounds;
    for (std::size_t k = 0; k < 3; ++k) {
        const double side = bounds.upper[k] - bounds.lower[k];
        longest = std::max(longest, side);
        out.allowed.lower[k] -= side;
        out.allowed.upper[k] += side;
    }
    const auto allowed = fractions_of(domain, domain.edges, out.allowed, scale);
    const double max_margin = 2 * domain.covering_radius / scale;
    for (double m = std::clamp(margin, longest * min_margin, std::max(max_margin, longest * min_margin));; m *= 0.8) {
        if (m < longest * min_margin) m = longest * min_margin;
        out.box = bounds;
        for (std::size_t k = 0; k < 3; ++k) {
            out.box.lower[k] -= m;
            out.box.upper[k] += m;
        }
        out.box = whole_box(out.box, {true, true, true});
        const auto range = fractions_of(domain, domain.edges, out.box, scale);
        bool fits = true;
        double apart = 0;  // steps between two places of one seed
        for (std::size_t j = 0; j < 3; ++j) {
            out.data.least[j] = static_cast<int>(std::ceil(range.lower[j] - 1 - slack));
            out.data.last[j] = static_cast<int>(std::floor(range.upper[j] + slack));
            fits = fits && out.data.least[j] >= -max_steps && out.data.last[j] < max_steps;
            if (allowed.lower[j] < -max_fraction || allowed.upper[j] > max_fraction) refuse();
            apart += 2 * max_steps + allowed.upper[j] - allowed.lower[j] + 2;
        }
        if (apart > MAX_STEPS_APART) refuse();
        if (fits) return;
        if (m == longest * min_margin) refuse();
    }
}

}  // namespace

CellImages cell_images(const TriclinicBox& cell, double margin) {
    double largest = 0;
    for (const auto* numbers : {&cell.origin, &cell.a, &cell.b, &cell.c})
        for (const double x : *numbers) {
            if (!std::isfinite(x))
                throw Error(ErrorCode::invalid_argument, "cell: it holds numbers that are not finite");
            largest = std::max(largest, std::abs(x));
        }
    if (largest == 0) throw Error(ErrorCode::invalid_argument, "cell: all numbers are 0");
    const int exponent = std::clamp(-std::ilogb(largest), -1021, 1023);
    const double scale = std::ldexp(1.0, exponent);
    TriclinicBox scaled = cell;
    for (auto* numbers : {&scaled.origin, &scaled.a, &scaled.b, &scaled.c})
        for (double& x : *numbers) x *= scale;
    const Domain domain = triclinic_domain(scaled);
    if (domain.skewed) refuse();
    CellImages out;
    out.volume = domain.volume / scale / scale / scale;
    find_steps(domain, scale, margin, out);

    LatticeData& data = out.data;
    const Units units = Units::for_box(out.box);
    bool lossy = false, origin_lossy = false;
    double largest_dual = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint64_t corner = units.of(out.box.lower[k], origin_lossy);
        data.origin[k] = words(units.of(cell.origin[k], origin_lossy) - corner);
        for (std::size_t j = 0; j < 3; ++j) {
            data.vector[3 * j + k] = words(to_units(domain.vector[j][k], units.shift - exponent, lossy));
            largest_dual = std::max(largest_dual, std::abs(domain.edges.dual[j][k]));
        }
    }
    // A fraction is the sum of products with the dual, over 2^(to_fraction + fraction_bits). Its error has four parts:
    // that of the dual, from Basis; the rounding of the dual to half, times coordinates below 2^63; two units at most
    // of coordinates and origin; the last shift.
    const int dual_shift = COORDINATE_BITS - 1 - std::ilogb(largest_dual);
    const int to_fraction = dual_shift - exponent + units.shift - fraction_bits;
    if (to_fraction <= 32 || to_fraction >= 64) refuse();
    data.to_fraction = static_cast<std::uint32_t>(to_fraction);
    double error = 0, size = 0;
    for (const double x : {largest_coordinate(out.allowed) * scale, largest_coordinate(out.box) * scale, 1.0})
        size = std::max(size, x);
    for (std::size_t j = 0; j < 3; ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bool rounded = false;
            data.dual[3 * j + k] = words(to_units(domain.edges.dual[j][k], dual_shift, rounded));
            sum += std::abs(domain.edges.dual[j][k]) * std::ldexp(1.0, exponent - units.shift);
            const auto &v = domain.vector[(j + 1) % 3], &w = domain.vector[(j + 2) % 3];
            const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
            if ((v[l] == 0 || w[m] == 0) && (v[m] == 0 || w[l] == 0) && !origin_lossy) data.zeros |= 1u << (3 * j + k);
        }
        error = std::max(error, domain.edges.fraction_error(static_cast<int>(j), size) +
                                    std::ldexp(1.5, 63 - to_fraction - fraction_bits) + 2 * sum +
                                    std::ldexp(2.0, -fraction_bits));
    }
    if (!(error < 0.01)) refuse();
    data.unsure = words(static_cast<std::uint64_t>(std::ldexp(2 * error, fraction_bits)) + 1);
    data.lossy = lossy ? 1 : 0;
    return out;
}

}  // namespace votess::gpu
