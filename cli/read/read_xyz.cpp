// XYZ: frames of a count, a comment, and that many rows `Element x y z`. In extended XYZ (ASE, OVITO) the comment
// describes columns (Properties), cell (Lattice, Origin) and periodic edges (pbc) as key=value; in that of i-PI it has
// the cell.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "failure.hpp"
#include "files/line_reader.hpp"
#include "read/columns.hpp"
#include "read/frames.hpp"
#include "read/input.hpp"
#include "read/rows_by_threads.hpp"
#include "read/text_frames.hpp"

namespace clvotess {
namespace {

constexpr std::array<std::string_view, 6> known_keys{"lattice", "origin", "pbc", "properties", "timestep", "step"};

// Returns whether a text holds `key=` of a known key.
bool hides_key(std::string_view text) {
    for (std::size_t at = text.find('='); at < text.size(); at = text.find('=', at + 1)) {
        const std::string_view before = text.substr(0, text.substr(0, at).find_last_not_of(" \t") + 1);
        const std::string key = lower_case(before.substr(before.find_last_of(" \t=\"'{[,") + 1));
        if (std::ranges::find(known_keys, std::string_view(key)) != known_keys.end()) return true;
    }
    return false;
}

class XyzReader {
public:
    XyzReader(const std::string& name, const ReadRequest& request) : lines_({}, name), request_(request) {}

    Input read_frame(std::string_view text) {
        lines_.go_on(text);
        read_count();
        std::string_view comment;
        static_cast<void>(lines_.next(comment));  // may be missing in a file without rows
        read_pairs(comment);
        Input input;
        input.domain = read_domain(comment);
        names_.clear();
        row_of_zeros_.clear();
        first_.reset();
        id_.reset();
        wanted_.reset();
        const auto properties = value_of("properties");
        if (properties) read_properties(*properties);
        for (const char* const key : {"timestep", "step"}) {
            if (const auto step = value_of(key); step && std::isfinite(read_double(*step).value_or(NAN)))
                input.timestep = *step;
        }
        const auto count = static_cast<std::size_t>(count_);
        if (!can_hold(lines_.rest().size(), count, 2)) throw short_frame(0);
        if (count == 0 && has_properties()) {
            words_ = row_of_zeros_;
            input.columns = wanted_of_row().columns(0);
        }
        input.points.reserve(3 * max_rows());
        for (std::size_t i = 0; i < count; i = input.size()) {
            if (!append_row(input)) throw short_frame(i);
            if (i == 0) append_by_threads(*this, input, count, request_.threads);
        }
        return input;
    }
    void skip_frame(std::string_view text) {
        lines_.go_on(text);
        read_count();
    }

    // Appends all rows of the text.
    void append_rows(Input& input) {
        while (append_row(input)) {
        }
    }
    [[nodiscard]] LineReader& lines() noexcept { return lines_; }
    [[nodiscard]] const LineReader& lines() const noexcept { return lines_; }

private:
    // Reads the pairs `key=value` of a comment. Values may be in quotes or brackets, and blanks around the `=`. The
    // case of a key does not matter. Throws Failure for a quote or bracket that hides a known key, and for a key with
    // two values.
    void read_pairs(std::string_view comment) {
        pairs_.clear();
        const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
        const auto behind_blanks = [&](std::size_t at) {
            while (at < comment.size() && blank(comment[at])) ++at;
            return at;
        };
        const auto end_of_word = [&](std::size_t at) {
            while (at < comment.size() && !blank(comment[at])) ++at;
            return at;
        };
        for (std::size_t at = behind_blanks(0); at < comment.size(); at = behind_blanks(at)) {
            const std::size_t begin = at;
            while (at < comment.size() && !blank(comment[at]) && comment[at] != '=') ++at;
            const std::string key = lower_case(comment.substr(begin, at - begin));
            const std::size_t sign = behind_blanks(at);
            if (sign == comment.size() || comment[sign] != '=') continue;
            at = sign + 1;
            if (const std::size_t word = behind_blanks(at); word < comment.size()) {
                const bool is_key = comment.find('=', word) < end_of_word(word);
                constexpr std::string_view opening = "\"'{[";
                if (!is_key || opening.find(comment[word]) != std::string_view::npos) at = word;
            }
            add_pair(key, comment, at, end_of_word(at));
        }
    }

