// OpenFOAM's polyMesh, as text.
#include "files/shared_mesh.hpp"

namespace votess::files {
namespace {

void begin_foam(ByteSink& out, const std::string& type, const std::string& object, const std::string& note = "") {
    out.begin_file("constant/polyMesh/" + object);
    out.put("// Voronoi cells by votess\nFoamFile\n{\n    version 2.0;\n    format ascii;\n    class " + type + ";\n");
    if (!note.empty()) out.put("    note \"" + note + "\";\n");
    out.put("    location \"constant/polyMesh\";\n    object " + object + ";\n}\n");
}

void put_length(ByteSink& out, std::size_t length) {
    out.put_number(length);
    out.put("\n(\n");
}

void put_vector(ByteSink& out, const Vector3& vector) {
    for (std::size_t k = 0; k < 3; ++k) {
        out.put(k == 0 ? "(" : " ");
        out.put_number(vector[k]);
    }
    out.put(")");
}

void put_patch(const Mesh& given, const SharedMesh& mesh, const Patch& patch, ByteSink& out) {
    out.put("    " + patch.name(given) + "\n    {\n");
    if (patch.wall != 0) {
        out.put("        type patch;\n");
    } else {
        out.put("        type cyclic;\n        transform translational;\n        neighbourPatch " +
                mesh.patches[patch.twin].name(given) + ";\n        separationVector ");
        put_vector(out, mesh.separation(mesh.patches[patch.twin]));  // from this patch to its twin
        out.put(";\n");
    }
    out.put("        nFaces " + std::to_string(patch.count) + ";\n        startFace " + std::to_string(patch.first) +
            ";\n    }\n");
}

}  // namespace

void write_foam(const Mesh& given, ByteSink& out) {
    const SharedMesh mesh(given);
    const std::size_t vertices = mesh.vertices.size() / 3, faces = mesh.faces.size();
    begin_foam(out, "vectorField", "points");
    put_length(out, vertices);
    for (std::size_t v = 0; v < vertices; ++v) {
        put_vector(out, mesh.vertex(static_cast<std::int32_t>(v)));
        out.put("\n");
    }
    out.put(")\n");

    begin_foam(out, "faceList", "faces");
    put_length(out, faces);
    for (std::size_t f = 0; f < faces; ++f) {
        const auto polygon = mesh.polygon(f);
        out.put_number(polygon.size());
        for (std::size_t c = 0; c < polygon.size(); ++c) {
            out.put(c == 0 ? "(" : " ");
            out.put_number(polygon[c]);
        }
        out.put(")\n");
    }
    out.put(")\n");

    const std::string note = "nPoints:" + std::to_string(vertices) + "  nCells:" + std::to_string(mesh.cells()) +
                             "  nFaces:" + std::to_string(faces) + "  nInternalFaces:" + std::to_string(mesh.inner());
    for (const bool owners : {true, false}) {
        const std::size_t count = owners ? faces : mesh.inner();
        begin_foam(out, "labelList", owners ? "owner" : "neighbour", note);
        put_length(out, count);
        for (std::size_t f = 0; f < count; ++f) {
            out.put_number(owners ? mesh.faces[f].owner : mesh.faces[f].neighbor);
            out.put("\n");
        }
        out.put(")\n");
    }

    begin_foam(out, "polyBoundaryMesh", "boundary");
    put_length(out, mesh.patches.size());
    for (const Patch& patch : mesh.patches) put_patch(given, mesh, patch, out);
    out.put(")\n");
}

}  // namespace votess::files
