// STL as text: a solid for each cell. Two cells have the same triangles between them.
#include <cstdlib>

#include "core/at.hpp"
#include "files/shared_mesh.hpp"

namespace votess::files {
namespace {

void put_places(ByteSink& out, const char* before, const Vector3& x) {
    out.put(before);
    for (const double number : x) put_next(out, number);
    out.put("\n");
}

void put_facet(const std::array<Vector3, 3>& corners, ByteSink& out) {
    Vector3 normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    const double size = length3(normal[0], normal[1], normal[2]);
    for (double& n : normal) n = size > 0 ? n / size + 0.0 : 0;  // + 0: no -0
    put_places(out, "facet normal", normal);
    out.put("outer loop\n");
    for (const Vector3& x : corners) put_places(out, "vertex", x);
    out.put("endloop\nendfacet\n");
}

}  // namespace

void write_stl(const Mesh& given, ByteSink& out) {
    const SharedMesh mesh(given);
    const CellFaces faces(mesh);
    const std::vector<std::size_t> apex = apexes(mesh);
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        const std::string name = std::to_string(mesh.rows[i]);
        out.put("solid " + name + "\n");
        for (const std::int32_t number : faces.of(i)) {
            const std::size_t face = at(std::abs(number)) - 1;
            const auto polygon = mesh.polygon(face);
            const std::size_t n = polygon.size(), first = apex[face];
            for (std::size_t k = 1; k + 1 < n; ++k) {
                std::array<Vector3, 3> corners{mesh.vertex(polygon[first]), mesh.vertex(polygon[(first + k) % n]),
                                               mesh.vertex(polygon[(first + k + 1) % n])};
                if (number < 0) std::swap(corners[1], corners[2]);
                put_facet(corners, out);
            }
        }
        out.put("endsolid " + name + "\n");
    }
}

}  // namespace votess::files
