// Draws a scene on the CPU.
#pragma once

#include <cstdint>
#include <vector>

#include "core/thread_pool.hpp"
#include "picture/scene.hpp"

namespace votess::picture {

// Returns 4 width height bytes: RGBA of sRGB, rows from the top, from the left. The same scene gives the same bytes for
// any number of threads.
//
// Four samples a pixel find the nearest triangle of the solid; triangles of the flat part lie over it. Light is soft
// and comes from one side and from the sky. Ambient occlusion darkens a pixel by the surfaces around it (Mittring,
// Finding next gen, SIGGRAPH 2007 courses: samples of the depth in a disc; here weighted by the cosine and distance).
// Strokes cover in their order what lies behind them.
[[nodiscard]] std::vector<std::uint8_t> draw(const Scene& scene, ThreadPool& pool);

}  // namespace votess::picture
