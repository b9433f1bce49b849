// Weights for given volumes.
#include <algorithm>
#include <cstddef>

#include "c/handles.hpp"

using namespace votess::c;

namespace {

votess_fit_options default_fit_options() {
    const votess::FitOptions defaults;
    votess_fit_options options{};
    options.max_steps = defaults.max_steps;
    options.tolerance = defaults.tolerance;
    options.normalize = defaults.normalize ? 1 : 0;
    return options;
}

votess::FitOptions convert(const votess_fit_options* given) {
    const votess_fit_options all =
        given == nullptr ? default_fit_options()
                         : read_struct(*given, "fit_options.struct_size", "call votess_fit_options_init first");
    votess::FitOptions converted{
        .tolerance = all.tolerance, .max_steps = all.max_steps, .normalize = all.normalize != 0};
    if (all.density != nullptr) converted.density = density_of(all.density, all.density_shape);
    return converted;
}

}  // namespace

votess_status votess_fit_options_init(votess_fit_options* options, size_t size) {
    return init_struct(options, size, default_fit_options(), "give sizeof(votess_fit_options)");
}

votess_status votess_fit_volumes(const double* points, size_t count, const double* targets,
                                 const votess_options* options, const votess_fit_options* fit_options,
                                 votess_fit** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        const votess::Options domain = convert_options(options, count);
        const auto input = coordinates(points, count, "points", "count", dimensions_of(domain));
        require_array(targets, count, "targets", "count");
        const votess::FitOptions converted = convert(fit_options);
        try {
            *out = new votess_fit{votess::fit_volumes(input, std::span(targets, count), domain, converted), true};
        } catch (const votess::FitError& error) {
            *out = new votess_fit{};
            (*out)->fit.weights = error.weights();
            (*out)->fit.residual = error.residual();
            (*out)->fit.steps = error.steps();
            throw;
        }
    });
}

votess_status votess_fit_array(const votess_fit* fit, const char* name, votess_array* array) {
    return expose(fit, "fit", name, array,
                  [](const votess_fit& of) { return std::array{named("weights", of.fit.weights)}; });
}

votess_status votess_fit_get_stats(const votess_fit* fit, votess_fit_stats* stats) {
    return guarded(fit, "fit", [&](auto& of) {
        require(stats, "stats");
        require_struct_size(stats->struct_size, sizeof *stats, "stats.struct_size",
                            "set it to sizeof(votess_fit_stats)");
        const votess::VolumeFit& from = of.fit;
        stats->steps = from.steps;
        stats->tessellations = from.tessellations;
        stats->residual = from.residual;
        stats->seconds_tessellate = from.seconds.tessellate;
        stats->seconds_assemble = from.seconds.assemble;
        stats->seconds_solve = from.seconds.solve;
        stats->seconds_total = from.seconds.total;
    });
}

votess_status votess_fit_result(const votess_fit* fit, votess_result** out) {
    return create(out, fit, "fit", [&](auto& of) {
        if (!of.converged) refuse("fit did not converge: it has weights and no result");
        return votess_result{of.fit.tessellation};
    });
}
