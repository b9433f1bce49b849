// NumPy's .npy, versions 1 to 3: magic, version, length of the header, header (a Python dict), raw array.
#include <bit>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>

#include "failure.hpp"
#include "input.hpp"
#include "numbers.hpp"

namespace clvotess {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are read as they lie in the file");

struct Header {
    std::string type;  // such as <f8
    bool column_major = false;
    std::uint64_t rows = 0;
};

class NpyReader {
public:
    explicit NpyReader(const std::string& path) : path_(path), stream_(path, std::ios::binary) {
        if (!stream_) throw bad_input("cannot open " + in_quotes(path) + ": " + std::strerror(errno));
        std::error_code problem;
        size_ = std::filesystem::file_size(path, problem);
        if (problem) throw error("not a regular file");
    }

    Input read() {
        const Header header = read_header();
        if (header.type == "<f8") return read_array<double>(header);
        if (header.type == "<f4") return read_array<float>(header);
        if (header.type == ">f8" || header.type == ">f4") {
            throw error("big-endian numbers (" + in_quotes(header.type) +
                        ") are not supported: save points.astype(\"<f8\") instead");
        }
        throw error("array of type " + in_quotes(header.type) +
                    ", expected float64 or float32: save points.astype(float)");
    }

private:
    [[nodiscard]] Failure error(const std::string& message) const { return bad_input(path_ + ": " + message); }

    void read_bytes(void* to, std::uint64_t count) {
        stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
        if (!stream_) throw error("the file ends too early");
    }

    Header read_header() {
        unsigned char start[8];
        if (size_ < 10) throw error("not a .npy file");
        read_bytes(start, sizeof start);
        if (std::memcmp(start, "\x93NUMPY", 6) != 0) throw error("not a .npy file");
        if (start[6] < 1 || start[6] > 3) throw error(".npy version " + std::to_string(start[6]) + " is not known");
        const unsigned length_bytes = start[6] == 1 ? 2 : 4;
        std::uint32_t length = 0;
        read_bytes(&length, length_bytes);
        data_begin_ = sizeof start + length_bytes + std::uint64_t{length};
        if (data_begin_ > size_) throw error("the file ends too early");
        std::string text(length, '\0');
        read_bytes(text.data(), length);
        return parse_header(text);
    }

    // The text after `'key':`, blanks skipped.
    std::string_view value_of(std::string_view dict, std::string_view key) const {
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
    }

    Header parse_header(std::string_view dict) const {
        Header header;
        const std::string_view type = value_of(dict, "descr");
        if (type[0] == '[') throw error("an array of records, expected an array of float64 with shape (N, 3)");
        const auto type_end = type.find(type[0], 1);
        if ((type[0] != '\'' && type[0] != '"') || type_end == std::string_view::npos) {
            throw error("cannot read the type in the header");
        }
        header.type = type.substr(1, type_end - 1);

        const std::string_view order = value_of(dict, "fortran_order");
        header.column_major = order.starts_with("True");
        if (!header.column_major && !order.starts_with("False")) throw error("cannot read the order in the header");

        const std::string_view shape_value = value_of(dict, "shape");
        const auto shape_end = shape_value.find(')');
        if (shape_value[0] != '(' || shape_end == std::string_view::npos) {
            throw error("cannot read the shape in the header");
        }
        const std::string_view shape = shape_value.substr(0, shape_end + 1);
        const auto comma = shape.find(',');
        const std::string_view tail = shape.substr(std::min(comma, shape.size()));
        const auto rows = read_uint64(shape.substr(1, std::min(comma, shape.size()) - 1));
        if (!rows || (tail != ", 3)" && tail != ",3)" && tail != ", 3,)")) {
            throw error("array of shape " + std::string(shape) + ", expected (N, 3)");
        }
        header.rows = *rows;
        return header;
    }

    template <typename Number>
    Input read_array(const Header& header) {
        const std::uint64_t bytes = size_ - data_begin_;
        if (header.rows > bytes / (3 * sizeof(Number)) || bytes != header.rows * 3 * sizeof(Number)) {
            throw error("the header announces " + std::to_string(header.rows) + " points of " +
                        std::to_string(3 * sizeof(Number)) + " bytes, but " + std::to_string(bytes) + " bytes follow");
        }
        Input input;
        input.points.resize(3 * header.rows);
        if constexpr (std::is_same_v<Number, double>) {
            if (!header.column_major) {
                read_bytes(input.points.data(), bytes);
                return input;
            }
        }
        // Widen or reorder through a small buffer, so that the file is never in memory twice.
        std::vector<Number> buffer(std::min<std::uint64_t>(3 * header.rows, std::uint64_t{1} << 16));
        for (std::uint64_t done = 0; done < 3 * header.rows;) {
            const auto count = std::min<std::uint64_t>(buffer.size(), 3 * header.rows - done);
            read_bytes(buffer.data(), count * sizeof(Number));
            for (std::uint64_t i = 0; i < count; ++i, ++done) {
                const std::uint64_t to = header.column_major ? done % header.rows * 3 + done / header.rows : done;
                input.points[to] = buffer[i];
            }
        }
        return input;
    }

    std::string path_;
    std::ifstream stream_;
    std::uint64_t size_ = 0;
    std::uint64_t data_begin_ = 0;
};

}  // namespace

Input read_npy(const std::string& path) {
    return NpyReader(path).read();
}

}  // namespace clvotess
