#include "files/numbers.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "failure.hpp"

namespace clvotess {
namespace {

std::string_view without_plus(std::string_view text) {
    const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
    return plus ? text.substr(1) : text;
}

template <typename Integer>
std::optional<Integer> read_integer(std::string_view text) {
    text = without_plus(text);
    Integer value{};
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || stop != text.data() + text.size()) return std::nullopt;
    return value;
}

// Returns whether a number outside of the range of float64 is too large; otherwise it is too small. The exponent and
// the first digit other than 0 decide.
bool is_huge(std::string_view text) {
    const auto mark = std::min(text.find_first_of("eE"), text.size());
    const std::string_view digits = text.substr(0, mark);
    const auto point = static_cast<std::int64_t>(std::min(digits.find('.'), digits.size()));
    const auto first = static_cast<std::int64_t>(std::min(digits.find_first_of("123456789"), digits.size()));
    std::int64_t exponent = 0;
    if (mark < text.size()) {
        const std::string_view word = without_plus(text.substr(mark + 1));
        constexpr std::int64_t farther_than_any_text = std::int64_t{1} << 62;
        exponent = read_integer<std::int64_t>(word).value_or(farther_than_any_text);
        if (word.starts_with('-') && exponent > 0) exponent = -exponent;
        exponent = std::clamp(exponent, -farther_than_any_text, farther_than_any_text);
    }
    return exponent + point - first > 0;
}

}  // namespace

std::optional<double> read_double(std::string_view text) {
    text = without_plus(text);
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (stop != text.data() + text.size()) return std::nullopt;
    if (error == std::errc::result_out_of_range) {
        value = is_huge(text) ? std::numeric_limits<double>::infinity() : 0.0;
        return text.starts_with('-') ? -value : value;
    }
    if (error != std::errc{}) return std::nullopt;
    return value;
}

bool has_decimal_comma(std::string_view text) {
    for (auto at = text.find(','); at != std::string_view::npos; at = text.find(',', at + 1)) {
        if (at > 0 && at + 1 < text.size() && is_digit(text[at - 1]) && is_digit(text[at + 1])) return true;
    }
    return false;
}

std::optional<std::int64_t> read_int64(std::string_view text) {
    return read_integer<std::int64_t>(text);
}
std::optional<std::uint64_t> read_uint64(std::string_view text) {
    return read_integer<std::uint64_t>(text);
}

std::string to_text(double value) {
    if (std::isnan(value)) return "nan";
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    return {digits, end};
}

// Overlong forms, surrogates and numbers above 0x10ffff are no characters.
std::size_t utf8_length(std::string_view text) {
    const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u; };
    const unsigned first = byte(0), second = byte(1);
    const std::size_t length = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    if (length < 2 || length > text.size() || first > 0xf4)
        return length == 1 ? std::min<std::size_t>(text.size(), 1) : 0;
    for (std::size_t k = 1; k < length; ++k)
        if (byte(k) >> 6 != 2) return 0;
    const bool good = (first != 0xe0 || second >= 0xa0) && (first != 0xed || second < 0xa0) &&
                      (first != 0xf0 || second >= 0x90) && (first != 0xf4 || second < 0x90);
    return good ? length : 0;
}

bool is_utf8(std::string_view text) {
    while (!text.empty()) {
        const std::size_t length = utf8_length(text);
        if (length == 0) return false;
        text.remove_prefix(length);
    }
    return true;
}

std::string in_quotes(std::string_view text) {
    constexpr std::size_t longest = 60;
    constexpr char hex[] = "0123456789abcdef";
    std::string result = "'";
    std::size_t at = 0;
    while (at < std::min(text.size(), longest)) {
        const std::size_t length = utf8_length(text.substr(at));
        const auto byte = static_cast<unsigned char>(text[at]);
        if (length == 0 || byte < 0x20 || byte == 0x7f) {
            result += {'\\', 'x', hex[byte >> 4], hex[byte & 15]};
        } else {
            result += text.substr(at, length);
        }
        at += std::max<std::size_t>(length, 1);
    }
    if (at < text.size()) result += "...";
    return result + "'";
}

}  // namespace clvotess
