// votess: exact 3D Voronoi tessellation. C++20 interface.
//
//     votess::Options options;
//     votess::Tessellation t = votess::tessellate(points /* span<const double>, 3N */, options);
//     for (auto j : t.neighbors(i)) ...        t.volumes()[i]
//
// The cell of a seed is the part of the domain that is nearer to it than to any other seed. Two seeds are neighbors
// when their cells share a polygon of positive area.
//
// Method: each cell is found separately, either by clipping with bisectors or by walking along its edges. It is
// complete when the security radius proves that no other seed can reach it (Ray, Sokolov, Lefebvre, Lévy: Meshless
// Voronoi on the GPU, ACM TOG 37(6), 2018). Every sign that decides the topology is exact for the float64 coordinates
// as given. So the lists do not depend on device, thread count, tuning options or the order of the seeds.
//
// The library never prints, never exits and keeps no global state except a cached "no GPU found". Errors are thrown as
// votess::Error.
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
    cancelled = 3,       // the progress callback returned false
    unsupported = 4,     // this build or this device cannot serve the request
    internal = 5,        // a bug in votess: please report it
    device_lost = 6,     // the device stopped answering or its driver failed
    invalid_use = 7,     // the Tessellator is busy in another call, or was moved from
    storage = 8,         // tessellate_stream() cannot write or read a temporary file, or its disk is full
    no_threads = 9,      // the system gives fewer threads than Options::threads requests
    not_converged = 10,  // fit_volumes() did not reach the tolerance
};

class VOTESS_API Error : public std::runtime_error {
public:
    Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    [[nodiscard]] ErrorCode code() const noexcept { return code_; }

private:
    ErrorCode code_;
};

// An axis-aligned box. Valid when lower < upper on every axis and all numbers are finite.
struct Box {
    std::array<double, 3> lower{};
    std::array<double, 3> upper{};
};

// One byte per cell. A finished run holds only `certified`, `duplicate`, `empty` and `outside`. The other values are
// reasons why one engine handed a cell to the next.
enum class CellStatus : std::uint8_t {
    certified = 0,             // complete: the security radius proves it, and every sign is certain
    needs_exact = 1,           // floating point could not certify a sign
    plane_overflow = 2,        // more planes than the engine can store
    vertex_overflow = 3,       // more vertices than the engine can store
    candidates_exhausted = 4,  // the candidate list ended before the security radius
    duplicate = 5,             // no cell: a seed of lower index has the same coordinates and keeps the cell
    empty = 6,                 // power diagrams, and seeds outside: the cell has no interior in the domain
    outside = 7,               // the seed lies outside of box or walls and was dropped, see Options::outside
};

// A triclinic box: the points origin + f0 a + f1 b + f2 c with 0 <= f <= 1. The edge vectors may have any direction and
// handedness; the volume must not be 0. The box repeats along the edges that `periodic` names. Across any other edge it
// ends at two walls, the planes that the remaining two edges span: -1 and -2 at f0 = 0 and 1, -3 and -4 at f1, -5 and
// -6 at f2. Along an edge that is 0 and does not repeat it has no end, see Options::box. For walls and for the place of
// seeds in the box, such an edge stands for the axis that is most nearly perpendicular to the others.
struct TriclinicBox {
    std::array<double, 3> origin{}, a{}, b{}, c{};
    std::array<bool, 3> periodic{true, true, true};
};

// A wall: the domain is where normal . x <= offset. The normal may have any positive length.
struct Wall {
    std::array<double, 3> normal{};
    double offset = 0;
};

// A closed surface of triangles, which encloses the domain. The surface may have several parts, holes through it,
// and parts inside each other, and may intersect itself. Vertices of a triangle are counterclockwise seen from outside.
// Triangles may have no area.
// With Options::planar it is a set of closed rings of edges, which have the domain on their left. So outlines are
// counterclockwise, and holes clockwise. Vertices at equal places are then one without `merge`; a tolerance is refused.
struct TriangleMesh {
    std::span<const double> vertices;         // 3V coordinates; in the plane 2V
    std::span<const std::int32_t> triangles;  // 3T indices of vertices; in the plane 2E, of edges
    bool merge = false;                       // vertices at equal places are one; both zeros are equal
    // merge: vertices at most this far apart are one too, at the place of the first. A share of the longest side of the
    // mesh's bounds, from 0 to 0.01. Vertices in a chain of such steps are one. Stats say how far they moved.
    double tolerance = 0;
};

