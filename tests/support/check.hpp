// Judging a tessellation. Each check returns one line on the first thing that is wrong, "" when all is well, so that
// a test can print the input beside it and a minimizer can call it again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

#include "support/generators.hpp"

namespace test {

// VOTESS_TEST_REDUCED=1 (sanitizers): ten times smaller.
bool reduced();
std::size_t by_size(std::size_t full, std::size_t when_reduced);
std::uint64_t environment(const char* name, std::uint64_t otherwise);

// Everything wanted, walls listed, the CPU, one thread.
votess::Options all_options(const std::optional<votess::Box>& box = std::nullopt);
votess::Tessellation run(const PointSet& set);
votess::Tessellation run(const PointSet& set, votess::Options options);

using Rows = std::vector<std::vector<std::int32_t>>;
Rows rows_of(const votess::Tessellation& t);
std::vector<std::int32_t> row_of(const votess::Tessellation& t, std::size_t i);

// What holds for any input: shapes, order, symmetry, volumes that fill the box, Euler, statuses, stats.
// may_underflow: cells are allowed whose volume is below the least double.
std::string check_invariants(const votess::Tessellation& t, std::span<const double> points, bool may_underflow = false);
// Exact equality of every array.
std::string check_identical(const votess::Tessellation& a, const votess::Tessellation& b);
// The same cells, however they were found: geometry equal to the digits promised, all else exactly.
std::string check_same_cells(const votess::Tessellation& a, const votess::Tessellation& b);
// Equal to the exact diagram: rows, counts, statuses; volumes and centroids to 1e-10. Needs all_options().
std::string check_exact(const votess::Tessellation& t, std::span<const double> points);

// Returns the code of the votess::Error that `call` throws, and nothing when it returns.
template <class Call>
std::optional<votess::ErrorCode> error_of(Call&& call, std::string* message = nullptr) {
    try {
        std::forward<Call>(call)();
    } catch (const votess::Error& error) {
        if (message) *message = error.what();
        return error.code();
    }
    return {};
}

}  // namespace test
