// Checks of a tessellation. Each returns one line on the first error, "" when all is right.
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

// Returns whether VOTESS_TEST_REDUCED is set: tests are ten times smaller under sanitizers.
bool reduced();
std::size_t by_size(std::size_t full, std::size_t when_reduced);

// Returns options for the CPU with one thread, walls listed, and volumes, centroids, counts and areas wanted.
votess::Options all_options(const std::optional<votess::Box>& box = std::nullopt);
votess::Tessellation run(const PointSet& set);
votess::Tessellation run(const PointSet& set, votess::Options options);

using Rows = std::vector<std::vector<std::int32_t>>;
Rows rows_of(const votess::Tessellation& t);
std::vector<std::int32_t> row_of(const votess::Tessellation& t, std::size_t i);

// Checks sizes, order, symmetry, volumes that fill the box, Euler's formula, statuses and stats.
// may_underflow: a volume may be below the least double.
std::string check_invariants(const votess::Tessellation& t, std::span<const double> points, bool may_underflow = false);
// Checks that every array is equal.
std::string check_identical(const votess::Tessellation& a, const votess::Tessellation& b);
// Checks that every array and attribute is equal, except the times and the memory of the run, and so are dual and
// pieces.
std::string check_same_result(const votess::Tessellation& a, const votess::Tessellation& b);
// Checks that lists are equal, and geometry to the promised digits.
std::string check_same_cells(const votess::Tessellation& a, const votess::Tessellation& b);
// Proves a tessellation with all_options() and the invariants.
std::string check_exact(const votess::Tessellation& t, std::span<const double> points);
// Tessellates and proves the answer: check_domain(), verify() and the certificate.
std::string check_right(const Coordinates& points, const votess::Options& options);
// Returns the message of the refusal, "" when there is none. The message must be one line and have this code.
std::string refusal(const Coordinates& points, const votess::Options& options = {},
                    votess::ErrorCode code = votess::ErrorCode::invalid_argument);

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
