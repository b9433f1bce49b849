// Text rows `x y z` or `id x y z`, in the plane `x y` or `id x y`, with further columns that the run requests; and rows
// under a line of names, of which those of .csv follow RFC 4180.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "failure.hpp"
#include "files/input_file.hpp"
#include "files/line_reader.hpp"
#include "files/numbers.hpp"
#include "read/columns.hpp"
#include "read/input.hpp"
#include "read/rows_by_threads.hpp"

namespace clvotess {
namespace {

constexpr std::size_t kept_fields = 64;
constexpr std::size_t row_bytes = 40;  // estimate for a file

// The fields of one line. `count` may exceed kept_fields.
struct Row {
    std::array<std::string_view, kept_fields> fields;
    std::size_t count = 0;
    const char* comma = nullptr;    // the first possible decimal comma: between digits, no point before it
    bool commas_everywhere = true;  // whether every gap has a comma
    std::size_t apart = 0;          // number of fields if a comma without blanks joins two
};

// The columns of coordinates and id.
struct Layout {
    std::vector<std::size_t> axes;
    std::optional<std::size_t> id;
};

bool is_mark(char c) {
    return c == ',' || c == ';';
}
// Returns whether a comment begins there, in a line whose fields may hold #.
bool is_comment(std::string_view line, std::size_t at) {
    return line[at] == '#' && (at == 0 || is_blank(line[at - 1]));
}
bool ends_field(char c) {
    return is_blank(c) || is_mark(c) || c == '#';
}

class TextReader {
public:
    TextReader(TextKind kind, const std::string& name, const ReadRequest& request)
        : lines_({}, name), request_(request) {
        for (std::string& column : request_.columns) column = plain_name(column);
        for (std::string& column : request_.coordinates) column = plain_name(column);
        may_have_names_ =
            kind == TextKind::csv ||
            std::ranges::any_of(request_.coordinates, [](const std::string& name) { return !read_uint64(name); });
    }

    // Appends the rows of the next part of the text. more: whether another part follows; then a row that ends within
    // quotes waits for it. Returns the length of the text without that row.
    std::size_t append(std::string_view text, bool more, Input& input) {
        lines_.go_on(text);
        more_ = more;
        append_rows(input, true);  // the first row says which columns there are
        // A piece that ends within quotes has an error, so that no row begins there.
        more_ = false;
        append_by_threads(*this, input, std::numeric_limits<std::size_t>::max(), request_.threads);
        more_ = more;
        append_rows(input);
        if (!more && !places_ && !names_.empty()) {  // a table of no rows has columns too
            const Words zeros(names_.size(), "0");
            Row row;
            row.count = zeros.size();
            std::copy_n(zeros.begin(), std::min(row.count, kept_fields), row.fields.begin());
            find_places(row);
            begin(input);
        }
        return text.size() - lines_.rest().size();
    }
    void append_rows(Input& input) { append_rows(input, false); }

    [[nodiscard]] LineReader& lines() noexcept { return lines_; }
    [[nodiscard]] const LineReader& lines() const noexcept { return lines_; }

private:
    // Appends the next rows; up to the first row of all, if `first`.
    void append_rows(Input& input, bool first) {
        Row row;
        while (!(first && places_) && next_row(row)) {
            check_commas(row);
            if (!places_) find_places(row);
            if (input.points.empty()) begin(input);
            append_row(row, input);
        }
    }

    // Reads the next row. Returns false at the end, and before a row that waits.
    bool next_row(Row& row) {
        while (!waits_ && lines_.next_filled(line_)) {
            first_line_ = lines_.line();
            const bool comment = line_[line_.find_first_not_of(blanks)] == '#';
            if (!places_ && comment) note_comment();
            if (comment || (!places_ && may_have_names_ && names_.empty() && take_names())) continue;
            if (!waits_ && has_fields())
                split_at_marks(row);
            else if (!waits_)
                split(line_, row);
            if (!waits_) return true;
        }
        if (std::exchange(waits_, false)) lines_.go_back(line_, first_line_);
        return false;
    }

    // Whether the marks of the names separate the fields of the current line.
    [[nodiscard]] bool has_fields() const {
        return !marks_.empty() &&
               (line_.find_first_of(marks_) != std::string_view::npos || line_.find('"') != std::string_view::npos);
    }

