#include "input/supports.hpp"

#include <array>
#include <string>

#include "core/errors.hpp"

namespace votess {
namespace {

struct Reason {
    Property property;
    const char* text;
};
constexpr std::array reasons{
    Reason{probed, "cells of probes do not form a diagram: give a result of tessellate()"},
    Reason{subset, "cells of some seeds do not form a diagram: leave out Options::only"},
    Reason{in_mesh, "cells in a mesh are not whole cells: tessellate without Options::mesh"},
    Reason{flat, "works in three dimensions only"},
};

unsigned properties_of(const Tessellation& t) {
    return (t.probed() ? probed : 0u) | (t.is_subset() ? subset : 0u) | (t.in_mesh() ? in_mesh : 0u) |
           (t.planar() ? flat : 0u);
}

}  // namespace

void require(const Tessellation& tessellation, SupportRow function) {
    const unsigned refused = (*function).refused & properties_of(tessellation);
    for (const Reason& reason : reasons)
        if ((refused & reason.property) != 0) refuse(std::string((*function).function) + "(): " + reason.text);
}

}  // namespace votess
