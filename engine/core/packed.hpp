// Arrays of numbers in fewer bytes, without loss: for files and messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "votess/export.hpp"

namespace votess {

// Comes before the bytes of packed values.
struct VOTESS_API PackedHead {
    enum class Form : std::uint8_t {
        bytes,    // integers less `first`, in `width` bytes each; or any values as they are, width = each
        steps,    // ascending integers: the step from the one before, at first from `first`, seven bits a byte
        singles,  // float64 as float32, which holds them exactly
    };

    std::uint64_t count = 0, size = 0;  // values, and their bytes
    std::uint64_t first = 0;
    std::uint32_t each = 0;  // bytes of a value that is not packed
    std::uint16_t width = 0;
    Form form = Form::bytes;
    std::uint8_t unused = 0;  // so that no byte is undefined

    // Whether the bytes are the values.
    [[nodiscard]] bool is_plain() const { return form == Form::bytes && width == each; }
    // Whether packing can have made it.
    [[nodiscard]] bool is_valid() const;
};
static_assert(std::has_unique_object_representations_v<PackedHead>);

// Replaces `bytes` by the packed values, in the shortest form. If that is plain, `bytes` is not used.
template <class T>
VOTESS_API PackedHead pack_integers(std::span<const T> values, std::vector<std::byte>& bytes);
VOTESS_API PackedHead pack_reals(std::span<const double> values, std::vector<std::byte>& bytes);

template <class T>
PackedHead pack(std::span<const T> values, std::vector<std::byte>& bytes) {
    static_assert(std::is_trivially_copyable_v<T>);
    if constexpr (std::is_same_v<T, double>) {
        return pack_reals(values, bytes);
    } else if constexpr (std::is_integral_v<T>) {
        return pack_integers(values, bytes);
    } else if constexpr (std::is_enum_v<T> && !std::is_same_v<T, std::byte>) {
        using Integer = std::underlying_type_t<T>;
        return pack_integers(std::span(reinterpret_cast<const Integer*>(values.data()), values.size()), bytes);
    } else {
        return {.count = values.size(), .size = values.size_bytes(), .each = sizeof(T), .width = sizeof(T)};
    }
}

// Unpacks values front to back.
class VOTESS_API Unpacker {
public:
    Unpacker() = default;
    // head: valid.
    explicit Unpacker(const PackedHead& head) : head_(head), values_(head.count), bytes_(head.size), at_(head.first) {}

    [[nodiscard]] const PackedHead& head() const { return head_; }
    // Returns how many values, and bytes of them, are not unpacked yet.
    [[nodiscard]] std::uint64_t values() const { return values_; }
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
    // from: the next bytes. Unpacks whole values into `to`. Returns the numbers of bytes used and written.
    struct Done {
        std::size_t used, written;
    };
    Done unpack(std::span<const std::byte> from, std::span<std::byte> to);
    // Skips whole values that are plain.
    void skip(std::size_t bytes) {
        bytes_ -= bytes;
        values_ -= bytes / head_.each;
    }

private:
    template <class T>
    Done unpack_integers(std::span<const std::byte> from, std::size_t count, std::byte* to);

    PackedHead head_;
    std::uint64_t values_ = 0, bytes_ = 0;
    std::uint64_t at_ = 0;  // the value before the next, in steps
};

}  // namespace votess