// Polygons that share vertices, as files hold them.
struct PolygonMesh {
    std::span<const double> vertices;       // 3V coordinates
    std::span<const std::int32_t> corners;  // of all polygons: indices of vertices
    std::span<const std::int64_t> offsets;  // N+1: polygon f has corners offsets[f] to offsets[f + 1] - 1
    std::int64_t first = 0;                 // the number of the first vertex and of the first polygon, for messages
};

// Returns triangles for TriangleMesh, as 3 indices of vertices each, in the order of the polygons. Polygons need not be
// convex, and are cut between their corners, by exact signs. A convex one becomes a fan around its first corner.
// Corners on a straight side, and several at one place, are kept, so that a closed mesh remains closed. Throws
// invalid_argument for a polygon that is not simple: its sides touch or cross; and for one that is not flat: a corner
// lies farther from its plane than rounding to 6 digits explains.
[[nodiscard]] VOTESS_API std::vector<std::int32_t> triangulate(const PolygonMesh& mesh);

// Return walls around round bodies: polyhedra of planes that touch the body, and so enclose it. Throw invalid_argument
// for numbers that are not finite, for a zero direction or size, and for too few or more than a million faces.
// Sphere: at least 4 faces. The volume is larger by a share of about 3 / faces (1e-2 for 300).
[[nodiscard]] VOTESS_API std::vector<Wall> sphere_walls(const std::array<double, 3>& center, double radius,
                                                        std::size_t faces);
// Cylinder without ends: at least 3 faces. The cross section is larger by pi^2 / (3 faces^2) (3e-3 for 32).
[[nodiscard]] VOTESS_API std::vector<Wall> cylinder_walls(const std::array<double, 3>& point,
                                                          const std::array<double, 3>& axis, double radius,
                                                          std::size_t faces);
// Cone without end: at least 3 faces, larger by the same share as a cylinder. axis: from the apex into the cone.
// angle: between axis and surface, in radians, below pi / 2.
[[nodiscard]] VOTESS_API std::vector<Wall> cone_walls(const std::array<double, 3>& apex,
                                                      const std::array<double, 3>& axis, double angle,
                                                      std::size_t faces);

enum class Outside : std::int32_t {
    error = 0,  // refuse the input
    drop = 1,   // seeds outside of box or walls get an empty cell with status `outside`
    keep = 2,   // seeds outside of box or walls get the part of their cell inside, or status `empty`
};

enum class Duplicates : std::int32_t {
    merge = 0,  // the lowest index keeps the cell, the others are empty with status `duplicate`
    error = 1,  // refuse the input
};

// The relative error that is promised of volumes, centroids and areas. The lists are exact either way.
enum class Precision : std::int32_t {
    single = 0,   // 1e-5 on a GPU, 1e-10 on the CPU
    double_ = 1,  // 1e-10; a GPU without float64 arithmetic is `unsupported`
};

// Which arrays to compute and store. A flag also requests the arrays after "adds".
struct Want {
#define VOTESS_GROUP(name, NAME, bit, value) bool name = value;
#include "votess/arrays.h"
};
// Returns the Want of a list of names with commas between them. A name is a field of Want or one of its arrays, as in
// "face_areas,volumes"; an array requests its whole field. Throws invalid_argument for an unknown or empty name.
[[nodiscard]] VOTESS_API Want want_of(std::string_view names);

// Called by the thread that runs tessellate() or a query, about ten times a second at most. `fraction` grows from 0 to
// 1. Return false to stop: the call then throws `cancelled`. An exception of the callback also ends the call and
// reaches its caller. A callback may use other Tessellators and Diagrams, not the one that calls it.
using ProgressCallback = std::function<bool(double fraction)>;
// One line of text for a log, without a line end.
using LogCallback = std::function<void(std::string_view message)>;

