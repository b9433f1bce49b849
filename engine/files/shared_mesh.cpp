#include "files/shared_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "input/option_name.hpp"
#include "votess/votess.hpp"

namespace votess::files {
namespace {

using Shift = std::array<std::int8_t, 3>;

// One side of a face between two cells. shift: of the cell `to`, seen from `from`; its first number that is not 0 is
// positive. From the other side both change places.
struct Side {
    Shift shift;
    std::int32_t from, to;
    std::size_t entry;

    [[nodiscard]] auto key() const { return std::tie(shift, from, to); }
};

// A face on a wall, or between two cells and seen from both sides.
struct Sides {
    std::vector<Side> walls;  // `to` is the wall
    std::vector<Side> fronts, backs;
};

std::string text_of(std::size_t number) {
    return std::to_string(number);
}

Sides sides_of(const Mesh& mesh) {
    Sides sides;
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        const auto cell = static_cast<std::int32_t>(i);
        const auto [begin, end] = mesh.entries(i);
        for (std::size_t k = begin; k < end; ++k) {
            const std::int32_t other = mesh.indices[k];
            if (other < 0) {
                sides.walls.push_back({{}, cell, other, k});
                continue;
            }
            Shift shift{}, back{};
            if (!mesh.shifts.empty()) std::ranges::copy(mesh.shifts.subspan(3 * k, 3), shift.begin());
            std::ranges::transform(shift, back.begin(), [](int s) { return static_cast<std::int8_t>(-s); });
            const bool front = shift == back ? cell < other : shift > Shift{};
            if (front)
                sides.fronts.push_back({shift, cell, other, k});
            else
                sides.backs.push_back({back, other, cell, k});
        }
    }
    for (auto* const half : {&sides.fronts, &sides.backs})
        std::ranges::sort(*half, {}, [](const Side& s) { return std::tuple_cat(s.key(), std::tie(s.entry)); });
    std::ranges::sort(sides.walls, {}, [](const Side& s) { return std::tuple(-s.to, s.from, s.entry); });
    return sides;
}

void check_pairs(const Sides& sides) {
    const auto& [walls, fronts, backs] = sides;
    const std::size_t both = std::min(fronts.size(), backs.size());
    std::size_t k = 0;
    while (k < both && fronts[k].key() == backs[k].key()) ++k;
    if (k == both && fronts.size() == backs.size()) return;
    const Side& lonely =
        k == backs.size() || (k < fronts.size() && fronts[k].key() < backs[k].key()) ? fronts[k] : backs[k];
    refuse("only one of the cells " + std::to_string(lonely.from) + " and " + std::to_string(lonely.to) +
           " has the face between them: give all cells of the diagram");
}

// Throws unless each edge has two faces, which run along it in opposite directions. In pieces it may have several
// pairs.
void check_closed(const Mesh& mesh) {
    struct Edge {
        std::int32_t low, high;
        bool ascends;
    };
    std::vector<Edge> edges;
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        edges.clear();
        const auto [begin, end] = mesh.entries(i);
        for (std::size_t k = begin; k < end; ++k) {
            const auto polygon = mesh.polygon(k);
            for (std::size_t c = 0; c < polygon.size(); ++c) {
                const std::int32_t a = polygon[c], b = polygon[(c + 1) % polygon.size()];
                edges.push_back({std::min(a, b), std::max(a, b), a < b});
            }
        }
        std::ranges::sort(edges, {}, [](const Edge& e) { return std::tie(e.low, e.high); });
        bool closed = true;
        for (std::size_t begin = 0, end = 0; closed && begin < edges.size(); begin = end) {
            const Edge& first = edges[begin];
            int turns = 0;
            for (; end < edges.size() && edges[end].low == first.low && edges[end].high == first.high; ++end)
                turns += edges[end].ascends ? 1 : -1;
            closed = turns == 0 && first.low != first.high && (end - begin == 2 || !mesh.rows.empty());
        }
        if (!closed)
            refuse("cell " + text_of(i) + " is not closed, because it lacks a face: leave out " + option("min_face") +
                   " and " + option("min_area"));
    }
}

}  // namespace

