// Arrays of handles, by their names, and the end of handles.
#include <algorithm>

#include "c/handles.hpp"

void votess::c::write_array(const char* handle, const char* name, std::span<const NamedArray> arrays,
                            votess_array& out) {
    const auto found =
        std::ranges::find(arrays, std::string_view(name), [](const NamedArray& array) { return array.name; });
    if (found != arrays.end()) {
        out = found->array;
        return;
    }
    std::string message = "name is '" + std::string(name).substr(0, 40) + "': the arrays of " + handle + " are";
    for (const NamedArray& array : arrays) message += (&array == arrays.data() ? " " : ", ") + std::string(array.name);
    refuse(message);
}

#define VOTESS_FREE(name)                          \
    void votess_##name##_free(votess_##name* of) { \
        delete of;                                 \
    }
VOTESS_FREE(alpha)
VOTESS_FREE(delaunay)
VOTESS_FREE(diagram)
VOTESS_FREE(fit)
VOTESS_FREE(groups)
VOTESS_FREE(hull)
VOTESS_FREE(masses)
VOTESS_FREE(natural)
VOTESS_FREE(network)
VOTESS_FREE(pieces)
VOTESS_FREE(rays)
VOTESS_FREE(result)
VOTESS_FREE(tessellator)
VOTESS_FREE(zones)
#undef VOTESS_FREE
