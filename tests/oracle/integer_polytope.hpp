// Polytopes bounded by planes of whole numbers: corners, faces, and whether another plane cuts.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "oracle/integer_domain.hpp"
#include "support/text.hpp"

namespace test {

constexpr mp_bitcnt_t digits = 512, many_digits = 4096;

using Real = mpf_class;
using Reals = VectorOf<Real>;
using Doubles = VectorOf<double>;

inline std::string name(const ExactFace& face) {
    const auto& s = face.shift;
    return s == std::array<int, 3>{} ? text(face.id) : text(face.id, '(', s[0], ',', s[1], ',', s[2], ')');
}

struct Vertex {
    Integers x;  // over w > 0
    mpz_class w;
    std::vector<std::size_t> on;  // the planes through it
    Doubles rounded{};
};

inline int side(const IntegerPlane& plane, const Vertex& v) {
    return cmp(dot(plane.n, v.x), mpz_class(plane.h * v.w));
}

inline Doubles rounded(const Integers& x) {
    return {x[0].get_d(), x[1].get_d(), x[2].get_d()};
}

// A plane of unit normal, rounded.
struct RoundedPlane {
    Doubles n;
    double h;
};

inline RoundedPlane rounded(const IntegerPlane& plane) {
    const mpz_class square = dot(plane.n, plane.n);
    const Real length = sqrt(Real(square, 128));
    const auto by_length = [&](const mpz_class& x) { return Real(Real(x, 128) / length).get_d(); };
    return {{by_length(plane.n[0]), by_length(plane.n[1]), by_length(plane.n[2])}, by_length(plane.h)};
}

// Whether the corner of three planes is beyond some plane for sure. Sums of products of unit normals have errors of
// some units of 2^-53, those with h of that times h.
bool surely_outside(const std::vector<RoundedPlane>& planes, const std::vector<std::size_t>& order, std::size_t a,
                    std::size_t b, std::size_t c) {
    constexpr double slack = 1e-13, underflow = 1e-290;
    const Doubles ab = cross(planes[a].n, planes[b].n), bc = cross(planes[b].n, planes[c].n),
                  ca = cross(planes[c].n, planes[a].n);
    const double w = dot(ab, planes[c].n), sign = w < 0 ? -1 : 1;
    if (std::abs(w) < slack) return false;
    Doubles x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = sign * (planes[a].h * bc[k] + planes[b].h * ca[k] + planes[c].h * ab[k]);
    const double size = std::abs(planes[a].h) + std::abs(planes[b].h) + std::abs(planes[c].h);
    return std::ranges::any_of(order, [&](std::size_t o) {
        return dot(planes[o].n, x) - planes[o].h * std::abs(w) > slack * (size + std::abs(planes[o].h)) + underflow;
    });
}

// The polyhedron inside all planes, by its corners: three planes each.
inline std::vector<Vertex> find_vertices(const std::vector<IntegerPlane>& planes) {
    std::map<std::vector<std::size_t>, Vertex> vertices;
    std::vector<std::size_t> order(planes.size());  // those that cut much come first
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::vector<RoundedPlane> by_doubles;
    for (const IntegerPlane& plane : planes) by_doubles.push_back(rounded(plane));
    for (std::size_t a = 0; a < planes.size(); ++a)
        for (std::size_t b = a + 1; b < planes.size(); ++b) {
            const Integers along = cross(planes[a].n, planes[b].n);
            if (is_zero(along)) continue;
            for (std::size_t c = b + 1; c < planes.size(); ++c) {
                if (surely_outside(by_doubles, order, a, b, c)) continue;
                Vertex v;
                v.w = dot(along, planes[c].n);
                if (v.w == 0) continue;
                const Integers bc = cross(planes[b].n, planes[c].n), ca = cross(planes[c].n, planes[a].n);
                for (std::size_t k = 0; k < 3; ++k)
                    v.x[k] = planes[a].h * bc[k] + planes[b].h * ca[k] + planes[c].h * along[k];
                if (v.w < 0) {
                    v.w = -v.w;
                    v.x = opposite(v.x);
                }
                bool inside = true;
                for (std::size_t o = 0; o < order.size() && inside; ++o) {
                    const int s = side(planes[order[o]], v);
                    if (s == 0) v.on.push_back(order[o]);
                    if (s <= 0) continue;
                    inside = false;
                    std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(o),
                                order.begin() + static_cast<std::ptrdiff_t>(o) + 1);
                }
                if (!inside) continue;
                std::ranges::sort(v.on);
                for (std::size_t k = 0; k < 3; ++k) {
                    mpq_class x(v.x[k], v.w);
                    x.canonicalize();
                    v.rounded[k] = x.get_d();
                }
                auto key = v.on;
                vertices.emplace(std::move(key), std::move(v));
            }
        }
    std::vector<Vertex> all;
    for (auto& [key, v] : vertices) all.push_back(std::move(v));
    return all;
}

