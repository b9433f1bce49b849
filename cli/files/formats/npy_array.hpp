// One array in NumPy's .npy layout, versions 1 to 3: magic, version, header length, header (a Python dict), raw array.
// The source of bytes is a file or a member of an archive.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "failure.hpp"
#include "files/binary_numbers.hpp"

namespace clvotess {

// A source of `size` bytes, read front to back. `read` throws when fewer remain. `skip` may be missing.
struct ByteSource {
    std::uint64_t size = 0;
    std::function<void(void* to, std::uint64_t count)> read;
    std::function<void(std::uint64_t count)> skip = {};
};

class NpyArray {
public:
    // Reads the header. `name` is for messages. Throws Failure.
    NpyArray(ByteSource source, std::string name);

    [[nodiscard]] const std::vector<std::uint64_t>& shape() const noexcept { return shape_; }
    [[nodiscard]] bool has_columns(std::uint64_t count) const noexcept {
        return shape_.size() == 2 && shape_[1] == count;
    }
    [[nodiscard]] bool is_column() const noexcept { return shape_.size() == 1; }  // (N,)
    [[nodiscard]] bool is_number() const noexcept { return number_.has_value(); }
    [[nodiscard]] bool is_float() const noexcept { return number_ && clvotess::is_float(*number_); }
    [[nodiscard]] bool is_whole() const noexcept { return number_ && !clvotess::is_float(*number_); }
    [[nodiscard]] bool is_flags() const noexcept { return type_ == "|b1"; }
    [[nodiscard]] std::string shape_text() const;

    // Reads all values of an array of numbers, in row-major order. Value k goes to to[offset + stride k]. Call it once.
    void read_numbers(std::vector<double>& to, std::size_t offset = 0, std::size_t stride = 1);
    // Reads the rows begin to end of an array (N, K) of numbers. The source must skip. Call it once.
    void read_rows(std::vector<double>& to, std::uint64_t begin, std::uint64_t end);
    // Reads the next rows of points, up to a number. Throws Failure for an array that is stored column by column.
    void read_next(std::uint64_t rows, std::vector<double>& to);
    // Reads all values of an array of whole numbers. Call it once.
    [[nodiscard]] std::vector<std::int64_t> read_whole();
    // Throws Failure unless the array is (N, K) of floats, for one of these K.
    void check_points(std::span<const std::size_t> columns) const;

private:
    [[nodiscard]] Failure error(const std::string& message) const;
    void parse_header(std::string_view dict);
    void check_size() const;
    [[nodiscard]] bool is_float64() const { return number_ == NumberType::float64 && !swapped_; }
    template <typename Take>
    void next(std::uint64_t count, Take take);
    template <typename Take>
    void each(Take take);

    ByteSource source_;
    std::string name_;
    std::string type_;                  // such as <f8
    std::optional<NumberType> number_;  // none for other types than those of numbers
    bool swapped_ = false;              // in the other order of bytes
    bool column_major_ = false;
    std::vector<std::uint64_t> shape_;
    std::uint64_t count_ = 1;
    std::uint64_t bytes_ = 0;  // after the header
    std::uint64_t done_ = 0;   // rows read by read_rows()
};

// Returns the header of an array in C order. type: such as "<i4".
[[nodiscard]] std::string npy_header(std::string_view type, std::span<const std::uint64_t> shape);

}  // namespace clvotess
