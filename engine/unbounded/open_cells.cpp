#include "unbounded/open_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <type_traits>
#include <unordered_map>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "result/arrays.hpp"

namespace votess {
namespace {

using detail::Result;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t rows_per_check = 4096;

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

template <class T>
void put(Buffer<T>& to, const std::vector<T>& from) {
    to.resize_uninitialized(from.size());
    std::ranges::copy(from, to.begin());
}

// The arrays of rows, as they grow.
class NewRows {
public:
    // other: a result of the same arrays. Either may have no entries, and then no areas and normals.
    explicit NewRows(const Result& like, const Result& other = {})
        : areas_wanted_(!like.face_areas.empty() || !other.face_areas.empty()),
          normals_wanted_(!like.face_normals.empty() || !other.face_normals.empty()),
          shifts_wanted_(like.periodic != std::array<bool, 3>{}),
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
        if (shifts_wanted_) shifts_.insert(shifts_.end(), &from.shifts[3 * entry], &from.shifts[3 * entry] + 3);
    }
    void add_infinity(std::int32_t id) {
        indices_.push_back(id);
        if (areas_wanted_) areas_.push_back(infinity);
        if (normals_wanted_) normals_.insert(normals_.end(), 3, not_a_number);
        if (shifts_wanted_) shifts_.insert(shifts_.end(), 3, 0);
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
        if (shifts_wanted_) put(result.shifts, shifts_);
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
    bool areas_wanted_, normals_wanted_, shifts_wanted_, polygons_wanted_, vertices_wanted_;
    std::vector<std::int64_t> indptr_{0}, face_offsets_{0}, cell_vertex_indptr_{0};
    std::vector<std::int32_t> indices_, face_vertices_, cell_vertices_;
    std::vector<std::int8_t> shifts_;
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

void set_endless_stats(Result& r, const Region& domain, std::uint64_t faces) {
    r.box = domain.box.value_or(Box{});
    r.cell = domain.cell;
    if (domain.cell) {
        const auto axes = endless_axes(domain);
        for (std::size_t k = 0; k < 3; ++k) {
            r.box.lower[k] = r.box.upper[k] = domain.cell->origin[k];
            for (const auto& v : {domain.cell->a, domain.cell->b, domain.cell->c})
                (v[k] < 0 ? r.box.lower[k] : r.box.upper[k]) += v[k];
            if (std::ranges::find(axes, static_cast<int>(k)) == axes.end()) continue;
            r.box.lower[k] = -infinity;
            r.box.upper[k] = infinity;
        }
    }
    Stats& stats = r.stats;
    stats.faces = faces;
    const std::uint64_t cells = r.status.size() - stats.empty_cells;
    stats.mean_faces = cells == 0 ? 0 : static_cast<double>(faces) / static_cast<double>(cells);
    stats.box_volume = infinity;
    stats.volume_sum = 0;
    for (const double volume : r.volumes) stats.volume_sum += volume;
    stats.tiny_faces.reset();
}

std::size_t original_of(const Result& r, std::size_t vertex) {
    return r.vertex_image_of.empty() ? vertex : at(r.vertex_image_of[vertex]);
}

// The vertices on sides at infinity, by number. One that a cell with an end touches is a vertex of the diagram.
std::vector<bool> find_infinite(const Result& r, const EndlessSides& sides) {
    std::vector<bool> on_side(r.vertices.size() / 3), of_closed(on_side.size());
    for (std::size_t i = 0; i < r.status.size(); ++i) {
        bool open = false;
        for (auto e = at(r.indptr[i]); e < at(r.indptr[i + 1]); ++e) {
            if (!sides.has(r.indices[e])) continue;
            open = true;
            for (const std::int32_t v : polygon_of(r, e)) on_side[original_of(r, at(v))] = true;
        }
        if (open) continue;
        for (const std::int32_t v : vertices_of(r, i)) of_closed[original_of(r, at(v))] = true;
    }
    std::vector<bool> infinite(on_side.size());
    for (std::size_t v = 0; v < infinite.size(); ++v)
        infinite[v] = on_side[original_of(r, v)] && !of_closed[original_of(r, v)];
    return infinite;
}

}  // namespace

void open_cells(Result& r, const Region& domain) {
    const EndlessSides sides(domain);
    const bool has_polygons = !r.face_offsets.empty();
    const std::vector<bool> at_infinity = has_polygons ? find_infinite(r, sides) : std::vector<bool>();
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
            if (corners.empty() || corners.back() == -1) rows.set_area(infinity);
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
    if (has_polygons) detail::keep_vertices(r, number);
    r.lists_walls = true;
    set_endless_stats(r, domain, rows.entries());
}

namespace {

// The vertices of the joined result: all of the near one, which are those of the diagram there, then others of taken
// cells. A cell has a vertex by the faces that meet there, which are the same in both results.
class JoinedVertices {
public:
    JoinedVertices(const Result& near, const Result& far, std::span<const std::int32_t> rows,
                   const std::vector<bool>& taken, std::span<const std::int32_t> names)
        : near_number_(near.vertices.size() / 3), far_number_(far.vertices.size() / 3, -1) {
        if (near.cell_vertex_indptr.empty()) return;
        std::iota(near_number_.begin(), near_number_.end(), 0);
        std::vector<bool> of_other(far_number_.size());
        for (std::size_t k = 0; k < rows.size(); ++k)
            if (!taken[at(rows[k])])
                for (const std::int32_t v : vertices_of(far, k)) of_other[at(v)] = true;
        const auto same_name = [](std::int32_t id) { return id; };
        const auto far_name = [&](std::int32_t id) { return id < 0 || names.empty() ? id : names[at(id)]; };
        const auto match = [&](std::size_t k) {
            const std::vector<Corner> here = corners(near, at(rows[k]), same_name), there = corners(far, k, far_name);
            for (std::size_t c = 0, n = 0; c < there.size(); ++c) {
                while (n < here.size() && here[n].faces < there[c].faces) ++n;
                std::int32_t& number = far_number_[at(there[c].vertex)];
                if (n < here.size() && here[n].faces == there[c].faces) number = here[n].vertex;
            }
        };
        std::vector<bool> of_taken(far_number_.size());
        for (std::size_t k = 0; k < rows.size(); ++k)
            if (taken[at(rows[k])]) {
                match(k);
                for (const std::int32_t v : vertices_of(far, k)) of_taken[at(v)] = true;
            }
        // A vertex on an end of the near box lacks faces in taken cells there, and has all of them in others.
        for (std::size_t k = 0; k < rows.size(); ++k)
            if (!taken[at(rows[k])] && std::ranges::any_of(vertices_of(far, k), [&](std::int32_t v) {
                    return of_taken[at(v)] && far_number_[at(v)] < 0;
                }))
                match(k);
        std::int32_t count = static_cast<std::int32_t>(near_number_.size());
        for (std::size_t v = 0; v < far_number_.size(); ++v) {
            if (!of_taken[v] || far_number_[v] >= 0) continue;
            if (of_other[v]) bug("a vertex of cells that reach infinity is in no other cell");
            far_number_[v] = count++;
            new_vertices_.push_back(static_cast<std::int32_t>(v));
        }
    }

