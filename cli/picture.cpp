#include "picture.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "failure.hpp"
#include "files/formats/png.hpp"
#include "files/numbers.hpp"
#include "files/output_file.hpp"
#include "words.hpp"

namespace clvotess {
namespace {

votess::Slice read_slice(const std::string& text) {
    const auto value = text.size() > 2 && text[1] == '=' ? read_double(std::string_view(text).substr(2)) : std::nullopt;
    if (!value || text[0] < 'x' || text[0] > 'z') {
        throw bad_input("--slice must be x=NUMBER, y=NUMBER or z=NUMBER, not " + in_quotes(text));
    }
    return {text[0] - 'x', *value};
}

void read_size(const std::string& text, votess::PictureOptions& options) {
    constexpr std::uint64_t least = 64, most = 16384;
    const auto parts = split(text, 'x');
    const auto width = read_uint64(parts.front()), height = read_uint64(parts.back());
    if (parts.size() != 2 || !width || !height || *width < least || *width > most || *height < least ||
        *height > most) {
        throw bad_input("--image-size must be WIDTHxHEIGHT in pixels, 64 to 16384 each, not " + in_quotes(text));
    }
    options.width = static_cast<std::uint32_t>(*width);
    options.height = static_cast<std::uint32_t>(*height);
}

void read_view(const std::string& text, votess::PictureOptions& options) {
    const auto parts = split(text, ',');
    const auto azimuth = read_double(parts.front()), elevation = read_double(parts.back());
    if (parts.size() != 2 || !azimuth || !elevation || !(*elevation >= -89 && *elevation <= 89)) {
        throw bad_input("--view must be AZIMUTH,ELEVATION in degrees, the elevation from -89 to 89, not " +
                        in_quotes(text));
    }
    options.azimuth = *azimuth;
    options.elevation = *elevation;
}

void check_file(const std::string& file, const std::string& input, const std::vector<std::string>& outputs) {
    if (extension_of(file) != ".png")
        throw bad_input("--image " + in_quotes(file) + ": give it a name that ends in .png");
    check_png();
    check_writable(file);
    for (const std::string& path : outputs) {
        if (path != "-" && identity_of(path) == identity_of(file)) {
            throw bad_input("--image " + in_quotes(file) + " is an output too: give it another name");
        }
    }
    if (input != "-" && !input.empty() && identity_of(input) == identity_of(file)) {
        throw bad_input("--image " + in_quotes(file) + " is the input: give it another name");
    }
}

}  // namespace

Coloring read_coloring(const Typed& typed) {
    Coloring coloring;
    if (const std::string* column = typed.value("--color")) coloring.column = *column;
    // The names of arrays, unless a column of the input has one.
    const std::string* const copy = typed.value("--copy");
    const auto copied = copy ? split(*copy, ',') : std::vector<std::string_view>();
    for (const auto& [array, column] : {std::pair{"volumes", "volume"}, {"surface_areas", "area"}})
        if (coloring.column == array && std::ranges::count(copied, std::string_view(array)) == 0)
            coloring.column = column;
    typed.read_word("--colormap", coloring.colormap);
    return coloring;
}

std::optional<PictureArguments> read_picture(const Typed& typed, const std::string& input,
                                             const std::vector<std::string>& outputs) {
    if (!typed.has("--image")) return {};
    const std::string* slice = typed.value("--slice");
    for (const std::string option : {"--cut", "--view"})
        if (slice && typed.has(option)) throw bad_input(option + " is for a picture in space, not for a --slice");
    PictureArguments picture;
    picture.file = *typed.value("--image");
    check_file(picture.file, input, outputs);
    votess::PictureOptions& options = picture.options;
    if (slice) options.slice = read_slice(*slice);
    if (const std::string* size = typed.value("--image-size")) read_size(*size, options);
    typed.read_word("--cut", options.cut);
    if (const std::string* view = typed.value("--view")) read_view(*view, options);
    options.seeds = typed.has("--seeds");
    options.skip_open = typed.has("--open");
    picture.quiet = typed.has("--quiet");
    return picture;
}

void check_picture(const PictureArguments& picture, bool planar) {
    if (picture.options.seeds && !picture.options.slice && !planar)
        throw bad_input("--seeds shows the points near a plane: add --slice");
}

std::string draw_picture(const PictureArguments& picture, const Coloring& coloring, const Input& input,
                         const votess::Tessellation& tessellation, const std::vector<InputColumn>& carried,
                         double gap) {
    const std::vector<double> values = coloring.values(input, tessellation, carried);
    votess::PictureOptions options = picture.options;
    options.values = values;
    options.colormap = coloring.colormap;
    options.label = coloring.label(tessellation.planar());
    options.gap = gap;
    const votess::Picture drawn = votess::render(tessellation, input.points, options);
    if (drawn.left_out > 0 && !picture.quiet)
        std::fprintf(stderr, "'%s' leaves out %s\n", picture.file.c_str(), open_cells(drawn.left_out).c_str());
    return to_png(drawn);
}

}  // namespace clvotess
