// Columns that a run requests in addition to coordinates and ids: weights or radii, masses, carried columns.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "files/line_reader.hpp"
#include "read/input.hpp"

namespace clvotess {

// Returns the names; numbers from 1 for columns without a name.
[[nodiscard]] std::vector<std::string> names_or_numbers(std::vector<std::string> names, std::size_t columns);

// Columns that may hold the species, the first that is there. LAMMPS has no column `species` of its own in a dump.
using SpeciesNames = const std::array<const char*, 5>&;
constexpr std::array<const char*, 5> species_names{"species", "element", "symbol", "typelabel", "type"};
constexpr std::array<const char*, 5> species_names_of_dump{"element", "typelabel", "species", "symbol", "type"};

// Places of the requested columns in the rows of a file. A vector NAME may consist of columns NAME_1, NAME_2, ... The
// name species also finds a column of SpeciesNames, and type finds typelabel.
class ColumnPlaces {
public:
    // names: of all columns; numbers from 1 where they have none. where: for messages. Throws Failure when a requested
    // column is missing and required, or when there are too many columns.
    ColumnPlaces(const ReadRequest& request, const Words& names, const std::string& where,
                 SpeciesNames species = species_names);

    // Adds the columns that hold a number in this row and are not `taken` for coordinates and ids, for --copy all.
    void add_others(const Words& names, std::span<const std::size_t> taken, const Words& row);

    // Chooses the columns that hold words, by their first row.
    void find_words(const Words& row);

    // Returns the column of the species, if ReadRequest::species is set and the file has one.
    [[nodiscard]] std::optional<std::size_t> species() const noexcept { return species_; }
    // Returns whether a column is requested.
    [[nodiscard]] bool holds(std::size_t column) const;
    // Returns one more than the last requested column.
    [[nodiscard]] std::size_t end() const;
    // Returns empty columns with room for `rows` rows.
    [[nodiscard]] std::vector<InputColumn> columns(std::size_t rows) const;
    // Adds a row to the columns and species. word(k) returns the text in column k. number(k, name) returns its number,
    // for the array `name`.
    template <typename Word, typename Number>
    void append(Input& input, Word word, Number number) const {
        for (std::size_t c = 0; c < places_.size(); ++c) {
            if (places_[c].words) {
                input.columns[c].words.emplace_back(word(places_[c].at[0]));
                continue;
            }
            InputColumn& column = input.columns[c];
            for (const std::size_t k : places_[c].at) {
                const double value = number(k, places_[c].name);
                if (column.may_round(value)) {
                    column.append(value, word(k));
                } else {
                    column.values.push_back(value);
                }
            }
        }
        if (species_) input.species.emplace_back(word(*species_));
    }

private:
    struct Place {
        std::string name;
        std::vector<std::size_t> at;
        bool carried = false, words = false;
    };
    bool carries_words_;
    std::vector<Place> places_;
    std::optional<std::size_t> species_;
};

}  // namespace clvotess