struct Options {
    // Domain. Default: the bounds of the seeds, each side moved out by half of (longest side / cbrt(N)). When all
    // seeds coincide: by half of the largest absolute coordinate, or 0.5 when that is 0.
    //
    // Bounds may be infinite (-infinity below, infinity above): the domain has no end there. Neighbors are exact,
    // however far away they meet. A cell that reaches infinity has infinite volume, surface and security radius, and no
    // centroid. Its row lists infinity once if it lists walls, as -1 without any end, else as the first of -1 to -6
    // that is missing. Infinity has an empty polygon, an infinite area and no normal. In other polygons -1 follows the
    // last corner where they reach infinity; in two dimensions it takes the place of a corner. Edges include rays. The
    // CPU makes the cells near the rim. Other axes may be periodic: a slab, a wire, or a strip of the plane. Faces of
    // infinite area do not count in the mean of min_face, and stay. Walls need a domain with ends, and so do all
    // functions except tessellate(), verify(), delaunay(), network(), watershed(), alpha_complex(), wrapped_points(),
    // render() without open cells, and Diagram, which needs `box`. Throws `unsupported` where vertices may leave
    // the range of double: an extent of 2^230 times the lowest bit of a coordinate, 2^160 with weights, 2^115 in a
    // cell.
    std::optional<Box> box;
    // Axes along which the box repeats; needs `box`. Seeds outside are wrapped into the box by a whole number of
    // periods, without rounding. An image of a seed is the exact sum of its coordinates and box vectors.
    std::array<bool, 3> periodic{};
    // A triclinic box instead of `box`. Set cell->periodic; leave `periodic` unset or equal.
    std::optional<TriclinicBox> cell;
    // Walls that cut the box, so that the domain is a convex polyhedron. Their ids are -7, -8, ... in this order. Not
    // in a periodic domain. Without a box the walls bound the domain. On sides where they have no end within a million
    // times the size of the default box, the default box bounds it.
    std::vector<Wall> walls;
    // A closed triangle mesh as the domain. Copied by the call. Each cell is its part inside, and cells without such a
    // part are `empty`. Volumes, centroids and areas count each place as often as the surface winds around it: once
    // inside, except where a surface intersects itself or encloses another one. Rows list neighbors that share a
    // positive area inside. `surface_areas` are those of the parts, and mesh_areas() the surface's share of them. Seeds
    // may lie outside. The mesh must lie strictly inside of `box`; the default box holds the mesh and the seeds. Along
    // periodic axes it may touch the box. A cell then has the parts of all its images in the mesh. Throws
    // invalid_argument for a mesh that is not closed or oriented alike, and names the first edge or triangle. Only
    // tessellate(), fit_volumes() and Diagram clip by a mesh, and not with walls or `outside`. The parts have no
    // vertices, faces, counts and radii: pieces() makes closed meshes of them. min_face and min_area drop faces by
    // areas inside.
    //
    // A place on the surface counts as if the mesh were moved by less than any distance, first in x, then y, then z. So
    // nothing is lost or counted twice where seeds and mesh share planes. A face in the surface counts as outside. A
    // part or face of a cell that touches the mesh so, and that rounding alone could explain, is dropped.
    //
    // In the plane the mesh is rings of edges, mesh_areas() holds lengths, and `cell` is refused.
    std::optional<TriangleMesh> mesh;
    // Points outside the domain: an error; or dropped, which leaves an empty cell with the status `outside`; or kept,
    // which gives each the part of its cell inside the domain, or the status `empty`.
    Outside outside = Outside::error;
    // The seeds whose cells to make, by index, each once; all of them if it is not set. Rows come in this order, and
    // their neighbors are indices among all seeds. The CPU makes the cells. Copied by the call.
    std::optional<std::span<const std::int64_t>> only;
    // List walls as neighbors too: -1 to -6 = xmin, xmax, ymin, ymax, zmin, zmax of the box, or the faces of a cell
    // across a, b and c; -7, -8, ... = walls.
    bool list_walls = false;
    // Two dimensions: the points are 2N coordinates x y, and the cells are polygons. `volumes` holds areas,
    // `surface_areas` perimeters and `face_areas` lengths of edges; min_area is a length. Centroids, normals, vertices
    // and shifts have two components. All counts are the number of edges. The corners of a cell, cell_vertex_indices,
    // are counterclockwise; face_vertices holds two for each edge, in that order. Leave z 0 in box, walls and cell, and
    // `c` of a cell. The default box has sqrt(N) instead of cbrt(N). Only count_tiny_faces() needs three dimensions
    // and throws invalid_argument.
    bool planar = false;
    // Power diagram: N weights w, length unit squared, any sign; or N radii, whose squares, rounded to float64, are the
    // weights. Copied by the call. The cell of seed i is where |x - p_i|^2 - w_i is least. Both empty: the Voronoi
    // diagram.
    std::span<const double> weights, radii;
    // Drop faces between two cells with an area below this share of the mean of all such faces. They leave lists,
    // areas, normals, polygons and face counts; walls and vertices stay. The cell of lower index decides for both, so
    // lists stay symmetric. 0 drops none.
    double min_face = 0;
    // Drop faces below this area, as min_face does; the larger limit counts (length unit squared).
    double min_area = 0;
    Want want;
    // Points of equal coordinates: the lowest index keeps the cell and the others get an empty one, or the input is
    // refused.
    Duplicates duplicates = Duplicates::merge;

