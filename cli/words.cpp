#include "words.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "options.hpp"

namespace clvotess {
namespace {

using Renamed = std::pair<std::string_view, std::string_view>;

// Members that have another name here than "--" and their own.
constexpr std::array<Renamed, 9> renamed_members{{{"planar", "--2d"},
                                                  {"walls", "--wall"},
                                                  {"cell.origin", "--origin"},
                                                  {"cell.periodic", "--periodic"},
                                                  {"mesh.merge", "--mesh-repair"},
                                                  {"mesh.tolerance", "--mesh-tolerance"},
                                                  {"method", "--to-grid"},
                                                  {"skip_open", "--open skip"},
                                                  {"want", "--want"}}};
constexpr std::array<Renamed, 11> renamed_functions{{{"alpha_complex", "--alpha"},
                                                     {"fit_volumes", "--volumes"},
                                                     {"merge", "--merge"},
                                                     {"picture", "--image"},
                                                     {"pieces", "-o FILE in .glb, .obj, .stl or .3mf"},
                                                     {"probe", "--probe"},
                                                     {"tessellate", "clvotess"},
                                                     {"to_grid", "--to-grid"},
                                                     {"trace", "--trace"},
                                                     {"verify", "--verify"},
                                                     {"watershed", "--watershed"}}};

template <std::size_t count>
std::string_view word_for(const std::array<Renamed, count>& names, std::string_view name) {
    const auto found = std::ranges::find(names, name, &Renamed::first);
    return found == names.end() ? std::string_view() : found->second;
}

bool is_of_name(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// Returns the number of characters at the beginning that satisfy the condition.
template <class Condition>
std::size_t length_of(std::string_view text, const Condition& condition) {
    return static_cast<std::size_t>(std::ranges::find_if_not(text, condition) - text.begin());
}

std::string name_of_member(std::string_view member) {
    if (const std::string_view other = word_for(renamed_members, member); !other.empty()) return std::string(other);
    if (member.starts_with("want.")) return "--want " + std::string(member.substr(member.find('.') + 1));
    std::string name = "--" + std::string(member);
    std::ranges::replace(name, '_', '-');
    return find_option(name) ? name : std::string(member);
}

// Appends the option at the beginning of the text, after "Options::", with its value. Returns the rest.
std::string_view append_member(std::string_view text, std::string& to) {
    std::size_t length = length_of(text, is_of_name);
    if (length + 1 < text.size() && text[length] == '.' && is_of_name(text[length + 1]))
        length += 1 + length_of(text.substr(length + 1), is_of_name);
    to += name_of_member(text.substr(0, length));
    text.remove_prefix(length);
    constexpr std::string_view equals = " = ";
    if (!text.starts_with(equals)) return text;
    text.remove_prefix(equals.size());
    to += ' ';
    return text;
}

}  // namespace

std::string in_words_of_options(std::string_view message) {
    constexpr std::string_view call = "()";
    std::string text;
    while (!message.empty()) {
        const std::size_t length = length_of(message, is_of_name);
        const std::string_view word = message.substr(0, length), rest = message.substr(length);
        if (word.ends_with("Options") && rest.starts_with("::")) {
            message = append_member(rest.substr(2), text);
        } else if (const std::string_view option = word_for(renamed_functions, word);
                   rest.starts_with(call) && !option.empty()) {
            text += option;
            message = rest.substr(call.size());
        } else {
            const std::size_t taken = std::max<std::size_t>(length, 1);
            text += message.substr(0, taken);
            message.remove_prefix(taken);
        }
    }
    return text;
}

std::string open_cells(std::uint64_t count) {
    return std::to_string(count) + (count == 1 ? " cell that reaches infinity" : " cells that reach infinity");
}

}  // namespace clvotess
