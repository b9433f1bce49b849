// The common part of all .glb files: the binary form of glTF 2.0 (ISO/IEC 12113).
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <limits>
#include <string>
#include <votess/votess.hpp>

#include "core/errors.hpp"
#include "files/byte_sink.hpp"

namespace votess::files {

inline constexpr std::uint64_t largest_glb = std::numeric_limits<std::uint32_t>::max();  // the format counts in 32 bits
inline constexpr std::uint64_t short_vertices = 65535;                                   // 65535 itself is not an index

inline std::uint64_t in_words(std::uint64_t bytes) {
    return (bytes + 3) / 4 * 4;
}

template <class Number>
std::string text_of(const std::array<Number, 3>& numbers) {
    std::string text;
    for (const Number number : numbers) {
        std::array<char, 32> digits{};
        const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
        text.append(text.empty() ? "[" : ",").append(std::string_view(digits.data(), end));
    }
    return text + "]";
}

inline void add_to_list(std::string& list, const std::string& item) {
    list.append(list.empty() ? "" : ",").append(item);
}

// Returns a place with y up, as glTF demands: z becomes y, and y becomes -z. That is a rotation, so faces keep their
// fronts.
template <class Number>
std::array<Number, 3> with_y_up(double x, double y, double z) {
    return {static_cast<Number>(x), static_cast<Number>(z), static_cast<Number>(0 - y)};
}

// The arrays of a file, as the lists of its head.
class GltfArrays {
public:
    // Returns the number of an array. type: the rest of its accessor.
    std::string add(std::uint64_t count, std::uint64_t bytes, bool of_vertices, const std::string& type) {
        add_to_list(views_, R"({"buffer":0,"byteOffset":)" + std::to_string(bytes_) + ",\"byteLength\":" +
                                std::to_string(bytes) + ",\"target\":" + (of_vertices ? "34962}" : "34963}"));
        add_to_list(accessors_, "{\"bufferView\":" + std::to_string(count_) + ",\"count\":" + std::to_string(count) +
                                    "," + type + "}");
        bytes_ += in_words(bytes);
        return std::to_string(count_++);
    }
    std::string add_positions(std::uint64_t count, const std::array<float, 3>& lower,
                              const std::array<float, 3>& upper) {
        return add(count, 12 * count, true,
                   R"("componentType":5126,"type":"VEC3","min":)" + text_of(lower) + ",\"max\":" + text_of(upper));
    }
    std::string add_indices(std::uint64_t count, bool is_short) {
        return add(count, count * (is_short ? 2 : 4), false,
                   std::string("\"componentType\":") + (is_short ? "5123" : "5125") + R"(,"type":"SCALAR")");
    }
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
    // Returns the members of the head that list the arrays.
    [[nodiscard]] std::string members() const {
        return "\"accessors\":[" + accessors_ + "],\"bufferViews\":[" + views_ +
               "],\"buffers\":[{\"byteLength\":" + std::to_string(bytes_) + "}]";
    }

private:
    std::string views_, accessors_;
    std::uint64_t bytes_ = 0;
    int count_ = 0;
};

inline constexpr const char* gltf_asset =
    R"({"asset":{"version":"2.0","generator":"votess )" VOTESS_VERSION_STRING "\"}";

// Begins a file with its head. The arrays must follow. Throws invalid_argument beyond 4 GiB. remedy: what to do then.
inline void begin_glb(std::string head, std::uint64_t array_bytes, const char* remedy, ByteSink& out) {
    head.resize(in_words(head.size()), ' ');
    const std::uint64_t bytes = 20 + head.size() + (array_bytes == 0 ? 0 : 8 + array_bytes);
    if (bytes > largest_glb)
        refuse("the .glb file would take " + std::to_string((bytes + 999'999) / 1'000'000) +
               " MB, but .glb ends at 4 GiB: " + remedy);
    out.set_total(bytes);
    out.put("glTF");
    for (const std::uint64_t number : {std::uint64_t{2}, bytes, std::uint64_t{head.size()}})
        out.put_binary(static_cast<std::uint32_t>(number));
    out.put("JSON");
    out.put(head);
    if (array_bytes == 0) return;
    out.put_binary(static_cast<std::uint32_t>(array_bytes));
    out.put(std::string_view("BIN\0", 4));
}

}  // namespace votess::files
