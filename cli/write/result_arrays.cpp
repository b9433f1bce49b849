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
using votess::Per;
using votess::Want;

// ids and weights are columns of the input.
void for_file_arrays(const auto& visit) {
    votess::for_all_arrays([&](const auto& array) {
        if (array.name != "ids" && array.name != "weights") visit(array);
    });
}

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
    const auto add = [&](const auto& array) {
        const auto& of_array = array.of(from);
        auto values = std::span(of_array.data(), of_array.size());
        const std::size_t columns = array.components == 3 ? whole.size : array.components;
        const bool of_entries = array.per == Per::entry;
        if (range && !values.empty()) {
            std::size_t begin = range->begin, end = begin + range->count;
            if constexpr (std::is_same_v<From, Rows>) {
                const auto entry = [&](std::size_t row) {
                    return static_cast<std::size_t>(from.indptr[row] - from.indptr[0]);
                };
                if (of_entries) begin = entry(begin), end = entry(end);
            }
            if (array.name == "indptr") ++end;
            values = values.subspan(columns * begin, columns * (end - begin));
        }
        using Narrow = typename std::remove_cvref_t<decltype(array.of(std::declval<const Cells&>()))>::value_type;
        using Given = std::remove_const_t<typename decltype(values)::element_type>;
        if (std::is_same_v<Narrow, Given> || whole.wide)
            arrays.push_back(as_array(array.name, std::span<const Given>(values), columns));
        else
            arrays.push_back(converted<Narrow>(array.name, values));
        arrays.back().of_entries = of_entries;
    };
    for_file_arrays([&](const auto& array) {
        if (array.word != nullptr && !(wanted.*array.word)) return;
        if (array.name == "shifts" && !whole.has_shifts) return;
        if (array.name == "duplicate_of" && !whole.has_duplicates) return;
        if (array.name == "mesh_areas" && !whole.in_mesh) return;
        if constexpr (requires { array.of(from); }) add(array);
    });
    for (const InputColumn& column : carried) {
        arrays.push_back(column.of_words ? as_texts(column.name, column.words)
                                         : as_array(column.name, std::span(column.values), column.width));
        if (column.of_integers) arrays.back().type = type_of<std::int64_t>();
    }
    return arrays;
}

}  // namespace

bool is_result_array(std::string_view name) {
    const auto of_alpha = [&](const AlphaNames& names) {
        return name == names.seeds || name == names.shifts || name == names.values || name == names.gabriel;
    };
    bool found = false;
    for_file_arrays([&](const auto& array) { found = found || array.name == name; });
    constexpr std::array<std::string_view, 9> others{"ids",   "box",     "periodic",    "cell",         "origin",
                                                     "walls", "version", "domain_from", "periodic_from"};
    return found || std::ranges::any_of(alpha_names, of_alpha) || std::ranges::find(others, name) != others.end();
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
                          .has_shifts = cells.periodic() != std::array<bool, 3>{},
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
