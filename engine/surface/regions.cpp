#include "surface/regions.hpp"

#include <algorithm>
#include <compare>
#include <functional>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "surface/nearest.hpp"

namespace votess::surface {
namespace {

Vector3 vertex_at(const SurfaceCells& faces, std::int32_t v) {
    const std::size_t k = 3 * at(v);
    return {faces.vertices[k], faces.vertices[k + 1], faces.vertices[k + 2]};
}

Vector3 middle_of(const SurfaceCells& faces, std::size_t face) {
    const std::size_t begin = at(faces.polygon_offsets[face]), end = at(faces.polygon_offsets[face + 1]);
    Vector3 sum{};
    for (std::size_t c = begin; c < end; ++c)
        for (std::size_t k = 0; k < 3; ++k) sum[k] += vertex_at(faces, faces.corners[c])[k];
    for (double& x : sum) x /= static_cast<double>(end - begin);
    return sum;
}

double area_of_corners(const Vector3& a, const Vector3& b, const Vector3& c) {
    return 0.5 * length3(cross(minus(b, a), minus(c, a)));
}

// Calls use(begin, end) for each run of equal elements.
template <class T, class Use>
void each_run(const std::vector<T>& sorted, const Use& use) {
    for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
        while (end < sorted.size() && sorted[end] == sorted[begin]) ++end;
        use(begin, end);
    }
}

std::array<std::int32_t, 3> sorted_corners(const std::array<std::int32_t, 3>& triangle) {
    return {triangle[0], std::min(triangle[1], triangle[2]), std::max(triangle[1], triangle[2])};
}

}  // namespace

Regions::Regions(SurfaceCells whole) : faces_(std::move(whole)) {
    std::int32_t count = 0;
    for (const std::int32_t pieces : faces_.pieces) count += pieces;
    is_cut_.assign(at(count), 0);
    connect();
    judge();
}

// Finds the side on the other face of each: the same part of an edge of the surface, or of a bisector in a triangle.
void Regions::connect() {
    struct Key {
        std::int32_t low, high, triangle;  // -1 for an edge
        std::uint32_t side;
        auto operator<=>(const Key&) const = default;
    };
    check_stop();
    std::vector<Key> keys;
    keys.reserve(faces_.corners.size());
    face_.resize(faces_.corners.size());
    for (std::size_t f = 0; f < faces_.polygon_pieces.size(); ++f) {
        const std::size_t begin = at(faces_.polygon_offsets[f]), end = at(faces_.polygon_offsets[f + 1]);
        std::fill(face_.begin() + static_cast<std::ptrdiff_t>(begin), face_.begin() + static_cast<std::ptrdiff_t>(end),
                  f);
        for (std::size_t s = begin; s < end; ++s) {
            const auto [low, high] = std::minmax({faces_.corners[s], faces_.corners[next(s)]});
            keys.push_back(
                {low, high, faces_.beyond[s] < 0 ? -1 : faces_.polygon_triangles[f], static_cast<std::uint32_t>(s)});
        }
    }
    std::ranges::sort(keys);
    other_.assign(keys.size(), crowded);
    for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
        const auto is_same = [&](const Key& key) {
            return std::tie(key.low, key.high, key.triangle) ==
                   std::tie(keys[begin].low, keys[begin].high, keys[begin].triangle);
        };
        while (end < keys.size() && is_same(keys[end])) ++end;
        if (end - begin == 1) other_[keys[begin].side] = border;
        if (end - begin == 2) {
            other_[keys[begin].side] = keys[begin + 1].side;
            other_[keys[begin + 1].side] = keys[begin].side;
        }
    }
}

