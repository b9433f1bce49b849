#include "files/pieces.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

#include "core/errors.hpp"
#include "core/vector3.hpp"
#include "files/gltf.hpp"

namespace votess::files {
namespace {

struct Material {
    const char* name;
    const char* linear;  // red, green, blue, alpha
    const char* hex;     // of sRGB
};
constexpr std::array<Material, 2> materials{
    {{"inside", "[0.8,0.36,0.16,1]", "#E6A170"}, {"surface", "[0.52,0.52,0.52,1]", "#BFBFBF"}}};

// A view of a piece.
struct Piece {
    std::span<const double> vertices, centroid;
    std::span<const std::int32_t> triangles;
    std::span<const std::uint8_t> on_surface;

    [[nodiscard]] std::size_t vertex_count() const { return vertices.size() / 3; }
    // Returns where the vertex is, from the centroid.
    [[nodiscard]] std::array<float, 3> from_centroid(std::size_t v) const {
        return with_y_up<float>(vertices[3 * v] - centroid[0], vertices[3 * v + 1] - centroid[1],
                                vertices[3 * v + 2] - centroid[2]);
    }
    // Visits the triangles with a material.
    template <class Use>
    void each_of(std::size_t material, const Use& use) const {
        for (std::size_t t = 0; t < on_surface.size(); ++t)
            if (on_surface[t] == material) use(triangles.subspan(3 * t, 3));
    }
};

Piece piece_of(const Pieces& all, std::size_t p) {
    const auto row = [&](const auto& values, const auto& offsets, std::size_t width) {
        const auto begin = static_cast<std::size_t>(offsets[p]), end = static_cast<std::size_t>(offsets[p + 1]);
        return values.subspan(width * begin, width * (end - begin));
    };
    return {row(all.vertices, all.vertex_offsets, 3), all.centroids.subspan(3 * p, 3),
            row(all.triangles, all.triangle_offsets, 3), row(all.on_surface, all.triangle_offsets, 1)};
}

// Writes three numbers, each after its text.
template <class Number>
void put_triple(std::span<const Number> numbers, const std::array<const char*, 3>& before, ByteSink& out) {
    for (std::size_t k = 0; k < 3; ++k) {
        out.put(before[k]);
        out.put_number(numbers[k]);
    }
}

// Returns the ids of the rows, and after a point the number of the piece if a row has several.
std::vector<std::string> names_of(const Pieces& pieces) {
    std::vector<std::string> names;
    names.reserve(pieces.size());
    for (std::size_t i = 0; i < pieces.ids.size(); ++i) {
        const std::int64_t count = pieces.indptr[i + 1] - pieces.indptr[i];
        for (std::int64_t k = 0; k < count; ++k) {
            std::string& name = names.emplace_back(std::to_string(pieces.ids[i]));
            if (count > 1) name.append(1, '.').append(std::to_string(k));
        }
    }
    return names;
}

void put_indices(const Piece& piece, std::size_t material, bool is_short, ByteSink& out) {
    std::size_t bytes = 0;
    piece.each_of(material, [&](auto corners) {
        for (const std::int32_t v : corners) {
            if (is_short)
                out.put_binary(static_cast<std::uint16_t>(v));
            else
                out.put_binary(v);
            bytes += is_short ? 2 : 4;
        }
    });
    out.put(std::string_view("\0\0\0", in_words(bytes) - bytes));
}

std::uint32_t checksum(std::string_view bytes) {
    static const auto table = [] {
        std::array<std::uint32_t, 256> made{};
        for (std::uint32_t i = 0; i < made.size(); ++i) {
            made[i] = i;
            for (int bit = 0; bit < 8; ++bit) made[i] = (made[i] & 1) != 0 ? made[i] >> 1 ^ 0xedb88320u : made[i] >> 1;
        }
        return made;
    }();
    std::uint32_t sum = ~0u;
    for (const char byte : bytes) sum = table[(sum ^ static_cast<std::uint8_t>(byte)) & 255] ^ sum >> 8;
    return ~sum;
}

// Writes an archive whose members are not packed.
void put_zip(std::span<const std::pair<std::string, std::string>> members, ByteSink& out) {
    std::uint64_t size = 22;
    for (const auto& [name, bytes] : members) size += bytes.size() + 2 * name.size() + 76;
    if (size > largest_glb)
        refuse("the .3mf file would take " + std::to_string((size + 999'999) / 1'000'000) +
               " MB, but it ends at 4 GiB: write fewer pieces");
    out.set_total(size);
    const auto put16 = [](ByteSink& to, std::size_t x) { to.put_binary(static_cast<std::uint16_t>(x)); };
    const auto put32 = [](ByteSink& to, std::size_t x) { to.put_binary(static_cast<std::uint32_t>(x)); };
    const auto put_member = [&](ByteSink& to, const std::pair<std::string, std::string>& member) {
        put16(to, 20);  // version
        for (int k = 0; k < 3; ++k) put16(to, 0);
        put16(to, 0x21);  // 1980-01-01
        put32(to, checksum(member.second));
        put32(to, member.second.size());
        put32(to, member.second.size());
        put16(to, member.first.size());
        put16(to, 0);
    };
    std::string directory;
    ByteSink entries([&](std::string_view bytes, std::uint64_t, const std::string&) { directory += bytes; });
    std::size_t place = 0;
    for (const auto& member : members) {
        out.put(std::string_view("PK\3\4", 4));
        put_member(out, member);
        out.put(member.first);
        out.put(member.second);
        entries.put(std::string_view("PK\1\2\24\0", 6));
        put_member(entries, member);
        for (int k = 0; k < 3; ++k) put16(entries, 0);
        put32(entries, 0);
        put32(entries, place);
        entries.put(member.first);
        place += 30 + member.first.size() + member.second.size();
    }
    entries.flush();
    out.put(directory);
    out.put(std::string_view("PK\5\6\0\0\0\0", 8));
    for (int k = 0; k < 2; ++k) put16(out, members.size());
    put32(out, directory.size());
    put32(out, place);
    put16(out, 0);
}

}  // namespace

// A node for each piece, at its centroid.
void write_pieces_glb(const Pieces& pieces, ByteSink& out) {
    const std::size_t count = pieces.size();
    const std::vector<std::string> names = names_of(pieces);
    GltfArrays arrays;
    std::string nodes, roots, meshes;
    for (std::size_t p = 0; p < count; ++p) {
        const Piece piece = piece_of(pieces, p);
        std::array<float, 3> lower = piece.from_centroid(0), upper = lower;
        for (std::size_t v = 1; v < piece.vertex_count(); ++v) {
            const auto place = piece.from_centroid(v);
            for (std::size_t k = 0; k < 3; ++k) {
                lower[k] = std::min(lower[k], place[k]);
                upper[k] = std::max(upper[k], place[k]);
            }
        }
        const std::string positions = arrays.add_positions(piece.vertex_count(), lower, upper);
        std::string primitives;
        for (std::size_t m = 0; m < materials.size(); ++m) {
            const auto triangles =
                static_cast<std::uint64_t>(std::ranges::count(piece.on_surface, static_cast<std::uint8_t>(m)));
            if (triangles == 0) continue;
            const std::string indices = arrays.add_indices(3 * triangles, piece.vertex_count() <= short_vertices);
            add_to_list(primitives, "{\"attributes\":{\"POSITION\":" + positions + "},\"indices\":" + indices +
                                        ",\"material\":" + std::to_string(m) + "}");
        }
        const std::string number = std::to_string(p), name = ",\"name\":\"" + names[p] + "\"";
        add_to_list(meshes, "{\"primitives\":[" + primitives + "]" + name + "}");
        add_to_list(nodes, "{\"mesh\":" + number + name + ",\"translation\":" +
                               text_of(with_y_up<double>(piece.centroid[0], piece.centroid[1], piece.centroid[2])) +
                               "}");
        add_to_list(roots, number);
    }
    std::string head = gltf_asset, list;
    for (const Material& material : materials)
        add_to_list(list,
                    std::string("{\"name\":\"") + material.name +
                        R"(","pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.9,"baseColorFactor":)" +
                        material.linear + "}}");
    if (count > 0)
        head += R"(,"scene":0,"scenes":[{"nodes":[)" + roots + "]}],\"nodes\":[" + nodes + "],\"meshes\":[" + meshes +
                "],\"materials\":[" + list + "]," + arrays.members();
    begin_glb(head + "}", arrays.bytes(), "write fewer pieces", out);
    for (std::size_t p = 0; p < count; ++p) {
        const Piece piece = piece_of(pieces, p);
        for (std::size_t v = 0; v < piece.vertex_count(); ++v) out.put_binary(piece.from_centroid(v));
        for (std::size_t m = 0; m < materials.size(); ++m)
            put_indices(piece, m, piece.vertex_count() <= short_vertices, out);
    }
}

void write_pieces_obj(const Pieces& pieces, ByteSink& out) {
    out.put("# Pieces of Voronoi cells by votess\n");
    const std::vector<std::string> names = names_of(pieces);
    std::int64_t first = 1;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const Piece piece = piece_of(pieces, p);
        out.put("o " + names[p] + "\n");
        for (std::size_t v = 0; v < piece.vertex_count(); ++v) {
            put_triple(piece.vertices.subspan(3 * v, 3), {"v ", " ", " "}, out);
            out.put("\n");
        }
        for (std::size_t m = 0; m < materials.size(); ++m) {
            if (std::ranges::count(piece.on_surface, static_cast<std::uint8_t>(m)) == 0) continue;
            out.put(std::string("usemtl ") + materials[m].name + "\n");
            piece.each_of(m, [&](auto corners) {
                out.put("f");
                for (const std::int32_t v : corners) {
                    out.put(" ");
                    out.put_number(first + v);
                }
                out.put("\n");
            });
        }
        first += static_cast<std::int64_t>(piece.vertex_count());
    }
}

void write_pieces_stl(const Pieces& pieces, ByteSink& out) {
    const std::uint64_t triangles = pieces.on_surface.size();
    out.set_total(84 + 50 * triangles);
    std::string head = "Pieces of Voronoi cells by votess";
    head.resize(80, ' ');
    out.put(head);
    out.put_binary(static_cast<std::uint32_t>(triangles));
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const Piece piece = piece_of(pieces, p);
        for (std::size_t t = 0; t < piece.on_surface.size(); ++t) {
            std::array<Vector3, 3> x;
            for (std::size_t i = 0; i < 3; ++i)
                std::ranges::copy(piece.vertices.subspan(3 * static_cast<std::size_t>(piece.triangles[3 * t + i]), 3),
                                  x[i].begin());
            Vector3 normal = cross(minus(x[1], x[0]), minus(x[2], x[0]));
            const double length = length3(normal[0], normal[1], normal[2]);
            for (double& n : normal) n = length > 0 ? n / length : 0;
            for (const Vector3& vector : {normal, x[0], x[1], x[2]})
                for (const double number : vector) out.put_binary(static_cast<float>(number));
            out.put_binary(std::uint16_t{0});
        }
    }
}

void write_pieces_3mf(const Pieces& pieces, ByteSink& out) {
    std::string model;
    ByteSink text([&](std::string_view bytes, std::uint64_t, const std::string&) { model += bytes; });
    text.put(R"(<?xml version="1.0" encoding="UTF-8"?>)"
             "\n"
             R"(<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>)"
             R"(<basematerials id="1">)");
    for (const Material& material : materials)
        text.put(std::string("<base name=\"") + material.name + "\" displaycolor=\"" + material.hex + "\"/>");
    text.put("</basematerials>\n");
    const std::vector<std::string> names = names_of(pieces);
    std::string build;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const Piece piece = piece_of(pieces, p);
        const std::string id = std::to_string(p + 2);
        text.put("<object id=\"" + id + R"(" type="model" pid="1" pindex="0" name=")" + names[p] +
                 "\"><mesh><vertices>\n");
        for (std::size_t v = 0; v < piece.vertex_count(); ++v) {
            put_triple(piece.vertices.subspan(3 * v, 3), {"<vertex x=\"", "\" y=\"", "\" z=\""}, text);
            text.put("\"/>\n");
        }
        text.put("</vertices><triangles>\n");
        for (std::size_t t = 0; t < piece.on_surface.size(); ++t) {
            put_triple(piece.triangles.subspan(3 * t, 3), {"<triangle v1=\"", "\" v2=\"", "\" v3=\""}, text);
            text.put(piece.on_surface[t] != 0 ? "\" pid=\"1\" p1=\"1\"/>\n" : "\" pid=\"1\" p1=\"0\"/>\n");
        }
        text.put("</triangles></mesh></object>\n");
        build += "<item objectid=\"" + id + "\"/>\n";
    }
    text.put("</resources><build>\n" + build + "</build></model>\n");
    text.flush();
    const std::array<std::pair<std::string, std::string>, 3> members{
        {{"[Content_Types].xml",
          R"(<?xml version="1.0" encoding="UTF-8"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/)"
          R"(content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.)"
          R"(relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.)"
          R"(3dmanufacturing-3dmodel+xml"/></Types>)"},
         {"_rels/.rels",
          R"(<?xml version="1.0" encoding="UTF-8"?><Relationships xmlns="http://schemas.openxmlformats.org/package/)"
          R"(2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="model" Type="http://)"
          R"(schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)"},
         {"3D/3dmodel.model", std::move(model)}}};
    put_zip(members, out);
}

