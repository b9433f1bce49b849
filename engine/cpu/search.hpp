// Candidates near a seed, nearest first. A hierarchy of bounding boxes over groups of consecutive sorted seeds serves
// two searches: a window of candidates around a group, shared by its seeds, and for cells that reach farther than a
// window (voids, hulls of clusters) a walk that skips boxes which no vertex of the cell reaches.
#pragma once

#include <cstdint>
#include <vector>

#include "cpu/cell.hpp"
#include "cpu/hierarchy.hpp"
#include "cpu/sort.hpp"

namespace votess::cpu {

// Entry of the best-first queues.
struct QueueEntry {
    double distance_squared;  // at most the distance from the home to any seed below the node
    std::int32_t level;
    std::uint32_t node;
};

// Builds cells. One per thread; holds all scratch memory.
class CellBuilder {
public:
    CellBuilder(const SortedSeeds& seeds, const Hierarchy& hierarchy);

    // Before build(). Forgets what it knew of the seeds, which have changed, but keeps its memory.
    void begin_job(const Box& scaled_box) {
        box_ = scaled_box;
        group_ = ~std::size_t{0};
        reach_ = 0;
    }
    // Clips the cell of a seed (index in sorted order) until it is proven complete. Fastest in ascending order.
    Cell& build(std::size_t seed);

private:
    void open_window(std::size_t group);
    // Loads groups until every seed nearer to the home group than sqrt(distance_squared) is in the window.
    void extend_window(double distance_squared, std::size_t least_count);
    void pop_into_window();
    // Clips by the window's seeds with squared distance in [from, to); true when the cell is proven complete.
    bool clip_band(std::size_t seed, double from, double to);
    void clip_far(std::size_t seed, double from);

    const Kernels& kernels_;
    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    Box box_;
    Cell cell_;

    std::size_t group_ = ~std::size_t{0};
    BoundingBox home_{};
    std::vector<QueueEntry> queue_, far_queue_;
    double covered_ = 0;  // squared distance from home within which the window is complete
    std::vector<double> x_, y_, z_, distance_;
    std::vector<std::int32_t> index_;
    std::size_t measured_ = 0;  // distances known for the current seed
    std::vector<std::uint64_t> band_;
    double reach_ = 0;  // 4 R^2 expected of the next cell
};

}  // namespace votess::cpu
