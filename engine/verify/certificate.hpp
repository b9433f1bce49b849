// A proof that rows are those of the Voronoi or power diagram of all seeds, from signs around each cell: verify()
// without a sample.
//
// Let the live seeds be those that are reported to have a cell. Let P_i be the polytope of the bisectors that row i
// lists and of all walls of the domain D. Suppose
//   1. P_i is bounded and has volume. Each plane that the row lists bounds it in a face of its own (check_cell());
//   2. i lists j with a shift exactly if j lists i with the opposite shift (RowChecker), and the face of P_i with j is
//      that of P_j with i;
//   3. the volumes of all P_i sum to less than 1.5 times that of D (check_volume()), or some place of D lies inside one
//      P_i and outside of all others (is_covered_once()), or the P_i lie within those of a proven diagram in a part of
//      D (lists_those_near());
//   4. each seed without a cell lies outside of D, or at the place of an equal or heavier one, or some other seeds and
//      walls leave it no volume (check_other(), is_excluded()).
// Then the rows are right. Proof. Follow a path in D that meets no edge of any P_i. By 1 and 2 it leaves one P_i
// through a face only where it enters the one P_j beyond, since other faces lie in walls. So all places of D lie in the
// same number of P_i, except for edges and faces, and by 3 this number is at most 1. Let V_i be the cell of i among the
// live seeds. P_i contains V_i, because its planes are some of those that bound V_i. The V_i fill D. So the number is 1
// and the P_i overlap nowhere, which leaves P_i no place outside of V_i. By 4 the other seeds own no place of D. A face
// of V_i thus lies in a plane of row i, by 1 and 2 with the right neighbor. In a periodic D the same holds for the
// images of all P_i.
//
// Condition 2 needs no P_j. A corner of P_i in general position is named by the seeds and walls whose planes meet
// there, up to a shift. All cells of these seeds have it, if the random numbers that cells add for it sum to 0: each
// cell adds the number, the last of k seeds adds 1 - k times it (add_names()). Sums are kept by some bits of the
// number. Where one is not 0, and at corners where more than three planes meet, each neighbor j around the corner is
// asked in exact signs: does a plane of row j cut the corner off (check_corner())? If none does, P_j has it. A wrong
// diagram passes with a probability of 2^-64 or less for each sum.
//
// Rows name no corners. Each corner is then searched in one cell, which hands it on to the others, see
// handed_corners.hpp: such a corner needs no name. A cell for which that fails is made from its planes alone.
//
// Polygons of a result name the corners of its cells, which saves the search for them. prove_shared() then proves each
// corner and edge in one of its cells, see shared_corners.hpp, but only where all cells have three planes at each
// corner. Otherwise RowPolytope::wrap_polygons() proves each corner by the signs above, and cells with more than three
// planes at a corner are found from the planes alone.
//
// A part of a diagram, as a block has it, proves some of its cells so, see block_certificate.hpp. Where a corner
// touches others, each neighbor around it is asked in exact signs, as at corners where more than three planes meet.
//
// An image of a vertex is a corner where that of its original is, shifted: in exact signs (check_images()), or by its
// name, which prove_shared() compares with the number of the original.
//
// Signs come from a filter, then from exact/. Nothing here knows how the engine found a cell.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/at.hpp"
#include "core/thread_pool.hpp"
#include "output/small_faces.hpp"
#include "result/result.hpp"
#include "result/rows.hpp"
#include "unbounded/endless_box.hpp"
#include "verify/handed_corners.hpp"
#include "verify/reported_cell.hpp"
#include "verify/row_polytope.hpp"
#include "verify/shared_corners.hpp"

