// The C interface: votess.h over votess.hpp. The only catch-all wall of votess; no exception passes it.
#include <votess/votess.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include <votess/votess.hpp>

struct votess_tessellator {
    votess::Tessellator tessellator;
};

struct votess_result {
    votess::Tessellation tessellation;
};

struct votess_delaunay {
    votess::Delaunay delaunay;
};

namespace {

template <typename Enum>
constexpr bool same(int c_value, Enum value) {
    return c_value == static_cast<int>(value);
}

static_assert(same(VOTESS_ERROR_INVALID_ARGUMENT, votess::ErrorCode::invalid_argument));
static_assert(same(VOTESS_ERROR_OUT_OF_MEMORY, votess::ErrorCode::out_of_memory));
static_assert(same(VOTESS_ERROR_CANCELLED, votess::ErrorCode::cancelled));
static_assert(same(VOTESS_ERROR_UNSUPPORTED, votess::ErrorCode::unsupported));
static_assert(same(VOTESS_ERROR_INTERNAL, votess::ErrorCode::internal));
static_assert(same(VOTESS_ERROR_DEVICE_LOST, votess::ErrorCode::device_lost));
static_assert(same(VOTESS_ERROR_INVALID_USE, votess::ErrorCode::invalid_use));
static_assert(same(VOTESS_CELL_CERTIFIED, votess::CellStatus::certified));
static_assert(same(VOTESS_CELL_NEEDS_EXACT, votess::CellStatus::needs_exact));
static_assert(same(VOTESS_CELL_PLANE_OVERFLOW, votess::CellStatus::plane_overflow));
static_assert(same(VOTESS_CELL_VERTEX_OVERFLOW, votess::CellStatus::vertex_overflow));
static_assert(same(VOTESS_CELL_CANDIDATES_EXHAUSTED, votess::CellStatus::candidates_exhausted));
static_assert(same(VOTESS_CELL_DUPLICATE, votess::CellStatus::duplicate));
static_assert(same(VOTESS_CELL_EMPTY, votess::CellStatus::empty));
static_assert(same(VOTESS_CELL_OUTSIDE, votess::CellStatus::outside));
static_assert(same(VOTESS_DUPLICATES_MERGE, votess::Duplicates::merge));
static_assert(same(VOTESS_DUPLICATES_ERROR, votess::Duplicates::error));
static_assert(same(VOTESS_OUTSIDE_ERROR, votess::Outside::error));
static_assert(same(VOTESS_OUTSIDE_DROP, votess::Outside::drop));
static_assert(same(VOTESS_KERNEL_AUTOMATIC, votess::Kernel::automatic));
static_assert(same(VOTESS_KERNEL_INVOCATION, votess::Kernel::invocation));
static_assert(same(VOTESS_KERNEL_SUBGROUP, votess::Kernel::subgroup));
static_assert(same(VOTESS_PRECISION_SINGLE, votess::Precision::single));
static_assert(same(VOTESS_PRECISION_DOUBLE, votess::Precision::double_));
// The status bytes are handed out as they lie in memory.
static_assert(sizeof(votess::CellStatus) == sizeof(std::uint8_t));

struct WantBit {
    std::uint32_t bit;
    bool votess::Want::*member;
};
constexpr WantBit want_bits[] = {
    {VOTESS_WANT_NEIGHBORS, &votess::Want::neighbors}, {VOTESS_WANT_VOLUMES, &votess::Want::volumes},
    {VOTESS_WANT_CENTROIDS, &votess::Want::centroids}, {VOTESS_WANT_COUNTS, &votess::Want::counts},
    {VOTESS_WANT_AREAS, &votess::Want::areas},         {VOTESS_WANT_NORMALS, &votess::Want::normals},
    {VOTESS_WANT_SURFACES, &votess::Want::surfaces},   {VOTESS_WANT_RADII, &votess::Want::radii},
    {VOTESS_WANT_VERTICES, &votess::Want::vertices},   {VOTESS_WANT_FACES, &votess::Want::faces},
};

// Up to the last field of the first release. These never change; fields added later lie beyond.
constexpr std::size_t first_options_size = offsetof(votess_options, log_user) + sizeof(votess_options::log_user);
constexpr std::size_t first_stats_size = offsetof(votess_stats, device) + sizeof(votess_stats::device);

// No padding at the end: whatever is added later makes the struct larger, which tells callers with and without it
// apart.
static_assert(sizeof(votess_options) <= VOTESS_LARGEST_STRUCT && sizeof(votess_stats) <= VOTESS_LARGEST_STRUCT);
static_assert(sizeof(votess_options) == offsetof(votess_options, reserved3) + sizeof(votess_options::reserved3));
static_assert(sizeof(votess_stats) == offsetof(votess_stats, reserved) + sizeof(votess_stats::reserved));

// The last failure of each thread. The one variable that outlives a call: thread-local, so that no thread sees or
// changes another's, and of fixed size, so that telling of exhausted memory takes none.
thread_local char last_error[1024] = "";

// Copies what fits, never half a UTF-8 character.
void copy_text(std::string_view text, char* out, std::size_t out_size) noexcept {
    if (out_size == 0) return;
    std::size_t length = text.size();
    if (length >= out_size) {
        length = out_size - 1;
        while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0u) == 0x80u) --length;
    }
    std::copy_n(text.data(), length, out);
    out[length] = '\0';
}

