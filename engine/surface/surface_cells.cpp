#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/thread_pool.hpp"
#include "input/settle.hpp"
#include "surface/measures.hpp"
#include "surface/parts.hpp"

namespace votess {
namespace surface {
namespace {

constexpr std::size_t cells_per_task = 64;

class Result {
public:
    Result(const Surface& surface, const Parts& parts, ThreadPool& pool)
        : surface_(surface), parts_(parts), pool_(pool) {}

    [[nodiscard]] SurfaceCells make() {
        sort_by_seed();
        measure();
        make_polygons();
        make_vertices();
        make_dual();
        return std::move(out_);
    }

private:
    void sort_by_seed() {
        begin_.assign(surface_.seeds() + 1, 0);
        for (const std::int32_t seed : parts_.seeds) ++begin_[at(seed) + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        by_seed_.resize(parts_.size());
        std::vector<std::size_t> next = begin_;
        for (std::size_t p = 0; p < parts_.size(); ++p) by_seed_[next[at(parts_.seeds[p])]++] = p;
    }

    void measure() {
        const std::size_t count = surface_.seeds();
        const double unscale = 1 / surface_.scale();
        out_.areas.resize(count);
        out_.energies.resize(count);
        out_.borders.resize(count);
        out_.centroids.resize(3 * count);
        out_.nearest.resize(3 * count);
        out_.pieces.resize(count);
        out_.euler.resize(count);
        areas_.resize(parts_.size());
        pieces_.resize(parts_.size());
        std::vector<std::unique_ptr<CellOnSurface>> cells(pool_.size());
        std::vector<std::vector<CellOnSurface::Shared>> rows(ceil_div(count, cells_per_task));
        out_.indptr.assign(count + 1, 0);
        pool_.run(rows.size(), [&](std::size_t index, unsigned worker) {
            check_stop();
            if (!cells[worker]) cells[worker] = std::make_unique<CellOnSurface>(surface_, parts_);
            CellOnSurface& cell = *cells[worker];
            for (std::size_t i = index * cells_per_task; i < std::min(count, (index + 1) * cells_per_task); ++i) {
                const std::span own(by_seed_.data() + begin_[i], begin_[i + 1] - begin_[i]);
                cell.measure(static_cast<std::int32_t>(i), own);
                out_.areas[i] = cell.area * unscale * unscale;
                out_.energies[i] = cell.energy * unscale * unscale * unscale * unscale;
                out_.borders[i] = cell.border * unscale;
                const exact::Point& seed = surface_.seed(static_cast<std::int32_t>(i));
                for (std::size_t k = 0; k < 3; ++k) {
                    out_.centroids[3 * i + k] = (seed[k] + cell.centroid[k]) * unscale;
                    out_.nearest[3 * i + k] = (seed[k] + cell.nearest[k]) * unscale;
                }
                out_.pieces[i] = cell.pieces;
                out_.euler[i] = cell.euler;
                out_.indptr[i + 1] = static_cast<std::int64_t>(cell.row.size());
                rows[index].insert(rows[index].end(), cell.row.begin(), cell.row.end());
                for (std::size_t k = 0; k < own.size(); ++k) {
                    areas_[own[k]] = cell.part_areas[k] * unscale * unscale;
                    pieces_[own[k]] = cell.part_pieces[k];
                }
            }
        });
        std::partial_sum(out_.indptr.begin(), out_.indptr.end(), out_.indptr.begin());
        std::int32_t before = 0;
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k) pieces_[by_seed_[k]] += before;
            before += out_.pieces[i];
        }
        for (const auto& row : rows)
            for (const CellOnSurface::Shared& shared : row) {
                out_.indices.push_back(shared.seed);
                out_.lengths.push_back(shared.length * unscale);
                out_.curves.push_back(shared.curves);
                out_.loops.push_back(shared.loops);
            }
    }

    // Passes on the parts with an area.
    void make_polygons() {
        out_.polygon_offsets.assign(1, 0);
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            if (parts_.without_area[p] != 0) continue;
            out_.polygon_triangles.push_back(parts_.triangles[p]);
            out_.polygon_seeds.push_back(parts_.seeds[p]);
            out_.polygon_areas.push_back(areas_[p]);
            out_.polygon_pieces.push_back(pieces_[p]);
            for (std::size_t c = parts_.begin(p); c < parts_.end(p); ++c) {
                if (parts_.without_length[c] != 0) continue;
                out_.corners.push_back(parts_.corners[c]);
                out_.beyond.push_back(parts_.sides[c]);
            }
            out_.polygon_offsets.push_back(static_cast<std::int64_t>(out_.corners.size()));
        }
    }

