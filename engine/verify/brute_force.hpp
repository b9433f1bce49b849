// Cells clipped by every seed of a job, without any search structure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/arithmetic.hpp"
#include "domain/lattice_reach.hpp"
#include "input/job.hpp"
#include "polytope/cell.hpp"

namespace votess {

class BruteForce {
public:
    // All seeds of the job have cells. The job must outlive this object.
    explicit BruteForce(const Job& job);

    // Clips the cell of seed i by every seed, in a periodic domain by every image that can reach it: ranges of shifts
    // are halved until they hold one shift. Starts with the nearest, for speed. Adds to work().
    void clip(std::size_t i, cpu::Cell& cell);
    // Clips the cell of a seed that is not in the job, but not by its own images. Lengths and weight are times the
    // job's scale. Planes of this cell have the job's number of seeds as their own id.
    void clip(const exact::Point& seed, double weight, cpu::Cell& cell);

    // The work so far, in distance tests.
    [[nodiscard]] double work() const noexcept { return work_; }

private:
    struct Place {             // of a seed in the domain
        exact::Shift shift{};  // that wrapped it
        exact::Point at;       // wrapped and rounded
    };
    struct Own {  // the seed of the cell
        exact::Point seed;
        double weight;
        Place place;
        std::size_t index;  // in the job, or its number of seeds
    };
    struct Images {               // of one seed by a range of shifts
        double distance_squared;  // of the nearest image, or less
        std::size_t seed;
        ShiftRange shifts;
    };
    static bool farther(const Images& a, const Images& b) { return a.distance_squared > b.distance_squared; }

    [[nodiscard]] exact::Point seed_of(std::size_t index) const;
    [[nodiscard]] double weight_of(std::size_t index) const;
    [[nodiscard]] Place place_of(const exact::Point& seed);
    void clip(const Own& own, cpu::Cell& cell);
    [[nodiscard]] double max_extra_weight() const;
    [[nodiscard]] double reach_of(cpu::Cell& cell) const;
    [[nodiscard]] Box bounds_of(std::size_t seed, const ShiftRange& shifts) const;
    void add(std::size_t seed, const ShiftRange& shifts, double max_square);
    void halve(const Images& images);
    void cut_by_nearest(cpu::Cell& cell);
    void cut(std::size_t seed, const ShiftRange& range, cpu::Cell& cell);

    const Job& job_;
    const Domain& domain_;
    const LatticeReach lattice_reach_;
    std::vector<Place> place_;
    exact::Point largest_{}, place_rounding_{};
    double rounding_ = 0;  // of distances
    Own own_{};
    std::vector<Images> images_;
    double work_ = 0;
};

}  // namespace votess
