// The network of a diagram, read off its polygons: no predicate, the vertices are exact already.
#include "votess/network.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "input/domain_of_result.hpp"
#include "input/option_name.hpp"
#include "input/supports.hpp"
#include "mesh/dual.hpp"
#include "mesh/joined_corners.hpp"
#include "result/handle.hpp"

namespace votess {
namespace {

using detail::Result;
using Vector = Vector3;
constexpr std::size_t cells_per_stop = 1024, vertices_per_stop = 8192,
                      comparisons_per_stop = 65536;  // after which the user may stop

// Returns a vector of an array; z is 0 in the plane.
Vector vector_at(std::span<const double> array, std::size_t i, std::size_t dimensions) {
    Vector vector{};
    std::copy_n(&array[dimensions * i], dimensions, vector.begin());
    return vector;
}

// Returns the distance from the origin to the segment between two points.
double distance_to_segment(const Vector& a, const Vector& b) {
    const Vector along = minus(b, a);
    const double squared = dot(along, along);
    const double t = squared > 0 ? std::clamp(-dot(a, along) / squared, 0.0, 1.0) : 0.0;
    const Vector foot{std::lerp(a[0], b[0], t), std::lerp(a[1], b[1], t), std::lerp(a[2], b[2], t)};
    return std::sqrt(dot(foot, foot));
}

// Whether places lie outside of a domain, which keeps seeds there. Places at its walls may count.
class OutsideTest {
public:
    explicit OutsideTest(const Tessellation& t) : walls_(t.walls()) {
        const std::size_t dimensions = t.planar() ? 2 : 3;
        std::array<Vector, 3> edges{};
        Vector origin{};
        if (const auto& cell = t.cell())
            edges = {cell->a, cell->b, cell->c}, origin = cell->origin;
        else
            for (std::size_t k = 0; k < dimensions; ++k)
                edges[k][k] = t.box().upper[k] - t.box().lower[k], origin[k] = t.box().lower[k];
        for (std::size_t k = 0; k < dimensions; ++k) {
            // Across the other edges.
            Vector across = edges[k];
            Vector first = edges[(k + 1) % 3], second = edges[(k + 2) % 3];
            remove_along(first, second);
            remove_along(first, across);
            remove_along(second, across);
            const double length = dot(edges[k], across);
            if (t.periodic()[k] || !(length > 0) || !std::isfinite(length)) continue;
            for (double& x : across) x /= length;
            slabs_.push_back({across, dot(origin, across)});
        }
    }
    [[nodiscard]] bool operator()(const Vector& place) const {
        constexpr double slack = 1e-9;
        const auto is_out = [&](const Slab& slab) {
            const double along = dot(place, slab.across) - slab.lower;
            return !(along > slack && along < 1 - slack);
        };
        const auto is_cut = [&](const Wall& wall) {
            const double along = dot(place, wall.normal);
            return !(along < wall.offset - slack * (std::abs(along) + std::abs(wall.offset)));
        };
        return std::ranges::any_of(slabs_, is_out) || std::ranges::any_of(walls_, is_cut);
    }

private:
    struct Slab {  // from lower to lower + 1
        Vector across;
        double lower;
    };
    static void remove_along(const Vector& along, Vector& from) {
        const double square = dot(along, along);
        if (!(square > 0)) return;
        const double turn = dot(along, from) / square;
        for (std::size_t k = 0; k < 3; ++k) from[k] -= turn * along[k];
    }

