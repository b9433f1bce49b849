#include "solid/cut_cell.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/arithmetic.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"

namespace votess::solid {
namespace {

constexpr double beyond_rounding = 1e-12;  // of coordinates, for a height above a face
constexpr double sum_rounding = 4 * unit;
constexpr double place_rounding = 0x1p-42;   // of the extent of a part
constexpr double volume_rounding = 0x1p-36;  // of a volume; half of it is for the centroid
constexpr double surface_rounding = 0x1p-36;
constexpr double overlay_rounding = 0x1p-38;  // of the extent; triangles in a plane may reach far
constexpr double quad_rounding = 0x1p-114;    // of a cone's terms, and of the extent
constexpr std::size_t word_bits = 64;
constexpr std::size_t triangles_per_stop = 256, places_per_stop = 256;  // after which the user may stop
constexpr std::int32_t absent = -2;                                     // of a vertex without a side yet
constexpr double beside_margin = 1e-8;  // of the distances that a triangle's plane is compared with

template <class Real>
std::array<Real, 3> difference(const std::array<Real, 3>& a, const std::array<Real, 3>& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Vector3 plus(const Vector3& a, const Vector3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

double largest(const Vector3& x) {
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
}

// A place between a and b, where a value changes its sign. It has these values and errors there.
struct Between {
    Vector3 x;
    double error;  // of x, if a and b are right
};

Between between(const Vector3& a, const Vector3& b, double at_a, double at_b, double errors) {
    const double range = std::abs(at_a - at_b), t = range > 0 ? std::clamp(at_a / (at_a - at_b), 0.0, 1.0) : 0.5;
    Between place;
    for (std::size_t k = 0; k < 3; ++k) place.x[k] = a[k] + t * (b[k] - a[k]);
    const double length = largest(minus(b, a));
    place.error = errors < 0.5 * range
                      ? length * (errors / (range - errors) + 4 * unit) + 4 * unit * std::max(largest(a), largest(b))
                      : infinity;
    return place;
}

std::size_t index(std::int32_t i) {
    return static_cast<std::size_t>(i);
}

}  // namespace

void CutCell::begin(const exact::Point& seed, std::int32_t id, const exact::Shift& move, double weight) {
    weight_ = weight;
    image_ = exact::Plane::bisector(seed, move, domain_.lattice);
    const auto place = exact::differences({}, image_).x;
    origin_ = {place[0].high, place[1].high, place[2].high};
    cell_.start(seed, domain_, id);
    signs_.begin(seed, image_);
}

void CutCell::add(std::int32_t id, const exact::Plane& neighbor, const exact::Shift& shift, double weight,
                  double inward) {
    exact::Plane bisector = neighbor;
    bisector.power = exact::two_sum(weight_, -weight);
    if (inward != 0) bisector.power = {bisector.power.high - inward, 0};
    cell_.clip(id, bisector, shift);
}

const CutMeasures& CutCell::measure(bool decide_faces) {
    std::vector<CutMeasures::Face> faces = std::move(out_.faces);  // for its memory
    faces.clear();
    out_ = {};
    out_.faces = std::move(faces);
    if (empty()) return out_;
    make_faces();
    find_candidates();
    std::size_t tried = 0;
    for (const std::uint32_t t : candidates_) {
        if (++tried % triangles_per_stop == 0) check_stop();
        const ClosedMesh::Triangle& triangle = mesh_.triangles()[t];
        const bool meets = clip(triangle);
        if (meets) add_polygon(t);
        if (face_of_triangle_ >= 0) add_on_face(triangle);
        if (meets || face_of_triangle_ >= 0) out_.meets_surface = true;
    }
    find_windings();
    if (!out_.meets_surface) return out_;
    find_places();
    find_segments();
    find_cones();
    const ConeSum part = sum(cones_);
    out_.empty = part.empty;
    out_.volume = part.volume;
    for (std::size_t k = 0; k < 3; ++k) out_.centroid[k] = apex_[k] + part.centroid[k];
    measure_areas();
    measure_faces(decide_faces);
    return out_;
}

void CutCell::find_faces() {
    make_faces();
    for (Place& place : place_) place.is_used = true;
    measure_places();
}

void CutCell::make_faces() {
    out_.faces.clear();
    cell_.canonical_faces(faces_);
    read_faces();
    crossings_.clear();
    segments_.clear();
    polygons_.clear();
    polygon_sides_.clear();
    on_faces_.clear();
    exact_is_ready_ = false;
    quads_.clear();
}

// Makes the edges, and their planes' bisectors.
void CutCell::read_faces() {
    const std::size_t count = faces_.size(), slots = static_cast<std::size_t>(cell_.slots());
    first_half_.assign(slots, absent);
    slots_.clear();
    for (const std::int32_t slot : faces_.corners) {
        if (first_half_[index(slot)] != absent) continue;
        first_half_[index(slot)] = -1;
        slots_.push_back(slot);
    }
    apex_ = {};
    for (const std::int32_t slot : slots_) apex_ = plus(apex_, cell_.position(slot));
    for (double& x : apex_) x /= static_cast<double>(slots_.size());
    at_slot_.assign(slots, -1);
    place_.clear();
    for (const std::int32_t slot : slots_) {
        const Vector3 x = cell_.position(slot);
        at_slot_[index(slot)] = add_place({Place::Kind::vertex, {slot}, minus(x, apex_), cell_.tolerance(slot)});
    }
    plane_.assign(count, -1);
    base_.assign(count, -1);
    unit_.resize(count);
    edges_.clear();
    edge_between_.assign(count * count, -1);
    halves_.clear();
    std::int32_t bisectors = 0;
    for (std::size_t f = 0; f < count; ++f) {
        const cpu::CellPlane& plane = cell_.planes()[index(faces_.planes[f])];
        if (plane.source.is_bisector()) {
            signs_.add(plane.source);
            plane_[f] = bisectors++;
        }
        out_.faces.push_back({plane.id, plane.shift});
        const int exponent = std::ilogb(largest(plane.n));  // squares of very short normals underflow
        for (std::size_t k = 0; k < 3; ++k) unit_[f][k] = std::scalbn(plane.n[k], -exponent);
        const double norm = length3(unit_[f][0], unit_[f][1], unit_[f][2]);
        for (double& x : unit_[f]) x /= norm;
        const std::int32_t begin = faces_.offsets[f], end = faces_.offsets[f + 1];
        for (std::int32_t c = begin; c < end; ++c)
            add_half(faces_.corners[index(c)], faces_.corners[index(c + 1 == end ? begin : c + 1)],
                     static_cast<std::int32_t>(f));
    }
    signs_.find_center(apex_);
    if (2 * edges_.size() != faces_.corners.size())
        throw Error(ErrorCode::internal, "a cell in a mesh has an edge without a second face");
}

// Makes an edge of two sides that run along it in opposite directions.
void CutCell::add_half(std::int32_t from, std::int32_t to, std::int32_t face) {
    for (std::int32_t* link = &first_half_[index(to)]; *link >= 0;) {
        const Half& half = halves_[index(*link)];
        if (half.to == from) {
            edge_of(half.face, face) = edge_of(face, half.face) = static_cast<std::int32_t>(edges_.size());
            edges_.push_back({to, from, half.face, face});
            *link = half.next;
            return;
        }
        link = &halves_[index(*link)].next;
    }
    halves_.push_back({to, face, first_half_[index(from)]});
    first_half_[index(from)] = static_cast<std::int32_t>(halves_.size()) - 1;
}

void CutCell::find_candidates() {
    Box bounds = empty_box;
    for (const std::int32_t slot : slots_)
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = cell_.position(slot)[k] + origin_[k];
            const double error = cell_.tolerance(slot) + sum_rounding * (std::abs(x) + std::abs(origin_[k]));
            bounds.lower[k] = std::min(bounds.lower[k], x - error);
            bounds.upper[k] = std::max(bounds.upper[k], x + error);
        }
    // Long cells at an angle have large boxes: planes of their faces pass over most of the mesh in them.
    const auto is_beyond = [&](const Box& box) {
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const std::int32_t slot = faces_.corners[index(faces_.offsets[f])];
            const auto& on_face = cell_.position(slot);
            double height = 0, size = 0;  // of the corner farthest inward, above the face
            for (std::size_t k = 0; k < 3; ++k) {
                const double corner = unit_[f][k] > 0 ? box.lower[k] : box.upper[k];
                height += unit_[f][k] * (corner - origin_[k] - on_face[k]);
                size += std::abs(corner) + std::abs(origin_[k]) + std::abs(on_face[k]);
            }
            if (height > beyond_rounding * size + 4 * cell_.tolerance(slot)) return true;
        }
        return false;
    };
    candidates_.clear();
    const auto add = [&](std::uint32_t t) {
        candidates_.push_back(t);
        return true;
    };
    mesh_.for_each_in(bounds, add, is_beyond);
    std::ranges::sort(candidates_);
    seen_.clear();
    outside_bits_.clear();
    words_ = ceil_div(faces_.size(), word_bits);
    values_.resize(faces_.size());
    seen_table_.assign(std::bit_ceil(6 * candidates_.size() + 2), -1);  // at least half of it stays free
}

// Returns the place of a vertex in seen_.
std::size_t CutCell::see(std::int32_t vertex) {
    const std::size_t mask = seen_table_.size() - 1;
    std::size_t at = (static_cast<std::size_t>(vertex) * 0x9e3779b97f4a7c15) >> 32 & mask;
    for (; seen_table_[at] >= 0; at = (at + 1) & mask)
        if (seen_[index(seen_table_[at])].vertex == vertex) return index(seen_table_[at]);
    const std::size_t seen = seen_.size();
    seen_table_[at] = static_cast<std::int32_t>(seen);
    seen_.push_back({vertex, 0, false, signs_.place(mesh_.vertex(vertex))});
    SeenVertex& u = seen_.back();
    outside_bits_.resize(outside_bits_.size() + words_);
    if (const std::size_t count = seen_.size() * faces_.size(); vertex_values_.size() < count)
        vertex_values_.resize(2 * count);
    MeshSigns::Value* value = &vertex_values_[seen * faces_.size()];
    for (std::size_t f = 0; f < faces_.size(); ++f, ++value) {
        if (plane_[f] < 0) {
            *value = {0, 0, -1, false};  // inside of the walls
            continue;
        }
        *value = signs_.value(index(plane_[f]), u.place);
        u.unsure += value->sign == 0 ? 1 : 0;
        if (value->sign > 0) outside_bits_[seen * words_ + f / word_bits] |= std::uint64_t{1} << f % word_bits;
    }
    return seen;
}

// Finds the signs that rounding hides.
void CutCell::decide(std::size_t seen) {
    SeenVertex& u = seen_[seen];
    for (std::size_t f = 0; f < faces_.size() && u.unsure > 0; ++f) {
        MeshSigns::Value& value = vertex_values_[seen * faces_.size() + f];
        if (value.sign != 0) continue;
        signs_.find_sign(index(plane_[f]), u.place, value);
        --u.unsure;
        u.tied |= value.tie;
        if (value.sign > 0) outside_bits_[seen * words_ + f / word_bits] |= std::uint64_t{1} << f % word_bits;
    }
}

// Returns whether the cell lies on one side of the triangle's plane, by more than rounding.
bool CutCell::beside(const ClosedMesh::Triangle& triangle) const {
    if (triangle.normal == Vector3{}) return false;
    const Vector3 from = signs_.place(mesh_.vertex(triangle.vertex[0])).relative;
    const double offset = dot(triangle.normal, from);
    double lower = infinity, upper = -infinity, size = std::abs(from[0]) + std::abs(from[1]) + std::abs(from[2]);
    for (const std::int32_t slot : slots_) {
        const Vector3 x = cell_.position(slot);
        const double height = dot(triangle.normal, x) - offset;
        const double error =
            2 * cell_.tolerance(slot) + beside_margin * (size + std::abs(x[0]) + std::abs(x[1]) + std::abs(x[2]));
        lower = std::min(lower, height - error);
        upper = std::max(upper, height + error);
    }
    return lower > 0 || upper < 0;
}

// Leaves the polygon in sides_. Returns whether there is one. Sets face_of_triangle_.
bool CutCell::clip(const ClosedMesh::Triangle& triangle) {
    face_of_triangle_ = -1;
    std::array<std::size_t, 3> seen;
    for (std::size_t i = 0; i < 3; ++i) seen[i] = see(triangle.vertex[i]);
    const auto bits = [&](std::size_t i, std::size_t word) { return outside_bits_[seen[i] * words_ + word]; };
    const auto is_outside = [&] {
        for (std::size_t word = 0; word < words_; ++word)
            if ((bits(0, word) & bits(1, word) & bits(2, word)) != 0) return true;
        return false;
    };
    const auto may_lie_on_face = [&] { return seen_[seen[0]].tied && seen_[seen[1]].tied && seen_[seen[2]].tied; };
    if ((is_outside() && !may_lie_on_face()) || beside(triangle)) return false;
    for (std::size_t i = 0; i < 3; ++i) {
        decide(seen[i]);
        places_[i] = seen_[seen[i]].place;
    }
    const auto read_values = [&](std::size_t f) {
        for (std::size_t i = 0; i < 3; ++i) values_[f][i] = vertex_values_[seen[i] * faces_.size() + f];
    };
    const auto is_tie = [&](const MeshSigns::Value& value) { return value.tie; };
    if (may_lie_on_face())
        for (std::size_t f = 0; f < faces_.size() && face_of_triangle_ < 0; ++f) {
            read_values(f);
            if (std::ranges::all_of(values_[f], is_tie)) face_of_triangle_ = static_cast<std::int32_t>(f);
        }
    if (is_outside()) return false;
    sides_ = {-1, -2, -3};
    for (std::size_t word = 0; word < words_; ++word)
        for (std::uint64_t cutting = bits(0, word) | bits(1, word) | bits(2, word); cutting != 0;
             cutting &= cutting - 1) {
            const std::size_t f = word * word_bits + static_cast<std::size_t>(std::countr_zero(cutting));
            read_values(f);
            if (!clip_by(f)) return false;
        }
    return true;
}

// Clips the polygon by a face. Returns whether any is left.
bool CutCell::clip_by(std::size_t f) {
    const std::size_t size = sides_.size();
    outside_.resize(size);
    int corners_outside = 0;
    for (std::size_t i = 0; i < size; ++i) {  // of the corner where side i begins
        outside_[i] = side({sides_[i == 0 ? size - 1 : i - 1], sides_[i]}, f) > 0 ? 1 : 0;
        corners_outside += outside_[i];
    }
    if (corners_outside == 0) return true;
    if (corners_outside == static_cast<int>(size)) return false;
    clipped_.clear();
    for (std::size_t i = 0; i < size; ++i) {
        const bool from = outside_[i] != 0, to = outside_[i + 1 == size ? 0 : i + 1] != 0;
        if (!from || !to) clipped_.push_back(sides_[i]);
        if (!from && to) clipped_.push_back(static_cast<Side>(f));
    }
    std::swap(sides_, clipped_);
    return true;
}

// Returns +1 if the corner lies outside the face's plane, else -1.
int CutCell::side(const Corner& corner, std::size_t face) {
    const MeshSigns::Values& f = values_[face];
    if (corner.in < 0 && corner.out < 0) return f[index(-1 - corner.out)].sign;
    const std::size_t plane = index(plane_[face]);
    if (corner.in < 0 || corner.out < 0) {
        const std::size_t from = index(-1 - std::min(corner.in, corner.out)), to = (from + 1) % 3;
        const std::size_t a = index(std::max(corner.in, corner.out));
        // Both ends decide alike where they lie on one side.
        if (f[from].sign == f[to].sign) return f[from].sign;
        return signs_.edge_side(plane, index(plane_[a]), places_[from], places_[to], f[from], f[to], values_[a][from],
                                values_[a][to]);
    }
    const std::size_t a = index(corner.in), b = index(corner.out);
    return signs_.determinant({index(plane_[a]), index(plane_[b]), plane}, places_, values_[a], values_[b], f);
}

std::int32_t CutCell::add_mesh_vertex(std::int32_t vertex, const Vector3& relative) {
    return add_place({Place::Kind::mesh_vertex, {vertex}, minus(relative, apex_), 2 * unit * largest(relative)});
}

// Returns the place of a corner of the polygon.
std::int32_t CutCell::place_of(const Corner& corner, std::uint32_t t) {
    const ClosedMesh::Triangle& triangle = mesh_.triangles()[t];
    if (corner.in < 0 && corner.out < 0) {
        const std::size_t i = index(-1 - corner.out);
        return add_mesh_vertex(triangle.vertex[i], places_[i].relative);
    }
    if (corner.in < 0 || corner.out < 0) {
        std::size_t from = index(-1 - std::min(corner.in, corner.out)), to = (from + 1) % 3;
        if (triangle.vertex[from] > triangle.vertex[to]) std::swap(from, to);  // as the triangle behind the edge does
        return add_place(on_mesh_edge(from, to, index(std::max(corner.in, corner.out)), triangle));
    }
    // From inside to outside along an edge of the cell, which runs counterclockwise around face `in`.
    const std::int32_t found = edge_of(corner.in, corner.out);
    if (found < 0) throw Error(ErrorCode::internal, "the mesh passes between two faces of a cell that share no edge");
    Edge& edge = edges_[index(found)];
    const std::int32_t place = add_place(on_edge(edge, t));
    crossings_.push_back({place, edge.left == corner.in ? -1 : 1, edge.first});
    edge.first = static_cast<std::int32_t>(crossings_.size()) - 1;
    return place;
}

CutCell::Place CutCell::on_mesh_edge(std::size_t from, std::size_t to, std::size_t face,
                                     const ClosedMesh::Triangle& triangle) const {
    const MeshSigns::Values& a = values_[face];
    const auto [x, error] =
        between(places_[from].relative, places_[to].relative, a[from].s, a[to].s, a[from].error + a[to].error);
    return {Place::Kind::on_mesh_edge,
            {static_cast<std::int32_t>(face), triangle.vertex[from], triangle.vertex[to]},
            minus(x, apex_),
            error};
}

// The values of the triangle's plane are n.(x - u), for its vertex u.
CutCell::Place CutCell::on_edge(const Edge& edge, std::uint32_t t) const {
    const Vector3 &u = places_[0].relative, a = minus(places_[1].relative, u), b = minus(places_[2].relative, u),
                  n = cross(a, b);
    const auto end = [&](std::int32_t slot) { return plus(at(at_slot_[index(slot)]), apex_); };
    const Vector3 x = end(edge.from), y = end(edge.to), from_u = minus(x, u), to_u = minus(y, u);
    const double tolerance =
        std::max(cell_.tolerance(edge.from), cell_.tolerance(edge.to)) + 4 * unit * std::max(largest(x), largest(y));
    const double farthest = std::max({largest(u), largest(places_[1].relative), largest(places_[2].relative)});
    const double normal_error =
        4 * (4 * unit * farthest * (largest(a) + largest(b)) + 2 * unit * largest(a) * largest(b));
    const double distance = std::max(largest(from_u), largest(to_u));
    const double value_error =
        3 * (normal_error * distance + largest(n) * (tolerance + 4 * unit * (largest(u) + distance)));
    const auto [place, error] = between(x, y, dot(n, from_u), dot(n, to_u), 2 * value_error);
    return {Place::Kind::on_edge,
            {edge.left, edge.right, static_cast<std::int32_t>(t)},
            minus(place, apex_),
            error + tolerance};
}

void CutCell::add_polygon(std::uint32_t t) {
    const std::size_t size = sides_.size();
    const auto polygon = static_cast<std::int32_t>(polygons_.size());
    polygons_.push_back({t, static_cast<std::int32_t>(polygon_sides_.size()), face_of_triangle_ >= 0});
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t before = crossings_.size();
        const std::int32_t place = place_of({sides_[i == 0 ? size - 1 : i - 1], sides_[i]}, t);
        place_[index(place)].is_used = true;
        const bool crosses = crossings_.size() > before;
        if (crosses) crossings_[before].polygon = polygon;
        polygon_sides_.push_back({sides_[i], crosses ? static_cast<std::int32_t>(before) : -1, place});
    }
}

