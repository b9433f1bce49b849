#include "votess/pieces.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "result/handle.hpp"
#include "result/result.hpp"
#include "solid/cell_pieces.hpp"
#include "solid/flat_pieces.hpp"
#include "solid/mesh_cells.hpp"

namespace votess {
namespace {

constexpr std::size_t cells_per_task = 64;

// Appends the pieces of further rows.
void append(const Pieces& more, Pieces& to) {
    const auto add = [](auto& all, const auto& part) { all.insert(all.end(), part.begin(), part.end()); };
    const auto add_offsets = [](std::vector<std::int64_t>& all, const std::vector<std::int64_t>& part) {
        const std::int64_t before = all.back();
        for (const std::int64_t offset : std::span(part).subspan(1)) all.push_back(before + offset);
    };
    add_offsets(to.indptr, more.indptr);
    add_offsets(to.vertex_offsets, more.vertex_offsets);
    add_offsets(to.triangle_offsets, more.triangle_offsets);
    add(to.vertices, more.vertices);
    add(to.triangles, more.triangles);
    add(to.on_surface, more.on_surface);
    add(to.sources, more.sources);
    add(to.volumes, more.volumes);
    add(to.centroids, more.centroids);
}

// Appends one piece, without an end of its row.
void append_piece(const Pieces& from, std::size_t p, Pieces& to) {
    const auto add = [](auto& all, const auto& part, std::int64_t begin, std::int64_t end) {
        all.insert(all.end(), part.begin() + begin, part.begin() + end);
    };
    const auto part = static_cast<std::int64_t>(p);
    const std::int64_t v = from.vertex_offsets[p], w = from.vertex_offsets[p + 1];
    const std::int64_t t = from.triangle_offsets[p], u = from.triangle_offsets[p + 1];
    add(to.vertices, from.vertices, 3 * v, 3 * w);
    add(to.triangles, from.triangles, 3 * t, 3 * u);
    add(to.on_surface, from.on_surface, t, u);
    add(to.sources, from.sources, t, u);
    add(to.volumes, from.volumes, part, part + 1);
    add(to.centroids, from.centroids, 3 * part, 3 * part + 3);
    to.vertex_offsets.push_back(to.vertex_offsets.back() + w - v);
    to.triangle_offsets.push_back(to.triangle_offsets.back() + u - t);
}

Pieces no_pieces() {
    Pieces none;
    none.indptr = none.vertex_offsets = none.triangle_offsets = {0};
    return none;
}

}  // namespace

Pieces pieces(const Tessellation& tessellation, const PieceOptions& options) {
    const detail::Result& result = detail::result_of(tessellation);
    const solid::MeshCells* const cells = result.mesh_cells.get();
    if (cells == nullptr)
        throw Error(ErrorCode::invalid_argument,
                    "pieces(): the cells are not cut by a mesh: tessellate with " + option("mesh"));
    if (!std::isfinite(options.gap) || options.gap < 0)
        throw Error(ErrorCode::invalid_argument,
                    "PieceOptions::gap is " + number(options.gap) + ": give a length from 0 on");
    check_member("PieceOptions::threads", options.threads);
    Progress progress(options.progress);
    const Stoppable stoppable(progress, {});
    ThreadPool pool(options.threads, "PieceOptions::threads");
    struct Worker {
        solid::CutCell cell;
        solid::CellPieces pieces;
    };
    std::vector<std::unique_ptr<Worker>> workers(pool.size());
    std::vector<Pieces> parts(ceil_div(cells->rows(), cells_per_task), no_pieces());
    pool.run_stage(parts.size(), [&](std::size_t index, unsigned worker) {
        if (!workers[worker])
            workers[worker] =
                std::make_unique<Worker>(Worker{{cells->mesh, *cells->domain, true}, {cells->mesh, cells->unit()}});
        auto& [cell, maker] = *workers[worker];
        for (std::size_t r = index * cells_per_task; r < std::min(cells->rows(), (index + 1) * cells_per_task); ++r) {
            check_stop();
            const auto [first, last] = cells->images(r);
            Pieces of_images = no_pieces();
            Pieces& out = last - first > 1 ? of_images : parts[index];
            for (std::size_t i = first; i < last; ++i) {
                if (cells->winding[i] == 0) continue;
                cells->make(r, i, cell, options.gap * cells->scale);
                if (cell.empty()) continue;
                if (cells->winding[i] == solid::MeshCells::cut) {
                    const solid::CutMeasures& m = cell.measure();
                    maker.add(cell, m.meets_surface, m.winding, out);
                } else {
                    cell.find_faces();
                    maker.add(cell, false, cells->winding[i], out);
                }
            }
            std::vector<std::size_t> order(of_images.size());  // large ones first, as of one image
            std::iota(order.begin(), order.end(), std::size_t{0});
            std::ranges::stable_sort(order, std::ranges::greater(),
                                     [&](std::size_t p) { return of_images.volumes[p]; });
            for (const std::size_t p : order) append_piece(of_images, p, parts[index]);
            parts[index].indptr.push_back(static_cast<std::int64_t>(parts[index].size()));
        }
    });
    Pieces all = no_pieces();
    for (Pieces& part : parts) append(std::exchange(part, {}), all);
    if (result.planar) all = solid::flat_pieces(all, *cells, *result.mesh_edges);
    for (std::size_t t = 0; t < all.sources.size(); ++t)
        if (all.on_surface[t] == 0) all.sources[t] = cells->name(all.sources[t]);
    return all;
}

}  // namespace votess
