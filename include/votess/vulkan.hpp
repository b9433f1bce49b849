// Voronoi cells inside a program that already runs Vulkan: votess records its passes into the program's own command
// buffer, on the program's own buffers. Nothing is copied, submitted or waited for behind its back.
//
//     using namespace votess::vulkan;
//     Requirements needs = requirements(host, physical_device);   // before vkCreateDevice: what to enable
//     ...
//     Plan plan({.instance = ..., .device = ..., ...}, {.most_seeds = 100000, .box = {{0, 0, 0}, {1, 1, 1}}});
//     // The program makes buffers: plan.sizes() says how large, buffer_usage with which usage.
//     Frame frame = plan.frame({.seeds = {positions}, .workspace = {scratch}, .header = ..., ...});
//     frame.record(commands, {.count = n});   // every frame; then the program submits, and draws from its buffers
//
// Contract of record(): no allocation (of Vulkan's or the heap), submission, wait or file access; the commands are for
// a queue family with compute, outside of a render pass. They change the bound compute pipeline, the compute descriptor
// set 0 and push constants, nothing of graphics.
//
// volk.h may stand before or behind this header. A program that uses the prototypes of vulkan.h includes that first.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#ifndef VULKAN_CORE_H_
#ifdef VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>
#else  // types only: prototypes would clash with a volk.h that follows
#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>
#undef VK_NO_PROTOTYPES
#endif
#endif