void CutCell::add_on_face(const ClosedMesh::Triangle& triangle) {
    const std::size_t f = index(face_of_triangle_);
    OnFace on{face_of_triangle_, triangle.given, {}, values_[f][0].sign < 0, false};
    for (std::size_t i = 0; i < 3; ++i) on.places[i] = add_mesh_vertex(triangle.vertex[i], places_[i].relative);
    const Vector3& normal = unit_[f];
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
    const int turn = cross_sign(places_[0].x, places_[1].x, places_[2].x, static_cast<int>(axis));
    on.faces_out = turn == (normal[axis] > 0 ? 1 : -1);
    on_faces_.push_back(on);
}

// Moves the apex to a corner of the part, and finds all corners it has well enough.
void CutCell::find_places() {
    const auto use = [&](std::int32_t slot) { place_[index(at_slot_[index(slot)])].is_used = true; };
    for (const std::int32_t slot : slots_)
        if (winding_[index(slot)] != 0) use(slot);
    find_apex();
    for (const OnFace& on : on_faces_)
        for (std::int32_t c = faces_.offsets[index(on.face)]; c < faces_.offsets[index(on.face) + 1]; ++c)
            use(faces_.corners[index(c)]);
    measure_places();
    for (Place& place : place_) {
        if (!place.is_used || place.error <= place_rounding * extent_) continue;
        if (!exact_is_ready_) prepare_exact(apex_);
        place.x = rounded(exact_place(place));
        place.error = 2 * unit * largest(place.x);
    }
    measure_places();
}

