#include "core/packed.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace votess {
namespace {

constexpr unsigned step_bits = 7;  // in a byte; the highest says that another follows

std::size_t bytes_of_step(std::uint64_t step) {
    return (static_cast<std::size_t>(std::bit_width(step | 1)) + step_bits - 1) / step_bits;
}

}  // namespace

bool PackedHead::is_valid() const {
    if (is_plain()) return size == count * each;
    const bool is_integer = std::has_single_bit(each) && each <= sizeof(std::uint64_t);
    switch (form) {
        case Form::bytes:
            return is_integer && width < each && size == count * width;
        case Form::steps:
            return is_integer && size >= count;
        case Form::singles:
            return each == sizeof(double) && size == count * sizeof(float);
    }
    return false;
}

template <class T>
PackedHead pack_integers(std::span<const T> values, std::vector<std::byte>& bytes) {
    PackedHead head{.count = values.size(), .each = sizeof(T)};
    if (values.empty()) return head;
    T least = values[0], most = values[0];
    bool ascend = true;
    for (std::size_t i = 1; i < values.size(); ++i) {
        least = std::min(least, values[i]);
        most = std::max(most, values[i]);
        ascend = ascend && values[i] >= values[i - 1];
    }
    const auto wide = [](T value) { return static_cast<std::uint64_t>(value); };  // differences may wrap around
    head.first = wide(least);
    head.width = static_cast<std::uint16_t>((std::bit_width(wide(most) - wide(least)) + 7) / 8);
    head.size = head.count * head.width;
    if (ascend) {
        std::uint64_t size = 1;
        for (std::size_t i = 1; i < values.size() && size < head.size; ++i)
            size += bytes_of_step(wide(values[i]) - wide(values[i - 1]));
        if (size < head.size) {
            head.form = PackedHead::Form::steps;
            head.width = 0;
            head.size = size;
        }
    }
    if (head.is_plain()) {
        head.first = 0;
        return head;
    }
    bytes.resize(static_cast<std::size_t>(head.size));
    std::byte* to = bytes.data();
    if (head.form == PackedHead::Form::bytes) {
        for (const T value : values) {
            const std::uint64_t rest = wide(value) - head.first;
            for (unsigned k = 0; k < head.width; ++k) *to++ = static_cast<std::byte>(rest >> 8 * k);
        }
        return head;
    }
    std::uint64_t last = head.first;
    for (const T value : values) {
        std::uint64_t step = wide(value) - last;
        last = wide(value);
        for (; step >> step_bits != 0; step >>= step_bits) *to++ = static_cast<std::byte>(step | 1u << step_bits);
        *to++ = static_cast<std::byte>(step);
    }
    return head;
}

template PackedHead pack_integers(std::span<const std::int8_t>, std::vector<std::byte>&);
template PackedHead pack_integers(std::span<const std::uint8_t>, std::vector<std::byte>&);
template PackedHead pack_integers(std::span<const std::int32_t>, std::vector<std::byte>&);
template PackedHead pack_integers(std::span<const std::uint32_t>, std::vector<std::byte>&);
template PackedHead pack_integers(std::span<const std::int64_t>, std::vector<std::byte>&);
template PackedHead pack_integers(std::span<const std::uint64_t>, std::vector<std::byte>&);

PackedHead pack_reals(std::span<const double> values, std::vector<std::byte>& bytes) {
    const PackedHead plain{
        .count = values.size(), .size = values.size_bytes(), .each = sizeof(double), .width = sizeof(double)};
    const auto is_single = [](double value) {
        return std::bit_cast<std::uint64_t>(static_cast<double>(static_cast<float>(value))) ==
               std::bit_cast<std::uint64_t>(value);
    };
    if (!std::ranges::all_of(values, is_single)) return plain;
    bytes.resize(values.size() * sizeof(float));
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto single = static_cast<float>(values[i]);
        std::memcpy(bytes.data() + sizeof single * i, &single, sizeof single);
    }
    return {.count = values.size(), .size = bytes.size(), .each = sizeof(double), .form = PackedHead::Form::singles};
}

template <class T>
Unpacker::Done Unpacker::unpack_integers(std::span<const std::byte> from, std::size_t count, std::byte* to) {
    const std::byte* byte = from.data();
    const std::byte* const end = byte + from.size();
    std::size_t done = 0;
    if (head_.form == PackedHead::Form::bytes) {
        const unsigned width = head_.width;
        if (width > 0) count = std::min(count, from.size() / width);
        for (; done < count; ++done) {
            std::uint64_t rest = 0;
            for (unsigned k = 0; k < width; ++k) rest |= static_cast<std::uint64_t>(*byte++) << 8 * k;
            const T value = static_cast<T>(head_.first + rest);
            std::memcpy(to + sizeof(T) * done, &value, sizeof(T));
        }
        return {static_cast<std::size_t>(byte - from.data()), sizeof(T) * done};
    }
    constexpr unsigned more = 1u << step_bits, longest = 63;
    while (done < count) {
        std::uint64_t step = 0;
        const std::byte* next = byte;
        for (unsigned shift = 0;; shift += step_bits) {
            if (next == end || shift > longest) return {static_cast<std::size_t>(byte - from.data()), sizeof(T) * done};
            const auto bits = static_cast<unsigned>(*next++);
            step |= static_cast<std::uint64_t>(bits & (more - 1)) << shift;
            if ((bits & more) == 0) break;
        }
        byte = next;
        const T value = static_cast<T>(at_ += step);
        std::memcpy(to + sizeof(T) * done++, &value, sizeof(T));
    }
    return {static_cast<std::size_t>(byte - from.data()), sizeof(T) * done};
}

Unpacker::Done Unpacker::unpack(std::span<const std::byte> from, std::span<std::byte> to) {
    Done done{};
    auto count = static_cast<std::size_t>(std::min<std::uint64_t>(values_, to.size() / head_.each));
    if (head_.is_plain()) {
        done.used = done.written = std::min(count, from.size() / head_.each) * head_.each;
        std::copy_n(from.data(), done.used, to.data());
    } else if (head_.form == PackedHead::Form::singles) {
        count = std::min(count, from.size() / sizeof(float));
        for (std::size_t i = 0; i < count; ++i) {
            float single = 0;
            std::memcpy(&single, from.data() + sizeof single * i, sizeof single);
            const double value = single;
            std::memcpy(to.data() + sizeof value * i, &value, sizeof value);
        }
        done = {count * sizeof(float), count * sizeof(double)};
    } else {
        switch (head_.each) {
            case 1:
                done = unpack_integers<std::uint8_t>(from, count, to.data());
                break;
            case 2:
                done = unpack_integers<std::uint16_t>(from, count, to.data());
                break;
            case 4:
                done = unpack_integers<std::uint32_t>(from, count, to.data());
                break;
            default:
                done = unpack_integers<std::uint64_t>(from, count, to.data());
        }
    }
    values_ -= done.written / head_.each;
    bytes_ -= done.used;
    return done;
}

}  // namespace votess
