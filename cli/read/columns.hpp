// Columns that a run wants beside coordinates and ids: weights or radii, and what is carried into the output.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "files/line_reader.hpp"
#include "read/input.hpp"

namespace clvotess {

// The names, and numbers from 1 for columns beyond them.
[[nodiscard]] std::vector<std::string> names_or_numbers(std::vector<std::string> names, std::size_t columns);

// Where the columns that a run wants lie in the rows of a file. Those of one vector NAME may be called NAME_1, NAME_2.
class ColumnPlaces {
public:
    // names: of all columns, numbers from 1 where they have none. where: for messages. Throws Failure when a column
    // that the request names is missing and may not be, or when there are too many columns.
    ColumnPlaces(const ReadRequest& request, const Words& names, const std::string& where);

    // For `all`: adds the columns that are not taken, for coordinates and ids, and hold a number in this row.
    void add_others(const Words& names, std::span<const std::size_t> taken, const Words& row);

    // Whether a column is wanted.
    [[nodiscard]] bool holds(std::size_t column) const;
    // One more than the highest column that is wanted.
    [[nodiscard]] std::size_t end() const;
    // The columns, still empty, with room for so many rows.
    [[nodiscard]] std::vector<InputColumn> columns(std::size_t rows) const;
    // Adds a row: number(k, name) is that of column k, and `name` that of the array.
    template <typename Number>
    void append(std::vector<InputColumn>& columns, Number number) const {
        for (std::size_t c = 0; c < places_.size(); ++c) {
            for (const std::size_t k : places_[c].at) columns[c].values.push_back(number(k, places_[c].name));
        }
    }

private:
    struct Place {
        std::string name;
        std::vector<std::size_t> at;
    };
    std::vector<Place> places_;
};

}  // namespace clvotess