// Finds the extent of the part, and the largest error.
void CutCell::measure_places() {
    extent_ = place_error_ = 0;
    for (const Place& place : place_) {
        if (!place.is_used) continue;
        extent_ = std::max(extent_, largest(place.x) - place.error);
        place_error_ = std::max(place_error_, place.error);
    }
}

void CutCell::find_apex() {
    const Place* best = nullptr;
    for (const Place& place : place_)
        if (place.is_used && (best == nullptr || place.error < best->error)) best = &place;
    if (best == nullptr) return;
    Vector3 apex = plus(best->x, apex_);
    if (!(best->error <= place_rounding * largest(apex))) {
        prepare_exact({});
        apex = rounded(exact_place(*best));
        exact_is_ready_ = false;
    }
    for (Place& place : place_) {
        const double before = largest(place.x);
        for (std::size_t k = 0; k < 3; ++k) {
            place.x[k] += apex_[k];
            place.x[k] -= apex[k];
        }
        place.error += 2 * unit * (before + largest(apex_) + largest(place.x));
    }
    apex_ = apex;
}

// Prepares exact places relative to an origin, which is relative to the seed.
void CutCell::prepare_exact(const Vector3& origin) {
    exact_.begin(cell_.seed(), image_, origin);
    for (const cpu::CellPlane& plane : cell_.planes()) exact_.include(plane.source);
    for (const Polygon& polygon : polygons_)
        for (const std::int32_t v : mesh_.triangles()[polygon.triangle].vertex) exact_.include(mesh_.vertex(v));
    for (const OnFace& on : on_faces_)
        for (const std::int32_t v : on.places) exact_.include(mesh_.vertex(place_[index(v)].of[0]));
    exact_.prepare();
    exact_is_ready_ = true;
    quads_.clear();
}