    // Adds the value that begins at `at`, and goes behind it. end: of the word there.
    void add_pair(const std::string& key, std::string_view comment, std::size_t& at, std::size_t end) {
        constexpr std::string_view opening = "\"'{[", closing = "\"'}]";
        const std::size_t bracket = at < comment.size() ? opening.find(comment[at]) : std::string_view::npos;
        const bool is_bare = bracket == std::string_view::npos, is_array = bracket == opening.find('[');
        const std::size_t first = is_bare ? at : at + 1;
        if (!is_bare) {
            const bool quoted = opening[bracket] == closing[bracket];
            std::size_t inner = 0;  // brackets
            for (end = first; end < comment.size() && (comment[end] != closing[bracket] || inner > 0); ++end) {
                if (quoted && comment[end] == '\\') ++end;  // ASE writes \" for a quote in a text
                if (is_array && comment[end] == '[') ++inner;
                if (is_array && comment[end] == ']') --inner;
            }
            end = std::min(end, comment.size());
        }
        std::string value(comment.substr(first, end - first));
        at = std::min(end + (is_bare ? 0 : 1), comment.size());
        const bool ends_well = at < comment.size() ? comment[at] == ' ' || comment[at] == '\t' || comment[at] == '\r'
                                                   : end < comment.size();
        if (!is_bare && !ends_well && hides_key(value))
            throw lines_.error(std::string("the ") + opening[bracket] + " before " + in_quotes(value) +
                               " has no end before other keys: close it");
        const bool has_no_key = key.empty() && !value.empty();
        if (has_no_key || (is_bare && hides_key(value)))
            throw lines_.error("the value " + in_quotes(value) + (has_no_key ? " has no key" : " holds another key") +
                               ": leave blanks between pairs of key=value");
        if (std::ranges::find(known_keys, std::string_view(key)) == known_keys.end()) return;
        if (is_array) std::ranges::replace(value, ',', ' ');
        if (const auto other = value_of(key); other && *other != value)
            throw lines_.error(key + " has two values, " + in_quotes(*other) + " and " + in_quotes(value) +
                               ": leave one");
        pairs_.emplace_back(key, std::move(value));
    }

    // Returns the value of a key, without quotes or brackets around it. Blanks replace the commas of an array in square
    // brackets; those within stay.
    [[nodiscard]] std::optional<std::string> value_of(std::string_view key) const {
        for (const auto& [name, value] : pairs_)
            if (name == key) return value;
        return std::nullopt;
    }

    // Reads the count of a frame.
    void read_count() {
        std::string_view line;
        static_cast<void>(lines_.next_filled(line));
        split_words(line, words_);
        const auto count = words_.size() == 1 ? read_uint64(words_[0]) : std::nullopt;
        if (!count && frames_ == 0) throw lines_.error("expected one whole number, how many rows follow");
        if (!count) {
            throw lines_.error("more rows than the " + std::to_string(count_) + " that the first line of frame " +
                               std::to_string(frames_ - 1) + " announces");
        }
        count_ = *count;
        ++frames_;
    }

    [[nodiscard]] Failure short_frame(std::uint64_t rows) const {
        return lines_.error("the file ends after " + std::to_string(rows) + " of the " + std::to_string(count_) +
                            " rows that its first line announces");
    }

    // Reads name:type:columns of each property, joined by colons. A property of several columns gives NAME_1, NAME_2,
    // ...
    void read_properties(const std::string& text) {
        std::vector<std::string> fields(1);
        for (const char c : text) {
            if (c == ':') {
                fields.emplace_back();
            } else {
                fields.back() += c;
            }
        }
        for (std::size_t k = 0; k + 2 < fields.size(); k += 3) {
            const auto columns = read_uint64(fields[k + 2]);
            if (!columns || *columns == 0 || *columns > max_columns) throw bad_properties(text);
            if (names_.size() + *columns > max_columns)
                throw lines_.error("Properties has more than " + std::to_string(max_columns) + " columns");
            const std::string name = lower_case(fields[k]);
            if ((name == "pos" || name == "position") && *columns == 3) first_ = names_.size();
            const bool whole = fields[k + 1] == "I" && *columns == 1;
            if (whole && (name == "id" || name == "ids" || name == "identifier")) id_ = names_.size();
            for (std::uint64_t c = 1; c <= *columns; ++c) {
                names_.push_back(*columns == 1 ? fields[k] : fields[k] + "_" + std::to_string(c));
                row_of_zeros_.emplace_back(fields[k + 1] == "S" ? "-" : "0");
            }
        }
        if (fields.size() % 3 != 0 || !first_) throw bad_properties(text);
    }

    [[nodiscard]] Failure bad_properties(const std::string& text) const {
        return lines_.error("Properties must be name:type:columns of each property, with pos:R:3 among them, not " +
                            in_quotes(text));
    }

    [[nodiscard]] std::array<double, 9> numbers_of(const char* key, const std::string& text, std::size_t count) {
        split_words(text, words_);
        if (words_.size() != count) {
            throw lines_.error(std::string(key) + " must hold " + std::to_string(count) + " numbers, not " +
                               in_quotes(text));
        }
        std::array<double, 9> numbers{};
        for (std::size_t k = 0; k < count; ++k) numbers[k] = lines_.number(words_[k]);
        return numbers;
    }

