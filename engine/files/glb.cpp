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

#include "files/mesh.hpp"

namespace votess::files {
namespace {

constexpr std::uint64_t largest_file = std::numeric_limits<std::uint32_t>::max();  // the format counts in 32 bits
constexpr std::uint64_t short_vertices = 65535;                                    // 65535 itself is not an index

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

template <class Number>
std::string text_of(const std::array<Number, 3>& numbers) {
    std::string text;
    for (const Number number : numbers) {
        std::array<char, 32> digits{};
        const char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
        text.append(text.empty() ? "[" : ",").append(std::string_view(digits.data(), end));
    }
    return text + "]";
}

void add_to_list(std::string& list, const std::string& item) {
    list.append(list.empty() ? "" : ",").append(item);
}

std::uint64_t in_words(std::uint64_t bytes) {
    return (bytes + 3) / 4 * 4;
}

class GlbWriter {
public:
    explicit GlbWriter(const Mesh& mesh) : mesh_(mesh) {
        for (std::size_t i = 0; i < mesh.cells(); ++i) add_cell(i);
        for (const Chunk& chunk : chunks_) binary_bytes_ += chunk.bytes();
        head_ = head();
        head_.resize(in_words(head_.size()), ' ');
    }

    [[nodiscard]] std::uint64_t bytes() const { return 20 + head_.size() + (chunks_.empty() ? 0 : 8 + binary_bytes_); }

    void write(ByteSink& out) const {
        out.put("glTF");
        for (const std::uint64_t number : {std::uint64_t{2}, bytes(), std::uint64_t{head_.size()}})
            out.put_binary(static_cast<std::uint32_t>(number));
        out.put("JSON");
        out.put(head_);
        if (!chunks_.empty()) {
            out.put_binary(static_cast<std::uint32_t>(binary_bytes_));
            out.put(std::string_view("BIN\0", 4));
        }
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
        [[nodiscard]] std::uint64_t bytes() const { return 20 * vertices + in_words(index_bytes()); }
    };

    template <class Use>
    void each_face(std::size_t i, const Use& use) const {
        const auto [begin, end] = mesh_.entries(i);
        for (std::size_t entry = begin; entry < end; ++entry)
            if (mesh_.polygon(entry).size() >= 3) use(mesh_.polygon(entry));
    }

    // Returns the position from the middle of the domain, because float32 has few digits. y is up, as glTF demands: z
    // becomes y, and y becomes -z. That is a rotation, so faces keep their fronts.
    [[nodiscard]] Position position(std::int32_t vertex) const {
        const double* const at = mesh_.vertex(vertex);
        const std::array<double, 3>& middle = mesh_.middle;
        return {static_cast<float>(at[0] - middle[0]), static_cast<float>(at[2] - middle[2]),
                static_cast<float>(middle[1] - at[1])};
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

    [[nodiscard]] std::string head() const {
        const std::string asset = R"({"asset":{"version":"2.0","generator":"votess )" VOTESS_VERSION_STRING "\"}";
        if (chunks_.empty()) return asset + "}";  // an array of the format holds at least one number
        std::string views, accessors, primitives;
        std::uint64_t place = 0;
        int arrays = 0;
        const auto add = [&](std::uint64_t count, std::uint64_t bytes, bool of_vertices, const std::string& type) {
            add_to_list(views, R"({"buffer":0,"byteOffset":)" + std::to_string(place) + ",\"byteLength\":" +
                                   std::to_string(bytes) + ",\"target\":" + (of_vertices ? "34962}" : "34963}"));
            add_to_list(accessors, "{\"bufferView\":" + std::to_string(arrays) + ",\"count\":" + std::to_string(count) +
                                       "," + type + "}");
            place += in_words(bytes);
            return std::to_string(arrays++);
        };
        for (const Chunk& chunk : chunks_) {
            const std::uint64_t n = chunk.vertices;
            const std::string bounds = ",\"min\":" + text_of(chunk.lower) + ",\"max\":" + text_of(chunk.upper);
            const auto positions = add(n, 12 * n, true, R"("componentType":5126,"type":"VEC3")" + bounds);
            const auto colors = add(n, 4 * n, true, R"("componentType":5121,"normalized":true,"type":"VEC4")");
            const auto rows = add(n, 4 * n, true, R"("componentType":5126,"type":"SCALAR")");
            const std::string width = chunk.is_short() ? "5123" : "5125";
            const auto indices =
                add(chunk.indices, chunk.index_bytes(), false, "\"componentType\":" + width + R"(,"type":"SCALAR")");
            add_to_list(primitives, "{\"attributes\":{\"POSITION\":" + positions + ",\"COLOR_0\":" + colors +
                                        ",\"_CELL\":" + rows + "},\"indices\":" + indices + ",\"material\":0}");
        }
        const std::array<double, 3> middle{mesh_.middle[0], mesh_.middle[2], -mesh_.middle[1]};
        // Without a material, viewers show metal, which is dark.
        return asset +
               R"(,"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"Voronoi cells","translation":)" +
               text_of(middle) + R"(}],"meshes":[{"name":"Voronoi cells","primitives":[)" + primitives +
               R"(]}],"materials":[{"name":"cells","pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.9}}],)" +
               "\"accessors\":[" + accessors + "],\"bufferViews\":[" + views +
               "],\"buffers\":[{\"byteLength\":" + std::to_string(binary_bytes_) + "}]}";
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
    std::uint64_t binary_bytes_ = 0;
    std::string head_;
};

}  // namespace

void write_glb(const Mesh& mesh, ByteSink& out) {
    const GlbWriter writer(mesh);
    if (writer.bytes() > largest_file) {
        throw Error(ErrorCode::invalid_argument, "the .glb file would take " +
                                                     std::to_string((writer.bytes() + 999'999) / 1'000'000) +
                                                     " MB, but .glb ends at 4 GiB: write .vtu, or fewer cells");
    }
    out.set_total(writer.bytes());
    writer.write(out);
}

}  // namespace votess::files
