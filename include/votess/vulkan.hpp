// Voronoi cells inside a program that already runs Vulkan. votess records its passes into the program's command buffer,
// on the program's buffers. It copies, submits and waits for nothing by itself.
//
//     using namespace votess::vulkan;
//     Requirements needs = requirements(host, physical_device);   // before vkCreateDevice: features to enable
//     ...
//     Plan plan({.instance = ..., .device = ..., ...}, {.max_seeds = 100000, .box = {{0, 0, 0}, {1, 1, 1}}});
//     // The program makes buffers of plan.sizes() bytes with buffer_usage.
//     Frame frame = plan.frame({.seeds = {positions}, .workspace = {scratch}, .header = ..., ...});
//     frame.record(commands, {.count = n});   // every frame; then the program submits, and draws from its buffers
//
// Contract of record(): it does not allocate (in Vulkan or on the heap), submit, wait or access files. The commands are
// for a queue family with compute, outside a render pass. They change the bound compute pipeline, compute descriptor
// set 0 and push constants, but no graphics state. Descriptor buffers (VK_EXT_descriptor_buffer) must be bound again.
//
// volk.h may be included before or after this header. A program that uses the prototypes of vulkan.h includes that
// first.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
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

// Arguments for vkCreateDevice. A device made without `features` works too, with some more cells unresolved.
struct Requirements {
    std::string missing;                  // one line: why votess cannot use the physical device; empty: it can
    std::uint32_t queue_family = 0;       // a suitable one; any with compute will do
    VkPhysicalDeviceFeatures features{};  // optional; shaderFloat64 at most
    std::vector<std::string> extensions;  // must be enabled
    // Whether the device can set the size of subgroups; for HostDevice::subgroup_size_control.
    bool subgroup_size_control = false;
};
// Returns the requirements of votess for a physical device. Throws Error: invalid_argument for null handles,
// unsupported for an instance below Vulkan 1.1.
[[nodiscard]] VOTESS_API Requirements requirements(const HostInstance& host, VkPhysicalDevice physical_device);

// ---- The program's device ----

// The program owns the handles. They must outlive every Plan and Frame made with them.
struct HostDevice {
    HostInstance host;
    VkPhysicalDevice physical_device = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    std::uint32_t queue_family = 0;       // family of the queue that runs the commands; with compute
    VkPhysicalDeviceFeatures features{};  // enabled on the device
    // Whether the device enables subgroupSizeControl and computeFullSubgroups of
    // VkPhysicalDeviceSubgroupSizeControlFeatures (below Vulkan 1.3 of VK_EXT_subgroup_size_control). Without them, one
    // invocation makes each cell on devices whose subgroups vary in size (Intel).
    bool subgroup_size_control = false;
    VkPipelineCache pipeline_cache = VK_NULL_HANDLE;  // may be null
    // Whether VK_EXT_debug_utils is enabled: stages then get labels, and objects names. Some loaders (1.3.239) crash in
    // these calls while another thread destroys a device.
    bool debug_utils = false;
    // A queue of that family, used only by the constructor of Plan. It submits a small test of the device's rounding
    // and waits for it; no one else may use the queue meanwhile. Null: no test; votess then assumes any rounding and
    // does not use float64.
    VkQueue probe_queue = VK_NULL_HANDLE;
};

// ---- The plan: everything that stays the same from frame to frame ----

enum class SeedFormat : std::uint32_t { float32 = 0, float64 = 1 };

// A power diagram, as by Options::weights: Buffers::weights holds a weight for each seed, length unit squared, any
// sign. For spheres it is the square of the radius.
struct WeightOptions {
    // Range of the weights of all frames. A seed whose weight is outside, or is not a number, gets status `outside` and
    // no cell. The range is at most four times the square of the box's longest side; a seed that is lighter than
    // another by the box's squared diagonal has no cell anyway. Weights that differ by less than 2^-61 of the range may
    // leave cells unresolved, so choose it narrow.
    double least = 0, largest = 0;
    // Numbers of PlanOptions::format from one weight to the next, and before the first one. Use `stride` 4 and `first`
    // 3 for a vec4 that holds a seed and its weight in w; seeds and weights are then the same range of a buffer.
    std::uint32_t stride = 1, first = 0;
};

