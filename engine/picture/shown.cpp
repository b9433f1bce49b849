#include "picture/shown.hpp"

#include <algorithm>

#include "core/box.hpp"

namespace votess::picture {
namespace {

constexpr double dwarfing = 8;  // times the others' median volume

Box bounds_of(const Mesh& mesh, std::size_t cell) {
    Box box = empty_box;
    for (std::size_t f = mesh.first_face(cell); f < mesh.end_face(cell); ++f)
        for (const std::int32_t v : mesh.polygon(f)) include(box, mesh.vertex(v));
    return box;
}

double median(std::vector<double>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

bool at_wall(const Mesh& mesh, std::size_t cell) {
    for (std::size_t f = mesh.first_face(cell); f < mesh.end_face(cell); ++f)
        if (mesh.indices[f] < 0) return true;
    return false;
}

}  // namespace

Shown choose_cells(const Mesh& mesh, const Box& domain, WallCells wall_cells, ThreadPool& pool) {
    const std::size_t n = mesh.cells();
    std::vector<Box> boxes(n);
    std::vector<char> walls(n);
    Shown shown;
    shown.cells.resize(n);
    over_cells(n, pool, [&](std::size_t begin, std::size_t end, std::size_t) {
        for (std::size_t i = begin; i < end; ++i) {
            shown.cells[i] = mesh.end_face(i) > mesh.first_face(i);
            walls[i] = at_wall(mesh, i);
            boxes[i] = bounds_of(mesh, i);
        }
    });

    // Bounds measure sizes well enough here.
    std::vector<double> sizes[2];
    for (std::size_t i = 0; i < n; ++i) {
        if (!shown.cells[i]) continue;
        double size = 1;
        for (std::size_t k = 0; k < 3; ++k) {
            const double side = domain.upper[k] - domain.lower[k];
            if (side > 0) size *= (boxes[i].upper[k] - boxes[i].lower[k]) / side;  // the plane has no height
        }
        sizes[static_cast<std::size_t>(walls[i])].push_back(size);
    }
    const bool dwarfed = median(sizes[1]) > dwarfing * median(sizes[0]);
    shown.walls_hidden = !sizes[0].empty() && !sizes[1].empty() &&
                         (wall_cells == WallCells::hide || (wall_cells == WallCells::automatic && dwarfed));
    shown.bounds = domain;
    if (!shown.walls_hidden) return shown;

    // Their neighbors too: drawn out towards the walls, they would stand as spikes around the rest.
    std::vector<char> outer = walls;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t f = mesh.first_face(i); walls[i] && f < mesh.end_face(i); ++f) {
            if (mesh.indices[f] >= 0) outer[static_cast<std::size_t>(mesh.indices[f])] = 1;
        }
    }
    const auto inner = [&](std::size_t i) { return shown.cells[i] && !outer[i]; };
    bool any = false;
    for (std::size_t i = 0; i < n; ++i) any = any || inner(i);
    if (!any) outer = walls;
    shown.bounds = {domain.upper, domain.lower};
    for (std::size_t i = 0; i < n; ++i) {
        shown.cells[i] = inner(i);
        if (shown.cells[i]) include(shown.bounds, boxes[i]);
    }
    return shown;
}

}  // namespace votess::picture
