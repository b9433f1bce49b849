// Seeds that stay, and what they are asked.
#include <algorithm>

#include "c/handles.hpp"

using namespace votess::c;

votess_status votess_diagram_new(const double* points, size_t count, const votess_options* options,
                                 votess_diagram** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        const auto input = coordinates(points, count);
        *out = new votess_diagram{votess::Diagram(input, convert_options(options, count))};
    });
}

void votess_diagram_free(votess_diagram* diagram) {
    delete diagram;
}

size_t votess_diagram_size(const votess_diagram* diagram) {
    if (diagram == nullptr) set_last_error("diagram is NULL");
    return diagram == nullptr ? 0 : diagram->diagram.size();
}

votess_status votess_diagram_locate(const votess_diagram* diagram, const double* queries, size_t count,
                                    int32_t* seeds) {
    return guarded([&] {
        require(diagram, "diagram");
        if (count > 0) require(seeds, "seeds");
        std::ranges::copy(diagram->diagram.locate(coordinates(queries, count, "queries")), seeds);
    });
}

votess_status votess_diagram_probe(const votess_diagram* diagram, const double* queries, size_t count, uint32_t want,
                                   int32_t list_walls, const double* weights, votess_result** out) {
    return guarded([&] {
        require(out, "out");
        *out = nullptr;
        require(diagram, "diagram");
        const auto input = coordinates(queries, count, "queries");
        votess::ProbeOptions options;
        options.want = convert_want(want, "want");
        options.list_walls = list_walls != 0;
        if (weights != nullptr) options.weights = {weights, count};
        *out = new votess_result{diagram->diagram.probe(input, options)};
    });
}
