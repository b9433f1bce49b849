#include "verify/same_arrays.hpp"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/at.hpp"
#include "core/text.hpp"
#include "input/settle.hpp"
#include "result/arrays.hpp"
#include "result/drop_faces.hpp"
#include "result/rows.hpp"

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

// How far numbers may differ.
struct Tolerance {
    double part;       // of their own size
    double of_vector;  // of that of their vector, or of its least scale

    // A CPU repeats its numbers except last digits: some runs find corners, or sum, in another order. A GPU
    // rounds relative to the size of all cells.
    static Tolerance of(const Result& r, double part) { return {part, r.stats.device == "cpu" ? 0x1p-40 : part}; }
    [[nodiscard]] bool is_of_cell() const { return of_vector < part; }
};

// Numbers are rounded relative to their own size, or to this one where they are small differences of larger ones: those
// of places next to the origin, on a GPU those of thin cells too.
template <class Array>
double least_scale(const Array& array, double spacing, bool planar, const Tolerance& tolerance) {
    constexpr double thin = 1e-3;
    int dimensions = 0;
    for (const auto group : {&Want::centroids, &Want::vertices, &Want::radii})
        if (array.word == group) dimensions = 1;
    for (const auto group : {&Want::areas, &Want::surfaces})
        if (array.word == group) dimensions = planar ? 1 : 2;
    if (array.word == &Want::volumes) dimensions = planar ? 2 : 3;
    if (array.word != &Want::centroids && array.word != &Want::vertices && tolerance.is_of_cell()) return 0;
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

// Compares one number or vector with another. least: of the size of the expected one.
template <class Values>
bool same_at(const Values& given, std::size_t i, const Values& expected, std::size_t k, std::size_t components,
             double least, const Tolerance& tolerance) {
    double scale = least;
    for (std::size_t c = 0; c < components; ++c) scale = std::max(scale, size_of(expected[components * k + c]));
    for (std::size_t c = 0; c < components; ++c) {
        const auto value = expected[components * k + c];
        const double allowed = std::max(tolerance.part * size_of(value), tolerance.of_vector * scale);
        if (!same(given[components * i + c], value, allowed)) return false;
    }
    return true;
}

template <class T>
std::string text_of(T value) {
    if constexpr (std::floating_point<T>)
        return number(value);
    else
        return std::to_string(static_cast<std::int64_t>(value));
}

// Returns the sum of the finite areas in a row, by which each of them is compared: faces may be as small as rounding.
double surface_of(const Result& r, const Rows& rows, std::size_t i) {
    double sum = 0;
    for (std::size_t e = rows.begin(i); e < rows.end(i) && !r.face_areas.empty(); ++e) sum += size_of(r.face_areas[e]);
    return sum;
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

std::string difference_from_second_run(const Result& result, Settled again, double part) {
    const Tolerance tolerance = Tolerance::of(result, part);
    again.want = {.neighbors = false, .volumes = false};
    detail::for_arrays([&](const auto& array) {
        if (array.word != nullptr && !array.of(result).empty()) again.want.*array.word = true;
    });
    const double spacing = spacing_of(again.points, result.planar ? 2 : 3);
    again.list_walls = result.lists_walls;
    again.min_area = result.least_face;
    const Result second = arrays_of(std::move(again));
    const bool same_engine = result.stats.device == "cpu";  // others number vertices as they come
    const Rows rows{second.indptr, second.indices, second.shifts};
    std::vector<double> surfaces(second.face_areas.size());  // by entry
    for (std::size_t i = 0; i < second.status.size() && !surfaces.empty(); ++i)
        std::fill(surfaces.begin() + std::ptrdiff_t(rows.begin(i)), surfaces.begin() + std::ptrdiff_t(rows.end(i)),
                  surface_of(second, rows, i));
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
        const double least = least_scale(array, spacing, result.planar, tolerance);
        const std::size_t components = components_of(array, result.planar);
        for (std::size_t k = 0; k < given.size() / components && text.empty(); ++k) {
            const double scale = array.name == "face_areas" ? std::max(least, surfaces[k]) : least;
            if (same_at(given, k, expected, k, components, scale, tolerance)) continue;
            std::size_t at = components * k;
            while (at + 1 < components * (k + 1) && same(given[at], expected[at], 0)) ++at;
            text = name + '[' + std::to_string(at) + "] is " + text_of(given[at]) + ", a second run gives " +
                   text_of(expected[at]);
        }
    });
    return text;
}

