// Every seed has its input coordinate and an integer shift, and its position is their exact sum. Two doubles
// approximate that sum; `rough` means that even they are rounded. Skewed boxes are searched in a reduced cell. Copies
// within a margin are ordinary candidates; farther ones are searched cell by cell. Only rows convert shifts back to the
// user's box.
//
// So the images within `reach` of a seed are among the sorted seeds, and windows and searches see space as it is.
// Different seeds may have the same rounded x. The exact planes do not depend on x and low.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/buffer.hpp"
#include "core/thread_pool.hpp"
#include "index/sort.hpp"
#include "index/sorted_seeds.hpp"
#include "input/job.hpp"

namespace votess::cpu {

// Returns the mean distance of seeds that fill a box with the given sides, some of which may be 0.
double mean_spacing(const std::array<double, 3>& sides, double count);

class SeedImages {
public:
    // Wraps and sorts the seeds of the job, then adds their images. order: of an earlier sort, see put_in_order(); then
    // add() adds the images. drop: called in between, if not empty; may remove seeds.
    void sort(const Job& job, std::span<const std::int32_t> order, SeedSorter& sorter, ThreadPool& pool,
              SortedSeeds& out, const std::function<void()>& drop = {});
    void add(SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out);
    // Replaces the images by those of a margin as wide as cells may need, once after a sort, if that are at most so
    // many. Seeds keep their ids. Returns false if it changed nothing.
    bool widen(double most, ThreadPool& pool, SortedSeeds& out);

    [[nodiscard]] const Domain& domain() const { return *domain_; }
    [[nodiscard]] bool is_image(std::int32_t id) const { return static_cast<std::size_t>(id) >= first_; }
    // Returns the seed of which an id is an image, and its shift. A seed is its own image by shift 0.
    [[nodiscard]] std::int32_t home(std::int32_t id) const {
        return is_image(id) ? home_[static_cast<std::size_t>(id) - first_] : id;
    }
    [[nodiscard]] exact::Shift shift(std::int32_t id) const {
        return is_image(id) ? shift_[static_cast<std::size_t>(id) - first_] : exact::Shift{};
    }
    // Returns the rounding errors of the coordinates of an id.
    [[nodiscard]] std::array<double, 3> low(std::int32_t id) const {
        const auto i = static_cast<std::size_t>(id);
        return i < first_low_ ? std::array<double, 3>{} : low_[i - first_low_];
    }
    // Whether the coordinates of a seed are exact doubles.
    [[nodiscard]] bool is_exact(std::size_t seed) const { return rounded_.empty() || !rounded_[seed]; }
    // Whether even x + low is rounded.
    [[nodiscard]] bool is_rough(std::int32_t id) const { return any_rough() && rough_[static_cast<std::size_t>(id)]; }
    [[nodiscard]] bool any_rough() const { return !rough_.empty(); }
    // Whether seeds have been shifted into the domain, or into its reduced cell.
    [[nodiscard]] bool any_wrapped() const { return !wraps_.empty(); }
    // Whether seeds have been moved from the domain into its reduced cell.
    [[nodiscard]] bool any_moved() const { return !moves_.empty(); }
    // Returns the shift to add to that of an image of `home` in a row of `seed`, so that it counts from their places in
    // the domain.
    [[nodiscard]] exact::Shift shift_in_domain(std::int32_t home, std::size_t seed) const {
        return moves_.empty() ? exact::Shift{} : shift_in_domain(home, moves_[seed]);
    }
    // Does the same for a cell that has been moved into the reduced cell by `moved`.
    [[nodiscard]] exact::Shift shift_in_domain(std::int32_t home, const exact::Shift& moved) const;
    // Rounded.
    [[nodiscard]] exact::Point place_in_domain(std::size_t seed) const;
    // Returns the place of an image of a seed, rounded.
    [[nodiscard]] exact::Point place(std::size_t seed, const exact::Shift& shift) const;
    [[nodiscard]] double largest_coordinate() const { return largest_coordinate_; }
    // Along each axis; 0 where box vectors have no component, so that no place is rounded.
    [[nodiscard]] const exact::Point& largest_rounded() const { return largest_rounded_; }
    // Returns bounds on the rounding errors of seeds (not of images): 0 along an axis where all are exact.
    [[nodiscard]] const exact::Point& rounding_of_seeds() const { return rounding_of_seeds_; }
    // Returns a distance within which all seeds and images around a seed are present; 0 if unknown.
    [[nodiscard]] double reach(const exact::Point& seed) const;
    // The same for all places in a box.
    [[nodiscard]] double reach(const Box& places) const;
    // Whether an image at that place is certainly present.
    [[nodiscard]] bool is_present(const exact::Point& image) const;
    // The same for all images in a box.
    [[nodiscard]] bool are_present(const Box& images) const;
    // Returns the smallest reach of all seeds.
    [[nodiscard]] double min_reach() const { return min_reach_; }

