#include "verify/told_cell.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/text.hpp"
#include "verify/verify_sample.hpp"

namespace votess {
namespace {

// Faces whose area is that of the threshold may have stayed or gone.
std::string check_row(const ToldCell& told, std::vector<ToldFace>& found, double allowed) {
    const std::vector<ToldFace>& row = *told.row;
    const std::string seed = "seed " + std::to_string(told.id);
    std::ranges::sort(found, std::less<>());
    std::size_t matched = 0;
    for (const ToldFace& face : found) {
        const auto entry = std::ranges::lower_bound(row, face, std::less<>());
        if (entry == row.end() || face < *entry) {
            if (face.id >= 0 && told.least_face > 0 && face.area < told.least_face + allowed) continue;
            return seed + " lists " + std::to_string(row.size()) + " neighbors, without " + std::to_string(face.id) +
                   ", which is one of the " + std::to_string(found.size()) + " found by trying every seed";
        }
        ++matched;
        if (!told.has_areas) continue;
        const double area = entry->area;
        if (area != face.area && !(std::abs(area - face.area) <= allowed + std::numeric_limits<double>::denorm_min()))
            return "the face of cell " + std::to_string(told.id) + " with " + std::to_string(face.id) + " has area " +
                   number(area) + ", trying every seed gives " + number(face.area);
    }
    if (matched == row.size()) return {};
    return seed + " lists " + std::to_string(row.size()) + " neighbors that differ from the " +
           std::to_string(found.size()) + " found by trying every seed";
}

}  // namespace

std::string difference(const ToldCell& told, double scale, std::span<const std::int64_t> ids, cpu::Cell& cell,
                       cpu::CellFaces& faces) {
    cell.canonical_faces(faces);
    constexpr std::size_t min_faces = 4;  // with fewer a cell has no interior
    if ((cell.empty() || faces.size() < min_faces) != told.empty)
        return "seed " + std::to_string(told.id) + " is said to have " + (told.empty ? "no cell" : "a cell") +
               ", trying every seed leaves " + (told.empty ? "one" : "none");
    if (told.empty) return {};

    const double unscale = 1 / scale;
    std::vector<double> areas;
    const cpu::CellGeometry geometry = cell.measure(faces, &areas);
    const double tolerance = told.tolerance + double_tolerance.cell;  // both are rounded
    if (told.row) {
        std::vector<ToldFace> row;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            const cpu::CellPlane& plane = cell.planes()[static_cast<std::size_t>(faces.planes[f])];
            if (plane.id < 0 && !told.lists_walls) continue;
            const bool named = plane.id >= 0 && !ids.empty();
            ToldFace face{named ? ids[static_cast<std::size_t>(plane.id)] : plane.id, {}, areas[f] * unscale * unscale};
            for (std::size_t k = 0; k < 3; ++k) face.shift[k] = static_cast<std::int8_t>(plane.shift[k]);
            row.push_back(face);
        }
        const double surface = std::accumulate(areas.begin(), areas.end(), 0.0) * unscale * unscale;
        if (auto failure = check_row(told, row, tolerance * surface); !failure.empty()) return failure;
    }
    if (told.volume) {
        const double volume = geometry.volume * unscale * unscale * unscale;
        if (volume != *told.volume &&  // both may be infinite
            !(std::abs(volume - *told.volume) <= tolerance * volume + std::numeric_limits<double>::denorm_min()))
            return "cell " + std::to_string(told.id) + " has volume " + number(*told.volume) +
                   ", trying every seed gives " + number(volume);
    }
    return {};
}

}  // namespace votess