    // Where to run: auto = the first GPU, else the CPU; cpu; gpu = the first GPU; lavapipe = the first Vulkan device
    // that is software; or the id of one of devices(). auto is the CPU for fewer than 10,000 points, which takes less
    // time than to open a GPU, and if the GPU fails or cannot serve the request. Otherwise a missing device is an
    // error.
    std::string device = "auto";
    // Relative error of volumes, centroids and areas from a GPU: 1e-5 or 1e-10. The CPU always reaches 1e-10; the
    // neighbors are exact either way.
    Precision precision = Precision::single;
    // Tuning: changes speed and memory, never the answer.

    // CPU threads, an error if the system gives fewer; 0 = all that it gives (at most 1024).
    unsigned threads = 0;
    // Blocks along an axis of the sorting grid; 0 = automatic (at most 1048576).
    unsigned grid_resolution = 0;
    // GPU: nearest neighbors tried first for each cell; 0 = automatic (at most 1024).
    unsigned k_init = 0;
    // GPU: cells in flight at once; 0 = automatic.
    unsigned chunk_size = 0;
    // Keep the cells for the next frame, or call of a Tessellator: cells that still hold there are not made again. Pays
    // on the CPU, where seeds move by at most a hundredth of their distance. Takes some 300 bytes a seed.
    bool follow = false;
    // CPU: baseline, avx2 or avx512; default: the best that the processor has. One that it lacks is an error.
    std::string instructions;

    ProgressCallback progress;
    LogCallback log;
};
// Returns walls around the convex hull of the points, for Options::walls, one for each facet. No point is outside, not
// even by rounding: a wall is farther out than its facet by some units in the last place of the largest coordinate. The
// walls do not depend on the order of the points, nor on weights. Uses these options: planar (points are 2N
// coordinates, and the walls are half-planes) and progress. Throws invalid_argument when all points lie in one plane,
// in two dimensions on one line, and for options that give another domain: box, cell, periodic, walls, outside.
[[nodiscard]] VOTESS_API std::vector<Wall> hull_walls(std::span<const double> points, const Options& options = {});
// Returns the arrays that a result holds: options.want, and those that it, min_face and min_area need. Throws
// invalid_argument or unsupported for options that are wrong for any seeds.
[[nodiscard]] VOTESS_API Want implied_want(const Options& options);

// Seconds of wall clock per stage. `open` finds and opens a device and makes its pipelines; 0 if no device was looked
// for. On the CPU, `knn` builds the search structure; `clip` finds the candidates too and decides uncertain signs
// exactly, so `fallback` is 0. On a GPU, a chunk of cells passes through knn, clip and download while the CPU finishes
// its share of the chunk before (`fallback`). The common time is divided in proportion to the time of each stage. Where
// a subgroup of the device makes a cell, it searches within `clip`.
struct StageSeconds {
    double open = 0, upload = 0, sort = 0, knn = 0, clip = 0, fallback = 0, download = 0;
    double total = 0;
};

