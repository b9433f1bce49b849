#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "failure.hpp"
#include "files/binary_numbers.hpp"
#include "files/input_file.hpp"
#include "files/line_reader.hpp"
#include "interrupt.hpp"
#include "read/input.hpp"
#include "read/surface.hpp"

namespace clvotess {
namespace {

// Takes the words of the next line that holds some before a comment. Returns false at the end.
bool next_words(LineReader& lines, Words& words) {
    std::string_view line;
    do {
        if (!lines.next_filled(line)) return false;
        split_words(line.substr(0, line.find('#')), words);
    } while (words.empty());
    return true;
}

// Adds the lines that follow while a backslash ends the last one. The words are in `joined`.
void join_lines(LineReader& lines, Words& words, std::string& joined) {
    joined.clear();
    for (bool more = true; more;) {
        for (const std::string_view word : words) joined.append(word).append(" ");
        joined.resize(joined.find_last_of('\\'));
        joined += ' ';
        if (joined.size() > max_line)
            throw lines.error("more than the " + std::to_string(max_line) + " bytes of a line");
        std::string_view line;
        words.clear();
        if (lines.next(line)) split_words(line.substr(0, line.find('#')), words);
        more = !words.empty() && words.back().ends_with('\\');
    }
    for (const std::string_view word : words) joined.append(word).append(" ");
    split_words(joined, words);
}

void add_vertex_of(const LineReader& lines, std::span<const std::string_view> words, SurfaceBuilder& builder) {
    if (words.size() < 3) throw lines.error("a vertex has " + std::to_string(words.size()) + " numbers, not x y z");
    builder.add_vertex(lines.number(words[0]), lines.number(words[1]), lines.number(words[2]));
}

class OffReader {
public:
    OffReader(std::string_view text, const std::string& name) : lines_(text, name), builder_(name) {}

    Surface read() {
        read_header();
        if (words_.size() < 2) throw lines_.error("expected: the numbers of vertices and faces");
        const auto count = [this](std::size_t k, const char* what) {
            const std::int64_t number = lines_.whole(words_[k], what);
            if (number < 0) throw lines_.error(in_quotes(words_[k]) + " is negative, which " + what + " cannot be");
            return number;
        };
        const std::int64_t vertices = count(0, "the number of vertices"), faces = count(1, "the number of faces");
        for (std::int64_t v = 0; v < vertices; ++v) {
            need_words(v, vertices, "vertices");
            add_vertex_of(lines_, words_, builder_);
        }
        std::vector<std::int64_t> corners;
        for (std::int64_t f = 0; f < faces; ++f) {
            need_words(f, faces, "faces");
            const std::int64_t size = lines_.whole(words_[0], "the number of corners");
            if (size < 0 || static_cast<std::uint64_t>(size) >= words_.size())  // colors may follow
                throw lines_.error("a face of " + std::to_string(size) + " corners, but the line lists " +
                                   std::to_string(words_.size() - 1));
            corners.clear();
            for (std::int64_t k = 1; k <= size; ++k)
                corners.push_back(lines_.whole(words_[static_cast<std::size_t>(k)], "a vertex of a face"));
            builder_.add_face(corners);
        }
        return builder_.finish();
    }

private:
    // Leaves the line with the numbers of vertices and faces.
    void read_header() {
        const bool any = next_words(lines_, words_);
        const std::string_view word = any ? words_[0] : std::string_view();
        const auto at = word.find("OFF");
        // Vertices have coordinates of textures, colors and normals too; any order of these letters is in use.
        std::string kind(word.substr(0, at));
        for (const std::string_view letters : {"ST", "C", "N"})
            if (const auto found = kind.find(letters); found != std::string::npos) kind.erase(found, letters.size());
        if (at == std::string_view::npos || !kind.empty())
            throw bad_input(lines_.name() + ": not an OFF file of three dimensions: it must begin with \"OFF\"");
        if (words_.size() > 1 && words_[1] == "BINARY")
            throw bad_input(lines_.name() + ": binary OFF is not read: convert it to .ply");
        words_[0] = word.substr(at + 3);
        if (words_[0].empty()) words_.erase(words_.begin());
        if (words_.empty() && !next_words(lines_, words_))
            throw bad_input(lines_.name() + ": the file ends after its header");
    }

    void need_words(std::int64_t done, std::int64_t count, const char* what) {
        if (!next_words(lines_, words_))
            throw bad_input(lines_.name() + ": the file ends after " + std::to_string(done) + " of the " +
                            std::to_string(count) + " " + what + " that it announces");
    }

    LineReader lines_;
    SurfaceBuilder builder_;
    Words words_;
};

// Any white space separates words, so that a facet may stand on one line or on seven. A name ends with its line, or
// before the next `facet normal` with a number.
class TextStl {
public:
    TextStl(std::string_view text, const std::string& name) : lines_(text, name) {}

