// The C interface among random hostile arguments: no crash, always a status, and after a failure a message that leads.
// Arrays are as long as small counts say; a count that is a lie cannot be told from one that is not below 2^31.
#include <doctest/doctest.h>
#include <votess/picture.h>
#include <votess/stream.h>
#include <votess/votess.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

class Hostile {
public:
    explicit Hostile(std::uint64_t seed) : random_(seed) {}

    // Mostly `good`, else any of some.
    template <class T>
    T any(T good, std::initializer_list<T> bad) {
        if (random_.below(4) > 0) return good;
        return *(bad.begin() + static_cast<std::ptrdiff_t>(random_.below(bad.size())));
    }
    std::size_t count(std::size_t good) {
        return any<std::size_t>(good, {0, 1, 1ull << 31, 1ull << 32, (1ull << 61) + 1, 1ull << 62, 1ull << 63,
                                       ~0ull / 24, ~0ull / 3, ~0ull / 32 + 1, ~0ull - 1, ~0ull});
    }
    std::int32_t number(std::int32_t good) {
        return any<std::int32_t>(good, {0, 1, 2, 7, -1, -2, std::numeric_limits<std::int32_t>::max(),
                                        std::numeric_limits<std::int32_t>::min()});
    }
    std::uint32_t size(std::size_t good) {
        return any(static_cast<std::uint32_t>(good), {0u, 1u, 4u, 8u, 4096u, 4097u, 0x80000000u, ~0u});
    }
    double real(double good) {
        return any(good, {0.0, -0.0, -1.0, 1e308, -1e308, 5e-324, std::nan(""), HUGE_VAL, -HUGE_VAL});
    }
    template <class T>
    T* pointer(T* good) {
        return any<T*>(good, {nullptr});
    }
    std::size_t below(std::size_t n) { return random_.below(n); }

    votess_options options(const double* numbers, bool few_wrong) {
        votess_options o;
        (void)votess_options_init(&o, sizeof o);
        o.device = "cpu";
        o.threads = 1;
        if (few_wrong && below(3) > 0) return o;
        o.struct_size = size(sizeof o);
        o.want = any(o.want, {0u, 1023u, 1024u, ~0u});
        o.list_walls = number(o.list_walls);
        o.has_box = number(o.has_box);
        for (double& x : o.box_upper) x = real(1);
        for (double& x : o.box_lower) x = real(0);
        for (auto& axis : o.periodic) axis = number(0);
        o.has_cell = any(0, {1});
        for (std::size_t k = 0; k < 3; ++k)
            o.cell_a[k] = real(k == 0), o.cell_b[k] = real(k == 1), o.cell_c[k] = real(k == 2);
        o.walls = pointer<const double>(numbers);
        o.wall_count = any<std::uint64_t>(0, {1, 2, 1ull << 31, 1ull << 58, ~0ull, ~0ull / 32 + 1});
        o.weights = any<const double*>(nullptr, {numbers});
        o.radii = any<const double*>(nullptr, {numbers});
        o.has_mesh = any(0, {1, -1});
        o.mesh_vertices = pointer<const double>(numbers);
        o.mesh_vertex_count = any<std::uint64_t>(4, {0, 3, 1ull << 31, 1ull << 61, ~0ull});
        o.mesh_merge = any(0, {1});
        o.mesh_triangles = any<const std::int32_t*>(nullptr, {triangles});
        o.mesh_triangle_count = any<std::uint64_t>(4, {0, 1, 1ull << 32, 1ull << 61, ~0ull / 3 + 1});
        o.min_face = real(0);
        o.min_area = real(0);
        o.outside = number(1);
        o.duplicates = number(0);
        o.device = any<const char*>("cpu", {"", "none", "999999"});
        o.precision = number(0);
        o.threads = any(1u, {2u, 1025u, ~0u});
        o.grid_resolution = any(0u, {1u, 1u << 20, ~0u});
        o.k_init = any(0u, {1u, 1025u, ~0u});
        o.chunk_size = any(0u, {1u, ~0u});
        o.instructions = any<const char*>(nullptr, {"", "baseline", "none"});
        return o;
    }

private:
    static constexpr std::int32_t triangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    test::Random random_;
};

}  // namespace

