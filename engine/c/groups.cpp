// Sums of the cells by group.
#include "c/handles.hpp"

using namespace votess::c;

votess_status votess_groups_new(const votess_result* result, const std::int64_t* labels, size_t count,
                                votess_groups** out) {
    return create(out, result, "result", [&](auto& of) {
        require_array(labels, count, "labels", "count");
        return votess_groups{votess::groups(of.tessellation, {labels, count})};
    });
}

votess_status votess_groups_array(const votess_groups* groups, const char* name, votess_array* array) {
    return expose(groups, "groups", name, array, [](const votess_groups& of) {
        const votess::Groups& g = of.groups;
        return std::array{named("labels", g.labels),
                          named("member_indptr", g.member_indptr),
                          named("members", g.members),
                          named("indptr", g.indptr),
                          named("indices", g.indices),
                          named("counts", g.counts),
                          named("areas", g.areas),
                          named("volumes", g.volumes),
                          named("surface_areas", g.surface_areas),
                          named("mesh_areas", g.mesh_areas)};
    });
}
