// Binary numbers of files: any width, either byte order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

namespace clvotess {

static_assert(std::endian::native == std::endian::little, "arrays are read and written without conversion");

enum class NumberType : std::uint8_t {
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64,
    float16
};

[[nodiscard]] constexpr std::size_t size_of(NumberType type) {
    constexpr std::array<std::size_t, 11> sizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 2};
    return sizes[static_cast<std::size_t>(type)];
}
[[nodiscard]] constexpr bool is_float(NumberType type) {
    return type >= NumberType::float32;
}

template <typename Number>
[[nodiscard]] Number load_number(const char* from, bool swapped) {
    std::array<char, sizeof(Number)> bytes;
    std::memcpy(bytes.data(), from, bytes.size());
    if (swapped) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Number>(bytes);
}

// Returns the value of the bits of a float16.
[[nodiscard]] inline float float16_value(std::uint16_t bits) {
    const int exponent = bits >> 10 & 31, fraction = bits & 1023;
    const float size = exponent == 31  ? (fraction == 0 ? std::numeric_limits<float>::infinity()
                                                        : std::numeric_limits<float>::quiet_NaN())
                       : exponent == 0 ? std::ldexp(static_cast<float>(fraction), -24)
                                       : std::ldexp(static_cast<float>(fraction + 1024), exponent - 25);
    return bits >> 15 != 0 ? -size : size;
}

// Returns use(number), where the number has its own type; a float32 for float16.
template <typename Use>
auto with_number(NumberType type, const char* from, bool swapped, Use use) {
    switch (type) {
        case NumberType::int8:
            return use(load_number<std::int8_t>(from, swapped));
        case NumberType::uint8:
            return use(load_number<std::uint8_t>(from, swapped));
        case NumberType::int16:
            return use(load_number<std::int16_t>(from, swapped));
        case NumberType::uint16:
            return use(load_number<std::uint16_t>(from, swapped));
        case NumberType::int32:
            return use(load_number<std::int32_t>(from, swapped));
        case NumberType::uint32:
            return use(load_number<std::uint32_t>(from, swapped));
        case NumberType::int64:
            return use(load_number<std::int64_t>(from, swapped));
        case NumberType::uint64:
            return use(load_number<std::uint64_t>(from, swapped));
        case NumberType::float16:
            return use(float16_value(load_number<std::uint16_t>(from, swapped)));
        case NumberType::float32:
            return use(load_number<float>(from, swapped));
        default:
            return use(load_number<double>(from, swapped));
    }
}

[[nodiscard]] inline double load_double(NumberType type, const char* from, bool swapped) {
    return with_number(type, from, swapped, [](auto value) { return static_cast<double>(value); });
}

// Returns nothing when the number is not whole or exceeds int64.
[[nodiscard]] inline std::optional<std::int64_t> load_whole(NumberType type, const char* from, bool swapped) {
    return with_number(type, from, swapped, [](auto value) -> std::optional<std::int64_t> {
        using Number = decltype(value);
        if constexpr (std::is_floating_point_v<Number>) {
            if (!(std::abs(value) <= Number{0x1p53} && std::trunc(value) == value)) return std::nullopt;
        } else if constexpr (std::is_same_v<Number, std::uint64_t>) {
            if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) return std::nullopt;
        }
        return static_cast<std::int64_t>(value);
    });
}

}  // namespace clvotess
