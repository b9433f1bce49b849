#include "result/arrays.hpp"

#include <algorithm>

namespace votess::detail {
namespace {

// Keeps those of `count` things for which stays(i), in the arrays that have values for each.
template <class Stays>
void keep_some(Result& r, Per per, std::size_t count, const Stays& stays) {
    for_arrays([&](const auto& array) {
        auto& values = array.of(r);
        if (array.per != per || values.empty()) return;
        std::size_t to = 0;
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < array.components && stays(i); ++k)
                values[to++] = values[array.components * i + k];
        values.resize_uninitialized(to);
    });
}

void keep_polygons(Result& r, const std::vector<bool>& stays) {
    if (r.face_offsets.empty()) return;
    std::int64_t to = 0;
    std::size_t face = 0;
    for (std::size_t entry = 0; entry < stays.size(); ++entry) {
        const std::int64_t begin = r.face_offsets[entry], end = r.face_offsets[entry + 1];
        if (!stays[entry]) continue;
        r.face_offsets[face++] = to;
        std::copy(r.face_vertices.data() + begin, r.face_vertices.data() + end, r.face_vertices.data() + to);
        to += end - begin;
    }
    r.face_offsets[face] = to;
    r.face_offsets.resize_uninitialized(face + 1);
    r.face_vertices.resize_uninitialized(static_cast<std::size_t>(to));
}

}  // namespace

void drop_third_components(Result& result) {
    for_arrays([&](const auto& array) {
        auto& values = array.of(result);
        if (array.components != 3 || values.empty()) return;
        const std::size_t count = values.size() / 3;
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < 2; ++k) values[2 * i + k] = values[3 * i + k];
        values.resize_uninitialized(2 * count);
    });
}

void keep_vertices(Result& r, std::span<const std::int32_t> number) {
    for (std::int32_t& original : r.vertex_image_of) original = number[static_cast<std::size_t>(original)];
    keep_some(r, Per::vertex, number.size(), [&](std::size_t v) { return number[v] >= 0; });
}

void keep_entries(Result& r, const std::vector<bool>& stays) {
    std::int64_t kept = 0, entry = 0;
    for (std::size_t i = 0; i + 1 < r.indptr.size(); ++i) {
        for (const std::int64_t end = r.indptr[i + 1]; entry < end; ++entry)
            kept += stays[static_cast<std::size_t>(entry)] ? 1 : 0;
        r.indptr[i + 1] = kept;
    }
    keep_polygons(r, stays);
    keep_some(r, Per::entry, stays.size(), [&](std::size_t entry) { return stays[entry]; });
}

void keep_wanted(Result& r, const Want& want, bool list_walls) {
    for_arrays([&](const auto& array) {
        if (array.word != nullptr && !(want.*array.word)) array.of(r).resize_uninitialized(0);
    });
    const bool drops = r.lists_walls && !list_walls;
    r.lists_walls = list_walls;
    if (!drops || r.indptr.empty()) return;
    std::vector<bool> stays(r.indices.size());
    for (std::size_t entry = 0; entry < stays.size(); ++entry) stays[entry] = r.indices[entry] >= 0;
    keep_entries(r, stays);
}

}  // namespace votess::detail