struct Face {
    std::size_t plane = 0;
    std::vector<std::size_t> corners;  // in order around it
};

// The corners of each face in order; the first face that is none in `wrong`.
inline std::vector<Face> find_faces(const std::vector<IntegerPlane>& planes, const std::vector<Vertex>& vertices,
                                    std::string& wrong) {
    std::vector<std::vector<std::size_t>> on(planes.size());
    for (std::size_t v = 0; v < vertices.size(); ++v)
        for (const std::size_t p : vertices[v].on) on[p].push_back(v);
    std::vector<Face> faces;
    for (std::size_t p = 0; p < planes.size(); ++p) {
        if (on[p].size() < 3) {
            if (planes[p].face.id < 0) continue;  // walls need not be listed
            wrong = "lists " + name(planes[p].face) + ", which touches it in no polygon";
            return {};
        }
        // Neighbors around the face share another face with it.
        std::map<std::size_t, std::vector<std::size_t>> next;
        for (std::size_t q = 0; q < planes.size(); ++q) {
            if (q == p || on[q].size() < 3) continue;
            std::vector<std::size_t> shared;
            std::ranges::set_intersection(on[p], on[q], std::back_inserter(shared));
            if (shared.size() > 2) {
                wrong = "lists " + name(planes[p].face) + " and " + name(planes[q].face) + " in one plane";
                return {};
            }
            if (shared.size() < 2) continue;
            next[shared[0]].push_back(shared[1]);
            next[shared[1]].push_back(shared[0]);
        }
        Face face{p, {on[p][0]}};
        for (std::size_t from = on[p][0], at = on[p][0]; face.corners.size() <= on[p].size();) {
            const auto& ends = next[at];
            if (ends.size() != 2) {
                wrong = "is not closed by the faces that it lists: " + name(planes[p].face) + " has an open side";
                return {};
            }
            const std::size_t to = ends[0] == from ? ends[1] : ends[0];
            from = at;
            at = to;
            if (at == face.corners[0]) break;
            face.corners.push_back(at);
        }
        if (face.corners.size() != on[p].size()) {
            wrong = "has a face with " + name(planes[p].face) + " that is no polygon";
            return {};
        }
        faces.push_back(std::move(face));
    }
    return faces;
}

// Whether any corner lies beyond the plane. touching: corners on it.
inline bool cuts(const IntegerPlane& plane, const std::vector<Vertex>& vertices, int& touching) {
    const Doubles n = rounded(plane.n);
    const double h = plane.h.get_d(), length = std::sqrt(dot(n, n));
    touching = 0;
    for (const Vertex& v : vertices) {
        const double s = dot(n, v.rounded) - h, size = std::sqrt(dot(v.rounded, v.rounded));
        const double error = 1e-14 * (length * size + std::abs(h));
        if (s < -error) continue;
        const int exact = s > error ? 1 : side(plane, v);
        if (exact > 0) return true;
        if (exact == 0) ++touching;
    }
    return false;
}

// When planes are equal, the face belongs to a wall before a seed, to the first wall, to the seed farthest behind.
inline bool hides(const IntegerPlane& a, const IntegerPlane& b) {
    if ((a.face.id < 0) != (b.face.id < 0)) return a.face.id < 0;
    return a.face.id < 0 ? a.face.id > b.face.id : dot(a.n, a.n) > dot(b.n, b.n);
}

inline bool coincide(const IntegerPlane& a, const IntegerPlane& b) {
    if (!is_zero(cross(a.n, b.n)) || dot(a.n, b.n) <= 0) return false;
    return a.h * dot(b.n, b.n) == b.h * dot(a.n, b.n);
}

}  // namespace test
