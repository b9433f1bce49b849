// How a device sees a job's domain. A device does not clip every domain; the exact clipper takes the cells of others.
#pragma once

#include <array>
#include <optional>

#include "gpu/domain/units.hpp"
#include "input/job.hpp"

namespace votess::gpu {

// The smallest and largest fractions, along the vectors of a basis, of the points of a box. The box has lengths as
// given; times `scale` they are the domain's.
struct FractionRange {
    std::array<double, 3> lower{}, upper{};
};
[[nodiscard]] FractionRange fractions_of(const Domain& domain, const Basis& basis, const Box& box, double scale);

// The region that holds the images of a periodic domain on a device. Seeds lie in the cell of a basis of the lattice.
struct ImageRange {
    Box box;                         // of seeds and images, in the units of length given
    std::array<bool, 3> extended{};  // axes along which images enlarge it beyond the cell
    const Basis* basis = nullptr;
    FractionRange fractions;  // of the box
};

// Returns how far around a domain images matter. That is the distance of the farthest seed that cuts a cell whose
// vertices are within `radius` of its own seed, when the other seed is heavier by at most `heavier`.
[[nodiscard]] double image_margin(double radius, double heavier);

// Returns the device's box of a domain that is not periodic.
[[nodiscard]] Box device_box(const Job& job);

struct DeviceDomain {
    Box box;                           // of seeds and images, in the units of length given
    std::optional<ImageRange> images;  // of a periodic domain; refers to the job's domain
};
// Returns nothing for a job that no device clips. Its images are many times its seeds, as in a long box that lies
// across the axes; or its weights differ too much for its size; or seeds lie beyond the walls of a periodic domain, or
// very far away.
[[nodiscard]] std::optional<DeviceDomain> device_domain(const Job& job);

}  // namespace votess::gpu
