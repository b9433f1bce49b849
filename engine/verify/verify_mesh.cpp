#include "verify/verify_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/text.hpp"
#include "input/options.hpp"

namespace votess {
namespace {

using detail::Result;

std::size_t at(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

bool has_polygons(const Result& r) {
    return !r.face_offsets.empty() && r.least_face == 0;
}

bool has_whole_surfaces(const Result& r) {
    return !r.face_areas.empty() && !r.face_normals.empty() && r.lists_walls && r.least_face == 0;
}

std::span<const std::int32_t> polygon(const Result& r, std::size_t entry) {
    const std::span<const std::int32_t> all = r.face_vertices;
    return all.subspan(at(r.face_offsets[entry]), at(r.face_offsets[entry + 1] - r.face_offsets[entry]));
}

// Every edge twice, in opposite directions.
bool is_watertight(const Result& r, std::size_t i, std::vector<std::uint64_t>& edges) {
    edges.clear();
    for (auto entry = at(r.indptr[i]); entry < at(r.indptr[i + 1]); ++entry) {
        const auto corners = polygon(r, entry);
        if (corners.size() < 3) return false;
        for (std::size_t k = 0; k < corners.size(); ++k)
            edges.push_back(static_cast<std::uint64_t>(corners[k]) << 32 |
                            static_cast<std::uint32_t>(corners[k + 1 == corners.size() ? 0 : k + 1]));
    }
    std::ranges::sort(edges);
    return std::ranges::adjacent_find(edges) == edges.end() && std::ranges::all_of(edges, [&](std::uint64_t edge) {
               return std::ranges::binary_search(edges, edge << 32 | edge >> 32);
           });
}

// The entry in the row of the neighbor that leads back, or the number of entries.
std::size_t other_side(const Result& r, std::size_t i, std::size_t entry) {
    const auto j = at(r.indices[entry]);
    for (auto back = at(r.indptr[j]); back < at(r.indptr[j + 1]); ++back) {
        bool leads = at(r.indices[back]) == i && r.indices[back] >= 0;
        for (std::size_t k = 0; k < 3 && leads && !r.shifts.empty(); ++k)
            leads = r.shifts[3 * back + k] == -r.shifts[3 * entry + k];
        if (leads) return back;
    }
    return r.indices.size();
}

// The same vertices, or images of them, the other way round.
bool same_polygon(const Result& r, std::size_t entry, std::size_t other) {
    const auto original = [&](std::int32_t v) { return r.vertex_image_of.empty() ? v : r.vertex_image_of[at(v)]; };
    const auto here = polygon(r, entry), there = polygon(r, other);
    if (here.size() != there.size()) return false;
    for (std::size_t turn = 0; turn < here.size(); ++turn) {
        std::size_t k = 0;
        while (k < here.size() && original(here[k]) == original(there[(turn + here.size() - k) % here.size()])) ++k;
        if (k == here.size()) return true;
    }
    return false;
}

std::string check_polygons(const Result& r) {
    std::vector<std::uint64_t> edges;
    for (std::size_t i = 0; i < r.status.size(); ++i) {
        if (!is_watertight(r, i, edges)) return "cell " + std::to_string(i) + " is not watertight";
        for (auto entry = at(r.indptr[i]); entry < at(r.indptr[i + 1]); ++entry) {
            if (r.indices[entry] < static_cast<std::int32_t>(i)) continue;
            const std::size_t other = other_side(r, i, entry);
            if (other == r.indices.size() || !same_polygon(r, entry, other))
                return "cells " + std::to_string(i) + " and " + std::to_string(r.indices[entry]) +
                       " have different polygons between them";
        }
    }
    return {};
}

std::string check_surfaces(const Result& r, double tolerance) {
    for (std::size_t i = 0; i < r.status.size(); ++i) {
        std::array<double, 3> sum{};
        double surface = 0;
        for (auto entry = at(r.indptr[i]); entry < at(r.indptr[i + 1]); ++entry) {
            surface += r.face_areas[entry];
            for (std::size_t k = 0; k < 3; ++k) sum[k] += r.face_areas[entry] * r.face_normals[3 * entry + k];
        }
        const double open = std::hypot(sum[0], sum[1], sum[2]);
        const double rounding = 64 * std::numeric_limits<double>::denorm_min();
        if (std::isfinite(surface) && !(open <= tolerance * surface + rounding))
            return "cell " + std::to_string(i) + " is not closed: area times normal sums to " + number(open) +
                   ", its surface is " + number(surface);
    }
    return {};
}

}  // namespace

bool has_mesh(const Result& result) {
    return has_polygons(result) || has_whole_surfaces(result);
}

std::string check_mesh(const Result& result, double tolerance) {
    if (has_polygons(result))
        if (auto failure = check_polygons(result); !failure.empty()) return failure;
    return has_whole_surfaces(result) ? check_surfaces(result, tolerance) : std::string();
}

}  // namespace votess
