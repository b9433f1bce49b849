#include "read/lammps/lammps_styles.hpp"

#include <algorithm>
#include <array>

#include "failure.hpp"

namespace clvotess {
namespace {

// Columns of the section Atoms, by the manual of LAMMPS (read_data). Three image flags may follow. Where manual and
// program differ in the number of columns, both are accepted.
struct Style {
    std::string_view name, columns;
};

constexpr std::array styles = std::to_array<Style>({
    {"amoeba", "id mol type q x y z"},
    {"angle", "id mol type x y z"},
    {"apip", "id type x y z"},
    {"atomic", "id type x y z"},
    {"body", "id type bodyflag mass x y z"},
    {"bond", "id mol type x y z"},
    {"bpm/sphere", "id mol type diameter density x y z"},
    {"charge", "id type q x y z"},
    {"dielectric", "id type q x y z mux muy muz area ed em epsilon curvature"},
    {"dielectric", "id mol type q x y z mux muy muz area ed em epsilon curvature"},
    {"dipole", "id type q x y z mux muy muz"},
    {"dpd", "id type theta x y z"},
    {"edpd", "id type temp cv x y z"},
    {"eff", "id type q spin eradius x y z"},
    {"electron", "id type q spin eradius x y z"},
    {"ellipsoid", "id type ellipsoidflag density x y z"},
    {"full", "id mol type q x y z"},
    {"line", "id mol type lineflag density x y z"},
    {"mdpd", "id type rho x y z"},
    {"meso", "id type rho esph cv x y z"},
    {"mesont", "id mol type bond_nt mass mradius mlength buckling x y z"},
    {"mesont", "id mol type bond_nt1 bond_nt2 mass mradius mlength buckling x y z"},
    {"molecular", "id mol type x y z"},
    {"oxdna", "id type x y z"},
    {"peri", "id type volume density x y z"},
    {"rheo", "id type status rho x y z"},
    {"rheo/thermal", "id type status rho esph x y z"},
    {"smd", "id type mol volume mass kradius cradius x0 y0 z0 x y z"},
    {"sph", "id type rho esph cv x y z"},
    {"sphere", "id type diameter density x y z"},
    {"spin", "id type x y z spx spy spz sp"},
    {"template", "id mol template-index template-atom type x y z"},
    {"tri", "id mol type triangleflag density x y z"},
    {"wavepacket", "id type charge spin eradius etag cs_re cs_im x y z"},
});

constexpr std::string_view basic_columns = "id type x y z";
constexpr std::size_t image_flags = 3;

AtomColumns made_of(std::string_view columns) {
    AtomColumns result;
    split_words(columns, result.names);
    result.x = find_name(result.names, "x").value();
    return result;
}

// Returns the style without the suffix of an accelerated variant, such as full/kk.
std::string_view plain_style(std::string_view name) {
    return name.ends_with("/kk") ? name.substr(0, name.size() - 3) : name;
}

// Returns the columns of style hybrid: id, type, x, y, z, then the other columns of each sub-style, each name once. If
// sub-styles are missing, unknown or do not fit the row, only the coordinates are known.
AtomColumns columns_of_hybrid(const Words& hint, std::size_t size) {
    AtomColumns result = made_of(basic_columns);
    bool all_known = hint.size() > 1;
    for (std::size_t k = 1; k < hint.size(); ++k) {
        const auto style = std::ranges::find(styles, plain_style(hint[k]), &Style::name);
        all_known = all_known && style != styles.end();
        if (!all_known) break;
        for (const std::string_view name : made_of(style->columns).names) {
            if (!find_name(result.names, name)) result.names.push_back(name);
        }
    }
    const std::size_t own = result.names.size();
    if (!all_known || (size != own && size != own + image_flags)) {
        result = made_of(basic_columns);
        result.names.resize(size);
    }
    return result;
}

}  // namespace

AtomColumns columns_of_style(const Words& hint, std::size_t size, const LineReader& lines) {
    const std::string_view name = plain_style(hint[0]);
    // Style tdpd ends with any number of concentrations.
    if (name == "hybrid" || name == "tdpd") {
        const std::size_t least = made_of(basic_columns).names.size();
        if (size < least) {
            throw lines.error("atoms of style " + std::string(name) + " have at least " + columns_text(least));
        }
        return columns_of_hybrid(hint, size);
    }
    std::string sizes;
    for (const Style& style : styles) {
        if (style.name != name) continue;
        AtomColumns result = made_of(style.columns);
        const std::size_t own = result.names.size();
        if (size == own || size == own + image_flags) return result;
        sizes += (sizes.empty() ? "" : " or ") + std::to_string(own);
    }
    throw lines.error("this row has " + columns_text(size) + ", but atoms of style " + std::string(name) + " have " +
                      sizes + ", and 3 more with image flags");
}

bool knows_style(const Words& hint) {
    if (hint.empty()) return false;
    const std::string_view name = plain_style(hint[0]);
    return name == "hybrid" || name == "tdpd" || std::ranges::find(styles, name, &Style::name) != styles.end();
}

AtomColumns columns_by_size(std::size_t size, const LineReader& lines) {
    constexpr std::array<std::string_view, 3> common{basic_columns, "id 2 3 x y z", "id 2 3 4 x y z"};
    for (const std::string_view columns : common) {
        AtomColumns result = made_of(columns);
        result.guessed = true;
        if (size == result.names.size() || size == result.names.size() + image_flags) return result;
    }
    throw lines.error("this row has " + columns_text(size) + ": " + ask_for_style);
}

std::optional<AtomColumns> columns_by_names(const Words& names) {
    constexpr std::array<std::string_view, 3> axes{"x", "y", "z"};
    const auto place = std::search(names.begin(), names.end(), axes.begin(), axes.end());
    if (names.empty() || !names[0].ends_with("id")) return std::nullopt;
    for (const std::string_view axis : axes) {
        if (std::ranges::count(names, axis) != 1 || place == names.end()) return std::nullopt;
    }
    return AtomColumns{names, static_cast<std::size_t>(place - names.begin()), false};
}

}  // namespace clvotess