namespace {

// A part of a result beside the whole; see difference_from_whole().
class PartOfWhole {
public:
    PartOfWhole(const Result& part, const Result& whole, double tolerance)
        : part_(part),
          whole_(whole),
          rows_{whole.indptr, whole.indices, whole.shifts},
          tolerance_(Tolerance::of(part, tolerance)),
          components_(part.planar ? 2 : 3),
          surfaces_(whole.status.size()) {
        for (std::size_t i = 0; i < surfaces_.size(); ++i) surfaces_[i] = surface_of(whole, rows_, i);
        if (!part.planar || whole.shifts.empty()) return;
        shifts_.assign(3 * whole.indices.size(), 0);
        for (std::size_t k = 0; k < whole.shifts.size(); ++k) shifts_[k / 2 * 3 + k % 2] = whole.shifts[k];
        rows_.shifts = shifts_;
    }

    // Returns which array of a row differs from that of seed i, "" for none.
    [[nodiscard]] std::string_view difference(std::size_t row, std::size_t i) {
        std::size_t dropped = 0;
        size_ = 0.5 * whole_.security_radii[i];
        if (!part_.indptr.empty())
            if (const std::string_view name = of_entries(row, i, dropped); !name.empty()) return name;
        if (const std::string_view name = of_vertices(row, i); !name.empty()) return name;
        std::string_view differs;
        detail::for_arrays([&](const auto& array) {
            const auto &given = array.of(part_), &expected = array.of(whole_);
            if (array.per != Per::cell || array.name == "ids" || given.empty() || !differs.empty()) return;
            if (expected.empty()) return void(differs = array.name);
            const bool counts_faces =  // in the plane all counts are that of edges
                array.name == "face_counts" || (part_.planar && array.word == &Want::counts);
            const bool equal =
                counts_faces ? static_cast<std::size_t>(given[row]) + dropped == static_cast<std::size_t>(expected[i])
                             : same_at(given, row, expected, i, components_of(array, part_.planar),
                                       least_scale(array, size_, part_.planar, tolerance_), tolerance_);
            if (!equal) differs = array.name;
        });
        return differs;
    }

private:
    [[nodiscard]] bool same_place(std::int32_t given, std::int32_t expected) const {
        if (given < 0 || expected < 0) return given == expected;  // at infinity
        return same_at(part_.vertices, static_cast<std::size_t>(given), whole_.vertices,
                       static_cast<std::size_t>(expected), components_, size_, tolerance_);
    }

    // Goes along both rows. The whole one may have more faces, those below the limit: next to it both are right.
    [[nodiscard]] std::string_view of_entries(std::size_t row, std::size_t i, std::size_t& dropped) const {
        const auto begin = [](const Result& r, std::size_t k) { return static_cast<std::size_t>(r.indptr[k]); };
        std::size_t entry = begin(part_, row);
        const std::size_t end = begin(part_, row + 1), all_end = begin(whole_, i + 1);
        for (std::size_t e = begin(whole_, i); e < all_end; ++e) {
            const bool is_face = part_.least_face > 0 && whole_.indices[e] >= 0;
            std::string_view differs = entry < end ? of_entry(entry, e, i) : "neighbors";
            const double area = is_face ? area_of_pair(whole_, rows_, i, e) : infinity,
                         near =
                             is_face ? 1e-9 * (part_.least_face + surfaces_[i] + surfaces_[at(whole_.indices[e])]) : 0;
            if (differs == "neighbors" && area < part_.least_face + near) {
                ++dropped;
                continue;
            }
            if (differs.empty() && area < part_.least_face - near) differs = "small faces";
            if (!differs.empty()) return differs;
            ++entry;
        }
        return entry == end ? "" : "neighbors";
    }