    std::span<const Wall> walls_;
    std::vector<Slab> slabs_;
};

// An edge as a cell has it.
struct Side {
    std::int32_t to;
    ByteShift shift;
    double radius;
    [[nodiscard]] std::pair<std::int32_t, ByteShift> end() const { return {to, shift}; }
};

// A sphere as a cell sees it, from its seed.
struct Sphere {
    Vector center;
    double radius;
};

// Returns the distance from the segment between two points to a sphere.
double distance_to_surface(const Vector& a, const Vector& b, const Sphere& sphere) {
    return distance_to_segment(minus(a, sphere.center), minus(b, sphere.center)) - sphere.radius;
}

class NetworkMaker {
public:
    // places: of the seeds. box: the vectors of a periodic domain.
    NetworkMaker(const Result& result, OutsideTest is_outside, std::span<const double> places,
                 const std::array<Vector, 3>& box)
        : r_(result),
          is_outside_(std::move(is_outside)),
          dimensions_(dimensions_of(result)),
          places_(places),
          box_(box),
          joined_(result),
          number_(result.vertices.size() / dimensions_) {
        double largest = 0;
        for (const auto& array : {std::span<const double>(result.vertices), places_})
            for (const double x : array) largest = std::max(largest, std::abs(x));
        if (largest > 0 && std::isfinite(largest)) exponent_ = std::clamp(std::ilogb(largest), -1000, 1000);
        per_unit_ = power_of_two(-exponent_);
        for (Vector& vector : box_)
            for (double& x : vector) x *= per_unit_;
        radii_.reserve(result.weights.size());
        for (const double weight : result.weights) radii_.push_back(std::sqrt(weight) * per_unit_);
        if (radii_.empty()) return;
        last_sphere_.assign(radii_.size(), radii_.size());
    }

    Network make() {
        number_vertices();
        find_larger();
        place_sides();
        join_sides();
        for (const auto& radii : {&out_.vertex_radii, &out_.edge_radii})
            for (double& radius : *radii) radius = times_power_of_two(radius, exponent_);
        return std::move(out_);
    }

private:
    void number_vertices() {
        for (std::size_t v = 0; v < number_.size(); ++v) {
            if (v % vertices_per_stop == 0) check_stop();
            const std::size_t first = joined_.original(static_cast<std::int32_t>(v));  // at most v
            if (first == v) {
                number_[v] = static_cast<std::int32_t>(out_.vertices.size());
                out_.vertices.push_back(static_cast<std::int32_t>(v));
                const double* point = &r_.vertices[dimensions_ * v];
                out_.points.insert(out_.points.end(), point, point + dimensions_);
            }
            number_[v] = number_[first];
        }
        out_.vertex_radii.assign(out_.vertices.size(), std::numeric_limits<double>::infinity());
        out_.at_walls.assign(out_.vertices.size(), 0);
    }

    // visit(a, b) for each edge of cell i, from its lower end. The polygons on both sides of an edge go along it in
    // opposite directions; one of them may have been dropped. In the plane a polygon is an edge, there and back.
    void for_edges(std::size_t i, const auto& visit) const {
        const bool whole = r_.dropped_offsets.empty();
        for (auto entry = at(r_.indptr[i]); entry < at(r_.indptr[i + 1]); ++entry) {
            const auto begin = r_.face_offsets[entry], end = r_.face_offsets[entry + 1];
            std::int32_t before = end > begin ? r_.face_vertices[at(end - 1)] : -1;
            for (auto k = begin; k < end; ++k) {
                const std::int32_t v = r_.face_vertices[at(k)];
                if (before >= 0 && v >= 0 && (before < v || !whole)) visit(before, v);
                before = v;
            }
        }
    }

    // Returns the lower end of an edge, and the edge from there; the end itself where the edge has shrunk.
    [[nodiscard]] std::pair<std::int32_t, Side> from_lower(std::int32_t a, std::int32_t b) const {
        const std::int32_t from = number_[at(a)], to = number_[at(b)];
        const ByteShift shift = sum(joined_.shift(b), negative(joined_.shift(a)));
        if (from < to || (from == to && shift >= ByteShift{})) return {from, {to, shift, 0}};
        return {to, {from, negative(shift), 0}};
    }

    // Sorts the edges of all cells by their lower ends.
    void place_sides() {
        begin_.assign(out_.vertices.size() + 2, 0);
        for_cells([&](std::size_t i) {
            for_edges(i, [&](std::int32_t a, std::int32_t b) { ++begin_[at(from_lower(a, b).first) + 2]; });
        });
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        sides_.resize(begin_.back());
        for_cells([&](std::size_t i) { measure(i); });
    }
    void for_cells(const auto& task) const {
        for (std::size_t i = 0; i < r_.status.size(); ++i) {
            if (i % cells_per_stop == 0) check_stop();
            task(i);
        }
    }

