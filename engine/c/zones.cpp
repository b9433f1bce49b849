// Zones of a watershed.
#include "c/handles.hpp"

using namespace votess::c;

votess_status votess_zones_new(const votess_result* result, const double* values, size_t count, int32_t maxima,
                               votess_zones** out) {
    return create(out, result, "result", [&](auto& of) {
        require_array(values, count, "values", "count");
        return votess_zones{votess::watershed(of.tessellation, {values, count}, maxima != 0)};
    });
}

votess_status votess_zones_merge(const votess_zones* zones, double threshold, votess_zones** out) {
    return create(out, zones, "zones", [&](auto& of) { return votess_zones{of.zones.merge(threshold)}; });
}

votess_status votess_zones_array(const votess_zones* zones, const char* name, votess_array* array) {
    return expose(zones, "zones", name, array, [](const votess_zones& of) {
        const votess::Zones& z = of.zones;
        return std::array{named("labels", z.labels),           named("cores", z.cores),
                          named("pairs", z.pairs, 2),          named("saddles", z.saddles),
                          named("passes", z.passes, 2),        named("parents", z.parents),
                          named("persistence", z.persistence), named("at_walls", z.at_walls)};
    });
}
