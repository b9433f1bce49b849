// Makes one vertex of the ends of short edges, so that solvers need no tiny faces. Each step is tried on the cells
// around it and undone where one of them would not stay a polyhedron. An edge at a periodic boundary goes together with
// its images.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <ranges>
#include <span>

#include "core/at.hpp"
#include "core/progress.hpp"
#include "files/shared_mesh.hpp"

namespace votess::files {
namespace {

using Polygon = std::vector<std::int32_t>;

struct Edge {
    std::int32_t kept, dropped;
    friend auto operator<=>(const Edge&, const Edge&) = default;
};

class Collapser {
public:
    explicit Collapser(SharedMesh& mesh)
        : mesh_(mesh),
          polygons_(mesh.faces.size()),
          areas_(mesh.faces.size()),
          thin_(mesh.faces.size()),
          twins_(mesh.faces.size(), none),
          apart_(mesh.faces.size()),
          faces_of_(mesh.vertices.size() / 3),
          walls_(faces_of_.size()),
          cells_(mesh),
          volumes_(mesh.cells()) {
        for (const double x : mesh.vertices) rounding_ = std::max(rounding_, rounding_of_corners * std::abs(x));
        for (std::size_t f = 0; f < polygons_.size(); ++f) {
            const auto polygon = mesh.polygon(f);
            polygons_[f].assign(polygon.begin(), polygon.end());
            for (const std::int32_t v : polygon) faces_of_[at(v)].push_back(f);
            areas_[f] = area(polygons_[f]);
            thin_[f] = is_thin(polygons_[f]) ? 1 : 0;
        }
        for (std::size_t p = 0; p < mesh.patches.size(); ++p) {
            const Patch& patch = mesh.patches[p];
            for (std::size_t f = patch.first; f < patch.first + patch.count; ++f) {
                if (patch.wall == 0) {
                    twins_[f] = mesh.patches[patch.twin].first + f - patch.first;
                    apart_[f] = mesh.separation(patch);
                }
                for (const std::int32_t v : polygons_[f])
                    if (patch.wall != 0) walls_[at(v)].push_back(mesh.planes[f]);
            }
        }
        for (auto& walls : walls_) {
            std::ranges::sort(walls);
            walls.erase(std::ranges::unique(walls).begin(), walls.end());
        }
        for (std::size_t i = 0; i < volumes_.size(); ++i) volumes_[i] = volume_range(i, origin_of(i))[0];
    }

    // Returns the number of edges below the length that remain.
    std::uint64_t collapse(double length) {
        std::vector<Edge> edges = short_edges(length);
        for (bool any = true; any;) {
            any = false;
            for (std::size_t e = 0; e < edges.size(); ++e) {
                if (e % edges_per_stop == 0) check_stop();
                const Edge& edge = edges[e];
                // One earlier step may have taken it.
                if (is_edge(edge))
                    any |= attempt(edge) || attempt({edge.dropped, edge.kept}) || attempt_cluster(edge, length);
            }
            edges = short_edges(length);
        }
        store();
        return edges.size();
    }

private:
    static constexpr std::size_t none = static_cast<std::size_t>(-1);
    static constexpr std::size_t edges_per_stop = 256;
    static constexpr double rounding_of_corners = 0x1p-42;

    [[nodiscard]] double length_of(const Edge& edge) const {
        const Vector3 d = minus(mesh_.vertex(edge.kept), mesh_.vertex(edge.dropped));
        return length3(d[0], d[1], d[2]);
    }

    // From short to long. The vertex on more walls is kept.
    [[nodiscard]] std::vector<Edge> short_edges(double length) const {
        std::vector<std::pair<double, Edge>> found;
        for (const Polygon& polygon : polygons_)
            for (std::size_t c = 0; c < polygon.size(); ++c) {
                const std::int32_t a = polygon[c], b = polygon[(c + 1) % polygon.size()];
                Edge edge{std::min(a, b), std::max(a, b)};
                if (const double l = length_of(edge); l < length) {
                    if (walls_[at(edge.dropped)].size() > walls_[at(edge.kept)].size())
                        std::swap(edge.kept, edge.dropped);
                    found.emplace_back(l, edge);
                }
            }
        std::ranges::sort(found);
        found.erase(std::ranges::unique(found).begin(), found.end());
        std::vector<Edge> edges;
        for (const auto& [_, edge] : found) edges.push_back(edge);
        return edges;
    }

