// Tessellations, Delaunay duals, verify, round walls, devices.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>
#include <votess/picture.hpp>

#include "c/handles.hpp"

using namespace votess::c;

namespace {

template <typename Coordinate>
votess_status tessellate(votess_tessellator* tessellator, const Coordinate* points, std::size_t count,
                         const votess_options* options, votess_result** out) noexcept {
    return create(out, [&] {
        const votess::Options converted = convert_options(options, count);
        const std::span<const Coordinate> input =
            coordinates(points, count, "points", "count", dimensions_of(converted));
        return votess_result{tessellator == nullptr ? votess::tessellate(input, converted)
                                                    : tessellator->tessellator.tessellate(input, converted)};
    });
}

std::uint32_t check_bit(std::string_view name) {
    if (name == "volumes") return VOTESS_CHECK_VOLUMES;
    if (name == "symmetry") return VOTESS_CHECK_SYMMETRY;
    if (name == "euler") return VOTESS_CHECK_EULER;
    if (name == "sample") return VOTESS_CHECK_SAMPLE;
    throw votess::Error(votess::ErrorCode::internal, "verify skipped an unknown check: " + std::string(name));
}

std::array<double, 3> vector(const double* numbers, const char* name) {
    require(numbers, name);
    return {numbers[0], numbers[1], numbers[2]};
}

void write_walls(const std::vector<votess::Wall>& walls, double* out) {
    require(out, "walls");
    std::ranges::copy(rows_of(walls), out);
}

}  // namespace

votess_status votess_tessellator_new(votess_tessellator** out) {
    return create(out, [&] { return votess_tessellator{}; });
}

votess_status votess_tessellate(votess_tessellator* tessellator, const double* points, size_t count,
                                const votess_options* options, votess_result** out) {
    return tessellate(tessellator, points, count, options, out);
}

votess_status votess_tessellate_f32(votess_tessellator* tessellator, const float* points, size_t count,
                                    const votess_options* options, votess_result** out) {
    return tessellate(tessellator, points, count, options, out);
}

votess_status votess_delaunay_new(const votess_result* result, votess_delaunay** out) {
    return create(out, result, "result", [&](auto& of) {
        return votess_delaunay{votess::delaunay(of.tessellation), dimensions_of(of.tessellation)};
    });
}

votess_status votess_delaunay_array(const votess_delaunay* delaunay, const char* name, votess_array* array) {
    return expose(delaunay, "delaunay", name, array, [](const votess_delaunay& of) {
        const votess::Delaunay& d = of.delaunay;
        const std::size_t corners = of.dimensions + 1;
        return std::array{named("tetrahedra", d.tetrahedra, corners),
                          named("tetrahedra_shifts", d.tetrahedra_shifts, corners * of.dimensions),
                          named("tetrahedra_centers", d.tetrahedra_centers),
                          named("polytope_indptr", d.polytope_indptr),
                          named("polytope_indices", d.polytope_indices),
                          named("polytope_shifts", d.polytope_shifts, of.dimensions),
                          named("polytope_centers", d.polytope_centers)};
    });
}

namespace votess::c {

void begin_report(const ReportOut& out) {
    require(out.passed, "passed");
    *out.passed = 0;
    if (out.proven != nullptr) *out.proven = 0;
    if (out.skipped != nullptr) *out.skipped = 0;
    if (out.sampled != nullptr) *out.sampled = 0;
    if (out.tiny_faces != nullptr) *out.tiny_faces = VOTESS_TINY_FACES_UNKNOWN;
    require_text_buffer(out.failure, out.failure_size, "failure");
    copy_text("", out.failure, out.failure_size);
    require_text_buffer(out.unproven, out.unproven_size, "unproven");
    copy_text("", out.unproven, out.unproven_size);
}

void write_report(const VerifyReport& report, const ReportOut& out) {
    if (out.skipped != nullptr) {
        for (const std::string& check : report.skipped) *out.skipped |= check_bit(check);
    }
    if (out.sampled != nullptr) *out.sampled = report.sampled;
    if (out.tiny_faces != nullptr) *out.tiny_faces = report.tiny_faces.value_or(VOTESS_TINY_FACES_UNKNOWN);
    copy_text(report.failure, out.failure, out.failure_size);
    copy_text(report.unproven, out.unproven, out.unproven_size);
    if (out.proven != nullptr) *out.proven = report.proven ? 1 : 0;
    *out.passed = report.passed ? 1 : 0;
}

}  // namespace votess::c

votess_status votess_verify(const votess_result* result, const double* points, size_t count, size_t sample,
                            uint64_t rng_seed, int* passed, int* proven, uint32_t* skipped, size_t* sampled,
                            uint64_t* tiny_faces, char* failure, size_t failure_size, char* unproven,
                            size_t unproven_size) {
    return guarded([&] {
        const ReportOut out{passed,  proven,       skipped,  sampled,      tiny_faces,
                            failure, failure_size, unproven, unproven_size};
        begin_report(out);
        const auto input = points_of(result, points, count);
        write_report(votess::verify(result->tessellation, input, verify_options(sample, rng_seed)), out);
    });
}

votess_status votess_count_tiny_faces(const votess_result* result, const double* points, size_t count,
                                      uint64_t* tiny_faces) {
    return guarded(result, "result", [&](auto& of) {
        require(tiny_faces, "tiny_faces");
        *tiny_faces = votess::count_tiny_faces(of.tessellation, coordinates(points, count));
    });
}

votess_status votess_wrapped_points(const votess_result* result, const double* points, size_t count, double* places) {
    return guarded([&] {
        const auto input = points_of(result, points, count);
        require_array(places, count, "places", "count");
        std::ranges::copy(votess::wrapped_points(result->tessellation, input), places);
    });
}

votess_status votess_value_colors(const double* values, size_t count, int32_t colormap, uint8_t* rgb) {
    return guarded([&] {
        require_array(values, count, "values", "count");
        require_array(rgb, count, "rgb", "count");
        if (colormap < 0 || colormap > 2) {
            refuse("colormap = " + std::to_string(colormap) + ": give 0 (tide), 1 (ember) or 2 (gray)");
        }
        votess::PictureOptions options;
        options.values = std::span(values, count);
        options.colormap = static_cast<votess::Colormap>(colormap);
        std::ranges::copy(votess::value_colors(options), rgb);
    });
}

votess_status votess_sphere_walls(const double center[3], double radius, size_t faces, double* walls) {
    return guarded([&] { write_walls(votess::sphere_walls(vector(center, "center"), radius, faces), walls); });
}

votess_status votess_cylinder_walls(const double point[3], const double axis[3], double radius, size_t faces,
                                    double* walls) {
    return guarded([&] {
        write_walls(votess::cylinder_walls(vector(point, "point"), vector(axis, "axis"), radius, faces), walls);
    });
}

votess_status votess_cone_walls(const double apex[3], const double axis[3], double angle, size_t faces, double* walls) {
    return guarded(
        [&] { write_walls(votess::cone_walls(vector(apex, "apex"), vector(axis, "axis"), angle, faces), walls); });
}

votess_status votess_hull_new(const double* points, size_t count, const votess_options* options, votess_hull** out) {
    return create(out, [&] {
        const votess::Options converted = convert_options(options, count);
        const auto input = coordinates(points, count, "points", "count", dimensions_of(converted));
        return votess_hull{rows_of(votess::hull_walls(input, converted))};
    });
}

votess_status votess_hull_array(const votess_hull* hull, const char* name, votess_array* array) {
    return expose(hull, "hull", name, array,
                  [](const votess_hull& of) { return std::array{named("walls", of.walls, 4)}; });
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