ExactPlace CutCell::exact_place(const Place& place) const {
    const auto& [i, j, k] = place.of;
    const auto plane = [&](std::int32_t face) { return index(faces_.planes[index(face)]); };
    switch (place.kind) {
        case Place::Kind::mesh_vertex:
            return exact_.vertex(mesh_.vertex(i));
        case Place::Kind::on_mesh_edge:
            return exact_.on_edge(plane(i), mesh_.vertex(j), mesh_.vertex(k));
        case Place::Kind::on_edge: {
            const auto& [u, v, w] = mesh_.triangles()[index(k)].vertex;
            return exact_.on_triangle(plane(i), plane(j), {mesh_.vertex(u), mesh_.vertex(v), mesh_.vertex(w)});
        }
        default: {
            const auto planes = cell_.corner_planes(i);
            const auto at = [&](std::size_t p) { return static_cast<std::size_t>(planes[p] - cell_.planes().data()); };
            return exact_.meeting(at(0), at(1), at(2));
        }
    }
}

Vector3 CutCell::rounded(const ExactPlace& place) const {
    Vector3 x;
    for (std::size_t k = 0; k < 3; ++k)
        x[k] = static_cast<double>(
            ldexp(static_cast<exact::Quad>(exact::Fraction(place.x[k], place.w)), exact_.quantum()));
    return x;
}