// Numbers of cells that the CPU made again after a device, by reason.
struct FallbackReasons {
    std::uint64_t uncertain = 0;  // floating point could not decide a sign, or not measure well enough
    std::uint64_t overflow = 0;   // more planes or vertices at once than the device holds
    std::uint64_t exhausted = 0;  // the search ended before the security radius
    std::uint64_t skipped = 0;    // not given to the device, which had failed at nearly all cells before
    std::uint64_t domain = 0;     // the device does not clip this domain
};

struct Stats {
    std::string device;                // name of the device that ran
    std::uint64_t points = 0;          // N
    std::uint64_t faces = 0;           // sum of the cells' numbers of faces, walls included
    double mean_faces = 0;             // faces / number of cells that are not empty
    double volume_sum = 0;             // sum of all volumes; 0 when volumes were not requested
    double box_volume = 0;             // volume of the domain
    std::uint64_t moved_vertices = 0;  // of a mesh, see TriangleMesh::tolerance
    double moved_distance = 0;         // the largest of these moves
    std::uint64_t duplicates = 0;      // seeds with status `duplicate`
    std::uint64_t empty_cells = 0;     // seeds without a cell: duplicate, empty or outside
    std::uint64_t fallback_cells = 0;  // cells that the CPU made again after another device
    FallbackReasons fallback_reasons;  // add up to fallback_cells
    std::uint64_t exact_cells = 0;     // cells made where exact arithmetic decided a sign
    std::uint64_t kept_cells = 0;      // cells of the last call that still hold, see Options::follow
    // Number of faces between cells with an area below 1e-9 of the mean, rounded down to a power of two. Lattices with
    // rounded coordinates have such faces; Options::min_face drops them. Known where the CPU measured all cells (for
    // volumes, centroids, areas, surfaces or radii) and where there are polygons; else see count_tiny_faces().
    std::optional<std::uint64_t> tiny_faces;
    unsigned threads = 0;  // CPU threads used
    StageSeconds seconds;
    std::uint64_t peak_memory_bytes = 0;  // peak resident memory of the process so far
    // Of volumes, centroids and areas; double_ after a run on the CPU.
    Precision precision = Precision::double_;
};

namespace detail {
struct Result;
struct ResultOf;
struct TessellatorState;
}  // namespace detail

// The result: a shared handle to immutable arrays, cheap to copy, safe to read from many threads. The spans are valid
// as long as any copy of the handle. Arrays that were not requested are empty. N is the number of seeds; rows follow
// the input order. A handle that was moved from is an empty result.
class VOTESS_API Tessellation {
public:
    Tessellation();
    explicit Tessellation(std::shared_ptr<const detail::Result> result);

    [[nodiscard]] std::size_t size() const noexcept;  // N
    // Row i: ids of the neighbors of seed i, ascending; walls come first, being negative.
    [[nodiscard]] std::span<const std::int32_t> neighbors(std::size_t i) const noexcept;
    using Id = std::int32_t;
    // The arrays of votess/arrays.h, by name: volumes(), centroids(), indices(), indptr(), face_areas(), ... Vectors
    // are one after the other, as in x y z x y z. With Options::only cells share vertices across the faces that they
    // share, and each image of a vertex that some cell has is stored.
#define VOTESS_ROW_ARRAY(name, type, ...) [[nodiscard]] std::span<const type> name() const noexcept;
#define VOTESS_ROW_STARTS(name, type, ...) [[nodiscard]] std::span<const type> name() const noexcept;
#define VOTESS_OTHER_ARRAY(name, type, ...) [[nodiscard]] std::span<const type> name() const noexcept;
#include "votess/arrays.h"
    // The area below which faces were dropped, see Options::min_face and min_area; 0 when none were.
    [[nodiscard]] double least_face() const noexcept;
    [[nodiscard]] const Box& box() const noexcept;  // the domain that was used; the bounds of a triclinic one
    [[nodiscard]] const std::array<bool, 3>& periodic() const noexcept;
    [[nodiscard]] const std::optional<TriclinicBox>& cell() const noexcept;
    [[nodiscard]] std::span<const Wall> walls() const noexcept;
    [[nodiscard]] bool planar() const noexcept;       // whether the cells are polygons, see Options::planar
    [[nodiscard]] bool lists_walls() const noexcept;  // whether the rows hold wall ids
    [[nodiscard]] bool probed() const noexcept;       // whether Diagram::probe() made the cells
    [[nodiscard]] bool in_mesh() const noexcept;      // whether Options::mesh was set
    [[nodiscard]] bool is_subset() const noexcept;    // whether Options::only was set
    [[nodiscard]] const Stats& stats() const noexcept;

private:
    friend struct detail::ResultOf;
    std::shared_ptr<const detail::Result> result_;
};

