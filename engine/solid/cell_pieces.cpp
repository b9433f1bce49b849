#include "solid/cell_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "core/errors.hpp"

namespace votess::solid {
namespace {

constexpr double equal_angles = 1e-12;
constexpr std::size_t samples = 16;  // of the corners of a hole or cavity

// Returns the distance of a corner from the sides of a loop, negative outside.
double depth(const FlatCorner& p, const std::vector<FlatCorner>& loop) {
    double square = infinity;
    bool inside = false;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const FlatCorner &a = loop[i], &b = loop[i + 1 == loop.size() ? 0 : i + 1];
        const double dx = b.x - a.x, dy = b.y - a.y, size = dx * dx + dy * dy;
        const double t = size > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / size, 0.0, 1.0) : 0;
        const double ex = a.x + t * dx - p.x, ey = a.y + t * dy - p.y;
        square = std::min(square, ex * ex + ey * ey);
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * dx) inside = !inside;
    }
    return inside ? std::sqrt(square) : -std::sqrt(square);
}

// Returns the solid angle of a triangle seen from the origin (van Oosterom, Strackee 1983).
double solid_angle(const Vector3& a, const Vector3& b, const Vector3& c) {
    const double x = length3(a), y = length3(b), z = length3(c);
    return 2 * std::atan2(dot(a, cross(b, c)), x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
}

[[noreturn]] void open_piece() {
    bug("a piece of a cell is not closed");
}

}  // namespace

void CellPieces::add(CutCell& cut, bool meets_surface, int winding, Pieces& out) {
    cut_ = &cut;
    meets_surface_ = meets_surface;
    plain_winding_ = winding;
    sides_.clear();
    polygons_.clear();
    triangles_.clear();
    if (meets_surface || winding != 0) {
        add_triangles();
        glue_mesh_edges();
        add_strands();
        link_triangles();
        link_vertices();
        find_loops();
        number_vertices();
        cut_polygons();
        find_surfaces();
        find_cavities();
        write(out);
    }
}

int CellPieces::winding_at(Id slot) const {
    return meets_surface_ ? cut_->winding_[at(slot)] : plain_winding_;
}

void CellPieces::glue(Id a, Id b) {
    side(a).partner = b;
    side(b).partner = a;
}

// Makes the parts of triangles, and for each of their sides on a face the side of the face.
void CellPieces::add_triangles() {
    mesh_edges_.clear();
    previous_.clear();
    const auto& given = cut_->polygon_sides_;
    for (std::size_t p = 0; p < cut_->polygons_.size(); ++p) {
        const CutCell::Polygon& polygon = cut_->polygons_[p];
        const Id begin = polygon.begin,
                 end = p + 1 < cut_->polygons_.size() ? cut_->polygons_[p + 1].begin : static_cast<Id>(given.size());
        const ClosedMesh::Triangle& triangle = mesh_.triangles()[polygon.triangle];
        polygons_.push_back({triangle.given, -1, -1, 0});
        for (Id i = begin; i < end; ++i) {
            const CutCell::Side before = given[at(i == begin ? end - 1 : i - 1)].side, here = given[at(i)].side;
            Side made{static_cast<Id>(p), i + 1 == end ? begin : i + 1};
            made.place = given[at(i)].place;
            made.corner = cut_->at(made.place);
            if (before < 0 && here < 0) made.mesh_vertex = triangle.vertex[at(-1 - here)];
            sides_.push_back(made);
            previous_.push_back(i == begin ? end - 1 : i - 1);
            if (here >= 0) continue;
            const Id from = triangle.vertex[at(-1 - here)], to = triangle.vertex[at(-1 - here) == 2 ? 0 : at(-here)];
            mesh_edges_.push_back({std::min(from, to), std::max(from, to), from > to, i});
        }
    }
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (given[i].side < 0) continue;
        Side made{-1, -1};
        made.face = given[i].side;
        made.place = sides_[at(sides_[i].next)].place;
        made.corner = cut_->at(made.place);
        sides_.push_back(made);
        glue(static_cast<Id>(i), static_cast<Id>(sides_.size()) - 1);
    }
}

