// The clipper: builds the cell of a seed from candidates, nearest first. A window of candidates around a group is
// shared by its seeds. Cells that reach farther (voids, hulls of clusters) search the boxes of the hierarchy. In a
// periodic domain this goes on through images that are not among the seeds, as pairs of a box and a range of shifts.
// The larger of the two is halved, so that a thin or long box costs little more than a cube.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "domain/lattice_reach.hpp"
#include "domain/probe.hpp"
#include "index/hierarchy.hpp"
#include "index/image_nodes.hpp"
#include "index/seed_images.hpp"
#include "index/sort.hpp"
#include "index/unwrapped.hpp"
#include "polytope/cell.hpp"

namespace votess::cpu {

// Entry of the best-first queues.
struct QueueEntry {
    double distance_squared;  // lower bound from the home to any seed below the node
    std::int32_t level;
    std::uint32_t node;
};

// The same for images.
struct FarEntry {
    double distance_squared;
    ImageNode at;
    Box images;  // bounds of all images, as seen from the home
};

// One for each thread; holds all scratch memory.
class CellBuilder {
public:
    CellBuilder(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels = best_kernels());

    // Call before build() when the seeds have changed. Keeps memory. The domain must outlive the job.
    void begin_job(const Domain& domain);
    // Clips the cell of a seed (index in sorted order) until it is proven complete. Fastest in ascending order.
    Cell& build(std::size_t seed) { return *build(seed, std::numeric_limits<std::size_t>::max()); }
    // Does the same, or returns nullptr when that takes more than max_tests tests of seeds against the cell or boxes
    // against its reach.
    Cell* build(std::size_t seed, std::size_t max_tests);
    [[nodiscard]] std::size_t tests() const { return tests_; }
    // Returns the cell of a seed if few owners of its middle leave it empty, else nullptr. For power diagrams.
    Cell* build_if_hidden(std::size_t seed);
    // Forgets the owners that buried the last seeds, so that cells do not depend on other blocks.
    void forget_owners() {
        owners_.clear();
        next_owner_ = 0;
    }
    // Builds the cell of a seed, clipped by planes first. Guards are relative to the place of the seed as given. Their
    // ids in the cell are places() + 1 and so on.
    Cell& build(std::size_t seed, std::span<const exact::Plane> guards);
    // Builds the cell of a query, as if it were a seed. Its id, which faces with its own images have, is places() of
    // the seeds. Fastest near the last query.
    Cell& build(const Probe& probe);
    // Returns the sorted seed at the place of the last probe, or -1. The probe has no cell unless that seed weighs
    // less.
    [[nodiscard]] std::int32_t coincident() const { return coincident_; }
    // Clips the cell by these seeds, which must include its neighbors.
    Cell& build_from(std::size_t seed, std::span<const std::int32_t> candidates);
    // Does the same by images of seeds, after guards.
    Cell& build_from(std::size_t seed, std::span<const std::int32_t> candidates, std::span<const exact::Shift> shifts,
                     std::span<const exact::Plane> guards = {});
    // Builds the cell of a seed of a periodic domain from candidates that include its neighbors among the seeds
    // themselves. Searches their images.
    Cell& build_among_images(std::size_t seed, std::span<const std::int32_t> candidates);
    // The same for neighbors among the seeds as they are unwrapped, without weights.
    Cell& build_among_images(std::size_t seed, std::span<const std::int32_t> candidates, const Unwrapped& unwrapped);
    // Returns the cell of a seed that is known to have none.
    Cell& build_hidden(std::size_t seed);
    // Clips the last cell again, by its neighbors only, so that its rounding does not depend on how it was found.
    // faces: scratch.
    Cell& rebuild(CellFaces& faces);

private:
    void set_seed(std::size_t seed);
    void start();
    Cell* search(std::size_t max_tests);
    Cell& build_from(std::span<const std::int32_t> candidates);
    // Clips by the walls that start() postponed. crowded: see Cell::clip_walls().
    void clip_walls(const std::function<void()>& crowded = {});
    // The same in a search. Many walls may meet where the cell does not reach, as at the tip of a cone. So if they are
    // many, the seeds that own its vertices clip it first.
    void clip_walls_among_seeds();
    void clip_by_owners_of_vertices();
    void clip_by_own_images();
    [[nodiscard]] exact::Plane bisector(std::int32_t home, const exact::Shift& shift) const;
    [[nodiscard]] bool coincides(const exact::Plane& bisector) const;
    [[nodiscard]] std::int32_t find_coincident();
    // Lets the user stop, at intervals of many tested vertices.
    void poll_stop();
    // These return whether they cut the cell.
    bool clip_by(std::int32_t id, double x, double y, double z);
    bool clip_by_image(std::int32_t home, const exact::Shift& shift);
    // Returns a squared distance at or beyond which no seed can cut the cell.
    [[nodiscard]] double reach_squared();
    // Returns the same for seeds that are not heavier, or that have no larger rest.
    [[nodiscard]] double equal_reach_squared();
    [[nodiscard]] bool node_may_cut(const QueueEntry& entry);
    [[nodiscard]] bool may_cut(const Box& seen, double more);
    void open_window(const Box& home);
    void open_window_of(std::size_t seed);
    // Loads groups until every seed nearer to the home group than sqrt(distance_squared) is in the window.
    void extend_window(double distance_squared, std::size_t min_count);
    void pop_into_window();
    [[nodiscard]] bool exhausted() const { return tests_ > max_tests_; }
    // Clips by the window's seeds with squared distance in [from, to). Returns the squared distance from which on seeds
    // have not been tried: `to`, infinity when the cell is proven complete or the tests are exhausted, or less than
    // `to` when clip_far() is cheaper. idle: tests since the last that cut the cell.
    double clip_band(double from, double to, std::size_t& idle);
    // Clips by the window's seeds, nearest first. Returns infinity when the cell is proven complete or the tests are
    // exhausted, else the squared distance from which on clip_far() must try seeds.
    double clip_window();
    // Clips by all seeds, and images among them, or by these alone, from that squared distance on.
    void clip_far(double from, bool images_only);
    // The same in a power diagram, where the cell may lie far from its seed: first by those that cut the middle of the
    // cell deepest, as bounds of the weights of boxes tell.
    void clip_by_power(double from, bool images_only);
    // Puts a ball around the cell.
    void enclose();
    struct WeightBound {
        double more;
        LiftedView view;
    };
    [[nodiscard]] WeightBound weight_bound(int level, std::size_t node, const Box& box) const;
    [[nodiscard]] bool ball_may_lose(const Box& seen, const WeightBound& bound, double& gain) const;
    Cell& rebuild_by_planes(const CellFaces& faces);
    void clip_by_heaviest();
    // Returns a seed or image of less power |x - q|^2 - w than the cell's own seed, mostly the least, or -1. x: from
    // the seed.
    [[nodiscard]] std::int32_t owner_of(const std::array<double, 3>& x);
    // Returns the one of least power among the owners that buried other seeds, or -1.
    [[nodiscard]] std::int32_t known_owner_of(const std::array<double, 3>& x,
                                              std::span<const std::int32_t> owners) const;
    void remember_owner(std::int32_t owner);
    // Clips a cell that does not hold its seed by the owner of its middle, again and again, until it is empty or holds
    // its middle. So a cell without volume takes few planes, wherever they come from. beyond: the seed lies outside of
    // the domain.
    void clip_if_hidden(bool beyond);
    // Returns the vector from a seed to a place of the domain, the nearest to it or to where the weights move its cell.
    [[nodiscard]] std::array<double, 3> way_into_domain() const;
    // Clips by the images beyond those among the seeds.
    void clip_far_images();
    // Clips by images of unwrapped seeds, without those that are not shifted.
    void clip_images_of(const Unwrapped& unwrapped);
    // Where searches for images find the seeds.
    struct Homes {
        const SortedSeeds& seeds;
        const Hierarchy& hierarchy;
        exact::Point at;        // of the cell's own seed
        exact::Point rounding;  // of places
        double known = 0;       // distance within which all images have been tried
        const Unwrapped* unwrapped = nullptr;
    };
    void clip_far_images(const Homes& homes);
    // Returns a bound on the excess of the weights of a node over the seed's.
    [[nodiscard]] double more_weight_of(const ImageNode& node) const;
    void push_far(const ImageNode& node, const Homes& homes);
    void clip_far_group(const FarEntry& entry, const Homes& homes, double from);
    void clip_far_image(std::int32_t home, const exact::Shift& shift, const Homes& homes);