    // Drops the brackets of a matrix, three rows of three. Returns whether there were some.
    bool join_rows(std::string& text) {
        if (text.find('[') == std::string::npos) return false;
        const std::string whole = text;
        std::size_t rows = 0;
        for (std::size_t begin = 0; (begin = text.find('[', begin)) != std::string::npos; ++rows) {
            const std::size_t end = std::min(text.find(']', begin), text.size() - 1);
            split_words(std::string_view(text).substr(begin + 1, end - begin - 1), words_);
            if (text[end] != ']' || words_.size() != 3) rows = 3;
            text[begin] = text[end] = ' ';
        }
        if (rows != 3)
            throw lines_.error("Lattice must hold three rows of three numbers, not " + in_quotes('[' + whole + ']'));
        return true;
    }

    // Returns the cell in a comment of i-PI, `CELL(abcABC): a b c bc ac ab ... positions{unit} cell{unit}`, or with
    // nine numbers H or GENH. Throws Failure if cell and positions have different units.
    std::optional<votess::TriclinicBox> cell_of_ipi(std::string_view comment) {
        constexpr std::string_view mark = "CELL", of_cell = "cell{";
        const auto at = comment.find(mark);
        if (at == std::string_view::npos) return std::nullopt;
        comment.remove_prefix(std::min(at + mark.size() + 1, comment.size()));
        const auto end = std::min(comment.find_first_of(")]}"), comment.size());
        const std::string kind(comment.substr(0, end));
        comment.remove_prefix(end);
        const std::size_t count = kind == "abcABC" ? 6 : kind == "H" || kind == "GENH" ? 9 : 0;
        if (count == 0 || comment.size() < 2 || comment[1] != ':') return std::nullopt;
        comment.remove_prefix(2);
        split_words(comment, words_);
        if (words_.size() < count)
            throw lines_.error("CELL(" + kind + ") must hold " + std::to_string(count) + " numbers");
        std::array<double, 9> n{};
        for (std::size_t k = 0; k < count; ++k) n[k] = lines_.number(words_[k]);
        const auto unit = [](std::string_view text) {
            const auto begin = text.find('{');
            return begin == std::string_view::npos ? std::string("atomic_unit")
                                                   : std::string(text.substr(begin + 1, text.find('}') - begin - 1));
        };
        const auto split = std::min(comment.find(of_cell), comment.size());
        const std::string positions = unit(comment.substr(0, split)), own = unit(comment.substr(split));
        if (own != positions)
            throw lines_.error("i-PI's cell has the unit " + own + " and its positions " + positions +
                               ": write both in the same");
        if (kind == "abcABC") return cell_of({n[0], n[1], n[2]}, {n[3], n[4], n[5]});
        if (kind == "H") return votess::TriclinicBox{.a{n[0], n[3], n[6]}, .b{n[1], n[4], n[7]}, .c{n[2], n[5], n[8]}};
        return votess::TriclinicBox{.a{n[0], n[1], n[2]}, .b{n[3], n[4], n[5]}, .c{n[6], n[7], n[8]}};
    }

    // Reads the cell. Without pbc it is periodic along all edges, as in ASE and OVITO.
    FileDomain read_domain(std::string_view comment) {
        FileDomain domain;
        domain.periodic_from = DomainSource::assumed;
        std::optional<votess::TriclinicBox> cell;
        if (auto lattice = value_of("lattice")) {
            // The columns of a matrix are edges: the package extxyz writes and reads them so (0.2.2 and 0.4.6).
            const bool is_matrix = join_rows(*lattice);
            split_words(*lattice, words_);
            const bool is_diagonal = !is_matrix && words_.size() == 3;
            auto n = numbers_of("Lattice", *lattice, is_diagonal ? 3 : 9);
            if (is_diagonal) n = {n[0], 0, 0, 0, n[1], 0, 0, 0, n[2]};
            if (is_matrix) std::swap(n[1], n[3]), std::swap(n[2], n[6]), std::swap(n[5], n[7]);
            cell = votess::TriclinicBox{.a = {n[0], n[1], n[2]}, .b = {n[3], n[4], n[5]}, .c = {n[6], n[7], n[8]}};
            const auto origin = value_of("origin");
            domain.corner_from = origin ? DomainSource::stated : DomainSource::assumed;
            if (origin) {
                const auto corner = numbers_of("Origin", *origin, 3);
                std::copy_n(corner.begin(), 3, cell->origin.begin());
            }
        } else {
            cell = cell_of_ipi(comment);
        }
        if (const auto pbc = value_of("pbc")) {
            split_words(*pbc, words_);
            if (words_.size() == 1) words_.resize(3, words_[0]);
            if (words_.size() != 3) throw lines_.error("pbc must be three of T or F, not " + in_quotes(*pbc));
            domain.periodic_from = DomainSource::stated;
            std::array<bool, 3>& periodic = cell ? cell->periodic : domain.periodic;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::string word = lower_case(words_[k]);
                periodic[k] = word == "t" || word == "true" || word == "1";
                if (!periodic[k] && word != "f" && word != "false" && word != "0") {
                    throw lines_.error("pbc must be three of T or F, not " + in_quotes(*pbc));
                }
            }
        }
        if (cell) state_cell(domain, *cell);
        return domain;
    }