    [[nodiscard]] static bool are_beside(const Polygon& polygon, const Edge& edge) {
        for (std::size_t c = 0; c < polygon.size(); ++c) {
            const std::int32_t a = polygon[c], b = polygon[(c + 1) % polygon.size()];
            if ((a == edge.kept && b == edge.dropped) || (b == edge.kept && a == edge.dropped)) return true;
        }
        return false;
    }
    [[nodiscard]] bool is_edge(const Edge& edge) const {
        return std::ranges::any_of(faces_of_[at(edge.dropped)],
                                   [&](std::size_t f) { return are_beside(polygons_[f], edge); });
    }

    // Adds the edge and its images.
    void add_images(const Edge& edge, std::vector<Edge>& images) const {
        if (std::ranges::find(images, edge) != images.end()) return;
        images.push_back(edge);
        for (const std::size_t f : faces_of_[at(edge.dropped)]) {
            if (twins_[f] == none || !are_beside(polygons_[f], edge)) continue;
            add_images({image(f, edge.kept), image(f, edge.dropped)}, images);
        }
    }
    // Returns the vertex of the twin at the place of one of a face at a periodic boundary. Both begin with the same
    // corner, and have opposite directions.
    [[nodiscard]] std::int32_t image(std::size_t face, std::int32_t vertex) const {
        const Polygon &from = polygons_[face], &to = polygons_[twins_[face]];
        const auto corner = static_cast<std::size_t>(std::ranges::find(from, vertex) - from.begin());
        return to[(to.size() - corner) % to.size()];
    }

    // Whether all images of the dropped vertex are among those of the edge, so that faces at the boundary stay equal.
    [[nodiscard]] bool takes_all_images(const std::vector<Edge>& images) const {
        for (const Edge& edge : images)
            for (const std::size_t f : faces_of_[at(edge.dropped)]) {
                if (twins_[f] == none) continue;
                const std::int32_t other = image(f, edge.dropped);
                if (std::ranges::find(images, other, &Edge::dropped) == images.end()) return false;
            }
        return true;
    }

    bool attempt(const Edge& edge) {
        std::vector<Edge> images;
        add_images(edge, images);
        if (!takes_all_images(images)) return false;
        std::vector<std::size_t> faces;
        for (const Edge& one : images) {
            const auto& walls = walls_[at(one.dropped)];
            if (!std::ranges::includes(walls_[at(one.kept)], walls)) return false;
            // Both vertices at the boundary, but the edge inside: the boundary would be pinched.
            if (is_at_boundary(one.kept) && is_at_boundary(one.dropped) && !is_edge_of_boundary(one)) return false;
            for (const Edge& other : images)
                if (one.kept == other.dropped || (one.dropped == other.dropped && one.kept != other.kept)) return false;
            const auto& own = faces_of_[at(one.dropped)];
            faces.insert(faces.end(), own.begin(), own.end());
        }
        return merge(images, {}, faces);
    }

    // A vertex of a cluster, or an image of one.
    struct Member {
        std::int32_t vertex;
        Vector3 offset;     // from the vertex where the search begins
        std::size_t group;  // vertices of a group become one
    };
    struct Move {
        std::int32_t vertex;
        Vector3 place;
    };

