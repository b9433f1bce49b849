#include "mesh/joined_corners.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "core/text.hpp"
#include "input/option_name.hpp"
#include "mesh/vertex_sets.hpp"

namespace votess {
namespace {

using detail::Result;

// A corner of a polygon: a vertex, and the set it belongs to now.
struct Place {
    std::int32_t vertex;
    std::uint32_t root;
    exact::Shift shift;
    [[nodiscard]] bool same(const Place& other) const { return root == other.root && shift == other.shift; }
};

// A cell at a set of vertices, and one of its faces there; or no face, for the cell alone.
struct Meeting {
    std::uint32_t root;
    std::int32_t cell;
    exact::Shift shift;  // of the cell
    std::int64_t entry;
    friend auto operator<=>(const Meeting&, const Meeting&) = default;
};
constexpr std::int64_t no_face = -1;

class Joiner {
public:
    explicit Joiner(const Result& result) : r_(result), sets_(vertices()) {
        sets_.init(0, vertices());
        for (std::size_t v = 0; v < r_.vertex_image_of.size(); ++v)
            sets_.unite(static_cast<std::uint32_t>(v), static_cast<std::uint32_t>(r_.vertex_image_of[v]),
                        wide(shift_in(r_.vertex_shifts, v, 1, dimensions_of(r_))));
    }

    // False when there is nothing to join.
    bool join() {
        if (r_.planar)
            find_ends();
        else
            find_near();
        mark_touched();
        if (std::ranges::find(touched_, true) == touched_.end()) return false;
        while (!pairs_.empty() || (!r_.planar && find_more())) {
            for (const auto& [a, b] : pairs_) join(a, b);
            pairs_.clear();
        }
        check_faces();
        return true;
    }

    [[nodiscard]] Place place(std::int32_t vertex) {
        const ShiftedVertex found = sets_.find(static_cast<std::uint32_t>(vertex));
        return {vertex, found.vertex, found.shift};
    }

private:
    static exact::Shift wide(const ByteShift& s) { return {s[0], s[1], s[2]}; }
    [[nodiscard]] std::size_t vertices() const { return r_.vertices.size() / dimensions_of(r_); }
    [[nodiscard]] std::size_t dropped() const { return r_.dropped_offsets.size() - 1; }
    static std::span<const std::int32_t> polygon(std::span<const std::int64_t> offsets,
                                                 std::span<const std::int32_t> corners, std::size_t f) {
        return corners.subspan(at(offsets[f]), at(offsets[f + 1] - offsets[f]));
    }

    [[noreturn]] void refuse(const std::string& what) const {
        throw Error(ErrorCode::invalid_argument,
                    (r_.planar ? "delaunay(): edges below a length of " : "delaunay(): faces below an area of ") +
                        number(r_.least_face) + " were dropped, and without them " + what + ": give a smaller " +
                        option("min_face") + " or " + option("min_area"));
    }

    // A vertex may be joined when a dropped face has it or an image of it, or an edge that is short.
    void mark_touched() {
        touched_.assign(vertices(), false);
        for (const std::int32_t v : r_.dropped_vertices) touched_[place(v).root] = true;
        for (const auto& [a, b] : pairs_) touched_[place(a).root] = touched_[place(b).root] = true;
        for (std::size_t v = 0; v < vertices(); ++v)
            touched_[v] = touched_[place(static_cast<std::int32_t>(v)).root];  // at most v
    }

    [[nodiscard]] double distance2(std::int32_t a, std::int32_t b) const {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double d = r_.vertices[3 * at(a) + k] - r_.vertices[3 * at(b) + k];
            sum += d * d;
        }
        return sum;
    }

    // Joins two corners of one polygon.
    void join(std::int32_t a, std::int32_t b) {
        const Place one = place(a), other = place(b);
        if (one.root == other.root && one.shift != other.shift)
            refuse("vertex " + std::to_string(one.root) + " would meet its own image");
        sets_.unite(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), {});
    }

