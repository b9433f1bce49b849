// --image: the options of the picture, and the picture as a PNG file.
#pragma once

#include <optional>
#include <string>
#include <vector>
#include <votess/picture.hpp>

#include "coloring.hpp"

namespace clvotess {

struct PictureArguments {
    std::string file;
    votess::PictureOptions options;  // without values and colors
};

// Options as typed.
struct TypedPicture {
    std::optional<std::string> image, slice, size, color, colormap, cut, view;
    bool seeds = false;
};

// Reads --color and --colormap.
[[nodiscard]] Coloring read_coloring(const TypedPicture& typed);

// Returns nothing without --image. Throws Failure when the file is also another file of the run.
[[nodiscard]] std::optional<PictureArguments> read_picture(const TypedPicture& typed, const std::string& input,
                                                           const std::vector<std::string>& outputs);

// Returns the bytes of the PNG file. The tessellation must hold faces and the arrays of the coloring.
[[nodiscard]] std::string draw_picture(const PictureArguments& picture, const Coloring& coloring, const Input& input,
                                       const votess::Tessellation& tessellation,
                                       const std::vector<InputColumn>& carried);

}  // namespace clvotess
