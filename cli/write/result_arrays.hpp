// The arrays of a result as .npz and .h5 hold them: names, types and shapes in one place.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>
#include <votess/votess.hpp>

#include "files/binary_numbers.hpp"

namespace clvotess {

struct ResultArray {
    std::string_view name;
    NumberType type{};
    std::size_t columns = 1;  // 1: shape (rows,), else (rows, columns)
    std::string_view bytes;   // of the library's memory, row-major

    [[nodiscard]] std::size_t rows() const noexcept { return bytes.size() / size_of(type) / columns; }
};

// Returns the arrays that `wanted` names, status, and duplicate_of when there are duplicates. They are valid as long as
// `cells`.
[[nodiscard]] std::vector<ResultArray> result_arrays(const votess::Tessellation& cells, const votess::Want& wanted);

}  // namespace clvotess
