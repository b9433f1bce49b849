// Natural-neighbor coordinates and interpolation.
#include <algorithm>

#include "c/handles.hpp"

using namespace votess::c;

namespace {

static_assert(same(VOTESS_NATURAL_SIBSON, votess::NaturalMethod::sibson));
static_assert(same(VOTESS_NATURAL_LAPLACE, votess::NaturalMethod::laplace));

votess::NaturalOptions natural_options(const votess_diagram& diagram, int32_t method, int32_t at_walls, bool gradients,
                                       const double* weights, std::size_t count) {
    if (method != VOTESS_NATURAL_SIBSON && method != VOTESS_NATURAL_LAPLACE)
        refuse("method is " + std::to_string(method) + ": give one of VOTESS_NATURAL_*");
    votess::NaturalOptions options;
    options.method = static_cast<votess::NaturalMethod>(method);
    options.at_walls = at_walls != 0;
    options.gradients = gradients;
    options.progress = diagram.progress;
    if (weights != nullptr) options.weights = {weights, count};
    return options;
}

}  // namespace

votess_status votess_natural_new(const votess_diagram* diagram, const double* queries, size_t count, int32_t method,
                                 int32_t at_walls, int32_t gradients, const double* weights, votess_natural** out) {
    return create(out, diagram, "diagram", [&](auto& of) {
        const auto input = queries_of(of, queries, count);
        const votess::NaturalOptions options = natural_options(of, method, at_walls, gradients != 0, weights, count);
        return votess_natural{of.diagram.natural_neighbors(input, options), dimensions_of(of.diagram)};
    });
}

votess_status votess_natural_array(const votess_natural* natural, const char* name, votess_array* array) {
    return expose(natural, "natural", name, array, [](const votess_natural& of) {
        const votess::NaturalCoordinates& n = of.coordinates;
        return std::array{named("indptr", n.indptr), named("indices", n.indices), named("weights", n.weights),
                          named("gradients", n.gradients, of.dimensions)};
    });
}

votess_status votess_diagram_interpolate(const votess_diagram* diagram, const double* values, size_t components,
                                         const double* queries, size_t count, int32_t method, int32_t at_walls,
                                         const double* weights, double* interpolated, double* gradients) {
    return guarded(diagram, "diagram", [&](auto& of) {
        const std::size_t seeds = of.diagram.size();
        if (seeds > 0) require(values, "values");
        const auto input = queries_of(of, queries, count);
        require_array(interpolated, count, "interpolated", "count");
        const std::size_t rows = std::max<std::size_t>({seeds, 3 * count, 1});
        if (components == 0 || components > std::numeric_limits<std::size_t>::max() / sizeof(double) / rows)
            refuse("components is " + std::to_string(components) + ": give at least 1, and no more than memory holds");
        const votess::Interpolated found =
            of.diagram.interpolate({values, seeds * components}, components, input,
                                   natural_options(of, method, at_walls, gradients != nullptr, weights, count));
        std::ranges::copy(found.values, interpolated);
        if (gradients != nullptr) std::ranges::copy(found.gradients, gradients);
    });
}
