// LAMMPS dumps in text: frames of `ITEM:` blocks. The box of the frame, with tilt and periodic axes, becomes the
// domain.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "failure.hpp"
#include "files/line_reader.hpp"
#include "read/columns.hpp"
#include "read/input.hpp"
#include "read/lammps/lammps_box.hpp"
#include "read/rows_by_threads.hpp"
#include "read/text_frames.hpp"

namespace clvotess {
namespace {

// The columns of x, y, z, and their scaling.
struct Place {
    std::vector<std::size_t> columns;
    bool scaled = false;
};

class DumpReader {
public:
    DumpReader(const std::string& name, const ReadRequest& request) : lines_({}, name), request_(request) {}

    Input read_frame(std::string_view text) {
        read_header(text);
        return read_atoms();
    }
    void skip_frame(std::string_view text) { read_header(text); }

    // Appends all rows of the text.
    void append_rows(Input& input) {
        while (append_row(input)) {
        }
    }
    [[nodiscard]] LineReader& lines() noexcept { return lines_; }
    [[nodiscard]] const LineReader& lines() const noexcept { return lines_; }

private:
    // Reads a frame up to the line ITEM: ATOMS.
    void read_header(std::string_view text) {
        lines_.go_on(text);
        count_.reset();
        has_box_ = false;
        timestep_.clear();
        std::string_view line;
        bool begun = false;
        while (lines_.next(line)) {
            split_words(line, words_);
            if (words_.empty()) continue;
            if (words_[0] != "ITEM:") {
                if (begun || frames_ > 0) {
                    throw lines_.error("more rows than the ITEM: NUMBER OF ATOMS of the frame before");
                }
                throw lines_.error("no LAMMPS dump in text: it must begin with ITEM: TIMESTEP");
            }
            begun = true;
            const std::string_view item = line.substr(line.find("ITEM:") + 5);
            const std::string_view head = item.substr(std::min(item.find_first_not_of(' '), item.size()));
            if (head.starts_with("TIMESTEP")) {
                split_words(lines_.need("the timestep"), words_);
                if (words_.size() != 1 || !read_double(words_[0]))
                    throw lines_.error("expected one number, the timestep");
                timestep_ = words_[0];
            } else if (head.starts_with("NUMBER OF ATOMS")) {
                read_count();
            } else if (head.starts_with("BOX BOUNDS")) {
                read_box();
            } else if (head.starts_with("ATOMS")) {
                if (!count_ || !has_box_) {
                    throw lines_.error("ITEM: ATOMS before ITEM: NUMBER OF ATOMS and ITEM: BOX BOUNDS");
                }
                ++frames_;
                return;
            } else if (head.starts_with("UNITS")) {
                split_words(lines_.need("the units"), words_);
                if (words_.size() == 1) units_ = words_[0];
            } else if (head.starts_with("TIME")) {
                (void)lines_.need("its value");
            } else {
                throw lines_.error("unknown block " + in_quotes(line));
            }
        }
        throw lines_.error("the file ends before the atoms of a frame");
    }

    void read_count() {
        split_words(lines_.need("the number of atoms"), words_);
        const auto count = words_.size() == 1 ? read_uint64(words_[0]) : std::nullopt;
        if (!count) throw lines_.error("expected one whole number, the number of atoms");
        if (!can_hold(lines_.rest().size(), *count, 2)) {
            throw lines_.error(std::to_string(*count) + " atoms are announced, but only " +
                               std::to_string(lines_.rest().size()) + " bytes follow");
        }
        count_ = *count;
    }

    void read_box() {
        // words_: ITEM: BOX BOUNDS [xy xz yz | abc origin] bx by bz, or without the boundaries in old files.
        const bool tilted = words_.size() >= 6 && words_[3] == "xy";
        box_ = {};
        box_.general = words_.size() >= 5 && words_[3] == "abc" && words_[4] == "origin";
        const std::size_t first = tilted ? 6 : box_.general ? 5 : 3;
        if (words_.size() == first + 3) {
            for (std::size_t k = 0; k < 3; ++k) box_.periodic[k] = words_[first + k] == "pp";
            box_.periodic_from = DomainSource::stated;
        } else if (words_.size() != first) {
            throw lines_.error("expected three boundaries such as pp pp ff");
        }
        std::array<double, 3> tilt{};
        for (std::size_t k = 0; k < 3; ++k) {
            split_words(lines_.need("the bounds of the box"), words_);
            if (box_.general) {
                if (words_.size() != 4)
                    throw lines_.error("expected x y z of an edge of the box, and one of its corner");
                for (std::size_t axis = 0; axis < 3; ++axis) box_.edges[k][axis] = lines_.number(words_[axis]);
                box_.corner[k] = lines_.number(words_[3]);
                continue;
            }
            if (words_.size() != (tilted ? 3u : 2u)) {
                throw lines_.error(tilted ? "expected lo hi tilt, the bounds of a tilted box"
                                          : "expected lo hi, the bounds of the box");
            }
            box_.lower[k] = lines_.number(words_[0]);
            box_.upper[k] = lines_.number(words_[1]);
            if (tilted) tilt[k] = lines_.number(words_[2]);
        }
        box_.xy = tilt[0];
        box_.xz = tilt[1];
        box_.yz = tilt[2];
        box_.take_off_bounds();
        if (const std::string problem = box_.problem(); !problem.empty()) throw lines_.error(problem);
        has_box_ = true;
    }

