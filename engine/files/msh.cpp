// Gmsh's .msh 4.1: the surfaces of all cells in triangles, with the topology that a mesher of volumes needs. Each
// vertex, edge, face and cell is an entity; cells have no elements yet.
#include <algorithm>

#include "core/at.hpp"
#include "core/box.hpp"
#include "files/shared_mesh.hpp"

namespace votess::files {
namespace {

void put_box(ByteSink& out, const Box& box) {
    for (const double x : box.lower) put_next(out, x);
    for (const double x : box.upper) put_next(out, x);
}

class MshWriter {
public:
    MshWriter(const Mesh& given, ByteSink& out) : given_(given), mesh_(given), edges_(mesh_), cells_(mesh_), out_(out) {
        for (std::size_t f = 0; f < mesh_.inner(); ++f) pairs_.push_back(pair_of(f));
        std::ranges::sort(pairs_);
        pairs_.erase(std::ranges::unique(pairs_).begin(), pairs_.end());
    }

    void write() {
        out_.put("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
        put_names();
        put_entities();
        put_nodes();
        put_elements();
    }

private:
    [[nodiscard]] std::size_t vertices() const { return mesh_.vertices.size() / 3; }
    // Returns the physical surface of a face: pairs of cells first, then the patches.
    [[nodiscard]] std::size_t group_of(std::size_t face) const {
        if (face < mesh_.inner())
            return static_cast<std::size_t>(std::ranges::lower_bound(pairs_, pair_of(face)) - pairs_.begin()) + 1;
        const auto patch = std::ranges::upper_bound(mesh_.patches, face, {}, &Patch::first);
        return pairs_.size() + static_cast<std::size_t>(patch - mesh_.patches.begin());
    }
    // Returns the row of a cell, which several pieces may have.
    [[nodiscard]] std::size_t row_of(std::size_t cell) const {
        const std::size_t row = mesh_.rows[cell];
        return given_.rows.empty() ? row : at(given_.rows[row]);
    }
    [[nodiscard]] std::array<std::size_t, 2> pair_of(std::size_t face) const {
        const std::size_t own = row_of(at(mesh_.faces[face].owner)), other = row_of(at(mesh_.faces[face].neighbor));
        return {std::min(own, other), std::max(own, other)};
    }

    void put_names() {
        out_.put("$PhysicalNames\n");
        std::vector<std::size_t> rows;
        for (std::size_t i = 0; i < mesh_.cells(); ++i)
            if (rows.empty() || rows.back() != row_of(i)) rows.push_back(row_of(i));
        out_.put_number(pairs_.size() + mesh_.patches.size() + rows.size());
        std::size_t tag = 0;
        const auto put = [&](int dimension, std::size_t number, const std::string& name) {
            out_.put("\n");
            out_.put_number(dimension);
            put_next(out_, number);
            out_.put(" \"" + name + "\"");
        };
        for (const auto& [own, other] : pairs_) put(2, ++tag, std::to_string(own) + " " + std::to_string(other));
        for (const Patch& patch : mesh_.patches) put(2, ++tag, patch.name(given_));
        for (const std::size_t row : rows) put(3, row + 1, "cell " + std::to_string(row));
        out_.put("\n$EndPhysicalNames\n");
    }

    void put_entities() {
        out_.put("$Entities\n");
        out_.put_number(vertices());
        for (const std::size_t count : {edges_.ends.size(), mesh_.faces.size(), mesh_.cells()}) put_next(out_, count);
        for (std::size_t v = 0; v < vertices(); ++v) {
            begin(v);
            for (const double x : mesh_.vertex(static_cast<std::int32_t>(v))) put_next(out_, x);
            out_.put(" 0");
        }
        for (std::size_t e = 0; e < edges_.ends.size(); ++e) {
            begin(e);
            put_bounds(edges_.ends[e]);
            out_.put(" 0 2");
            for (const std::int32_t v : edges_.ends[e]) put_next(out_, v + 1);
        }
        for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
            begin(f);
            const auto polygon = mesh_.polygon(f);
            put_bounds(polygon);
            out_.put(" 1");
            put_next(out_, group_of(f));
            put_next(out_, polygon.size());
            for (std::size_t c = 0; c < polygon.size(); ++c)
                put_next(out_, edges_.of_corners[static_cast<std::size_t>(mesh_.offsets[f]) + c]);
        }
        for (std::size_t i = 0; i < mesh_.cells(); ++i) {
            begin(i);
            Box bounds = empty_box;
            for (const std::int32_t face : cells_.of(i))
                for (const std::int32_t v : mesh_.polygon(static_cast<std::size_t>(std::abs(face)) - 1))
                    include(bounds, mesh_.vertex(v));
            put_box(out_, bounds);
            out_.put(" 1");
            put_next(out_, row_of(i) + 1);
            put_next(out_, cells_.of(i).size());
            for (const std::int32_t face : cells_.of(i)) put_next(out_, face);
        }
        out_.put("\n$EndEntities\n");
    }
    void begin(std::size_t number) {
        out_.put("\n");
        out_.put_number(number + 1);
    }
    void put_bounds(const auto& corners) {
        Box bounds = empty_box;
        for (const std::int32_t v : corners) include(bounds, mesh_.vertex(v));
        put_box(out_, bounds);
    }

