#include "solid/closed_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "core/at.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"
#include "core/sum.hpp"
#include "core/text.hpp"
#include "exact/double_double.hpp"
#include "exact/integer/big_int.hpp"
#include "exact/integer/rows.hpp"
#include "input/option_name.hpp"
#include "solid/mesh_signs.hpp"

namespace votess::solid {
namespace {

constexpr std::uint32_t leaf_triangles = 4;
constexpr double max_tolerance = 0.01;
constexpr double thin = 1e-6;            // of the sine of a triangle's angle: its plane is then not used
constexpr double sure_volume = 1e-3;     // of the terms it sums: the sum then has 1e-12 of it right
constexpr double plane_rounding = 1e-8;  // of the distance to a vertex, for a triangle that is not thin

// An edge of a triangle, from its lower vertex.
struct Edge {
    std::int32_t low, high;
    std::int32_t triangle;
    bool reversed;  // the triangle runs along it from high to low

    friend auto operator<=>(const Edge&, const Edge&) = default;
};

// Unites places that are at most `reach` apart. first[v]: the vertex whose place stands for that of v, the lowest.
void join_near(const std::vector<exact::Point>& vertices, std::span<const std::int32_t> places, double reach,
               std::vector<std::int32_t>& first) {
    const auto root = [&](std::int32_t v) {
        while (first[at(v)] != v) v = first[at(v)] = first[at(first[at(v)])];
        return v;
    };
    // Cells of a grid, from which the neighbors are at most one away.
    std::vector<std::pair<exact::Point, std::int32_t>> cells;
    for (const std::int32_t v : places) {
        exact::Point cell;
        for (std::size_t k = 0; k < 3; ++k) cell[k] = std::floor(vertices[at(v)][k] / reach);
        cells.emplace_back(cell, v);
    }
    std::ranges::sort(cells);
    for (const auto& [cell, v] : cells) {
        check_stop();
        for (const double x : {cell[0], cell[0] + 1})
            for (const double y : {cell[1] - 1, cell[1], cell[1] + 1}) {
                const auto low = std::pair(exact::Point{x, y, cell[2] - 1}, std::int32_t{-1});
                for (auto it = std::ranges::lower_bound(cells, low);
                     it != cells.end() && it->first <= exact::Point{x, y, cell[2] + 1}; ++it) {
                    const std::int32_t a = root(v), b = root(it->second);
                    const Vector3 apart = minus(vertices[at(v)], vertices[at(it->second)]);
                    if (a != b && length3(apart) <= reach) first[at(std::max(a, b))] = std::min(a, b);
                }
            }
    }
    for (std::int32_t v = 0; at(v) < first.size(); ++v) first[at(v)] = root(v);
}

std::array<std::int32_t, 3> sorted(std::array<std::int32_t, 3> triangle) {
    std::ranges::sort(triangle);
    return triangle;
}

}  // namespace

ClosedMesh::ClosedMesh(const TriangleMesh& given) : ClosedMesh(given, option("mesh")) {
    check_closed();
    find_volume();
}

void ClosedMesh::refuse(const std::string& message) const {
    throw Error(ErrorCode::invalid_argument, name_ + ": " + message);
}

ClosedMesh::ClosedMesh(const TriangleMesh& given, std::string name) : name_(std::move(name)), bounds_(empty_box) {
    const auto shape = [&](const char* what, std::size_t size, const char* rows) {
        if (size % 3 != 0)
            refuse(std::string(what) + " hold " + std::to_string(size) +
                   " numbers, not a multiple of 3: the shape must be " + rows);
        if (size / 3 > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
            refuse(std::to_string(size / 3) + " " + what + " are too many: give at most 2147483647");
    };
    shape("vertices", given.vertices.size(), "(V,3)");
    shape("triangles", given.triangles.size(), "(T,3)");
    if (given.triangles.empty()) refuse("it has no triangles: give a surface");
    vertices_.resize(given.vertices.size() / 3);
    for (std::size_t v = 0; v < vertices_.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) {
            vertices_[v][k] = given.vertices[3 * v + k];
            if (!std::isfinite(vertices_[v][k]))
                refuse("vertex " + std::to_string(v) + ": " + axis_name[k] + " = " + number(vertices_[v][k]) +
                       " is not finite");
        }
    given_.resize(given.triangles.size() / 3);
    for (std::size_t t = 0; t < given_.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t v = given_[t][k] = given.triangles[3 * t + k];
            if (v < 0 || static_cast<std::size_t>(v) >= vertices_.size())
                refuse("triangle " + std::to_string(t) + " names vertex " + std::to_string(v) + ", but there are " +
                       std::to_string(vertices_.size()) + ": give indices from 0 on");
        }
    find_bounds();
    merged_ = given.merge;
    if (!(given.tolerance >= 0 && given.tolerance <= max_tolerance))
        throw Error(ErrorCode::invalid_argument, name_ + ".tolerance is " + number(given.tolerance) +
                                                     ": give a share of the mesh's size, from 0 to " +
                                                     number(max_tolerance));
    if (given.tolerance > 0 && !merged_)
        throw Error(ErrorCode::invalid_argument, name_ + ".tolerance needs " + name_ + ".merge: set both");
    if (merged_) merge_vertices(given.tolerance);
}

void ClosedMesh::find_bounds() {
    bounds_ = empty_box;
    for (const auto& triangle : given_)
        for (const std::int32_t v : triangle) include(bounds_, vertex(v));
}

// Triangles name the first of all vertices at a place, or within the tolerance of it.
void ClosedMesh::merge_vertices(double tolerance) {
    const auto index = [](std::int32_t v) { return static_cast<std::size_t>(v); };
    std::vector<std::int32_t> order(vertices_.size()), first(vertices_.size()), places;
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(
        order, [&](std::int32_t i, std::int32_t j) { return vertex(i) != vertex(j) ? vertex(i) < vertex(j) : i < j; });
    for (std::size_t k = 0; k < order.size(); ++k) {
        const bool repeats = k > 0 && vertex(order[k]) == vertex(order[k - 1]);
        first[index(order[k])] = repeats ? first[index(order[k - 1])] : order[k];
        if (!repeats) places.push_back(order[k]);
    }
    if (tolerance > 0) {
        const Vector3 size = minus(bounds_.upper, bounds_.lower);
        join_near(vertices_, places, tolerance * std::max({size[0], size[1], size[2]}), first);
    }
    for (std::int32_t v : places) {
        const Vector3 move = minus(vertex(v), vertex(first[index(v)]));
        distance_ = std::max(distance_, length3(move));
    }
    for (auto& triangle : given_)
        for (std::int32_t& v : triangle) v = first[index(v)];
    for (std::size_t v = 0; v < first.size(); ++v)
        if (vertices_[v] != vertex(first[v])) ++moved_;
    find_bounds();
}

std::string ClosedMesh::between(std::int32_t a, std::int32_t b, const char* word) const {
    const auto text = [&](std::int32_t v) {
        const exact::Point& x = vertex(v);
        return std::to_string(v) + " (" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ")";
    };
    return text(a) + " " + word + " " + text(b);
}

// Each edge must be run along as often in one direction as in the other.
void ClosedMesh::check_closed() const {
    std::vector<Edge> edges;
    edges.reserve(3 * given_.size());
    for (std::size_t t = 0; t < given_.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int32_t a = given_[t][k], b = given_[t][(k + 1) % 3];
            if (a != b) edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), a > b});
        }
    check_stop();
    std::ranges::sort(edges);
    // The triangles of an edge, and how often more they run along it in one direction.
    const auto turns_from = [&](std::size_t begin, std::size_t& end) {
        int turns = 0;
        for (end = begin;
             end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high; ++end)
            turns += edges[end].reversed ? -1 : 1;
        return turns;
    };
    std::vector<Edge> wrong;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end)
        if (turns_from(begin, end) != 0) wrong.push_back(edges[begin]);
    if (wrong.empty()) return;
    const std::string others =
        wrong.size() == 1 ? "" : "; " + std::to_string(wrong.size()) + " edges are open or turned in all";
    // Returns a share of the size that would merge the ends of an edge with others, or more than is allowed.
    const auto tolerance_for = [&](const Edge& edge) {
        const Vector3 size = minus(bounds_.upper, bounds_.lower);
        double longest = 0;
        for (const std::int32_t v : {edge.low, edge.high}) {
            double nearest = infinity;
            for (const Edge& other : wrong)
                for (const std::int32_t w : {other.low, other.high}) {
                    const Vector3 apart = minus(vertex(w), vertex(v));
                    if (w != v) nearest = std::min(nearest, length3(apart));
                }
            longest = std::max(longest, nearest);
        }
        return longest / std::max({size[0], size[1], size[2]});
    };
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        const Edge& first = edges[begin];
        const int turns = turns_from(begin, end);
        if (turns == 0) continue;
        const std::string edge = "the edge between vertices " + between(first.low, first.high, "and");
        if (end - begin == 1)
            refuse(edge + " belongs to triangle " + std::to_string(first.triangle) + " alone" + others +
                   ": close the hole" +
                   (!merged_ ? ", or merge vertices at equal places: " + option("mesh.merge")
                    : tolerance_for(first) <= max_tolerance
                        ? ", or merge near vertices: " + option("mesh.tolerance") + " = " +
                              number(std::min(2 * tolerance_for(first), max_tolerance))
                        : ""));
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t j = i + 1; j < end; ++j) {
                const auto s = static_cast<std::size_t>(edges[i].triangle);
                const auto t = static_cast<std::size_t>(edges[j].triangle);
                if (s != t && sorted(given_[s]) == sorted(given_[t]) && edges[i].reversed == edges[j].reversed)
                    refuse("triangles " + std::to_string(s) + " and " + std::to_string(t) + " are the same" + others +
                           ": remove one of them");
            }
        if (end - begin == 2)
            refuse("triangles " + std::to_string(first.triangle) + " and " + std::to_string(edges[begin + 1].triangle) +
                   " both run along the edge from vertex " +
                   (first.reversed ? between(first.high, first.low, "to") : between(first.low, first.high, "to")) +
                   others + ": reverse one of them, or those around it");
        refuse(edge + " belongs to " + std::to_string(end - begin) + " triangles, " + std::to_string(std::abs(turns)) +
               " more in one direction than in the other" + others + ": remove some, or add those that are missing");
    }
}