    [[nodiscard]] double radius(std::size_t i) const { return radii_.empty() ? 0 : radii_[i]; }
    // In a unit in which squares are representable.
    [[nodiscard]] Vector from_seed(std::size_t i, std::span<const double> array, std::size_t k) const {
        Vector difference = minus(vector_at(array, k, dimensions_), vector_at(places_, i, dimensions_));
        for (double& x : difference) x *= per_unit_;
        return difference;
    }
    [[nodiscard]] Vector from_seed(std::size_t i, std::int32_t vertex) const {
        return from_seed(i, r_.vertices, at(vertex));
    }
    [[nodiscard]] Sphere sphere(std::size_t i, const Member& m) const {
        Vector center = from_seed(i, places_, at(m.seed));
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t k = 0; k < 3 && m.shift[axis] != 0; ++k) center[k] += m.shift[axis] * box_[axis][k];
        return {center, radius(at(m.seed))};
    }

    // Lists for each cell the spheres larger than its own that are nearer to some place in it.
    //
    // Smaller ones are not nearer, as their power is not less. From a place go straight to the nearest surface. On the
    // way the same sphere stays the nearest. So each cell on the way has a smaller sphere and a place that the larger
    // one is nearer to, up to the cell of the larger one, or to a wall if that sphere lies outside of the domain. From
    // there they are found neighbor by neighbor.
    void find_larger() {
        std::vector<std::pair<std::size_t, Member>> found;  // by cell
        const auto try_cell = [&](const Member& next, std::size_t g) {
            const Member back{static_cast<std::int32_t>(g), negative(next.shift)};
            if (!(radius(at(next.seed)) < radius(g)) || !mark(next, g)) return;
            if (!is_nearer(at(next.seed), sphere(at(next.seed), back))) return;
            found.emplace_back(at(next.seed), back);
            queue_.push_back(next);
        };
        if (!radii_.empty()) {
            find_border();
            for_cells([&](std::size_t g) {
                if (r_.status[g] == CellStatus::outside || r_.status[g] == CellStatus::duplicate) return;
                queue_.assign(1, {static_cast<std::int32_t>(g), {}});
                seen_.clear();
                mark(queue_.back(), g);
                if (is_outside_(vector_at(places_, g, dimensions_))) for_border_near(g, try_cell);
                for (std::size_t seen = 0; !queue_.empty(); ++seen) {
                    if (seen % cells_per_stop == cells_per_stop - 1) check_stop();
                    const Member from = queue_.back();
                    queue_.pop_back();
                    for (auto e = at(r_.indptr[at(from.seed)]); e < at(r_.indptr[at(from.seed) + 1]); ++e) {
                        if (r_.indices[e] < 0) continue;
                        try_cell({r_.indices[e], sum(from.shift, shift_in(r_.shifts, e, 1, dimensions_))}, g);
                    }
                }
            });
        }
        larger_begin_.assign(r_.status.size() + 2, 0);
        for (const auto& [cell, member] : found) ++larger_begin_[cell + 2];
        std::partial_sum(larger_begin_.begin(), larger_begin_.end(), larger_begin_.begin());
        larger_.resize(found.size());
        for (const auto& [cell, member] : found) larger_[larger_begin_[cell + 1]++] = member;
    }
    // Finds the cells at walls, and how far they reach from their seeds.
    void find_border() {
        for_cells([&](std::size_t i) {
            if (r_.indptr[i] == r_.indptr[i + 1] || r_.indices[at(r_.indptr[i])] >= 0) return;
            double square = 0;
            for (auto k = at(r_.cell_vertex_indptr[i]); k < at(r_.cell_vertex_indptr[i + 1]); ++k) {
                const Vector end = from_seed(i, r_.cell_vertex_indices[k]);
                square = std::max(square, dot(end, end));
            }
            border_.push_back({static_cast<std::int32_t>(i), 2 * std::sqrt(square) - radius(i)});
        });
    }
    // visit(member, g) for each cell at a wall with a place that sphere g, or an image of it, may be nearer to: its
    // center lies within twice the cell's reach, by the triangle inequality.
    void for_border_near(std::size_t g, const auto& visit) const {
        constexpr double slack = 1 + 1e-9;
        for (const Border& cell : border_) {
            if (!(radius(at(cell.seed)) < radius(g))) continue;
            const double reach = (cell.reach + radius(g)) * slack;
            const auto side = [&](std::size_t axis) { return static_cast<std::int8_t>(r_.periodic[axis] ? 1 : 0); };
            ByteShift shift;
            for (shift[0] = -side(0); shift[0] <= side(0); ++shift[0])
                for (shift[1] = -side(1); shift[1] <= side(1); ++shift[1])
                    for (shift[2] = -side(2); shift[2] <= side(2); ++shift[2]) {
                        const Vector center =
                            sphere(at(cell.seed), {static_cast<std::int32_t>(g), negative(shift)}).center;
                        if (dot(center, center) < reach * reach) visit(Member{cell.seed, shift}, g);
                    }
        }
    }
    // Returns whether sphere g sees this cell for the first time.
    bool mark(const Member& m, std::size_t g) {
        if (m.shift != ByteShift{}) return seen_.insert(m).second;
        return std::exchange(last_sphere_[at(m.seed)], g) != g;
    }
    // Whether a larger sphere may be nearer than that of cell i at an end. A place is nearer if a convex function is
    // positive there, so a sphere that is nearer at no end is nearer nowhere in the cell.
    [[nodiscard]] bool is_nearer(std::size_t i, const Sphere& other) const {
        constexpr double slack = 1e-9;
        const double wider = other.radius - radius(i), square = dot(other.center, other.center);
        const double limit = square - wider * wider - slack * (square + wider * wider);
        for (auto k = at(r_.cell_vertex_indptr[i]); k < at(r_.cell_vertex_indptr[i + 1]); ++k) {
            const Vector end = from_seed(i, r_.cell_vertex_indices[k]);
            if (2 * (std::sqrt(dot(end, end)) * wider + dot(end, other.center)) > limit) return true;
        }
        return false;
    }

