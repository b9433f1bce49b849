#include "oracle/shares.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace test {
namespace {

using Exact = std::array<mpq_class, 3>;

Exact minus(const Exact& a, const Exact& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
mpq_class dot(const Exact& a, const Exact& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Exact cross(const Exact& a, const Exact& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct HalfSpace {  // n.x <= h
    Exact n;
    mpq_class h;
};

// A convex polytope: polygons counterclockwise seen from outside, each with the number of its plane.
class Polytope {
public:
    struct Face {
        int plane;
        std::vector<int> corners;
    };

    static Polytope cube(const mpq_class& half) {
        Polytope p;
        for (int i = 0; i < 8; ++i)
            p.vertices_.push_back(
                {(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half});
        p.faces_ = {{-1, {0, 4, 6, 2}}, {-1, {1, 3, 7, 5}}, {-1, {0, 1, 5, 4}},
                    {-1, {2, 6, 7, 3}}, {-1, {0, 2, 3, 1}}, {-1, {4, 5, 7, 6}}};
        p.round();
        return p;
    }

    void clip(const HalfSpace& by, int plane) {
        if (is_surely_inside(by)) return;
        std::vector<mpq_class> excess;
        bool within = false, beyond = false;
        for (const Exact& v : vertices_) {
            excess.push_back(dot(by.n, v) - by.h);
            within |= excess.back() < 0;
            beyond |= excess.back() > 0;
        }
        if (!beyond) return;
        if (!within) return faces_.clear();
        std::vector<Face> faces;
        std::map<int, std::vector<int>> rim;  // by corner of the new face, the two beside it
        std::map<std::pair<int, int>, int> crossings;
        const auto crossing = [&](int i, int j) {
            const auto [at, is_new] = crossings.try_emplace(std::minmax(i, j), static_cast<int>(vertices_.size()));
            if (is_new) {
                const mpq_class share = excess[i] / (excess[i] - excess[j]);
                Exact x;
                for (int k = 0; k < 3; ++k) x[k] = vertices_[i][k] + share * (vertices_[j][k] - vertices_[i][k]);
                vertices_.push_back(x);
            }
            return at->second;
        };
        for (const Face& face : faces_) {
            Face kept{face.plane, {}};
            std::vector<int> on;
            bool cut = false;
            for (std::size_t c = 0; c < face.corners.size(); ++c) {
                const int i = face.corners[c], j = face.corners[(c + 1) % face.corners.size()];
                const int si = sgn(excess[i]), sj = sgn(excess[j]);
                cut |= si > 0;
                if (si <= 0) kept.corners.push_back(i);
                if (si == 0) on.push_back(i);
                if (si * sj >= 0) continue;
                kept.corners.push_back(crossing(i, j));
                on.push_back(kept.corners.back());
            }
            if (cut && on.size() == 2) {
                rim[on[0]].push_back(on[1]);
                rim[on[1]].push_back(on[0]);
            }
            if (kept.corners.size() >= 3) faces.push_back(kept);
        }
        faces_ = faces;
        Face cap{plane, {rim.begin()->first}};
        for (int last = -1;;) {
            const int at = cap.corners.back();
            const std::vector<int>& beside = rim[at];
            const int next = beside[0] == last ? beside[1] : beside[0];
            if (next == cap.corners.front()) break;
            cap.corners.push_back(next);
            last = at;
        }
        if (dot(cross(minus(vertices_[cap.corners[1]], vertices_[cap.corners[0]]),
                      minus(vertices_[cap.corners[2]], vertices_[cap.corners[0]])),
                by.n) < 0)
            std::ranges::reverse(cap.corners);
        faces_.push_back(cap);
        compact();
    }

    [[nodiscard]] bool empty() const { return faces_.empty(); }
    [[nodiscard]] const std::vector<Face>& faces() const { return faces_; }
    [[nodiscard]] const std::vector<std::array<double, 3>>& rounded() const { return rounded_; }
    [[nodiscard]] const Exact& vertex(int v) const { return vertices_[v]; }
    [[nodiscard]] mpq_class volume() const {
        mpq_class sum = 0;
        for (const Face& face : faces_)
            for (std::size_t c = 1; c + 1 < face.corners.size(); ++c)
                sum += dot(minus(vertices_[face.corners[0]], vertices_[0]),
                           cross(minus(vertices_[face.corners[c]], vertices_[0]),
                                 minus(vertices_[face.corners[c + 1]], vertices_[0])));
        return sum / 6;
    }

private:
    void compact() {
        std::vector<int> number(vertices_.size(), -1);
        std::vector<Exact> kept;
        for (Face& face : faces_)
            for (int& c : face.corners) {
                if (number[c] < 0) {
                    number[c] = static_cast<int>(kept.size());
                    kept.push_back(vertices_[c]);
                }
                c = number[c];
            }
        vertices_ = kept;
        round();
    }
    void round() {
        rounded_.clear();
        for (const Exact& v : vertices_) rounded_.push_back({v[0].get_d(), v[1].get_d(), v[2].get_d()});
    }
    [[nodiscard]] bool is_surely_inside(const HalfSpace& by) const {
        const std::array<double, 3> n{by.n[0].get_d(), by.n[1].get_d(), by.n[2].get_d()};
        const double h = by.h.get_d();
        return std::ranges::all_of(rounded_, [&](const auto& x) {
            const double p = n[0] * x[0], q = n[1] * x[1], r = n[2] * x[2];
            return h - p - q - r > 1e-14 * (std::abs(h) + std::abs(p) + std::abs(q) + std::abs(r));
        });
    }

    std::vector<Exact> vertices_;
    std::vector<std::array<double, 3>> rounded_;
    std::vector<Face> faces_;
};

Exact exact(const double* x) {
    return {mpq_class(x[0]), mpq_class(x[1]), mpq_class(x[2])};
}

struct Vectors {
    Exact origin;
    std::array<Exact, 3> edge;
    std::array<bool, 3> periodic;
};

Vectors vectors_of(const votess::Options& options) {
    if (options.cell)
        return {exact(options.cell->origin.data()),
                {exact(options.cell->a.data()), exact(options.cell->b.data()), exact(options.cell->c.data())},
                options.cell->periodic};
    Vectors v{exact(options.box->lower.data()), {}, options.periodic};
    const Exact upper = exact(options.box->upper.data());
    for (int k = 0; k < 3; ++k) v.edge[k][k] = upper[k] - v.origin[k];
    return v;
}

// Visits the sums of vectors by whole numbers from -2 to 2 along periodic edges.
template <class Visit>
void for_shifts(const Vectors& v, Visit visit) {
    const auto least = [&](int j) { return v.periodic[j] ? -2 : 0; };
    for (int i = least(0); i <= -least(0); ++i)
        for (int j = least(1); j <= -least(1); ++j)
            for (int k = least(2); k <= -least(2); ++k) {
                Exact t;
                for (int c = 0; c < 3; ++c) t[c] = i * v.edge[0][c] + j * v.edge[1][c] + k * v.edge[2][c];
                visit(t, i == 0 && j == 0 && k == 0);
            }
}

// An image of a seed: a, relative to the query, and its distance h from the bisector, times |a|. First rounded, then
// exact where it matters.
struct Image {
    std::int32_t seed;
    std::size_t shift;
    double h, length;
    bool kept = true;
    HalfSpace bisector{};
};

double radius_of(const Polytope& cell) {
    double radius = 0;
    for (const auto& x : cell.rounded()) radius = std::max(radius, std::hypot(x[0], x[1], x[2]));
    return radius;
}

// Marks images that are farther than another from all of a polytope, with much room for rounding.
void drop_far(std::vector<Image>& images, double radius) {
    double nearest = HUGE_VAL;
    for (const Image& image : images) nearest = std::min(nearest, image.h + radius * image.length);
    const double room = 1e-6 * (std::abs(nearest) + radius * radius);
    for (Image& image : images) image.kept = image.h - radius * image.length <= nearest + room;
}

}  // namespace

Shares exact_shares(std::span<const double> points, std::span<const double> weights, const votess::Options& options,
                    const std::array<double, 3>& query, double weight) {
    // All is relative to the query.
    const Vectors v = vectors_of(options);
    const Exact q = exact(query.data());
    mpq_class size = 1;
    for (const Exact& edge : v.edge)
        for (const mpq_class& x : edge) size += 4 * abs(x);
    Polytope cell = Polytope::cube(size);
    constexpr int wall = -2, own = -3;
    for (int j = 0; j < 3; ++j) {
        if (v.periodic[j]) continue;
        Exact n = cross(v.edge[(j + 1) % 3], v.edge[(j + 2) % 3]);
        if (dot(n, v.edge[j]) < 0)
            for (mpq_class& x : n) x = -x;
        const mpq_class low = dot(n, minus(v.origin, q));
        cell.clip({n, low + dot(n, v.edge[j])}, wall);
        cell.clip({{-n[0], -n[1], -n[2]}, -low}, wall);
    }
    for (const votess::Wall& w : options.walls) {
        const Exact n = exact(w.normal.data());
        cell.clip({n, mpq_class(w.offset) - dot(n, q)}, wall);
    }
    std::vector<Exact> shifts;
    for_shifts(v, [&](const Exact& t, bool zero) {
        shifts.push_back(t);
        if (!zero) cell.clip({t, dot(t, t) / 2}, own);
    });

    // Images near the query: |x - a|^2 - w_a <= |x|^2 - w  where  a.x >= (a.a + w - w_a) / 2 = h. Of such powers, those
    // less |x|^2 - w are twice h - a.x.
    const auto more = [&](std::size_t seed) {
        return weights.empty() ? mpq_class(0) : mpq_class(mpq_class(weight) - mpq_class(weights[seed]));
    };
    std::vector<Image> images;
    std::vector<Exact> near;  // the seeds, each by its image about nearest to the query
    for (std::size_t s = 0; s < points.size() / 3; ++s) {
        Exact at = minus(exact(&points[3 * s]), q);
        for (int j = 0; j < 3; ++j) {
            if (!v.periodic[j]) continue;
            const Exact n = cross(v.edge[(j + 1) % 3], v.edge[(j + 2) % 3]);
            const mpq_class f = dot(n, at) / dot(n, v.edge[j]);
            const int whole = static_cast<int>(std::lround(f.get_d()));
            for (int c = 0; c < 3; ++c) at[c] -= whole * v.edge[j][c];
        }
        near.push_back(at);
        const double w = more(s).get_d();
        for (std::size_t t = 0; t < shifts.size(); ++t) {
            double square = 0;
            for (int c = 0; c < 3; ++c) square += std::pow(at[c].get_d() + shifts[t][c].get_d(), 2);
            images.push_back({static_cast<std::int32_t>(s), t, 0.5 * (square + w), std::sqrt(square)});
        }
    }
    drop_far(images, radius_of(cell));
    std::erase_if(images, [](const Image& image) { return !image.kept; });
    std::ranges::stable_sort(images, {}, &Image::h);
    for (Image& image : images) {
        const auto s = static_cast<std::size_t>(image.seed);
        Exact a;
        for (int c = 0; c < 3; ++c) a[c] = near[s][c] + shifts[image.shift][c];
        image.bisector = {a, (dot(a, a) + more(s)) / 2};
    }
    for (std::size_t i = 0; i < images.size() && !cell.empty(); ++i) cell.clip(images[i].bisector, static_cast<int>(i));

    drop_far(images, radius_of(cell));
    Shares shares;
    shares.volume = cell.empty() ? mpq_class(0) : cell.volume();
    if (cell.empty()) return shares;
    for (const Polytope::Face& face : cell.faces()) {
        shares.meets_itself |= face.plane == own;
        shares.at_wall |= face.plane == wall;
        if (face.plane < 0) continue;
        const HalfSpace& by = images[face.plane].bisector;
        Shares::Share& share = shares.of[images[face.plane].seed];
        // The area vector is n times `times`, which is the area over the distance.
        const mpq_class square = dot(by.n, by.n);
        mpq_class times = 0;
        for (std::size_t c = 1; c + 1 < face.corners.size(); ++c) {
            const Exact &x = cell.vertex(face.corners[0]), &y = cell.vertex(face.corners[c]),
                        &z = cell.vertex(face.corners[c + 1]);
            const mpq_class part = dot(cross(minus(y, x), minus(z, x)), by.n) / square / 2;
            times += part;
            for (int k = 0; k < 3; ++k) share.gradient[k] += part * (x[k] + y[k] + z[k]) / 3;
        }
        share.area += times.get_d();
    }
    for (std::size_t i = 0; i < images.size(); ++i) {
        if (!images[i].kept) continue;
        Polytope part = cell;
        const HalfSpace& a = images[i].bisector;
        for (std::size_t j = 0; j < images.size() && !part.empty(); ++j) {
            const HalfSpace& b = images[j].bisector;
            if (j != i && images[j].kept) part.clip({minus(b.n, a.n), b.h - a.h}, 0);
        }
        if (!part.empty()) shares.of[images[i].seed].volume += part.volume();
    }
    return shares;
}

}  // namespace test