    // Makes one vertex of the ends of all edges that are connected with this one and no longer than it. Corners that
    // rounding sets apart are such a cluster, and to join a few of them may leave no polyhedra. No vertex moves farther
    // than `most`.
    bool attempt_cluster(const Edge& edge, double most) {
        const std::vector<Member> members = cluster_of(edge, most);
        const auto walls_of = [&](const Member& m) -> const auto& {
            return walls_[at(m.vertex)];
        };
        const auto more_walls = [&](const Member& a, const Member& b) {
            return walls_of(a).size() < walls_of(b).size();
        };
        if (members.empty()) return false;
        const Member& anchor = *std::ranges::max_element(members, more_walls);
        const Vector3 place = minus(mesh_.vertex(anchor.vertex), anchor.offset);
        std::vector<Edge> edges;
        std::vector<Move> moves;
        std::vector<std::size_t> faces;
        for (std::size_t group = 0; group < members.size(); ++group) {
            auto own = members | std::views::filter([&](const Member& m) { return m.group == group; });
            if (own.empty()) continue;
            const auto target_of = [&](const Member& m) {
                return Vector3{place[0] + m.offset[0], place[1] + m.offset[1], place[2] + m.offset[2]};
            };
            const auto distance = [&](const Member& m) { return length3(minus(mesh_.vertex(m.vertex), target_of(m))); };
            const Member& kept = *std::ranges::min_element(
                own, {}, [&](const Member& m) { return std::pair(-std::ssize(walls_of(m)), distance(m)); });
            if (!std::ranges::includes(walls_of(anchor), walls_of(kept))) return false;
            const Vector3 target = target_of(kept);
            if (distance(kept) > rounding_) moves.push_back({kept.vertex, target});
            for (const Member& m : own) {
                if (!(length3(minus(mesh_.vertex(m.vertex), target)) <= most)) return false;
                if (!std::ranges::includes(walls_of(kept), walls_of(m))) return false;
                const auto& around = faces_of_[at(m.vertex)];
                faces.insert(faces.end(), around.begin(), around.end());
                if (m.vertex != kept.vertex) edges.push_back({kept.vertex, m.vertex});
            }
        }
        return merge(edges, moves, faces);
    }

    // Returns nothing if the cluster is one edge, reaches its own image, or would pinch the domain between walls.
    [[nodiscard]] std::vector<Member> cluster_of(const Edge& edge, double most) const {
        const double reach = length_of(edge);
        std::vector<Member> members{{edge.kept, {}, 0}};
        const Vector3 start = mesh_.vertex(edge.kept);
        bool good = true;
        const auto number = [&](std::int32_t v) {
            return at(std::ranges::find(members, v, &Member::vertex) - members.begin());
        };
        const auto add = [&](std::int32_t v, const Vector3& offset) {
            const std::size_t m = number(v);
            if (m == members.size()) members.push_back({v, offset, m});
            good = good && length3(minus(members[m].offset, offset)) <= most &&
                   length3(minus(minus(mesh_.vertex(v), offset), start)) <= most;
        };
        const auto join = [&](std::int32_t a, std::int32_t b) {
            const std::size_t one = members[number(a)].group, two = members[number(b)].group;
            for (Member& m : members)
                if (m.group == std::max(one, two)) m.group = std::min(one, two);
            return one != two;
        };
        const auto each_face = [&](std::size_t m, const auto& use) {
            for (const std::size_t f : faces_of_[at(members[m].vertex)]) use(f);
        };
        for (std::size_t m = 0; good && m < members.size(); ++m) {
            const auto [v, offset, _] = members[m];
            each_face(m, [&](std::size_t f) {
                const Polygon& polygon = polygons_[f];
                const std::size_t n = polygon.size(), c = at(std::ranges::find(polygon, v) - polygon.begin());
                for (const std::int32_t w : {polygon[(c + 1) % n], polygon[(c + n - 1) % n]}) {
                    if (length_of({v, w}) > reach) continue;
                    add(w, offset);
                    join(v, w);
                    const bool walled = !walls_[at(v)].empty() && !walls_[at(w)].empty();
                    good = good && !(walled && !is_edge_of_boundary({v, w}));
                }
                if (twins_[f] != none) add(image(f, v), minus(offset, apart_[f]));
            });
        }
        if (!good || members.size() == 2) return {};
        // A face at a periodic boundary has the same groups as its twin.
        for (bool any = true; any;) {
            any = false;
            for (std::size_t m = 0; m < members.size(); ++m)
                each_face(m, [&](std::size_t f) {
                    if (twins_[f] == none) return;
                    for (const std::int32_t w : polygons_[f])
                        if (const std::size_t k = number(w); k < members.size() && members[k].group == members[m].group)
                            any |= join(image(f, members[m].vertex), image(f, w));
                });
        }
        return members;
    }

