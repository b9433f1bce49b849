#include "files/joined_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/at.hpp"
#include "core/box.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"

namespace votess::files {
namespace {

using Id = std::int32_t;

// Errors of corners are at most 2^-42 of a cell's part, and half a unit in the last place.
constexpr double same_of_extent = 0x1p-40, same_of_coordinate = 0x1p-50;
constexpr double same_direction = 1e-9;  // sine of an angle
constexpr std::size_t regions_per_stop = 1024;

struct Triangle {
    std::array<Id, 3> corners;
    Id piece;
    Id source;  // the row beyond; on the surface -1 - a number, ascending with the triangles of the mesh
};

// A side of a triangle.
struct TriangleSide {
    Id low, high;
    bool ascends;
    Id triangle;

    [[nodiscard]] auto ends() const { return std::tie(low, high); }
    [[nodiscard]] std::array<Id, 2> path() const { return ascends ? std::array{low, high} : std::array{high, low}; }
};

// Two triangles of one region and the side between them. `left` has it from `from` to `to`.
struct Diagonal {
    Id from, to, left, right;
};

// Sets with a representative each: the lowest number.
class Sets {
public:
    explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
    [[nodiscard]] Id find(Id i) {
        while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
        return i;
    }
    void join(Id i, Id j) {
        i = find(i), j = find(j);
        parent_[at(std::max(i, j))] = std::min(i, j);
    }

private:
    std::vector<Id> parent_;
};

// Returns the distance up to which two corners are one.
double tolerance_of(const Pieces& pieces) {
    double extent = 0, coordinate = 0;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const auto begin = 3 * at(pieces.vertex_offsets[p]), end = 3 * at(pieces.vertex_offsets[p + 1]);
        const auto [lower, upper] = bounds_of(pieces.vertices.subspan(begin, end - begin));
        for (std::size_t k = 0; k < 3; ++k) {
            extent = std::max(extent, upper[k] - lower[k]);
            coordinate = std::max({coordinate, std::abs(lower[k]), std::abs(upper[k])});
        }
    }
    return same_of_extent * extent + same_of_coordinate * coordinate;
}

// Returns the first vertex at the place of each. Steps up to the tolerance along each axis lead from one to the other.
std::vector<Id> first_at_place(std::span<const double> vertices, double tolerance) {
    struct Part {
        std::size_t begin, end, axis;
        int whole;  // axes along which it has no gap
    };
    std::vector<Id> order(vertices.size() / 3), first(order.size());
    std::iota(order.begin(), order.end(), 0);
    std::vector<Part> pending{{0, order.size(), 0, 0}};
    while (!pending.empty()) {
        const Part part = pending.back();
        pending.pop_back();
        const auto own = std::span(order).subspan(part.begin, part.end - part.begin);
        if (own.size() < 2 || part.whole == 3) {
            for (const Id v : own) first[at(v)] = *std::ranges::min_element(own);
            continue;
        }
        const auto x = [&](Id v) { return vertices[3 * at(v) + part.axis]; };
        std::ranges::sort(own, {}, x);
        for (std::size_t i = 0, j = 0; i < own.size(); i = j) {
            for (j = i + 1; j < own.size() && x(own[j]) - x(own[j - 1]) <= tolerance;) ++j;
            const bool whole = j - i == own.size();
            pending.push_back({part.begin + i, part.begin + j, (part.axis + 1) % 3, whole ? part.whole + 1 : 1});
        }
    }
    return first;
}

// Joins the triangles of pieces to polygons.
class Joiner {
public:
    explicit Joiner(const Pieces& pieces) : pieces_(pieces), tolerance_(tolerance_of(pieces)) {
        read_triangles();
        join_planes();
        do find_regions();
        while (split_sides());
        pair_regions();
        find_owners();
    }

    // On the surface `other` is -1 - a patch, and `plane` the number of its source.
    struct Face {
        Id piece, other, plane;
        std::vector<Id> polygon;
    };
    std::vector<double> vertices;
    std::vector<Id> rows;  // of the pieces
    std::vector<Face> faces;
    Id patches = 0;

