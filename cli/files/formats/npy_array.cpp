#include "files/formats/npy_array.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>

#include "files/numbers.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

// Returns a shape as Python writes it.
std::string text_of(std::span<const std::uint64_t> shape) {
    std::string text = "(";
    for (std::size_t k = 0; k < shape.size(); ++k) text += (k > 0 ? ", " : "") + std::to_string(shape[k]);
    return text + (shape.size() == 1 ? ",)" : ")");
}

// Returns nothing unless a type such as <f8 is one of numbers.
std::optional<NumberType> number_of(std::string_view type) {
    using enum NumberType;
    constexpr std::array<std::pair<std::string_view, NumberType>, 12> types{{{"b1", uint8},
                                                                             {"i1", int8},
                                                                             {"u1", uint8},
                                                                             {"i2", int16},
                                                                             {"u2", uint16},
                                                                             {"i4", int32},
                                                                             {"u4", uint32},
                                                                             {"i8", int64},
                                                                             {"u8", uint64},
                                                                             {"f2", float16},
                                                                             {"f4", float32},
                                                                             {"f8", float64}}};
    const auto found = std::ranges::find(types, type.substr(std::min<std::size_t>(1, type.size())),
                                         [](const auto& t) { return t.first; });
    if (found == types.end() || std::string_view("<>|=").find(type[0]) == std::string_view::npos) return std::nullopt;
    return found->second;
}

constexpr const char* ends_early = "the file ends too early";

}  // namespace

NpyArray::NpyArray(ByteSource source, std::string name) : source_(std::move(source)), name_(std::move(name)) {
    unsigned char start[8];
    if (source_.size < 10) throw error("not a .npy file");
    source_.read(start, sizeof start);
    if (std::memcmp(start, "\x93NUMPY", 6) != 0) throw error("not a .npy file");
    if (start[6] < 1 || start[6] > 3) throw error(".npy version " + std::to_string(start[6]) + " is not known");
    const unsigned length_bytes = start[6] == 1 ? 2 : 4;
    if (source_.size < sizeof start + length_bytes) throw error(ends_early);
    std::uint32_t length = 0;
    source_.read(&length, length_bytes);
    constexpr std::uint32_t longest_header = std::uint32_t{1} << 16;  // NumPy itself reads 10,000 bytes
    if (length > longest_header) throw error("the header has " + std::to_string(length) + " bytes, which is too long");
    const std::uint64_t data_begin = sizeof start + length_bytes + std::uint64_t{length};
    if (data_begin > source_.size) throw error(ends_early);
    bytes_ = source_.size - data_begin;
    std::string text(length, '\0');
    source_.read(text.data(), length);
    parse_header(text);
}

Failure NpyArray::error(const std::string& message) const {
    return bad_input(name_ + ": " + message);
}

std::string NpyArray::shape_text() const {
    return text_of(shape_);
}

void NpyArray::parse_header(std::string_view dict) {
    // Returns the text after `'key':`, without blanks in front.
    const auto value_of = [&](std::string_view key) {
        for (const char quote : {'\'', '"'}) {
            const std::string name = quote + std::string(key) + quote;
            const auto at = dict.find(name);
            if (at == std::string_view::npos) continue;
            const auto colon = dict.find_first_not_of(' ', at + name.size());
            if (colon == std::string_view::npos || dict[colon] != ':') continue;
            const auto value = dict.find_first_not_of(' ', colon + 1);
            if (value != std::string_view::npos) return dict.substr(value);
        }
        throw error("the header has no '" + std::string(key) + "'");
    };
    const std::string_view type = value_of("descr");
    if (type[0] == '[') throw error("an array of records, expected an array of float64 with shape (N, 3)");
    const auto type_end = type.find(type[0], 1);
    if ((type[0] != '\'' && type[0] != '"') || type_end == std::string_view::npos) {
        throw error("cannot read the type in the header");
    }
    type_ = type.substr(1, type_end - 1);
    number_ = number_of(type_);
    swapped_ = type_.starts_with('>');

    const std::string_view order = value_of("fortran_order");
    column_major_ = order.starts_with("True");
    if (!column_major_ && !order.starts_with("False")) throw error("cannot read the order in the header");

    const std::string_view value = value_of("shape");
    const auto end = value.find(')');
    if (value[0] != '(' || end == std::string_view::npos) throw error("cannot read the shape in the header");
    std::string_view list = value.substr(1, end - 1);
    while (!list.empty()) {
        const auto comma = std::min(list.find(','), list.size());
        std::string_view word = list.substr(0, comma);
        list.remove_prefix(std::min(comma + 1, list.size()));
        word.remove_prefix(std::min(word.find_first_not_of(' '), word.size()));
        if (word.empty() && list.empty()) break;
        const auto extent = read_uint64(word);
        if (!extent) throw error("array of shape " + in_quotes(value.substr(0, end + 1)) + ", expected (N, 3)");
        if (*extent != 0 && count_ > std::numeric_limits<std::uint64_t>::max() / *extent) {
            throw error("the header announces more points than fit, shape " + in_quotes(value.substr(0, end + 1)));
        }
        constexpr std::size_t max_axes = 64;
        if (shape_.size() == max_axes) throw error("an array of more than 64 axes, expected (N, 3)");
        shape_.push_back(*extent);
        count_ *= *extent;
    }
}

