// A mesh made without search and star, and comparing meshes.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "input/options.hpp"
#include "mesh/mesh_builder.hpp"
#include "output/polygon_writer.hpp"
#include "polytope/cell.hpp"
#include "support/check.hpp"
#include "support/mesh.hpp"

namespace test {

using votess::Tessellation;

namespace {

void clip_by_all(const PointSet& set, std::size_t i, votess::cpu::Cell& cell) {
    const double* p = set.points.data() + 3 * i;
    std::vector<std::pair<double, std::int32_t>> others;
    for (std::size_t j = 0; j < set.size(); ++j) {
        const double* q = set.points.data() + 3 * j;
        if (j != i)
            others.emplace_back(std::hypot(q[0] - p[0], q[1] - p[1], q[2] - p[2]), static_cast<std::int32_t>(j));
    }
    std::ranges::sort(others);
    cell.start({p[0], p[1], p[2]}, *set.box);
    for (const auto& [distance, j] : others) {
        const double* q = set.points.data() + 3 * static_cast<std::size_t>(j);
        cell.clip(j, votess::exact::Point{q[0], q[1], q[2]});
    }
}

}  // namespace

Tessellation mesh_of_clipped_cells(const PointSet& set) {
    votess::Options options = all_options(set.box);
    options.want.faces = options.want.vertices = true;
    const votess::Job job = votess::validate({set.points, {}}, options);
    votess::ThreadPool pool(1);
    votess::MeshBuilder builder;
    builder.begin(job);
    auto result = std::make_shared<votess::detail::Result>();
    std::vector<std::int32_t> cells(set.size()), indices;
    std::iota(cells.begin(), cells.end(), 0);
    std::vector<std::int64_t> indptr{0};
    votess::cpu::PolygonWriter writer;
    votess::cpu::Cell cell;
    votess::cpu::CellFaces faces;
    votess::cpu::CellPolygons polygons;
    for (std::size_t i = 0; i < set.size(); ++i) {
        clip_by_all(set, i, cell);
        cell.canonical_faces(faces);
        std::vector<votess::FaceLabel> labels;
        for (const std::int32_t p : faces.planes) labels.push_back({cell.planes()[static_cast<std::size_t>(p)].id, {}});
        std::vector<std::uint32_t> order(labels.size());
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::sort(order, {}, [&](std::uint32_t f) { return labels[f]; });
        std::vector<std::uint32_t> ranks(order.size());
        for (std::size_t r = 0; r < order.size(); ++r) ranks[order[r]] = static_cast<std::uint32_t>(r);
        votess::cpu::read_polygons(cell, faces, ranks, polygons);
        for (const std::uint32_t f : order) indices.push_back(labels[f].id);
        indptr.push_back(static_cast<std::int64_t>(indices.size()));
        const double* p = set.points.data() + 3 * i;
        writer.append(polygons, labels, order, 0, {p[0], p[1], p[2]});
    }
    builder.add(cells, writer.block());
    result->indptr.resize_uninitialized(indptr.size());
    std::ranges::copy(indptr, result->indptr.begin());
    result->indices.resize_uninitialized(indices.size());
    std::ranges::copy(indices, result->indices.begin());
    result->status.resize_uninitialized(set.size());
    std::ranges::fill(result->status, votess::CellStatus::certified);
    builder.finish(*result, pool);
    return Tessellation(std::move(result));
}

std::string check_same_mesh(const Tessellation& a, const Tessellation& b) {
    if (!std::ranges::equal(a.indices(), b.indices())) return "rows differ";
    if (!std::ranges::equal(a.face_offsets(), b.face_offsets())) return "face_offsets differ";
    if (!std::ranges::equal(a.face_vertices(), b.face_vertices())) return "face_vertices differ";
    if (!std::ranges::equal(a.cell_vertex_indptr(), b.cell_vertex_indptr())) return "cell_vertex_indptr differs";
    if (!std::ranges::equal(a.cell_vertex_indices(), b.cell_vertex_indices())) return "cell_vertex_indices differ";
    if (a.vertices().size() != b.vertices().size()) return "other vertices";
    const double size = b.box().upper[0] - b.box().lower[0];
    for (std::size_t k = 0; k < a.vertices().size(); ++k)
        if (!(std::abs(a.vertices()[k] - b.vertices()[k]) <= 1e-9 * size))
            return "vertex " + std::to_string(k / 3) + " lies elsewhere";
    return "";
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

}  // namespace test
