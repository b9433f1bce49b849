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
#include "solid/closed_mesh.hpp"
#include "solid/cut_cell.hpp"

namespace votess::solid {

struct MeshCells {
    explicit MeshCells(const TriangleMesh& given) : mesh(given) {}

    static constexpr int cut = std::numeric_limits<int>::min();  // instead of the winding number of a cell

    ClosedMesh mesh;  // times scale
    std::shared_ptr<const Domain> domain;
    double scale = 1;
    std::vector<double> seeds;      // 3N, times scale
    std::vector<std::int32_t> ids;  // of the rows, in a subset
    Buffer<std::int64_t> indptr;    // by row
    Buffer<std::int32_t> indices;   // all neighbors
    std::vector<int> winding;       // by row: of plain cells; `cut` for others; 0 for none

    [[nodiscard]] std::size_t rows() const { return winding.size(); }
    [[nodiscard]] std::int32_t seed_of(std::size_t row) const {
        return ids.empty() ? static_cast<std::int32_t>(row) : ids[row];
    }
    [[nodiscard]] exact::Point place(std::int32_t seed) const {
        const double* x = &seeds[3 * static_cast<std::size_t>(seed)];
        return {x[0], x[1], x[2]};
    }
    [[nodiscard]] double weight(std::int32_t seed) const {
        return domain->weights.empty() ? 0 : domain->weights[static_cast<std::size_t>(seed)];
    }
    [[nodiscard]] std::span<const std::int32_t> row(std::size_t r) const {
        const auto begin = static_cast<std::size_t>(indptr[r]), end = static_cast<std::size_t>(indptr[r + 1]);
        return std::span<const std::int32_t>(indices).subspan(begin, end - begin);
    }
    // Makes the cell of a row. gap: of pieces, scaled.
    void make(std::size_t r, CutCell& cell, MeshSigns::Ties ties = MeshSigns::Ties::moved, double gap = 0) const {
        const std::int32_t seed = seed_of(r);
        const exact::Point x = place(seed);
        cell.begin(x, seed, weight(seed), ties);
        // Near ones first: fewer vertices are then made and lost.
        struct Neighbor {
            double square;
            std::int32_t id;
        };
        std::vector<Neighbor> near;
        near.reserve(row(r).size());
        for (const std::int32_t j : row(r)) {
            const Vector3 n = minus(place(j), x);
            near.push_back({dot(n, n), j});
        }
        std::ranges::sort(near, {}, [](const Neighbor& j) { return std::pair(j.square, j.id); });
        for (const auto& [square, j] : near) cell.add(j, place(j), weight(j), gap * std::sqrt(square));
    }
};

}  // namespace votess::solid
