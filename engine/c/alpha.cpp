// The alpha complex.
#include "c/handles.hpp"

using namespace votess::c;

namespace {

template <typename Element>
const Element* expose(const votess_alpha* alpha, std::int32_t dimension, std::size_t* length,
                      std::vector<Element> votess::AlphaSimplices::*array) noexcept {
    std::span<const Element> elements;
    if (alpha == nullptr)
        set_last_error("alpha is NULL");
    else if (dimension < 0 || dimension > 3)
        set_last_error("dimension is not 0, 1, 2 or 3");
    else
        elements = alpha->complex.simplices[static_cast<std::size_t>(dimension)].*array;
    return expose_span(elements, length);
}

}  // namespace

votess_status votess_alpha_new(const votess_result* result, const double* points, size_t count,
                               const int32_t* replicate, votess_alpha** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(result, "result");
        std::array<std::int32_t, 3> copies{1, 1, 1};
        if (replicate != nullptr) copies = {replicate[0], replicate[1], replicate[2]};
        const auto input = coordinates(points, count, "points", "count", result->tessellation.planar() ? 2 : 3);
        *out = new votess_alpha{votess::alpha_complex(result->tessellation, input, copies)};
    });
}

void votess_alpha_free(votess_alpha* alpha) {
    delete alpha;
}

const int32_t* votess_alpha_seeds(const votess_alpha* alpha, int32_t dimension, size_t* length) {
    return expose(alpha, dimension, length, &votess::AlphaSimplices::seeds);
}

const int8_t* votess_alpha_shifts(const votess_alpha* alpha, int32_t dimension, size_t* length) {
    return expose(alpha, dimension, length, &votess::AlphaSimplices::shifts);
}

const double* votess_alpha_values(const votess_alpha* alpha, int32_t dimension, size_t* length) {
    return expose(alpha, dimension, length, &votess::AlphaSimplices::values);
}

const uint8_t* votess_alpha_gabriel(const votess_alpha* alpha, int32_t dimension, size_t* length) {
    return expose(alpha, dimension, length, &votess::AlphaSimplices::gabriel);
}
