#include "arguments/typed.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>
#include <utility>

#include "failure.hpp"
#include "files/numbers.hpp"

namespace clvotess {
namespace {

// Edit distance with swaps of neighbors, row by row.
std::size_t changes(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before_last, last, row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        before_last = std::exchange(last, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before_last[j - 2] + 1);
        }
    }
    return row.back();
}

// Returns the word with the fewest changes of a letter, the first of several. A change inserts, deletes or replaces a
// letter, or swaps two neighbors. Returns nothing if each word takes more changes than a third of its length.
std::optional<std::string> nearest_word(std::string_view typed, const std::vector<std::string>& words) {
    constexpr std::size_t longest = 64;
    if (typed.size() > longest) return std::nullopt;
    std::optional<std::string> nearest;
    std::size_t fewest = longest;
    for (const std::string& word : words) {
        // The beginning of a word is one change away, however long the rest is.
        const bool begins = typed.size() >= 3 && word.starts_with(typed);
        const std::size_t count = begins ? 1 : changes(typed, word);
        if (count >= fewest || 3 * count > word.size()) continue;
        fewest = count;
        nearest = word;
    }
    return nearest;
}

// Drops a value after =, and all minus signs in front: a single one is a common slip.
[[noreturn]] void refuse_unknown(const std::string& word) {
    if (word == "--voro++") throw bad_input("--voro++ must be the first argument: move it to the front");
    std::string name = word.substr(0, word.find('='));
    name.erase(0, name.find_first_not_of('-'));
    std::vector<std::string> names;
    each_option([&](const Option& option) { names.push_back(long_name(option).substr(2)); });
    const auto nearest = nearest_word(name, names);
    const auto longer = std::ranges::find_if(
        names, [&](const std::string& known) { return known.ends_with("-" + name) && nearest != known; });
    std::string meant = nearest ? "--" + *nearest : "";
    if (!name.empty() && longer != names.end()) meant += (meant.empty() ? "--" : " or --") + *longer;
    throw bad_input("unknown option " + in_quotes(word) +
                    (meant.empty() ? ": clvotess --help-all lists all options" : ": did you mean " + meant + "?"));
}

// message: from CLI11; it begins with the name of the option.
[[noreturn]] void refuse_values(CLI::App& app, const std::string& message) {
    std::string name = message.substr(0, message.find_first_of(": "));
    if (!name.starts_with('-')) name.insert(0, "--");
    const CLI::Option* const option = app.get_option_no_throw(name);
    if (!option) throw bad_input(message + ", see clvotess --help");
    if (option->get_items_expected_max() == 0)
        throw bad_input(name + " takes no value: remove = and the text after it");
    const std::size_t given = option->results().size();
    if (given > 1) throw bad_input(name + " is given " + std::to_string(given) + " times: give it once");
    throw bad_input(name + " needs a value: " + std::string(find_option(name)->names));
}

// Returns the option as CLI11 takes it; null for --voro++, which is not among others.
CLI::Option* add(CLI::App& app, const Option& option) {
    std::string names;
    for (const std::string_view name : names_of(option)) names += (names.empty() ? "" : ",") + std::string(name);
    const std::string_view value = value_of(option);
    if (names == "--voro++") return nullptr;
    if (names.empty()) return app.add_option(std::string(option.names));
    if (value.empty()) return app.add_flag(names)->disable_flag_override();
    CLI::Option* const added = app.add_option(names);
    if (option.traits.repeats)
        return added->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args(false);
    return value.starts_with('[') ? added->expected(0, 1) : added;
}

void read_one(const Typed& /*typed*/, const std::string& /*name*/, bool& to) {
    to = true;
}
void read_one(const Typed& typed, const std::string& name, unsigned& to) {
    to = static_cast<unsigned>(whole_number(name, *typed.value(name), std::numeric_limits<unsigned>::max()));
}
void read_one(const Typed& typed, const std::string& name, double& to) {
    const auto number = read_double(*typed.value(name));
    if (!number) throw bad_input(name + " must be a number, not " + in_quotes(*typed.value(name)));
    to = *number;
}
void read_one(const Typed& typed, const std::string& name, std::string& to) {
    to = *typed.value(name);
}
template <class Enum>
void read_one(const Typed& typed, const std::string& name, Enum& to) {
    typed.read_word(name, to);
}

}  // namespace

// CLI11 only splits the command line, so that our messages can name a remedy.
Typed::Typed(int count, const char* const* values) {
    CLI::App app;
    app.set_help_flag();
    std::map<std::string, CLI::Option*> added;
    each_option([&](const Option& option) { added[long_name(option)] = add(app, option); });
    try {
        app.parse(count, values);
    } catch (const CLI::ExtrasError&) {
        const auto extras = app.remaining();
        const std::string first = extras.empty() ? "" : extras.front();
        if (first.starts_with('-')) refuse_unknown(first);
        throw bad_input("only one INPUT is possible, but " + in_quotes(first) + " is a second: " +
                        (read_double(first) ? "join the numbers of an option by commas, as in --box 0,0,0,1,1,1"
                                            : "run clvotess for each"));
    } catch (const CLI::ArgumentMismatch& error) {
        refuse_values(app, error.what());
    } catch (const CLI::ParseError& error) {
        throw bad_input(std::string(error.what()) + ", see clvotess --help");
    }
    for (const auto& [name, option] : added) values_[name] = option ? option->results() : std::vector<std::string>();
}

int Typed::word_index(std::string_view name) const {
    const auto words = words_of(*find_option(name));
    const std::string& typed = *value(name);
    std::string known;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (words[i] == typed) return static_cast<int>(i);
        known += std::string(i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + std::string(words[i]);
    }
    throw bad_input(std::string(name) + " must be " + known + ", not " + in_quotes(typed));
}

void Typed::read_members(votess::Options& options) const {
    each_option([&](const Option& option) {
        const std::string name = long_name(option);
        const auto read = [&](auto member) {
            if constexpr (!std::is_same_v<decltype(member), std::monostate>) read_one(*this, name, options.*member);
        };
        if (has(name)) std::visit(read, option.traits.member);
    });
}

std::uint64_t whole_number(const std::string& option, const std::string& text, std::uint64_t max) {
    const auto value = read_uint64(text);
    if (value && *value <= max) return *value;
    throw bad_input(option + " must be a whole number from 0 to " + std::to_string(max) + ", not " + in_quotes(text));
}

}  // namespace clvotess
