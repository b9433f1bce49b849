// The network of a diagram.
#include <optional>

#include "c/handles.hpp"

using namespace votess::c;

namespace {

template <typename Element>
const Element* expose(const votess_network* network, std::size_t* length,
                      std::vector<Element> votess::Network::*array) noexcept {
    return expose_array(network, &votess_network::network, array, "network is NULL", length);
}

}  // namespace

votess_status votess_network_new(const votess_result* result, const double* points, size_t count,
                                 votess_network** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(result, "result");
        const auto input = coordinates(points, count, "points", "count", result->tessellation.planar() ? 2 : 3);
        *out = new votess_network{votess::network(result->tessellation, input)};
    });
}

void votess_network_free(votess_network* network) {
    delete network;
}

const double* votess_network_points(const votess_network* network, size_t* length) {
    return expose(network, length, &votess::Network::points);
}

const int32_t* votess_network_vertices(const votess_network* network, size_t* length) {
    return expose(network, length, &votess::Network::vertices);
}

const double* votess_network_vertex_radii(const votess_network* network, size_t* length) {
    return expose(network, length, &votess::Network::vertex_radii);
}

const uint8_t* votess_network_at_walls(const votess_network* network, size_t* length) {
    return expose(network, length, &votess::Network::at_walls);
}

const int32_t* votess_network_edges(const votess_network* network, size_t* length) {
    return expose(network, length, &votess::Network::edges);
}

const int8_t* votess_network_shifts(const votess_network* network, size_t* length) {
    return expose(network, length, &votess::Network::shifts);
}

const double* votess_network_edge_radii(const votess_network* network, size_t* length) {
    return expose(network, length, &votess::Network::edge_radii);
}

votess_status votess_network_largest_included(const votess_network* network, double* radius, int32_t* vertex) {
    return guarded([&] {
        require(network, "network");
        require(radius, "radius");
        require(vertex, "vertex");
        const votess::IncludedSphere sphere = network->network.largest_included();
        *radius = sphere.radius;
        *vertex = sphere.vertex;
    });
}

votess_status votess_network_largest_free(const votess_network* network, int32_t axis, double* radius, int32_t* edge,
                                          double* included_radius, int32_t* included_vertex) {
    return guarded([&] {
        require(network, "network");
        require(radius, "radius");
        require(edge, "edge");
        require(included_radius, "included_radius");
        require(included_vertex, "included_vertex");
        const std::optional<votess::FreeSphere> found =
            network->network.largest_free(axis == -1 ? std::nullopt : std::optional<int>(axis));
        constexpr votess::FreeSphere none{0, -1, {0, -1}};
        const votess::FreeSphere sphere = found.value_or(none);
        *radius = sphere.radius;
        *edge = sphere.edge;
        *included_radius = sphere.included.radius;
        *included_vertex = sphere.included.vertex;
    });
}
