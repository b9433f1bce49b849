// Arrays, domain and statistics of a result.
#include <cstddef>
#include <cstdint>

#include "c/handles.hpp"
#include "result/arrays.hpp"
#include "result/handle.hpp"

using namespace votess::c;

namespace {

// The first version of the struct ends here. Fields added later follow, without padding.
constexpr std::size_t first_stats_size = offsetof(votess_stats, device) + sizeof(votess_stats::device);
static_assert(sizeof(votess_stats) >= first_stats_size && sizeof(votess_stats) <= VOTESS_LARGEST_STRUCT);
// Exposed as they lie in memory.
static_assert(sizeof(votess::Wall) == 4 * sizeof(double) && sizeof(votess::Box) == 6 * sizeof(double));
static_assert(offsetof(votess::TriclinicBox, c) == 9 * sizeof(double));

static_assert(same(VOTESS_CELL_CERTIFIED, votess::CellStatus::certified));
static_assert(same(VOTESS_CELL_NEEDS_EXACT, votess::CellStatus::needs_exact));
static_assert(same(VOTESS_CELL_PLANE_OVERFLOW, votess::CellStatus::plane_overflow));
static_assert(same(VOTESS_CELL_VERTEX_OVERFLOW, votess::CellStatus::vertex_overflow));
static_assert(same(VOTESS_CELL_CANDIDATES_EXHAUSTED, votess::CellStatus::candidates_exhausted));
static_assert(same(VOTESS_CELL_DUPLICATE, votess::CellStatus::duplicate));
static_assert(same(VOTESS_CELL_EMPTY, votess::CellStatus::empty));
static_assert(same(VOTESS_CELL_OUTSIDE, votess::CellStatus::outside));

}  // namespace

size_t votess_sizeof_stats(void) {
    return sizeof(votess_stats);
}

size_t votess_result_size(const votess_result* result) {
    return value_of<std::size_t>(result, "result is NULL",
                                 [](const votess_result& of) { return of.tessellation.size(); });
}

votess_status votess_result_array(const votess_result* result, const char* name, votess_array* array) {
    return expose(result, "result", name, array, [](const votess_result& of) {
        const votess::Tessellation& t = of.tessellation;
        std::vector<NamedArray> arrays;
        votess::for_all_arrays([&](const auto& row) {
            arrays.push_back(
                named(row.name.data(), row.of(votess::detail::result_of(t)), components_of(row, t.planar())));
        });
        arrays.push_back(named("box", std::span<const double>(t.box().lower.data(), 6), 3));
        arrays.push_back(named("periodic", t.periodic()));
        arrays.push_back(
            named("cell", std::span<const double>(t.cell() ? t.cell()->origin.data() : nullptr, t.cell() ? 12 : 0), 3));
        arrays.push_back(
            named("walls",
                  std::span<const double>(reinterpret_cast<const double*>(t.walls().data()), 4 * t.walls().size()), 4));
        return arrays;
    });
}

int votess_result_in_mesh(const votess_result* result) {
    return value_of<int>(result, "result is NULL", [](const votess_result& of) { return of.tessellation.in_mesh(); });
}

int votess_result_planar(const votess_result* result) {
    return value_of<int>(result, "result is NULL", [](const votess_result& of) { return of.tessellation.planar(); });
}

int votess_result_lists_walls(const votess_result* result) {
    return value_of<int>(result, "result is NULL",
                         [](const votess_result& of) { return of.tessellation.lists_walls(); });
}

double votess_result_least_face(const votess_result* result) {
    return value_of<double>(result, "result is NULL",
                            [](const votess_result& of) { return of.tessellation.least_face(); });
}

void votess::c::check_stats(const votess_stats& out) {
    require_struct_size(out.struct_size, first_stats_size, "stats.struct_size", "set it to sizeof(votess_stats)");
}

void votess::c::write_stats(const votess::Stats& stats, votess_stats& out) {
    votess_stats c_stats{};
    c_stats.threads = stats.threads;
    c_stats.points = stats.points;
    c_stats.faces = stats.faces;
    c_stats.duplicates = stats.duplicates;
    c_stats.empty_cells = stats.empty_cells;
    c_stats.fallback_cells = stats.fallback_cells;
    c_stats.fallback_uncertain = stats.fallback_reasons.uncertain;
    c_stats.fallback_overflow = stats.fallback_reasons.overflow;
    c_stats.fallback_exhausted = stats.fallback_reasons.exhausted;
    c_stats.fallback_skipped = stats.fallback_reasons.skipped;
    c_stats.fallback_domain = stats.fallback_reasons.domain;
    c_stats.exact_cells = stats.exact_cells;
    c_stats.kept_cells = stats.kept_cells;
    c_stats.tiny_faces = stats.tiny_faces ? static_cast<std::int64_t>(*stats.tiny_faces) : -1;
    c_stats.peak_memory_bytes = stats.peak_memory_bytes;
    c_stats.mean_faces = stats.mean_faces;
    c_stats.volume_sum = stats.volume_sum;
    c_stats.box_volume = stats.box_volume;
    c_stats.moved_vertices = stats.moved_vertices;
    c_stats.moved_distance = stats.moved_distance;
    c_stats.seconds_open = stats.seconds.open;
    c_stats.seconds_upload = stats.seconds.upload;
    c_stats.seconds_sort = stats.seconds.sort;
    c_stats.seconds_knn = stats.seconds.knn;
    c_stats.seconds_clip = stats.seconds.clip;
    c_stats.seconds_fallback = stats.seconds.fallback;
    c_stats.seconds_download = stats.seconds.download;
    c_stats.seconds_total = stats.seconds.total;
    copy_text(stats.device, c_stats.device, sizeof c_stats.device);
    c_stats.precision = static_cast<std::int32_t>(stats.precision);
    write_struct(c_stats, out);
}

votess_status votess_result_stats(const votess_result* result, votess_stats* out) {
    return guarded(result, "result", [&](auto& of) {
        require(out, "stats");
        check_stats(*out);
        write_stats(of.tessellation.stats(), *out);
    });
}