    void make_faces() {
        const std::vector<Id> patch = patches_of_triangles();
        for (std::size_t r = 0; r < regions_.size(); ++r) {
            if (r % regions_per_stop == 0) check_stop();
            const Region& region = regions_[r];
            const Triangle& first = triangles_[at(region.triangles.front())];
            const Id piece = owners_[at(first.piece)];
            if (piece < 0) continue;
            if (first.source >= 0 && region.twin < static_cast<Id>(r)) continue;  // made by the twin
            const Id other = first.source < 0 ? -1 : owners_[at(piece_of(region.twin))];
            if (other == piece) continue;
            for (std::vector<Id>& polygon : polygons_of(region)) {
                if (first.source < 0) {
                    const Id number = patch[at(region.triangles.front())];
                    faces.push_back({piece, -1 - number, -1 - first.source, std::move(polygon)});
                    continue;
                }
                faces.push_back({other, piece, -1, {polygon.rbegin(), polygon.rend()}});
                faces.push_back({piece, other, -1, std::move(polygon)});
            }
        }
        std::ranges::stable_sort(faces, {}, &Face::piece);
    }

private:
    // Connected triangles of one piece with one source.
    struct Region {
        std::vector<Id> triangles;
        std::vector<Diagonal> diagonals;
        std::vector<std::array<Id, 2>> rim;  // sides that lead around it, ascending
        Id twin = -1;                        // the other side of a face between pieces
    };

    void read_triangles() {
        const std::vector<Id> first = first_at_place(pieces_.vertices, tolerance_);
        std::vector<Id> number(first.size());
        for (std::size_t v = 0; v < first.size(); ++v) {
            if (first[v] != static_cast<Id>(v)) {
                number[v] = number[at(first[v])];
                continue;
            }
            number[v] = static_cast<Id>(vertices.size() / 3);
            vertices.insert(vertices.end(), &pieces_.vertices[3 * v], &pieces_.vertices[3 * v] + 3);
        }
        for (std::size_t row = 0; row + 1 < pieces_.indptr.size(); ++row)
            for (std::int64_t p = pieces_.indptr[row]; p < pieces_.indptr[row + 1]; ++p) {
                rows.push_back(static_cast<Id>(row));
                for (auto t = at(pieces_.triangle_offsets[at(p)]); t < at(pieces_.triangle_offsets[at(p) + 1]); ++t) {
                    std::array<Id, 3> corners{};
                    for (std::size_t k = 0; k < 3; ++k)
                        corners[k] = number[at(pieces_.vertex_offsets[at(p)] + pieces_.triangles[3 * t + k])];
                    const Id source = pieces_.on_surface[t] != 0 ? -1 - pieces_.sources[t] : pieces_.sources[t];
                    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
                        triangles_.push_back({corners, static_cast<Id>(p), source});
                }
            }
    }

    // Makes one source of triangles of the mesh that touch and lie in one plane.
    void join_planes() {
        std::vector<Id> sources;
        for (const Triangle& t : triangles_)
            if (t.source < 0) sources.push_back(-1 - t.source);
        std::ranges::sort(sources);
        sources.erase(std::ranges::unique(sources).begin(), sources.end());
        for (Triangle& t : triangles_)
            if (t.source < 0) {
                const auto found = std::ranges::lower_bound(sources, -1 - t.source);
                t.source = -1 - static_cast<Id>(found - sources.begin());
            }
        std::vector<Vector3> normals(sources.size());
        std::vector<TriangleSide> sides;
        for (std::size_t t = 0; t < triangles_.size(); ++t) {
            const Triangle& triangle = triangles_[t];
            if (triangle.source >= 0) continue;
            const auto& [a, b, c] = triangle.corners;
            const Vector3 area = cross(step(a, b), step(a, c));
            for (std::size_t k = 0; k < 3; ++k) normals[at(-1 - triangle.source)][k] += area[k];
            add_sides(t, sides);
        }
        for (Vector3& n : normals) {
            const double size = length3(n);
            for (double& x : n) x /= size > 0 ? size : 1;
        }
        std::ranges::sort(sides, {}, [](const TriangleSide& s) { return s.ends(); });
        Sets planes(sources.size());
        for (std::size_t i = 1; i < sides.size(); ++i) {
            if (sides[i].ends() != sides[i - 1].ends()) continue;
            const Id one = -1 - triangles_[at(sides[i - 1].triangle)].source;
            const Id two = -1 - triangles_[at(sides[i].triangle)].source;
            const Vector3 &m = normals[at(one)], &n = normals[at(two)];
            if (one != two && dot(m, n) > 0 && length3(cross(m, n)) <= same_direction) planes.join(one, two);
        }
        for (Triangle& t : triangles_)
            if (t.source < 0) t.source = -1 - planes.find(-1 - t.source);
    }
    void add_sides(std::size_t t, std::vector<TriangleSide>& sides) const {
        for (std::size_t k = 0; k < 3; ++k) {
            const Id a = triangles_[t].corners[k], b = triangles_[t].corners[(k + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), a < b, static_cast<Id>(t)});
        }
    }

