// How a device sees a job's domain. A device does not clip every domain; the exact clipper takes the cells of others.
#pragma once

#include <array>
#include <optional>

#include "gpu/domain/units.hpp"
#include "input/job.hpp"

namespace votess::gpu {

// The least and the largest fractions of the points of a box in lengths as given; times `scale` these are the domain's.
struct FractionRange {
    std::array<double, 3> lower{}, upper{};
};
[[nodiscard]] FractionRange fractions_of(const Domain& domain, const Basis& basis, const Box& box, double scale);

// Where a device has the images of a periodic domain. Seeds lie in the cell of a basis of the lattice.
struct ImageRange {
    Box box;                         // of seeds and images, in the units of length given
    std::array<bool, 3> extended{};  // axes along which it is larger than the cell, for the images
    const Basis* basis = nullptr;
    FractionRange fractions;  // of the box
};

// How far around a domain images count: as far as the farthest seed that cuts a cell whose vertices are within the
// radius of its own seed, and heavier than that by at most so much.
[[nodiscard]] double image_margin(double radius, double heavier);

// Returns the device's box of a domain that is not periodic.
[[nodiscard]] Box device_box(const Job& job);

struct DeviceDomain {
    Box box;                           // of seeds and images, in the units of length given
    std::optional<ImageRange> images;  // of a periodic domain; refers to the job's domain
};
// Returns nothing for a job that no device clips. Its images are many times its seeds, as in a long box that lies
// across the axes; or its weights differ too much for its size.
[[nodiscard]] std::optional<DeviceDomain> device_domain(const Job& job);

}  // namespace votess::gpu
