// StarWalk: from vertex to vertex along the edges.
#pragma once

#include "cpu/walk/star_walk.hpp"

namespace votess::cpu {

// `planes` is planes_, in a register when it can be.
template <class Isa>
int StarWalk<Isa>::slot_of(std::int32_t local, int& planes) {
    const int known = slot_[static_cast<std::size_t>(local)];
    if (known >= 0) return known;
    slot_[static_cast<std::size_t>(local)] = static_cast<std::int16_t>(planes);
    local_[static_cast<std::size_t>(planes)] = local;
    return planes++;
}

// The edges a -> b, b -> c, c -> a of a vertex.
template <class Isa>
template <Star::Keep Kept>
void StarWalk<Isa>::link_corner(int a, int b, int c, int vertex) {
    const std::uint64_t bit_a = 1ull << a, bit_b = 1ull << b, bit_c = 1ull << c;
    out_[a] |= bit_b;
    in_[a] |= bit_c;
    out_[b] |= bit_c;
    in_[b] |= bit_a;
    out_[c] |= bit_a;
    in_[c] |= bit_b;
    if constexpr (Kept != Keep::nothing) {
        shape_.a[vertex] = static_cast<std::uint8_t>(a);
        shape_.b[vertex] = static_cast<std::uint8_t>(b);
        shape_.c[vertex] = static_cast<std::uint8_t>(c);
    }
    if constexpr (Kept == Keep::places)
        from_vertex_[a][b] = from_vertex_[b][c] = from_vertex_[c][a] = static_cast<std::uint8_t>(vertex);
}

template <class Isa>
void StarWalk<Isa>::forget_planes() {
    for (int p = 0; p < planes_; ++p) {
        slot_[static_cast<std::size_t>(local_[p])] = no_slot;
        out_[p] = in_[p] = 0;
    }
    planes_ = 0;
}

template <class Isa>
bool StarWalk<Isa>::build(std::size_t seed) {
    seed_ = seed;
    own_id_ = static_cast<std::int32_t>(seed);
    p_ = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    base_ = {p_, {}};
    if (weighted_) weight_ = seeds_.weights[seed];
    if (any_moved_) {
        const auto& low = seeds_.images->low(own_id_);
        low_ = {{low[0], low[1], low[2], 0}};
        base_ = seeds_.images->base(seed);
        moved_ = !seeds_.images->is_exact(seed);
    }
    const bool done = build_cell<false>();
    if (done) cells_.set_done(seed);
    if (have_candidates_ && !done) window_.show(seed, own_x_);
    if (done && window_open_ && window_home_ == seed / Window::home_seeds) window_.hide(seed);
    return done;
}

template <class Isa>
bool StarWalk<Isa>::build(const Probe& probe) {
    ++seed_;  // what is known of walls belongs to another
    own_id_ = static_cast<std::int32_t>(seeds_.places());
    p_ = probe.place.at;
    base_ = {probe.x, probe.place.by};
    const auto& low = probe.place.low;
    low_ = {{low[0], low[1], low[2], 0}};
    if (weighted_) weight_ = probe.weight;
    if (seeds_.images != nullptr) {
        moved_ = low != std::array<double, 3>{};
        any_moved_ = seeds_.images->any_moved() || moved_;
        any_rough_ = seeds_.images->any_rough();
    }
    return build_cell<true>() && !empty_ && !may_coincide();
}

template <class Isa>
template <bool Alone>
bool StarWalk<Isa>::build_cell() {
    forget_planes();
    own_local_ = cells_.local(own_id_);
    vertices_ = ends_ = open_begin_ = open_end_ = 0;
    planes_known_ = facings_known_ = 0;
    scale_ = unscale_ = 1;
    have_candidates_ = have_walls_ = used_exact_ = false;
    power_found_ = least_power;
    ties_.clear();
    tie_slots_.clear();
    if (keep_ == Keep::nothing) return complete<Keep::nothing, Alone>();
    return keep_ == Keep::corners ? complete<Keep::corners, Alone>() : complete<Keep::places, Alone>();
}

// Alone: no other cell has handed over vertices.
template <class Isa>
template <Star::Keep Kept, bool Alone>
bool StarWalk<Isa>::complete() {
    if constexpr (!Alone)
        if (!take_known<Kept>()) return false;
    empty_ = false;
    reached_ = 0;
    if (vertices_ == 0 && !find_first<Kept>()) {
        if (empty_) faces_ = edges_ = 0;
        return empty_;
    }
    if (open_end_ > 0 && !have_candidates_ && !gather_candidates()) return false;
    for (;;) {
        // Two open edges at once, far from each other: their searches overlap in the processor. The second may have
        // been closed by the vertex of the first.
        while (open_begin_ < open_end_ && !is_open(open_edges_[open_begin_])) ++open_begin_;
        if (open_begin_ == open_end_) break;
        OpenEdge edges[2];
        edges[0] = open_edges_[open_begin_++];
        while (open_begin_ < open_end_ && !is_open(open_edges_[open_end_ - 1])) --open_end_;
        edges[1] = open_begin_ < open_end_ ? open_edges_[--open_end_] : edges[0];
        Ray rays[2];
        aim(edges[0], rays[0]);
        aim(edges[1], rays[1]);
        int hits[2];
        Isa::first_hits(candidates_, candidates_.near, rays, hits);
        for (int k = 0; k < 2; ++k)
            if (is_open(edges[k]) && !close<Kept>(edges[k], rays[k], hits[k])) return false;
    }
    const double needed = reached_ * unscale_ * unscale_;
    if (needed > 0) {
        typical_reach_ += (std::min(needed, 4 * typical_reach_) - typical_reach_) / 16;
        power_found_ = std::max(power_found_, bounds::power((1 + 4 * margin) * 0.25 * needed, weight_));
    }
    return collect_faces();
}

// The first vertex of a cell that knows none. The edge to begin with is none if not all seeds near it are candidates;
// those that were found since may help.
template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::find_first() {
    int candidates = 0;
    for (int tries = 0; tries < most_beginnings; ++tries) {
        open_begin_ = open_end_ = 0;
        begun_badly_ = false;
        if (!begin_anywhere() || empty_ || candidates_.count == candidates) return false;
        candidates = candidates_.count;
        const OpenEdge edge = open_edges_[open_begin_++];
        Ray ray;
        aim(edge, ray);
        if (close<Kept>(edge, ray, -1)) return true;
        if (!begun_badly_) return false;
    }
    return false;
}

template <class Isa>
void StarWalk<Isa>::take_position(const KnownVertex& known, int vertex) {
    numbers_[vertex] = known.vertex;
    const std::size_t owner = cells_.owner(known.vertex);
    Wide from = wide(cells_.seed_position(owner)) - Wide{p_[0], p_[1], p_[2], 0};
    if (cells_.has_lows()) from += wide(cells_.seed_low(owner)) - wide(low_);
    wide(position_[vertex]) = wide(cells_.position(known.vertex)) + from;
}

template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::take_known() {
    make_room(cells_.locals());
    const auto handed = cells_.known(seed_);
    if (handed.size() > most_vertices - 4) return false;
    int planes = 0, vertices = 0, ties = 0;
    for (const KnownVertex& known : handed) {
        if (planes > most_planes - 4) {
            planes_ = planes;
            return false;
        }
        if (known.is_tie()) {
            planes_ = planes;
            if (!take_tie(known, vertices++)) return false;
            planes = planes_;
            ++ties;
            continue;
        }
        if constexpr (Kept == Keep::places) take_position(known, vertices);
        const int a = slot_of(known.cells[0], planes), b = slot_of(known.cells[1], planes),
                  c = slot_of(known.cells[2], planes);
        link_corner<Kept>(a, b, c, vertices++);
    }
    planes_ = planes, vertices_ = vertices, ends_ += 3 * (vertices - ties);
    for (int p = 0; p < planes; ++p)
        for (std::uint64_t open = out_[p] & ~in_[p]; open != 0; open &= open - 1)
            open_edges_[open_end_++] = {static_cast<std::uint8_t>(p),
                                        static_cast<std::uint8_t>(std::countr_zero(open))};
    return true;
}

template <class Isa>
bool StarWalk<Isa>::take_tie(const KnownVertex& known, int vertex) {
    if (keep_ == Keep::places) take_position(known, vertex);
    power_found_ = std::max(power_found_, cells_.power_of_tie(known));
    tied_cells_.clear();
    for (const std::int32_t cell : cells_.tie(known))
        if (cell != own_local_) tied_cells_.push_back(cell);
    return link_polygon(tied_cells_, vertex, false);
}

// Faces are the planes that have edges; a plane that was tried as a beginning may have none.
template <class Isa>
bool StarWalk<Isa>::collect_faces() {
    int edges = 0, faces = 0;
    const int planes = planes_;
    for (int p = 0; p < planes; ++p) {
        face_[faces] = cells_.id(local_[p]);
        face_slot_[faces] = static_cast<std::uint8_t>(p);
        const int own = std::popcount(out_[p]);
        edges += own;
        faces += own != 0 ? 1 : 0;
    }
    faces_ = faces;
    edges_ = edges / 2;
    return edges == ends_;  // no edge was found twice in the same direction
}

// In floats: what it hits is a guess.
template <class Isa>
void StarWalk<Isa>::aim(const OpenEdge& edge, Ray& ray) {
    need_facing(edge.a);
    need_facing(edge.b);
    const Facing &a = facing_[edge.a], &b = facing_[edge.b];
    Floats ab, across;
    cross(floats(a.normal), floats(b.normal), ab);
    // e x ab / |ab|^2 is the point of the line that is nearest to the seed.
    cross(a.distance * floats(b.normal) - b.distance * floats(a.normal), ab, across);
    const Floats squares = ab * ab;
    const float square = squares[0] + squares[1] + squares[2];
    floats(ray.o) = across;
    floats(ray.d) = -ab;
    ray.s = square;
    ray.least = parallel * std::sqrt(square) * static_cast<float>(longest_);
}

// False when the planes are too near to parallel, or too large or small to square.
template <class Isa>
bool StarWalk<Isa>::draw_line(const OpenEdge& edge, Line& line) const {
    const Wide &na = wide(n_[edge.a]), &nb = wide(n_[edge.b]);
    const double square_a = square_[edge.a], square_b = square_[edge.b];
    Wide ab;
    cross(na, nb, ab);
    line.norms2 = square_a * square_b;
    line.longest2 = std::max(square_a, square_b);
    wide(line.ab) = ab;
    wide(line.e) = h_[edge.a] * nb - h_[edge.b] * na;
    return square_a > smallest_square && square_b > smallest_square && line.norms2 < largest_product &&
           dot(ab, ab) * worst_condition2 > line.norms2;
}

template <class Isa>
int StarWalk<Isa>::first_hit(const Ray& ray) {
    const Ray rays[2] = {ray, ray};
    int hits[2];
    Isa::first_hits(candidates_, candidates_.count, rays, hits);
    if (hits[0] < 0 && !have_walls_ && add_walls()) Isa::first_hits(candidates_, candidates_.count, rays, hits);
    return hits[0];
}

// Cramer's rule: (ha nb x nc + hb nc x na + hc na x nb) / det = (e x nc + hc ab) / det. False when the planes are too
// near to parallel, or meet behind where the edge begins.
template <class Isa>
bool StarWalk<Isa>::solve(const Line& line, Third& c, Four& x) const {
    const double determinant = dot(wide(c.n), wide(line.ab));
    c.norms2 = line.norms2 * c.square;
    c.determinant2 = determinant * determinant;
    if (!(determinant < 0 && c.norms2 < worst_condition2 * c.determinant2 && c.square > smallest_square)) return false;
    Wide across;
    cross(wide(line.e), wide(c.n), across);
    wide(x) = (across + c.h * wide(line.ab)) * (1 / determinant);
    return true;
}

template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::close(const OpenEdge& edge, const Ray& ray, int lane) {
    Line line;
    if (!draw_line(edge, line)) return false;
    bool searched = false;
    for (int pick = 0; pick < most_picks; ++pick) {
        if (lane < 0) lane = first_hit(ray);
        if (lane < 0) return false;
        const std::int32_t id = candidates_.id[lane];
        const std::int32_t three[3] = {id_[edge.a], id_[edge.b], id};
        Third third;
        alignas(32) Four x;
        plane_through(id, third.n, third.h, third.square);
        if (!solve(line, third, x)) {
            begun_badly_ = true;
            return false;
        }
        const double x2 = dot(wide(x), wide(x));
        third.length2 = error_length2(line, third, x2);
        if (!(x2 < longest_normal * longest_normal)) {
            if (have_walls_ || !add_walls()) return false;
            lane = -1;
            continue;
        }
        float v[4];
        narrow(wide(x), v);
        v[3] = static_cast<float>(rounding_by_square_ * x2 + rounding_);
        const double reach2 = reach_squared(x2);
        const int count = in_reach(reach2);
        const int touching = Isa::touching(candidates_, count, v, three, 0);
        tied_.clear();
        if (touching >= 0) {
            const int cutting = examine(v, three, third, x, touching, count);
            if (cutting >= 0) {
                lane = cutting;
                continue;
            }
        }
        if (reach2 > covered_ && !searched) {
            if (!have_walls_) {
                if (!add_walls()) return false;
                lane = -1;
                continue;
            }
            int added = 0;
            if (!add_inside(line, third, x, three, added)) return false;
            searched = vertices_ > 0 && added < most_new;
            if (added > 0) {
                lane = -1;
                continue;
            }
        }
        if (!plain_) {
            if (seeds_.images != nullptr && !(reach2 < images_within2_ && x2 > images_beyond2_) &&
                !images_known(x, x2, reach2))
                return false;
            if (weighted_ && vertices_ == 0 && is_hidden(three, third, x)) return false;
            if (weighted_) note_reach(x2, third);
        }
        reached_ = std::max(reached_, 4 * x2);
        if (tied_.empty()) return add_vertex<Kept>(edge, id, third, x);
        return add_tie(edge, id, third, x) && !is_open(edge);
    }
    return false;
}

// Keeps the reach of a vertex in a power diagram. Not inlined: without weights it costs nothing.
template <class Isa>
void StarWalk<Isa>::note_reach(double x2, const Third& third) {
    reached_ = std::max(reached_, 4 * most_distance_squared(x2, third));
}

// Whether all images that may lie nearer to a vertex than the seed are there, and none is rounded by too much to tell.
template <class Isa>
bool StarWalk<Isa>::images_known(const Four& x, double x2, double reach2) {
    set_image_reach(seeds_.images->reach(p_));
    if (!(x2 > images_beyond2_)) return false;
    if (reach2 < images_within2_) return true;
    // The sphere around the vertex has half of that radius.
    exact::Point vertex;
    double size = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double offset = x.x[k] * unscale_;
        vertex[k] = p_[k] + offset;
        size = std::max(size, std::abs(p_[k]) + std::abs(offset));
    }
    const double radius = in_places(bounds::widest_reach(x2, more_), size);
    return reach2 * unscale_ * unscale_ < own_images_ * own_images_ * (1 - 4 * margin) &&
           radius < seeds_.images->reach(vertex);
}