void set_last_error(std::string_view message) noexcept {
    copy_text(message, last_error, sizeof last_error);
}

[[noreturn]] void refuse(const std::string& message) {
    throw votess::Error(votess::ErrorCode::invalid_argument, message);
}

template <typename Function>
votess_status guarded(Function&& function) noexcept {
    try {
        function();
        return VOTESS_OK;
    } catch (const votess::Error& error) {
        set_last_error(error.what());
        return static_cast<votess_status>(error.code());
    } catch (const std::bad_alloc&) {
        set_last_error("out of memory");
        return VOTESS_ERROR_OUT_OF_MEMORY;
    } catch (const std::exception& error) {
        std::snprintf(last_error, sizeof last_error, "internal error, please report it: %s", error.what());
        return VOTESS_ERROR_INTERNAL;
    } catch (...) {
        set_last_error("internal error, please report it: an exception of unknown type");
        return VOTESS_ERROR_INTERNAL;
    }
}

void require(const void* pointer, const char* name) {
    if (pointer == nullptr) refuse(std::string(name) + " is NULL");
}

void require_text_buffer(const char* buffer, std::size_t size, const char* name) {
    if (buffer == nullptr && size != 0) {
        refuse(std::string(name) + " is NULL but its size is " + std::to_string(size) + ": give 0");
    }
}

void require_struct_size(std::size_t size, std::size_t smallest, const char* name, const char* remedy) {
    if (size >= smallest && size <= VOTESS_LARGEST_STRUCT) return;
    const bool small = size < smallest;
    refuse(std::string(name) + " is " + std::to_string(size) + ", but the " + (small ? "smallest" : "largest") +
           " known is " + std::to_string(small ? smallest : VOTESS_LARGEST_STRUCT) + ": " + remedy);
}

votess_options default_options() {
    const votess::Options defaults;
    votess_options options{};
    options.struct_size = sizeof(votess_options);
    for (const WantBit& word : want_bits)
        if (defaults.want.*word.member) options.want |= word.bit;
    options.walls = defaults.walls ? 1 : 0;
    options.duplicates = static_cast<std::int32_t>(defaults.duplicates);
    options.threads = defaults.threads;
    options.grid_resolution = defaults.grid_resolution;
    options.precision = static_cast<std::int32_t>(defaults.precision);
    options.k_init = defaults.k_init;
    options.chunk_size = defaults.chunk_size;
    options.kernel = static_cast<std::int32_t>(defaults.kernel);
    return options;
}