void CellPieces::glue_mesh_edges() {
    std::ranges::sort(mesh_edges_);
    for (std::size_t begin = 0, end = 0; begin < mesh_edges_.size(); begin = end) {
        const MeshEdge& first = mesh_edges_[begin];
        int turns = 0;
        for (; end < mesh_edges_.size() && mesh_edges_[end].low == first.low && mesh_edges_[end].high == first.high;
             ++end)
            turns += mesh_edges_[end].reversed ? -1 : 1;
        if (turns != 0) open_piece();
        if (end - begin == 2)
            glue(first.side, mesh_edges_[begin + 1].side);
        else
            glue_around(begin, end);
    }
}

// Glues several pairs of triangles at one edge, so that each pair has the inside between them.
void CellPieces::glue_around(std::size_t begin, std::size_t end) {
    const exact::Point &low = mesh_.vertex(mesh_edges_[begin].low), &high = mesh_.vertex(mesh_edges_[begin].high);
    const Vector3 axis = minus(high, low);
    Vector3 x{}, y{};
    for (std::size_t i = begin; i < end; ++i) {
        MeshEdge& edge = mesh_edges_[i];
        const CutCell::Polygon& polygon = cut_->polygons_[at(side(edge.side).polygon)];
        Vector3 out{};  // towards the third vertex, across the axis
        for (const Id v : mesh_.triangles()[polygon.triangle].vertex)
            if (v != edge.low && v != edge.high) out = minus(mesh_.vertex(v), low);
        out = cross(cross(axis, out), axis);
        if (i == begin) x = out, y = cross(axis, x);
        edge.angle = std::atan2(dot(out, y) / std::max(length3(y), tiny), dot(out, x) / std::max(length3(x), tiny));
    }
    const auto edges = std::span(mesh_edges_).subspan(begin, end - begin);
    std::ranges::sort(edges, {}, [](const MeshEdge& e) { return std::pair(e.angle, e.side); });
    // Seen along the axis, the inside follows counterclockwise behind a triangle that runs along it backward.
    for (std::size_t i = 0, j = 0; i < edges.size(); i = j) {
        for (j = i + 1; j < edges.size() && edges[j].angle - edges[i].angle < equal_angles;) ++j;
        std::stable_sort(edges.begin() + static_cast<std::ptrdiff_t>(i), edges.begin() + static_cast<std::ptrdiff_t>(j),
                         [](const MeshEdge& a, const MeshEdge& b) { return !a.reversed && b.reversed; });
    }
    // From the place where most of them have ended.
    std::size_t start = 0;
    int sum = 0, lowest = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        sum += edges[i].reversed ? 1 : -1;
        if (sum < lowest) lowest = sum, start = i + 1;
    }
    std::vector<Id> open;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const MeshEdge& edge = edges[(start + i) % edges.size()];
        if (edge.reversed) {
            open.push_back(edge.side);
        } else {
            glue(open.back(), edge.side);
            open.pop_back();
        }
    }
}

// Returns where an edge of the cell meets the mesh, in order.
std::vector<CellPieces::Id> CellPieces::crossings_of(const CutCell::Edge& edge) {
    std::vector<Id> found;
    for (Id c = edge.first; c >= 0; c = cut_->crossings_[at(c)].next) found.push_back(c);
    if (found.size() < 2) return found;
    const auto plane = [&](Id face) { return at(cut_->plane_[at(face)]); };
    const auto places = [&](Id c) {
        MeshSigns::Places u;
        const auto& triangle = mesh_.triangles()[cut_->polygons_[at(cut_->crossings_[at(c)].polygon)].triangle];
        for (std::size_t i = 0; i < 3; ++i) u[i] = cut_->signs_.place(mesh_.vertex(triangle.vertex[i]));
        return u;
    };
    const auto order = [&](Id c, Id d) {
        return cut_->signs_.crossing_order(plane(edge.left), plane(edge.right), places(c), places(d));
    };
    std::ranges::sort(found, [&](Id c, Id d) { return order(c, d) < 0; });
    // At one place the winding number first approaches 0.
    int winding = winding_at(edge.from);
    for (std::size_t i = 0, j = 0; i < found.size(); i = j) {
        for (j = i + 1; j < found.size() && order(found[i], found[j]) == 0;) ++j;
        const int away = winding < 0 ? -1 : 1;
        std::stable_partition(found.begin() + static_cast<std::ptrdiff_t>(i),
                              found.begin() + static_cast<std::ptrdiff_t>(j),
                              [&](Id c) { return cut_->crossings_[at(c)].jump != away; });
        for (std::size_t k = i; k < j; ++k) winding += cut_->crossings_[at(found[k])].jump;
    }
    return found;
}

