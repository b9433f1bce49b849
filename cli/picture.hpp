// --image: the options of the picture, and the picture as a PNG file.
#pragma once

#include <optional>
#include <string>
#include <vector>
#include <votess/picture.hpp>

#include "arguments/typed.hpp"
#include "coloring.hpp"

namespace clvotess {

struct PictureArguments {
    std::string file;
    bool quiet = false;
    votess::PictureOptions options;  // without values and colors
};

// --color and --colormap.
[[nodiscard]] Coloring read_coloring(const Typed& typed);

// Returns nothing without --image. It checks the file's name against the other files of the run.
[[nodiscard]] std::optional<PictureArguments> read_picture(const Typed& typed, const std::string& input,
                                                           const std::vector<std::string>& outputs);

// Throws Failure for options that a picture of these points does not have.
void check_picture(const PictureArguments& picture, bool planar);

// Returns the bytes of the PNG file. The tessellation must hold faces, unless it is in a mesh, and the arrays of the
// coloring. gap: of pieces in a mesh.
[[nodiscard]] std::string draw_picture(const PictureArguments& picture, const Coloring& coloring, const Input& input,
                                       const votess::Tessellation& tessellation,
                                       const std::vector<InputColumn>& carried, double gap);

}  // namespace clvotess
