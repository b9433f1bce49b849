// PLY: a header in text with elements and their properties, then the elements as text or binary. The points are x, y, z
// of the element `vertex`; a mesh has the lists of the element `face` too. Other elements are skipped.
#include <algorithm>
#include <array>
#include <optional>

#include "failure.hpp"
#include "files/binary_numbers.hpp"
#include "files/line_reader.hpp"
#include "interrupt.hpp"
#include "read/columns.hpp"
#include "read/input.hpp"
#include "read/surface.hpp"

namespace clvotess {
namespace {

// Properties are numbers.
std::string_view no_word(std::size_t /*column*/) {
    return {};
}

struct Property {
    std::string_view name;
    NumberType type{};
    std::optional<NumberType> count_type;  // for a list
};

struct Element {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

std::optional<NumberType> type_of(std::string_view name) {
    using enum NumberType;
    constexpr std::array<std::pair<std::string_view, NumberType>, 16> names{{{"char", int8},
                                                                             {"int8", int8},
                                                                             {"uchar", uint8},
                                                                             {"uint8", uint8},
                                                                             {"short", int16},
                                                                             {"int16", int16},
                                                                             {"ushort", uint16},
                                                                             {"uint16", uint16},
                                                                             {"int", int32},
                                                                             {"int32", int32},
                                                                             {"uint", uint32},
                                                                             {"uint32", uint32},
                                                                             {"float", float32},
                                                                             {"float32", float32},
                                                                             {"double", float64},
                                                                             {"float64", float64}}};
    for (const auto& [known, type] : names) {
        if (known == name) return type;
    }
    return std::nullopt;
}

class PlyReader {
public:
    PlyReader(std::string_view bytes, const std::string& name, const ReadRequest& request)
        : lines_(bytes, name), request_(request) {}

    Input read() {
        read_header();
        for (const Element& element : elements_) {
            if (element.name == "vertex") return read_vertices(element);
            skip(element);
        }
        throw lacks("vertex");
    }

    Surface read_surface() {
        read_header();
        SurfaceBuilder builder(lines_.name());
        bool has_vertices = false, has_faces = false;
        for (const Element& element : elements_) {
            if (element.name == "vertex" && !has_vertices) {
                builder.set_vertices(read_vertices(element).points);
                has_vertices = true;
            } else if (element.name == "face" && !has_faces) {
                read_faces(element, builder);
                has_faces = true;
            } else {
                skip(element);
            }
        }
        if (!has_vertices || !has_faces) throw lacks(has_vertices ? "face" : "vertex");
        return builder.finish();
    }

private:
    [[nodiscard]] Failure lacks(const char* element) const {
        return bad_input(lines_.name() + ": the header has no element " + element);
    }

    void read_header() {
        if (!lines_.rest().starts_with("ply\n") && !lines_.rest().starts_with("ply\r\n")) {
            throw bad_input(lines_.name() + ": not a PLY file: it must begin with a line \"ply\"");
        }
        (void)lines_.need("the header");
        for (;;) {
            split_words(lines_.need("end_header"), words_);
            if (words_.empty()) throw lines_.error("an empty line in the header");
            if (words_[0] == "comment" || words_[0] == "obj_info") continue;
            if (words_[0] == "end_header") break;
            if (words_[0] == "format") {
                read_format();
            } else if (words_[0] == "element") {
                const auto count = words_.size() == 3 ? read_uint64(words_[2]) : std::nullopt;
                if (!count) throw lines_.error("expected: element NAME COUNT");
                if (elements_.size() == max_arrays)
                    throw lines_.error("more than the " + std::to_string(max_arrays) + " elements that are read");
                elements_.push_back({words_[1], *count, {}});
            } else if (words_[0] == "property") {
                read_property();
            } else {
                throw lines_.error("unknown word " + in_quotes(words_[0]) + " in the header");
            }
        }
        if (!has_format_) throw lines_.error("the header has no line \"format\"");
    }

    void read_format() {
        const std::string_view word = words_.size() == 3 ? words_[1] : std::string_view{};
        ascii_ = word == "ascii";
        swapped_ = word == "binary_big_endian";
        if (!ascii_ && !swapped_ && word != "binary_little_endian") {
            throw lines_.error("unknown format, expected ascii, binary_little_endian or binary_big_endian");
        }
        has_format_ = true;
    }

    void read_property() {
        if (elements_.empty()) throw lines_.error("a property before any element");
        const bool list = words_.size() == 5 && words_[1] == "list";
        if (!list && words_.size() != 3) throw lines_.error("expected: property TYPE NAME");
        const auto type = type_of(words_[list ? 3 : 1]);
        const auto count_type = list ? type_of(words_[2]) : std::nullopt;
        if (!type || (list && !count_type)) throw lines_.error("unknown type of a property");
        if (elements_.back().properties.size() == max_columns)
            throw lines_.error("more than the " + std::to_string(max_columns) + " properties that are read");
        elements_.back().properties.push_back({words_.back(), *type, count_type});
    }

