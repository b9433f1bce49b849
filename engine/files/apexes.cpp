// Chooses the triangles of faces: a fan for each, around a corner.
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "core/at.hpp"
#include "files/shared_mesh.hpp"

namespace votess::files {
namespace {

using Line = std::array<std::int32_t, 2>;  // the lower vertex first

// Returns the corners from best to worst: those with flat fans first, then by the thickness of the thinnest triangle.
// Thickness is the area, divided by the square of the longest side.
std::vector<std::size_t> by_thickness(const SharedMesh& mesh, std::size_t face) {
    const auto polygon = mesh.polygon(face);
    const std::size_t n = polygon.size();
    constexpr double near = 0.8;  // cosine of 37 degrees
    std::vector<std::tuple<int, double, std::size_t>> ratios;
    for (std::size_t apex = 0; apex < n; ++apex) {
        double least = std::numeric_limits<double>::infinity();
        const Vector3 origin = mesh.vertex(polygon[apex]);
        for (std::size_t k = 1; k + 1 < n; ++k) {
            const Vector3 a = minus(mesh.vertex(polygon[(apex + k) % n]), origin),
                          b = minus(mesh.vertex(polygon[(apex + k + 1) % n]), origin), c = minus(b, a),
                          area = cross(a, b);
            const double longest = std::max({dot(a, a), dot(b, b), dot(c, c)});
            least = std::min(least, longest > 0 ? std::sqrt(dot(area, area)) / longest : 0);
        }
        const double worst = mesh.normals.empty() ? 1 : worst_cosine(mesh, polygon, apex, mesh.normals[face]);
        ratios.emplace_back((worst < near ? 1 : 0) + (worst < flat_fan ? 1 : 0), -least, apex);
    }
    std::ranges::sort(ratios);
    std::vector<std::size_t> result;
    for (const auto& [folds, thickness, apex] : ratios) result.push_back(apex);
    return result;
}

// Diagonals must not be where another face has a diagonal or a side, else triangles could coincide. Faces of polyhedra
// share a side at most, but after collapse_edges() two of them may share several corners.
class FanChooser {
public:
    explicit FanChooser(const SharedMesh& mesh) : mesh_(mesh) {
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
            const auto polygon = mesh.polygon(f);
            for (std::size_t c = 0; c < polygon.size(); ++c) take(polygon[c], polygon[(c + 1) % polygon.size()]);
        }
    }

    // Returns whether the fan's diagonals are free.
    [[nodiscard]] bool is_free(std::size_t face, std::size_t apex) const {
        return std::ranges::none_of(diagonals(face, apex), [&](const Line& line) { return taken_.contains(line); });
    }
    void take_fan(std::size_t face, std::size_t apex) {
        for (const auto& [a, b] : diagonals(face, apex)) take(a, b);
    }

private:
    // Only those at vertices that others joined can coincide with others.
    [[nodiscard]] bool may_coincide(std::int32_t a, std::int32_t b) const {
        return mesh_.moved[at(a)] != 0 || mesh_.moved[at(b)] != 0;
    }
    void take(std::int32_t a, std::int32_t b) {
        if (may_coincide(a, b)) taken_.insert({std::min(a, b), std::max(a, b)});
    }
    [[nodiscard]] std::vector<Line> diagonals(std::size_t face, std::size_t apex) const {
        const auto polygon = mesh_.polygon(face);
        std::vector<Line> lines;
        for (std::size_t k = 2; k + 1 < polygon.size(); ++k) {
            const std::int32_t a = polygon[apex], b = polygon[(apex + k) % polygon.size()];
            if (may_coincide(a, b)) lines.push_back({std::min(a, b), std::max(a, b)});
        }
        return lines;
    }

    const SharedMesh& mesh_;
    std::set<Line> taken_;
};

}  // namespace

double worst_cosine(const SharedMesh& mesh, std::span<const std::int32_t> polygon, std::size_t apex,
                    const Vector3& direction) {
    constexpr double no_area = 1e-9;  // triangles in a straight line have any direction
    const std::size_t n = polygon.size();
    const Vector3 origin = mesh.vertex(polygon[apex]);
    const double size = length3(direction[0], direction[1], direction[2]);
    double worst = 1;
    for (std::size_t k = 1; k + 1 < n; ++k) {
        const Vector3 area = cross(minus(mesh.vertex(polygon[(apex + k) % n]), origin),
                                   minus(mesh.vertex(polygon[(apex + k + 1) % n]), origin));
        const double length = length3(area[0], area[1], area[2]);
        if (length > no_area * size) worst = std::min(worst, dot(area, direction) / (length * size));
    }
    return worst;
}

std::vector<std::size_t> apexes(const SharedMesh& mesh) {
    constexpr auto none = static_cast<std::size_t>(-1);
    std::vector<std::size_t> twins(mesh.faces.size(), none), result(mesh.faces.size(), none);
    for (const Patch& patch : mesh.patches)
        for (std::size_t k = 0; patch.wall == 0 && k < patch.count; ++k)
            twins[patch.first + k] = mesh.patches[patch.twin].first + k;
    FanChooser fans(mesh);
    for (std::size_t f = 0; f < result.size(); ++f) {
        if (result[f] != none) continue;
        const std::size_t corners = mesh.polygon(f).size(), twin = twins[f];
        const auto in_twin = [&](std::size_t apex) { return (corners - apex) % corners; };
        const std::vector<std::size_t> candidates = by_thickness(mesh, f);
        const auto found = std::ranges::find_if(candidates, [&](std::size_t apex) {
            return fans.is_free(f, apex) && (twin == none || fans.is_free(twin, in_twin(apex)));
        });
        result[f] = found != candidates.end() ? *found : candidates.front();
        fans.take_fan(f, result[f]);
        if (twin == none) continue;
        result[twin] = in_twin(result[f]);
        fans.take_fan(twin, result[twin]);
    }
    return result;
}

}  // namespace votess::files
