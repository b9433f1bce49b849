// The cells along rays.
#include "c/handles.hpp"

using namespace votess::c;

votess_status votess_rays_new(const votess_diagram* diagram, const double* origins, const double* directions,
                              const double* lengths, size_t count, int32_t middles, votess_rays** out) {
    return create(out, diagram, "diagram", [&](auto& of) {
        const auto from = queries_of(of, origins, count, "origins"),
                   along = queries_of(of, directions, count, "directions");
        require_array(lengths, count, "lengths", "count");
        return votess_rays{of.diagram.trace(from, along, {lengths, count}, {middles != 0, of.progress}),
                           dimensions_of(of.diagram)};
    });
}

votess_status votess_rays_array(const votess_rays* rays, const char* name, votess_array* array) {
    return expose(rays, "rays", name, array, [](const votess_rays& of) {
        return std::array{named("offsets", of.cells.offsets), named("seeds", of.cells.seeds),
                          named("lengths", of.cells.lengths), named("middles", of.cells.middles, of.dimensions)};
    });
}
