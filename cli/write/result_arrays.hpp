// The arrays of a result in .npz and .h5: names, types and shapes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>
#include <votess/stream.hpp>
#include <votess/votess.hpp>

#include "files/binary_numbers.hpp"
#include "write/output.hpp"

namespace clvotess {

struct ResultArray {
    std::string_view name;
    NumberType type{};
    std::size_t columns = 1;                        // 1: shape (rows,), else (rows, columns)
    std::string_view bytes;                         // in the library's memory, row-major
    bool of_entries = false;                        // one row for each neighbor; else for each cell
    std::size_t text = 0;                           // bytes of each text, instead of numbers of `type`
    std::shared_ptr<const std::string> owner = {};  // of the bytes, if they are not the library's

    [[nodiscard]] std::size_t item() const noexcept { return text > 0 ? text : size_of(type); }
    [[nodiscard]] std::size_t rows() const noexcept { return bytes.size() / item() / columns; }
};

template <typename Number>
[[nodiscard]] constexpr NumberType type_of() {
    if constexpr (std::is_same_v<Number, double>) return NumberType::float64;
    if constexpr (std::is_same_v<Number, std::int64_t>) return NumberType::int64;
    if constexpr (std::is_same_v<Number, std::int32_t>) return NumberType::int32;
    if constexpr (std::is_same_v<Number, std::uint32_t>) return NumberType::uint32;
    if constexpr (std::is_same_v<Number, std::int8_t>) return NumberType::int8;
    return NumberType::uint8;
}

template <typename Number>
[[nodiscard]] ResultArray as_array(std::string_view name, std::span<const Number> values, std::size_t columns = 1) {
    const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    return {.name = name, .type = type_of<Number>(), .columns = columns, .bytes = bytes};
}

// Returns the arrays of `wanted`, status, duplicate_of if there are duplicates, ids if there are any, and the carried
// columns. They are views into `data`.
[[nodiscard]] std::vector<ResultArray> result_arrays(const OutputData& data);

// What holds for all rows of a result, of which pieces may be written.
struct WholeRows {
    std::size_t size = 3;  // of vectors
    bool has_ids = false, has_shifts = false, has_duplicates = false, in_mesh = false;
    bool wide = false;  // ids of seeds need 64 bits
};
// Some of the rows, counted from the first one.
struct RowRange {
    std::size_t begin, count;
};
// Returns the arrays of a piece of the rows, or of some of it, with the ids and columns of these.
[[nodiscard]] std::vector<ResultArray> result_arrays(const votess::StreamRows& piece,
                                                     const std::optional<RowRange>& range, const WholeRows& whole,
                                                     std::span<const std::int64_t> ids, const votess::Want& wanted,
                                                     const std::vector<InputColumn>& carried);

void write_npz_arrays(OutputFile& file, std::span<const ResultArray> arrays);

// Returns whether .npz and .h5 may hold an array of that name.
[[nodiscard]] bool is_result_array(std::string_view name);

// The domain: box (2, 3), periodic (3,); for a triclinic domain cell (3, 3) and origin (3,); walls (M, 4) if any. In
// the plane vectors have two components. In .h5 all except the walls are attributes of the root.
class DomainArrays {
public:
    explicit DomainArrays(const votess::Tessellation& cells);
    DomainArrays(const DomainArrays&) = delete;
    DomainArrays& operator=(const DomainArrays&) = delete;

    [[nodiscard]] const std::vector<ResultArray>& all() const noexcept { return arrays_; }

private:
    std::vector<double> box_, cell_, origin_, walls_;
    std::vector<std::uint8_t> periodic_;
    std::vector<ResultArray> arrays_;
};

// An output whose arrays are written in pieces.
class StreamedFile {
public:
    virtual ~StreamedFile() = default;
    // Adds an array of `rows` rows in total, and writes its first ones. Arrays follow the order of result_arrays().
    virtual void add(const ResultArray& first, std::uint64_t rows) = 0;
    // Writes rows of array `number`, from `row` on.
    virtual void write(std::size_t number, std::uint64_t row, const ResultArray& rows) = 0;
    // Writes the domain and attributes, and closes the file.
    virtual void finish(const votess::Tessellation& domain, const std::vector<Attribute>& attributes) = 0;
};

}  // namespace clvotess