void ClosedMesh::find_volume() {
    exact::Point middle;
    double length = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        middle[k] = 0.5 * bounds_.lower[k] + 0.5 * bounds_.upper[k];
        length = std::max(length, bounds_.upper[k] - bounds_.lower[k]);
    }
    if (!std::isfinite(length)) refuse("its size exceeds the largest double: give lengths in a larger unit");
    if (length == 0) refuse("all vertices lie at one place: it encloses no volume");
    // No product leaves the range in units of about the length.
    const int power = -std::ilogb(length);
    unit_ = std::ldexp(1, -power);
    Sum sum;
    double size = 0;
    for (const auto& t : given_) {
        std::array<Vector3, 3> x;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k) x[i][k] = std::ldexp(vertex(t[i])[k] - middle[k], power);
        const Vector3 a = minus(x[1], x[0]), b = minus(x[2], x[0]);
        sum += dot(x[0], cross(a, b)) / 6;
        size += length3(x[0]) * length3(a) * length3(b);
    }
    volume_ = sum.value();
    if (!(std::abs(volume_) > sure_volume * size)) volume_ = long_volume();  // as of the high prism over polygons
    if (std::isnan(volume_)) volume_ = exact_volume();
    if (volume_ == 0) refuse("it encloses no volume");
    if (volume_ < 0)
        refuse("its triangles face inward, so that it encloses the volume " + number(volume()) +
               ": reverse the vertices of each, in the plane those of each edge");
}

