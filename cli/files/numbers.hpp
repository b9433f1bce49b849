// Strict reading of numbers: the whole text is the number, or there is none. Independent of the locale.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace clvotess {

// Decimal or scientific, also nan and inf; a leading + is allowed. Too large for float64 reads as infinity.
[[nodiscard]] std::optional<double> read_double(std::string_view text);
[[nodiscard]] std::optional<std::int64_t> read_int64(std::string_view text);
[[nodiscard]] std::optional<std::uint64_t> read_uint64(std::string_view text);

// Shortest text that reads back as the same value.
[[nodiscard]] std::string to_text(double value);

}  // namespace clvotess
