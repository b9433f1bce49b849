// Measures of a mesh as OpenFOAM's checkMesh has them, and of volumes also between the triangles of other files.
#include <algorithm>
#include <limits>
#include <numbers>

#include "files/shared_mesh.hpp"

namespace votess::files {
namespace {

constexpr double severe = 70, skew = 4;  // above which checkMesh counts a face

Vector3 sum_of(const Vector3& a, const Vector3& b, double times = 1) {
    return {a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]};
}
struct CellMeasures {
    std::vector<double> volumes;
    std::vector<Vector3> centers;
};

// Sums over pyramids between the faces and the mean of their centers.
CellMeasures measure_cells(const SharedMesh& mesh, const std::vector<FaceMeasure>& faces) {
    CellMeasures cells{std::vector<double>(mesh.cells()), std::vector<Vector3>(mesh.cells())};
    std::vector<Vector3> middle(mesh.cells());
    std::vector<double> count(mesh.cells());
    const auto each = [&](const auto& use) {
        for (std::size_t f = 0; f < faces.size(); ++f) {
            use(static_cast<std::size_t>(mesh.faces[f].owner), faces[f], 1.0);
            if (mesh.faces[f].neighbor >= 0) use(static_cast<std::size_t>(mesh.faces[f].neighbor), faces[f], -1.0);
        }
    };
    each([&](std::size_t cell, const FaceMeasure& face, double) {
        middle[cell] = sum_of(middle[cell], face.center);
        ++count[cell];
    });
    for (std::size_t i = 0; i < mesh.cells(); ++i)
        for (double& x : middle[i]) x /= count[i];
    each([&](std::size_t cell, const FaceMeasure& face, double sign) {
        const Vector3 arm = minus(face.center, middle[cell]);
        const double pyramid = sign * dot(face.area, arm) / 3;
        cells.volumes[cell] += pyramid;
        cells.centers[cell] = sum_of(cells.centers[cell], arm, pyramid * 3 / 4);
    });
    for (std::size_t i = 0; i < mesh.cells(); ++i)
        cells.centers[i] = sum_of(middle[i], cells.centers[i], cells.volumes[i] > 0 ? 1 / cells.volumes[i] : 0);
    return cells;
}

// Returns the volumes between the triangles that files of triangles have.
std::vector<double> volumes_in_triangles(const SharedMesh& mesh, const CellMeasures& cells) {
    const std::vector<std::size_t> apex = apexes(mesh);
    std::vector<double> volumes(mesh.cells());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto polygon = mesh.polygon(f);
        const std::size_t n = polygon.size(), first = apex[f];
        const auto add = [&](std::int32_t cell, double sign) {
            const auto i = static_cast<std::size_t>(cell);
            const auto corner = [&](std::size_t k) {
                return minus(mesh.vertex(polygon[(first + k) % n]), cells.centers[i]);
            };
            for (std::size_t k = 1; k + 1 < n; ++k)
                volumes[i] += sign * dot(corner(0), cross(corner(k), corner(k + 1))) / 6;
        };
        add(mesh.faces[f].owner, 1);
        if (mesh.faces[f].neighbor >= 0) add(mesh.faces[f].neighbor, -1);
    }
    return volumes;
}

}  // namespace

FaceMeasure measure_face(const SharedMesh& mesh, std::size_t face) {
    const auto polygon = mesh.polygon(face);
    const Vector3 origin = mesh.vertex(polygon[0]);
    Vector3 middle{};
    for (const std::int32_t v : polygon)
        middle = sum_of(middle, minus(mesh.vertex(v), origin), 1 / static_cast<double>(polygon.size()));
    FaceMeasure result;
    double weight = 0;
    for (std::size_t c = 0; c < polygon.size(); ++c) {
        const Vector3 a = minus(minus(mesh.vertex(polygon[c]), origin), middle),
                      b = minus(minus(mesh.vertex(polygon[(c + 1) % polygon.size()]), origin), middle);
        const Vector3 area = cross(a, b);
        const double size = length3(area);
        result.area = sum_of(result.area, area, 0.5);
        result.center = sum_of(result.center, sum_of(a, b), size / 3);
        weight += size;
    }
    const Vector3 offset = sum_of(middle, result.center, weight > 0 ? 1 / weight : 0);
    result.center = sum_of(origin, offset);
    return result;
}

