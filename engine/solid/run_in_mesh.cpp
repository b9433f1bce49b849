#include "solid/run_in_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#include "core/at.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"
#include "core/sum.hpp"
#include "core/text.hpp"
#include "core/thread_pool.hpp"
#include "input/default_box.hpp"
#include "input/option_name.hpp"
#include "input/settle.hpp"
#include "result/arrays.hpp"
#include "result/drop_faces.hpp"
#include "solid/closed_mesh.hpp"
#include "solid/cut_cell.hpp"
#include "solid/mesh_cells.hpp"

namespace votess::solid {
namespace {

using detail::Result;

constexpr double position_rounding = 0x1p-50;  // of a coordinate
constexpr double radius_slack = 1e-4;          // covers the error of a radius from a GPU
constexpr double min_share = 1e-3;             // of a flat mesh's bounds in a cube, along one axis
constexpr std::size_t rows_per_task = 256, rows_per_group = 8;

// To rounding. Longer meshes would need many images of each cell.
void check_in_cell(const ClosedMesh& mesh, const Domain& domain, double scale) {
    constexpr double slack = 1e-9;
    for (std::size_t v = 0; v < mesh.vertices(); ++v) {
        exact::Point x = mesh.vertex(static_cast<std::int32_t>(v));
        for (double& coordinate : x) coordinate *= scale;
        for (const double f : domain.fraction(x))
            if (!(f >= -slack && f <= 1 + slack))
                throw Error(ErrorCode::invalid_argument, option("mesh") + ": vertex " + std::to_string(v) +
                                                             " lies outside of the cell: move the mesh into it");
    }
}

double sum_of(std::span<const double> values) {
    Sum sum;
    for (const double x : values) sum += x;
    return sum.value();
}

// Cuts whole cells, in rows.
class MeshCut {
public:
    // cells: with the mesh and the seeds, in units of the job. job: with the rows of a subset. wanted: of the cut.
    // kept: the rows wanted, the first ones; the others tell them the areas of faces.
    MeshCut(std::shared_ptr<MeshCells> cells, const Job& job, const Wanted& wanted, std::size_t kept)
        : cells_(std::move(cells)),
          mesh_(cells_->mesh),
          wanted_(wanted.want),
          min_face_(wanted.min_face),
          min_area_(wanted.min_area),
          kept_(kept),
          job_(job),
          has_areas_(wanted_.areas || wanted_.surfaces) {}

    // Returns the arrays that a cut needs, and those that it passes on.
    [[nodiscard]] static Want of_whole_cells(Want wanted) {
        wanted.areas |= wanted.surfaces;
        wanted.neighbors = wanted.radii = wanted.volumes = true;
        return wanted;
    }

    // whole: without walls.
    [[nodiscard]] Result make(Result whole) {
        result_ = std::move(whole);
        keep_cells();
        if (job_.domain->is_periodic()) find_images();
        sort_rows();
        cut_cells();
        fill_plain();
        decide_faces();
        share_areas();
        drop_others();
        write_rows();
        finish();
        return std::move(result_);
    }

private:
    static constexpr int unknown = MeshCells::cut;
    static constexpr std::uint8_t unsure = 2;