// Looks through the candidates that come too near to a vertex, from `lane` on. Returns one that cuts it off, or -1;
// tied_ then holds those that go through it.
template <class Isa>
int StarWalk<Isa>::examine(const float* v, const std::int32_t* three, const Third& third, const Four& x, int lane,
                           int count) {
    std::optional<exact::ExactVertex> vertex;
    const double relative = relative_error(third);
    while (lane >= 0) {
        const std::int32_t id = candidates_.id[lane];
        const int sure = sure_side(id, third, relative, x);
        if (sure > 0) return lane;
        if (sure == 0) {
            used_exact_ = true;
            if (!vertex)
                vertex.emplace(base_.point, exact_plane(three[0]), exact_plane(three[1]), exact_plane(three[2]));
            const int side = vertex->side(exact_plane(id));
            if (side > 0) return lane;
            if (side == 0 && std::find(tied_.begin(), tied_.end(), id) == tied_.end()) tied_.push_back(id);
        }
        lane = Isa::touching(candidates_, count, v, three, lane + 1);
    }
    return -1;
}

// Bounds the error of n.x, in units of |n| and the length of the vertex.
template <class Isa>
double StarWalk<Isa>::relative_error(const Third& third) const {
    return (weighted_ ? bounds::weighted_factor : bounds::solved_factor) * third.condition() + 8 * unit;
}