MeshQuality measure(const SharedMesh& mesh) {
    MeshQuality quality;
    std::vector<FaceMeasure> faces(mesh.faces.size());
    double least_edge = std::numeric_limits<double>::infinity(), least_area = least_edge, least_volume = least_edge;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        faces[f] = measure_face(mesh, f);
        least_area = std::min(least_area, length3(faces[f].area));
        const auto polygon = mesh.polygon(f);
        for (std::size_t c = 0; c < polygon.size(); ++c)
            least_edge = std::min(
                least_edge, length3(minus(mesh.vertex(polygon[c]), mesh.vertex(polygon[(c + 1) % polygon.size()]))));
    }
    const CellMeasures cells = measure_cells(mesh, faces);
    const std::vector<double> in_triangles = volumes_in_triangles(mesh, cells);
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        const double volume = std::min(cells.volumes[i], in_triangles[i]);
        least_volume = std::min(least_volume, volume);
        quality.wrong_cells += volume > 0 ? 0 : 1;
    }
    if (mesh.cells() > 0)
        quality.min_area = least_area, quality.min_volume = least_volume, quality.min_edge = least_edge;

    double angles = 0;
    std::uint64_t inner = 0;
    // between: from the owner's center to the neighbor's, or to the wall along its normal.
    const auto add = [&](std::size_t f, const Vector3& between, bool is_inner) {
        const FaceMeasure& face = faces[f];
        const double area = length3(face.area), distance = length3(between), along = dot(face.area, between);
        if (!(along > 0)) {
            ++quality.wrong_faces;
            return;
        }
        if (is_inner) {
            const double angle = std::acos(std::min(1.0, along / (area * distance))) * 180 / std::numbers::pi;
            quality.max_non_orthogonality = std::max(quality.max_non_orthogonality, angle);
            quality.severe_faces += angle > severe ? 1 : 0;
            angles += angle;
            ++inner;
        }
        const Vector3 arm = minus(face.center, cells.centers[static_cast<std::size_t>(mesh.faces[f].owner)]);
        const Vector3 off = sum_of(arm, between, -dot(face.area, arm) / along);
        const double off_length = length3(off);
        double size = (is_inner ? 0.2 : 0.4) * distance;
        for (const std::int32_t v : mesh.polygon(f))
            if (off_length > 0)
                size = std::max(size, std::abs(dot(off, minus(mesh.vertex(v), face.center))) / off_length);
        quality.max_skewness = std::max(quality.max_skewness, off_length / size);
        quality.skew_faces += off_length > skew * size ? 1 : 0;
    };
    const auto center = [&](std::int32_t cell) { return cells.centers[static_cast<std::size_t>(cell)]; };
    for (std::size_t f = 0; f < mesh.inner(); ++f)
        add(f, minus(center(mesh.faces[f].neighbor), center(mesh.faces[f].owner)), true);
    for (const Patch& patch : mesh.patches) {
        const Vector3 apart = mesh.separation(patch);
        for (std::size_t k = 0; k < patch.count; ++k) {
            const std::size_t f = patch.first + k;
            const Vector3 own = center(mesh.faces[f].owner);
            if (patch.wall == 0) {
                if (patch.twin < static_cast<std::size_t>(&patch - mesh.patches.data())) continue;  // seen from there
                const Vector3 other = center(mesh.faces[mesh.patches[patch.twin].first + k].owner);
                add(f, minus(sum_of(other, apart), own), true);
            } else {
                const double area2 = dot(faces[f].area, faces[f].area);
                const Vector3 arm = minus(faces[f].center, own);
                add(f, sum_of({}, faces[f].area, area2 > 0 ? dot(faces[f].area, arm) / area2 : 0), false);
            }
        }
    }
    quality.mean_non_orthogonality = inner > 0 ? angles / static_cast<double>(inner) : 0;
    return quality;
}

}  // namespace votess::files
