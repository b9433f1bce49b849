// Handles of the C interface, the catch of all exceptions, and the last error.
#pragma once

#include <votess/votess.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>
#include <votess/alpha.hpp>
#include <votess/density.hpp>
#include <votess/diagram.hpp>
#include <votess/fit.hpp>
#include <votess/groups.hpp>
#include <votess/network.hpp>
#include <votess/pieces.hpp>
#include <votess/votess.hpp>
#include <votess/zones.hpp>

#include "core/errors.hpp"

struct votess_tessellator {
    votess::Tessellator tessellator;
};

struct votess_result {
    votess::Tessellation tessellation;
};

struct votess_delaunay {
    votess::Delaunay delaunay;
    std::size_t dimensions;
};

struct votess_hull {
    std::vector<double> walls;
};

struct votess_diagram {
    votess::Diagram diagram;
    votess::ProgressCallback progress;  // for its queries
};

struct votess_rays {
    votess::RayCells cells;
    std::size_t dimensions;
};

struct votess_natural {
    votess::NaturalCoordinates coordinates;
    std::size_t dimensions;
};

struct votess_fit {
    votess::VolumeFit fit;
    bool converged = false;  // false: weights, but no tessellation
};

struct votess_zones {
    votess::Zones zones;
};

struct votess_groups {
    votess::Groups groups;
};

struct votess_masses {
    votess::Masses masses;
    std::size_t dimensions;
};

struct votess_network {
    votess::Network network;
    std::size_t dimensions;
};

struct votess_pieces {
    votess::Pieces pieces;
    std::size_t dimensions;
};

struct votess_alpha {
    votess::AlphaComplex complex;
    std::size_t dimensions;
};