void CellPieces::add_strands() {
    const cpu::CellFaces& faces = cut_->faces_;
    begins_.assign(cut_->crossings_.size(), -1);
    ends_.assign(cut_->crossings_.size(), -1);
    first_copy_.clear();
    Id copies = 0;
    for (const Id slot : faces.corners) {
        first_copy_.push_back(copies);
        copies += std::abs(winding_at(slot));
    }
    leaves_.assign(at(copies), -1);
    arrives_.assign(at(copies), -1);
    std::vector<Strand> open;
    for (const CutCell::Edge& edge : cut_->edges_) {
        open.clear();
        const int winding = winding_at(edge.from);
        for (Id k = 0; k < std::abs(winding); ++k) open.push_back({{-1, edge.from, k}, {}, winding < 0 ? -1 : 1});
        for (const Id c : crossings_of(edge)) {
            const int jump = cut_->crossings_[at(c)].jump;
            if (open.empty() || open.back().sign == jump) {
                open.push_back({{c}, {}, jump});
                continue;
            }
            Strand ended = open.back();
            open.pop_back();
            ended.to = {c};
            add_strand(edge, ended);
        }
        for (std::size_t k = 0; k < open.size(); ++k) {
            open[k].to = {-1, edge.to, static_cast<Id>(k)};
            add_strand(edge, open[k]);
        }
    }
}

void CellPieces::add_strand(const CutCell::Edge& edge, const Strand& strand) {
    const cpu::CellFaces& faces = cut_->faces_;
    const auto place = [&](const End& end) {
        return end.crossing < 0 ? cut_->at_slot_[at(end.slot)] : cut_->crossings_[at(end.crossing)].place;
    };
    const auto copy = [&](const End& end, Id face) {
        Id c = faces.offsets[at(face)];
        while (faces.corners[at(c)] != end.slot) ++c;
        return at(first_copy_[at(c)] + end.copy);
    };
    const auto add_side = [&](Id face, const End& from, const End& to) {
        const auto s = static_cast<Id>(sides_.size());
        Side made{-1, -1};
        made.face = face;
        made.place = place(from);
        made.corner = cut_->at(made.place);
        sides_.push_back(made);
        (from.crossing >= 0 ? begins_[at(from.crossing)] : leaves_[copy(from, face)]) = s;
        (to.crossing >= 0 ? ends_[at(to.crossing)] : arrives_[copy(to, face)]) = s;
        return s;
    };
    const bool forward = strand.sign > 0;
    const Id left = add_side(edge.left, forward ? strand.from : strand.to, forward ? strand.to : strand.from);
    const Id right = add_side(edge.right, forward ? strand.to : strand.from, forward ? strand.from : strand.to);
    glue(left, right);
}

// Finds which side of a face follows a side on a triangle.
void CellPieces::link_triangles() {
    for (std::size_t i = 0; i < cut_->polygon_sides_.size(); ++i) {
        const auto s = static_cast<Id>(i);
        const CutCell::PolygonSide& here = cut_->polygon_sides_[i];
        const CutCell::PolygonSide& before = cut_->polygon_sides_[at(previous_[i])];
        if (here.side >= 0) {
            // The side of the face ends where this one begins.
            Id& next = side(side(s).partner).next;
            if (before.side < 0) {
                const Id across = side(previous_[i]).partner;
                next = side(previous_[at(across)]).partner;
            } else {
                next = begins_[at(here.crossing)];
            }
            if (next < 0) open_piece();
        }
        if (here.side >= 0 && before.side >= 0) {
            const Id arrives = ends_[at(here.crossing)];
            if (arrives < 0) open_piece();
            side(arrives).next = side(previous_[i]).partner;
        }
    }
}

// Joins the sides of a face at vertices of the cell.
void CellPieces::link_vertices() {
    for (std::size_t k = 0; k < arrives_.size(); ++k) {
        if (arrives_[k] < 0 || leaves_[k] < 0) open_piece();
        side(arrives_[k]).next = leaves_[k];
    }
}

// Returns a place on a face, seen along an axis.
FlatCorner CellPieces::flat(Id face, const Vector3& place, Id id) const {
    const Vector3& normal = cut_->unit_[at(face)];
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
    std::size_t x = (axis + 1) % 3, y = (axis + 2) % 3;
    if (normal[axis] < 0) std::swap(x, y);
    return {place[x], place[y], id};
}

