#include "cpu/star.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace votess::cpu {
namespace {

using Vector = std::array<double, 3>;

constexpr double unit = 0x1p-53;
constexpr float float_unit = 0x1p-24f;
constexpr float quantum = 2;            // of window integers: more than q in star.hpp
constexpr double worst_condition = 1e6;  // |na||nb||nc| / |det|
constexpr double margin = 2e-8;  // more than the relative error of a vertex that is accepted
constexpr double solved_factor = 64 * unit;
constexpr double smallest_normal = 1e-100, largest_normal = 1e100;  // no square of a product leaves the range
constexpr double reach_margin = 1.25;  // of the squared security radius that is typical
constexpr int most_picks = 64;         // planes tried for one vertex
constexpr int most_new = 24;           // seeds taken at once from beyond the window

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

Star::Star(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Box& box, const StarKernels& kernels)
    : seeds_(seeds), hierarchy_(hierarchy), box_(box), kernels_(kernels), window_(seeds, hierarchy, kernels) {}

void Star::begin(std::size_t first, std::size_t last, bool measure) {
    cells_.begin(first, last, measure);
    measure_ = measure;
    window_group_ = ~std::size_t{0};
    if (typical_reach_ == 0) {
        const BoundingBox all = hierarchy_.box(hierarchy_.top_level(), 0);
        double volume = 1;
        for (int k = 0; k < 3; ++k) volume *= std::max(all.upper[k] - all.lower[k], 1e-9);
        typical_reach_ = 5 * std::pow(volume / static_cast<double>(seeds_.size()), 2.0 / 3);
    }
    if (epoch_ > 1u << 25) {
        epoch_ = 0;
        std::fill(slot_.begin(), slot_.end(), 0);
    }
}

bool Star::build(std::size_t seed) {
    seed_ = seed;
    p_ = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
    ++epoch_;
    planes_ = vertices_ = edges_ = 0;
    planes_known_ = active_ = 0;
    have_candidates_ = have_walls_ = used_exact_ = false;
    const bool complete = this->complete(seed);
    if (have_candidates_ && !complete) window_.show(seed, own_x_);
    if (complete) {
        cells_.set_done(seed);
        if (window_group_ == seed / group_size && window_open_) window_.hide(seed);
    }
    return complete;
}

bool Star::complete(std::size_t seed) {
    bool sound = true;
    cells_.for_each_known(seed, [&](std::uint32_t index) {
        if (!sound || vertices_ == most_vertices) {
            sound = false;
            return;
        }
        const SharedVertex& v = cells_.vertex(index);
        const std::int32_t own = cells_.local(static_cast<std::int32_t>(seed));
        const auto& c = v.cells;
        // Even permutations of the four cells keep the orientation.
        const int k = c[1] == own ? 1 : (c[2] == own ? 2 : 3);
        const std::array<std::int32_t, 3> others = k == 1   ? std::array{c[0], c[3], c[2]}
                                                   : k == 2 ? std::array{c[0], c[1], c[3]}
                                                            : std::array{c[0], c[2], c[1]};
        const int a = slot_of(others[0]), b = slot_of(others[1]), d = slot_of(others[2]);
        if (a < 0 || b < 0 || d < 0) {
            sound = false;
            return;
        }
        if (measure_) {
            const VertexPosition& position = cells_.position(index);
            const auto from = static_cast<std::size_t>(cells_.id(c[0]));
            position_[vertices_] = {position.x + (seeds_.x[from] - p_[0]), position.y + (seeds_.y[from] - p_[1]),
                                    position.z + (seeds_.z[from] - p_[2])};
            error_[vertices_] = position.error;
        }
        sound = add_face_corner(a, b, d);
    });
    if (!sound) return false;
    if (vertices_ == 0 && !begin_anywhere()) return false;
    double needed = 0;
    while (active_ != 0) {
        const int a = std::countr_zero(active_);
        const int b = std::countr_zero(open_[a]);
        if (!have_candidates_ && !gather_candidates(seed)) return false;
        if (!close_edge(a, b)) return false;
        needed = std::max(needed, last_reach_);
    }
    if (needed > 0) typical_reach_ += (std::min(needed, 4 * typical_reach_) - typical_reach_) / 16;
    return true;
}

int Star::slot_of(std::int32_t local) {
    if (static_cast<std::size_t>(local) >= slot_.size()) slot_.resize(std::max<std::size_t>(2 * slot_.size(), local + 1024));
    std::uint32_t& entry = slot_[local];
    if (entry / most_planes == epoch_) return static_cast<int>(entry % most_planes);
    if (planes_ == most_planes) return -1;
    entry = epoch_ * most_planes + static_cast<std::uint32_t>(planes_);
    local_[planes_] = local;
    id_[planes_] = cells_.id(local);
    open_[planes_] = 0;
    return planes_++;
}

void Star::plane_through(std::int32_t id, Vector& n, double& h) const {
    if (id >= 0) {
        n = {seeds_.x[id] - p_[0], seeds_.y[id] - p_[1], seeds_.z[id] - p_[2]};
        h = 0.5 * dot(n, n);
        return;
    }
    const int axis = (-1 - id) / 2;
    const double distance = (-1 - id) % 2 == 0 ? box_.lower[axis] - p_[axis] : box_.upper[axis] - p_[axis];
    n = {};
    n[axis] = 2 * distance;
    h = 2 * distance * distance;
}

exact::Plane Star::exact_plane(std::int32_t id) const {
    if (id >= 0) return exact::Plane::bisector({seeds_.x[id], seeds_.y[id], seeds_.z[id]});
    const int axis = (-1 - id) / 2;
    return (-1 - id) % 2 == 0 ? exact::Plane::lower(axis, box_.lower[axis])
                              : exact::Plane::upper(axis, box_.upper[axis]);
}

void Star::need_plane(int slot) {
    if ((planes_known_ >> slot) & 1) return;
    planes_known_ |= 1ull << slot;
    plane_through(id_[slot], n_[slot], h_[slot]);
    norm_[slot] = std::sqrt(2 * h_[slot]);
}

bool Star::toggle(int from, int to) {
    if ((open_[to] >> from) & 1) {
        open_[to] &= ~(1ull << from);
        if (open_[to] == 0) active_ &= ~(1ull << to);
        if (measure_)
            edge_[edges_] = {from_vertex_[to][from], static_cast<std::uint8_t>(vertices_),
                             static_cast<std::uint8_t>(from), static_cast<std::uint8_t>(to)};
        ++edges_;
        return true;
    }
    if ((open_[from] >> to) & 1) return false;
    open_[from] |= 1ull << to;
    active_ |= 1ull << from;
    if (measure_) from_vertex_[from][to] = static_cast<std::uint8_t>(vertices_);
    return true;
}

bool Star::add_face_corner(int a, int b, int c) {
    if (vertices_ == most_vertices - 4) return false;
    const bool sound = toggle(a, b) && toggle(b, c) && toggle(c, a);
    ++vertices_;
    return sound;
}

bool Star::gather_candidates(std::size_t seed) {
    const std::size_t group = seed / group_size;
    double reach2 = reach_margin * typical_reach_;
    if (window_group_ != group) {
        window_group_ = group;
        window_open_ = window_.open(group, std::sqrt(reach2) * 1.02, cells_);
        if (window_open_)
            for (std::size_t s = group * group_size; s < seed; ++s)
                if (cells_.holds(static_cast<std::int64_t>(s)) && cells_.done(s)) window_.hide(s);
    }
    if (!window_open_) return false;
    reach2 = std::min(reach2, window_.reach() * window_.reach());
    const double scale = window_.scale();
    const auto p = window_.position(seed);
    window_.hide(seed);
    for (int tries = 0;; ++tries) {
        if (kernels_.select(window_.seeds(), p.data(), static_cast<float>(reach2 * scale * scale), candidates_)) break;
        if (tries == 8) {
            window_.show(seed, p[0]);
            return false;
        }
        reach2 *= 0.5;
    }
    have_candidates_ = true;
    own_x_ = p[0];
    const double reach = std::sqrt(reach2);
    const double covered = reach * (1 - 0x1p-20) - quantum / scale;
    covered_ = covered > 0 ? covered * covered : 0;
    longest_ = reach * scale * (1 + 0x1p-20) + quantum;
    extras_ = candidates_.count;
    for (int wall = -1; wall >= -6; --wall) {
        Vector n;
        double h;
        plane_through(wall, n, h);
        if (2 * h < reach2 * (1 + 0x1p-20)) add_candidate(wall);
    }
    return true;
}

bool Star::add_candidate(std::int32_t id) {
    CandidatePlanes& c = candidates_;
    if (c.count == CandidatePlanes::capacity) return false;
    Vector n;
    double h;
    plane_through(id, n, h);
    const double scale = window_.scale();
    const double length = std::sqrt(2 * h) * scale;
    if (!(length < 1e12)) return false;  // its square times another must stay a float
    longest_ = std::max(longest_, length * (1 + 0x1p-20));
    const int i = c.count++;
    c.nx[i] = static_cast<float>(n[0] * scale);
    c.ny[i] = static_cast<float>(n[1] * scale);
    c.nz[i] = static_cast<float>(n[2] * scale);
    c.h[i] = static_cast<float>(h * scale * scale);
    c.id[i] = id;
    if (c.count % 16 == 1)
        for (int k = c.count; k < c.count + 15; ++k) {
            c.nx[k] = c.ny[k] = c.nz[k] = 0;
            c.h[k] = CandidatePlanes::never;
        }
    return true;
}

bool Star::is_extra(std::int32_t id) const {
    const std::int32_t* end = candidates_.id + candidates_.count;
    return std::find(candidates_.id + extras_, end, id) != end;
}

bool Star::add_walls() {
    have_walls_ = true;
    for (int wall = -1; wall >= -6; --wall) {
        if (!is_extra(wall) && !add_candidate(wall)) return false;
    }
    return true;
}

// The nearest seed is a neighbor, and the middle between the two lies inside their face. From there any way along the
// face leads to an edge.
bool Star::begin_anywhere() {
    if (!gather_candidates(seed_)) return false;
    if (candidates_.count == extras_ && !add_walls()) return false;
    const CandidatePlanes& c = candidates_;
    const auto nearest = static_cast<int>(std::min_element(c.h, c.h + c.count) - c.h);
    const int a = slot_of(cells_.local(c.id[nearest]));
    need_plane(a);
    const Vector& n = n_[a];
    const Vector along = cross(n, {0.61803398875 * n[1], 0.7548776662 * n[2], 0.5698402910 * n[0] + norm_[a]});
    const double scale = window_.scale();
    float o[3], d[3];
    for (int k = 0; k < 3; ++k) {
        o[k] = static_cast<float>(0.5 * n[k] * scale);
        d[k] = static_cast<float>(along[k] * scale * scale);
    }
    const float least = 0x1p-18f * (std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2])) * static_cast<float>(longest_);
    int hit = kernels_.first_hit(c, o, d, least);
    if (hit < 0 && !have_walls_) {
        if (!add_walls()) return false;
        hit = kernels_.first_hit(c, o, d, least);
    }
    if (hit < 0) return false;
    return close_edge(a, slot_of(cells_.local(c.id[hit])));
}

