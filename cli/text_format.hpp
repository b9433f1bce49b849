// --format: text rows with the codes of Voro++ 0.4.6.
#pragma once

#include <string>
#include <string_view>
#include <vector>
#include <votess/votess.hpp>

namespace clvotess {

struct FormatPiece {
    char code = 0;        // one of i x y z q w s n v c f F; 0: the literal text
    std::string literal;  // printed as it is
};

class TextFormat {
public:
    // Throws Failure on an unknown code.
    explicit TextFormat(std::string_view format);

    [[nodiscard]] const std::vector<FormatPiece>& pieces() const noexcept { return pieces_; }
    // Adds to `want` the arrays that the codes print.
    void add_needs(votess::Want& want) const;
    // A surface is whole only when the rows list walls.
    [[nodiscard]] bool needs_walls() const;

private:
    std::vector<FormatPiece> pieces_;
};

}  // namespace clvotess
