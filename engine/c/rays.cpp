// The cells along rays.
#include "c/handles.hpp"

using namespace votess::c;

namespace {

template <typename Element>
const Element* expose(const votess_rays* rays, std::size_t* length,
                      std::vector<Element> votess::RayCells::*array) noexcept {
    return expose_array(rays, &votess_rays::cells, array, "rays is NULL", length);
}

}  // namespace

votess_status votess_rays_new(const votess_diagram* diagram, const double* origins, const double* directions,
                              const double* lengths, size_t count, int32_t middles, votess_rays** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(diagram, "diagram");
        const auto from = queries_of(*diagram, origins, count, "origins"),
                   along = queries_of(*diagram, directions, count, "directions");
        require_array(lengths, count, "lengths", "count");
        *out =
            new votess_rays{diagram->diagram.trace(from, along, {lengths, count}, {middles != 0, diagram->progress})};
    });
}

void votess_rays_free(votess_rays* rays) {
    delete rays;
}

const int64_t* votess_rays_offsets(const votess_rays* rays, size_t* length) {
    return expose(rays, length, &votess::RayCells::offsets);
}

const int32_t* votess_rays_seeds(const votess_rays* rays, size_t* length) {
    return expose(rays, length, &votess::RayCells::seeds);
}

const double* votess_rays_lengths(const votess_rays* rays, size_t* length) {
    return expose(rays, length, &votess::RayCells::lengths);
}

const double* votess_rays_middles(const votess_rays* rays, size_t* length) {
    return expose(rays, length, &votess::RayCells::middles);
}