// Finds the winding number of each vertex, from one of them along the edges.
void CutCell::find_windings() {
    std::int32_t start = -1;
    bool on_wall = false;
    for (std::size_t f = 0; f < faces_.size() && !on_wall; ++f)
        if (plane_[f] < 0) start = faces_.corners[index(faces_.offsets[f])], on_wall = true;
    if (!on_wall)
        for (const std::int32_t slot : slots_)
            if (start < 0 || cell_.tolerance(slot) < cell_.tolerance(start)) start = slot;
    out_.winding = on_wall ? 0 : winding_at(start);  // the mesh lies inside of the walls
    if (!out_.meets_surface) return;
    winding_.assign(index(cell_.slots()), 0);
    known_.assign(index(cell_.slots()), 0);
    winding_[index(start)] = out_.winding;
    known_[index(start)] = 1;
    // Each pass keeps the edges whose vertices are both unknown.
    pending_.resize(edges_.size());
    std::iota(pending_.begin(), pending_.end(), 0);
    for (std::size_t before = pending_.size() + 1; pending_.size() < before;) {
        before = pending_.size();
        std::erase_if(pending_, [&](std::int32_t e) {
            const Edge& edge = edges_[index(e)];
            const std::size_t from = index(edge.from), to = index(edge.to);
            if (known_[from] == known_[to]) return known_[from] != 0;
            int jump = 0;
            for (std::int32_t c = edge.first; c >= 0; c = crossings_[index(c)].next) jump += crossings_[index(c)].jump;
            if (known_[from] != 0)
                winding_[to] = winding_[from] + jump;
            else
                winding_[from] = winding_[to] - jump;
            known_[from] = known_[to] = 1;
            return true;
        });
    }
}

// Counts the triangles above a vertex of three bisectors.
int CutCell::winding_at(std::int32_t slot) {
    const auto planes = cell_.corner_planes(slot);
    std::array<std::size_t, 3> k;
    MeshSigns& at = corner_signs_;
    at.begin(cell_.seed(), image_);
    at.set_center(signs_);
    for (std::size_t i = 0; i < 3; ++i) {
        k[i] = i;
        at.add(planes[i]->source);
    }
    const int turn = exact::orientation(cell_.seed(), planes[0]->source, planes[1]->source, planes[2]->source);
    Box column;
    for (std::size_t i = 0; i < 3; ++i) {
        const double x = cell_.position(slot)[i] + origin_[i];
        const double error = cell_.tolerance(slot) + sum_rounding * (std::abs(x) + std::abs(origin_[i]));
        column.lower[i] = x - error;
        column.upper[i] = i == 2 ? infinity : x + error;
    }
    int winding = 0;
    mesh_.for_each_in(column, [&](std::uint32_t t) {
        const ClosedMesh::Triangle& triangle = mesh_.triangles()[t];
        if (triangle.upward == 0) return true;
        MeshSigns::Places u;
        for (std::size_t i = 0; i < 3; ++i) u[i] = at.place(mesh_.vertex(triangle.vertex[i]));
        for (std::size_t i = 0; i < 3; ++i)
            if (turn * at.upright_determinant(k, u[i], u[(i + 1) % 3]) != triangle.upward) return true;
        std::array<MeshSigns::Values, 3> values;
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t i = 0; i < 3; ++i) values[row][i] = at.value(row, u[i]);
        if (turn * at.determinant(k, u, values[0], values[1], values[2]) == triangle.upward) winding += triangle.upward;
        return true;
    });
    return winding;
}

