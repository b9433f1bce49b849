// .glb: the cells as triangles with flat colors, in the binary form of glTF 2.0 (ISO/IEC 12113).
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>

#include "failure.hpp"
#include "files/atomic_file.hpp"
#include "write/output.hpp"
#if VOTESS_HAVE_GLTF
#include <tiny_gltf.h>
#endif

namespace clvotess {

#if VOTESS_HAVE_GLTF

void check_glb() {}

namespace {

using Vector = std::array<double, 3>;

// Colors of vertices are linear in glTF.
std::array<float, 256> linear_of_srgb() {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double s = static_cast<double>(i) / 255;
        table[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return table;
}

// Twice the area of a polygon along its unit normal (Newell), which becomes that normal; false when it has none.
bool make_normal(const std::vector<Vector>& corners, Vector& normal) {
    normal = {};
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vector &a = corners[k], &b = corners[k + 1 < corners.size() ? k + 1 : 0];
        normal[0] += (a[1] - b[1]) * (a[2] + b[2]);
        normal[1] += (a[2] - b[2]) * (a[0] + b[0]);
        normal[2] += (a[0] - b[0]) * (a[1] + b[1]);
    }
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    for (double& x : normal) x /= length;
    return std::isnormal(length);
}

class Triangles {
public:
    Triangles(const OutputData& data, const std::vector<std::uint8_t>& colors) : cells_(data.tessellation) {
        const votess::Box& box = cells_.box();
        for (std::size_t axis = 0; axis < 3; ++axis) middle_[axis] = std::midpoint(box.lower[axis], box.upper[axis]);
        const auto linear = linear_of_srgb();
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            add_cell(i, {linear[colors[3 * i]], linear[colors[3 * i + 1]], linear[colors[3 * i + 2]], 1.0F});
        }
    }