namespace votess {

class Certificate {
public:
    struct Verdict {
        bool proven = false;
        std::uint64_t tiny_faces = 0;  // as in Stats
        Fault fault;                   // of a cell, or of -1: of all together
        Fault unsettled;               // why a cell is neither proven nor certainly wrong
        // Of a part: sums for condition 3 of all parts, and seeds without a cell that its cells do not exclude.
        double volume = 0, doubt = 0;
        std::vector<std::int32_t> open;
    };
    // Some cells of a diagram: the first ones of the result. Rows of all their neighbors follow, then other seeds
    // without rows, which those name. Condition 3 is left to the caller, and so is the symmetry of rows.
    struct Part {
        std::size_t cells;
        std::span<const std::int64_t> ids;  // of the seeds of the result, in messages; empty: all cells are there
    };
    // What a domain without end adds, whose far box is proven.
    struct Endless {
        const detail::Result* numbers = nullptr;  // whose numbers are compared where a cell has an end; rows match
        const EndlessSides* sides = nullptr;      // where the domain has no end
        bool covered_once = false;                // condition 3 is known to hold
    };
    static constexpr const char* no_volume =
        "float64 cannot tell whether the cells fill the domain: they are too thin, too small or too large";
    // Whether cells with that sum of volumes cover the domain once, condition 3. doubt: of the sum.
    enum class Cover : std::uint8_t { once, unknown, more };
    [[nodiscard]] static Cover cover_of(double volume, double doubt, double domain);
    [[nodiscard]] static std::string text_of_cover(double volume, double domain);
    // job: of the points of the result, and its domain. Rows must ascend and be symmetric. All must outlive this
    // object.
    Certificate(const CheckedRun& run, const Job& job, const detail::Result& result, const Endless& endless,
                const Part& part = {});
    // Proves all cells on all threads. Throws `cancelled`.
    [[nodiscard]] Verdict prove();
    // Returns which of these seeds without a cell, as far as they lie in cells with rows, cells of a part exclude.
    // Throws `cancelled`.
    [[nodiscard]] std::vector<std::int32_t> find_excluded(std::span<const std::int32_t> hidden);
    // Tries to prove all cells from polygons, with what cells share proven once. Rows need not ascend nor be symmetric.
    // Returns no verdict unless it is `proven`. Call it before prove(), of another object. Throws `cancelled`.
    [[nodiscard]] std::optional<Verdict> prove_shared();

private:
    struct Worker {
        explicit Worker(const SeedPlanes& planes, std::span<const std::int32_t> images = {})
            : polytope(planes), shared(planes, images) {}
        RowPolytope polytope;
        SharedCorners shared;
        HandedCorners handed;
        RowPolytope::Measures measures;
        RowPolytope::Extent extent;       // of handed corners
        std::vector<std::uint64_t> sums;  // of names of corners, by bucket
        // Cells, and the end in `named` of the buckets of their names.
        std::vector<std::pair<std::int32_t, std::size_t>> named_cells;
        std::vector<std::uint16_t> named;
        void name_for(std::int32_t cell) { named_cells.emplace_back(cell, named.size()); }
        std::uint64_t polygons = 0;  // sum over both sides of all faces
        double volume = 0, doubt = 0;
        std::size_t covering = 0;  // other cells that may hold place_
        Fault fault, unsettled;
        std::int32_t owner = -1;                   // a live seed from which to look for others
        std::vector<std::int32_t> open, excluded;  // seeds without a cell
        struct PlaneName {                         // what a plane adds to the name of a corner
            std::uint64_t sum = 0;                 // of numbers of seeds and walls
            std::uint32_t seeds = 0, before = 0;
            std::uint64_t random = 0, shift = 0, products = 0, squares = 0;  // of seeds
        };
        std::vector<PlaneName> names;
        std::vector<std::uint64_t> keys, corner_keys;
        struct Vertex {
            std::int32_t id;
            std::uint64_t key;
        };
        std::vector<Vertex> found;
        std::vector<RowPolytope::Name> asked;  // whose planes do not cut a corner off, see check_corner()
        bool has_polygons = false;             // the polytope is that of polygons
        std::vector<std::int32_t> vertices;    // by corner
        FaceTally areas;
        std::vector<double> seed_areas;
        struct UnlistedWall {
            std::int32_t id;
            double distance;  // from the seed
            RoundedPlane plane;
        };
        std::vector<UnlistedWall> walls;
    };