    const Kernels& kernels_;
    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const Domain* domain_ = nullptr;
    LatticeReach lattice_reach_;
    Cell cell_;
    bool plain_ = true;                     // no images and no weights
    double rounding_ = 0;                   // of distances to images
    exact::Point place_rounding_{};         // of their coordinates
    std::int32_t heaviest_ = -1;            // seed of a periodic power diagram
    double more_weight_ = 0;                // bound on the excess of any weight over the seed's
    std::vector<exact::Shift> own_images_;  // that may bound the cell of a probe

    // The current seed or probe.
    std::int32_t own_ = -1;  // its id
    bool probing_ = false;
    std::span<const exact::Plane> guards_;
    exact::Point at_{};
    SeedImages::Base base_{};
    double weight_ = 0;
    LiftedView view_{};
    double rest_ = 0, more_rest_ = 0;  // see Lift; bound on the excess of any rest over this one
    std::int32_t coincident_ = -1;
    exact::Point center_{};  // of a ball around the cell, from the seed
    double radius_ = 0;
    int cuts_ = 0;  // since the ball was found

    std::size_t group_ = ~std::size_t{0};
    Box home_{};
    bool walls_postponed_ = false, clipped_by_owner_ = false;
    std::vector<QueueEntry> queue_, far_queue_, owner_queue_;
    std::vector<FarEntry> far_images_;
    double covered_ = 0;  // squared distance from home within which the window is complete
    std::vector<double> x_, y_, z_, distance_;
    std::vector<std::int32_t> index_;
    std::size_t measured_ = 0;  // distances known for the current seed
    std::vector<std::uint64_t> band_;
    std::vector<std::pair<double, std::int32_t>> candidates_;
    std::vector<std::int32_t> neighbors_;
    std::vector<CellPlane> planes_;
    std::vector<std::int32_t> owners_;         // that buried the last seeds
    std::vector<std::int32_t> vertex_owners_;  // that clipped the cell before walls
    std::vector<std::array<double, 3>> vertices_;
    std::size_t next_owner_ = 0;             // the one to forget next
    std::size_t max_unowned_ = 0;            // tests of boxes for an owner, while none is found
    std::size_t tests_ = 0, max_tests_ = 0;  // of the current seed
    double reach_ = 0;                       // 4 R^2 expected of the next cell
    std::size_t tested_vertices_ = 0;        // since the last check_stop()
};

}  // namespace votess::cpu
