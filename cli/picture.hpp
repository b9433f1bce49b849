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
    Coloring coloring;
    votess::PictureOptions options;  // without its values
};

// The words as typed.
struct TypedPicture {
    std::optional<std::string> image, slice, size, color, colormap, cut, view;
    bool seeds = false;
};

// --color and --colormap.
[[nodiscard]] Coloring read_coloring(const TypedPicture& typed);

// Returns nothing without --image. It checks the file's name against the other files of the run.
[[nodiscard]] std::optional<PictureArguments> read_picture(const TypedPicture& typed, const std::string& input,
                                                           const std::vector<std::string>& outputs);

// Adds what the picture needs.
void add_needs(const PictureArguments& picture, votess::Want& want);

// The bytes of the file. The tessellation has what add_needs() adds.
[[nodiscard]] std::string draw_picture(const PictureArguments& picture, const Input& input,
                                       const votess::Tessellation& tessellation,
                                       const std::vector<InputColumn>& carried);

}  // namespace clvotess