std::string Patch::name(const Mesh& mesh) const {
    static constexpr std::array names{"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"};
    if (wall == 0) {
        std::string result = "periodic";
        for (const int s : shift) result.append("_").append(std::to_string(s));
        return result;
    }
    if (mesh.left_out && wall == -1) return "open";
    const auto k = static_cast<std::size_t>(-static_cast<std::int64_t>(wall)) - 1;
    if (!mesh.patches.empty()) return mesh.patches[k];
    return k < names.size() ? names[k] : "wall" + std::to_string(k + 1);
}

Vector3 SharedMesh::separation(const Patch& patch) const {
    Vector3 sum{};
    for (std::size_t e = 0; e < 3; ++e)
        for (std::size_t k = 0; k < 3; ++k) sum[k] += patch.shift[e] * edges[3 * e + k];
    return sum;
}

SharedMesh::SharedMesh(const Mesh& mesh) : edges(mesh.edges) {
    check_closed(mesh);
    const Sides sides = sides_of(mesh);
    check_pairs(sides);

    std::vector<std::int32_t> number(mesh.cells(), -1);
    for (std::size_t i = 0; i < mesh.cells(); ++i) {
        const auto [begin, end] = mesh.entries(i);
        if (begin == end) continue;
        number[i] = static_cast<std::int32_t>(rows.size());
        rows.push_back(i);
    }
    const auto cell = [&](std::int32_t row) { return number[static_cast<std::size_t>(row)]; };

    std::size_t k = 0;
    for (; k < sides.fronts.size() && sides.fronts[k].shift == Shift{}; ++k) {
        const Side &front = sides.fronts[k], &back = sides.backs[k];
        const auto ours = mesh.polygon(front.entry), theirs = mesh.polygon(back.entry);
        const auto start = std::ranges::find(theirs, ours[0]);
        bool same = ours.size() == theirs.size() && start != theirs.end();
        for (std::size_t c = 0; same && c < ours.size(); ++c)
            same =
                theirs[(static_cast<std::size_t>(start - theirs.begin()) + ours.size() - c) % ours.size()] == ours[c];
        if (!same)
            refuse("cells " + std::to_string(front.from) + " and " + std::to_string(front.to) +
                   " have different polygons of the face between them");
        add_face(mesh, front.entry, cell(front.from), cell(front.to));
    }
    for (const Side& side : sides.walls) {
        if (patches.empty() || patches.back().wall != side.to)
            patches.push_back({side.to, {}, faces.size(), 0, patches.size()});
        ++patches.back().count;
        add_face(mesh, side.entry, cell(side.from), -1);
    }
    while (k < sides.fronts.size()) {
        const std::size_t begin = k, first = faces.size();
        const Shift& shift = sides.fronts[begin].shift;
        for (; k < sides.fronts.size() && sides.fronts[k].shift == shift; ++k)
            add_face(mesh, sides.fronts[k].entry, cell(sides.fronts[k].from), -1);
        const std::size_t count = k - begin, number_of_patch = patches.size();
        Shift back{};
        std::ranges::transform(shift, back.begin(), [](int s) { return static_cast<std::int8_t>(-s); });
        patches.push_back({0, shift, first, count, number_of_patch + 1});
        patches.push_back({0, back, first + count, count, number_of_patch});
        const Vector3 apart = separation(patches[number_of_patch]);
        for (std::size_t b = begin; b < k; ++b) {
            add_face(mesh, sides.backs[b].entry, cell(sides.backs[b].to), -1);
            if (mesh.polygon(sides.backs[b].entry).size() != mesh.polygon(sides.fronts[b].entry).size())
                refuse("cells " + std::to_string(sides.backs[b].from) + " and " + std::to_string(sides.backs[b].to) +
                       " have different polygons of the face between them");
            turn_last_face(mesh, mesh.polygon(sides.fronts[b].entry), apart);
        }
    }
    vertices.assign(mesh.vertices.begin(), mesh.vertices.end());
    moved.resize(vertices.size() / 3);
    drop_unused_vertices();
    if (mesh.min_edge > 0) short_edges = collapse_edges(*this, mesh.min_edge);
    if (mesh.short_edges != nullptr) *mesh.short_edges = short_edges;
    if (mesh.measure) mesh.measure(*this);
}