    // Appends the next line to the current one, which ends within quotes. Returns false at the end of the text; the row
    // may wait then.
    bool go_on_in_quotes() {
        if (lines_.extend(line_)) return true;
        waits_ = more_;
        return false;
    }

    // Takes the line as the names of the columns. Returns false for a row of numbers.
    bool take_names() {
        marks_ = marks_in_line();
        if (!waits_) names_ = names_of(line_, marks_);
        if (names_.empty()) marks_.clear();
        if (names_.empty()) return false;
        // Where both marks occur, one may belong to names.
        for (const char mark : marks_.size() > 1 ? marks_ : std::string()) {
            std::vector<std::string> names;
            try {
                names = names_of(line_, std::string(1, mark));
            } catch (const Failure&) {
                continue;
            }
            if (!names_coordinates(names)) continue;
            names_ = std::move(names);
            marks_ = mark;
        }
        check_names();
        return true;
    }
    // Returns whether the names have x and y, or those of --columns.
    [[nodiscard]] bool names_coordinates(const std::vector<std::string>& names) const {
        const std::vector<std::string> usual{"x", "y"};
        return std::ranges::all_of(
            request_.coordinates.empty() ? usual : request_.coordinates,
            [&](const std::string& axis) { return std::ranges::count(names, axis) > 0 || read_uint64(axis); });
    }

    // Keeps the names in a comment. They count if they fit the row after it.
    void note_comment() {
        const auto begin = line_.find_first_not_of("# \t");
        const bool quoted = line_.find('"') != std::string_view::npos;
        comment_.clear();
        if (begin == std::string_view::npos || quoted) return;
        const std::string_view text = line_.substr(begin);
        std::string marks;
        add_marks(text, marks);
        comment_ = names_of(text, marks);
    }

    // Takes the names of a comment such as `# x y z mass`, if it names a coordinate for each that is wanted and has as
    // many words as the row has columns. A first column before the coordinates is the id, as without names.
    void take_comment(std::size_t columns) {
        const bool numbered = !request_.coordinates.empty() && read_uint64(request_.coordinates[0]);
        if (!names_.empty() || numbered || comment_.size() != columns || !names_coordinates(comment_)) return;
        names_ = std::move(comment_);
        const bool may_be_id = !request_.all_columns && !is_requested(names_[0]) && !is_requested("1");
        if (!named("id") && may_be_id && columns == axis_names().size() + 1 && named("x") == 1u) names_[0] = "id";
        check_names();
    }

    // Throws Failure for a decimal comma. A comma between two digits separates fields if every gap of the row has a
    // comma, unless blanks after other commas leave 3 or 4 numbers, as in "0,5, 1, 2".
    void check_commas(const Row& row) const {
        const bool may_be_decimals = names_.empty() && (row.apart == 3 || row.apart == 4) && row.apart < row.count;
        if (!row.comma || (row.commas_everywhere && !may_be_decimals)) return;
        const char *begin = row.comma, *end = row.comma;
        while (begin != line_.data() && !is_blank(begin[-1]) && begin[-1] != ';') --begin;
        while (end != line_.data() + line_.size() && !is_blank(*end) && *end != ';') ++end;
        throw lines_.error(not_a_number({begin, static_cast<std::size_t>(end - begin)}));
    }

    // Splits a line into fields, at blanks with at most one comma or semicolon among them.
    void split(std::string_view line, Row& row) const {
        row.count = 0;
        row.comma = nullptr;
        row.commas_everywhere = true;
        row.apart = 0;
        const char* at = line.data();
        const char* const end = at + line.size();
        const auto skip_blanks = [&] {
            while (at != end && is_blank(*at)) ++at;
            return at == end || *at == '#';
        };
        for (const char* gap = at; !skip_blanks(); gap = at) {
            const bool comma = *at == ',';
            if (is_mark(*at)) {
                if (row.count > 0) ++at;
                if (skip_blanks() || is_mark(*at))
                    throw lines_.error("column " + std::to_string(row.count + 1) + " is empty");
            }
            const char* const begin = at;
            const bool joined = row.count > 0 && comma && begin - gap == 1;
            if (row.count > 0 && !comma) row.commas_everywhere = false;
            if (!joined) ++row.apart;
            if (joined && !row.comma && is_digit(gap[-1]) && is_digit(*begin) && !has_point(row)) row.comma = gap;
            while (at != end && !ends_field(*at)) ++at;
            if (row.count < kept_fields) row.fields[row.count] = {begin, static_cast<std::size_t>(at - begin)};
            ++row.count;
        }
    }

