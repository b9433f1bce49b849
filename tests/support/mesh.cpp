#include "support/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "support/check.hpp"
#include "support/text.hpp"

namespace test {
namespace {

using votess::Tessellation;

std::size_t at(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

std::span<const std::int32_t> polygon(const Tessellation& t, std::size_t entry) {
    const auto offsets = t.face_offsets();
    return t.face_vertices().subspan(at(offsets[entry]), at(offsets[entry + 1] - offsets[entry]));
}

std::uint64_t edge_key(std::int32_t v, std::int32_t w) {
    return static_cast<std::uint64_t>(v) << 32 | static_cast<std::uint32_t>(w);
}

std::string check_shapes(const Tessellation& t) {
    const std::size_t faces = t.indices().size(), vertices = t.vertices().size() / 3;
    if (t.vertices().size() % 3 != 0) return "vertices are not triples";
    if (t.face_offsets().size() != faces + 1 || t.face_offsets()[0] != 0) return "face_offsets has a wrong shape";
    if (at(t.face_offsets()[faces]) != t.face_vertices().size()) return "face_vertices has a wrong size";
    if (t.cell_vertex_indptr().size() != t.size() + 1 || t.cell_vertex_indptr()[0] != 0)
        return "cell_vertex_indptr has a wrong shape";
    if (at(t.cell_vertex_indptr()[t.size()]) != t.cell_vertex_indices().size())
        return "cell_vertex_indices has a wrong size";
    std::vector<bool> used(vertices);
    std::int32_t next = 0;  // numbered in order of first use
    for (const std::int32_t v : t.cell_vertex_indices()) {
        if (v < 0 || at(v) >= vertices) return "a vertex does not exist";
        used[at(v)] = true;
    }
    if (std::ranges::find(used, false) != used.end()) return "a vertex belongs to no cell";
    for (std::size_t i = 0; i < t.size(); ++i)
        for (auto e = at(t.face_offsets()[at(t.indptr()[i])]); e < at(t.face_offsets()[at(t.indptr()[i + 1])]); ++e) {
            const std::int32_t v = t.face_vertices()[e];
            if (v > next) return text("vertex ", v, " is used before vertex ", next);
            if (v == next) ++next;
        }
    return {};
}

// Every edge twice, in opposite directions; the cell's own list of vertices.
std::string check_cell(const Tessellation& t, std::size_t i) {
    std::vector<std::uint64_t> edges;
    std::vector<std::int32_t> corners;
    for (auto e = at(t.indptr()[i]); e < at(t.indptr()[i + 1]); ++e) {
        const auto p = polygon(t, e);
        if (p.size() < 3) return text("cell ", i, " has a face of ", p.size(), " corners");
        for (std::size_t k = 0; k < p.size(); ++k) {
            edges.push_back(edge_key(p[k], p[(k + 1) % p.size()]));
            corners.push_back(p[k]);
        }
    }
    std::ranges::sort(edges);
    if (std::ranges::adjacent_find(edges) != edges.end()) return text("cell ", i, " has an edge twice");
    for (const std::uint64_t edge : edges)
        if (!std::ranges::binary_search(edges, edge << 32 | edge >> 32)) return text("cell ", i, " has a hole");
    std::ranges::sort(corners);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    const auto begin = at(t.cell_vertex_indptr()[i]), end = at(t.cell_vertex_indptr()[i + 1]);
    if (!std::ranges::equal(corners, t.cell_vertex_indices().subspan(begin, end - begin)))
        return text("cell ", i, " lists other vertices than its faces have");
    if (corners.size() != t.vertex_counts()[i] || edges.size() / 2 != t.edge_counts()[i])
        return text("cell ", i, " counts other vertices or edges than it has");
    return {};
}

// Area vectors from the polygons, against areas and normals; vertices on the planes of their faces.
std::string check_geometry(const Tessellation& t, std::span<const double> points, std::size_t i) {
    const double* p = points.data() + 3 * i;
    const double surface = t.surface_areas()[i], reach = t.security_radii()[i] / 2;
    double largest = 0, farthest = 0;
    for (int k = 0; k < 3; ++k)
        largest = std::max({largest, std::abs(t.box().lower[at(k)]), std::abs(t.box().upper[at(k)])});
    const double place = 1e-9 * reach + 4e-16 * largest;  // of a vertex
    double closed[3]{}, sum = 0;
    for (auto e = at(t.indptr()[i]); e < at(t.indptr()[i + 1]); ++e) {
        const double* n = t.face_normals().data() + 3 * e;
        if (std::abs(std::hypot(n[0], n[1], n[2]) - 1) > 1e-15)
            return text("cell ", i, ": a normal is not of unit length");
        const std::int32_t j = t.indices()[e];
        double height = 0;
        if (j < 0) {
            const auto axis = at(-1 - j) / 2;
            const double wall = (-1 - j) % 2 == 0 ? t.box().lower[axis] : t.box().upper[axis];
            height = std::abs(wall - p[axis]);
            if (n[axis] != ((-1 - j) % 2 == 0 ? -1 : 1)) return text("cell ", i, ": wall normal");
        } else {
            const double* q = points.data() + 3 * at(j);
            const double d = std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]);
            height = d / 2;
            for (int k = 0; k < 3; ++k)
                if (std::abs((q[k] - p[k]) / d - n[k]) > 1e-15) return text("cell ", i, ": normal of ", j);
        }
        const auto corners = polygon(t, e);
        const double* first = t.vertices().data() + 3 * at(corners[0]);
        double doubled[3]{}, rim = 0;
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const double* v = t.vertices().data() + 3 * at(corners[k]);
            const double* w = t.vertices().data() + 3 * at(corners[(k + 1) % corners.size()]);
            double above = -height, away = 0, a[3], b[3];
            for (int c = 0; c < 3; ++c) {
                above += (v[c] - p[c]) * n[c];
                away += (v[c] - p[c]) * (v[c] - p[c]);
                a[c] = v[c] - first[c];
                b[c] = w[c] - first[c];
                rim += std::abs(w[c] - v[c]);
            }
            farthest = std::max(farthest, std::sqrt(away));
            if (std::abs(above) > place) return text("cell ", i, ": a vertex is off its face with ", j, " by ", above);
            for (int c = 0; c < 3; ++c) doubled[c] += a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
        }
        const double area = (doubled[0] * n[0] + doubled[1] * n[1] + doubled[2] * n[2]) / 2;
        if (std::abs(area - t.face_areas()[e]) > 1e-9 * surface + 4 * place * rim)
            return text("cell ", i, ": the polygon with ", j, " has area ", area, ", not ", t.face_areas()[e]);
        sum += t.face_areas()[e];
        for (int k = 0; k < 3; ++k) closed[k] += t.face_areas()[e] * n[k];
    }
    if (std::abs(sum - surface) > 1e-12 * surface) return text("cell ", i, ": surface area");
    if (std::hypot(closed[0], closed[1], closed[2]) > 1e-9 * surface) return text("cell ", i, " is not closed");
    if (std::abs(farthest - reach) > 1e-9 * reach + 4e-16 * largest)
        return text("cell ", i, ": security radius ", t.security_radii()[i], ", not ", 2 * farthest);
    return {};
}