    std::vector<double> corners() {
        bool open = false;  // after `solid`
        while (find_word()) {
            const std::string word = lower_case(take());
            if (word == "solid" || word == "endsolid") {
                if (open == (word == "solid")) throw lines_.error("\"" + word + "\" at a wrong place");
                open = !open;
                skip_name(open);
                continue;
            }
            if (!open) throw lines_.error("expected: solid");
            if (word != "facet")
                throw lines_.error("the word " + in_quotes(words_[next_ - 1]) + " is unknown, or at a wrong place");
            take_facet();
        }
        // Other readers allow this. But a file that was cut may end between two closed parts, and would pass.
        if (open) throw bad_input(lines_.name() + ": the file ends before \"endsolid\"");
        return std::move(corners_);
    }

private:
    [[nodiscard]] bool find_word() {
        for (std::string_view line; next_ == words_.size(); next_ = 0) {
            if (!lines_.next_filled(line)) return false;
            split_words(line, words_);
        }
        return true;
    }
    // Goes to what follows a name on its line. Behind `endsolid` that is another solid with facets.
    void skip_name(bool of_solid) {
        const auto word = [&](std::size_t k) { return k < words_.size() ? lower_case(words_[k]) : std::string(); };
        std::size_t facet = next_;
        const auto is_facet = [&](std::size_t k) {
            return word(k) == "facet" && word(k + 1) == "normal" && k + 2 < words_.size() && read_double(words_[k + 2]);
        };
        while (facet < words_.size() && !is_facet(facet)) ++facet;
        if (!of_solid && facet < words_.size())
            while (next_ < facet && word(next_) != "solid") ++next_;
        else
            next_ = facet;
    }
    std::string_view take() {
        if (!find_word()) throw bad_input(lines_.name() + ": the file ends inside a facet");
        return words_[next_++];
    }
    void take(const char* expected) {
        const std::string_view word = take();
        if (lower_case(word) != expected)
            throw lines_.error("expected: " + std::string(expected) + ", not " + in_quotes(word));
    }

    void take_facet() {
        constexpr std::size_t words_of_normal = 4;
        std::string word = lower_case(take());
        for (std::size_t k = 0; k < words_of_normal && word != "outer"; ++k) word = lower_case(take());
        if (word != "outer") throw lines_.error("expected: outer loop");
        take("loop");
        std::size_t count = 0;
        for (word = lower_case(take()); word == "vertex"; word = lower_case(take()), ++count)
            for (int k = 0; k < 3; ++k) {
                const std::string_view text = take();
                corners_.push_back(lines_.number(text));
                if (!std::isfinite(corners_.back())) throw lines_.error(in_quotes(text) + " is not finite");
            }
        if (word != "endloop") throw lines_.error("expected: vertex or endloop, not " + in_quotes(word));
        if (count != 3) throw lines_.error("a facet of " + std::to_string(count) + " corners, not 3");
        take("endfacet");
    }