struct PlanOptions {
    std::uint32_t max_seeds = 0;  // maximum of one frame
    Box box{};                    // seeds outside, or not finite, get status `outside` and no cell
    // Axes along which the box repeats. Seeds up to one side length outside are wrapped into it, without rounding. The
    // device makes images of the seeds up to `margin` around the box. Cells that reach farther stay unresolved; all
    // cells do when max_images is too small (see Header::images).
    std::array<bool, 3> periodic{};
    // A triclinic box that repeats along all its edges, instead of box and periodic. Seeds outside its bounds by up to
    // their length are wrapped into it, by vectors rounded to at most 2^-61 of the longest side. Cells for which the
    // rounding matters stay unresolved. All cells do when a seed is so near a face that its side is uncertain.
    std::optional<TriclinicBox> cell{};
    std::optional<WeightOptions> weights{};
    // Walls that cut the box, as Options::walls, with the ids -7, -8, ... in this order. The box may then neither be
    // periodic nor change from frame to frame. Seeds beyond a wall get status `outside`. All cells stay unresolved when
    // a seed is within 2^-58 of the longest side of a wall, so that its side is uncertain.
    std::vector<Wall> walls{};
    // Width of the layer of images, length unit, at most 0.99 sides. 0 = 3.4 mean distances between seeds, with weights
    // up to twice that.
    double margin = 0;
    std::uint32_t max_images = 0;  // maximum number of images; 0 = a quarter more than uniform seeds have
    SeedFormat format = SeedFormat::float32;
    std::uint32_t stride = 3;       // numbers from one seed to the next, at least 3: 4 for a vec4
    bool neighbors = true;          // rows of neighbors
    bool geometry = true;           // volumes and centroids
    bool areas = false;             // areas of the faces behind the entries of rows
    bool list_walls = false;        // list the ids of walls in the rows too
    std::uint32_t max_entries = 0;  // maximum of all rows together; 0 = 20 a seed. See Header::entries
    // Cells in flight: more workspace, more speed, longer dispatches. 0 = automatic: 2^20 on GPUs with memory of their
    // own, 2^17 on other GPUs.
    std::uint32_t chunk_size = 0;
    std::uint32_t k_init = 0;  // as Options::k_init
    // Keep the cells for the next frame: cells that still hold there are not made again. It changes speed, never the
    // answer; see Header::kept. Pays where seeds move by at most a hundredth of their distance. Needs Buffers::kept,
    // and all cells are in flight at once: chunk_size must be 0.
    bool follow = false;
};

// A part of a buffer. The offset must be a multiple of minStorageBufferOffsetAlignment. One buffer may hold several.
struct BufferRange {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceSize offset = 0;
};

// Usage that each buffer needs; the program adds its own (vertex, indirect, ...).
inline constexpr VkBufferUsageFlags buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                                   VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                                                   VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;

// Bytes of each buffer for max_seeds seeds, N. All arrays follow the input order of the seeds. 0: not requested. A
// buffer for very many seeds may exceed maxMemoryAllocationSize (4 GiB with some drivers); it then needs sparse
// binding.
struct BufferSizes {
    VkDeviceSize seeds = 0;  // input: x y z, `stride` numbers of `format` apart; ends with the last z
    // Scratch; contents are undefined. Use device-local memory. At most 90 bytes for each seed and image, 18 more with
    // weights, 56 for each wall, 900 for each cell of the chunk, 390 more with `follow`, where all cells are in one
    // chunk. All buffers of 1e8 seeds need about 22 GB.
    VkDeviceSize workspace = 0;
    VkDeviceSize header = 0;   // struct Header
    VkDeviceSize cells = 0;    // N struct Cell
    VkDeviceSize indices = 0;  // int32: the rows; that of seed i is indices[cells[i].row_begin ..+ row_length]
    // N x 4 float32: centroid relative to the seed, and volume, with a relative error of at most 1e-5; 0 without a
    // cell. Choose a unit of length that keeps volumes in the range of float32.
    VkDeviceSize geometry = 0;
    // float32: for each entry of indices the area of its face, with an error of about 1e-5 of the cell's surface.
    VkDeviceSize areas = 0;
    // Periodic plans: 4 int8 for each entry of indices, its shift (sx, sy, sz) as Tessellation::shifts() and 0. Rows
    // are ordered by id, then shift.
    VkDeviceSize shifts = 0;
    VkDeviceSize weights = 0;  // input: WeightOptions::stride numbers apart; ends with the last weight
    // In a plan with `follow`: the cells of the last frame, 260 bytes a seed and 128 more in a periodic plan. Only
    // frames may write it; frames of one plan may share it, one after the other.
    VkDeviceSize kept = 0;
};