    // In the plane a dropped edge shrinks to a point.
    void find_ends() {
        for (std::size_t f = 0; f < dropped(); ++f)
            pairs_.emplace_back(r_.dropped_vertices[2 * f], r_.dropped_vertices[2 * f + 1]);
    }
    // Ends of short edges: beside one, a face of the same length has an area that is dropped.
    void find_near() {
        for (std::size_t f = 0; f < dropped(); ++f) add_near(polygon(r_.dropped_offsets, r_.dropped_vertices, f));
        for (std::size_t entry = 0; entry < r_.indices.size(); ++entry)
            if (r_.indices[entry] >= 0) add_near(polygon(r_.face_offsets, r_.face_vertices, entry));
    }
    void add_near(std::span<const std::int32_t> corners) {
        if (reaches_infinity(corners)) return;
        double around = 0;
        for_edges(corners, [&](std::int32_t a, std::int32_t b) { around += std::sqrt(distance2(a, b)); });
        const double most = r_.least_face / (around / 2);
        for_edges(corners, [&](std::int32_t a, std::int32_t b) {
            if (distance2(a, b) <= most * most) pairs_.emplace_back(a, b);
        });
    }
    static bool reaches_infinity(std::span<const std::int32_t> corners) {
        return !corners.empty() && corners.back() < 0;
    }
    static void for_edges(std::span<const std::int32_t> corners, const auto& visit) {
        for (std::size_t k = 0; k < corners.size(); ++k) visit(corners[k], corners[(k + 1) % corners.size()]);
    }

    bool find_more() {
        for (std::size_t f = 0; f < dropped(); ++f) shrink(polygon(r_.dropped_offsets, r_.dropped_vertices, f));
        if (pairs_.empty()) join_false_corners();
        return !pairs_.empty();
    }

    // Returns the polygon after joins: equal corners are one, and a detour to a corner and back is removed. A polygon
    // that collapsed has one corner.
    std::span<const Place> reduced(std::span<const std::int32_t> corners) {
        word_.clear();
        for (const std::int32_t v : corners) {
            const Place p = place(v);
            if (!word_.empty() && word_.back().same(p)) continue;
            if (word_.size() > 1 && word_[word_.size() - 2].same(p))
                word_.pop_back();
            else
                word_.push_back(p);
        }
        std::size_t begin = 0, end = word_.size();
        while (end - begin > 1) {
            if (word_[begin].same(word_[end - 1]))
                --end;
            else if (end - begin > 2 && word_[begin].same(word_[end - 2]))
                end -= 2;
            else if (end - begin > 2 && word_[begin + 1].same(word_[end - 1]))
                ++begin;
            else if (end - begin == 2)
                --end;
            else
                break;
        }
        return std::span(word_).subspan(begin, end - begin);
    }

    // A dropped face that still has an area loses its shortest edge.
    void shrink(std::span<const std::int32_t> corners) {
        const std::span<const Place> left = reduced(corners);
        if (left.size() < 3) return;
        double nearest = std::numeric_limits<double>::infinity();
        std::pair<std::int32_t, std::int32_t> pair;
        for_edges(corners, [&](std::int32_t a, std::int32_t b) {
            const Place from = place(a), to = place(b);
            bool is_left = false;
            for (std::size_t k = 0; k < left.size(); ++k)
                is_left |= left[k].same(from) && left[(k + 1) % left.size()].same(to);
            if (const double d = distance2(a, b); is_left && d < nearest) nearest = d, pair = {a, b};
        });
        pairs_.push_back(pair);
    }