    [[nodiscard]] std::size_t rows() const { return result_.status.size(); }
    [[nodiscard]] std::int32_t seed_of(std::size_t row) const { return cells_->seed_of(row); }
    [[nodiscard]] std::int64_t row_of(std::int32_t seed) const { return job_.only ? job_.only->row_of(seed) : seed; }
    [[nodiscard]] exact::Point place(std::int32_t seed) const { return cells_->place(seed); }
    // Returns the place of an image, rounded once.
    [[nodiscard]] exact::Point position(std::int32_t seed, const exact::Shift& shift) const {
        const exact::Shift move = cells_->move(seed, shift);
        if (move == exact::Shift{}) return place(seed);
        const auto x = exact::differences({}, exact::Plane::bisector(place(seed), move, job_.domain->lattice)).x;
        return {x[0].high, x[1].high, x[2].high};
    }
    // Returns the entry of a neighbor by its id and shift, or no_entry.
    [[nodiscard]] std::size_t entry(std::size_t r, std::int32_t neighbor, const exact::Shift& shift) const {
        const auto ids = cells_->row(r);
        const auto found = std::ranges::lower_bound(ids, neighbor);
        std::size_t e = at(cells_->indptr[r]) + at(found - ids.begin());
        for (; e < at(cells_->indptr[r + 1]) && cells_->indices[e] == neighbor; ++e)
            if (cells_->shift(e) == shift) return e;
        return no_entry;
    }
    static constexpr std::size_t no_entry = std::numeric_limits<std::size_t>::max();
    static exact::Shift opposite(const exact::Shift& shift) { return {-shift[0], -shift[1], -shift[2]}; }

    // Keeps all neighbors, for pieces() too.
    void keep_cells() {
        cells_->domain = job_.domain;
        cells_->scale = job_.scale;
        if (job_.region.thickness > 0) cells_->raise();
        if (job_.only) cells_->ids = job_.only->ids();
        cells_->indptr = std::move(result_.indptr);
        cells_->indices = std::move(result_.indices);
        cells_->shifts = std::move(result_.shifts);
        dropped_.assign(cells_->indices.size(), 0);
    }

    // Finds the images of cells that may reach the mesh, and where seeds lie inside a periodic domain.
    void find_images() {
        const Domain& domain = *job_.domain;
        const auto seeds = static_cast<std::int32_t>(cells_->seeds.size() / 3);
        std::vector<exact::Shift> wraps(at(seeds));
        for (std::int32_t i = 0; i < seeds; ++i) wraps[at(i)] = wrap(domain, place(i)).value_or(exact::Shift{});
        if (std::ranges::any_of(wraps, [](const exact::Shift& shift) { return shift != exact::Shift{}; }))
            cells_->wraps = std::move(wraps);
        const Box& bounds = mesh_.placed();
        cells_->image_offsets.assign(1, 0);
        for (std::size_t r = 0; r < rows(); ++r) {
            check_stop();
            // An image of the mesh comes near the cell, as an image of the cell near the mesh.
            if (result_.status[r] == CellStatus::certified) {
                const ShiftRange range = shifts_around(domain, bounds, position(seed_of(r), {}), reach(r));
                const auto& [u, v, w] = domain.reduced.shift;
                for (std::int32_t a = range.lower[0]; a <= range.upper[0]; ++a)
                    for (std::int32_t b = range.lower[1]; b <= range.upper[1]; ++b)
                        for (std::int32_t c = range.lower[2]; c <= range.upper[2]; ++c)
                            cells_->image_shifts.push_back({-a * u[0] - b * v[0] - c * w[0],
                                                            -a * u[1] - b * v[1] - c * w[1],
                                                            -a * u[2] - b * v[2] - c * w[2]});
            }
            cells_->image_offsets.push_back(cells_->image_shifts.size());
        }
    }

    const CutMeasures& cut(std::size_t r, std::size_t image, CutCell& cell, bool decide_faces = false) const {
        cells_->make(r, image, cell);
        return cell.measure(decide_faces);
    }

