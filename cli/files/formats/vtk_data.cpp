#include "files/formats/vtk_data.hpp"

#include <algorithm>
#include <array>

#include "failure.hpp"
#include "files/inflate.hpp"
#include "files/line_reader.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

constexpr std::uint64_t best_ratio = 1032;                    // of deflate
constexpr std::uint64_t round_size = std::uint64_t{1} << 16;  // numbers or groups, then signals are looked at

int base64_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+') return 62;
    return c == '/' ? 63 : -1;
}

// A stream of bytes in base64, which may hold several runs that end with padding each.
class Base64 {
public:
    explicit Base64(std::string_view text) : text_(text) {}

    // Whole groups of four letters, until `count` bytes are there; then the rest of a group is dropped.
    [[nodiscard]] bool read(std::string& to, std::uint64_t count) {
        if (count > text_.size()) return false;
        to.clear();
        to.reserve(count + 2);
        while (to.size() < count) {
            if (at_ % (4 * round_size) == 0) throw_if_interrupted();
            if (at_ + 4 > text_.size()) return false;
            std::uint32_t group = 0;
            int bytes = 3;
            for (std::size_t k = 0; k < 4; ++k) {
                const char c = text_[at_ + k];
                const int value = base64_value(c);
                if (value < 0 && !(c == '=' && k >= 2)) return false;
                if (c == '=') bytes = std::min(bytes, static_cast<int>(k) - 1);
                group = group << 6 | static_cast<std::uint32_t>(std::max(value, 0));
            }
            for (int k = 0; k < bytes; ++k) to += static_cast<char>(group >> (16 - 8 * k) & 0xff);
            if (bytes < 3 && to.size() < count) return false;
            at_ += 4;
        }
        to.resize(count);
        return true;
    }

private:
    std::string_view text_;
    std::size_t at_ = 0;
};

// Either raw bytes or base64. A run begins a new group of base64, as VTK encodes the headers of packed data apart.
class Stream {
public:
    Stream(std::string_view bytes, bool base64) : rest_(bytes), base64_(base64) {}

    [[nodiscard]] bool read(std::string& to, std::uint64_t count) {
        if (!base64_) {
            if (count > rest_.size()) return false;
            to = rest_.substr(0, count);
            rest_.remove_prefix(count);
            return true;
        }
        if (count > rest_.size()) return false;
        const std::uint64_t letters = (count + 2) / 3 * 4;
        if (letters > rest_.size() || !Base64(rest_.substr(0, letters)).read(to, count)) return false;
        rest_.remove_prefix(letters);
        return true;
    }
    // The first `count` bytes, which stay.
    [[nodiscard]] bool peek(std::string& to, std::uint64_t count) const { return Stream(*this).read(to, count); }
    [[nodiscard]] std::size_t size() const noexcept { return rest_.size(); }

private:
    std::string_view rest_;
    bool base64_;
};

class Loader {
public:
    Loader(const VtkArray& array, const VtkLayout& layout, const std::string& where)
        : array_(array), layout_(layout), where_(where) {}

    // Calls take(i, bytes of number i, swapped).
    template <typename Take>
    void binary(std::uint64_t count, Take take) {
        const std::uint64_t bytes_each = size_of(array_.type);
        if (count > std::numeric_limits<std::uint64_t>::max() / bytes_each) throw damaged();
        const bool appended = array_.place == VtkArray::Place::appended;
        const std::string_view bytes = appended ? layout_.appended : array_.content;
        if (appended && array_.offset > bytes.size()) throw damaged();
        Stream stream(appended ? bytes.substr(array_.offset) : bytes, !appended || !layout_.appended_raw);
        std::string numbers;
        if (layout_.packed) {
            unpack(stream, count * bytes_each, numbers);
        } else {
            const std::size_t head = header_size();
            if (!stream.peek(numbers, head)) throw damaged();
            check_size(header(numbers, 0), count * bytes_each);
            if (!stream.read(numbers, head + count * bytes_each)) throw damaged();
            numbers.erase(0, head);
        }
        for (std::uint64_t i = 0; i < count; ++i) {
            if (i % round_size == 0) throw_if_interrupted();
            take(i, numbers.data() + i * bytes_each, layout_.swapped);
        }
    }

    template <typename Take>
    void text(std::uint64_t count, Take take) {
        std::string_view rest = array_.content;
        constexpr std::string_view blanks = " \t\r\n";
        for (std::uint64_t i = 0; i < count; ++i) {
            if (i % round_size == 0) throw_if_interrupted();
            rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
            const std::string_view word = rest.substr(0, rest.find_first_of(blanks));
            if (word.empty()) {
                throw bad_input(where_ + ": it ends after " + std::to_string(i) + " of " + std::to_string(count) +
                                " numbers");
            }
            take(i, word);
            rest.remove_prefix(word.size());
        }
        if (rest.find_first_not_of(blanks) != std::string_view::npos) {
            throw bad_input(where_ + ": more than the " + std::to_string(count) + " numbers that are announced");
        }
    }