void Regions::judge() {
    check_stop();
    const std::size_t count = is_cut_.size();
    areas_.assign(count, 0);
    counts_.assign(count, 0);
    is_exempt_.assign(count, 0);
    euler_.assign(count, 0);
    border_ends_.assign(count, 0);
    faults_.assign(count, 0);
    meetings_.clear(), ends_.clear(), closing_.clear(), triangles_.clear();
    count_sides();
    std::vector<std::uint8_t> is_seen(faces_.corners.size());
    for (std::size_t s = 0; s < is_seen.size(); ++s)
        if (is_seen[s] == 0) {
            walk_around(s, is_seen);
            meet();
        }
    std::ranges::stable_sort(meetings_, {}, sorted_corners);
    std::vector<std::uint8_t> has_triangle(count);
    for (std::size_t k = 0; k < meetings_.size(); ++k) {
        const auto& triangle = meetings_[k];
        if (k > 0 && sorted_corners(triangle) == sorted_corners(meetings_[k - 1])) {
            mark({triangle[0], triangle[1], triangle[2]});
            continue;
        }
        triangles_.insert(triangles_.end(), triangle.begin(), triangle.end());
        for (const std::int32_t region : triangle) has_triangle[at(region)] = 1;
    }
    mark_pairs();
    for (std::size_t r = 0; r < count; ++r) {
        if (euler_[r] != 1 || border_ends_[r] > 2 || has_triangle[r] == 0) faults_[r] |= faulty;
        if (is_exempt_[r] != 0) faults_[r] = 0;
    }
}

void Regions::count_sides() {
    for (std::size_t f = 0; f < faces_.polygon_pieces.size(); ++f) {
        const std::size_t region = at(faces_.polygon_pieces[f]);
        areas_[region] += faces_.polygon_areas[f];
        ++counts_[region];
        ++euler_[region];
        for (std::size_t s = at(faces_.polygon_offsets[f]); s < at(faces_.polygon_offsets[f + 1]); ++s) {
            if (other_[s] == crowded) is_exempt_[region] = 1;
            const bool is_counted =
                other_[s] >= 0 && at(other_[s]) < s && region_of(at(other_[s])) == faces_.polygon_pieces[f];
            if (!is_counted) --euler_[region];
        }
    }
}

// Lists the regions around a vertex, as the first face turns.
void Regions::walk_around(std::size_t first, std::vector<std::uint8_t>& is_seen) {
    const std::int32_t vertex = faces_.corners[first];
    // Goes on to the next face across a side, and to its other side at the vertex.
    const auto cross_side = [&](std::size_t& corner, std::size_t& side) {
        if (other_[side] < 0) return false;
        const std::size_t entered = at(other_[side]);
        const bool leads_from = faces_.corners[entered] == vertex;
        corner = leads_from ? entered : next(entered);
        side = leads_from ? before(entered) : next(entered);
        return true;
    };
    is_open_ = false;
    std::size_t corner = first, side = first;
    while (cross_side(corner, side))
        if (corner == first) break;
    is_open_ = other_[side] < 0;
    if (!is_open_) corner = first, side = first;
    const bool is_turned = side != corner;  // the walk runs against the first face
    side = is_turned ? corner : before(corner);
    around_.clear();
    const std::size_t start = corner;
    do {
        is_seen[corner] = 1;
        if (around_.empty() || around_.back() != region_of(corner)) around_.push_back(region_of(corner));
    } while (cross_side(corner, side) && corner != start);
    if (!is_open_ && around_.size() > 1 && around_.front() == around_.back()) around_.pop_back();
    if (is_turned) std::ranges::reverse(around_);
}