    // A set where a cell has but two faces lies within an edge of that cell: it joins the nearest one along a dropped
    // face.
    void join_false_corners() {
        find_meetings();
        std::vector<std::uint32_t> false_corners;
        for (auto begin = meetings_.begin(); begin != meetings_.end();) {
            const auto end =
                std::find_if(begin, meetings_.end(), [&](const Meeting& m) { return m.root != begin->root; });
            bool on_wall = false, is_false = false;
            for (auto cell = begin; cell != end;) {
                const auto next = std::find_if(
                    cell, end, [&](const Meeting& m) { return m.cell != cell->cell || m.shift != cell->shift; });
                constexpr std::ptrdiff_t least = 3;
                is_false |= next - cell - 1 < least;  // the first has no face
                for (; cell != next; ++cell) on_wall |= cell->entry != no_face && r_.indices[at(cell->entry)] < 0;
            }
            if (is_false && !on_wall) false_corners.push_back(begin->root);
            begin = end;
        }
        if (false_corners.empty()) return;
        struct Nearest {
            double distance2 = std::numeric_limits<double>::infinity();
            std::pair<std::int32_t, std::int32_t> pair;
        };
        std::vector<Nearest> nearest(false_corners.size());
        for (std::size_t f = 0; f < dropped(); ++f) {
            for_edges(polygon(r_.dropped_offsets, r_.dropped_vertices, f), [&](std::int32_t a, std::int32_t b) {
                const Place one = place(a), other = place(b);
                if (one.same(other)) return;
                const double d = distance2(a, b);
                for (const std::uint32_t root : {one.root, other.root}) {
                    const auto found = std::ranges::lower_bound(false_corners, root);
                    if (found == false_corners.end() || *found != root) continue;
                    Nearest& best = nearest[static_cast<std::size_t>(found - false_corners.begin())];
                    if (d < best.distance2) best = {d, {a, b}};
                }
            });
        }
        for (std::size_t k = 0; k < nearest.size(); ++k) {
            if (nearest[k].distance2 == std::numeric_limits<double>::infinity())
                refuse("vertex " + std::to_string(false_corners[k]) + " is no corner of one of its cells");
            pairs_.push_back(nearest[k].pair);
        }
    }

    // At the sets that are touched.
    void find_meetings() {
        meetings_.clear();
        const auto add = [&](std::int32_t v, std::size_t cell, std::int64_t entry) {
            if (v < 0 || !touched_[at(v)]) return;
            const Place p = place(v);
            meetings_.push_back({p.root, static_cast<std::int32_t>(cell), VertexSets::negative(p.shift), entry});
        };
        for (std::size_t i = 0; i < r_.status.size(); ++i) {
            for (auto k = at(r_.cell_vertex_indptr[i]); k < at(r_.cell_vertex_indptr[i + 1]); ++k)
                add(r_.cell_vertex_indices[k], i, no_face);
            for (auto entry = at(r_.indptr[i]); entry < at(r_.indptr[i + 1]); ++entry)
                for (const std::int32_t v : polygon(r_.face_offsets, r_.face_vertices, entry))
                    add(v, i, static_cast<std::int64_t>(entry));
        }
        std::ranges::sort(meetings_);
        const auto rest = std::ranges::unique(meetings_);
        meetings_.erase(rest.begin(), rest.end());
    }

    [[nodiscard]] bool is_point(std::span<const std::int32_t> edge) {
        return edge[0] >= 0 && edge[1] >= 0 && place(edge[0]).same(place(edge[1]));
    }
    void check_faces() {
        for (std::size_t i = 0; i < r_.status.size(); ++i)
            for (auto entry = at(r_.indptr[i]); entry < at(r_.indptr[i + 1]); ++entry) {
                const auto corners = polygon(r_.face_offsets, r_.face_vertices, entry);
                const auto is_touched = [&](std::int32_t v) { return touched_[at(v)]; };
                if (r_.indices[entry] < 0 || reaches_infinity(corners) || std::ranges::none_of(corners, is_touched))
                    continue;
                if (r_.planar ? is_point(corners) : reduced(corners).size() < 3)
                    refuse("the " + std::string(r_.planar ? "edge" : "face") + " between cells " + std::to_string(i) +
                           " and " + std::to_string(r_.indices[entry]) +
                           (r_.planar ? " has no length either" : " has no area either"));
            }
    }

    const Result& r_;
    VertexSets sets_;
    std::vector<bool> touched_;                                 // by vertex
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs_;  // to join
    std::vector<Place> word_;
    std::vector<Meeting> meetings_;
};

}  // namespace

JoinedCorners::JoinedCorners(const Result& result) : result_(result) {
    if (result.dropped_offsets.empty()) return;
    Joiner joiner(result);
    if (!joiner.join()) return;
    const std::size_t vertices = result.vertices.size() / dimensions_of(result);
    originals_.resize(vertices);
    shifts_.resize(vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
        const Place place = joiner.place(static_cast<std::int32_t>(v));
        originals_[v] = static_cast<std::int32_t>(place.root);
        for (std::size_t k = 0; k < 3; ++k) shifts_[v][k] = static_cast<std::int8_t>(place.shift[k]);
    }
}

}  // namespace votess