// The other side of each face has the same corners, the other way round.
std::string check_sides(const Tessellation& t) {
    for (std::size_t i = 0; i < t.size(); ++i)
        for (std::size_t k = 0; k < t.neighbors(i).size(); ++k) {
            const std::int32_t j = t.neighbors(i)[k];
            if (j < static_cast<std::int32_t>(i)) continue;
            const auto row = t.neighbors(at(j));
            const auto back =
                static_cast<std::size_t>(std::ranges::lower_bound(row, static_cast<std::int32_t>(i)) - row.begin());
            const auto here = polygon(t, at(t.indptr()[i]) + k), there = polygon(t, at(t.indptr()[at(j)]) + back);
            const auto start = static_cast<std::size_t>(std::ranges::find(there, here[0]) - there.begin());
            bool equal = here.size() == there.size();
            for (std::size_t c = 0; equal && c < here.size(); ++c)
                equal = here[c] == there[(start + here.size() - c) % here.size()];
            if (!equal) return text("cells ", i, " and ", j, " have different polygons between them");
        }
    return {};
}

std::string check_complex(const Tessellation& t) {
    std::vector<std::uint64_t> edges;
    std::size_t faces = 0, cells = 0;
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (t.status()[i] == votess::CellStatus::certified) ++cells;
        for (auto e = at(t.indptr()[i]); e < at(t.indptr()[i + 1]); ++e) {
            if (t.indices()[e] < static_cast<std::int32_t>(i))
                faces += t.indices()[e] < 0 ? 1 : 0;
            else
                ++faces;
            const auto p = polygon(t, e);
            for (std::size_t k = 0; k < p.size(); ++k) {
                const std::int32_t v = p[k], w = p[(k + 1) % p.size()];
                if (v < w) edges.push_back(edge_key(v, w));
            }
        }
    }
    std::ranges::sort(edges);
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    const auto euler = static_cast<std::int64_t>(t.vertices().size() / 3 - edges.size() + faces - cells);
    if (t.size() > 0 && euler != 1)
        return text("V - E + F - C = ", t.vertices().size() / 3, " - ", edges.size(), " + ", faces, " - ", cells, " = ",
                    euler);
    return {};
}

}  // namespace

