#include "unbounded/run_endless.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/at.hpp"
#include "core/box.hpp"
#include "core/progress.hpp"
#include "core/vector3.hpp"
#include "exact/insphere.hpp"
#include "result/arrays.hpp"
#include "result/drop_faces.hpp"
#include "unbounded/flat_ends.hpp"
#include "unbounded/open_cells.hpp"

namespace votess {
namespace {

using detail::Result;

constexpr std::size_t seeds_per_stop = 4096;
constexpr std::size_t min_near = 30;  // fewer seeds are as fast in the far box alone

// Sets the wanted measures of some rows of a result to those of rows of another one. Those of other rows stay.
// row_of: of each of `rows` in the other.
void take_measures(Result& result, const Want& want, const Result& some, std::span<const std::size_t> rows,
                   const auto& row_of) {
    const std::size_t count = result.status.size();
    const auto take = [&]<class T>(bool wanted, Buffer<T>& to, const Buffer<T>& from, std::size_t each) {
        if (!wanted) return;
        if (to.size() != each * count) {
            to.resize_uninitialized(each * count);
            std::ranges::fill(to, T{});
        }
        for (std::size_t k = 0; k < rows.size(); ++k) std::copy_n(&from[each * row_of(k)], each, &to[each * rows[k]]);
    };
    for_row_arrays([&](const auto& array, std::size_t) {
        if (array.per != Per::cell || array.word == nullptr || array.word == &Want::counts) return;
        take(want.*array.word, array.of(result), array.of(some), array.components);
    });
    if (!want.areas) return;
    if (result.face_areas.size() != result.indices.size()) {
        result.face_areas.resize_uninitialized(result.indices.size());
        std::ranges::fill(result.face_areas, 0);
    }
    for (std::size_t k = 0; k < rows.size(); ++k)
        std::copy(some.face_areas.begin() + some.indptr[row_of(k)],
                  some.face_areas.begin() + some.indptr[row_of(k) + 1],
                  result.face_areas.begin() + result.indptr[rows[k]]);
}

// Returns whether the seeds lie in one plane or on one line up to rounding, measured from three of them.
bool is_thin(const Points& points) {
    constexpr double thin = 0x1p-40;
    const std::size_t count = points.count();
    if (count == 0) return false;
    const Vector3 first = point_of(points, 0);
    const auto from_first = [&](std::size_t i) { return minus(point_of(points, i), first); };
    const auto largest = [&](const auto& size) {  // of those that are finite
        std::size_t at = 0;
        double most = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (i % seeds_per_stop == 0) check_stop();
            if (const double x = size(from_first(i)); x > most) most = x, at = i;
        }
        return std::pair{at, most};
    };
    const auto [second, extent] = largest([](const Vector3& x) { return length3(x); });
    if (!(extent > 0x1p-300 && extent < 0x1p300)) return false;
    const Vector3 along = from_first(second);
    const auto [third, area] = largest([&](const Vector3& x) { return length3(cross(along, x)); });
    if (area <= thin * extent * extent) return true;
    const Vector3 normal = cross(along, from_first(third));
    return largest([&](const Vector3& x) { return std::abs(dot(normal, x)); }).second <= thin * area * extent;
}

class EndlessRun {
public:
    EndlessRun(const Settled& whole, const RunInBox& run)
        : whole_(whole),
          run_(run),
          progress_(whole.progress),
          sides_(whole.region),
          flat_ends_(whole.points, whole.region),
          thin_(has_no_ends() && !flat_ends_.any() && whole.weights.empty() && is_thin(whole.points)) {}

