// .glb: the cells as triangles with flat colors, in the binary form of glTF 2.0 (ISO/IEC 12113).
//
// Each cell is a closed solid with vertices of its own, which carry its color and no normals: the format demands that
// a mesh without normals is shaded flat. Cells lie in chunks of at most 65535 vertices, so that an index takes two
// bytes. A chunk is a primitive of the one mesh.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <votess/votess.hpp>

#include "files/gltf.hpp"
#include "files/mesh.hpp"

namespace votess::files {
namespace {

// glTF takes the colors of vertices as linear.
std::array<std::uint8_t, 256> linear_of_srgb() {
    std::array<std::uint8_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
        const double s = static_cast<double>(i) / 255;
        const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
        table[i] = static_cast<std::uint8_t>(std::lround(255 * linear));
    }
    return table;
}

class GlbWriter {
public:
    explicit GlbWriter(const Mesh& mesh) : mesh_(mesh) {
        for (std::size_t i = 0; i < mesh.cells(); ++i) add_cell(i);
    }

    void write(ByteSink& out) const {
        GltfArrays arrays;
        const std::string text = head(arrays);
        begin_glb(text, arrays.bytes(), "write .vtu, or fewer cells", out);
        for (const Chunk& chunk : chunks_) put_chunk(out, chunk);
    }

private:
    using Position = std::array<float, 3>;

    // Consecutive cells. The file has their positions, colors, rows, indices.
    struct Chunk {
        std::size_t first_cell = 0, end_cell = 0;
        std::uint64_t vertices = 0, indices = 0;
        Position lower{}, upper{};

        [[nodiscard]] bool is_short() const { return vertices <= short_vertices; }
        [[nodiscard]] std::uint64_t index_bytes() const { return indices * (is_short() ? 2 : 4); }
    };

    template <class Use>
    void each_face(std::size_t i, const Use& use) const {
        const auto [begin, end] = mesh_.entries(i);
        for (std::size_t entry = begin; entry < end; ++entry)
            if (mesh_.polygon(entry).size() >= 3) use(mesh_.polygon(entry));
    }

    // Returns the position from the middle of the domain, because float32 has few digits.
    [[nodiscard]] Position position(std::int32_t vertex) const {
        const double* const at = mesh_.vertex(vertex);
        const std::array<double, 3>& middle = mesh_.middle;
        return with_y_up<float>(at[0] - middle[0], at[1] - middle[1], at[2] - middle[2]);
    }

    void add_cell(std::size_t i) {
        const auto vertices = mesh_.vertices_of(i);
        if (vertices.empty()) return;
        if (chunks_.empty() || chunks_.back().vertices + vertices.size() > short_vertices) {
            const Position first = position(vertices[0]);
            chunks_.push_back({.first_cell = i, .lower = first, .upper = first});
        }
        Chunk& chunk = chunks_.back();
        chunk.end_cell = i + 1;
        chunk.vertices += vertices.size();
        each_face(i, [&](auto polygon) { chunk.indices += 3 * (polygon.size() - 2); });
        for (const std::int32_t vertex : vertices) {
            const Position at = position(vertex);
            for (std::size_t k = 0; k < 3; ++k) {
                chunk.lower[k] = std::min(chunk.lower[k], at[k]);
                chunk.upper[k] = std::max(chunk.upper[k], at[k]);
            }
        }
    }

    [[nodiscard]] std::string head(GltfArrays& arrays) const {
        const std::string asset = gltf_asset;
        if (chunks_.empty()) return asset + "}";  // an array of the format holds at least one number
        std::string primitives;
        for (const Chunk& chunk : chunks_) {
            const std::uint64_t n = chunk.vertices;
            const auto positions = arrays.add_positions(n, chunk.lower, chunk.upper);
            const auto colors = arrays.add(n, 4 * n, true, R"("componentType":5121,"normalized":true,"type":"VEC4")");
            const auto rows = arrays.add(n, 4 * n, true, R"("componentType":5126,"type":"SCALAR")");
            const auto indices = arrays.add_indices(chunk.indices, chunk.is_short());
            add_to_list(primitives, "{\"attributes\":{\"POSITION\":" + positions + ",\"COLOR_0\":" + colors +
                                        ",\"_CELL\":" + rows + "},\"indices\":" + indices + ",\"material\":0}");
        }
        const auto middle = with_y_up<double>(mesh_.middle[0], mesh_.middle[1], mesh_.middle[2]);
        // Without a material, viewers show metal, which is dark.
        return asset +
               R"(,"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"Voronoi cells","translation":)" +
               text_of(middle) + R"(}],"meshes":[{"name":"Voronoi cells","primitives":[)" + primitives +
               R"(]}],"materials":[{"name":"cells","pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.9}}],)" +
               arrays.members() + "}";
    }

    void put_chunk(ByteSink& out, const Chunk& chunk) const {
        const auto each_vertex = [&](const auto& use) {
            for (std::size_t i = chunk.first_cell; i < chunk.end_cell; ++i)
                for (const std::int32_t vertex : mesh_.vertices_of(i)) use(i, vertex);
        };
        each_vertex([&](std::size_t, std::int32_t vertex) { out.put_binary(position(vertex)); });
        each_vertex([&](std::size_t i, std::int32_t) {
            const std::uint8_t* const c = mesh_.colors.data() + 3 * i;
            out.put_binary(std::array<std::uint8_t, 4>{linear_[c[0]], linear_[c[1]], linear_[c[2]], 255});
        });
        each_vertex([&](std::size_t i, std::int32_t) { out.put_binary(static_cast<float>(i)); });
        std::size_t before = 0;  // vertices of earlier cells
        std::vector<std::size_t> corners;
        const auto put_index = [&](std::size_t index) {
            if (chunk.is_short())
                out.put_binary(static_cast<std::uint16_t>(index));
            else
                out.put_binary(static_cast<std::uint32_t>(index));
        };
        for (std::size_t i = chunk.first_cell; i < chunk.end_cell; ++i) {
            const auto vertices = mesh_.vertices_of(i);
            each_face(i, [&](auto polygon) {
                corners.clear();
                for (const std::int32_t vertex : polygon) {
                    const auto at = std::ranges::lower_bound(vertices, vertex);
                    corners.push_back(before + static_cast<std::size_t>(at - vertices.begin()));
                }
                for (std::size_t k = 2; k < corners.size(); ++k)  // a fan: faces are convex
                    for (const std::size_t corner : {std::size_t{0}, k - 1, k}) put_index(corners[corner]);
            });
            before += vertices.size();
        }
        out.put(std::string_view("\0\0\0", in_words(chunk.index_bytes()) - chunk.index_bytes()));
    }

    const Mesh& mesh_;
    const std::array<std::uint8_t, 256> linear_ = linear_of_srgb();
    std::vector<Chunk> chunks_;
};

}  // namespace

void write_glb(const Mesh& mesh, ByteSink& out) {
    GlbWriter(mesh).write(out);
}

}  // namespace votess::files
