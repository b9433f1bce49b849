// Neper's .tess: polyhedra with shared faces, edges and vertices, the seeds, and the polyhedron around all.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "files/shared_mesh.hpp"
#include "input/option_name.hpp"
#include "votess/votess.hpp"

namespace votess::files {
namespace {

// Writes how many there are, then each, counted from 1.
void put_list(ByteSink& out, const std::vector<std::size_t>& list) {
    put_next(out, list.size());
    for (const std::size_t k : list) put_next(out, k + 1);
}

void put_numbers(ByteSink& out, const Vector3& vector) {
    for (const double x : vector) put_next(out, x);
}

// Writes d, a, b, c of the plane a x + b y + c z = d. The face has the rounded corners of a cell: components within
// their errors are 0, as those of a wall along an axis. place: on the plane.
void put_plane(ByteSink& out, const FaceMeasure& face, const Vector3& place, double sign) {
    constexpr double rounding = 0x1p-44;
    Vector3 normal = face.area;
    const double area = length3(normal[0], normal[1], normal[2]);
    for (double& x : normal) x = std::abs(x) > rounding * area ? sign * x / area : 0;
    put_next(out, dot(normal, place) + 0.0);  // + 0: no -0
    put_numbers(out, normal);
}

// A polygon of the polyhedron around all cells: its corners, and the edge after each.
struct Loop {
    std::vector<std::size_t> corners, edges;
};

// The polyhedron around all cells. Its faces are the patches.
struct Domain {
    struct Edge {
        std::array<std::size_t, 2> patches, corners;
        std::vector<std::size_t> parts;  // edges of cells
    };
    std::vector<std::int32_t> corners;  // vertices
    std::vector<std::vector<std::size_t>> patches_of_corners;
    std::vector<Edge> edges;
    std::vector<Loop> loops;  // of each patch

    Domain(const SharedMesh& mesh, const SharedEdges& edges_of_mesh) : loops(mesh.patches.size()) {
        struct Step {  // along the rim of a patch
            std::size_t patch;
            std::int32_t from, to;
            std::size_t edge;
            std::size_t other = 0;  // patch
        };
        std::vector<std::vector<Step>> by_edge(edges_of_mesh.ends.size());
        for (std::size_t p = 0; p < mesh.patches.size(); ++p)
            for (std::size_t f = mesh.patches[p].first; f < mesh.patches[p].first + mesh.patches[p].count; ++f) {
                const auto polygon = mesh.polygon(f);
                for (std::size_t c = 0; c < polygon.size(); ++c) {
                    const std::int32_t edge =
                        std::abs(edges_of_mesh.of_corners[static_cast<std::size_t>(mesh.offsets[f]) + c]) - 1;
                    by_edge[static_cast<std::size_t>(edge)].push_back(
                        {p, polygon[c], polygon[(c + 1) % polygon.size()], static_cast<std::size_t>(edge)});
                }
            }
        std::vector<std::map<std::int32_t, Step>> rims(mesh.patches.size());  // by the vertex where each step begins
        for (auto& steps : by_edge) {
            if (steps.size() != 2 || steps[0].patch == steps[1].patch) continue;
            steps[0].other = steps[1].patch, steps[1].other = steps[0].patch;
            for (const Step& step : steps) rims[step.patch].emplace(step.from, step);
        }
        std::map<std::int32_t, std::vector<std::size_t>> at;  // patches at each corner
        for (std::size_t p = 0; p < rims.size(); ++p)
            for (const auto& [from, step] : rims[p]) {
                const auto next = rims[p].find(step.to);
                if (next == rims[p].end()) refuse("the cells are not those of a convex domain: .tess cannot hold them");
                if (next->second.other != step.other) at[step.to].push_back(p);
            }
        for (auto& [vertex, patches] : at) {
            corners.push_back(vertex);
            std::ranges::sort(patches);
            patches_of_corners.push_back(patches);
        }
        std::map<std::pair<std::size_t, std::size_t>, std::size_t> numbers;  // of edges, by their patches
        for (std::size_t p = 0; p < rims.size(); ++p) {
            const auto is_corner = [&](std::int32_t v) { return std::ranges::binary_search(corners, v); };
            const auto first = std::ranges::find_if(rims[p], [&](const auto& e) { return is_corner(e.first); });
            if (first == rims[p].end()) refuse("the domain has a face without corners: .tess cannot hold it");
            const Step* step = &first->second;
            do {
                const auto [found, is_new] =
                    numbers.try_emplace({std::min(p, step->other), std::max(p, step->other)}, edges.size());
                if (is_new) edges.push_back({{p, step->other}, {}, {}});
                Edge& edge = edges[found->second];
                if (is_corner(step->from)) {
                    loops[p].corners.push_back(number_of(step->from));
                    loops[p].edges.push_back(found->second);
                    if (is_new) edge.corners[0] = number_of(step->from);
                }
                if (edge.patches[0] == p) {
                    edge.parts.push_back(step->edge);
                    if (is_corner(step->to)) edge.corners[1] = number_of(step->to);
                }
                step = &rims[p].at(step->to);
            } while (step != &first->second);
        }
    }

