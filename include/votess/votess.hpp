// votess: exact 3D Voronoi tessellation. C++20 interface.
//
//     votess::Options options;
//     votess::Tessellation t = votess::tessellate(points /* span<const double>, 3N */, options);
//     for (auto j : t.neighbors(i)) ...        t.volumes()[i]
//
// The cell of a seed is the part of the domain that is nearer to it than to any other seed; two seeds are
// neighbors when their cells share a polygon of positive area. Each cell is found by itself, by clipping with bisectors
// or by walking along its edges, and complete when the security radius proves that no other seed can reach it (Ray,
// Sokolov, Lefebvre, Lévy: Meshless Voronoi on the GPU, ACM TOG 37(6), 2018). Every sign that decides the topology is
// exact for the float64 coordinates as given, so the lists are the same on any device, for any thread count, any tuning
// option and any order of the seeds.
//
// The library never prints, never exits and keeps no global state, but for the memory that a machine has no GPU. Errors
// are thrown as votess::Error.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>
#include <votess/export.hpp>
#include <votess/version.hpp>

namespace votess {

// The values equal those of votess_status in votess.h.
enum class ErrorCode : std::int32_t {
    invalid_argument = 1,  // bad input: the message names the first offending index and value
    out_of_memory = 2,
    cancelled = 3,    // the progress callback asked to stop
    unsupported = 4,  // a request that this build or this device cannot serve
    internal = 5,     // a bug in votess: please report it
    device_lost = 6,  // the device stopped answering or its driver failed
    invalid_use = 7,  // a Tessellator that is at work in another call, or was moved from
    storage = 8,      // a temporary file of tessellate_stream() cannot be written or read, or its disk has no room
    no_threads = 9,   // the system gives fewer threads than Options::threads requests
};

class VOTESS_API Error : public std::runtime_error {
public:
    Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    [[nodiscard]] ErrorCode code() const noexcept { return code_; }

private:
    ErrorCode code_;
};

// An axis-aligned box. Valid when lower < upper on every axis; both are finite.
struct Box {
    std::array<double, 3> lower{};
    std::array<double, 3> upper{};
};

// One byte per cell. A finished run holds only `certified`, `duplicate`, `empty` and `outside`; the others are reasons
// why one engine handed a cell to the next.
enum class CellStatus : std::uint8_t {
    certified = 0,             // the security radius proves the cell complete, every sign is certain
    needs_exact = 1,           // a sign could not be certified in floating point
    plane_overflow = 2,        // more planes than the engine's storage holds
    vertex_overflow = 3,       // more vertices than the engine's storage holds
    candidates_exhausted = 4,  // the candidate list ended before the security radius
    duplicate = 5,             // same coordinates as a seed of lower index, which keeps the cell; this one is empty
    empty = 6,                 // power diagrams: the cell has no interior
    outside = 7,               // the seed lies outside of box or walls and was dropped, see Options::outside
};

// A triclinic box: its points are origin + f0 a + f1 b + f2 c with 0 <= f <= 1. The edge vectors a, b, c may have any
// direction and handedness; the volume is not 0. It repeats along those edges that `periodic` names. Across each other
// edge it ends at two walls, the planes through its corners that the other two edges span: -1 and -2 at f0 = 0 and 1,
// -3 and -4 at f1, -5 and -6 at f2.
struct TriclinicBox {
    std::array<double, 3> origin{}, a{}, b{}, c{};
    std::array<bool, 3> periodic{true, true, true};
};

// A wall: the domain is where normal . x <= offset. The normal has any length but 0.
struct Wall {
    std::array<double, 3> normal{};
    double offset = 0;
};

// Walls around round bodies: polyhedra of planes that touch them, so that they hold all of the body and a little more.
// Throw invalid_argument for what is not finite, no direction or size, and for too few faces or more than a million.
// sphere: at least 4 faces; the volume is larger by a share of about 3 / faces (1e-2 for 300).
[[nodiscard]] VOTESS_API std::vector<Wall> sphere_walls(const std::array<double, 3>& center, double radius,
                                                        std::size_t faces);
// cylinder without ends: at least 3 faces; the cross section is larger by pi^2 / (3 faces^2) (3e-3 for 32).
[[nodiscard]] VOTESS_API std::vector<Wall> cylinder_walls(const std::array<double, 3>& point,
                                                          const std::array<double, 3>& axis, double radius,
                                                          std::size_t faces);
// cone without end; axis: from the apex into it; angle: between axis and surface, in radians, below pi / 2. Larger by
// the same share as a cylinder.
[[nodiscard]] VOTESS_API std::vector<Wall> cone_walls(const std::array<double, 3>& apex,
                                                      const std::array<double, 3>& axis, double angle,
                                                      std::size_t faces);

enum class Outside : std::int32_t {
    error = 0,  // refuse the input
    drop = 1,   // seeds outside of box or walls get an empty cell with status `outside`
};

enum class Duplicates : std::int32_t {
    merge = 0,  // the lowest index keeps the cell, the others are empty with status `duplicate`
    error = 1,  // refuse the input
};

// The relative error that is promised of volumes, centroids and areas. The lists are exact either way.
enum class Precision : std::int32_t {
    single = 0,   // 1e-5 on a GPU; the CPU gives 1e-10 always
    double_ = 1,  // 1e-10; on a GPU that lacks float64 arithmetic `unsupported`
};

// Which arrays to compute and store.
struct Want {
    bool neighbors = true;   // indptr, indices
    bool volumes = true;     // volumes
    bool centroids = false;  // centroids
    bool counts = false;     // face_counts, edge_counts, vertex_counts
    bool areas = false;      // face_areas; and neighbors, whose entries they belong to
    bool normals = false;    // face_normals; and neighbors
    bool surfaces = false;   // surface_areas
    bool radii = false;      // security_radii
    bool vertices = false;   // vertices, cell_vertex_indptr, cell_vertex_indices; and neighbors
    bool faces = false;      // face_offsets, face_vertices; and vertices, neighbors, and walls in the rows
};
// Returns the Want of names with commas between them: the words above, and the arrays that they stand for, such as
// "face_areas,volumes". An array brings its whole word. Throws invalid_argument for another name, or an empty one.
[[nodiscard]] VOTESS_API Want want_of(std::string_view names);

// Called from the thread that runs tessellate() or a query, at most some ten times a second. `fraction` grows from 0 to
// 1. Return false to stop: the call then throws ErrorCode::cancelled. What the callback throws ends the call as well,
// and reaches its caller. It may use other Tessellators and Diagrams, not its own.
using ProgressCallback = std::function<bool(double fraction)>;
// One line of text for a log, without a line end.
using LogCallback = std::function<void(std::string_view message)>;

struct Options {
    // Domain. Default: the bounds of the seeds, each side moved out by half of (longest side / cbrt(N)); when all
    // seeds coincide, by half of the largest absolute coordinate (0.5 when that is 0).
    std::optional<Box> box;
    // Axes along which the box repeats, which then must be given. Seeds beyond it are wrapped into it, by a whole
    // number of periods and without any rounding; an image of a seed is the exact sum of its coordinates and box
    // vectors.
    std::array<bool, 3> periodic{};
    // Instead of box. It says itself along which edges it repeats; `periodic` says the same beside it, or nothing.
    std::optional<TriclinicBox> cell;
    // A convex polyhedron: walls that cut the box, ids -7, -8, ... in this order. Not with a periodic domain. Without a
    // box the polyhedron bounds itself; on sides where it has no end within a million times the size of the default
    // box, that one does.
    std::vector<Wall> walls;
    Outside outside = Outside::error;
    // List the wall ids -1..-6 (xmin, xmax, ymin, ymax, zmin, zmax) and -7, -8, ... in the rows too.
    bool list_walls = false;
    // Power diagram: N weights w, length unit squared, any sign; copied by the call. The cell of seed i is where
    // |x - p_i|^2 - w_i is least. Empty: all weights are 0, the Voronoi diagram. Or N radii: weights are their squares,
    // rounded to float64.
    std::span<const double> weights, radii;
    // Drop faces between two cells that are smaller than this times the mean area of all such faces of the run from
    // rows, areas, normals, polygons and face_counts; decided once per pair, by the area that the cell of lower index
    // has found, so that rows stay symmetric. Walls stay, and vertices. Adds areas and neighbors. 0 drops nothing.
    double min_face = 0;
    // The same for faces smaller than this area, in the square of the unit of length; the larger limit counts.
    double min_area = 0;
    Want want;
    Duplicates duplicates = Duplicates::merge;

