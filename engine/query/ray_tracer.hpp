// Walks along a ray from cell to neighbor.
//
// Seeds are lines over the time of the ray, and their lower envelope is the sequence of cells (exact/ray.hpp). The next
// cell is that of the neighbor whose line crosses first. Through an edge or a vertex the walk may take
// several steps at one time. Cells without length are left out. Each step leads to a line that falls faster, so the
// walk ends. Equal lines belong to cells whose common face or edge holds the ray.
//
// Signs. Let p be the seed of a cell relative to the origin, N the way to a neighbor, M = N + 2 p, and w their weights.
// Twice the time of the crossing is A / B, with A = N.M - (w_q - w_p) and B = N.d. No |d_k| exceeds 1, and u = 2^-53.
// N errs by u |N_k| and, where places are rounded or shifted, by `delta`. A coordinate of p errs by less than e =
// error_, which is at least 16 u times the sum of coordinates that make it. Then M errs by less than 3 e + delta. |M_k|
// is below e / (4 u). So A errs by less than 5 e (|N|_1 + 3 delta) + 2 delta |M|_1 + 4 u (|w_q| + |w_p|), B by 8 u
// |N|_1 + 4 delta.
//
// One bound on |N|_1 serves a whole cell. Where B is below 64 times its bound, or 2^-16 of that length, integers decide
// its sign. Elsewhere A / B errs by a + b |A / B| at most, see Errors. Candidates that these bounds do not separate are
// compared in integers.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/buffer.hpp"
#include "exact/ray.hpp"
#include "index/sorted_seeds.hpp"
#include "input/job.hpp"
#include "votess/votess.hpp"

namespace votess::cpu {

// The neighbors of the sorted seeds.
class CellGraph {
public:
    // t: cells of the seeds in input order, with neighbors.
    CellGraph(const Domain& domain, const SortedSeeds& seeds, const Tessellation& t);

    struct Place {
        double x, y, z, weight;  // in the domain, rounded
        std::size_t begin;       // of its links
        float reach;             // at least the sum |dx| + |dy| + |dz| of the way to any neighbor
        std::uint32_t count : 31, has_shifts : 1;
    };
    struct Link {
        std::int32_t seed;
        std::array<std::int8_t, 3> shift;
        bool is_shifted;
    };
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

    [[nodiscard]] std::span<const Link> links(std::size_t seed) const {
        return {links_.data() + places_[seed].begin, places_[seed].count};
    }
    [[nodiscard]] const Place& place(std::size_t seed) const { return places_[seed]; }
    [[nodiscard]] bool has_cell(std::size_t seed) const { return has_cell_[seed]; }
    [[nodiscard]] std::size_t first_cell() const { return first_cell_; }  // none: no seed has one
    [[nodiscard]] double size() const { return size_; }                   // largest coordinate of a place
    [[nodiscard]] double max_weight() const { return max_weight_; }       // by its size
    [[nodiscard]] double period() const { return period_; }               // largest coordinate of a lattice vector
    [[nodiscard]] int max_shift() const { return max_shift_; }            // of a link
    [[nodiscard]] std::size_t max_links() const { return max_links_; }    // of a seed

private:
    // Accessed at random, hence huge pages.
    Buffer<Link> links_{Buffer<Link>::Pages::huge};
    Buffer<Place> places_{Buffer<Place>::Pages::huge};
    std::vector<bool> has_cell_;
    std::size_t first_cell_ = none;
    double size_ = 0, period_ = 0, max_weight_ = 0;
    int max_shift_ = 0;
    std::size_t max_links_ = 0;
};

// One per thread. All arguments stay with the caller.
class RayTracer {
public:
    // A seed or its image, by a shift from the seed's place in the domain.
    struct Image {
        std::size_t seed;
        exact::Shift shift;
    };
    // Receives the pieces of a ray: an image, and the times between which its cell holds the ray.
    struct Piece {
        Image image;
        double begin, end;
    };

    // has_box: whether the box bounds the domain.
    RayTracer(const Domain& domain, const SortedSeeds& seeds, const CellGraph& graph, bool has_box);

    // Appends the pieces of a ray from time 0 to `end`, or to a wall. No component of the direction exceeds 1 in size.
    // start: an image whose cell holds the origin. Returns false when the ray never ends.
    [[nodiscard]] bool trace(const exact::Ray& ray, double end, const Image& start, std::vector<Piece>& out);
    // Returns the middle of a piece of the last ray, relative to its image.
    [[nodiscard]] std::array<double, 3> middle_of(const Piece& piece) const;

private:
    // A crossing, between bounds of twice its time; exact_of() decides where they overlap another's.
    struct Event {
        double time = 0, least = 0, most = 0;
        exact::Crossing::Kind kind = exact::Crossing::Kind::time;
        double end = 0;                      // of kind time
        const exact::Plane* wall = nullptr;  // of kind wall
        Image from{}, to{};                  // of kind bisector
    };
    // Bounds for the neighbors of one cell, on the errors of A and B; then a and b.
    struct Errors {
        double rise, slope, min_slope, constant, relative;
    };
    [[nodiscard]] Errors errors_of(const CellGraph::Place& here, const std::array<double, 3>& p) const;
    [[nodiscard]] exact::Plane plane_of(const Image& image) const;
    [[nodiscard]] std::array<double, 3> position(const Image& image) const;
    [[nodiscard]] exact::Crossing between(const Image& from, const Image& to) const {
        return exact::Crossing::between(plane_of(from), plane_of(to));
    }
    [[nodiscard]] bool later(const Event& a, const Event& b) const;
    [[nodiscard]] exact::Crossing exact_of(const Event& event) const;
    void find_time(Event& event) const;
    static void set_time(Event& event, double time);
    [[nodiscard]] bool find_stop(double end);
    [[nodiscard]] Image walk_to_origin(Image from) const;
    [[nodiscard]] bool find_next(const Image& from, Event& event);
    [[nodiscard]] bool is_same_line(const Image& a, const Image& b) const;
    [[nodiscard]] Image lowest_of_ties(const Image& of);

    const Domain& domain_;
    const SortedSeeds& seeds_;
    const CellGraph& graph_;
    std::vector<exact::Plane> walls_;
    exact::Ray ray_;
    Event stop_;
    double error_ = 0;                          // of a position
    double place_error_ = 0, shift_error_ = 0;  // of the way to a neighbor, and more of one that is shifted
    std::vector<double> slopes_, times_;        // by neighbor: B, and A / B where B is surely positive
    std::vector<Image> candidates_;
    std::vector<Image> ties_;
};

}  // namespace votess::cpu
