#include "unbounded/open_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/scrambled.hpp"
#include "core/vector3.hpp"
#include "result/arrays.hpp"

namespace votess {
namespace {

using detail::Result;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t rows_per_check = 4096;

std::size_t at(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

std::span<const std::int32_t> polygon_of(const Result& r, std::size_t entry) {
    const std::span<const std::int32_t> all = r.face_vertices;
    return all.subspan(at(r.face_offsets[entry]), at(r.face_offsets[entry + 1] - r.face_offsets[entry]));
}

std::span<const std::int32_t> vertices_of(const Result& r, std::size_t row) {
    const std::span<const std::int32_t> all = r.cell_vertex_indices;
    return all.subspan(at(r.cell_vertex_indptr[row]), at(r.cell_vertex_indptr[row + 1] - r.cell_vertex_indptr[row]));
}

Vector3 position(const Result& r, std::int32_t vertex) {
    return {r.vertices[3 * at(vertex)], r.vertices[3 * at(vertex) + 1], r.vertices[3 * at(vertex) + 2]};
}

double area_of(const Result& r, std::span<const std::int32_t> polygon) {
    const Vector3 first = position(r, polygon[0]);
    Vector3 doubled{};
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
        const Vector3 part = cross(minus(position(r, polygon[k]), first), minus(position(r, polygon[k + 1]), first));
        for (std::size_t i = 0; i < 3; ++i) doubled[i] += part[i];
    }
    return 0.5 * std::hypot(doubled[0], doubled[1], doubled[2]);
}

template <class T>
void put(Buffer<T>& to, const std::vector<T>& from) {
    to.resize_uninitialized(from.size());
    std::ranges::copy(from, to.begin());
}

// The arrays of rows, as they grow.
class NewRows {
public:
    explicit NewRows(const Result& like)
        : areas_wanted_(!like.face_areas.empty()),
          normals_wanted_(!like.face_normals.empty()),
          polygons_wanted_(!like.face_offsets.empty()),
          vertices_wanted_(!like.cell_vertex_indptr.empty()) {
        indptr_.reserve(like.indptr.size());
        indices_.reserve(like.indices.size());
        if (areas_wanted_) areas_.reserve(like.indices.size());
        if (normals_wanted_) normals_.reserve(3 * like.indices.size());
    }