// On which side of a plane the vertex lies: 0 where rounding may decide.
template <class Isa>
int StarWalk<Isa>::sure_side(std::int32_t id, const Third& third, double relative, const Four& x) {
    Four n;
    double h, square;
    plane_through(id, n, h, square);
    const double excess = dot(wide(n), wide(x)) - h;
    const double bound = std::sqrt(square * third.length2) * relative + 12 * unit * size_of_h(h, square);
    return excess > bound ? 1 : excess < -bound ? -1 : 0;
}

template <class Isa>
void StarWalk<Isa>::keep_position(const Third& third, const Four& x) {
    Wide position = wide(x) * unscale_;
    position[3] = third.norms2 / third.determinant2 * third.length2 * unscale_ * unscale_;
    wide(position_[vertices_]) = position;
    numbers_[vertices_] = cells_.place(own_local_, position_[vertices_]);
}

template <class Isa>
template <Star::Keep Kept>
bool StarWalk<Isa>::add_vertex(const OpenEdge& edge, std::int32_t id, const Third& third, const Four& x) {
    if (planes_ > most_planes - 2 || vertices_ > most_vertices - 4) return false;
    const int c = new_slot(id);
    if (((planes_known_ >> c) & 1) == 0) {
        planes_known_ |= 1ull << c;
        facings_known_ |= 1ull << c;
        id_[c] = id;
        wide(n_[c]) = wide(third.n);
        h_[c] = third.h;
        square_[c] = third.square;
        face(c);
    }
    if constexpr (Kept == Keep::places) keep_position(third, x);
    cells_.give({own_local_, local_[edge.b], local_[edge.a], local_[c]},
                Kept == Keep::places ? numbers_[vertices_] : 0);
    link_corner<Kept>(edge.b, edge.a, c, vertices_++);
    ends_ += 3;
    stack(edge.a, c);
    stack(c, edge.b);
    return true;
}

