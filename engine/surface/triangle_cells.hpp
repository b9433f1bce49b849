// The parts of one triangle in all cells, made together.
//
// On the triangle, the square of the distance from each seed, less that from one fixed place, is linear. The cells are
// the lower envelope of these functions. Each corner lies between three sites: seeds, or edges of the triangle. Corners
// and sides are the triangles and edges of a dual triangulation. A seed that is added removes the corners nearer to it,
// and gets a new one at each side that crosses the border of the hole (Bowyer, Watson 1981). So a side between two
// cells is made once. A seed can only cut if a corner is nearer to it, so the tree is searched up to their largest
// distance.
//
// Signs come from double, with bounds on the errors. Where a bound hides a sign, and for very many parts, make() gives
// up: ClippedTriangle decides then.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "surface/clipped_triangle.hpp"
#include "surface/kernels.hpp"
#include "surface/surface.hpp"

namespace votess::surface {

class TriangleCells {
public:
    explicit TriangleCells(const Surface& surface);

    // Begins with any triangle: what follows depends on none before.
    void restart() { hint_ = none; }
    // Returns whether it found all parts, sooner if the last triangle is near. exact: rounds corners whose bounds are
    // large.
    [[nodiscard]] bool make(std::int32_t triangle, ClippedTriangle& exact);
    [[nodiscard]] std::size_t parts() const { return parts_.size(); }
    [[nodiscard]] std::int32_t seed(std::size_t part) const { return surface_.tree().seed(of(sites_[part]).number); }
    // Returns the area of a part.
    [[nodiscard]] double area(std::size_t part, double of_triangle) const;
    // Selects a part, for what follows.
    void select(std::size_t part);
    [[nodiscard]] std::int32_t seed() const { return surface_.tree().seed(number_); }
    [[nodiscard]] std::size_t size() const { return size_; }
    // As ClippedTriangle returns them.
    [[nodiscard]] Side side(std::size_t i) const { return sides_[i]; }
    [[nodiscard]] const std::array<double, 2>& weights(std::size_t i) const { return weights_[i]; }
    [[nodiscard]] Vector3 place(std::size_t i) const;
    [[nodiscard]] bool has_length(std::size_t) const { return true; }
    [[nodiscard]] bool has_area() const { return true; }

private:
    using Site = std::uint32_t;  // 0 to 2: edges of the triangle, each from its corner; then seeds
    static constexpr Site edges = 3;
    static constexpr std::uint32_t none = 0xffffffff;
    static constexpr std::size_t max_seeds = Envelope::max_seeds, max_corners = 2 * max_seeds + 2;
    // At weights w of the second and third vertex the value is f + w[0] du + w[1] dv.
    struct Seed {
        double f, du, dv;
        double error;  // bound, of each
        std::uint32_t number;
    };
    struct Links {
        std::array<Site, 3> site;           // around the corner, as the triangle turns
        std::array<std::uint32_t, 3> next;  // the corner at the other end of the side between the other two sites
        // Returns the corner that follows along the cell of a site.
        [[nodiscard]] std::uint32_t after(Site of) const { return next[site[0] == of ? 1 : site[1] == of ? 2 : 0]; }
    };
    struct Change {
        Site from, to;
        std::uint32_t corner;  // beyond the side between them
        std::size_t back;      // its link here
    };
    void add_group(std::uint32_t first);
    void begin(std::size_t k, std::uint32_t number);
    [[nodiscard]] const Seed& of(Site site) const { return seeds_[site - edges]; }
    void add(std::size_t k, std::uint32_t number);
    [[nodiscard]] bool find_removed(std::size_t k);
    void join(const Seed& own, Site site);
    void set_row(std::size_t i, const Seed& own, Site site);
    void remove_rest(std::size_t used);
    void clear_corners(std::size_t from, std::size_t end);
    void find_reach();
    [[nodiscard]] bool is_beyond_balls(const Box& box) const;
    void settle(std::int32_t triangle, ClippedTriangle& exact);

    const Surface& surface_;
    const SurfaceKernels& kernels_;
    std::array<exact::Point, 3> vertex_{};
    TriangleFrame frame_{};
    SeedFunctions functions_{};  // of a group
    std::vector<Seed> seeds_;
    Envelope envelope_{};
    std::array<std::uint8_t, Envelope::room / group> marks_{};
    std::array<Links, max_corners> links_;
    std::array<std::uint8_t, max_corners> is_removed_{};
    std::vector<std::uint32_t> removed_;
    std::vector<Change> border_;
    std::array<std::uint32_t, max_seeds + edges> change_from_;  // changes, by site
    Ring ring_{};
    std::vector<std::uint32_t> made_;  // corners, of the ring
    bool is_sure_ = true;
    std::uint32_t hint_ = none;         // a seed of the last triangle
    std::vector<std::uint32_t> parts_;  // a corner of each
    std::vector<Site> sites_;           // of these
    std::array<std::uint32_t, max_seeds + edges> corner_of_site_;

    std::uint32_t number_ = 0;
    std::size_t size_ = 0;
    std::array<Side, max_seeds + edges> sides_;
    std::array<std::array<double, 2>, max_seeds + edges> weights_;
    std::array<Vector3, 3> relative_{};
};

}  // namespace votess::surface