    // Calls field(text, quoted) for each field of a line that marks separate, by RFC 4180: quotes may hold marks,
    // blanks, line ends and doubled quotes. Blanks around a field do not count. go_on(line): appends the next line.
    template <typename Field, typename GoOn>
    void each_field(std::string_view line, std::string_view marks, Field field, GoOn go_on) const {
        std::size_t at = 0, column = 1;
        const auto skip_blanks = [&] {
            while (at < line.size() && is_blank(line[at])) ++at;
        };
        const auto ended = [&] {
            return at == line.size() || line[at] == marks.front() || line[at] == marks.back() || is_comment(line, at);
        };
        for (;; ++at, ++column) {
            skip_blanks();
            const bool quoted = at < line.size() && line[at] == '"';
            std::size_t begin = at + (quoted ? 1 : 0), end = begin;
            if (quoted) {
                for (std::size_t from = begin;;) {
                    end = line.find('"', from);
                    if (end == std::string_view::npos) {
                        from = line.size();
                        if (go_on(line)) continue;
                        if (waits_) return;
                        throw bad_input(lines_.name() + ":" + std::to_string(first_line_) + ": the quote in column " +
                                        std::to_string(column) + " does not end");
                    }
                    if (line.substr(end + 1, 1) != "\"") break;
                    from = end + 2;
                }
                at = end + 1;
                skip_blanks();
                if (!ended())
                    throw lines_.error("column " + std::to_string(column) + " goes on behind its quotes: double the " +
                                       "quotes within");
            } else {
                while (!ended()) ++at;
                end = at;
                while (end > begin && is_blank(line[end - 1])) --end;
            }
            field(line.substr(begin, end - begin), quoted);
            if (at == line.size() || is_comment(line, at)) return;
        }
    }

    // Splits the current line, with those in which its quotes go on.
    void split_at_marks(Row& row) {
        row.count = 0;
        row.comma = nullptr;
        each_field(
            line_, marks_,
            [&](std::string_view field, bool) {
                if (row.count < kept_fields) row.fields[row.count] = field;
                ++row.count;
            },
            [this](std::string_view& line) {
                const bool extended = go_on_in_quotes();
                line = line_;
                return extended;
            });
    }

    // Returns a field without the doubling of its quotes.
    static std::string text_of(std::string_view field) {
        std::string text(field);
        for (std::size_t at = 0; (at = text.find("\"\"", at)) != std::string::npos; ++at) text.erase(at, 1);
        return text;
    }

    static bool has_point(const Row& row) {
        return row.fields[std::min(row.count, kept_fields) - 1].find('.') != std::string_view::npos;
    }

    // Returns the name in lower case, without blanks and quotes around it.
    static std::string plain_name(std::string_view name) {
        while (!name.empty() && is_blank(name.front())) name.remove_prefix(1);
        while (!name.empty() && is_blank(name.back())) name.remove_suffix(1);
        if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
        return lower_case(name);
    }

    // Adds the commas and semicolons of a line that are neither in quotes nor in a comment, each once. Returns whether
    // the line ends within quotes. quoted: whether it begins there.
    static bool add_marks(std::string_view line, std::string& marks, bool quoted = false) {
        for (std::size_t at = 0; at < line.size() && (quoted || !is_comment(line, at)); ++at) {
            quoted ^= line[at] == '"';
            if (!quoted && is_mark(line[at]) && marks.find(line[at]) == std::string::npos) marks += line[at];
        }
        return quoted;
    }
    // Returns those of the current line, with those in which its quotes go on.
    std::string marks_in_line() {
        std::string marks;
        for (std::size_t from = 0; add_marks(line_.substr(from), marks, from > 0);) {
            from = line_.size();
            if (!go_on_in_quotes()) break;
        }
        return marks;
    }

