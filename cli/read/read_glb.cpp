// GLB: binary glTF 2.0. A header, a chunk of JSON, and a chunk of numbers that its accessors describe. The mesh has the
// triangles of all nodes of the scene, each moved by the matrices of its node and of those above it.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "failure.hpp"
#include "files/binary_numbers.hpp"
#include "files/json.hpp"
#include "files/limits.hpp"
#include "interrupt.hpp"
#include "read/surface.hpp"

namespace clvotess {
namespace {

constexpr std::string_view magic = "glTF";

// An affine map: the rows of its matrix, then the translation.
struct Placement {
    std::array<std::array<double, 4>, 3> rows{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

    [[nodiscard]] std::array<double, 3> at(const std::array<double, 3>& x) const {
        std::array<double, 3> y{};
        for (std::size_t i = 0; i < 3; ++i)
            y[i] = rows[i][0] * x[0] + rows[i][1] * x[1] + rows[i][2] * x[2] + rows[i][3];
        return y;
    }
    // Returns the placement that first applies `inner`.
    [[nodiscard]] Placement of(const Placement& inner) const {
        Placement both;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 4; ++k) {
                both.rows[i][k] = k == 3 ? rows[i][3] : 0;
                for (std::size_t j = 0; j < 3; ++j) both.rows[i][k] += rows[i][j] * inner.rows[j][k];
            }
        return both;
    }
    [[nodiscard]] bool mirrors() const {
        const auto& [a, b, c] = rows;
        return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                   a[2] * (b[0] * c[1] - b[1] * c[0]) <
               0;
    }
};

class GlbReader {
public:
    GlbReader(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

    Surface read() {
        const Json document = read_chunks();
        if (const auto needed = document.find("extensionsRequired"))
            for (const Json& extension : needed->items())
                if (extension.text() != "\"KHR_texture_transform\"" &&
                    !extension.text().starts_with("\"KHR_materials_"))
                    throw error("it needs the extension " + std::string(extension.text()) +
                                ", which is not read: export it without");
        const std::vector<Json> buffers = items(document, "buffers");
        if (!buffers.empty() && buffers[0].find("uri"))
            throw error("its numbers are in a \"uri\" and not in the chunk BIN, as Open3D writes them: write .ply");
        nodes_ = items(document, "nodes");
        meshes_ = items(document, "meshes");
        accessors_ = items(document, "accessors");
        views_ = items(document, "bufferViews");
        surface_.merge = true;
        walk(roots(document));
        if (surface_.triangles.empty()) throw error("its scene has no triangles");
        return std::move(surface_);
    }

private:
    struct Array {
        const char* first;
        std::size_t count, step;
        NumberType type;
    };
    static constexpr std::uint64_t triangles = 4, strip = 5, fan = 6;  // modes
    struct Primitive {
        std::uint64_t mode;
        Array points;
        std::optional<Array> indices;
    };
    struct Visit {
        std::size_t node;
        Placement above;
    };

    [[nodiscard]] Failure error(const std::string& message) const { return bad_input(name_ + ": " + message); }

    [[nodiscard]] Failure moved(const std::string& by) const {
        return error("its vertices are placed by " + by + ", which is not read: export it with them applied");
    }

    static std::vector<Json> items(const Json& object, std::string_view name) {
        const auto found = object.find(name);
        return found ? found->items() : std::vector<Json>{};
    }
    // Returns a member that is a whole number, or `absent`.
    [[nodiscard]] std::uint64_t whole(const Json& object, std::string_view name,
                                      std::optional<std::uint64_t> absent) const {
        const auto found = object.find(name);
        const auto number = found ? found->whole() : absent;
        if (!number) throw error("its JSON has no whole number " + in_quotes(name) + " where one is needed");
        return *number;
    }
    [[nodiscard]] const Json& entry(const std::vector<Json>& all, std::uint64_t index, const char* what) const {
        if (index >= all.size())
            throw error(std::string(what) + " " + std::to_string(index) + " is named, but there are " +
                        std::to_string(all.size()));
        return all[index];
    }
    template <std::size_t count>
    [[nodiscard]] std::optional<std::array<double, count>> numbers(const Json& object, std::string_view name) const {
        const auto found = object.find(name);
        if (!found) return std::nullopt;
        const std::vector<Json> values = found->items();
        std::array<double, count> all{};
        for (std::size_t k = 0; k < count; ++k) {
            const auto number = k < values.size() ? values[k].number() : std::nullopt;
            if (!number || values.size() != count)
                throw error(in_quotes(name) + " of a node must be " + std::to_string(count) + " numbers");
            all[k] = *number;
        }
        return all;
    }

    Json read_chunks() {
        constexpr std::size_t header = 12, head = 8;
        const auto number = [&](std::size_t at) { return std::size_t{load_number<std::uint32_t>(&bytes_[at], false)}; };
        if (!bytes_.starts_with(magic) || bytes_.size() < header + head || number(4) != 2)
            throw error("not a binary glTF file of version 2");
        if (number(8) != bytes_.size())
            throw error(std::to_string(number(8)) + " bytes are announced, but the file has " +
                        std::to_string(bytes_.size()));
        std::optional<std::string_view> json;
        for (std::size_t at = header; at + head <= bytes_.size();) {
            const std::size_t size = number(at);
            const std::string_view kind = bytes_.substr(at + 4, 4);
            if (size > bytes_.size() - at - head) throw error("the file ends within a chunk");
            if (kind == "JSON" && !json) json = bytes_.substr(at + head, size);
            if (kind == std::string_view("BIN\0", 4) && binary_.empty()) binary_ = bytes_.substr(at + head, size);
            at += head + size;
        }
        if (!json) throw error("it has no chunk of JSON");
        return Json::read(*json, name_);
    }

    // Returns the nodes of the scene; of all, those that are below no other, if there is none.
    [[nodiscard]] std::vector<std::uint64_t> roots(const Json& document) const {
        const std::vector<Json> scenes = items(document, "scenes");
        if (!scenes.empty()) return children(entry(scenes, whole(document, "scene", 0), "scene"), "nodes");
        std::vector<bool> below(nodes_.size());
        for (const Json& node : nodes_)
            for (const std::uint64_t child : children(node, "children")) below[child] = true;
        std::vector<std::uint64_t> all;
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            if (!below[i]) all.push_back(i);
        return all;
    }
    [[nodiscard]] std::vector<std::uint64_t> children(const Json& object, std::string_view name) const {
        std::vector<std::uint64_t> all;
        for (const Json& child : items(object, name)) {
            const auto index = child.whole();
            if (!index) throw error(in_quotes(child.text()) + " is not the index of a node");
            (void)entry(nodes_, *index, "node");
            all.push_back(*index);
        }
        return all;
    }

    void walk(const std::vector<std::uint64_t>& roots) {
        std::vector<bool> seen(nodes_.size());
        Placement up;  // y is up in the file
        up.rows = {{{1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}}};
        std::vector<Visit> pending;
        for (const std::uint64_t root : roots) pending.push_back({root, up});
        while (!pending.empty()) {
            const auto [index, above] = pending.back();
            pending.pop_back();
            if (seen[index]) throw error("node " + std::to_string(index) + " has two parents");
            seen[index] = true;
            const bool has_mesh = nodes_[index].find("mesh").has_value();
            const std::vector<std::uint64_t> below = children(nodes_[index], "children");
            if (!has_mesh && below.empty()) continue;  // a camera or a light
            const Placement place = above.of(placement(index));
            if (has_mesh) add_mesh(nodes_[index], place);
            for (const std::uint64_t child : below) pending.push_back({child, place});
        }
    }

    [[nodiscard]] Placement placement(std::size_t index) const {
        const Json& node = nodes_[index];
        const auto forbidden = [&](const std::string& what) {
            return error("node " + std::to_string(index) + " has " + what + ", which glTF forbids: export it again");
        };
        Placement result;
        if (const auto columns = numbers<16>(node, "matrix")) {
            for (const char* const other : {"translation", "rotation", "scale"})
                if (node.find(other)) throw forbidden("both \"matrix\" and " + in_quotes(other));
            for (std::size_t k = 0; k < 4; ++k)
                if ((*columns)[4 * k + 3] != (k < 3 ? 0 : 1))
                    throw forbidden("a \"matrix\" with another last row than 0, 0, 0, 1");
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t k = 0; k < 4; ++k) result.rows[i][k] = (*columns)[4 * k + i];
            return result;
        }
        const auto move = numbers<3>(node, "translation").value_or(std::array<double, 3>{});
        const auto scale = numbers<3>(node, "scale").value_or(std::array<double, 3>{1, 1, 1});
        auto [x, y, z, w] = numbers<4>(node, "rotation").value_or(std::array<double, 4>{0, 0, 0, 1});
        const double length = std::sqrt(x * x + y * y + z * z + w * w);
        if (!(std::abs(length - 1) < 0x1p-10)) throw error("\"rotation\" of a node is not of length 1");
        for (double* const part : {&x, &y, &z, &w}) *part /= length;
        const std::array<std::array<double, 3>, 3> turn{
            {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
             {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
             {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}};
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t k = 0; k < 3; ++k) result.rows[i][k] = turn[i][k] * scale[k];
            result.rows[i][3] = move[i];
        }
        return result;
    }

