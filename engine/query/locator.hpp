// Finds the cell that holds a point x: its seed q has the least |x - q|^2 - w. The lowest index wins a tie.
//
// Distances are rounded and have error bounds. Seeds that may be the nearest are candidates. Exact arithmetic compares
// several candidates (exact::farther()).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "domain/lattice_reach.hpp"
#include "domain/probe.hpp"
#include "index/hierarchy.hpp"
#include "index/image_nodes.hpp"
#include "index/sorted_seeds.hpp"
#include "input/job.hpp"
#include "polytope/cell_kernels.hpp"

namespace votess::cpu {

// Where a point lies after it has been wrapped. Nothing where that takes more than some 500 million periods.
std::optional<Place> wrapped_into(const Domain& domain, const exact::Point& x);
inline std::optional<Place> place_in(const Domain& domain, const exact::Point& x) {
    return domain.is_periodic() ? wrapped_into(domain, x) : Place{x};
}

// One per thread. The seeds and all that belongs to them stay with the caller.
class Locator {
public:
    Locator(const Job& job, const SortedSeeds& seeds, const Hierarchy& hierarchy);

    // x: times the scale of the job; its number is for messages. Nothing where the domain is not.
    [[nodiscard]] std::optional<Place> place(const exact::Point& x, std::size_t number) const;
    // The input index of the seed whose cell holds x; -1 where there are no seeds. Fastest when the last x was near,
    // for its seeds are in the cache.
    [[nodiscard]] std::int32_t find(const exact::Point& x, const Place& place);
    // The seed or image whose cell holds x, by its number among the sorted seeds and the shift by which it would be
    // sorted; home -1 where there are no seeds.
    struct Nearest {
        std::int32_t home = -1;
        exact::Shift shift{};
    };
    [[nodiscard]] Nearest nearest(const exact::Point& x, const Place& place);
    // A group of seeds near a place.
    [[nodiscard]] std::size_t group_near(const exact::Point& at) const;

private:
    // A seed or image that may be the nearest: bounds of |x - q|^2 - w.
    struct Candidate {
        double least, most;
        std::int32_t home;
        exact::Shift shift;
    };

    // No seed of weight at most `weight` matters beyond this squared distance.
    [[nodiscard]] double reach_squared(double weight) const;
    [[nodiscard]] double reach_to(double weight) const {
        return seeds_.weights.empty() ? reach_ : reach_squared(weight);
    }
    [[nodiscard]] double error_of(double distance_squared, double weight) const;
    void keep(std::int32_t home, const exact::Shift& shift, double distance_squared);
    void try_group(std::size_t group);
    void search();
    void search_images();
    void push_far(const ImageNode& node);
    [[nodiscard]] Nearest decide(const exact::Point& x, const exact::Shift& by);
    [[nodiscard]] exact::Plane plane_of(const Candidate& candidate, const exact::Shift& by) const;

    const Domain& domain_;
    const LatticeReach lattice_reach_;
    const SortedSeeds& seeds_;
    const Hierarchy& hierarchy_;
    const Kernels& kernels_;
    const StarKernels& box_kernels_;
    double image_rounding_ = 0;  // of places among the images

    exact::Point at_{};
    double rounding_ = 0;          // of at_, and of places of seeds
    double best_ = 0;              // least upper bound
    double reach_ = 0;             // reach_squared(0)
    std::size_t first_group_ = 0;  // tried before the search
    std::vector<Candidate> candidates_;
    struct Node {
        std::int32_t level;
        std::uint32_t index;
    };
    std::array<Node, Hierarchy::max_nodes> nodes_;
    std::vector<ImageNode> far_;
};

}  // namespace votess::cpu