    Result make() {
        const bool far_alone = thin_ || whole_.points.count() < min_near;
        Result result = far_alone ? far_cells(whole_, {0, 1}) : in_both_boxes();
        if (whole_.min_face > 0 || whole_.min_area > 0) {
            Stats& stats = result.stats;
            stats.faces -= drop_small_faces(result, whole_.min_face, whole_.min_area);
            const std::uint64_t cells = result.status.size() - stats.empty_cells;
            if (cells > 0) stats.mean_faces = static_cast<double>(stats.faces) / static_cast<double>(cells);
        }
        if (result.vertices.size() == 3 && !whole_.subset && result.vertex_image_of.empty()) find_tetrahedron(result);
        result.walls.clear();
        detail::keep_wanted(result, whole_.want, whole_.list_walls);
        return result;
    }

private:
    [[nodiscard]] bool has_no_ends() const {
        for (std::int32_t wall = -6; wall < 0; ++wall)
            if (!sides_.has(wall)) return false;
        return whole_.region.walls.empty();
    }
    // Runs a part, whose rows list walls. region: of the whole, with ends.
    [[nodiscard]] Result run(Settled part, Region region, const Want& want, const Share& share) {
        part.region = std::move(region);
        flat_ends_.cut(part.region);
        part.list_walls = true;
        part.want = want;
        part.want.neighbors = true;
        part.progress = progress_.within(share);
        part.min_face = part.min_area = 0;  // make() drops faces
        return run_(std::move(part));
    }
    // Open cells need polygons for areas and counts.
    [[nodiscard]] bool needs_polygons() const {
        return whole_.want.areas || whole_.want.counts || whole_.want.vertices;
    }

    void find_tetrahedron(Result& result) const {
        std::vector<std::int32_t> seeds;
        for (std::size_t i = 0; i < whole_.points.count(); ++i)
            if (result.cell_vertex_indptr[i] != result.cell_vertex_indptr[i + 1])
                seeds.push_back(static_cast<std::int32_t>(i));
        if (seeds.size() != 4) return;
        std::array<exact::Point, 4> x;
        double largest = 0;
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                x[k][axis] = whole_.points[3 * at(seeds[k]) + axis];
                largest = std::max(largest, std::abs(x[k][axis]));
            }
        const int exponent = std::ilogb(largest);
        for (exact::Point& point : x)
            for (double& coordinate : point) coordinate = std::ldexp(coordinate, -exponent);
        if (exact::orient(x[1], x[2], x[3], x[0]) < 0) std::swap(seeds[2], seeds[3]);
        result.lone_tetrahedron = {seeds[0], seeds[1], seeds[2], seeds[3]};
    }

    // Runs a part between far ends.
    Result run_far(Settled part, const Want& want, const Share& share) {
        Region region = whole_.region;
        end_far(region, part.points, part.weights);
        part.device = "cpu";  // no device clips so large a box
        return run(std::move(part), std::move(region), want, share);
    }

    // Returns the cells of a part. The first run finds the rows; a second one measures the cells that have an end. The
    // others take long to measure in so large a box, and have only faces to measure. Nearly all cells of thin seeds
    // have an end, and take long to find.
    Result far_cells(Settled part, const Share& share) {
        if (thin_) {
            Want all = whole_.want;
            all.faces |= needs_polygons();
            Result result = run_far(std::move(part), all, share);
            open_cells(result, whole_.region);
            return result;
        }
        Want rows = whole_.want;
        rows.volumes = rows.centroids = rows.surfaces = rows.radii = rows.areas = false;
        rows.faces |= needs_polygons();
        Result result = run_far(part, rows, share.part(0, 0.8));
        if (whole_.want.volumes || whole_.want.centroids || whole_.want.surfaces || whole_.want.radii ||
            whole_.want.areas) {
            std::vector<std::int64_t> ids;
            std::vector<std::size_t> closed;
            for (std::size_t i = 0; i < result.status.size(); ++i) {
                if (!whole_.want.areas && lists_end(result, i, [&](std::int32_t id) { return sides_.has(id); }))
                    continue;
                closed.push_back(i);
                ids.push_back(part.subset ? (*part.subset)[i] : static_cast<std::int64_t>(i));
            }
            Want measures = whole_.want;
            measures.counts = measures.normals = measures.vertices = measures.faces = false;
            Result some;
            if (!ids.empty()) {
                part.subset = std::move(ids);
                some = run_far(std::move(part), measures, share.part(0.8, 1));
            }
            take_measures(result, whole_.want, some, closed, [](std::size_t k) { return k; });
        }
        open_cells(result, whole_.region);
        return result;
    }

