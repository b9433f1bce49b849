// Cells clipped by every seed, without any search structure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "input/job.hpp"
#include "polytope/cell.hpp"

namespace votess {

// Duplicates and seeds outside have no cell.
inline bool takes_part(CellStatus status) {
    return status != CellStatus::duplicate && status != CellStatus::outside;
}

// Seeds that take part, where they lie in the domain; by slot.
class BruteForce {
public:
    // status: of the seeds of the job, which must outlive it.
    BruteForce(const Job& job, std::span<const CellStatus> status);

    // Clips the cell of seed i by every seed, in a periodic domain by every image that can reach it: ranges of shifts
    // are halved until they hold one. Nearest first, for speed alone. Adds to work().
    void clip(std::size_t i, cpu::Cell& cell);
    // The cell of a seed that is none of the job's; lengths and weight are times its scale. Images of itself are not
    // tried. Its number, for planes, is that of the job's seeds.
    void clip(const exact::Point& seed, double weight, cpu::Cell& cell);

    // Counted in distance tests.
    [[nodiscard]] double work() const noexcept { return work_; }

private:
    struct Place {             // of a seed in the domain
        exact::Shift shift{};  // that wrapped it
        exact::Point at;       // where to, rounded
    };
    struct Own {  // the seed whose cell it is
        exact::Point seed;
        double weight;
        Place place;
        std::int32_t id;
        std::size_t slot;
    };
    struct Images {               // of one seed by a range of shifts
        double distance_squared;  // of the nearest, or less
        std::size_t slot;
        ShiftRange shifts;
    };
    static bool farther(const Images& a, const Images& b) { return a.distance_squared > b.distance_squared; }
    static constexpr double infinity = std::numeric_limits<double>::infinity();

    [[nodiscard]] exact::Point seed_of(std::size_t index) const;
    [[nodiscard]] double weight_of(std::size_t index) const;
    [[nodiscard]] Place place_of(const exact::Point& seed);
    void clip(const Own& own, cpu::Cell& cell);
    [[nodiscard]] double more() const;
    [[nodiscard]] double reach_of(cpu::Cell& cell) const;
    [[nodiscard]] Box bounds_of(std::size_t slot, const ShiftRange& shifts) const;
    void add(std::size_t slot, const ShiftRange& shifts, double most);
    void halve(const Images& images);
    void cut_by_nearest(cpu::Cell& cell);
    void cut(std::size_t slot, const ShiftRange& range, cpu::Cell& cell);

    const Job& job_;
    const Domain& domain_;
    std::vector<std::size_t> slot_;  // by index
    std::vector<std::int32_t> id_;
    std::vector<Place> place_;
    exact::Point largest_{}, place_rounding_{};
    double rounding_ = 0;  // of distances
    Own own_{};
    std::vector<Images> images_;
    double work_ = 0;
};

}  // namespace votess