    // Sorts the rows by the blocks of a grid around the mesh, because near cells need the same memory.
    void sort_rows() {
        constexpr double rows_per_block = 8;
        const Box& box = mesh_.placed();
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
                const double along = (place(seed_of(r))[k] - box.lower[k]) / longest * blocks;
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
    // Returns whether a triangle may come near an image of the cell of a row.
    [[nodiscard]] bool any_near(std::size_t r) const {
        const auto [first, last] = cells_->images(r);
        for (std::size_t i = first; i < last; ++i) {
            const exact::Point x = position(seed_of(r), cells_->image_shift(i));
            const double size = std::abs(x[0]) + std::abs(x[1]) + std::abs(x[2]);
            if (mesh_.any_near(x, reach(r) + position_rounding * size)) return true;
        }
        return false;
    }
    // Returns false only if no triangle comes near any cell of order_[begin] to order_[end - 1]. One query for all.
    [[nodiscard]] bool any_near_group(std::size_t begin, std::size_t end) const {
        if (!cells_->image_offsets.empty()) return true;
        exact::Point middle{};
        for (std::size_t i = begin; i < end; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                middle[k] += place(seed_of(order_[i]))[k] / static_cast<double>(end - begin);
        double distance = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t r = order_[i];
            if (result_.status[r] != CellStatus::certified) continue;
            const Vector3 from = minus(place(seed_of(r)), middle);
            distance = std::max(distance, length3(from) + reach(r));
        }
        return mesh_.any_near(middle, distance);
    }

    // Cuts the cells that triangles come near, on all threads. The others are plain.
    void cut_cells() {
        const std::size_t count = rows();
        plain_.assign(count, 1);
        winding_.assign(cells_->image_offsets.empty() ? count : cells_->image_offsets.back(), unknown);
        empty_.assign(count, 0);
        result_.mesh_areas.resize_uninitialized(count);
        std::ranges::fill(result_.mesh_areas, 0.0);
        ThreadPool pool(job_.threads);
        std::vector<std::unique_ptr<CutCell>> cells(pool.size());
        const auto task = [&](std::size_t index, unsigned worker) {
            if (!cells[worker]) cells[worker] = std::make_unique<CutCell>(mesh_, *cells_->domain, wanted_.centroids);
            const std::size_t end = std::min(count, (index + 1) * rows_per_task);
            bool near = true;  // whether triangles may come near the current group
            for (std::size_t k = index * rows_per_task; k < end; ++k) {
                check_stop();
                if (k % rows_per_group == 0) near = any_near_group(k, std::min(end, k + rows_per_group));
                const std::size_t r = order_[k];
                if (result_.status[r] != CellStatus::certified)
                    plain_[r] = 0;
                else if (near && any_near(r))
                    cut_row(r, *cells[worker]);
            }
        };
        pool.run_stage(ceil_div(count, rows_per_task), std::cref(task));
    }

    // Cuts the images of a cell, and adds their measures.
    void cut_row(std::size_t r, CutCell& cell) {
        const std::size_t begin = at(cells_->indptr[r]), end = at(cells_->indptr[r + 1]);
        const MeasureUnit unit = job_.unit();
        const auto [first, last] = cells_->images(r);
        std::vector<double> whole;  // areas
        if (has_areas_) {
            const auto areas = std::span<const double>(result_.face_areas).subspan(begin, end - begin);
            whole.assign(areas.begin(), areas.end());
        }
        std::vector<std::size_t> plain;  // images
        double volume = 0;               // scaled, as it may not be a number otherwise
        std::array<double, 3> moment{};
        bool touches = true;
        for (std::size_t i = first; i < last; ++i) {
            const CutMeasures& m = cut(r, i, cell);
            winding_[i] = m.winding;
            if (!m.meets_surface) {
                plain.push_back(i);
                continue;
            }
            if (plain_[r] != 0) {
                plain_[r] = 0;
                std::fill(dropped_.begin() + static_cast<std::ptrdiff_t>(begin),
                          dropped_.begin() + static_cast<std::ptrdiff_t>(end), 1);
            }
            winding_[i] = unknown;
            result_.mesh_areas[r] += unit.area(m.surface);
            for (const CutMeasures::Face& face : m.faces) {
                const std::size_t e = entry(r, face.id, face.shift);
                if (e == no_entry || (face.area == 0 && !face.is_unsure)) continue;
                if (!face.is_unsure)
                    add_area(e, unit.area(face.area));
                else if (dropped_[e] == 1)
                    dropped_[e] = unsure;
            }
            if (m.empty) continue;
            touches = false;
            volume += m.volume;
            for (std::size_t k = 0; k < 3; ++k) moment[k] += m.volume * m.centroid[k];
        }
        if (plain_[r] != 0) return;
        const exact::Point x = position(seed_of(r), {});
        for (const std::size_t i : plain) {
            if (winding_[i] == 0) continue;
            touches = false;
            const double part = winding_[i] * (result_.volumes[r] / unit.volume(1));
            volume += part;
            if (wanted_.centroids)
                for (std::size_t k = 0; k < 3; ++k)
                    moment[k] += part * (result_.centroids[3 * r + k] * job_.scale - x[k]);
            for (std::size_t e = begin; e < end; ++e)
                add_area(e, has_areas_ ? std::abs(winding_[i]) * whole[e - begin] : 0);
        }
        empty_[r] = touches ? 1 : 0;
        result_.volumes[r] = unit.volume(volume);
        if (wanted_.centroids)
            for (std::size_t k = 0; k < 3; ++k) result_.centroids[3 * r + k] = unit.length(moment[k] / volume + x[k]);
    }
    // Adds to the area of a face that was dropped so far, or has a part already.
    void add_area(std::size_t e, double area) {
        if (has_areas_) result_.face_areas[e] = dropped_[e] != 0 ? area : result_.face_areas[e] + area;
        dropped_[e] = 0;
    }

    // Finds the winding numbers of plain cells. Neighbors that are plain have the same.
    void fill_plain() {
        CutCell cell(mesh_, *cells_->domain, false);
        struct Place {
            std::size_t row, image;
        };
        std::vector<Place> pending;
        std::vector<std::uint8_t> done(winding_.size());
        const bool repeats = !cells_->image_offsets.empty();
        const auto image_of = [&](std::size_t r, const exact::Shift& shift) {
            const auto [first, last] = cells_->images(r);
            std::size_t i = first;
            while (i < last && cells_->image_shift(i) != shift) ++i;
            return i < last ? i : no_entry;
        };
        const auto spread = [&](const Place& start) {
            done[start.image] = 1;
            pending.assign(1, start);
            while (!pending.empty()) {
                const auto [r, image] = pending.back();
                pending.pop_back();
                const exact::Shift shift = cells_->image_shift(image);
                for (std::size_t e = at(cells_->indptr[r]); e < at(cells_->indptr[r + 1]); ++e) {
                    const std::int64_t other = row_of(cells_->indices[e]);
                    if (other < 0 || plain_[at(other)] == 0) continue;
                    const std::size_t i =
                        repeats ? image_of(at(other), MeshCells::sum(shift, cells_->shift(e))) : at(other);
                    if (i == no_entry || done[i] != 0) continue;
                    winding_[i] = winding_[image];
                    done[i] = 1;
                    pending.push_back({at(other), i});
                }
            }
        };
        for (const bool known : {true, false})
            for (std::size_t r = 0; r < rows(); ++r) {
                if (plain_[r] == 0) continue;
                check_stop();
                const auto [first, last] = cells_->images(r);
                for (std::size_t i = first; i < last; ++i) {
                    if (done[i] != 0 || (known && winding_[i] == unknown)) continue;
                    if (winding_[i] == unknown) winding_[i] = cut(r, i, cell).winding;
                    spread({r, i});
                }
            }
        for (std::size_t r = 0; r < rows(); ++r) {
            if (plain_[r] == 0) continue;
            int sum = 0, sheets = 0;
            const auto [first, last] = cells_->images(r);
            for (std::size_t i = first; i < last; ++i) sum += winding_[i], sheets += std::abs(winding_[i]);
            result_.volumes[r] = sum == 0 ? 0 : sum * result_.volumes[r];  // which may be infinite
            empty_[r] = sheets == 0 ? 1 : 0;
            if (sheets == 1 || !has_areas_) continue;
            for (std::size_t e = at(cells_->indptr[r]); e < at(cells_->indptr[r + 1]); ++e)
                result_.face_areas[e] *= sheets;
        }
    }

    // Finds out whether faces exist that are as small as rounding. Empty neighbors have none.
    void decide_faces() {
        ThreadPool pool(job_.threads);
        std::vector<std::unique_ptr<CutCell>> cells(pool.size());
        const auto task = [&](std::size_t index, unsigned worker) {
            for (std::size_t k = index * rows_per_task; k < std::min(rows(), (index + 1) * rows_per_task); ++k) {
                check_stop();
                const std::size_t r = order_[k], end = at(cells_->indptr[r + 1]);
                bool decides = false;
                for (std::size_t e = at(cells_->indptr[r]); e < end; ++e) {
                    if (dropped_[e] != unsure) continue;
                    const std::int64_t other = row_of(cells_->indices[e]);
                    if (empty_[r] != 0 || (other >= 0 && empty_[at(other)] != 0)) dropped_[e] = 1;
                    decides |= dropped_[e] == unsure;
                }
                if (!decides) continue;
                if (!cells[worker]) cells[worker] = std::make_unique<CutCell>(mesh_, *cells_->domain, false);
                decide_row(r, *cells[worker]);
            }
        };
        pool.run_stage(ceil_div(rows(), rows_per_task), std::cref(task));
    }

    void decide_row(std::size_t r, CutCell& cell) {
        const MeasureUnit unit = job_.unit();
        std::vector<std::pair<std::size_t, double>> found;  // entries and areas
        const auto [first, last] = cells_->images(r);
        for (std::size_t i = first; i < last; ++i) {
            if (winding_[i] != unknown) continue;
            for (const CutMeasures::Face& face : cut(r, i, cell, true).faces)
                if (const std::size_t e = entry(r, face.id, face.shift);
                    e != no_entry && dropped_[e] == unsure && face.area > 0)
                    found.emplace_back(e, unit.area(face.area));
        }
        for (const auto& [e, area] : found) add_area(e, area);
        for (std::size_t e = at(cells_->indptr[r]); e < at(cells_->indptr[r + 1]); ++e)
            if (dropped_[e] == unsure) dropped_[e] = 1;
    }

    // Gives both cells of a face the area that one of them has found: the one of less surface, whose errors are
    // smaller. A cell that the mesh does not cut may not know of triangles on the face.
    void share_areas() {
        if (!has_areas_) return;
        constexpr double agreement = 0x1p-44;  // of the surface; beyond it triangles lie on the face
        auto& areas = result_.face_areas;
        std::vector<double> surface(rows());
        for (std::size_t r = 0; r < rows(); ++r) {
            surface[r] = result_.mesh_areas[r];
            for (std::size_t e = at(cells_->indptr[r]); e < at(cells_->indptr[r + 1]); ++e)
                if (dropped_[e] == 0) surface[r] += areas[e];
        }
        for (std::size_t k = 0; k < rows(); ++k) {
            const std::uint32_t r = order_[k];  // the rows of neighbors are then near in memory
            for (std::size_t e = at(cells_->indptr[r]); e < at(cells_->indptr[r + 1]); ++e) {
                const std::int32_t seed = seed_of(r), neighbor = cells_->indices[e];
                const exact::Shift shift = cells_->shift(e);
                if (neighbor < seed || (neighbor == seed && shift < exact::Shift{})) continue;  // set from there
                const std::int64_t other = row_of(neighbor);
                if (other < 0 || dropped_[e] != 0) continue;
                const std::size_t o = at(other), back = entry(o, seed, opposite(shift));
                if (back == no_entry) continue;
                bool from_other = surface[o] < surface[r];
                const bool one_is_plain = plain_[r] != plain_[o], is_smaller_plain = plain_[from_other ? o : r] != 0;
                if (one_is_plain && is_smaller_plain)
                    from_other ^= !(std::abs(areas[e] - areas[back]) <= agreement * surface[from_other ? r : o]);
                areas[from_other ? e : back] = areas[from_other ? back : e];
            }
        }
    }

    // Drops the rows that are not kept, which are the last ones.
    void drop_others() {
        if (kept_ == rows()) return;
        const std::size_t images = cells_->images(kept_).first;
        detail::for_arrays([&](const auto& array) {
            auto& values = array.of(result_);
            if (array.per == Per::cell && !values.empty()) values.resize_uninitialized(array.components * kept_);
        });
        if (!result_.weights.empty()) result_.weights.resize_uninitialized(kept_);
        result_.stats.points = kept_;
        cells_->ids.resize(kept_);
        cells_->indptr.resize_uninitialized(kept_ + 1);
        const std::size_t entries = at(cells_->indptr[kept_]);
        cells_->indices.resize_uninitialized(entries);
        if (!cells_->shifts.empty()) cells_->shifts.resize_uninitialized(3 * entries);
        winding_.resize(images);
        if (cells_->image_offsets.empty()) return;
        cells_->image_offsets.resize(kept_ + 1);
        cells_->image_shifts.resize(images);
    }

    // Drops faces outside, and empties the cells outside.
    void write_rows() {
        const auto copy = [](const auto& from, auto& to) {
            to.resize_uninitialized(from.size());
            std::ranges::copy(from, to.begin());
        };
        copy(cells_->indptr, result_.indptr);
        copy(cells_->indices, result_.indices);
        copy(cells_->shifts, result_.shifts);
        std::vector<bool> stays(cells_->indices.size());
        for (std::size_t r = 0; r < rows(); ++r) {
            const auto begin = at(cells_->indptr[r]), end = at(cells_->indptr[r + 1]);
            const bool empty = empty_[r] != 0 || result_.status[r] != CellStatus::certified;
            if (empty && result_.status[r] == CellStatus::certified) {
                result_.status[r] = CellStatus::empty;
                if (wanted_.centroids)
                    for (std::size_t k = 0; k < 3; ++k)
                        result_.centroids[3 * r + k] = std::numeric_limits<double>::quiet_NaN();
            }
            double surface = result_.mesh_areas[r];
            for (std::size_t e = begin; e < end; ++e) {
                stays[e] = !empty && dropped_[e] == 0;
                if (stays[e] && has_areas_) surface += result_.face_areas[e];
            }
            if (wanted_.surfaces) result_.surface_areas[r] = surface;
        }
        detail::keep_entries(result_, stays);
    }

    void finish() {
        for (std::size_t r = 0; r < rows(); ++r) {
            const auto [first, last] = cells_->images(r);
            if (result_.status[r] != CellStatus::certified)
                std::fill(winding_.begin() + static_cast<std::ptrdiff_t>(first),
                          winding_.begin() + static_cast<std::ptrdiff_t>(last), 0);
        }
        cells_->winding = std::move(winding_);
        result_.mesh_cells = cells_;
        result_.lists_walls = false;
        result_.security_radii = {};
        if (min_face_ > 0 || min_area_ > 0) (void)drop_small_faces(result_, min_face_, min_area_);
        Stats& stats = result_.stats;
        stats.faces = result_.indices.size();
        stats.empty_cells = static_cast<std::uint64_t>(
            std::ranges::count_if(result_.status, [](CellStatus status) { return status != CellStatus::certified; }));
        const std::uint64_t cells = stats.points - stats.empty_cells;
        stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
        stats.box_volume = volume_in(mesh_, job_.region);
        stats.moved_vertices = mesh_.moved_vertices();
        stats.moved_distance = mesh_.moved_distance();
        stats.volume_sum = wanted_.volumes ? sum_of(result_.volumes) : 0;
        stats.tiny_faces.reset();
        detail::keep_wanted(result_, wanted_, false);
    }

    std::shared_ptr<MeshCells> cells_;
    const ClosedMesh& mesh_;
    const Want wanted_;
    const double min_face_, min_area_;
    const std::size_t kept_;
    const Job& job_;
    const bool has_areas_;
    Result result_;
    std::vector<std::uint32_t> order_;         // of rows, by place
    std::vector<std::uint8_t> plain_, empty_;  // by row
    std::vector<std::uint8_t> dropped_;        // by entry: 1 for faces without a part inside; unsure
    std::vector<int> winding_;                 // by image, of plain ones
};

// Returns the seeds of a run's subset, then their neighbors.
std::vector<std::int64_t> with_neighbors(Settled part, const RunInBox& run) {
    std::vector<std::int64_t> ids = *part.subset;
    std::vector<bool> listed(part.points.count());
    part.want = {.neighbors = true, .volumes = false};
    const Result rows = run(std::move(part));
    for (const std::int64_t id : ids) listed[at(id)] = true;
    for (const std::int32_t id : rows.indices)
        if (id >= 0 && !listed[at(id)]) {
            listed[at(id)] = true;
            ids.push_back(id);
        }
    return ids;
}

}  // namespace

Result run_in_mesh(const Settled& whole, const RunInBox& run) {
    check_want(whole.want);
    const Points& points = whole.points;
    Progress progress(whole.progress);
    ClosedMesh mesh(*whole.region.mesh);
    Settled in_box = whole;
    in_box.region = region_around(mesh, whole);
    in_box.want = MeshCut::of_whole_cells(whole.want);
    in_box.list_walls = false;
    in_box.min_face = in_box.min_area = 0;  // they drop faces by their areas inside
    // A face has one area, by its cell of lower index or by the one that triangles cut.
    const bool more_cells = whole.subset && (whole.want.areas || whole.want.surfaces);
    in_box.progress = progress.within({0, 0.2});
    if (more_cells) in_box.subset = with_neighbors(in_box, run);
    in_box.progress = progress.within({more_cells ? 0.2 : 0, 0.5});
    const Job job = make_job(in_box);
    place_mesh(mesh, job);
    const auto cells = std::make_shared<MeshCells>(std::make_shared<const ClosedMesh>(std::move(mesh)));
    cells->seeds.resize(points.coordinates());
    for (std::size_t i = 0; i < points.coordinates(); ++i) cells->seeds[i] = points[i] * job.scale;
    cells->weights = job.domain->weights;
    Result cut = run(std::move(in_box));
    const Stoppable stoppable(progress, {0.5, 0.95});
    return MeshCut(cells, job, whole, whole.subset ? whole.subset->size() : cut.status.size()).make(std::move(cut));
}

Want want_of_probes(const Want& wanted) {
    check_want(wanted);
    return MeshCut::of_whole_cells(with_implied(wanted));
}

Result cut_probes(Result whole, std::span<const double> places, std::span<const double> weights,
                  std::shared_ptr<const ClosedMesh> mesh, const Job& job, const Want& wanted) {
    const std::size_t count = whole.status.size();
    std::vector<std::int32_t> seeds(whole.indices.begin(), whole.indices.end());  // neighbors
    const auto repeats = [&](std::size_t r) { return whole.status[r] == CellStatus::duplicate; };
    for (std::size_t r = 0; r < count; ++r)
        if (repeats(r)) seeds.push_back(whole.duplicate_of[r]);
    std::ranges::sort(seeds);
    const auto rest = std::ranges::unique(seeds);
    seeds.erase(rest.begin(), rest.end());
    if (!seeds.empty() && seeds.back() == *job.probes_of) seeds.pop_back();
    const auto first = static_cast<std::int32_t>(seeds.size());  // of the queries
    const auto cells = std::make_shared<MeshCells>(std::move(mesh));
    for (const std::int32_t seed : seeds)
        for (std::size_t k = 0; k < 3; ++k) cells->seeds.push_back(job.points[3 * at(seed) + k] * job.scale);
    for (const double x : places) cells->seeds.push_back(x * job.scale);
    if (job.domain->has_weights()) {
        for (const std::int32_t seed : seeds) cells->weights.push_back(job.domain->weights[at(seed)]);
        cells->weights.insert(cells->weights.end(), weights.begin(), weights.end());
        cells->weights.resize(at(first) + count);
    }
    for (std::size_t r = 0; r < count; ++r)
        for (std::size_t e = at(whole.indptr[r]); e < at(whole.indptr[r + 1]); ++e) {
            std::int32_t& id = whole.indices[e];
            const auto at = std::ranges::lower_bound(seeds, id);
            id = at != seeds.end() && *at == id ? static_cast<std::int32_t>(at - seeds.begin())
                                                : first + static_cast<std::int32_t>(r);
        }
    std::vector<std::int32_t> ids(count);
    std::iota(ids.begin(), ids.end(), first);
    // At the place of a seed the cell is that seed's, which may be its own neighbor.
    std::vector<std::size_t> duplicates;
    for (std::size_t r = 0; r < count; ++r) {
        if (!repeats(r)) continue;
        duplicates.push_back(r);
        ids[r] = static_cast<std::int32_t>(std::ranges::lower_bound(seeds, whole.duplicate_of[r]) - seeds.begin());
    }
    for (const std::size_t r : duplicates) whole.status[r] = CellStatus::certified;
    Job of_rows = job;
    of_rows.only = std::make_shared<const Subset>(std::move(ids));
    Wanted of_cut;
    of_cut.want = with_implied(wanted);
    cells->names = std::move(seeds);
    cells->names.resize(at(first) + count, *job.probes_of);
    Result result = MeshCut(cells, of_rows, of_cut, count).make(std::move(whole));
    for (std::int32_t& id : result.indices) id = cells->name(id);
    for (const std::size_t r : duplicates) result.status[r] = CellStatus::duplicate;
    return result;
}

Region region_around(const ClosedMesh& mesh, const Settled& run) {
    Region region = run.region;
    region.mesh.reset();
    if (!region.box && !region.cell) region.box = default_box_around(mesh, run.points);
    check_inside(mesh, region);
    return region;
}

void place_mesh(ClosedMesh& mesh, const Job& job) {
    if (job.domain->triclinic) check_in_cell(mesh, *job.domain, job.scale);
    mesh.scale_by(job.scale);
}

Box default_box_around(const ClosedMesh& mesh, const Points& points) {
    std::vector<CellStatus> outside;
    Box bounds = check_points(points, {}, outside);
    include(bounds, mesh.bounds());
    return default_box(bounds, std::max<std::size_t>(points.count(), 1));
}

void check_want(const Want& want) {
    const auto refuse = [](const std::string& what) {
        throw Error(ErrorCode::unsupported, option("mesh") + ": " + what);
    };
    if (want.vertices || want.faces || want.counts)
        refuse("the parts of cells have no vertices, faces and counts: leave these out of " + option("want") +
               ", use pieces()");
    if (exceeds(want, {.centroids = true, .areas = true, .normals = true, .surfaces = true}))
        refuse(
            "the parts of cells have volumes, centroids, areas, normals and surfaces: leave the other groups out of " +
            option("want"));
}

double volume_in(const ClosedMesh& mesh, const Region& region) {
    return mesh.volume(region.thickness > 0 ? mesh.bounds().upper[2] - mesh.bounds().lower[2] : 0);
}

void check_inside(const ClosedMesh& mesh, const Region& region) {
    if (!region.box) return;
    const Box& box = *region.box;
    for (std::size_t k = 0; k < (region.thickness > 0 ? 2 : 3); ++k)
        for (const double x : {mesh.bounds().lower[k], mesh.bounds().upper[k]}) {
            const bool inside = x > box.lower[k] && x < box.upper[k];
            if (inside || (region.periodic[k] && (x == box.lower[k] || x == box.upper[k]))) continue;
            throw Error(ErrorCode::invalid_argument,
                        option("mesh") + ": it reaches " + axis_name[k] + " = " + number(x) + ", and the box spans " +
                            number(box.lower[k]) + " to " + number(box.upper[k]) + ": give " + option("box") +
                            " with the mesh " + (region.periodic[k] ? "inside" : "strictly inside, or none"));
        }
}

}  // namespace votess::solid
