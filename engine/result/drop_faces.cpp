#include "result/drop_faces.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "result/arrays.hpp"
#include "result/rows.hpp"

namespace votess {
namespace {

using detail::Result;

// Stores each dropped polygon once, from the side whose area counts.
void keep_dropped_polygons(Result& r, const Rows& rows, const std::vector<bool>& stays) {
    if (r.face_offsets.empty()) return;
    std::vector<std::int64_t> offsets{0};
    std::vector<std::int32_t> vertices;
    for (std::size_t i = 0; i < r.status.size(); ++i)
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
            if (stays[entry] || !(FaceLabel{static_cast<std::int32_t>(i), {}} < rows.label(entry))) continue;
            vertices.insert(vertices.end(), &r.face_vertices[static_cast<std::size_t>(r.face_offsets[entry])],
                            &r.face_vertices[static_cast<std::size_t>(r.face_offsets[entry + 1] - 1)] + 1);
            offsets.push_back(static_cast<std::int64_t>(vertices.size()));
        }
    r.dropped_offsets.resize_uninitialized(offsets.size());
    r.dropped_vertices.resize_uninitialized(vertices.size());
    std::ranges::copy(offsets, r.dropped_offsets.begin());
    std::ranges::copy(vertices, r.dropped_vertices.begin());
}

}  // namespace

double area_of_pair(const Result& r, const Rows& rows, std::size_t i, std::size_t entry) {
    const FaceLabel there = rows.label(entry);
    const bool lower = FaceLabel{static_cast<std::int32_t>(i), {}} < there;
    return r.face_areas[lower ? entry : rows.find(static_cast<std::size_t>(there.id), there.seen_from_behind(i))];
}

std::uint64_t drop_small_faces(Result& r, double share, double area) {
    const std::size_t entries = r.indices.size(), count = r.status.size();
    double sum = 0;
    std::size_t faces = 0;
    for (std::size_t entry = 0; entry < entries; ++entry)
        if (r.indices[entry] >= 0 && std::isfinite(r.face_areas[entry])) sum += r.face_areas[entry], ++faces;
    if (faces == 0) return 0;
    r.least_face = std::max(area, share * (sum / static_cast<double>(faces)));
    const Rows rows{r.indptr, r.indices, r.shifts};
    std::vector<bool> stays(entries, true);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry)
            if (r.indices[entry] >= 0) stays[entry] = !(area_of_pair(r, rows, i, entry) < r.least_face);
    keep_dropped_polygons(r, rows, stays);
    std::size_t dropped = 0;
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry) {
            if (stays[entry]) continue;
            ++dropped;
            if (!r.face_counts.empty()) --r.face_counts[i];
        }
    detail::keep_entries(r, stays);
    return dropped;
}

}  // namespace votess