// RFC 7946: a feature for each cell, a polygon for each piece. Outlines are counterclockwise, holes clockwise.
void write_pieces_geojson(const Pieces& pieces, ByteSink& out) {
    const auto put_place = [&](std::size_t v, const char* before) {
        out.put(before);
        out.put_number(pieces.vertices[2 * v]);
        out.put(",");
        out.put_number(pieces.vertices[2 * v + 1]);
        out.put("]");
    };
    const auto put_polygon = [&](std::size_t p) {
        const auto first = static_cast<std::size_t>(pieces.vertex_offsets[p]);
        const auto begin = static_cast<std::size_t>(pieces.triangle_offsets[p]);
        const auto end = static_cast<std::size_t>(pieces.triangle_offsets[p + 1]);
        std::size_t start = 0;  // of the ring
        bool begins = true;
        for (std::size_t e = begin; e < end; ++e) {
            const auto from = static_cast<std::size_t>(pieces.triangles[2 * e]);
            const auto to = static_cast<std::size_t>(pieces.triangles[2 * e + 1]);
            if (begins) {
                put_place(first + from, e == begin ? "[[[" : "],[[");
                start = from;
            }
            put_place(first + to, ",[");
            begins = to == start;
        }
        out.put("]]");
    };
    out.put("{\"type\":\"FeatureCollection\",\"features\":[");
    const char* separator = "\n";
    for (std::size_t row = 0; row < pieces.ids.size(); ++row) {
        const auto begin = static_cast<std::size_t>(pieces.indptr[row]);
        const auto end = static_cast<std::size_t>(pieces.indptr[row + 1]);
        if (begin == end) continue;
        const std::string id = std::to_string(pieces.ids[row]);
        out.put(separator);
        out.put("{\"type\":\"Feature\",\"id\":" + id + ",\"properties\":{\"id\":" + id +
                "},\"geometry\":{\"type\":\"MultiPolygon\",\"coordinates\":[");
        for (std::size_t p = begin; p < end; ++p) {
            if (p > begin) out.put(",");
            put_polygon(p);
        }
        out.put("]}}");
        separator = ",\n";
    }
    out.put("\n]}\n");
}

}  // namespace votess::files