    // Renames the dropped vertices and moves others, if the faces around all of them and their cells remain.
    bool merge(const std::vector<Edge>& images, std::vector<Move> moves, std::vector<std::size_t>& faces) {
        std::ranges::sort(faces);
        faces.erase(std::ranges::unique(faces).begin(), faces.end());
        const auto exchange_places = [&] {
            for (auto& [v, place] : moves)
                std::ranges::swap_ranges(place, std::span(mesh_.vertices).subspan(3 * at(v), 3));
        };
        exchange_places();
        std::vector<Polygon> before;
        for (const std::size_t f : faces) before.push_back(polygons_[f]);
        bool good = true;
        for (std::size_t k = 0; good && k < faces.size(); ++k) good = rename(faces[k], images);
        good = good && are_twins(faces);
        for (std::size_t k = 0; good && k < faces.size(); ++k) good = keeps_direction(faces[k]);
        if (good) {
            std::vector<std::int32_t> cells;
            for (const std::size_t f : faces)
                for (const std::int32_t cell : {mesh_.faces[f].owner, mesh_.faces[f].neighbor})
                    if (cell >= 0) cells.push_back(cell);
            std::ranges::sort(cells);
            cells.erase(std::ranges::unique(cells).begin(), cells.end());
            good = std::ranges::all_of(cells, [&](std::int32_t cell) { return is_polyhedron(at(cell)); });
        }
        if (!good) {
            for (std::size_t k = 0; k < faces.size(); ++k) polygons_[faces[k]] = before[k];
            exchange_places();
            return false;
        }
        for (std::size_t k = 0; k < faces.size(); ++k)
            if (polygons_[faces[k]].empty())
                for (const std::int32_t v : before[k]) std::erase(faces_of_[at(v)], faces[k]);
        for (const Edge& one : images) {
            auto& kept = faces_of_[at(one.kept)];
            for (const std::size_t f : faces_of_[at(one.dropped)])
                if (std::ranges::find(kept, f) == kept.end()) kept.push_back(f);
            faces_of_[at(one.dropped)].clear();
            mesh_.moved[at(one.kept)] = 1;
        }
        return true;
    }

    [[nodiscard]] bool is_boundary(std::size_t face) const { return mesh_.faces[face].neighbor < 0; }
    [[nodiscard]] bool is_at_boundary(std::int32_t vertex) const {
        return std::ranges::any_of(faces_of_[at(vertex)], [&](std::size_t f) { return is_boundary(f); });
    }
    [[nodiscard]] bool is_edge_of_boundary(const Edge& edge) const {
        return std::ranges::any_of(faces_of_[at(edge.dropped)],
                                   [&](std::size_t f) { return is_boundary(f) && are_beside(polygons_[f], edge); });
    }

    // Renames dropped corners. A face with two corners vanishes. Returns whether the face visits no vertex twice. The
    // first corner stays the first, so that twins correspond.
    bool rename(std::size_t face, const std::vector<Edge>& images) {
        Polygon& polygon = polygons_[face];
        Polygon renamed;
        for (std::int32_t v : polygon) {
            const auto found = std::ranges::find(images, v, &Edge::dropped);
            if (found != images.end()) v = found->kept;
            if (renamed.empty() || renamed.back() != v) renamed.push_back(v);
        }
        while (renamed.size() > 1 && renamed.front() == renamed.back()) renamed.pop_back();
        if (renamed.size() < 3) {
            polygon.clear();
            return true;
        }
        Polygon sorted = renamed;
        std::ranges::sort(sorted);
        if (std::ranges::adjacent_find(sorted) != sorted.end()) return false;
        polygon = std::move(renamed);
        return true;
    }
    // Whether faces at a periodic boundary still have as many corners as their twins.
    [[nodiscard]] bool are_twins(const std::vector<std::size_t>& faces) const {
        return std::ranges::all_of(faces, [&](std::size_t f) {
            return twins_[f] == none || polygons_[f].size() == polygons_[twins_[f]].size();
        });
    }