// Takes what the regions around a vertex share there.
void Regions::meet() {
    std::vector<std::int32_t> each = around_;
    std::ranges::sort(each);
    each_run(each, [&](std::size_t begin, std::size_t end) {
        ++euler_[at(each[begin])];
        if (end - begin > 1) faults_[at(each[begin])] |= faulty;
    });
    const std::size_t count = around_.size();
    if (is_open_ && count > 1) {
        ++border_ends_[at(around_.front())];
        ++border_ends_[at(around_.back())];
        closing_.push_back(std::minmax({around_.front(), around_.back()}));
    }
    if (count + (is_open_ ? 1 : 0) < 3) return;
    for (std::size_t k = is_open_ ? 1 : 0; k < count; ++k)
        ends_.push_back(std::minmax({around_[k == 0 ? count - 1 : k - 1], around_[k]}));
    std::ranges::rotate(around_, std::ranges::min_element(around_));
    for (std::size_t k = 1; k + 1 < count; ++k)  // a region that meets itself is at fault above
        if (around_[0] != around_[k] && around_[0] != around_[k + 1])
            meetings_.push_back({around_[0], around_[k], around_[k + 1]});
}

// Marks the largest of some regions that can be split.
void Regions::mark(std::initializer_list<std::int32_t> regions) {
    std::int32_t best = *regions.begin();
    const auto worth = [&](std::int32_t r) {
        return std::tuple(is_exempt_[at(r)] == 0, is_cut_[at(r)] == 0 || counts_[at(r)] > 1, areas_[at(r)]);
    };
    const bool has_exempt = std::ranges::any_of(regions, [&](std::int32_t r) { return is_exempt_[at(r)] != 0; });
    for (const std::int32_t r : regions)
        if (worth(r) > worth(best)) best = r;
    faults_[at(best)] |= has_exempt ? beside_crowd : faulty;
}

// Marks regions that share several curves, or an edge that has not two triangles, or one on the border.
void Regions::mark_pairs() {
    std::ranges::sort(ends_);
    each_run(ends_, [&](std::size_t begin, std::size_t end) {
        if (end - begin > 2) mark({ends_[begin].first, ends_[begin].second});
    });
    std::vector<std::pair<Pair, bool>> edges;  // and whether of a triangle
    for (const auto& [a, b, c] : meetings_)
        for (const auto& pair : {std::minmax({a, b}), std::minmax({b, c}), std::minmax({a, c})})
            edges.emplace_back(pair, true);
    for (const Pair& pair : closing_) edges.emplace_back(pair, false);
    std::ranges::sort(edges);
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        std::size_t triangles = 0;
        for (; end < edges.size() && edges[end].first == edges[begin].first; ++end)
            triangles += edges[end].second ? 1 : 0;
        if (end - begin != 2 || triangles == 0) mark({edges[begin].first.first, edges[begin].first.second});
    }
}

// Cuts the faces of faulty regions into triangles, unless they are.
void Regions::cut_faces() {
    SurfaceCells cut;
    cut.pieces = faces_.pieces;
    cut.vertices = std::move(faces_.vertices);
    cut.polygon_offsets.push_back(0);
    const auto add_face = [&](std::size_t f, double area) {
        cut.polygon_triangles.push_back(faces_.polygon_triangles[f]);
        cut.polygon_seeds.push_back(faces_.polygon_seeds[f]);
        cut.polygon_pieces.push_back(faces_.polygon_pieces[f]);
        cut.polygon_areas.push_back(area);
        cut.polygon_offsets.push_back(static_cast<std::int64_t>(cut.corners.size()));
    };
    for (std::size_t f = 0; f < faces_.polygon_pieces.size(); ++f) {
        const std::size_t region = at(faces_.polygon_pieces[f]);
        const std::size_t begin = at(faces_.polygon_offsets[f]), end = at(faces_.polygon_offsets[f + 1]);
        if (!is_split(region) || is_cut_[region] != 0) {
            for (std::size_t s = begin; s < end; ++s) {
                cut.corners.push_back(faces_.corners[s]);
                cut.beyond.push_back(faces_.beyond[s]);
            }
            add_face(f, faces_.polygon_areas[f]);
            continue;
        }
        std::swap(cut.vertices, faces_.vertices);
        const Vector3 middle = middle_of(faces_, f);
        std::swap(cut.vertices, faces_.vertices);
        const auto number = static_cast<std::int32_t>(cut.vertices.size() / 3);
        cut.vertices.insert(cut.vertices.end(), middle.begin(), middle.end());
        for (std::size_t s = begin; s < end; ++s) {
            const std::int32_t from = faces_.corners[s], to = faces_.corners[next(s)];
            const std::int32_t own = faces_.polygon_seeds[f];
            cut.corners.insert(cut.corners.end(), {from, to, number});
            cut.beyond.insert(cut.beyond.end(), {faces_.beyond[s], own, own});
            add_face(f, area_of_corners(vertex_at(cut, from), vertex_at(cut, to), middle));
        }
    }
    faces_ = std::move(cut);
    for (std::size_t r = 0; r < faults_.size(); ++r) is_cut_[r] |= is_split(r) ? 1 : 0;
    connect();
}