// Traces the loops of all faces, and makes polygons of them.
void CellPieces::find_loops() {
    loops_.clear();
    std::vector<bool> seen(sides_.size());
    for (std::size_t i = cut_->polygon_sides_.size(); i < sides_.size(); ++i) {
        if (seen[i]) continue;
        Loop loop{sides_[i].face, static_cast<Id>(i), {}, 0};
        for (Id s = loop.first; !seen[at(s)]; s = side(s).next) {
            if (side(s).next < 0 || side(s).face != loop.face) open_piece();
            seen[at(s)] = true;
            loop.corners.push_back(flat(loop.face, side(s).corner, s));
        }
        loop.area = doubled_area(loop.corners);
        loops_.push_back(std::move(loop));
    }
    std::ranges::stable_sort(loops_, {}, &Loop::face);
    for (std::size_t begin = 0, end = 0; begin < loops_.size(); begin = end) {
        while (end < loops_.size() && loops_[end].face == loops_[begin].face) ++end;
        group_loops(begin, end);
    }
}

// Gives each hole the polygon of the smallest loop around it.
void CellPieces::group_loops(std::size_t begin, std::size_t end) {
    const auto loops = std::span(loops_).subspan(begin, end - begin);
    const auto number = [&](const Loop& loop, Id polygon) {
        for (const FlatCorner& corner : loop.corners) side(corner.id).polygon = polygon;
    };
    const auto begin_polygon = [&](const Loop& loop) {
        number(loop, static_cast<Id>(polygons_.size()));
        polygons_.push_back({-1, loop.face, -1, loop.area});
    };
    for (const Loop& loop : loops)
        if (loop.area >= 0 || loops.size() == 1) begin_polygon(loop);
    for (const Loop& hole : loops) {
        if (hole.area >= 0 || loops.size() == 1) continue;
        const Loop* around = nullptr;
        for (const Loop& loop : loops) {
            if (loop.area <= 0 || loop.area < -hole.area || (around != nullptr && loop.area >= around->area)) continue;
            double sum = 0;
            const std::size_t step = ceil_div(hole.corners.size(), samples);
            for (std::size_t k = 0; k < hole.corners.size(); k += step) sum += depth(hole.corners[k], loop.corners);
            if (sum > 0) around = &loop;
        }
        if (around != nullptr)
            number(hole, side(around->first).polygon);
        else
            begin_polygon(hole);
    }
}

// Finds the sides around each corner.
void CellPieces::number_vertices() {
    places_.clear();
    cut_places_.clear();
    mesh_vertices_.clear();
    for (std::size_t i = 0; i < sides_.size(); ++i) {
        if (sides_[i].vertex >= 0) continue;
        const auto vertex = static_cast<Id>(places_.size());
        places_.push_back(sides_[i].corner);
        cut_places_.push_back(sides_[i].place);
        mesh_vertices_.push_back(sides_[i].mesh_vertex);
        for (auto s = static_cast<Id>(i); side(s).vertex < 0; s = side(side(s).partner).next) {
            if (side(s).partner < 0) open_piece();
            side(s).vertex = vertex;
        }
    }
}

void CellPieces::cut_polygons() {
    const std::size_t triangle_sides = cut_->polygon_sides_.size();
    for (std::size_t i = 0; i < triangle_sides; ++i) {
        const Side& first = sides_[i];
        if (i > 0 && sides_[i - 1].polygon == first.polygon) continue;
        for (Id s = first.next; side(s).next != static_cast<Id>(i); s = side(s).next)
            triangles_.push_back({{first.vertex, side(s).vertex, side(side(s).next).vertex}, first.polygon});
    }
    std::vector<Id> loops(loops_.size());
    std::iota(loops.begin(), loops.end(), 0);
    const auto polygon = [&](Id loop) { return side(loops_[at(loop)].first).polygon; };
    // The outline first: it is the largest.
    std::ranges::sort(loops, {}, [&](Id loop) { return std::pair(polygon(loop), -std::abs(loops_[at(loop)].area)); });
    for (std::size_t begin = 0, end = 0; begin < loops.size(); begin = end) {
        while (end < loops.size() && polygon(loops[end]) == polygon(loops[begin])) ++end;
        cut_face(std::span(loops).subspan(begin, end - begin));
    }
}

