#include "unbounded/run_endless.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/progress.hpp"
#include "exact/insphere.hpp"
#include "input/implied_wants.hpp"
#include "input/options.hpp"
#include "result/arrays.hpp"
#include "unbounded/open_cells.hpp"

namespace votess {
namespace {

using detail::Result;

constexpr std::size_t min_near = 30;  // fewer seeds are as fast in the far box alone

std::size_t to_index(std::int64_t i) {
    return static_cast<std::size_t>(i);
}

class EndlessRun {
public:
    EndlessRun(const Points& points, const Options& options, const RunInBox& run)
        : options_(options), run_(run), points_(points), progress_(options.progress) {
        check_endless(options);
        Options with_default_box = options;
        with_default_box.box.reset();
        check_options(with_default_box);  // the device too, which the far box does not use
        wanted_ = with_implied(options);
        weights_ = options.weights.empty() ? options.radii : options.weights;
        squares_ = !options.radii.empty();
    }

    Result make() {
        Result result = options_.only || points_.count() < min_near ? in_far_box() : in_both_boxes();
        if (result.vertices.size() == 3) find_tetrahedron(result);
        detail::keep_wanted(result, wanted_, options_.list_walls || wanted_.faces);
        return result;
    }

private:
    // The options of a part of the run, whose rows list walls.
    [[nodiscard]] Options part(const Box& box, const Share& share) {
        Options part = options_;
        part.box = box;
        part.list_walls = true;
        part.want = wanted_;
        part.want.neighbors = true;
        part.progress = progress_.within(share);
        return part;
    }
    // Open cells need polygons for areas and counts.
    [[nodiscard]] bool needs_polygons() const { return wanted_.areas || wanted_.counts || wanted_.vertices; }

    [[nodiscard]] Box far(const Points& points, std::span<const double> weights) const {
        if (!squares_) return far_box(points, weights, *options_.box);
        std::vector<double> squares;
        for (const double radius : weights) squares.push_back(radius * radius);
        return far_box(points, squares, *options_.box);
    }

    void find_tetrahedron(Result& result) const {
        std::vector<std::int32_t> seeds;
        for (std::size_t i = 0; i < points_.count(); ++i)
            if (result.cell_vertex_indptr[i] != result.cell_vertex_indptr[i + 1])
                seeds.push_back(static_cast<std::int32_t>(i));
        if (seeds.size() != 4) return;
        std::array<exact::Point, 4> x;
        double largest = 0;
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                x[k][axis] = points_[3 * to_index(seeds[k]) + axis];
                largest = std::max(largest, std::abs(x[k][axis]));
            }
        const int exponent = std::ilogb(largest);
        for (exact::Point& point : x)
            for (double& coordinate : point) coordinate = std::ldexp(coordinate, -exponent);
        if (exact::orient(x[1], x[2], x[3], x[0]) < 0) std::swap(seeds[2], seeds[3]);
        result.lone_tetrahedron = {seeds[0], seeds[1], seeds[2], seeds[3]};
    }

    Result in_far_box() {
        Options options = part(far(points_, weights_), {0, 1});
        options.device = "cpu";  // no device clips so large a box
        options.want.faces |= needs_polygons();
        Result result = run_(points_, options);
        open_cells(result, *options_.box);
        return result;
    }

    Result in_both_boxes() {
        Options options = part(near_box(points_, *options_.box), {0, 0.7});
        if (needs_polygons()) options.want.faces = true;
        Result near = run_(points_, options);
        const EndlessSides sides(options_.box);
        std::vector<bool> taken(points_.count()), needed(points_.count());
        bool some_empty = false;
        for (std::size_t i = 0; i < points_.count(); ++i) {
            if (near.status[i] == CellStatus::empty) some_empty = true;
            const auto begin = to_index(near.indptr[i]), end = to_index(near.indptr[i + 1]);
            for (std::size_t e = begin; e < end; ++e)
                if (sides.has(near.indices[e])) taken[i] = true;
            if (!taken[i]) continue;
            needed[i] = true;
            for (std::size_t e = begin; e < end; ++e)
                if (near.indices[e] >= 0) needed[to_index(near.indices[e])] = true;
        }
        // A cell that is empty here may lie far away, and its empty row names no seeds around it.
        if (some_empty) return in_far_box();

        std::vector<std::int32_t> seeds, taken_seeds;
        std::vector<double> some_points, some_weights;
        std::vector<std::int64_t> only;
        for (std::size_t i = 0; i < points_.count(); ++i) {
            if (!needed[i]) continue;
            if (taken[i]) {
                only.push_back(std::ssize(seeds));
                taken_seeds.push_back(static_cast<std::int32_t>(i));
            }
            seeds.push_back(static_cast<std::int32_t>(i));
            for (std::size_t k = 0; k < 3; ++k) some_points.push_back(points_[3 * i + k]);
            if (!weights_.empty()) some_weights.push_back(weights_[i]);
        }
        options = part(far({some_points, {}}, some_weights), {0.7, 0.95});
        options.device = "cpu";
        (squares_ ? options.radii : options.weights) = some_weights;
        if (needs_polygons())
            options.want.faces = true;
        else
            options.only = only;
        Result far = run_({some_points, {}}, options);
        open_cells(far, *options_.box);
        return join_cells(std::move(near), far, options.only ? taken_seeds : seeds, taken, seeds, *options_.box);
    }

    const Options& options_;
    const RunInBox& run_;
    Points points_;
    Progress progress_;
    Want wanted_;
    std::span<const double> weights_;  // or radii
    bool squares_ = false;
};

}  // namespace

Result run_endless(const Points& points, const Options& options, const RunInBox& run) {
    return EndlessRun(points, options, run).make();
}

}  // namespace votess
