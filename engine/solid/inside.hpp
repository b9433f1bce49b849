// Which places of a domain lie in a mesh, and the parts of a ray in it.
//
// A line o + t d passes through a triangle uvw if it passes all three edges on one side. The side of an edge uv is the
// sign of det(d, u - o, v - o). The time is n.(u - o) / n.d with n = (v - u) x (w - u), and n.(u - o) is
// det(u - o, v - o, w - o). The winding number at a time is the sum of the signs of n.d over later crossings.
//
// Ties. The mesh counts as moved by (e, e^2, e^3), as in mesh_signs.hpp. This adds e ((v - u) x d) to the determinant
// of an edge, and e n to that of a time: the first component that is not 0 decides. So a line passes an edge of the
// mesh on the same side for both of its triangles, and none that lies along the line.
//
// In a periodic domain the mesh repeats. An image of it is the mesh, seen from the place moved the other way.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "domain/domain.hpp"
#include "exact/ray.hpp"
#include "solid/closed_mesh.hpp"

namespace votess::solid {

// Constant, so that many threads may use it at once.
class Inside {
public:
    // mesh: in units of the domain, with its tree.
    Inside(std::shared_ptr<const ClosedMesh> mesh, std::shared_ptr<const Domain> domain)
        : kept_(std::move(mesh)), mesh_(*kept_), domain_(std::move(domain)) {}

    [[nodiscard]] const std::shared_ptr<const ClosedMesh>& mesh() const { return kept_; }
    // Returns whether x lies inside. Exact; the surface is inside.
    [[nodiscard]] bool holds(const exact::Point& x) const;

    struct Part {
        double begin, end;  // times
    };
    // Returns the parts of a ray from time 0 to `end`, ascending. Which triangles it passes is exact, also the order of
    // its crossings; times are rounded.
    [[nodiscard]] std::vector<Part> parts(const exact::Ray& ray, double end) const;

private:
    struct Crossing {
        double time;
        std::uint32_t triangle;
        int sign;      // +1 where the ray leaves
        int of_image;  // an index
    };
    [[nodiscard]] exact::Plane image_of(const exact::Point& x, const exact::Shift& shift) const {
        return exact::Plane::bisector(x, shift, domain_->lattice);
    }
    void add_crossings(const exact::Ray& ray, const exact::Plane& image, int number, std::vector<Crossing>& to) const;
    [[nodiscard]] bool on_surface(const exact::Plane& image) const;
    [[nodiscard]] std::vector<exact::Shift> shifts_along(const exact::Ray& ray, double end) const;

    std::shared_ptr<const ClosedMesh> kept_;
    const ClosedMesh& mesh_;
    std::shared_ptr<const Domain> domain_;
};

}  // namespace votess::solid
