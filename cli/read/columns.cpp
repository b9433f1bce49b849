#include "read/columns.hpp"

#include <algorithm>
#include <optional>

#include "failure.hpp"

namespace clvotess {
namespace {

// Returns the name of a column; column_NUMBER for one without a name.
std::string name_of(std::string_view name) {
    return (read_uint64(name) ? "column_" : "") + std::string(name);
}

// Finds a column by name, or by number from 1.
std::optional<std::size_t> find_any(const Words& names, const std::string& name) {
    if (const auto same = find_name(names, name)) return same;
    if (const auto number = read_uint64(name); number && *number >= 1 && *number <= names.size()) return *number - 1;
    return std::nullopt;
}

std::optional<std::size_t> find_species(const Words& names, SpeciesNames species) {
    for (const char* const name : species)
        if (const auto at = find_name(names, name)) return at;
    return std::nullopt;
}

}  // namespace

std::vector<std::string> names_or_numbers(std::vector<std::string> names, std::size_t columns) {
    for (std::size_t k = names.size(); k < columns; ++k) names.push_back(std::to_string(k + 1));
    return names;
}

ColumnPlaces::ColumnPlaces(const ReadRequest& request, const Words& names, const std::string& where,
                           SpeciesNames species)
    : carries_words_(request.carries_words) {
    if (names.size() > max_columns) {
        throw bad_input(where + ": " + columns_text(names.size()) + ", more than the " + std::to_string(max_columns) +
                        " that are read");
    }
    if (request.species) species_ = find_species(names, species);
    for (std::size_t c = 0; c < request.columns.size(); ++c) {
        const std::string& name = request.columns[c];
        const bool carried = c >= request.first_carried;
        if (!find_name(names, name) && find_name(names, name + "_1")) {
            Place& place = places_.emplace_back();
            place.name = name;
            place.carried = carried;
            for (std::size_t part = 1;; ++part) {
                const auto at = find_name(names, name + "_" + std::to_string(part));
                if (!at) break;
                place.at.push_back(*at);
            }
            continue;
        }
        if (const auto at = find_any(names, name)) {
            const std::string number = std::to_string(*at + 1);
            places_.push_back({name_of(names[*at].empty() ? number : names[*at]), {*at}, carried});
        } else if (const auto alias = name == "species" ? find_species(names, species)
                                      : name == "type"  ? find_name(names, "typelabel")
                                                        : std::nullopt) {
            places_.push_back({name, {*alias}, carried});
        } else if (!request.columns_may_lack) {
            std::string list;
            for (const std::string_view known : names) add_name(list, known);
            throw bad_input(where + ": no column " + in_quotes(name) + "; there are " + list);
        }
    }
}

void ColumnPlaces::add_others(const Words& names, std::span<const std::size_t> taken, const Words& row) {
    for (std::size_t k = 0; k < std::min(names.size(), row.size()); ++k) {
        const bool free = std::ranges::find(taken, k) == taken.end() && !holds(k) && !names[k].empty();
        if (free && (read_double(row[k]) || has_decimal_comma(row[k])))
            places_.push_back({name_of(names[k]), {k}, true});
    }
}

void ColumnPlaces::find_words(const Words& row) {
    for (Place& place : places_) {
        const std::size_t k = place.at[0];
        place.words = carries_words_ && place.carried && place.at.size() == 1 && k < row.size() && !row[k].empty() &&
                      !read_double(row[k]) && !has_decimal_comma(row[k]);
    }
}

bool ColumnPlaces::holds(std::size_t column) const {
    return std::ranges::any_of(
        places_, [&](const Place& place) { return std::ranges::find(place.at, column) != place.at.end(); });
}

std::size_t ColumnPlaces::end() const {
    std::size_t end = 0;
    for (const Place& place : places_) end = std::max(end, *std::ranges::max_element(place.at) + 1);
    return end;
}

std::vector<InputColumn> ColumnPlaces::columns(std::size_t rows) const {
    std::vector<InputColumn> columns;
    for (const Place& place : places_) {
        InputColumn& column = columns.emplace_back(InputColumn{.name = place.name, .width = place.at.size()});
        column.of_words = place.words;
        column.keeps_integers = place.carried;
        if (!place.words) column.values.reserve(rows * place.at.size());
    }
    return columns;
}

}  // namespace clvotess
