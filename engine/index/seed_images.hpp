// Images of the seeds of a periodic domain around its box, so that windows and searches see space as it is. All images
// within `reach` of a seed are there; what lies farther, the few cells that need it search for themselves.
//
// Positions are wrapped into the domain, or into its reduced cell when it is skewed. A coordinate x + low of a seed or
// image is exact, or the nearest such sum where two doubles cannot hold it; the exact planes do not depend on it. So
// seeds at different places may have the same x.
#pragma once

#include <cstdint>
#include <vector>

#include "core/buffer.hpp"
#include "core/thread_pool.hpp"
#include "index/sort.hpp"
#include "index/sorted_seeds.hpp"
#include "input/job.hpp"

namespace votess::cpu {

class SeedImages {
public:
    // Wraps and sorts the seeds of the job, then adds their images.
    void sort(const Job& job, SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out);

    [[nodiscard]] const Domain& domain() const { return *domain_; }
    [[nodiscard]] bool is_image(std::int32_t id) const { return static_cast<std::size_t>(id) >= first_; }
    // The seed that an id is an image of, and by which shift; a seed is its own by none.
    [[nodiscard]] std::int32_t home(std::int32_t id) const {
        return is_image(id) ? home_[static_cast<std::size_t>(id) - first_] : id;
    }
    [[nodiscard]] exact::Shift shift(std::int32_t id) const {
        return is_image(id) ? shift_[static_cast<std::size_t>(id) - first_] : exact::Shift{};
    }
    // What rounding took from the coordinates of an id.
    [[nodiscard]] const std::array<double, 3>& low(std::int32_t id) const { return low_[static_cast<std::size_t>(id)]; }
    // Whether the coordinates of a seed are exact doubles.
    [[nodiscard]] bool is_exact(std::size_t seed) const { return low_[seed] == std::array<double, 3>{}; }
    // Whether not even x + low is exact.
    [[nodiscard]] bool is_rough(std::int32_t id) const { return rough_[static_cast<std::size_t>(id)]; }
    [[nodiscard]] bool any_rough() const { return any_rough_; }
    // Whether some seeds have been moved into the domain, or into its reduced cell.
    [[nodiscard]] bool any_wrapped() const { return !wraps_.empty(); }
    // Whether some seeds have been moved from the domain into its reduced cell.
    [[nodiscard]] bool any_moved() const { return !moves_.empty(); }
    // Returns what to add to the shift of an image of `home`, as a cell of `seed` sees it, to count from the places of
    // both in the domain.
    [[nodiscard]] exact::Shift shift_in_domain(std::int32_t home, std::size_t seed) const {
        return moves_.empty() ? exact::Shift{} : shift_in_domain(home, moves_[seed]);
    }
    // The same for a cell that has itself been moved into the reduced cell.
    [[nodiscard]] exact::Shift shift_in_domain(std::int32_t home, const exact::Shift& moved) const;
    // Where a seed lies in the domain, rounded.
    [[nodiscard]] exact::Point place_in_domain(std::size_t seed) const;
    [[nodiscard]] double largest_coordinate() const { return largest_coordinate_; }
    // Along each axis; 0 where box vectors have no component, and no place is rounded.
    [[nodiscard]] const exact::Point& largest_rounded() const { return largest_rounded_; }
    // What rounding took at most from the coordinates of seeds (not of images): 0 along an axis where all are exact.
    [[nodiscard]] const exact::Point& rounding_of_seeds() const { return rounding_of_seeds_; }
    // All seeds and images nearer to a seed than this are there; 0 when that is not known of any.
    [[nodiscard]] double reach(const exact::Point& seed) const;
    // The least of all seeds.
    [[nodiscard]] double min_reach() const { return min_reach_; }

    // A seed as exact arithmetic knows it: coordinates and the shift that goes with them.
    struct Base {
        exact::Point point;
        exact::Shift shift;
    };
    [[nodiscard]] Base base(std::size_t seed) const;
    // Bisector of a seed and the image of `home` by `shift`, relative to base(seed).point.
    [[nodiscard]] exact::Plane bisector(const Base& seed, std::int32_t home, const exact::Shift& shift) const;

private:
    [[nodiscard]] std::array<double, 3> fraction(const exact::Point& x) const;
    // Whether wrapping surely leaves a point where it is; needs edge_error_.
    [[nodiscard]] bool surely_inside(const exact::Point& x) const;
    void wrap_points(const std::vector<CellStatus>& outside, ThreadPool& pool);
    [[nodiscard]] exact::Differences position(std::size_t input, const exact::Shift& shift) const;
    void restore_false_duplicates(SortedSeeds& out) const;
    void choose_margin(std::size_t seeds);
    template <class Visit>
    void for_images(const exact::Point& x, Visit visit) const;
    void append(SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out);

    std::shared_ptr<const Domain> domain_;
    const SortedSeeds* seeds_ = nullptr;
    Points points_;
    double scale_ = 1;
    const Basis* basis_ = nullptr;     // that seeds are wrapped by
    bool axis_aligned_ = false;        // box vectors are doubles, along x, y and z
    std::array<double, 3> margin_{};   // of the box, in fractions
    std::array<double, 3> error_{};    // of fractions
    std::vector<exact::Shift> wraps_;  // by input; empty when all seeds lie inside
    // The part of wraps_ from the domain into its reduced cell, by sorted seed; empty when there is none.
    std::vector<exact::Shift> moves_;
    std::vector<double> wrapped_, wrapped_low_;  // 3N coordinates and what rounding took from them, with wraps_
    std::vector<char> wrapped_rough_;            // N, whether even the two of them are rounded
    double domain_size_ = 0;                     // no coordinate inside is larger
    std::array<double, 3> edge_error_{};         // of fractions of the domain's edges, within domain_size_
    double min_reach_ = 0;
    std::size_t first_ = 0;  // id of the first image
    Buffer<std::int32_t> home_;
    Buffer<exact::Shift> shift_;
    std::vector<std::array<double, 3>> low_;  // by id
    std::vector<bool> rough_;                 // by id
    bool any_rough_ = false;
    SortedSeeds sorted_images_;
    double largest_coordinate_ = 0;
    exact::Point largest_rounded_{}, rounding_of_seeds_{};
};

}  // namespace votess::cpu