    // Returns the names in a line, which these marks separate, or blanks without any; nothing if one is a number.
    [[nodiscard]] std::vector<std::string> names_of(std::string_view line, const std::string& marks) const {
        std::vector<std::string> names;
        Words words;
        bool numbers = false;
        const auto is_number = [](std::string_view word) { return read_double(word).has_value(); };
        if (marks.empty()) {
            split_words(line.substr(0, line.find('#')), words);
            for (const std::string_view word : words) names.push_back(plain_name(word));
            numbers = std::ranges::any_of(words, is_number);
        } else {
            each_field(
                line, marks,
                [&](std::string_view field, bool quoted) {
                    names.push_back(lower_case(quoted ? text_of(field) : std::string(field)));
                    words = {field};
                    if (!quoted) split_words(field, words);
                    numbers |= !words.empty() && std::ranges::all_of(words, is_number);
                },
                [](std::string_view&) { return false; });
        }
        return numbers ? std::vector<std::string>() : names;
    }

    [[nodiscard]] std::optional<std::size_t> named(std::string_view name) const { return find_name(names_, name); }

    // Returns the names of the coordinates. Only names of x and y, the id and requested columns mean two dimensions.
    [[nodiscard]] std::vector<std::string> axis_names() const {
        if (!request_.coordinates.empty()) return request_.coordinates;
        bool flat = request_.dimensions != Dimensions::three && !named("z");
        if (request_.dimensions == Dimensions::either)
            for (std::size_t k = 0; k < names_.size(); ++k)
                flat &= names_[k] == "x" || names_[k] == "y" || names_[k] == "id" || is_requested(names_[k]) ||
                        is_requested(std::to_string(k + 1));
        return flat ? std::vector<std::string>{"x", "y"} : std::vector<std::string>{"x", "y", "z"};
    }
    [[nodiscard]] bool is_requested(const std::string& name) const {
        return std::ranges::count(request_.columns, name) > 0;
    }

    // Throws Failure unless the line names the coordinates, and each used name once.
    void check_names() const {
        std::vector<std::string> used = axis_names();
        for (const std::string& axis : used) {
            if (named(axis) || (!request_.coordinates.empty() && read_uint64(axis))) continue;
            std::string list;
            for (const std::string& name : names_) list += (list.empty() ? "" : ", ") + in_quotes(name);
            std::string why = " of --columns";
            if (request_.coordinates.empty())
                why = std::string(": name the columns of the coordinates by --columns") +
                      (axis == "z" ? ", or add --2d for x and y alone" : "");
            throw lines_.error("the line of names lacks " + in_quotes(axis) + why + "; there are " + list);
        }
        used.emplace_back("id");
        used.insert(used.end(), request_.columns.begin(), request_.columns.end());
        if (request_.all_columns) used.insert(used.end(), names_.begin(), names_.end());
        for (const std::string& name : used) {
            if (std::ranges::count(names_, name) > 1) {
                throw lines_.error("the line of names has " + in_quotes(name) + " more than once");
            }
        }
    }

    // Returns the columns of --columns, by names or numbers.
    [[nodiscard]] std::vector<std::size_t> axes_of(std::size_t columns) const {
        std::vector<std::size_t> axes;
        for (const std::string& name : request_.coordinates) {
            const auto number = read_uint64(name);
            if (const auto at = named(name)) {
                axes.push_back(*at);
            } else if (number && *number >= 1 && *number <= columns) {
                axes.push_back(*number - 1);
            } else {
                throw lines_.error("no column " + in_quotes(name) + " of --columns: this row has " +
                                   columns_text(columns) +
                                   (names_.empty() ? ", and no line of names comes first" : ""));
            }
        }
        return axes;
    }

