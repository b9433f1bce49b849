// Pictures of a result.
#include <votess/picture.h>

#include <algorithm>
#include <cmath>
#include <votess/picture.hpp>

#include "c/handles.hpp"
#include "c/piece_arrays.hpp"

using namespace votess::c;

namespace {

static_assert(same(0, votess::Cut::corner) && same(3, votess::Cut::none) && same(2, votess::ColorScale::logarithmic) &&
              same(2, votess::Colormap::gray) && same(2, votess::WallCells::hide));

votess_picture_options defaults() {
    const votess::PictureOptions start;
    votess_picture_options options{};
    options.width = start.width;
    options.height = start.height;
    std::ranges::fill(options.range, std::nan(""));
    std::ranges::fill(options.cut_at, std::nan(""));
    options.azimuth = start.azimuth;
    options.elevation = start.elevation;
    options.slice_axis = -1;
    options.edges = options.color_bar = options.frame = 1;
    std::ranges::copy(start.background, options.background);
    return options;
}

// Returns the enumerator of a number from 0 to `last`.
template <typename Enum>
Enum word(int32_t number, Enum last, const char* name) {
    if (number < 0 || number > static_cast<int32_t>(last))
        refuse(std::string("options.") + name + " = " + std::to_string(number) + ": give 0 to " +
               std::to_string(static_cast<int>(last)));
    return static_cast<Enum>(number);
}

votess::PictureOptions convert(const votess_picture_options* given) {
    const votess_picture_options all =
        given == nullptr ? defaults()
                         : read_struct(*given, "options.struct_size", "call votess_picture_options_init first");
    require_array(all.values, all.value_count, "options.values", "options.value_count");
    votess::PictureOptions options;
    options.width = all.width;
    options.height = all.height;
    options.threads = all.threads;
    options.values = std::span(all.values, all.values == nullptr ? 0 : all.value_count);
    if (all.label != nullptr) options.label = all.label;
    if (!std::isnan(all.range[0]) || !std::isnan(all.range[1])) options.range = {all.range[0], all.range[1]};
    options.azimuth = all.azimuth;
    options.elevation = all.elevation;
    if (std::ranges::any_of(all.cut_at, [](double x) { return !std::isnan(x); }))
        options.cut_at = {all.cut_at[0], all.cut_at[1], all.cut_at[2]};
    if (all.slice_axis != -1) options.slice = votess::Slice{all.slice_axis, all.slice_value};
    options.gap = all.gap;
    options.cut = word(all.cut, votess::Cut::none, "cut");
    options.scale = word(all.scale, votess::ColorScale::logarithmic, "scale");
    options.colormap = word(all.colormap, votess::Colormap::gray, "colormap");
    options.wall_cells = word(all.wall_cells, votess::WallCells::hide, "wall_cells");
    options.edges = all.edges != 0;
    options.seeds = all.seeds != 0;
    options.color_bar = all.color_bar != 0;
    options.skip_open = all.skip_open != 0;
    options.frame = all.frame != 0;
    std::ranges::copy(all.background, options.background.begin());
    return options;
}

void check_size(const votess::PictureOptions& look, const uint8_t* pixels, size_t size) {
    require(pixels, "pixels");
    const std::size_t bytes = std::size_t{4} * look.width * look.height;
    if (size != bytes)
        refuse("size = " + std::to_string(size) + ": a picture of " + std::to_string(look.width) + " x " +
               std::to_string(look.height) + " pixels has " + std::to_string(bytes) + " bytes");
}

}  // namespace

votess_status votess_picture_options_init(votess_picture_options* options, size_t size) {
    return init_struct(options, size, defaults(), "give sizeof(votess_picture_options)");
}

votess_status votess_render(const votess_result* result, const double* points, size_t count,
                            const votess_picture_options* options, uint8_t* pixels, size_t size, uint64_t* left_out) {
    return guarded([&] {
        const auto input = points_of(result, points, count);
        const votess::PictureOptions look = convert(options);
        check_size(look, pixels, size);
        const votess::Picture picture = votess::render(result->tessellation, input, look);
        std::ranges::copy(picture.pixels, pixels);
        if (left_out != nullptr) *left_out = picture.left_out;
    });
}

votess_status votess_render_pieces(const votess_piece_arrays* pieces, const votess_picture_options* options,
                                   uint8_t* pixels, size_t size) {
    return guarded([&] {
        const votess::PictureOptions look = convert(options);  // which checks struct_size
        const votess::files::Pieces given = checked_pieces(pieces, options != nullptr && options->planar != 0 ? 2 : 3);
        check_size(look, pixels, size);
        require(look.values.data(), "options.values");
        votess::Pieces all;
        const auto copy = [](auto& to, const auto& from) { to.assign(from.begin(), from.end()); };
        copy(all.indptr, given.indptr);
        copy(all.vertex_offsets, given.vertex_offsets);
        copy(all.vertices, given.vertices);
        copy(all.triangle_offsets, given.triangle_offsets);
        copy(all.triangles, given.triangles);
        copy(all.on_surface, given.on_surface);
        copy(all.sources, given.sources);
        all.sources.resize(all.on_surface.size(), -1);
        copy(all.centroids, given.centroids);
        all.volumes.resize(given.size());  // options.values color them
        std::ranges::copy(votess::render(all, look).pixels, pixels);
    });
}