// count: of the points, and so of weights and radii.
void convert_domain(const votess_options& given, std::size_t count, votess::Options& options) {
    if (given.has_box != 0) {
        votess::Box box;
        std::copy_n(given.box_lower, 3, box.lower.begin());
        std::copy_n(given.box_upper, 3, box.upper.begin());
        options.box = box;
    }
    for (std::size_t k = 0; k < 3; ++k) options.periodic[k] = given.periodic[k] != 0;
    if (given.has_cell != 0) {
        votess::TriclinicBox& cell = options.cell.emplace();
        std::copy_n(given.cell_origin, 3, cell.origin.begin());
        std::copy_n(given.cell_a, 3, cell.a.begin());
        std::copy_n(given.cell_b, 3, cell.b.begin());
        std::copy_n(given.cell_c, 3, cell.c.begin());
    }
    if (given.planes == nullptr && given.plane_count != 0) {
        refuse("options.planes is NULL but plane_count is " + std::to_string(given.plane_count));
    }
    for (std::uint64_t w = 0; w < given.plane_count; ++w) {
        const double* plane = given.planes + 4 * w;
        options.planes.push_back({{plane[0], plane[1], plane[2]}, plane[3]});
    }
    if (given.weights != nullptr) options.weights = {given.weights, count};
    if (given.radii != nullptr) options.radii = {given.radii, count};
    if (given.outside != VOTESS_OUTSIDE_ERROR && given.outside != VOTESS_OUTSIDE_DROP) {
        refuse("options.outside is " + std::to_string(given.outside) +
               ": use VOTESS_OUTSIDE_ERROR or VOTESS_OUTSIDE_DROP");
    }
    options.outside = static_cast<votess::Outside>(given.outside);
}

votess::Options convert_options(const votess_options* given, std::size_t count) {
    if (given == nullptr) return {};
    require_struct_size(given->struct_size, first_options_size, "options.struct_size",
                        "call votess_options_init first");
    votess_options c_options = default_options();
    std::memcpy(&c_options, given, std::min<std::size_t>(given->struct_size, sizeof c_options));

    std::uint32_t unknown = c_options.want;
    for (const WantBit& word : want_bits) unknown &= ~word.bit;
    if (unknown != 0) {
        refuse("options.want is " + std::to_string(c_options.want) + ": its bits " + std::to_string(unknown) +
               " are unknown; combine VOTESS_WANT_* bits");
    }
    if (c_options.duplicates != VOTESS_DUPLICATES_MERGE && c_options.duplicates != VOTESS_DUPLICATES_ERROR) {
        refuse("options.duplicates is " + std::to_string(c_options.duplicates) +
               ": use VOTESS_DUPLICATES_MERGE or VOTESS_DUPLICATES_ERROR");
    }
    if (c_options.precision != VOTESS_PRECISION_SINGLE && c_options.precision != VOTESS_PRECISION_DOUBLE) {
        refuse("options.precision is " + std::to_string(c_options.precision) +
               ": use VOTESS_PRECISION_SINGLE or VOTESS_PRECISION_DOUBLE");
    }
    if (c_options.reserved != 0) {
        refuse("options.reserved is " + std::to_string(c_options.reserved) + ": it must be 0");
    }
    if (c_options.kernel < VOTESS_KERNEL_AUTOMATIC || c_options.kernel > VOTESS_KERNEL_SUBGROUP) {
        refuse("options.kernel is " + std::to_string(c_options.kernel) +
               ": use VOTESS_KERNEL_AUTOMATIC, VOTESS_KERNEL_INVOCATION or VOTESS_KERNEL_SUBGROUP");
    }

    if (c_options.reserved3 != 0) {
        refuse("options.reserved3 is " + std::to_string(c_options.reserved3) + ": it must be 0");
    }

    votess::Options options;
    convert_domain(c_options, count, options);
    options.walls = c_options.walls != 0;
    for (const WantBit& word : want_bits) options.want.*word.member = (c_options.want & word.bit) != 0;
    options.min_face = c_options.min_face;
    options.duplicates = static_cast<votess::Duplicates>(c_options.duplicates);
    if (c_options.device != nullptr) options.device = c_options.device;
    options.threads = c_options.threads;
    options.grid_resolution = c_options.grid_resolution;
    options.precision = static_cast<votess::Precision>(c_options.precision);
    options.k_init = c_options.k_init;
    options.chunk_size = c_options.chunk_size;
    options.kernel = static_cast<votess::Kernel>(c_options.kernel);
    if (c_options.instructions != nullptr) options.instructions = c_options.instructions;
    if (c_options.progress != nullptr) {
        options.progress = [callback = c_options.progress, user = c_options.progress_user](double fraction) {
            return callback(fraction, user) != 0;
        };
    }
    if (c_options.log != nullptr) {
        options.log = [callback = c_options.log, user = c_options.log_user](std::string_view message) {
            callback(std::string(message).c_str(), user);
        };
    }
    return options;
}