    void measure(std::size_t i) {
        larger_here_.clear();
        for (std::size_t k = larger_begin_[i]; k < larger_begin_[i + 1]; ++k)
            larger_here_.push_back(sphere(i, larger_[k]));
        const auto room = [&](const Vector& a, const Vector& b) {
            double least = distance_to_segment(a, b) - radius(i);
            for (const Sphere& other : larger_here_) least = std::min(least, distance_to_surface(a, b, other));
            return least;
        };
        for (auto k = at(r_.cell_vertex_indptr[i]); k < at(r_.cell_vertex_indptr[i + 1]); ++k) {
            const std::int32_t v = r_.cell_vertex_indices[k];
            const Vector to = from_seed(i, v);
            double& least = out_.vertex_radii[at(number_[at(v)])];
            least = std::min(least, room(to, to));
        }
        for_edges(i, [&](std::int32_t a, std::int32_t b) {
            auto [from, side] = from_lower(a, b);
            side.radius = room(from_seed(i, a), from_seed(i, b));
            sides_[begin_[at(from) + 1]++] = side;
        });
        for (auto entry = at(r_.indptr[i]); entry < at(r_.indptr[i + 1]) && r_.indices[entry] < 0; ++entry)
            for (auto k = r_.face_offsets[entry]; k < r_.face_offsets[entry + 1]; ++k)
                if (const std::int32_t v = r_.face_vertices[at(k)]; v >= 0) out_.at_walls[at(number_[at(v)])] = 1;
    }