void CellPieces::cut_face(std::span<const Id> loops) {
    polygon_loops_.clear();
    const Id polygon = side(loops_[at(loops.front())].first).polygon;
    for (const Id loop : loops) {
        polygon_loops_.push_back(loops_[at(loop)].corners);
        for (FlatCorner& corner : polygon_loops_.back()) corner.id = side(corner.id).vertex;
    }
    for (const auto& vertices : ears_.cut(polygon_loops_)) triangles_.push_back({vertices, polygon});
}

// Finds the connected surfaces, and measures them.
void CellPieces::find_surfaces() {
    surfaces_.clear();
    std::vector<Id> first(polygons_.size() + 1), sides(sides_.size()), pending;
    for (const Side& s : sides_) ++first[at(s.polygon) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Id> next = first;
    for (std::size_t i = 0; i < sides_.size(); ++i) sides[at(next[at(sides_[i].polygon)]++)] = static_cast<Id>(i);
    for (Polygon& start : polygons_) {
        if (start.surface >= 0) continue;
        const auto number = static_cast<Id>(surfaces_.size());
        surfaces_.emplace_back();
        start.surface = number;
        pending.assign(1, static_cast<Id>(&start - polygons_.data()));
        while (!pending.empty()) {
            const Id p = pending.back();
            pending.pop_back();
            for (Id k = first[at(p)]; k < first[at(p) + 1]; ++k) {
                const Id other = side(side(sides[at(k)]).partner).polygon;
                if (polygons_[at(other)].surface >= 0) continue;
                polygons_[at(other)].surface = number;
                pending.push_back(other);
            }
        }
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t)
        surfaces_[at(polygons_[at(triangles_[t].polygon)].surface)].triangles.push_back(static_cast<Id>(t));
    for (Surface& surface : surfaces_) {
        cones_.clear();
        for (const Id t : surface.triangles) {
            const auto& [u, v, w] = triangles_[at(t)].vertex;
            cones_.push_back({cut_places_[at(u)], cut_places_[at(v)], cut_places_[at(w)], 1, -1});
        }
        const CutCell::ConeSum sum = cut_->sum(cones_);
        surface.volume = surface.sum = sum.volume;
        surface.dropped = sum.empty;
        for (std::size_t k = 0; k < 3; ++k) surface.moment[k] = sum.volume * sum.centroid[k];
    }
}

// Returns how often a surface winds around another, about 0 or 1.
double CellPieces::winding_in(const Surface& outer, const Surface& inner) const {
    const std::size_t step = ceil_div(inner.triangles.size(), samples);
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < inner.triangles.size(); i += step, ++count) {
        const Vector3& from = places_[at(triangles_[at(inner.triangles[i])].vertex[0])];
        for (const Id t : outer.triangles) {
            const auto& [u, v, w] = triangles_[at(t)].vertex;
            sum += solid_angle(minus(places_[at(u)], from), minus(places_[at(v)], from), minus(places_[at(w)], from));
        }
    }
    return sum / (4 * std::numbers::pi * count);
}

// Gives each cavity to the smallest piece around it.
void CellPieces::find_cavities() {
    for (Surface& cavity : surfaces_) {
        if (cavity.dropped || cavity.volume >= 0) continue;
        for (const Surface& around : surfaces_) {
            if (around.dropped || around.volume <= -cavity.volume) continue;
            if (cavity.outer >= 0 && around.volume >= surfaces_[at(cavity.outer)].volume) continue;
            if (winding_in(around, cavity) > 0.5) cavity.outer = static_cast<Id>(&around - surfaces_.data());
        }
    }
}

// Returns how many parts of a face with larger outlines lie at a place of one, and face as it does. The winding number
// is as many and one at least.
int CellPieces::sheets_before(Id polygon, const Vector3& place) const {
    const Polygon& own = polygons_[at(polygon)];
    const FlatCorner corner = flat(own.face, place, -1);
    int count = 0;
    const auto [begin, end] = std::ranges::equal_range(loops_, own.face, {}, &Loop::face);
    for (auto loop = begin; loop != end; ++loop) {
        const Id other = side(loop->first).polygon;
        const double area = polygons_[at(other)].outline;
        const bool is_larger = std::pair(-std::abs(area), other) < std::pair(-std::abs(own.outline), polygon);
        if (is_larger && area * own.outline > 0 && depth(corner, loop->corners) > 0)
            count += loop->area * area > 0 ? 1 : -1;  // a hole takes it away
    }
    return count;
}