    [[nodiscard]] Failure short_frame(std::uint64_t rows) const {
        return lines_.error("the file ends after " + std::to_string(rows) + " of the " + std::to_string(*count_) +
                            " atoms of its frame");
    }

    [[nodiscard]] Place find_place(const Words& names) const {
        if (!request_.coordinates.empty()) {
            Place place;
            for (const std::string& name : request_.coordinates) {
                const auto found = find_name(names, name);
                if (!found) throw lines_.error("no column " + in_quotes(name) + " of --columns");
                place.columns.push_back(*found);
            }
            constexpr std::array<std::string_view, 2> fractions{"xs", "xsu"};
            place.scaled = std::ranges::find(fractions, request_.coordinates[0]) != fractions.end();
            return place;
        }
        for (const auto& [suffix, scaled] : {std::pair{"", false}, {"u", false}, {"s", true}, {"su", true}}) {
            const auto x = find_name(names, std::string("x") + suffix);
            const auto y = find_name(names, std::string("y") + suffix);
            const auto z = find_name(names, std::string("z") + suffix);
            if (x && y && z) return {{*x, *y, *z}, scaled};
            if (x && y && request_.dimensions == Dimensions::two) return {{*x, *y}, scaled};
        }
        throw lines_.error("no columns x y z, xu yu zu, xs ys zs or xsu ysu zsu");
    }

    // Appends the next row. Returns false at the end of the text.
    bool append_row(Input& input) {
        std::string_view line;
        if (!lines_.next(line)) return false;
        split_words(line, words_);
        if (words_.size() != names_.size()) {
            throw lines_.error("this row has " + columns_text(words_.size()) + ", " + std::to_string(names_.size()) +
                               " are announced");
        }
        std::array<double, 3> position{};
        const std::size_t size = place_.columns.size();
        for (std::size_t k = 0; k < size; ++k) position[k] = lines_.number(words_[place_.columns[k]]);
        if (place_.scaled) position = box_.unscaled(position);
        if (first_) {
            std::vector<std::size_t> taken = place_.columns;
            taken.push_back(id_.value_or(names_.size()));
            if (request_.all_columns) wanted_->add_others(names_, taken, words_);
            wanted_->find_words(words_);
            first_ = false;
        }
        if (input.points.empty()) {
            input.columns = wanted_->columns(max_rows());
            input.dimensions = size;
        }
        input.points.insert(input.points.end(), position.begin(), position.begin() + static_cast<std::ptrdiff_t>(size));
        if (id_) input.ids.push_back(lines_.whole(words_[*id_], "an id"));
        wanted_->append(
            input, [&](std::size_t k) { return words_[k]; },
            [&](std::size_t k, const std::string& column) { return lines_.number(words_[k], column); });
        return true;
    }
    // Returns how many rows may follow.
    [[nodiscard]] std::size_t max_rows() const {
        return std::min(static_cast<std::size_t>(*count_), lines_.rest().size() / (2 * names_.size()) + 2);
    }

    Input read_atoms() {
        names_.assign(words_.begin() + 2, words_.end());
        place_ = find_place(names_);
        id_ = find_name(names_, "id");
        wanted_.emplace(request_, names_, lines_.name(), species_names_of_dump);
        first_ = true;

        Input input;
        input.domain = box_.domain();
        if (!units_.empty()) input.units.push_back({"units", units_});
        input.timestep = timestep_;
        const auto count = static_cast<std::size_t>(*count_);
        if (!can_hold(lines_.rest().size(), count, 2 * names_.size())) throw short_frame(0);
        input.points.reserve(3 * count);
        if (id_) input.ids.reserve(count);
        input.columns = wanted_->columns(0);  // of a frame without atoms
        for (std::size_t i = 0; i < count; i = input.size()) {
            if (!append_row(input)) throw short_frame(i);
            if (i == 0) append_by_threads(*this, input, count, request_.threads);
        }
        return input;
    }

    LineReader lines_;
    ReadRequest request_;
    Words words_;
    std::optional<std::uint64_t> count_;
    bool has_box_ = false;
    std::uint64_t frames_ = 0;  // begun
    std::string timestep_;
    std::string units_;  // metal, lj, ...; the first frame states them
    LammpsBox box_;
    // Names and places of the atoms.
    Words names_;
    Place place_;
    std::optional<std::size_t> id_;
    std::optional<ColumnPlaces> wanted_;
    bool first_ = false;  // whether the next row is the first
};

}  // namespace

std::unique_ptr<InputFrames> open_dump_frames(std::unique_ptr<TextSource> source, const ReadRequest& request) {
    return std::make_unique<TextFrames<DumpReader>>(std::move(source), FrameKind::lammps_dump, request);
}

}  // namespace clvotess
