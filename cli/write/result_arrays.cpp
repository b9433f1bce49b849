#include "write/result_arrays.hpp"

#include <algorithm>
#include <array>
#include <tuple>
#include <type_traits>
#include <utility>

namespace clvotess {

namespace {

struct AlphaNames {
    std::string_view seeds, shifts, values, gabriel;
};
constexpr std::array<AlphaNames, 4> alpha_names{
    {{"alpha_seeds_0", "alpha_shifts_0", "alpha_values_0", "alpha_gabriel_0"},
     {"alpha_seeds_1", "alpha_shifts_1", "alpha_values_1", "alpha_gabriel_1"},
     {"alpha_seeds_2", "alpha_shifts_2", "alpha_values_2", "alpha_gabriel_2"},
     {"alpha_seeds_3", "alpha_shifts_3", "alpha_values_3", "alpha_gabriel_3"}}};

// dimensions: of the points.
void add_alpha(const votess::AlphaComplex& alpha, std::size_t dimensions, bool periodic,
               std::vector<ResultArray>& arrays) {
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        arrays.push_back(as_array(name, std::span(values), columns));
    };
    for (std::size_t k = 0; k <= dimensions; ++k) {
        const votess::AlphaSimplices& simplices = alpha.simplices[k];
        add(alpha_names[k].seeds, simplices.seeds, k + 1);
        if (periodic) add(alpha_names[k].shifts, simplices.shifts, dimensions * (k + 1));
        add(alpha_names[k].values, simplices.values);
        add(alpha_names[k].gabriel, simplices.gabriel);
    }
}

// Returns texts of equal length, filled with zeros.
ResultArray as_texts(std::string_view name, const std::vector<std::string>& words) {
    std::size_t longest = 1;
    for (const std::string& word : words) longest = std::max(longest, word.size());
    auto bytes = std::make_shared<std::string>();
    bytes->reserve(longest * words.size());
    for (const std::string& word : words) (*bytes += word).resize(bytes->size() + longest - word.size());
    return {.name = name, .bytes = *bytes, .text = longest, .owner = bytes};
}

using Cells = votess::Tessellation;
using Rows = votess::StreamRows;
using votess::Want;

// An array of rows. of_rows: null where pieces have none; their ids of seeds have 64 bits.
template <class OfCells, class OfRows>
struct RowArray {
    std::string_view name;
    OfCells of_cells;
    OfRows of_rows;
    std::size_t columns = 1;          // 3: a vector, which has two components in the plane
    bool Want::*word = nullptr;       // the group that wants it; null: every file has it
    bool of_entries = false;          // one row for each neighbor
    bool WholeRows::*held = nullptr;  // whether the rows have it; null: yes
};
template <class OfCells, class OfRows, class... Others>
RowArray(std::string_view, OfCells, OfRows, Others...) -> RowArray<OfCells, OfRows>;

// In the order of the files.
constexpr std::tuple row_arrays{
    RowArray{"indptr", &Cells::indptr, &Rows::indptr, 1, &Want::neighbors},
    RowArray{"indices", &Cells::indices, &Rows::indices, 1, &Want::neighbors, true},
    RowArray{"shifts", &Cells::shifts, &Rows::shifts, 3, &Want::neighbors, true, &WholeRows::has_shifts},
    RowArray{"face_areas", &Cells::face_areas, &Rows::face_areas, 1, &Want::areas, true},
    RowArray{"face_normals", &Cells::face_normals, &Rows::face_normals, 3, &Want::normals, true},
    RowArray{"volumes", &Cells::volumes, &Rows::volumes, 1, &Want::volumes},
    RowArray{"centroids", &Cells::centroids, &Rows::centroids, 3, &Want::centroids},
    RowArray{"surface_areas", &Cells::surface_areas, &Rows::surface_areas, 1, &Want::surfaces},
    RowArray{"mesh_areas", &Cells::mesh_areas, nullptr, 1, &Want::surfaces, false, &WholeRows::in_mesh},
    RowArray{"security_radii", &Cells::security_radii, &Rows::security_radii, 1, &Want::radii},
    RowArray{"face_counts", &Cells::face_counts, &Rows::face_counts, 1, &Want::counts},
    RowArray{"edge_counts", &Cells::edge_counts, &Rows::edge_counts, 1, &Want::counts},
    RowArray{"vertex_counts", &Cells::vertex_counts, &Rows::vertex_counts, 1, &Want::counts},
    RowArray{"vertices", &Cells::vertices, nullptr, 3, &Want::vertices},
    RowArray{"cell_vertex_indptr", &Cells::cell_vertex_indptr, nullptr, 1, &Want::vertices},
    RowArray{"cell_vertex_indices", &Cells::cell_vertex_indices, nullptr, 1, &Want::vertices},
    RowArray{"face_offsets", &Cells::face_offsets, nullptr, 1, &Want::faces},
    RowArray{"face_vertices", &Cells::face_vertices, nullptr, 1, &Want::faces},
    RowArray{"status", &Cells::status, &Rows::status},
    RowArray{"duplicate_of", &Cells::duplicate_of, &Rows::duplicate_of, 1, nullptr, false, &WholeRows::has_duplicates},
};

// Returns an array with numbers of another type.
template <class Number>
ResultArray converted(std::string_view name, const auto& values) {
    const std::vector<Number> numbers(values.begin(), values.end());
    auto bytes = std::make_shared<const std::string>(reinterpret_cast<const char*>(numbers.data()),
                                                     numbers.size() * sizeof(Number));
    return {.name = name, .type = type_of<Number>(), .bytes = *bytes, .owner = bytes};
}

// from: Cells or Rows.
template <class From>
std::vector<ResultArray> arrays_of(const From& from, const std::optional<RowRange>& range, const WholeRows& whole,
                                   std::span<const std::int64_t> ids, const Want& wanted,
                                   const std::vector<InputColumn>& carried) {
    std::vector<ResultArray> arrays;
    if (whole.has_ids) arrays.push_back(as_array("ids", ids));
    const auto add = [&](const auto& array, auto values) {
        const std::size_t columns = array.columns == 3 ? whole.size : array.columns;
        if (range && !values.empty()) {
            std::size_t begin = range->begin, end = begin + range->count;
            if constexpr (std::is_same_v<From, Rows>) {
                const auto entry = [&](std::size_t row) {
                    return static_cast<std::size_t>(from.indptr[row] - from.indptr[0]);
                };
                if (array.of_entries) begin = entry(begin), end = entry(end);
            }
            if (array.name == "indptr") ++end;
            values = values.subspan(columns * begin, columns * (end - begin));
        }
        using Narrow = typename decltype((std::declval<Cells>().*array.of_cells)())::value_type;
        using Given = typename decltype(values)::value_type;
        if (std::is_same_v<Narrow, Given> || whole.wide)
            arrays.push_back(as_array(array.name, values, columns));
        else
            arrays.push_back(converted<Narrow>(array.name, values));
        arrays.back().of_entries = array.of_entries;
    };
    const auto visit = [&](const auto& array) {
        if (array.word != nullptr && !(wanted.*array.word)) return;
        if (array.held != nullptr && !(whole.*array.held)) return;
        if constexpr (std::is_same_v<From, Cells>)
            add(array, (from.*array.of_cells)());
        else if constexpr (!std::is_null_pointer_v<decltype(array.of_rows)>)
            add(array, from.*array.of_rows);
    };
    std::apply([&](const auto&... array) { (visit(array), ...); }, row_arrays);
    for (const InputColumn& column : carried)
        arrays.push_back(column.of_words ? as_texts(column.name, column.words)
                                         : as_array(column.name, std::span(column.values), column.width));
    return arrays;
}

}  // namespace

