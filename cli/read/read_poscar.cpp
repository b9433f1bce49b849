// VASP's POSCAR and CONTCAR: comment, scale, three edges, species and their counts, then positions, as fractions of the
// edges or as lengths. The cell is periodic along all edges.
#include <array>
#include <cmath>

#include "failure.hpp"
#include "files/line_reader.hpp"
#include "read/input.hpp"

namespace clvotess {
namespace {

using Vector = std::array<double, 3>;

// Returns whether the text begins with a data block, as CIF does.
bool is_cif(std::string_view text, const std::string& name) {
    LineReader lines(text, name);
    std::string_view line;
    Words words;
    while (lines.next_filled(line)) {
        split_words(line, words);
        if (words[0][0] == '#') continue;
        return words.size() == 1 && lower_case(words[0].substr(0, 5)) == "data_" &&
               lines.rest().find("_cell_") != std::string_view::npos;
    }
    return false;
}

class PoscarReader {
public:
    PoscarReader(std::string_view text, const std::string& name, bool species)
        : lines_(text, name), wants_species_(species) {}

    Input read() {
        if (is_cif(lines_.rest(), lines_.name()))
            throw bad_input(lines_.name() + ": a CIF file: " + conversion(".cif"));
        (void)lines_.need("a comment");
        const Words scale = words_of("the scale of the cell");
        if (scale.size() != 1 && scale.size() != 3) throw lines_.error("expected one or three numbers, the scale");
        for (std::size_t k = 0; k < 3; ++k) scale_[k] = lines_.number(scale[scale.size() == 3 ? k : 0]);
        for (Vector& edge : edges_) edge = three(words_of("an edge of the cell"));
        take_scale();

        Words counts = words_of("the species"), species;
        if (!read_uint64(counts.at(0))) {
            species = counts;
            counts = words_of("the number of atoms of each species");
        }
        std::uint64_t count = 0;
        for (const std::string_view word : counts) {
            const auto number = read_uint64(word);
            constexpr std::uint64_t max = std::uint64_t{1} << 40;
            if (!number || *number > max) throw lines_.error(in_quotes(word) + " is not a number of atoms");
            count += *number;
            if (count > max) throw lines_.error("the numbers of atoms add up to more than " + std::to_string(max));
        }
        std::string how = lower_case(words_of("Direct or Cartesian")[0]);
        if (how[0] == 's') how = lower_case(words_of("Direct or Cartesian")[0]);  // Selective dynamics
        const bool lengths = how[0] == 'c' || how[0] == 'k';
        if (!lengths && how[0] != 'd') throw lines_.error("expected Direct or Cartesian, not " + in_quotes(how));
        if (!can_hold(lines_.rest().size(), count, 6)) {
            throw lines_.error(std::to_string(count) + " atoms are announced, but only " +
                               std::to_string(lines_.rest().size()) + " bytes follow");
        }

        Input input;
        input.points.reserve(3 * count);
        for (std::uint64_t i = 0; i < count; ++i) {
            const Vector x = three(words_of("atom " + std::to_string(i + 1) + " of " + std::to_string(count)));
            for (std::size_t k = 0; k < 3; ++k) {
                input.points.push_back(lengths ? scale_[k] * x[k]
                                               : x[0] * edges_[0][k] + x[1] * edges_[1][k] + x[2] * edges_[2][k]);
            }
        }
        if (wants_species_ && species.size() == counts.size()) {
            for (std::size_t k = 0; k < counts.size(); ++k)
                input.species.insert(input.species.end(), *read_uint64(counts[k]), std::string(species[k]));
        }
        input.domain.periodic_from = DomainSource::assumed;
        input.domain.cell = votess::TriclinicBox{.a = edges_[0], .b = edges_[1], .c = edges_[2]};
        return input;
    }

private:
    Words words_of(const std::string& what) {
        Words words;
        split_words(lines_.need(what), words);
        if (words.empty()) throw lines_.error("an empty line instead of " + what);
        return words;
    }

    // Returns the first three words of a line. Flags may follow them.
    [[nodiscard]] Vector three(const Words& words) const {
        if (words.size() < 3) throw lines_.error("expected three numbers, not " + columns_text(words.size()));
        return {lines_.number(words[0]), lines_.number(words[1]), lines_.number(words[2])};
    }

    // Applies the scale. A negative scale is the volume of the cell.
    void take_scale() {
        if (scale_[0] < 0) {
            const auto& [a, b, c] = edges_;
            const double volume = std::abs(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                                           a[2] * (b[0] * c[1] - b[1] * c[0]));
            scale_.fill(std::cbrt(-scale_[0] / volume));
        }
        for (const double scale : scale_) {
            if (!(scale > 0 && std::isfinite(scale))) throw lines_.error("the scale of the cell is not positive");
        }
        for (Vector& edge : edges_) {
            for (std::size_t k = 0; k < 3; ++k) edge[k] *= scale_[k];
        }
    }

    LineReader lines_;
    bool wants_species_;
    Vector scale_{};
    std::array<Vector, 3> edges_{};
};

}  // namespace

Input parse_poscar(std::string_view text, const std::string& name, const ReadRequest& request) {
    const bool carried =
        request.columns == std::vector<std::string>{"species"} && request.first_carried == 0 && request.carries_words;
    if (!request.columns.empty() && !carried && !request.columns_may_lack)
        throw bad_input(name + ": a POSCAR has no column " + in_quotes(request.columns[0]));
    Input input = PoscarReader(text, name, request.species || carried).read();
    if (!carried) return input;
    if (input.species.size() != input.size()) throw bad_input(name + ": this POSCAR does not name its species");
    input.columns.push_back({.name = "species", .words = input.species, .of_words = true});
    return input;
}

}  // namespace clvotess
