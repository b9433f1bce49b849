#include "arguments/elements.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "failure.hpp"
#include "files/line_reader.hpp"

namespace clvotess {
namespace {

struct Element {
    std::string_view symbol;
    double radius;  // angstrom
};

// B. Cordero and others, "Covalent radii revisited", Dalton Transactions 2008, 2832, doi:10.1039/b801115j, table 2.
// Carbon has the radius of sp3; manganese, iron and cobalt have those of low spin.
constexpr std::array<Element, 96> elements{
    {{"h", 0.31},  {"he", 0.28}, {"li", 1.28}, {"be", 0.96}, {"b", 0.84},  {"c", 0.76},  {"n", 0.71},  {"o", 0.66},
     {"f", 0.57},  {"ne", 0.58}, {"na", 1.66}, {"mg", 1.41}, {"al", 1.21}, {"si", 1.11}, {"p", 1.07},  {"s", 1.05},
     {"cl", 1.02}, {"ar", 1.06}, {"k", 2.03},  {"ca", 1.76}, {"sc", 1.70}, {"ti", 1.60}, {"v", 1.53},  {"cr", 1.39},
     {"mn", 1.39}, {"fe", 1.32}, {"co", 1.26}, {"ni", 1.24}, {"cu", 1.32}, {"zn", 1.22}, {"ga", 1.22}, {"ge", 1.20},
     {"as", 1.19}, {"se", 1.20}, {"br", 1.20}, {"kr", 1.16}, {"rb", 2.20}, {"sr", 1.95}, {"y", 1.90},  {"zr", 1.75},
     {"nb", 1.64}, {"mo", 1.54}, {"tc", 1.47}, {"ru", 1.46}, {"rh", 1.42}, {"pd", 1.39}, {"ag", 1.45}, {"cd", 1.44},
     {"in", 1.42}, {"sn", 1.39}, {"sb", 1.39}, {"te", 1.38}, {"i", 1.39},  {"xe", 1.40}, {"cs", 2.44}, {"ba", 2.15},
     {"la", 2.07}, {"ce", 2.04}, {"pr", 2.03}, {"nd", 2.01}, {"pm", 1.99}, {"sm", 1.98}, {"eu", 1.98}, {"gd", 1.96},
     {"tb", 1.94}, {"dy", 1.92}, {"ho", 1.92}, {"er", 1.89}, {"tm", 1.90}, {"yb", 1.87}, {"lu", 1.87}, {"hf", 1.75},
     {"ta", 1.70}, {"w", 1.62},  {"re", 1.51}, {"os", 1.44}, {"ir", 1.41}, {"pt", 1.36}, {"au", 1.36}, {"hg", 1.32},
     {"tl", 1.45}, {"pb", 1.46}, {"bi", 1.48}, {"po", 1.40}, {"at", 1.50}, {"rn", 1.50}, {"fr", 2.60}, {"ra", 2.21},
     {"ac", 2.15}, {"th", 2.06}, {"pa", 2.00}, {"u", 1.96},  {"np", 1.90}, {"pu", 1.87}, {"am", 1.80}, {"cm", 1.69}}};

}  // namespace

std::vector<double> covalent_radii(const std::vector<std::string>& species) {
    std::vector<double> radii;
    radii.reserve(species.size());
    const Element* last = nullptr;  // often that of the next atom too
    for (std::size_t i = 0; i < species.size(); ++i) {
        const std::string symbol = lower_case(species[i].substr(0, species[i].find_first_of("0123456789+-")));
        if (!last || last->symbol != symbol) {
            last = std::ranges::find(elements, std::string_view(symbol), &Element::symbol);
            if (last == elements.end())
                throw bad_input("--radii covalent needs elements, and atom " + std::to_string(i) + " is " +
                                in_quotes(species[i]) + ": name a column of radii instead");
        }
        radii.push_back(last->radius);
    }
    return radii;
}

}  // namespace clvotess
