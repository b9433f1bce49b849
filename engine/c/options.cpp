// votess_options and what it becomes in votess.hpp.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "c/handles.hpp"

namespace votess::c {
namespace {

static_assert(same(VOTESS_DUPLICATES_MERGE, Duplicates::merge));
static_assert(same(VOTESS_DUPLICATES_ERROR, Duplicates::error));
static_assert(same(VOTESS_OUTSIDE_ERROR, Outside::error));
static_assert(same(VOTESS_OUTSIDE_DROP, Outside::drop));
static_assert(same(VOTESS_PRECISION_SINGLE, Precision::single));
static_assert(same(VOTESS_PRECISION_DOUBLE, Precision::double_));

struct WantBit {
    std::uint32_t bit;
    bool Want::*member;
};
constexpr WantBit want_bits[] = {
    {VOTESS_WANT_NEIGHBORS, &Want::neighbors}, {VOTESS_WANT_VOLUMES, &Want::volumes},
    {VOTESS_WANT_CENTROIDS, &Want::centroids}, {VOTESS_WANT_COUNTS, &Want::counts},
    {VOTESS_WANT_AREAS, &Want::areas},         {VOTESS_WANT_NORMALS, &Want::normals},
    {VOTESS_WANT_SURFACES, &Want::surfaces},   {VOTESS_WANT_RADII, &Want::radii},
    {VOTESS_WANT_VERTICES, &Want::vertices},   {VOTESS_WANT_FACES, &Want::faces},
};

// These never change; fields added later lie beyond.
constexpr std::size_t first_size = offsetof(votess_options, log_user) + sizeof(votess_options::log_user);
// No padding at the end: whatever is added later makes the struct larger, which tells callers with and without it
// apart.
static_assert(sizeof(votess_options) == first_size && sizeof(votess_options) <= VOTESS_LARGEST_STRUCT);

std::uint32_t bits_of(const Want& want) {
    std::uint32_t bits = 0;
    for (const WantBit& word : want_bits)
        if (want.*word.member) bits |= word.bit;
    return bits;
}

votess_options default_options() {
    const Options defaults;
    votess_options options{};
    options.struct_size = sizeof(votess_options);
    options.want = bits_of(defaults.want);
    options.list_walls = defaults.list_walls ? 1 : 0;
    std::ranges::fill(options.cell_periodic, 1);
    options.min_face = defaults.min_face;
    options.min_area = defaults.min_area;
    options.outside = static_cast<std::int32_t>(defaults.outside);
    options.duplicates = static_cast<std::int32_t>(defaults.duplicates);
    options.precision = static_cast<std::int32_t>(defaults.precision);
    options.threads = defaults.threads;
    options.grid_resolution = defaults.grid_resolution;
    options.k_init = defaults.k_init;
    options.chunk_size = defaults.chunk_size;
    return options;
}

// count: of the points, and so of weights and radii.
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
    options.outside = static_cast<Outside>(given.outside);
}

}  // namespace

Want convert_want(std::uint32_t bits, const std::string& name) {
    std::uint32_t unknown = bits;
    for (const WantBit& word : want_bits) unknown &= ~word.bit;
    if (unknown != 0) {
        refuse(name + " is " + std::to_string(bits) + ": its bits " + std::to_string(unknown) +
               " are unknown; combine VOTESS_WANT_* bits");
    }
    Want want;
    for (const WantBit& word : want_bits) want.*word.member = (bits & word.bit) != 0;
    return want;
}

Options convert_options(const votess_options* given, std::size_t count) {
    if (given == nullptr) return {};
    require_struct_size(given->struct_size, first_size, "options.struct_size", "call votess_options_init first");
    votess_options c_options = default_options();
    std::memcpy(&c_options, given, std::min<std::size_t>(given->struct_size, sizeof c_options));

    Options options;
    options.want = convert_want(c_options.want, "options.want");
    convert_domain(c_options, count, options);
    options.list_walls = c_options.list_walls != 0;
    options.min_face = c_options.min_face;
    options.min_area = c_options.min_area;
    options.duplicates = static_cast<Duplicates>(c_options.duplicates);
    if (c_options.device != nullptr) options.device = c_options.device;
    options.threads = c_options.threads;
    options.grid_resolution = c_options.grid_resolution;
    options.precision = static_cast<Precision>(c_options.precision);
    options.k_init = c_options.k_init;
    options.chunk_size = c_options.chunk_size;
    if (c_options.instructions != nullptr) options.instructions = c_options.instructions;
    if (c_options.progress != nullptr) {
        options.progress = [callback = c_options.progress, user = c_options.progress_user](double fraction) {
            return call_back("progress", [&] { return callback(fraction, user) != 0; });
        };
    }
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
    return guarded([&] {
        require(options, "options");
        require_struct_size(size, first_size, "size", "give sizeof(votess_options)");
        votess_options defaults = default_options();
        defaults.struct_size = static_cast<std::uint32_t>(std::min(size, sizeof defaults));
        std::memcpy(options, &defaults, defaults.struct_size);
    });
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
        constexpr std::size_t any_count = 1;  // weights and radii are given or not, and not read
        *want = bits_of(votess::implied_want(convert_options(options, any_count)));
    });
}