template <typename Coordinate>
std::span<const Coordinate> coordinates(const Coordinate* points, std::size_t count) {
    if (points == nullptr && count != 0) refuse("points is NULL but count is " + std::to_string(count));
    if (count > std::numeric_limits<std::size_t>::max() / (3 * sizeof(Coordinate))) {
        refuse("count is " + std::to_string(count) + ": so many points do not fit into memory");
    }
    return {points, 3 * count};
}

template <typename Coordinate>
votess_status tessellate(votess_tessellator* tessellator, const Coordinate* points, std::size_t count,
                         const votess_options* options, votess_result** out) noexcept {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        const std::span<const Coordinate> input = coordinates(points, count);
        const votess::Options converted = convert_options(options, count);
        *out = new votess_result{tessellator == nullptr ? votess::tessellate(input, converted)
                                                        : tessellator->tessellator.tessellate(input, converted)};
    });
}

template <typename Element>
const Element* expose(const votess_result* result, std::size_t* length,
                      std::span<const Element> (votess::Tessellation::*array)() const noexcept) noexcept {
    std::span<const Element> elements;
    if (result != nullptr) {
        elements = (result->tessellation.*array)();
    } else {
        set_last_error("result is NULL");
    }
    if (length != nullptr) *length = elements.size();
    return elements.empty() ? nullptr : elements.data();
}

template <typename Element>
const Element* expose(const votess_delaunay* delaunay, std::size_t* length,
                      std::vector<Element> votess::Delaunay::*array) noexcept {
    std::span<const Element> elements;
    if (delaunay != nullptr) {
        elements = delaunay->delaunay.*array;
    } else {
        set_last_error("delaunay is NULL");
    }
    if (length != nullptr) *length = elements.size();
    return elements.empty() ? nullptr : elements.data();
}

std::uint32_t check_bit(std::string_view name) {
    if (name == "volumes") return VOTESS_CHECK_VOLUMES;
    if (name == "symmetry") return VOTESS_CHECK_SYMMETRY;
    if (name == "euler") return VOTESS_CHECK_EULER;
    if (name == "sample") return VOTESS_CHECK_SAMPLE;
    throw votess::Error(votess::ErrorCode::internal, "verify skipped an unknown check: " + std::string(name));
}

}  // namespace

uint32_t votess_version(void) {
    return VOTESS_VERSION_MAJOR * 1000000u + VOTESS_VERSION_MINOR * 1000u + VOTESS_VERSION_PATCH;
}

const char* votess_version_string(void) {
    return VOTESS_VERSION_STRING;
}

size_t votess_sizeof_options(void) {
    return sizeof(votess_options);
}

size_t votess_sizeof_stats(void) {
    return sizeof(votess_stats);
}

const char* votess_last_error(void) {
    return last_error;
}

votess_status votess_options_init(votess_options* options, size_t size) {
    return guarded([&] {
        require(options, "options");
        require_struct_size(size, first_options_size, "size", "give sizeof(votess_options)");
        votess_options defaults = default_options();
        defaults.struct_size = static_cast<std::uint32_t>(std::min(size, sizeof defaults));
        std::memcpy(options, &defaults, defaults.struct_size);
    });
}

votess_status votess_tessellator_new(votess_tessellator** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        *out = new votess_tessellator{};
    });
}

void votess_tessellator_free(votess_tessellator* tessellator) {
    delete tessellator;
}