bool is_result_array(std::string_view name) {
    const auto of_alpha = [&](const AlphaNames& names) {
        return name == names.seeds || name == names.shifts || name == names.values || name == names.gabriel;
    };
    const auto of_rows = [&](const auto&... array) { return ((name == array.name) || ...); };
    constexpr std::array<std::string_view, 9> others{"ids",   "box",     "periodic",    "cell",         "origin",
                                                     "walls", "version", "domain_from", "periodic_from"};
    return std::ranges::any_of(alpha_names, of_alpha) || std::apply(of_rows, row_arrays) ||
           std::ranges::find(others, name) != others.end();
}

std::vector<ResultArray> result_arrays(const votess::StreamRows& piece, const std::optional<RowRange>& range,
                                       const WholeRows& whole, std::span<const std::int64_t> ids, const Want& wanted,
                                       const std::vector<InputColumn>& carried) {
    return arrays_of(piece, range, whole, ids, wanted, carried);
}

std::vector<ResultArray> result_arrays(const OutputData& data) {
    const Cells& cells = data.tessellation;
    const WholeRows whole{.size = size_of_vectors(cells),
                          .has_ids = !data.input.ids.empty(),
                          .has_shifts = !cells.shifts().empty(),
                          .has_duplicates = !cells.duplicate_of().empty(),
                          .in_mesh = cells.in_mesh()};
    auto arrays = arrays_of(cells, std::nullopt, whole, data.input.ids, data.wanted, data.carried);
    if (data.alpha != nullptr) add_alpha(*data.alpha, whole.size, cells.periodic() != std::array<bool, 3>{}, arrays);
    return arrays;
}

DomainArrays::DomainArrays(const votess::Tessellation& cells) {
    const std::size_t size = size_of_vectors(cells);
    const auto append = [size](const auto& vector, auto& to) {
        to.insert(to.end(), vector.begin(), vector.begin() + static_cast<std::ptrdiff_t>(size));
    };
    append(cells.box().lower, box_);
    append(cells.box().upper, box_);
    append(cells.periodic(), periodic_);
    const auto add = [&](std::string_view name, const auto& values, std::size_t columns = 1) {
        arrays_.push_back(as_array(name, std::span(values.data(), values.size()), columns));
    };
    add("box", box_, size);
    add("periodic", periodic_);
    if (const auto& cell = cells.cell()) {
        append(cell->a, cell_);
        append(cell->b, cell_);
        if (size == 3) append(cell->c, cell_);
        append(cell->origin, origin_);
        add("cell", cell_, size);
        add("origin", origin_);
    }
    for (const votess::Wall& wall : cells.walls()) {
        append(wall.normal, walls_);
        walls_.push_back(wall.offset);
    }
    if (!walls_.empty()) add("walls", walls_, size + 1);
}

}  // namespace clvotess
