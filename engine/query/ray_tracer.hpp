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
//
// Memory. The places of the neighbors lie scattered. So each cell has a sketch of N, 16 bits a coordinate, and most
// neighbors are skipped by it, see sketch_ray(). Several tracers take turns in a thread, and each requests the
// memory of its next turn: look(), step(), look(), ...
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/buffer.hpp"
#include "exact/ray.hpp"
#include "index/sorted_seeds.hpp"
#include "input/job.hpp"
#include "query/ray_sketch.hpp"
#include "votess/votess.hpp"

namespace votess::cpu {

// The neighbors of the sorted seeds.
class CellGraph {
public:
    // t: cells of the seeds in input order, with neighbors.
    CellGraph(const Domain& domain, const SortedSeeds& seeds, const Tessellation& t);

    struct alignas(64) Place {
        double x = 0, y = 0, z = 0, weight = 0;  // in the domain, rounded
        std::size_t sketch = 0;                  // number of its first
        float reach = 0;                         // at least the sum |dx| + |dy| + |dz| of the way to any neighbor
        float inverse_unit = 0;                  // of its sketches: a power of two below 1 / reach
        float max_constant = 0;                  // in units squared, see SketchedCell
        std::uint32_t count : 31 = 0, has_shifts : 1 = 0;
    };
    using Shift = std::array<std::int8_t, 3>;
    struct Link {
        std::size_t seed;
        Shift shift;
        bool is_shifted;
    };
    static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

    [[nodiscard]] const Place& place(std::size_t seed) const { return places_[seed]; }
    [[nodiscard]] SketchedCell sketched(const Place& place) const {
        return {{sketches_.data() + place.sketch, ceil_div(std::size_t{place.count}, RaySketch::lanes)},
                constants_.empty() ? nullptr : constants_.data() + place.sketch,
                place.count};
    }
    // Returns the i-th neighbor of the seed at this place.
    [[nodiscard]] Link link(const Place& place, std::size_t i) const {
        const std::size_t sketch = place.sketch + i / RaySketch::lanes, lane = i % RaySketch::lanes;
        const auto seed = static_cast<std::size_t>(sketches_[sketch].seed[lane]);
        if (place.has_shifts == 0) return {seed, {}, false};
        const Shift& shift = shifts_[sketch * RaySketch::lanes + lane];
        return {seed, shift, (shift[0] | shift[1] | shift[2]) != 0};
    }
    [[nodiscard]] bool has_cell(std::size_t seed) const { return has_cell_[seed]; }
    [[nodiscard]] std::size_t first_cell() const { return first_cell_; }  // none: no seed has one
    [[nodiscard]] double size() const { return size_; }                   // largest coordinate of a place
    [[nodiscard]] double max_weight() const { return max_weight_; }       // by its size
    [[nodiscard]] double period() const { return period_; }               // largest coordinate of a lattice vector
    [[nodiscard]] int max_shift() const { return max_shift_; }            // of a link
    [[nodiscard]] std::size_t max_links() const { return max_links_; }    // of a seed

private:
    void draw(Place& place, std::span<const std::array<double, 3>> ways);

    // Accessed at random, hence huge pages.
    Buffer<Place> places_{Buffer<Place>::Pages::huge};
    Buffer<RaySketch> sketches_{Buffer<RaySketch>::Pages::huge};
    Buffer<SketchConstants> constants_{Buffer<SketchConstants>::Pages::huge};  // of a power diagram
    Buffer<Shift> shifts_{Buffer<Shift>::Pages::huge};                         // of a periodic domain; by lane
    std::vector<bool> has_cell_;
    std::size_t first_cell_ = none;
    double size_ = 0, period_ = 0, max_weight_ = 0;
    int max_shift_ = 0;
    std::size_t max_links_ = 0;
};

// Some per thread. All arguments stay with the caller.
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

    // walls: those of the domain that end a ray.
    RayTracer(const Domain& domain, const SortedSeeds& seeds, const CellGraph& graph, std::vector<exact::Plane> walls,
              std::string_view instructions);

    // Starts a ray from time 0 to `end`, or to a wall. No component of the direction exceeds 1 in size.
    // start: an image whose cell holds the origin. Returns false when the ray never ends.
    [[nodiscard]] bool start(const exact::Ray& ray, double end, const Image& start);
    // Whether look() and step() are due, in turns.
    [[nodiscard]] bool is_under_way() const { return is_under_way_; }
    // Returns the time at which the ray ends.
    [[nodiscard]] double end() const { return 0.5 * stop_.time; }
    // Selects the neighbors that may be next.
    void look();
    // Finds the next, and the piece before it.
    void step();
    // Returns the pieces of the ray so far.
    [[nodiscard]] std::span<const Piece> pieces() const { return pieces_; }
    // Returns the middle of a piece of the ray, relative to its image.
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
    void set_error();
    [[nodiscard]] SketchRay sketch_ray(const CellGraph::Place& here) const;
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
    [[nodiscard]] bool find_next(Event& event);
    [[nodiscard]] bool is_same_line(const Image& a, const Image& b) const;
    [[nodiscard]] Image lowest_of_ties(const Image& of);

    const Domain& domain_;
    const SortedSeeds& seeds_;
    const CellGraph& graph_;
    SelectCrossings select_crossings_;
    std::vector<exact::Plane> walls_;
    double place_error_ = 0, shift_error_ = 0;  // of the way to a neighbor, and more of one that is shifted
    exact::Ray ray_;
    Event stop_, from_;  // the end of the ray, and of the last piece
    Image at_{};         // the next piece's
    std::size_t steps_ = 0;
    bool is_under_way_ = false;
    std::vector<Piece> pieces_;
    std::array<float, 3> sketch_direction_{};
    // From look():
    double error_ = 0;  // of a position
    std::array<double, 3> position_{};
    Errors errors_{};
    std::vector<float> scratch_;
    std::vector<std::uint32_t> selected_;
    std::size_t selected_count_ = 0;
    std::vector<double> slopes_, times_;  // of the selected: B, and A / B where B is surely positive
    std::vector<Image> candidates_;
    std::vector<Image> ties_;
};

}  // namespace votess::cpu
