// Every option of clvotess, told once: --help, --help-all, the manual page and the completions are made of this table.
#pragma once

#include <string_view>
#include <vector>

namespace clvotess {

struct HelpRow {
    std::string_view names;  // "-o, --output FILE": names, then what the value is; words to choose from with | between
    std::string_view brief;  // for --help; empty: the option is not among the usual ones
    std::string_view text;   // lines as they are printed; empty: told at the next row
};

struct HelpSection {
    std::string_view heading;
    std::vector<HelpRow> rows;
};

[[nodiscard]] const std::vector<HelpSection>& help_sections();

}  // namespace clvotess