// Outcome of a frame, written by the GPU in this layout.
struct Header {
    std::uint32_t seeds;       // of the frame; the number in RecordOptions::count_buffer where there is one
    std::uint32_t certified;   // cells that are proven exact
    std::uint32_t unresolved;  // cells for resolve(), which need exact arithmetic or more neighbors
    std::uint32_t duplicates;  // seeds equal to another one of lower index
    std::uint32_t outside;     // seeds outside box or walls, not finite, or with a weight outside its range
    std::uint32_t entries;     // entries that the rows need. Above max_entries, rows that do not fit are dropped, and
                               // their cells get status `candidates_exhausted`
    std::uint32_t faces;       // of all certified cells, walls included
    std::uint32_t images;      // images of periodic seeds within the margin
    std::uint32_t empty;       // cells of power diagrams that are proven to have no interior
    std::uint32_t kept;        // cells of the last frame that still hold, see PlanOptions::follow; they are certified
};

struct Cell {
    std::uint32_t status;      // CellStatus; unless certified, row and geometry are empty
    std::uint32_t row_begin;   // first entry of the row in indices
    std::uint32_t row_length;  // ids ascend, walls first
    std::uint32_t faces;       // walls included
};

struct Buffers {
    BufferRange seeds{}, workspace{}, header{}, cells{}, indices{}, geometry{}, areas{}, shifts{}, weights{}, kept{};
};

// Queries for the times of stages: `slots` consecutive ones of a timestamp pool from `first` on, reset by the program.
//   0 begin, 1 after upload, 2 after sort, 3 after the hierarchy of knn, 4 after all cells (knn, clip, download)
struct Timestamps {
    static constexpr std::uint32_t slots = 5;
    VkQueryPool pool = VK_NULL_HANDLE;
    std::uint32_t first = 0;
};

struct RecordOptions {
    std::uint32_t count = 0;  // seeds of this frame, at most max_seeds
    // For a number of seeds that only the GPU knows: a buffer with TRANSFER_SRC usage that holds it as uint32, at a
    // multiple of 4. All stages then run for `count` seeds, and a larger number means `count`. Seeds and weights beyond
    // the number are not read. Their cells get status `outside`, but Header::outside does not count them. Before:
    // writes to the number must be visible to copies (stage TRANSFER, access TRANSFER_READ).
    BufferRange count_buffer{};
    std::optional<Box> box{};            // of this frame; default: that of the plan. Not with walls
    std::optional<TriclinicBox> cell{};  // of this frame, if the plan has one
    Timestamps timestamps{};             // none when pool is null
    // In a plan with `follow`: make all cells. Required for the first frame with a new buffer `kept`. Also required
    // when something else wrote to it, or the commands of the frame before did not run to the end.
    bool fresh = false;
};

namespace detail {
struct PlanState;
struct FrameState;
struct PlanAccess;
}  // namespace detail

// Buffers and descriptor sets of one frame in flight, shared by copies. Keep one until the commands have run. One
// thread at a time may record a Frame or its copies.
class VOTESS_API Frame {
public:
    Frame();
    // Records all stages: upload, sort, knn, clip, download.
    //
    // Before: writes to seeds and weights must be visible to compute shaders (stage COMPUTE_SHADER, access
    // SHADER_READ). No other use of workspace, header, cells, indices, geometry, areas, shifts and kept may be pending;
    // the stages COMPUTE_SHADER and TRANSFER write them.
    // After: the last command is a barrier. It makes these buffers visible to all later commands on the queue, at any
    // stage, for any access. The host needs its own barrier.
    //
    // Throws Error and then records nothing. invalid_argument: an empty Frame, null commands, a count above max_seeds,
    // an empty or inverted box, a box where the plan has a cell or walls, a cell where it has none. unsupported: a
    // periodic box that Plan() would refuse, or a box too small for the plan's weights.
    void record(VkCommandBuffer commands, const RecordOptions& options) const;

private:
    friend class Plan;
    friend struct detail::PlanAccess;
    std::shared_ptr<detail::FrameState> state_;
};