    [[nodiscard]] tinygltf::Model model() const {
        tinygltf::Model model;
        model.asset.version = "2.0";
        model.asset.generator = "votess " VOTESS_VERSION_STRING;
        if (rows_.empty()) return model;  // an array of the format holds at least one number
        model.buffers.emplace_back();
        tinygltf::Primitive primitive;
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        primitive.material = 0;
        primitive.attributes["POSITION"] = add(model, positions_, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
        primitive.attributes["NORMAL"] = add(model, normals_, 3, TINYGLTF_TARGET_ARRAY_BUFFER);
        primitive.attributes["COLOR_0"] = add(model, colors_, 4, TINYGLTF_TARGET_ARRAY_BUFFER);
        primitive.attributes["_CELL"] = add(model, rows_, 1, TINYGLTF_TARGET_ARRAY_BUFFER);
        primitive.indices = add(model, indices_, 1, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
        add_bounds(model.accessors[0]);
        tinygltf::Material material;
        material.name = "cells";
        material.pbrMetallicRoughness.metallicFactor = 0;
        material.pbrMetallicRoughness.roughnessFactor = 0.8;
        model.materials.push_back(material);
        tinygltf::Mesh mesh;
        mesh.name = "Voronoi cells";
        mesh.primitives.push_back(primitive);
        model.meshes.push_back(mesh);
        tinygltf::Node node;
        node.mesh = 0;
        node.name = mesh.name;
        node.translation = {middle_.begin(), middle_.end()};
        model.nodes.push_back(node);
        model.scenes.emplace_back();
        model.scenes[0].nodes = {0};
        model.defaultScene = 0;
        return model;
    }

private:
    void add_cell(std::size_t i, const std::array<float, 4>& color) {
        const auto offsets = cells_.face_offsets();
        for (auto entry = cells_.indptr()[i]; entry < cells_.indptr()[i + 1]; ++entry) {
            const auto begin = static_cast<std::size_t>(offsets[static_cast<std::size_t>(entry)]);
            const auto end = static_cast<std::size_t>(offsets[static_cast<std::size_t>(entry) + 1]);
            corners_.clear();
            for (const std::int32_t index : cells_.face_vertices().subspan(begin, end - begin)) {
                const double* const at = cells_.vertices().data() + 3 * static_cast<std::size_t>(index);
                corners_.push_back({at[0] - middle_[0], at[1] - middle_[1], at[2] - middle_[2]});
            }
            Vector normal{};
            if (make_normal(corners_, normal)) add_face(i, normal, color);
        }
    }

    // A fan: faces are convex.
    void add_face(std::size_t i, const Vector& normal, const std::array<float, 4>& color) {
        const auto first = static_cast<std::uint32_t>(rows_.size());
        for (const Vector& corner : corners_) {
            for (const double x : corner) positions_.push_back(static_cast<float>(x));
            for (const double x : normal) normals_.push_back(static_cast<float>(x));
            colors_.insert(colors_.end(), color.begin(), color.end());
            rows_.push_back(static_cast<float>(i));
        }
        for (std::uint32_t k = 2; k < corners_.size(); ++k) {
            indices_.insert(indices_.end(), {first, first + k - 1, first + k});
        }
        if (rows_.size() > std::numeric_limits<std::uint32_t>::max() / 44) {
            throw bad_input("the cells are too many for .glb, which ends at 4 GiB: write .vtu or .ply");
        }
    }

    // Adds an array to the buffer and returns the number of its accessor.
    template <typename Number>
    static int add(tinygltf::Model& model, const std::vector<Number>& numbers, std::size_t width, int target) {
        std::vector<unsigned char>& bytes = model.buffers[0].data;
        const auto* const begin = reinterpret_cast<const unsigned char*>(numbers.data());
        tinygltf::BufferView view;
        view.buffer = 0;
        view.byteOffset = bytes.size();
        view.byteLength = numbers.size() * sizeof(Number);
        view.target = target;
        bytes.insert(bytes.end(), begin, begin + view.byteLength);
        model.bufferViews.push_back(view);
        tinygltf::Accessor accessor;
        accessor.bufferView = static_cast<int>(model.bufferViews.size()) - 1;
        accessor.componentType =
            std::is_same_v<Number, float> ? TINYGLTF_COMPONENT_TYPE_FLOAT : TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        accessor.count = numbers.size() / width;
        accessor.type = width == 1 ? TINYGLTF_TYPE_SCALAR : width == 3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC4;
        model.accessors.push_back(accessor);
        return static_cast<int>(model.accessors.size()) - 1;
    }

    // The format demands them of positions.
    void add_bounds(tinygltf::Accessor& accessor) const {
        accessor.minValues.assign(3, std::numeric_limits<double>::infinity());
        accessor.maxValues.assign(3, -std::numeric_limits<double>::infinity());
        for (std::size_t k = 0; k < positions_.size(); ++k) {
            accessor.minValues[k % 3] = std::min(accessor.minValues[k % 3], static_cast<double>(positions_[k]));
            accessor.maxValues[k % 3] = std::max(accessor.maxValues[k % 3], static_cast<double>(positions_[k]));
        }
    }

    const votess::Tessellation& cells_;
    Vector middle_{};  // positions are float32 and count from there
    std::vector<Vector> corners_;
    std::vector<float> positions_, normals_, colors_, rows_;
    std::vector<std::uint32_t> indices_;
};

}  // namespace

void write_glb(OutputFile& file, const OutputData& data) {
    votess::PictureOptions options;
    options.colormap = data.coloring.colormap;
    const std::vector<double> values = data.coloring.values(data.input, data.tessellation, data.carried);
    options.values = values;
    const Triangles triangles(data, votess::value_colors(options));
    tinygltf::Model model = triangles.model();
    std::ostringstream bytes;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, bytes, false, true)) {
        throw runtime_failure("cannot make a .glb file");
    }
    file.write(bytes.view());
}

#else

void check_glb() {
    throw bad_input("this clvotess was built without tinygltf, which writes .glb: write .ply or .vtu");
}

void write_glb(OutputFile&, const OutputData&) {
    check_glb();
}

#endif

}  // namespace clvotess