    [[nodiscard]] ColumnPlaces wanted_of_row() const {
        std::vector<std::string> own = names_or_numbers(names_, words_.size());
        if (names_.empty() && !own.empty()) own[0] = "species";
        const Words names(own.begin(), own.end());
        ColumnPlaces wanted(request_, names, lines_.place());
        const std::size_t first = first_.value_or(1);
        std::vector<std::size_t> taken{first, first + 1, first + 2};
        if (id_) taken.push_back(*id_);
        if (request_.all_columns) wanted.add_others(names, taken, words_);
        wanted.find_words(words_);
        return wanted;
    }

    // Appends the next row. Returns false at the end of the text.
    bool append_row(Input& input) {
        std::string_view line;
        if (!lines_.next_filled(line)) return false;
        split_words(line, words_);
        if (!wanted_) wanted_ = wanted_of_row();
        if (input.points.empty()) input.columns = wanted_->columns(max_rows());
        const std::size_t first = first_.value_or(1);
        const bool more = wanted_->end() > 0;
        const bool fits = has_properties() ? words_.size() == names_.size()
                          : more           ? words_.size() >= std::max<std::size_t>(wanted_->end(), 4)
                                           : words_.size() == 4;
        if (!fits) {
            throw lines_.error("this row has " + columns_text(words_.size()) + ", expected " +
                               (has_properties() ? std::to_string(names_.size()) + ", as Properties says"
                                : more           ? "more"
                                                 : "4 (element x y z)"));
        }
        for (std::size_t k = 0; k < 3; ++k) input.points.push_back(lines_.number(words_[first + k]));
        if (id_) input.ids.push_back(lines_.whole(words_[*id_], "an id"));
        wanted_->append(
            input, [this](std::size_t k) { return words_[k]; },
            [this](std::size_t k, const std::string& column) { return lines_.number(words_[k], column); });
        return true;
    }
    // Returns how many rows may follow.
    [[nodiscard]] std::size_t max_rows() const {
        constexpr std::size_t shortest = 8;  // bytes of "H 0 0 0" and its line end
        return std::min(static_cast<std::size_t>(count_), lines_.rest().size() / shortest + 2);
    }
    [[nodiscard]] bool has_properties() const { return !names_.empty(); }

    LineReader lines_;
    ReadRequest request_;
    Words words_;
    std::uint64_t count_ = 0, frames_ = 0;
    std::vector<std::pair<std::string, std::string>> pairs_;  // known keys of the comment, in lower case, and values
    std::vector<std::string> names_;                          // of the columns, by Properties
    Words row_of_zeros_;                                      // as rows of these columns are
    std::optional<std::size_t> first_, id_;
    std::optional<ColumnPlaces> wanted_;  // known from the first row
};

}  // namespace

std::unique_ptr<InputFrames> open_xyz_frames(std::unique_ptr<TextSource>& source, const ReadRequest& request,
                                             std::string& head) {
    // The first line that is not blank says whether there are frames.
    bool more = true;
    while (more) {
        more = source->append(head);
        const auto begin = head.find_first_not_of(std::string(blanks) + "\n\xef\xbb\xbf");
        if (head.find('\n', std::min(begin, head.size())) != std::string::npos) break;
        check_last_line(head, source->name());
    }
    if (!holds_frames(head, source->name())) return nullptr;
    if (request.npy_holds_columns) throw bad_input(source->name() + ": rays are rows of text without a count first");
    if (!request.coordinates.empty())
        throw bad_input(source->name() + ": --columns goes with rows, not with frames, whose Properties name pos");
    return std::make_unique<TextFrames<XyzReader>>(std::move(source), FrameKind::xyz, request, std::move(head));
}

Input read_xyz(std::unique_ptr<TextSource> source, const ReadRequest& request) {
    std::string text;
    if (const auto frames = open_xyz_frames(source, request, text))
        return read_frame(*frames, request.frame.value_or(0));
    if (request.frame) throw without_frames(source->name());
    return parse_text(rest_of(*source, std::move(text)), TextKind::plain, source->name(), request);
}

}  // namespace clvotess