    [[nodiscard]] Failure damaged() const { return bad_input(where_ + ": the data are damaged or end too early"); }

private:
    [[nodiscard]] std::size_t header_size() const { return layout_.wide_headers ? 8 : 4; }
    [[nodiscard]] std::uint64_t header(const std::string& bytes, std::size_t index) const {
        const char* const from = bytes.data() + index * header_size();
        return layout_.wide_headers ? load_number<std::uint64_t>(from, layout_.swapped)
                                    : load_number<std::uint32_t>(from, layout_.swapped);
    }

    void check_size(std::uint64_t found, std::uint64_t expected) const {
        if (found == expected) return;
        throw bad_input(where_ + ": " + std::to_string(found) + " bytes are there, " + std::to_string(expected) +
                        " are announced");
    }

    // Header: number of blocks, size of each but the last, size of the last if that is less, packed sizes.
    void unpack(Stream& stream, std::uint64_t expected, std::string& numbers) const {
        std::string head;
        if (!stream.peek(head, header_size())) throw damaged();
        const std::uint64_t blocks = header(head, 0);
        if (blocks > stream.size() / header_size()) throw damaged();
        if (!stream.read(head, (3 + blocks) * header_size())) throw damaged();
        const std::uint64_t block_size = header(head, 1), last_size = header(head, 2);
        std::uint64_t packed_size = 0;
        for (std::uint64_t k = 0; k < blocks; ++k) {
            const std::uint64_t size = header(head, 3 + k);
            if (size > stream.size()) throw damaged();
            packed_size += size;
            if (packed_size > stream.size()) throw damaged();
        }
        const std::uint64_t full = last_size > 0 && blocks > 0 ? blocks - 1 : blocks;
        if (last_size > expected || (block_size > 0 && full > expected / block_size)) throw damaged();
        check_size(full * block_size + (blocks > 0 ? last_size : 0), expected);
        std::string packed;
        if (expected / best_ratio > packed_size) throw damaged();
        if (!stream.read(packed, packed_size)) throw damaged();
        numbers.resize(expected);
        std::size_t from = 0, to = 0;
        for (std::uint64_t k = 0; k < blocks; ++k) {
            const std::size_t size = k < full ? block_size : last_size;
            const std::uint64_t packed_block = header(head, 3 + k);
            Inflater inflater(std::string_view(packed).substr(from, packed_block), Inflater::Frame::zlib);
            if (inflater.read(numbers.data() + to, size) < size) throw damaged();
            char beyond = 0;  // reaches the end and its checksum
            if (inflater.read(&beyond, 1) > 0 || !inflater.ended()) throw damaged();
            from += packed_block;
            to += size;
        }
    }

    const VtkArray& array_;
    const VtkLayout& layout_;
    const std::string& where_;
};

// So that a broken count takes no memory.
void check_possible(const VtkArray& array, const VtkLayout& layout, std::uint64_t count, const std::string& where) {
    const std::size_t bytes = array.place == VtkArray::Place::appended ? layout.appended.size() : array.content.size();
    const std::uint64_t most = array.place == VtkArray::Place::text ? bytes / 2 + 1
                               : layout.packed                      ? bytes * best_ratio
                                                                    : bytes / size_of(array.type) + 1;
    if (count <= most) return;
    throw bad_input(where + ": " + std::to_string(count) + " numbers are announced, but only " + std::to_string(bytes) +
                    " bytes are there");
}

}  // namespace

std::vector<double> load_floats(const VtkArray& array, const VtkLayout& layout, std::uint64_t count,
                                const std::string& where) {
    check_possible(array, layout, count, where);
    Loader loader(array, layout, where);
    std::vector<double> values(count);
    if (array.place == VtkArray::Place::text) {
        loader.text(count, [&](std::uint64_t i, std::string_view word) {
            const auto value = read_double(word);
            if (!value) throw bad_input(where + ": " + not_a_number(word));
            values[i] = *value;
        });
    } else {
        loader.binary(count, [&](std::uint64_t i, const char* from, bool swapped) {
            values[i] = load_double(array.type, from, swapped);
        });
    }
    return values;
}

std::vector<std::int64_t> load_wholes(const VtkArray& array, const VtkLayout& layout, std::uint64_t count,
                                      const std::string& where) {
    check_possible(array, layout, count, where);
    Loader loader(array, layout, where);
    std::vector<std::int64_t> values(count);
    const auto store = [&](std::uint64_t i, std::optional<std::int64_t> value) {
        if (!value) throw bad_input(where + ": number " + std::to_string(i) + " is no whole number of 64 bits");
        values[i] = *value;
    };
    if (array.place == VtkArray::Place::text) {
        loader.text(count, [&](std::uint64_t i, std::string_view word) { store(i, read_int64(word)); });
    } else {
        loader.binary(count, [&](std::uint64_t i, const char* from, bool swapped) {
            store(i, load_whole(array.type, from, swapped));
        });
    }
    return values;
}

}  // namespace clvotess