    // A side has a diagonal if two triangles of its piece and source meet there, and, between two pieces, no third
    // piece: images of one cell may have faces with one source that meet in an edge.
    void find_regions() {
        check_stop();
        regions_.clear();
        std::vector<TriangleSide> sides;
        for (std::size_t t = 0; t < triangles_.size(); ++t) add_sides(t, sides);
        const auto owner = [&](const TriangleSide& side) {
            const Triangle& triangle = triangles_[at(side.triangle)];
            return std::pair(triangle.piece, triangle.source);
        };
        std::ranges::sort(sides, {}, [&](const TriangleSide& s) { return std::tuple(s.ends(), owner(s), s.triangle); });
        Sets sets(triangles_.size());
        std::vector<Diagonal> diagonals;
        std::vector<TriangleSide> rims;
        for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
            std::size_t pieces = 0;
            for (end = i; end < sides.size() && sides[end].ends() == sides[i].ends(); ++end)
                pieces += end == i || owner(sides[end]).first != owner(sides[end - 1]).first ? 1 : 0;
            for (std::size_t begin = i, j = i; begin < end; begin = j) {
                for (j = begin; j < end && owner(sides[j]) == owner(sides[begin]);) ++j;
                const TriangleSide &one = sides[begin], &two = sides[j - 1];
                const bool inside = triangles_[at(one.triangle)].source < 0 || pieces <= 2;
                if (j - begin == 2 && one.ascends != two.ascends && inside) {
                    sets.join(one.triangle, two.triangle);
                    const auto [from, to] = one.path();
                    diagonals.push_back({from, to, one.triangle, two.triangle});
                } else {
                    rims.insert(rims.end(), sides.begin() + static_cast<std::ptrdiff_t>(begin),
                                sides.begin() + static_cast<std::ptrdiff_t>(j));
                }
            }
        }
        std::vector<Id> number(triangles_.size(), -1);
        const auto region = [&](Id t) -> Region& { return regions_[at(number[at(sets.find(t))])]; };
        for (Id t = 0; t < static_cast<Id>(triangles_.size()); ++t) {
            if (sets.find(t) == t) {
                number[at(t)] = static_cast<Id>(regions_.size());
                regions_.emplace_back();
            }
            region(t).triangles.push_back(t);
        }
        for (const Diagonal& diagonal : diagonals) region(diagonal.left).diagonals.push_back(diagonal);
        for (const TriangleSide& side : rims) region(side.triangle).rim.push_back(side.path());
        for (Region& one : regions_) std::ranges::sort(one.rim);
    }

    // Splits triangles where a rim has vertices that the rim from the other side lacks. Returns whether there are any.
    bool split_sides() {
        struct Step {
            std::array<Id, 4> key;  // rows on both sides, and the ends; the lower one first
            int turns;
        };
        std::vector<Step> steps;
        for (const Region& region : regions_) {
            const Triangle& t = triangles_[at(region.triangles.front())];
            const Id own = rows[at(t.piece)], beyond = t.source;
            if (beyond < 0) continue;
            for (const auto& [a, b] : region.rim)
                steps.push_back(
                    {{std::min(own, beyond), std::max(own, beyond), std::min(a, b), std::max(a, b)}, a < b ? 1 : -1});
        }
        std::ranges::sort(steps, {}, &Step::key);
        std::vector<std::array<Id, 4>> lonely;
        for (std::size_t i = 0, end = 0; i < steps.size(); i = end) {
            int turns = 0;
            for (end = i; end < steps.size() && steps[end].key == steps[i].key; ++end) turns += steps[end].turns;
            if (turns != 0) lonely.push_back(steps[i].key);
        }
        std::map<std::array<Id, 2>, std::vector<Id>> splits;  // from the lower end on
        const auto rows_of = [](const std::array<Id, 4>& key) { return std::pair(key[0], key[1]); };
        for (std::size_t begin = 0, end = 0; begin < lonely.size(); begin = end) {
            std::vector<Id> ends;
            for (end = begin; end < lonely.size() && rows_of(lonely[end]) == rows_of(lonely[begin]); ++end)
                ends.insert(ends.end(), {lonely[end][2], lonely[end][3]});
            std::ranges::sort(ends);
            ends.erase(std::ranges::unique(ends).begin(), ends.end());
            for (std::size_t k = begin; k < end; ++k)
                if (std::vector<Id> found = between(lonely[k][2], lonely[k][3], ends); !found.empty())
                    splits[{lonely[k][2], lonely[k][3]}] = std::move(found);
        }
        if (splits.empty()) return false;
        std::vector<Triangle> pending = std::exchange(triangles_, {});
        while (!pending.empty()) {
            const Triangle triangle = pending.back();
            pending.pop_back();
            if (!split(triangle, splits, pending)) triangles_.push_back(triangle);
        }
        std::ranges::stable_sort(triangles_, {}, &Triangle::piece);
        return true;
    }
    // Returns the vertices on a side, along it.
    [[nodiscard]] std::vector<Id> between(Id from, Id to, const std::vector<Id>& ends) const {
        const Vector3 along = step(from, to);
        const double square = dot(along, along), room = 2 * tolerance_;
        std::vector<std::pair<double, Id>> found;
        for (const Id v : ends) {
            if (v == from || v == to) continue;
            const Vector3 arm = step(from, v);
            const double share = dot(arm, along) / square;
            if (share > 0 && share < 1 && length3(cross(arm, along)) <= room * std::sqrt(square))
                found.emplace_back(share, v);
        }
        std::ranges::sort(found);
        std::vector<Id> result;
        for (const auto& [_, v] : found) result.push_back(v);
        return result;
    }
    // Appends the parts of a triangle, if one of its sides is split. Those without an area vanish.
    static bool split(const Triangle& triangle, const std::map<std::array<Id, 2>, std::vector<Id>>& splits,
                      std::vector<Triangle>& parts) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Id from = triangle.corners[k], to = triangle.corners[(k + 1) % 3],
                     top = triangle.corners[(k + 2) % 3];
            const auto found = splits.find({std::min(from, to), std::max(from, to)});
            if (found == splits.end()) continue;
            std::vector<Id> path = found->second;
            if (from > to) std::ranges::reverse(path);
            path.insert(path.begin(), from);
            path.push_back(to);
            for (std::size_t i = 0; i + 1 < path.size(); ++i)
                if (path[i] != top && path[i + 1] != top)
                    parts.push_back({{path[i], path[i + 1], top}, triangle.piece, triangle.source});
            return true;
        }
        return false;
    }

    // Finds the two sides of each face: their rims are the same, in opposite directions.
    void pair_regions() {
        struct Rim {
            std::array<Id, 4> key;  // rows on this side and beyond, the first step
            Id region;
        };
        const auto rows_of = [&](const Region& region) {
            const Triangle& t = triangles_[at(region.triangles.front())];
            return std::pair(rows[at(t.piece)], t.source);
        };
        std::vector<Rim> rims;
        for (std::size_t r = 0; r < regions_.size(); ++r)
            if (const auto [own, beyond] = rows_of(regions_[r]); beyond >= 0)
                for (const auto& [a, b] : regions_[r].rim) rims.push_back({{own, beyond, a, b}, static_cast<Id>(r)});
        std::ranges::sort(rims, {}, [](const Rim& rim) { return std::pair(rim.key, rim.region); });
        for (std::size_t r = 0; r < regions_.size(); ++r) {
            if (r % regions_per_stop == 0) check_stop();
            Region& region = regions_[r];
            const auto [own, beyond] = rows_of(region);
            if (beyond < 0 || region.twin >= 0) continue;
            std::vector<std::array<Id, 2>> back;
            for (const auto& [a, b] : region.rim) back.push_back({b, a});
            std::ranges::sort(back);
            if (!back.empty())
                for (const Rim& rim :
                     std::ranges::equal_range(rims, std::array{beyond, own, back[0][0], back[0][1]}, {}, &Rim::key)) {
                    Region& other = regions_[at(rim.region)];
                    if (other.twin >= 0 || &other == &region || other.rim != back) continue;
                    region.twin = rim.region;
                    other.twin = static_cast<Id>(r);
                    break;
                }
            if (region.twin < 0)
                refuse("the pieces of cells " + std::to_string(own) + " and " + std::to_string(beyond) +
                       " do not share the face between them: give the pieces of all cells, without a gap; "
                       "if a plane between seeds lies in the surface, move the mesh a little");
        }
    }

    // A piece thinner than errors of corners becomes a part of the neighbor at its largest face, or vanishes.
    void find_owners() {
        const std::size_t count = pieces_.size();
        std::vector<double> volumes(count), areas(count), largest(count);
        std::vector<Id> neighbor(count, -1);
        for (const Region& region : regions_) {
            const Id piece = triangles_[at(region.triangles.front())].piece;
            const Vector3 origin = point_of(pieces_.centroids, at(piece));
            double area = 0;
            for (const Id t : region.triangles) {
                const auto& [a, b, c] = triangles_[at(t)].corners;
                const Vector3 normal = cross(step(a, b), step(a, c));
                area += length3(normal) / 2;
                volumes[at(piece)] += dot(minus(point_of(vertices, at(a)), origin), normal) / 6;
            }
            areas[at(piece)] += area;
            if (region.twin < 0 || area <= largest[at(piece)]) continue;
            largest[at(piece)] = area;
            neighbor[at(piece)] = piece_of(region.twin);
        }
        owners_.resize(count);
        std::iota(owners_.begin(), owners_.end(), 0);
        const auto owner = [&](Id p) {
            while (p >= 0 && owners_[at(p)] != p) p = owners_[at(p)];
            return p;
        };
        for (std::size_t p = 0; p < count; ++p)
            if (std::abs(volumes[p]) <= tolerance_ * areas[p]) {
                const Id other = owner(neighbor[p]);
                owners_[p] = other == static_cast<Id>(p) ? -1 : other;
            }
        for (Id& p : owners_) p = owner(p);
    }
    [[nodiscard]] Id piece_of(Id region) const { return triangles_[at(regions_[at(region)].triangles.front())].piece; }

    // Returns the number of the connected part of the surface that each triangle is of, in the order of the mesh.
    std::vector<Id> patches_of_triangles() {
        Sets sets(vertices.size() / 3);
        std::map<Id, Id> first;  // the first triangle of the mesh in each part
        for (const Triangle& t : triangles_)
            if (t.source < 0)
                for (const Id v : t.corners) sets.join(t.corners[0], v);
        for (const Triangle& t : triangles_) {
            if (t.source >= 0) continue;
            const auto found = first.try_emplace(sets.find(t.corners[0]), -1 - t.source).first;
            found->second = std::min(found->second, -1 - t.source);
        }
        std::vector<std::pair<Id, Id>> order;
        for (const auto& [part, triangle] : first) order.emplace_back(triangle, part);
        std::ranges::sort(order);
        for (const auto& [_, part] : order) first[part] = patches++;
        std::vector<Id> result;
        for (const Triangle& t : triangles_) result.push_back(t.source < 0 ? first[sets.find(t.corners[0])] : -1);
        return result;
    }

    // Joins triangles while polygons stay convex (Hertel, Mehlhorn 1983), first across long sides.
    std::vector<std::vector<Id>> polygons_of(const Region& region) const {
        Vector3 normal{};
        std::map<Id, Id> number;  // of each triangle
        std::vector<std::vector<Id>> polygons;
        for (const Id t : region.triangles) {
            const auto& [a, b, c] = triangles_[at(t)].corners;
            const Vector3 area = cross(step(a, b), step(a, c));
            for (std::size_t k = 0; k < 3; ++k) normal[k] += area[k];
            number[t] = static_cast<Id>(polygons.size());
            polygons.push_back({a, b, c});
        }
        const double size = length3(normal);
        for (double& n : normal) n /= size > 0 ? size : 1;
        std::vector<std::pair<double, Diagonal>> diagonals;
        for (const Diagonal& d : region.diagonals) diagonals.emplace_back(-length3(step(d.from, d.to)), d);
        std::ranges::stable_sort(diagonals, {}, [](const auto& d) { return d.first; });
        Sets sets(polygons.size());
        for (const auto& [_, d] : diagonals) {
            const Id left = sets.find(number[d.left]), right = sets.find(number[d.right]);
            std::vector<Id>&one = polygons[at(left)], &two = polygons[at(right)];
            if (left == right) continue;
            // one: ... from, to ...; two: ... to, from ...
            std::ranges::rotate(one, std::ranges::find(one, d.to));
            std::ranges::rotate(two, std::ranges::find(two, d.from));
            if (!is_convex(one[one.size() - 2], d.from, two[1], normal) ||
                !is_convex(two[two.size() - 2], d.to, one[1], normal))
                continue;
            std::vector<Id> joined = one;
            joined.insert(joined.end(), two.begin() + 1, two.end() - 1);
            std::vector<Id> sorted = joined;
            std::ranges::sort(sorted);
            if (std::ranges::adjacent_find(sorted) != sorted.end()) continue;
            sets.join(left, right);
            two.clear();
            one.clear();
            polygons[at(std::min(left, right))] = std::move(joined);
        }
        std::erase_if(polygons, [](const auto& polygon) { return polygon.empty(); });
        return polygons;
    }
    [[nodiscard]] Vector3 step(Id a, Id b) const { return minus(point_of(vertices, at(b)), point_of(vertices, at(a))); }
    [[nodiscard]] bool is_convex(Id a, Id b, Id c, const Vector3& normal) const {
        const Vector3 in = step(a, b), out = step(b, c);
        const double x = length3(in), y = length3(out);
        return dot(normal, cross(in, out)) >= -same_direction * x * y - tolerance_ * (x + y);
    }

    const Pieces& pieces_;
    double tolerance_;
    std::vector<Triangle> triangles_;
    std::vector<Region> regions_;
    std::vector<Id> owners_;  // by piece: the one that it is a part of, or -1
};

}  // namespace