// Finds the sides of the parts of all faces.
void CutCell::find_segments() {
    const auto add_segment = [&](const Segment& segment) {
        std::int32_t& base = base_[index(segment.face)];
        if (base < 0) base = segment.from;
        segments_.push_back(segment);
    };
    for (const Edge& edge : edges_) {
        on_edge_.clear();
        for (std::int32_t c = edge.first; c >= 0; c = crossings_[index(c)].next)
            on_edge_.push_back(crossings_[index(c)]);
        std::int32_t from = at_slot_[index(edge.from)];
        const std::int32_t end = at_slot_[index(edge.to)];
        // Where rounding changes the order, segments that are too much run back and forth.
        const Vector3 along = minus(at(end), at(from));
        std::ranges::sort(on_edge_, {}, [&](const Crossing& c) { return dot(along, at(c.place)); });
        on_edge_.push_back({end, 0, -1});
        int winding = winding_[index(edge.from)];
        for (const Crossing& crossing : on_edge_) {
            if (winding != 0) {
                add_segment({edge.left, from, crossing.place, winding});
                add_segment({edge.right, crossing.place, from, winding});
            }
            winding += crossing.jump;
            from = crossing.place;
        }
    }
    for (std::size_t p = 0; p < polygons_.size(); ++p) {
        const std::size_t begin = index(polygons_[p].begin),
                          end = p + 1 < polygons_.size() ? index(polygons_[p + 1].begin) : polygon_sides_.size();
        for (std::size_t i = begin; i < end; ++i)
            if (const PolygonSide& side = polygon_sides_[i]; side.side >= 0)
                add_segment({side.side, polygon_sides_[i + 1 == end ? begin : i + 1].place, side.place});
    }
}

void CutCell::find_cones() {
    cones_.clear();
    for (std::size_t p = 0; p < polygons_.size(); ++p) {
        const std::size_t begin = index(polygons_[p].begin),
                          end = p + 1 < polygons_.size() ? index(polygons_[p + 1].begin) : polygon_sides_.size();
        for (std::size_t i = begin + 2; i < end; ++i)
            cones_.push_back({polygon_sides_[begin].place, polygon_sides_[i - 1].place, polygon_sides_[i].place, 1,
                              polygons_[p].on_face ? absent : -1});
    }
    for (const Segment& s : segments_) cones_.push_back({base_[index(s.face)], s.from, s.to, s.weight, s.face});
}

CutCell::ConeSum CutCell::sum(std::span<const Cone> cones) {
    Sum volume;
    std::array<Sum, 3> moment;
    double error = 0;
    for (const Cone& cone : cones) {
        const Vector3 &a = at(cone.a), &b = at(cone.b), &c = at(cone.c), ab = minus(b, a), bc = minus(c, b),
                      n = cross(ab, bc);
        const double part = cone.weight * dot(a, n) / 6;
        volume += part;
        if (centroids_)
            for (std::size_t k = 0; k < 3; ++k) moment[k] += part * (a[k] + b[k] + c[k]) / 4;
        const double shift = std::max({error_of(cone.a), error_of(cone.b), error_of(cone.c)});
        error += std::abs(cone.weight) * (4 * largest(n) * shift + 64 * unit * largest(ab) * largest(bc) * largest(a));
    }
    ConeSum sum{false, volume.value(), {}};
    if (!(error < volume_rounding * std::abs(sum.volume))) return sum_exactly(cones);
    if (centroids_)
        for (std::size_t k = 0; k < 3; ++k) sum.centroid[k] = moment[k].value() / sum.volume;
    return sum;
}

// Measures the parts of faces, and the surface.
void CutCell::measure_areas() {
    Sum surface;
    double surface_error = 0;
    area_error_.assign(faces_.size(), 0);
    for (const Cone& cone : cones_) {
        const Vector3 &a = at(cone.a), &b = at(cone.b), &c = at(cone.c), ab = minus(b, a), bc = minus(c, b),
                      n = cross(ab, bc);
        const double shift = std::max({error_of(cone.a), error_of(cone.b), error_of(cone.c)});
        const double error = std::abs(cone.weight) *
                             (16 * unit * largest(ab) * largest(bc) + 4 * std::max(largest(ab), largest(bc)) * shift);
        if (cone.face == -1) surface += 0.5 * length3(n), surface_error += error;
        if (cone.face < 0) continue;
        out_.faces[index(cone.face)].area += 0.5 * cone.weight * dot(unit_[index(cone.face)], n);
        area_error_[index(cone.face)] += error;
    }
    sum_surface_ = surface;
    // A long part may have far less area than rounding at its length spoils.
    whole_ = surface.value();
    double worst = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        whole_ += std::abs(out_.faces[f].area);
        worst = std::max(worst, area_error_[f]);
    }
    const bool is_precise = surface_error <= surface_rounding * surface.value() && worst <= surface_rounding * whole_;
    if (!quads_.empty() || !is_precise) measure_areas_in_quad();
}