    // The cells around an edge have it each. Rounding must not give an edge more room than its ends.
    void join_sides() {
        const bool periodic = !r_.shifts.empty();
        for (std::size_t v = 0; v < out_.vertices.size(); ++v) {
            if (v % vertices_per_stop == 0) check_stop();
            const auto own = std::span(sides_).subspan(begin_[v], begin_[v + 1] - begin_[v]);
            std::ranges::sort(own, {}, [](const Side& s) { return std::tuple(s.to, s.shift, s.radius); });
            const auto from = static_cast<std::int32_t>(v);
            for (std::size_t k = 0; k < own.size(); ++k) {
                const Side& side = own[k];
                if (side.to == from && side.shift == ByteShift{}) continue;
                if (k > 0 && own[k - 1].end() == side.end()) continue;
                out_.edges.insert(out_.edges.end(), {from, side.to});
                if (periodic)
                    out_.shifts.insert(out_.shifts.end(), side.shift.begin(), side.shift.begin() + dimensions_);
                out_.edge_radii.push_back(
                    std::min({side.radius, out_.vertex_radii[v], out_.vertex_radii[at(side.to)]}));
            }
        }
    }

    const Result& r_;
    const OutsideTest is_outside_;
    const std::size_t dimensions_;
    std::span<const double> places_;
    std::array<Vector, 3> box_;
    int exponent_ = 0;  // coordinates are below about 2^exponent_
    double per_unit_;
    std::vector<double> radii_;  // N in a power diagram, else empty
    const JoinedCorners joined_;
    std::vector<std::int32_t> number_;  // by vertex of the mesh
    std::vector<std::size_t> begin_;    // of the sides of each vertex
    std::vector<Side> sides_;
    struct Border {
        std::int32_t seed;
        double reach;  // see for_border_near()
    };
    std::vector<Border> border_;
    std::vector<std::size_t> larger_begin_;  // of the larger spheres of each cell, see find_larger()
    std::vector<Member> larger_;
    std::vector<Sphere> larger_here_;       // of one cell
    std::vector<std::size_t> last_sphere_;  // by seed: the last sphere that saw its cell, without a shift
    std::set<Member> seen_;                 // cells with a shift, by this sphere
    std::vector<Member> queue_;
    Network out_;
};

// Sets of vertices between which a sphere can move, with the shift from the root of a set to each: union-find (Galler
// and Fischer 1964) with weights on the links.
class ConnectedVertices {
public:
    using Shift = std::array<std::int64_t, 3>;
    struct Place {
        std::size_t root;
        Shift shift;
    };

    explicit ConnectedVertices(std::size_t count) : up_(count), size_(count, 1), shift_(count) {
        std::iota(up_.begin(), up_.end(), std::size_t{0});
    }

    Place find(std::size_t v) {
        Shift shift{};
        for (; up_[v] != v; v = up_[v]) {
            if (const std::size_t above = up_[v]; up_[above] != above) {
                add(shift_[v], shift_[above]);
                up_[v] = up_[above];
            }
            add(shift, shift_[v]);
        }
        return {v, shift};
    }
    // Joins the sets of a, and of b moved by the shift. Returns how far the way along this edge and back within the set
    // leads if they are in one set already.
    Shift unite(std::size_t a, std::size_t b, Shift shift) {
        Place from = find(a), to = find(b);
        add(shift, from.shift);
        for (std::size_t k = 0; k < 3; ++k) shift[k] -= to.shift[k];
        if (from.root == to.root) return shift;
        if (size_[from.root] < size_[to.root]) {
            std::swap(from, to);
            for (auto& s : shift) s = -s;
        }
        up_[to.root] = from.root;
        size_[from.root] += size_[to.root];
        shift_[to.root] = shift;
        return {};
    }

private:
    static void add(Shift& to, const Shift& more) {
        for (std::size_t k = 0; k < 3; ++k) to[k] += more[k];
    }

    std::vector<std::size_t> up_, size_;
    std::vector<Shift> shift_;  // from the one above
};

}  // namespace

