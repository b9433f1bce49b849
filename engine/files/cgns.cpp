// CGNS 3.4 and later: one unstructured zone of polyhedra, in HDF5. Names and labels are those of the standard (SIDS).
#include <algorithm>
#include <limits>

#include "files/hdf5_nodes.hpp"
#include "files/shared_mesh.hpp"

namespace votess::files {
namespace {

constexpr std::int32_t polygons = 22, polyhedra = 23;  // NGON_n and NFACE_n

Hdf5Node group(const std::string& name, const std::string& label, std::vector<Hdf5Node> children) {
    return {name, label, NodeType::none, {}, {}, std::move(children)};
}

Hdf5Node text(const std::string& name, const std::string& label, const std::string& value) {
    return {name, label, NodeType::text, {value.size()}, [value](ByteSink& out) { out.put(value); }};
}

// Numbers of few values. The extent is that of HDF5.
template <class Number>
Hdf5Node numbers(const std::string& name, const std::string& label, NodeType type, std::vector<Number> values,
                 std::vector<std::uint64_t> extent = {}) {
    if (extent.empty()) extent = {values.size()};
    return {name, label, type, extent, [values = std::move(values)](ByteSink& out) {
                for (const Number value : values) out.put_binary(value);
            }};
}

class CgnsWriter {
public:
    explicit CgnsWriter(const Mesh& given) : given_(given), mesh_(given), cells_(mesh_) {
        if (mesh_.cells() == 0) refuse("a .cgns file holds at least one cell, and there is none");
        // Old readers know 32 bits alone.
        const auto largest = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
        std::size_t sides = 0;
        for (std::size_t i = 0; i < mesh_.cells(); ++i) sides += cells_.of(i).size();
        const std::size_t elements = mesh_.faces.size() + mesh_.cells();
        if (std::max({mesh_.corners.size(), sides, elements}) > largest) integer_ = NodeType::int64;
    }

    void write(ByteSink& out) const {
        const std::size_t vertices = mesh_.vertices.size() / 3, faces = mesh_.faces.size(), cells = mesh_.cells();
        std::vector<Hdf5Node> coordinates;
        for (std::size_t k = 0; k < 3; ++k)
            coordinates.push_back({std::string("Coordinate") + "XYZ"[k],
                                   "DataArray_t",
                                   NodeType::float64,
                                   {vertices},
                                   [this, k, vertices](ByteSink& sink) {
                                       for (std::size_t v = 0; v < vertices; ++v)
                                           sink.put_binary(mesh_.vertices[3 * v + k]);
                                   }});
        std::vector<Hdf5Node> zone;
        zone.push_back(text("ZoneType", "ZoneType_t", "Unstructured"));
        zone.push_back(group("GridCoordinates", "GridCoordinates_t", std::move(coordinates)));
        zone.push_back(elements(
            "Faces", polygons, 0, faces,
            [&](std::size_t f) -> std::span<const std::int32_t> { return mesh_.polygon(f); }, 1));
        zone.push_back(elements(
            "Cells", polyhedra, faces, cells, [&](std::size_t i) { return cells_.of(i); }, 0));
        std::vector<Hdf5Node> walls, connections;
        for (const Patch& patch : mesh_.patches)
            if (patch.count > 0) (patch.wall != 0 ? walls : connections).push_back(boundary(patch));
        if (!walls.empty()) zone.push_back(group("ZoneBC", "ZoneBC_t", std::move(walls)));
        if (!connections.empty())
            zone.push_back(group("ZoneGridConnectivity", "ZoneGridConnectivity_t", std::move(connections)));
        zone.push_back(group("Rows", "FlowSolution_t",
                             {text("GridLocation", "GridLocation_t", "CellCenter"),
                              integers("Row", "DataArray_t", {cells}, [this](std::size_t i) { return row_of(i); })}));
        std::vector<Hdf5Node> base{
            {"Zone", "Zone_t", integer_, {3, 1}, put_all({vertices, cells, 0}), std::move(zone)}};
        write_nodes({numbers<float>("CGNSLibraryVersion", "CGNSLibraryVersion_t", NodeType::float32, {3.4F}),
                     {"Base",
                      "CGNSBase_t",
                      NodeType::int32,
                      {2},
                      [](ByteSink& sink) {
                          for (int k = 0; k < 2; ++k) sink.put_binary(std::int32_t{3});
                      },
                      std::move(base)}},
                    out);
    }

private:
    void put_integer(ByteSink& out, std::int64_t value) const {
        if (integer_ == NodeType::int64) return out.put_binary(value);
        out.put_binary(static_cast<std::int32_t>(value));
    }
    // value: returns that of an index.
    [[nodiscard]] Hdf5Node integers(const std::string& name, const std::string& label,
                                    const std::vector<std::uint64_t>& extent, const auto& value) const {
        std::uint64_t count = 1;
        for (const std::uint64_t n : extent) count *= n;
        return {name, label, integer_, extent, [this, count, value](ByteSink& out) {
                    for (std::size_t k = 0; k < count; ++k) put_integer(out, static_cast<std::int64_t>(value(k)));
                }};
    }
    [[nodiscard]] std::function<void(ByteSink&)> put_all(const std::vector<std::size_t>& values) const {
        return [this, values](ByteSink& out) {
            for (const std::size_t value : values) put_integer(out, static_cast<std::int64_t>(value));
        };
    }
    [[nodiscard]] Hdf5Node range(const std::string& name, std::size_t first, std::size_t count,
                                 const std::vector<std::uint64_t>& extent) const {
        return {name, "IndexRange_t", integer_, extent, put_all({first + 1, first + count})};
    }

