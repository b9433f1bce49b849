#include "verify/same_arrays.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <span>
#include <utility>

#include "core/text.hpp"
#include "input/settle.hpp"
#include "result/arrays.hpp"

namespace votess {
namespace {

using detail::Result;

// Whether offsets run from 0 up to the end of what they count. None: the array was not wanted.
bool ascend_to(std::span<const std::int64_t> offsets, std::size_t count, std::size_t end) {
    return offsets.empty() || (offsets.size() == count + 1 && offsets.front() == 0 && std::ranges::is_sorted(offsets) &&
                               offsets.back() == static_cast<std::int64_t>(end));
}

template <class T>
double size_of(T value) {
    return std::isfinite(static_cast<double>(value)) ? std::abs(static_cast<double>(value)) : 0;
}

// Returns the order of the distance between neighbors: the longest side of the bounds of all points, by their number.
double spacing_of(const Points& points, std::size_t dimensions) {
    double longest = 0;
    for (std::size_t axis = 0; axis < dimensions; ++axis) {
        double lower = std::numeric_limits<double>::infinity(), upper = -lower;
        for (std::size_t k = axis; k < points.coordinates(); k += dimensions)
            lower = std::min(lower, points[k]), upper = std::max(upper, points[k]);
        longest = std::max(longest, upper - lower);
    }
    return longest / std::cbrt(static_cast<double>(std::max<std::size_t>(points.coordinates() / dimensions, 1)));
}

// Numbers are rounded relative to their own size, or to this one where they are small differences of larger ones: that
// of a thin cell, or of a cell next to the origin.
double least_scale(std::string_view name, double spacing, bool planar) {
    constexpr double thin = 1e-3;
    int dimensions = 0;
    if (name == "volumes") dimensions = planar ? 2 : 3;
    if (name == "surface_areas" || name == "mesh_areas" || name == "face_areas") dimensions = planar ? 1 : 2;
    if (name == "centroids" || name == "vertices" || name == "security_radii") dimensions = 1;
    const double scale = (dimensions > 1 ? thin : 1) * std::pow(spacing, dimensions);
    return std::isfinite(scale) ? scale : 0;
}

template <class T>
bool same(T a, T b, double allowed) {
    if constexpr (std::floating_point<T>)
        return a == b || (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= allowed;
    else
        return a == b;
}

template <class T>
std::string text_of(T value) {
    if constexpr (std::floating_point<T>)
        return number(value);
    else
        return std::to_string(static_cast<std::int64_t>(value));
}

}  // namespace

std::string malformed(const Result& r) {
    const std::size_t cells = r.status.size(), entries = r.indices.size();
    const auto exist = [](std::span<const std::int32_t> ids, std::int64_t lowest, std::size_t count) {
        std::int32_t least = 0, largest = -1;  // without an early end, which vectors lack
        for (const std::int32_t id : ids) least = std::min(least, id), largest = std::max(largest, id);
        return least >= lowest && (largest < 0 || static_cast<std::size_t>(largest) < count);
    };
    const std::size_t vertices =
        r.vertices.empty() ? std::numeric_limits<std::size_t>::max() : r.vertices.size() / (r.planar ? 2 : 3);
    if (!ascend_to(r.indptr, cells, entries)) return "indptr does not ascend from 0 to the number of entries";
    if (!ascend_to(r.face_offsets, entries, r.face_vertices.size()))
        return "face_offsets does not ascend from 0 to the number of corners";
    if (!ascend_to(r.cell_vertex_indptr, cells, r.cell_vertex_indices.size()))
        return "cell_vertex_indptr does not ascend from 0 to the number of vertices of cells";
    if (!exist(r.face_vertices, -1, vertices)) return "face_vertices names a vertex that does not exist";
    if (!exist(r.cell_vertex_indices, 0, vertices)) return "cell_vertex_indices names a vertex that does not exist";
    if (!exist(r.vertex_image_of, 0, vertices)) return "vertex_image_of names a vertex that does not exist";
    const std::size_t seeds = r.is_subset ? r.all_seeds->count : cells;
    if (!exist(r.duplicate_of, -1, seeds)) return "duplicate_of names a seed that does not exist";
    if (!exist(r.ids, 0, seeds)) return "ids names a seed that does not exist";
    for (std::size_t i = 0; i < r.ids.size() && i < r.weights.size() && r.is_subset; ++i)
        if (r.weights[i] != r.all_seeds->weights[static_cast<std::size_t>(r.ids[i])])
            return "the weight of seed " + std::to_string(r.ids[i]) + " is " + number(r.weights[i]) + ", it had " +
                   number(r.all_seeds->weights[static_cast<std::size_t>(r.ids[i])]);
    for (std::size_t i = 0; i < cells; ++i)
        if (r.status[i] != CellStatus::certified && r.status[i] < CellStatus::duplicate)
            return "cell " + std::to_string(i) + " has no verdict";
    return {};
}

std::string difference_from_second_run(const Result& result, Settled again, double tolerance) {
    again.want = {.neighbors = false, .volumes = false};
    detail::for_arrays([&](const auto& array) {
        if (array.word != nullptr && !array.of(result).empty()) again.want.*array.word = true;
    });
    const double spacing = spacing_of(again.points, result.planar ? 2 : 3);
    again.list_walls = result.lists_walls;
    again.min_area = result.least_face;
    const Result second = arrays_of(std::move(again));
    const bool same_engine = result.stats.device == "cpu";  // others number vertices as they come
    std::string text;
    detail::for_arrays([&](const auto& array) {
        const auto &given = array.of(result), &expected = array.of(second);
        const bool of_rows = array.per == Per::cell || array.per == Per::entry || array.name == "indptr";
        if (!text.empty() || given.empty() || array.name == "weights" || (!of_rows && !same_engine)) return;
        const std::string name(array.name);
        if (given.size() != expected.size()) {
            text = name + " has another size than in a second run";
            return;
        }
        const double least = least_scale(array.name, spacing, result.planar);
        const std::size_t components = components_of(array, result.planar);
        for (std::size_t k = 0; k < given.size() && text.empty(); ++k) {
            double scale = least;
            for (std::size_t c = k - k % components; c < std::min(k - k % components + components, expected.size());
                 ++c)
                scale = std::max(scale, size_of(expected[c]));
            if (!same(given[k], expected[k], tolerance * scale))
                text = name + '[' + std::to_string(k) + "] is " + text_of(given[k]) + ", a second run gives " +
                       text_of(expected[k]);
        }
    });
    return text;
}

}  // namespace votess
