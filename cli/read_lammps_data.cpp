// LAMMPS data files: a header with the number of atoms and the box, then sections; of these only Atoms is read.
#include <algorithm>
#include <array>
#include <optional>

#include "failure.hpp"
#include "input.hpp"
#include "lammps_box.hpp"
#include "line_reader.hpp"

namespace clvotess {
namespace {

// Columns of the Atoms section; three whole numbers, the image flags, may follow.
struct Style {
    std::string_view name, columns;
};

constexpr std::array<Style, 19> styles{{
    {"atomic", "id type x y z"},
    {"charge", "id type q x y z"},
    {"molecular", "id mol type x y z"},
    {"bond", "id mol type x y z"},
    {"angle", "id mol type x y z"},
    {"full", "id mol type q x y z"},
    {"sphere", "id type diameter density x y z"},
    {"dipole", "id type q x y z mux muy muz"},
    {"dpd", "id type theta x y z"},
    {"edpd", "id type temp cv x y z"},
    {"mdpd", "id type rho x y z"},
    {"electron", "id type q spin eradius x y z"},
    {"ellipsoid", "id type ellipsoidflag density x y z"},
    {"body", "id type bodyflag mass x y z"},
    {"line", "id mol type lineflag density x y z"},
    {"tri", "id mol type triangleflag density x y z"},
    {"peri", "id type volume density x y z"},
    {"spin", "id type x y z spx spy spz sp"},
    {"sph", "id type rho esph cv x y z"},
}};

constexpr const char* ask_for_style = "name the atom style behind the word Atoms, as in \"Atoms # sphere\"";

class DataReader {
public:
    DataReader(std::string_view text, const std::string& name, const ReadRequest& request)
        : lines_(text, name), request_(request) {}

    Input read() {
        std::string_view line;
        (void)lines_.next(line);  // the first line is a comment, whatever it holds
        while (lines_.next(line)) {
            const auto mark = std::min(line.find('#'), line.size());
            split_words(line.substr(0, mark), words_);
            if (words_.empty()) continue;
            if (words_[0] == "Atoms" && words_.size() == 1) {
                Words hint;
                split_words(line.substr(std::min(mark + 1, line.size())), hint);
                return read_atoms(hint.empty() ? std::string_view{} : hint[0]);
            }
            read_header();
        }
        throw lines_.error("the file ends before its section Atoms");
    }

private:
    // `N atoms`, `lo hi xlo xhi`, `xy xz yz xy xz yz`. Other lines and sections are passed over.
    void read_header() {
        const std::size_t n = words_.size();
        if (n == 2 && words_[1] == "atoms") {
            count_ = read_uint64(words_[0]);
            if (!count_) throw lines_.error(in_quotes(words_[0]) + " is not a number of atoms");
            return;
        }
        constexpr std::array<std::array<std::string_view, 2>, 3> bounds{
            {{"xlo", "xhi"}, {"ylo", "yhi"}, {"zlo", "zhi"}}};
        for (std::size_t k = 0; k < 3; ++k) {
            if (n == 4 && words_[2] == bounds[k][0] && words_[3] == bounds[k][1]) {
                box_.lower[k] = lines_.number(words_[0]);
                box_.upper[k] = lines_.number(words_[1]);
                bounds_seen_[k] = true;
            }
        }
        if (n == 6 && words_[3] == "xy" && words_[4] == "xz" && words_[5] == "yz") {
            box_.xy = lines_.number(words_[0]);
            box_.xz = lines_.number(words_[1]);
            box_.yz = lines_.number(words_[2]);
        }
        if (n >= 2 && (words_[n - 1] == "avec" || words_[n - 1] == "bvec" || words_[n - 1] == "cvec")) {
            throw lines_.error("boxes written as avec, bvec, cvec are not supported");
        }
    }