votess_status votess_tessellate(votess_tessellator* tessellator, const double* points, size_t count,
                                const votess_options* options, votess_result** out) {
    return tessellate(tessellator, points, count, options, out);
}

votess_status votess_tessellate_f32(votess_tessellator* tessellator, const float* points, size_t count,
                                    const votess_options* options, votess_result** out) {
    return tessellate(tessellator, points, count, options, out);
}

void votess_result_free(votess_result* result) {
    delete result;
}

size_t votess_result_size(const votess_result* result) {
    if (result != nullptr) return result->tessellation.size();
    set_last_error("result is NULL");
    return 0;
}

const int64_t* votess_result_indptr(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::indptr);
}

const int32_t* votess_result_indices(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::indices);
}

const double* votess_result_face_areas(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::face_areas);
}

const double* votess_result_face_normals(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::face_normals);
}

const int8_t* votess_result_shifts(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::shifts);
}

const double* votess_result_volumes(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::volumes);
}

const double* votess_result_centroids(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::centroids);
}

const uint32_t* votess_result_face_counts(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::face_counts);
}

const uint32_t* votess_result_edge_counts(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::edge_counts);
}

const uint32_t* votess_result_vertex_counts(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::vertex_counts);
}

const double* votess_result_surface_areas(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::surface_areas);
}

const double* votess_result_security_radii(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::security_radii);
}

const double* votess_result_vertices(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::vertices);
}

const int64_t* votess_result_face_offsets(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::face_offsets);
}

const int32_t* votess_result_face_vertices(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::face_vertices);
}

const int64_t* votess_result_cell_vertex_indptr(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::cell_vertex_indptr);
}

const int32_t* votess_result_cell_vertex_indices(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::cell_vertex_indices);
}

const uint8_t* votess_result_status(const votess_result* result, size_t* length) {
    return reinterpret_cast<const std::uint8_t*>(expose(result, length, &votess::Tessellation::status));
}

const int32_t* votess_result_duplicate_of(const votess_result* result, size_t* length) {
    return expose(result, length, &votess::Tessellation::duplicate_of);
}

int votess_result_lists_walls(const votess_result* result) {
    if (result != nullptr) return result->tessellation.lists_walls() ? 1 : 0;
    set_last_error("result is NULL");
    return 0;
}

double votess_result_least_face(const votess_result* result) {
    if (result != nullptr) return result->tessellation.least_face();
    set_last_error("result is NULL");
    return 0;
}

votess_status votess_result_box(const votess_result* result, double lower[3], double upper[3]) {
    return guarded([&] {
        require(result, "result");
        require(lower, "lower");
        require(upper, "upper");
        const votess::Box& box = result->tessellation.box();
        std::copy(box.lower.begin(), box.lower.end(), lower);
        std::copy(box.upper.begin(), box.upper.end(), upper);
    });
}

votess_status votess_result_stats(const votess_result* result, votess_stats* out) {
    return guarded([&] {
        require(result, "result");
        require(out, "stats");
        const std::uint32_t size = out->struct_size;
        require_struct_size(size, first_stats_size, "stats.struct_size", "set it to sizeof(votess_stats)");

        const votess::Stats& stats = result->tessellation.stats();
        votess_stats c_stats{};
        c_stats.struct_size = size;
        c_stats.threads = stats.threads;
        c_stats.points = stats.points;
        c_stats.faces = stats.faces;
        c_stats.duplicates = stats.duplicates;
        c_stats.empty_cells = stats.empty_cells;
        c_stats.fallback_cells = stats.fallback_cells;
        c_stats.exact_cells = stats.exact_cells;
        c_stats.peak_memory_bytes = stats.peak_memory_bytes;
        c_stats.mean_faces = stats.mean_faces;
        c_stats.volume_sum = stats.volume_sum;
        c_stats.box_volume = stats.box_volume;
        c_stats.seconds_upload = stats.seconds.upload;
        c_stats.seconds_sort = stats.seconds.sort;
        c_stats.seconds_knn = stats.seconds.knn;
        c_stats.seconds_clip = stats.seconds.clip;
        c_stats.seconds_fallback = stats.seconds.fallback;
        c_stats.seconds_download = stats.seconds.download;
        c_stats.seconds_total = stats.seconds.total;
        copy_text(stats.device, c_stats.device, sizeof c_stats.device);
        c_stats.precision = static_cast<std::int32_t>(stats.precision);
        std::memcpy(out, &c_stats, std::min<std::size_t>(size, sizeof c_stats));
    });
}