    void put_nodes() {
        out_.put("$Nodes\n");
        out_.put_number(vertices());
        for (const std::size_t number : {vertices(), std::size_t{1}, vertices()}) put_next(out_, number);
        for (std::size_t v = 0; v < vertices(); ++v) {
            out_.put("\n0");
            put_next(out_, v + 1);
            out_.put(" 0 1\n");
            out_.put_number(v + 1);
            out_.put("\n");
            for (const double x : mesh_.vertex(static_cast<std::int32_t>(v))) put_next(out_, x);
        }
        out_.put("\n$EndNodes\n");
    }

    void put_elements() {
        constexpr int point = 15, line = 1, triangle = 2;
        const std::vector<std::size_t> apex = apexes(mesh_);
        std::size_t triangles = 0;
        for (std::size_t f = 0; f < mesh_.faces.size(); ++f) triangles += mesh_.polygon(f).size() - 2;
        const std::size_t blocks = vertices() + edges_.ends.size() + mesh_.faces.size();
        const std::size_t elements = vertices() + edges_.ends.size() + triangles;
        out_.put("$Elements\n");
        out_.put_number(blocks);
        for (const std::size_t number : {elements, std::size_t{1}, elements}) put_next(out_, number);
        std::size_t element = 0;
        const auto begin_block = [&](int dimension, std::size_t entity, int type, std::size_t count) {
            out_.put("\n");
            out_.put_number(dimension);
            put_next(out_, entity + 1);
            put_next(out_, type);
            put_next(out_, count);
        };
        const auto put = [&](const auto& corners) {
            begin(element++);
            for (const std::int32_t v : corners) put_next(out_, v + 1);
        };
        for (std::size_t v = 0; v < vertices(); ++v) {
            begin_block(0, v, point, 1);
            put(std::array{static_cast<std::int32_t>(v)});
        }
        for (std::size_t e = 0; e < edges_.ends.size(); ++e) {
            begin_block(1, e, line, 1);
            put(edges_.ends[e]);
        }
        for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
            const auto polygon = mesh_.polygon(f);
            const std::size_t n = polygon.size();
            begin_block(2, f, triangle, n - 2);
            for (std::size_t k = 1; k + 1 < n; ++k)
                put(std::array{polygon[apex[f]], polygon[(apex[f] + k) % n], polygon[(apex[f] + k + 1) % n]});
        }
        out_.put("\n$EndElements\n");
    }

    const Mesh& given_;
    SharedMesh mesh_;
    SharedEdges edges_;
    CellFaces cells_;
    std::vector<std::array<std::size_t, 2>> pairs_;  // rows of cells that touch
    ByteSink& out_;
};

}  // namespace

void write_msh(const Mesh& mesh, ByteSink& out) {
    MshWriter(mesh, out).write();
}

}  // namespace votess::files
