// votess_options, and its conversion to votess::Options.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "c/handles.hpp"
#include "input/each_option.hpp"
#include "votess/row_arrays.hpp"

namespace votess::c {
namespace {

static_assert(same(VOTESS_DUPLICATES_MERGE, Duplicates::merge));
static_assert(same(VOTESS_DUPLICATES_ERROR, Duplicates::error));
static_assert(same(VOTESS_OUTSIDE_ERROR, Outside::error));
static_assert(same(VOTESS_OUTSIDE_DROP, Outside::drop));
static_assert(same(VOTESS_OUTSIDE_KEEP, Outside::keep));
static_assert(same(VOTESS_PRECISION_SINGLE, Precision::single));
static_assert(same(VOTESS_PRECISION_DOUBLE, Precision::double_));

// The first version of the struct ends here. Fields added later follow.
constexpr std::size_t first_options_size = offsetof(votess_options, log_user) + sizeof(votess_options::log_user);
static_assert(sizeof(votess_options) >= first_options_size && sizeof(votess_options) <= VOTESS_LARGEST_STRUCT);

std::uint32_t bits_of(const Want& want) {
    std::uint32_t bits = 0;
    for (const GroupInfo& group : array_groups)
        if (want.*group.word) bits |= group.bit;
    return bits;
}

// Texts of C are NULL by default.
void assign(const char*& /*to*/, const std::string& /*from*/) {}
void assign(std::string& to, const char* from) {
    if (from != nullptr) to = from;
}
void assign(bool& to, std::int32_t from) {
    to = from != 0;
}
template <class To, class From>
void assign(To& to, From from) {
    to = static_cast<To>(from);
}

votess_options default_options() {
    const Options defaults;
    votess_options options{};
    options.want = bits_of(defaults.want);
    std::ranges::fill(options.cell_periodic, 1);
    each_option([&](auto, auto member, auto c_member, auto) { assign(options.*c_member, defaults.*member); });
    return options;
}

// count: of the points, weights and radii.
void convert_domain(const votess_options& given, std::size_t count, Options& options) {
    if (given.has_box != 0) {
        Box box;
        std::copy_n(given.box_lower, 3, box.lower.begin());
        std::copy_n(given.box_upper, 3, box.upper.begin());
        options.box = box;
    }
    for (std::size_t k = 0; k < 3; ++k) options.periodic[k] = given.periodic[k] != 0;
    if (given.has_cell != 0) {
        TriclinicBox& cell = options.cell.emplace();
        std::copy_n(given.cell_origin, 3, cell.origin.begin());
        std::copy_n(given.cell_a, 3, cell.a.begin());
        std::copy_n(given.cell_b, 3, cell.b.begin());
        std::copy_n(given.cell_c, 3, cell.c.begin());
        for (std::size_t k = 0; k < 3; ++k) cell.periodic[k] = given.cell_periodic[k] != 0;
    }
    require_array(given.walls, given.wall_count, "options.walls", "wall_count");
    for (std::uint64_t w = 0; w < given.wall_count; ++w) {
        const double* wall = given.walls + 4 * w;
        options.walls.push_back({{wall[0], wall[1], wall[2]}, wall[3]});
    }
    if (given.weights != nullptr) options.weights = {given.weights, count};
    if (given.radii != nullptr) options.radii = {given.radii, count};
    if (given.has_mesh != 0) {
        const std::size_t dimensions = given.planar != 0 ? 2 : 3;
        require_array(given.mesh_vertices, given.mesh_vertex_count, "options.mesh_vertices", "mesh_vertex_count");
        require_array(given.mesh_triangles, given.mesh_triangle_count, "options.mesh_triangles", "mesh_triangle_count");
        options.mesh = TriangleMesh{{given.mesh_vertices, dimensions * given.mesh_vertex_count},
                                    {given.mesh_triangles, dimensions * given.mesh_triangle_count},
                                    given.mesh_merge != 0,
                                    given.mesh_tolerance};
    }
    if (given.has_only == 0) return;
    require_array(given.only, given.only_count, "options.only", "only_count");
    options.only = std::span(given.only, given.only_count);
}

}  // namespace

Want convert_want(std::uint32_t bits, const std::string& name) {
    std::uint32_t unknown = bits;
    for (const GroupInfo& group : array_groups) unknown &= ~group.bit;
    if (unknown != 0) {
        refuse(name + " is " + std::to_string(bits) + ": its bits " + std::to_string(unknown) +
               " are unknown, combine VOTESS_WANT_* bits");
    }
    Want want;
    for (const GroupInfo& group : array_groups) want.*group.word = (bits & group.bit) != 0;
    return want;
}

Options convert_options(const votess_options* given, std::size_t count) {
    if (given == nullptr) return {};
    const votess_options c_options = read_struct(*given, "options.struct_size", "call votess_options_init first",
                                                 first_options_size, default_options());
    Options options;
    options.want = convert_want(c_options.want, "options.want");
    convert_domain(c_options, count, options);
    each_option([&](auto, auto member, auto c_member, auto) { assign(options.*member, c_options.*c_member); });
    if (c_options.progress != nullptr) options.progress = watching(c_options.progress, c_options.progress_user);
    if (c_options.log != nullptr) {
        options.log = [callback = c_options.log, user = c_options.log_user](std::string_view message) {
            call_back("log", [&] { callback(std::string(message).c_str(), user); });
        };
    }
    return options;
}

}  // namespace votess::c

using namespace votess::c;

size_t votess_sizeof_options(void) {
    return sizeof(votess_options);
}

votess_status votess_options_init(votess_options* options, size_t size) {
    return init_struct(options, size, default_options(), "give sizeof(votess_options)", first_options_size);
}

votess_status votess_want_of(const char* names, uint32_t* want) {
    return guarded([&] {
        require(names, "names");
        require(want, "want");
        *want = bits_of(votess::want_of(names));
    });
}

votess_status votess_options_implied_want(const votess_options* options, uint32_t* want) {
    return guarded([&] {
        require(want, "want");
        constexpr std::size_t any_count = 1;  // weights and radii are not read
        *want = bits_of(votess::implied_want(convert_options(options, any_count)));
    });
}