    // Copies an entry under another id; polygon() follows where polygons are wanted.
    void add(const Result& from, std::size_t entry, std::int32_t id) {
        indices_.push_back(id);
        if (areas_wanted_) areas_.push_back(from.face_areas[entry]);
        if (normals_wanted_)
            normals_.insert(normals_.end(), &from.face_normals[3 * entry], &from.face_normals[3 * entry] + 3);
    }
    void add_infinity(std::int32_t id) {
        indices_.push_back(id);
        if (areas_wanted_) areas_.push_back(infinity);
        if (normals_wanted_) normals_.insert(normals_.end(), 3, not_a_number);
        if (polygons_wanted_) face_offsets_.push_back(static_cast<std::int64_t>(face_vertices_.size()));
    }
    void set_area(double area) {
        if (areas_wanted_) areas_.back() = area;
    }
    // number: of each vertex of the polygon; -1 stays.
    void polygon(std::span<const std::int32_t> polygon, std::span<const std::int32_t> number) {
        if (!polygons_wanted_) return;
        for (const std::int32_t v : polygon) face_vertices_.push_back(v < 0 ? v : number[at(v)]);
        face_offsets_.push_back(static_cast<std::int64_t>(face_vertices_.size()));
    }
    // Vertices without a number are left out. The others ascend if `number` does.
    void end_row(std::span<const std::int32_t> vertices, std::span<const std::int32_t> number) {
        indptr_.push_back(static_cast<std::int64_t>(indices_.size()));
        if (!vertices_wanted_) return;
        const std::ptrdiff_t begin = std::ssize(cell_vertices_);
        for (const std::int32_t v : vertices)
            if (number[at(v)] >= 0) cell_vertices_.push_back(number[at(v)]);
        std::sort(cell_vertices_.begin() + begin, cell_vertices_.end());
        cell_vertex_indptr_.push_back(std::ssize(cell_vertices_));
    }
    void move_into(Result& result) {
        put(result.indptr, indptr_);
        put(result.indices, indices_);
        if (areas_wanted_) put(result.face_areas, areas_);
        if (normals_wanted_) put(result.face_normals, normals_);
        if (polygons_wanted_) {
            put(result.face_offsets, face_offsets_);
            put(result.face_vertices, face_vertices_);
        }
        if (vertices_wanted_) {
            put(result.cell_vertex_indptr, cell_vertex_indptr_);
            put(result.cell_vertex_indices, cell_vertices_);
        }
    }
    [[nodiscard]] std::size_t entries() const { return indices_.size(); }

private:
    bool areas_wanted_, normals_wanted_, polygons_wanted_, vertices_wanted_;
    std::vector<std::int64_t> indptr_{0}, face_offsets_{0}, cell_vertex_indptr_{0};
    std::vector<std::int32_t> indices_, face_vertices_, cell_vertices_;
    std::vector<double> areas_, normals_;
};

// The polygon without its corners at infinity, and -1 behind the last corner if there were some.
void cut_infinity(std::span<const std::int32_t> polygon, const std::vector<bool>& at_infinity,
                  std::vector<std::int32_t>& out) {
    out.clear();
    const std::size_t size = polygon.size();
    const auto is_infinite = [&](std::size_t k) { return at_infinity[at(polygon[k % size])]; };
    std::size_t first = 0;  // follows the corners at infinity
    while (first < size && !(is_infinite(first + size - 1) && !is_infinite(first))) ++first;
    bool open = false;
    for (std::size_t k = first; k < first + size; ++k)
        is_infinite(k) ? void(open = true) : out.push_back(polygon[k % size]);
    if (open) out.push_back(-1);
}

// Numbers edges of a cell, those at infinity left out.
std::uint32_t count_edges(const Result& r, std::size_t row, const EndlessSides& sides) {
    std::vector<std::uint64_t> of_infinity;
    std::size_t ends = 0;
    const auto for_edges = [&](bool infinite, const auto& use) {
        for (auto e = at(r.indptr[row]); e < at(r.indptr[row + 1]); ++e) {
            if (sides.has(r.indices[e]) != infinite) continue;
            const auto polygon = polygon_of(r, e);
            for (std::size_t k = 0; k < polygon.size(); ++k) {
                const std::uint64_t from = at(polygon[k]), to = at(polygon[k + 1 == polygon.size() ? 0 : k + 1]);
                use(from, to);
            }
        }
    };
    for_edges(true, [&](std::uint64_t from, std::uint64_t to) { of_infinity.push_back(to << 32 | from); });
    std::ranges::sort(of_infinity);
    for_edges(false, [&](std::uint64_t from, std::uint64_t to) {
        if (!std::ranges::binary_search(of_infinity, from << 32 | to)) ++ends;
    });
    return static_cast<std::uint32_t>(ends / 2);
}

void set_open(Result& r, std::size_t row) {
    if (!r.volumes.empty()) r.volumes[row] = infinity;
    for (std::size_t k = 0; k < 3 && !r.centroids.empty(); ++k) r.centroids[3 * row + k] = not_a_number;
    if (!r.surface_areas.empty()) r.surface_areas[row] = infinity;
    if (!r.security_radii.empty()) r.security_radii[row] = infinity;
}

void set_endless_stats(Result& r, const Box& box, std::uint64_t faces) {
    r.box = box;
    Stats& stats = r.stats;
    stats.faces = faces;
    const std::uint64_t cells = r.status.size() - stats.empty_cells;
    stats.mean_faces = cells == 0 ? 0 : static_cast<double>(faces) / static_cast<double>(cells);
    stats.box_volume = infinity;
    stats.volume_sum = 0;
    for (const double volume : r.volumes) stats.volume_sum += volume;
    stats.tiny_faces.reset();
}

// Keeps only the vertices with a number, which ascend with the vertices.
void renumber_vertices(Buffer<double>& vertices, std::span<const std::int32_t> number) {
    std::size_t kept = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] < 0) continue;
        for (std::size_t k = 0; k < 3; ++k) vertices[3 * kept + k] = vertices[3 * v + k];
        ++kept;
    }
    vertices.resize_uninitialized(3 * kept);
}

}  // namespace