bool Star::close_edge(int a, int b) {
    need_plane(a);
    need_plane(b);
    const Vector &na = n_[a], &nb = n_[b];
    const Vector ab = cross(na, nb);
    const double square = dot(ab, ab);
    const double norms = norm_[a] * norm_[b];
    if (!(norm_[a] > smallest_normal && norm_[b] > smallest_normal && norms < largest_normal) ||
        !(square * (worst_condition * worst_condition) > norms * norms))
        return false;
    const double scale = window_.scale();
    const Vector nb_ab = cross(nb, ab), ab_na = cross(ab, na);
    const double inverse = scale / square;
    const double scale2 = scale * scale;
    float o[3], d[3];
    for (int k = 0; k < 3; ++k) {
        o[k] = static_cast<float>((h_[a] * nb_ab[k] + h_[b] * ab_na[k]) * inverse);
        d[k] = static_cast<float>(-ab[k] * scale2);
    }
    const float slope = 0x1p-18f * (std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]));
    int lane = -1;
    for (int pick = 0; pick < most_picks; ++pick) {
        if (lane < 0) lane = kernels_.first_hit(candidates_, o, d, slope * static_cast<float>(longest_));
        if (lane < 0) {
            if (have_walls_ || !add_walls()) return false;
            continue;
        }
        const std::int32_t id = candidates_.id[lane];
        Vector nc;
        double hc;
        plane_through(id, nc, hc);
        const Vector bc = cross(nb, nc), ca = cross(nc, na);
        const double determinant = dot(nc, ab);
        const double norm_c = std::sqrt(2 * hc);
        const double condition = norms * norm_c / -determinant;
        if (!(determinant < 0 && condition < worst_condition && norm_c > smallest_normal)) return false;
        const double over = 1 / determinant;
        Vector x;
        float v[3];
        double x2 = 0;
        for (int k = 0; k < 3; ++k) {
            x[k] = (h_[a] * bc[k] + h_[b] * ca[k] + hc * ab[k]) * over;
            v[k] = static_cast<float>(x[k] * scale);
            x2 += x[k] * x[k];
        }
        const auto length = static_cast<float>(std::sqrt(x2) * scale);
        if (!(length < 1e12f)) {
            if (have_walls_ || !add_walls()) return false;
            lane = -1;
            continue;
        }
        const auto longest = static_cast<float>(longest_);
        const float bound = 1.01f * (float_unit * (6.5f * longest * length + 4.6f * longest * longest) +
                                     quantum * (length + longest));
        std::uint64_t touching[CandidatePlanes::capacity / 64];
        const int words = kernels_.touching(candidates_, v, bound, touching);
        int next = -1;
        for (int w = 0; w < words && next < 0; ++w)
            for (std::uint64_t m = touching[w]; m != 0; m &= m - 1) {
                const int other = 64 * w + std::countr_zero(m);
                const std::int32_t q = candidates_.id[other];
                if (q == id || q == id_[a] || q == id_[b]) continue;
                const int side = side_of(x, condition, a, b, id, q);
                if (side == 0) return false;
                if (side > 0) {
                    next = other;
                    break;
                }
            }
        if (next >= 0) {
            lane = next;
            continue;
        }
        last_reach_ = 4 * x2;
        if (4 * x2 * (1 + margin) > covered_) {
            if (!have_walls_) {
                if (!add_walls()) return false;
                lane = -1;
                continue;
            }
            int added = 0;
            if (!add_inside(x, std::sqrt(x2), id_[a], id_[b], id, added)) return false;
            if (added > 0) {
                lane = -1;
                continue;
            }
        }
        const std::int32_t local = cells_.local(id);
        const int c = slot_of(local);
        if (c < 0) return false;
        if (!((planes_known_ >> c) & 1)) {
            planes_known_ |= 1ull << c;
            n_[c] = nc;
            h_[c] = hc;
            norm_[c] = norm_c;
        }
        const double error = solved_factor * condition * std::sqrt(x2);
        if (measure_) {
            position_[vertices_] = x;
            error_[vertices_] = error;
        }
        cells_.add({{cells_.local(static_cast<std::int32_t>(seed_)), local_[b], local_[a], local}},
                   {x[0], x[1], x[2], error + 8 * unit * std::sqrt(x2)});
        return add_face_corner(b, a, c);
    }
    return false;
}

