// Collects text and binary numbers, and passes them on in large pieces.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

namespace votess::files {

class ByteSink {
public:
    // total: bytes of the whole file; 0 when unknown. file: its path, for formats of several files; else empty.
    using Write = std::function<void(std::string_view bytes, std::uint64_t total, const std::string& file)>;

    explicit ByteSink(Write write) : write_(std::move(write)) {}

    void set_total(std::uint64_t total) { total_ = total; }
    // Begins the next of several files.
    void begin_file(std::string path) {
        flush();
        file_ = std::move(path);
    }

    void put(std::string_view bytes) {
        if (bytes.size() + bytes_.size() > piece) flush();
        if (bytes.size() > piece) return write_(bytes, total_, file_);  // no copy of a large array
        bytes_ += bytes;
    }
    // Writes the shortest text that reads back as the same number.
    template <class Number>
    void put_number(Number value) {
        std::array<char, 32> text{};
        put({text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr});
    }
    // Writes a value as it lies in memory.
    template <class Value>
    void put_binary(const Value& value) {
        put({reinterpret_cast<const char*>(&value), sizeof value});
    }
    void flush() {
        if (!bytes_.empty()) write_(bytes_, total_, file_);
        bytes_.clear();
    }

private:
    static constexpr std::size_t piece = std::size_t{1} << 20;

    Write write_;
    std::string bytes_, file_;
    std::uint64_t total_ = 0;
};

// Writes a space and a number.
template <class Number>
void put_next(ByteSink& out, Number number) {
    out.put(" ");
    out.put_number(number);
}

}  // namespace votess::files