    enum class Prefetch : std::uint8_t { none, seeds, all };
    template <Prefetch what, class Task>
    void for_cells(const Task& task);
    [[gnu::always_inline]] inline void prefetch(Prefetch what, std::size_t i) const;
    [[nodiscard]] bool is_live(std::int32_t id) const;
    [[nodiscard]] std::int32_t first_live() const {
        return static_cast<std::int32_t>(std::ranges::find(live_, true) - live_.begin());
    }
    [[nodiscard]] std::int64_t id_of(std::size_t i) const {
        return part_.ids.empty() ? static_cast<std::int64_t>(i) : part_.ids[i];
    }
    [[nodiscard]] std::string text_of(std::size_t i) const { return std::to_string(id_of(i)); }
    [[nodiscard]] std::string text_of(const RowPolytope::Name& name) const;
    [[nodiscard]] bool has_row(std::int32_t id) const { return rows_.begin(at(id)) != rows_.end(at(id)); }
    [[nodiscard]] RowPolytope::Name name(std::size_t entry) const;
    void check_cell(Worker& w, std::size_t i);
    [[nodiscard]] bool has_right_side(Worker& w, std::size_t i) const;
    void begin_cell(Worker& w, std::size_t i) const;
    [[nodiscard]] bool check_shared(Worker& w, std::size_t i);
    [[nodiscard]] bool shared_cover_once(Worker& sum);
    [[nodiscard]] std::vector<std::int32_t> order_in_space();
    void check_cells();
    [[nodiscard]] bool close_handed(Worker& w, std::size_t i);
    [[nodiscard]] bool build(Worker& w, std::size_t i) { return add_row(w, i) && wrap_row(w, i); }
    [[nodiscard]] bool wrap_row(Worker& w, std::size_t i);
    [[nodiscard]] bool add_row(Worker& w, std::size_t i);
    [[nodiscard]] bool add_seeds(Worker& w, std::size_t i, std::size_t entry) const;
    [[nodiscard]] bool wrap_polygons(Worker& w, std::size_t i) const;
    void find_walls(Worker& w, std::size_t i, double reach) const;
    [[nodiscard]] bool check_faces(Worker& w, std::size_t i, RowPolytope::Shape shape);
    void check_numbers(Worker& w, std::size_t i);
    void measure_handed(Worker& w, std::size_t i);
    static void add_areas(Worker& w);
    void check_polygons(Worker& w, std::size_t i);
    [[nodiscard]] bool find_vertices(Worker& w, std::size_t i) const;
    [[nodiscard]] bool take_vertices(Worker& w, std::size_t i) const;
    [[nodiscard]] std::optional<std::size_t> find_wrong_shift(bool certain) const;
    void check_images(Worker& sum);
    [[nodiscard]] std::span<const std::int32_t> polygons_of(std::size_t i) const;
    void add_polygons(Worker& w, std::size_t i) const;
    [[nodiscard]] std::span<const std::int32_t> vertices_of(std::size_t i) const;
    void check_vertices(Worker& w, std::size_t i) const;
    [[nodiscard]] bool is_near(const RowPolytope& polytope, const Vector3& place, int corner,
                               std::int32_t vertex) const;
    void check_vertex(Worker& w, std::size_t i, int corner, std::int32_t vertex) const;
    void name_planes(Worker& w, std::size_t i) const;
    void add_names(Worker& w, std::size_t i);
    void add_name(Worker& w, int corner);
    [[nodiscard]] bool is_named(const RowPolytope& polytope, int corner) const;
    static void add_to_sum(Worker& w, std::uint64_t name, std::uint64_t factor);
    [[nodiscard]] std::vector<bool> cells_of_open_names() const;
    void check_names(Worker& w, std::size_t i);
    [[nodiscard]] std::uint64_t name_of(const Worker& w, int corner, std::uint64_t& factor) const;
    void check_corner(Worker& w, std::size_t i, int corner);
    void check_other(Worker& w, std::size_t i);
    void check_hidden(Worker& w, std::size_t i);
    [[nodiscard]] bool is_excluded(Worker& w, std::size_t i);
    [[nodiscard]] RowPolytope::Name owner_of(Worker& w, std::size_t i, const Vector3& place) const;
    [[nodiscard]] std::optional<std::size_t> best_cut(Worker& w, std::size_t i, const Vector3& place, bool exactly,
                                                      RowPolytope::Name& best) const;
    template <class Visit>
    void for_neighbors(const RowPolytope::Name& of, const Visit& visit) const;
    void check_volume(Worker& sum);
    [[nodiscard]] bool is_covered_once();
    void tally_cover(Worker& w, std::size_t i) const;
    [[nodiscard]] bool no_other_covers() const;
    void find_place();
    void unsettle(Worker& w, std::size_t i, const char* why) const;

    const CheckedRun& run_;
    const Job& job_;
    const detail::Result& result_;
    Endless endless_;
    Part part_;
    std::size_t count_;  // cells to prove, the first ones
    const detail::Result& numbers_;
    double tolerance_;  // of numbers
    Rows rows_;
    SeedPlanes planes_;
    double unscale_;
    std::vector<bool> live_;
    struct NearWall {  // with an outward normal of length 1; an offset of -infinity is not known
        std::int32_t id;
        Vector3 normal;
        double offset;
    };
    std::vector<NearWall> walls_;
    bool has_places_ = false;                // or other numbers that are compared
    bool measures_ = false;                  // volumes or others are needed
    std::optional<std::size_t> covered_by_;  // the cell that holds place_
    Vector3 place_{};
    ThreadPool pool_;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::vector<std::uint64_t> open_names_;  // sums over all workers, by bucket
};

}  // namespace votess
