// The names of arrays, and the groups of Want that they belong to.
#include <algorithm>
#include <array>
#include <span>
#include <string>

#include "core/errors.hpp"
#include "core/text.hpp"
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
// Arrays whose name is not that of their group.
constexpr std::array arrays{Name{"indptr", &Want::neighbors},
                            Name{"indices", &Want::neighbors},
                            Name{"shifts", &Want::neighbors},
                            Name{"face_areas", &Want::areas},
                            Name{"face_normals", &Want::normals},
                            Name{"surface_areas", &Want::surfaces},
                            Name{"mesh_areas", &Want::surfaces},
                            Name{"security_radii", &Want::radii},
                            Name{"face_counts", &Want::counts},
                            Name{"edge_counts", &Want::counts},
                            Name{"vertex_counts", &Want::counts},
                            Name{"cell_vertices", &Want::vertices},
                            Name{"cell_vertex_indptr", &Want::vertices},
                            Name{"cell_vertex_indices", &Want::vertices},
                            Name{"face_offsets", &Want::faces},
                            Name{"face_vertices", &Want::faces},
                            Name{"status", nullptr},
                            Name{"duplicate_of", nullptr},
                            Name{"ids", nullptr}};

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
std::string guess(std::string_view text) {
    constexpr std::size_t shortest = 3;
    if (text.size() < shortest) return {};
    for (const std::span<const Name> names : {std::span<const Name>(words), std::span<const Name>(arrays)})
        for (const Name& name : names)
            if (name.name.starts_with(text)) return "did you mean " + std::string(name.name) + "? Else ";
    return {};
}

void add(std::string_view text, Want& want) {
    const auto find = [&](const auto& names) {
        const auto found = std::ranges::find(names, text, &Name::name);
        return found == names.end() ? nullptr : &*found;
    };
    const Name* name = find(words);
    if (name == nullptr) name = find(arrays);
    if (name == nullptr)
        refuse("Options::want has " + in_quotes(std::string(text)) + ": " + guess(text) + "give groups of " +
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