Network network(const Tessellation& tessellation, std::span<const double> points) {
    require(tessellation, "network");
    require_finite_points(tessellation, points, "network");
    const Result& result = detail::result_of(tessellation);
    const auto refuse = [](const std::string& message) {
        throw Error(ErrorCode::invalid_argument, "network(): " + message);
    };
    if (result.face_offsets.empty() && !result.status.empty())
        refuse("the tessellation has no polygons, set " + option("want.faces"));
    for (std::size_t i = 0; i < result.weights.size(); ++i)
        if (result.weights[i] < 0)
            refuse("the weight of seed " + std::to_string(i) +
                   " is negative: weights are squares of radii here, give radii");
    const std::vector<double> places = wrapped_points(tessellation, points);
    std::array<Vector, 3> box{};
    if (const auto& cell = tessellation.cell())
        box = {cell->a, cell->b, cell->c};
    else
        for (std::size_t k = 0; k < 3; ++k)
            if (tessellation.periodic()[k]) box[k][k] = tessellation.box().upper[k] - tessellation.box().lower[k];
    return NetworkMaker(result, OutsideTest(tessellation), places, box).make();
}

IncludedSphere Network::largest_included() const {
    const auto largest = std::ranges::max_element(vertex_radii);
    if (largest == vertex_radii.end()) return {-std::numeric_limits<double>::infinity(), -1};
    return {*largest, static_cast<std::int32_t>(largest - vertex_radii.begin())};
}

// Edges join vertices from the widest edge down. The first way from a vertex to an image of itself has the most room.
// Where ways of several regions have as much, that of the largest sphere counts.
std::optional<FreeSphere> Network::largest_free(std::optional<int> axis) const {
    const std::size_t dimensions = shifts.empty() ? 3 : shifts.size() / edge_radii.size();
    if (axis && (*axis < 0 || *axis >= static_cast<int>(dimensions)))
        throw Error(ErrorCode::invalid_argument, "largest_free(): axis " + std::to_string(*axis) + ": give 0" +
                                                     (dimensions == 2 ? " or 1" : ", 1 or 2") + ", or none");
    if (shifts.empty()) return {};
    std::vector<std::int32_t> order(edge_radii.size());
    std::iota(order.begin(), order.end(), 0);
    std::size_t compared = 0;
    std::ranges::stable_sort(order, [&](std::int32_t a, std::int32_t b) {
        if (++compared % comparisons_per_stop == 0) check_stop();
        return edge_radii[at(a)] > edge_radii[at(b)];
    });
    ConnectedVertices sets(vertex_radii.size());
    std::vector<std::int32_t> ways;  // edges of equal room that close a way to an image
    for (std::size_t next = 0; next < order.size(); ++next) {
        if (next % vertices_per_stop == 0) check_stop();
        const std::int32_t e = order[next];
        if (!ways.empty() && edge_radii[at(e)] < edge_radii[at(ways[0])]) break;
        const std::size_t from = at(edges[2 * at(e)]), to = at(edges[2 * at(e) + 1]);
        const ByteShift s = shift_in(shifts, at(e), 1, dimensions);
        const ConnectedVertices::Shift net = sets.unite(from, to, {s[0], s[1], s[2]});
        if (axis ? net[at(*axis)] != 0 : net != ConnectedVertices::Shift{}) ways.push_back(e);
    }
    if (ways.empty()) return {};
    std::vector<std::int32_t> way_of(vertex_radii.size(), -1);  // by root: the first
    for (const std::int32_t e : ways)
        if (auto& way = way_of[sets.find(at(edges[2 * at(e)])).root]; way < 0) way = e;
    FreeSphere found{edge_radii[at(ways[0])], -1, {-std::numeric_limits<double>::infinity(), -1}};
    in_pieces(vertex_radii.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const std::int32_t way = way_of[sets.find(v).root];
            if (way < 0 || !(vertex_radii[v] > found.included.radius)) continue;
            found.edge = way;
            found.included = {vertex_radii[v], static_cast<std::int32_t>(v)};
        }
    });
    return found;
}

}  // namespace votess