void NpyArray::check_points(std::span<const std::size_t> columns) const {
    if (!is_float()) throw error("array of type " + in_quotes(type_) + ", expected floats: save points.astype(float)");
    std::string expected;
    for (const std::size_t count : columns) {
        if (has_columns(count)) return;
        expected += (expected.empty() ? "(N, " : " or (N, ") + std::to_string(count) + ")";
    }
    throw error("array of shape " + shape_text() + ", expected " + expected);
}

void NpyArray::check_size() const {
    const std::size_t item_size = size_of(*number_);
    if (count_ <= bytes_ / item_size && bytes_ == count_ * item_size) return;
    const std::uint64_t columns = has_columns(3) || has_columns(2) ? shape_[1] : 1;
    throw error("the header announces " + std::to_string(count_ / columns) + (columns > 1 ? " points" : " numbers") +
                " of " + std::to_string(columns * item_size) + " bytes, but " + std::to_string(bytes_) +
                " bytes follow");
}

// Reads through a small buffer, so that the array is never in memory twice.
template <typename Take>
void NpyArray::next(std::uint64_t count, Take take) {
    const std::size_t size = size_of(*number_);
    std::vector<char> buffer(size * std::min<std::uint64_t>(count, std::uint64_t{1} << 16));
    for (std::uint64_t done = 0; done < count;) {
        throw_if_interrupted();
        const auto bytes = std::min<std::uint64_t>(buffer.size(), size * (count - done));
        source_.read(buffer.data(), bytes);
        for (std::uint64_t i = 0; i < bytes; i += size) take(done++, &buffer[i]);
    }
}

template <typename Take>
void NpyArray::each(Take take) {
    const std::uint64_t columns = shape_.size() == 2 ? shape_[1] : 1;
    next(count_, [&](std::uint64_t done, const char* value) {
        const std::uint64_t rows = count_ / columns;
        take(column_major_ ? done % rows * columns + done / rows : done, value);
    });
}

void NpyArray::read_rows(std::vector<double>& to, std::uint64_t begin, std::uint64_t end) {
    check_size();
    const std::uint64_t columns = shape_[1], rows = shape_[0], taken = end - begin;
    to.resize(columns * taken);
    const auto skip = [&](std::uint64_t numbers) { source_.skip(numbers * size_of(*number_)); };
    const auto load = [&](const char* value) { return load_double(*number_, value, swapped_); };
    if (!column_major_) {
        skip(columns * begin);
        next(columns * taken, [&](std::uint64_t k, const char* value) { to[k] = load(value); });
        return;
    }
    for (std::uint64_t c = 0; c < columns; ++c) {
        skip(begin);
        next(taken, [&](std::uint64_t i, const char* value) { to[columns * i + c] = load(value); });
        skip(rows - end);
    }
}

void NpyArray::read_numbers(std::vector<double>& to, std::size_t offset, std::size_t stride) {
    check_size();
    if (count_ > 0 && to.size() < offset + stride * (count_ - 1) + 1) {
        to.resize(offset + stride * (count_ - 1) + 1);
    }
    if (is_float64() && !column_major_ && stride == 1) {
        source_.read(to.data() + offset, bytes_);
        return;
    }
    each([&](std::uint64_t k, const char* value) { to[offset + stride * k] = load_double(*number_, value, swapped_); });
}

void NpyArray::read_next(std::uint64_t rows, std::vector<double>& to) {
    check_size();
    if (column_major_ && shape_[0] > 1)
        throw error("the array is stored column by column: save np.ascontiguousarray(points) to read it in pieces");
    const auto columns = static_cast<std::size_t>(shape_[1]);
    to.resize(columns * std::min(rows, shape_[0] - done_));
    done_ += to.size() / columns;
    if (is_float64()) return source_.read(to.data(), to.size() * sizeof(double));
    next(to.size(), [&](std::uint64_t k, const char* value) { to[k] = load_double(*number_, value, swapped_); });
}

std::vector<std::int64_t> NpyArray::read_whole() {
    check_size();
    std::vector<std::int64_t> values(count_);
    each([&](std::uint64_t k, const char* value) {
        const auto whole = load_whole(*number_, value, swapped_);
        if (!whole)
            throw error("number " + std::to_string(k) + " = " +
                        std::to_string(load_number<std::uint64_t>(value, swapped_)) + " is too large for int64");
        values[k] = *whole;
    });
    return values;
}

std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape) {
    std::string dict =
        "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': " + text_of(shape) + ", }";
    constexpr std::size_t start_size = 10, alignment = 64;
    const std::size_t unpadded = start_size + dict.size() + 1;
    dict.append((alignment - unpadded % alignment) % alignment, ' ');
    dict += '\n';
    std::string header("\x93NUMPY\x01\x00", 8);
    header += static_cast<char>(dict.size() & 0xff);
    header += static_cast<char>(dict.size() >> 8);
    return header + dict;
}

}  // namespace clvotess