    [[nodiscard]] Array array(std::uint64_t index, const char* type) const {
        const Json& accessor = entry(accessors_, index, "accessor");
        const std::string what = "accessor " + std::to_string(index);
        const auto kind = accessor.find("type");
        if (!kind || kind->text() != type) throw error(what + " is not of the type " + type);
        if (accessor.find("sparse")) throw error(what + " is sparse, which is not read");
        constexpr std::array<std::pair<std::uint64_t, NumberType>, 4> types{{{5121, NumberType::uint8},
                                                                             {5123, NumberType::uint16},
                                                                             {5125, NumberType::uint32},
                                                                             {5126, NumberType::float32}}};
        const std::uint64_t code = whole(accessor, "componentType", {});
        const auto found = std::ranges::find(types, code, &std::pair<std::uint64_t, NumberType>::first);
        if (found == types.end())
            throw error(what + " has numbers of type " + std::to_string(code) + ", which is not read");
        const Json& view = entry(views_, whole(accessor, "bufferView", {}), "bufferView");
        if (whole(view, "buffer", {}) != 0) throw error("numbers outside of the file are not read: export one .glb");
        const std::uint64_t begin = whole(view, "byteOffset", 0), length = whole(view, "byteLength", {});
        const std::uint64_t from = whole(accessor, "byteOffset", 0), count = whole(accessor, "count", {});
        const std::uint64_t each = size_of(found->second) * (type == std::string_view("\"VEC3\"") ? 3 : 1);
        const std::uint64_t step = whole(view, "byteStride", each);
        const bool fits = begin <= binary_.size() && length <= binary_.size() - begin && from <= length &&
                          step >= each &&
                          (count == 0 || (each <= length - from && count - 1 <= (length - from - each) / step));
        if (!fits) throw error(what + " reaches beyond its bytes");
        return {binary_.data() + begin + from, static_cast<std::size_t>(count), static_cast<std::size_t>(step),
                found->second};
    }

