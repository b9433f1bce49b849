#include "write/text_format.hpp"

#include <utility>

#include "failure.hpp"

namespace clvotess {

TextFormat::TextFormat(std::string_view format, bool like_voropp) : like_voropp_(like_voropp) {
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
        } else if (codes.find(format[at]) != std::string_view::npos) {
            end_literal();
            pieces_.push_back({format[at], {}});
        } else {
            throw bad_input("--format has the code " + in_quotes(format.substr(at - 1, 2)) +
                            ", known are %i %x %y %z %q %r %w %p %P %o %m %g %E %s %e %F %A %a %f %t %l %n %v %c %C "
                            "and %%");
        }
    }
    end_literal();
}

char TextFormat::first_of(std::string_view of_codes) const {
    for (const FormatPiece& piece : pieces_)
        if (piece.code != 0 && of_codes.find(piece.code) != std::string_view::npos) return piece.code;
    return 0;
}

void TextFormat::add_needs(votess::Want& want) const {
    using votess::Want;
    constexpr std::pair<std::string_view, bool Want::*> needs[] = {
        {"n", &Want::neighbors}, {"v", &Want::volumes},   {"cC", &Want::centroids}, {"f", &Want::areas},
        {"F", &Want::surfaces},  {"l", &Want::normals},   {"m", &Want::radii},      {"wsg", &Want::counts},
        {"pP", &Want::vertices}, {"oEeAat", &Want::faces}};
    for (const auto& [of_codes, member] : needs) want.*member |= has_any(of_codes);
}

}  // namespace clvotess