    // Returns the layout by the line of names. Without one, the columns except `wanted` are x y z or id x y z, in the
    // plane x y or id x y.
    [[nodiscard]] Layout layout_of(std::size_t columns, const ColumnPlaces& wanted) const {
        if (columns > kept_fields) {
            throw lines_.error("this row has " + std::to_string(columns) + " columns, more than the " +
                               std::to_string(kept_fields) + " that are read");
        }
        if (!names_.empty() && names_.size() != columns) {
            throw lines_.error("this row has " + columns_text(columns) + ", the line of names " +
                               std::to_string(names_.size()));
        }
        Layout layout;
        if (!request_.coordinates.empty()) {
            layout.axes = axes_of(columns);
            layout.id = named("id");
            return layout;
        }
        if (!names_.empty()) {
            for (const std::string& axis : axis_names()) layout.axes.push_back(*named(axis));
            layout.id = named("id");
            return layout;
        }
        std::vector<std::size_t> places;
        for (std::size_t k = 0; k < columns; ++k) {
            if (!wanted.holds(k)) places.push_back(k);
        }
        if (request_.all_columns && !request_.columns_may_lack)
            throw lines_.error("--copy all needs a header line, as in .csv");
        if (columns == 5 && wanted.end() == 0 && request_.dimensions != Dimensions::two) {
            throw lines_.error(
                "5 columns have one too many: name it with --radii 5, --weights 5 or --copy 5, or remove it");
        }
        const bool flat =
            request_.dimensions == Dimensions::two || (request_.dimensions == Dimensions::either && columns == 2);
        const std::size_t coordinates = flat ? 2 : 3;
        if (places.size() != coordinates && places.size() != coordinates + 1) {
            throw lines_.error("this row has " + columns_text(columns) + ", expected " +
                               (flat ? "2 (x y) or 3 (id x y) with --2d" : "3 (x y z) or 4 (id x y z)") +
                               (wanted.end() > 0 ? " in addition to the named ones" : "") +
                               (places.size() == 2 ? "; for two dimensions add --2d" : ""));
        }
        if (places.size() > coordinates) layout.id = places[0];
        layout.axes.assign(places.end() - static_cast<std::ptrdiff_t>(coordinates), places.end());
        return layout;
    }

    // Throws Failure for a first row of words alone, which is a line of names.
    void check_first_row(const Row& row) const {
        for (std::size_t k = 0; k < std::min(row.count, kept_fields); ++k) {
            const std::string_view field = row.fields[k];
            if (field.empty() || field.find_first_of("0123456789") != std::string_view::npos || read_double(field))
                return;
        }
        throw lines_.error(in_quotes(row.fields[0]) +
                           " is not a number: put # before a line of names, or name the file .csv");
    }

    // Finds the columns by the first row.
    void find_places(const Row& row) {
        columns_ = row.count;
        take_comment(columns_);
        if (names_.empty()) check_first_row(row);
        const std::size_t side_by_side = request_.coordinates.size() + request_.columns.size();
        if (request_.npy_holds_columns && columns_ != side_by_side)
            throw lines_.error("this row has " + columns_text(columns_) + ", expected the " +
                               std::to_string(side_by_side) + " of a ray: origin, direction and length");
        const std::vector<std::string> own = names_or_numbers(names_, columns_);
        const Words names(own.begin(), own.end());
        places_.emplace(request_, names, lines_.place());
        layout_ = layout_of(columns_, *places_);
        const auto kept = static_cast<std::ptrdiff_t>(columns_);
        const Words words(row.fields.begin(), row.fields.begin() + kept);
        places_->find_words(words);
        if (!request_.all_columns) return;
        std::vector<std::size_t> taken(layout_.axes.begin(), layout_.axes.end());
        if (layout_.id) taken.push_back(*layout_.id);
        places_->add_others(names, taken, words);
    }

    // Reserves memory for all remaining rows.
    void begin(Input& input) const {
        const auto rows =
            1 + static_cast<std::size_t>(std::count(lines_.rest().begin(), lines_.rest().end(), '\n')) + 1;
        input.dimensions = layout_.axes.size();
        input.points.reserve(input.dimensions * rows);
        if (layout_.id) input.ids.reserve(rows);
        input.columns = places_->columns(rows);
    }

