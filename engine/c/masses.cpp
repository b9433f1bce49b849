// Masses under a density on a grid.
#include "c/handles.hpp"

using namespace votess::c;

votess::Density votess::c::density_of(const double* values, const size_t shape[3]) {
    std::size_t count = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        // More than any function takes is refused later, by its shape.
        if (shape[k] != 0 && count > std::numeric_limits<std::size_t>::max() / sizeof(double) / shape[k]) count = 0;
        count *= shape[k];
    }
    if (count > 0) require(values, "density");
    return {{shape[0], shape[1], shape[2]}, {values, count}};
}

votess_status votess_masses_new(const votess_result* result, const double* density, const size_t shape[3],
                                uint32_t threads, votess_masses** out) {
    return create(out, result, "result", [&](auto& of) {
        require(shape, "shape");
        const votess::Tessellation& t = of.tessellation;
        return votess_masses{votess::masses(t, density_of(density, shape), threads), dimensions_of(t)};
    });
}

votess_status votess_masses_array(const votess_masses* masses, const char* name, votess_array* array) {
    return expose(masses, "masses", name, array, [](const votess_masses& of) {
        const votess::Masses& m = of.masses;
        return std::array{named("masses", m.masses), named("centroids", m.centroids, of.dimensions),
                          named("second_moments", m.second_moments), named("face_masses", m.face_masses)};
    });
}
