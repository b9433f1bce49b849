// The parts that a large picture is drawn in, and what the shaders are told about each.
#pragma once

#include <cstdint>
#include <vector>

#include "picture/scene.hpp"
#include "shared/picture.h"

namespace votess::gpu {

// A part of the picture: what is kept of it, and what is drawn, which has a border.
struct PicturePart {
    std::uint32_t left, top, width, height;             // kept
    std::uint32_t draw_left, draw_top, draw_w, draw_h;  // drawn
};

// At most `most` pixels along a side are drawn at once, but never less than what borders need.
[[nodiscard]] std::vector<PicturePart> cut_picture(const picture::Scene& scene, std::uint32_t most);

// flat: positions are pixels of the picture.
[[nodiscard]] PicturePush push_for(const picture::Scene& scene, const PicturePart& part, bool flat);

}  // namespace votess::gpu
