#include "surface/flips.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/at.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"

namespace votess::surface {
namespace {

constexpr double flat_angle = 20;  // degrees: a triangle is flat if its smallest angle is less, and its largest obtuse
constexpr int max_passes = 20;

class Flips {
public:
    Flips(const std::vector<double>& vertices, double sharp, std::vector<std::int32_t>& triangles)
        : vertices_(vertices), cosine_(std::cos(sharp * std::numbers::pi / 180)), triangles_(triangles) {}

    void make() {
        for (std::size_t t = 0; t < triangles_.size() / 3; ++t)
            for (const std::int32_t v : triangle(t)) add(v, t);
        bool is_changed = true;
        for (int pass = 0; is_changed && pass < max_passes; ++pass) {
            check_stop();
            is_changed = false;
            for (std::size_t t = 0; t < triangles_.size() / 3; ++t) is_changed |= flip(t);
        }
    }

private:
    using Triangle = std::array<std::int32_t, 3>;
    [[nodiscard]] Triangle triangle(std::size_t t) const {
        return {triangles_[3 * t], triangles_[3 * t + 1], triangles_[3 * t + 2]};
    }
    [[nodiscard]] Vector3 place(std::int32_t v) const {
        return {vertices_[3 * at(v)], vertices_[3 * at(v) + 1], vertices_[3 * at(v) + 2]};
    }
    void add(std::int32_t v, std::size_t t) {
        if (at(v) >= of_vertex_.size()) of_vertex_.resize(at(v) + 1);
        of_vertex_[at(v)].push_back(t);
    }
    void remove(std::int32_t v, std::size_t t) { std::erase(of_vertex_[at(v)], t); }

    // Returns the smallest angle in degrees.
    [[nodiscard]] double angle(const Triangle& t) const {
        double least = 180;
        for (std::size_t k = 0; k < 3; ++k) least = std::min(least, angle_at(t, k));
        return least;
    }
    [[nodiscard]] double angle_at(const Triangle& t, std::size_t k) const {
        const Vector3 a = minus(place(t[(k + 1) % 3]), place(t[k])), b = minus(place(t[(k + 2) % 3]), place(t[k]));
        return std::atan2(length3(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi;
    }
    // Returns whether two triangles turn less than a sharp edge does.
    [[nodiscard]] bool is_smooth(const Triangle& s, const Triangle& t) const {
        const Vector3 m = normal(s), n = normal(t);
        return dot(m, n) > cosine_ * length3(m) * length3(n);
    }
    [[nodiscard]] Vector3 normal(const Triangle& t) const {
        return cross(minus(place(t[1]), place(t[0])), minus(place(t[2]), place(t[0])));
    }

    // Flips the edge of a flat triangle (a, b, c) opposite to its obtuse angle at b.
    bool flip(std::size_t t) {
        Triangle own = triangle(t);
        const double before = angle(own);
        if (before >= flat_angle) return false;
        std::size_t k = 0;
        while (k < 3 && angle_at(own, k) <= 90) ++k;
        if (k == 3) return false;
        const std::int32_t b = own[k], c = own[(k + 1) % 3], a = own[(k + 2) % 3];
        std::size_t other = t;
        std::int32_t d = -1;
        for (const std::size_t u : of_vertex_[at(a)]) {
            const Triangle next = triangle(u);
            if (u == t || std::ranges::find(next, c) == next.end()) continue;
            if (d >= 0) return false;  // more than two triangles at the edge
            // It must run along the edge from a to c.
            const auto from = static_cast<std::size_t>(std::ranges::find(next, a) - next.begin());
            if (next[(from + 1) % 3] != c) return false;
            other = u, d = next[(from + 2) % 3];
        }
        if (d < 0) return false;
        for (const std::size_t u : of_vertex_[at(b)])
            if (const Triangle next = triangle(u); std::ranges::find(next, d) != next.end()) return false;
        const Triangle beyond = triangle(other), first{b, d, a}, second{b, c, d};
        if (std::min(angle(first), angle(second)) <= std::min(before, angle(beyond))) return false;
        if (!is_smooth(first, second) || !is_smooth(first, beyond) || !is_smooth(second, beyond)) return false;
        for (const auto& [v, u] : {std::pair{c, t}, std::pair{a, other}}) remove(v, u);
        set(t, first), set(other, second);
        add(d, t), add(b, other);
        return true;
    }
    void set(std::size_t t, const Triangle& to) {
        std::ranges::copy(to, triangles_.begin() + static_cast<std::ptrdiff_t>(3 * t));
    }

    const std::vector<double>& vertices_;
    double cosine_;
    std::vector<std::int32_t>& triangles_;
    std::vector<std::vector<std::size_t>> of_vertex_;
};

}  // namespace

void flip_flat(const std::vector<double>& vertices, double sharp, std::vector<std::int32_t>& triangles) {
    const std::vector<std::int32_t> before = triangles;
    Flips(vertices, sharp, triangles).make();
    if (triangles == before) return;
    std::vector<std::array<std::int32_t, 3>> sorted;
    for (std::size_t k = 0; k < triangles.size(); k += 3) {
        std::array t{triangles[k], triangles[k + 1], triangles[k + 2]};
        std::ranges::rotate(t, std::ranges::min_element(t));
        sorted.push_back(t);
    }
    std::ranges::sort(sorted, {}, [](const auto& t) {
        return std::array{t[0], std::min(t[1], t[2]), std::max(t[1], t[2])};
    });
    triangles.clear();
    for (const auto& t : sorted) triangles.insert(triangles.end(), t.begin(), t.end());
}

}  // namespace votess::surface
