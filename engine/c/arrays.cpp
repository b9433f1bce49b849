// Arrays of handles, by their names.
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