void SharedMesh::add_face(const Mesh& mesh, std::size_t entry, std::int32_t owner, std::int32_t neighbor) {
    faces.push_back({owner, neighbor});
    planes.push_back(mesh.planes.empty() ? mesh.indices[entry] : mesh.planes[entry]);
    const auto polygon = mesh.polygon(entry);
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    offsets.push_back(static_cast<std::int64_t>(corners.size()));
}

// The polygon then begins with the image of the front's first corner: all corners together are nearest to their images.
// One corner alone might be as near to several, where rounding sets corners apart.
void SharedMesh::turn_last_face(const Mesh& mesh, std::span<const std::int32_t> front, const Vector3& apart) {
    const auto begin = corners.begin() + static_cast<std::ptrdiff_t>(offsets[offsets.size() - 2]);
    const std::span back(begin, corners.end());
    const std::size_t n = back.size();
    std::size_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t first = 0; first < n; ++first) {
        double sum = 0;
        for (std::size_t c = 0; c < n; ++c) {
            const double *const x = mesh.vertex(front[c]), *const y = mesh.vertex(back[(first + n - c) % n]);
            sum += length3(y[0] - (x[0] - apart[0]), y[1] - (x[1] - apart[1]), y[2] - (x[2] - apart[2]));
        }
        if (sum < least) least = sum, best = first;
    }
    std::rotate(begin, begin + static_cast<std::ptrdiff_t>(best), corners.end());
}

SharedEdges::SharedEdges(const SharedMesh& mesh) : of_corners(mesh.corners.size()) {
    struct Run {
        std::int32_t low, high;
        std::size_t corner;
    };
    std::vector<Run> runs;
    runs.reserve(mesh.corners.size());
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        const auto polygon = mesh.polygon(f);
        for (std::size_t c = 0; c < polygon.size(); ++c) {
            const std::int32_t a = polygon[c], b = polygon[(c + 1) % polygon.size()];
            const std::size_t corner = static_cast<std::size_t>(mesh.offsets[f]) + c;
            of_corners[corner] = a < b ? 1 : -1;
            runs.push_back({std::min(a, b), std::max(a, b), corner});
        }
    }
    std::ranges::sort(runs, {}, [](const Run& run) { return std::tie(run.low, run.high, run.corner); });
    for (const Run& run : runs) {
        if (ends.empty() || ends.back() != std::array{run.low, run.high}) ends.push_back({run.low, run.high});
        of_corners[run.corner] *= static_cast<std::int32_t>(ends.size());
    }
}

CellFaces::CellFaces(const SharedMesh& mesh) : begins_(mesh.cells() + 1) {
    const auto each = [&](const auto& use) {
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
            const auto number = static_cast<std::int32_t>(f + 1);
            use(static_cast<std::size_t>(mesh.faces[f].owner), number);
            if (mesh.faces[f].neighbor >= 0) use(static_cast<std::size_t>(mesh.faces[f].neighbor), -number);
        }
    };
    each([&](std::size_t cell, std::int32_t) { ++begins_[cell + 1]; });
    for (std::size_t i = 0; i < mesh.cells(); ++i) begins_[i + 1] += begins_[i];
    faces_.resize(begins_.back());
    std::vector<std::size_t> next(begins_);
    each([&](std::size_t cell, std::int32_t number) { faces_[next[cell]++] = number; });
}

void SharedMesh::drop_unused_vertices() {
    std::vector<std::int32_t> number(vertices.size() / 3, -1);
    for (const std::int32_t v : corners) number[static_cast<std::size_t>(v)] = 0;
    std::int32_t count = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] < 0) continue;
        const auto to = static_cast<std::size_t>(count);
        std::copy_n(&vertices[3 * v], 3, &vertices[3 * to]);
        moved[to] = moved[v];
        number[v] = count++;
    }
    vertices.resize(3 * static_cast<std::size_t>(count));
    moved.resize(static_cast<std::size_t>(count));
    for (std::int32_t& v : corners) v = number[static_cast<std::size_t>(v)];
}

}  // namespace votess::files