    [[nodiscard]] std::span<const std::int32_t> near() const { return near_number_; }
    [[nodiscard]] std::span<const std::int32_t> far() const { return far_number_; }
    void place(Result& joined, const Result& far) const {
        if (joined.cell_vertex_indptr.empty()) return;
        const std::size_t known = near_number_.size(), count = known + new_vertices_.size();
        const auto lengthened = [&](auto& values, std::size_t each) {
            std::remove_reference_t<decltype(values)> all;
            all.resize_uninitialized(each * count);
            std::ranges::copy(values, all.begin());
            values = std::move(all);
        };
        lengthened(joined.vertices, 3);
        for (std::size_t n = 0; n < new_vertices_.size(); ++n)
            std::ranges::copy(position(far, new_vertices_[n]), &joined.vertices[3 * (known + n)]);
        if (far.vertex_image_of.empty()) return;
        // All images of a vertex are new, or none.
        lengthened(joined.vertex_image_of, 1);
        lengthened(joined.vertex_shifts, 3);
        std::unordered_map<std::int32_t, std::size_t> first;  // of the images of a far vertex
        for (std::size_t n = 0; n < new_vertices_.size(); ++n) {
            const std::size_t v = at(new_vertices_[n]);
            const std::size_t image_of = first.emplace(far.vertex_image_of[v], n).first->second;
            const std::size_t original = at(new_vertices_[image_of]);
            joined.vertex_image_of[known + n] = static_cast<std::int32_t>(known + image_of);
            for (std::size_t k = 0; k < 3; ++k)
                joined.vertex_shifts[3 * (known + n) + k] =
                    static_cast<std::int8_t>(far.vertex_shifts[3 * v + k] - far.vertex_shifts[3 * original + k]);
        }
    }

private:
    // A vertex of a cell, by the ids and shifts of its faces there.
    struct Corner {
        std::vector<std::array<std::int32_t, 4>> faces;
        std::int32_t vertex;
    };
    // Returns the corners of a row, ascending by faces.
    static std::vector<Corner> corners(const Result& r, std::size_t row, const auto& name) {
        std::vector<std::pair<std::int32_t, std::array<std::int32_t, 4>>> passages;
        for (auto e = at(r.indptr[row]); e < at(r.indptr[row + 1]); ++e) {
            std::array<std::int32_t, 4> face{name(r.indices[e])};
            for (std::size_t k = 0; k < 3 && !r.shifts.empty(); ++k) face[k + 1] = r.shifts[3 * e + k];
            for (const std::int32_t v : polygon_of(r, e))
                if (v >= 0) passages.emplace_back(v, face);
        }
        std::ranges::sort(passages);
        std::vector<Corner> corners;
        for (const auto& [vertex, face] : passages) {
            if (corners.empty() || corners.back().vertex != vertex) corners.push_back({{}, vertex});
            corners.back().faces.push_back(face);
        }
        std::ranges::sort(corners, {}, &Corner::faces);
        return corners;
    }

    std::vector<std::int32_t> near_number_, far_number_;  // -1: not in the joined result
    std::vector<std::int32_t> new_vertices_;              // of `far`, in the order of their numbers
};

}  // namespace

Result join_cells(Result&& near, const Result& far, std::span<const std::int32_t> rows, const std::vector<bool>& taken,
                  std::span<const std::int32_t> names, const Region& domain) {
    const JoinedVertices vertices(near, far, rows, taken, names);
    const bool has_polygons = !near.face_offsets.empty();
    NewRows joined(near, far);
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
        const auto has_none = [](CellStatus s) { return s == CellStatus::empty || s == CellStatus::outside; };
        empty_cells += std::uint64_t{has_none(far.status[k])} - std::uint64_t{has_none(near.status[i])};
        detail::copy_cell(near, i, far, k);
    }
    joined.move_into(near);
    vertices.place(near, far);
    near.lists_walls = true;
    near.stats.empty_cells = empty_cells;
    near.stats.exact_cells += far.stats.exact_cells;
    set_endless_stats(near, domain, joined.entries());
    return std::move(near);
}

}  // namespace votess