namespace votess::vulkan {

// ---- Before the device exists ----

struct HostInstance {
    VkInstance instance = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr get_instance_proc_addr = nullptr;  // of the loader that made the instance
    std::uint32_t api_version = VK_API_VERSION_1_1;              // VkApplicationInfo::apiVersion
};

// What to give to vkCreateDevice. A device that was made without `features` runs too, with some more cells unresolved.
struct Requirements {
    std::string missing;                  // why votess cannot use the physical device, in one line; empty: it can
    std::uint32_t queue_family = 0;       // one that will do: any with compute will
    VkPhysicalDeviceFeatures features{};  // votess uses these where they are enabled: shaderFloat64 at most
    std::vector<std::string> extensions;  // must be enabled
    // The device can be asked for a size of subgroups; for HostDevice::subgroup_size_control.
    bool subgroup_size_control = false;
};
// Throws Error invalid_argument for null handles, unsupported for an instance below Vulkan 1.1.
[[nodiscard]] VOTESS_API Requirements requirements(const HostInstance& host, VkPhysicalDevice physical_device);

// ---- The program's device ----

// Handles stay the program's, and must outlive every Plan and Frame made with them.
struct HostDevice {
    HostInstance host;
    VkPhysicalDevice physical_device = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    std::uint32_t queue_family = 0;       // of the queue that the commands will run on; with compute
    VkPhysicalDeviceFeatures features{};  // those that the device was made with
    // The device was made with subgroupSizeControl and computeFullSubgroups of
    // VkPhysicalDeviceSubgroupSizeControlFeatures; below Vulkan 1.3 with VK_EXT_subgroup_size_control for them.
    // Without, devices whose subgroups vary in size (Intel's) make each cell by one invocation.
    bool subgroup_size_control = false;
    VkPipelineCache pipeline_cache = VK_NULL_HANDLE;  // may be null
    // VK_EXT_debug_utils is enabled: stages get labels, objects names. Loaders (1.3.239) may crash in these calls while
    // another thread destroys a device.
    bool debug_utils = false;
    // A queue of that family, used while a Plan is made and never later: a small test is submitted, and waited for,
    // that shows how the device rounds. Nobody else may use the queue at that time. Null: no test, the bounds hold for
    // any rounding then, and float64 is not used.
    VkQueue probe_queue = VK_NULL_HANDLE;
};

// ---- The plan: all that does not change from frame to frame ----

enum class SeedFormat : std::uint32_t { float32 = 0, float64 = 1 };

// A power diagram, as of Options::weights: a weight for each seed, length unit squared, any sign, in Buffers::weights;
// of spheres, the square of the radius. The weights of all frames are promised to lie from `least` to `largest`; a seed
// with another one, or one that is not a number, gets status `outside` and no cell. These may differ by four times the
// square of the box's longest side; a seed that is lighter than another one by more than the box's squared diagonal,
// which is less, has no cell anyway. The nearer they are, the finer weights are told apart: what is finer than 2^-61 of
// their difference may leave cells unresolved.
struct WeightOptions {
    double least = 0, largest = 0;
    // Numbers of PlanOptions::format from one weight to the next, and before the first one. With `stride` 4 and `first`
    // 3 a weight is the w of a vec4 that holds its seed, when both are the same range of a buffer.
    std::uint32_t stride = 1, first = 0;
};

struct PlanOptions {
    std::uint32_t most_seeds = 0;  // of one frame
    Box box;                       // seeds outside of it, or not finite, get status `outside` and no cell
    // Axes along which the box repeats. Seeds up to a side beyond it are wrapped into it, without rounding. Images of
    // the seeds up to `margin` around the box are made on the device, in most_images places; cells that reach farther
    // stay unresolved, all cells where the places are too few (see Header::images).
    std::array<bool, 3> periodic{};
    // Instead of box and periodic: a triclinic box that repeats along all its edges. Seeds up to as much outside of its
    // bounds as they are long are wrapped into it, by vectors that are rounded to 2^-61 of the longest side at most;
    // cells for which that matters stay unresolved. All cells do where a seed is so near to a face that it may be on
    // either side of it.
    std::optional<TriclinicBox> cell{};
    std::optional<WeightOptions> weights{};
    // A convex polyhedron, as Options::walls: walls of any direction that cut the box, which may not be periodic or
    // change from frame to frame. Rows list them as -7, -8, ... in this order. Seeds beyond one get status `outside`;
    // all cells stay unresolved where one is so near to it, 2^-58 of the longest side, that it may be on either side.
    std::vector<Wall> walls{};
    // Length, at most 0.99 sides count; 0 = 3.4 mean distances between seeds, with weights up to twice as much.
    double margin = 0;
    std::uint32_t most_images = 0;  // 0 = a quarter more than uniform seeds have
    SeedFormat format = SeedFormat::float32;
    std::uint32_t stride = 3;        // numbers from one seed to the next, at least 3: 4 for a vec4
    bool neighbors = true;           // rows of neighbors
    bool geometry = true;            // volumes and centroids
    bool areas = false;              // of the faces in the rows, beside them
    bool list_walls = false;         // list the wall ids -1 .. -6, and of `walls`, in the rows too
    std::uint32_t most_entries = 0;  // of all rows together; 0 = 20 a seed. See Header::entries
    // Cells worked on at once: more workspace, more speed, longer dispatches. 0 = automatic: 2^20 on GPUs with memory
    // of their own, 2^17 on other GPUs.
    std::uint32_t chunk_size = 0;
    std::uint32_t k_init = 0;  // as Options::k_init
};

// A part of a buffer. The offset must be a multiple of minStorageBufferOffsetAlignment. One buffer may hold several.
struct BufferRange {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceSize offset = 0;
};

// Usage that each of the buffers needs; the program adds its own (vertex, indirect, ...).
inline constexpr VkBufferUsageFlags buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                                   VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                                   VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;

// Bytes of each buffer, for most_seeds seeds. All arrays are in the order of the seeds as given. 0: not wanted. With
// very many seeds one may be larger than the device allocates at once (maxMemoryAllocationSize, 4 GiB with some
// drivers): such a buffer needs sparse binding.
struct BufferSizes {
    VkDeviceSize seeds = 0;  // read: x y z, `stride` numbers of `format` apart; ends with the last z
    // Nothing to be found in it; device-local. At most 90 bytes a seed or place for an image, 18 more with weights, 56
    // a wall, and 900 a cell of the chunk (PlanOptions), so that with all arrays 1e8 seeds take some 22 GB.
    VkDeviceSize workspace = 0;
    VkDeviceSize header = 0;   // struct Header
    VkDeviceSize cells = 0;    // N struct Cell
    VkDeviceSize indices = 0;  // int32: the rows; that of seed i is indices[cells[i].row_begin ..+ row_length]
    // N x 4 float32: centroid relative to the seed, and volume; 0 for cells without. The relative error of a volume is
    // at most 1e-5. Choose a unit of length with which volumes are in the range of float32.
    VkDeviceSize geometry = 0;
    // float32: beside each entry of indices the area of that face, right to 1e-5 of the cell's surface or so.
    VkDeviceSize areas = 0;
    // Periodic: beside each entry of indices 4 int8, its shift (sx, sy, sz) and 0: as Tessellation::shifts(). Rows are
    // ordered by id, then shift.
    VkDeviceSize shifts = 0;
    VkDeviceSize weights = 0;  // read: WeightOptions::stride numbers apart; ends with the last weight
};

// How the frame came out, on the GPU; word for word as here.
struct Header {
    std::uint32_t seeds;       // of the frame
    std::uint32_t certified;   // cells that are proven exact
    std::uint32_t unresolved;  // cells for resolve(): certain only with exact arithmetic or more neighbors
    std::uint32_t duplicates;  // seeds equal to another one of lower index
    std::uint32_t outside;     // seeds outside of box or walls, or not finite; of a weight that is not as promised
    std::uint32_t entries;     // that the rows need. More than most_entries: the rows of the cells that did not fit are
                               // left out, with status `candidates_exhausted`
    std::uint32_t faces;       // of all certified cells, walls included
    std::uint32_t images;      // that periodic seeds have within the margin
    std::uint32_t empty;       // cells of power diagrams that are proven to have no interior
};

struct Cell {
    std::uint32_t status;      // CellStatus; not certified: row and geometry are empty
    std::uint32_t row_begin;   // first entry of the row in indices
    std::uint32_t row_length;  // ids ascend, walls first
    std::uint32_t faces;       // walls included
};

struct Buffers {
    BufferRange seeds{}, workspace{}, header{}, cells{}, indices{}, geometry{}, areas{}, shifts{}, weights{};
};

// Where to note times: `slots` consecutive queries of a timestamp pool from `first` on, which the program has reset.
//   0 begin, 1 after upload, 2 after sort, 3 after knn's hierarchy, 4 after all cells (knn, clip, download)
struct Timestamps {
    static constexpr std::uint32_t slots = 5;
    VkQueryPool pool = VK_NULL_HANDLE;
    std::uint32_t first = 0;
};

struct RecordOptions {
    std::uint32_t count = 0;             // seeds of this frame, at most most_seeds
    std::optional<Box> box{};            // of this frame; default: the plan's. Not where the plan has walls
    std::optional<TriclinicBox> cell{};  // of this frame, where the plan has one
    Timestamps timestamps{};             // none while pool is null
};

namespace detail {
struct PlanState;
struct FrameState;
}  // namespace detail

// Buffers and descriptor sets of one frame in flight. Copies share them; they must live until the commands are done.
// One thread at a time records a Frame or its copies.
class VOTESS_API Frame {
public:
    Frame();
    // Records all stages: upload, sort, knn, clip, download.
    //
    // Expected before: writes to seeds and weights are visible to compute shaders (stage COMPUTE_SHADER, access
    // SHADER_READ); no other use of the workspace and of what is written (header, cells, indices, geometry, areas,
    // shifts) is pending; they are written at COMPUTE_SHADER and TRANSFER stages. Promised after: the last commands are
    // a barrier that makes what was written visible to all later commands on the queue, at any stage, for any access;
    // not to the host, which needs its own barrier.
    //
    // Throws invalid_argument: an empty Frame, null commands, a count above most_seeds, an empty or inverted box, a box
    // where the plan has a cell or walls, a cell where it has none; unsupported: a periodic box as Plan() refuses, or
    // one too small for the plan's weights. Then nothing was recorded.
    void record(VkCommandBuffer commands, const RecordOptions& options) const;

private:
    friend class Plan;
    std::shared_ptr<detail::FrameState> state_;
};

struct ResolveOptions {
    std::optional<Box> box{};  // with which the frame was recorded; default: the plan's. As in RecordOptions
    std::optional<TriclinicBox> cell{};
    unsigned threads = 0;  // as Options::threads
};

// The cells that were left to the CPU, made exactly.
struct Resolved {
    std::vector<std::uint32_t> cells;   // R seeds, ascending: those with an unresolved status
    std::vector<CellStatus> status;     // R: certified; or no cell: duplicate, empty, outside of walls
    std::vector<std::int64_t> indptr;   // R+1
    std::vector<std::int32_t> indices;  // indptr[R]: rows, ids ascend, walls first
    std::vector<std::int8_t> shifts;    // 3 indptr[R] of a periodic plan, else empty
    std::vector<double> areas;          // indptr[R] of a plan with areas, else empty
    std::vector<double> volumes;        // R
    std::vector<double> centroids;      // 3R, absolute
};

// Immutable, safe to use from several threads. All pipelines are made here.
class VOTESS_API Plan {
public:
    // Throws Error: invalid_argument, also for a cell beside a box or periodic axes, areas without neighbors, walls in
    // a periodic box or that leave nothing of it; unsupported (limits of the device, a periodic box with bounds of very
    // different size such as 1e-30 and 1, a cell that leans or is thin so much that images lie more than three edges
    // away, or that does not repeat along all edges, weights that differ too much; the message says which);
    // out_of_memory, device_lost.
    Plan(const HostDevice& device, const PlanOptions& options);