    void append_row(const Row& row, Input& input) const {
        if (row.count != columns_) {
            throw lines_.error("this row has " + columns_text(row.count) + ", the rows before it have " +
                               std::to_string(columns_));
        }
        if (layout_.id) {
            const std::string_view field = row.fields[*layout_.id];
            const auto id = read_int64(field);
            if (!id) {
                if (has_decimal_comma(field)) throw lines_.error(not_a_number(field));
                if (!field.empty() && field.find_first_not_of("0123456789") == field.npos)
                    throw lines_.error(in_quotes(field) + " is too large for an id");
                const bool flat = layout_.axes.size() == 2;
                const bool may_be_radii = names_.empty() && row.count == layout_.axes.size() + 1 && read_double(field);
                throw lines_.error(in_quotes(field) + " is not a whole number, as an id must be" +
                                   (!names_.empty() ? ": write whole numbers, or rename the column id"
                                    : flat          ? " (columns id x y)"
                                                    : " (columns id x y z)") +
                                   (!may_be_radii ? ""
                                    : flat ? "; if the columns are x y z, leave --2d out, if x y r, add --radii 3"
                                           : "; if the columns are x y z r, add --radii 4"));
            }
            input.ids.push_back(*id);
        }
        const auto number = [&](std::size_t k, const auto&... name) {
            if (row.fields[k].empty()) throw lines_.error("column " + std::to_string(k + 1) + " is empty");
            return lines_.number(row.fields[k], name...);
        };
        for (const std::size_t k : layout_.axes) input.points.push_back(number(k));
        places_->append(
            input, [&](std::size_t k) { return text_of(row.fields[k]); },
            [&](std::size_t k, const std::string& name) {
                const bool missing = row.fields[k].empty() && request_.all_columns && !is_requested(name);
                return missing ? std::numeric_limits<double>::quiet_NaN() : number(k, name);
            });
    }

    LineReader lines_;
    std::string_view line_;             // the current line, or lines of a row
    std::size_t first_line_ = 0;        // number of the first of them
    bool more_ = false;                 // whether more text follows
    bool waits_ = false;                // whether the current row ends within quotes and waits for that
    std::vector<std::string> names_;    // of the columns, by a line of names
    std::string marks_;                 // commas and semicolons between those; empty if blanks are
    std::vector<std::string> comment_;  // the words of the last comment
    bool may_have_names_ = false;       // whether a line of names may come first
    ReadRequest request_;               // with plain names
    // Set by the first row.
    std::optional<ColumnPlaces> places_;
    std::size_t columns_ = 0;
    Layout layout_;
};

// A text in pieces of whole lines. It is read once, because parsing numbers is the slowest step.
class TextPieces : public InputPieces {
public:
    TextPieces(const std::string& path, TextKind kind, const ReadRequest& request, std::size_t bytes)
        : file_(path), reader_(kind, file_.name(), request), bytes_(bytes) {
        read_more();
    }

    bool restart() override { return false; }
    bool next(Input& piece) override {
        piece = {};
        for (;;) {
            const std::size_t end = more_ ? text_.rfind('\n') + 1 : text_.size();  // 0 within a line
            text_.erase(0, reader_.append(std::string_view(text_).substr(0, end), more_, piece));
            if (!more_) break;
            read_more();
            if (!piece.points.empty()) break;
        }
        return !piece.points.empty();
    }
    // Returns the text that is read and not yet parsed.
    [[nodiscard]] std::string_view text() const noexcept { return text_; }
    [[nodiscard]] const std::string& name() const noexcept { return file_.name(); }

private:
    void read_more() {
        more_ = file_.append(text_, bytes_);
        check_last_line(text_, file_.name());
    }

    InputFile file_;
    TextReader reader_;
    std::size_t bytes_;
    std::string text_;
    bool more_ = true;
};

}  // namespace

Input parse_text(std::string_view text, TextKind kind, const std::string& name, const ReadRequest& request) {
    Input input;
    TextReader(kind, name, request).append(text, false, input);
    return input;
}

bool holds_frames(std::string_view text, const std::string& name) {
    LineReader lines(text, name);
    std::string_view line;
    if (!lines.next_filled(line)) return false;
    Words words;
    split_words(line, words);
    return words.size() == 1 && read_uint64(words[0]);
}

std::unique_ptr<InputPieces> open_text(const std::string& path, TextKind kind, const ReadRequest& request,
                                       std::size_t rows) {
    return std::make_unique<TextPieces>(path, kind, request, rows * row_bytes);
}

std::unique_ptr<InputPieces> open_xyz(const std::string& path, const ReadRequest& request, std::size_t rows) {
    auto pieces = std::make_unique<TextPieces>(path, TextKind::plain, request, rows * row_bytes);
    return holds_frames(pieces->text(), pieces->name()) ? nullptr : std::move(pieces);
}

}  // namespace clvotess