void CutCell::measure_areas_in_quad() {
    using exact::Quad;
    if (quads_.empty()) find_quads();
    std::vector<Quad> areas(faces_.size());
    sum_surface_ = {};
    for (const Cone& cone : cones_) {
        const auto &a = quads_[index(cone.a)], &b = quads_[index(cone.b)], &c = quads_[index(cone.c)];
        const auto n = cross(difference(b, a), difference(c, b));
        if (cone.face == -1)
            sum_surface_ +=
                0.5 * length3(static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2]));
        if (cone.face >= 0) areas[index(cone.face)] += Quad(cone.weight) * dot(unit_[index(cone.face)], n);
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        out_.faces[f].area = 0.5 * static_cast<double>(areas[f]);
        area_error_[f] = 0;
    }
    for (const Cone& cone : cones_) {
        if (cone.face < 0) continue;
        const Vector3 &a = at(cone.a), &b = at(cone.b), &c = at(cone.c);
        const double length = std::max({largest(minus(b, a)), largest(minus(c, b)), place_error_});
        area_error_[index(cone.face)] += quad_rounding * std::abs(cone.weight) * extent_ * length;
    }
}

// Returns the area of a face without triangles in its plane, or 0 where rounding may matter.
double CutCell::sure_area(std::int32_t face) {
    using exact::Quad;
    constexpr double digits = 0x1p34;  // beyond the 1e-10 that areas promise
    if (quads_.empty()) find_quads();
    Quad area;
    double bound = 0;
    for (const Cone& cone : cones_) {
        if (cone.face != face) continue;
        const auto &a = quads_[index(cone.a)], &b = quads_[index(cone.b)], &c = quads_[index(cone.c)],
                   ab = difference(b, a), bc = difference(c, b);
        area += Quad(cone.weight) * dot(unit_[index(face)], cross(ab, bc));
        const auto size = [](const std::array<Quad, 3>& x) {
            return largest({static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])});
        };
        const double length = std::max({size(ab), size(bc), quad_rounding * extent_});
        bound += 16 * quad_rounding * std::abs(cone.weight) * extent_ * length;
    }
    const double sure = std::abs(0.5 * static_cast<double>(area));
    return sure > digits * bound ? sure : 0;
}

void CutCell::find_quads() {
    if (!exact_is_ready_) prepare_exact(apex_);
    quads_.resize(place_.size());
    for (std::size_t i = 0; i < place_.size(); ++i) {
        if (i % places_per_stop == places_per_stop - 1) check_stop();
        if (!place_[i].is_used) continue;
        const ExactPlace place = exact_place(place_[i]);
        const auto w = static_cast<exact::Quad>(place.w);
        for (std::size_t k = 0; k < 3; ++k)
            quads_[i][k] = ldexp(static_cast<exact::Quad>(place.x[k]) / w, exact_.quantum());
    }
}

CutCell::ConeSum CutCell::sum_exactly(std::span<const Cone> cones) {
    using exact::Quad;
    if (cones.empty()) return {true, 0, {}};
    if (quads_.empty()) find_quads();
    Quad volume;
    std::array<Quad, 3> moment;
    double bound = 0;
    for (const Cone& cone : cones) {
        const auto &a = quads_[index(cone.a)], &b = quads_[index(cone.b)], &c = quads_[index(cone.c)],
                   ab = difference(b, a), bc = difference(c, b);
        const Quad part = Quad(cone.weight) * dot(a, cross(ab, bc));
        volume += part;
        if (centroids_)
            for (std::size_t k = 0; k < 3; ++k) moment[k] += part * (a[k] + b[k] + c[k]);
        const auto size = [](const std::array<Quad, 3>& x) {
            return largest({static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])});
        };
        bound += quad_rounding * std::abs(cone.weight) * std::max(size(a), extent_) * size(ab) * size(bc);
    }
    ConeSum sum{false, static_cast<double>(volume) / 6, {}};
    if (!(bound <= volume_rounding * std::abs(sum.volume)) || volume == Quad()) return sum_in_fractions(cones);
    if (centroids_)
        for (std::size_t k = 0; k < 3; ++k) sum.centroid[k] = ratio(moment[k], volume) / 4;
    return sum;
}

CutCell::ConeSum CutCell::sum_in_fractions(std::span<const Cone> cones) const {
    using exact::BigInt;
    using exact::Fraction;
    using exact::Quad;
    std::vector<ExactPlace> x(place_.size());
    for (std::size_t i = 0; i < place_.size(); ++i)
        if (place_[i].is_used) x[i] = exact_place(place_[i]);
    std::array<std::vector<Fraction>, 4> terms;  // 24 times the moments, 6 times the volume
    for (const Cone& cone : cones) {
        const ExactPlace &a = x[index(cone.a)], &b = x[index(cone.b)], &c = x[index(cone.c)];
        const Fraction volume(dot(a.x, cross(b.x, c.x)) * BigInt(cone.weight), a.w * b.w * c.w);
        if (volume.sign() == 0) continue;
        terms[3].push_back(volume);
        for (std::size_t k = 0; k < 3 && centroids_; ++k)
            terms[k].push_back(volume *
                               Fraction(a.x[k] * b.w * c.w + b.x[k] * a.w * c.w + c.x[k] * a.w * b.w, a.w * b.w * c.w));
    }
    const auto sum = [](std::vector<Fraction>& all) {
        for (; all.size() > 1; all.resize((all.size() + 1) / 2)) {
            check_stop();
            for (std::size_t i = 0; 2 * i < all.size(); ++i) {
                const bool alone = 2 * i + 1 == all.size();
                all[i] = alone ? std::move(all[2 * i]) : all[2 * i] + all[2 * i + 1];
            }
        }
        return all.empty() ? Fraction() : std::move(all[0]);
    };
    const Fraction volume = sum(terms[3]);
    if (volume.sign() == 0) return {true, 0, {}};
    ConeSum result{false, static_cast<double>(ldexp(static_cast<Quad>(volume), 3 * exact_.quantum())) / 6, {}};
    for (std::size_t k = 0; k < 3 && centroids_; ++k)
        result.centroid[k] =
            ratio(ldexp(static_cast<Quad>(sum(terms[k])), exact_.quantum()), static_cast<Quad>(volume)) / 4;
    return result;
}