TEST_SUITE("api") {
    TEST_CASE("C: hostile arguments are refused with a message that leads") {
        constexpr std::size_t n = 12;
        Hostile hostile(91);
        std::size_t accepted = 0, refused = 0;
        std::string wrong;
        const auto note = [&](const char* call, votess_status status) {
            const std::string said = votess_last_error();
            ++(status == VOTESS_OK ? accepted : refused);
            if (status < VOTESS_OK || status > VOTESS_ERROR_NO_THREADS || status == VOTESS_ERROR_INTERNAL)
                wrong = std::string(call) + ": " + said;
            if (status != VOTESS_OK && said.size() < 8) wrong = std::string(call) + " says nothing";
        };
        const std::size_t rounds = test::by_size(300, 100);
        for (std::size_t round = 0; round < rounds && wrong.empty(); ++round) {
            CAPTURE(round);
            std::vector<double> points(3 * n), numbers(4 * n), room(8 * n);
            for (double& x : points) x = hostile.real(0.01 * static_cast<double>(hostile.below(100)));
            for (double& x : numbers) x = hostile.real(0.5);
            if (round % 2 == 0)
                for (std::size_t i = 0; i < points.size(); ++i)
                    points[i] = 0.01 * static_cast<double>(hostile.below(100));
            const votess_options options = hostile.options(numbers.data(), true);
            const votess_options* const given = hostile.pointer(&options);
            votess_result* result = nullptr;
            note("tessellate", votess_tessellate(nullptr, hostile.pointer<const double>(points.data()),
                                                 hostile.count(n), given, &result));
            std::vector<float> narrow(points.begin(), points.end());
            votess_result* other = nullptr;
            note("tessellate_f32",
                 votess_tessellate_f32(nullptr, narrow.data(), hostile.count(n), given, hostile.pointer(&other)));
            votess_result_free(other);
            std::uint32_t want = 0;
            note("implied_want", votess_options_implied_want(&options, hostile.pointer(&want)));
            votess_options fresh;
            note("options_init",
                 votess_options_init(&fresh, hostile.any(sizeof fresh, {std::size_t{0}, std::size_t{8},
                                                                        std::size_t{4097}, ~std::size_t{0}})));
            int passed = 0;
            char text[64];
            note("verify", votess_verify(result, hostile.pointer<const double>(points.data()), hostile.count(n),
                                         hostile.count(3), 1, hostile.pointer(&passed), nullptr, nullptr, nullptr,
                                         nullptr, hostile.pointer<char>(text), hostile.any<std::size_t>(64, {0, 1}),
                                         hostile.pointer<char>(text), hostile.any<std::size_t>(64, {0, 1})));
            note("wrapped_points", votess_wrapped_points(result, hostile.pointer<const double>(points.data()),
                                                         hostile.count(n), hostile.pointer(room.data())));
            votess_picture_options look;
            (void)votess_picture_options_init(&look, sizeof look);
            look.width = look.height = hostile.any<std::uint32_t>(64, {0, 63, ~0u});
            look.values = hostile.pointer<const double>(numbers.data());
            look.value_count = hostile.count(n);
            look.label = hostile.pointer("m");
            for (double* const number : {look.range, look.range + 1, &look.azimuth, &look.elevation, look.cut_at,
                                         look.cut_at + 2, &look.slice_value, &look.gap})
                *number = hostile.real(*number);
            for (std::int32_t* const word :
                 {&look.slice_axis, &look.cut, &look.scale, &look.colormap, &look.wall_cells})
                *word = hostile.number(*word);
            std::vector<std::uint8_t> picture(4 * 64 * 64);
            note("render", votess_render(result, hostile.pointer<const double>(points.data()), hostile.count(n), &look,
                                         hostile.pointer(picture.data()),
                                         hostile.any<std::size_t>(picture.size(), {0, ~0ull}), nullptr));
            votess_stats stats{};
            stats.struct_size = hostile.size(sizeof stats);
            note("stats", votess_result_stats(result, &stats));
            votess_array array{};
            note("array",
                 votess_result_array(result, hostile.any<const char*>("volumes", {nullptr, "", "volume", "vertices"}),
                                     hostile.pointer(&array)));
            const double* volumes = static_cast<const double*>(array.data);
            if (array.components == 1 && array.length > 0 && !(volumes[array.length - 1] >= 0)) wrong = "volumes";
            votess_result_free(result);

            votess_diagram *diagram = nullptr, *view = nullptr;
            note("diagram_new", votess_diagram_new(points.data(), hostile.count(n), given, &diagram));
            note("diagram_view", votess_diagram_view(diagram, given, &view));
            const std::size_t seeds = votess_diagram_size(diagram);
            std::int32_t located[n];
            const double* const queries = hostile.pointer<const double>(points.data());
            note("locate", votess_diagram_locate(view, queries, hostile.count(n), hostile.pointer(located)));
            votess_result* probes = nullptr;
            note("probe", votess_diagram_probe(view, queries, hostile.count(n), hostile.any(3u, {0u, 1023u, ~0u}),
                                               hostile.number(0), hostile.any<const double*>(nullptr, {numbers.data()}),
                                               &probes));
            votess_result_free(probes);
            votess_natural* natural = nullptr;
            note("natural", votess_natural_new(diagram, queries, hostile.count(n), hostile.number(0), hostile.number(1),
                                               hostile.number(0), hostile.any<const double*>(nullptr, {numbers.data()}),
                                               &natural));
            note("natural_array",
                 votess_natural_array(natural, hostile.any<const char*>("weights", {nullptr, "walls"}), &array));
            votess_natural_free(natural);
            // As many components as the arrays have room for, or far too many.
            const std::size_t components = hostile.any<std::size_t>(2, {0, 1, 1ull << 61, ~0ull});
            if (seeds > 0 || components <= 2)
                note("interpolate",
                     votess_diagram_interpolate(view, hostile.pointer<const double>(numbers.data()), components,
                                                queries, hostile.count(n), hostile.number(0), hostile.number(1),
                                                nullptr, hostile.pointer(room.data()), nullptr));
            const auto along = [&] {
                return hostile.any<std::size_t>(2, {0, 1, (1u << 20) + 1, 1ull << 32, 1ull << 63, ~0ull});
            };
            const std::size_t shape[3] = {along(), along(), along()};
            note("to_grid", votess_diagram_to_grid(view, hostile.pointer<const double>(numbers.data()),
                                                   hostile.any<std::size_t>(1, {0, 2, 1ull << 40, ~0ull}), shape,
                                                   hostile.number(0), hostile.number(-1), room.data(), nullptr));
            votess_diagram_free(view);
            votess_diagram_free(diagram);

            std::uint8_t rgb[3 * n];
            note("value_colors", votess_value_colors(hostile.pointer<const double>(numbers.data()), hostile.count(n),
                                                     hostile.number(0), hostile.pointer(rgb)));
            const std::int64_t rows[] = {0, hostile.any(1, {0, -1})}, corners_of[] = {0, hostile.any(3, {0, 2, -1})};
            const std::int32_t corners[] = {0, hostile.number(1), 2}, wall = hostile.number(-1);
            const votess_column column{hostile.pointer("m"), hostile.pointer<const double>(numbers.data()),
                                       hostile.count(1), hostile.any('f', {'i', 'x', '\0'}),
                                       hostile.any<std::uint8_t>(8, {0, 1, 3, 4})};
            votess_mesh mesh{};
            mesh.struct_size = hostile.size(sizeof mesh);
            mesh.column_count = 1;
            mesh.cells = hostile.any<std::uint64_t>(1, {0, 1ull << 31, ~0ull});
            mesh.vertex_count = hostile.any<std::uint64_t>(3, {0, 2, 1ull << 31, ~0ull});
            mesh.indptr = mesh.cell_vertex_indptr = hostile.pointer(rows);
            mesh.indices = hostile.pointer(&wall);
            mesh.face_offsets = hostile.pointer(corners_of);
            mesh.face_vertices = mesh.cell_vertex_indices = hostile.pointer(corners);
            mesh.vertices = points.data();
            mesh.colors = hostile.pointer(rgb);
            mesh.columns = hostile.pointer(&column);
            for (double& x : mesh.box_upper) x = hostile.real(1);
            const auto takes = [](const votess_bytes*, void*) { return 1; };
            const auto stops = [](const votess_bytes*, void*) { return 0; };
            note("write_mesh",
                 votess_write_mesh(hostile.pointer<const votess_mesh>(&mesh),
                                   hostile.any<const char*>(".vtu", {".ply", ".obj", ".glb", ".txt", "", nullptr}),
                                   hostile.any<votess_write_callback>(takes, {nullptr, stops}), nullptr));
            const double direction[3] = {hostile.real(1), hostile.real(0), hostile.real(0)};
            note("sphere_walls",
                 votess_sphere_walls(direction, hostile.real(1), hostile.count(8), hostile.pointer(room.data())));
            note("cylinder_walls", votess_cylinder_walls(direction, hostile.pointer<const double>(direction),
                                                         hostile.real(1), hostile.count(8), room.data()));
            note("cone_walls",
                 votess_cone_walls(direction, direction, hostile.real(0.5), hostile.count(8), room.data()));
        }
        CHECK(wrong == "");
        CHECK(accepted > rounds);
        CHECK(refused > rounds);
    }
}