// Returns the triangle of the mesh that lies on a part of a face and faces as it does, or -1. Ties put such triangles
// into the neighbor. Where the winding number is negative, parts of faces and the triangles on them face inward.
// Triangles at one place that face each other are no surface, and each of the others ends one part.
CellPieces::Id CellPieces::on_surface(const Triangle& triangle) const {
    if (cut_->on_faces_.empty()) return -1;
    const Polygon& polygon = polygons_[at(triangle.polygon)];
    const auto& [i, j, k] = triangle.vertex;
    const Vector3 &u = places_[at(i)], &v = places_[at(j)], &w = places_[at(k)];
    Vector3 middle{};
    for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] = (u[axis] + v[axis] + w[axis]) / 3;
    const Vector3& normal = cut_->unit_[at(polygon.face)];
    const bool out = dot(normal, cross(minus(v, u), minus(w, u))) >= 0;
    Id found = -1;
    int count = 0;
    for (const CutCell::OnFace& on : cut_->on_faces_) {
        if (on.face != polygon.face || on.in_cell) continue;
        bool inside = true;
        for (std::size_t side = 0; side < 3 && inside; ++side) {
            const Vector3 &a = cut_->at(on.places[side]), &b = cut_->at(on.places[(side + 1) % 3]);
            const double left = dot(normal, cross(minus(b, a), minus(middle, a)));
            inside = on.faces_out ? left >= 0 : left <= 0;
        }
        if (!inside) continue;
        count += on.faces_out == out ? 1 : -1;
        if (on.faces_out == out && found < 0) found = on.given;
    }
    return count > 0 && sheets_before(triangle.polygon, middle) < count ? found : -1;
}

void CellPieces::write(Pieces& out) {
    std::vector<Id> order;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        Surface& surface = surfaces_[s];
        if (surface.dropped) continue;
        if (surface.outer < 0) {
            order.push_back(static_cast<Id>(s));
            continue;
        }
        Surface& around = surfaces_[at(surface.outer)];
        around.triangles.insert(around.triangles.end(), surface.triangles.begin(), surface.triangles.end());
        around.sum += surface.sum;
        for (std::size_t k = 0; k < 3; ++k) around.moment[k] += surface.moment[k];
    }
    std::ranges::stable_sort(order, std::ranges::greater(), [&](Id s) { return surfaces_[at(s)].sum; });
    const exact::Point& origin = cut_->origin_;
    const Vector3& apex = cut_->apex_;
    new_vertex_.assign(places_.size(), -1);
    for (const Id s : order) {
        const Surface& surface = surfaces_[at(s)];
        const double volume = surface.sum;
        out.volumes.push_back(unit_.volume(volume));
        for (std::size_t k = 0; k < 3; ++k)
            out.centroids.push_back(unit_.length(surface.moment[k] / volume + apex[k] + origin[k]));
        Id count = 0;
        for (const Id t : surface.triangles) {
            const Triangle& triangle = triangles_[at(t)];
            for (const Id v : triangle.vertex) {
                if (new_vertex_[at(v)] < 0) {
                    new_vertex_[at(v)] = count++;
                    const Id of_mesh = mesh_vertices_[at(v)];
                    for (std::size_t k = 0; k < 3; ++k) {
                        const double x =
                            of_mesh >= 0 ? mesh_.vertex(of_mesh)[k] : places_[at(v)][k] + apex[k] + origin[k];
                        out.vertices.push_back(unit_.length(x));
                    }
                }
                out.triangles.push_back(new_vertex_[at(v)]);
            }
            const Polygon& polygon = polygons_[at(triangle.polygon)];
            const Id given = polygon.face < 0 ? polygon.triangle : on_surface(triangle);
            out.on_surface.push_back(given >= 0 ? 1 : 0);
            out.sources.push_back(given >= 0 ? given : cut_->out_.faces[at(polygon.face)].id);
        }
        out.vertex_offsets.push_back(static_cast<std::int64_t>(out.vertices.size() / 3));
        out.triangle_offsets.push_back(static_cast<std::int64_t>(out.triangles.size() / 3));
    }
}

}  // namespace votess::solid
