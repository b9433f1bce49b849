// --format: text rows with the codes of Voro++ 0.4.6.
#pragma once

#include <string>
#include <string_view>
#include <vector>
#include <votess/votess.hpp>

namespace clvotess {

struct FormatPiece {
    char code = 0;        // one of TextFormat::codes; 0: literal text
    std::string literal;  // printed unchanged
};

class TextFormat {
public:
    static constexpr std::string_view codes = "ixyzqrwpPomgEesFAaftlnvcC";

    // like_voropp: six digits for each number, and no row for a seed without a cell. Throws Failure for an unknown
    // code.
    explicit TextFormat(std::string_view format, bool like_voropp = false);

    [[nodiscard]] bool like_voropp() const noexcept { return like_voropp_; }

    [[nodiscard]] const std::vector<FormatPiece>& pieces() const noexcept { return pieces_; }
    [[nodiscard]] bool has_any(std::string_view of_codes) const { return first_of(of_codes) != 0; }
    // Returns the first code that needs three dimensions; 0 without one.
    [[nodiscard]] char solid_code() const { return first_of("zaAeEot"); }
    // Adds to `want` the arrays that the codes print.
    void add_needs(votess::Want& want) const;

private:
    [[nodiscard]] char first_of(std::string_view of_codes) const;

    std::vector<FormatPiece> pieces_;
    bool like_voropp_ = false;
};

}  // namespace clvotess
