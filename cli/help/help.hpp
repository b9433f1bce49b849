// What clvotess tells about itself, made of the table of options.
#pragma once

#include <string>

namespace clvotess {

[[nodiscard]] std::string usual_help();                          // --help
[[nodiscard]] std::string whole_help();                          // --help-all
[[nodiscard]] std::string manual_page();                         // --man: in roff
[[nodiscard]] std::string completion(const std::string& shell);  // Throws Failure unless it is bash, zsh or fish.

}  // namespace clvotess