    [[nodiscard]] std::string_view of_entry(std::size_t entry, std::size_t e, std::size_t i) const {
        if (part_.indices[entry] != whole_.indices[e]) return "neighbors";
        std::string_view differs;
        detail::for_arrays([&](const auto& array) {
            const auto &given = array.of(part_), &expected = array.of(whole_);
            if (array.per != Per::entry || given.empty() || !differs.empty()) return;
            // Areas are rounded as their sum.
            const bool is_area = array.name == "face_areas";
            const Tolerance& tolerance = is_area ? Tolerance{tolerance_.part, tolerance_.part} : tolerance_;
            const double least = least_scale(array, size_, part_.planar, tolerance_);
            if (!same_at(given, entry, expected, e, components_of(array, part_.planar),
                         is_area ? std::max(least, surfaces_[i]) : least, tolerance))
                differs = array.name == "shifts" ? "neighbors" : array.name;
        });
        if (!differs.empty() || part_.face_offsets.empty()) return differs;
        const auto polygon = [](const Result& r, std::size_t k) {
            const auto from = static_cast<std::size_t>(r.face_offsets[k]);
            return std::span<const std::int32_t>(r.face_vertices)
                .subspan(from, static_cast<std::size_t>(r.face_offsets[k + 1]) - from);
        };
        const auto given = polygon(part_, entry), expected = polygon(whole_, e);
        const bool equal = std::ranges::equal(given, expected, [&](auto a, auto b) { return same_place(a, b); });
        return equal ? "" : "polygons";
    }

    [[nodiscard]] std::string_view of_vertices(std::size_t row, std::size_t i) const {
        if (part_.cell_vertex_indptr.empty()) return "";
        const auto list = [](const Result& r, std::size_t k) {
            const auto from = static_cast<std::size_t>(r.cell_vertex_indptr[k]);
            return std::span<const std::int32_t>(r.cell_vertex_indices)
                .subspan(from, static_cast<std::size_t>(r.cell_vertex_indptr[k + 1]) - from);
        };
        const auto given = list(part_, row), expected = list(whole_, i);
        if (given.size() != expected.size()) return "vertices";
        const auto same = [&](std::int32_t a, std::int32_t b) { return same_place(a, b); };
        if (part_.planar) {
            if (given.empty()) return "";
            std::size_t turn = 0;
            while (turn < expected.size() && !same(given[0], expected[turn])) ++turn;
            for (std::size_t k = 0; k < given.size(); ++k)
                if (!same(given[k], expected[(turn + k) % expected.size()])) return "vertices";
            return "";
        }
        // Both ascend, by numbers that the cells before them have made different.
        const bool equal = std::ranges::adjacent_find(given, std::greater_equal<>()) == given.end() &&
                           std::ranges::all_of(given, [&](std::int32_t v) {
                               return std::ranges::any_of(expected, [&](std::int32_t u) { return same(v, u); });
                           });
        return equal ? "" : "vertices";
    }

    const Result &part_, &whole_;
    Rows rows_;                        // of the whole
    std::vector<std::int8_t> shifts_;  // of three components, where those of the whole have two
    Tolerance tolerance_;
    std::size_t components_;
    std::vector<double> surfaces_;  // sums of the finite areas of cells, where there are areas
    double size_ = 0;               // of the cell: the distance to its farthest vertex
};

}  // namespace

std::string difference_from_whole(const Result& part, const Result& whole, double tolerance) {
    PartOfWhole pair(part, whole, tolerance);
    for (std::size_t row = 0; row < part.status.size(); ++row) {
        const std::size_t i = part.is_subset ? static_cast<std::size_t>(part.ids[row]) : row;
        const std::string_view name = pair.difference(row, i);
        if (!name.empty())
            return "cell " + std::to_string(i) + " has other " + std::string(name) + " than in a run of all cells";
    }
    return {};
}

}  // namespace votess
