#include "text_format.hpp"

#include <algorithm>

#include "failure.hpp"

namespace clvotess {

TextFormat::TextFormat(std::string_view format) {
    constexpr std::string_view known = "ixyzqwsnvcfF";
    if (format.empty()) throw bad_input("--format is empty: give codes such as \"%i %n\"");
    if (format.find('\n') != std::string_view::npos) throw bad_input("--format holds a line end: one cell is one line");
    std::string literal;
    const auto end_literal = [&] {
        if (!literal.empty()) pieces_.push_back({0, literal});
        literal.clear();
    };
    for (std::size_t at = 0; at < format.size(); ++at) {
        if (format[at] != '%') {
            literal += format[at];
            continue;
        }
        if (++at == format.size()) throw bad_input("--format ends with a single %: write %% for a percent sign");
        if (format[at] == '%') {
            literal += '%';
        } else if (known.find(format[at]) != std::string_view::npos) {
            end_literal();
            pieces_.push_back({format[at], {}});
        } else {
            throw bad_input("--format has the code " + in_quotes(format.substr(at - 1, 2)) +
                            ", this version knows %i %x %y %z %q %w %s %n %v %c %f %F and %%");
        }
    }
    end_literal();
}

void TextFormat::add_needs(votess::Want& want) const {
    for (const FormatPiece& piece : pieces_) {
        switch (piece.code) {
            case 'n':
                want.neighbors = true;
                break;
            case 'v':
                want.volumes = true;
                break;
            case 'c':
                want.centroids = true;
                break;
            case 'f':
            case 'F':
                want.areas = want.neighbors = true;
                break;
            case 'w':
            case 's':
                want.counts = true;
                break;
            default:
                break;
        }
    }
}

bool TextFormat::needs_walls() const {
    return std::ranges::any_of(pieces_, [](const FormatPiece& piece) { return piece.code == 'F'; });
}

}  // namespace clvotess