// Keeps device, threads and buffers between calls, and reuses the arrays of a Tessellation once no handle is left.
// Calls of the same size then allocate nothing: keep one object for seeds that move from call to call. The destructor
// frees all memory that it keeps; results stay valid.
//
// One call at a time per object: a second one, from another thread or a callback, throws `invalid_use` and changes
// nothing. Different objects are independent.
//
// After fork() the child may use, move and destroy its copy. The CPU gets new threads. A GPU opened before is
// `unsupported` there; with "auto" the CPU replaces it. An object that was busy during the fork throws `invalid_use`.
class VOTESS_API Tessellator {
public:
    Tessellator();
    ~Tessellator();
    Tessellator(Tessellator&&) noexcept;
    Tessellator& operator=(Tessellator&&) noexcept;

    // Returns the cells of the points: 3N coordinates x0 y0 z0 x1 ..., or 2N x0 y0 x1 ... if options.planar. Any length
    // unit, finite, inside options.box. float32 is widened without loss. N = 0 gives an empty result; 2^31 points or
    // more are `unsupported`. The call copies points and weights first: if another thread writes to them meanwhile,
    // cells are wrong, but nothing else is. Throws Error: invalid_argument, out_of_memory, cancelled, unsupported,
    // internal, device_lost, invalid_use, no_threads. A Tessellator that was moved from may only be assigned or
    // destroyed, else `invalid_use`.
    [[nodiscard]] Tessellation tessellate(std::span<const double> points, const Options& options = {});
    [[nodiscard]] Tessellation tessellate(std::span<const float> points, const Options& options = {});

private:
    std::shared_ptr<detail::TessellatorState> state_;
};

// The same with a Tessellator that lives for one call.
[[nodiscard]] VOTESS_API Tessellation tessellate(std::span<const double> points, const Options& options = {});
[[nodiscard]] VOTESS_API Tessellation tessellate(std::span<const float> points, const Options& options = {});

// The dual of the cells: one simplex for each vertex of the mesh off the walls, in the order of the vertices. Four
// cells meet in a tetrahedron. Where more meet (seeds on an empty sphere) the dual is the convex polytope of their
// seeds, which has no unique triangulation. In the plane three cells meet in a triangle, more in a convex polygon: both
// are counterclockwise and take the place of tetrahedra and polytopes. They have three corners instead of four, shifts
// two components instead of three. Together they are the Delaunay complex of the seeds, or the regular complex
// of a power diagram. Simplices whose empty sphere has its center outside the domain are missing. In a periodic domain
// each simplex is stored once, not for each image.
struct Delaunay {
    std::vector<std::int32_t> tetrahedra;          // 4T seeds, the lowest first, det(b-a, c-a, d-a) > 0
    std::vector<std::int8_t> tetrahedra_shifts;    // 12T in a periodic domain, else empty: as Tessellation::shifts()
    std::vector<std::int32_t> tetrahedra_centers;  // T vertices: the centers of the empty spheres
    std::vector<std::int64_t> polytope_indptr;     // P+1 offsets into polytope_indices
    std::vector<std::int32_t> polytope_indices;    // the seeds of each polytope, ascending; in the plane in turn
    std::vector<std::int8_t> polytope_shifts;      // three for each of these, as above
    std::vector<std::int32_t> polytope_centers;    // P vertices
};
// Returns the dual. Throws invalid_argument without Want::faces and for cells of probes.
//
// After min_face or min_area, vertices that dropped faces joined count as one, named by the first. So a lattice with
// rounded coordinates has the polytopes of the lattice. A dropped face shrinks to an edge when it is long, else to a
// point. The ends of an edge too short for a face to be kept are joined too, and vertices where a cell has only two
// faces. Each polytope is a union of tetrahedra, so volumes sum up as before. In the plane each dropped edge shrinks to
// a point. Throws invalid_argument where no complex results: where a kept face would shrink, in the plane a whole cell,
// or a vertex would meet its own image.
[[nodiscard]] VOTESS_API Delaunay delaunay(const Tessellation& tessellation);