    // The columns of the first row, by the hint behind `Atoms #` or by their number.
    [[nodiscard]] Words columns_of(std::string_view hint, const Words& row) const {
        Words columns;
        if (hint == "hybrid") {  // what follows depends on the styles that it joins
            split_words("id type x y z", columns);
            for (std::size_t k = columns.size(); k < row.size(); ++k) columns.push_back("");
            if (row.size() < 5) throw lines_.error("atoms of style hybrid have at least 5 columns");
            return columns;
        }
        const auto* const style = std::ranges::find(styles, hint, &Style::name);
        if (style != styles.end()) {
            split_words(style->columns, columns);
            const std::size_t own = columns.size();
            if (row.size() != own && row.size() != own + 3) {
                throw lines_.error("this row has " + std::to_string(row.size()) + " columns, but atoms of style " +
                                   std::string(hint) + " have " + std::to_string(own) + ", or with image flags " +
                                   std::to_string(own + 3));
            }
            return columns;
        }
        if (!hint.empty()) {
            std::string known;
            for (const Style& other : styles) add_name(known, other.name);
            throw lines_.error("atom style " + in_quotes(hint) + " is not known: " + known + " hybrid are");
        }
        // Without a hint: what lies before the coordinates depends on the style, but in the common ones their place
        // follows from the number of columns.
        switch (row.size()) {
            case 5:
            case 8:
                split_words("id type x y z", columns);
                break;
            case 6:
            case 9:
                split_words("id 2 3 x y z", columns);
                break;
            case 7:
            case 10:
                split_words("id 2 3 4 x y z", columns);
                break;
            default:
                throw lines_.error("this row has " + std::to_string(row.size()) + " columns: " + ask_for_style);
        }
        return columns;
    }

    // Of style sphere also `radius`, half of the diameter.
    void find_value(const Words& columns) {
        if (request_.column.empty()) return;
        const auto diameter = std::find(columns.begin(), columns.end(), "diameter");
        if (request_.column == "radius" && diameter != columns.end()) {
            value_column_ = static_cast<std::size_t>(diameter - columns.begin());
            factor_ = 0.5;
        } else {
            value_column_ = find_column(columns, request_.column, lines_.name());
        }
    }

    Input read_atoms(std::string_view hint) {
        if (!count_) throw lines_.error("the section Atoms comes before the line \"N atoms\"");
        // LAMMPS takes a box as periodic unless its script says otherwise, and a data file cannot say so.
        box_.periodic = {true, true, true};
        const bool has_box = bounds_seen_[0] && bounds_seen_[1] && bounds_seen_[2];
        if (!has_box) throw lines_.error("the header lacks the box: lines with xlo xhi, ylo yhi and zlo zhi");
        if (const std::string problem = box_.problem(); !problem.empty()) throw lines_.error(problem);

        Input input;
        input.domain = box_.domain();
        const auto count = static_cast<std::size_t>(*count_);
        constexpr std::size_t shortest_row = 10;
        if (!can_hold(lines_.rest().size(), count, shortest_row)) throw short_section(0);
        input.points.reserve(3 * count);
        input.ids.reserve(count);
        Words columns;
        std::size_t row_size = 0, first = 0;
        while (input.ids.size() < count) {
            std::string_view line;
            if (!lines_.next(line)) throw short_section(input.ids.size());
            split_words(line.substr(0, std::min(line.find('#'), line.size())), words_);
            if (words_.empty()) continue;
            if (columns.empty()) {
                columns = columns_of(hint, words_);
                row_size = words_.size();
                first = static_cast<std::size_t>(std::ranges::find(columns, "x") - columns.begin());
                find_value(columns);
            }
            if (words_.size() != row_size) {
                throw lines_.error("this row has " + std::to_string(words_.size()) +
                                   (words_.size() == 1 ? " column" : " columns") + ", the rows before it have " +
                                   std::to_string(row_size));
            }
            input.ids.push_back(lines_.whole(words_[0], "an id"));
            for (std::size_t k = 0; k < 3; ++k) input.points.push_back(lines_.number(words_[first + k]));
            for (std::size_t k = columns.size(); k < row_size; ++k) {
                if (read_int64(words_[k])) continue;
                throw lines_.error(in_quotes(words_[k]) + " is not a whole number, as an image flag must be" +
                                   (hint.empty() ? std::string("; ") + ask_for_style : ""));
            }
            if (value_column_) input.column.push_back(factor_ * lines_.number(words_[*value_column_]));
        }
        return input;
    }

    [[nodiscard]] Failure short_section(std::size_t rows) const {
        return lines_.error("the file ends after " + std::to_string(rows) + " of the " + std::to_string(*count_) +
                            " atoms that its header announces");
    }

    LineReader lines_;
    const ReadRequest& request_;
    Words words_;
    std::optional<std::uint64_t> count_;
    LammpsBox box_;
    std::array<bool, 3> bounds_seen_{};
    std::optional<std::size_t> value_column_;
    double factor_ = 1;
};

}  // namespace

Input parse_lammps_data(std::string_view text, const std::string& name, const ReadRequest& request) {
    return DataReader(text, name, request).read();
}

}  // namespace clvotess
