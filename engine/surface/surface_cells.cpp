#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/errors.hpp"
#include "core/progress.hpp"
#include "core/thread_pool.hpp"
#include "input/settle.hpp"
#include "surface/measures.hpp"
#include "surface/nearest.hpp"
#include "surface/parts.hpp"
#include "surface/regions.hpp"

namespace votess {
namespace surface {
namespace {

constexpr std::size_t cells_per_task = 64;

SurfaceCells only_areas(const Surface& surface, ThreadPool& pool) {
    SurfaceCells out;
    find_areas(surface, pool, out.areas, out.borders);
    const double unscale = 1 / surface.scale();
    for (double& area : out.areas) area *= unscale * unscale;
    for (double& border : out.borders) border *= unscale;
    return out;
}

class Result {
public:
    Result(const Surface& surface, SurfaceWant want, bool is_whole, Parts& parts, ThreadPool& pool)
        : surface_(surface),
          want_(want),
          is_whole_(is_whole),
          parts_(parts),
          pool_(pool),
          unscale_(1 / surface.scale()) {}

    [[nodiscard]] SurfaceCells make() {
        sort_by_seed();
        if (want_ >= SurfaceWant::polygons) number_corners(parts_, surface_, pool_);
        measure();
        if (want_ >= SurfaceWant::polygons) {
            make_polygons();
            make_vertices();
        }
        if (want_ == SurfaceWant::all) make_dual();
        return std::move(out_);
    }

private:
    void sort_by_seed() {
        begin_.assign(surface_.seeds() + 1, 0);
        for (const Part& part : parts_.list) ++begin_[at(part.seed) + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        by_seed_.resize(parts_.size());
        std::vector<std::size_t> next = begin_;
        for (std::size_t p = 0; p < parts_.size(); ++p) by_seed_[next[at(parts_.list[p].seed)]++] = p;
    }

    void measure() {
        const std::size_t count = surface_.seeds();
        const bool has_polygons = want_ >= SurfaceWant::polygons, is_all = want_ == SurfaceWant::all;
        out_.areas.resize(count);
        out_.energies.resize(count);
        out_.borders.resize(count);
        out_.centroids.assign(3 * count, nan);
        out_.nearest.assign(3 * count, nan);
        if (has_polygons) {
            out_.pieces.resize(count);
            out_.euler.resize(count);
            pieces_.resize(parts_.size());
        }
        if (is_all) out_.indptr.assign(count + 1, 0);
        // In the order of the tree, in which near cells follow each other.
        std::vector<std::unique_ptr<CellOnSurface>> cells(pool_.size());
        std::vector<std::vector<CellOnSurface::Shared>> rows(ceil_div(surface_.tree().size(), cells_per_task));
        pool_.run(rows.size(), [&](std::size_t index, unsigned worker) {
            check_stop();
            if (!cells[worker]) cells[worker] = std::make_unique<CellOnSurface>(surface_, parts_, want_);
            CellOnSurface& cell = *cells[worker];
            const std::size_t end = std::min(surface_.tree().size(), (index + 1) * cells_per_task);
            for (std::size_t number = index * cells_per_task; number < end; ++number) {
                const std::int32_t id = surface_.tree().seed(static_cast<std::uint32_t>(number));
                const std::size_t i = at(id);
                const std::span own(by_seed_.data() + begin_[i], begin_[i + 1] - begin_[i]);
                cell.measure(id, own);
                out_.areas[i] = cell.area * unscale_ * unscale_;
                out_.energies[i] = cell.energy * unscale_ * unscale_ * unscale_ * unscale_;
                out_.borders[i] = cell.border * unscale_;
                const exact::Point& seed = surface_.seed(id);
                for (std::size_t k = 0; k < 3; ++k) {
                    out_.centroids[3 * i + k] = (seed[k] + cell.centroid[k]) * unscale_;
                    out_.nearest[3 * i + k] = (seed[k] + cell.nearest[k]) * unscale_;
                }
                if (!has_polygons) continue;
                out_.pieces[i] = cell.pieces;
                out_.euler[i] = cell.euler;
                for (std::size_t k = 0; k < own.size(); ++k) pieces_[own[k]] = cell.part_pieces[k];
                if (!is_all) continue;
                out_.indptr[i + 1] = static_cast<std::int64_t>(cell.row.size());
                rows[index].insert(rows[index].end(), cell.row.begin(), cell.row.end());
            }
        });
        std::int32_t before = 0;
        for (std::size_t i = 0; i < out_.pieces.size(); ++i) {
            for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k) pieces_[by_seed_[k]] += before;
            before += out_.pieces[i];
        }
        if (is_all) set_rows(rows);
    }

