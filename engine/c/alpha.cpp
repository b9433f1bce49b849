// The alpha complex.
#include "c/handles.hpp"

using namespace votess::c;

votess_status votess_alpha_new(const votess_result* result, const double* points, size_t count,
                               const int32_t* replicate, votess_alpha** out) {
    return create(out, [&] {
        const auto input = points_of(result, points, count);
        std::array<std::int32_t, 3> copies{1, 1, 1};
        if (replicate != nullptr) copies = {replicate[0], replicate[1], replicate[2]};
        const votess::Tessellation& t = result->tessellation;
        return votess_alpha{votess::alpha_complex(t, input, copies), dimensions_of(t)};
    });
}

votess_status votess_alpha_array(const votess_alpha* alpha, int32_t k, const char* name, votess_array* array) {
    return expose(alpha, "alpha", name, array, [k](const votess_alpha& of) {
        if (k < 0 || k > 3) refuse("k is " + std::to_string(k) + ": give 0, 1, 2 or 3");
        const std::size_t corners = static_cast<std::size_t>(k) + 1;
        const votess::AlphaSimplices& s = of.complex.simplices[corners - 1];
        return std::array{named("seeds", s.seeds, corners), named("shifts", s.shifts, corners * of.dimensions),
                          named("values", s.values), named("gabriel", s.gabriel)};
    });
}
