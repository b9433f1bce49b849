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

struct Name {
    std::string_view name;
    bool Want::*word;  // null: in every result
};

constexpr std::array words{Name{"neighbors", &Want::neighbors}, Name{"volumes", &Want::volumes},
                           Name{"centroids", &Want::centroids}, Name{"counts", &Want::counts},
                           Name{"areas", &Want::areas},         Name{"normals", &Want::normals},
                           Name{"surfaces", &Want::surfaces},   Name{"radii", &Want::radii},
                           Name{"vertices", &Want::vertices},   Name{"faces", &Want::faces}};
// Returns the arrays whose name is not that of their group. Weights are input, which nobody wants.
std::vector<Name> named_arrays() {
    std::vector<Name> arrays{{"cell_vertices", &Want::vertices}};
    for_all_arrays([&](const auto& array) {
        if (array.name != "weights" && std::ranges::find(words, array.name, &Name::name) == words.end())
            arrays.push_back({array.name, array.word});
    });
    return arrays;
}

std::string list(const auto& names) {
    std::string text;
    for (const Name& name : names) text += (text.empty() ? "" : ", ") + std::string(name.name);
    return text;
}

std::string_view without_blanks(std::string_view text) {
    const auto begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

// Returns a question for the first name that begins with the text, as volumes does with volume; or nothing.
std::string guess(std::string_view text, std::span<const Name> arrays) {
    constexpr std::size_t shortest = 3;
    if (text.size() < shortest) return {};
    for (const std::span<const Name> names : {std::span<const Name>(words), arrays})
        for (const Name& name : names)
            if (name.name.starts_with(text)) return "did you mean " + std::string(name.name) + "? Else ";
    return {};
}

void add(std::string_view text, Want& want) {
    const auto find = [&](const auto& names) {
        const auto found = std::ranges::find(names, text, &Name::name);
        return found == names.end() ? nullptr : &*found;
    };
    const std::vector<Name> arrays = named_arrays();
    const Name* name = find(words);
    if (name == nullptr) name = find(arrays);
    if (name == nullptr)
        refuse("Options::want has " + in_quotes(std::string(text)) + ": " + guess(text, arrays) + "give groups of " +
               list(words) + ", or arrays of " + list(arrays));
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