    Result near_cells() {
        Want want = whole_.want;
        want.faces |= needs_polygons();
        Region region = whole_.region;
        end_near(region, whole_.points, whole_.weights);
        return run(whole_, std::move(region), want, {0, 0.7});
    }
    // Returns the rows whose cells reach beyond the near box. A cell that is empty there may lie beyond it.
    std::vector<bool> find_taken(const Result& near) {
        std::vector<bool> taken(near.status.size());
        std::vector<std::int64_t> empty;
        for (std::size_t i = 0; i < taken.size(); ++i) {
            taken[i] = lists_end(near, i, [&](std::int32_t id) { return sides_.has(id) && !flat_ends_.has(id); });
            if (near.status[i] == CellStatus::empty) empty.push_back(static_cast<std::int64_t>(i));
        }
        if (whole_.subset || empty.empty()) {
            for (const std::int64_t i : empty) taken[at(i)] = true;
            return taken;
        }
        Settled part = whole_;
        part.subset = empty;
        const Result beyond = run_far(std::move(part), {.neighbors = true, .volumes = false}, {0.7, 0.8});
        for (std::size_t k = 0; k < empty.size(); ++k) taken[at(empty[k])] = beyond.status[k] != CellStatus::empty;
        return taken;
    }

    Result in_both_boxes() {
        Result near = near_cells();
        const std::vector<bool> taken = find_taken(near);
        open_cells(near, whole_.region);
        if (std::ranges::find(taken, true) == taken.end()) return near;
        if (whole_.subset) return with_far(std::move(near), taken);

        // Vertices that taken cells share with others are found by all cells around them.
        std::vector<bool> needed = taken;
        for (std::size_t i = 0; i < taken.size(); ++i)
            for (auto e = near.indptr[i]; e < near.indptr[i + 1] && taken[i]; ++e)
                if (near.indices[at(e)] >= 0) needed[at(near.indices[at(e)])] = true;
        std::vector<std::int32_t> seeds, taken_seeds;
        std::vector<double> some_points;
        Settled part = whole_;
        part.weights.given.clear();
        std::vector<std::int64_t> only;
        for (std::size_t i = 0; i < taken.size(); ++i) {
            if (!needed[i]) continue;
            if (taken[i]) {
                only.push_back(std::ssize(seeds));
                taken_seeds.push_back(static_cast<std::int32_t>(i));
            }
            seeds.push_back(static_cast<std::int32_t>(i));
            for (std::size_t k = 0; k < 3; ++k) some_points.push_back(whole_.points[3 * i + k]);
            if (!whole_.weights.empty()) part.weights.given.push_back(whole_.weights.given[i]);
        }
        const bool all = needs_polygons();
        part.points = {some_points, {}};
        if (!all) part.subset = std::move(only);
        const Result far = far_cells(std::move(part), {0.8, 0.95});
        return join_cells(std::move(near), far, all ? seeds : taken_seeds, taken, seeds, whole_.region);
    }

    // Takes cells of a subset into its near result, from among all points. Where there are polygons all come from the
    // far box, since those of two runs may share vertices that no cell of the subset tells.
    Result with_far(Result near, const std::vector<bool>& taken) {
        if (needs_polygons()) {
            Result far = far_cells(whole_, {0.7, 0.95});
            std::vector<std::size_t> kept;
            for (std::size_t i = 0; i < taken.size(); ++i)
                if (!taken[i]) kept.push_back(i);
            take_measures(far, whole_.want, near, kept, [&](std::size_t k) { return kept[k]; });
            return far;
        }
        std::vector<std::int32_t> rows;
        std::vector<std::int64_t> only;
        for (std::size_t i = 0; i < taken.size(); ++i) {
            if (!taken[i]) continue;
            rows.push_back(static_cast<std::int32_t>(i));
            only.push_back((*whole_.subset)[i]);
        }
        Settled part = whole_;
        part.subset = std::move(only);
        const Result far = far_cells(std::move(part), {0.7, 0.95});
        return join_cells(std::move(near), far, rows, taken, {}, whole_.region);
    }

    const Settled& whole_;
    const RunInBox& run_;
    Progress progress_;
    EndlessSides sides_;
    FlatEnds flat_ends_;
    bool thin_;  // all cells reach far beyond the near box
};

}  // namespace

Result run_endless(const Settled& whole, const RunInBox& run) {
    return EndlessRun(whole, run).make();
}

}  // namespace votess
