// The network of a diagram.
#include <optional>

#include "c/handles.hpp"

using namespace votess::c;

votess_status votess_network_new(const votess_result* result, const double* points, size_t count,
                                 votess_network** out) {
    return create(out, [&] {
        const auto input = points_of(result, points, count);
        return votess_network{votess::network(result->tessellation, input), dimensions_of(result->tessellation)};
    });
}

votess_status votess_network_array(const votess_network* network, const char* name, votess_array* array) {
    return expose(network, "network", name, array, [](const votess_network& of) {
        const votess::Network& n = of.network;
        return std::array{named("points", n.points, of.dimensions),
                          named("vertices", n.vertices),
                          named("vertex_radii", n.vertex_radii),
                          named("at_walls", n.at_walls),
                          named("edges", n.edges, 2),
                          named("shifts", n.shifts, of.dimensions),
                          named("edge_radii", n.edge_radii)};
    });
}

votess_status votess_network_largest_included(const votess_network* network, double* radius, int32_t* vertex) {
    return guarded(network, "network", [&](auto& of) {
        require(radius, "radius");
        require(vertex, "vertex");
        const votess::IncludedSphere sphere = of.network.largest_included();
        *radius = sphere.radius;
        *vertex = sphere.vertex;
    });
}

votess_status votess_network_largest_free(const votess_network* network, int32_t axis, double* radius, int32_t* edge,
                                          double* included_radius, int32_t* included_vertex) {
    return guarded(network, "network", [&](auto& of) {
        require(radius, "radius");
        require(edge, "edge");
        require(included_radius, "included_radius");
        require(included_vertex, "included_vertex");
        const std::optional<votess::FreeSphere> found =
            of.network.largest_free(axis == -1 ? std::nullopt : std::optional<int>(axis));
        constexpr votess::FreeSphere none{0, -1, {0, -1}};
        const votess::FreeSphere sphere = found.value_or(none);
        *radius = sphere.radius;
        *edge = sphere.edge;
        *included_radius = sphere.included.radius;
        *included_vertex = sphere.included.vertex;
    });
}