    void make_vertices() {
        const std::size_t given = surface_.vertices().size(), count = given + parts_.places.size();
        const double unscale = 1 / surface_.scale();
        out_.vertices.resize(3 * count);
        const auto set = [&](std::size_t v, const exact::Point& x) {
            for (std::size_t k = 0; k < 3; ++k) out_.vertices[3 * v + k] = x[k] * unscale;
        };
        for (std::size_t v = 0; v < given; ++v) set(v, surface_.vertices()[v]);
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const Surface::Triangle& triangle = surface_.triangles()[at(parts_.triangles[p])];
            for (std::size_t c = parts_.begin(p); c < parts_.end(p); ++c) {
                const std::size_t v = at(parts_.corners[c]);
                const Side in = parts_.before(p, c), out = parts_.sides[c];
                if (v < given) continue;
                const auto& place = parts_.places[v - given];
                exact::Point x;
                if (in >= 0 && out >= 0) {
                    const auto &u = surface_.vertex(triangle.vertex[0]), &a = surface_.vertex(triangle.vertex[1]),
                               &b = surface_.vertex(triangle.vertex[2]);
                    for (std::size_t k = 0; k < 3; ++k)
                        x[k] = u[k] + place[0] * (a[k] - u[k]) + place[1] * (b[k] - u[k]);
                } else {
                    const Surface::Edge& edge = surface_.edges()[at(triangle.edge[corner_of(std::min(in, out))])];
                    const auto &a = surface_.vertex(edge.low), &b = surface_.vertex(edge.high);
                    for (std::size_t k = 0; k < 3; ++k) x[k] = a[k] + place[0] * (b[k] - a[k]);
                }
                set(v, x);
            }
        }
    }

    // Three cells meet at a corner inside of a triangle; around it, a part's seed precedes the one beyond the side
    // before the corner. Calls use(seeds, pieces) for each such corner.
    template <class Use>
    void each_meeting(const Use& use) const {
        for (std::size_t p = 0; p < parts_.size(); ++p)
            for (std::size_t c = parts_.begin(p); c < parts_.end(p); ++c) {
                const Side in = parts_.before(p, c), out = parts_.sides[c];
                const std::int32_t seed = parts_.seeds[p], triangle = parts_.triangles[p];
                if (seed < in && seed < out)
                    use(std::array{seed, in, out}, std::array{pieces_[p], pieces_[parts_.find(triangle, in)],
                                                              pieces_[parts_.find(triangle, out)]});
            }
    }

    void make_dual() {
        std::vector<Corners> cells, pieces;
        each_meeting([&](const Corners& of_cells, const Corners& of_pieces) {
            cells.push_back(of_cells);
            pieces.push_back(of_pieces);
        });
        count_alike(std::move(cells), out_.dual, out_.dual_counts);
        count_alike(std::move(pieces), out_.piece_dual, out_.piece_dual_counts);
    }

    using Corners = std::array<std::int32_t, 3>;  // the lowest first
    // Lists triangles, each once in its first direction, ascending by their sorted corners.
    static void count_alike(std::vector<Corners> triangles, std::vector<std::int32_t>& dual,
                            std::vector<std::int32_t>& counts) {
        const auto sorted = [](const Corners& c) { return Corners{c[0], std::min(c[1], c[2]), std::max(c[1], c[2])}; };
        check_stop();
        std::ranges::stable_sort(triangles, {}, sorted);
        for (std::size_t k = 0; k < triangles.size(); ++k) {
            if (k > 0 && sorted(triangles[k]) == sorted(triangles[k - 1])) {
                ++counts.back();
                continue;
            }
            dual.insert(dual.end(), triangles[k].begin(), triangles[k].end());
            counts.push_back(1);
        }
    }

    const Surface& surface_;
    const Parts& parts_;
    ThreadPool& pool_;
    SurfaceCells out_;
    std::vector<std::size_t> begin_, by_seed_;  // parts of each seed
    std::vector<double> areas_;                 // by part
    std::vector<std::int32_t> pieces_;          // by part, numbered over all cells
};

}  // namespace
}  // namespace surface

SurfaceCells surface_cells(std::span<const double> points, const TriangleMesh& mesh, const SurfaceOptions& options) {
    check_threads(options.threads);
    Progress progress(options.progress);
    const Stoppable stoppable(progress, {});
    const surface::Surface surface(points, mesh, options.weights);
    ThreadPool pool(options.threads);
    const surface::Parts parts = surface::find_parts(surface, pool);
    return surface::Result(surface, parts, pool).make();
}

std::vector<std::int32_t> SurfaceCells::faults() const {
    std::vector<std::uint8_t> bad(size());
    for (std::size_t i = 0; i < size(); ++i) {
        if (pieces[i] > 0 && (pieces[i] != 1 || euler[i] != 1)) bad[i] = 1;
        for (auto k = static_cast<std::size_t>(indptr[i]); k < static_cast<std::size_t>(indptr[i + 1]); ++k)
            if (curves[k] != 1 || loops[k] != 0) bad[i] = 1;
    }
    for (std::size_t t = 0; t < dual_counts.size(); ++t)
        if (dual_counts[t] != 1)
            for (std::size_t k = 0; k < 3; ++k) bad[static_cast<std::size_t>(dual[3 * t + k])] = 1;
    std::vector<std::int32_t> found;
    for (std::size_t i = 0; i < bad.size(); ++i)
        if (bad[i] != 0) found.push_back(static_cast<std::int32_t>(i));
    return found;
}

}  // namespace votess
