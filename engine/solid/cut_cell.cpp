#include "solid/cut_cell.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/arithmetic.hpp"

namespace votess::solid {
namespace {

constexpr double beyond_rounding = 1e-12;  // of coordinates, for a height above a face
constexpr double sum_rounding = 4 * 0x1p-53;
constexpr double place_rounding = 16 * 0x1p-53;  // of the farthest coordinate
constexpr std::size_t word_bits = 64;
constexpr std::int32_t absent = -2;     // of a vertex without a side yet
constexpr double beside_margin = 1e-8;  // of the distances that a triangle's plane is compared with

Vector3 plus(const Vector3& a, const Vector3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

// Returns a and b themselves for 0 and 1, so that polygons close.
Vector3 between(const Vector3& a, const Vector3& b, double t) {
    if (t == 1) return b;
    Vector3 x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = a[k] + t * (b[k] - a[k]);
    return x;
}

// Returns x / (x - y), for numbers of which rounding may have changed the signs, which differ.
double crossing_place(double x, double y) {
    return x == y ? 0.5 : std::clamp(x / (x - y), 0.0, 1.0);
}

std::size_t index(std::int32_t i) {
    return static_cast<std::size_t>(i);
}

}  // namespace

void CutCell::begin(const exact::Point& seed, std::int32_t id, const exact::Shift& move, double weight,
                    MeshSigns::Ties ties) {
    weight_ = weight;
    ties_ = ties;
    image_ = exact::Plane::bisector(seed, move, domain_.lattice);
    const auto place = exact::differences({}, image_).x;
    origin_ = {place[0].high, place[1].high, place[2].high};
    cell_.start(seed, domain_, id);
    signs_.begin(seed, image_, ties_);
}

void CutCell::add(std::int32_t id, const exact::Plane& neighbor, const exact::Shift& shift, double weight,
                  double inward) {
    exact::Plane bisector = neighbor;
    bisector.power = exact::two_sum(weight_, -weight);
    if (inward != 0) bisector.power = {bisector.power.high - inward, 0};
    cell_.clip(id, bisector, shift);
}

const CutMeasures& CutCell::measure() {
    std::vector<CutMeasures::Face> faces = std::move(out_.faces);  // for its memory
    faces.clear();
    out_ = {};
    out_.faces = std::move(faces);
    sum_volume_ = sum_surface_ = {};
    sum_moment_ = {};
    sum_area_ = 0;
    find_faces();
    find_candidates();
    for (const std::uint32_t t : candidates_) {
        const ClosedMesh::Triangle& triangle = mesh_.triangles()[t];
        const bool meets = clip(triangle);
        if (meets) add_polygon(t);
        if (face_of_triangle_ >= 0) add_on_face(triangle.given);
        if (meets || face_of_triangle_ >= 0) out_.meets_surface = true;
    }
    find_windings();
    if (!out_.meets_surface) return out_;
    add_faces();
    out_.volume = sum_volume_.value();
    out_.surface = sum_surface_.value();
    // Without a tie no part is thinner than any number.
    const double thickness = signs_.met_tie() ? place_error_ : 0;
    out_.volume_error = sum_area_ * thickness;
    for (CutMeasures::Face& face : out_.faces) face.error *= thickness;
    if (centroids_)
        for (std::size_t k = 0; k < 3; ++k) out_.centroid[k] = apex_[k] + sum_moment_[k].value() / out_.volume;
    return out_;
}

void CutCell::find_faces() {
    out_.faces.clear();
    cell_.canonical_faces(faces_);
    read_faces();
    crossings_.clear();
    segments_.clear();
    polygons_.clear();
    polygon_sides_.clear();
    on_faces_.clear();
    outlines_.clear();
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
    place_error_ = 0;
    at_.resize(slots);
    for (const std::int32_t slot : slots_) {
        at_[index(slot)] = minus(cell_.position(slot), apex_);
        place_error_ = std::max(place_error_, cell_.tolerance(slot));
    }
    plane_.assign(count, -1);
    base_.resize(count);
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
        for (std::size_t k = 0; k < 3; ++k) unit_[f][k] = plane.n[k] / plane.norm;
        base_[f] = at_[index(faces_.corners[index(faces_.offsets[f])])];
        const std::int32_t begin = faces_.offsets[f], end = faces_.offsets[f + 1];
        for (std::int32_t c = begin; c < end; ++c)
            add_half(faces_.corners[index(c)], faces_.corners[index(c + 1 == end ? begin : c + 1)],
                     static_cast<std::int32_t>(f));
    }
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
    Box bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
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
            double height = 0, size = 0;  // of the corner farthest inward, above the face
            for (std::size_t k = 0; k < 3; ++k) {
                const double corner = unit_[f][k] > 0 ? box.lower[k] : box.upper[k];
                height += unit_[f][k] * (corner - origin_[k] - apex_[k] - base_[f][k]);
                size += std::abs(corner) + std::abs(origin_[k]) + std::abs(apex_[k]) + std::abs(base_[f][k]);
            }
            if (height > beyond_rounding * size + 4 * place_error_) return true;
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

// Returns a corner of the polygon relative to the apex. All sums of this cell use the same number for it.
Vector3 CutCell::position(const Corner& corner, const ClosedMesh::Triangle& triangle) {
    const auto vertex = [&](std::size_t i) { return minus(places_[i].relative, apex_); };
    if (corner.in < 0 && corner.out < 0) return vertex(index(-1 - corner.out));
    if (corner.in < 0 || corner.out < 0) {
        std::size_t from = index(-1 - std::min(corner.in, corner.out)), to = (from + 1) % 3;
        if (triangle.vertex[from] > triangle.vertex[to]) std::swap(from, to);  // as the triangle behind the edge does
        const MeshSigns::Values& a = values_[index(std::max(corner.in, corner.out))];
        return between(vertex(from), vertex(to), crossing_place(a[from].s, a[to].s));
    }
    // From inside to outside along an edge of the cell, which runs counterclockwise around face `in`.
    const std::int32_t at = edge_of(corner.in, corner.out);
    if (at < 0) throw Error(ErrorCode::internal, "the mesh passes between two faces of a cell that share no edge");
    Edge& edge = edges_[index(at)];
    const Vector3 u = vertex(0), n = cross(minus(vertex(1), u), minus(vertex(2), u));
    const Vector3 &x = at_[index(edge.from)], &y = at_[index(edge.to)];
    const double place = crossing_place(dot(n, minus(x, u)), dot(n, minus(y, u)));
    crossings_.push_back({place, edge.left == corner.in ? -1 : 1, edge.first});
    edge.first = static_cast<std::int32_t>(crossings_.size()) - 1;
    return between(x, y, place);
}

void CutCell::add_polygon(std::uint32_t t) {
    const std::size_t size = sides_.size();
    std::vector<Vector3>& corners = corners_;
    corners.clear();
    polygons_.push_back({t, static_cast<std::int32_t>(polygon_sides_.size())});
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t before = crossings_.size();
        corners.push_back(position({sides_[i == 0 ? size - 1 : i - 1], sides_[i]}, mesh_.triangles()[t]));
        const bool crosses = crossings_.size() > before;
        if (crosses) crossings_[before].polygon = static_cast<std::int32_t>(polygons_.size()) - 1;
        polygon_sides_.push_back({sides_[i], crosses ? static_cast<std::int32_t>(before) : -1, corners[i]});
    }
    Vector3 doubled{};
    for (std::size_t i = 2; i < size; ++i) {
        doubled = plus(doubled, cross(minus(corners[i - 1], corners[0]), minus(corners[i], corners[0])));
        add_cone(corners[0], corners[i - 1], corners[i], 1);
    }
    const double area = 0.5 * length3(doubled[0], doubled[1], doubled[2]);
    if (face_of_triangle_ < 0) sum_surface_ += area;
    sum_area_ += area;
    for (const MeshSigns::Place& place : places_)
        for (const double x : place.relative) place_error_ = std::max(place_error_, place_rounding * std::abs(x));
    for (std::size_t i = 0; i < size; ++i)
        if (sides_[i] >= 0) segments_.push_back({sides_[i], corners[i], corners[i + 1 == size ? 0 : i + 1]});
}

void CutCell::add_on_face(std::int32_t given) {
    const std::size_t f = index(face_of_triangle_);
    OnFace on{face_of_triangle_, given, {}, values_[f][0].sign < 0, false};
    for (std::size_t i = 0; i < 3; ++i) {
        on.corners[i] = minus(places_[i].relative, apex_);
        for (const double x : places_[i].relative) place_error_ = std::max(place_error_, place_rounding * std::abs(x));
    }
    const auto& [u, v, w] = on.corners;
    on.faces_out = dot(cross(minus(v, u), minus(w, u)), unit_[f]) > 0;
    on_faces_.push_back(on);
}

void CutCell::add_cone(const Vector3& a, const Vector3& b, const Vector3& c, double weight) {
    const double volume = weight * dot(a, cross(minus(b, a), minus(c, b))) / 6;  // exact to the size of c - b
    sum_volume_ += volume;
    if (!centroids_) return;
    for (std::size_t k = 0; k < 3; ++k) sum_moment_[k] += volume * (a[k] + b[k] + c[k]) / 4;
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
    at.begin(cell_.seed(), image_, ties_);
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

void CutCell::add_faces() {
    has_triangles_.assign(faces_.size(), 0);
    for (const OnFace& on : on_faces_) has_triangles_[index(on.face)] = 1;
    const auto add_segment = [&](const Segment& segment) {
        const std::size_t f = index(segment.face);
        const Vector3& base = base_[f];
        add_cone(base, segment.from, segment.to, segment.weight);
        const Vector3 side = minus(segment.to, segment.from);
        const double area = 0.5 * segment.weight * dot(unit_[f], cross(minus(segment.from, base), side));
        out_.faces[f].area += area;
        out_.faces[f].error += std::abs(segment.weight) * length3(side[0], side[1], side[2]);
        sum_area_ += std::abs(area);
        if (has_triangles_[f] != 0) outlines_.push_back(segment);
    };
    for (const Edge& edge : edges_) {
        on_edge_.clear();
        for (std::int32_t c = edge.first; c >= 0; c = crossings_[index(c)].next)
            on_edge_.push_back(crossings_[index(c)]);
        std::ranges::sort(on_edge_, {}, &Crossing::at);
        on_edge_.push_back({1, 0, -1});
        int winding = winding_[index(edge.from)];
        const Vector3 &begin = at_[index(edge.from)], &end = at_[index(edge.to)];
        Vector3 from = begin;
        for (const Crossing& crossing : on_edge_) {
            const Vector3 to = between(begin, end, crossing.at);
            if (winding != 0) {
                add_segment({edge.left, from, to, winding});
                add_segment({edge.right, to, from, winding});
            }
            winding += crossing.jump;
            from = to;
        }
    }
    for (const Segment& segment : segments_) add_segment({segment.face, segment.to, segment.from});
    for (CutMeasures::Face& face : out_.faces) face.area = std::abs(face.area);
    for (std::size_t f = 0; f < faces_.size(); ++f)
        if (has_triangles_[f] != 0) share_face(static_cast<std::int32_t>(f));
}

// Sets the area of a face with triangles in its plane: that of places inside the mesh on both sides. Adds the triangles
// that bound this cell to the surface.
void CutCell::share_face(std::int32_t face) {
    enum Layer : std::size_t { whole, inside, triangles, triangles_out };  // inside: beyond the triangles
    const std::size_t f = index(face);
    double perimeter = 0;
    layers_.begin(unit_[f]);
    for (const Edge& edge : edges_) {
        if (edge.left != face && edge.right != face) continue;
        const Vector3 &from = at_[index(edge.from)], &to = at_[index(edge.to)], side = minus(to, from);
        layers_.add(from, to, whole, edge.left == face ? 1 : -1);
        perimeter += length3(side[0], side[1], side[2]);
    }
    for (const Segment& s : outlines_)
        if (s.face == face) layers_.add(s.from, s.to, inside, s.weight);
    int step = 0;  // of the winding number through a triangle that faces out
    for (const OnFace& on : on_faces_) {
        if (on.face != face) continue;
        step = on.in_cell ? 1 : -1;
        out_.faces[f].error += perimeter;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vector3 &from = on.corners[i], &to = on.corners[(i + 1) % 3];
            layers_.add(from, to, triangles, 1);
            if (on.faces_out) layers_.add(from, to, triangles_out, 1);
        }
    }
    double area = 0;
    layers_.for_each_part([&](double part, const Layers::Counts& count) {
        if (count[whole] == 0) return;
        const int one = count[inside], other = one + step * count[triangles];
        if ((one > 0) == (other > 0)) area += part * std::min(std::abs(one), std::abs(other));
        sum_surface_ += part * count[triangles_out];
    });
    out_.faces[f].area = area;
}

}  // namespace votess::solid