    // A seed for exact arithmetic: coordinates and their shift.
    struct Base {
        exact::Point point;
        exact::Shift shift;
    };
    [[nodiscard]] Base base(std::size_t seed) const;
    // The image of `home` by `shift`, relative to base(seed).point.
    [[nodiscard]] exact::Plane bisector(const Base& seed, std::int32_t home, const exact::Shift& shift) const;

private:
    [[nodiscard]] std::array<double, 3> fraction(const exact::Point& x) const;
    // Returns how deep a box lies inside of the margin, in fractions.
    [[nodiscard]] std::array<double, 3> depths(const Box& box) const;
    // Whether wrapping certainly leaves a point in place. Needs edge_error_.
    [[nodiscard]] bool surely_inside(const exact::Point& x) const;
    void wrap_points(const std::vector<CellStatus>& outside, ThreadPool& pool);
    [[nodiscard]] exact::Differences position(std::size_t input, const exact::Shift& shift) const;
    [[nodiscard]] exact::Differences position(const exact::Point& x, const exact::Shift& shift) const;
    void restore_false_duplicates(SortedSeeds& out) const;
    bool choose_margin(const SortedSeeds& seeds, ThreadPool& pool, double wide);
    template <class Visit>
    void for_images(const exact::Point& x, Visit visit) const;
    // Replaces the images by those within the margin, if any.
    enum class Images { none, within_margin };
    void append(Images images, SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out);

    std::shared_ptr<const Domain> domain_;
    const SortedSeeds* seeds_ = nullptr;
    Points points_;
    double scale_ = 1;
    const Basis* basis_ = nullptr;    // by which seeds are wrapped
    bool axis_aligned_ = false;       // box vectors are doubles, along x, y and z
    bool wide_ = false;               // widen() has been called
    std::array<double, 3> margin_{};  // of the box, in fractions
    std::array<double, 3> error_{};   // of fractions
    Buffer<exact::Shift> wraps_;      // by input; empty when no seed is shifted
    // The part of wraps_ from the domain into its reduced cell, by sorted seed; empty if there is none.
    Buffer<exact::Shift> moves_;
    Buffer<double> wrapped_, wrapped_low_;  // 3N coordinates and their rounding errors, with wraps_
    Buffer<char> wrapped_rough_;            // N, whether even their sum is rounded
    double domain_size_ = 0;                // bound on coordinates inside
    std::array<double, 3> edge_error_{};    // of fractions of the domain's edges
    double min_reach_ = 0;
    std::size_t first_ = 0;  // id of the first image
    Buffer<std::int32_t> home_;
    Buffer<exact::Shift> shift_;
    Buffer<std::array<double, 3>> low_;  // by id, from first_low_ on; the others are 0
    std::size_t first_low_ = 0;          // 0, or first_ if no seed is wrapped
    std::vector<bool> rounded_;          // of seeds: whether low is not 0; empty if no seed is wrapped
    std::vector<bool> rough_;            // by id; empty if none is
    SortedSeeds sorted_images_;
    double largest_coordinate_ = 0;
    exact::Point largest_rounded_{}, rounding_of_seeds_{};
};

}  // namespace votess::cpu
