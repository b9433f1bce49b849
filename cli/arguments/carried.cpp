#include "arguments/carried.hpp"

#include <limits>
#include <utility>
#include <votess/zones.hpp>

#include "arguments/elements.hpp"
#include "failure.hpp"
#include "write/output.hpp"

namespace clvotess {
namespace {

std::size_t first_mass(const Arguments& arguments) {
    return (arguments.has_weights ? 1 : 0) + (arguments.has_volumes ? 1 : 0);
}

std::size_t first_value(const Arguments& arguments) {
    return first_mass(arguments) + (arguments.has_density ? 1 : 0);
}

}  // namespace

void complete_columns(const Arguments& arguments, Input& input) {
    for (std::size_t c = input.columns.size(); c < arguments.read.columns.size(); ++c)
        input.columns.push_back({arguments.read.columns[c], 1, {}});
    if (!arguments.covalent) return;
    if (input.species.size() != input.size())
        throw bad_input("--radii covalent needs elements, and the file names none: name a column of radii instead");
    input.columns.insert(input.columns.begin(), {"radius", 1, covalent_radii(input.species)});
}

void take_weights(const Arguments& arguments, const Input& input, votess::Options& options) {
    if (!arguments.has_weights) return;
    (arguments.has_radii ? options.radii : options.weights) = one_each(input.columns.at(0));
}

std::span<const double> targets_of(const Arguments& arguments, const Input& input) {
    return one_each(input.columns.at(arguments.has_weights ? 1 : 0));
}

std::vector<InputColumn> take_carried(const Arguments& arguments, Input& input) {
    const std::size_t named = first_value(arguments) + (arguments.has_zones && !arguments.zones_of_density ? 1 : 0);
    std::vector<InputColumn> carried;
    for (std::size_t c = arguments.read.all_columns ? 0 : named; c < input.columns.size(); ++c) {
        if (c < named) {
            carried.push_back(input.columns[c]);
        } else {
            carried.push_back(std::move(input.columns[c]));
        }
    }
    if (arguments.has_zones) carried.push_back({"zone", 1, {}});
    if (arguments.has_volumes) carried.push_back({"weights", 1, {}});
    if (arguments.has_density) carried.push_back({"density", 1, {}});
    return carried_columns(arguments.outputs, std::move(carried), input.planar());
}

std::vector<double> masses_of(const Arguments& arguments, const Input& input) {
    if (!arguments.has_density) return {};
    const std::span<const double> masses = one_each(input.columns.at(first_mass(arguments)));
    return {masses.begin(), masses.end()};
}

std::vector<double> densities(std::span<const double> masses, std::span<const double> volumes) {
    std::vector<double> result(masses.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < masses.size(); ++i)
        if (volumes[i] > 0) result[i] = masses[i] / volumes[i];
    return result;
}

void fill_weights(const Arguments& arguments, std::span<const double> weights, std::vector<InputColumn>& carried) {
    if (!arguments.has_volumes) return;
    const auto column = arguments.has_density ? carried.rbegin() + 1 : carried.rbegin();
    column->values.assign(weights.begin(), weights.end());
}

void fill_density(const Arguments& arguments, std::span<const double> masses, std::span<const double> volumes,
                  std::vector<InputColumn>& carried) {
    if (arguments.has_density) carried.back().values = densities(masses, volumes);
}

void fill_zones(const Arguments& arguments, const Input& input, const votess::Tessellation& tessellation,
                std::vector<InputColumn>& carried) {
    if (!arguments.has_zones) return;
    const std::span<const double> values = arguments.zones_of_density
                                               ? std::span<const double>(carried.back().values)
                                               : one_each(input.columns.at(first_value(arguments)));
    const auto column = carried.end() - 1 - (arguments.has_volumes ? 1 : 0) - (arguments.has_density ? 1 : 0);
    votess::Zones zones = votess::watershed(tessellation, values);
    if (arguments.merge) zones = zones.merge(*arguments.merge);
    column->values.assign(zones.labels.begin(), zones.labels.end());
}

}  // namespace clvotess