    LineReader lines_;
    Words words_;
    std::size_t next_ = 0;  // of the words of the line
    std::vector<double> corners_;
};

// A binary file may begin with "solid" too.
bool has_binary_size(std::string_view bytes) {
    constexpr std::size_t head = 84, each = 50;
    return bytes.size() >= head &&
           bytes.size() == head + std::uint64_t{each} * load_number<std::uint32_t>(bytes.data() + head - 4, false);
}

std::vector<double> binary_corners(std::string_view bytes, const std::string& name) {
    constexpr std::size_t head = 84, normal = 12, each = 50;
    if (bytes.size() < head)
        throw bad_input(name + ": not an STL file: " + std::to_string(bytes.size()) + " bytes, a header has 84");
    const auto count = load_number<std::uint32_t>(bytes.data() + head - 4, false);
    if (!has_binary_size(bytes))
        throw bad_input(name + ": " + std::to_string(count) + " triangles are announced, which take " +
                        std::to_string(head + std::uint64_t{each} * count) + " bytes, but the file has " +
                        std::to_string(bytes.size()));
    std::vector<double> corners;
    corners.reserve(std::size_t{9} * count);
    for (std::size_t t = 0; t < count; ++t) {
        constexpr std::size_t triangles_in_a_round = 4096;
        if (t % triangles_in_a_round == 0) throw_if_interrupted();
        const char* at = bytes.data() + head + each * t + normal;
        for (std::size_t k = 0; k < 9; ++k, at += sizeof(float)) {
            corners.push_back(static_cast<double>(load_number<float>(at, false)));
            if (!std::isfinite(corners.back()))
                throw bad_input(name + ": triangle " + std::to_string(t) + " has a corner that is not finite");
        }
    }
    return corners;
}

}  // namespace

std::string SurfaceBuilder::face_text(std::int64_t face) const {
    return name_ + ": face " + std::to_string(face + first_);
}

void SurfaceBuilder::add_face(std::span<const std::int64_t> corners) {
    const auto face = static_cast<std::int64_t>(offsets_.size()) - 1;
    if (corners.size() < 3)
        throw bad_input(face_text(face) + " has " + std::to_string(corners.size()) + " corners: give at least 3");
    for (const std::int64_t v : corners) {
        if (v < 0 || v > std::numeric_limits<std::int32_t>::max())
            throw bad_input(face_text(face) + " names vertex " + std::to_string(v + first_) + ": give numbers from " +
                            std::to_string(first_) + " on");
        if (v > max_vertex_) max_vertex_ = v, face_of_max_ = face;
        corners_.push_back(static_cast<std::int32_t>(v));
    }
    offsets_.push_back(static_cast<std::int64_t>(corners_.size()));
}

Surface SurfaceBuilder::finish() {
    if (max_vertex_ >= vertices())
        throw bad_input(face_text(face_of_max_) + " names vertex " + std::to_string(max_vertex_ + first_) +
                        ", but there are " + std::to_string(vertices()));
    try {
        surface_.triangles = votess::triangulate({surface_.vertices, corners_, offsets_, first_});
    } catch (const votess::Error& error) {
        throw bad_input(name_ + ": " + error.what());
    }
    return std::move(surface_);
}

Surface parse_off(std::string_view text, const std::string& name) {
    return OffReader(text, name).read();
}

Surface parse_obj(std::string_view text, const std::string& name) {
    LineReader lines(text, name);
    SurfaceBuilder builder(name, 1);
    std::vector<std::int64_t> corners;
    std::string joined;
    for (Words words; next_words(lines, words);) {
        if (words.back().ends_with('\\')) join_lines(lines, words, joined);
        if (words.empty()) continue;
        if (words[0] == "v") add_vertex_of(lines, std::span(words).subspan(1), builder);
        if (words[0] != "f") continue;  // nothing else is a part of the surface
        corners.clear();
        for (const std::string_view word : std::span(words).subspan(1)) {
            const std::int64_t v = lines.whole(word.substr(0, word.find('/')), "a vertex of a face");
            if (v < -builder.vertices()) throw lines.error("vertex " + std::to_string(v) + " is before the first");
            corners.push_back(v < 0 ? builder.vertices() + v : v - 1);  // -1: the last one so far
        }
        builder.add_face(corners);
    }
    return builder.finish();
}

Surface parse_stl(std::string_view bytes, const std::string& name) {
    constexpr std::size_t head = 84;
    if (!has_binary_size(bytes))  // DOS marks the end of a file by Ctrl-Z
        bytes = bytes.substr(0, bytes.find_last_not_of("\x1a \t\r\n") + 1);
    const std::string begin = lower_case(bytes.substr(0, head));
    const auto word = begin.find_first_not_of(std::string(blanks) + "\n\xef\xbb\xbf");
    const bool is_text = word != std::string::npos && begin.compare(word, 5, "solid") == 0 &&
                         begin.find('\0') == std::string::npos && !has_binary_size(bytes);
    std::string lines;
    if (is_text && bytes.find('\n') == std::string_view::npos) {  // lines end as on an old Mac, or there is one
        lines = bytes;
        std::ranges::replace(lines, '\r', '\n');
        bytes = lines;
    }
    Surface surface{is_text ? TextStl(bytes, name).corners() : binary_corners(bytes, name), {}, true, 0};
    constexpr auto max = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max());
    if (surface.vertices.size() / 3 > max)
        throw bad_input(name + ": more than the " + std::to_string(max) + " corners that are read");
    surface.triangles.resize(surface.vertices.size() / 3);
    std::iota(surface.triangles.begin(), surface.triangles.end(), 0);
    return surface;
}

namespace {

struct SurfaceFormat {
    std::string_view extension;
    Surface (*parse)(std::string_view, const std::string&);
    bool planar = false;
};
constexpr std::array<SurfaceFormat, 10> surface_formats{{{".off", parse_off},
                                                         {".obj", parse_obj},
                                                         {".stl", parse_stl},
                                                         {".ply", parse_ply_surface},
                                                         {".glb", parse_glb},
                                                         {".geojson", parse_geojson, true},
                                                         {".json", parse_geojson, true},
                                                         {".geojsonl", parse_geojson_sequence, true},
                                                         {".geojsons", parse_geojson_sequence, true},
                                                         {".geojsonseq", parse_geojson_sequence, true}}};

const SurfaceFormat& find_format(const std::string& option, const std::string& path) {
    const auto* const format = std::ranges::find(surface_formats, extension_of(path), &SurfaceFormat::extension);
    if (format == surface_formats.end())
        throw bad_input(
            option + " " + in_quotes(path) +
            ": known are .off .obj .stl .ply .glb, and for --2d .geojson .json .geojsonl .geojsons .geojsonseq: " +
            "convert it, for example with trimesh, PyVista or Blender, polygons with ogr2ogr");
    return *format;
}

}  // namespace

bool holds_polygons(const std::string& option, const std::string& path) {
    return find_format(option, path).planar;
}

Surface read_surface(const std::string& option, const std::string& path) {
    return find_format(option, path).parse(read_whole(path), path);
}

}  // namespace clvotess