struct VerifyOptions {
    // Number of cells to clip again, instead of a proof of all cells. Unset: a proof where one is possible, see
    // verify(), else as many as take about a second, but at least 64 or all. The number depends on the input alone, not
    // on a clock.
    std::optional<std::size_t> sample;
    std::uint64_t rng_seed = 1;  // of the sample
};
struct VerifyReport {
    bool passed = false;
    std::string failure;               // one line on the first failed check; empty when passed
    std::vector<std::string> skipped;  // of "volumes", "symmetry", "euler", "sample"
    std::size_t sampled = 0;           // cells clipped again, up to the one that failed; a proof needs none
    // As in Stats, not a failure. Unset for rows found in blocks and of some seeds.
    std::optional<std::uint64_t> tiny_faces;
    bool proven = false;   // all neighbors, shifts, and which seeds have cells are proven; no sample was needed
    std::string unproven;  // one line on why not all cells are proven; empty when they are, and when a check failed
};
// Checks a result from outside, as --verify does:
//   - volumes sum to that of the domain (relative 1e-9; 1e-4 when stats().precision is single)
//   - rows ascend and are symmetric; Euler's formula V - E + F = 2 holds for each cell
//   - without a sample, all cells are proven on all threads: the bisectors that a row lists, and the walls, bound a
//     polytope. Corners and faces of these fit together, and their volumes sum to that of the domain; so they are the
//     diagram. Seeds without a cell are outside, duplicates, or excluded by a few others. Signs are exact, and numbers
//     that stand for corners miss a fault with a probability of 2^-64. All other arrays are those of the polytopes
//   - else a sample of cells equals cells clipped again by every seed, without a search structure
//   - with polygons each cell is watertight: every edge occurs twice, in opposite directions, and both cells of a face
//     have the same polygon
//   - with areas and normals of all faces each cell is closed: their sum is 0 to 1e-9 of the surface (1e-4 when single)
// In two dimensions and in a domain without end this holds for the cells of a thin sheet and of a box that ends far
// away, and rows, shifts, volumes, counts, areas and normals equal those.
// In a mesh this holds for the whole cells. Their parts equal those of a second run on the CPU, have the volumes of
// their pieces, and sum to the volume of the mesh. Wherever there is no such proof, all arrays equal those of a second
// run too, unless a sample is given. Skips checks whose arrays the result lacks, and names them in
// `skipped`.
// With Options::only all seeds clip the cells, rows are symmetric among those that are there, and the check "volumes"
// is skipped. Where there are so many cells that it takes longer than a run of all cells, without neighbors, and after
// min_face or min_area, such a run is made and checked, and each array equals its part of that. There is no proof in a
// mesh, nor of rows found in blocks in a domain without end; `unproven` says why. points: the array given to
// tessellate(). Throws invalid_argument when its length differs from that of the run, and for cells of probes.
[[nodiscard]] VOTESS_API VerifyReport verify(const Tessellation& tessellation, std::span<const double> points,
                                             const VerifyOptions& options = {});

// Returns Stats::tiny_faces. Where that is unknown, tessellates the points again on the CPU and measures. points and
// errors: as for verify().
[[nodiscard]] VOTESS_API std::uint64_t count_tiny_faces(const Tessellation& tessellation,
                                                        std::span<const double> points);

// Returns 3N coordinates of the seeds inside a periodic domain: the points, moved by whole box vectors, each coordinate
// rounded once. Tessellation::shifts() count from there. Dropped seeds are returned as given. points and errors: as for
// verify(). With Options::only: all points of the run, whose number is not checked.
[[nodiscard]] VOTESS_API std::vector<double> wrapped_points(const Tessellation& tessellation,
                                                            std::span<const double> points);

struct DeviceInfo {
    std::string id;           // for Options::device
    std::string name;         // for people
    std::string description;  // limits, features and the way to make cells, in one line
};
// Returns the devices of this machine, the CPU among them.
[[nodiscard]] VOTESS_API std::vector<DeviceInfo> devices();

}  // namespace votess
