// LAMMPS data files: a header with the number of atoms and the box, then sections. Only the section Atoms is read.
#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "failure.hpp"
#include "files/line_reader.hpp"
#include "read/columns.hpp"
#include "read/input.hpp"
#include "read/lammps/lammps_box.hpp"
#include "read/lammps/lammps_styles.hpp"

namespace clvotess {
namespace {

constexpr std::size_t spin_columns = 9;

// Compared as bits, which also orders NaN.
using Triple = std::array<std::uint64_t, 3>;

bool has_equal_pair(std::vector<Triple>& triples) {
    std::ranges::sort(triples);
    return std::ranges::adjacent_find(triples) != triples.end();
}

class DataReader {
public:
    DataReader(std::string_view text, const std::string& name, const ReadRequest& request)
        : lines_(text, name), request_(request) {}

    Input read() {
        std::string_view line;
        (void)lines_.next(line);  // the first line is a comment; LAMMPS itself ends it with "units = metal"
        split_words(line, words_);
        for (std::size_t k = 2; k < words_.size(); ++k) {
            if (words_[k - 2] == "units" && words_[k - 1] == "=") units_ = words_[k];
        }
        while (lines_.next(line)) {
            const auto mark = std::min(line.find('#'), line.size());
            split_words(line.substr(0, mark), words_);
            if (words_.empty()) continue;
            if (words_[0] == "Atoms" && words_.size() == 1) {
                Words hint;
                const std::string_view comment = line.substr(std::min(mark + 1, line.size()));
                split_words(comment, hint);
                take_names(comment, true);
                if (named_ || !knows_style(hint)) hint.clear();  // an unrelated comment
                return read_atoms(hint);
            }
            read_header();
        }
        throw lines_.error("the file ends before its section Atoms");
    }

private:
    // Reads `N atoms`, `lo hi xlo xhi`, `xy xz yz xy xz yz`, `x y z avec`, `x y z abc origin`. Skips other lines and
    // sections.
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
        constexpr std::array<std::string_view, 3> edges{"avec", "bvec", "cvec"};
        for (std::size_t k = 0; k < 3; ++k) {
            if (n == 4 && words_[3] == edges[k]) read_vector(box_.edges[k], edges_seen_[k]);
        }
        if (n == 5 && words_[3] == "abc" && words_[4] == "origin") read_vector(box_.corner, corner_seen_);
    }

    void read_vector(LammpsBox::Vector3& vector, bool& seen) {
        for (std::size_t axis = 0; axis < 3; ++axis) vector[axis] = lines_.number(words_[axis]);
        box_.general = seen = true;
    }

    // Stores the words if they name columns, in a line before the rows or after `Atoms #`.
    void take_names(std::string_view line, bool commented) {
        names_text_ = lower_case(line);
        Words names;
        split_words(names_text_, names);
        named_ = columns_by_names(names);
        names_commented_ = commented;
    }

    // Returns the columns of rows of `size` words: by the words after `Atoms #`, by names, else by their number. A
    // comment that does not fit the rows is ignored.
    [[nodiscard]] AtomColumns columns_of(const Words& hint, std::size_t size) const {
        const bool fits = named_ && (size == named_->names.size() || size == named_->names.size() + 3);
        if (named_ && !fits && !names_commented_) {
            throw lines_.error("this row has " + columns_text(size) + ", but " + std::to_string(named_->names.size()) +
                               " are named before the rows");
        }
        if (hint.empty()) return fits ? *named_ : columns_by_size(size, lines_);
        AtomColumns columns = columns_of_style(hint, size, lines_);
        if (!fits) return columns;
        if (columns.x != named_->x) {
            throw lines_.error("x is column " + std::to_string(columns.x + 1) + " of atom style " + in_quotes(hint[0]) +
                               ", but column " + std::to_string(named_->x + 1) +
                               " of those named before the rows: correct one of them");
        }
        return columns.names.back().empty() ? *named_ : columns;
    }

    // Throws Failure if the assumed image flags may be coordinates or values of style spin. Image flags are equal for
    // some atoms, coordinates for none. The four values of spin follow z.
    void check_guess(const std::vector<double>& points, std::vector<Triple>& flags) const {
        std::vector<Triple> places(flags.size());
        for (std::size_t i = 0; i < places.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) places[i][k] = std::bit_cast<std::uint64_t>(points[3 * i + k]);
        }
        if (!four_whole_ && has_equal_pair(flags) && !has_equal_pair(places)) return;
        throw lines_.error("which columns are the coordinates is not sure: " + std::string(ask_for_style));
    }