votess_status votess_delaunay_new(const votess_result* result, votess_delaunay** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(result, "result");
        *out = new votess_delaunay{votess::delaunay(result->tessellation)};
    });
}

void votess_delaunay_free(votess_delaunay* delaunay) {
    delete delaunay;
}

const int32_t* votess_delaunay_tetrahedra(const votess_delaunay* delaunay, size_t* length) {
    return expose(delaunay, length, &votess::Delaunay::tetrahedra);
}

const int8_t* votess_delaunay_tetrahedra_shifts(const votess_delaunay* delaunay, size_t* length) {
    return expose(delaunay, length, &votess::Delaunay::tetrahedra_shifts);
}

const int32_t* votess_delaunay_tetrahedra_centers(const votess_delaunay* delaunay, size_t* length) {
    return expose(delaunay, length, &votess::Delaunay::tetrahedra_centers);
}

const int64_t* votess_delaunay_polytope_indptr(const votess_delaunay* delaunay, size_t* length) {
    return expose(delaunay, length, &votess::Delaunay::polytope_indptr);
}

const int32_t* votess_delaunay_polytope_indices(const votess_delaunay* delaunay, size_t* length) {
    return expose(delaunay, length, &votess::Delaunay::polytope_indices);
}

const int8_t* votess_delaunay_polytope_shifts(const votess_delaunay* delaunay, size_t* length) {
    return expose(delaunay, length, &votess::Delaunay::polytope_shifts);
}

const int32_t* votess_delaunay_polytope_centers(const votess_delaunay* delaunay, size_t* length) {
    return expose(delaunay, length, &votess::Delaunay::polytope_centers);
}

votess_status votess_verify(const votess_result* result, const double* points, size_t count, size_t sample,
                            uint64_t rng_seed, int* passed, uint32_t* skipped, size_t* sampled, char* failure,
                            size_t failure_size) {
    return guarded([&] {
        require(passed, "passed");
        *passed = 0;
        if (skipped != nullptr) *skipped = 0;
        if (sampled != nullptr) *sampled = 0;
        require_text_buffer(failure, failure_size, "failure");
        copy_text("", failure, failure_size);
        require(result, "result");

        votess::VerifyOptions options;
        if (sample != VOTESS_SAMPLE_AUTOMATIC) options.sample = sample;
        options.rng_seed = rng_seed;
        const votess::VerifyReport report = votess::verify(result->tessellation, coordinates(points, count), options);
        if (skipped != nullptr) {
            for (const std::string& check : report.skipped) *skipped |= check_bit(check);
        }
        if (sampled != nullptr) *sampled = report.sampled;
        copy_text(report.failure, failure, failure_size);
        *passed = report.passed ? 1 : 0;
    });
}

size_t votess_device_count(void) {
    std::size_t count = 0;
    guarded([&] { count = votess::devices().size(); });
    return count;
}

votess_status votess_device_info(size_t index, char* id, size_t id_size, char* name, size_t name_size,
                                 char* description, size_t description_size) {
    return guarded([&] {
        require_text_buffer(id, id_size, "id");
        require_text_buffer(name, name_size, "name");
        require_text_buffer(description, description_size, "description");
        const std::vector<votess::DeviceInfo> devices = votess::devices();
        if (index >= devices.size()) {
            refuse("index is " + std::to_string(index) + ", but there are " + std::to_string(devices.size()) +
                   " devices");
        }
        copy_text(devices[index].id, id, id_size);
        copy_text(devices[index].name, name, name_size);
        copy_text(devices[index].description, description, description_size);
    });
}