    // "auto" = the first GPU, else the CPU; "cpu"; "gpu" = the first GPU; "lavapipe" = the first Vulkan device that is
    // software; a number = that device of devices(). A device that is not available is `unsupported`, never replaced.
    // With "auto" the CPU replaces a GPU that fails or cannot do what is requested. Nor does "auto" open a GPU for
    // fewer than 10,000 seeds: the CPU is done before. Stats::device names the device that ran.
    std::string device = "auto";
    Precision precision = Precision::single;
    // Tuning: changes speed and memory, never the answer.
    // CPU threads, at most 1024. Throws `no_threads` where the system gives fewer. 0 = one for each processor, or as
    // many of them as the system gives.
    unsigned threads = 0;
    unsigned grid_resolution = 0;  // blocks along an axis of the sorting grid, 0 = automatic; at most 2^20
    unsigned k_init = 0;           // GPU: nearest neighbors tried first for each cell, 0 = automatic; at most 1024
    unsigned chunk_size = 0;       // GPU: cells in flight at once, 0 = automatic
    // CPU: "baseline", "avx2" or "avx512"; one that the processor lacks is `unsupported`. "" = the best it has.
    std::string instructions;

    ProgressCallback progress;
    LogCallback log;
};
// What a result holds: options.want, and the arrays that these, min_face and min_area need. Throws invalid_argument or
// unsupported for options that are wrong whatever the seeds are.
[[nodiscard]] VOTESS_API Want implied_want(const Options& options);

// Seconds of wall clock per stage of the pipeline. `open` looks for a device, opens it and makes its pipelines; it is 0
// where no device was looked for. On the CPU `knn` builds the search structure, and `clip` pulls the candidates and
// decides uncertain signs exactly on the spot, so that nothing is left for `fallback`. On a GPU, where chunks of cells
// pass through knn, clip and download while the CPU does its share of the chunk before (`fallback`), that stretch is
// divided by what each took; where a subgroup of the device makes a cell, it searches within `clip`.
struct StageSeconds {
    double open = 0, upload = 0, sort = 0, knn = 0, clip = 0, fallback = 0, download = 0;
    double total = 0;
};

// Why cells were redone on the CPU after another device.
struct FallbackReasons {
    std::uint64_t uncertain = 0;  // floating point could not decide a sign, or not measure well enough
    std::uint64_t overflow = 0;   // more planes or vertices at once than the device holds
    std::uint64_t exhausted = 0;  // the search ended before the security radius
    std::uint64_t skipped = 0;    // the device had failed at nearly all cells before, and was not asked
    std::uint64_t domain = 0;     // the device does not clip this domain
};

struct Stats {
    std::string device;                // name of the device that ran
    std::uint64_t points = 0;          // N
    std::uint64_t faces = 0;           // sum over cells of their number of faces, walls included
    double mean_faces = 0;             // faces / cells that are not empty
    double volume_sum = 0;             // sum of all volumes; 0 when volumes were not wanted
    double box_volume = 0;             // volume of the domain
    std::uint64_t duplicates = 0;      // seeds with status `duplicate`
    std::uint64_t empty_cells = 0;     // seeds that have no cell: duplicate, empty or outside
    std::uint64_t fallback_cells = 0;  // cells redone on the CPU after another device
    FallbackReasons fallback_reasons;  // they add up to fallback_cells
    std::uint64_t exact_cells = 0;     // cells where exact arithmetic decided a sign
    // Of faces, walls left out: those with an area below 1e-9 of the mean, or rather below the largest power of two
    // within that. Coordinates of lattices that were rounded have such faces; Options::min_face drops them. Known where
    // the CPU measured all cells, for volumes, centroids, areas, surfaces or radii, and where there are polygons;
    // count_tiny_faces() finds it elsewhere.
    std::optional<std::uint64_t> tiny_faces;
    unsigned threads = 0;  // CPU threads used
    StageSeconds seconds;
    std::uint64_t peak_memory_bytes = 0;  // peak resident memory of the process so far
    // What volumes, centroids and areas hold; the CPU always gives double_.
    Precision precision = Precision::double_;
};

namespace detail {
struct Result;
struct TessellatorState;
}  // namespace detail

struct Delaunay;
struct VerifyOptions;
struct VerifyReport;

// The result: a shared handle to immutable arrays, cheap to copy, safe to read from many threads. The spans stay
// valid as long as any copy of the handle. An array that was not wanted is an empty span. N is the number of seeds,
// rows follow the input order.
class VOTESS_API Tessellation {
public:
    Tessellation();
    explicit Tessellation(std::shared_ptr<const detail::Result> result);