    // Elements are numbered from 1 on through both sections. parts: returns those of an element. Adds `base` to each.
    [[nodiscard]] Hdf5Node elements(const std::string& name, std::int32_t type, std::size_t first, std::size_t count,
                                    const auto& parts, int base) const {
        std::uint64_t total = 0;
        for (std::size_t e = 0; e < count; ++e) total += parts(e).size();
        const auto put_starts = [this, count, parts](ByteSink& out) {
            std::int64_t start = 0;
            put_integer(out, start);
            for (std::size_t e = 0; e < count; ++e)
                put_integer(out, start += static_cast<std::int64_t>(parts(e).size()));
        };
        const auto put_parts = [this, count, parts, base](ByteSink& out) {
            for (std::size_t e = 0; e < count; ++e)
                for (const std::int32_t part : parts(e)) put_integer(out, std::int64_t{part} + base);
        };
        Hdf5Node node = numbers<std::int32_t>(name, "Elements_t", NodeType::int32, {type, 0});
        node.children = {range("ElementRange", first, count, {2}),
                         {"ElementStartOffset", "DataArray_t", integer_, {count + 1}, put_starts},
                         {"ElementConnectivity", "DataArray_t", integer_, {total}, put_parts}};
        return node;
    }

    // A condition at a wall, or a periodic connection to the faces of the twin.
    [[nodiscard]] Hdf5Node boundary(const Patch& patch) const {
        std::vector<Hdf5Node> children{range("PointRange", patch.first, patch.count, {2, 1}),
                                       text("GridLocation", "GridLocation_t", "FaceCenter")};
        if (patch.wall != 0) {
            Hdf5Node node = text(patch.name(given_), "BC_t", "UserDefined");
            node.children = std::move(children);
            return node;
        }
        const std::size_t twin = mesh_.patches[patch.twin].first;
        const Vector3 apart = mesh_.separation(mesh_.patches[patch.twin]);
        std::vector<float> translation;
        for (const double x : apart) translation.push_back(static_cast<float>(x));
        const std::vector<float> nothing(3);
        children.push_back(text("GridConnectivityType", "GridConnectivityType_t", "Abutting1to1"));
        children.push_back(integers("PointListDonor", "IndexArray_t", {patch.count, 1},
                                    [twin](std::size_t k) { return twin + k + 1; }));
        children.push_back(group("GridConnectivityProperty", "GridConnectivityProperty_t",
                                 {group("Periodic", "Periodic_t",
                                        {numbers("RotationCenter", "DataArray_t", NodeType::float32, nothing),
                                         numbers("RotationAngle", "DataArray_t", NodeType::float32, nothing),
                                         numbers("Translation", "DataArray_t", NodeType::float32, translation)})}));
        Hdf5Node node = text(patch.name(given_), "GridConnectivity_t", "Zone");
        node.children = std::move(children);
        return node;
    }

    // Returns the row of a cell, which several pieces may have.
    [[nodiscard]] std::size_t row_of(std::size_t cell) const {
        const std::size_t row = mesh_.rows[cell];
        return given_.rows.empty() ? row : static_cast<std::size_t>(given_.rows[row]);
    }

    const Mesh& given_;
    SharedMesh mesh_;
    CellFaces cells_;
    NodeType integer_ = NodeType::int32;
};

}  // namespace

void write_cgns(const Mesh& mesh, ByteSink& out) {
    CgnsWriter(mesh).write(out);
}

}  // namespace votess::files
