// A buffer of fixed size in front of an OutputFile, for text and for binary numbers.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "files/atomic_file.hpp"

namespace clvotess {

class OutputBuffer {
public:
    explicit OutputBuffer(OutputFile& file) : file_(file), bytes_(capacity, '\0') {}

    void put(std::string_view text) {
        if (text.empty()) return;
        if (text.size() > capacity - used_) flush();
        if (text.size() > capacity) return file_.write(text);
        std::memcpy(bytes_.data() + used_, text.data(), text.size());
        used_ += text.size();
    }

    void put(char c) {
        make_room();
        bytes_[used_++] = c;
    }

    // Numbers that are no whole ones get at most so many digits, as %g prints them; else as few as read back the same.
    void set_digits(int digits) { digits_ = digits; }

    // Writes a number as text.
    template <typename Number>
    void put_number(Number value) {
        make_room();
        if constexpr (std::is_floating_point_v<Number>) {
            if (std::isnan(value)) return put(std::string_view("nan"));  // never -nan
        }
        char* const begin = bytes_.data() + used_;
        char* end = nullptr;
        if constexpr (std::is_floating_point_v<Number>) {
            end = digits_ > 0
                      ? std::to_chars(begin, begin + longest_number, value, std::chars_format::general, digits_).ptr
                      : std::to_chars(begin, begin + longest_number, value).ptr;
        } else {
            end = std::to_chars(begin, begin + longest_number, value).ptr;
        }
        used_ += static_cast<std::size_t>(end - begin);
    }

    void put_three(double x, double y, double z, char between = ' ') {
        put_number(x);
        put(between);
        put_number(y);
        put(between);
        put_number(z);
    }

    // Writes a value as it lies in memory.
    template <typename Number>
    void put_binary(Number value) {
        make_room();
        std::memcpy(bytes_.data() + used_, &value, sizeof value);
        used_ += sizeof value;
    }

    void flush() {
        file_.write(std::string_view(bytes_.data(), used_));
        used_ = 0;
    }

private:
    static constexpr std::size_t capacity = std::size_t{1} << 20;
    static constexpr std::size_t longest_number = 32;

    void make_room() {
        if (capacity - used_ < longest_number) flush();
    }

    OutputFile& file_;
    std::string bytes_;
    std::size_t used_ = 0;
    int digits_ = 0;
};

}  // namespace clvotess
