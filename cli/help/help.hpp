// Help texts, manual page and completions, generated from the table of options.
#pragma once

#include <string>
#include <string_view>

namespace clvotess {

[[nodiscard]] std::string usual_help();                          // --help
[[nodiscard]] std::string whole_help();                          // --help-all
[[nodiscard]] std::string manual_page();                         // --man: in roff
[[nodiscard]] std::string completion(const std::string& shell);  // throws Failure unless it is bash, zsh or fish

}  // namespace clvotess