int Star::side_of(const Vector& x, double condition, int a, int b, std::int32_t c, std::int32_t d) {
    Vector n;
    double h;
    plane_through(d, n, h);
    const double excess = dot(n, x) - h;
    const double bound = std::sqrt(2 * h) * std::sqrt(dot(x, x)) * unit * (64 * condition + 8) + 12 * unit * h;
    if (excess > bound) return 1;
    if (excess < -bound) return -1;
    used_exact_ = true;
    return exact::side_of_vertex(p_, exact_plane(id_[a]), exact_plane(id_[b]), exact_plane(c), exact_plane(d));
}

// Seeds beyond the candidates that the sphere around the vertex may hold; some of them if they are many.
bool Star::add_inside(const Vector& x, double radius, std::int32_t a, std::int32_t b, std::int32_t c, int& added) {
    BoundingBox at;
    double size = 0;
    for (int k = 0; k < 3; ++k) {
        at.lower[k] = at.upper[k] = p_[k] + x[k];
        size = std::max(size, std::abs(p_[k]) + std::abs(x[k]));
    }
    const double reach = radius * (1 + margin) + 8 * unit * size;
    nodes_.assign(1, {hierarchy_.top_level(), 0});
    while (!nodes_.empty()) {
        const Node node = nodes_.back();
        nodes_.pop_back();
        unsigned near = kernels_.near_boxes(hierarchy_.block(node.level, node.index), at, reach * reach);
        for (; near != 0; near &= near - 1) {
            const std::uint32_t child = node.index * box_fan + static_cast<std::uint32_t>(std::countr_zero(near));
            if (node.level > 0) {
                nodes_.push_back({node.level - 1, child});
                continue;
            }
            if (cells_.group_done(child)) continue;
            const std::size_t begin = std::size_t{child} * group_size;
            for (std::size_t s = begin; s < std::min(begin + group_size, seeds_.size()); ++s) {
                const Vector n{seeds_.x[s] - p_[0], seeds_.y[s] - p_[1], seeds_.z[s] - p_[2]};
                const double square = dot(n, n);
                if (square < covered_ || dot(n, x) - 0.5 * square < -margin * (square + radius * std::sqrt(square)))
                    continue;
                const auto id = static_cast<std::int32_t>(s);
                if (s == seed_ || id == a || id == b || id == c) continue;
                if (is_extra(id)) continue;
                if (!add_candidate(id)) return false;
                if (++added == most_new) return true;
            }
        }
    }
    return true;
}

}  // namespace votess::cpu
