#include "solid/run_in_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "input/default_box.hpp"
#include "input/implied_wants.hpp"
#include "input/options.hpp"
#include "solid/closed_mesh.hpp"
#include "solid/cut_cell.hpp"
#include "solid/mesh_cells.hpp"
#include "solid/sum.hpp"

namespace votess::solid {
namespace {

using detail::Result;

constexpr double radius_slack = 1e-4;  // covers the error of a radius from a GPU
constexpr double min_share = 1e-3;     // of a flat mesh's bounds in a cube, along one axis
constexpr std::size_t rows_per_task = 256, rows_per_group = 8;

[[noreturn]] void unsupported(const std::string& what) {
    throw Error(ErrorCode::unsupported, "mesh: " + what);
}

void check_others(const Options& options) {
    if (options.planar) unsupported("it works in three dimensions only: leave out planar");
    if (options.cell || options.periodic != std::array<bool, 3>{})
        unsupported("it works in a domain that is not periodic: leave out periodic and cell");
    if (!options.walls.empty()) unsupported("it replaces walls: leave them out");
    if (options.outside != Outside::error)
        unsupported("seeds may lie outside of the mesh, but not outside of the box: leave out `outside`");
    if (options.min_face > 0 || options.min_area > 0) unsupported("leave out min_face and min_area");
    const Want& want = options.want;
    if (want.vertices || want.faces || want.counts)
        unsupported("the parts of cells have no vertices, faces and counts: leave these out of want, use pieces()");
    if (want.radii) unsupported("the parts of cells have no security radii: leave these out of want");
    if (options.box)
        for (std::size_t k = 0; k < 3; ++k)
            if (std::isinf(options.box->lower[k]) || std::isinf(options.box->upper[k]))
                unsupported("the box needs ends: leave it out, the default holds the mesh");
}

void check_in_box(const ClosedMesh& mesh, const Box& box) {
    for (std::size_t k = 0; k < 3; ++k)
        for (const double x : {mesh.bounds().lower[k], mesh.bounds().upper[k]})
            if (!(x > box.lower[k] && x < box.upper[k]))
                throw Error(ErrorCode::invalid_argument, std::string("mesh: it reaches ") + axis_name[k] + " = " +
                                                             number(x) + ", and the box spans " + number(box.lower[k]) +
                                                             " to " + number(box.upper[k]) +
                                                             ": give a box with the mesh strictly inside, or none");
}

Options without_mesh(const Options& options) {
    Options in_box = options;
    in_box.mesh.reset();
    return in_box;
}

double sum_of(std::span<const double> values) {
    Sum sum;
    for (const double x : values) sum += x;
    return sum.value();
}

std::size_t to_index(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

// Returns options of a run in the box in which the cells are made.
Options options_in_box(const ClosedMesh& mesh, const Points& points, const Options& options) {
    Options in_box = without_mesh(options);
    check_options(in_box);
    check_shape(points);
    if (in_box.box) {
        check_box(*in_box.box);
    } else {
        std::vector<CellStatus> outside;
        Box bounds = check_points(points, in_box, outside);
        for (std::size_t k = 0; k < 3; ++k) {
            bounds.lower[k] = std::min(bounds.lower[k], mesh.bounds().lower[k]);
            bounds.upper[k] = std::max(bounds.upper[k], mesh.bounds().upper[k]);
        }
        in_box.box = default_box(bounds, std::max<std::size_t>(points.count(), 1));
    }
    check_in_box(mesh, *in_box.box);
    return in_box;
}

class MeshRun {
public:
    MeshRun(const Points& points, const Options& options, const RunInBox& run)
        : options_(options),
          run_(run),
          points_(points),
          progress_(options.progress),
          cells_(std::make_shared<MeshCells>(checked(options))),
          mesh_(cells_->mesh) {
        copy(options_.weights, weights_);
        copy(options_.radii, radii_);
        if (options_.only) copy(*options_.only, only_);
    }

    Result make() {
        Options in_box = options_in_box(mesh_, points_, options_);
        wanted_ = with_implied(options_);
        in_box.want.neighbors = in_box.want.areas = in_box.want.radii = in_box.want.volumes = true;
        in_box.list_walls = false;
        in_box.progress = progress_.within({0, 0.5});
        job_ = validate(points_, in_box);
        mesh_.scale_by(job_.scale);
        result_ = run_(points_, in_box);
        keep_cells();
        const Stoppable stoppable(progress_);
        if (progress_) Stoppable::enter_stage({0.5, 0.95});
        sort_rows();
        cut_cells();
        fill_plain();
        measure_rows();
        write_rows();
        finish();
        return std::move(result_);
    }

private:
    static constexpr int unknown = MeshCells::cut;
    static constexpr double dropped = -1;  // instead of the area of a face

    [[nodiscard]] static TriangleMesh checked(const Options& options) {
        check_others(options);
        return *options.mesh;
    }
    // Both parts of the run read the same copy, see input/snapshot.hpp.
    template <class Number>
    static void copy(std::span<const Number>& numbers, std::vector<Number>& to) {
        if (numbers.empty()) return;
        to.assign(numbers.begin(), numbers.end());
        numbers = to;
    }
    [[nodiscard]] std::size_t rows() const { return result_.status.size(); }
    [[nodiscard]] std::int32_t seed_of(std::size_t row) const { return cells_->seed_of(row); }
    [[nodiscard]] std::int64_t row_of(std::int32_t seed) const { return job_.only ? job_.only->row_of(seed) : seed; }
    [[nodiscard]] exact::Point place(std::int32_t seed) const { return cells_->place(seed); }
    [[nodiscard]] std::span<const std::int32_t> row(std::size_t r) const { return cells_->row(r); }
    [[nodiscard]] std::size_t entry(std::size_t r, std::int32_t neighbor) const {
        const auto ids = row(r);
        const auto at = std::ranges::lower_bound(ids, neighbor);
        return at != ids.end() && *at == neighbor ? to_index(cells_->indptr[r]) + to_index(at - ids.begin()) : no_entry;
    }
    static constexpr std::size_t no_entry = std::numeric_limits<std::size_t>::max();

    // Keeps all neighbors, for pieces() too.
    void keep_cells() {
        cells_->domain = job_.domain;
        cells_->scale = job_.scale;
        cells_->seeds.resize(points_.coordinates());
        for (std::size_t i = 0; i < points_.coordinates(); ++i) cells_->seeds[i] = points_[i] * job_.scale;
        cells_->ids = result_.ids;
        cells_->indptr = std::move(result_.indptr);
        cells_->indices = std::move(result_.indices);
    }

    const CutMeasures& cut(std::size_t r, CutCell& cell) const {
        cells_->make(r, cell);
        return cell.measure();
    }

    // Sorts the rows by the blocks of a grid around the mesh, because near cells need the same memory.
    void sort_rows() {
        constexpr double rows_per_block = 8;
        const Box& box = mesh_.bounds();  // as points_
        const Vector3 size = minus(box.upper, box.lower);
        const double longest = std::max({size[0], size[1], size[2]});
        double share = 1;  // of a cube
        for (const double x : size) share *= std::max(x / longest, min_share);
        const double blocks = std::cbrt(static_cast<double>(rows()) / rows_per_block / share);  // along the longest
        std::array<std::size_t, 3> side;
        for (std::size_t k = 0; k < 3; ++k) side[k] = static_cast<std::size_t>(blocks * size[k] / longest) + 1;
        std::vector<std::uint32_t> block(rows()), begin(side[0] * side[1] * side[2] + 1);
        order_.resize(rows());
        for (std::size_t r = 0; r < rows(); ++r) {
            std::size_t at = 0;
            for (std::size_t k = 3; k-- > 0;) {
                const double along = (points_[3 * to_index(seed_of(r)) + k] - box.lower[k]) / longest * blocks;
                at = at * side[k] + static_cast<std::size_t>(std::clamp(along, 0.0, static_cast<double>(side[k] - 1)));
            }
            block[r] = static_cast<std::uint32_t>(at);
            ++begin[at + 1];
        }
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        for (std::size_t r = 0; r < rows(); ++r) order_[begin[block[r]]++] = static_cast<std::uint32_t>(r);
    }

    // Returns a bound on the distance from a seed to its cell's vertices, scaled.
    [[nodiscard]] double reach(std::size_t r) const {
        return 0.5 * result_.security_radii[r] * job_.scale * (1 + radius_slack);
    }
    // Returns whether a triangle may come near any cell of order_[begin] to order_[end - 1].
    [[nodiscard]] bool any_near(std::size_t begin, std::size_t end) const {
        exact::Point middle{};
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                middle[k] += place(seed_of(order_[i]))[k] / static_cast<double>(end - begin);
        double distance = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t r = order_[i];
            if (result_.status[r] != CellStatus::certified) continue;
            const Vector3 from = minus(place(seed_of(r)), middle);
            distance = std::max(distance, length3(from[0], from[1], from[2]) + reach(r));
        }
        return mesh_.any_near(middle, distance);
    }

    // Cuts the cells that triangles come near, on all threads. The others are plain.
    void cut_cells() {
        const std::size_t count = rows();
        plain_.assign(count, 0);
        winding_.assign(count, unknown);
        empty_.assign(count, 0);
        result_.mesh_areas.resize_uninitialized(count);
        std::ranges::fill(result_.mesh_areas, 0.0);
        const double unscale = 1 / job_.scale, square = unscale * unscale;
        ThreadPool pool(options_.threads);
        std::vector<std::unique_ptr<CutCell>> cells(pool.size());
        const auto task = [&](std::size_t index, unsigned worker) {
            if (!cells[worker]) cells[worker] = std::make_unique<CutCell>(mesh_, *job_.domain, wanted_.centroids);
            const std::size_t end = std::min(count, (index + 1) * rows_per_task);
            bool near = true;  // whether triangles may come near the current group
            for (std::size_t k = index * rows_per_task; k < end; ++k) {
                check_stop();
                if (k % rows_per_group == 0) near = any_near(k, std::min(end, k + rows_per_group));
                const std::size_t r = order_[k];
                if (result_.status[r] != CellStatus::certified) continue;
                if (!near || !mesh_.any_near(place(seed_of(r)), reach(r))) {
                    plain_[r] = 1;
                    continue;
                }
                const CutMeasures& m = cut(r, *cells[worker]);
                winding_[r] = m.winding;
                plain_[r] = m.meets_surface ? 0 : 1;
                if (!m.meets_surface) continue;
                empty_[r] = std::abs(m.volume) <= m.volume_error ? 1 : 0;  // it only touches the mesh
                result_.volumes[r] = empty_[r] != 0 ? 0 : m.volume * square * unscale;
                result_.mesh_areas[r] = m.surface * square;
                if (wanted_.centroids)
                    for (std::size_t k = 0; k < 3; ++k)
                        result_.centroids[3 * r + k] = (m.centroid[k] + place(seed_of(r))[k]) * unscale;
                for (const CutMeasures::Face& face : m.faces) {
                    const std::size_t e = entry(r, face.id);
                    if (e == no_entry) continue;
                    result_.face_areas[e] = face.area > face.error ? face.area * square : dropped;
                }
            }
        };
        pool.run_stage(ceil_div(count, rows_per_task), std::cref(task));
    }

    // Finds the winding numbers of plain cells. Neighbors that are plain have the same.
    void fill_plain() {
        CutCell cell(mesh_, *job_.domain, false);
        std::vector<std::size_t> pending;
        std::vector<std::uint8_t> done(rows());
        const auto spread = [&](std::size_t start) {
            done[start] = 1;
            pending.assign(1, start);
            while (!pending.empty()) {
                const std::size_t r = pending.back();
                pending.pop_back();
                for (const std::int32_t j : row(r)) {
                    const std::int64_t other = row_of(j);
                    if (other < 0 || plain_[to_index(other)] == 0 || done[to_index(other)] != 0) continue;
                    winding_[to_index(other)] = winding_[r];
                    done[to_index(other)] = 1;
                    pending.push_back(to_index(other));
                }
            }
        };
        for (const bool known : {true, false})
            for (std::size_t r = 0; r < rows(); ++r) {
                if (plain_[r] == 0 || done[r] != 0 || (known && winding_[r] == unknown)) continue;
                check_stop();
                if (winding_[r] == unknown) winding_[r] = cut(r, cell).winding;
                spread(r);
            }
        for (std::size_t r = 0; r < rows(); ++r) {
            if (plain_[r] == 0) continue;
            result_.volumes[r] *= winding_[r];
            empty_[r] = winding_[r] == 0 ? 1 : 0;
            if (winding_[r] == 1) continue;
            for (std::size_t e = to_index(cells_->indptr[r]); e < to_index(cells_->indptr[r + 1]); ++e)
                result_.face_areas[e] *= std::abs(winding_[r]);
        }
    }

    // Gives both cells of a face the area that one of them has found: the cut one, of two the lower.
    void measure_rows() {
        auto& areas = result_.face_areas;
        for (const std::uint32_t r : order_)  // the rows of neighbors are then near in memory
            for (std::size_t e = to_index(cells_->indptr[r]); e < to_index(cells_->indptr[r + 1]); ++e) {
                const std::int32_t seed = seed_of(r), neighbor = cells_->indices[e];
                const std::int64_t other = row_of(neighbor);
                if (empty_[r] != 0) areas[e] = dropped;
                if (other < 0) continue;
                const std::size_t o = to_index(other);
                if (neighbor < seed) continue;  // that row sets both
                const std::size_t back = entry(o, seed);
                if (back == no_entry) continue;
                if (empty_[r] != 0 || empty_[o] != 0)
                    areas[e] = dropped;
                else if (plain_[r] != 0 && plain_[o] == 0)
                    areas[e] = areas[back];
                areas[back] = areas[e];
            }
    }

    // Drops faces outside, and empties the cells outside.
    void write_rows() {
        result_.indptr.resize_uninitialized(rows() + 1);
        result_.indptr[0] = 0;
        result_.indices.resize_uninitialized(cells_->indices.size());
        std::size_t out = 0;
        for (std::size_t r = 0; r < rows(); ++r) {
            const auto begin = to_index(cells_->indptr[r]), end = to_index(cells_->indptr[r + 1]);
            const bool empty = empty_[r] != 0 || result_.status[r] != CellStatus::certified;
            if (empty && result_.status[r] == CellStatus::certified) {
                result_.status[r] = CellStatus::empty;
                if (wanted_.centroids)
                    for (std::size_t k = 0; k < 3; ++k)
                        result_.centroids[3 * r + k] = std::numeric_limits<double>::quiet_NaN();
            }
            if (empty) result_.mesh_areas[r] = 0;
            double surface = result_.mesh_areas[r];
            for (std::size_t e = begin; e < end; ++e) {
                const double area = result_.face_areas[e];
                if (area == dropped) continue;
                surface += area;
                result_.indices[out] = cells_->indices[e];
                result_.face_areas[out] = area;
                if (wanted_.normals) std::copy_n(&result_.face_normals[3 * e], 3, &result_.face_normals[3 * out]);
                ++out;
            }
            if (wanted_.surfaces) result_.surface_areas[r] = empty ? 0 : surface;
            result_.indptr[r + 1] = static_cast<std::int64_t>(out);
        }
        result_.indices.resize_uninitialized(out);
        result_.face_areas.resize_uninitialized(out);
        if (wanted_.normals) result_.face_normals.resize_uninitialized(3 * out);
    }

    void finish() {
        for (std::size_t r = 0; r < rows(); ++r)
            cells_->winding.push_back(result_.status[r] != CellStatus::certified ? 0
                                      : plain_[r] != 0                           ? winding_[r]
                                                                                 : MeshCells::cut);
        result_.mesh_cells = cells_;
        result_.lists_walls = false;
        result_.security_radii = {};
        Stats& stats = result_.stats;
        stats.faces = result_.indices.size();
        stats.empty_cells = static_cast<std::uint64_t>(
            std::ranges::count_if(result_.status, [](CellStatus status) { return status != CellStatus::certified; }));
        const std::uint64_t cells = stats.points - stats.empty_cells;
        stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
        stats.box_volume = mesh_.volume();
        stats.volume_sum = wanted_.volumes ? sum_of(result_.volumes) : 0;
        stats.tiny_faces.reset();
        if (!wanted_.areas) result_.face_areas = {};
        if (!wanted_.volumes) result_.volumes = {};
        if (!wanted_.surfaces) result_.mesh_areas = {};
        if (!wanted_.neighbors) result_.indptr = {}, result_.indices = {};
    }

    Options options_;
    std::vector<double> weights_, radii_;
    std::vector<std::int64_t> only_;
    const RunInBox& run_;
    Points points_;
    Progress progress_;
    std::shared_ptr<MeshCells> cells_;
    ClosedMesh& mesh_;
    Want wanted_;
    Job job_;
    Result result_;
    std::vector<std::uint32_t> order_;         // of rows, by place
    std::vector<std::uint8_t> plain_, empty_;  // by row
    std::vector<int> winding_;                 // by row, of plain cells
};

}  // namespace

Result run_in_mesh(const Points& points, const Options& options, const RunInBox& run) {
    return MeshRun(points, options, run).make();
}

BoxAround box_around(const Points& points, const Options& options) {
    check_others(options);
    const ClosedMesh mesh(*options.mesh);
    return {options_in_box(mesh, points, options), mesh.volume()};
}

void check_in_mesh(const Options& options) {
    check_others(options);
    (void)ClosedMesh(*options.mesh);
    check_options(without_mesh(options));
}

}  // namespace votess::solid
