// Help texts, manual page and completions, generated from the table of options.
#pragma once

#include <string>
#include <string_view>

namespace clvotess {

[[nodiscard]] std::string usual_help();                          // --help
[[nodiscard]] std::string whole_help();                          // --help-all
[[nodiscard]] std::string manual_page();                         // --man: in roff
[[nodiscard]] std::string completion(const std::string& shell);  // Throws Failure unless it is bash, zsh or fish.
// Returns the names of an option and its value, as in --help: "-o, --output FILE". Returns "" for an unknown one.
[[nodiscard]] std::string_view usage_of(std::string_view option);

}  // namespace clvotess
