// The command line, split into options and their values.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>
#include <votess/votess.hpp>

#include "options.hpp"

namespace clvotess {

class Typed {
public:
    // Throws Failure for an unknown option, and for too few or too many values.
    Typed(int count, const char* const* values);

    // Whether an option was typed. name: the long one, "--output" or "INPUT".
    [[nodiscard]] bool has(std::string_view name) const { return !values(name).empty(); }
    // Returns the value of an option, null if it was not typed.
    [[nodiscard]] const std::string* value(std::string_view name) const {
        return has(name) ? &values(name).front() : nullptr;
    }
    [[nodiscard]] const std::vector<std::string>& values(std::string_view name) const {
        return values_.at(std::string(name));
    }
    // Sets a value by the word that was typed, if one was: the enumerators have the order of the words.
    template <class Enum>
    void read_word(std::string_view name, Enum& to) const {
        if (has(name)) to = static_cast<Enum>(word_index(name));
    }
    // Sets the members that the table of options names.
    void read_members(votess::Options& options) const;

private:
    [[nodiscard]] int word_index(std::string_view name) const;

    std::map<std::string, std::vector<std::string>> values_;  // by the long name; one for each option
};

// Throws Failure unless the text is a whole number from 0 to max. The ranges of Options are checked by the library.
[[nodiscard]] std::uint64_t whole_number(const std::string& option, const std::string& text, std::uint64_t max);

}  // namespace clvotess