void open_cells(Result& r, const Box& box) {
    const EndlessSides sides(box);
    const bool has_polygons = !r.face_offsets.empty();
    std::vector<bool> at_infinity(r.vertices.size() / 3);
    for (std::size_t e = 0; has_polygons && e < r.indices.size(); ++e)
        if (sides.has(r.indices[e]))
            for (const std::int32_t v : polygon_of(r, e)) at_infinity[at(v)] = true;
    std::vector<std::int32_t> number(at_infinity.size(), -1);
    std::int32_t vertices = 0;
    for (std::size_t v = 0; v < number.size(); ++v)
        if (!at_infinity[v]) number[v] = vertices++;

    NewRows rows(r);
    std::vector<std::int32_t> corners;
    for (std::size_t i = 0; i < r.status.size(); ++i) {
        if (i % rows_per_check == 0) check_stop();
        const std::size_t begin = at(r.indptr[i]), end = at(r.indptr[i + 1]);
        bool open = false, listed = false;
        for (std::size_t e = begin; e < end; ++e) open = open || sides.has(r.indices[e]);
        for (std::size_t e = begin; e < end; ++e) {
            const std::int32_t id = r.indices[e];
            if (open && !listed && id >= sides.id()) rows.add_infinity(sides.id()), listed = true;
            if (sides.has(id)) continue;
            rows.add(r, e, id);
            if (!has_polygons) continue;
            cut_infinity(polygon_of(r, e), at_infinity, corners);
            if (open) rows.set_area(corners.empty() || corners.back() == -1 ? infinity : area_of(r, corners));
            rows.polygon(corners, number);
        }
        if (open && !listed) rows.add_infinity(sides.id());
        const auto of_cell = has_polygons ? vertices_of(r, i) : std::span<const std::int32_t>();
        rows.end_row(of_cell, number);
        if (!open) continue;
        set_open(r, i);
        if (r.face_counts.empty() || !has_polygons) continue;
        r.edge_counts[i] = count_edges(r, i, sides);
        r.vertex_counts[i] = static_cast<std::uint32_t>(
            std::ranges::count_if(of_cell, [&](std::int32_t v) { return number[at(v)] >= 0; }));
    }
    rows.move_into(r);
    for (std::size_t i = 0; i < r.face_counts.size(); ++i)
        r.face_counts[i] = static_cast<std::uint32_t>(r.indptr[i + 1] - r.indptr[i]);
    if (has_polygons) renumber_vertices(r.vertices, number);
    r.lists_walls = true;
    set_endless_stats(r, box, rows.entries());
}

namespace {

// The vertices of both results in the joined one.
class JoinedVertices {
public:
    JoinedVertices(const Result& near, const Result& far, std::span<const std::int32_t> rows,
                   const std::vector<bool>& taken, const Box& box)
        : near_number_(near.vertices.size() / 3, -1), far_number_(far.vertices.size() / 3, -1) {
        if (near.cell_vertex_indptr.empty()) return;
        // A vertex of taken and of other cells is known by the seeds of `far` around it.
        std::vector<bool> of_taken(near_number_.size()), of_other(near_number_.size());
        for (std::size_t i = 0; i < near.status.size(); ++i)
            for (const std::int32_t v : vertices_of(near, i)) (taken[i] ? of_taken : of_other)[at(v)] = true;
        for (std::size_t v = 0; v < near_number_.size(); ++v)
            if (of_other[v]) near_number_[v] = count_++;
        std::vector<std::uint64_t> near_key(near_number_.size()), far_key(far_number_.size());
        std::vector<bool> far_taken(far_number_.size()), far_other(far_number_.size());
        for (std::size_t k = 0; k < rows.size(); ++k) {
            const std::size_t i = at(rows[k]);
            for (const std::int32_t v : vertices_of(near, i))
                near_key[at(v)] += scrambled(i);  // so that sums of few differ
            for (const std::int32_t v : vertices_of(far, k)) {
                far_key[at(v)] += scrambled(i);
                (taken[i] ? far_taken : far_other)[at(v)] = true;
            }
        }
        std::unordered_multimap<std::uint64_t, std::int32_t> by_key;
        for (std::size_t v = 0; v < near_number_.size(); ++v)
            if (of_taken[v] && of_other[v]) by_key.emplace(near_key[v], static_cast<std::int32_t>(v));
        const EndlessSides sides(box);
        for (std::size_t v = 0; v < far_number_.size(); ++v) {
            if (!far_taken[v]) continue;
            if (!far_other[v]) {
                far_number_[v] = count_++;
                new_vertices_.push_back(static_cast<std::int32_t>(v));
                continue;
            }
            // Two vertices on walls with ends may have the same seeds.
            double least = infinity;
            const auto [first, last] = by_key.equal_range(far_key[v]);
            for (auto match = first; match != last; ++match) {
                const Vector3 d = minus(position(near, match->second), position(far, static_cast<std::int32_t>(v)));
                double distance = 0;
                for (std::size_t k = 0; k < 3; ++k)
                    if (sides.has_end(k)) distance = std::max(distance, std::abs(d[k]));
                if (distance < least) least = distance, far_number_[v] = near_number_[at(match->second)];
            }
            if (far_number_[v] < 0)
                throw Error(ErrorCode::internal,
                            "a bug in votess: a vertex of cells that reach infinity is in no other cell");
        }
    }

