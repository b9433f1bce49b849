#include "surface/mesh_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "surface/nearest.hpp"

namespace votess::surface {
namespace {

Vector3 place_at(const std::vector<double>& places, std::int32_t i) {
    const std::size_t k = 3 * at(i);
    return {places[k], places[k + 1], places[k + 2]};
}

// Returns how many triangles meet at each edge.
std::vector<std::size_t> triangles_at_edges(const std::vector<std::int32_t>& triangles) {
    std::vector<std::pair<std::int32_t, std::int32_t>> sides;
    for (std::size_t k = 0; k < triangles.size(); ++k)
        sides.push_back(std::minmax({triangles[k], triangles[k % 3 == 2 ? k - 2 : k + 1]}));
    std::ranges::sort(sides);
    std::vector<std::size_t> counts;
    for (std::size_t k = 0; k < sides.size(); ++k) {
        if (k == 0 || sides[k] != sides[k - 1]) counts.push_back(0);
        ++counts.back();
    }
    return counts;
}

// A tree of boxes over triangles.
class TriangleTree {
public:
    TriangleTree(const std::vector<double>& vertices, const std::vector<std::int32_t>& triangles) {
        for (std::size_t k = 0; k < triangles.size(); k += 3)
            triangles_.push_back({place_at(vertices, triangles[k]), place_at(vertices, triangles[k + 1]),
                                  place_at(vertices, triangles[k + 2])});
        if (!triangles_.empty()) split(0, triangles_.size());
    }

    // Returns the distance of a place from the triangles, or a distance of at most `enough` if there is one.
    [[nodiscard]] double distance_from(const Vector3& x, double enough) const {
        double least = infinity;
        if (!nodes_.empty()) search(0, x, enough, least);
        return least;
    }

private:
    using Triangle = std::array<Vector3, 3>;
    struct Node {
        Box box;
        std::size_t begin, end;  // triangles
        std::size_t second = 0;  // the second child, the first follows; 0 for a leaf
    };
    static constexpr std::size_t leaf_triangles = 4;

    void split(std::size_t begin, std::size_t end) {
        if (nodes_.size() % 1024 == 0) check_stop();
        const std::size_t node = nodes_.size();
        Node made{empty_box, begin, end};
        for (std::size_t t = begin; t < end; ++t)
            for (const Vector3& x : triangles_[t]) include(made.box, x);
        nodes_.push_back(made);
        if (end - begin <= leaf_triangles) return;
        const Vector3 size = minus(made.box.upper, made.box.lower);
        const auto axis = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
        const auto sum = [axis](const Triangle& t) { return t[0][axis] + t[1][axis] + t[2][axis]; };
        const std::size_t half = begin + (end - begin) / 2;
        const auto first = triangles_.begin();
        std::ranges::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(half),
                                 first + static_cast<std::ptrdiff_t>(end), {}, sum);
        split(begin, half);
        nodes_[node].second = nodes_.size();
        split(half, end);
    }

    void search(std::size_t node, const Vector3& x, double enough, double& least) const {
        if (least <= enough || distance_squared(x, nodes_[node].box) >= least * least) return;
        const Node& of = nodes_[node];
        if (of.second == 0) {
            for (std::size_t t = of.begin; t < of.end; ++t) {
                const auto& [a, b, c] = triangles_[t];
                least = std::min(least, distance(x, nearest_on_triangle(x, a, b, c)));
            }
            return;
        }
        std::size_t near = node + 1, far = of.second;
        if (distance_squared(x, nodes_[far].box) < distance_squared(x, nodes_[near].box)) std::swap(near, far);
        search(near, x, enough, least);
        search(far, x, enough, least);
    }

    std::vector<Triangle> triangles_;
    std::vector<Node> nodes_;
};

// Returns the largest distance found between a mesh and the surface that its cells lie on.
double distance_of(const Remesh& mesh, const solid::MeshArrays& surface) {
    if (mesh.triangles.empty()) return infinity;
    double largest = 0;
    const auto widen = [&](const TriangleTree& tree, const Vector3& x) {
        check_stop();
        largest = std::max(largest, tree.distance_from(x, largest));
    };
    const TriangleTree of_mesh(mesh.vertices, mesh.triangles), of_surface(surface.vertices, surface.triangles);
    std::vector<std::int32_t> corners = mesh.cells.corners;
    std::ranges::sort(corners);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    for (const std::int32_t corner : corners) widen(of_mesh, place_at(mesh.cells.vertices, corner));
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
        const Vector3 a = place_at(mesh.vertices, mesh.triangles[t]),
                      b = place_at(mesh.vertices, mesh.triangles[t + 1]),
                      c = place_at(mesh.vertices, mesh.triangles[t + 2]);
        const auto middle = [](const Vector3& u, const Vector3& v) { return along(u, minus(v, u), 0.5); };
        for (const Vector3& x :
             {middle(a, b), middle(b, c), middle(c, a), along(middle(a, b), minus(c, middle(a, b)), 1.0 / 3)})
            widen(of_surface, x);
    }
    return largest;
}

void measure_angles(Remesh& mesh) {
    const std::size_t count = mesh.triangles.size() / 3;
    mesh.min_angle = count > 0 ? 180 : 0;
    double sum = 0;
    for (std::size_t t = 0; t < count; ++t) {
        double least = 180;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector3 x = place_at(mesh.vertices, mesh.triangles[3 * t + k]);
            const Vector3 a = minus(place_at(mesh.vertices, mesh.triangles[3 * t + (k + 1) % 3]), x);
            const Vector3 b = minus(place_at(mesh.vertices, mesh.triangles[3 * t + (k + 2) % 3]), x);
            const Vector3 n = cross(a, b);
            least = std::min(least, std::atan2(length3(n[0], n[1], n[2]), dot(a, b)) * 180 / std::numbers::pi);
        }
        sum += least;
        mesh.min_angle = std::min(mesh.min_angle, least);
    }
    mesh.mean_min_angle = count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace

void report_on_mesh(Remesh& mesh, const Regions& regions, const Features& features, const solid::MeshArrays& surface) {
    measure_angles(mesh);
    for (const std::size_t triangles : triangles_at_edges(mesh.triangles)) {
        mesh.border_edges += triangles == 1 ? 1 : 0;
        mesh.crowded_edges += triangles > 2 ? 1 : 0;
    }
    std::vector<std::uint8_t> bad = regions.faults();
    for (const Features::Gap& gap : features.gaps(regions.faces(), mesh.vertices)) bad[gap.piece] = 1;
    const SurfaceCells& faces = regions.faces();
    for (std::size_t f = 0; f < faces.polygon_pieces.size(); ++f)
        if (bad[at(faces.polygon_pieces[f])] != 0) mesh.faults.push_back(faces.polygon_seeds[f]);
    std::ranges::sort(mesh.faults);
    mesh.faults.erase(std::unique(mesh.faults.begin(), mesh.faults.end()), mesh.faults.end());
    mesh.distance = distance_of(mesh, surface);
}

}  // namespace votess::surface
