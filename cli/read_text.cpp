// Text rows `x y z` or `id x y z`, and the classic XYZ layout.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <optional>

#include "failure.hpp"
#include "input.hpp"
#include "numbers.hpp"

namespace clvotess {
namespace {

constexpr std::size_t kept_fields = 6;  // one more than any layout has

// The fields of one line. `count` may exceed the number of fields kept.
struct Row {
    std::array<std::string_view, kept_fields> fields;
    std::size_t count = 0;
};

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
bool is_mark(char c) {
    return c == ',' || c == ';';
}
bool ends_field(char c) {
    return is_blank(c) || is_mark(c) || c == '#';
}

class TextReader {
public:
    TextReader(std::string_view text, TextKind kind, const std::string& name) : rest_(text), kind_(kind), name_(name) {
        if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);  // byte order mark of UTF-8
    }

    Input read() {
        Row row;
        if (!next_row(row)) return {};
        if (kind_ == TextKind::xyz && row.count == 1 && read_uint64(row.fields[0])) return read_classic(row.fields[0]);
        Row header;
        if (kind_ == TextKind::csv && is_header(row)) {
            header = row;
            if (!next_row(row)) return {};
        }
        return read_rows(row, header);
    }

private:
    [[nodiscard]] Failure error(const std::string& message) const {
        return bad_input(name_ + ":" + std::to_string(line_) + ": " + message);
    }

    bool next_line(std::string_view& line) {
        if (rest_.empty()) return false;
        const auto end = std::min(rest_.find('\n'), rest_.size());
        line = rest_.substr(0, end);
        rest_.remove_prefix(std::min(end + 1, rest_.size()));
        ++line_;
        return true;
    }

    // The next line that holds any field.
    bool next_row(Row& row) {
        std::string_view line;
        while (next_line(line)) {
            split(line, row);
            if (row.count > 0) return true;
        }
        return false;
    }

    // Between two fields: blanks, with at most one comma or semicolon among them.
    void split(std::string_view line, Row& row) const {
        row.count = 0;
        const char* at = line.data();
        const char* const end = at + line.size();
        const auto skip_blanks = [&] {
            while (at != end && is_blank(*at)) ++at;
            return at == end || *at == '#';
        };
        while (!skip_blanks()) {
            if (is_mark(*at)) {
                if (row.count > 0) ++at;
                if (skip_blanks() || is_mark(*at)) throw error("column " + std::to_string(row.count + 1) + " is empty");
            }
            const char* const begin = at;
            while (at != end && !ends_field(*at)) ++at;
            if (row.count < kept_fields) row.fields[row.count] = {begin, static_cast<std::size_t>(at - begin)};
            ++row.count;
        }
    }

    static bool is_header(const Row& row) {
        const auto kept = std::min(row.count, kept_fields);
        return std::none_of(row.fields.begin(), row.fields.begin() + static_cast<std::ptrdiff_t>(kept),
                            [](std::string_view field) { return read_double(field).has_value(); });
    }

    // A line of names that puts x elsewhere than we would read it must not pass in silence.
    void check_header(const Row& header, std::size_t columns) const {
        if (header.count != columns) return;
        for (std::size_t column = 0; column < columns; ++column) {
            std::string_view name = header.fields[column];
            if (name.size() > 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
            if (name.size() != 1) continue;
            const auto axis = std::string_view("xyz").find(static_cast<char>(std::tolower(name[0])));
            if (axis == std::string_view::npos || column == columns - 3 + axis) continue;
            throw error("the line of names has " + in_quotes(name) + " in column " + std::to_string(column + 1) +
                        ", but the columns must be x y z or id x y z");
        }
    }

    double coordinate(std::string_view field) const {
        if (const auto value = read_double(field)) return *value;
        throw error(in_quotes(field) + " is not a number");
    }

    void append_position(const Row& row, std::size_t first, Input& input) const {
        for (std::size_t axis = 0; axis < 3; ++axis) input.points.push_back(coordinate(row.fields[first + axis]));
    }

    void reserve(Input& input, bool with_ids) const {
        const auto rows = 1 + static_cast<std::size_t>(std::count(rest_.begin(), rest_.end(), '\n')) + 1;
        input.points.reserve(3 * rows);
        if (with_ids) input.ids.reserve(rows);
    }

    Input read_rows(Row row, const Row& header) {
        const std::size_t columns = row.count;
        if (columns == 5) {
            throw error("5 columns are id x y z r, but this version does not support radii: remove the last column");
        }
        if (columns != 3 && columns != 4) {
            throw error("this row has " + std::to_string(columns) + (columns == 1 ? " column" : " columns") +
                        ", expected 3 (x y z) or 4 (id x y z)");
        }
        check_header(header, columns);
        const bool with_ids = columns == 4;
        Input input;
        reserve(input, with_ids);
        do {
            if (row.count != columns) {
                throw error("this row has " + std::to_string(row.count) + (row.count == 1 ? " column" : " columns") +
                            ", the rows before it have " + std::to_string(columns));
            }
            if (with_ids) {
                const auto id = read_int64(row.fields[0]);
                if (!id)
                    throw error(in_quotes(row.fields[0]) +
                                " is not a whole number, as an id must be (columns id x y z)");
                input.ids.push_back(*id);
            }
            append_position(row, with_ids ? 1 : 0, input);
        } while (next_row(row));
        return input;
    }

    // Count, one line of comment, then `Element x y z` that many times.
    Input read_classic(std::string_view count_field) {
        const std::uint64_t count = *read_uint64(count_field);
        std::string_view comment;
        next_line(comment);
        Input input;
        reserve(input, false);
        Row row;
        while (next_row(row)) {
            if (input.size() == count) {
                throw error("more rows than the " + std::to_string(count) +
                            " that the first line announces; this version reads one frame only");
            }
            if (row.count != 4) {
                throw error("this row has " + std::to_string(row.count) + (row.count == 1 ? " column" : " columns") +
                            ", expected 4 (element x y z)");
            }
            append_position(row, 1, input);
        }
        if (input.size() != count) {
            throw error("the file ends after " + std::to_string(input.size()) + " of the " + std::to_string(count) +
                        " rows that its first line announces");
        }
        return input;
    }

    std::string_view rest_;
    TextKind kind_;
    const std::string& name_;
    std::size_t line_ = 0;
};

}  // namespace

Input parse_text(std::string_view text, TextKind kind, const std::string& name) {
    return TextReader(text, kind, name).read();
}

}  // namespace clvotess
