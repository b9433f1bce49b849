// Numbers and arrays as bytes, and back.
#pragma once

#include <cstring>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/packed.hpp"
#include "votess/votess.hpp"

namespace votess {

// Bytes that one block or rank sends to another: for the same version of votess on a machine of the same kind. An empty
// message need not be sent.
using Message = std::vector<std::byte>;

// A structure has a static function parts(), which returns references to its values as a tuple; or it has put_to() and
// get_from().
template <class T>
concept HasParts = requires(T& value) {
    T::parts(value);
};

class Writer {
public:
    template <class T>
    void put(const T& value) {
        if constexpr (requires { value.put_to(*this); }) {
            value.put_to(*this);
        } else if constexpr (HasParts<T>) {
            std::apply([&](const auto&... part) { (put(part), ...); }, T::parts(value));
        } else {
            static_assert(std::is_trivially_copyable_v<T>);
            append(std::span(&value, 1));
        }
    }
    template <class T>
    void put(const std::vector<T>& values) {
        put(static_cast<std::uint64_t>(values.size()));
        append(std::span(values));
    }
    void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
    // Puts more values of an array whose length has been put.
    template <class T, std::size_t N>
    void append(std::span<const T, N> values) {
        const auto bytes = std::as_bytes(values);
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    // Puts an array in fewer bytes, for Reader::unpack().
    template <class T>
    void pack(const std::vector<T>& values) {
        std::vector<std::byte> packed;
        const PackedHead head = votess::pack(std::span(values), packed);
        put(head);
        append(head.is_plain() ? std::as_bytes(std::span(values)) : std::span<const std::byte>(packed));
    }
    [[nodiscard]] Message take() { return std::move(bytes_); }

private:
    Message bytes_;
};

// Throws invalid_argument when the bytes do not have the form that is read.
class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    template <class T>
    void get(T& value) {
        if constexpr (requires { value.get_from(*this); }) {
            value.get_from(*this);
        } else if constexpr (HasParts<T>) {
            std::apply([&](auto&... part) { (get(part), ...); }, T::parts(value));
        } else {
            static_assert(std::is_trivially_copyable_v<T>);
            std::memcpy(&value, take(sizeof(T)), sizeof(T));
        }
    }
    template <class T>
    void get(std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        std::uint64_t count = 0;
        get(count);
        if (count > bytes_.size() / sizeof(T)) refuse();
        values.resize(count);
        if (count > 0) std::memcpy(values.data(), take(count * sizeof(T)), count * sizeof(T));
    }
    // most: the number of values that the array may have.
    template <class T>
    void unpack(std::vector<T>& values, std::uint64_t most) {
        PackedHead head;
        get(head);
        if (!head.is_valid() || head.each != sizeof(T) || head.count > most || head.size > bytes_.size()) refuse();
        values.resize(static_cast<std::size_t>(head.count));
        const auto size = static_cast<std::size_t>(head.size);
        const auto to = std::as_writable_bytes(std::span(values));
        if (Unpacker(head).unpack({take(size), size}, to).written < to.size()) refuse();
    }
    [[nodiscard]] std::size_t left() const { return bytes_.size(); }  // bytes
    void end() const {
        if (!bytes_.empty()) refuse();
    }

private:
    const std::byte* take(std::size_t count) {
        if (count > bytes_.size()) refuse();
        const std::byte* begin = bytes_.data();
        bytes_ = bytes_.subspan(count);
        return begin;
    }
    [[noreturn]] static void refuse() {
        throw Error(ErrorCode::invalid_argument, "a message between blocks was not written by this version of votess");
    }
    std::span<const std::byte> bytes_;
};

template <class... T>
Message message_of(const T&... values) {
    Writer writer;
    (writer.put(values), ...);
    return writer.take();
}
// Reads the values of message_of(). Keeps them when the message is empty.
template <class... T>
void read_message(const Message& message, T&... values) {
    if (message.empty()) return;
    Reader reader(message);
    (reader.get(values), ...);
    reader.end();
}

// No elements make an empty message.
template <class T>
Message to_message(const T& value) {
    return value.size() == 0 ? Message{} : message_of(value);
}

// One array as a message, without its length.
template <class T>
Message to_bytes(const std::vector<T>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    return {bytes.begin(), bytes.end()};
}
template <class T>
void append_bytes(const Message& message, std::vector<T>& values) {
    const std::size_t old = values.size();
    values.resize(old + message.size() / sizeof(T));
    if (!message.empty()) std::memcpy(values.data() + old, message.data(), message.size());
}

}  // namespace votess