struct ResolveOptions {
    std::optional<Box> box{};  // the same box and cell as in RecordOptions
    std::optional<TriclinicBox> cell{};
    unsigned threads = 0;  // as Options::threads
};

// The cells that the GPU did not resolve, made exactly on the CPU.
struct Resolved {
    std::vector<std::uint32_t> cells;   // R seeds, ascending: those with an unresolved status
    std::vector<CellStatus> status;     // R: certified; or without a cell: duplicate, empty, outside
    std::vector<std::int64_t> indptr;   // R+1
    std::vector<std::int32_t> indices;  // indptr[R]: rows, ids ascend, walls first
    std::vector<std::int8_t> shifts;    // 3 indptr[R] in a periodic plan, else empty
    std::vector<double> areas;          // indptr[R] in a plan with areas, else empty
    std::vector<double> volumes;        // R
    std::vector<double> centroids;      // 3R, absolute; of the cells around the seeds as given, not as wrapped
};

// Immutable, safe to use from several threads. The constructor makes all pipelines.
class VOTESS_API Plan {
public:
    // Throws Error; the message gives the reason.
    //   - invalid_argument: also a cell with a box or periodic axes, areas without neighbors, walls in a periodic box,
    //     walls that leave nothing of the box, a chunk_size with follow
    //   - unsupported: limits of the device; a periodic box with bounds of very different size, such as 1e-30 and 1; a
    //     cell so skewed or thin that images lie more than three edges away; a cell that does not repeat along all
    //     edges; weights that differ too much
    //   - out_of_memory, device_lost
    Plan(const HostDevice& device, const PlanOptions& options);
    // Returns a plan with other options on the same device, which shares pipelines with this one: those that both need.
    // So it is made in milliseconds where options differ only in sizes, box, walls or formats. Throws as Plan().
    [[nodiscard]] Plan with(const PlanOptions& options) const;

    [[nodiscard]] const BufferSizes& sizes() const noexcept;
    [[nodiscard]] const PlanOptions& options() const noexcept;
    // Returns one line that names the kernel, its lanes and the numbers that measure: "subgroups of 32 make cells,
    // measured in float64".
    [[nodiscard]] std::string kernel() const;
    // Returns a Frame on these buffers; makes only descriptor sets. Any number of frames may be in flight, each with
    // its own workspace and outputs. Throws invalid_argument for a missing buffer or an offset that cannot be bound.
    [[nodiscard]] Frame frame(const Buffers& buffers) const;
    // Returns the cells with an unresolved status (needs_exact, plane_overflow, vertex_overflow, candidates_exhausted),
    // made exactly on the CPU. They complete the certified rows. seeds, cells, weights: as read back from the buffers;
    // seeds are options().stride apart, weights as in WeightOptions. Throws invalid_argument for too few numbers,
    // weights without a power diagram and the reverse; as tessellate() for seeds that have a cell.
    [[nodiscard]] Resolved resolve(std::span<const float> seeds, std::span<const Cell> cells,
                                   const ResolveOptions& options = {}) const;
    [[nodiscard]] Resolved resolve(std::span<const double> seeds, std::span<const Cell> cells,
                                   const ResolveOptions& options = {}) const;
    [[nodiscard]] Resolved resolve(std::span<const float> seeds, std::span<const float> weights,
                                   std::span<const Cell> cells, const ResolveOptions& options = {}) const;
    [[nodiscard]] Resolved resolve(std::span<const double> seeds, std::span<const double> weights,
                                   std::span<const Cell> cells, const ResolveOptions& options = {}) const;

private:
    friend struct detail::PlanAccess;
    explicit Plan(std::shared_ptr<const detail::PlanState> state) : state_(std::move(state)) {}
    std::shared_ptr<const detail::PlanState> state_;
};

}  // namespace votess::vulkan
