// Strict parsing of numbers: the whole text must be the number. Independent of the locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace clvotess {

// Reads decimal or scientific notation, nan and inf; a leading + is allowed. Numbers beyond the range of float64 read
// as infinity, numbers below it as 0.
[[nodiscard]] std::optional<double> read_double(std::string_view text);
[[nodiscard]] std::optional<std::int64_t> read_int64(std::string_view text);
[[nodiscard]] std::optional<std::uint64_t> read_uint64(std::string_view text);

[[nodiscard]] constexpr bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
// Returns whether a comma is between two digits, as in 0,5.
[[nodiscard]] bool has_decimal_comma(std::string_view text);

// Returns the shortest text that reads back as the same value.
[[nodiscard]] std::string to_text(double value);

}  // namespace clvotess
