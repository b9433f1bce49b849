// --only: the cells of some points among all.
#pragma once

#include <cstdint>
#include <vector>

#include "arguments/arguments.hpp"
#include "read/input.hpp"

namespace clvotess {

// Throws Failure for options and outputs that need all cells.
void check_only(const Arguments& arguments);
// Returns the indices that --only names among `count` points. Throws Failure.
[[nodiscard]] std::vector<std::int64_t> read_only(const std::string& only, std::size_t count);
// Returns these points with their species and ids, without columns. If the file has no ids, they are the indices.
[[nodiscard]] Input points_of(const Input& input, const std::vector<std::int64_t>& only);
[[nodiscard]] InputColumn rows_of(const InputColumn& column, const std::vector<std::int64_t>& only);

}  // namespace clvotess