    // rows: those of cells_per_task numbers each.
    void set_rows(const std::vector<std::vector<CellOnSurface::Shared>>& rows) {
        std::partial_sum(out_.indptr.begin(), out_.indptr.end(), out_.indptr.begin());
        const std::size_t total = at(out_.indptr.back());
        out_.indices.resize(total);
        out_.lengths.resize(total);
        out_.curves.resize(total);
        out_.loops.resize(total);
        pool_.run(rows.size(), [&](std::size_t index, unsigned) {
            std::size_t next = 0;
            const std::size_t end = std::min(surface_.tree().size(), (index + 1) * cells_per_task);
            for (std::size_t number = index * cells_per_task; number < end; ++number) {
                const std::size_t i = at(surface_.tree().seed(static_cast<std::uint32_t>(number)));
                for (std::size_t k = at(out_.indptr[i]); k < at(out_.indptr[i + 1]); ++k) {
                    const CellOnSurface::Shared& shared = rows[index][next++];
                    out_.indices[k] = shared.seed;
                    out_.lengths[k] = shared.length * unscale_;
                    out_.curves[k] = shared.curves;
                    out_.loops[k] = shared.loops;
                }
            }
        });
    }

    // Passes on the parts with an area, or all.
    void make_polygons() {
        out_.polygon_offsets.assign(1, 0);
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const Part& part = parts_.list[p];
            if (!part.has_area && !is_whole_) continue;
            out_.polygon_triangles.push_back(part.triangle);
            out_.polygon_seeds.push_back(part.seed);
            out_.polygon_areas.push_back(part.area * unscale_ * unscale_);
            out_.polygon_pieces.push_back(pieces_[p]);
            for (std::size_t c = parts_.begin(p); c < parts_.end(p); ++c) {
                if (parts_.without_length[c] != 0 && !is_whole_) continue;
                out_.corners.push_back(parts_.corners[c]);
                out_.beyond.push_back(parts_.sides[c]);
            }
            out_.polygon_offsets.push_back(static_cast<std::int64_t>(out_.corners.size()));
        }
    }

    void make_vertices() {
        const std::size_t given = surface_.vertices().size();
        out_.vertices.resize(3 * (given + parts_.sources.size()));
        const auto set = [&](std::size_t v, const exact::Point& x) {
            for (std::size_t k = 0; k < 3; ++k) out_.vertices[3 * v + k] = x[k] * unscale_;
        };
        for (std::size_t v = 0; v < given; ++v) set(v, surface_.vertices()[v]);
        for (std::size_t v = 0; v < parts_.sources.size(); ++v) {
            const auto [p, c] = parts_.sources[v];
            const Surface::Triangle& triangle = surface_.triangles()[at(parts_.list[p].triangle)];
            const Side in = parts_.before(p, c), out = parts_.sides[c];
            if (in >= 0 && out >= 0) {
                const auto& u = surface_.vertex(triangle.vertex[0]);
                const auto& w = parts_.weights[c];
                set(given + v, along(along(u, minus(surface_.vertex(triangle.vertex[1]), u), w[0]),
                                     minus(surface_.vertex(triangle.vertex[2]), u), w[1]));
            } else {
                const Surface::Edge& edge = surface_.edges()[at(triangle.edge[corner_of(std::min(in, out))])];
                const auto& low = surface_.vertex(edge.low);
                set(given + v,
                    along(low, minus(surface_.vertex(edge.high), low), parts_.share_on_edge(surface_, {p, c})));
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
                const auto [triangle, seed] = std::pair(parts_.list[p].triangle, parts_.list[p].seed);
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
    SurfaceWant want_;
    bool is_whole_;  // keeps parts without area and sides without length
    Parts& parts_;
    ThreadPool& pool_;
    double unscale_;
    SurfaceCells out_;
    std::vector<std::size_t> begin_, by_seed_;  // parts of each seed
    std::vector<std::int32_t> pieces_;          // by part, numbered over all cells
};

SurfaceCells cells_on(std::span<const double> points, const TriangleMesh& mesh, const SurfaceOptions& options,
                      bool is_whole) {
    Progress progress(options.progress);
    const Stoppable stoppable(progress, {});
    ThreadPool pool(options.threads, "SurfaceOptions::threads");
    const Surface surface(points, mesh, options.weights, pool);
    if (options.want == SurfaceWant::areas) return only_areas(surface, pool);
    Parts parts = find_parts(surface, options.want, pool);
    return Result(surface, options.want, is_whole, parts, pool).make();
}

}  // namespace

SurfaceCells whole_cells(std::span<const double> points, const TriangleMesh& mesh, unsigned threads) {
    SurfaceOptions options;
    options.want = SurfaceWant::polygons;
    options.threads = threads;
    return cells_on(points, mesh, options, true);
}

}  // namespace surface

SurfaceCells surface_cells(std::span<const double> points, const TriangleMesh& mesh, const SurfaceOptions& options) {
    check_member("SurfaceOptions::threads", options.threads);
    if (options.want < SurfaceWant::areas || options.want > SurfaceWant::all)
        refuse("SurfaceOptions::want is " + std::to_string(static_cast<std::int32_t>(options.want)) +
               ": give areas, nearest, polygons or all");
    return surface::cells_on(points, mesh, options, false);
}

std::vector<std::int32_t> SurfaceCells::faults() const {
    if (indptr.size() != size() + 1) refuse("SurfaceCells::faults() needs all arrays: set SurfaceOptions::want to all");
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