// Splits a region halfway between its faces farthest apart. Returns whether it has several.
bool Regions::bisect(std::int32_t region, const std::vector<std::size_t>& own) {
    if (own.size() < 2) return false;
    using Length = std::pair<double, std::uint32_t>;  // and the number of sides crossed
    std::vector<Vector3> middles;
    for (const std::size_t f : own) middles.push_back(middle_of(faces_, f));
    const auto index = [&](std::size_t f) {
        return static_cast<std::size_t>(std::ranges::lower_bound(own, f) - own.begin());
    };
    constexpr Length unreached{std::numeric_limits<double>::infinity(), 0};
    const auto lengths_from = [&](std::size_t start) {
        std::vector<Length> lengths(own.size(), unreached);
        std::priority_queue<std::pair<Length, std::size_t>, std::vector<std::pair<Length, std::size_t>>, std::greater<>>
            pending;
        lengths[start] = {0, 0};
        pending.push({lengths[start], start});
        while (!pending.empty()) {
            const auto [length, k] = pending.top();
            pending.pop();
            if (length > lengths[k]) continue;
            for (std::size_t s = at(faces_.polygon_offsets[own[k]]); s < at(faces_.polygon_offsets[own[k] + 1]); ++s) {
                if (other_[s] < 0 || region_of(at(other_[s])) != region) continue;
                const std::size_t to = index(face_[at(other_[s])]);
                const Length way{length.first + distance(middles[k], middles[to]), length.second + 1};
                if (!(way < lengths[to])) continue;
                lengths[to] = way;
                pending.push({way, to});
            }
        }
        return lengths;
    };
    const auto farthest = [](const std::vector<Length>& lengths) {
        return static_cast<std::size_t>(std::ranges::max_element(lengths) - lengths.begin());
    };
    const std::size_t a = farthest(lengths_from(0));
    const auto from_a = lengths_from(a);
    const std::size_t b = farthest(from_a);
    const auto from_b = lengths_from(b);
    const auto added = static_cast<std::int32_t>(is_cut_.size());
    is_cut_.push_back(1);
    for (std::size_t k = 0; k < own.size(); ++k)
        if (from_b[k] < from_a[k]) faces_.polygon_pieces[own[k]] = added;
    return true;
}

void Regions::split(std::size_t max) {
    const auto is_faulty = [](std::uint8_t fault) { return (fault & faulty) != 0; };
    while (is_cut_.size() < max && std::ranges::any_of(faults_, is_faulty)) {
        cut_faces();
        const std::size_t count = faults_.size();
        std::vector<std::vector<std::size_t>> own(count);
        for (std::size_t f = 0; f < faces_.polygon_pieces.size(); ++f)
            if (const std::size_t region = at(faces_.polygon_pieces[f]); is_split(region)) own[region].push_back(f);
        bool is_any = false;
        for (std::size_t r = 0; r < count && is_cut_.size() < max; ++r)
            is_any |= bisect(static_cast<std::int32_t>(r), own[r]);
        if (!is_any) return;
        judge();
    }
}

}  // namespace votess::surface