    [[nodiscard]] Failure too_short(const Element& element, std::uint64_t done) const {
        return bad_input(lines_.name() + ": the file ends after " + std::to_string(done) + " of the " +
                         std::to_string(element.count) + " elements " + std::string(element.name) +
                         " that its header announces");
    }

    // Returns the smallest size of a row in bytes. Lists count without elements; a number of text has a digit and a
    // blank.
    [[nodiscard]] std::size_t shortest_row(const Element& element) const {
        std::size_t bytes = 0;
        for (const Property& property : element.properties) {
            bytes += ascii_ ? 2 : size_of(property.count_type.value_or(property.type));
        }
        return bytes;
    }

    void check_count(const Element& element) const {
        if (!can_hold(lines_.rest().size(), element.count, shortest_row(element))) throw too_short(element, 0);
    }

    // Calls use() for each line of an element in text, with its words in words_.
    template <typename Use>
    void each_line(const Element& element, Use use) {
        std::string_view line;
        for (std::uint64_t i = 0; i < element.count; ++i) {
            do {
                if (!lines_.next(line)) throw too_short(element, i);
                split_words(line, words_);
            } while (words_.empty() && !element.properties.empty());
            use();
        }
    }

    // Skips one row, and stores in fields where each property begins.
    void pass_row(const Element& element, std::uint64_t row, std::vector<const char*>& fields) {
        constexpr std::uint64_t rows_in_a_round = 4096;
        if (row % rows_in_a_round == 0) throw_if_interrupted();
        std::string_view rest = lines_.rest();
        fields.clear();
        for (const Property& property : element.properties) {
            fields.push_back(rest.data());
            std::uint64_t bytes = size_of(property.type);
            if (property.count_type) {
                const std::size_t head = size_of(*property.count_type);
                if (rest.size() < head) throw too_short(element, row);
                const auto count = load_whole(*property.count_type, rest.data(), swapped_);
                if (!count || *count < 0) throw bad_input(lines_.name() + ": a list has no valid length");
                if (static_cast<std::uint64_t>(*count) > rest.size()) throw too_short(element, row);
                bytes = head + bytes * static_cast<std::uint64_t>(*count);
            }
            if (bytes > rest.size()) throw too_short(element, row);
            rest.remove_prefix(bytes);
        }
        lines_.skip(lines_.rest().size() - rest.size(), 0);
    }

    void skip(const Element& element) {
        if (element.properties.empty()) return;
        check_count(element);
        if (ascii_) return each_line(element, [] {});
        std::vector<const char*> fields;
        for (std::uint64_t i = 0; i < element.count; ++i) pass_row(element, i, fields);
    }

    Input read_vertices(const Element& element) {
        Words names;
        for (const Property& property : element.properties) names.push_back(property.name);
        const auto at = [&](std::string_view name) -> std::optional<std::size_t> {
            const auto found = find_name(names, name);
            return found && element.properties[*found].count_type ? std::nullopt : found;
        };
        std::vector<std::string> axes = request_.coordinates;
        if (axes.empty()) axes = {"x", "y"};
        if (request_.coordinates.empty() && (at("z") || request_.dimensions != Dimensions::two)) axes.emplace_back("z");
        std::vector<std::size_t> places;
        for (const std::string& axis : axes)
            if (const auto place = at(axis)) places.push_back(*place);
        auto id = at("id");
        if (id && is_float(element.properties[*id].type)) id.reset();
        if (places.size() != axes.size()) {
            std::string list;
            for (const std::string& axis : axes) list += (list.empty() ? "" : ", ") + axis;
            throw bad_input(lines_.name() + ": the element vertex has no properties " + list);
        }
        ReadRequest of_numbers = request_;
        of_numbers.species = false;
        ColumnPlaces wanted(of_numbers, names, lines_.name());
        for (std::size_t k = 0; k < names.size(); ++k) {
            if (wanted.holds(k) && element.properties[k].count_type) {
                throw bad_input(lines_.name() + ": the column " + in_quotes(names[k]) + " is a list");
            }
        }
        if (request_.all_columns) {
            std::vector<std::size_t> taken = places;
            if (id) taken.push_back(*id);
            Words all(names.size(), "0");  // every property is a number or a list
            for (std::size_t k = 0; k < names.size(); ++k)
                if (element.properties[k].count_type) taken.push_back(k);
            wanted.add_others(names, taken, all);
        }
        check_count(element);
        const auto count = static_cast<std::size_t>(element.count);
        Input input;
        input.dimensions = places.size();
        input.points.reserve(input.dimensions * count);
        if (id) input.ids.reserve(count);
        input.columns = wanted.columns(count);
        if (ascii_) {
            read_text_rows(element, places, id, wanted, input);
        } else {
            std::vector<const char*> fields;
            const auto value = [&](std::size_t k) {
                return load_double(element.properties[k].type, fields[k], swapped_);
            };
            for (std::size_t i = 0; i < count; ++i) {
                pass_row(element, i, fields);
                for (const std::size_t k : places) input.points.push_back(value(k));
                if (id) input.ids.push_back(*load_whole(element.properties[*id].type, fields[*id], swapped_));
                wanted.append(input, no_word, [&](std::size_t k, const std::string&) { return value(k); });
            }
        }
        return input;
    }