// In two doubles. NaN if the digits do not suffice for a rounded sum.
double ClosedMesh::long_volume() const {
    using exact::DoubleDouble;
    constexpr double sure = 0x1p-40;
    const int power = -std::ilogb(unit_);
    const exact::Point& first = vertex(given_.front()[0]);
    DoubleDouble six_fold;
    double size = 0;
    for (const auto& t : given_) {
        std::array<std::array<DoubleDouble, 3>, 3> x;
        double bound = 1;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k)
                x[i][k] = exact::two_sum(std::ldexp(vertex(t[i])[k], power), -std::ldexp(first[k], power));
            bound *= length3(x[i][0].high, x[i][1].high, x[i][2].high);
        }
        const auto minor = [&](std::size_t k, std::size_t l) {
            const DoubleDouble p = x[1][k] * x[2][l], q = x[1][l] * x[2][k];
            return p + DoubleDouble{-q.high, -q.low};
        };
        six_fold = six_fold + (x[0][0] * minor(1, 2) + x[0][1] * minor(2, 0) + x[0][2] * minor(0, 1));
        size += bound;
    }
    if (!(std::abs(six_fold.high) > sure * size)) return std::numeric_limits<double>::quiet_NaN();
    return (six_fold.high + six_fold.low) / 6;
}

double ClosedMesh::exact_volume() const {
    using exact::BigInt;
    exact::BitRange range;
    for (const auto& t : given_)
        for (const std::int32_t v : t) range.add(vertex(v));
    const int quantum = range.quantum();
    const auto relative = [&](std::int32_t v, std::int32_t from) {
        std::array<BigInt, 3> x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = BigInt(exact::to_wide<exact::widest>(vertex(v)[k], quantum) -
                          exact::to_wide<exact::widest>(vertex(from)[k], quantum));
        return x;
    };
    BigInt six_fold;
    const std::int32_t first = given_.front()[0];
    for (const auto& t : given_) {
        check_stop();
        six_fold = six_fold + dot(relative(t[0], first), cross(relative(t[1], first), relative(t[2], first)));
    }
    return static_cast<double>(ldexp(static_cast<exact::Quad>(six_fold), 3 * (quantum - std::ilogb(unit_)))) / 6;
}

