// Cells around a mesh, before it cuts them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/buffer.hpp"
#include "core/measure_unit.hpp"
#include "solid/closed_mesh.hpp"
#include "solid/cut_cell.hpp"

namespace votess::solid {

struct MeshCells {
    explicit MeshCells(std::shared_ptr<const ClosedMesh> of_cells) : kept(std::move(of_cells)), mesh(*kept) {}

    static constexpr std::int32_t below = -5, above = -6;        // walls of a sheet
    static constexpr int cut = std::numeric_limits<int>::min();  // instead of the winding number of a cell

    std::shared_ptr<const ClosedMesh> kept;
    const ClosedMesh& mesh;  // times scale
    std::shared_ptr<const Domain> domain;
    double scale = 1;
    // Half of the height of a sheet, times scale; 0 for cells in space. The domain is then higher. The mirror images of
    // a seed bound its cell instead of walls, which do not cut a mesh.
    double half_height = 0;
    std::vector<double> seeds;        // 3N, times scale
    std::vector<double> weights;      // N, times scale squared; or none
    std::vector<exact::Shift> wraps;  // by seed: into a periodic domain; empty if all lie inside
    std::vector<std::int32_t> ids;    // of the rows, in a subset
    std::vector<std::int32_t> names;  // of seeds, in rows of probes; else they are numbered as given
    Buffer<std::int64_t> indptr;      // by row
    Buffer<std::int32_t> indices;     // all neighbors
    Buffer<std::int8_t> shifts;       // three for each neighbor; empty if nothing repeats
    // The images of cells that may reach the mesh, in a periodic domain: those of row r are image_offsets[r] to
    // image_offsets[r + 1] - 1. Otherwise empty, and the image of a row is its cell.
    std::vector<std::size_t> image_offsets;
    std::vector<exact::Shift> image_shifts;  // from places inside the domain
    std::vector<int> winding;                // by image: of plain ones; `cut` for others

    [[nodiscard]] MeasureUnit unit() const { return {1 / scale, 2 * half_height / scale}; }
    // Prepares for the cells of a sheet, whose domain is set.
    void raise() {
        Box box = domain->box;
        half_height = box.upper[2];
        for (double* z : {&box.lower[2], &box.upper[2]}) *z *= 4;
        Domain higher = box_domain(box, domain->periodic);
        higher.weights = domain->weights;
        domain = std::make_shared<const Domain>(std::move(higher));
    }

    [[nodiscard]] std::size_t rows() const { return indptr.empty() ? 0 : indptr.size() - 1; }
    [[nodiscard]] std::int32_t seed_of(std::size_t row) const {
        return ids.empty() ? static_cast<std::int32_t>(row) : ids[row];
    }
    [[nodiscard]] std::int32_t name(std::int32_t seed) const {
        return names.empty() ? seed : names[static_cast<std::size_t>(seed)];
    }
    [[nodiscard]] exact::Point place(std::int32_t seed) const {
        const double* x = &seeds[3 * static_cast<std::size_t>(seed)];
        return {x[0], x[1], x[2]};
    }
    [[nodiscard]] double weight(std::int32_t seed) const {
        return weights.empty() ? 0 : weights[static_cast<std::size_t>(seed)];
    }
    [[nodiscard]] std::span<const std::int32_t> row(std::size_t r) const {
        const auto begin = static_cast<std::size_t>(indptr[r]), end = static_cast<std::size_t>(indptr[r + 1]);
        return std::span<const std::int32_t>(indices).subspan(begin, end - begin);
    }
    // Returns the shift of a neighbor, from places inside the domain.
    [[nodiscard]] exact::Shift shift(std::size_t entry) const {
        if (shifts.empty()) return {};
        return {shifts[3 * entry], shifts[3 * entry + 1], shifts[3 * entry + 2]};
    }
    // Returns the first image of a row and the one after the last.
    [[nodiscard]] std::pair<std::size_t, std::size_t> images(std::size_t r) const {
        if (image_offsets.empty()) return {r, r + 1};
        return {image_offsets[r], image_offsets[r + 1]};
    }
    [[nodiscard]] exact::Shift image_shift(std::size_t image) const {
        return image_shifts.empty() ? exact::Shift{} : image_shifts[image];
    }
    // Returns the shift of an image from where its seed was given.
    [[nodiscard]] exact::Shift move(std::int32_t seed, const exact::Shift& shift) const {
        return wraps.empty() ? shift : sum(shift, wraps[static_cast<std::size_t>(seed)]);
    }
    [[nodiscard]] static exact::Shift sum(const exact::Shift& a, const exact::Shift& b) {
        return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
    }
    // Makes an image of the cell of a row. gap: of pieces, scaled.
    void make(std::size_t r, std::size_t image, CutCell& cell, double gap = 0) const {
        const std::int32_t seed = seed_of(r);
        const exact::Point x = place(seed);
        cell.begin(x, seed, move(seed, image_shift(image)), weight(seed));
        const exact::Shift home = move(seed, {}), back{-home[0], -home[1], -home[2]};
        const auto first = static_cast<std::size_t>(indptr[r]);
        const auto bisector = [&](std::size_t entry) {
            const std::int32_t j = indices[entry];
            return exact::Plane::bisector(place(j), sum(move(j, shift(entry)), back), domain->lattice);
        };
        // Near ones first: fewer vertices are then made and lost.
        struct Neighbor {
            double square;
            std::size_t entry;
        };
        std::vector<Neighbor> near(row(r).size());
        for (std::size_t k = 0; k < near.size(); ++k) {
            const auto n = exact::differences(x, bisector(first + k)).x;
            const double square = n[0].high * n[0].high + n[1].high * n[1].high + n[2].high * n[2].high;
            near[k] = {square, first + k};
        }
        std::ranges::sort(near, {}, [](const Neighbor& j) { return std::pair(j.square, j.entry); });
        for (const auto& [square, entry] : near)
            cell.add(indices[entry], bisector(entry), shift(entry), weight(indices[entry]), gap * std::sqrt(square));
        if (half_height == 0) return;
        for (const auto& [wall, z] : {std::pair(below, -2 * half_height), std::pair(above, 2 * half_height)})
            cell.add(wall, exact::Plane::bisector({x[0], x[1], z}, {}, domain->lattice), {}, weight(seed));
    }
};

}  // namespace votess::solid
