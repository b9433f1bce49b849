#include "result/arrays.hpp"

#include <algorithm>

namespace votess::detail {
namespace {

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
    for_arrays([&](const auto& array) {
        auto& values = array.of(r);
        if (array.per != Per::vertex || values.empty()) return;
        std::size_t to = 0;
        for (std::size_t v = 0; v < number.size(); ++v)
            for (std::size_t k = 0; k < array.components && number[v] >= 0; ++k)
                values[to++] = values[array.components * v + k];
        values.resize_uninitialized(to);
    });
}

void keep_entries(Result& r, const std::vector<bool>& stays) {
    std::int64_t kept = 0, entry = 0;
    for (std::size_t i = 0; i + 1 < r.indptr.size(); ++i) {
        for (const std::int64_t end = r.indptr[i + 1]; entry < end; ++entry)
            kept += stays[static_cast<std::size_t>(entry)] ? 1 : 0;
        r.indptr[i + 1] = kept;
    }
    keep_polygons(r, stays);
    for_arrays([&](const auto& array) {
        auto& values = array.of(r);
        if (array.per != Per::entry || values.empty()) return;
        std::size_t to = 0;
        for (std::size_t from = 0; from < stays.size(); ++from)
            if (stays[from])
                for (std::size_t k = 0; k < array.components; ++k) values[to++] = values[array.components * from + k];
        values.resize_uninitialized(to);
    });
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