    [[nodiscard]] std::size_t size() const noexcept;  // N
    // Row i: ids of the neighbors of seed i in ascending order (walls first, being negative).
    [[nodiscard]] std::span<const std::int32_t> neighbors(std::size_t i) const noexcept;
    [[nodiscard]] std::span<const std::int64_t> indptr() const noexcept;   // N+1, CSR row starts, indptr[0] = 0
    [[nodiscard]] std::span<const std::int32_t> indices() const noexcept;  // indptr[N], CSR columns
    // indptr[N], length unit squared: area of the face behind each entry of indices, in the same order; those of walls
    // only when the rows list walls. Each with an absolute error of at most 1e-10 of the area of the cell's whole
    // surface (1e-5 with stats().precision single), so a face that is no tiny part of it has that relative error, and
    // one too small to measure may have area 0.
    [[nodiscard]] std::span<const double> face_areas() const noexcept;
    // 3 indptr[N]: unit normal of the face behind each entry of indices, outward.
    [[nodiscard]] std::span<const double> face_normals() const noexcept;
    // 3 indptr[N] in a periodic domain, else empty: the number of box vectors (sx, sy, sz) that carry the neighbor to
    // where it touches, both seeds taken where they lie inside the box. Rows are ordered by id, then shift.
    [[nodiscard]] std::span<const std::int8_t> shifts() const noexcept;
    [[nodiscard]] std::span<const double> volumes() const noexcept;               // N, length unit cubed
    [[nodiscard]] std::span<const double> centroids() const noexcept;             // 3N, x y z absolute; NaN when empty
    [[nodiscard]] std::span<const std::uint32_t> face_counts() const noexcept;    // N, walls included
    [[nodiscard]] std::span<const std::uint32_t> edge_counts() const noexcept;    // N
    [[nodiscard]] std::span<const std::uint32_t> vertex_counts() const noexcept;  // N
    [[nodiscard]] std::span<const double> surface_areas() const noexcept;         // N, walls included
    // N: twice the distance from the seed to the farthest vertex of its cell; 0 when empty.
    [[nodiscard]] std::span<const double> security_radii() const noexcept;
    // The mesh. Vertices that are equal in exact arithmetic are one, shared by all cells that have it; in a periodic
    // domain cells lie where their seeds do, so a vertex appears once for each image that some cell has.
    [[nodiscard]] std::span<const double> vertices() const noexcept;  // 3V, absolute
    // indptr[N]+1 and face_offsets[indptr[N]]: the polygon of each entry of indices, as vertices in counterclockwise
    // order seen from outside the cell.
    [[nodiscard]] std::span<const std::int64_t> face_offsets() const noexcept;
    [[nodiscard]] std::span<const std::int32_t> face_vertices() const noexcept;
    // N+1 and its last: the vertices of each cell, ascending.
    [[nodiscard]] std::span<const std::int64_t> cell_vertex_indptr() const noexcept;
    [[nodiscard]] std::span<const std::int32_t> cell_vertex_indices() const noexcept;
    // The area below which faces were dropped, see Options::min_face and min_area; 0: none were.
    [[nodiscard]] double least_face() const noexcept;
    [[nodiscard]] std::span<const CellStatus> status() const noexcept;  // N
    // N when the input has duplicates, else empty: index of the seed that keeps the cell; -1 for those not duplicate.
    [[nodiscard]] std::span<const std::int32_t> duplicate_of() const noexcept;
    [[nodiscard]] const Box& box() const noexcept;  // the domain that was used; of a triclinic one the bounds
    [[nodiscard]] const std::array<bool, 3>& periodic() const noexcept;
    [[nodiscard]] const std::optional<TriclinicBox>& cell() const noexcept;
    [[nodiscard]] std::span<const Wall> walls() const noexcept;
    [[nodiscard]] std::span<const double> weights() const noexcept;  // N in a power diagram, else empty
    [[nodiscard]] bool lists_walls() const noexcept;                 // whether the rows hold wall ids
    [[nodiscard]] bool probed() const noexcept;                      // whether the cells are those of Diagram::probe()
    [[nodiscard]] const Stats& stats() const noexcept;

private:
    friend VOTESS_API Delaunay delaunay(const Tessellation& tessellation);
    friend VOTESS_API VerifyReport verify(const Tessellation& tessellation, std::span<const double> points,
                                          const VerifyOptions& options);
    std::shared_ptr<const detail::Result> result_;
};

// Keeps device, threads and buffers between calls, and takes back the arrays of a Tessellation that nobody holds any
// more: calls of the same size take no new memory, so seeds that move from call to call are tessellated by one object
// that is kept. Destroying the Tessellator frees what it keeps; results that are held stay valid. One call at a time
// per object: a second one, from another thread or from a callback of the first, throws `invalid_use` and changes
// nothing. Different objects are independent. After fork() the child may use, move and destroy a copy of its own: the
// CPU gets new threads; a GPU opened before is `unsupported` there, or with "auto" replaced by the CPU; one that was at
// work during the fork stays so, and throws `invalid_use`.
class VOTESS_API Tessellator {
public:
    Tessellator();
    ~Tessellator();
    Tessellator(Tessellator&&) noexcept;
    Tessellator& operator=(Tessellator&&) noexcept;