    [[nodiscard]] std::size_t number_of(std::int32_t vertex) const {
        return static_cast<std::size_t>(std::ranges::lower_bound(corners, vertex) - corners.begin());
    }
};

void put_domain(const Mesh& given, const SharedMesh& mesh, const SharedEdges& edges, ByteSink& out) {
    const Domain domain(mesh, edges);
    const bool cube = !given.skewed && mesh.patches.size() == 6 && mesh.patches.back().wall == -6;
    static constexpr std::array sides{"x0", "x1", "y0", "y1", "z0", "z1"};
    const auto label = [&](std::vector<std::size_t> patches) {
        std::ranges::sort(patches);
        std::string result;
        for (const std::size_t p : patches)
            if (cube)
                result += sides[p];
            else
                result.append("f").append(std::to_string(p + 1));
        return result;
    };
    out.put(std::string(" **domain\n  *general\n   ") + (cube ? "cube" : "poly") + "\n  *vertex\n  ");
    put_next(out, domain.corners.size());
    for (std::size_t k = 0; k < domain.corners.size(); ++k) {
        out.put("\n  ");
        put_next(out, k + 1);
        Vector3 corner = mesh.vertex(domain.corners[k]);
        if (cube)  // as given, without rounding
            for (const std::size_t p : domain.patches_of_corners[k]) corner[p / 2] = given.bounds[p % 2][p / 2];
        put_numbers(out, corner);
        out.put(" ");
        out.put(label(domain.patches_of_corners[k]));
        out.put("\n     ");
        put_list(out, {static_cast<std::size_t>(domain.corners[k])});
    }
    out.put("\n  *edge\n  ");
    put_next(out, domain.edges.size());
    for (std::size_t k = 0; k < domain.edges.size(); ++k) {
        const Domain::Edge& edge = domain.edges[k];
        out.put("\n  ");
        put_next(out, k + 1);
        put_list(out, {edge.corners[0], edge.corners[1]});
        out.put("\n     " + label({edge.patches[0], edge.patches[1]}) + "\n    ");
        put_list(out, edge.parts);
    }
    out.put("\n  *face\n  ");
    put_next(out, mesh.patches.size());
    for (std::size_t p = 0; p < mesh.patches.size(); ++p) {
        out.put("\n  ");
        put_next(out, p + 1);
        put_list(out, domain.loops[p].corners);
        out.put("\n    ");
        put_list(out, domain.loops[p].edges);
        out.put("\n     plane\n     4");
        std::vector<std::size_t> faces(mesh.patches[p].count);
        for (std::size_t k = 0; k < faces.size(); ++k) faces[k] = mesh.patches[p].first + k;
        const auto area2 = [&](std::size_t f) {
            const Vector3 area = measure_face(mesh, f).area;
            return dot(area, area);
        };
        if (cube) {  // inward
            Vector3 normal{};
            normal[p / 2] = p % 2 == 0 ? 1 : -1;
            put_next(out, normal[p / 2] * given.bounds[p % 2][p / 2] + 0.0);
            put_numbers(out, normal);
        } else {
            const std::size_t largest = *std::ranges::max_element(faces, {}, area2);
            put_plane(out, measure_face(mesh, largest), mesh.vertex(mesh.polygon(largest)[0]), -1);
        }
        out.put("\n     " + label({p}) + "\n    ");
        put_list(out, faces);
    }
    out.put("\n");
}

}  // namespace

void write_tess(const Mesh& given, ByteSink& out) {
    const SharedMesh mesh(given);
    if (given.left_out) refuse(".tess holds cells of a domain with ends: give a box");
    if (!mesh.patches.empty() && mesh.patches.back().wall == 0)
        refuse(".tess holds no periodic boundary here: write .msh or .foam, or tessellate without " +
               option("periodic"));
    if (given.seeds.empty() && mesh.cells() > 0) refuse("mesh.seeds is NULL, but .tess needs seeds");
    const SharedEdges edges(mesh);
    out.put("***tess\n **format\n   3.5\n **general\n   3 standard\n **cell\n  ");
    put_next(out, mesh.cells());
    if (mesh.cells() < given.cells()) {
        out.put("\n  *id\n  ");
        for (const std::size_t row : mesh.rows) put_next(out, row + 1);
    }
    // Neper's weights are radii: they count squared.
    const double least = given.weights.empty() ? 0 : std::min(0.0, *std::ranges::min_element(given.weights));
    out.put("\n  *seed\n");
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        const std::size_t row = mesh.rows[i];
        out.put("  ");
        put_next(out, i + 1);
        for (const double x : given.seeds.subspan(3 * row, 3)) put_next(out, x);
        put_next(out, given.weights.empty() ? 0.0 : std::sqrt(given.weights[row] - least));
        out.put("\n");
    }
    const std::size_t vertices = mesh.vertices.size() / 3;
    out.put(" **vertex\n ");
    put_next(out, vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
        out.put("\n  ");
        put_next(out, v + 1);
        put_numbers(out, mesh.vertex(static_cast<std::int32_t>(v)));
        out.put(mesh.moved[v] != 0 ? " 1" : " 0");
    }
    out.put("\n **edge\n ");
    put_next(out, edges.ends.size());
    for (std::size_t e = 0; e < edges.ends.size(); ++e) {
        out.put("\n  ");
        put_next(out, e + 1);
        for (const std::int32_t v : edges.ends[e]) put_next(out, v + 1);
        out.put(" 0");
    }
    out.put("\n **face\n ");
    put_next(out, mesh.faces.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto polygon = mesh.polygon(f);
        out.put("\n  ");
        put_next(out, f + 1);
        put_next(out, polygon.size());
        for (const std::int32_t v : polygon) put_next(out, v + 1);
        out.put("\n    ");
        put_next(out, polygon.size());
        for (std::size_t c = 0; c < polygon.size(); ++c)
            put_next(out, edges.of_corners[static_cast<std::size_t>(mesh.offsets[f]) + c]);
        out.put("\n    ");
        const FaceMeasure measure = measure_face(mesh, f);
        put_plane(out, measure, measure.center, 1);
        // The state of a face with moved vertices is 1: it need not be flat, and is that around its center.
        const bool moved =
            std::ranges::any_of(polygon, [&](std::int32_t v) { return mesh.moved[static_cast<std::size_t>(v)] != 0; });
        out.put(moved ? "\n     1 0" : "\n     0 0");
        put_numbers(out, moved ? measure_face(mesh, f).center : Vector3{});
    }
    out.put("\n **polyhedron\n ");
    put_next(out, mesh.cells());
    const CellFaces faces(mesh);
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        out.put("\n  ");
        put_next(out, i + 1);
        put_next(out, faces.of(i).size());
        for (const std::int32_t face : faces.of(i)) put_next(out, face);
    }
    out.put("\n");
    put_domain(given, mesh, edges, out);
    out.put("***end\n");
}

}  // namespace votess::files