void CutCell::measure_faces(bool decide) {
    has_triangles_.assign(faces_.size(), 0);
    for (const OnFace& on : on_faces_) has_triangles_[index(on.face)] = 1;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        CutMeasures::Face& face = out_.faces[f];
        const auto number = static_cast<std::int32_t>(f);
        face.area = std::abs(face.area);
        if (has_triangles_[f] != 0) {
            Shared shared = lay_over(number, false);
            if (!(area_error_[f] <= surface_rounding * (whole_ + shared.area))) shared = lay_over(number, true);
            face.area = shared.area;
            if (!out_.empty || shared.surface > area_error_[f]) sum_surface_ += shared.surface;
        }
        if (base_[f] < 0) face.area = 0;  // no part of it lies inside
        face.is_unsure = base_[f] >= 0 && !(face.area > area_error_[f]);
        if (!face.is_unsure || !decide) continue;
        const double area = has_triangles_[f] == 0 ? sure_area(number) : 0;
        face.area = area > 0 ? area : lay_over(number, true).area;
        face.is_unsure = false;
    }
    out_.surface = sum_surface_.value();
}

template <class Visit>
void CutCell::for_each_outline(std::int32_t face, Visit visit) const {
    for (const Edge& edge : edges_) {
        const std::int32_t from = at_slot_[index(edge.from)], to = at_slot_[index(edge.to)];
        if (edge.left == face) visit(from, to, Outline::whole, 1);
        if (edge.right == face) visit(to, from, Outline::whole, 1);
    }
    for (const Segment& s : segments_)
        if (s.face == face) visit(s.from, s.to, Outline::inside, s.weight);
    // Edges between two of the triangles cancel.
    struct Side {
        std::int32_t low, high, from, to;
        int all, out;  // how often triangles, and those that face out, run from the lower vertex to the higher
    };
    std::vector<Side> sides;
    for (const OnFace& on : on_faces_) {
        if (on.face != face) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            std::int32_t from = on.places[i], to = on.places[(i + 1) % 3];
            const auto vertex = [&](std::int32_t place) { return place_[index(place)].of[0]; };
            const int one = vertex(from) < vertex(to) ? 1 : -1;
            if (one < 0) std::swap(from, to);
            sides.push_back({vertex(from), vertex(to), from, to, one, on.faces_out ? one : 0});
        }
    }
    std::ranges::sort(sides, {}, [](const Side& s) { return std::pair(s.low, s.high); });
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        const Side& first = sides[begin];
        int all = 0, out = 0;
        for (; end < sides.size() && sides[end].low == first.low && sides[end].high == first.high; ++end)
            all += sides[end].all, out += sides[end].out;
        if (all != 0) visit(first.from, first.to, Outline::triangles, all);
        if (out != 0) visit(first.from, first.to, Outline::triangles_out, out);
    }
}

// Lays a face over with the triangles in its plane. Finds the area inside the mesh on both sides, and that of the
// triangles that bound this cell.
CutCell::Shared CutCell::lay_over(std::int32_t face, bool exactly) {
    const std::size_t f = index(face);
    int step = 0;  // of the winding number through a triangle that faces out
    for (const OnFace& on : on_faces_)
        if (on.face == face) step = on.in_cell ? 1 : -1;
    double error = place_error_, length = 0;
    for_each_outline(face, [&](std::int32_t from, std::int32_t to, Outline, int weight) {
        error = std::max({error, place_[index(from)].error, place_[index(to)].error});
        length += std::abs(weight) * std::min(largest(minus(at(to), at(from))), 4 * extent_);
    });
    area_error_[f] = 8 * error * length;
    const double stretch = layers_.begin(unit_[f]);
    Shared shared;
    const auto add_part = [&](double area, const Layers::Counts& count) {
        const auto of = [&](Outline outline) { return count[static_cast<std::size_t>(outline)]; };
        if (of(Outline::whole) == 0) return;
        const int one = of(Outline::inside), other = one + step * of(Outline::triangles);
        if ((one > 0) == (other > 0)) shared.area += area * std::min(std::abs(one), std::abs(other));
        shared.surface += area * of(Outline::triangles_out);
    };
    if (exactly || error > overlay_rounding * extent_) {
        if (!exact_is_ready_) prepare_exact(apex_);
        const auto corner = [&](std::int32_t place) {
            ExactPlace at = exact_place(place_[index(place)]);
            return ExactLayers::Corner{std::move(at.x[layers_.x()]), std::move(at.x[layers_.y()]), std::move(at.w)};
        };
        exact_layers_.begin();
        for_each_outline(face, [&](std::int32_t from, std::int32_t to, Outline outline, int weight) {
            exact_layers_.add(corner(from), corner(to), static_cast<std::size_t>(outline), weight);
        });
        exact_layers_.for_each_part(exact_.quantum(), [&](double part, const Layers::Counts& count) {
            add_part(std::max(part * stretch, std::numeric_limits<double>::denorm_min()), count);
        });
    } else {
        for_each_outline(face, [&](std::int32_t from, std::int32_t to, Outline outline, int weight) {
            layers_.add(at(from), at(to), static_cast<std::size_t>(outline), weight);
        });
        layers_.for_each_part(add_part);
    }
    return shared;
}

}  // namespace votess::solid