    // Adds a column `radius` after those of the file: half of the diameter.
    void find_wanted(const AtomColumns& columns, Input& input) {
        Words names = columns.names;
        const auto diameter = find_name(names, "diameter");
        if (find_name(request_.columns, "radius") && diameter && !find_name(names, "radius")) {
            diameter_ = *diameter;
            half_ = names.size();
            names.push_back("radius");
        }
        wanted_.emplace(request_, names, lines_.name());
        const std::array<std::size_t, 4> taken{0, columns.x, columns.x + 1, columns.x + 2};
        if (request_.all_columns) wanted_->add_others(names, taken, words_);
        wanted_->find_words(words_);
        input.columns = wanted_->columns(static_cast<std::size_t>(*count_));
    }

    Input read_atoms(const Words& hint) {
        if (!count_) throw lines_.error("the section Atoms comes before the line \"N atoms\"");
        if (box_.general && !(edges_seen_[0] && edges_seen_[1] && edges_seen_[2] && corner_seen_))
            throw lines_.error("the header lacks a part of the box: lines with avec, bvec, cvec and abc origin");
        const bool has_box = box_.general || (bounds_seen_[0] && bounds_seen_[1] && bounds_seen_[2]);
        if (!has_box) throw lines_.error("the header lacks the box: lines with xlo xhi, ylo yhi and zlo zhi");
        if (const std::string problem = box_.problem(); !problem.empty()) throw lines_.error(problem);

        Input input;
        input.domain = box_.domain();
        if (!units_.empty()) input.units.push_back({"units", std::string(units_)});
        const auto count = static_cast<std::size_t>(*count_);
        constexpr std::size_t shortest_row = 10;
        if (!can_hold(lines_.rest().size(), count, shortest_row)) throw short_section(0);
        input.points.reserve(3 * count);
        input.ids.reserve(count);
        AtomColumns columns;
        std::vector<Triple> flags;  // with guessed columns
        std::size_t row_size = 0;
        while (input.ids.size() < count) {
            std::string_view line;
            if (!lines_.next(line)) throw short_section(input.ids.size());
            const auto mark = std::min(line.find('#'), line.size());
            split_words(line.substr(0, mark), words_);
            if (row_size == 0 && (words_.empty() ? !named_ : !read_double(words_[0]))) {
                take_names(words_.empty() ? line.substr(std::min(mark + 1, line.size())) : line.substr(0, mark),
                           words_.empty());
                if (named_) continue;
            }
            if (words_.empty()) continue;
            if (row_size == 0) {
                row_size = words_.size();
                columns = columns_of(hint, row_size);
                four_whole_ = row_size == spin_columns;
                find_wanted(columns, input);
            }
            if (words_.size() != row_size) {
                throw lines_.error("this row has " + columns_text(words_.size()) + ", the rows before it have " +
                                   std::to_string(row_size));
            }
            input.ids.push_back(lines_.whole(words_[0], "an id"));
            for (std::size_t k = 0; k < 3; ++k) input.points.push_back(lines_.number(words_[columns.x + k]));
            four_whole_ = four_whole_ && read_int64(words_[columns.x + 2]);
            if (columns.guessed && columns.names.size() < row_size) flags.emplace_back();
            for (std::size_t k = columns.names.size(); k < row_size; ++k) {
                const auto flag = read_int64(words_[k]);
                if (!flag) {
                    throw lines_.error(in_quotes(words_[k]) + " is not a whole number, as an image flag must be" +
                                       (columns.guessed ? std::string("; ") + ask_for_style : ""));
                }
                if (columns.guessed) flags.back()[k - columns.names.size()] = static_cast<std::uint64_t>(*flag);
            }
            wanted_->append(
                input, [this](std::size_t k) { return words_[k]; },
                [this](std::size_t k, const std::string& column) {
                    return half_ == k ? 0.5 * lines_.number(words_[diameter_], column)
                                      : lines_.number(words_[k], column);
                });
        }
        if (!flags.empty()) check_guess(input.points, flags);
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
    std::string_view units_;
    LammpsBox box_;
    std::array<bool, 3> bounds_seen_{}, edges_seen_{};
    bool corner_seen_ = false;
    std::string names_text_;
    std::optional<AtomColumns> named_;  // points into names_text_
    bool names_commented_ = false;
    bool four_whole_ = false;  // the last four columns, in rows as long as those of style spin
    std::optional<ColumnPlaces> wanted_;
    std::size_t diameter_ = 0;
    std::optional<std::size_t> half_;  // column of the radius, if requested
};

}  // namespace

Input parse_lammps_data(std::string_view text, const std::string& name, const ReadRequest& request) {
    return DataReader(text, name, request).read();
}

}  // namespace clvotess
