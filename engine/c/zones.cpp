// Zones of a watershed.
#include "c/handles.hpp"

using namespace votess::c;

namespace {

template <typename Element>
const Element* expose(const votess_zones* zones, std::size_t* length,
                      std::vector<Element> votess::Zones::*array) noexcept {
    return expose_array(zones, &votess_zones::zones, array, "zones is NULL", length);
}

}  // namespace

votess_status votess_zones_new(const votess_result* result, const double* values, size_t count, int32_t maxima,
                               votess_zones** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(result, "result");
        require_array(values, count, "values", "count");
        *out = new votess_zones{votess::watershed(result->tessellation, {values, count}, maxima != 0)};
    });
}

votess_status votess_zones_merge(const votess_zones* zones, double threshold, votess_zones** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(zones, "zones");
        *out = new votess_zones{zones->zones.merge(threshold)};
    });
}

void votess_zones_free(votess_zones* zones) {
    delete zones;
}

const int32_t* votess_zones_labels(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::labels);
}

const int32_t* votess_zones_cores(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::cores);
}

const int32_t* votess_zones_pairs(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::pairs);
}

const double* votess_zones_saddles(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::saddles);
}

const int32_t* votess_zones_passes(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::passes);
}

const int32_t* votess_zones_parents(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::parents);
}

const double* votess_zones_persistence(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::persistence);
}

const uint8_t* votess_zones_at_walls(const votess_zones* zones, size_t* length) {
    return expose(zones, length, &votess::Zones::at_walls);
}
