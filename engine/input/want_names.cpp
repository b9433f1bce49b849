// The names of arrays, and the groups of Want that they belong to.
#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "core/text.hpp"
#include "result/arrays.hpp"
#include "votess/votess.hpp"

namespace votess {
namespace {

// Returns the arrays whose name is not that of their group. Weights are input, which nobody wants.
std::vector<GroupInfo> named_arrays() {
    std::vector<GroupInfo> arrays{{"cell_vertices", &Want::vertices, 0}};
    for_all_arrays([&](const auto& array) {
        if (array.name != "weights" &&
            std::ranges::find(array_groups, array.name, &GroupInfo::name) == std::end(array_groups))
            arrays.push_back({array.name, array.word, 0});
    });
    return arrays;
}

std::string list(const auto& names) {
    std::string text;
    for (const GroupInfo& name : names) text += (text.empty() ? "" : ", ") + std::string(name.name);
    return text;
}

std::string_view without_blanks(std::string_view text) {
    const auto begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

// Returns a question for the first name that begins with the text, as volumes does with volume; or nothing.
std::string guess(std::string_view text, std::span<const GroupInfo> arrays) {
    constexpr std::size_t shortest = 3;
    if (text.size() < shortest) return {};
    for (const std::span<const GroupInfo> names : {std::span<const GroupInfo>(array_groups), arrays})
        for (const GroupInfo& name : names)
            if (name.name.starts_with(text)) return "did you mean " + std::string(name.name) + "? Else ";
    return {};
}

void add(std::string_view text, Want& want) {
    const auto find = [&](const auto& names) {
        const auto found = std::ranges::find(names, text, &GroupInfo::name);
        return found == std::end(names) ? nullptr : &*found;
    };
    const std::vector<GroupInfo> arrays = named_arrays();
    const GroupInfo* name = find(array_groups);
    if (name == nullptr) name = find(arrays);
    if (name == nullptr)
        refuse("Options::want has " + in_quotes(std::string(text)) + ": " + guess(text, arrays) + "give groups of " +
               list(array_groups) + ", or arrays of " + list(arrays));
    if (name->word != nullptr) want.*name->word = true;
}

}  // namespace

Want want_of(std::string_view names) {
    Want want{.neighbors = false, .volumes = false};
    for (;;) {
        const auto comma = names.find(',');
        add(without_blanks(names.substr(0, comma)), want);
        if (comma == std::string_view::npos) return want;
        names.remove_prefix(comma + 1);
    }
}

}  // namespace votess