    void read_text_rows(const Element& element, const std::vector<std::size_t>& axes, std::optional<std::size_t> id,
                        const ColumnPlaces& wanted, Input& input) {
        const bool lists =
            std::ranges::any_of(element.properties, [](const Property& p) { return p.count_type.has_value(); });
        Words first;  // of each property
        each_line(element, [&] {
            if (lists) {
                each_field(element.properties, [&](std::size_t k, std::size_t at, std::size_t) {
                    if (k == 0) first.clear();
                    first.push_back(at < words_.size() ? words_[at] : std::string_view());
                });
                words_ = first;
            }
            if (words_.size() != element.properties.size()) {
                throw lines_.error("this row has " + columns_text(words_.size()) + ", " +
                                   std::to_string(element.properties.size()) + " are announced");
            }
            for (const std::size_t k : axes) input.points.push_back(lines_.number(words_[k]));
            if (id) input.ids.push_back(lines_.whole(words_[*id], "an id"));
            wanted.append(input, no_word, [this](std::size_t k, const std::string& column) {
                return lines_.number(words_[k], column);
            });
        });
    }

    void read_faces(const Element& element, SurfaceBuilder& builder) {
        const std::vector<Property>& properties = element.properties;
        const auto found = std::ranges::find_if(properties, [](const Property& property) {
            return (property.name == "vertex_indices" || property.name == "vertex_index") && property.count_type;
        });
        if (found == properties.end()) throw bad_input(lines_.name() + ": the element face has no list vertex_indices");
        const auto list = static_cast<std::size_t>(found - properties.begin());
        check_count(element);
        std::vector<std::int64_t> corners;
        if (ascii_) {
            each_line(element, [&] {
                read_list_of_row(properties, list, corners);
                builder.add_face(corners);
            });
            return;
        }
        std::vector<const char*> fields;
        const std::size_t head = size_of(*found->count_type), each = size_of(found->type);
        for (std::uint64_t i = 0; i < element.count; ++i) {
            pass_row(element, i, fields);
            const auto size = static_cast<std::size_t>(*load_whole(*found->count_type, fields[list], swapped_));
            corners.clear();
            for (std::size_t k = 0; k < size; ++k) {
                const auto corner = load_whole(found->type, fields[list] + head + k * each, swapped_);
                if (!corner) throw bad_input(lines_.name() + ": a face names a vertex by no whole number");
                corners.push_back(*corner);
            }
            builder.add_face(corners);
        }
    }

    // Reads one list of the row in words_.
    void read_list_of_row(const std::vector<Property>& properties, std::size_t list,
                          std::vector<std::int64_t>& numbers) const {
        each_field(properties, [&](std::size_t k, std::size_t at, std::size_t size) {
            if (k != list) return;
            numbers.clear();
            for (std::size_t i = at; i < at + size; ++i)
                numbers.push_back(lines_.whole(words_[i], "a vertex of a face"));
        });
    }

    // Calls use(property, first, size) for each property of the row in words_, with its place among them.
    void each_field(const std::vector<Property>& properties, const auto& use) const {
        std::size_t at = 0;
        for (std::size_t k = 0; k < properties.size(); ++k) {
            std::size_t size = 1;
            if (at < words_.size() && properties[k].count_type) {
                const std::int64_t count = lines_.whole(words_[at], "the length of a list");
                if (count < 0) throw lines_.error("a list has no valid length");
                ++at;
                size = static_cast<std::size_t>(count);
            }
            if (size > words_.size() - at) throw lines_.error("the row ends within " + in_quotes(properties[k].name));
            use(k, at, size);
            at += size;
        }
        if (at != words_.size()) throw lines_.error("the row has more numbers than its properties");
    }

    LineReader lines_;
    const ReadRequest request_;
    Words words_;
    std::vector<Element> elements_;
    bool has_format_ = false, ascii_ = false, swapped_ = false;
};

}  // namespace

Input parse_ply(std::string_view bytes, const std::string& name, const ReadRequest& request) {
    return PlyReader(bytes, name, request).read();
}

Surface parse_ply_surface(std::string_view bytes, const std::string& name) {
    return PlyReader(bytes, name, {}).read_surface();
}

}  // namespace clvotess