JoinedPieces::JoinedPieces(const Pieces& pieces)
    : min_edge_(pieces.min_edge), short_edges_(pieces.short_edges), measure_(pieces.measure) {
    Joiner joiner(pieces);
    joiner.make_faces();
    indptr_.assign(pieces.size() + 1, 0);
    for (const auto& [piece, other, plane, polygon] : joiner.faces) {
        ++indptr_[at(piece) + 1];
        indices_.push_back(other);
        planes_.push_back(plane);
        face_vertices_.insert(face_vertices_.end(), polygon.begin(), polygon.end());
        face_offsets_.push_back(static_cast<std::int64_t>(face_vertices_.size()));
    }
    std::partial_sum(indptr_.begin(), indptr_.end(), indptr_.begin());
    vertices_ = std::move(joiner.vertices);
    rows_ = std::move(joiner.rows);
    for (Id k = 0; k < joiner.patches; ++k)
        patches_.push_back(joiner.patches == 1 ? "surface" : "surface" + std::to_string(k + 1));
}

Mesh JoinedPieces::mesh() const {
    Mesh mesh;
    mesh.indptr = indptr_;
    mesh.indices = indices_;
    mesh.vertices = vertices_;
    mesh.face_offsets = face_offsets_;
    mesh.face_vertices = face_vertices_;
    mesh.rows = rows_;
    mesh.patches = patches_;
    mesh.planes = planes_;
    mesh.min_edge = min_edge_;
    mesh.short_edges = short_edges_;
    mesh.measure = measure_;
    return mesh;
}

void write_pieces_foam(const Pieces& pieces, ByteSink& out) {
    const JoinedPieces joined(pieces);
    write_foam(joined.mesh(), out);
}

void write_pieces_msh(const Pieces& pieces, ByteSink& out) {
    const JoinedPieces joined(pieces);
    write_msh(joined.mesh(), out);
}

void write_pieces_cgns(const Pieces& pieces, ByteSink& out) {
    const JoinedPieces joined(pieces);
    write_cgns(joined.mesh(), out);
}

}  // namespace votess::files