void ClosedMesh::scale_by(double scale) {
    for (std::size_t v = 0; v < vertices_.size(); ++v)
        for (std::size_t k = 0; k < 3; ++k) {
            const double given = vertices_[v][k];
            vertices_[v][k] = given * scale;
            if (vertices_[v][k] / scale != given)
                refuse("vertex " + std::to_string(v) + ": " + axis_name[k] + " = " + number(given) +
                       " is too small beside the box to represent both at one scale: move it to 0");
        }
    triangles_.clear();
    for (const auto& t : given_) {
        const exact::Point &u = vertex(t[0]), &v = vertex(t[1]), &w = vertex(t[2]);
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        const int upward = cross_sign(u, v, w, 2);
        const Vector3 a = minus(v, u), b = minus(w, u), n = cross(a, b);
        const double length = length3(n);
        Triangle triangle{t, static_cast<std::int32_t>(&t - given_.data()), static_cast<std::int8_t>(upward), {}, 0};
        if (length > thin * length3(a) * length3(b)) {
            for (std::size_t k = 0; k < 3; ++k) triangle.normal[k] = n[k] / length;
            triangle.offset = dot(triangle.normal, u);
        }
        triangles_.push_back(triangle);
    }
    make_tree();
}

void ClosedMesh::make_tree() {
    std::vector<Box> boxes(triangles_.size(), empty_box);
    for (std::size_t t = 0; t < boxes.size(); ++t)
        for (const std::int32_t v : triangles_[t].vertex) include(boxes[t], vertex(v));
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0u);
    nodes_.clear();
    if (boxes.empty()) return;
    nodes_.resize(1);
    split(0, 0, static_cast<std::uint32_t>(order.size()), order, boxes);
    std::vector<Triangle> sorted;
    for (const std::uint32_t t : order) {
        sorted.push_back(triangles_[t]);
        boxes_.push_back(boxes[t]);
    }
    triangles_ = std::move(sorted);
}

void ClosedMesh::split(std::uint32_t at, std::uint32_t begin, std::uint32_t end, std::vector<std::uint32_t>& order,
                       const std::vector<Box>& boxes) {
    Box box = empty_box, middles = empty_box;
    const auto twice_middle = [&](std::uint32_t t, std::size_t k) { return boxes[t].lower[k] + boxes[t].upper[k]; };
    for (std::uint32_t i = begin; i < end; ++i) {
        const std::uint32_t t = order[i];
        include(box, boxes[t]);
        include(middles, Vector3{twice_middle(t, 0), twice_middle(t, 1), twice_middle(t, 2)});
    }
    nodes_[at].box = box;
    if (end - begin <= leaf_triangles) {
        nodes_[at].first = begin;
        nodes_[at].count = end - begin;
        return;
    }
    const Vector3 size = minus(middles.upper, middles.lower);
    const auto axis = static_cast<std::size_t>(std::ranges::max_element(size) - size.begin());
    const std::uint32_t half = begin + (end - begin) / 2;
    std::nth_element(order.begin() + begin, order.begin() + half, order.begin() + end,
                     [&](std::uint32_t s, std::uint32_t t) { return twice_middle(s, axis) < twice_middle(t, axis); });
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[at].first = child;
    nodes_.resize(nodes_.size() + 2);
    split(child, begin, half, order, boxes);
    split(child + 1, half, end, order, boxes);
}

bool ClosedMesh::any_near(const exact::Point& x, double distance) const {
    Box around;
    for (std::size_t k = 0; k < 3; ++k) around.lower[k] = x[k] - distance, around.upper[k] = x[k] + distance;
    bool found = false;
    for_each_in(around, [&](std::uint32_t t) {
        const Box& box = boxes_[t];
        if (distance_squared(x, box) > distance * distance * (1 + plane_rounding)) return true;
        const Triangle& triangle = triangles_[t];
        double reach = 0;  // to the farthest corner
        for (std::size_t k = 0; k < 3; ++k)
            reach += std::max(std::abs(box.lower[k] - x[k]), std::abs(box.upper[k] - x[k]));
        const double height = std::abs(dot(triangle.normal, x) - triangle.offset);
        if (height > distance + plane_rounding * (reach + std::abs(triangle.offset))) return true;
        found = true;
        return false;
    });
    return found;
}

}  // namespace votess::solid