    // Returns twice the area, along the normal.
    [[nodiscard]] Vector3 area(const Polygon& polygon) const {
        Vector3 sum{};
        for (std::size_t c = 1; c + 1 < polygon.size(); ++c) {
            const Vector3 origin = mesh_.vertex(polygon[0]);
            const Vector3 part =
                cross(minus(mesh_.vertex(polygon[c]), origin), minus(mesh_.vertex(polygon[c + 1]), origin));
            for (std::size_t k = 0; k < 3; ++k) sum[k] += part[k];
        }
        return sum;
    }
    // Whether corners within rounding of a line leave the face no normal.
    [[nodiscard]] bool is_thin(const Polygon& polygon) const {
        const Vector3 twice = area(polygon);
        double longest = 0;
        for (const std::int32_t v : polygon) longest = std::max(longest, length_of({polygon[0], v}));
        return length3(twice) <= rounding_ * longest;
    }
    // Whether the normal is still near that of the cells' plane: the angle is at most 37 degrees, so that the face
    // still leads from one cell to the other. There is a fan of triangles no part of which folds onto another face.
    [[nodiscard]] bool keeps_direction(std::size_t face) const {
        constexpr double least_cosine = 0.8;
        const Polygon& polygon = polygons_[face];
        if (polygon.empty()) return true;
        const Vector3 now = area(polygon), &first = areas_[face];
        if (thin_[face] != 0) return is_thin(polygon);
        if (!(dot(now, first) > least_cosine * length3(now[0], now[1], now[2]) * length3(first[0], first[1], first[2])))
            return false;
        for (std::size_t apex = 0; apex < polygon.size(); ++apex)
            if (worst_cosine(mesh_, polygon, apex, first) > flat_fan) return true;
        return false;
    }

    // Whether the faces of a cell are closed, are one surface without holes, and enclose it.
    [[nodiscard]] bool is_polyhedron(std::size_t cell) const {
        std::vector<std::array<std::int32_t, 2>> edges;
        std::vector<std::int32_t> vertices;
        std::size_t faces = 0;
        for (const std::int32_t number : cells_.of(cell)) {
            const Polygon& polygon = polygons_[at(std::abs(number)) - 1];
            if (polygon.empty()) continue;
            ++faces;
            for (std::size_t c = 0; c < polygon.size(); ++c) {
                const std::int32_t a = polygon[c], b = polygon[(c + 1) % polygon.size()];
                edges.push_back(number > 0 ? std::array{a, b} : std::array{b, a});
                vertices.push_back(a);
            }
        }
        std::ranges::sort(edges);
        if (faces < 4 || std::ranges::adjacent_find(edges) != edges.end()) return false;
        for (const auto& [a, b] : edges)
            if (!std::ranges::binary_search(edges, std::array{b, a})) return false;
        std::ranges::sort(vertices);
        vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
        if (vertices.size() + faces != edges.size() / 2 + 2) return false;
        const Vector3 origin = origin_of(cell);
        return keeps_volume(cell, origin) && is_around_its_centroid(cell, origin);
    }
    // Returns a corner of the cell.
    [[nodiscard]] Vector3 origin_of(std::size_t cell) const {
        for (const std::int32_t number : cells_.of(cell))
            if (const Polygon& polygon = polygons_[at(std::abs(number)) - 1]; !polygon.empty())
                return mesh_.vertex(polygon[0]);
        return {};
    }

    // Returns the least and the greatest volume of the cell, times 6, whichever fans of triangles its faces become.
    // The volume between fans around the means of the corners is within too: it is the mean over all fans.
    [[nodiscard]] std::array<double, 2> volume_range(std::size_t cell, const Vector3& origin) const {
        std::array<double, 2> sum{};
        std::vector<Vector3> places;
        for (const std::int32_t number : cells_.of(cell)) {
            const Polygon& polygon = polygons_[at(std::abs(number)) - 1];
            const std::size_t n = polygon.size();
            if (n == 0) continue;
            places.clear();
            for (const std::int32_t v : polygon) places.push_back(minus(mesh_.vertex(v), origin));
            std::array<double, 2> range{};
            for (std::size_t apex = 0; apex < (n == 3 ? 1 : n); ++apex) {
                double fan = 0;
                for (std::size_t k = 1; k + 1 < n; ++k)
                    fan += dot(places[apex], cross(places[(apex + k) % n], places[(apex + k + 1) % n]));
                if (number < 0) fan = -fan;
                range = apex == 0 ? std::array{fan, fan} : std::array{std::min(range[0], fan), std::max(range[1], fan)};
            }
            sum[0] += range[0];
            sum[1] += range[1];
        }
        return sum;
    }
    // Whether the volume differs by at most half from that of the cell as it was.
    [[nodiscard]] bool keeps_volume(std::size_t cell, const Vector3& origin) const {
        const auto [least, greatest] = volume_range(cell, origin);
        return least > 0 && least >= 0.5 * volumes_[cell] && greatest <= 1.5 * volumes_[cell];
    }

