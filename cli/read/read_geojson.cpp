// GeoJSON (RFC 7946) and sequences of it (RFC 8142, and one text a line): the polygons of its geometries. Other
// geometries are refused.
#include <algorithm>
#include <cmath>
#include <string>

#include "failure.hpp"
#include "files/json.hpp"
#include "read/surface.hpp"

namespace clvotess {
namespace {

constexpr int max_depth = 32;  // of collections

class GeojsonReader {
public:
    // name: for messages.
    explicit GeojsonReader(std::string name) : name_(std::move(name)) { surface_.planar = true; }
    void rename(std::string name) { name_ = std::move(name); }

    void read(std::string_view text) { add(Json::read(text, name_), ""); }

    [[nodiscard]] Surface finish() {
        if (surface_.triangles.empty()) throw error("no polygon found");
        return std::move(surface_);
    }

private:
    // place: the place of the value in the text, as "feature 2, ", for messages.
    void add(const Json& value, const std::string& place, int depth = 0) {
        if (depth > max_depth) throw error("collections lie in each other, more than " + std::to_string(max_depth));
        const std::optional<Json> type = value.find("type");
        const std::string_view kind = type ? type->text() : "";
        if (kind == "\"Feature\"") {
            const std::optional<Json> geometry = value.find("geometry");
            if (geometry && geometry->text() != "null") add(*geometry, place, depth + 1);
        } else if (kind == "\"FeatureCollection\"") {
            add_all(value, "features", place + "feature ", depth);
        } else if (kind == "\"GeometryCollection\"") {
            add_all(value, "geometries", place + "geometry ", depth);
        } else if (kind == "\"Polygon\"") {
            add_polygon(coordinates_of(value, place), place);
        } else if (kind == "\"MultiPolygon\"") {
            std::size_t k = 0;
            for (const Json& polygon : coordinates_of(value, place).items())
                add_polygon(polygon, place + "polygon " + std::to_string(k++) + ", ");
        } else {
            throw error(place + "a geometry has the type " + (kind.empty() ? std::string("none") : std::string(kind)) +
                        ": give polygons, or keep these alone");
        }
    }

    [[nodiscard]] Failure error(const std::string& message) const { return bad_input(name_ + ": " + message); }

    void add_all(const Json& value, const char* member, const std::string& place, int depth) {
        const std::optional<Json> parts = value.find(member);
        if (!parts) throw error(std::string("a collection has no \"") + member + "\"");
        std::size_t k = 0;
        for (const Json& part : parts->items()) add(part, place + std::to_string(k++) + ", ", depth + 1);
    }
    [[nodiscard]] Json coordinates_of(const Json& geometry, const std::string& place) const {
        const std::optional<Json> coordinates = geometry.find("coordinates");
        if (!coordinates) throw error(place + "a polygon has no \"coordinates\"");
        return *coordinates;
    }
    void add_polygon(const Json& polygon, const std::string& place) {
        std::size_t k = 0;
        for (const Json& ring : polygon.items()) {
            add_ring(ring, k > 0, place + "ring " + std::to_string(k));
            ++k;
        }
    }

    void add_ring(const Json& ring, bool is_hole, const std::string& where) {
        std::vector<std::array<double, 2>> places;
        for (const Json& place : ring.items()) {
            const std::vector<Json> numbers = place.items();
            const auto x = numbers.size() < 2 ? std::nullopt : numbers[0].number();
            const auto y = numbers.size() < 2 ? std::nullopt : numbers[1].number();
            if (!x || !y)
                throw error(where + ": place " + std::to_string(places.size()) + " is " + std::string(place.text()) +
                            ", not two numbers");
            places.push_back({*x, *y});
        }
        if (places.size() > 1 && places.front() == places.back()) places.pop_back();
        if (places.size() < 3)
            throw error(where + " has " + std::to_string(places.size()) + (places.size() == 1 ? " place" : " places") +
                        ": give at least 3");
        long double area = 0;  // thin rings need the digits
        for (std::size_t i = 0; i < places.size(); ++i) {
            const auto &a = places[i], &b = places[(i + 1) % places.size()], &o = places[0];
            const auto from = [&](const std::array<double, 2>& x, std::size_t k) {
                return static_cast<long double>(x[k]) - o[k];
            };
            area += from(a, 0) * from(b, 1) - from(a, 1) * from(b, 0);
        }
        if ((area > 0) == is_hole) std::ranges::reverse(places);
        const auto first = static_cast<std::int32_t>(surface_.vertices.size() / 2);
        const auto count = static_cast<std::int32_t>(places.size());
        for (std::int32_t i = 0; i < count; ++i) {
            const auto& place = places[static_cast<std::size_t>(i)];
            surface_.vertices.insert(surface_.vertices.end(), place.begin(), place.end());
            surface_.triangles.insert(surface_.triangles.end(), {first + i, first + (i + 1) % count});
        }
    }

    std::string name_;
    Surface surface_;
};

// Returns the text without the mark of UTF-8, which some editors write.
std::string_view without_mark(std::string_view text) {
    constexpr std::string_view mark = "\xEF\xBB\xBF";
    if (text.starts_with(mark)) text.remove_prefix(mark.size());
    return text;
}

}  // namespace

Surface parse_geojson(std::string_view text, const std::string& name) {
    GeojsonReader reader(name);
    reader.read(without_mark(text));
    return reader.finish();
}

Surface parse_geojson_sequence(std::string_view text, const std::string& name) {
    constexpr char record = '\x1E';
    text = without_mark(text);
    const bool has_records = text.find(record) != std::string_view::npos;
    GeojsonReader reader(name);
    std::size_t line = 1;
    while (!text.empty()) {
        const std::string_view part = text.substr(0, text.find(has_records ? record : '\n'));
        if (part.find_first_not_of(" \t\r\n") != std::string_view::npos) {
            reader.rename(name + ":" + std::to_string(line));
            reader.read(part);
        }
        line += static_cast<std::size_t>(std::ranges::count(part, '\n'));
        if (!has_records) ++line;
        text.remove_prefix(std::min(part.size() + 1, text.size()));
    }
    reader.rename(name);
    return reader.finish();
}

}  // namespace clvotess