// A vertex of more than three planes: each of its cells sorts out by itself which of the others it has an edge with.
template <class Isa>
bool StarWalk<Isa>::add_tie(const OpenEdge& edge, std::int32_t id, const Third& third, const Four& x) {
    if (vertices_ > most_vertices - 4) return false;
    if (keep_ == Keep::places) keep_position(third, x);
    tied_cells_.assign({own_local_, local_[edge.a], local_[edge.b], cells_.local(id)});
    for (const std::int32_t other : tied_) tied_cells_.push_back(cells_.local(other));
    const double square = (1 + 4 * margin) * most_distance_squared(dot(wide(x), wide(x)), third);
    cells_.give_tie(tied_cells_, numbers_[vertices_], bounds::power(square * unscale_ * unscale_, weight_));
    return link_polygon(std::span(tied_cells_).subspan(1), vertices_++, true);
}

template <class Isa>
bool StarWalk<Isa>::link_polygon(std::span<const std::int32_t> cells, int vertex, bool stack_them) {
    if (cells.size() > most_ties || planes_ + cells.size() > most_planes || ends_ + cells.size() > 4 * most_vertices)
        return false;
    if (weighted_ && any_parallel(cells)) return false;
    used_exact_ = true;
    std::array<exact::Plane, most_ties> planes;
    std::array<const exact::Plane*, most_ties> pointers;
    for (std::size_t k = 0; k < cells.size(); ++k) {
        planes[k] = exact_plane(cells_.id(cells[k]));
        pointers[k] = &planes[k];
    }
    std::array<int, most_ties> room;
    const auto polygon = exact::corner_polygon(base_.point, std::span(pointers).first(cells.size()),
                                               std::span(room).first(cells.size()));
    if (polygon.size() < 3) return false;
    std::array<std::uint8_t, most_ties> slots;
    const std::size_t count = polygon.size();
    for (std::size_t k = 0; k < count; ++k) {
        const std::int32_t cell = cells[static_cast<std::size_t>(polygon[k])];
        make_room(cell);
        slots[k] = static_cast<std::uint8_t>(slot_of(cell, planes_));
    }
    for (std::size_t k = 0; k < count; ++k) {
        const int a = slots[k], b = slots[k + 1 == count ? 0 : k + 1];
        out_[a] |= 1ull << b;
        in_[b] |= 1ull << a;
        from_vertex_[a][b] = static_cast<std::uint8_t>(vertex);
    }
    if (keep_ != Keep::nothing) {
        const auto begin = std::ssize(tie_slots_);
        tie_slots_.insert(tie_slots_.end(), slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count));
        ties_.push_back({vertex, begin, std::ssize(tie_slots_)});
    }
    ends_ += static_cast<int>(count);
    for (std::size_t k = 0; k < count && stack_them; ++k) stack(slots[k], slots[k + 1 == count ? 0 : k + 1]);
    return true;
}

}  // namespace votess::cpu