    // Reads the triangles of a mesh, once.
    const std::vector<Primitive>& primitives(std::uint64_t index) {
        const auto [found, is_new] = primitives_.try_emplace(index);
        if (!is_new) return found->second;
        for (const Json& json : items(entry(meshes_, index, "mesh"), "primitives")) {
            const std::uint64_t mode = whole(json, "mode", triangles);
            if (mode < triangles) continue;  // points and lines
            const auto attributes = json.find("attributes");
            if (!attributes) throw error("a primitive has no attributes");
            Primitive made{mode, array(whole(*attributes, "POSITION", {}), "\"VEC3\""), {}};
            if (made.points.type != NumberType::float32) throw error("positions that are not float32 are not read");
            if (json.find("indices")) made.indices = array(whole(json, "indices", {}), "\"SCALAR\"");
            if (made.indices && is_float(made.indices->type)) throw error("indices of vertices are not whole numbers");
            found->second.push_back(made);
        }
        return found->second;
    }

    // A file may use a mesh many times.
    void check_size(std::size_t vertices, std::size_t corners) {
        constexpr std::size_t each = 64;  // bytes
        const std::uint64_t bytes = surface_.vertices.size() * sizeof(double) + 3 * sizeof(double) * vertices +
                                    surface_.triangles.size() * sizeof(std::int32_t) +
                                    3 * sizeof(std::int32_t) * corners + each * ++uses_;
        if (bytes > max_unpacked(bytes_.size()))
            throw error("its nodes repeat meshes to more than " + std::to_string(max_unpacked(bytes_.size())) +
                        " bytes");
        if (surface_.vertices.size() / 3 + vertices >
            static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
            throw error("more than the 2147483647 vertices that are read");
    }

    // Throws for vertices that a placement alone does not put in place.
    void check_fixed(const Json& node, const Json& mesh) const {
        if (node.find("skin")) throw moved("a skin");
        if (const auto more = node.find("extensions"); more && more->find("EXT_mesh_gpu_instancing"))
            throw moved("EXT_mesh_gpu_instancing");
        for (const Json& weight : items(node.find("weights") ? node : mesh, "weights"))
            if (weight.number().value_or(1) != 0) throw moved("weights of morph targets");
    }

    void add_mesh(const Json& node, const Placement& place) {
        const std::uint64_t index = whole(node, "mesh", {});
        const std::vector<Primitive>& found = primitives(index);
        if (!found.empty()) check_fixed(node, meshes_[index]);
        for (const auto& [mode, points, indices] : found) {
            throw_if_interrupted();
            const std::size_t first = surface_.vertices.size() / 3, count = indices ? indices->count : points.count;
            check_size(points.count, count);
            for (std::size_t i = 0; i < points.count; ++i) {
                std::array<double, 3> x;
                for (std::size_t k = 0; k < 3; ++k)
                    x[k] = load_double(points.type, points.first + i * points.step + k * sizeof(float), false);
                const auto y = place.at(x);
                surface_.vertices.insert(surface_.vertices.end(), y.begin(), y.end());
            }
            const auto corner = [&, &points = points, &indices = indices](std::size_t i) {
                if (!indices) return i;
                const auto v =
                    static_cast<std::size_t>(*load_whole(indices->type, indices->first + i * indices->step, false));
                if (v < points.count) return v;
                throw error("a triangle names vertex " + std::to_string(v) + ", but there are " +
                            std::to_string(points.count));
            };
            const bool flips = place.mirrors();
            for (std::size_t i = 0; i + 2 < count; i += mode == triangles ? 3 : 1) {
                const bool odd = mode == strip && i % 2 == 1;
                std::array<std::size_t, 3> t{corner(mode == fan ? 0 : i), corner(i + 1), corner(i + 2)};
                if (odd != flips) std::swap(t[1], t[2]);
                for (const std::size_t v : t) surface_.triangles.push_back(static_cast<std::int32_t>(first + v));
            }
        }
    }

    std::string_view bytes_;
    std::string name_;
    std::string_view binary_;
    std::vector<Json> nodes_, meshes_, accessors_, views_;
    std::map<std::uint64_t, std::vector<Primitive>> primitives_;  // by mesh
    std::size_t uses_ = 0;                                        // of primitives
    Surface surface_;
};

}  // namespace

Surface parse_glb(std::string_view bytes, const std::string& name) {
    return GlbReader(bytes, name).read();
}

}  // namespace clvotess