    [[nodiscard]] std::span<const std::int32_t> near() const { return near_number_; }
    [[nodiscard]] std::span<const std::int32_t> far() const { return far_number_; }
    void place(Result& joined, const Result& far) const {
        if (joined.cell_vertex_indptr.empty()) return;
        renumber_vertices(joined.vertices, near_number_);
        Buffer<double> all;
        all.resize_uninitialized(3 * at(count_));
        double* to = std::ranges::copy(joined.vertices, all.begin()).out;
        for (const std::int32_t v : new_vertices_) to = std::ranges::copy(position(far, v), to).out;
        joined.vertices = std::move(all);
    }

private:
    std::vector<std::int32_t> near_number_, far_number_;  // -1: not in the joined result
    std::vector<std::int32_t> new_vertices_;              // of `far`, in the order of their numbers
    std::int32_t count_ = 0;
};

}  // namespace

Result join_cells(Result&& near, const Result& far, std::span<const std::int32_t> rows, const std::vector<bool>& taken,
                  std::span<const std::int32_t> names, const Box& box) {
    const JoinedVertices vertices(near, far, rows, taken, box);
    const bool has_polygons = !near.face_offsets.empty();
    NewRows joined(near);
    std::size_t next = 0;  // among the far rows
    std::uint64_t empty_cells = near.stats.empty_cells;
    for (std::size_t i = 0; i < near.status.size(); ++i) {
        if (i % rows_per_check == 0) check_stop();
        if (!taken[i]) {
            for (auto e = at(near.indptr[i]); e < at(near.indptr[i + 1]); ++e) {
                joined.add(near, e, near.indices[e]);
                if (has_polygons) joined.polygon(polygon_of(near, e), vertices.near());
            }
            joined.end_row(has_polygons ? vertices_of(near, i) : std::span<const std::int32_t>(), vertices.near());
            continue;
        }
        while (at(rows[next]) != i) ++next;
        const std::size_t k = next;
        for (auto e = at(far.indptr[k]); e < at(far.indptr[k + 1]); ++e) {
            const std::int32_t id = far.indices[e];
            joined.add(far, e, id < 0 || names.empty() ? id : names[at(id)]);
            if (has_polygons) joined.polygon(polygon_of(far, e), vertices.far());
        }
        joined.end_row(has_polygons ? vertices_of(far, k) : std::span<const std::int32_t>(), vertices.far());
        empty_cells += (far.status[k] == CellStatus::empty) - (near.status[i] == CellStatus::empty);
        detail::copy_cell(near, i, far, k);
    }
    joined.move_into(near);
    vertices.place(near, far);
    near.lists_walls = true;
    near.stats.empty_cells = empty_cells;
    near.stats.exact_cells += far.stats.exact_cells;
    set_endless_stats(near, box, joined.entries());
    return std::move(near);
}

}  // namespace votess