std::string check_mesh(const Tessellation& t, std::span<const double> points) {
    if (auto failure = check_shapes(t); !failure.empty()) return failure;
    for (std::size_t i = 0; i < t.size(); ++i) {
        if (auto failure = check_cell(t, i); !failure.empty()) return failure;
        if (auto failure = check_geometry(t, points, i); !failure.empty()) return failure;
    }
    if (auto failure = check_sides(t); !failure.empty()) return failure;
    return check_complex(t);
}

std::vector<std::uint32_t> cells_of_vertices(const Tessellation& t) {
    std::vector<std::uint32_t> cells(t.vertices().size() / 3);
    for (const std::int32_t v : t.cell_vertex_indices()) ++cells[at(v)];
    return cells;
}

std::vector<bool> interior_vertices(const Tessellation& t) {
    std::vector<bool> interior(t.vertices().size() / 3, true);
    for (std::size_t e = 0; e < t.indices().size(); ++e)
        if (t.indices()[e] < 0)
            for (const std::int32_t v : polygon(t, e)) interior[at(v)] = false;
    return interior;
}

double delaunay_volume(const Tessellation& t, const votess::Delaunay& dual, std::span<const double> points) {
    std::array<std::array<double, 3>, 3> vectors{};
    for (std::size_t k = 0; k < 3; ++k) vectors[k][k] = t.box().upper[k] - t.box().lower[k];
    if (t.cell()) vectors = {t.cell()->a, t.cell()->b, t.cell()->c};
    // Seeds may lie outside of the cell; its fractions bring them in.
    const auto& [a, b, c] = vectors;
    const auto cross = [](const auto& u, const auto& v) {
        return std::array<double, 3>{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    };
    const auto dot = [](const auto& u, const auto& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; };
    const double whole = dot(a, cross(b, c));
    const auto place = [&](std::size_t seed, const std::int8_t* shift) {
        std::array<double, 3> x{};
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = points[3 * seed + k] - (t.cell() ? t.cell()->origin[k] : t.box().lower[k]);
        const double f[3] = {dot(x, cross(b, c)) / whole, dot(x, cross(c, a)) / whole, dot(x, cross(a, b)) / whole};
        for (std::size_t v = 0; v < 3; ++v)
            for (std::size_t k = 0; k < 3; ++k) x[k] += vectors[v][k] * (shift[v] - std::floor(f[v]));
        return x;
    };
    double sum = 0;
    for (std::size_t s = 0; s < dual.tetrahedra_centers.size(); ++s) {
        std::array<std::array<double, 3>, 4> corner;
        for (std::size_t k = 0; k < 4; ++k)
            corner[k] =
                place(static_cast<std::size_t>(dual.tetrahedra[4 * s + k]), &dual.tetrahedra_shifts[12 * s + 3 * k]);
        for (std::size_t k = 1; k < 4; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis) corner[k][axis] -= corner[0][axis];
        const double six = dot(corner[1], cross(corner[2], corner[3]));
        if (!(six > 0)) return -1;
        sum += six / 6;
    }
    return sum;
}

votess::Options mesh_options(const std::optional<votess::Box>& box) {
    votess::Options options = all_options(box);
    options.want.normals = options.want.surfaces = options.want.radii = options.want.faces = true;
    return options;
}

votess::Tessellation mesh_of(const PointSet& set) {
    return votess::tessellate(set.points, mesh_options(set.box));
}

}  // namespace test
