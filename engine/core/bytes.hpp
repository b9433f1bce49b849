// Numbers and arrays as bytes, and back.
#pragma once

#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "votess/blocks.hpp"

namespace votess::blocks {

class Writer {
public:
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        put_all(std::span(&value, 1));
    }
    template <class T>
    void put(const std::vector<T>& values) {
        put(static_cast<std::uint64_t>(values.size()));
        put_all(std::span(values));
    }
    void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
    // Appends to an array whose length has been written.
    template <class T>
    void append(std::span<const T> values) {
        put_all(values);
    }
    [[nodiscard]] Message take() { return std::move(bytes_); }

private:
    template <class T, std::size_t N>
    void put_all(std::span<const T, N> values) {
        const auto bytes = std::as_bytes(values);
        bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    }
    Message bytes_;
};

// Throws invalid_argument if the bytes do not match the types read.
class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    template <class T>
    void get(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        std::memcpy(&value, take(sizeof(T)), sizeof(T));
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
        throw Error(ErrorCode::invalid_argument,
                    "a message between blocks is damaged or from another version: run the same version everywhere");
    }
    std::span<const std::byte> bytes_;
};

}  // namespace votess::blocks
