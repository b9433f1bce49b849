// The table of options: every option of clvotess and of the library is stated there once.
//
// clvotess reads it to split the command line and to print --help, --help-all, the manual page and the completions.
// tools/options.py copies the options of the library into their other places: votess.hpp, votess.h, the checks of the
// engine and Python. A new option is one row, a run of tools/options.py, its use in the engine, and its test.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>
#include <votess/votess.hpp>

namespace clvotess {

// Members of votess::Options for options that are one flag, number, word or text. Words have the order of the
// enumerators.
using Flag = bool votess::Options::*;
using Count = unsigned votess::Options::*;
using Number = double votess::Options::*;
using Text = std::string votess::Options::*;
template <class Enum>
using Word = Enum votess::Options::*;
using Member = std::variant<std::monostate, Flag, Count, Number, Text, Word<votess::Outside>, Word<votess::Duplicates>,
                            Word<votess::Precision>>;

// What an option needs. Queries compute no cells. --memory never holds all cells or points, and ranks hold neither on
// one machine: clvotess-mpi refuses what follows `cells`.
enum class Needs { nothing, cells, all_cells, all_points, one_machine };

struct Traits {
    std::string_view brief = {};  // for --help; "" leaves the option out
    Member member = {};
    std::string_view start = {};                           // default; "" is 0 or an empty text
    double max = std::numeric_limits<double>::infinity();  // of a number; the least is 0
    std::string_view unit = {};                            // of a number
    Needs needs = Needs::nothing;
    std::string_view with = {};  // an option that must be there too, or some to choose from with | between
    bool repeats = false;        // may be given several times
    bool solid = false;          // needs three dimensions
    bool on_surface = false;     // goes with --surface
};

struct Option {
    std::string_view names;  // "-o, --output FILE": names, then the value; words to choose from with | between
    std::string_view text;   // for --help-all, in lines of at most 75 characters; "" continues in the next row
    Traits traits = {};
};

// Rows without names are headings.
[[nodiscard]] const std::vector<Option>& option_table();

// Calls use(option) for each row except headings.
template <class Use>
void each_option(Use use) {
    for (const Option& option : option_table())
        if (!option.names.empty()) use(option);
}

// Returns the parts of a text between separators; one empty part of an empty text.
[[nodiscard]] std::vector<std::string_view> split(std::string_view text, char separator);
// Returns the names without the value: "-o" and "--output"; the long one last. None of INPUT.
[[nodiscard]] std::vector<std::string_view> names_of(const Option& option);
// Returns "--output", or "INPUT".
[[nodiscard]] std::string long_name(const Option& option);
// Returns what follows the names: "FILE", "auto|cpu|gpu|lavapipe|INDEX", "[xyz|none]", or "" for a flag.
[[nodiscard]] std::string_view value_of(const Option& option);
// Returns the words that an option takes; none if its value is not a word.
[[nodiscard]] std::vector<std::string_view> words_of(const Option& option);
// Returns the option of that name, such as "--output"; null if there is none.
[[nodiscard]] const Option* find_option(std::string_view name);

}  // namespace clvotess