    // points: 3N coordinates x0 y0 z0 x1 ..., any length unit, finite, inside options.box. The call copies them and
    // the weights first. Where another thread writes into them meanwhile, cells are wrong, and nothing else is.
    // float32 input is widened without loss. N = 0 gives an empty result; N from 2^31 on is `unsupported`.
    // Throws Error: invalid_argument, out_of_memory, cancelled, unsupported, internal, device_lost, invalid_use,
    // no_threads.
    // A Tessellator that was moved from may only be assigned or destroyed, else `invalid_use`.
    [[nodiscard]] Tessellation tessellate(std::span<const double> points, const Options& options = {});
    [[nodiscard]] Tessellation tessellate(std::span<const float> points, const Options& options = {});

private:
    std::shared_ptr<detail::TessellatorState> state_;
};

// The same with a Tessellator that lives for one call.
[[nodiscard]] VOTESS_API Tessellation tessellate(std::span<const double> points, const Options& options = {});
[[nodiscard]] VOTESS_API Tessellation tessellate(std::span<const float> points, const Options& options = {});

// The dual of the cells. Around each vertex of the mesh that lies off the walls: the tetrahedron of its four cells, or
// where more cells meet (seeds on an empty sphere) the convex polytope that their seeds span, which has no one way to
// be cut into tetrahedra. Together the Delaunay complex of the seeds (of a power diagram the regular one, with power
// spheres), but for simplices whose empty sphere has its center outside of the domain. In order of the vertices; in a
// periodic domain each once, not for each image.
struct Delaunay {
    std::vector<std::int32_t> tetrahedra;          // 4T seeds, the first the lowest, positive: det(b-a, c-a, d-a) > 0
    std::vector<std::int8_t> tetrahedra_shifts;    // 12T in a periodic domain, else empty: as Tessellation::shifts()
    std::vector<std::int32_t> tetrahedra_centers;  // T: the vertex that is the center of the empty sphere
    std::vector<std::int64_t> polytope_indptr;     // P+1
    std::vector<std::int32_t> polytope_indices;    // seeds of polytope p from polytope_indptr[p], ascending
    std::vector<std::int8_t> polytope_shifts;      // three for each of these, as above
    std::vector<std::int32_t> polytope_centers;    // P
};
// Needs Want::faces, else throws invalid_argument, as for cells of probes. After min_face or min_area, vertices that
// dropped faces joined are one, named by the first of them: a rounded lattice has the polytopes of the lattice. A
// dropped face shrinks to an edge when it is long, else to a point. Ends of edges so short that a face of that width is
// dropped are joined too, and vertices where a cell has only two faces. Each polytope is a union of tetrahedra, so
// volumes sum up as before. Throws invalid_argument where that leaves no complex: a face that was not dropped would
// shrink too, or a vertex would meet its own image.
[[nodiscard]] VOTESS_API Delaunay delaunay(const Tessellation& tessellation);

// The checker of --verify. Volumes sum to the domain's (relative 1e-9; 1e-4 when stats().precision is single), neighbor
// rows ascend and are symmetric, Euler's formula V - E + F = 2 holds for each cell, and `sample` cells drawn with
// `rng_seed` equal cells clipped anew by every seed, without any search structure. Checks whose arrays the result lacks
// are skipped and named in `skipped`. Where there are polygons, each cell is also watertight: every edge twice, in
// opposite directions, and both cells of a face have the same polygon. Where there are areas and normals of all faces,
// it is closed: their sum is 0 to 1e-9 of the surface (1e-4 when single). After min_face or min_area neither these nor
// Euler's formula.
struct VerifyOptions {
    // Nothing: as many as take about a second, at least 64 or all. How many depends on the input alone, not on a clock.
    std::optional<std::size_t> sample;
    std::uint64_t rng_seed = 1;
};
struct VerifyReport {
    bool passed = false;
    std::string failure;               // one line on the first failed check; empty when passed
    std::vector<std::string> skipped;  // of "volumes", "symmetry", "euler", "sample"
    std::size_t sampled = 0;           // cells tried by brute force, up to the one that failed
    // No failure: as in Stats. Of rows found in blocks unknown.
    std::optional<std::uint64_t> tiny_faces;
};
// points: the array given to tessellate(). Throws invalid_argument when its length differs from the result's, and for
// cells of probes.
[[nodiscard]] VOTESS_API VerifyReport verify(const Tessellation& tessellation, std::span<const double> points,
                                             const VerifyOptions& options = {});

// Returns Stats::tiny_faces; where that is unknown, it tessellates the points again on the CPU and measures. points,
// and what it throws: as verify().
[[nodiscard]] VOTESS_API std::uint64_t count_tiny_faces(const Tessellation& tessellation,
                                                        std::span<const double> points);

// Where the seeds lie inside a periodic domain, 3N: points, moved by whole box vectors and each coordinate rounded
// once. Tessellation::shifts() count from there. Seeds that were dropped stay where they are. points: as in verify().
[[nodiscard]] VOTESS_API std::vector<double> wrapped_points(const Tessellation& tessellation,
                                                            std::span<const double> points);

struct DeviceInfo {
    std::string id;           // what Options::device accepts
    std::string name;         // for people
    std::string description;  // limits and features in one line
};
[[nodiscard]] VOTESS_API std::vector<DeviceInfo> devices();

}  // namespace votess