    [[nodiscard]] const BufferSizes& sizes() const noexcept;
    [[nodiscard]] const PlanOptions& options() const noexcept;
    // Binds buffers: makes descriptor sets, and nothing else. Any number of frames may be in flight, each with its own
    // workspace and outputs. Throws invalid_argument for a null buffer that is needed or an offset that cannot be
    // bound.
    [[nodiscard]] Frame frame(const Buffers& buffers) const;
    // The cells whose status says that they are unresolved (needs_exact, plane_overflow, vertex_overflow,
    // candidates_exhausted), on the CPU, exactly: together with the certified rows the whole answer. Takes seeds, cells
    // and weights as read back by the program; x y z of consecutive seeds lie options().stride apart, weights as
    // WeightOptions says. Throws invalid_argument for too few numbers, weights that the plan has not or none where it
    // has some, and as tessellate() does for seeds that have a cell.
    [[nodiscard]] Resolved resolve(std::span<const float> seeds, std::span<const Cell> cells,
                                   const ResolveOptions& options = {}) const;
    [[nodiscard]] Resolved resolve(std::span<const double> seeds, std::span<const Cell> cells,
                                   const ResolveOptions& options = {}) const;
    [[nodiscard]] Resolved resolve(std::span<const float> seeds, std::span<const float> weights,
                                   std::span<const Cell> cells, const ResolveOptions& options = {}) const;
    [[nodiscard]] Resolved resolve(std::span<const double> seeds, std::span<const double> weights,
                                   std::span<const Cell> cells, const ResolveOptions& options = {}) const;

private:
    std::shared_ptr<const detail::PlanState> state_;
};

}  // namespace votess::vulkan