    // Whether the faces of a cell of positive volume look away from its centroid. Then each face leads from one of its
    // cells to the other.
    [[nodiscard]] bool is_around_its_centroid(std::size_t cell, const Vector3& origin) const {
        double volume = 0;  // times 6
        Vector3 moment{};   // times 24
        const auto each = [&](const auto& use) {
            for (const std::int32_t number : cells_.of(cell))
                if (const Polygon& polygon = polygons_[at(std::abs(number)) - 1]; !polygon.empty())
                    use(polygon, number > 0 ? 1.0 : -1.0);
        };
        each([&](const Polygon& polygon, double sign) {
            const Vector3 a = minus(mesh_.vertex(polygon[0]), origin);
            for (std::size_t c = 1; c + 1 < polygon.size(); ++c) {
                const Vector3 x = minus(mesh_.vertex(polygon[c]), origin),
                              y = minus(mesh_.vertex(polygon[c + 1]), origin);
                const double part = sign * dot(a, cross(x, y));
                volume += part;
                for (std::size_t k = 0; k < 3; ++k) moment[k] += part * (a[k] + x[k] + y[k]);
            }
        });
        bool away = true;
        each([&](const Polygon& polygon, double sign) {
            if (is_thin(polygon)) return;
            Vector3 arm{};  // from the centroid to the mean of the corners
            for (const std::int32_t v : polygon) {
                const Vector3 x = minus(mesh_.vertex(v), origin);
                for (std::size_t k = 0; k < 3; ++k) arm[k] += x[k] / static_cast<double>(polygon.size());
            }
            for (std::size_t k = 0; k < 3; ++k) arm[k] -= moment[k] / (4 * volume);
            away &= sign * dot(area(polygon), arm) > 0;
        });
        return away;
    }

    // Writes the polygons back, without those that vanished.
    void store() {
        std::vector<SharedFace> faces;
        std::vector<std::int32_t> planes;
        mesh_.offsets.assign(1, 0);
        mesh_.corners.clear();
        std::vector<std::size_t> begins(polygons_.size() + 1);
        for (std::size_t f = 0; f < polygons_.size(); ++f) {
            begins[f] = faces.size();
            if (polygons_[f].empty()) continue;
            faces.push_back(mesh_.faces[f]);
            planes.push_back(mesh_.planes[f]);
            mesh_.normals.push_back(areas_[f]);
            mesh_.corners.insert(mesh_.corners.end(), polygons_[f].begin(), polygons_[f].end());
            mesh_.offsets.push_back(static_cast<std::int64_t>(mesh_.corners.size()));
        }
        begins.back() = faces.size();
        for (Patch& patch : mesh_.patches) {
            const std::size_t end = begins[patch.first + patch.count];
            patch.first = begins[patch.first];
            patch.count = end - patch.first;
        }
        mesh_.faces = std::move(faces);
        mesh_.planes = std::move(planes);
        mesh_.drop_unused_vertices();
    }

    SharedMesh& mesh_;
    std::vector<Polygon> polygons_;
    std::vector<Vector3> areas_;                      // of the faces as they were
    std::vector<std::uint8_t> thin_;                  // of these: 1 for one without a normal
    double rounding_ = 0;                             // a length: errors of corners are below
    std::vector<std::size_t> twins_;                  // of faces at a periodic boundary, else none
    std::vector<Vector3> apart_;                      // of these faces: from the twin
    std::vector<std::vector<std::size_t>> faces_of_;  // each vertex
    std::vector<std::vector<std::int32_t>> walls_;    // planes at the boundary of each vertex, ascending
    CellFaces cells_;
    std::vector<double> volumes_;  // of the cells as they were, times 6
};

}  // namespace

std::uint64_t collapse_edges(SharedMesh& mesh, double length) {
    return Collapser(mesh).collapse(length);
}

}  // namespace votess::files
