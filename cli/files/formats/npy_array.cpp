#include "files/formats/npy_array.hpp"

#include <algorithm>
#include <bit>
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

static_assert(std::endian::native == std::endian::little, "arrays are read without conversion");

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
    if (type_ == ">f8" || type_ == ">f4") {
        throw error("big-endian numbers (" + in_quotes(type_) +
                    ") are not supported: save points.astype(\"<f8\") instead");
    }
    if (!is_float()) {
        throw error("array of type " + in_quotes(type_) + ", expected float64 or float32: save points.astype(float)");
    }
    std::string expected;
    for (const std::size_t count : columns) {
        if (has_columns(count)) return;
        expected += (expected.empty() ? "(N, " : " or (N, ") + std::to_string(count) + ")";
    }
    throw error("array of shape " + shape_text() + ", expected " + expected);
}

void NpyArray::check_size(std::size_t item_size) const {
    if (count_ <= bytes_ / item_size && bytes_ == count_ * item_size) return;
    const std::uint64_t columns = has_columns(3) || has_columns(2) ? shape_[1] : 1;
    throw error("the header announces " + std::to_string(count_ / columns) + (columns > 1 ? " points" : " numbers") +
                " of " + std::to_string(columns * item_size) + " bytes, but " + std::to_string(bytes_) +
                " bytes follow");
}

// Reads through a small buffer, so that the array is never in memory twice.
template <typename Number, typename Take>
void NpyArray::next(std::uint64_t count, Take take) {
    std::vector<Number> buffer(std::min<std::uint64_t>(count, std::uint64_t{1} << 16));
    for (std::uint64_t done = 0; done < count;) {
        throw_if_interrupted();
        const auto some = std::min<std::uint64_t>(buffer.size(), count - done);
        source_.read(buffer.data(), some * sizeof(Number));
        for (std::uint64_t i = 0; i < some; ++i, ++done) take(done, buffer[i]);
    }
}

template <typename Number, typename Take>
void NpyArray::each(Take take) {
    check_size(sizeof(Number));
    const std::uint64_t columns = shape_.size() == 2 ? shape_[1] : 1;
    next<Number>(count_, [&](std::uint64_t done, Number value) {
        const std::uint64_t rows = count_ / columns;
        take(column_major_ ? done % rows * columns + done / rows : done, value);
    });
}

template <typename Number>
void NpyArray::rows(std::vector<double>& to, std::uint64_t begin, std::uint64_t end) {
    check_size(sizeof(Number));
    const std::uint64_t columns = shape_[1], rows = shape_[0], taken = end - begin;
    to.resize(columns * taken);
    const auto skip = [&](std::uint64_t numbers) { source_.skip(numbers * sizeof(Number)); };
    if (!column_major_) {
        skip(columns * begin);
        next<Number>(columns * taken, [&](std::uint64_t k, Number value) { to[k] = value; });
        return;
    }
    for (std::uint64_t c = 0; c < columns; ++c) {
        skip(begin);
        next<Number>(taken, [&](std::uint64_t i, Number value) { to[columns * i + c] = value; });
        skip(rows - end);
    }
}

void NpyArray::read_rows(std::vector<double>& to, std::uint64_t begin, std::uint64_t end) {
    if (type_ == "<f8")
        rows<double>(to, begin, end);
    else
        rows<float>(to, begin, end);
}

void NpyArray::read_floats(std::vector<double>& to, std::size_t offset, std::size_t stride) {
    check_size(type_ == "<f4" ? sizeof(float) : sizeof(double));
    if (count_ > 0 && to.size() < offset + stride * (count_ - 1) + 1) {
        to.resize(offset + stride * (count_ - 1) + 1);
    }
    if (type_ == "<f8" && !column_major_ && stride == 1) {
        source_.read(to.data() + offset, bytes_);
        return;
    }
    const auto take = [&](std::uint64_t k, auto value) { to[offset + stride * k] = value; };
    if (type_ == "<f8") {
        each<double>(take);
    } else {
        each<float>(take);
    }
}

void NpyArray::read_next(std::uint64_t rows, std::vector<double>& to) {
    check_size(type_ == "<f4" ? sizeof(float) : sizeof(double));
    if (column_major_ && shape_[0] > 1)
        throw error("the array is stored column by column: save np.ascontiguousarray(points) to read it in pieces");
    const auto columns = static_cast<std::size_t>(shape_[1]);
    to.resize(columns * std::min(rows, shape_[0] - done_));
    done_ += to.size() / columns;
    if (type_ == "<f8") return source_.read(to.data(), to.size() * sizeof(double));
    std::vector<float> numbers(to.size());
    source_.read(numbers.data(), numbers.size() * sizeof(float));
    std::copy(numbers.begin(), numbers.end(), to.begin());
}

std::vector<std::int64_t> NpyArray::read_whole() {
    std::vector<std::int64_t> values;
    const auto take = [&](std::uint64_t k, auto value) {
        if constexpr (std::is_same_v<decltype(value), std::uint64_t>) {
            if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
                throw error("number " + std::to_string(k) + " = " + std::to_string(value) + " is too large for int64");
            }
        }
        values[k] = static_cast<std::int64_t>(value);
    };
    check_size(type_[2] == '8' ? 8 : type_[2] == '4' ? 4 : 1);
    values.resize(count_);
    if (type_[0] == '|') {
        each<std::uint8_t>(take);
    } else if (type_ == "<i8") {
        each<std::int64_t>(take);
    } else if (type_ == "<u8") {
        each<std::uint64_t>(take);
    } else if (type_ == "<i4") {
        each<std::int32_t>(take);
    } else {
        each<std::uint32_t>(take);
    }
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