namespace votess::c {

// Whether a constant of votess.h has the value of votess.hpp.
template <typename Enum>
constexpr bool same(int c_value, Enum value) {
    return c_value == static_cast<int>(value);
}

// Copies the part that fits, without half a UTF-8 character.
void copy_text(std::string_view text, char* out, std::size_t out_size) noexcept;
// libvotess exports the functions with VOTESS_API to libvotess_mpi of the same version, which shares the last error.
VOTESS_API void set_last_error(std::string_view message) noexcept;
VOTESS_API void set_internal_error(const char* message) noexcept;

using votess::refuse;
VOTESS_API void require(const void* pointer, const char* name);
void require_text_buffer(const char* buffer, std::size_t size, const char* name);

// Where the report of verify() goes; see votess_verify.
struct ReportOut {
    int* passed;
    int* proven;  // this and the next three may be null
    std::uint32_t* skipped;
    std::size_t* sampled;
    std::uint64_t* tiny_faces;
    char* failure;
    std::size_t failure_size;
    char* unproven;
    std::size_t unproven_size;
};
// Refuses pointers that must not be NULL, and writes "not passed".
VOTESS_API void begin_report(const ReportOut& out);
VOTESS_API void write_report(const VerifyReport& report, const ReportOut& out);
[[nodiscard]] inline VerifyOptions verify_options(std::size_t sample, std::uint64_t rng_seed) {
    VerifyOptions options;
    if (sample != VOTESS_SAMPLE_AUTOMATIC) options.sample = sample;
    options.rng_seed = rng_seed;
    return options;
}

VOTESS_API void require_struct_size(std::size_t size, std::size_t smallest, const char* name, const char* remedy);

// Returns a struct of a caller; members that its struct_size leaves out are those of `all`.
template <typename Struct>
[[nodiscard]] Struct read_struct(const Struct& given, const char* name, const char* remedy,
                                 std::size_t smallest = sizeof(Struct), Struct all = {}) {
    require_struct_size(given.struct_size, smallest, name, remedy);
    std::memcpy(&all, &given, std::min<std::size_t>(given.struct_size, sizeof all));
    return all;
}

// Fills a struct of a caller up to its struct_size, which stays.
template <typename Struct>
void write_struct(Struct from, Struct& to) {
    from.struct_size = to.struct_size;
    std::memcpy(&to, &from, std::min<std::size_t>(to.struct_size, sizeof from));
}

// bits: VOTESS_WANT_*. name: for messages.
[[nodiscard]] Want convert_want(std::uint32_t bits, const std::string& name);
// given: NULL for the defaults. count: length of weights and radii.
[[nodiscard]] VOTESS_API Options convert_options(const votess_options* given, std::size_t count);

// Checks struct_size.
void check_stats(const votess_stats& out);
void write_stats(const Stats& stats, votess_stats& out);

// Refuses an array that is NULL but has elements, and more elements than any function takes.
VOTESS_API void require_array(const void* array, std::uint64_t count, const char* name, const char* count_name);

// Returns 2 or 3 for a Tessellation, Diagram or Options.
template <typename Of>
[[nodiscard]] std::size_t dimensions_of(const Of& of) {
    if constexpr (requires { of.planar(); })
        return of.planar() ? 2 : 3;
    else
        return of.planar ? 2 : 3;
}

// Returns a density on a grid. Refuses NULL, unless the shape has no elements. The library checks the shape.
[[nodiscard]] Density density_of(const double* values, const size_t shape[3]);

template <typename Coordinate>
std::span<const Coordinate> coordinates(const Coordinate* points, std::size_t count, const char* name = "points",
                                        const char* count_name = "count", std::size_t dimensions = 3) {
    require_array(points, count, name, count_name);
    return {points, dimensions * count};
}

// Returns get(*handle), or without a handle 0 and the error.
template <typename Value, typename Handle, typename Get>
Value value_of(const Handle* handle, const char* error, const Get& get) noexcept {
    if (handle != nullptr) return static_cast<Value>(get(*handle));
    set_last_error(error);
    return 0;
}

// Returns numbers nx, ny, nz and d of each wall.
inline std::vector<double> rows_of(const std::vector<Wall>& walls) {
    std::vector<double> rows;
    for (const Wall& wall : walls) {
        rows.insert(rows.end(), wall.normal.begin(), wall.normal.end());
        rows.push_back(wall.offset);
    }
    return rows;
}

// Those of a result.
inline std::span<const double> points_of(const votess_result* result, const double* points, std::size_t count) {
    require(result, "result");
    return coordinates(points, count, "points", "count", dimensions_of(result->tessellation));
}

// Those of queries, which have the dimensions of the seeds.
inline std::span<const double> queries_of(const votess_diagram& diagram, const double* queries, std::size_t count,
                                          const char* name = "queries") {
    return coordinates(queries, count, name, "count", dimensions_of(diagram.diagram));
}

// Calls a callback. An exception of the callback becomes an error that names it.
template <typename Function>
auto call_back(const char* name, const Function& function) {
    const std::string threw = std::string("the callback ") + name + " threw ";
    try {
        return function();
    } catch (const std::exception& error) {
        throw Error(ErrorCode::cancelled, threw + "an exception: " + error.what());
    } catch (...) {
        throw Error(ErrorCode::cancelled, threw + "an exception of unknown type");
    }
}

// Returns a callback of the engine for one of C, which is not NULL.
inline ProgressCallback watching(votess_progress_callback callback, void* user) {
    return [=](double fraction) { return call_back("progress", [&] { return callback(fraction, user) != 0; }); };
}

// Calls function(data). Meanwhile the callback of votess_set_progress() may stop it.
VOTESS_API void call_watched(void (*function)(void*), void* data);

template <typename Function>
votess_status guarded(Function&& function) noexcept {
    try {
        call_watched([](void* data) { (*static_cast<std::remove_reference_t<Function>*>(data))(); }, &function);
        return VOTESS_OK;
    } catch (const votess::Error& error) {
        set_last_error(error.what());
        return static_cast<votess_status>(error.code());
    } catch (const std::bad_alloc&) {
        set_last_error("out of memory");
        return VOTESS_ERROR_OUT_OF_MEMORY;
    } catch (const std::exception& error) {
        set_internal_error(error.what());
        return VOTESS_ERROR_INTERNAL;
    } catch (...) {
        set_internal_error("an exception of unknown type");
        return VOTESS_ERROR_INTERNAL;
    }
}

// The same with function(*handle). name: of the handle, for messages.
template <typename Handle, typename Function>
votess_status guarded(Handle* handle, const char* name, const Function& function) noexcept {
    return guarded([&] {
        require(handle, name);
        function(*handle);
    });
}

// Fills a struct of options, of the size that the caller compiled, with the defaults.
template <typename Struct>
votess_status init_struct(Struct* options, std::size_t size, const Struct& defaults, const char* remedy,
                          std::size_t smallest = sizeof(Struct)) noexcept {
    return guarded([&] {
        require(options, "options");
        require_struct_size(size, smallest, "size", remedy);
        options->struct_size = static_cast<std::uint32_t>(std::min(size, sizeof defaults));
        write_struct(defaults, *options);
    });
}

// Makes a handle: *out = make(), or NULL after an error.
template <typename Handle, typename Make>
votess_status create(Handle** out, const Make& make) noexcept {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        *out = new Handle(make());
    });
}

// The same from another handle: make(*from).
template <typename Handle, typename From, typename Make>
votess_status create(Handle** out, From* from, const char* name, const Make& make) noexcept {
    return create(out, [&] {
        require(from, name);
        return make(*from);
    });
}

// An array of a handle, and its name.
struct NamedArray {
    const char* name;
    votess_array array;
};

// components: elements in a row.
template <typename Elements>
NamedArray named(const char* name, const Elements& elements, std::size_t components = 1) noexcept {
    using Element = std::remove_cvref_t<decltype(elements[0])>;
    constexpr char kind = std::is_floating_point_v<Element> ? 'f' : std::is_signed_v<Element> ? 'i' : 'u';
    static_assert(std::is_arithmetic_v<Element> || sizeof(Element) == 1);  // CellStatus
    return {name,
            {elements.empty() ? nullptr : elements.data(), elements.size() / components, components, kind,
             static_cast<std::uint8_t>(sizeof(Element))}};
}

// Writes the array of this name. handle: the word for messages. Refuses a name that is not among them.
VOTESS_API void write_array(const char* handle, const char* name, std::span<const NamedArray> arrays,
                            votess_array& out);

// Writes the array of this name from arrays(*handle), which makes all of them.
template <typename Handle, typename Arrays>
votess_status expose(const Handle* handle, const char* word, const char* name, votess_array* out,
                     const Arrays& arrays) noexcept {
    return guarded([&] {
        require(out, "array");
        *out = {};
        require(handle, word);
        require(name, "name");
        write_array(word, name, arrays(*handle), *out);
    });
}

}  // namespace votess::c
